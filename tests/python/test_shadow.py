"""drive --shadow: beside another driver, by the measurements alone, and without any effect on the robot."""

import json
import signal
import subprocess
import sys

import pytest
from robots_end import BATON, ROOT, RobotsEnd

WALK = ROOT / "examples" / "02_walk_and_turn.jsonl"
STAND = '{"t": 0, "guide": "trunk"}\n'

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")


def robot(*more):
    return RobotsEnd(BATON, "robot", "--sim", "--world", "flat", "--listen", "127.0.0.1:0", *more)


def drive_command(on, script, *more):
    return [str(part) for part in (BATON, "drive", "--on", on, "--world", "flat", "--input", f"script:{script}", *more)]


def drive(on, script, *more):
    done = subprocess.run(drive_command(on, script, "--fast", *more), capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done


def shadowed(tmp_path, robot_options, script, seconds, *more):
    """A run of a driver with somebody in its shadow: what the shadow says and reports."""
    report = tmp_path / "shadow.json"
    with robot(*robot_options) as end:
        shadow = subprocess.Popen(
            drive_command(end.address, script, "--shadow", "--seconds", seconds - 0.1, "--report", report, *more),
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        end.await_log("an observer looks on")
        drive(end.address, script, "--seconds", seconds, "--trace", tmp_path / "driven.csv")
        said, log = shadow.communicate(timeout=60)
    assert shadow.returncode == 0, log
    return said, log, json.loads(report.read_text())


def standing(tmp_path):
    (tmp_path / "stand.jsonl").write_text(STAND)
    return tmp_path / "stand.jsonl"


@pytest.mark.parametrize("follows", [(), ("--targets",)])
def test_the_driven_run_is_the_same_bit_by_bit_and_an_exact_robot_is_in_order(follows, tmp_path):
    options = ("--plant", "model", *follows)
    with robot(*options) as end:
        drive(end.address, WALK, "--seconds", 6, "--trace", tmp_path / "alone.csv")
    said, log, report = shadowed(tmp_path, options, WALK, 6, "--record", tmp_path / "shadow.mcap")
    assert (tmp_path / "driven.csv").read_bytes() == (tmp_path / "alone.csv").read_bytes()
    assert report["findings"] == []
    assert "nothing disagrees" in said
    assert report["timing"]["lost"] == report["timing"]["repeated"] == 0
    assert report["timing"]["measurements"] >= 1180
    assert report["plans"]["outcomes"] == {"possible": len(report["plans"]["commands"])}
    assert "trunk: possible" in log
    replayed = subprocess.run([BATON, "replay", tmp_path / "shadow.mcap", "--verify"], capture_output=True, text=True)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


@pytest.mark.parametrize(
    "scenario, times, named",
    [
        ("mass", 1, ["weight by the sole forces"]),
        ("encoders", 3, ["right sole's pitch against the left", "right sole's roll against the left"]),
        ("mount", 2, ["IMU's roll against the soles", "IMU's pitch against the soles"]),
    ],
)
def test_what_is_wrong_is_named(scenario, times, named, tmp_path):
    options = ("--plant", "model", "--scenario", scenario, "--times", times, "--seed", 2)
    said, _, report = shadowed(tmp_path, options, standing(tmp_path), 3)
    found = {finding["what"]: finding["verdict"] for finding in report["findings"]}
    assert any(what in found for what in named), said
    assert all(verdict in said for verdict in found.values())


def test_a_robot_that_does_not_know_of_observers_is_left_as_it_is(tmp_path):
    with RobotsEnd(sys.executable, ROOT / "examples" / "06_robot.py", "0") as end:
        done = subprocess.run(drive_command(end.address, WALK, "--shadow", "--state", "torques"),
                              capture_output=True, text=True, timeout=60)  # fmt: skip
        assert done.returncode == 1
        assert "refused (protocol)" in done.stderr
        assert end.process.poll() is None  # and it waits for a driver as before
        assert drive(end.address, standing(tmp_path), "--state", "torques", "--headless", "--seconds", 0.1)


def test_a_robot_in_real_time_is_seen_from_its_first_driver_to_the_end(tmp_path):
    report = tmp_path / "shadow.json"
    with robot("--plant", "model", "--real-time") as end:
        shadow = subprocess.Popen(drive_command(end.address, WALK, "--shadow", "--report", report),
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip
        end.await_log("an observer looks on")
        drive(end.address, standing(tmp_path), "--headless", "--seconds", 2)
        shadow.send_signal(signal.SIGINT)
        said, log = shadow.communicate(timeout=60)
    assert shadow.returncode == 0, log
    assert json.loads(report.read_text())["still_s"] > 0.5, said


def test_options_that_have_no_meaning_are_refused(tmp_path):
    for options, why in [((), "--shadow needs --on"), (("--on", "tcp://127.0.0.1:9", "--fast"), "--fast with --shadow")]:
        done = subprocess.run([BATON, "drive", "--shadow", *options, "--seconds", "1"], capture_output=True, text=True)
        assert done.returncode == 2
        assert why in done.stderr
