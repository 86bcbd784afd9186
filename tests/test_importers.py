"""Every importer and checker that installs from the package registries: loads, runs alone, runs coupled, agrees; the table in docs/.

The whole of this file, run with fmi-sim at hand, writes docs/interoperability.md.
"""

import csv
import json
import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import importers
from conftest import NAMES
from fmpy_master import ROOT
from native import cosim
from importers import ALL, ALONE, COUPLED, EVERY, H, MODELS, OUTPUTS, SIGNALS, STEPS, driven

FMI_SIM = "0.7.0"
IMPORTERS = {  # class in `importers` or `containers`: name in the table
    "FMPy": f"FMPy {version('FMPy')}",
    "FMPyContainer": f"FMPy {version('FMPy')}, container",
    "Ecos": f"ecospy {version('ecospy')}",
    "Libcosim": f"libcosimpy {version('libcosimpy')}",
    "FmiSim": f"fmi-sim {FMI_SIM}",
    "ToolboxParallel": f"fmu-manipulation-toolbox {version('fmu-manipulation-toolbox')}, container, parallel",
    "ToolboxSequential": f"fmu-manipulation-toolbox {version('fmu-manipulation-toolbox')}, container, sequential",
}
# Alone: largest difference over the largest magnitude, for any output. Importers that add up times or interpolate inputs
# give inputs that are rounded otherwise; the stiff nut-rod spring makes 1e-13 of that.
ALONE_TOLERANCE = 1e-12
# Coupled: largest differences of i_q (A, Emla), x (m, Hdrm), v_q (V, Controller) to the native master, and what makes them.
ONE_EXCHANGE = "one exchange of values a step: voltages come one step late"
COUPLED_TOLERANCE = {
    "FMPy": (0.0, 0.0, 0.0, "the master `tests/fmpy_master.py`, same schedule"),
    "FMPyContainer": (5e-3, 5e-7, 2e-3, "Jacobi schedule"),
    "Ecos": (2e-2, 2e-5, 1.0, ONE_EXCHANGE),
    "Libcosim": (2e-2, 2e-5, 0.1, ONE_EXCHANGE),
    "ToolboxParallel": (2e-2, 2e-5, 0.1, ONE_EXCHANGE),
    "ToolboxSequential": (0.1, 1e-4, 0.1, "manipulator first: forces come one step late"),
}
CHECKERS = {
    "FMPy": f"FMPy {version('FMPy')}, `validate_fmu`, `read_ssd` with the schemas",
    "Toolbox": f"fmu-manipulation-toolbox {version('fmu-manipulation-toolbox')}, `fmutool -check`, `fmucontainer`",
    "Pyssp": f"pyssp_standard {version('pyssp_standard')}, readers of FMU, SSP and SSV, schemas of SSP",
}


def run(importer, kind, model, fmu_dir, work):
    arguments = [sys.executable, Path(__file__).with_name("importers.py"), importer, kind, model, fmu_dir, work]
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=300)
    assert done.stdout, f"{importer} ended with {done.returncode}:\n{done.stderr[-3000:]}"
    return np.array(json.loads(done.stdout))


@pytest.fixture(scope="module")
def cells():
    """Cells of the table that have passed: (row, model, column). The table is written when all are there."""
    found = {}
    yield found
    wanted = {(i, m, "alone") for i in IMPORTERS for m in MODELS} | {(i, m, "coupled") for i in COUPLED_TOLERANCE for m in MODELS}
    if wanted | {(c, m, "check") for c in CHECKERS for m in (*MODELS, "Manipulator.ssp")} <= set(found):
        path = ROOT / "docs/interoperability.md"
        lines = path.read_text().splitlines()
        start, end = (next(i for i, line in enumerate(lines) if line == f"<!-- {mark} -->") for mark in ("table", "end of table"))
        text = "\n".join([*lines[: start + 1], *table(found), *lines[end:]]) + "\n"
        if text != path.read_text():
            path.write_text(text)


def table(cells):
    lines = ["| importer | FMU | loads | runs alone | runs coupled | alone agrees to | coupled agrees to |", "|---|---|---|---|---|---|---|"]
    for importer, title in IMPORTERS.items():
        for model in MODELS:
            coupled = cells.get((importer, model, "coupled"))
            alone = cells[importer, model, "alone"]
            lines.append(f"| {title} | {model} | yes | yes | {'yes' if coupled else 'cannot'} | {alone} | {coupled or '-'} |")
    lines += ["", "| checker | FMU or system | complaints |", "|---|---|---|"]
    lines += [
        f"| {title} | {file} | {cells[checker, file, 'check']} |"
        for checker, title in CHECKERS.items()
        for file in (*MODELS, "Manipulator.ssp")
    ]
    return lines


@pytest.fixture(scope="module")
def references(fmus):
    """What calls of the C interface give: outputs of each FMU alone at the end of each step."""
    found = {}
    for model in MODELS:
        instance, rows = fmus[f"{model}.fmu"].running(), []
        for k in range(STEPS):
            instance.set(driven(model, k * H))
            instance.step(k * H, H)
            rows.append(instance.get(*OUTPUTS[model]))
        instance.free()
        found[model] = np.array(rows)
        assert (np.ptp(found[model], axis=0) > 0).all() or model == "Controller"
    return found


def needs_fmi_sim():
    program = shutil.which(importers.FmiSim.PROGRAM)
    said = subprocess.run([program, "--version"], capture_output=True, text=True).stderr if program else ""  # it is an "Error"
    if FMI_SIM not in said:
        pytest.skip(f"fmi-sim {FMI_SIM} is not at hand: tests/README.md")


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("importer", IMPORTERS)
def test_runs_alone(cells, references, fmu_dir, tmp_path, importer, model):
    """Driven by inputs that change every step, for half a second."""
    if importer == "FmiSim":
        needs_fmi_sim()
    found, expected = run(importer, "alone", model, fmu_dir, tmp_path), references[model]
    assert found.shape == expected.shape
    size = np.abs(expected).max(axis=0)
    difference = (np.abs(found - expected).max(axis=0) / np.where(size == 0, 1, size)).max()
    print(f"{importer} {model}: {difference:.1e}")
    assert difference < ALONE_TOLERANCE
    cells[importer, model, "alone"] = f"{ALONE_TOLERANCE:g} of each output's peak" if difference else "the last bit"


@pytest.fixture(scope="module")
def native(fmu_dir, tmp_path_factory):
    """The native master's signals."""
    path = tmp_path_factory.mktemp("native") / "run.csv"
    arguments = [cosim(), "run", "--system", fmu_dir / "Manipulator.ssp", "--quiet", "--stop-time", COUPLED, "--csv", path]
    done = subprocess.run(list(map(str, [*arguments, "--signals", ",".join(ALL)])), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with path.open() as file:
        titles, *rows = csv.reader(file)
    columns = dict(zip((title.split(" ")[0] for title in titles), np.array(rows, dtype=float).T))
    found = np.column_stack([columns[s] for s in ALL])[EVERY::EVERY]
    assert np.ptp(found[:, ALL.index("hdrm.x[2]")]) > 0.03, "nothing moved"
    return found


@pytest.mark.parametrize("importer", COUPLED_TOLERANCE)
def test_runs_coupled(cells, native, fmu_dir, tmp_path, importer):
    """The packed system with its own values: the start pose is held, then the tip is two seconds on its way."""
    found = run(importer, "coupled", "-", fmu_dir, tmp_path)
    assert found.shape == native.shape
    *tolerances, reason = COUPLED_TOLERANCE[importer]
    for model, tolerance, unit in zip(MODELS, tolerances, ("A of i_q", "m of x", "V of v_q")):
        columns = [ALL.index(signal) for signal in SIGNALS[model]]
        difference = np.abs(found - native)[:, columns].max()
        print(f"{importer} {model}: {difference:.1e} {unit}")
        assert difference <= tolerance
        cells[importer, model, "coupled"] = f"{tolerance:g} {unit} ({reason})" if tolerance else f"the last bit ({reason})"


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_has_no_complaint(cells, fmu_dir, name):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(fmu_dir / f"{name}.fmu")) == []
    cells["FMPy", name, "check"] = "none"


def test_fmpy_reads_the_ssp(cells, fmu_dir):
    from fmpy.ssp.ssd import read_ssd

    assert len(read_ssd(str(fmu_dir / "Manipulator.ssp")).system.elements) == 5
    cells["FMPy", "Manipulator.ssp", "check"] = "none"


def test_fmpy_cannot_start_the_ssp_by_itself(fmu_dir, capfd):
    """simulate_ssp passes no values in initialization and sets every connected input to 0 before the first step: the rods jump to 0, and
    the manipulator refuses the forces by name. Should this fail one day, FMPy has learnt it: see docs/interoperability.md."""
    from fmpy.ssp.simulation import simulate_ssp

    with pytest.raises(Exception, match="fmi2SetReal failed with status 3"):
        simulate_ssp(str(fmu_dir / "Manipulator.ssp"), stop_time=0.01, step_size=H)
    assert "`f[1]` = " in (said := capfd.readouterr().out) and "allowed are values" in said, said


@pytest.mark.parametrize("name", NAMES)
def test_toolbox_has_no_complaint(cells, fmu_dir, name, tmp_path):
    """fmutool -check: schema and semantics."""
    tool = Path(sys.executable).with_name("fmutool")
    done = subprocess.run([tool, "-input", fmu_dir / f"{name}.fmu", "-check"], capture_output=True, text=True, cwd=tmp_path)
    said = done.stdout + done.stderr
    assert "seems to be compliant with FMI-2.0" in said and "No semantic error" in said, said
    assert "ERROR" not in said and "WARNING" not in said, said
    cells["Toolbox", name, "check"] = "none"


def test_toolbox_container_from_the_ssp_alone_cannot_start(cells, fmu_dir, tmp_path):
    """The container comes out of the .ssp with all five instances, but starts the actuators at a wrong rod position, which the
    manipulator refuses by name. Should this fail one day, the toolbox has learnt to initialize: see docs/interoperability.md."""
    import fmpy

    shutil.copy(fmu_dir / "Manipulator.ssp", tmp_path)
    tool = Path(sys.executable).with_name("fmucontainer")
    arguments = [tool, "-container", f"Manipulator.ssp:{H}", "-fmu-directory", "."]
    done = subprocess.run(list(map(str, arguments)), cwd=tmp_path, check=True, capture_output=True, text=True)
    assert "Loop of links" in done.stdout + done.stderr
    with zipfile.ZipFile(tmp_path / "Manipulator.fmu") as archive:
        assert len([n for n in archive.namelist() if n.endswith("modelDescription.xml")]) >= 6
    said = []
    with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
        fmpy.simulate_fmu(str(tmp_path / "Manipulator.fmu"), stop_time=H, step_size=H, logger=lambda *a: said.append(a[-1].decode()))
    assert any("`f[1]`" in text and "allowed are values" in text for text in said), said
    cells["Toolbox", "Manipulator.ssp", "check"] = "loop of links at initialization: see below"


@pytest.mark.parametrize("name", NAMES)
def test_pyssp_reads_the_fmus(cells, fmu_dir, fmus, name):
    """pyssp_standard finds every variable; its schema check knows FMI 3 only."""
    from pyssp_standard.fmu import FMU

    with FMU(fmu_dir / f"{name}.fmu", mode="r") as fmu, fmu.model_description as description:
        found = {v.name for causality in ("inputs", "outputs", "parameters") for v in getattr(description, causality)}
    variables = fmus[f"{name}.fmu"].variables.values()
    assert found == {v.name for v in variables if v.causality in ("input", "output", "parameter")}
    cells["Pyssp", name, "check"] = "none"


def test_pyssp_reads_the_ssp(cells, fmu_dir, system):
    """pyssp_standard finds every connection, and no connection that does not fit, and every parameter set complies."""
    from pyssp_standard.ssp import SSP
    from pyssp_standard.ssv import SSV

    with SSP(fmu_dir / "Manipulator.ssp", mode="r") as ssp, ssp.system_structure as ssd:
        ssd.__check_compliance__()
        found = {(c.start_element, c.start_connector, c.end_element, c.end_connector) for c in ssd.connections()}
        resources = {Path(str(r)).name for r in ssp.resources}
    assert found == {(*link.source, *link.target) for link in system.links}
    assert {"Emla.fmu", "Hdrm.fmu", "Controller.fmu", "triangular.ssv", "pd.ssv"} <= resources
    for path in (ROOT / "system/resources").iterdir():
        with SSV(path, mode="r") as ssv:
            ssv.__check_compliance__()
            assert len(ssv.parameters) >= 1, path
    cells["Pyssp", "Manipulator.ssp", "check"] = "none"
