"""The files that come with the package: FMUs, systems and parameter files, for other tools and for the runs."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from hdrm_fmu import _native
from hdrm_fmu.errors import BadInput

#: Packed FMUs, systems and parameter files.
DATA = Path(__file__).resolve().parent / "data"

MACHINE = "Manipulator.ssp"


def _named(suffix):
    found = {path.stem: path for path in sorted(DATA.glob(f"*{suffix}"))}
    if not found:
        raise BadInput(f"{DATA} holds no {suffix}: the package was not built whole; build it by `cargo xtask wheel`, or install its wheel")
    return found


def fmus() -> dict[str, Path]:
    """Paths of the packed FMUs by name (`Emla`, `Hdrm`, `Controller`, `Rig`, `Sensors`, …), for FMPy or any other importer."""
    return _named(".fmu")


def systems() -> dict[str, Path]:
    """Paths of the packed systems (`.ssp`) by name (`Manipulator`, `Real`, `Testbed`, …), for `System` or any SSP tool."""
    return _named(".ssp")


def parameters() -> dict[str, Path]:
    """Paths of the parameter files (JSON) by name, such as `reference_machine`."""
    files = sorted((DATA / "parameters").glob("*.json"))
    return {path.stem: path for path in files if not path.name.endswith(".schema.json")}


def digest(path):
    """SHA-256 of a file, as hexadecimal digits."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise BadInput(f"`{path}` cannot be read: {error.strerror}") from None


@cache
def identity():
    """Version of the package and a hash of its native code and files: equal where results are equal bit for bit."""
    hashed = hashlib.sha256()
    for path in (Path(_native.__file__), *sorted(p for p in DATA.rglob("*") if p.is_file())):
        hashed.update(digest(path).encode())
    return f"{_native.VERSION}-{hashed.hexdigest()[:16]}"
