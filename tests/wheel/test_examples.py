"""The examples of examples/python do what they say; a run by Python is the program's."""

import csv
import json
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import baton

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))


def example(name, *args):
    done = subprocess.run([sys.executable, ROOT / "examples" / "python" / name, *args], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_what_the_documentation_shows():
    text = (ROOT / "docs" / "python.md").read_text()
    code = re.search(r"```python\n(.*?)```", text, re.S)[1]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    first, *_, last = done.stdout.splitlines()
    assert f"# {first}, …" in text and last.endswith("True False"), done.stdout + done.stderr


def test_arms():
    out = example("04_arms.py")
    way, off = re.search(r"(\S+) m away, the arms within (\S+) rad of their targets \(median\), on its feet", out).groups()
    assert float(way) > 0.3 and float(off) < 0.05


def test_guide():
    out = example("01_guide.py")
    ahead, higher = re.search(r"(\S+) m ahead, the hand (\S+) cm higher, on its feet", out).groups()
    assert float(ahead) > 0.2 and float(higher) >= 3
    assert "left_foot step" in out and "trunk step" in out and "left_hand reach" in out


def test_collect(tmp_path):
    file = tmp_path / "data.npz"
    out = example("02_collect.py", "--out", file, "--episodes", "2", "--seconds", "4")
    assert " 0 falls" in out
    data = np.load(file)
    assert data["t"].shape == (1600,) and set(data["episode"]) == {0, 1}
    assert data["q"].shape == data["target"].shape == (1600, len(data["joints"]))
    assert all(np.isfinite(data[name]).all() for name in ("q", "dq", "attitude", "rate", "soles", "target"))
    assert np.ptp(data["q"], axis=0).max() > 0.1  # it moved


def test_own_simulator():
    out = example("03_own_simulator.py")
    ahead, beside = re.search(r"(\S+) m ahead; then (\S+) mm beside the start, on its feet", out).groups()
    assert float(ahead) > 0.3 and float(beside) < 30


@pytest.mark.skipif(not PROGRAM.is_file(), reason=f"no program at {PROGRAM}: make build, or set BATON")
@pytest.mark.parametrize("options", [{"plant": "real"}, {"plant": "model", "scenario": "push", "times": 0.5}, {"gait": "stop", "state": "torques"}])
def test_the_same_run_as_the_program(tmp_path, options):
    script = tmp_path / "script.jsonl"
    stick = [(0.0, "trunk", [1, 0, 0, 0, 0, 0]), (2.0, "left_hand", [0, 1, 0.5, 0, 0, 0]), (3.0, "trunk", [0, 0, 0, 0, 0, 0])]
    script.write_text("".join(json.dumps({"t": t, "guide": part, "axes": axes}) + "\n" for t, part, axes in stick))
    trace = tmp_path / "trace.csv"
    flags = [text for key, value in options.items() for text in (f"--{key}", str(value))]
    subprocess.run([PROGRAM, "drive", "--headless", "--fast", "--seconds", "4", "--world", "flat", "--seed", "6", "--input",
                    f"script:{script}", "--trace", trace, *flags], check=True, capture_output=True)  # fmt: skip
    with trace.open() as file:
        rows = list(csv.DictReader(file))
    run = baton.Run(baton.Robot("mighty"), "flat", seed=6, **options)
    assert len(rows) == 800
    for row in rows:
        assert [row[f"qpos_{i}"] for i in range(27)] == [f"{q:.10g}" for q in run.truth.q]
        newest = [(part, axes) for t, part, axes in stick if t <= run.t + 1e-9][-1]
        run.step(baton.Command(*newest))
        assert run.phase == row["phase"]
    assert any(row["phase"] == "single_left" for row in rows)
