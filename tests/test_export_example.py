"""The example of fmu-export, packed by cargo-fmu: schema, rules, runs against the closed form, reset, saved states."""

import math

import fmpy
import numpy as np
import pytest
from conftest import FMU_DIR
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu


@pytest.fixture(scope="module")
def example():
    """The packed example; `cargo xtask test` leaves it beside the folder of the FMUs."""
    folder = FMU_DIR.parent / "fmu-examples"
    path = folder / "Oscillator.fmu"
    assert path.is_file(), f"cargo xtask pack --package fmu-oscillator --profile release --out {folder}"
    return str(path)


def closed_form(t, m, d, k, x0):
    """Free swing of the damped linear oscillator from rest at x0."""
    delta, w = d / (2 * m), math.sqrt(k / m - (d / (2 * m)) ** 2)
    return x0 * np.exp(-delta * t) * (np.cos(w * t) + delta / w * np.sin(w * t))


def test_rules_of_the_standard(example):
    assert validate_fmu(example) == []
    fmpy.read_model_description(example, validate=True, validate_variable_names=True, validate_model_structure=True)


def test_licences_lie_where_the_standard_wants_them(example):
    files = fmpy.extract(example)
    with open(f"{files}/documentation/licenses/license.txt") as text:
        assert text.readline() == "Licence: MIT OR Apache-2.0\n"


@pytest.mark.parametrize(
    "start_values, m, d", [({}, 2.0, 1.5), ({"parameter_file": "heavy.txt", "spring": 1}, 20.0, 4.5)], ids=["start values", "file"]
)
def test_free_swing(example, start_values, m, d):
    """RK4 at 1 ms misses 4e-11 of the amplitude (see the test of the model)."""
    result = fmpy.simulate_fmu(example, stop_time=5.0, output_interval=0.01, output=["x[1]"], start_values=start_values)
    np.testing.assert_allclose(result["x[1]"], closed_form(result["time"], m, d, 80.0, 0.1), rtol=0, atol=1e-10)


def test_reset_and_saved_states_repeat_bit_for_bit(example):
    description = fmpy.read_model_description(example)
    vr = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(example),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )

    def step(k):
        fmu.setReal([vr["F[1]"]], [math.sin(k)])
        fmu.doStep(k * 0.1, 0.1)
        return fmu.getReal([vr["x[1]"], vr["v[1]"], vr["a[1]"]])

    fmu.instantiate()
    runs = []
    for _ in range(2):
        fmu.setupExperiment(startTime=0.0, stopTime=1.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        first = [step(k) for k in range(5)]
        saved = fmu.serializeFMUstate(fmu.getFMUstate())
        runs.append(first + [step(k) for k in range(5, 10)])
        fmu.reset()
    assert runs[0] == runs[1]
    assert len(set(map(tuple, runs[0]))) == 10, "it does not move"
    fmu.setFMUstate(fmu.deSerializeFMUstate(saved))
    assert [step(k) for k in range(5, 10)] == runs[0][5:]
    assert fmu.getDirectionalDerivative([vr["a[1]"]], [vr["F[1]"]], [3.0]) == [1.5]
    fmu.terminate()
    fmu.freeInstance()


@pytest.fixture(scope="module")
def derived():
    """The packed example of the derives."""
    path = FMU_DIR.parent / "fmu-examples" / "Pendulum.fmu"
    assert path.is_file(), f"cargo xtask pack --package fmu-pendulum --profile release --out {path.parent}"
    return str(path)


def test_derived_variables_say_what_the_structs_say(derived):
    assert validate_fmu(derived) == []
    description = fmpy.read_model_description(
        derived, validate=True, validate_variable_names=True, validate_model_structure=True
    )
    rows = [
        (v.name, v.causality, v.variability, v.unit, v.displayUnit, v.start, v.min, v.description) for v in description.modelVariables
    ]
    assert rows == [
        ("length", "parameter", "fixed", "m", None, "1.5", "0.001", "Length of the rod"),
        ("mass", "parameter", "fixed", "kg", None, "2.0", "0.001", "Mass at its end"),
        ("friction", "parameter", "tunable", "N.m.s/rad", None, "0.25", "0.0", "Friction of the pivot"),
        ("torque", "input", "continuous", "N.m", None, "0.0", None, "Torque on the pivot"),
        ("angle", "output", "continuous", "rad", "deg", None, None, "Angle from hanging down"),
        ("speed", "output", "continuous", "rad/s", "deg/s", None, None, "Angular velocity"),
        ("energy", "output", "continuous", "J", None, None, None, "Kinetic and potential energy"),
        ("acceleration", "output", "continuous", "rad/s2", None, None, None, "Angular acceleration"),
        ("der(angle)", "local", "continuous", "rad/s", None, None, None, "Time derivative"),
        ("der(speed)", "local", "continuous", "rad/s2", None, None, None, "Time derivative"),
    ]
    assert description.description == "A pendulum with a torque on its pivot"


def test_derived_model_swings(derived):
    """Small swings are those of the damped linear oscillator, inertia m l^2, stiffness m g l: sin x is x - x^3/6, so the frequency is
    lower by x0^2/16 = 6e-6 of it, which in 10 s at 2.56 rad/s and an amplitude of 0.01 rad makes 1.6e-6 rad."""
    result = fmpy.simulate_fmu(derived, stop_time=10.0, output_interval=0.01, output=["angle"])
    linear = closed_form(result["time"], 2.0 * 1.5**2, 0.25, 2.0 * 9.80665 * 1.5, 0.01)
    np.testing.assert_allclose(result["angle"], linear, rtol=0, atol=1.6e-6)
    assert np.abs(result["angle"] - linear).max() > 1e-7, "the pendulum is linear"
    held = fmpy.simulate_fmu(
        derived, stop_time=1.0, output_interval=0.1, output=["acceleration"], start_values={"torque": 2.0 * 9.80665 * 1.5 * np.sin(0.01)}
    )
    np.testing.assert_allclose(held["acceleration"], 0.0, atol=1e-12)
