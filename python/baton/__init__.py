"""Guide a humanoid robot: one body part at a time, by verified motions (docs/python.md)."""

import pathlib

from . import _core
from ._core import (
    AnswerLate,
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
)

__all__ = [
    "AnswerLate",
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
)

_SHARE = pathlib.Path(__file__).parent / "share"
_core.use_share_dir(_SHARE)


def robots() -> dict[str, bool]:
    """The robots that `Robot` knows by name, and whether their model is there: `python -m baton.fetch_robots` gets it."""
    from .fetch_robots import is_there

    return {p.parent.name: is_there(p.parent) for p in sorted((_SHARE / "robots").glob("*/profile.toml"))}
