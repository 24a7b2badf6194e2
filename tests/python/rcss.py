"""rcssservermj (make rcss), `baton bridge rcss` and `baton drive` as processes, for tests."""

import json
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))
SERVER = ROOT / "build" / "rcss" / "bin" / "rcssservermj"


class Ended:
    """A process that ends with the block."""

    process: subprocess.Popen

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def _free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Simulator(Ended):
    """The simulator, waiting for robots at `address`.

    mode: --sync: a command acts a cycle late; --sequential: at once
    """

    def __init__(self, mode="--sync"):
        self.folder = tempfile.TemporaryDirectory()  # it writes its log where it is started
        port, monitors = _free_ports(2)
        self.address = f"127.0.0.1:{port}"
        command = [SERVER, mode, "--no-realtime", "--no-render", "--aport", port, "--mport", monitors]
        self.process = subprocess.Popen(
            [str(part) for part in command], cwd=self.folder.name, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        for _ in range(1200):  # tries; it takes a second to start
            assert self.process.poll() is None, f"{SERVER} does not start"
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                return
            except OSError:
                time.sleep(0.05)
        raise AssertionError(f"{SERVER} does not listen")

    def __exit__(self, *args):
        super().__exit__(*args)
        self.folder.cleanup()


class Bridge(Ended):
    """`baton bridge rcss` at `address`."""

    def __init__(self, server, robot="rcss_k1"):
        command = [BATON, "bridge", "rcss", "--server", server, "--robot", robot, "--listen", "127.0.0.1:0"]
        self.process = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        first = self.process.stdout.readline()
        found = re.search(r"at (tcp://\S+);", first)
        assert found, first + self.process.stderr.read()
        self.address = found[1]

    def await_log(self, text):
        """Reads its log up to a line that contains this."""
        for line in self.process.stderr:
            if text in line:
                return
        raise AssertionError(f"{text!r} was not logged")


def drive_command(on, script, seconds, robot="rcss_k1", *more):
    return [str(part) for part in (BATON, "drive", "--robot", robot, "--world", "flat", "--on", on, "--state", "torques",
            "--headless", "--fast", "--input", f"script:{script}", "--seconds", seconds, *more)]  # fmt: skip


def drive(on, lines, seconds, robot="rcss_k1", *more):
    """Drives by a script, a list of dicts. Returns the process and its report."""
    with tempfile.TemporaryDirectory() as folder:
        script = pathlib.Path(folder) / "script.jsonl"
        script.write_text("".join(json.dumps(line) + "\n" for line in lines))
        report = pathlib.Path(folder) / "report.json"
        done = subprocess.run(
            drive_command(on, script, seconds, robot, "--report", report, *more),
            capture_output=True,
            text=True,
            timeout=300,
        )
        return done, json.loads(report.read_text()) if report.exists() else None
