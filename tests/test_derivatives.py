"""Directional derivatives, output derivatives and input derivatives against differences, and against JAX."""

import json
from pathlib import Path

import numpy as np
import pytest

GOLDEN = json.loads((Path(__file__).parent / "oracle/derivatives.json").read_text())["hdrm"]


@pytest.fixture(params=[0, 1, 2])
def moving(request, hdrm, emla):
    """Instances at a point inside a run that is different for each seed; by name, with sizes of their inputs."""
    random = np.random.default_rng(request.param)
    plant = hdrm.instance()
    plant.set({f"zeta_start[{i + 1}]": v for i, v in enumerate(random.uniform([-0.5, 0.2, -1.8, -1, -1.4, -1], [0.5, 0.9, -0.8, 1, -0.6, 1]))})
    plant.set({f"zeta_dot_start[{i + 1}]": v for i, v in enumerate(random.uniform(-0.3, 0.3, 6))})
    plant.set({f"f[{i + 1}]": v for i, v in enumerate(random.uniform(-3e4, 4e4, 3))})
    actuator = emla.instance()
    actuator.set({"x": 0.31, "x_dot": 0.02, "F_hold": random.uniform(1e4, 3e4), "v_q": random.uniform(5, 30), "v_d": -4.0})
    for instance in (plant, actuator):
        instance.start()
        instance.step(0.0, 1e-3)
    yield {"hdrm": plant, "emla": actuator}
    plant.free()
    actuator.free()


SIZES = {"f": 1e4, "tau_wrist": 100.0, "wrench_env": 100.0, "v_d": 10.0, "v_q": 10.0, "x": 1e-4, "x_dot": 1e-3, "F_ext": 1e4, "F_hold": 1e4, "v_dc": 10.0, "T_ambient": 10.0, "base.acceleration": 1.0, "base.tilt": 0.1, "base.angular_velocity": 0.1, "base.angular_acceleration": 0.1}  # fmt: skip


def reals(instance, causality):
    return [n for n in instance.fmu.names(causality) if instance.fmu.variables[n].type == "Real"]


def continuous_inputs(instance):
    """A load acts at the beginning of a step: nothing follows it at once."""
    return [n for n in reals(instance, "input") if instance.fmu.variables[n].variability == "continuous"]


def worst(found, expected, scale):
    """Largest difference relative to the largest magnitude of each output."""
    return max(abs(a - b) / s for a, b, s in zip(found, expected, scale))


@pytest.mark.parametrize("name", ["hdrm", "emla"])
def test_directional_derivatives(moving, name):
    """Against central differences over each input: their truncation is below 1e-5 of the change where outputs bend
    (losses), rounding below 1e-8 of the value."""
    instance = moving[name]
    outputs = reals(instance, "output")
    for known in continuous_inputs(instance):
        step, here = 1e-3 * SIZES[known.split("[")[0]], instance.get(known)
        if name == "emla" and known == "x":  # the rod has moved on since x was set
            here = instance.get("x_rod")
        sides = []
        for sign in (1, -1):
            instance.set({known: here + sign * step})
            sides.append(np.array(instance.get(*outputs)))
        instance.set({known: here})
        difference = (sides[0] - sides[1]) / 2
        exact = np.array(instance.directional(outputs, {known: step}))
        scale = 1e-5 * np.abs(difference) + 1e-9 * np.abs(sides[0]) + 1e-14
        assert (np.abs(exact - difference) <= scale).all(), [(known, *t) for t in zip(outputs, exact, difference) if t[1] != t[2]]


def test_directional_derivative_is_linear(moving):
    """Along a sum of inputs it is the sum; twice the same known adds up."""
    instance = moving["hdrm"]
    unknowns = [f"zeta_ddot[{i}]" for i in range(1, 7)]
    both = instance.directional(unknowns, {"f[2]": 3.0, "tau_wrist[1]": -2.0})
    one, other = instance.directional(unknowns, {"f[2]": 3.0}), instance.directional(unknowns, {"tau_wrist[1]": -2.0})
    np.testing.assert_allclose(both, np.add(one, other), rtol=1e-12, atol=1e-15)
    assert np.abs(both).min() > 0


@pytest.mark.parametrize("name", ["hdrm", "emla"])
def test_output_derivatives(moving, name):
    """Against the next samples: y(h) - y(0) = h y' + O(h^2) with inputs changing at a given rate; Richardson over h and
    h/2 leaves O(h^2)."""
    instance = moving[name]
    # Means start anew with each step; what the network says is discrete, evaluated once a step.
    outputs = [o for o in reals(instance, "output") if not o.endswith("_mean") and instance.fmu.variables[o].variability == "continuous"]
    inputs = [i for i in continuous_inputs(instance) if i not in ("x", "F_hold")]
    rates = {i: SIZES[i.split("[")[0]] * r for i, r in zip(inputs, np.random.default_rng(5).uniform(-1, 1, len(inputs)))}
    if name == "emla":
        rates["x"] = instance.get("x_dot")  # the motion must be one
    instance.set_derivatives(rates)
    exact, start = np.array(instance.derivatives(*outputs)), np.array(instance.get(*outputs))
    state, ends, h = instance.save(), {}, 1e-5
    for part in (1, 2, 4):
        instance.step(1e-3, h / part)
        ends[part] = (np.array(instance.get(*outputs)) - start) * part / h
        instance.restore(state)
    first, second = 2 * ends[2] - ends[1], 2 * ends[4] - ends[2]
    estimate = (4 * second - first) / 3
    scale = np.abs(estimate) * 1e-4 + np.abs(start) * 1e-15 * 64 / h + 1e-9
    bad = [(o, a, b) for o, a, b, s in zip(outputs, exact, estimate, scale) if abs(a - b) > s]
    assert not bad
    assert np.count_nonzero(exact) > len(outputs) / 2


def elements(values):
    """One entry for each element of the arrays: the FMU's names."""
    single = {n: v for n, v in values.items() if np.ndim(v) == 0}
    return single | {f"{n}[{i + 1}]": x for n, v in values.items() if np.ndim(v) for i, x in enumerate(v)}


def agree(found, expected):
    """Each output's vector to 1e-11 of its largest element. A linear solve with a mass matrix of condition 1e4 rounds to
    1e4 * 2e-16, and the rate of an acceleration needs two of them; a forgotten term is larger by some orders."""
    for name in {n.split("[")[0] for n in expected}:
        pairs = [(a, b) for a, (n, b) in zip(found, expected.items()) if n.split("[")[0] == name]
        found_vector, vector = np.array(pairs).T
        assert np.abs(found_vector - vector).max() <= 1e-11 * np.abs(vector).max(), (name, pairs)


@pytest.mark.parametrize("case", range(len(GOLDEN["cases"])))
def test_derivatives_of_the_manipulator_equal_those_of_jax(hdrm, case):
    """Against automatic differentiation of the Lagrangian (oracle/derivatives.py) at random states."""
    golden = GOLDEN["cases"][case]
    instance = hdrm.instance()
    instance.set({"inertia_scale": GOLDEN["inertia_scale"], "payload.mass": GOLDEN["payload.mass"]})
    instance.set(elements({n: golden[n] for n in ("zeta_start", "zeta_dot_start")} | golden["u"]))
    instance.start()
    along, rate = elements(golden["along"]), elements(golden["rate"])
    agree(instance.directional(list(along), elements(golden["du"])), along)
    instance.set_derivatives(elements(golden["u_dot"]))
    # A quaternion and its negative are the same orientation.
    sign = np.sign(instance.get("tip.orientation[1]"))
    agree([sign * v if "orientation" in n else v for n, v in zip(rate, instance.derivatives(*rate))], rate)
    instance.free()


def swung(hdrm, h, order, until=0.5):
    """Joint angles after forces that follow sines; inputs sampled at each communication point with `order` derivatives."""
    instance, w = hdrm.running(), 2 * np.pi * 1.3
    mean, swing = {"f[1]": 0.0, "f[2]": 41e3, "f[3]": 31e3}, 4e3
    for k in range(round(until / h)):
        t = k * h
        instance.set({n: v + swing * np.sin(w * t) for n, v in mean.items()})
        if order:
            instance.set_derivatives({n: swing * w * np.cos(w * t) for n in mean})
        instance.step(t, h)
    angles = np.array(instance.get(*(f"zeta[{i}]" for i in range(1, 7))))
    instance.free()
    return angles


def test_input_derivatives_raise_the_order_of_the_coupling(hdrm):
    """Held inputs leave a coupling error of first order in the communication step, with first derivatives of second."""
    exact = swung(hdrm, 1.25e-4, order=1)
    errors = {o: [np.abs(swung(hdrm, h, o) - exact).max() for h in (8e-3 / 3.2, 4e-3 / 3.2)] for o in (0, 1)}
    held, slopes = (np.log2(errors[o][0] / errors[o][1]) for o in (0, 1))
    assert held == pytest.approx(1, abs=0.15)
    assert slopes == pytest.approx(2, abs=0.2)
    assert errors[1][1] < 0.02 * errors[0][1]


def test_a_derivative_counts_for_one_step_only(hdrm):
    """FMI 2.0: derivatives are for the next fmi2DoStep. The value reached acts on; what was set is read back."""
    instance = hdrm.running()
    instance.set({"f[2]": 10e3})
    instance.set_derivatives({"f[2]": 1e6})
    instance.step(0.0, 1e-3)
    assert instance.get("f[2]") == 10e3
    state, accelerations = instance.save(), [f"zeta_ddot[{i}]" for i in range(1, 7)]
    reached = instance.get(*accelerations)
    instance.step(1e-3, 1e-3)
    held = instance.get("zeta[2]")
    instance.restore(state)
    instance.set({"f[2]": 11e3})
    assert instance.get(*accelerations) == pytest.approx(reached, rel=1e-12)
    instance.step(1e-3, 1e-3)
    assert instance.get("zeta[2]") == pytest.approx(held, rel=1e-15)
    instance.free()


def test_force_of_the_actuator_is_for_the_new_time(emla):
    """After a step and before x is set again, F refers to the rod moved on with its velocity, not to the old x; x is read as it was set."""
    moved, told = (emla.instance().start(0.0, {"x": 0.3, "x_dot": 0.06, "F_hold": 2e4}) for _ in range(2))
    for instance in (moved, told):
        instance.step(0.0, 1e-3)
    told.set({"x": 0.3 + 0.06e-3})
    assert moved.get("F") == pytest.approx(told.get("F"), rel=1e-9)
    assert moved.get("x") == 0.3
    told.set({"x": 0.3})
    assert abs(moved.get("F") - told.get("F")) > 5e3
