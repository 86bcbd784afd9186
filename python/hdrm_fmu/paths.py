"""Reads the path that the tip follows: from a file, from points, or a built-in one."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np
import pandas

from hdrm_fmu import _native
from hdrm_fmu.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

#: What describes a path: a file or the name of a built-in path, what is in a JSON file, a table with the columns of a CSV file, or positions of
#: the shape (n, 3), m.
Waypoints = Union[str, "os.PathLike[str]", Mapping[str, Any], pandas.DataFrame, "ArrayLike"]

#: Parameters of the controller that say which path it follows.
TRAJECTORY, FILE = "trajectory", "path_file"


@dataclass(frozen=True)
class TipPath:
    """A path as it was read: its name in messages; the text of its file, none of a built-in path; whether loads are picked up or set down."""

    name: str
    text: str | None
    has_loads: bool

    @property
    def content(self) -> str:
        """Equal for equal paths."""
        return self.name if self.text is None else self.text

    @contextmanager
    def at_hand(self) -> Iterator[str]:
        """The path file for the controller, which exists within this context; errors name the path as the user did."""
        if self.text is None:
            yield self.name
            return
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "path"
            file.write_text(self.text, encoding="utf-8")
            try:
                yield str(file)
            except RunFailed as error:
                raise RunFailed(str(error).replace(str(file), self.name)) from None


def tip_path(waypoints):
    """The path that `waypoints` describes, checked as far as that needs no machine; None stays None."""
    if waypoints is None or isinstance(waypoints, TipPath):
        return waypoints
    name = os.fspath(waypoints) if isinstance(waypoints, (str, os.PathLike)) else "waypoints"
    try:
        if isinstance(waypoints, str) and _native.is_built_in_path(name):
            return TipPath(name, None, False)
        text = _text(waypoints)
        return TipPath(name, text, _native.path_has_loads(text))
    except RunFailed as error:
        raise BadInput(f"path `{name}`: {error}") from None


def _text(waypoints):
    """Text of the path's file, as documented in docs/machine/paths.md."""
    if isinstance(waypoints, (str, os.PathLike)):
        try:
            return Path(waypoints).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            built_in = " and ".join(_native.BUILT_IN_PATHS)
            reason = getattr(error, "strerror", None) or error
            raise BadInput(f"path `{os.fspath(waypoints)}` cannot be read: {reason}; the built-in paths are {built_in}") from None
    if isinstance(waypoints, Mapping):
        try:
            return json.dumps(dict(waypoints), allow_nan=False, default=lambda value: value.tolist())
        except (TypeError, ValueError, AttributeError) as error:
            raise BadInput(f"waypoints: {error}; a dictionary must hold what a path file in JSON holds") from None
    if isinstance(waypoints, pandas.DataFrame):
        return waypoints.to_csv(index=False)
    try:
        positions = np.asarray(waypoints, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"waypoints = {waypoints!r} must be a file, a dictionary, a DataFrame, or positions of the shape (n, 3)") from None
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise BadInput(f"waypoints have the shape {positions.shape}; positions must have the shape (n, 3): x, y, z in m")
    return pandas.DataFrame(positions, columns=["x", "y", "z"]).to_csv(index=False)


def check_free(path, values):
    """Refuse start values (by full name) that choose another path or trajectory than `path`."""
    for name, value in values.items():
        if path is not None and name.rsplit(".", 1)[-1] in (TRAJECTORY, FILE):
            raise BadInput(f"`{name}` = {value} is given together with waypoints, which the controller follows; one of them must be left out")
