"""`baton bridge unitree` against whoever may be on the robot's network, by bytes that this test makes up: a robot whose
states it writes itself, its motion switcher, and others who do not belong there (tests/bridge/unitree_wire.cpp says
what it is told to). The checksum here shares nothing with the bridge's.
"""

import json
import math
import signal
import struct
import subprocess
import threading
import time
import zlib

import pytest
from unitree_network import BATON, FIRST, WIRE, Bridge, network_with_g1, started

PERIOD = 0.002  # of states [s]
L1_A = 1 << 1 | 1 << 8
L2_B = 1 << 5 | 1 << 9
NOTHING_ELSE = 0.8  # time after which what would have come has come [s]

REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def crc(words):
    """CRC-32/MPEG-2 over words from their highest byte on, by way of the reflected CRC-32 of zlib."""
    highest_first = struct.pack(f">{len(words) // 4}I", *struct.unpack(f"<{len(words) // 4}I", words))
    return int(f"{zlib.crc32(highest_first.translate(REVERSED)) ^ 0xFFFFFFFF:032b}"[::-1], 2)


def sealed(message):
    return message + struct.pack("<I", crc(message))


def state(tick, *, machine=5, buttons=0, q=0.0, quaternion=(1, 0, 0, 0)):
    head = struct.pack("<2I2B2xI", 1, 2, 0, machine, tick)
    imu = struct.pack("<13fh2x", *quaternion, 0.01, 0.02, 0.03, 0.1, 0.2, 9.8, 0, 0, 0, 30)
    motor = struct.pack("<B3x4f2hf7I", 1, q, 0.0, 0.0, 1.0, 30, 31, 48.0, *[0] * 7)
    remote = struct.pack("<2BH36x", 0x55, 0x51, buttons)
    return sealed(head + imu + 35 * motor + remote + bytes(16))


def command(kp=0.0):
    return sealed(struct.pack("<2B2x", 0, 5) + 35 * struct.pack("<B3x5fI", 1, 0, 0, 0, kp, 0, 0) + bytes(16))


class Wire:
    """Somebody on the network: by default a robot, which publishes states and has a motion switcher."""

    def __init__(self, network, *options, robot=True, gait="", releases=True):
        self.process = subprocess.Popen(
            [*FIRST, *network.prefix, str(WIRE), *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self.lock = threading.Lock()
        self.gait, self.releases = gait, releases
        self.asked, self.commands = [], []  # APIs; (time, bytes)
        self.changes, self.speaks, self.running = {}, robot, True
        self.tick = 0
        self.threads = [threading.Thread(target=self._listen), threading.Thread(target=self._speak)]
        for thread in self.threads:
            thread.start()

    def send(self, kind, data):
        with self.lock:
            self.process.stdin.write(kind + data)
            self.process.stdin.flush()

    def answer(self, request, code, text):
        text = text.encode()
        self.send(b"A", struct.pack("<qiI", request, code, len(text)) + text)

    def _listen(self):
        while kind := self.process.stdout.read(1):
            if kind == b"c":
                self.commands.append((time.monotonic(), self.process.stdout.read(1004)))
                continue
            request, api = struct.unpack("<2q", self.process.stdout.read(16))
            self.asked.append(api)
            if self.gait is None:
                continue  # deaf
            if api == 1003 and self.releases:
                self.gait = ""
            self.answer(request, 0, json.dumps({"form": "0", "name": self.gait}) if api == 1001 else "")

    def _speak(self):
        due = time.monotonic()
        while self.running:
            due = max(due + PERIOD, time.monotonic() - 5 * PERIOD)
            time.sleep(max(0.0, due - time.monotonic()))
            if self.speaks:
                self.tick += 2
                self.send(b"S", state(self.tick, **self.changes))

    def heard(self, since=0.0):
        """Commands since then, taken apart: (mode_pr, mode_machine, motors as (mode, q, dq, tau, kp, kd))."""
        for t, data in list(self.commands):
            if t > since:
                assert struct.unpack("<I", data[-4:])[0] == crc(data[:-4])
                motors = [struct.unpack_from("<B3x5f", data, 4 + 28 * i) for i in range(35)]
                yield data[0], data[1], motors

    def await_motors(self, as_wanted, limit=10.0):
        """Waits until the newest command's motors are as wanted."""
        until = time.monotonic() + limit
        while not (self.commands and as_wanted(list(self.heard(self.commands[-1][0] - PERIOD))[-1][2])):
            assert time.monotonic() < until, "the commands do not become what they should"
            time.sleep(PERIOD)

    def kill(self):
        self.running = False
        self.threads[1].join()
        self.process.kill()
        self.threads[0].join()
        self.process.communicate()


@pytest.fixture
def network():
    with network_with_g1() as network:
        yield network


@pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")
@pytest.mark.parametrize(
    ("options", "why"),
    [
        ([], "baton: bridge: must be followed by what it leads to: rcss or unitree"),
        (["unitree", "--interface", "nope0"], "--interface nope0: this computer has no such network interface"),
        (["unitree", "--interface", "a'/><b"], "--interface a'/><b: this computer has no such network interface"),
        (["unitree", "--robot", "mighty"], "--robot mighty: a G1 has no joint 'left_shoulder_flexion'"),
        (["unitree", "--listen", "0.0.0.0:0"], "can be reached by others: needs a token"),
        (["unitree", "--token", "/nowhere"], "/nowhere"),
        (["unitree", "--sim"], "--sim"),
    ],
)
def test_bad_input_is_named(options, why):
    done = subprocess.run([BATON, "bridge", *options], capture_output=True, text=True)
    assert done.returncode == 2 and why in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")
def test_a_missing_bridge_is_named(tmp_path):
    alone = tmp_path / "baton"
    alone.write_bytes(BATON.read_bytes())
    alone.chmod(0o755)
    done = subprocess.run([alone, "bridge", "unitree"], capture_output=True, text=True)
    assert done.returncode == 1 and f"{tmp_path}/baton-bridge-unitree: No such file" in done.stderr
    assert "scripts/setup" in done.stderr


def refusal_of(bridge):
    """Why a bridge has ended by itself."""
    _, err = bridge.process.communicate(timeout=30)
    assert bridge.process.returncode == 1
    return err


def braking(motors):
    return all(kp == tau == dq == 0.0 and mode == 1 and kd > 0 for mode, _, dq, tau, kp, kd in motors[:29])


def holding(motors):
    return not braking(motors)


@pytest.fixture
def served(network):
    with started(Wire, network) as robot, started(Bridge, network) as bridge:
        bridge.await_ready()
        yield network, robot, bridge


def ignored(bridge):
    assert bridge.end() == 0
    return bridge.log


def test_each_state_is_answered_by_a_command_that_the_robot_accepts(served):
    _, robot, bridge = served
    since = time.monotonic()
    tick = robot.tick
    time.sleep(2.0)
    heard = list(robot.heard(since))
    assert all(pr == 0 and machine == 5 and braking(motors) for pr, machine, motors in heard)
    print(f"{len(heard)} commands to {(robot.tick - tick) // 2} states in 2 s")
    assert 0.9 * (robot.tick - tick) / 2 < len(heard) < 1.2 * 1000
    assert all(motor == (0, 0, 0, 0, 0, 0) for _, _, motors in heard for motor in motors[29:])
    assert bridge.end() == 0


@pytest.mark.parametrize("buttons", [L1_A, L2_B])
def test_the_remote_damps_whoever_drives_until_somebody_arms(served, buttons):
    network, robot, bridge = served
    bridge.type("s")
    bridge.await_log("takes its stance")
    robot.changes = {"buttons": buttons}
    bridge.await_log("damped: by the remote")
    bridge.type("a")
    bridge.await_log("not done: the remote still damps")
    robot.changes = {}
    time.sleep(0.2)
    since = time.monotonic()
    drive = [BATON, "drive", "--robot", "g1", "--on", bridge.address, "--state", "torques", "--world", "flat",
             "--headless", "--seconds", "1"]  # fmt: skip
    refused = network.run(*drive)
    assert refused.returncode == 1 and "refused (damped): by the remote" in refused.stderr
    assert all(braking(motors) for _, _, motors in robot.heard(since))
    bridge.type("a")
    bridge.await_log("armed")
    bridge.type("s")
    bridge.await_log("takes its stance")
    robot.await_motors(holding)
    damp = network.run(BATON, "damp", bridge.address)
    assert damp.returncode == 0
    bridge.await_log("damped: asked for over the network")
    robot.await_motors(braking)


def test_who_only_observes_says_nothing_and_leaves_the_factory_gait(network, tmp_path):
    report = tmp_path / "shadow.json"
    with (
        started(lambda n: Wire(n, gait="ai"), network) as robot,
        started(lambda n: Bridge(n, "--observe"), network) as bridge,
    ):
        bridge.await_ready()
        driver = [BATON, "drive", "--robot", "g1", "--on", bridge.address, "--state", "torques", "--world", "flat"]
        for other in ([*driver, "--headless", "--seconds", "1"], [BATON, "damp", bridge.address]):
            refused = network.run(*other)
            assert refused.returncode == 1 and "somebody else controls this robot" in refused.stderr
        done = network.run(*driver, "--shadow", "--input", "auto", "--seconds", "2", "--report", report)
        assert done.returncode == 0, done.stderr
        timing = json.loads(report.read_text())["timing"]
        assert timing["measurements"] >= 390 and timing["lost"] == 0
        assert bridge.end() == 0
        assert robot.commands == [] and robot.asked == []


def test_a_factory_gait_is_released_first(network):
    with started(lambda n: Wire(n, gait="ai"), network) as robot, started(Bridge, network) as bridge:
        bridge.await_log("ends the factory gait 'ai'")
        bridge.await_ready()
        assert robot.asked == [1001, 1003, 1001]


@pytest.mark.parametrize(
    ("gait", "why"),
    [
        ("ai", "the factory gait 'ai' is still active after it was told 5 times to end"),
        (None, "the motion switcher does not answer, so whether the factory gait is active is not known"),
    ],
)
def test_nothing_is_commanded_while_the_factory_gait_may_be_active(network, gait, why):
    with (
        started(lambda n: Wire(n, gait=gait, releases=False), network) as robot,
        started(Bridge, network) as bridge,
    ):
        assert why in refusal_of(bridge)
        assert robot.commands == []


def test_nobody_there(network):
    with started(Bridge, network) as bridge:
        assert "no state of a robot on rt/lowstate (lo) for 5 s" in refusal_of(bridge)


def test_a_g1_without_all_joints_is_refused(network):
    with started(Wire, network) as robot:
        robot.changes = {"machine": 4}
        with started(Bridge, network) as bridge:
            assert "this G1 has 23 joints (mode_machine 4): must be 29" in refusal_of(bridge)


def test_states_that_cannot_be_the_robots_are_ignored_and_counted(served):
    _, robot, bridge = served
    good = state(1)
    for _ in range(10):
        robot.send(b"S", good[:-4] + b"\1\2\3\4")
        robot.send(b"S", good[:100] + bytes([good[100] ^ 1]) + good[101:])
        robot.send(b"S", state(3, q=math.nan))
        robot.send(b"S", state(3, q=1e9))
        robot.send(b"S", state(3, quaternion=(0, 0, 0, 0)))
        robot.send(b"S", state(3, machine=6))
        time.sleep(0.01)
    time.sleep(NOTHING_ELSE)
    log = ignored(bridge)
    for what in ("20 × a state: wrong checksum", "20 × a state: impossible reading of a motor",
                 "10 × a state: impossible reading of the IMU", "10 × a state: another mode_machine"):  # fmt: skip
        assert what in log
    assert log.count("wrong checksum") == 2, "once when it was first seen, once counted"
    assert "damped: nothing new" not in log
    assert all(pr == 0 and machine == 5 and all(abs(q) < 1 for _, q, *_ in motors)
               for pr, machine, motors in robot.heard())  # fmt: skip


def test_nothing_but_such_states_damps(served):
    _, robot, bridge = served
    robot.changes = {"q": math.nan}
    bridge.await_log("damped: nothing new from the robot for 100 ms")
    since = time.monotonic()
    time.sleep(1.0)
    heard = list(robot.heard(since))
    assert len(heard) > 300 and all(braking(motors) for *_, motors in heard), "it is still told to brake"


def test_a_second_publisher_of_states_and_one_of_another_type_are_ignored(served):
    network, robot, bridge = served
    with started(lambda n: Wire(n, "--wrong-type", robot=False), network) as stranger:
        time.sleep(NOTHING_ELSE)
        stranger.send(b"S", command())
        bridge.await_log("ignored: a publisher of rt/lowstate whose type is not unitree_hg::msg::dds_::LowState_")
    with started(Wire, network) as second:
        second.changes = {"buttons": L1_A, "q": 0.5}
        bridge.await_log("ignored: a second publisher of rt/lowstate")
        time.sleep(NOTHING_ELSE)
    log = ignored(bridge)
    assert "by the remote" not in log
    assert all(q == 0.0 for *_, motors in robot.heard() for _, q, *_ in motors[:29])


def test_a_robot_that_comes_back_is_heard_again(served):
    network, robot, bridge = served
    robot.kill()
    bridge.await_log("damped: nothing new")
    with started(Wire, network):
        for _ in range(20):  # DDS takes 10 s to find out that the first one is gone
            time.sleep(1.0)
            bridge.type("a")
            if "armed" in bridge.await_line(bridge.process.stderr, ""):
                break
        else:
            raise AssertionError(bridge.log)


def test_somebody_else_who_commands_the_motors(network):
    with started(Wire, network) as robot, started(lambda n: Wire(n, robot=False), network) as other:
        stop = threading.Event()

        def meddle():
            while not stop.wait(0.01):
                other.send(b"C", command(kp=1.0))

        thread = threading.Thread(target=meddle)
        thread.start()
        try:
            with started(Bridge, network) as bridge:
                assert "somebody else commands the motors on rt/lowcmd" in refusal_of(bridge)
        finally:
            stop.set()
            thread.join()
        time.sleep(NOTHING_ELSE)
        with started(Bridge, network) as bridge:
            bridge.await_ready()
            bridge.type("s")
            bridge.await_log("takes its stance")
            other.send(b"C", command(kp=1.0))
            bridge.await_log("damped: somebody else commands the motors")
            assert "1 × a command of somebody else on rt/lowcmd" in ignored(bridge)
        assert robot.commands


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_it_ends_with_the_motors_braking(served, how):
    _, robot, bridge = served
    bridge.type("s")
    bridge.await_log("takes its stance")
    robot.await_motors(holding)
    asked = time.monotonic()
    assert bridge.end(how) == 0
    robot.await_motors(braking)
    last = [braking(motors) for *_, motors in robot.heard(asked)]
    first = last.index(True)  # how soon it hears the signal is the computer's matter, to some extent
    assert first < 500 and len(last) - first > 100 and all(last[first:]), "once it brakes, it brakes to the end"
