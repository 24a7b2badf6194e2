#!/usr/bin/env python3
"""What baton can do in rcssservermj, as the table of docs/rcss.md: the manoeuvres of `baton check`, and random sticks.

    tests/python/rcss_table.py [--robot rcss_k1] [--mode --sync] [--seeds 20] [--seconds 30] [--only NAME]

Needs `make build rcss`. Standard library only.
"""

import argparse
import json
import pathlib
import subprocess
import sys

import rcss

UNIT = 1.3  # [s] a third of the longest duration of a segment, as in `baton check`


class Stick:
    """Does one thing after the other."""

    def __init__(self, guide):
        self.guide, self.t, self.lines = guide, 0.0, []
        self.hold(0.5)

    def hold(self, seconds, axis=None, to=0.0, lift=(0, 0)):
        axes = [to if i == axis else 0 for i in range(6)]
        self.lines.append({"t": round(self.t, 3), "guide": self.guide, "axes": axes, "lift": list(lift)})
        self.t += seconds
        return self


def manoeuvres():
    yield "stand", Stick("trunk").hold(10)
    shift, squat = Stick("trunk"), Stick("trunk")
    for to in (1, -1):
        shift.hold(1.5 * UNIT, 1, to).hold(1.5 * UNIT)
        squat.hold(2 * UNIT, 2, -to).hold(UNIT)
    yield "shift", shift
    yield "squat", squat
    for hand in ("left_hand", "right_hand"):
        reach = Stick(hand)
        for axis, to in ((0, 1), (2, 1), (0, -1), (2, -1)):
            reach.hold(UNIT, axis, to).hold(UNIT)
        yield f"reach {hand}", reach
    for foot, out in (("left_foot", 1), ("right_foot", -1)):
        yield f"lift {foot}", Stick(foot).hold(4 * UNIT, lift=(int(out > 0), int(out < 0))).hold(4 * UNIT)
        step = Stick(foot)
        for axis, to in ((0, 1), (0, -1), (1, out), (1, -out)):
            step.hold(1.5 * UNIT, axis, to).hold(3 * UNIT)
        yield f"step {foot}", step
    yield "walk", Stick("trunk").hold(30, 0, 1).hold(2 * UNIT)
    yield "walk back", Stick("trunk").hold(30, 0, -1).hold(2 * UNIT)
    yield "walk left", Stick("trunk").hold(30, 1, 1).hold(2 * UNIT)
    yield "turn", Stick("trunk").hold(30, 5, 1).hold(2 * UNIT)


def random_sticks(seeds, seconds):
    for seed in range(seeds):
        command = [sys.executable, pathlib.Path(__file__).with_name("random_script.py"), "--seed", str(seed),
                   "--seconds", str(seconds)]  # fmt: skip
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        yield f"random {seed}", [json.loads(line) for line in text.splitlines()], seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="rcss_k1")
    parser.add_argument("--mode", default="sync", choices=("sync", "sequential"))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--only", default="")
    o = parser.parse_args()
    runs = [(name, stick.lines, stick.t) for name, stick in manoeuvres()] + list(random_sticks(o.seeds, o.seconds))
    with rcss.Simulator("--" + o.mode) as simulator, rcss.Bridge(simulator.address, o.robot) as bridge:
        for name, lines, seconds in runs:
            if not name.startswith(o.only):
                continue
            done, report = rcss.drive(bridge.address, lines, seconds, o.robot)
            if report is None:
                print(f"{name:20} {done.stderr.strip()}", flush=True)
                continue
            commands, trunk = report["commands"], report["final"]["trunk"]
            print(
                f"{name:20} {commands['moved']:3} of {commands['given']:3} moved  "
                f"{trunk['p'][0]:6.2f} {trunk['p'][1]:6.2f} m {trunk['rpy'][2] * 57.3:5.0f} deg  "
                f"COM {1e3 * report['tracking']['com_rms_m']:5.1f} mm  caught {report['segments']['caught']}  "
                f"falls {report['falls']} (at {report['duration_s']:.1f} s)  {report['segments']['refused'] or ''}",
                flush=True,
            )


if __name__ == "__main__":
    main()
