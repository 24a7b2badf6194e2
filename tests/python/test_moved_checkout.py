"""A checkout that was moved or copied with what was built in it: `make` and scripts/setup notice, and make it anew."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture
def checkout(tmp_path):
    """Makefile and set-up, in a folder with a blank in its name, without anything to build."""
    folder = tmp_path / "my checkout"
    shutil.copytree(ROOT / "scripts", folder / "scripts")
    shutil.copy(ROOT / "Makefile", folder)
    return folder


def configure(folder, home, build="build/release"):
    (folder / build).mkdir(parents=True)
    (folder / build / "CMakeCache.txt").write_text(f"# cache\nCMAKE_HOME_DIRECTORY:INTERNAL={home}\n")
    (folder / build / "build.ninja").touch()


def commands(folder, target):
    done = subprocess.run(["make", "-n", target], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


def index(lines, word):
    return next((i for i, line in enumerate(lines) if word in line), None)


@pytest.mark.parametrize("target", ["run", "build", "test", "bench"])
def test_a_build_folder_of_another_place_is_made_anew_before_anything_is_built(checkout, tmp_path, target):
    configure(checkout, tmp_path / "where it was")
    lines = commands(checkout, target)
    removed, configured = index(lines, "rm -rf build/release"), index(lines, "cmake --preset release")
    assert removed is not None and removed < configured < index(lines, "cmake --build")


@pytest.mark.parametrize("target, preset", [("sanitize", "sanitize"), ("ci-clang", "clang")])
def test_those_of_other_presets_too(checkout, tmp_path, target, preset):
    configure(checkout, tmp_path, f"build/{preset}")
    lines = commands(checkout, target)
    assert index(lines, f"rm -rf build/{preset}") < index(lines, f"cmake --preset {preset}")


def test_a_build_folder_of_this_place_stays_by_whatever_name_it_goes(checkout, tmp_path):
    (tmp_path / "link").symlink_to(checkout)
    configure(checkout, tmp_path / "link")
    for folder in (checkout, tmp_path / "link"):
        lines = commands(folder, "build")
        assert index(lines, "rm -rf") is None and index(lines, "--preset") is None
        assert index(lines, "cmake --build") is not None


def test_without_a_build_folder_it_is_configured(checkout):
    lines = commands(checkout, "build")
    assert index(lines, "rm -rf") is None and index(lines, "cmake --preset release") is not None


def set_up(folder, tools):
    """Runs scripts/setup where there is no Python to make an environment with: it stops if it needs to."""
    environment = {"PATH": str(tools), "BATON_SKIP_PACKAGES": "1"}
    return subprocess.run(["bash", "scripts/setup"], cwd=folder, env=environment, capture_output=True, text=True,
                          timeout=60)  # fmt: skip


def test_the_environment_is_made_anew_in_another_place(checkout, tmp_path):
    tools = tmp_path / "tools"
    tools.mkdir()
    for tool in ("bash", "dirname", "mkdir", "flock", "cat", "cksum"):
        (tools / tool).symlink_to(shutil.which(tool))
    (checkout / ".venv" / "bin").mkdir(parents=True)
    (checkout / ".venv" / "bin" / "python").symlink_to(sys.executable)
    lists = b"".join((checkout / "scripts" / name).read_bytes()
                     for name in ("requirements.txt", "requirements-no-deps.txt"))  # fmt: skip
    checksum = subprocess.run(["cksum"], input=lists, capture_output=True).stdout.decode().strip()
    (checkout / ".venv" / "baton.stamp").write_text(f"{checksum} {os.path.realpath(checkout)}\n")
    here = set_up(checkout, tools)
    assert here.returncode == 0, here.stderr
    moved = checkout.rename(tmp_path / "elsewhere")
    there = set_up(moved, tools)
    assert there.returncode == 2 and "Python 3.11 or newer" in there.stderr


def test_an_environment_that_is_a_link_is_not_emptied(checkout, tmp_path):
    shared = tmp_path / "shared environment"
    shared.mkdir()
    (shared / "kept").touch()
    (checkout / ".venv").symlink_to(shared)
    done = subprocess.run(["bash", "scripts/setup"], cwd=checkout, env=os.environ | {"BATON_SKIP_PACKAGES": "1"},
                          capture_output=True, text=True, timeout=60)  # fmt: skip
    assert done.returncode == 2 and ".venv is a symbolic link" in done.stderr
    assert (shared / "kept").exists()
