"""The packages that are made of the suite as SSP tools read them: schemas, names, units, start values, annotations."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyssp_standard
import pytest
from lxml import etree

from fmpy_master import ROOT, Master
from native import call, recorded
from system import SSC, SSD, SSV, System, read_set

SCHEMAS = {".ssd": "SystemStructureDescription.xsd", ".ssv": "SystemStructureParameterValues.xsd"}
PACKAGES = {
    "Manipulator.ssp": "system/SystemStructure.ssd",
    "Real.ssp": "system/Real.ssd",
    "Electric.ssp": "system/Electric.ssd",
    "Testbed.ssp": "system/Testbed.ssd",
    "RigTestbed.ssp": "system/RigTestbed.ssd",
}


@pytest.fixture(scope="module", params=PACKAGES)
def package(request, fmu_dir):
    """Texts by file name."""
    with zipfile.ZipFile(fmu_dir / request.param) as archive:
        return {name: archive.read(name) for name in archive.namelist() if Path(name).suffix in SCHEMAS}


def schema(suffix):
    return etree.XMLSchema(file=str(Path(pyssp_standard.__file__).parent / "resources" / SCHEMAS[suffix]))


def complaints(name, text):
    """What the schemas say against a file; the structure's does not look into the parameter sets inside it."""
    checks = [(schema(Path(name).suffix), root := etree.fromstring(text))]
    checks += [(schema(".ssv"), etree.fromstring(etree.tostring(inner))) for inner in root.iterdescendants(f"{SSV}ParameterSet")]
    return [error for check, element in checks if not check.validate(element) for error in check.error_log]


def test_every_file_complies_with_the_schema(package):
    assert {name: found for name, text in package.items() if (found := complaints(name, text))} == {}


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.ssd")), ids=lambda path: path.name)
def test_the_structures_of_the_examples_comply_with_the_schema(path):
    assert complaints(path.name, path.read_bytes()) == []


@pytest.mark.parametrize("right, wrong", [(b"<ssv:Parameter name=", b"<ssv:Parameter title="), (b"startElement=", b"from=")])
def test_the_schemas_can_complain(package, right, wrong):
    found = {name: complaints(name, text.replace(right, wrong)) for name, text in package.items() if right in text}
    assert found and all(found.values())


def test_structures_of_one_package_have_names_of_their_own(package):
    names = [ElementTree.fromstring(text).get("name") for name, text in package.items() if name.endswith(".ssd")]
    assert len(set(names)) == len(names) and "SystemStructure.ssd" in package
    assert all(re.fullmatch(r"\w+", name) for name in names), "importers use the name as an identifier"


def test_every_parameter_set_defines_its_units_as_the_fmus_do(package, fmus):
    """Also the unit 1. A set inside a structure defines its own too: importers read it by itself."""
    described = {u.name: u.baseUnit for fmu in fmus.values() for u in fmu.description.unitDefinitions}
    sets = [s for text in package.values() for s in ElementTree.fromstring(text).iter(f"{SSV}ParameterSet")]
    for parameters in sets:
        defined = {u.get("name"): u.find(f"{SSC}BaseUnit").attrib for u in parameters.iterfind(f"{SSV}Units/{SSC}Unit")}
        used = {u for value in parameters.iterfind(f"{SSV}Parameters/{SSV}Parameter/*") if (u := value.get("unit"))}
        assert used == set(defined), parameters.get("name")
        for unit, exponents in defined.items():
            for base in "kg m s A K mol cd rad".split():
                found = getattr(described[unit], base) if described[unit] is not None else 0
                assert int(exponents.get(base, 0)) == found, (unit, base)
    assert sets


def test_every_structure_defines_the_units_of_its_connectors(package):
    for name, root in ((name, ElementTree.fromstring(text)) for name, text in package.items() if name.endswith(".ssd")):
        used = {unit for connector in root.iter(f"{SSD}Connector") for kind in connector if (unit := kind.get("unit"))}
        assert used <= {unit.get("name") for unit in root.iterfind(f"{SSD}Units/{SSC}Unit")}, name


def test_no_comment_is_among_the_items_of_a_structure(package):
    """Some readers take every child of an element for one of its items."""
    for name, text in package.items():
        if name.endswith(".ssd"):
            assert [node.text for node in etree.fromstring(text).iter(etree.Comment)] == [], name


def test_values_are_given_in_forms_that_every_importer_reads(package):
    """Real, Integer, Boolean, String: `ssv:Enumeration` makes some importers end with an error and others drop the value without a word."""
    for name, text in package.items():
        for parameter in ElementTree.fromstring(text).iter(f"{SSV}Parameter"):
            (value,) = parameter
            assert value.tag.removeprefix(SSV) in ("Real", "Integer", "Boolean", "String"), (name, parameter.get("name"))


def test_actuators_start_at_the_start_pose_of_the_manipulator(fmu_dir, hdrm):
    """For importers that initialize each component by itself."""
    instance = hdrm.running()
    names = ("SystemStructure.ssd", "triangular_pd.ssd")
    for package, name in [(package, name) for package in ("Manipulator.ssp", "Real.ssp", "Electric.ssp") for name in names]:
        system = System.read(fmu_dir / package, name)
        for k in (1, 2, 3):
            bound = system.parameters[f"emla_{k}"]
            assert [bound["x"].value, bound["F_hold"].value] == pytest.approx(instance.get(f"x[{k}]", f"f_hold[{k}]"), rel=1e-9, abs=1e-9)
    instance.free()


def test_annotations_have_reverse_domain_names(package):
    for name, text in package.items():
        for annotation in ElementTree.fromstring(text).iter(f"{SSC}Annotation"):
            assert re.fullmatch(r"(org|io|com)(\.[a-z][\w-]*)+", annotation.get("type")), (name, annotation.get("type"))


def test_openmodelica_is_told_kind_and_step_of_the_system(package):
    """As OMSimulator writes it itself: a system with a fixed communication step, whose size is a number of seconds."""
    for name, text in package.items():
        if name.endswith(".ssd"):
            annotations = ElementTree.fromstring(text).iterfind(f"{SSD}System/{SSD}Annotations/{SSC}Annotation")
            (found,) = [a for a in annotations if a.get("type") == "org.openmodelica"]
            (master,) = found.iterfind("{*}Annotations/{*}SimulationInformation/{*}FixedStepMaster")
            step = 1e-4 if b'name="RigTestbed"' in text else 1e-3
            assert (master.get("description"), float(master.get("stepSize"))) == ("oms-ma", step), name


def test_the_machine_as_built_holds_its_gains_and_one_variant_does_not(fmu_dir):
    """As opened it is what `--parameters resources/real.ssv` made of it."""
    system = lambda variant: System.read(fmu_dir / "Real.ssp", variant)
    gains = {tuple(name.split(".", 1)): p for name, p in read_set((ROOT / "system/resources/real.ssv").read_bytes()).items()}
    default, bare = system("SystemStructure.ssd"), system("bare.ssd")
    assert {end: default.parameters[end[0]][end[1]] for end in gains} == gains
    assert all(bare.parameters[component].get(name) != value for (component, name), value in gains.items())
    with zipfile.ZipFile(fmu_dir / "Real.ssp") as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
    assert [child.tag.removeprefix(SSD) for child in root.find(f"{SSD}System")][:2] == ["ParameterBindings", "Elements"], "readers take them in this order"


STANDARD = ["--schedule", "standard", "--stop-time", "8", "--quiet"]


def test_the_machine_as_built_does_not_swing_as_opened(fmu_dir, tmp_path):
    """Tip error over the first 8 s of the cubic trajectory, by an exchange once a step too. Without its gains it reaches 0.6 m."""
    largest = {}
    for variant, schedule in (("SystemStructure.ssd", "gauss-seidel"), ("standard.ssd", "standard"), ("bare.ssd", "gauss-seidel")):
        options = ["--system", fmu_dir / "Real.ssp", "--variant", variant, "--schedule", schedule, "--stop-time", 8]
        largest[variant] = recorded(tmp_path / "rows.csv", ["controller.tip_error_norm"], *options).max()
    # `hdrm-fmu`, which tells components of a delay under this schedule, leaves what the variant says.
    told = call("hdrm-fmu", "run", *options[:2], "--variant", "standard.ssd", *STANDARD, "--csv", tmp_path / "told.csv", "--signals", "controller.tip_error_norm")
    assert told.returncode == 0 and largest["standard.ssd"] == max(float(line.split(",")[1]) for line in (tmp_path / "told.csv").read_text().splitlines()[1:]), told.stderr
    print(largest)
    assert largest["SystemStructure.ssd"] < 2e-3 and largest["standard.ssd"] < 2e-3 < largest["bare.ssd"]


@pytest.mark.parametrize("package, step", [("Testbed.ssp", 1e-3), ("RigTestbed.ssp", 1e-4)])
def test_testbeds_stay_where_they_are_as_opened(fmu_dir, fmus, package, step):
    """Nothing is asked of them until a reference is given: small voltages, rods at rest."""
    master = Master(System.read(fmu_dir / package), fmus, h=step)
    names = [f"controller.v_q[{k}]" for k in (2, 3)] + [f"emla_{name}.x_rod" for name in ("lift", "tilt")]
    _, rows = master.record(0.2, names)
    master.free()
    print(np.abs(rows[:, :2]).max(axis=0), np.ptp(rows[:, 2:], axis=0))
    assert np.abs(rows[:, :2]).max() < 20.0 and np.abs(rows[:, 2:] - 0.3).max() < 1e-4


def test_the_master_takes_the_fmus_of_a_package(fmu_dir, tmp_path):
    """Of one whose FMUs are nowhere else under these names."""
    package = tmp_path / "Renamed.ssp"
    with zipfile.ZipFile(fmu_dir / "Testbed.ssp") as archive, zipfile.ZipFile(package, "w") as renamed:
        for name in archive.namelist():
            data = archive.read(name)
            renamed.writestr(name.replace(".fmu", "_renamed.fmu"), data.replace(b".fmu", b"_renamed.fmu") if name.endswith(".ssd") else data)
    command = [sys.executable, ROOT / "tests/fmpy_master.py", "--ssd", package, "--stop-time", 0.01, "--signals", "emla_lift.x_rod"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0 and "emla_lift.x_rod: last 0.3" in done.stdout, done.stderr


@pytest.mark.parametrize("name", PACKAGES)
def test_the_package_holds_the_structure_of_the_repository_and_the_same_fmus(fmu_dir, name):
    with zipfile.ZipFile(fmu_dir / name) as archive:
        assert archive.read("SystemStructure.ssd") == (ROOT / PACKAGES[name]).read_bytes()
        fmus = [file for file in archive.namelist() if file.endswith(".fmu")]
        assert all(archive.read(file) == (fmu_dir / Path(file).name).read_bytes() for file in fmus) and len(fmus) >= 2
