"""The two ends of a connection as processes of their own, and a robot's end that is not ours (examples/06_robot.py)."""

import csv
import json
import shutil
import signal
import subprocess
import sys

import link_faults
import pytest
from mcap.reader import make_reader
from robots_end import BATON, ROOT, RobotsEnd

WALK = ROOT / "examples" / "02_walk_and_turn.jsonl"

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")


def simulated(*more):
    return RobotsEnd(BATON, "robot", "--sim", "--world", "flat", "--seed", "2", "--listen", "127.0.0.1:0", *more)


def drive_command(on, seconds, *more):
    return [str(BATON), "drive", "--on", on, "--world", "flat", "--headless", "--input", f"script:{WALK}",
            "--seconds", str(seconds), *map(str, more)]  # fmt: skip


def drive(on, seconds, *more):
    return subprocess.run(drive_command(on, seconds, "--fast", *more), capture_output=True, text=True, timeout=120)


def test_two_processes_give_the_run_of_one(tmp_path):
    with simulated() as end:
        there = drive(end.address, 4, "--trace", tmp_path / "there.csv")
    inside = drive("sim", 4, "--seed", 2, "--trace", tmp_path / "inside.csv")
    assert there.returncode == inside.returncode == 0, there.stderr + inside.stderr
    assert (tmp_path / "there.csv").read_bytes() == (tmp_path / "inside.csv").read_bytes()


def test_arms_are_driven_over_the_connection_as_inside(tmp_path):
    arms = tmp_path / "arms.jsonl"
    with arms.open("w") as file:
        for k in range(30):
            q = [[0.6 + 0.04 * (k % 10), 0.1]]
            chunk = {"t": 0.1 * k, "joints": ["left_elbow_flexion", "right_shoulder_flexion"], "at": [1 + 0.1 * k], "q": q}
            file.write(json.dumps(chunk) + "\n")
    driven = ("--arms", f"script:{arms}")
    inside = drive("sim", 4, "--seed", 2, "--trace", tmp_path / "inside.csv", *driven)
    for mode in [(), ("--targets",)]:
        with simulated(*mode) as end:
            there = drive(end.address, 4, "--trace", tmp_path / "there.csv", *driven)
        assert there.returncode == inside.returncode == 0, there.stderr + inside.stderr
        assert (tmp_path / "there.csv").read_bytes() == (tmp_path / "inside.csv").read_bytes()
    without = drive("sim", 4, "--seed", 2, "--trace", tmp_path / "without.csv")
    assert without.returncode == 0 and (tmp_path / "without.csv").read_bytes() != (tmp_path / "inside.csv").read_bytes()


def test_a_driver_that_is_killed_leaves_the_robot_to_the_next(tmp_path):
    with simulated() as end:
        victim = subprocess.Popen(drive_command(end.address, 60), stderr=subprocess.PIPE)
        end.await_log("a driver has taken over")
        victim.send_signal(signal.SIGKILL)
        victim.communicate()
        end.await_log("driver lost")
        assert drive(end.address, 1).returncode == 0


def test_a_robot_that_is_killed_ends_the_run_with_its_files_written(tmp_path):
    report, trace = tmp_path / "report.json", tmp_path / "trace.csv"
    with simulated() as end:
        driver = subprocess.Popen(
            drive_command(end.address, 60, "--report", report, "--trace", trace), stderr=subprocess.PIPE, text=True
        )
        while not trace.exists() or trace.stat().st_size < 20_000:  # until it drives
            assert driver.poll() is None
        end.process.kill()
        _, log = driver.communicate(timeout=30)
    assert driver.returncode == 1
    assert end.address in log
    assert end.address in json.loads(report.read_text())["link"]["broken"]
    assert len(trace.read_text().splitlines()) > 1


def test_damp_is_latched_whoever_asks_for_it():
    with simulated() as end:
        driver = subprocess.Popen(drive_command(end.address, 60), stderr=subprocess.PIPE, text=True)
        end.await_log("a driver has taken over")
        end.type("d")
        _, log = driver.communicate(timeout=30)
        assert driver.returncode == 1
        assert "the robot was damped: by the robot's own key" in log
        assert "refused (damped)" in drive(end.address, 1).stderr
        end.type("a")
        end.await_log("armed")
        assert drive(end.address, 1).returncode == 0

        assert subprocess.run([BATON, "damp", end.address], capture_output=True).returncode == 0
        assert "refused (damped)" in drive(end.address, 1).stderr
        end.process.send_signal(signal.SIGINT)
        assert end.process.wait(timeout=10) == 0


@pytest.mark.parametrize("mode", [(), ("--real-time",)])
def test_a_robot_that_hangs_takes_its_stance_is_lowered_and_walks(mode, tmp_path):
    recording, report = tmp_path / "run.mcap", tmp_path / "report.json"
    stick = tmp_path / "stick.jsonl"
    stick.write_text('{"t": 0, "guide": "trunk"}\n{"t": 6, "axes": [1, 0, 0, 0, 0, 0]}\n')
    with simulated("--targets", "--gantry", *mode) as end:
        command = [BATON, "drive", "--on", end.address, "--gantry", "--world", "flat", "--headless", "--seconds", "14",
                   "--input", f"script:{stick}", "--record", recording, "--report", report]  # fmt: skip
        driver = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        said = []
        for line in driver.stderr:
            said.append(line.strip().removeprefix("info: "))
            if line.startswith("info: in its stance"):
                end.type("l")
        assert driver.wait(timeout=30) == 0, said
        assert said == ["hangs: takes its stance", "in its stance: lower it until it stands, then slacken the ropes",
                        "lifted, or its soles carry nothing by its sensors: no motion begins before it stands",
                        "stands, and can be guided"]  # fmt: skip
        told = json.loads(report.read_text())
        assert told["falls"] == 0 and told["commands"]["moved"] > 0 and told["travel_m"] > 0.05
        replayed = subprocess.run([BATON, "replay", recording, "--verify"], capture_output=True, text=True)
        assert replayed.returncode == 0, replayed.stdout + replayed.stderr
        lowered = drive(end.address, 1, "--gantry")  # it hangs again, as for each driver
        assert lowered.returncode == 0, lowered.stderr


def test_a_robot_whose_feet_carry_it_does_not_hang():
    with simulated("--targets") as end:
        refused = drive(end.address, 1, "--gantry")
        assert refused.returncode == 2
        assert "--gantry: the soles carry" in refused.stderr and "must hang" in refused.stderr
    shadow = ["drive", "--gantry", "--shadow", "--on", "tcp://127.0.0.1:1"]
    for command in (["drive", "--gantry", "--headless"], ["robot", "--sim", "--gantry"], shadow):
        wrong = subprocess.run([BATON, *command], capture_output=True, text=True, timeout=60)
        assert wrong.returncode == 2 and "--gantry" in wrong.stderr


@pytest.mark.parametrize("end_it", [signal.SIGKILL, signal.SIGSTOP])
def test_a_robot_whose_driver_is_killed_or_stopped_in_a_step_comes_to_rest(end_it, tmp_path):
    trace = tmp_path / "trace.csv"
    with simulated("--real-time") as end:
        driver = subprocess.Popen(drive_command(end.address, 60, "--trace", trace), stderr=subprocess.PIPE, text=True)
        while not trace.exists() or ",single_" not in trace.read_text():  # a foot is in the air
            assert driver.poll() is None
        driver.send_signal(end_it)
        if end_it == signal.SIGKILL:
            end.await_log("driver lost")
            end.await_log("at rest, without a driver")
        else:
            end.await_log("comes to rest")
            driver.send_signal(signal.SIGCONT)
            end.await_log("the stick counts again")
            assert any("it rests" in line for line in driver.stderr)
        driver.kill()
        driver.communicate()
        end.process.send_signal(signal.SIGINT)
        _, rest = end.process.communicate(timeout=20)
        assert "fallen" not in rest


def test_a_robot_that_takes_targets_alone_is_driven_the_same(tmp_path):
    with simulated("--targets") as end:
        there = drive(end.address, 4, "--trace", tmp_path / "there.csv", "--report", tmp_path / "there.json")
    inside = drive("sim", 4, "--seed", 2, "--trace", tmp_path / "inside.csv")
    assert there.returncode == inside.returncode == 0, there.stderr + inside.stderr
    assert (tmp_path / "there.csv").read_bytes() == (tmp_path / "inside.csv").read_bytes()
    assert json.loads((tmp_path / "there.json").read_text())["link"]["navigates"] is False


def test_a_bare_robot_keeps_its_balance_by_a_robots_end_in_between(tmp_path):
    token = tmp_path / "token"
    token.write_text("sesame\n")
    with simulated("--targets", "--real-time", "--token", token) as bare:
        between = (BATON, "robot", "--on", bare.address, "--world", "flat", "--listen", "127.0.0.1:0")
        with pytest.raises(AssertionError, match="a token is needed"):
            RobotsEnd(*between)
        with RobotsEnd(*between, "--on-token", token) as end:
            driver = subprocess.Popen(drive_command(end.address, 60, "--trace", tmp_path / "t.csv"))
            while not (tmp_path / "t.csv").exists() or ",single_" not in (tmp_path / "t.csv").read_text():
                assert driver.poll() is None
            driver.kill()
            end.await_log("at rest, without a driver")
            driver.wait()
            done = drive(end.address, 1, "--report", tmp_path / "report.json")  # it goes on from where it stands
            assert done.returncode == 0, done.stderr
            assert json.loads((tmp_path / "report.json").read_text())["falls"] == 0
            assert subprocess.run([BATON, "damp", end.address], capture_output=True).returncode == 0
            bare.await_log("damped: asked for by the driver")
            end.type("a")
            end.await_log("not armed: arm the robot at its own end")
            bare.process.kill()
            assert end.process.wait(timeout=20) == 1
            assert bare.address in end.process.stderr.read()


def test_a_robots_end_takes_only_a_bare_robot_in_real_time():
    for options, why in [((), "navigates by itself"), (("--targets",), "waits for its targets")]:
        with simulated(*options) as other:
            done = subprocess.run([BATON, "robot", "--on", other.address, "--world", "flat"],
                                  capture_output=True, text=True, timeout=60)  # fmt: skip
            assert done.returncode == 2
            assert why in done.stderr


def test_a_second_driver_is_refused():
    with simulated() as end:
        first = subprocess.Popen(drive_command(end.address, 60), stderr=subprocess.PIPE)
        end.await_log("a driver has taken over")
        assert "refused (busy)" in drive(end.address, 1).stderr
        first.send_signal(signal.SIGINT)  # comes to rest, and hands the robot back
        first.communicate(timeout=60)
        assert first.returncode == 0
        end.await_log("handed the robot back")


def test_only_this_machine_without_a_token(tmp_path):
    done = subprocess.run(
        [BATON, "robot", "--sim", "--listen", "0.0.0.0:0"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2
    assert "needs a token" in done.stderr
    token = tmp_path / "token"
    token.write_text("sesame\n")
    with simulated("--token", token) as end:
        assert "refused (token)" in drive(end.address, 1).stderr
        assert drive(end.address, 1, "--token", token).returncode == 0


@pytest.mark.parametrize("closed", ["<&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_descriptors_are_not_taken_by_connections(closed, tmp_path):
    """Else the robot's end would log into a connection, or take what it says for keys."""
    with simulated() as other:  # a port that is free now
        port = other.address.rsplit(":", 1)[1]
    command = f"exec {BATON} robot --sim --world flat --listen 127.0.0.1:{port} {closed}"
    process = subprocess.Popen(["bash", "-c", command], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        for _ in range(200):
            done = drive(f"tcp://127.0.0.1:{port}", 1)
            if "Connection refused" not in done.stderr:
                break
        assert done.returncode == 0, done.stderr
        assert process.poll() is None
    finally:
        process.kill()
        process.wait()


def test_a_log_that_nobody_reads_any_more_ends_nothing():
    with simulated() as end:
        end.process.stderr.close()
        assert drive(end.address, 1).returncode == 0
        assert drive(end.address, 1).returncode == 0
        assert end.process.poll() is None


def test_a_robot_that_stands_otherwise_takes_its_stance_first(tmp_path):
    example = (ROOT / "examples" / "06_robot.py").read_text()
    moved = example.replace('"shoulder_flexion": -0.349', '"shoulder_flexion": 0.2')
    assert moved != example
    (tmp_path / "robot.py").write_text(moved)
    trace = tmp_path / "trace.csv"
    with RobotsEnd(sys.executable, tmp_path / "robot.py", "0") as end:
        done = drive(end.address, 6, "--state", "torques", "--trace", trace, "--record", tmp_path / "r.mcap")
    assert done.returncode == 0, done.stderr
    again = subprocess.run([BATON, "replay", tmp_path / "r.mcap", "--verify"], capture_output=True, text=True)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "takes its stance first" in done.stderr and "in its stance" in done.stderr
    with trace.open() as file:
        shoulder = [float(row["target_left_shoulder_flexion"]) for row in csv.DictReader(file)]
    assert shoulder[0] == pytest.approx(0.2)
    assert shoulder[-1] == pytest.approx(-0.349, abs=0.01)
    assert max(abs(b - a) for a, b in zip(shoulder, shoulder[1:])) < 0.03  # no jump


def test_a_robot_in_python_is_driven_by_its_torques(tmp_path):
    report = tmp_path / "report.json"
    example = (sys.executable, ROOT / "examples" / "06_robot.py", "0")
    with RobotsEnd(*example) as end:
        done = drive(end.address, 1)
        assert done.returncode == 2
        assert "measures no forces on its soles: must be --state torques" in done.stderr
    with RobotsEnd(*example) as end:
        done = drive(end.address, 12, "--state", "torques", "--report", report)
        assert done.returncode == 0, done.stderr
        said, _ = end.process.communicate(timeout=10)
    assert "driven for 2400 ticks" in said
    result = json.loads(report.read_text())
    assert result["on"] == "real"
    assert result["segments"]["committed"] > 20
    assert result["segments"]["refused"] == {} and result["sensors"] == {}
    assert result["link"]["battery"] == 0.9
    assert result["final"] is None  # as it has no truth


def test_the_driver_is_warned_of_a_low_battery(tmp_path):
    weak = tmp_path / "weak.py"
    weak.write_text((ROOT / "examples" / "06_robot.py").read_text().replace("BATTERY = 0.9", "BATTERY = 0.12"))
    with RobotsEnd(sys.executable, weak, "0") as end:
        done = drive(end.address, 1, "--state", "torques")
    assert done.returncode == 0 and done.stderr.count("the robot's battery is at 12 %") == 1, done.stderr


@pytest.mark.parametrize("kind", ["cut", "fills"])
def test_a_cut_connection_or_a_full_disk_leaves_nothing_broken(kind, tmp_path):
    fault, wrong = link_faults.run(link_faults.FAULTS.index(kind), tmp_path, "mighty")
    assert fault.kind == kind and not wrong


def notes_of(recording):
    """What happened on the link, by the recording: tick, what, text."""
    with open(recording, "rb") as stream:
        found = make_reader(stream, validate_crcs=True).iter_messages(topics=["/baton/link"])
        return [(m.sequence, *(json.loads(m.data)[key] for key in ("what", "text"))) for _, _, m in found]


@pytest.mark.parametrize("mode", [(), ("--targets",)])
def test_a_fault_that_the_robot_reports_brings_it_to_rest_and_is_on_record(mode, tmp_path):
    record, report, trace = tmp_path / "run.mcap", tmp_path / "r.json", tmp_path / "t.csv"
    with simulated(*mode) as end:
        files = ("--record", record, "--report", report, "--trace", trace)
        driver = subprocess.Popen(drive_command(end.address, 8, *files), stderr=subprocess.PIPE, text=True)
        end.await_log("a driver has taken over")
        while not trace.exists() or trace.stat().st_size < 300_000:  # until it walks
            assert driver.poll() is None
        end.type("f left knee: too hot")
        end.await_log("fault: left knee: too hot: comes to rest")
        _, log = driver.communicate(timeout=60)
        # Whoever drives next is told, too.
        second = drive(end.address, 1)
        end.type("f")
        end.await_log("fault over")
        third = drive(end.address, 1)
    assert driver.returncode == 0, log
    assert "the robot reports a fault: left knee: too hot: it rests" in log
    assert second.returncode == 0 and "left knee: too hot" in second.stderr
    assert third.returncode == 0 and "fault" not in third.stderr
    ((tick, what, text),) = notes_of(record)
    assert what == "fault" and "left knee: too hot" in text
    (note,) = json.loads(report.read_text())["link"]["notes"]
    assert note["what"] == "fault" and abs(note["t"] - 0.005 * tick) < 0.011
    rows = list(csv.DictReader(trace.open()))
    moving = [row["segment"] != "-1" and row["phase"] != "hold" for row in rows]
    assert any(moving[:tick]) and not any(moving[-100:])
    assert "1 link: fault" in subprocess.run([BATON, "info", record], capture_output=True, text=True).stdout


def test_the_robots_end_records_each_run_whatever_becomes_of_its_driver(tmp_path):
    folder = tmp_path / "black box"
    with simulated("--real-time", "--record", folder) as end:
        victim = subprocess.Popen(drive_command(end.address, 60), stderr=subprocess.PIPE)
        end.await_log(f"recording to {folder}/001.mcap")
        while (folder / "001.mcap").stat().st_size < 200_000:  # until it walks
            assert victim.poll() is None
        victim.send_signal(signal.SIGKILL)
        victim.communicate()
        end.await_log("at rest, without a driver")
        assert drive(end.address, 1).returncode == 0
        end.await_log("at rest, without a driver")
        end.process.send_signal(signal.SIGINT)
        assert end.process.wait(timeout=30) == 0
    assert sorted(file.name for file in folder.iterdir()) == ["001.mcap", "002.mcap"]
    for file in folder.iterdir():
        again = subprocess.run([BATON, "replay", file, "--verify"], capture_output=True, text=True)
        assert again.returncode == 0 and "identical bit for bit" in again.stdout, again.stdout + again.stderr
        assert "not finished" not in again.stdout
    texts = [text for _, _, text in notes_of(folder / "001.mcap")]
    assert any("driver lost" in text for text in texts) and texts[-1] == "at rest, without a driver"
    # It goes on counting, and what cannot be written is said and ends nothing.
    with simulated("--record", folder) as end:
        assert drive(end.address, 1).returncode == 0
        end.await_log("driver has handed the robot back")
        assert (folder / "003.mcap").exists()
        shutil.rmtree(folder)
        assert drive(end.address, 1).returncode == 0
        end.await_log("this run is not recorded")
    done = subprocess.run([BATON, "robot", "--sim", "--targets", "--record", folder], capture_output=True, text=True)
    assert done.returncode == 2 and "--record with --targets" in done.stderr
