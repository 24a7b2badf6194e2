#!/usr/bin/env python3
"""Real-time latency from a command, sent like the page's, to the first joint target that responds.

Starts the program in real time on `ideal`, takes the stick over the WebSocket, and changes it at random
while the robot stands and moves. Which tick answers which change is read from the recording and the trace afterwards:
a motion answers the command that was in force when it was asked for. docs/physics.md says how to read the table.
"""

import argparse
import collections
import dataclasses
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
import tomllib

from mcap.reader import make_reader
from websockets.sync.client import connect

ROOT = pathlib.Path(__file__).resolve().parents[1]
PARTS = ("left_foot", "right_foot", "left_hand", "right_hand", "trunk")
AXES = {"foot": (0, 1, 5), "hand": (0, 1, 2), "trunk": (0, 1, 2, 3, 4, 5)}
SITUATIONS = {"hold": "at rest", "double": "double support", "single_left": "a foot in the air", "single_right": "a foot in the air"}
HEARTBEAT = 1 / 30  # same as the page [s]
DIFFERENT = 1e-9  # threshold on joint targets [rad]
REST = 1.0  # without a response, a change is held for this much longer than the longest motion [s]


@dataclasses.dataclass
class Change:
    """A change of the stick; ticks are counted from the start of the run."""

    command: dict
    switched: bool  # to another guided part
    deflected: bool  # else released
    sent: float  # wall-clock time [s]
    refusal: str | None = None  # refusal reported to the page meanwhile
    tick: int | None = None  # first tick with the new command
    situation: str | None = None
    response: int | None = None  # first tick whose joint target shows the first motion in response
    latency: float | None = None  # from sending to that tick [s]
    first: bool = False  # the first answer was that motion, or came too late


class Stick:
    """A driving page: sends its newest command at once and 30 times a second."""

    def __init__(self, socket):
        self.socket = socket
        self.state = {}
        self.offset = math.inf  # minimum over states of wall-clock arrival − run time [s]
        self.lags = []  # the same for every state
        self.lock = threading.Lock()
        self.command = command("trunk")
        self.ended = threading.Event()
        self.socket.send(json.dumps({"type": "drive"}))
        self.threads = [threading.Thread(target=target, daemon=True) for target in (self.listen, self.beat)]
        for thread in self.threads:
            thread.start()

    def listen(self):
        for text in self.socket:
            came = time.monotonic()
            message = json.loads(text)
            if message["type"] != "state":
                raise RuntimeError(text)
            self.lags.append(came - message["t"])
            self.offset = min(self.offset, self.lags[-1])
            self.state = message

    def beat(self):
        while not self.ended.wait(HEARTBEAT):
            self.send(self.command)

    def send(self, what):
        with self.lock:
            self.command = what
            sent = time.monotonic()
            self.socket.send(json.dumps(what))
            return sent

    def close(self):
        self.ended.set()
        self.threads[1].join()


def command(guide, axes=(0, 0, 0, 0, 0, 0), lift=(0, 0)):
    return {"type": "command", "guide": guide, "axes": list(axes), "lift": list(lift), "recall": "none", "deadman": True}


def deflected(rng, guide):
    """Nearly full deflection of one axis, or in a horizontal direction; no two commands are equal."""
    axes = [0.0] * 6
    if rng.random() < 0.5:
        axes[rng.choice(AXES[guide.split("_")[-1]])] = rng.choice((-1, 1)) * rng.uniform(0.98, 1)
    else:
        angle = rng.uniform(-math.pi, math.pi)
        axes[:2] = math.cos(angle), math.sin(angle)
    return command(guide, axes)


def differ(a, b):
    """Another part, or a direction at least 60° different."""
    dot = sum(x * y for x, y in zip(a["axes"], b["axes"]))
    return a["guide"] != b["guide"] or dot <= 0.5 * math.hypot(*a["axes"]) * math.hypot(*b["axes"])


def wait_for(condition, patience, what):
    end = time.monotonic() + patience
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError(f"{what}: not within {patience} s")
        time.sleep(0.002)


def steer(stick, rng, count, lookahead, longest):
    """Changes the stick until it has been deflected `count` times."""
    wait_for(lambda: stick.state.get("role") == "driver" and stick.state["device"]["armed"], 30, "the stick")
    changes = []
    while sum(change.deflected for change in changes) < count:
        old = stick.command
        guide = old["guide"] if rng.random() < 0.5 else rng.choice(PARTS)
        if any(old["axes"]) and rng.random() < 0.2:
            new = command(old["guide"])
        else:
            new = deflected(rng, guide)
            if not differ(old, new):
                continue
        refusals = stick.state["refusals"]
        change = Change(new, new["guide"] != old["guide"], any(new["axes"]), stick.send(new))
        # Held until a motion seems to respond, or it is refused at rest, so that slow responses count too.
        while change.deflected and began(stick) < change.sent + lookahead and time.monotonic() < change.sent + longest + REST:
            time.sleep(0.005)
            if stick.state["refusals"] > refusals:
                change.refusal = stick.state["refusal"]["reason"]
                if stick.state["goal"] is None:
                    break
        time.sleep(rng.uniform(0.1, 2.0))
        changes.append(change)
    return changes


def began(stick):
    """Wall-clock start of the motion under way; long ago if there is none."""
    state = stick.state
    return state["t"] - state["segment"]["time"] + stick.offset if state["goal"] else -math.inf


def read_recording(recording):
    """Active command of each tick; tick of each planning request → tick of its answer."""
    commands, asks = [], {}
    with open(recording, "rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            tick = message.sequence
            while len(commands) <= tick:
                commands.append(commands[-1] if commands else None)
            if channel.topic == "/baton/command":
                commands[tick] = json.loads(message.data)
            elif channel.topic == "/baton/planner":
                if json.loads(message.data)["call"] == "ask":
                    asks[tick] = math.inf
                else:
                    asks[max(asks)] = tick
    return commands, asks


def columns(trace, *begins):
    """The columns of a trace whose names begin so, in the trace's order."""
    with open(trace) as lines:
        head = next(lines).rstrip("\n").split(",")
        places = [place for place, name in enumerate(head) if name.startswith(begins)]
        rows = [line.rstrip("\n").split(",") for line in lines]
    return [[row[place] for row in rows] for place in places]


def find_answers(changes, recording, trace, offset, tick):
    """Fills in the outcome of the changes; `tick`: the profile's table."""
    commands, asks = read_recording(recording)
    segments, phases, *joints = columns(trace, "segment", "phase", "target_")
    targets = [[float(angle) for angle in row] for row in zip(*joints)]
    begun = [k for k in range(1, len(segments)) if segments[k] != segments[k - 1] and segments[k] != "-1"]
    # A motion answers the command of the last tick at which the planner was asked before it.
    asked = {k: max(a for a in asks if a < k) for k in begun}
    k = 0
    for change in changes:
        same = lambda c: all(c[key] == change.command[key] for key in ("guide", "axes"))
        k = next((k for k in range(k, len(commands)) if same(commands[k])), None)
        if k is None:
            raise RuntimeError(f"a command never arrived: {change.command}")
        change.tick = k
        change.situation = SITUATIONS[phases[max(k - 1, 0)]]
    for change, following in zip(changes, [*changes[1:], None]):
        last = following.tick if following else len(commands)
        change.response = next((k for k in begun if change.tick <= asked[k] < last), None)
        first = next((a for a in asks if a >= change.tick), None)
        late = first is not None and asks[first] - first >= tick["lookahead"]
        change.first = late or (change.response is not None and asked[change.response] == first)
        if change.response is not None:
            # From rest a motion starts gently: the joints may follow a tick or two later.
            while max(abs(a - b) for a, b in zip(targets[change.response], targets[change.response - 1])) <= DIFFERENT:
                change.response += 1
            # A state carries the time of the next tick.
            change.latency = offset + (change.response + 1) * tick["period"] - change.sent


def measure(program, robot, count, seed, folder):
    """Changes with their outcome, the program's report, and the lag of states behind the clock [s]."""
    profile = tomllib.loads(subprocess.run([program, "profile", robot], stdout=subprocess.PIPE, text=True, check=True).stdout)
    tick = profile["tick"]
    outputs = {"--trace": folder / "trace.csv", "--record": folder / "run.mcap", "--report": folder / "report.json"}
    options = ["--robot", robot, "--world", "flat", "--on", "ideal", "--input", "page", "--port", "0"]
    options += [str(word) for pair in outputs.items() for word in pair]
    baton = subprocess.Popen([program, "drive", *options], stdout=subprocess.PIPE, text=True)
    try:
        url = re.search(r"page at http(\S+?)/?\n", baton.stdout.readline()).group(1)
        with connect(f"ws{url}/ws", max_size=None) as socket:
            stick = Stick(socket)
            changes = steer(stick, random.Random(seed), count, tick["lookahead"] * tick["period"], profile["duration"]["max"])
            stick.close()
    finally:
        baton.terminate()  # comes to rest and writes its files
        baton.communicate(timeout=60)
    if baton.returncode != 0:
        raise RuntimeError(f"{program}: exit {baton.returncode}")
    find_answers(changes, outputs["--record"], outputs["--trace"], stick.offset, tick)
    return changes, json.loads(outputs["--report"].read_text()), sorted(lag - stick.offset for lag in stick.lags)


def quantile(values, share):
    """In the format of baton_bench."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else 0.0


def row(name, changes):
    values = [1e3 * change.latency for change in changes if change.response is not None]
    without = collections.Counter(change.refusal or "not answered" for change in changes if change.response is None)
    remark = f"p90 {quantile(values, 0.9):.0f}, {sum(v > 150 for v in values)} above 150"
    if without:
        remark += "; none at all: " + ", ".join(f"{n} {why}" for why, n in without.most_common())
    numbers = "".join(f" {quantile(values, share):>10.2f}" for share in (0.5, 0.99, 1.0))
    return f"{'page latency: ' + name:<56} {'ms':>5}{numbers} {len(values):>7}  {remark}"


def loop_lines(report, lags):
    """Timing of the control loop and the planner."""
    loop, plan = report["loop"], report["plan_us"]
    ticks = round(report["duration_s"] / (1e-6 * loop["period_us"]))
    used = (f"{name} {loop['period_us'] - loop['slack_us'][slack]:.0f}" for name, slack in (("p99", "p1"), ("max", "min")))
    return (
        f"ticks: {ticks}, late {loop['late']}, of the period used {', '.join(used)} us; CPU p99 {report['tick_us']['p99']:.0f} us;"
        f" states behind the clock: p99 {1e3 * quantile(lags, 0.99):.1f} ms\n"
        f"answers: {plan['n']}, CPU p50 {plan['p50']:.0f} us, p99 {plan['p99']:.0f}; too late and dropped: {loop['dropped']}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--changes", type=int, default=120, help="times that the stick is deflected anew (120, about 5 minutes)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--robot", default="mighty", help="a name in robots/ or a profile's file")
    parser.add_argument("--program", default=ROOT / "build" / "release" / "baton", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        changes, report, lags = measure(options.program, options.robot, options.changes, options.seed, pathlib.Path(folder))
    changes = [change for change in changes if change.deflected]
    print(f"{'':<56} {'unit':>5} {'median':>10} {'p99':>10} {'worst':>10} {'count':>7}")
    print(row("all changes", changes))
    for situation in dict.fromkeys(SITUATIONS.values()):
        for switched in (False, True):
            name = f"{situation}, {'another' if switched else 'same'} part"
            print(row(name, [c for c in changes if c.situation == situation and c.switched == switched]))
    moved = [change for change in changes if change.response is not None]
    print(row("a motion is the first answer, or it is late", [c for c in moved if c.first]))
    print(row("a refusal is, or nothing to do", [c for c in moved if not c.first]))
    print(loop_lines(report, lags))
    return 0


if __name__ == "__main__":
    sys.exit(main())
