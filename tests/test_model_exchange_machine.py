"""Model Exchange of Emla, Hdrm and DcLink: the equations against Co-Simulation of the same library, events against closed forms and
against an extrapolation method that knows nothing of them, and FMPy's CVode in both versions.

The reference is the modified midpoint rule, extrapolated over 2, 4, ... 12 parts: order 12, so what is left is rounding."""

from ctypes import POINTER, c_double, cast
from functools import cache

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model
from fmpy.model_description import read_model_description

FOLDERS = {2: "", 3: "fmi3/"}


@pytest.fixture(scope="module")
def opened(fmu_dir, tmp_path_factory):
    """Description and folder of an FMU by name and version."""

    @cache
    def of(name, version):
        path, folder = fmu_dir / f"{FOLDERS[version]}{name}.fmu", tmp_path_factory.mktemp(f"{name}{version}")
        fmpy.extract(str(path), str(folder))
        return read_model_description(str(path)), str(folder)

    return of


def real(values):
    return cast(values.ctypes.data, POINTER(c_double))


class Equations:
    """An instance of FMI 2.0 for Model Exchange, in Continuous-Time Mode after `event`."""

    def __init__(self, opened, name, **values):
        description, folder = opened(name, 2)
        self.variables = {v.name: v for v in description.modelVariables}
        self.states = [d.variable.derivative.name for d in description.derivatives]
        self.n, self.z = description.numberOfContinuousStates, np.empty(description.numberOfEventIndicators)
        self.names = [v.name for v in description.modelVariables if v.name.startswith("event.")]
        self.model = FMU2Model(
            guid=description.guid, modelIdentifier=description.modelExchange.modelIdentifier, unzipDirectory=folder, instanceName=name
        )
        self.model.instantiate()
        self.model.setupExperiment(startTime=0.0)
        self.set(**values)
        self.model.enterInitializationMode()
        self.model.exitInitializationMode()
        self.next = self.event(entered=True)

    def set(self, **values):
        for name, value in values.items():
            variable = self.variables[name.replace("__", ".")] if "[" not in name else self.variables[name]
            kind = {"Enumeration": "Integer"}.get(variable.type, variable.type)
            getattr(self.model, f"set{kind}")([variable.valueReference], [value])

    def get(self, *names):
        found = [getattr(self.model, f"get{self.variables[n].type}")([self.variables[n].valueReference])[0] for n in names]
        return found[0] if len(found) == 1 else found

    def event(self, entered=False, **values):
        """Event Mode and back; the next time event."""
        if not entered:
            self.model.enterEventMode()
        self.set(**values)
        again = True
        while again:
            again, _, _, _, defined, at = self.model.newDiscreteStates()
        self.model.enterContinuousTimeMode()
        return at if defined else None

    def x(self):
        x = np.empty(self.n)
        self.model.getContinuousStates(real(x), self.n)
        return x

    def at(self, t, x, inputs):
        self.model.setTime(t)
        self.set(**inputs(t))
        self.model.setContinuousStates(real(x), self.n)

    def rates(self, t, x, inputs):
        self.at(t, x, inputs)
        dx = np.empty(self.n)
        self.model.getDerivatives(real(dx), self.n)
        return dx

    def indicators(self, t, x, inputs):
        self.at(t, x, inputs)
        self.model.getEventIndicators(real(self.z), len(self.z))
        return self.z.copy()

    def after(self, t, x, h, inputs):
        """States a time `h` later, where nothing happens between."""
        table = []
        for n in range(2, 14, 2):
            d = h / n
            old, new = x, x + d * self.rates(t, x, inputs)
            for k in range(1, n):
                old, new = new, old + 2 * d * self.rates(t + k * d, new, inputs)
            row = [(old + new + d * self.rates(t + h, new, inputs)) / 2]
            for k, last in enumerate(table):
                ratio = (n / (n - 2 * (k + 1))) ** 2
                row.append(row[k] + (row[k] - last) / (ratio - 1))
            table = row
        return table[-1]

    def run(self, end, step, inputs=lambda t: {}, begin=0.0):
        """From `begin` to `end`, or to just behind where an indicator changes sign: time, states and the indicators that did."""
        t, x = begin, self.x()
        parts = max(1, round((end - begin) / step))
        h, signs = (end - begin) / parts, self.indicators(t, x, inputs) > 0
        changed = lambda t, x: np.flatnonzero((self.indicators(t, x, inputs) > 0) != signs)
        which = []
        for k in range(parts):
            t = begin + k * h
            later = self.after(t, x, h, inputs)
            if len(which := changed(t + h, later)):
                low, high = 0.0, h
                while high - low > 4e-16 * (end + h) and low < (middle := (low + high) / 2) < high:
                    low, high = (low, middle) if len(changed(t + middle, self.after(t, x, middle, inputs))) else (middle, high)
                later = self.after(t, x, high, inputs)
                t, x, which = t + high, later, changed(t + high, later)
                break
            t, x = (end if k + 1 == parts else t + h), later
        self.at(t, x, inputs)
        self.model.completedIntegratorStep()
        return t, x, list(which)

    def events(self, end, step, inputs=lambda t: {}, begin=0.0):
        """Runs to the end; what happened on the way: times and names of indicators."""
        t, found = begin, []
        while t < end:
            goal = end if self.next is None else min(end, self.next)
            t, _, which = self.run(goal, step, inputs, t)
            if which or t == self.next:
                found += [(t, self.names[k]) for k in which] or [(t, "time")]
                self.next = self.event()
        return found


EMLA = {"v_q": 40.0, "v_d": -3.0, "x": 0.31, "x_dot": 0.02, "F_hold": 2e4}
FREE = {**EMLA, "drive": 2, "F_ext": 1.5e4}
HDRM = {f"zeta_dot_start[{i + 1}]": v for i, v in enumerate([0.1, -0.05, 0.08, 1.2, -0.9, 2.0])} | {"f[2]": 4e4, "f[3]": 3e4, "tau_wrist[2]": 50.0}
LINK = {"i_load[1]": 30.0, "i_load[2]": -5.0}
# FMU, values, end, step of the reference
SMOOTH = {
    "emla": ("Emla", EMLA, 0.02, 1e-4),
    "free rod": ("Emla", FREE, 0.02, 1e-4),
    "hdrm": ("Hdrm", HDRM, 0.05, 5e-3),
    "link": ("DcLink", LINK, 0.02, 1e-3),
}


def moving_rod(values):
    """The rod's signals: Co-Simulation moves `x` on with `x_dot` by itself."""
    if "x" not in values or "drive" in values:
        return lambda t: {}
    return lambda t: {"x": values["x"] + values["x_dot"] * t}


def co_simulated(fmus, name, values, end, h, states):
    instance = fmus[f"{name}.fmu"].instance()
    instance.start(values=values)
    steps = round(end / h)
    for k in range(steps):
        instance.step(k * h, h)
    found = np.array(instance.get(*states))
    instance.free()
    return found


def relative(found, expected, start):
    """Largest difference in terms of the state's size or its way, which is its peak in these monotone runs; of states that move."""
    size = np.maximum(np.abs(expected), np.abs(expected - start))
    moves = size > 0
    return np.max(np.abs(found - expected)[moves] / size[moves])


@pytest.mark.parametrize("case", SMOOTH)
def test_co_simulation_converges_to_model_exchange(opened, fmus, case):
    """At 10 us within 1e-6 of the peaks; from 1 ms on at least as the fourth power of the step, where more than rounding is left."""
    name, values, end, step = SMOOTH[case]
    equations = Equations(opened, name, **values)
    start = equations.x()
    _, expected, which = equations.run(end, step, moving_rod(values))
    assert which == []
    error = lambda h: relative(co_simulated(fmus, name, values, end, h, equations.states), expected, start)
    coarse, fine = error(1e-3), error(1e-5)
    print(case, coarse, fine)
    assert fine <= 1e-6 and coarse <= 1e-3


def test_the_residual_is_held_over_a_step(opened, fmus):
    """With alpha > 0 a Co-Simulation step holds the network's residual: half the step, half the error."""
    values = {**EMLA, "alpha": 0.5}
    equations = Equations(opened, "Emla", **values)
    start = equations.x()
    _, expected, which = equations.run(0.02, 1e-4, moving_rod(values))
    assert which == []
    error = lambda h: np.abs(co_simulated(fmus, "Emla", values, 0.02, h, ["w_m"]) - expected[3])
    errors = [error(h) for h in (4e-4, 2e-4, 1e-4)]
    ratios = [a / b for a, b in zip(errors, errors[1:])]
    print(errors, ratios, start[3])
    assert all(1.8 < ratio < 2.2 for ratio in ratios)


FLAT = {f"battery.ocv[{k}]": 3.3 for k in range(1, 22)} | {"battery.R_1": 0.0}  # no RC pair: the circuit is a capacitor behind a resistor
OPEN, C = 200 * 3.3, 12e-3


def test_precharge_ends_when_the_capacitor_is_charged(opened):
    link = Equations(opened, "DcLink", **FLAT, **{"precharge.on": True})
    R = 0.12 + 0.02 + 50.0
    passed = lambda share: -R * C * np.log(1 - share)
    found = link.events(passed(0.95) + 1e-6, 0.05)
    assert [name for _, name in found] == ["event.undervoltage", "event.ready"]
    assert [t for t, _ in found] == pytest.approx([passed(450 / OPEN), passed(0.95)], abs=1e-9)
    assert link.get("ready", "precharging") == [True, False]


def test_the_chopper_switches_at_its_thresholds(opened):
    """A pack that takes nothing, and drives that give back 20 A: the voltage rises as a line, and falls through 20 Ohm."""
    link = Equations(opened, "DcLink", **FLAT, **{"battery.charge_limit": 0.0, "i_load[1]": -20.0})
    rise = lambda a, b: (b - a) * C / 20
    on = rise(OPEN, 750)
    fall = 20.0 * C * np.log((750 - 400) / (730 - 400))
    expected = [(0.0, "limit"), (on, "chopper"), (on + fall, "chopper"), (on + fall + rise(730, 750), "chopper")]
    found = link.events(0.09, 1e-3)
    assert [name for _, name in found] == [f"event.{name}" for _, name in expected]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in expected], abs=1e-9)
    assert link.get("braking", "limited") == [True, True]
    brake, load, loss, battery, stored = link.get("energy.brake", "energy.load", "energy.loss", "energy.battery", "energy.stored")
    assert brake > 1.0 and battery == pytest.approx(load + brake + loss + stored - C * OPEN**2 / 2, abs=1e-9 * stored)


def test_an_overvoltage_is_met_where_no_chopper_is(opened):
    link = Equations(opened, "DcLink", **FLAT, **{"battery.charge_limit": 0.0, "i_load[1]": -20.0, "brake.fitted": False})
    found = link.events(0.15, 1e-3)
    assert [name for _, name in found] == ["event.limit", "event.overvoltage"]
    assert found[1][0] == pytest.approx((850 - OPEN) * C / 20, abs=1e-9)


def test_a_pack_that_gives_nothing_empties_the_capacitor(opened):
    link = Equations(opened, "DcLink", **FLAT, **{"battery.discharge_limit": 0.0, "i_load[1]": 20.0})
    found = link.events(0.45, 5e-3)
    assert [name for _, name in found] == [f"event.{name}" for name in ("limit", "undervoltage", "empty")]
    assert [t for t, _ in found] == pytest.approx([0.0, (OPEN - 450) * C / 20, OPEN * C / 20], abs=1e-9)
    assert link.get("v_dc", "undervoltage") == [0.0, True]
    link.event(**{"i_load[1]": -20.0})
    t, x, which = link.run(0.5, 5e-3, begin=0.45)
    assert which == [] and link.get("v_dc") == pytest.approx(0.05 * 20 / C, rel=1e-12)


WRIST = {"gravity[2]": 0.0, "wrist": True, "tau_wrist[1]": 900.0}


def bisected(f, low, high):
    """Where f passes from negative to positive."""
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if f(middle) > 0 else (middle, high)
    return high


def test_a_motor_of_the_wrist_breaks_away_and_crosses_its_play(opened):
    """The torque 900 (1 - e^(-t/T)) N.m exceeds 80 N.m of dry friction; from then on the motor runs freely until half of the play is
    crossed, while the joint rests."""
    T, friction, J, half = 5e-3, 80.0, 10.0, 0.1 * np.pi / 180
    hdrm = Equations(opened, "Hdrm", **WRIST)
    t_0 = -T * np.log(1 - friction / 900)
    rate = lambda t: ((900 - friction) * (t - t_0) + 900 * T * (np.exp(-t / T) - np.exp(-t_0 / T))) / J
    angle = lambda t: (
        (900 - friction) * (t - t_0) ** 2 / 2 - 900 * T**2 * (np.exp(-t / T) - np.exp(-t_0 / T)) - 900 * T * np.exp(-t_0 / T) * (t - t_0)
    ) / J
    t_1 = bisected(lambda t: angle(t) - half, t_0, 0.1)
    found = hdrm.events(t_1 + 1e-6, 1e-3)
    assert [name for _, name in found] == ["event.friction_1", "event.play_1"]
    assert [t for t, _ in found] == pytest.approx([t_0, t_1], abs=1e-9)
    assert hdrm.get("wrist.rate[1]") == pytest.approx(rate(t_1), rel=1e-3)


def test_a_motor_of_the_wrist_comes_to_rest(opened, fmus):
    """The command falls below the friction: the motor is braked until it stands, and stays. Time stepping takes 50 us at a time."""
    hdrm = Equations(opened, "Hdrm", **WRIST)
    hdrm.events(8e-3, 1e-3)
    hdrm.next = hdrm.event(**{"tau_wrist[1]": 0.0})
    t, found = 8e-3, []
    while t < 0.2 and "event.friction_1" not in found:
        t, _, which = hdrm.run(0.2, 5e-4, begin=t)
        found += [hdrm.names[k] for k in which]
        hdrm.event()
    assert "event.friction_1" in found and hdrm.get("wrist.rate[1]") == 0.0
    stepped = fmus["Hdrm.fmu"].instance()
    stepped.start(values=WRIST)
    for k in range(round(t / 2e-5)):
        if k == 400:
            stepped.set({"tau_wrist[1]": 0.0})
        stepped.step(k * 2e-5, 2e-5)
    assert stepped.get("wrist.rate[1]") == pytest.approx(0.0, abs=0.01)
    assert stepped.get("wrist.angle[1]") == pytest.approx(hdrm.get("wrist.angle[1]"), abs=2e-4)
    stepped.free()


def test_a_push_comes_at_its_times_and_a_load_when_it_is_set(opened, fmus):
    """Against Co-Simulation, whose steps begin at the same times."""
    values = HDRM | {"push.start": 0.012, "push.duration": 0.02, "push.force[1]": 900.0, "push.force[3]": -400.0, "load.moves_with_tip": False}
    hdrm = Equations(opened, "Hdrm", **values)
    found = hdrm.events(0.04, 4e-3)
    assert found == [(0.012, "time"), (0.012 + 0.02, "time")]
    before = hdrm.get("zeta_dot[6]")
    assert hdrm.event(**{"load.mass": 120.0}) is None
    assert abs(hdrm.get("zeta_dot[6]") - before) > 1e-3, "the impact"
    _, expected, _ = hdrm.run(0.05, 2e-3, begin=0.04)
    stepped = fmus["Hdrm.fmu"].instance()
    stepped.start(values=values)
    for k in range(500):
        if k == 400:
            stepped.set({"load.mass": 120.0})
        stepped.step(k * 1e-4, 1e-4)
    assert stepped.get(*hdrm.states) == pytest.approx(expected, rel=1e-7, abs=1e-10)
    assert hdrm.get("energy.load") == pytest.approx(stepped.get("energy.load"), rel=1e-9)
    stepped.free()


FRICTIONLESS = {f"joint_viscous[{i}]": 0.0 for i in range(1, 7)}


def test_the_tip_meets_the_plane_and_energy_is_kept(opened):
    """A machine that falls: kinetic, potential and elastic energy and the heat of the contact are what there was at the start."""
    height = Equations(opened, "Hdrm").get("tip.position[2]")
    plane = {"contact.stiffness": 2e6, "contact.offset": height - 0.02, "contact.friction": 0.3}
    hdrm = Equations(opened, "Hdrm", **FRICTIONLESS, **plane)
    energy = lambda: sum(hdrm.get("energy.kinetic", "energy.potential", "energy.contact", "energy.contact_loss"))
    start = energy()
    t, _, which = hdrm.run(0.2, 2e-3)
    assert [hdrm.names[k] for k in which] == ["event.contact"]
    assert hdrm.get("tip.position[2]") == pytest.approx(height - 0.02, abs=1e-12)
    hdrm.event()
    later, _, which = hdrm.run(t + 0.02, 5e-5, begin=t)
    assert hdrm.get("contact.penetration" if not which else "energy.contact_loss") > 1e-6
    assert hdrm.get("energy.kinetic") > 10.0
    assert energy() == pytest.approx(start, abs=1e-9 * abs(start))


@pytest.mark.parametrize("joint, name", [(1, "slew"), (2, "lift"), (3, "tilt"), (4, "wrist_1"), (5, "wrist_2"), (6, "wrist_3")])
def test_end_stops_are_met(opened, fmus, joint, name):
    """From just before a stop, with 0.5 rad/s: found where the distance is none, left again, and as Co-Simulation has it."""
    machine = Equations(opened, "Hdrm")
    x = machine.x()
    start = x[joint - 1]

    def distance(zeta):
        x[joint - 1] = zeta
        return machine.indicators(0.0, x, lambda t: {})[machine.names.index(f"event.stop_{name}")]

    way = 1.0 if distance(start + 1e-3) < distance(start) else -1.0
    end = bisected(lambda s: -distance(start + way * s), 0.0, 7.0)
    values = {f"zeta_start[{joint}]": start + way * (end - 5e-3), f"zeta_dot_start[{joint}]": 0.5 * way}
    hdrm = Equations(opened, "Hdrm", **values)
    t, _, which = hdrm.run(0.05, 1e-3)
    assert [hdrm.names[k] for k in which] == [f"event.stop_{name}"]
    assert hdrm.get(f"zeta[{joint}]") == pytest.approx(start + way * end, abs=1e-12)
    hdrm.event()
    hdrm.events(0.02, 2e-4, begin=t)
    stepped = co_simulated(fmus, "Hdrm", values, 0.02, 2e-5, hdrm.states)
    assert stepped == pytest.approx(hdrm.x(), rel=1e-5, abs=1e-7)


def test_undervoltage_trips_where_the_voltage_passes_it(opened):
    """The link's voltage falls as a line: the time is known, and so is what follows."""
    emla = Equations(opened, "Emla", **EMLA, undervoltage=600.0)
    emla.stored = emla.get("energy.stored")
    inputs = lambda t: {"v_dc": 650.0 - 1e4 * t, "x": 0.31 + 0.02 * t}
    t, _, which = emla.run(0.01, 1e-4, inputs)
    assert [emla.names[k] for k in which] == ["event.undervoltage"] and t == pytest.approx(5e-3, abs=1e-9)
    assert emla.get("i_q") > 1.0
    emla.event()
    assert emla.get("tripped", "i_d", "i_q") == [True, 0.0, 0.0]
    balanced(emla)


def balanced(emla):
    """energy.in = energy.out + energy.shift + energy.loss + rise of energy.stored, to the rounding of what is stored."""
    came, left, shift, lost, stored = emla.get("energy.in", "energy.out", "energy.shift", "energy.loss", "energy.stored")
    assert came - left - shift - lost == pytest.approx(stored - emla.stored, abs=1e-8 * stored)


def test_a_brake_slips_until_the_shaft_rests_and_holds_it(opened):
    """Speed and torque change their signs on the way; energy is kept through all of it."""
    values = {**FREE, "F_ext": 2e4}
    emla = Equations(opened, "Emla", **values)
    emla.stored = emla.get("energy.stored")
    t, _, which = emla.run(0.01, 1e-4)
    assert which == [] and emla.get("w_m") > 1.0
    emla.event(brake=True, v_d=0.0, v_q=0.0)
    names = []
    while t < 0.2 and emla.get("w_m") != 0.0:
        t, _, which = emla.run(0.2, 1e-4, begin=t)
        names += [emla.names[k] for k in which]
        emla.event()
    assert {"event.speed", "event.brake"} & set(names) and emla.get("w_m") == 0.0
    balanced(emla)
    t, _, _ = emla.run(t + 0.005, 1e-4, begin=t)
    assert emla.get("w_m") == 0.0, "held"
    emla.event(brake=False, v_q=-60.0)
    names = [name for _, name in emla.events(t + 0.03, 1e-4, begin=t)]
    emla.event(v_q=60.0)
    names += [name for _, name in emla.events(t + 0.06, 1e-4, begin=t + 0.03)]
    assert {"event.speed", "event.torque"} <= set(names), names
    balanced(emla)


def test_the_load_changes_its_sign(opened, fmus):
    """A rod that moves on while the motor is driven back: the gear factor jumps, and the inertia with it. RK4 of Co-Simulation does
    not stop there; 10 us keep its error below 1e-5."""
    values = {**EMLA, "v_q": -60.0, "F_hold": 4e3}
    emla = Equations(opened, "Emla", **values)
    emla.stored = emla.get("energy.stored")
    found = [name for _, name in emla.events(0.02, 1e-4, moving_rod(values))]
    assert {"event.load", "event.torque", "event.speed"} <= set(found), found
    balanced(emla)
    stepped = co_simulated(fmus, "Emla", values, 0.02, 1e-5, emla.states)
    assert stepped == pytest.approx(emla.x(), rel=1e-5, abs=1e-5)


CVODE = {
    "Emla": (FREE, ["F", "i_q", "w_m", "x_rod", "energy.in", "energy.out", "energy.loss", "energy.stored"], 0.05),
    "Hdrm": ({"push.start": 0.05, "push.duration": 0.02}, ["energy.kinetic", "energy.potential", "energy.contact_loss"], 0.2),
    "DcLink": ({"precharge.on": True, "precharge.R": 5.0}, ["v_dc", "soc", "T_battery", "energy.loss", "energy.stored", "ready"], 0.5),
}


@pytest.mark.parametrize("name", CVODE)
def test_cvode_of_fmpy_gives_the_same_bits_in_both_versions(opened, name, fmu_dir):
    values, outputs, stop = CVODE[name]
    results = []
    for version in (2, 3):
        description, folder = opened(name, version)
        calls = [0]
        result = fmpy.simulate_fmu(
            folder,
            model_description=description,
            fmi_type="ModelExchange",
            start_values=values,
            output=outputs,
            stop_time=stop,
            output_interval=stop / 20,
            relative_tolerance=1e-8,
            record_events=True,
            fmi_call_logger=lambda call: calls.__setitem__(0, calls[0] + ("Derivatives" in call)),
        )
        print(name, version, len(result), "points", calls[0] / stop, "right-hand sides a second")
        results.append(result)
    two, three = results
    assert len(two) == len(three) > 20 and all(np.array_equal(two[n], three[n]) for n in ["time", *outputs])
