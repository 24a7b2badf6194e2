"""Collects data: episodes of random commands, with what the sensors said and the joints were told, in one .npz file.

    python examples/python/02_collect.py --out data.npz [--robot mighty] [--episodes 4] [--seconds 10]

Each episode has a plant of its own: other errors of sensors and motors. Arrays have one row a tick; `episode` says
which episode a row belongs to. The robot rests while a command is refused, which is part of the data.
"""

import argparse
import pathlib

import numpy as np

import baton

PARTS = ["trunk", "left_foot", "right_foot", "left_hand", "right_hand"]

parser = argparse.ArgumentParser(description="Collect episodes of random commands.")
parser.add_argument("--out", type=pathlib.Path, required=True)
parser.add_argument("--robot", default="mighty")
parser.add_argument("--episodes", type=int, default=4)
parser.add_argument("--seconds", type=float, default=10.0)
parser.add_argument("--seed", type=int, default=0)
options = parser.parse_args()

robot = baton.Robot(options.robot)
random = np.random.default_rng(options.seed)
rows = {name: [] for name in ("episode", "t", "part", "axes", "q", "dq", "attitude", "rate", "soles", "target")}
moved = refused = falls = 0
for episode in range(options.episodes):
    run = baton.Run(robot, seed=options.seed + episode)
    until = 0.0
    while run.t < options.seconds and not run.fallen:
        if run.t >= until:  # another command, for one to two seconds
            part = int(random.integers(len(PARTS)))
            axes = np.clip(random.normal(scale=0.7, size=6), -1, 1)
            run.guide(PARTS[part], axes)
            until = run.t + random.uniform(1.0, 2.0)
        if run.guard == "lifted":  # or seems so: it goes on once the stick was centred
            run.release()
        now = run.t
        for event in run.step():
            moved += isinstance(event, baton.Committed)
            refused += isinstance(event, baton.Refused)
        m = run.measurement
        for name, value in {"episode": episode, "t": now, "part": part, "axes": axes, "q": m.q, "dq": m.dq,
                            "attitude": m.attitude, "rate": m.rate, "soles": np.concatenate([m.left_sole, m.right_sole]),
                            "target": run.target.q + run.target.q_correction}.items():  # fmt: skip
            rows[name].append(value)
    falls += run.fallen
    print(f"episode {episode + 1} of {options.episodes}: {run.t:.1f} s")

np.savez_compressed(options.out, parts=PARTS, joints=[joint.name for joint in robot.joints],
                    **{name: np.array(values) for name, values in rows.items()})  # fmt: skip
print(f"{len(rows['t'])} ticks, {moved} motions, {refused} refusals, {falls} falls: {options.out}")
