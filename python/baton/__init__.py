"""Guide a humanoid robot: one body part at a time, by verified motions (docs/python.md)."""

import ctypes
import importlib.metadata
import pathlib
import sys

# The libraries of two other packages that _core is linked with, wherever those are.
for _pattern in ("mujoco/libmujoco.so.*", "cmeel.prefix/lib/libeiquadprog.so"):
    for _library in [file for folder in sys.path for file in pathlib.Path(folder).glob(_pattern)][:1]:
        ctypes.CDLL(str(_library))

from . import _core  # noqa: E402
from ._core import (  # noqa: E402
    AnswerLate,
    ArmsRefused,
    Command,
    Committed,
    DisturbedChanged,
    Ended,
    GuardChanged,
    HeatChanged,
    InputError,
    Joint,
    JointTarget,
    Measurement,
    Refusal,
    Refused,
    Robot,
    Run,
    SensorChanged,
    Slipped,
    Truth,
    scenarios,
)

__version__ = importlib.metadata.version("baton")
__all__ = [
    "AnswerLate",
    "ArmsRefused",
    "Command",
    "Committed",
    "DisturbedChanged",
    "Ended",
    "Event",
    "GuardChanged",
    "HeatChanged",
    "InputError",
    "Joint",
    "JointTarget",
    "Measurement",
    "Refusal",
    "Refused",
    "Robot",
    "Run",
    "SensorChanged",
    "Slipped",
    "Truth",
    "robots",
    "scenarios",
]

#: What happens in a run.
Event = (
    Committed
    | Ended
    | Refused
    | AnswerLate
    | Slipped
    | DisturbedChanged
    | GuardChanged
    | SensorChanged
    | HeatChanged
    | ArmsRefused
)

_core.use_share_dir(pathlib.Path(__file__).parent / "share")


def robots() -> dict[str, bool]:
    """The robots that `Robot` knows by name, and whether their model is there: `python -m baton.fetch_robots` gets it."""
    from .fetch_robots import is_there

    return {p.parent.name: is_there(p.parent) for p in sorted((pathlib.Path(_core.share_dir()) / "robots").glob("*/profile.toml"))}
