"""What a run is asked for: the keywords that `run`, `System.run`, `System.check` and `sweep` share."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from typing import Any, Callable, TypedDict

from hdrm_fmu.names import by_name, unknown


class Asked(TypedDict, total=False):
    """Keywords of a run; each may be left out."""

    #: Start values by name.
    settings: Mapping[str, object] | None
    #: Names or patterns (`*`: any text, an array by its name) of the signals that are kept.
    signals: str | Iterable[str] | None
    #: Time between two recorded points, s, a multiple of the communication step; default: every step.
    interval: float | None
    #: s; default: the end of the motion, else of the system's default experiment.
    stop_time: float | None
    #: Largest tip error with which the verdict is good, m.
    max_error: float | None
    #: Further metrics, of `tracking` and `energy`.
    metrics: Iterable[str]


def complete(given: Asked, function: Callable[..., object]) -> dict[str, Any]:
    """`given` keywords of a function with all that are left out; others are refused with the nearest names."""
    for name in given.keys() - Asked.__annotations__.keys():
        raise unknown("keyword", name, [*inspect.signature(function).parameters, *Asked.__annotations__])
    asked: dict[str, Any] = {**dict.fromkeys(Asked.__annotations__), "metrics": (), **given}
    asked["settings"] = by_name(asked["settings"])
    return asked
