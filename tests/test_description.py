"""Model descriptions and files: valid for every checker, the interface complete, dependencies exact, no algebraic loop."""

import subprocess
import zipfile

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from pathlib import Path

import interface
from conftest import FMU_DIR, NAMES
from system import AlgebraicLoop, feedthrough, levels

FUNCTIONS = """
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode
    ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative
    SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus
    GetBooleanStatus GetStringStatus
""".split()


def test_xsd_has_no_complaint(fmu):
    schema = Path(fmpy.__file__).parent / "schema/fmi2/fmi2ModelDescription.xsd"
    etree.XMLSchema(file=str(schema)).assertValid(etree.parse(f"{fmu.folder}/modelDescription.xml"))


def test_a_broken_description_is_complained_about(fmus, tmp_path):
    """FMPy's check and the schema can fail: a unit and an attribute made wrong are found."""
    text = Path(fmus["Hdrm.fmu"].folder, "modelDescription.xml").read_text()
    path = tmp_path / "Broken.fmu"
    for right, wrong in [('unit="rad/s2"', 'unit="rad/s9"'), ("variableNamingConvention", "namingConvention")]:
        assert right in text
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", text.replace(right, wrong))
        assert validate_fmu(str(path))


def test_all_34_functions_are_exported(fmu):
    assert len(FUNCTIONS) == 34
    dll = fmu.instance().slave.dll
    assert [f for f in FUNCTIONS if not hasattr(dll, f"fmi2{f}")] == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("causality, table", [
    ("input", interface.INPUTS), ("output", interface.OUTPUTS), ("parameter", interface.PARAMETERS)
])  # fmt: skip
def test_interface_is_complete(fmus, name, causality, table):
    """Names, causalities and units that other people's wiring relies on."""
    fmu = fmus[f"{name}.fmu"]
    for entry, unit in table[name].items():
        for element in interface.elements(entry):
            variable = fmu.variables.get(element)
            assert variable is not None, f"{name} has no {element}"
            assert variable.causality == causality, element
            if unit is not None:
                assert (variable.unit or (variable.declaredType.unit if variable.declaredType else None) or "") == unit, element


def test_tunable_parameters(fmus):
    for name, tunable in interface.TUNABLE.items():
        for entry in interface.PARAMETERS[name]:
            for element in interface.elements(entry):
                found = fmus[f"{name}.fmu"].variables[element].variability
                assert (found == "tunable") == (entry in tunable), (name, element)


def test_enumerations_have_their_items(fmus):
    for (name, variable), items in interface.ENUMERATIONS.items():
        declared = fmus[f"{name}.fmu"].variables[variable].declaredType
        assert [(i.name, int(i.value)) for i in declared.items] == [(n, k + 1) for k, n in enumerate(items)]


def test_capabilities(fmu):
    c = fmu.description.coSimulation
    assert c.canHandleVariableCommunicationStepSize and c.canInterpolateInputs
    assert c.canGetAndSetFMUstate and c.canSerializeFMUstate
    assert not c.canBeInstantiatedOnlyOncePerProcess and not c.needsExecutionTool
    plant = fmu.identifier != "Controller"
    assert (c.maxOutputDerivativeOrder >= 1) == plant
    assert c.providesDirectionalDerivative == plant
    assert fmu.description.variableNamingConvention == "structured"
    assert float(fmu.description.defaultExperiment.stopTime) > 0


def test_every_variable_is_described(fmu):
    assert [v.name for v in fmu.description.modelVariables if not v.description] == []


def test_start_values_are_those_of_the_machine(emla, hdrm):
    import json

    machine = json.loads(Path(hdrm.folder, "resources/reference_machine.json").read_text())
    for name in "R_s L_d lambda_m N_gear rho C_b v_max".split():
        assert float(emla.variables[name].start) == machine["emla"][name]
    for i, angle in enumerate(machine["start"]["zeta"]):
        assert float(hdrm.variables[f"zeta_start[{i + 1}]"].start) == angle
    assert float(hdrm.variables["payload.mass"].start) == machine["bodies"]["PL"]["mass"]


def test_log_categories_are_declared(fmu):
    declared = {c.name for c in fmu.description.logCategories}
    assert declared == {"logAll", "logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"}


def test_dependencies_of_the_actuator(emla):
    """F follows the rod at once and the voltages never: what lets x, x_dot -> F pass without a step of delay."""
    through = feedthrough(emla, initialization=False)
    assert set(through["F"]) == {"x", "x_dot"}
    assert not any(through[y] for y in ("F_mean", "i_d", "i_q", "w_m", "theta_m"))
    assert "F_hold" in feedthrough(emla, initialization=True)["F"]
    assert not any("F_hold" in inputs for inputs in through.values())


def test_dependencies_of_the_manipulator(hdrm):
    """Only accelerations depend on inputs at once: never x or x_dot on f."""
    through = feedthrough(hdrm, initialization=False)
    assert {name.split("[")[0] for name, inputs in through.items() if inputs} == {"zeta_ddot"}
    assert not any(feedthrough(hdrm, initialization=True)["f_hold[2]"])


def test_dependencies_of_the_controller(controller):
    """Commands answer the measurements of the same instant."""
    through = feedthrough(controller, initialization=False)
    assert {"zeta[1]", "zeta_dot[6]", "i_q[2]", "w_m[2]"} <= set(through["v_q[2]"])
    assert "i_q[1]" not in through["v_q[2]"]
    assert "F[2]" not in through["v_q[2]"]


def test_dependencies_are_what_outputs_do(fmu):
    """Changing one input changes no output that is said not to depend on it, at a point inside a run."""
    instance = fmu.running()
    instance.step(0.0, 1e-3)
    inputs = [i for i in fmu.names("input") if i != "F_hold"]
    start = dict(zip(inputs, instance.get(*inputs)))
    before, through = instance.outputs(), feedthrough(fmu, initialization=False)
    changed_by = {}
    for name in inputs:
        instance.set({name: start[name] + 1e-3})
        after = instance.outputs()
        instance.set({name: start[name]})
        for output in after:
            if after[output] != before[output]:
                changed_by.setdefault(output, set()).add(name)
    instance.free()
    assert {o: extra for o, by in changed_by.items() if (extra := by - set(through[o]))} == {}
    assert changed_by


def test_every_connector_is_a_variable_of_its_fmu(system, fmus):
    """With the same causality and unit. What connections must fulfil both masters check: tests/test_bad_systems.py."""
    for (component, name), connector in system.connectors.items():
        variable = fmus[system.components[component]].variables[name]
        assert (variable.causality, variable.type, variable.unit) == connector, (component, name)


@pytest.mark.parametrize("initialization", [False, True])
def test_there_is_no_algebraic_loop(system, fmus, initialization):
    found = levels(system, fmus, initialization)
    assert len(found) == len(system.links) and max(found) >= 1


def test_an_algebraic_loop_would_be_found(system, fmus):
    """Wired to the joint accelerations, which depend on the forces at once, the exchange has no order."""
    from dataclasses import replace

    links = [
        replace(link, source=("hdrm", "zeta_ddot[2]")) if link.target == ("emla_2", "x_dot") else link for link in system.links
    ]
    with pytest.raises(AlgebraicLoop, match="emla_2.F"):
        levels(replace(system, links=links), fmus)


@pytest.mark.parametrize("name", NAMES)
def test_files_of_an_fmu(fmu_dir, name):
    with zipfile.ZipFile(fmu_dir / f"{name}.fmu") as archive:
        files = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
        icon = archive.read("model.png")
        licence = archive.read("licenses/license.txt").decode()
    assert {"modelDescription.xml", "resources/reference_machine.json"} <= files
    assert any(f.startswith("binaries/") for f in files)
    assert icon.startswith(b"\x89PNG\r\n")
    assert "MIT" in licence and "Apache-2.0" in licence
    for word in interface.INPUTS[name]:
        assert word.split("[")[0] in page, f"documentation does not mention {word}"


def test_ssp_holds_the_structure_and_the_same_fmus(fmu_dir):
    with zipfile.ZipFile(fmu_dir / "Manipulator.ssp") as archive:
        structure = archive.read("SystemStructure.ssd")
        for name in NAMES:
            assert archive.read(f"resources/{name}.fmu") == (fmu_dir / f"{name}.fmu").read_bytes(), name
    assert structure == Path(__file__).parent.parent.joinpath("system/SystemStructure.ssd").read_bytes()


def test_binary_says_nothing_of_the_build_machine(fmu):
    """No library beyond those of a plain Linux is needed."""
    library = f"{fmu.folder}/binaries/linux64/{fmu.identifier}.so"
    if not Path(library).exists():
        pytest.skip("not a Linux build")
    listed = subprocess.run(["ldd", library], capture_output=True, text=True).stdout
    names = {line.split()[0] for line in listed.splitlines()}
    assert all(n.startswith(("linux-vdso", "libc.so", "libm.so", "libgcc_s.so", "/lib", "libpthread", "libdl")) for n in names), names
