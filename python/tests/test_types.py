"""What a type checker says of the package, and of scripts that use it."""

import subprocess
import sys

SCRIPT = """
from typing import Any

import numpy as np
import pandas
import xarray
from typing_extensions import assert_type

import hdrm_fmu

run = hdrm_fmu.run(mode="adaptive", waypoints=[[3.0, 1.1, 0.0], [2.9, 1.1, 0.0]], stop_time=0.1, signals=["emla_2.*"])
assert_type(run, xarray.Dataset)
table = hdrm_fmu.sweep(hdrm_fmu.grid(mode=["pd"]), out="results", waypoints="mine.csv", settings={"hdrm.inertia_scale": 1.2})
assert_type(table, pandas.DataFrame)
hdrm_fmu.run(stop_tim=0.1)  # type: ignore[call-arg]
hdrm_fmu.run(stop_time="long")  # type: ignore[arg-type]
hdrm_fmu.System("x.ssp").run(interval=[0.1])  # type: ignore[arg-type]
assert_type(hdrm_fmu.findings(run), list[hdrm_fmu.Finding])
assert_type(hdrm_fmu.Machine("sized").scale(1.2).gains("ideal"), pandas.DataFrame)
assert_type(hdrm_fmu.Machine({"extends": "reference"}).perturb(3).machine, hdrm_fmu.Machine)
hdrm_fmu.Machine(5)  # type: ignore[arg-type]
hdrm_fmu.run(machine=5)  # type: ignore[arg-type]
with hdrm_fmu.System("x.ssp") as s:
    assert_type(s.get("a", float), float)
    assert_type(s.port("a", np.ndarray).get(), np.ndarray)
    assert_type(s.get(["a", "b"]), dict[str, Any])
    s.get("a", str)  # type: ignore[type-var]
"""


def test_the_package_and_its_users_are_checked(tmp_path):
    """Each `type: ignore` must be needed: without types of its own the package would make some of them needless."""
    (tmp_path / "script.py").write_text(SCRIPT)
    options = ["--ignore-missing-imports", "--warn-unused-ignores", "--cache-dir", str(tmp_path / "cache")]
    for what in (["-p", "hdrm_fmu"], ["script.py"]):
        done = subprocess.run([sys.executable, "-m", "mypy", *options, *what], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
