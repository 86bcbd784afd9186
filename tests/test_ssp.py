"""The packages that are made of the suite as SSP tools read them: schemas, names, units, start values, annotations."""

import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pyssp_standard
import pytest
from lxml import etree

from fmpy_master import ROOT
from system import SSC, SSD, SSV, System

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


@pytest.mark.parametrize("name", PACKAGES)
def test_the_package_holds_the_structure_of_the_repository_and_the_same_fmus(fmu_dir, name):
    with zipfile.ZipFile(fmu_dir / name) as archive:
        assert archive.read("SystemStructure.ssd") == (ROOT / PACKAGES[name]).read_bytes()
        fmus = [file for file in archive.namelist() if file.endswith(".fmu")]
        assert all(archive.read(file) == (fmu_dir / Path(file).name).read_bytes() for file in fmus) and len(fmus) >= 2
