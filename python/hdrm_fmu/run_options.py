"""The keywords that `run`, `System.run`, `System.check` and `sweep` share: start values, signals, stop time, metrics."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from typing import Any, Callable, TypedDict

from hdrm_fmu.names import by_name, unknown


class RunOptions(TypedDict, total=False):
    """Keywords of a run; each may be left out."""

    #: Start values by name.
    settings: Mapping[str, object] | None
    #: Names or patterns (`*`: any text, an array by its name) of the signals that are recorded.
    signals: str | Iterable[str] | None
    #: Time between two recorded points, s, a multiple of the communication step; default: every step.
    interval: float | None
    #: s; default: the end of the motion, else of the system's default experiment.
    stop_time: float | None
    #: Largest tip error with which the verdict is good, m.
    max_error: float | None
    #: Further metrics, of `tracking` and `energy`.
    metrics: Iterable[str]


def complete(given: RunOptions, function: Callable[..., object]) -> dict[str, Any]:
    """The keywords that `function` was given, completed by the defaults; an unknown keyword is refused with the nearest names."""
    for name in given.keys() - RunOptions.__annotations__.keys():
        raise unknown("keyword", name, [*inspect.signature(function).parameters, *RunOptions.__annotations__])
    options: dict[str, Any] = {**dict.fromkeys(RunOptions.__annotations__), "metrics": (), **given}
    options["settings"] = by_name(options["settings"])
    return options
