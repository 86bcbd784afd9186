"""Sizes that are parameters: structural parameters of FMI 3.0, constants of FMI 2.0 that are said when packing."""

import math
import shutil

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from conftest import FMU_DIR
from fmpy_master import ROOT
from native import cargo_fmu

# x' = w (x_2, -x_1): a rotation.
W = 1.5
A = [0.0, W, -W, 0.0]
# The solver of order 4 errs by (w h)^5/120 a step of h = 0.01 s: 6.4e-12 of 1, times 100 steps.
TOLERANCE = 7e-10


def pack(out, *sizes):
    options = [option for size in sizes for option in ("--size", size)]
    environment = {"CARGO_TARGET_DIR": str(FMU_DIR.parent)}
    arguments = ("pack", "--profile", "release", "--example", "state_space", "--out", out, *options)
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


def test_a_size_that_is_not_there_is_refused_when_packing(tmp_path):
    for size, reason in [
        ("k=3", "`k` must be a structural parameter of `StateSpace`, of which it has: n, m, r"),
        ("n=2000", "`n` must be a whole number from 1 to 1000"),
    ]:
        done = pack(tmp_path, size)
        assert done.returncode != 0 and reason in done.stderr, done.stderr
