"""Whatever a stick does: random scripts, driven by the program, judged by check_trace.py.

The program is build/release/baton, or the one that the environment variable BATON names.
"""

import collections
import dataclasses
import functools
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import check_trace
import random_script

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))
TUNED = ROOT / "tests" / "robots" / "tuned"
KINDS = {"step", "lift", "lower", "air", "shift", "reach"}
SECONDS = 30

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")


@dataclasses.dataclass(frozen=True)
class Sample:
    """A random script, where it is driven, and by whom."""

    style: str
    seed: int
    world: str
    robot: str = "mighty"
    on: str = "ideal"

    def __str__(self):
        return f"{self.robot}-{self.on}-{self.world}-{self.style}-{self.seed}"


IDEAL = [
    Sample("mixed", 1, "flat"),
    Sample("mixed", 2, "room"),
    Sample("uniform", 3, "flat"),
    Sample("friendly", 4, "room"),
    Sample("friendly", 5, "flat"),
    Sample("hectic", 45, "room"),
]
SCALED = [Sample("mixed", 7, "room", "scaled"), Sample("friendly", 8, "flat", "scaled")]
PHYSICS = Sample("mixed", 9, "room", on="sim")
EVERY = [*IDEAL, *SCALED, PHYSICS]


@dataclasses.dataclass
class Run:
    folder: pathlib.Path
    profile: pathlib.Path
    on: str
    said: str

    @property
    def trace(self):
        return self.folder / "trace.csv"

    @property
    def model(self):
        return self.folder / "model.xml"

    @functools.cached_property
    def report(self):
        return json.loads((self.folder / "report.json").read_text())

    @functools.cached_property
    def summary(self):
        return check_trace.check(self.trace, self.model, self.profile, self.on, self.report)


def drive(folder, script, *, world, on="ideal", profile=None, seconds=SECONDS, ends=0, more=()):
    """A run of the program; script: lines of JSON; profile: with all keys; ends: the exit status wanted; more: options."""
    profile = profile or whole("mighty", folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "script.jsonl").write_text("".join(line + "\n" for line in script))
    outputs = ["--trace", folder / "trace.csv", "--save-model", folder / "model.xml", "--report", folder / "report.json"]
    command = [BATON, "drive", "--robot", profile, "--world", world, "--on", on, "--input", f"script:{folder / 'script.jsonl'}"]
    run = subprocess.run([*command, "--seconds", str(seconds), "--headless", "--fast", *outputs, *more], capture_output=True, text=True, timeout=120)
    assert run.returncode == ends, f"exit {run.returncode}: {run.stderr or run.stdout}"
    return Run(folder, pathlib.Path(profile), on, run.stdout)


def whole(robot, folder):
    """The robot's profile with all that is derived, in a file."""
    folder.mkdir(parents=True, exist_ok=True)
    printed = subprocess.run([BATON, "profile", robot], capture_output=True, text=True, check=True, timeout=60)
    (folder / "profile.toml").write_text(printed.stdout)
    return folder / "profile.toml"


@pytest.fixture(scope="module")
def scaled(tmp_path_factory):
    """The profile of a second biped, 1.7 times as large, with every name another."""
    out = tmp_path_factory.mktemp("scaled")
    maker = [sys.executable, ROOT / "scripts" / "scale_robot.py", TUNED, out]
    subprocess.run([*maker, "--scale", "1.7", "--seed", "1"], check=True)
    return out / "profile.toml"


@pytest.fixture(scope="module")
def driven(tmp_path_factory, scaled):
    """Sample -> Run; each is driven once."""
    folder = tmp_path_factory.mktemp("random")

    @functools.cache
    def of(sample):
        script = random_script.lines(sample.seed, SECONDS, sample.style)
        profile = None if sample.robot == "mighty" else scaled
        return drive(folder / str(sample), script, world=sample.world, on=sample.on, profile=profile)

    return of


@pytest.mark.parametrize("sample", EVERY, ids=str)
def test_random_script_breaks_no_rule(driven, sample):
    run = driven(sample)
    assert run.summary["violations"] == [], run.said
    assert run.report["falls"] == 0
    assert run.summary["ticks"] == round(SECONDS / 0.005)


@pytest.mark.parametrize("sample", EVERY, ids=str)
def test_the_stick_is_away_from_the_centre(sample):
    script = random_script.commands(sample.seed, SECONDS, sample.style)
    ends = [c[0] for c in script[1:]] + [SECONDS]
    active = sum(end - c[0] for c, end in zip(script, ends) if random_script.deflected(*c[1:]))
    assert active >= 0.7 * SECONDS


def test_four_commands_in_five_move_the_robot(driven):
    said, found = collections.Counter(), collections.Counter()
    for sample in EVERY:
        run = driven(sample)
        commands = run.report["commands"]
        script = random_script.commands(sample.seed, SECONDS, sample.style)
        counted = check_trace.count_commands(run.trace, run.model, run.profile, script)
        assert 0 < commands["moved"] <= commands["given"] <= counted["given"]
        said.update(commands)
        found.update(counted)
    assert said["moved"] >= 0.8 * said["given"], said
    # The report's own count against what the trace shows, which also counts throttles that only stay up.
    assert said["given"] >= 0.9 * found["given"], (said, found)
    assert abs(said["moved"] - found["moved"]) <= 0.05 * found["given"], (said, found)


def test_every_kind_of_segment_occurs(driven):
    kinds = collections.Counter()
    for sample in EVERY:
        run = driven(sample)
        if sample.on == "sim":
            continue
        command = [BATON, "plan", run.folder / "script.jsonl", "--robot", run.profile, "--world", sample.world]
        planned = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        kinds.update(s["kind"] for s in json.loads(planned.stdout)["segments"] if "kind" in s)
    assert set(kinds) == KINDS, kinds


@pytest.mark.parametrize("sample", [IDEAL[0], PHYSICS], ids=str)
def test_same_script_same_trace(driven, sample, tmp_path):
    first = driven(sample)
    script = random_script.lines(sample.seed, SECONDS, sample.style)
    again = drive(tmp_path, script, world=sample.world, on=sample.on)
    assert again.trace.read_bytes() == first.trace.read_bytes()
    assert again.model.read_bytes() == first.model.read_bytes()


# ---------------------------------------------------------------- measured is not planned


def deviation(run, *pairs):
    """Largest difference of columns that mean the same, measured and planned."""
    number = check_trace.Trace(run.trace).number
    return max(np.nanmax(np.abs(number[a] - number[b])) for a, b in pairs)


ZMP = (("zmp_x", "zmp_plan_x"), ("zmp_y", "zmp_plan_y"))
COM = (("com_x", "com_plan_x"), ("com_y", "com_plan_y"), ("com_z", "com_plan_z"))


def soft_floor(folder, time_constant):
    """The flat world with a floor that gives way, which no planner knows of; hard contacts have 0.005 s."""
    text = (ROOT / "worlds" / "flat.xml").read_text()
    floor = 'name="ground_floor" type="plane"'
    assert floor in text
    (folder / "soft.xml").write_text(text.replace(floor, f'{floor} priority="2" condim="4" friction="0.8 0.01 0.0001" solref="{time_constant} 1"'))
    return folder / "soft.xml"


def test_measured_columns_are_measured(tmp_path):
    """In physics they differ from what was planned, and differ more on a floor that gives way."""
    sample = PHYSICS
    script = random_script.lines(sample.seed, SECONDS, sample.style)
    hard = drive(tmp_path / "hard", script, world="flat", on="sim", seconds=10, more=["--plant", "model"])
    soft = drive(tmp_path / "soft", script, world=soft_floor(tmp_path, 0.03), on="sim", seconds=10, more=["--plant", "model"])
    assert 1e-3 < deviation(hard, *ZMP)
    assert 1e-5 < deviation(hard, *COM) < 5e-3
    assert deviation(soft, *COM) > 2 * deviation(hard, *COM)
    trace = check_trace.Trace(hard.trace)
    load = trace.number["force_left"] + trace.number["force_right"]
    assert np.ptp(load) > 0.5
    touch = np.stack([trace.number["touch_left"], trace.number["touch_right"]])
    contact = np.stack([trace.number["contact_left"], trace.number["contact_right"]])
    assert (touch != contact).any()


def test_a_fall_ends_the_run_and_is_written_down(tmp_path):
    """On a floor like a mattress the robot falls, whatever it plans."""
    script = ['{"t": 0, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}']
    run = drive(tmp_path, script, world=soft_floor(tmp_path, 0.3), on="sim", ends=3)
    assert "fallen" in run.said
    assert run.report["falls"] == 1 and run.report["duration_s"] < SECONDS
    fallen = [row.split(",")[3] == "fallen" for row in run.trace.read_text().splitlines()]
    since = fallen.index(True)
    assert all(fallen[since:]) and 0 < len(fallen) - since < 40, "the navigator knows it shortly before the ground does"
    assert "fall" in [violation["kind"] for violation in run.summary["violations"]]


# ---------------------------------------------------------------- the checks themselves

# A step, a shift, a hand, a foot that is lifted: in single support and in double, in motion and at rest.
SHORT = [
    {"t": 0.0, "guide": "left_foot", "axes": [0.6, 0.2, 0, 0, 0, 0]},
    {"t": 0.5, "guide": "trunk", "axes": [0, 0.5, 0, 0, 0, 0]},
    {"t": 1.5, "guide": "right_hand", "axes": [0.5, 0, 0, 0, 0, 0]},
    {"t": 2.1, "guide": "right_foot", "axes": [0, 0, 0, 0, 0, 0], "lift": [0, 0.8]},
    {"t": 3.2, "guide": "right_foot", "axes": [0, 0, 0, 0, 0, 0], "lift": [0, 0]},
]


class Table:
    """A trace to be spoilt."""

    def __init__(self, run):
        self.robot = check_trace.Robot(run.model, run.profile)
        self.names, *self.rows = [line.split(",") for line in run.trace.read_text().splitlines()]
        trace = check_trace.Trace(run.trace)
        self.number = trace.number
        self.phase = np.array(trace.word["phase"])
        self.hold = np.flatnonzero((self.phase == "hold") & (np.arange(trace.ticks) > 0))
        self.single = np.flatnonzero((self.phase == "single_left") | (self.phase == "single_right"))
        self.double = np.flatnonzero(self.phase == "double")
        self.moving = np.flatnonzero(self.phase != "hold")

    def middle(self, ticks):
        return int(ticks[len(ticks) // 2])

    def q(self, name):
        """The column of a joint's angle, and its range."""
        j = self.robot.joint_names.index(name)
        return f"qpos_{self.robot.qadr[j]}", self.robot.range[j]

    def v(self, name):
        return f"qvel_{self.robot.dadr[self.robot.joint_names.index(name)]}"

    def set(self, column, ticks, value):
        """value: a word, a number, or one for each tick."""
        k = self.names.index(column)
        ticks = np.atleast_1d(ticks)
        for tick, x in zip(ticks, np.broadcast_to(value, ticks.shape)):
            self.rows[tick][k] = x if isinstance(x, str) else f"{x:.10g}"

    def add(self, column, ticks, value):
        self.set(column, ticks, self.number[column][ticks] + value)

    def write(self, file):
        file.write_text("\n".join(",".join(row) for row in [self.names, *self.rows]) + "\n")
        return file


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    run = drive(tmp_path_factory.mktemp("short"), [json.dumps(line) for line in SHORT], world="flat", seconds=4.5)
    assert run.summary["violations"] == []
    return run


def every(table):
    return np.arange(len(table.rows))


def bump(ticks, height):
    """From 0 to the height and back."""
    return height * np.sin(np.pi * (np.arange(len(ticks)) + 0.5) / len(ticks)) ** 2


def beyond_range(t):
    column, (lowest, _) = t.q("left_knee_flexion")
    t.set(column, t.middle(t.moving), lowest - 1e-3)


def target_beyond_range(t):
    _, (_, highest) = t.q("left_knee_flexion")
    t.set("target_left_knee_flexion", t.middle(t.moving), highest + 1e-3)


def too_fast(t):
    t.set(t.v("right_hip_flexion"), t.middle(t.moving), 6.0)


def leaps(t):
    t.add(t.q("right_elbow_flexion")[0], t.middle(t.moving), 0.05)


def not_a_number(t):
    t.set("com_plan_z", t.middle(t.moving), "nan")


def infinite(t):
    t.set("force_left", 17, "inf")


def com_elsewhere(t):
    t.add("com_y", t.middle(t.moving), 1e-4)


def com_plan_elsewhere(t):
    t.add("com_plan_x", t.middle(t.moving), 2e-3)


def zmp_plan_elsewhere(t):
    t.add("zmp_plan_y", t.middle(t.single), 0.01)


def stands_on_the_wrong_foot(t):
    ticks = t.single[len(t.single) // 3 : len(t.single) // 2]
    for side in check_trace.SIDES:
        other = 1 - t.number[f"contact_{side}"][ticks]
        t.set(f"contact_{side}", ticks, other)
        t.set("phase", ticks, np.where(other == 1, f"single_{side}", [t.rows[k][3] for k in ticks]))


def stands_on_one_foot_only(t):
    t.set("contact_right", t.hold[:40], 0)


def shaken(t):
    for column in ("qpos_0", "com_x"):
        t.add(column, every(t), 0.02 * np.sin(0.1 * every(t)))


def slides(t):
    t.add("qpos_1", every(t), np.linspace(0, 2e-3, len(t.rows)))


def sinks(t):
    t.add("qpos_2", every(t), -1e-3)


def feet_too_close(t):
    t.add(t.q("left_hip_abduction")[0], every(t), -0.08)


def arm_in_trunk(t):
    for joint in ("shoulder_abduction", "elbow_flexion", "shoulder_flexion"):
        t.set(t.q(f"left_{joint}")[0], every(t), 0.0)
    t.set(t.q("left_elbow_rotation")[0], every(t), 0.0)
    t.set(t.q("left_elbow_flexion")[0], every(t), 1.5)


def too_strong(t):
    ticks = t.moving[:14]
    t.add(t.q("left_shoulder_flexion")[0], ticks, bump(ticks, 0.08))


def leans(t):
    tilt = 0.4 / 2
    for i, x in enumerate((np.cos(tilt), 0.0, np.sin(tilt), 0.0)):
        t.set(f"qpos_{3 + i}", every(t), x)


def quaternion_too_long(t):
    t.add("qpos_3", 40, 1e-3)


def clock_stops(t):
    t.set("t", 50, t.number["t"][49])


def motion_in_hold(t):
    t.set(t.v("left_knee_flexion"), t.hold[3], 0.01)


def drifts_in_hold(t):
    t.add(t.q("left_elbow_flexion")[0], t.hold[3], 1e-6)


def target_not_followed(t):
    t.add("target_left_knee_flexion", t.middle(t.moving), 1e-4)


def unknown_phase(t):
    t.set("phase", 60, "flying")


def phase_of_another(t):
    t.set("phase", t.middle(t.double), "single_left")


def both_feet_off(t):
    for side in check_trace.SIDES:
        t.set(f"contact_{side}", t.middle(t.double), 0)


def segment_left_out(t):
    later = np.flatnonzero(t.number["segment"] >= 1)
    t.add("segment", later, 1)


def segment_in_hold(t):
    t.set("segment", t.hold[2], 0)


def falls(t):
    t.set("phase", len(t.rows) - 1, "fallen")


def touches_otherwise(t):
    t.set("touch_left", t.hold[5], 0)


def stamps(t):
    t.add("qpos_2", every(t), 2e-3 * np.sin(0.4 * every(t)))


def bend_knees(t, more):
    for side in check_trace.SIDES:
        for joint, share in (("hip_flexion", 1), ("knee_flexion", 2), ("ankle_flexion", 1)):
            t.add(t.q(f"{side}_{joint}")[0], every(t), share * more)


def crouches(t):
    bend_knees(t, 0.35)


def stretches(t):
    bend_knees(t, -0.45)


def turns_a_foot(t):
    t.add(t.q("left_knee_rotation")[0], every(t), 0.45)


def straddles(t):
    t.add(t.q("left_hip_abduction")[0], every(t), 0.6)


SPOILT = {
    beyond_range: {"joint_range"},
    target_beyond_range: {"target_range"},
    too_fast: {"joint_speed", "consistency"},
    leaps: {"joint_step", "consistency", "target_followed"},
    not_a_number: {"not_finite"},
    infinite: {"not_finite"},
    com_elsewhere: {"com_column"},
    com_plan_elsewhere: {"com_plan_column"},
    zmp_plan_elsewhere: {"zmp_plan_column"},
    stands_on_the_wrong_foot: {"zmp_inside", "zmp_verified", "zmp_from_speeds", "both_soles_change"},
    stands_on_one_foot_only: {"zmp_inside", "hold_contact", "touch_contact"},
    shaken: {"zmp_inside", "friction", "root_consistency", "momentum_consistency", "sole_slip"},
    slides: {"sole_slip", "com_plan_column"},
    sinks: {"sole_off_ground", "swing_above_ground"},
    feet_too_close: {"sole_gap"},
    arm_in_trunk: {"self_collision"},
    too_strong: {"motor_torque", "motor_load"},
    leans: {"trunk_inclination"},
    quaternion_too_long: {"quaternion"},
    clock_stops: {"time"},
    motion_in_hold: {"rest_speed"},
    drifts_in_hold: {"rest_step"},
    target_not_followed: {"target_followed"},
    unknown_phase: {"phase_word"},
    phase_of_another: {"phase_contact"},
    both_feet_off: {"no_contact"},
    segment_left_out: {"segment_order"},
    segment_in_hold: {"segment_hold"},
    falls: {"fall"},
    touches_otherwise: {"touch_contact"},
    stamps: {"normal_force"},
    crouches: {"com_height_low"},
    stretches: {"com_height_high"},
    turns_a_foot: {"foot_yaw"},
    straddles: {"feet_apart"},
}


@pytest.mark.parametrize("spoil", SPOILT, ids=lambda spoil: spoil.__name__)
def test_a_spoilt_trace_is_found_out(short, tmp_path, spoil):
    table = Table(short)
    spoil(table)
    summary = check_trace.check(table.write(tmp_path / "spoilt.csv"), short.model, short.profile, "ideal")
    found = {violation["kind"] for violation in summary["violations"]}
    assert SPOILT[spoil] <= found


@pytest.mark.parametrize(
    "key, value",
    [("duration_s", 4.0), ("falls", 1), ("commands", {"given": 2, "moved": 3}), ("final", {"com": [0, 0, 0.26]}), ("zmp_margin_m", {"measured_min": 0.03})],
)
def test_a_report_that_lies_is_found_out(short, key, value):
    summary = check_trace.check(short.trace, short.model, short.profile, "ideal", {**short.report, key: value})
    kind = {"duration_s": "report_duration", "final": "report_com", "zmp_margin_m": "report_zmp_margin"}.get(key, f"report_{key}")
    assert [violation["kind"] for violation in summary["violations"]] == [kind]


def test_a_row_cut_short_is_an_error(short, tmp_path):
    text = short.trace.read_text()
    (tmp_path / "cut.csv").write_text(text[: len(text) - 20])
    with pytest.raises(ValueError, match="row 900 has"):
        check_trace.check(tmp_path / "cut.csv", short.model, short.profile)
