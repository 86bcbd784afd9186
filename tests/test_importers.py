"""Every importer and checker that installs from the package registries: loads, runs alone, runs coupled, agrees as docs/fmus/interoperability.md
says."""

import json
import shutil
import subprocess
import sys
import zipfile
from ctypes import byref
from pathlib import Path

import numpy as np
import pytest

import importers
import interoperability
from conftest import NAMES
from fmpy_master import Master
from importers import ALL, ALONE, COUPLED, EVERY, H, MODELS, OUTPUTS, SIGNALS, STEPS, driven
from interoperability import FMI_SIM, IMPORTERS, IMPORTERS_3, PACKAGE, ROOT
from native import recorded
from system import System


def run(importer, kind, model, fmu_dir, work):
    arguments = [sys.executable, Path(__file__).with_name("importers.py"), importer, kind, model, fmu_dir, work]
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, timeout=300)
    assert done.stdout, f"{importer} ended with {done.returncode}:\n{done.stderr[-3000:]}"
    return np.array(json.loads(done.stdout))


def test_the_page_says_what_is_tested():
    """Run `python tests/interoperability.py` where this fails."""
    assert interoperability.PAGE.read_text() == interoperability.page()


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
@pytest.mark.parametrize("importer", [name for name in IMPORTERS if name != "FmiSim"])
def test_runs_alone(references, fmu_dir, tmp_path, importer, model):
    """Driven by inputs that change every step, for half a second."""
    found, expected = run(importer, "alone", model, fmu_dir, tmp_path), references[model]
    assert found.shape == expected.shape
    size = np.abs(expected).max(axis=0)
    difference = (np.abs(found - expected).max(axis=0) / np.where(size == 0, 1, size)).max()
    print(f"{importer} {model}: {difference:.1e}")
    assert difference <= IMPORTERS[importer].alone


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_runs_alone_in_fmi_sim(references, fmu_dir, tmp_path, model):
    needs_fmi_sim()
    test_runs_alone(references, fmu_dir, tmp_path, "FmiSim", model)


@pytest.mark.parametrize("importer", IMPORTERS_3)
def test_runs_alone_in_fmi_3(references, fmu_dir, tmp_path, importer):
    """The same with the FMU of FMI 3.0: to the numbers of that of FMI 2.0."""
    found, expected = run(importer, "alone", "Emla", fmu_dir / "fmi3", tmp_path), references["Emla"]
    assert found.shape == expected.shape
    difference = (np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max()
    print(f"{importer}: {difference:.1e}")
    assert difference <= IMPORTERS_3[importer]


@pytest.fixture(scope="module")
def coupled_as(fmu_dir, fmus, tmp_path_factory):
    """Our masters' signals every half second by schedule; `after_set` as in `interoperability.Coupled`."""
    done = {}

    def by_fmpy(schedule, after_set, structure):
        master, rows = Master(System.read(fmu_dir / PACKAGE, structure), fmus, schedule=schedule, h=H), []
        for _ in range(round(COUPLED / H) // EVERY):
            _, found = master.record(master.time + EVERY * H, ALL)
            if after_set:
                master.exchange.run(verb="Set")
                found = [[master.instances[c].get(name) for c, name in (signal.split(".", 1) for signal in ALL)]]
            rows.append(found[-1])
        master.free()
        return np.array(rows)

    def coupled_as(schedule, after_set=False, structure="SystemStructure.ssd"):
        key = schedule, after_set, structure
        if key not in done:
            path = tmp_path_factory.mktemp("native") / "run.csv"
            native = lambda: recorded(path, ALL, "--system", fmu_dir / PACKAGE, "--stop-time", COUPLED)[EVERY::EVERY]
            done[key] = native() if schedule == "gauss-seidel" else by_fmpy(*key)
            assert np.ptp(done[key][:, ALL.index("hdrm.x[2]")]) > 0.03, "nothing moved"
        return done[key]

    return coupled_as


@pytest.mark.parametrize("importer", [name for name, importer in IMPORTERS.items() if importer.coupled])
def test_runs_coupled(coupled_as, fmu_dir, tmp_path, importer):
    """The packed system with its own values: the start pose is held, then the tip is two seconds on its way."""
    agreed = IMPORTERS[importer].coupled
    found, expected = run(importer, "coupled", PACKAGE, fmu_dir, tmp_path), coupled_as(agreed.schedule, agreed.after_set)
    assert found.shape == expected.shape
    for model, tolerance in zip(MODELS, agreed.tolerances):
        difference = np.abs(found - expected)[:, [ALL.index(signal) for signal in SIGNALS[model]]].max()
        print(f"{importer} {model}: {difference:.1e}")
        assert difference <= tolerance


def variant(fmu_dir, name, folder):
    """A package with the variant as its default structure, for importers that read no other."""
    path = folder / "Variant.ssp"
    with zipfile.ZipFile(fmu_dir / PACKAGE) as package, zipfile.ZipFile(path, "w") as made:
        for file in package.namelist():
            if not file.endswith(".ssd"):
                made.writestr(file, package.read(file))
        made.writestr("SystemStructure.ssd", package.read(name))
    return path


@pytest.mark.parametrize("importer", ["Ecos", "Libcosim"])
def test_the_variant_for_one_exchange_a_step_reaches_the_importers(coupled_as, fmu_dir, tmp_path, importer):
    """With `standard.ssd` controller and actuators are told the delay: the run is that of our master with this variant, and another than
    with the default structure."""
    agreed = IMPORTERS[importer].coupled
    found = run(importer, "coupled", variant(fmu_dir, "standard.ssd", tmp_path), fmu_dir, tmp_path)
    np.testing.assert_allclose(found, coupled_as("standard", agreed.after_set, "standard.ssd"), rtol=0, atol=max(agreed.tolerances))
    assert np.abs(found - coupled_as("standard", agreed.after_set)).max() > 1e-3


@pytest.mark.parametrize("importer", ["Ecos", "Libcosim"])
def test_a_variant_runs_but_its_enumerations_are_not_known(coupled_as, fmu_dir, tmp_path, importer):
    """Its sets are read without an error, but `mode` and `trajectory` keep their start values: the run is that of the default structure. Should
    this fail one day, the importer has learnt enumerations: see docs/fmus/interoperability.md."""
    agreed = IMPORTERS[importer].coupled
    found = run(importer, "coupled", variant(fmu_dir, "triangular_pd.ssd", tmp_path), fmu_dir, tmp_path)
    np.testing.assert_allclose(found, coupled_as("standard", agreed.after_set), rtol=0, atol=max(agreed.tolerances))


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_has_no_complaint(fmu_dir, name):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(fmu_dir / f"{name}.fmu")) == []


def test_fmpy_reads_the_ssp(fmu_dir):
    from fmpy.ssp.ssd import read_ssd

    assert len(read_ssd(str(fmu_dir / "Manipulator.ssp")).system.elements) == 5


def test_fmpy_cannot_start_the_ssp_by_itself(fmu_dir):
    """simulate_ssp passes no values in initialization and sets every connected input to 0 before the first step: the rods jump to 0, and
    the manipulator discards the forces. Should this fail one day, FMPy has learnt it: see docs/fmus/interoperability.md."""
    from fmpy.ssp.simulation import simulate_ssp

    with pytest.raises(Exception, match="fmi2SetReal failed with status 2"):
        simulate_ssp(str(fmu_dir / "Manipulator.ssp"), stop_time=0.01, step_size=H)


def checked_by_toolbox(fmu, version, folder):
    """What fmutool says of an FMU in which it finds no error."""
    tool = Path(sys.executable).with_name("fmutool")
    done = subprocess.run([tool, "-input", fmu, "-check"], capture_output=True, text=True, cwd=folder)
    said = done.stdout + done.stderr
    assert f"seems to be compliant with FMI-{version}" in said and "No semantic error" in said, said
    return said


@pytest.mark.parametrize("name", NAMES)
def test_toolbox_has_no_complaint(fmu_dir, name, tmp_path):
    """fmutool -check: schema and semantics."""
    said = checked_by_toolbox(fmu_dir / f"{name}.fmu", "2.0", tmp_path)
    assert "ERROR" not in said and "WARNING" not in said, said


@pytest.fixture
def default_logger():
    """FMPy's native proxy keeps the logger of the last run that had its own, and that logger ends with its run: the default one is put
    back before messages of other instances of this process call freed memory."""
    yield
    from fmpy import fmi2, logging

    fmi2.defaultCallbacks.logger = fmi2.fmi2CallbackLoggerTYPE(fmi2.printLogMessage)
    logging.addLoggerProxy(byref(fmi2.defaultCallbacks))


def test_toolbox_container_from_the_ssp_alone_cannot_start(fmu_dir, default_logger, tmp_path):
    """The container comes out of the .ssp with all five instances, but starts the actuators at a wrong rod position, which the
    manipulator discards. Should this fail one day, the toolbox has learnt to initialize: see docs/fmus/interoperability.md."""
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
    assert "Hdrm.fmu: fmuSetReal64 status=2" in said, said  # the message of a discarded value comes with loggingOn only


@pytest.mark.parametrize("name", NAMES)
def test_pyssp_reads_the_fmus(fmu_dir, fmus, name):
    """pyssp_standard finds every variable; its schema check knows FMI 3 only."""
    from pyssp_standard.fmu import FMU

    with FMU(fmu_dir / f"{name}.fmu", mode="r") as fmu, fmu.model_description as description:
        found = {v.name for causality in ("inputs", "outputs", "parameters") for v in getattr(description, causality)}
    variables = fmus[f"{name}.fmu"].variables.values()
    assert found == {v.name for v in variables if v.causality in ("input", "output", "parameter")}


def test_pyssp_reads_the_ssp(fmu_dir, system):
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


@pytest.mark.parametrize("importer", ["FMPy", "Ecos"])
def test_fmi_3_runs_alone(references, fmu_dir, tmp_path, importer):
    """An FMU of FMI 3.0 whose variables are scalars, driven like that of 2.0."""
    found, expected = run(importer, "alone", "Emla", fmu_dir / "fmi3", tmp_path), references["Emla"]
    size = np.abs(expected).max(axis=0)
    assert (np.abs(found - expected).max(axis=0) <= IMPORTERS[importer].alone * size).all()


@pytest.mark.parametrize("name", NAMES)
def test_toolbox_has_no_complaint_about_fmi_3(fmu_dir, name, tmp_path):
    checked_by_toolbox(fmu_dir / f"fmi3/{name}.fmu", "3.0", tmp_path)


@pytest.mark.slow
def test_fmi_sim_reads_no_units_of_fmi_3(fmu_dir, tmp_path):
    """Its reader of descriptions of FMI 3.0 refuses units. Should this fail one day, it has learnt them: see docs/fmus/interoperability.md."""
    needs_fmi_sim()
    command = [importers.FmiSim.PROGRAM, "--model", fmu_dir / "fmi3/Emla.fmu", "co-simulation", "-f", "0.01"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode != 0 and "unknown field" in done.stderr


def test_libcosim_reads_no_fmi_3(fmu_dir, tmp_path):
    """Should this fail one day, libcosim has learnt FMI 3.0: see docs/fmus/interoperability.md."""
    text = "from libcosimpy.CosimSlave import CosimLocalSlave as S; from libcosimpy.CosimExecution import CosimExecution as E\n"
    text += f"assert E.from_step_size(1e6).add_local_slave(S({str(fmu_dir / 'fmi3/Emla.fmu')!r}, 'fmu')) == 0"
    assert subprocess.run([sys.executable, "-c", text], capture_output=True, cwd=tmp_path).returncode != 0
