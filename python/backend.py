"""What pip calls to build the package: the FMUs are packed first, then maturin compiles the native module."""

import subprocess
from pathlib import Path

from maturin import *  # noqa: F403 the hooks that need nothing of ours
from maturin import build_wheel as _build_wheel

HERE = Path(__file__).resolve().parent


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    if not (HERE.parent / "Cargo.toml").is_file():
        raise RuntimeError("hdrm_fmu is built in its repository, because the FMUs are packed there; install the wheel elsewhere")
    subprocess.run(["cargo", "xtask", "wheel", "--prepare"], cwd=HERE.parent, check=True)
    return _build_wheel(wheel_directory, config_settings, metadata_directory)
