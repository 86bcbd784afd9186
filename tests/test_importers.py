"""Every importer that installs from the package registries: loads, runs alone, runs coupled, agrees; the table in docs/.

The whole of this file, run, writes docs/interoperability.md.
"""

import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import importers
from conftest import NAMES
from fmpy_master import ROOT

# Importer, what of `importers` it runs, largest difference to the reference (joint angles in rad, strokes in m) and why that.
ONE_EXCHANGE = "one exchange of values a step, so that voltages come one step late"
ALONE = {"FMPy": ("fmpy_alone", 1e-12), "ecospy": ("ecos_alone", 1e-9), "libcosimpy": ("cosim_alone", 1e-9)}
COUPLED = {
    "FMPy (container)": ("fmpy_container", 1e-7, "Jacobi schedule"),
    "ecospy": ("ecos_coupled", 2e-5, ONE_EXCHANGE),
    "libcosimpy": ("cosim_coupled", 2e-5, ONE_EXCHANGE),
    "fmu-manipulation-toolbox (container, parallel)": ("toolbox_parallel", 2e-5, ONE_EXCHANGE),
    "fmu-manipulation-toolbox (container, sequential)": ("toolbox_sequential", 1e-4, "manipulator first, forces one step late"),
}
NOTES = """
- The reference is the FMPy master in `tests/fmpy_master.py` (Gauss-Seidel, 1 ms), which gives the native master's numbers bit for bit
  (`tests/test_closed_loop.py`).
- *Alone*: the manipulator falls for 0.5 s; joint angles are compared. *Coupled*: five instances for 5 s, the last of them on the
  cubic trajectory; strokes are compared. The tip moves with 0.15 m/s there: a command that comes one step late is 0.15 mm.
- ecospy needs `libtbb.so.12`, which its wheel does not bring: the wheel `tbb` does; load it first.
- libcosim (libcosimpy) and ecos have no enumerations: `mode`, `trajectory` and `drive` keep their start values there.
- fmu-manipulation-toolbox initializes components in a loop of connections one after the other, without the others' values, and
  so leaves the actuators at a wrong rod position if they come before the manipulator. Its container works when the manipulator is
  listed first and the connected inputs have start values; `tests/importers.py` writes such a description from the SSD.
- fmi-sim (crate, 0.7.0) is not part of the run, since it builds for a quarter of an hour: `tests/README.md` says how to install it.
"""


def run(name, fmu_dir, work):
    arguments = [sys.executable, Path(__file__).with_name("importers.py"), name, fmu_dir, work]
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=300)
    assert done.stdout, f"{name} ended with {done.returncode}:\n{done.stderr[-3000:]}"
    return np.array(json.loads(done.stdout))


@pytest.fixture(scope="module")
def table():
    """Cells that have passed, (importer, column): text. Written out if all are there."""
    cells = {}
    yield cells
    wanted = {("FMPy", "loads")} | {(i, "alone") for i in ALONE} | {(i, "coupled") for i in COUPLED}
    if wanted <= set(cells):
        write(cells)


def write(cells):
    lines = ["# Interoperability", "", "Written by `pytest tests/test_importers.py`; every entry is a test that has passed.", ""]
    lines += ["| importer | reads | runs alone | runs coupled |", "|---|---|---|---|"]
    for importer in dict.fromkeys(name for name, _ in cells):
        lines.append("| " + " | ".join([importer, *(cells.get((importer, column), "-") for column in ("loads", "alone", "coupled"))]) + " |")
    text = "\n".join(lines) + "\n" + NOTES
    path = ROOT / "docs/interoperability.md"
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_reads(table, fmu_dir, name):
    import fmpy

    assert fmpy.read_model_description(str(fmu_dir / f"{name}.fmu"), validate=True).modelName == name
    table["FMPy", "loads"] = "Emla, Hdrm, Controller, .ssp: no complaint"


@pytest.mark.parametrize("importer", ALONE)
def test_runs_alone(table, fmu_dir, hdrm, tmp_path, importer):
    name, tolerance = ALONE[importer]
    instance = hdrm.running()
    for k in range(round(importers.ALONE / importers.H)):
        instance.step(k * importers.H, importers.H)
    expected = instance.get(*importers.ANGLES)
    assert max(map(abs, expected)) > 0.1
    assert np.abs(run(name, fmu_dir, tmp_path) - expected).max() < tolerance
    table[importer, "alone"] = f"Hdrm: agrees to {tolerance:g} rad"


@pytest.fixture(scope="module")
def strokes(system, fmus):
    """Of the reference at the end of the coupled run."""
    from fmpy_master import Master

    master = Master(system, fmus)
    found = master.record(importers.END, [f"hdrm.{name}" for name in importers.STROKES])[1]
    master.free()
    assert np.abs(found[-1] - found[0]).max() > 0.01, "nothing moved"
    return found[-1]


@pytest.mark.parametrize("importer", COUPLED)
def test_runs_coupled(table, fmu_dir, strokes, tmp_path, importer):
    name, tolerance, reason = COUPLED[importer]
    difference = np.abs(run(name, fmu_dir, tmp_path) - strokes).max()
    print(f"{importer}: {difference:.2e} m")
    assert difference < tolerance
    table[importer, "coupled"] = f"5 instances: agrees to {tolerance:g} m ({reason})"


@pytest.mark.parametrize("name", NAMES)
def test_toolbox_has_no_complaint(table, fmu_dir, name, tmp_path):
    """fmutool -check: schema and semantics."""
    tool = Path(sys.executable).with_name("fmutool")
    done = subprocess.run([tool, "-input", fmu_dir / f"{name}.fmu", "-check"], capture_output=True, text=True, cwd=tmp_path)
    said = done.stdout + done.stderr
    assert "seems to be compliant with FMI-2.0" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said
    for mode in ("parallel", "sequential"):
        table[f"fmu-manipulation-toolbox (container, {mode})", "loads"] = "Emla, Hdrm, Controller: check without complaint"


def test_toolbox_reads_the_ssp(fmu_dir, tmp_path):
    """A container with all five instances comes out of the .ssp."""
    for file in fmu_dir.iterdir():
        shutil.copy(file, tmp_path)
    tool = Path(sys.executable).with_name("fmucontainer")
    subprocess.run([tool, "-container", "Manipulator.ssp:0.001", "-fmu-directory", "."], cwd=tmp_path, check=True, capture_output=True)
    with zipfile.ZipFile(tmp_path / "Manipulator.fmu") as archive:
        assert len([n for n in archive.namelist() if n.endswith("modelDescription.xml")]) >= 6


def test_pyssp_reads_the_ssp(table, fmu_dir, system):
    """pyssp_standard finds every connection, and no connection that does not fit."""
    from pyssp_standard.ssp import SSP

    with SSP(fmu_dir / "Manipulator.ssp", mode="r") as ssp, ssp.system_structure as ssd:
        found = {(c.start_element, c.start_connector, c.end_element, c.end_connector) for c in ssd.connections()}
        resources = {Path(str(r)).name for r in ssp.resources}
    assert found == {(*link.source, *link.target) for link in system.links}
    assert {"Emla.fmu", "Hdrm.fmu", "Controller.fmu"} <= resources
    table["pyssp_standard", "loads"] = ".ssp: all connections"
