"""The keywords that `run`, `System.run`, `System.check` and `sweep` share: start values, signals, stop time, metrics."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from typing import Any, Callable, TypedDict, TypeVar

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


F = TypeVar("F", bound=Callable[..., object])


def explicit(function: F) -> F:
    """Has `help` and editors show the keywords of a run one by one, in place of `**options`."""
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    defaults = {**dict.fromkeys(RunOptions.__annotations__), "metrics": ()}
    hints = RunOptions.__annotations__
    text = lambda hint: getattr(hint, "__forward_arg__", hint)
    more = [inspect.Parameter(n, inspect.Parameter.KEYWORD_ONLY, default=of, annotation=text(hints[n])) for n, of in defaults.items()]
    function.__signature__ = signature.replace(parameters=[*own, *more])  # type: ignore[attr-defined]
    return function


def complete(given: RunOptions, function: Callable[..., object]) -> dict[str, Any]:
    """The keywords that `function` was given, completed by the defaults; an unknown keyword is refused with the nearest names."""
    for name in given.keys() - RunOptions.__annotations__.keys():
        raise unknown("keyword", name, [*inspect.signature(function).parameters])
    options: dict[str, Any] = {**dict.fromkeys(RunOptions.__annotations__), "metrics": (), **given}
    options["settings"] = by_name(options["settings"])
    return options
