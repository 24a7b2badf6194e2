"""`baton bridge unitree` between `baton drive` and a Unitree G1 in MuJoCo that is on DDS by the maker's own SDK
(unitree_g1.py), in a network namespace of its own, in real time.
"""

import functools
import json
import pathlib
import signal
import sys
import time

import pytest
from unitree_network import BATON, SOON, Bridge, Program, network_with_g1, started

pytest.importorskip("unitree_interface", reason="the maker's SDK has no wheel for this Python")

G1 = pathlib.Path(__file__).with_name("unitree_g1.py")
HANGING = 0.85  # height of the gantry at which the feet are in the air [m]
TOUCHING = 0.76  # the soles touch the ground and carry a part of the weight
SLACK = 0.5


class Robot(Program):
    def __init__(self, network, *options):
        super().__init__(network, sys.executable, G1, "--switcher", "--gantry", HANGING, *options)

    def look(self):
        self.type("look")
        return json.loads(self.await_line(self.process.stdout, '"height"'))


def wait(robot, seconds):
    """Looks at the robot meanwhile."""
    seen = [robot.look()]
    while seen[-1]["t"] < seen[0]["t"] + seconds:
        time.sleep(0.1)
        seen.append(robot.look())
    print(*(f"{k} {v:.3f}" for k, v in seen[-1].items() if isinstance(v, float)), sep=", ")
    return seen


@pytest.fixture
def limp():
    """A robot that hangs limp, its feet in the air, and its bridge."""
    with network_with_g1() as network, started(Robot, network) as robot, started(Bridge, network) as bridge:
        bridge.await_ready()
        assert robot.look()["kp"] == 0.0
        yield network, robot, bridge


@pytest.fixture
def hanging(limp):
    """The same in its stance, its soles on the ground."""
    _, robot, bridge = limp
    bridge.type("s")
    bridge.await_log("takes its stance")
    wait(robot, 2.0)
    for _ in range(10):
        if wait(robot, 0.5)[-1]["speed"] < 0.05:
            break
    robot.type(f"height {TOUCHING}")
    wait(robot, 1.5)
    return limp


class Driver(Program):
    """Drives by a script; the gantry is let down when it has begun, unless it is told of it."""

    def __init__(self, network, robot, bridge, script, seconds, *more):
        super().__init__(
            network, BATON, "drive", "--robot", "g1", "--on", bridge.address, "--world", "flat", "--state", "torques",
            "--headless", "--input", f"script:{script}", "--seconds", seconds, *more, first=SOON,
        )  # fmt: skip
        if "--gantry" in more:
            return
        bridge.await_log("the motors follow the driver")
        time.sleep(0.5)
        robot.type(f"height {SLACK}")

    def outcome(self):
        out, err = self.process.communicate(timeout=30)
        print(out, err)
        return self.process.returncode, out, err


@pytest.fixture
def script(tmp_path):
    """Writes a script of the stick: lines of (time, guided part or None, forward)."""

    def write(*lines):
        file = tmp_path / "script.jsonl"
        with file.open("w") as out:
            for t, part, forward in lines:
                line = {"t": t, "axes": [forward, 0, 0, 0, 0, 0]}
                out.write(json.dumps(line | ({"guide": part} if part else {})) + "\n")
        return file

    return write


def stands(seen):
    return all(look["upright"] > 0.97 and look["height"] > 0.65 for look in seen)


def lies_limp(look):
    return look["kp"] == 0.0 and look["kd"] > 0.0


def in_real_time(test):
    """Robot and bridge live in real time: where the computer has lost some of it, a failure tells nothing."""

    @functools.wraps(test)
    def judged(**fixtures):
        _, robot, _ = fixtures.get("hanging") or fixtures["limp"]
        try:
            test(**fixtures)
        except AssertionError:
            if (lost := robot.look()["lost"]) > 0.0:
                pytest.skip(f"this computer has lost {lost:.2f} s of real time")
            raise

    return judged


@in_real_time
def test_it_stands_walks_stops_and_is_handed_back(hanging, script):
    network, robot, bridge = hanging
    driver = Driver(network, robot, bridge, script((0, "trunk", 0), (6, None, 1), (12, None, 0)), 15)
    standing = wait(robot, 5.0)
    assert stands(standing)
    walking = wait(robot, 9.0)
    assert stands(walking)
    forward = walking[-1]["x"] - standing[-1]["x"]
    print(f"it walked {forward:.3f} m")
    assert forward > 0.15
    code, out, _ = driver.outcome()
    assert code == 0 and "on its feet, as far as its sensors tell" in out
    bridge.await_log("the motors brake")
    assert lies_limp(wait(robot, 0.2)[-1])
    assert bridge.end() == 0


@in_real_time
def test_its_driver_leads_it_from_hanging_limp_to_a_walk(limp, script):
    network, robot, bridge = limp
    stick = script((0, "trunk", 0), (13, None, 1), (25, None, 0))
    driver = Driver(network, robot, bridge, stick, 27, "--gantry")
    driver.await_log("in its stance")
    robot.type(f"height {SLACK}")
    driver.await_log("stands, and can be guided", 12.0)
    seen = wait(robot, 20.0)
    assert stands(seen)
    print(f"it walked {seen[-1]['x'] - seen[0]['x']:.3f} m")
    assert seen[-1]["x"] > seen[0]["x"] + 0.1
    code, out, _ = driver.outcome()
    assert code == 0 and "on its feet, as far as its sensors tell" in out


@in_real_time
def test_it_reaches_and_brakes_when_its_driver_is_killed(hanging, script):
    network, robot, bridge = hanging
    driver = Driver(network, robot, bridge, script((0, "left_hand", 0), (4, None, 1), (8, None, 0)), 60)
    before = wait(robot, 3.0)
    reaching = wait(robot, 6.0)
    assert stands(before + reaching)
    forward = reaching[-1]["hand"][0] - before[-1]["hand"][0]
    print(f"the hand went {forward:.3f} m forward")
    assert forward > 0.05
    driver.kill()
    bridge.await_log("driver lost")
    bridge.await_log("the motors brake")
    assert lies_limp(wait(robot, 0.2)[-1])


@pytest.mark.parametrize("how", ["mute", "freeze"])
@in_real_time
def test_a_pulled_cable_damps(hanging, script, how):
    network, robot, bridge = hanging
    driver = Driver(network, robot, bridge, script((0, "trunk", 0)), 60)
    assert stands(wait(robot, 2.0))
    robot.type(how)
    bridge.await_log("damped: nothing new from the robot for 100 ms", limit=3.0)
    code, _, err = driver.outcome()
    assert code == 1 and "the robot was damped: nothing new from the robot for 100 ms" in err
    assert lies_limp(wait(robot, 0.2)[-1]), "what can still be heard is told to brake"
    bridge.type("a")
    bridge.await_log("not done: nothing is heard from the robot")
    robot.type("speak" if how == "mute" else "thaw")
    time.sleep(0.2)
    bridge.type("a")
    bridge.await_log("armed")
    bridge.type("s")
    bridge.await_log("takes its stance")


@in_real_time
def test_a_bridge_that_ends_leaves_the_robot_braking(hanging, script):
    network, robot, bridge = hanging
    driver = Driver(network, robot, bridge, script((0, "trunk", 0)), 60)
    assert stands(wait(robot, 2.0))
    assert bridge.end(signal.SIGTERM) == 0
    code, _, err = driver.outcome()
    assert code == 1 and "the robot was damped: the bridge ends" in err
    assert lies_limp(robot.look())


def test_a_robot_that_is_switched_off_does_not_hang_the_bridge(hanging):
    _, robot, bridge = hanging
    robot.kill()
    bridge.await_log("damped: nothing new from the robot for 100 ms")
    assert bridge.end() == 0
