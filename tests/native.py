"""The native programs: `cosim`, which runs any system of FMUs, and `hdrm-fmu`, which makes the manipulator's experiments; beside the
packed FMUs or where the environment variables COSIM and HDRM_FMU say."""

import os
from pathlib import Path

from conftest import FMU_DIR


def program(name):
    """The newest build of a native program; an environment variable of its name in capitals has the first word."""
    here = os.environ.get(name.upper().replace("-", "_"))
    places = [Path(here).resolve()] if here else [FMU_DIR.parent / kind / name for kind in ("release", "debug")]
    found = max((p for p in places if p.is_file()), key=lambda p: p.stat().st_mtime, default=None)
    assert found, f"no program `{name}` among {[str(p) for p in places]}; `cargo build --release` of its package makes it"
    return found


def cosim():
    return program("cosim")


def hdrm_fmu():
    return program("hdrm-fmu")
