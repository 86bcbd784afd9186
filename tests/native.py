"""The native programs: `cosim`, which runs any system of FMUs, and `hdrm-fmu`, which knows the experiments of this machine.

They are looked for in the build folder beside the packed FMUs; the environment variables COSIM and HDRM_FMU name others.
"""

import csv
import ctypes.util
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np

from conftest import FMU_DIR


def program(name):
    """The newest build of a program."""
    here = os.environ.get(name.upper().replace("-", "_"))
    places = [Path(here).resolve()] if here else [FMU_DIR.parent / kind / name for kind in ("release", "debug")]
    found = max((p for p in places if p.is_file()), key=lambda p: p.stat().st_mtime, default=None)
    assert found, f"no program `{name}` among {[str(p) for p in places]}; `cargo xtask demo` builds it"
    return found


def hdrm_fmu():
    return program("hdrm-fmu")


def call(name, *arguments, **options):
    """Run a program; its exit code, standard output and standard error."""
    return subprocess.run([str(part) for part in (program(name), *arguments)], capture_output=True, text=True, **options)


def cargo_fmu(*arguments, environment=None, **options):
    """Run `cargo fmu`; all builds outside of the workspace share a folder, so that the same crate is built once."""
    shared = {"CARGO_TARGET_DIR": str(FMU_DIR.parent / "stand-alone")}
    return call("cargo-fmu", "fmu", *arguments, env=os.environ | shared | (environment or {}), **options)


def named(settings):
    """Options of a program for start values: {component: {variable: value}}."""
    settings = {f"{c}.{v}": value for c, values in (settings or {}).items() for v, value in values.items()}
    return [option for name, value in settings.items() for option in ("--set", f"{name}={value}")]


def evaluated(folder, times, signals, rows, *options, settings=None):
    """A run that another importer recorded, by the definitions of the native programs: the object that `hdrm-fmu evaluate` writes, with
    `metrics` in SI units."""
    file = folder / "evaluated.csv"
    with file.open("w", newline="") as to:
        writer = csv.writer(to)
        writer.writerow(["time", *signals])
        writer.writerows([repr(float(t)), *map(repr, row.tolist())] for t, row in zip(times, rows))
    done = call("hdrm-fmu", "evaluate", file, "--system", FMU_DIR / "Manipulator.ssp", "--json", folder / "evaluated.json", *named(settings), *options)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "evaluated.json").read_text())


def recorded(path, signals, *options, settings=None):
    """Rows of `signals` (component.variable) from `cosim run`; `settings`: {component: {variable: value}}."""
    done = call("cosim", "run", "--quiet", "--csv", path, "--signals", ",".join(signals), *named(settings), *options)
    assert done.returncode == 0, done.stderr
    with open(path) as file:
        titles, *rows = csv.reader(file)
    columns = dict(zip(titles, np.array(rows, dtype=float).T))
    return np.column_stack([columns[s] for s in signals])


def libpython():
    """The Python library of this interpreter, which pythonfmu's FMUs expect in the program that loads them."""
    built = Path(sysconfig.get_config_var("LIBDIR") or "") / (sysconfig.get_config_var("INSTSONAME") or "")
    if built.is_file() and ".so" in built.name:
        return str(built)
    return ctypes.util.find_library(f"python{sys.version_info.major}.{sys.version_info.minor}")
