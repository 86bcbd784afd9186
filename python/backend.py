"""The build backend that pip calls for the package: packs the FMUs, then has maturin compile the native module.

Without optimisation of whole programs, which takes twice as long; `pip install ./python --config-settings lto=yes` has it, as the wheels do that
are handed out.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

#: The profile that compiles all of it fast, every crate once.
FAST = "pip"
#: That of programs which are handed out.
PROFILE = {f"CARGO_PROFILE_RELEASE_{name}": value for name, value in (("DEBUG_ASSERTIONS", "false"), ("OVERFLOW_CHECKS", "false"), ("STRIP", "symbols"))}

WHEEL = "install a finished wheel, which needs no compiler (docs/studies/python.md says where it is made)"


def __getattr__(hook):
    """The other hooks are maturin's own."""
    import maturin

    return getattr(maturin, hook)


def _check():
    if not (ROOT / "Cargo.toml").is_file():
        sys.exit(f"hdrm_fmu is built in its repository, because the FMUs are packed there: run `pip install ./python` there, or {WHEEL}.")
    if shutil.which("cargo") is None:
        sys.exit(f"hdrm_fmu is compiled here by Rust, but there is no `cargo`: install Rust (https://rustup.rs) and a C compiler, or {WHEEL}.")
    return []


def _tell(line):
    """Says something although pip keeps the output of a build to itself."""
    print(line, flush=True)
    try:
        with open("/dev/tty", "w") as terminal:
            terminal.write(f"\n{line}\n")
    except OSError:  # no terminal, or not Unix
        pass


def _prepare(config_settings):
    _check()
    settings = dict(config_settings or {})
    lto = settings.pop("lto", "no")
    if lto not in ("yes", "no"):
        sys.exit(f"--config-settings lto={lto}: must be yes or no.")
    time = "3 to 5 minutes" if lto == "no" else "about 10 minutes"
    _tell(f"hdrm_fmu: packing the FMUs and compiling the master takes {time} on two cores, less where they were built before.")
    if lto == "yes":
        os.environ.update(PROFILE)
        prepare = ["xtask", "wheel", "--prepare"]
    else:
        os.environ.setdefault("MATURIN_PEP517_ARGS", f"--profile {FAST}")
        prepare = ["run", "--quiet", "--profile", FAST, "--package", "xtask", "--", "wheel", "--prepare", "--quick"]
    done = subprocess.run(["cargo", *prepare], cwd=ROOT)
    if done.returncode != 0:
        sys.exit("hdrm_fmu: packing the FMUs failed, see above.")
    return settings


def get_requires_for_build_wheel(config_settings=None):
    return _check()


def get_requires_for_build_editable(config_settings=None):
    return _check()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    settings = _prepare(config_settings)
    return __getattr__("build_wheel")(wheel_directory, settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    settings = _prepare(config_settings)
    return __getattr__("build_editable")(wheel_directory, settings, metadata_directory)
