"""Model Exchange: the examples of the kit in FMPy, which integrates them with CVode and finds their events, in both versions of FMI."""

import math

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from conftest import FMU_DIR
from fmpy_master import ROOT
from native import cargo_fmu

EXAMPLES = {"Pendulum": "fmu-pendulum", "Oven": "fmu-oven"}


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """The archives by name and version."""
    out = tmp_path_factory.mktemp("exchange")
    for package in EXAMPLES.values():
        done = cargo_fmu("pack", "-p", package, "--profile", "release", "--out", out, cwd=ROOT, environment={"CARGO_TARGET_DIR": FMU_DIR.parent})
        assert done.returncode == 0, done.stderr
    done = cargo_fmu("pack", "--profile", "release", "--out", out, cwd=ROOT / "examples/battery")
    assert done.returncode == 0, done.stderr
    return {(name, version): str(out / folder / f"{name}.fmu") for name in [*EXAMPLES, "Battery"] for version, folder in [(2, ""), (3, "fmi3")]}


def simulate(path, kind="ModelExchange", tolerance=1e-10, **options):
    return fmpy.simulate_fmu(path, fmi_type=kind, relative_tolerance=tolerance, **options)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", [*EXAMPLES, "Battery"])
def test_rules_of_the_standard(packed, name, version):
    assert validate_fmu(packed[name, version]) == []
    description = fmpy.read_model_description(packed[name, version], validate=True, validate_variable_names=True, validate_model_structure=True)
    assert description.modelExchange.modelIdentifier == description.coSimulation.modelIdentifier == name
    states = {"Pendulum": 2, "Oven": 1, "Battery": 4}[name]
    assert (description.numberOfContinuousStates, description.numberOfEventIndicators) == (states, int(name == "Oven"))
    for unknown in description.derivatives:
        assert unknown.variable.name == f"der({unknown.variable.derivative.name})"


@pytest.mark.parametrize("version", [2, 3])
def test_the_importer_finds_the_events(packed, version):
    """Heated from 293.15 K towards 593.15 K with tau = 400 s, the oven passes 463.15 K after tau ln(300/130); then it cools to 453.15 K in
    tau ln(170/160) and is heated again in tau ln(140/130). CVode's root is as good as its states, 1e-10 of 300 K over the slope of
    0.4 K/s: 1e-7 s, and each of the eighteen times adds its own error."""
    result = simulate(packed["Oven", version], stop_time=800.0, output_interval=10.0, output=["temperature", "heating", "switchings"], record_events=True)
    rises = np.flatnonzero(np.diff(result["switchings"]) == 1)
    tau = 400.0
    expected, t = [], tau * math.log(300 / 130)
    while t < 800.0:
        expected.append(t)
        t += tau * math.log(170 / 160 if len(expected) % 2 else 140 / 130)
    found = result["time"][rises]
    assert len(expected) == 18
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-5)
    np.testing.assert_allclose(result["time"][rises + 1], found, rtol=0, atol=0, err_msg="an event takes no time")


@pytest.mark.parametrize("version", [2, 3])
def test_both_interfaces_find_the_same_oven(packed, version):
    """The step of Co-Simulation is the closed form."""
    runs = [
        simulate(packed["Oven", version], kind, stop_time=800.0, output_interval=10.0, output=["temperature", "switchings"], record_events=False)
        for kind in ("ModelExchange", "CoSimulation")
    ]
    for name, atol in [("temperature", 1e-5), ("switchings", 0)]:
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=0, atol=atol)


@pytest.mark.parametrize("version", [2, 3])
def test_the_battery_follows_the_closed_form(packed, version):
    """At a constant current the charge is a straight line and the RC pair an exponential; CVode errs by some 100 times its tolerance."""
    i, t = 80.0, 60.0
    result = simulate(packed["Battery", version], stop_time=t, output_interval=1.0, start_values={"i": i}, output=["v", "soc", "v_1"])
    assert result["soc"][-1] == pytest.approx(0.9 - i * t / (3600.0 * 50.0), abs=1e-8)
    assert result["v_1"][-1] == pytest.approx(0.8e-3 * i * -math.expm1(-t / (0.8e-3 * 2.0e4)), abs=1e-8)


def test_both_versions_are_the_same_bits(packed):
    for name in [*EXAMPLES, "Battery"]:
        two, three = [simulate(packed[name, version], stop_time=100.0, output_interval=0.5) for version in (2, 3)]
        assert two.dtype.names == three.dtype.names
        for column in two.dtype.names:
            assert np.array_equal(two[column], three[column]), (name, column)


def test_co_simulation_converges_to_model_exchange(packed):
    """The pendulum swings freely: there are no inputs that a step could hold, and 1 ms of Runge-Kutta errs by (w dt)^4/120 of the swing,
    3.6e-13. What differs is CVode's error: it falls with its tolerance, some 1e3 of it over ten seconds."""
    co = simulate(packed["Pendulum", 2], "CoSimulation", stop_time=10.0, output_interval=0.1, start_values={"length": 0.75}, output=["angle"])
    last = math.inf
    for tolerance in [1e-6, 1e-8, 1e-10]:
        exchange = simulate(packed["Pendulum", 2], tolerance=tolerance, stop_time=10.0, output_interval=0.1, start_values={"length": 0.75}, output=["angle"])
        error = np.abs(co["angle"] - exchange["angle"]).max()
        assert error < min(last / 10, 1e3 * tolerance), (tolerance, error)
        last = error


def test_an_input_steers_continuously(packed):
    """A torque that grows with time, T = a t, on the hanging pendulum: near rest the angle follows I x'' + d x' + m g l x = a t."""
    signals = np.array([(0.0, 0.0), (4.0, 0.4)], dtype=[("time", float), ("torque", float)])
    mass, friction, stiffness, slope = 2.0 * 1.5**2, 0.25, 2.0 * 9.80665 * 1.5, 0.1
    result = simulate(packed["Pendulum", 3], stop_time=4.0, output_interval=5e-4, input=signals, output=["angle"])
    delta = friction / (2 * mass)
    w = math.sqrt(stiffness / mass - delta**2)
    t = result["time"]
    # The particular solution is (a/k)(t - d/k); the rest swings from x = 0.01 + a d/k^2 with the speed -a/k.
    x0, v0 = 0.01 + slope * friction / stiffness**2, -slope / stiffness
    exact = slope / stiffness * (t - friction / stiffness) + np.exp(-delta * t) * (x0 * np.cos(w * t) + (v0 + delta * x0) / w * np.sin(w * t))
    # FMPy sets inputs once in an output interval h of 0.5 ms and holds them: a h / k is 1.7e-6 rad. And sin x is x - x^3/6: at 0.024 rad
    # the frequency is lower by x^2/16 = 3.6e-5, which makes 3.6e-5 * 10 rad * 0.01 rad = 3.6e-6 rad.
    np.testing.assert_allclose(result["angle"], exact, rtol=0, atol=5.3e-6)
