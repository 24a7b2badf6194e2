"""A foreign simulator: Booster's K1 and T1 in rcssservermj by `baton bridge rcss`, as docs/rcss.md says.

Needs `make rcss`, which `make test` and `make test-python` do.
"""

import contextlib
import re
import signal
import socket
import struct
import subprocess
import threading
import xml.etree.ElementTree

import pytest
import rcss
from rcss import BATON, ROOT, SERVER, Bridge, Simulator, drive, drive_command

pytestmark = [
    pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON"),
    pytest.mark.skipif(not SERVER.is_file(), reason="no simulator: make rcss"),
]

REST = {"t": 0, "guide": "trunk"}


@pytest.fixture(scope="module")
def simulator():
    with Simulator() as one:
        yield one


@pytest.fixture(scope="module")
def bridge(simulator):
    with Bridge(simulator.address) as one:
        yield one


def held(guide, axis, seconds, to=1):
    axes = [to if i == axis else 0 for i in range(6)]
    return [{"t": 0, "guide": guide}, {"t": 0.5, "axes": axes}, {"t": 0.5 + seconds}]


def test_it_stands(bridge):
    done, report = drive(bridge.address, [REST], 10)
    assert done.returncode == 0, done.stderr
    assert report["falls"] == 0
    assert report["tracking"]["com_rms_m"] < 0.003  # measured: 0.0002
    assert report["tilt_deg_max"] < 1.5  # 0.3


@pytest.mark.parametrize(
    "lines",
    [
        held("trunk", 1, 1.5),  # shift
        held("trunk", 2, 2.0, to=-1),  # squat
        held("left_hand", 0, 1.3),
        held("right_hand", 2, 1.3),
        [{"t": 0, "guide": "left_foot"}, {"t": 0.5, "lift": [1, 0]}, {"t": 5, "lift": [0, 0]}],
        held("right_foot", 0, 1.5),
    ],
    ids=["shift", "squat", "reach forward", "reach up", "lift a foot", "step"],
)
def test_it_moves_what_is_guided(bridge, lines):
    done, report = drive(bridge.address, lines, 9)
    assert done.returncode == 0, done.stderr
    assert report["falls"] == 0
    assert report["commands"]["moved"] == report["commands"]["given"] == 1
    assert report["tracking"]["com_rms_m"] < 0.010  # 0.004


def test_the_hand_that_is_guided_is_the_one_that_moves(bridge):
    """By the simulator's own joints: left and right, order and sign are its model's."""
    at = {}
    for part in ("trunk", "left_hand", "right_hand"):
        _, report = drive(bridge.address, held(part, 2, 1.3) if part != "trunk" else [REST], 4)
        at[part] = {hand: report["final"][hand]["p"][2] for hand in ("left_hand", "right_hand")}
    for hand, other in (("left_hand", "right_hand"), ("right_hand", "left_hand")):
        assert at[hand][hand] > at["trunk"][hand] + 0.02
        assert abs(at[hand][other] - at["trunk"][other]) < 0.02


def test_it_walks_backward_as_the_simulator_sees_it(bridge):
    done, report = drive(bridge.address, held("trunk", 0, 20, to=-1), 23)
    assert done.returncode == 0, done.stderr
    assert report["falls"] == 0
    assert report["final"]["trunk"]["p"][0] < -0.3  # truth of the simulator; measured: -1.2
    assert abs(report["final"]["trunk"]["p"][1]) < 0.3


def test_t1_stands_and_reaches():
    with Simulator() as simulator, Bridge(simulator.address, "rcss_t1") as bridge:
        done, report = drive(bridge.address, held("left_hand", 0, 2), 6, "rcss_t1")
        assert done.returncode == 0, done.stderr
        assert report["falls"] == 0 and report["commands"] == {"given": 1, "moved": 1}


def test_without_the_late_cycle():
    """--sequential: a command acts at once. The bridge finds that out by itself."""
    with Simulator("--sequential") as simulator, Bridge(simulator.address) as bridge:
        done, report = drive(bridge.address, held("left_foot", 0, 1.5), 6)
        assert done.returncode == 0, done.stderr
        assert report["falls"] == 0 and report["commands"] == {"given": 1, "moved": 1}


def test_a_driver_that_is_killed_leaves_the_robot_to_the_next(bridge, tmp_path):
    script = tmp_path / "rest.jsonl"
    script.write_text('{"t": 0, "guide": "trunk"}\n')
    trace = tmp_path / "trace.csv"
    victim = subprocess.Popen(drive_command(bridge.address, script, 100000, "rcss_k1", "--trace", trace))
    while not trace.exists() or trace.stat().st_size < 20_000:  # until it drives
        assert victim.poll() is None
    victim.send_signal(signal.SIGKILL)
    victim.wait()
    done, report = drive(bridge.address, [REST], 2)
    assert done.returncode == 0, done.stderr
    assert report["falls"] == 0


def test_a_simulator_that_is_killed_ends_both_with_a_line(tmp_path):
    script = tmp_path / "rest.jsonl"
    script.write_text('{"t": 0, "guide": "trunk"}\n')
    trace = tmp_path / "trace.csv"
    with Simulator() as simulator, Bridge(simulator.address) as bridge:
        driver = subprocess.Popen(
            drive_command(bridge.address, script, 100000, "rcss_k1", "--trace", trace), stderr=subprocess.PIPE, text=True
        )
        while not trace.exists() or trace.stat().st_size < 20_000:
            assert driver.poll() is None
        simulator.process.kill()
        _, log = driver.communicate(timeout=60)
        assert driver.returncode == 1
        assert bridge.process.wait(timeout=60) == 1
        said = bridge.process.stderr.read()
    assert re.search(r"^baton: simulator tcp://\S+: the other end ", said, re.MULTILINE), said
    assert bridge.address in log


def run_bridge(*more):
    return subprocess.run(
        [str(part) for part in (BATON, "bridge", "rcss", "--listen", "127.0.0.1:0", *more)],
        capture_output=True,
        text=True,
        timeout=120,
    )


@contextlib.contextmanager
def answering(answer):
    """A server that answers each message with these bytes."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            with contextlib.suppress(OSError):
                connection, _ = server.accept()
                with connection:
                    while connection.recv(65536):
                        connection.sendall(answer)

        thread = threading.Thread(target=serve)
        thread.start()
        yield f"127.0.0.1:{server.getsockname()[1]}"
        thread.join(timeout=10)


def framed(text):
    return struct.pack(">I", len(text)) + text.encode()


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "a message of 1213486160 bytes"),
        (framed("(syn)"), "no (time ...)"),
        (framed("(time (now 1.0)"), "a bracket is not closed"),
        (b"\0\0\0\0", "a message of 0 bytes"),
        (framed("(time (now 1.00))(GS (pm PlayOn))(GYR (rt 0 0 0))(ACC (a 0 0 9))(quat (q 1 0 0 0))(pos (p 0 0 0))"),
         "no joint 'q_hj1'"),
    ],
    ids=["http", "syn", "cut", "empty", "no joints"],
)  # fmt: skip
def test_what_is_no_simulator_is_told_so(answer, says):
    with answering(answer) as address:
        done = run_bridge("--server", address)
    assert done.returncode == 1
    assert done.stderr.startswith(f"baton: simulator tcp://{address}: not understood: {says}"), done.stderr
    assert done.stderr.count("\n") == 1


def test_where_nobody_is(simulator):
    done = run_bridge("--server", "127.0.0.1:1")
    assert done.returncode == 1
    assert done.stderr == "baton: no simulator: tcp://127.0.0.1:1: Connection refused\n"
    assert run_bridge("--server", "nowhere").returncode == 2
    done = run_bridge("--server", simulator.address, "--robot", "mighty")
    assert done.returncode == 2
    assert "must be the simulator's own model" in done.stderr


def test_a_second_bridge_is_refused_by_the_simulator(simulator, bridge):
    done = run_bridge("--server", simulator.address)
    assert done.returncode == 1
    assert "somebody plays as player 1 of team baton" in done.stderr
    assert drive(bridge.address, [REST], 1)[0].returncode == 0  # the first does not notice


@pytest.mark.parametrize("robot", ["rcss_k1", "rcss_t1"])
def test_the_models_are_those_of_the_installed_simulator(robot):
    """Else the names of the joints, masses and ranges could be those of another version."""
    model = ROOT / "robots" / robot / "model" / "robot.xml"
    [installed] = (ROOT / "build" / "rcss").glob(f"lib/python*/site-packages/rcsssmj/resources/robots/{robot[-2:].upper()}/robot.xml")  # fmt: skip
    assert model.read_text() == installed.read_text()
    assert xml.etree.ElementTree.parse(model).getroot().get("model") == robot[-2:].upper()
