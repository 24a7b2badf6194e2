"""The examples do what they say: scripts 01 to 04 on the ideal robot, 05 as a project of its own against an install."""

import json
import math
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
BATON = BUILD / "baton"

pytestmark = pytest.mark.skipif(not BATON.exists(), reason=f"{BATON} is not built")


def run(*args):
    done = subprocess.run([str(a) for a in args], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def drive(name, seconds, folder):
    """The report of a script on the ideal robot."""
    report = folder / "report.json"
    run(BATON, "drive", "--headless", "--fast", "--on", "ideal", "--world", "flat", "--seconds", seconds,
        "--input", f"script:{ROOT / 'examples' / name}", "--report", report)  # fmt: skip
    result = json.loads(report.read_text())
    assert result["falls"] == 0 and result["segments"]["refused"] == {}
    assert result["commands"]["moved"] == result["commands"]["given"] > 0
    return result


def kinds(name):
    """What the script becomes: the kinds of its segments."""
    plan = json.loads(run(BATON, "plan", ROOT / "examples" / name))
    return [segment["kind"] for segment in plan["segments"]]


def test_one_step_with_each_foot(tmp_path):
    final = drive("01_step.jsonl", 6, tmp_path)["final"]
    assert final["left_foot"]["p"][0] == pytest.approx(0.05, abs=1e-3)
    assert final["right_foot"]["p"][0] == pytest.approx(0.05, abs=1e-3)
    assert final["com"][0] == pytest.approx(0.05, abs=1e-3)
    assert kinds("01_step.jsonl") == ["step", "step"]


def test_the_feet_follow_the_trunk(tmp_path):
    final = drive("02_walk_and_turn.jsonl", 18, tmp_path)["final"]
    assert final["com"][0] > 0.3
    assert final["trunk"]["rpy"][2] > math.radians(45)
    middle = [(a + b) / 2 for a, b in zip(final["left_foot"]["p"], final["right_foot"]["p"])]
    assert math.dist(middle[:2], final["com"][:2]) < 0.03


def test_standing_on_one_foot(tmp_path):
    assert kinds("03_one_foot_standing.jsonl") == ["lift", "air", "lower"]
    up = drive("03_one_foot_standing.jsonl", 5, tmp_path)["final"]
    assert up["left_foot"]["p"][2] == pytest.approx(0.03, abs=1e-3)
    assert math.dist(up["com"][:2], up["right_foot"]["p"][:2]) < 1e-3
    down = drive("03_one_foot_standing.jsonl", 8, tmp_path)["final"]
    assert down["left_foot"]["p"] == pytest.approx([0.05, 0.042, 0.0], abs=1e-3)


def test_the_body_follows_the_hand(tmp_path):
    final = drive("04_reach.jsonl", 6, tmp_path)["final"]
    assert final["left_hand"]["p"][0] > 0.2
    assert final["com"][0] > 0.02
    assert "step" in kinds("04_reach.jsonl")


def test_the_library_in_a_project_of_its_own(tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("no cmake")
    run("cmake", "--install", BUILD, "--prefix", tmp_path / "baton")
    run("cmake", "-S", ROOT / "examples" / "05_embed", "-B", tmp_path / "build",
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'baton'}", "-DCMAKE_BUILD_TYPE=Debug")  # fmt: skip
    run("cmake", "--build", tmp_path / "build")
    assert "segments" in run(tmp_path / "build" / "embed")
