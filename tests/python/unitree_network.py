"""What the tests of `baton bridge unitree` share: a network, and programs on it.

The program is build/release/baton, or the one that the environment variable BATON names.
"""

import contextlib
import os
import pathlib
import re
import select
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))
WIRE = BATON.with_name("baton_unitree_wire")

# Robot and bridge live in real time: before all else that this computer does, where that is allowed.
FIRST = ["chrt", "-f", "10"]
if subprocess.run([*FIRST, "true"], capture_output=True).returncode != 0:
    FIRST = []
SOON = ["nice", "-n", "-15"]  # a driver, which plans, too; where it is not allowed, nice says so and goes on


class Network:
    """A network namespace that holds nothing but a loopback with multicast, as DDS needs it."""

    def __init__(self):
        script = "ip link set lo up multicast on && echo up && exec cat"
        self.holder = subprocess.Popen(
            ["unshare", "-rn", "sh", "-c", script],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        if self.holder.stdout.readline() != "up\n":
            pytest.skip("no network namespace can be made here: " + self.holder.stderr.read().strip())
        self.prefix = ["nsenter", "-t", str(self.holder.pid), "-U", "--preserve-credentials", "-n"]

    def start(self, *command, first=FIRST):
        return subprocess.Popen(
            [*first, *self.prefix, *map(str, command)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1,
        )  # fmt: skip

    def run(self, *command, timeout=60):
        return subprocess.run([*self.prefix, *map(str, command)], capture_output=True, text=True, timeout=timeout)

    def close(self):
        self.holder.kill()
        self.holder.communicate()


class Program:
    """A running program: what is typed, what it says."""

    def __init__(self, network, *command, first=FIRST):
        self.process = network.start(*command, first=first)
        self.log = ""
        self.rest = {self.process.stdout: "", self.process.stderr: ""}  # that was read and is no whole line

    def type(self, line):
        self.process.stdin.write(line + "\n")

    def await_line(self, stream, text, limit=20.0):
        """Reads a stream up to a line that contains this."""
        until = time.monotonic() + limit
        while True:
            *lines, self.rest[stream] = self.rest[stream].split("\n")
            for at, line in enumerate(lines):
                self.log += line + "\n"
                if text in line:
                    self.rest[stream] = "\n".join([*lines[at + 1 :], self.rest[stream]])
                    return line
            if time.monotonic() > until:
                break
            if select.select([stream], [], [], 0.1)[0]:
                if not (some := os.read(stream.fileno(), 4096)):
                    break
                self.rest[stream] += some.decode()
        raise AssertionError(f"{text!r} was not said, but:\n{self.log}")

    def await_log(self, text, limit=20.0):
        return self.await_line(self.process.stderr, text, limit)

    def end(self, how=signal.SIGINT):
        self.process.send_signal(how)
        _, rest = self.process.communicate(timeout=10)
        self.log += rest
        return self.process.returncode

    def kill(self):
        self.process.kill()
        self.process.communicate()


class Bridge(Program):
    def __init__(self, network, *options):
        super().__init__(network, BATON, "bridge", "unitree", "--interface", "lo", "--listen", "127.0.0.1:0", *options)

    def await_ready(self):
        line = self.await_line(self.process.stdout, "tcp://")
        self.address = re.search(r"tcp://[\d.]+:\d+", line)[0]


@contextlib.contextmanager
def started(kind, network, *options):
    program = kind(network, *options)
    try:
        yield program
    finally:
        program.kill()


@contextlib.contextmanager
def network_with_g1():
    """The network, once the G1's model is there."""
    for program in (BATON, WIRE):
        if not program.is_file():
            pytest.skip(f"no program at {program}: make build, or set BATON")
    subprocess.run([ROOT / "scripts" / "fetch_robots", "g1"], check=True)
    network = Network()
    try:
        yield network
    finally:
        network.close()
