"""rcssservermj (make rcss), `baton bridge rcss` and `baton drive` as processes, for tests."""

import json
import pathlib
import socket
import subprocess
import tempfile
import time

from robots_end import BATON, ROOT, Ended, RobotsEnd

SERVER = ROOT / "build" / "rcss" / "bin" / "rcssservermj"


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


class Bridge(RobotsEnd):
    """`baton bridge rcss` at `address`."""

    def __init__(self, server, robot="rcss_k1"):
        super().__init__(BATON, "bridge", "rcss", "--server", server, "--robot", robot, "--listen", "127.0.0.1:0")


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
