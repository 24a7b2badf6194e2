"""Drives simulated robots in real time over a connection with faults: real processes, with a proxy in between that delays,
stalls, cuts and garbles what passes; drivers that are killed, stopped, or whose disk is full at once or after a while.
Nothing of it may make a robot fall or a program hang, each recording opens, and one of the ends names what was cut, killed,
full, or stalled or stopped for 0.7 s or more. A function of the seed but for what the computer's speed does.

    python tests/python/link_faults.py --runs 50 --seed 1
"""

import argparse
import dataclasses
import json
import pathlib
import random
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

from robots_end import BATON, RobotsEnd

FAULTS = ["none", "delay", "stall", "cut", "garble", "kill", "stop", "disk", "fills", "robot"]
SECONDS = 8.0  # that a driver drives, if nothing ends it
LASTS = 0.5  # time without a fresh stick from which the robot's end says so [s]
FILLS = 200_000  # bytes that a disk takes before it is full


@dataclasses.dataclass
class Fault:
    """What goes wrong, and when after the connection [s]."""

    kind: str
    at: float
    lasts: float


class Proxy:
    """Passes bytes on between one driver and a robot's end, with one fault."""

    def __init__(self, to, fault, rng):
        self.to, self.fault, self.rng = to, fault, rng
        self.begun = 0.0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        driver, _ = self.listener.accept()
        robot = socket.create_connection(self.to)
        self.begun = time.monotonic()
        for source, sink in ((driver, robot), (robot, driver)):
            threading.Thread(target=self.carry, args=(source, sink), daemon=True).start()

    def carry(self, source, sink):
        try:
            while data := source.recv(4096):
                t = time.monotonic() - self.begun
                if self.fault.at < t < self.fault.at + self.fault.lasts:
                    if self.fault.kind == "delay":
                        time.sleep(self.rng.uniform(0.0, 0.5))
                    elif self.fault.kind == "stall":
                        time.sleep(max(0.0, self.fault.at + self.fault.lasts - t))
                    elif self.fault.kind == "cut":
                        break
                    elif self.fault.kind == "garble" and self.rng.random() < 0.05:
                        place = self.rng.randrange(len(data))
                        data = data[:place] + bytes([self.rng.randrange(256)]) + data[place + 1 :]
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


def script_of(rng):
    """A stick that changes every second or so."""
    lines, t = [], 0.3
    while t < SECONDS:
        part = rng.choice(["trunk", "trunk", "left_foot", "right_foot", "left_hand", "right_hand"])
        axes = [round(rng.uniform(-1, 1), 2) if rng.random() < 0.4 else 0 for _ in range(6)]
        lines.append(json.dumps({"t": round(t, 2), "guide": part, "axes": axes, "lift": [rng.choice([0, 0, 0.5]), 0]}))
        t += rng.uniform(0.3, 1.5)
    return "\n".join(lines) + "\n"


def run(seed, folder, robot):
    """One robot, one fault, and a driver after it. Returns the fault and all that went wrong."""
    rng = random.Random(seed)
    fault = Fault(FAULTS[seed % len(FAULTS)], rng.uniform(1.5, SECONDS - 3.0), rng.uniform(0.2, 2.5))
    wrong = []
    script, recording = folder / "stick.jsonl", folder / "run.mcap"
    script.write_text(script_of(rng))
    end = RobotsEnd(BATON, "robot", "--sim", "--robot", robot, "--world", "flat", "--real-time", "--listen", "127.0.0.1:0",
                    "--seed", str(seed))  # fmt: skip
    with end:
        port = int(end.address.rsplit(":", 1)[1])
        proxy = Proxy(("127.0.0.1", port), fault, rng)
        file = pathlib.Path("/dev/full") if fault.kind == "disk" else recording
        command = [BATON, "drive", "--robot", robot, "--world", "flat", "--headless", "--input", f"script:{script}",
                   "--seconds", str(SECONDS), "--record", file, "--on"]  # fmt: skip

        def limit_files():
            if fault.kind == "fills":
                resource.setrlimit(resource.RLIMIT_FSIZE, (FILLS, FILLS))

        # With SIGXFSZ ignored, as Python leaves it, a write beyond the limit fails as on a full disk.
        driver = subprocess.Popen([*command, proxy.address], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  preexec_fn=limit_files, restore_signals=False)  # fmt: skip
        if fault.kind in ("kill", "stop", "robot"):
            while not proxy.begun and driver.poll() is None:
                time.sleep(0.01)
            time.sleep(fault.at)
            if fault.kind == "robot":
                end.process.kill()
            else:
                driver.send_signal(signal.SIGKILL if fault.kind == "kill" else signal.SIGSTOP)
            if fault.kind == "stop":
                time.sleep(fault.lasts)
                driver.send_signal(signal.SIGCONT)
        try:
            log, _ = driver.communicate(timeout=SECONDS + 40)
        except subprocess.TimeoutExpired:
            driver.kill()
            log, _ = driver.communicate()
            wrong.append("the driver hangs")
        expected = {"stall": (0, 1), "stop": (0, 1), "garble": (0, 1), "cut": (1,), "robot": (1,), "kill": (-9,)}
        if driver.returncode not in expected.get(fault.kind, (0,)):
            wrong.append(f"the driver ended with {driver.returncode}: {log[-300:]}")
        if driver.returncode == 1 and "tcp://" not in log:
            wrong.append(f"the driver does not say what was wrong: {log[-300:]}")
        if fault.kind in ("disk", "fills") and "not complete" not in log:
            wrong.append("the full disk is not named")
        if fault.kind != "disk":
            info = subprocess.run([BATON, "info", recording], capture_output=True, text=True)
            if info.returncode != 0:
                wrong.append(f"the recording does not open: {info.stderr[-200:]}")
        said = ""
        if fault.kind != "robot":
            end.process.send_signal(signal.SIGINT)
            try:
                _, said = end.process.communicate(timeout=40)
            except subprocess.TimeoutExpired:
                wrong.append("the robot's end hangs")
            if "fallen" in said or end.process.returncode not in (0, None):
                wrong.append(f"the robot's end: {end.process.returncode}: {said[-300:]}")
        if fault.kind in ("stall", "stop") and fault.lasts > LASTS + 0.2 and "link: " not in log + said:
            wrong.append("neither end says that the stick was too old")
        if fault.kind == "kill" and "driver lost" not in said:
            wrong.append("the robot's end does not say that its driver is gone")
    return fault, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=len(FAULTS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--robot", default="mighty")
    options = parser.parse_args()
    bad = 0
    for seed in range(options.seed, options.seed + options.runs):
        with tempfile.TemporaryDirectory() as folder:
            fault, wrong = run(seed, pathlib.Path(folder), options.robot)
        bad += bool(wrong)
        print(f"{seed}: {fault.kind} at {fault.at:.1f} s: {'; '.join(wrong) or 'as it should be'}", flush=True)
    print(f"{options.runs} runs, {bad} of them not as they should be")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
