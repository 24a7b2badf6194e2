"""The Python package, as `make test-wheel` installs it: its commands, events and errors, and robots of one's own."""

import ast
import gc
import math
import pathlib
import re
import signal
import subprocess
import sys
import threading
import weakref

import mujoco
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
    assert pathlib.Path(baton.__file__).is_relative_to(sys.prefix)
    assert re.fullmatch(r"\d+\.\d+\.\d+", baton.__version__)


def test_the_licences_of_what_it_contains_are_there():
    package = pathlib.Path(baton.__file__).parent
    libraries = {re.match(r"lib[a-z]+", file.name)[0] for file in package.with_name("baton.libs").iterdir()}
    licences = {file.stem for file in (package / "licences").iterdir()}
    assert len(libraries) >= 4 and libraries | {"nanobind", "libeigen3-dev", "nlohmann-json3-dev"} <= licences
    assert all("Licen" in file.read_text() or "Copyright" in file.read_text() for file in (package / "licences").iterdir())


def test_a_robot_tells_what_it_is(robot):
    assert robot.name == "mighty" and len(robot.joints) == 20
    assert robot.mass == pytest.approx(5.53, abs=0.01) and robot.period == 0.005
    assert all(joint.lower < joint.upper and joint.torque > 0 and joint.speed > 0 for joint in robot.joints)
    assert robot.kp.shape == robot.kd.shape == (20,) and (robot.kp > 0).all()
    assert robot.standing().shape == (27,)
    assert baton.Robot("mighty", drive="stiff").drive == "stiff"
    assert baton.robots()["mighty"] and "push" in baton.scenarios()
    assert baton.Robot(pathlib.Path(ROOT / "robots" / "mighty" / "profile.toml")).nq == robot.nq == 27
    with pytest.raises(baton.InputError, match="must be a name or a file"):
        baton.Robot(3)


def test_commands_are_compared_by_value():
    assert baton.Command("trunk", FORWARD) == baton.Command("trunk", np.array(FORWARD))
    assert baton.Command() != baton.Command(recall="home") and baton.Command() != None and baton.Command() not in [3, "x"]  # noqa: E711
    with pytest.raises(TypeError):
        hash(baton.Command())


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


def test_arms_follow_what_drives_them_while_it_walks(robot):
    run = baton.Run(robot, seed=3)
    joints = ["left_elbow_flexion", "right_elbow_flexion"]
    index = [[joint.name for joint in robot.joints].index(name) for name in joints]
    run.guide("trunk", FORWARD)
    run.drive_arms(joints, [1.0, 2.0], [[0.9, 0.9], [0.6, 1.3]])
    run.advance(3.0)
    assert run.measurement.q[index] == pytest.approx([0.6, 1.3], abs=0.06)
    run.release_arms()
    run.advance(1.0)
    assert not run.fallen and run.truth.q[0] > 0.05


def test_the_same_commands_give_the_same_run_again(robot):
    run = baton.Run(robot, seed=3)
    run.guide("trunk", FORWARD)
    first = targets(run, 3.0)
    run.advance(0.002)  # is forgotten
    run.reset()
    run.advance(0.002)
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


def test_what_is_left_of_a_tick_counts_the_next_time(robot):
    run = baton.Run(robot, on="ideal")
    for _ in range(100):
        run.advance(0.002)
    assert run.t == pytest.approx(0.2, abs=0.0026)
    run.step()
    run.advance(0.05)
    assert run.t == pytest.approx(0.255, abs=0.0026)


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
        (lambda r: baton.Run(r, on=3), "on 3: has no method read"),
        (lambda r: baton.Run(r, plant="odd"), 'plant "odd": must be one of real, model'),
        (lambda r: baton.Run(r, state="odd"), 'state "odd"'),
        (lambda r: baton.Run(r, gait="odd"), 'gait "odd"'),
        (lambda r: baton.Run(r, duration="odd"), 'duration "odd"'),
        (lambda r: baton.Run(r, on_limit="odd"), 'on_limit "odd"'),
        (lambda r: baton.Run(r, scenario="odd"), 'scenario "odd": must be one of nominal'),
        (lambda r: baton.Run(r, on="ideal", scenario="push"), "scenario: must be on='sim'"),
        (lambda r: baton.Run(r, on="ideal", plant="model"), "plant: must be on='sim'"),
        (lambda r: baton.Run(r, times=2.0), "times 2: needs a scenario"),
        (lambda r: baton.Run(r, scenario="push", times=math.nan), "times nan: must be above 0"),
        (lambda r: baton.Run(r, scenario="push", times=1e8), "times 100000000: must be above 0, and at most 100"),
        (lambda r: baton.Run(r, seed=-1), "seed -1: must be 0 or more"),
        (lambda r: baton.Run(r, "\ud800"), "must be a name or a file"),
        (lambda r: baton.Robot("mighty\0x"), "must be a name or a file"),
        (lambda r: baton.Command("trunk", [None] * 6), "must be numbers"),
        (lambda r: baton.Command("trunk", ["1"] * 6), "must be numbers"),
        (lambda r: baton.Command("trunk", [1j] * 6), "must be numbers"),
        (lambda r: measurement(20, age=-1.0), "age -1: must be 0 or more"),
        (lambda r: baton.Run(r, scenario="stiff", times=2.0), "stiff has no size"),
        (lambda r: baton.Run(r, 7), "world 7: must be a name or a file"),
        (lambda r: baton.Run(r, on=Mine(r), state="perfect"), "has no truth"),
        (lambda r: r.mjcf(timestep=0.0), "timestep 0"),
        (lambda r: baton.Run(r).guide("trunk", lift=1.0), "only a foot has a lever"),
        (lambda r: baton.Run(r).guide("trunk", [1]), "axes has the shape"),
        (lambda r: baton.Run(r).drive_arms(["left_knee_flexion"], [1], [[0]]), "left_knee_flexion.*none of an arm"),
        (lambda r: baton.Run(r).drive_arms(["left_elbow_flexion"], [1, 2], [[0]]), "1 × 1 numbers: must be 2 × 1"),
        (lambda r: baton.Run(r).drive_arms(["left_elbow_flexion"], [], [[]]), "t has no times"),
        (lambda r: baton.Run(r).pose("head"), 'part "head"'),
        (lambda r: baton.Run(r).advance(-1.0), "seconds -1"),
        (lambda r: baton.Run(r).advance(math.nan), "seconds nan"),
        (lambda r: baton.Run(r).advance(1e17), r"seconds 1e\+17: must be 0 … "),
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
    assert mine.asked == 20 and run.truth is None and run.qpos is None and run.mjcf is None
    assert mine.target.q.shape == (20,)
    q, dq, tau = robot.servo_command(mine.target)
    kp = robot.kp
    assert np.allclose(q, mine.target.q + mine.target.q_correction + mine.target.tau / kp)  # pd: the torque is in the angle
    assert np.allclose(dq, mine.target.dq) and (tau == 0).all()
    with pytest.raises(baton.InputError, match="reset"):
        run.reset()
    mine.reset = lambda: None
    run.reset()
    assert run.t == 0
    run.advance(0.1)
    assert run.t == pytest.approx(0.1)
    other = baton.Robot("g1") if baton.robots()["g1"] else None
    if other is not None:
        with pytest.raises(baton.InputError, match="has 20 joints; must have the 29"):
            other.servo_command(mine.target)
    with pytest.raises(baton.InputError, match="to_end nan"):
        robot.servo_command(mine.target, math.nan)


def test_a_robot_of_ones_own_cannot_step_its_run(robot):
    mine = Mine(robot)
    run = baton.Run(robot, on=mine)
    for name in ("read", "write"):
        good = getattr(mine, name)
        for call in (run.step, run.reset, lambda: run.advance(0.1)):
            setattr(mine, name, lambda *args, call=call: call())
            with pytest.raises(RuntimeError, match="in a step"):
                run.step()
        setattr(mine, name, good)
    mine.write = lambda target: run.guide("trunk", FORWARD)  # may be
    run.step()
    assert run.command.axes[0] == 1


def test_the_time_goes_on_if_a_target_could_not_be_written(robot):
    mine = Mine(robot)
    run = baton.Run(robot, on=mine)
    run.advance(0.1)
    good = mine.write
    mine.write = lambda target: 1 / 0
    with pytest.raises(ZeroDivisionError):
        run.step()
    mine.write = good
    assert run.t == pytest.approx(0.105)
    run.advance(0.1)
    assert run.t == pytest.approx(0.205) and mine.asked == 41


def test_a_run_is_for_one_thread_at_a_time(robot):
    entered, leave = threading.Event(), threading.Event()

    class Slow(Mine):
        def write(self, target):
            entered.set()
            leave.wait(60)

    run = baton.Run(robot, on=Slow(robot))
    thread = threading.Thread(target=run.step)
    thread.start()
    assert entered.wait(60)
    for call in (run.step, run.reset, run.release, lambda: run.t, lambda: run.com, lambda: run.measurement, lambda: run.pose("trunk")):
        with pytest.raises(RuntimeError, match="another thread"):
            call()
    leave.set()
    thread.join()
    run.step()
    assert run.t == pytest.approx(0.01)


def test_runs_on_threads_of_their_own_do_not_meet(robot):
    def drive(seed, into):
        run = baton.Run(robot, seed=seed)
        run.guide("trunk", FORWARD)
        run.advance(2.0)
        into[seed] = run.truth.q

    alone, together = {}, {}
    for seed in range(3):
        drive(seed, alone)
    threads = [threading.Thread(target=drive, args=(seed, together)) for seed in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for seed in range(3):
        assert np.array_equal(alone[seed], together[seed])


def test_a_robot_that_knows_its_run_is_freed(robot):
    mine = Mine(robot)
    mine.run = baton.Run(robot, on=mine)
    mine.run.step()
    gone = weakref.ref(mine)
    del mine
    gc.collect()
    assert gone() is None


def test_a_live_run_ends_while_it_plans(robot):
    for ticks in (1, 2, 15):
        run = baton.Run(robot, live=True)
        run.guide("trunk", FORWARD)
        for _ in range(ticks):
            run.step()
        del run


def test_its_own_simulations_are_quiet(tmp_path):
    code = "import baton; run = baton.Run('mighty', scenario='push', times=50.0); run.advance(6.0); print(run.fallen)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert (done.stdout, done.stderr) == ("True\n", "") and not list(tmp_path.iterdir())


def test_an_exception_of_an_argument_is_its_own(robot):
    class Odd:
        def __array__(self, *args, **kwargs):
            raise KeyboardInterrupt

        def __fspath__(self):
            raise KeyboardInterrupt

    for call in (lambda: baton.Command("trunk", Odd()), lambda: baton.Robot(Odd())):
        with pytest.raises(KeyboardInterrupt):
            call()


def test_an_impossible_reading_is_never_believed(robot):
    mine = Mine(robot)
    run = baton.Run(robot, on=mine)
    run.advance(0.2)
    good = mine.inner.measurement
    for angle in (10.0, -1e308, 1e200):
        q = good.q.copy()
        q[14] = angle
        mine.read = lambda q=q: measurement(20, q=q, attitude=good.attitude, left_sole=good.left_sole, right_sole=good.right_sole)
        events = run.advance(1.0)
        health = [e.health for e in events if isinstance(e, baton.SensorChanged) and e.sensor == "encoders"]
        assert health == ["bridged", "lost"]
        assert np.isfinite(run.target.q).all() and np.isfinite(run.target.tau).all()
        mine.read = lambda: good
        run.advance(1.0)


def test_warnings_of_other_simulations_stay(robot):
    heard = []
    mujoco.set_mju_user_warning(heard.append)
    try:
        baton.Run(robot).step()
        model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>")
        data = mujoco.MjData(model)
        data.qvel[0] = math.nan
        mujoco.mj_step(model, data)
    finally:
        mujoco.set_mju_user_warning(None)
    assert any("Nan" in text for text in heard)


def test_models_are_fetched_into_a_folder(tmp_path):
    command = [sys.executable, "-m", "baton.fetch_robots", "--into", tmp_path, "--wheels", ROOT / "build" / "wheels"]
    folder = tmp_path / "jvrc1"
    folder.mkdir()
    (folder / "profile.toml").write_text((ROOT / "robots" / "jvrc1" / "profile.toml").read_text())
    for says in ("jvrc1: fetched", "jvrc1: already there"):
        done = subprocess.run([*command, "jvrc1"], capture_output=True, text=True)
        assert done.returncode == 0 and says in done.stderr, done.stderr
    assert len(baton.Robot(folder / "profile.toml").joints) == 32
    assert "License" in (folder / "model" / "licences" / "METADATA").read_text()
    done = subprocess.run([*command, "nobody"], capture_output=True, text=True)
    assert done.returncode == 2 and "known: g1 t1 talos rcss_k1 rcss_t1 jvrc1" in done.stderr


def measurement(n, **other):
    fields = {"t": 0.0, "q": np.zeros(n), "dq": np.zeros(n), "attitude": np.eye(3), "rate": [0, 0, 0],
              "acceleration": [0, 0, 9.81], "left_sole": [0, 0, 27, 0, 0, 0], "right_sole": [0, 0, 27, 0, 0, 0]}  # fmt: skip
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
    for state, missing, says in (("sensors", {"left_sole": None, "right_sole": None}, "no forces under the soles"), ("torques", {}, "no motor torques")):
        run = baton.Run(robot, on=mine, state=state)
        mine.read = lambda missing=missing: measurement(20, **missing)
        with pytest.raises(baton.InputError, match=says):
            run.step()
    reading = measurement(20, torque=np.arange(20.0), left_sole=[1, 2, 3, 4, 5, 6], right_sole=None, age=0.1)
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
        if name not in ("Event", "robots", "scenarios"):
            assert name in classes
    for name in ("Robot", "Run", "Command", "Measurement"):
        members = {node.name for node in classes[name].body if isinstance(node, ast.FunctionDef)}
        public = {member for member in vars(getattr(baton, name)) if not member.startswith("_")}
        assert public and public <= members
    assert "std::" not in ast.unparse(stub)
