"""The native programs: `cosim`, which runs any system of FMUs, and `hdrm-fmu`, which knows the experiments of this machine.

They are looked for in the build folder beside the packed FMUs; the environment variables COSIM and HDRM_FMU name others.
"""

import csv
import os
import subprocess
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


def recorded(path, signals, *options, settings=None):
    """Rows of `signals` (component.variable) from `cosim run`; `settings`: {component: {variable: value}}."""
    named = {f"{c}.{v}": value for c, values in (settings or {}).items() for v, value in values.items()}
    options += tuple(option for name, value in named.items() for option in ("--set", f"{name}={value}"))
    done = call("cosim", "run", "--quiet", "--csv", path, "--signals", ",".join(signals), *options)
    assert done.returncode == 0, done.stderr
    with open(path) as file:
        titles, *rows = csv.reader(file)
    columns = dict(zip(titles, np.array(rows, dtype=float).T))
    return np.column_stack([columns[s] for s in signals])
