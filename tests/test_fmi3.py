"""The FMUs of FMI 3.0: valid, the same interface as those of FMI 2.0, the same numbers bit for bit, and as hard to misuse."""

import random
import re
import struct
import zipfile
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_uint32, c_uint8, c_void_p
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from conftest import NAMES, WORLD
from fmu import ERROR, OK
from fmu3 import Fmu3

FMPY = Path(fmpy.__file__).parent
ALL = (*NAMES, *WORLD)


@pytest.fixture(scope="module")
def fmus3(fmu_dir, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus3")
    return {name: Fmu3(fmu_dir / f"fmi3/{name}.fmu", folder / name) for name in ALL}


@pytest.fixture(params=ALL)
def fmu3(request, fmus3):
    """Each of them in turn."""
    return fmus3[request.param]


@pytest.fixture
def fmu2(fmu3, fmus):
    """The same FMU in FMI 2.0."""
    return fmus[f"{fmu3.identifier}.fmu"]


def valid(schema, path):
    etree.XMLSchema(file=str(FMPY / f"schema/fmi3/{schema}.xsd")).assertValid(etree.parse(str(path)))


def test_checkers_have_no_complaint(fmu3):
    assert validate_fmu(fmu3.path) == []
    valid("fmi3ModelDescription", fmu3.folder / "modelDescription.xml")
    valid("fmi3TerminalsAndIcons", fmu3.folder / "terminalsAndIcons/terminalsAndIcons.xml")


def test_terminals_are_of_variables(fmu3):
    terminals = etree.parse(str(fmu3.folder / "terminalsAndIcons/terminalsAndIcons.xml"))
    members = terminals.findall(".//TerminalMemberVariable")
    assert members and {m.get("variableName") for m in members} <= set(fmu3.variables)


def test_the_archive_has_the_files_of_fmi_3_and_the_library_of_fmi_2(fmu3, fmu2):
    with zipfile.ZipFile(fmu3.path) as three, zipfile.ZipFile(fmu2.path) as two:
        names = set(three.namelist())
        identifier = fmu3.identifier
        assert {f"binaries/x86_64-linux/{identifier}.so", "modelDescription.xml", "terminalsAndIcons/icon.png", "documentation/index.html"} <= names
        assert any(name.startswith("documentation/licenses/") for name in names)
        assert "model.png" not in names and not any("linux64" in name for name in names)
        assert three.read(f"binaries/x86_64-linux/{identifier}.so") == two.read(f"binaries/linux64/{identifier}.so")
        resources = {name for name in names if name.startswith("resources/")}
        assert resources == {name for name in two.namelist() if name.startswith("resources/")}


def test_every_function_of_the_header_is_exported(fmu3):
    header = (FMPY / "c-code/fmi3Functions.h").read_text()
    functions = set(re.findall(r"FMI3_Export\s+fmi3\w+TYPE\s+(fmi3\w+);", header))
    assert len(functions) == 75
    library = fmu3.instance()
    assert [name for name in sorted(functions) if not hasattr(library.library, name)] == []
    library.free()


def test_elements_are_the_variables_of_fmi_2(fmu3, fmu2):
    """By name, order, unit, start value and bounds; an array has what its elements have."""
    found = {}
    for v in fmu3.description.modelVariables[1:]:
        starts = v.start.split() if v.start and v.dimensions else [v.start] * fmu3.length(v.name)
        for name, start in zip(fmu3.elements(v.name), starts, strict=True):
            found[name] = (v.causality, v.variability, v.unit, v.displayUnit, start, v.min, v.max, v.nominal, v.description)
    assert fmu3.description.modelVariables[0].causality == "independent"
    expected = {
        v.name: (v.causality, v.variability, v.unit, v.displayUnit, v.start, v.min, v.max, v.nominal, v.description)
        for v in fmu2.description.modelVariables
    }
    assert list(found) == list(expected)
    assert found == expected


@pytest.mark.parametrize("event_mode", [False, True])
def test_fmpy_runs_each_alone(fmu3, event_mode):
    result = fmpy.simulate_fmu(fmu3.path, stop_time=0.02, output_interval=1e-3, use_event_mode=event_mode)
    assert len(result) == 21
    for name in result.dtype.names:
        assert np.isfinite(result[name]).all(), name


def drawn(generator, fmu2, name):
    """A value near zero within the bounds of an input."""
    v = fmu2.variables[name]
    value = generator.gauss(0.0, 0.1) * float(v.nominal or 1.0)
    return min(max(value, float(v.min or "-inf")), float(v.max or "inf"))


@pytest.mark.parametrize("event_mode", [False, True])
def test_both_versions_give_the_same_numbers(fmu3, fmu2, event_mode):
    """All outputs after each of 100 steps with random inputs; with Event Mode also after each set, which FMI 2.0 has always allowed."""
    generator = random.Random(1203)
    two, three = fmu2.running(), fmu3.instance(event_mode=event_mode).initialize()
    real = [n for n in fmu3.names("input") if fmu3.access(n) == "Float64"]

    def bits(outputs):
        return {name: struct.pack("d", value) if isinstance(value, float) else int(value) for name, value in outputs.items()}

    if event_mode:
        three.call("fmi3EnterStepMode")
    for k in range(100):
        if event_mode:
            three.call("fmi3EnterEventMode")
        for name in generator.sample(real, min(3, len(real))):
            elements = fmu3.elements(name)
            start = [two.get(element) for element in elements]
            values = [drawn(generator, fmu2, e) if k % 10 == 9 else s + 1e-3 * drawn(generator, fmu2, e) for e, s in zip(elements, start)]
            low, high = (float(getattr(fmu2.variables[elements[0]], b) or f"{s}inf") for b, s in (("min", "-"), ("max", "")))
            values = [min(max(value, low), high) for value in values]
            two.set(dict(zip(elements, values)))
            three.set(name, *values)
        if event_mode:
            assert bits(three.outputs()) == bits(two.outputs())
            three.update()
            three.call("fmi3EnterStepMode")
        statuses = []
        for instance in (two, three):
            try:
                instance.step(k * 1e-3, 1e-3)
                statuses.append(OK)
            except Exception as refused:  # noqa: BLE001 (either kind of refusal)
                statuses.append(refused.status)
        assert statuses[0] == statuses[1]
        if statuses[0] != OK:
            break
        assert bits(three.outputs()) == bits(two.outputs()), k
    assert k > 20
    two.free()
    three.free()


def test_states_are_not_carried_between_the_versions(fmu3, fmu2):
    two, three = fmu2.running(), fmu3.instance().initialize()
    of_two, of_three = two.serialize(), three.serialize()
    state = c_void_p()
    data = (c_uint8 * len(of_two))(*of_two)
    assert three.status("fmi3DeserializeFMUState", data, c_size_t(len(of_two)), byref(state)) == ERROR
    assert three.text.endswith("serialized state is of an instance of FMI 2.0; it must be of FMI 3.0")
    with pytest.raises(Exception, match="(?i)deserialize|status"):
        two.deserialize(of_three)
    two.free()
    three.free()


def test_the_adjoint_is_the_transpose(fmus3):
    """⟨w, J s⟩ = ⟨Jᵀ w, s⟩ on the manipulator. Tolerance: rounding of some thousand terms."""
    fmu, generator = fmus3["Hdrm"], np.random.default_rng(12)
    instance = fmu.instance().initialize()
    knowns = ["f", "tau_wrist", *fmu.elements("f")[:0], *[f"wrench_env[{i}]" for i in range(1, 7)]]
    unknowns = ["zeta_ddot", "x_dot", "tip.position"]
    n, m = (sum(map(fmu.length, names)) for names in (knowns, unknowns))

    def derivative(function, seed, size):
        seed, result = (c_double * len(seed))(*seed), (c_double * size)()
        references = instance.references(unknowns), c_size_t(len(unknowns)), instance.references(knowns), c_size_t(len(knowns))
        instance.call(function, *references, seed, c_size_t(len(seed)), result, c_size_t(size))
        return np.array(result)

    for _ in range(5):
        s, w = generator.normal(size=n), generator.normal(size=m)
        forward = derivative("fmi3GetDirectionalDerivative", s, m)
        backward = derivative("fmi3GetAdjointDerivative", w, n)
        assert np.linalg.norm(forward) > 0
        terms = np.abs(w) @ np.abs(forward) + np.abs(s) @ np.abs(backward)
        assert abs(w @ forward - backward @ s) < 1e-10 * terms
    instance.free()


def test_random_misuse_changes_nothing(fmu3):
    """Calls with random references, lengths, values and order: none crashes, and one that is not done leaves the instance as it was."""
    generator = random.Random(77)
    instance = fmu3.instance(event_mode=True).initialize()
    references = [v.valueReference for v in fmu3.description.modelVariables] + [4000, 70000, 2**32 - 1]
    numbers = [0.0, 1.0, -1.0, 1e-3, 1e300, float("nan"), float("inf")]
    done = dict.fromkeys((OK, 2, ERROR), 0)

    def values():
        n = generator.choice([0, 1, 1, 1, 2, 3, 6])
        return (c_uint32 * max(n, 1))(*(generator.choice(references) for _ in range(n))), c_size_t(n)

    def batch(kind):
        n = generator.choice([0, 1, 1, 3, 6])
        return (kind * 16)(*(generator.choice(numbers) if kind is c_double else generator.randrange(2) for _ in range(n))), c_size_t(n)

    def places(*kinds):
        return [byref(kind()) for kind in kinds]

    calls = [
        ("fmi3SetFloat64", lambda: (*values(), *batch(c_double))),
        ("fmi3GetFloat64", lambda: (*values(), *batch(c_double))),
        ("fmi3SetInt32", lambda: (*values(), *batch(c_int))),
        ("fmi3GetInt32", lambda: (*values(), *batch(c_int))),
        ("fmi3SetBoolean", lambda: (*values(), *batch(c_bool))),
        ("fmi3GetBoolean", lambda: (*values(), *batch(c_bool))),
        ("fmi3GetFloat32", lambda: (*values(), *batch(c_int))),
        ("fmi3GetDirectionalDerivative", lambda: (*values(), *values(), *batch(c_double), *batch(c_double))),
        ("fmi3GetAdjointDerivative", lambda: (*values(), *values(), *batch(c_double), *batch(c_double))),
        ("fmi3GetNumberOfVariableDependencies", lambda: (c_uint32(generator.choice(references)), *places(c_size_t))),
        ("fmi3DoStep", lambda: (c_double(generator.choice(numbers)), c_double(generator.choice(numbers)), c_bool(True), *places(c_bool, c_bool, c_bool, c_double))),
        ("fmi3EnterEventMode", tuple),
        ("fmi3EnterStepMode", tuple),
        ("fmi3UpdateDiscreteStates", lambda: places(c_bool, c_bool, c_bool, c_bool, c_bool, c_double)),
        ("fmi3EnterConfigurationMode", tuple),
        ("fmi3ExitInitializationMode", tuple),
        ("fmi3EnterContinuousTimeMode", tuple),
    ]
    for _ in range(1500):
        function, arguments = generator.choice(calls)
        before = instance.serialize()
        status = instance.status(function, *arguments())
        done[status] += 1
        if status != OK:
            assert instance.text.startswith(f"{function}: ")
            assert instance.serialize() == before, f"{function} changed the instance: {instance.text}"
    assert min(done[OK], done[ERROR]) > 100, done
    instance.call("fmi3Reset")
    instance.initialize()
    instance.free()
