"""The build backend that pip calls for the package: packs the FMUs, then has maturin compile the native module."""

import subprocess
from pathlib import Path

from maturin import *  # noqa: F403 the other hooks are maturin's own
from maturin import build_wheel as _build_wheel

HERE = Path(__file__).resolve().parent


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    if not (HERE.parent / "Cargo.toml").is_file():
        raise RuntimeError("hdrm_fmu is built in its repository, because the FMUs are packed there; install the wheel elsewhere")
    subprocess.run(["cargo", "xtask", "wheel", "--prepare"], cwd=HERE.parent, check=True)
    return _build_wheel(wheel_directory, config_settings, metadata_directory)
