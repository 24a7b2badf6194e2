"""Robots that are not in this repository: their models are fetched from PyPI, and stand and reach without an edit.

The program is build/release/baton, or the one that the environment variable BATON names.
"""

import csv
import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))

pytestmark = pytest.mark.skipif(not BATON.is_file(), reason=f"no program at {BATON}: make build, or set BATON")


def run(*args):
    return subprocess.run([str(BATON), *map(str, args)], capture_output=True, text=True)


@pytest.fixture(scope="module")
def jvrc1():
    """The smallest of the packages; its URDF has Collada meshes, mimic joints and neither armature nor IMU."""
    subprocess.run([ROOT / "scripts" / "fetch_robots", "jvrc1"], check=True)
    return "jvrc1"


def test_a_fetched_robot_is_listed(jvrc1):
    out = run("robots").stdout
    assert "mighty" in out
    [line] = [line for line in out.splitlines() if line.startswith("jvrc1")]
    assert line.endswith("jvrc1.urdf")


def test_fetching_again_leaves_it_alone(jvrc1):
    again = subprocess.run([ROOT / "scripts" / "fetch_robots", "jvrc1"], capture_output=True, text=True)
    assert again.returncode == 0 and "already there" in again.stderr
    unknown = subprocess.run([ROOT / "scripts" / "fetch_robots", "nobody"], capture_output=True, text=True)
    assert unknown.returncode == 2 and "jvrc1" in unknown.stderr


def test_a_robot_of_the_web_shifts_and_reaches_in_physics(jvrc1, tmp_path):
    script = tmp_path / "script.jsonl"
    lines = [{"t": 0, "guide": "trunk"}, {"t": 0.5, "axes": [0, 1, 0, 0, 0, 0]}, {"t": 2.5}]
    lines += [{"t": 5, "guide": "left_hand", "axes": [1, 0, 0, 0, 0, 0]}, {"t": 7, "guide": "left_hand"}]
    script.write_text("".join(json.dumps(line) + "\n" for line in lines))
    report = tmp_path / "report.json"
    done = run("drive", "--robot", jvrc1, "--world", "flat", "--fast", "--seconds", 10, "--seed", 1, "--input", f"script:{script}", "--report", report)
    assert done.returncode == 0, done.stderr
    result = json.loads(report.read_text())
    assert result["falls"] == 0
    assert result["commands"] == {"given": 2, "moved": 2}


def test_it_walks_though_its_knees_are_weak(jvrc1, tmp_path):
    """At 0.92 of its height with straight legs, one knee alone would need 0.98 of its stall torque."""
    script, trace, report = tmp_path / "script.jsonl", tmp_path / "trace.csv", tmp_path / "report.json"
    lines = [{"t": 0.5, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}, {"t": 12.5, "guide": "trunk"}]
    script.write_text("".join(json.dumps(line) + "\n" for line in lines))
    done = run("drive", "--robot", jvrc1, "--world", "flat", "--fast", "--seconds", 16, "--seed", 1, "--input", f"script:{script}", "--report", report, "--trace", trace)
    assert done.returncode == 0, done.stderr
    assert json.loads(report.read_text())["commands"] == {"given": 1, "moved": 1}
    with trace.open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["qpos_0"]) - float(rows[0]["qpos_0"]) > 0.5
    steps = {row["segment"] for row in rows if row["phase"].startswith("single")}
    assert len(steps) > 5


def test_who_is_not_fetched_is_told_how_to():
    missing = [name for name in ("g1", "t1", "talos") if not (ROOT / "robots" / name / "model").exists()]
    for name in missing:
        result = run("drive", "--robot", name, "--fast", "--seconds", 1)
        assert result.returncode == 2
        assert "make robots" in result.stderr and name in result.stderr
    if not missing:
        pytest.skip("all robots are fetched")
