"""Sizes that are parameters: structural parameters of FMI 3.0, constants of FMI 2.0 that are said when packing."""

import math
import shutil

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from conftest import FMU_DIR
from fmpy_master import ROOT
from native import call, cargo_fmu

# x' = w (x_2, -x_1): a rotation.
W = 1.5
A = [0.0, W, -W, 0.0]
# The solver of order 4 errs by (w h)^5/120 a step of h = 0.01 s: 6.4e-12 of 1, times 100 steps.
TOLERANCE = 7e-10


def pack(out, *sizes, example="state_space"):
    options = [option for size in sizes for option in ("--size", size)]
    environment = {"CARGO_TARGET_DIR": str(FMU_DIR.parent)}
    arguments = ("pack", "--profile", "release", "--example", example, "--out", out, *options)
    return cargo_fmu(*arguments, cwd=ROOT, environment=environment)


@pytest.fixture(scope="module")
def archives(tmp_path_factory):
    """Of FMI 2.0 with sizes, of FMI 3.0 without."""
    made = []
    for sizes in [("n=2", "m=1", "r=2"), ()]:
        out = tmp_path_factory.mktemp("sizes")
        done = pack(out, *sizes)
        assert done.returncode == 0, done.stderr
        made.append(out)
    return made[0] / "StateSpace.fmu", made[1] / "fmi3/StateSpace.fmu"


def test_descriptions_are_valid(archives):
    for archive in archives:
        assert validate_fmu(str(archive)) == []
        done = cargo_fmu("check", archive)
        assert done.returncode == 0 and " 0 failed" in done.stdout, done.stdout


def test_sizes_are_said_when_packing_for_fmi_2(archives):
    description = fmpy.read_model_description(str(archives[0]))
    names = [v.name for v in description.modelVariables]
    assert [n for n in names if n.startswith(("A", "C", "y"))] == ["A[1,1]", "A[1,2]", "A[2,1]", "A[2,2]", "C[1,1]", "C[1,2]", "C[2,1]", "C[2,2]", "y[1]", "y[2]"]
    (n,) = (v for v in description.modelVariables if v.name == "n")
    assert (n.causality, n.variability, n.start) == ("local", "constant", "2")
    matrix = {f"A[{1 + k // 2},{1 + k % 2}]": value for k, value in enumerate(A)}
    unit = {"C[1,1]": 1.0, "C[1,2]": 0.0, "C[2,1]": 0.0, "C[2,2]": 1.0, "x0[1]": 0.0, "x0[2]": 1.0, "D[2,1]": 0.25}
    for interface in ("CoSimulation", "ModelExchange"):
        result = fmpy.simulate_fmu(
            str(archives[0]), fmi_type=interface, stop_time=1.0, output_interval=0.1, relative_tolerance=1e-10, start_values=matrix | unit | {"u[1]": 2.0}, output=["y[1]", "y[2]"]
        )
        t = result["time"]
        limit = TOLERANCE if interface == "CoSimulation" else 1e-7  # CVode keeps 1e-10 a step
        assert np.abs(result["y[1]"] - np.sin(W * t)).max() < limit
        assert np.abs(result["y[2]"] - np.cos(W * t) - 0.5).max() < limit


def test_sizes_are_structural_parameters_in_fmi_3(archives):
    """As the StateSpace of the Reference-FMUs: 3 of everything, and another number after Configuration Mode."""
    archive = str(archives[1])
    description = fmpy.read_model_description(archive)
    variables = {v.name: v for v in description.modelVariables}
    reference = {name: v.valueReference for name, v in variables.items()}
    assert [v.name for v in description.modelVariables if v.causality == "structuralParameter"] == ["n", "m", "r"]
    dimensions = [d.variable.name for d in variables["B"].dimensions]
    assert (dimensions, variables["B"].shape) == (["n", "m"], (3, 3))
    folder = fmpy.extract(archive)
    fmu = FMU3Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier="StateSpace", instanceName="x")
    fmu.instantiate()
    assert fmu.getUInt64([reference["n"]]) == [3]
    assert fmu.getFloat64([reference["x0"]], nValues=3) == [1.0, 2.0, 3.0]
    fmu.enterConfigurationMode()
    for name, size in {"n": 2, "m": 1, "r": 4}.items():
        fmu.setUInt64([reference[name]], [size])
    fmu.exitConfigurationMode()
    fmu.setFloat64([reference["A"]], A)
    fmu.setFloat64([reference["x0"]], [0.0, 1.0])
    fmu.setFloat64([reference["C"]], [1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 0.0])
    fmu.setFloat64([reference["D"]], [0.0, 0.25, 0.0, 0.0])
    fmu.setFloat64([reference["u"]], [2.0])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    assert fmu.getFloat64([reference["y"]], nValues=4) == [0.0, 1.5, 1.0, 0.0]
    for k in range(10):
        fmu.doStep(currentCommunicationPoint=k / 10, communicationStepSize=0.1)
    s, c = math.sin(W), math.cos(W)
    assert fmu.getFloat64([reference["y"]], nValues=4) == pytest.approx([s, c + 0.5, s + c, 2.0 * s], abs=2.0 * TOLERANCE)
    state = fmu.getFMUState()
    fmu.reset()
    assert fmu.getUInt64([reference["r"]]) == [3]
    fmu.setFMUState(state)
    assert fmu.getUInt64([reference["r"]]) == [4]
    fmu.terminate()
    fmu.freeInstance()
    shutil.rmtree(folder)


def test_cosim_sets_sizes_in_configuration_mode(archives, tmp_path):
    """As the test before, by the master: the same closed form, and the same numbers as FMPy's calls, which err alike."""
    said = {"n": 2, "m": 1, "r": 4, "A": A, "x0[2]": 1.0, "x0[1]": 0.0, "C": [1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 0.0], "D[2,1]": 0.25, "u": 2.0}
    words = [f"{name}={' '.join(map(str, value)) if isinstance(value, list) else value}" for name, value in said.items()]
    options = [option for word in words for option in ("--set", word)]
    rows = tmp_path / "rows.csv"
    done = call("cosim", "run", archives[1], "--quiet", "--stop-time", 1, "--step", 0.1, "--csv", rows, "--signals", "y", *options)
    assert done.returncode == 0, done.stderr
    head, *_, last = rows.read_text().splitlines()
    assert head == "time," + ",".join(f"StateSpace.y[{k}]" for k in (1, 2, 3, 4))
    s, c = math.sin(W), math.cos(W)
    assert [float(x) for x in last.split(",")[1:]] == pytest.approx([s, c + 0.5, s + c, 2.0 * s], abs=2.0 * TOLERANCE)
    for size, reason in [("n=0", "`StateSpace.n`: `0` is not a whole number from 1 to 1000"), ("n=1001", "`1001` is not"), ("n=2.5", "not a whole number")]:
        done = call("cosim", "run", archives[1], "--set", size)
        assert done.returncode == 1 and reason in done.stderr, done.stderr


def test_a_size_that_is_not_there_is_refused_when_packing(tmp_path):
    for size, reason in [
        ("k=3", "`k` must be a structural parameter of `StateSpace`, which has: n, m, r"),
        ("n=2000", "`n` must be a whole number from 1 to 1000"),
    ]:
        done = pack(tmp_path, size)
        assert done.returncode != 0 and reason in done.stderr, done.stderr


SINGLE = [float(np.float32(x)) for x in (0.1, -1e-40, 99.875, 1 / 3)]
# By the name in the examples: the functions, values, and one that is refused with what must be said of it.
TYPES = {
    "real": ("Float64", [1 / 3, -0.0, 5e-324, 99.9], None),
    "integer": ("Int32", [-100, 0, 99, 100], (101, "from -100 to 100")),
    "boolean": ("Boolean", [True, False, False, True], None),
    "text": ("String", ["", "ä€", "x" * 300, "%s"], None),
    "choice": ("Int64", [1, 2, 3, 1], (4, "1 (Closed) or 2 (Half) or 3 (Open)")),
    "float32": ("Float32", SINGLE, (math.inf, "from -99.9 to 99.9")),
    "int8": ("Int8", [-100, -1, 99, 100], (101, "from -100 to 100")),
    "uint8": ("UInt8", [0, 1, 199, 200], (201, "finite and at most 200")),
    "int16": ("Int16", [-(2**15), -1, 0, 2**15 - 1], None),
    "uint16": ("UInt16", [0, 1, 2, 2**16 - 1], None),
    "uint32": ("UInt32", [0, 1, 2, 2**32 - 1], None),
    "int64": ("Int64", [-(2**53), -1, 2**53 + 1, 2**63 - 1], (-(2**53) - 1, "finite and at least -9007199254740992")),
    "uint64": ("UInt64", [0, 1, 2**53 + 1, 2**64 - 1], None),
    "binary": ("Binary", [b"", b"\0", b"\0\xff\n", bytes(range(256))], None),
}


def taken(kind, n, shift=0):
    values = TYPES[kind][1]
    return [values[(k + shift) % len(values)] for k in range(n)]


class Arrays3:
    """An instance of FMI 3.0, its variables by name."""

    def __init__(self, archive, folder):
        description = fmpy.read_model_description(str(archive))
        self.variables = {v.name: v for v in description.modelVariables}
        self.kinds = [kind for kind in TYPES if f"{kind}.vector" in self.variables]
        self.said = []
        self.fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(archive), str(folder)), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="x")
        self.fmu.instantiate(loggingOn=True, eventModeUsed=True, logMessage=lambda _e, _s, _c, text: self.said.append(text.decode()))

    def access(self, verb, name):
        return getattr(self.fmu, verb + TYPES[name.split(".")[0].split("[")[0]][0])

    def set(self, name, values):
        self.access("set", name)([self.variables[name].valueReference], values)

    def get(self, name, n):
        return self.access("get", name)([self.variables[name].valueReference], nValues=n)

    def resize(self, n):
        self.fmu.enterConfigurationMode()
        self.fmu.setUInt64([self.variables["n"].valueReference], [n])
        self.fmu.exitConfigurationMode()


@pytest.fixture(scope="module")
def arrays(tmp_path_factory):
    out = tmp_path_factory.mktemp("arrays")
    for example in ("arrays2", "arrays3"):
        done = pack(out, example=example)
        assert done.returncode == 0, done.stderr
        assert ("not packed for FMI 2.0: variable `float32[1].array` is Float32" in done.stderr) == (example == "arrays3")
    assert sorted(p.name for p in out.iterdir()) == ["Arrays2.fmu", "fmi3"]
    return out


def test_arrays_of_each_type_are_described(arrays):
    for archive in sorted(arrays.rglob("*.fmu")):
        assert validate_fmu(str(archive)) == []
        done = cargo_fmu("check", archive)
        assert done.returncode == 0 and " 0 failed" in done.stdout, done.stdout


@pytest.mark.parametrize("name", ["Arrays2", "Arrays3"])
def test_arrays_of_each_type_are_set_and_read_in_fmi_3(arrays, tmp_path, name):
    x = Arrays3(arrays / f"fmi3/{name}.fmu", tmp_path)
    start = {kind: x.get(f"{kind}.vector", 3) for kind in x.kinds}
    n = 5
    x.resize(n)
    for kind in x.kinds:
        assert x.get(f"{kind}.vector", n) == [start[kind][0]] * n
        for variable, count, shift in [(f"{kind}[1].array", 3, 1), (f"{kind}[2].matrix", 2 * n, 2), (f"{kind}.vector", n, 0), (f"{kind}.matrix", 4, 3)]:
            x.set(variable, taken(kind, count, shift))
            assert x.get(variable, count) == taken(kind, count, shift), variable
            with pytest.raises(FMICallException):
                x.set(variable, taken(kind, count + 1))
    x.fmu.enterInitializationMode()
    x.fmu.exitInitializationMode()

    def seen():
        found = {f"{kind}.{output}": x.get(f"{kind}.{output}", count) for kind in x.kinds for output, count in [("last", n), ("now", 4), ("given", 2 * n)]}
        return found | {f"{kind}.vector": x.get(f"{kind}.vector", n) for kind in x.kinds}

    for kind in x.kinds:
        assert seen()[f"{kind}.now"] == taken(kind, 4, 3) and seen()[f"{kind}.given"] == taken(kind, 2 * n, 2)
        x.set(f"{kind}.vector", taken(kind, n, 1))
        x.set(f"{kind}[2].matrix", taken(kind, 2 * n, 3))  # tunable
        with pytest.raises(FMICallException):
            x.set(f"{kind}[1].array", taken(kind, 3))
        assert seen()[f"{kind}.last"] == taken(kind, n) and seen()[f"{kind}.given"] == taken(kind, 2 * n, 3)
    if name == "Arrays3":
        # Enumerations and Int64 in one call: both, or none.
        both = [x.variables[v].valueReference for v in ("choice.vector", "int64.vector")]
        before = x.fmu.getInt64(both, nValues=2 * n)
        assert before == taken("choice", n, 1) + taken("int64", n, 1)
        with pytest.raises(FMICallException):
            x.fmu.setInt64(both, [3, 1, 2, 3, 1] + [0, 0, 0, 0, TYPES["int64"][2][0]])
        assert "`int64.vector[5]` = -9007199254740993 must be finite and at least -9007199254740992" in x.said[-1]
        assert x.fmu.getInt64(both, nValues=2 * n) == before
        x.fmu.setInt64(both, [3, 1, 2, 3, 1] + [5, 4, 3, 2, 1])
        assert x.get("int64.vector", n) == [5, 4, 3, 2, 1]
    for kind in x.kinds:
        if TYPES[kind][2]:
            wrong, reason = TYPES[kind][2]
            before = seen()
            with pytest.raises(FMICallException):
                x.set(f"{kind}.vector", [*taken(kind, 2), wrong, *taken(kind, n - 3)])
            assert f"`{kind}.vector[3]` = {wrong} must be {reason}" in x.said[-1], x.said[-1]
            assert seen() == before
    x.fmu.enterStepMode()
    x.fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.1)
    after = seen()
    assert all(after[f"{kind}.last"] == after[f"{kind}.vector"] for kind in x.kinds)
    state = x.fmu.getFMUState()
    serialized = x.fmu.serializeFMUState(state)
    x.fmu.reset()
    assert {kind: x.get(f"{kind}.vector", 3) for kind in x.kinds} == start
    for saved in (state, x.fmu.deserializeFMUState(serialized)):
        x.fmu.setFMUState(saved)
        assert seen() == after
        x.fmu.reset()
    x.fmu.freeInstance()


def test_arrays_of_each_type_are_elements_in_fmi_2(arrays, tmp_path):
    description = fmpy.read_model_description(str(arrays / "Arrays2.fmu"))
    reference = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(arrays / "Arrays2.fmu"), str(tmp_path / "2")), modelIdentifier="Arrays2", instanceName="x")
    fmu.instantiate()
    access = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "text": "String", "choice": "Integer"}

    def elements(name, n):
        columns = 2 if name.split(".")[1] in ("matrix", "now", "given") else 0
        return [reference[f"{name}[{1 + k // columns},{1 + k % columns}]" if columns else f"{name}[{k + 1}]"] for k in range(n)]

    def call(verb, name, n, *values):
        kind = name.split(".")[0].split("[")[0]
        got = getattr(fmu, verb + access[kind])(elements(name, n), *values)
        return [v.decode() if isinstance(v, bytes) else v for v in got] if verb == "get" else None

    other = Arrays3(arrays / "fmi3/Arrays2.fmu", tmp_path / "3")
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    other.fmu.enterInitializationMode()
    sizes = {"[1].array": 3, "[2].matrix": 6, ".vector": 3, ".matrix": 4}
    for kind in access:
        for shift, (name, n) in enumerate(sizes.items()):
            values = taken(kind, n, shift)
            call("set", kind + name, n, values)
            other.set(kind + name, values)
            assert call("get", kind + name, n) == values
        call("set", f"{kind}.vector", 1, taken(kind, 1, 3))
        assert call("get", f"{kind}.vector", 3) == taken(kind, 1, 3) + taken(kind, 3, 2)[1:]
        call("set", f"{kind}.vector", 3, taken(kind, 3, 2))
        if TYPES[kind][2]:
            with pytest.raises(FMICallException):
                call("set", f"{kind}.vector", 3, [*taken(kind, 2), TYPES[kind][2][0]])
            assert call("get", f"{kind}.vector", 3) == taken(kind, 3, 2)
    for instance in (fmu, other.fmu):
        instance.exitInitializationMode()
    other.fmu.enterStepMode()
    for instance in (fmu, other.fmu):
        instance.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.1)
    outputs = [(f"{kind}.{output}", n) for kind in access for output, n in [("last", 3), ("now", 4), ("given", 6)]]
    found = {name: call("get", name, n) for name, n in outputs}
    assert found == {name: other.get(name, n) for name, n in outputs}  # the same bits in both versions
    state = fmu.getFMUstate()
    fmu.reset()
    fmu.setFMUstate(fmu.deSerializeFMUstate(fmu.serializeFMUstate(state)))
    assert {name: call("get", name, n) for name, n in outputs} == found
    for instance in (fmu, other.fmu):
        instance.terminate()
        instance.freeInstance()


@pytest.mark.parametrize("name", ["Arrays2", "Arrays3"])
def test_values_of_each_type_pass_to_processes(arrays, tmp_path, name):
    """Texts and bytes too: between two copies of the FMU, each in a process of its own, every type gives what it gives in one process."""
    fmu = arrays / f"fmi3/{name}.fmu"
    kinds = {v.name.split(".")[0] for v in fmpy.read_model_description(str(fmu)).modelVariables if v.name.endswith(".last")}
    assert kinds >= ({"text", "boolean"} if name == "Arrays2" else {"binary", "uint64"})
    options = [word for kind in sorted(kinds) for k in (1, 2, 3) for word in ("--connect", f"a.{kind}.last[{k}]=b.{kind}.vector[{k}]")]
    if name == "Arrays2":
        options += [word for k, text in enumerate(["", "ä€", "x" * 300], start=1) for word in ("--set", f"a.text.vector[{k}]={text}")]

    def rows(*more):
        table = tmp_path / "rows.csv"
        words = [f"a={fmu}", f"b={fmu}", *options, *more, "--step", 0.1, "--stop-time", 1, "--quiet", "--csv", table, "--signals", "*"]
        done = call("cosim", "run", *words)
        assert done.returncode == 0, done.stderr
        return table.read_text()

    alone = rows()
    assert name == "Arrays3" or "x" * 300 in alone.splitlines()[-1]
    assert rows("--isolate", "all") == alone
    assert rows("--isolate", "b", "--schedule", "standard") == rows("--schedule", "standard")
