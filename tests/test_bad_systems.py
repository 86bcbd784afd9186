"""Systems that cannot be run are refused by both masters, each with the reason in `bad_systems/systems.json`.

An entry changes some text of the good system `bad_systems/good.ssd`, which both masters run. Where the native master has another reason, it is
the entry's `native`; null: it runs the system, and the FMPy master says that it does not support it.

What both run, they run alike: the good system with other start times, steps and ends, and with an FMU that declares no dependencies.
"""

import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fmpy_master import Master
from fmu import Fmu, Refused
from native import call, recorded
from system import BadSystem, System

FOLDER = Path(__file__).parent / "bad_systems"
GOOD = (FOLDER / "good.ssd").read_text()
BAD = {entry["name"]: entry for entry in json.loads((FOLDER / "systems.json").read_text())}
FILES = {entry["name"]: entry for entry in json.loads((FOLDER / "files.json").read_text())}
MAPPING = "<ssm:ParameterMapping xmlns:ssm='m' xmlns:ssc='c' version='1.0'>{}</ssm:ParameterMapping>"


def changed(entry):
    """The good system's text with the entry's edits."""
    text = GOOD
    for old, new in entry["edits"]:
        assert text.count(old) == 1, f"{old} is there {text.count(old)} times"
        text = text.replace(old, new)
    return text


@pytest.fixture
def fmpy(fmus, tmp_path):
    """Runs a structure for two steps in the FMPy master."""

    def run(text):
        path = tmp_path / "system.ssd"
        path.write_text(text)
        system = System.read(path)
        for file in system.components.values():
            if file not in fmus:
                raise BadSystem(f"FMU `{file}` cannot be read")
        master = Master(system, fmus)
        master.record(2e-3, ["hdrm.x[1]"])
        master.free()

    return run


@pytest.fixture
def native(fmu_dir, tmp_path):
    """Runs a structure for two steps in the native master."""

    def run(text):
        path = tmp_path / "system.ssd"
        path.write_text(text)
        return call("cosim", "run", "--system", path, "--fmu-dir", fmu_dir, "--quiet", "--stop-time", "2e-3")

    return run


def test_both_masters_run_the_good_system(fmpy, native):
    fmpy(GOOD)
    done = native(GOOD)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", BAD)
def test_the_fmpy_master_refuses(fmpy, name):
    with pytest.raises((BadSystem, Refused)) as refused:
        fmpy(changed(BAD[name]))
    assert BAD[name]["reason"] in str(refused.value)


@pytest.mark.parametrize("name", BAD)
def test_the_native_master_refuses(native, name):
    done = native(changed(BAD[name]))
    reason = BAD[name].get("native", BAD[name]["reason"])
    if reason is None:
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 1 and reason in done.stderr, (done.returncode, done.stderr)


OSP = """<ssd:Annotations><ssc:Annotation type='com.opensimulationplatform'><osp:Algorithm
    xmlns:osp='http://opensimulationplatform.com/SSP/OSPAnnotations'><osp:FixedStepAlgorithm baseStepSize='0.0005'/></osp:Algorithm>
    </ssc:Annotation></ssd:Annotations>"""
EXPERIMENT = "<ssd:DefaultExperiment startTime='0' stopTime='0.01'/>"
BOTH_ENDS = "startElement='hdrm' startConnector='x[1]' endElement='emla' endConnector='x'"
AT_ONCE = "<ssd:Annotations><ssc:Annotation type='io.github.hdrm-fmu.feedthrough'/></ssd:Annotations>"
#: Changes to the good system: edits.
ALIKE = {
    "as it is": [],
    "another start time": [(EXPERIMENT, "<ssd:DefaultExperiment startTime='0.3' stopTime='0.31'/>")],
    "a step of its own": [(EXPERIMENT, f"<ssd:DefaultExperiment startTime='0' stopTime='0.01'>{OSP}</ssd:DefaultExperiment>")],
    "ends in the other order": [(BOTH_ENDS, "startElement='emla' startConnector='x' endElement='hdrm' endConnector='x[1]'")],
    "without declared dependencies": [("resources/Emla.fmu", "resources/Bare.fmu")],
    "trusted without declared dependencies": [
        ("resources/Emla.fmu'>", "resources/Bare.fmu'>" + AT_ONCE),
    ],
}
SIGNALS = ["emla.F", "emla.i_q", "hdrm.x[1]"]


@pytest.fixture(scope="module")
def with_bare(fmus, tmp_path_factory):
    """The FMUs, and `Bare.fmu`: the actuator with a description that says nothing of dependencies."""
    folder = tmp_path_factory.mktemp("bare")
    with zipfile.ZipFile(fmus["Emla.fmu"].path) as source, zipfile.ZipFile(folder / "Bare.fmu", "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                data = re.sub(rb' dependencies(Kind)?="[^"]*"', b"", data)
            target.writestr(name, data)
    for name in ("Emla.fmu", "Hdrm.fmu"):
        (folder / name).symlink_to(fmus[name].path)
    return folder, fmus | {"Bare.fmu": Fmu(folder / "Bare.fmu", folder / "bare")}


def edited(name):
    text = GOOD
    for old, new in ALIKE[name]:
        assert text.count(old) == 1, f"{old} is there {text.count(old)} times"
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("schedule", ["gauss-seidel", "jacobi", "standard"])
@pytest.mark.parametrize("name", ALIKE)
def test_both_masters_run_it_alike(with_bare, tmp_path, name, schedule):
    """To the last bit."""
    folder, fmus = with_bare
    path = tmp_path / "system.ssd"
    path.write_text(edited(name))
    system = System.read(path)
    master = Master(system, fmus, {"emla": {"v_q": 9.0}}, schedule, system.step or 1e-3)
    times, rows = master.record(system.stop, SIGNALS)
    master.free()
    out = tmp_path / "run.csv"
    native = recorded(out, SIGNALS, "--system", path, "--fmu-dir", folder, "--schedule", schedule, settings={"emla": {"v_q": 9.0}})
    assert times[0] == float(out.read_text().splitlines()[1].split(",")[0])
    np.testing.assert_array_equal(rows, native)
    assert np.ptp(rows[:, 1]) > 0.0, "nothing happens"


def test_undeclared_dependencies_cost_a_step_unless_it_is_trusted(with_bare, tmp_path):
    """The actuator's force depends at once on its motion: read once it is that of the step before, unless get after set is known to work."""
    folder, fmus = with_bare
    rows = {}
    for name in ("as it is", "without declared dependencies", "trusted without declared dependencies"):
        path = tmp_path / "system.ssd"
        path.write_text(edited(name))
        master = Master(System.read(path), fmus, {"emla": {"v_q": 9.0}}, "jacobi")
        rows[name] = master.record(0.01, SIGNALS)[1]
        master.free()
    declared, late, trusted = rows.values()
    np.testing.assert_array_equal(trusted, declared)
    assert (late != declared).any()


def test_there_are_forty_that_the_native_master_refuses():
    refused = [entry for entry in BAD.values() if entry.get("native", entry["reason"]) is not None]
    assert len(refused) >= 40 and len(FILES) >= 40, (len(refused), len(FILES))
    reasons = [entry["reason"] for entry in FILES.values()]
    assert len(set(reasons)) == len(reasons), "each entry has a fault of its own"


@pytest.mark.parametrize("name", FILES)
def test_the_native_master_refuses_the_file(fmu_dir, tmp_path, name):
    entry = FILES[name]
    options = list(entry.get("options", []))
    for kind, suffix in {"input": "csv", "units": "units.csv", "scenario": entry.get("suffix", "json"), "mapping": "ssm"}.items():
        if kind in entry:
            file = tmp_path / f"bad.{suffix}"
            file.write_text(MAPPING.format(entry[kind]) if kind == "mapping" else entry[kind])
            options += {"units": [], "mapping": ["--fmu", f"emla={fmu_dir / 'Emla.fmu'}", "--map", file]}.get(kind, [f"--{kind}", file])
    done = call("cosim", "run", "--system", FOLDER / "good.ssd", "--fmu-dir", fmu_dir, "--quiet", "--stop-time", "2e-3", *options)
    assert done.returncode == 1 and entry["reason"] in done.stderr, (done.returncode, done.stderr)
