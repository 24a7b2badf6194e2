"""Programs that are the robot's end of a connection, as processes, for tests.

The program is build/release/baton, or the one that the environment variable BATON names.
"""

import os
import pathlib
import re
import subprocess
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))


class Ended:
    """A process that ends with the block."""

    process: subprocess.Popen

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


class RobotsEnd(Ended):
    """`baton robot`, or another program that says where it listens, at `address`."""

    def __init__(self, *command):
        self.process = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        first = self.process.stdout.readline()
        port = re.search(r"(?:port |:)(\d+)(?:;|\s*$)", first)
        assert port, first + self.process.stderr.read()
        self.address = f"tcp://127.0.0.1:{port[1]}"

    def type(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def await_log(self, text, limit=60.0):
        """Reads its log up to a line that contains this. A process that does not say it in time [s] is killed."""
        timer = threading.Timer(limit, self.process.kill)
        timer.start()
        try:
            for line in self.process.stderr:
                if text in line:
                    return
        finally:
            timer.cancel()
        raise AssertionError(f"{text!r} was not logged")
