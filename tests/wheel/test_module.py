"""The Python package, as `make test-wheel` installs it: its commands, events and errors, and robots of one's own."""

import ast
import math
import pathlib
import re
import signal

import numpy as np
import pytest

import baton

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARTS = ["left_foot", "right_foot", "left_hand", "right_hand", "trunk"]
RECALLS = ["none", "retrace", "home", "stop"]
FORWARD = [1, 0, 0, 0, 0, 0]


@pytest.fixture(scope="module")
def robot():
    return baton.Robot("mighty")


def targets(run, seconds):
    """The joint targets of every tick."""
    rows = []
    while run.t < seconds:
        run.step()
        rows.append(run.target.q + run.target.q_correction)
    return np.array(rows)


def test_the_package_is_the_installed_one():
    assert ROOT not in pathlib.Path(baton.__file__).resolve().relative_to("/").parents
    assert "site-packages" in baton.__file__


def test_a_robot_tells_what_it_is(robot):
    assert robot.name == "mighty" and len(robot.joints) == 20
    assert robot.mass == pytest.approx(5.53, abs=0.01) and robot.period == 0.005
    assert all(joint.lower < joint.upper and joint.torque > 0 and joint.speed > 0 for joint in robot.joints)
    assert robot.kp.shape == robot.kd.shape == (20,) and (robot.kp > 0).all()
    assert robot.standing().shape == (27,)
    assert baton.Robot("mighty", drive="stiff").drive == "stiff"
    assert baton.robots()["mighty"]


def test_the_trunk_walks_and_comes_to_rest(robot):
    run = baton.Run(robot, plant="model")
    run.guide("trunk", FORWARD)
    events = run.advance(6.0)
    run.release()
    events += run.advance(4.0)
    steps = [e for e in events if isinstance(e, baton.Committed) and e.kind == "step"]
    assert len(steps) >= 6 and all(e.guided == "trunk" and e.purpose == "follow" and e.duration > 0 for e in steps)
    segments = [e.segment for e in events if isinstance(e, baton.Committed)]
    assert segments == list(range(len(segments)))
    assert isinstance(events[-1], baton.Ended) and run.resting and not run.fallen
    assert [e.t for e in events] == sorted(e.t for e in events)
    assert run.truth.q[0] - robot.standing()[0] > 0.2
    assert run.com[:2] == pytest.approx(run.truth.q[:2], abs=0.06)  # the COM is above the pelvis
    assert run.pose("left_foot")[2, 3] == pytest.approx(0.0, abs=0.002)


def test_a_lever_stays_where_it_was(robot):
    run = baton.Run(robot, plant="model")
    run.guide("left_foot", lift=1.0)
    run.advance(3.0)
    assert run.pose("left_foot")[2, 3] > 0.02 and run.resting
    run.guide("left_foot", [0.5, 0, 0, 0, 0, 0])
    assert run.command.lift == (1.0, 0.0)
    run.advance(1.0)
    run.release()
    run.advance(1.0)
    assert run.command.lift == (1.0, 0.0) and run.pose("left_foot")[2, 3] > 0.02
    run.guide("left_foot", lift=0.0)
    run.advance(4.0)
    assert run.pose("left_foot")[2, 3] < 0.002 and not run.fallen


def test_the_same_commands_give_the_same_run_again(robot):
    run = baton.Run(robot, seed=3)
    run.guide("trunk", FORWARD)
    first = targets(run, 3.0)
    run.reset()
    assert run.t == 0 and run.measurement is None and run.target is None and run.command == baton.Command()
    run.guide("trunk", FORWARD)
    assert np.array_equal(first, targets(run, 3.0))
    other = baton.Run(robot, seed=4)
    other.guide("trunk", FORWARD)
    assert not np.array_equal(first, targets(other, 3.0))


def test_a_step_and_advance_are_the_same(robot):
    a, b = baton.Run(robot, seed=5), baton.Run(robot, seed=5)
    command = baton.Command("trunk", FORWARD)
    happened = []
    for _ in range(400):
        happened += a.step(command)
    b.guide("trunk", FORWARD)
    assert [repr(e) for e in happened] == [repr(e) for e in b.advance(2.0)]
    assert np.array_equal(a.truth.q, b.truth.q)


def test_no_command_breaks_a_run(robot):
    """Whatever the stick does, in 20 runs of 400 ticks: nothing is raised, nothing falls, all targets are finite."""
    strange = [0.0, 1.0, -1.0, 5.0, 1e300, -1e-310, math.nan, math.inf, -math.inf]
    told = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        run = baton.Run(robot, seed=seed, live=seed % 4 == 0)
        for _ in range(400):
            if random.random() < 0.1:
                axes = random.choice(strange, 6) if random.random() < 0.3 else random.uniform(-1, 1, 6)
                lift = tuple(random.choice(strange + [0.5] * 9, 2))
                command = baton.Command(random.choice(PARTS), axes, lift=lift, recall=random.choice(RECALLS, p=[0.7, 0.1, 0.1, 0.1]))
            else:
                command = None
            told += len(run.step(command))
            target = run.target
            for values in (target.q, target.dq, target.tau, target.q_correction):
                assert np.isfinite(values).all()
        assert not run.fallen
    assert told > 100


def test_a_refusal_says_why(robot):
    run = baton.Run(robot, plant="model")
    run.guide("left_foot", [0, -1, 0, 0, 0, 0])  # into the other foot
    run.advance(1.0)
    run.guide("left_hand", [0, 0, 1, 0, 0, 0])
    refusals = [e.refusal for e in run.advance(8.0) if isinstance(e, baton.Refused)]
    assert refusals
    known = set(re.findall(r"`(\w+)`", (ROOT / "docs" / "refusals.md").read_text()))
    for refusal in refusals:
        assert refusal.reason in known and refusal.part in PARTS
        assert refusal.unit == "none" or f"{refusal.limit:.4g}" in str(refusal)


@pytest.mark.parametrize(
    "call, says",
    [
        (lambda r: baton.Robot("nobody"), "nobody"),
        (lambda r: baton.Robot("mighty", drive="warp"), "warp"),
        (lambda r: baton.Robot("g1"), "python -m baton.fetch_robots"),
        (lambda r: baton.Command("arm"), 'part "arm": must be one of left_foot'),
        (lambda r: baton.Command("trunk", [1, 2]), r"axes has the shape \(2,\); must be \(6,\)"),
        (lambda r: baton.Command("trunk", "up"), "axes 'up': must be numbers"),
        (lambda r: baton.Command(recall="back"), 'recall "back": must be one of none'),
        (lambda r: baton.Run(r, "nowhere"), "nowhere"),
        (lambda r: baton.Run(r, on="air"), 'on "air": must be one of sim, ideal'),
        (lambda r: baton.Run(r, on=3), "3 has no method read"),
        (lambda r: baton.Run(r, plant="odd"), 'plant "odd": must be one of real, model'),
        (lambda r: baton.Run(r, state="odd"), 'state "odd"'),
        (lambda r: baton.Run(r, gait="odd"), 'gait "odd"'),
        (lambda r: baton.Run(r, duration="odd"), 'duration "odd"'),
        (lambda r: baton.Run(r, on_limit="odd"), 'on_limit "odd"'),
        (lambda r: baton.Run(r, scenario="odd"), "odd: must be one of nominal"),
        (lambda r: baton.Run(r, on="ideal", scenario="push"), "physics"),
        (lambda r: baton.Run(r).guide("trunk", lift=1.0), "only a foot has a lever"),
        (lambda r: baton.Run(r).guide("trunk", [1]), "axes has the shape"),
        (lambda r: baton.Run(r).pose("trunk"), "before the first step"),
        (lambda r: baton.Run(r).advance(-1.0), "seconds -1"),
        (lambda r: baton.Run(r).advance(math.nan), "seconds nan"),
        (lambda r: baton.Run(r, on="ideal").qpos, "qpos: only of a robot on 'sim'"),
    ],
)
def test_wrong_input_is_named(robot, call, says):
    with pytest.raises(baton.InputError, match=says):
        call(robot)


def test_a_wrong_command_changes_nothing(robot):
    run = baton.Run(robot)
    run.guide("left_foot", [0.5, 0, 0, 0, 0, 0], lift=0.3)
    held = run.command
    with pytest.raises(baton.InputError):
        run.guide("trunk", [1, 1])
    with pytest.raises(baton.InputError):
        run.guide("trunk", lift=0.5)
    assert run.command == held


def test_advance_can_be_interrupted(robot):
    class Enough(Exception):
        pass

    def enough(*_):
        raise Enough

    before = signal.signal(signal.SIGALRM, enough)
    try:
        run = baton.Run(robot)
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(Enough):
            run.advance(1e6)
    finally:
        signal.signal(signal.SIGALRM, before)
    run.advance(0.1)  # and goes on
    assert not run.fallen


class Mine:
    """A robot that does as it is told, through the simulation of another run."""

    def __init__(self, robot):
        self.inner = baton.Run(robot, plant="model")
        self.inner.advance(0.5)  # it stands
        self.asked = 0

    def read(self):
        self.asked += 1
        return self.inner.measurement

    def write(self, target):
        self.target = target


def test_a_robot_of_ones_own_is_read_and_told(robot):
    mine = Mine(robot)
    run = baton.Run(robot, on=mine)
    run.advance(0.1)
    assert mine.asked == 20 and run.truth is None
    assert mine.target.q.shape == (20,)
    q, dq, tau = robot.servo_command(mine.target)
    kp = robot.kp
    assert np.allclose(q, mine.target.q + mine.target.q_correction + mine.target.tau / kp)  # pd: the torque is in the angle
    assert np.allclose(dq, mine.target.dq) and (tau == 0).all()
    with pytest.raises(baton.InputError, match="reset"):
        run.reset()


def measurement(n, **other):
    fields = {"t": 0.0, "q": np.zeros(n), "dq": np.zeros(n), "attitude": np.eye(3), "rate": [0, 0, 0], "acceleration": [0, 0, 9.81]}
    return baton.Measurement(**{**fields, **other})


def test_what_a_robot_says_is_checked(robot):
    mine = Mine(robot)
    run = baton.Run(robot, on=mine)
    mine.read = lambda: None
    with pytest.raises(baton.InputError, match="gave None; must give a baton.Measurement"):
        run.step()
    mine.read = lambda: measurement(7)
    with pytest.raises(baton.InputError, match="7 joint angles"):
        run.step()
    mine.read = lambda: 1 / 0
    with pytest.raises(ZeroDivisionError):
        run.step()
    with pytest.raises(baton.InputError, match=r"attitude has the shape \(3,\); must be \(3, 3\)"):
        measurement(20, attitude=[0, 0, 0])
    reading = measurement(20, torque=np.arange(20.0), left_sole=[1, 2, 3, 4, 5, 6], age=0.1)
    assert reading.torque[3] == 3 and reading.left_sole.tolist() == [1, 2, 3, 4, 5, 6] and (reading.right_sole == 0).all()
    assert measurement(20).torque is None


def test_broken_readings_are_bridged_and_told(robot):
    class Broken(Mine):
        def read(self):
            good = self.inner.measurement
            bad = 40 <= self.asked < 45
            self.asked += 1
            return measurement(20, t=0.005 * self.asked, q=good.q, dq=good.dq, attitude=np.full((3, 3), math.nan) if bad else good.attitude,
                               acceleration=good.acceleration, left_sole=good.left_sole, right_sole=good.right_sole)  # fmt: skip

    run = baton.Run(robot, on=Broken(robot))
    health = [(e.sensor, e.health) for e in run.advance(1.0) if isinstance(e, baton.SensorChanged)]
    assert health == [("attitude", "bridged"), ("attitude", "good")]
    assert run.guard == "armed"


def test_the_simulated_model_can_be_drawn(robot):
    mujoco = pytest.importorskip("mujoco")
    run = baton.Run(robot, "room", seed=2)
    run.advance(0.5)
    model = mujoco.MjModel.from_xml_string(run.mjcf)
    data = mujoco.MjData(model)
    assert run.qpos.shape == (model.nq,)
    data.qpos[:] = run.qpos
    mujoco.mj_forward(model, data)
    assert data.subtree_com[0][2] > 0.2


def test_stubs_have_every_name():
    stub = ast.parse((pathlib.Path(baton.__file__).parent / "_core.pyi").read_text())
    classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
    for name in baton.__all__:
        if name not in ("Event", "robots"):
            assert name in classes
    for name in ("Robot", "Run", "Command", "Measurement"):
        members = {node.name for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        public = {member for member in vars(getattr(baton, name)) if not member.startswith("_")}
        assert public and public <= members
    assert "std::" not in ast.unparse(stub)
