"""Waves and nods with both arms, as a policy or a motion capture rig would, while the stick walks mighty in a curve.

The targets come in chunks of half a second, each known a second ahead.

    python examples/python/04_arms.py
"""

import sys

import numpy as np

import baton

AHEAD = 1.0  # s
CHUNK = 0.5  # s
JOINTS = ["left_shoulder_flexion", "left_elbow_flexion", "right_shoulder_flexion", "right_elbow_flexion"]


def policy(t):
    """The angles at time t, away from those at home."""
    wave = np.sin(2.0 * np.pi * t / 2.0)
    return 0.3 * np.array([wave, -np.abs(wave), -wave, -np.abs(wave)]) * min(1.0, t / 4.0)


run = baton.Run("mighty", seed=1)
joints = [joint.name for joint in run.robot.joints]
index = [joints.index(name) for name in JOINTS]
home = np.array([run.robot.joints[i].home for i in index])

run.guide("trunk", [0.8, 0, 0, 0, 0, 0.3])
known, off = AHEAD, []
for _ in range(int(20.0 / CHUNK)):
    times = known + np.arange(0.0, CHUNK, 0.05)
    run.drive_arms(JOINTS, times, [home + policy(t) for t in times])
    known += CHUNK
    for event in run.advance(CHUNK):
        if isinstance(event, (baton.ArmsRefused, baton.Refused)):
            print(f"  {event!r}")
    off.append(np.abs(run.measurement.q[index] - home - policy(run.t)).max())

way = np.linalg.norm(run.truth.q[:2])
print(f"{way:.2f} m away, the arms within {np.median(off):.3f} rad of their targets (median), "
      f"{'fallen' if run.fallen else 'on its feet'}")
sys.exit(int(run.fallen))
