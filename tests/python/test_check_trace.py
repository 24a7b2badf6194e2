"""The checker's judgement of physics: honest runs pass, each forged column of a trace is found out.

The program is build/release/baton, or the one that the environment variable BATON names.
"""

import json

import numpy as np
import pytest

import check_trace
import random_script
from test_random_scripts import BATON, drive, scaled  # noqa: F401 (a fixture)

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")

SECONDS = 6
STRETCH = (2.0, 4.0)  # [s] forged, if not all of a run is
WALK = [
    {"t": 0.0, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]},
    {"t": 3.5, "guide": "trunk", "axes": [0, 1, 0, 0, 0, 0.5]},
]
STAND = [{"t": 0.0, "guide": "trunk", "axes": [0, 0, 0, 0, 0, 0]}]


def script(driving):
    lines = {"walk": WALK, "stand": STAND}.get(driving)
    return random_script.lines(103, SECONDS, driving) if lines is None else [json.dumps(line) for line in lines]


# (driving, options of the program)
FORGED = {
    "walk": ("walk", []),
    "walk-real": ("walk", ["--plant", "real"]),
    "friendly": ("friendly", []),
    "friendly-real": ("friendly", ["--plant", "real", "--seed", "103"]),
    "stand": ("stand", []),
    "stand-real": ("stand", ["--plant", "real"]),
}
MOVING = [name for name in FORGED if not name.startswith("stand")]
SCENARIOS = ["push", "mix", "tiles", "slope", "noise", "stiff"]


@pytest.fixture(scope="module")
def honest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("honest")
    return {name: drive(folder / name, script(way), world="flat", on="sim", seconds=SECONDS, more=more) for name, (way, more) in FORGED.items()}


@pytest.mark.parametrize("name", FORGED)
def test_an_honest_run_passes(honest, name):
    assert honest[name].summary["violations"] == []


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_an_honest_run_passes_in_other_physics(tmp_path, scenario):
    run = drive(tmp_path, script("walk"), world="flat", on="sim", seconds=SECONDS, more=["--scenario", scenario, "--seed", "5"])
    assert run.summary["violations"] == []


@pytest.mark.parametrize("plant", ["model", "real"])
def test_an_honest_run_of_a_larger_robot_passes(tmp_path, scaled, plant):  # noqa: F811
    run = drive(tmp_path, script("walk"), world="flat", on="sim", seconds=SECONDS, profile=scaled, more=["--plant", plant])
    assert run.summary["violations"] == []


class Forgery:
    """Columns of a trace to be changed, in all ticks or in a stretch."""

    def __init__(self, trace, period=0.005):
        self.names, *rows = [line.split(",") for line in trace.read_text().splitlines()]
        self.columns = dict(zip(self.names, (list(column) for column in zip(*rows))))
        self.all = np.arange(len(rows))
        self.stretch = self.all[round(STRETCH[0] / period) : round(STRETCH[1] / period)]
        self.second = self.stretch[: round(1.0 / period)]

    def get(self, name):
        return np.array(self.columns[name], float)

    def set(self, name, ticks, values):
        for tick, value in zip(ticks, np.broadcast_to(values, ticks.shape)):
            self.columns[name][tick] = f"{value:.10g}"

    def add(self, names, ticks, amount):
        for name in names:
            self.set(name, ticks, self.get(name)[ticks] + amount)

    def copy(self, names, ticks, late=0):
        """names: {column: the one that is copied into it}; late [ticks]"""
        copied = {name: self.columns[other].copy() for name, other in names.items()}
        for name, values in copied.items():
            for tick in ticks:
                self.columns[name][tick] = values[min(max(tick - late, 0), len(values) - 1)]

    def write(self, file):
        rows = zip(*(self.columns[name] for name in self.names))
        file.write_text("\n".join(",".join(row) for row in [self.names, *rows]) + "\n")
        return file


def shift(names, amount):
    return lambda f, ticks: f.add(names, ticks, amount)


def loads(change):
    """change: share of the left foot in the sum of the forces -> another."""

    def forge(f, ticks):
        left, right = f.get("force_left")[ticks], f.get("force_right")[ticks]
        share = change(left / np.maximum(left + right, 1e-9))
        f.set("force_left", ticks, share * (left + right))
        f.set("force_right", ticks, (1 - share) * (left + right))

    return forge


def scale_forces(factor):
    def forge(f, ticks):
        for name in ("force_left", "force_right"):
            f.set(name, ticks, factor * f.get(name)[ticks])

    return forge


def plan_into_com(f, ticks):
    f.copy({f"com_{axis}": f"com_plan_{axis}" for axis in "xyz"}, ticks)


def com_into_plan(f, ticks):
    f.copy({f"com_plan_{axis}": f"com_{axis}" for axis in "xyz"}, ticks)


def plan_into_zmp(f, ticks):
    f.copy({"zmp_x": "zmp_plan_x", "zmp_y": "zmp_plan_y"}, ticks)


def targets_into_joints(f, ticks):
    targets = [name for name in f.names if name.startswith("target_")]
    f.copy({f"qpos_{7 + j}": name for j, name in enumerate(targets)}, ticks, late=1)


def joints_into_targets(f, ticks):
    targets = [name for name in f.names if name.startswith("target_")]
    f.copy({name: f"qpos_{7 + j}" for j, name in enumerate(targets)}, ticks, late=-1)


def freeze_zmp(f, ticks):
    for name in ("zmp_x", "zmp_y"):
        f.set(name, ticks, f.get(name)[ticks[len(ticks) // 2]])


def states_late(ticks_late):
    states = ("qpos_", "qvel_", "com_x", "com_y", "com_z")
    return lambda f, ticks: f.copy({name: name for name in f.names if name.startswith(states)}, ticks, late=ticks_late)


PLANNED_COM = ("com_plan_x", "com_plan_y", "com_plan_z")
# Whatever the robot does: name -> (what is done to all ticks or a stretch, kinds of which one is found)
ANYWHERE = {
    "planned COM 20 mm forward": (shift(["com_plan_x"], 0.02), {"place_begin", "plan_step"}),
    "planned COM 20 mm aside": (shift(["com_plan_y"], -0.02), {"place_begin", "plan_step"}),
    "planned COM 20 mm aslant": (shift(["com_plan_x", "com_plan_y"], -0.0142), {"place_begin", "plan_step"}),
    "planned COM 20 mm up": (shift(["com_plan_z"], 0.02), {"place_begin", "plan_step"}),
    "plan 20 mm aside": (shift(["com_plan_y", "zmp_plan_y"], 0.02), {"place_begin", "plan_step"}),
    "ZMP 30 mm forward": (shift(["zmp_x"], 0.03), {"newton_zmp"}),
    "ZMP 30 mm aside": (shift(["zmp_y"], -0.03), {"newton_zmp"}),
    "planned ZMP 30 mm forward": (shift(["zmp_plan_x"], 0.03), {"plan_zmp"}),
    "planned ZMP 30 mm aside": (shift(["zmp_plan_y"], -0.03), {"plan_zmp"}),
    "all on the left foot": (loads(lambda s: np.ones_like(s)), {"load_split"}),
    "all on the right foot": (loads(lambda s: np.zeros_like(s)), {"load_split"}),
    "a quarter to the left foot": (loads(lambda s: np.where(s < 0.75, s + 0.25, s - 0.25)), {"load_split"}),
    "a quarter to the right foot": (loads(lambda s: np.where(s > 0.25, s - 0.25, s + 0.25)), {"load_split"}),
    "forces 1.3 times as large": (scale_forces(1.3), {"newton_force"}),
    "forces 0.7 times as large": (scale_forces(0.7), {"newton_force"}),
}
# A robot that stands still shows none of these.
IN_MOTION = {
    "feet exchanged": (loads(lambda s: 1 - s), {"load_split"}),
    "half on each foot": (loads(lambda s: np.full_like(s, 0.5)), {"load_split"}),
    "ZMP frozen": (freeze_zmp, {"frozen"}),
    "planned COM measured": (plan_into_com, {"copied"}),
    "measured COM planned": (com_into_plan, {"copied"}),
    "planned ZMP measured": (plan_into_zmp, {"copied"}),
    "planned joints measured": (targets_into_joints, {"copied"}),
    "measured joints planned": (joints_into_targets, {"copied"}),
    "states 50 ms late": (states_late(10), {"lag"}),
    "states 50 ms early": (states_late(-10), {"lag"}),
}
# Two of three, in turn, to save time.
CASES = [(name, forgery) for i, forgery in enumerate(ANYWHERE) for k, name in enumerate(FORGED) if (i + k) % 3]
CASES += [(name, forgery) for forgery in IN_MOTION for name in MOVING]
CASES = [(*case, ("all", "stretch")[i % 2]) for i, case in enumerate(CASES)]


def found_in(run, forgery, part, file):
    """Kinds of violations in a forged trace, and those of which one is wanted."""
    forge, wanted = {**ANYWHERE, **IN_MOTION}[forgery]
    forged = Forgery(run.trace)
    forge(forged, getattr(forged, part))
    summary = check_trace.check(forged.write(file), run.model, run.profile, "sim")
    return {violation["kind"] for violation in summary["violations"]}, wanted


@pytest.mark.parametrize("name, forgery, part", CASES)
def test_a_forged_trace_is_found_out(honest, tmp_path, name, forgery, part):
    found, wanted = found_in(honest[name], forgery, part, tmp_path / "forged.csv")
    assert found & wanted


@pytest.mark.parametrize("name", ["walk", "walk-real"])
@pytest.mark.parametrize("forgery", ["a quarter to the left foot", "a quarter to the right foot", "half on each foot"])
def test_a_second_with_another_split_is_found_out(honest, tmp_path, name, forgery):
    found, wanted = found_in(honest[name], forgery, "second", tmp_path / "forged.csv")
    assert found & wanted
