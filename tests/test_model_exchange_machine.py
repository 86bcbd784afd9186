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

    def run(self, end, parts, inputs=lambda t: {}, watch=None):
        """To the time `end`, or to where indicator `watch` changes sign: time and states."""
        x, h = self.x(), end / parts
        for k in range(parts):
            t, later = k * h, self.after(k * h, x, h, inputs)
            if watch is not None:
                sign = self.indicators(t, x, inputs)[watch] > 0
                if (self.indicators(t + h, later, inputs)[watch] > 0) != sign:
                    low, high = 0.0, h
                    while high - low > 1e-14 * (1 + t):
                        middle = (low + high) / 2
                        same = (self.indicators(t + middle, self.after(t, x, middle, inputs), inputs)[watch] > 0) == sign
                        low, high = (middle, high) if same else (low, middle)
                    later = self.after(t, x, high, inputs)
                    self.at(t + high, later, inputs)
                    self.model.completedIntegratorStep()
                    return t + high, later
            x = later
        self.at(end, x, inputs)
        self.model.completedIntegratorStep()
        return end, x


EMLA = {"v_q": 20.0, "v_d": -3.0, "x": 0.31, "x_dot": 0.02, "F_hold": 2e4}
FREE = {**EMLA, "drive": 2, "F_ext": 1.5e4}
HDRM = {f"zeta_dot_start[{i + 1}]": v for i, v in enumerate([0.1, -0.05, 0.08, 1.2, -0.9, 2.0])} | {"f[2]": 4e4, "f[3]": 3e4, "tau_wrist[2]": 50.0}
LINK = {"i_load[1]": 30.0, "i_load[2]": -5.0}
SMOOTH = {"emla": ("Emla", EMLA, 0.02), "free rod": ("Emla", FREE, 0.02), "hdrm": ("Hdrm", HDRM, 0.05), "link": ("DcLink", LINK, 0.02)}


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
    """At 10 us within 1e-6 of the peaks, and at fourth order (sixth: the link) where more than rounding is left."""
    name, values, end = SMOOTH[case]
    equations = Equations(opened, name, **values)
    start = equations.x()
    _, expected = equations.run(end, 200, moving_rod(values))
    errors = {h: relative(co_simulated(fmus, name, values, end, h, equations.states), expected, start) for h in (1e-3, 1e-5)}
    print(case, errors)
    assert errors[1e-5] <= 1e-6
    assert errors[1e-3] <= 1e-4
