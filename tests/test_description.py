"""Model descriptions and files: valid for every checker, the interface complete, dependencies exact, no algebraic loop."""

import subprocess
import sys
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from pathlib import Path

import interface
from conftest import FMU_DIR, NAMES, WORLD
from system import AlgebraicLoop, feedthrough, levels

FUNCTIONS = """
    GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode
    ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate GetDirectionalDerivative
    SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus GetIntegerStatus
    GetBooleanStatus GetStringStatus
""".split()


@pytest.fixture(params=(*NAMES, *WORLD))
def fmu(request, fmus):
    """Each of them in turn."""
    return fmus[f"{request.param}.fmu"]


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


@pytest.mark.parametrize("name", (*NAMES, *WORLD))
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
    assert c.canHandleVariableCommunicationStepSize
    assert c.canGetAndSetFMUstate and c.canSerializeFMUstate
    assert not c.canBeInstantiatedOnlyOncePerProcess and not c.needsExecutionTool
    plant = fmu.identifier in ("Emla", "Hdrm")
    assert c.canInterpolateInputs == plant  # controller and sensors sample their inputs, the rig's drive does
    assert (c.maxOutputDerivativeOrder >= 1) == plant
    assert c.providesDirectionalDerivative == (plant or fmu.description.modelExchange is not None)
    assert fmu.description.variableNamingConvention == "structured"
    assert float(fmu.description.defaultExperiment.stopTime) > 0


def test_variables_change_when_they_say_so(controller, emla):
    """What a sampled controller holds is discrete. What an actuator passes on at once is continuous; what its network computes
    once a step is discrete."""
    of = lambda fmu, *names: {fmu.variables[name].variability for name in names}
    rows = [f"{row}[{k}]" for row in ("v_d", "v_q", "tau_wrist") for k in (1, 2, 3)]
    assert of(controller, *rows) == {"discrete"}
    assert of(emla, "x", "x_dot", "v_d", "v_q", "F", "i_d", "i_q", "P_in", "P_loss", "loss.mechanical") == {"continuous"}
    assert of(emla, "F_net", "F_hyb", "efficiency") == {"discrete"}


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
    assert declared == {"logAll", "logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError"}


def test_dependencies_of_the_actuator(emla):
    """F follows the rod at once and the voltages never: what lets x, x_dot -> F pass without a step of delay."""
    through = feedthrough(emla, initialization=False)
    assert set(through["F"]) == {"x", "x_dot"}
    assert not any(through[y] for y in ("F_mean", "i_d", "i_q", "w_m", "theta_m"))
    assert "F_hold" in feedthrough(emla, initialization=True)["F"]
    assert not any("F_hold" in inputs for inputs in through.values())


def test_dependencies_of_the_manipulator(hdrm):
    """Only accelerations depend on forces at once, never x or x_dot; what holds the machine follows the motion of its base, and a load the next step."""
    row = lambda name: name.split("[")[0]
    through = {name: {row(known) for known in inputs} for name, inputs in feedthrough(hdrm, initialization=False).items()}
    base = {"base.acceleration", "base.tilt"}
    assert {"base.angular_velocity", "base.angular_acceleration"} < through["zeta_ddot[4]"]
    assert {row(name) for name, inputs in through.items() if inputs - base} == {"zeta_ddot"}
    assert {row(name) for name, inputs in through.items() if inputs} == {"zeta_ddot", "f_hold", "tau_hold", "energy.potential"}
    assert {row(known) for known in feedthrough(hdrm, initialization=True)["f_hold[2]"]} == base | {"load.mass", "load.com"}


def test_dependencies_of_the_controller(controller):
    """Commands answer the measurements of the same instant."""
    through = feedthrough(controller, initialization=False)
    assert {"zeta[1]", "zeta_dot[6]", "i_q[2]", "w_m[2]"} <= set(through["v_q[2]"])
    assert "i_q[1]" not in through["v_q[2]"]
    assert "F[2]" not in through["v_q[2]"]


def states(fmu, hdrm):
    """Start values of runs that together let every input act: a pose and motion without symmetry, every kind of reference, commands far
    from saturation."""
    zeta, small = [0.31, 0.52, -1.13, 0.41, -0.62, 0.37], [1e-3 * i for i in range(1, 7)]
    numbered = lambda name, values: {f"{name}[{i}]": value for i, value in enumerate(values, 1)}
    if fmu.identifier == "Emla":
        common = {"v_q": 17.0, "v_d": -3.0, "x": 0.31, "x_dot": 0.02, "F_hold": 12e3}
        fed = {"v_dc": 560.0, "undervoltage": 450.0, "heat": True, "temperature": True}
        flat = fed | {"v_dc": 400.0}
        other = [{"alpha": 0.5}, {"drive": "force", "F_ext": 9e3}, {"x_dot": 0.0}, {"F_hold": -12e3}, fed, flat]
        # Loaded as its network knows it: elsewhere the interval is that of 0 and 1.
        calibrated = common | {"v_q": 60.0, "F_hold": 30e3, "interval": True, "surrogate_file": str(Path(__file__).parents[1] / "parameters/surrogate_rig.json")}
        return [common | values for values in other] + [calibrated | values for values in ({}, fed, flat)]
    if fmu.identifier == "Rig":
        common = {"v_q": 17.0, "v_d": -3.0, "x": 0.31, "x_dot": 0.02, "F_hold": 12e3}
        limited = common | {"switching": False, "v_q": 300.0, "v_d": -300.0}
        return [common, limited, common | {"drive": "force", "F_ext": 9e3}]
    if fmu.identifier == "Sensors":
        ideal = {f"{name}[{i}]": 0.3 for name in "theta_m i_d i_q F".split() for i in (1, 2, 3)}
        estimated = ideal | {"speed": "difference", "speed.filter_time": 0.0, "current": True, "current.bits": 40}
        return [ideal, estimated, estimated | {"force": "absent"}]
    if fmu.identifier == "DcLink":
        return [{"i_load[1]": 12.0, "precharge.on": True, "precharge.v_start": 300.0}, {"i_load[2]": -9.0}]
    pose = numbered("zeta_start", zeta) | numbered("zeta_dot_start", small)
    if fmu.identifier == "Hdrm":
        carried = {"load.mass": 90.0, "load.com[2]": 0.1, "base.tilt[1]": 0.1, "base.tilt[2]": -0.2, "base.angular_velocity[1]": 0.3}
        return [pose | carried | {"f[2]": 3e4, "f[3]": 2e4, "tau_wrist[1]": 40.0}]
    plant = hdrm.running(**pose)
    position = plant.get(*(f"tip.position[{i}]" for i in (1, 2, 3)))
    orientation = plant.get(*(f"tip.orientation[{i}]" for i in (1, 2, 3, 4)))
    x = plant.get("x[1]", "x[2]", "x[3]")
    plant.free()
    rows = {"zeta": zeta, "zeta_dot": small, "x": x, "x_dot": small[:3], "reference.velocity": small[:3]}
    rows |= dict.fromkeys(("i_d", "i_q", "w_m"), [0.1, 0.2, 0.3])
    rows |= {"reference.position": np.add(position, 1e-5), "reference.orientation": orientation, "reference.rod_position": np.add(x, 1e-5)}
    common = {element: value for name, values in rows.items() for element, value in numbered(name, values).items()}
    hybrid = common | {"trajectory": "cubic", "alpha": 0.4}
    hot = common | {"derating": True} | numbered("T_winding", [428.1] * 3) | {"v_dc": 30.0}
    path = common | {"trajectory": "path", "path_file": str(Path(__file__).parents[1] / "examples/paths/two_pickups.json"), "path_check": False}
    external = [common | {"trajectory": "external", "mode": mode} for mode in ("adaptive", "pd")]
    return external + [hybrid, hot, path, common | {"level": "actuator"}]


# Changes that carry the actuator over the threshold of a Boolean, or beyond the voltage limit.
LARGE = {"F_hold": 1e5, "x_dot": 0.1, "v_d": 1e3, "v_dc": -200.0}


def changed(variable, value):
    if variable.type == "Boolean":
        return [not value]
    return [value + change for change in {1e-6, 1e-4, 1e-3, LARGE.get(variable.name, 1e-3)} if value + change >= float(variable.min or -1e300)]


def perturbed(instance, inputs):
    """{output: inputs whose change alone changes it}, from changes of several sizes."""
    found, start = {}, dict(zip(inputs, instance.get(*inputs)))
    instance.set(start)  # a value that is set counts from then on, also the same one again: the rod has moved on since the last
    before = instance.outputs()
    for name in inputs:
        for value in changed(instance.fmu.variables[name], start[name]):
            instance.set({name: value})
            for output, value in instance.outputs().items():
                if value != before[output]:
                    found.setdefault(output, set()).add(name)
            instance.set({name: start[name]})
    assert instance.outputs() == before
    return found


def row(name):
    return name.split("[")[0]


def compared(said, found, exact=True):
    """{output: (dependencies too few, rows too many)}, where there are any; unless `exact`, too many are fine."""
    wrong = {}
    for output, by in said.items():
        seen = found.get(output, set())
        few, many = seen - set(by), {row(i) for i in by} - {row(i) for i in seen}
        if few or exact and many:
            wrong[output] = few, many
    return wrong


def test_dependencies_are_what_outputs_do(fmu, hdrm):
    """Exact: an output changes with every input that it is said to depend on, in one of several states inside a run, and with no other.
    A dependency too few makes importers exchange in a wrong order, one too many makes them find algebraic loops. Outputs declare whole rows of
    the variable table (`tip_error[1]` on all of `reference.position`), so one element of a row is enough."""
    said, found = feedthrough(fmu, initialization=False), {}
    for values in states(fmu, hdrm):
        instance = fmu.instance().start(0.0, values)
        for k in range(2):
            instance.step(k * 1e-3, 1e-3)
        for output, by in perturbed(instance, [i for i in fmu.names("input") if i != "F_hold"]).items():
            found.setdefault(output, set()).update(by)
        instance.free()
    assert compared(said, found) == {}


def test_initial_dependencies_are_what_outputs_do(fmu, hdrm):
    """The same in Initialization Mode, where inputs act through the initial state too."""
    said, found = feedthrough(fmu, initialization=True), {}
    for values in states(fmu, hdrm):
        instance = fmu.instance()
        instance.set(values)
        instance.setup()
        instance.call("fmi2EnterInitializationMode")
        for output, by in perturbed(instance, fmu.names("input")).items():
            found.setdefault(output, set()).update(by)
        instance.free()
    # The path that gives the loads is laid from the start pose, but at its beginning they are the same from every pose.
    for name in ("load.mass", "load.com[1]", "load.com[2]", "load.com[3]"):
        if fmu.identifier == "Controller":
            found.setdefault(name, set()).update(by for by in said[name] if row(by) == "zeta")
    # Of Rig and Sensors no state is known in which all inputs that they declare act initially.
    assert compared(said, found, exact=fmu.identifier not in ("Rig", "Sensors")) == {}


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


@pytest.mark.parametrize("name", (*NAMES, *WORLD))
def test_files_of_an_fmu(fmu_dir, name):
    with zipfile.ZipFile(fmu_dir / f"{name}.fmu") as archive:
        files = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
        icon = archive.read("model.png")
        licence = archive.read("documentation/licenses/license.txt").decode()
    assert {"modelDescription.xml", *(["resources/reference_machine.json"] if name not in ("Sensors", "DcLink") else [])} <= files
    assert any(f.startswith("binaries/") for f in files)
    assert icon.startswith(b"\x89PNG\r\n")
    assert "MIT" in licence and "Apache-2.0" in licence
    for word in interface.INPUTS[name]:
        assert word.split("[")[0] in page, f"documentation does not mention {word}"


@pytest.mark.skipif(sys.platform != "linux", reason="ldd is a program of Linux")
def test_a_plain_linux_is_enough(fmu):
    """No library beyond those of a plain Linux is needed."""
    library = f"{fmu.folder}/binaries/linux64/{fmu.identifier}.so"
    listed = subprocess.run(["ldd", library], capture_output=True, text=True).stdout
    names = {line.split()[0] for line in listed.splitlines()}
    assert all(n.startswith(("linux-vdso", "libc.so", "libm.so", "libgcc_s.so", "/lib", "libpthread", "libdl")) for n in names), names
