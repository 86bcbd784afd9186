"""The interface of Hdrm.fmu, names and units, for a plant in Python behind pythonfmu.

Nothing that is not in the FMU is imported before initialization: there a package that is missing can be named.
"""

import json
import sys
from abc import abstractmethod
from math import isfinite
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String
from pythonfmu.enums import Fmi2Status

UNITS = {
    "1": {},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "J": {"kg": 1, "m": 2, "s": -2},
}

INPUTS = [
    ("f", 3, "N", "actuator forces of slew, lift and tilt, positive when pushing"),
    ("tau_wrist", 3, "N.m", "wrist torques; beyond the machine's limits they saturate"),
    ("wrench_env", 6, "N", "force (1 to 3) and moment (4 to 6) of the environment on the end-effector at T4 in T4 axes"),
]

OUTPUTS = [
    ("x", 3, "m", "strokes of slew, lift and tilt actuator"),
    ("x_dot", 3, "m/s", "rod velocities"),
    ("zeta", 6, "rad", "joint angles: slew, lift, tilt, wrist"),
    ("zeta_dot", 6, "rad/s", "joint rates"),
    ("zeta_ddot", 6, "rad/s2", "joint accelerations"),
    ("f_hold", 3, "N", "actuator forces that hold the start pose against gravity"),
    ("tip.position", 3, "m", "tip T4 in the world: x forward, y up, z = x cross y"),
    ("tip.orientation", 4, "1", "orientation of T4 in the world, unit quaternion w, x, y, z"),
    ("tip.velocity", 6, "m/s", "velocity (1 to 3) and angular velocity (4 to 6) of T4 in world axes"),
    ("energy.kinetic", None, "J", "kinetic energy"),
    ("energy.potential", None, "J", "potential energy of gravity, zero at the height of the world's origin"),
    ("energy.elastic", None, "J", "energy in bent members"),
    ("energy.loss", None, "J", "energy lost in joints and bent members since the start"),
]

# Moments and angular velocities in rows that begin with forces and velocities.
ANGULAR = {"wrench_env": "N.m", "tip.velocity": "rad/s"}


class Quantity(Real):
    """A real variable with a unit, which pythonfmu does not know."""

    def __init__(self, name, unit, **kwargs):
        super().__init__(name, **kwargs)
        self.unit = unit

    def to_xml(self):
        element = super().to_xml()
        element.find("Real").set("unit", self.unit)
        return element


class PlantFmu(Fmi2Slave):
    """A plant with the interface of Hdrm.fmu. Subclasses say which in `plant`, and may add to `PARAMETERS` and `OUTPUTS`."""

    INPUTS, OUTPUTS = INPUTS, OUTPUTS
    # name: (start value, unit, description); the start value's type is the variable's, and reals have a unit
    PARAMETERS = {
        "inertia_scale": (1.0, "1", "factor on mass, first moment and inertia of every body, payload included"),
        "machine_file": ("", None, "machine JSON to use instead of the embedded reference machine"),
    }

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {name: [0.0] * (size or 1) for name, size, _, _ in (*self.INPUTS, *self.OUTPUTS)}
        self.settings = {name: start for name, (start, _, _) in self.PARAMETERS.items()}
        for rows, causality in ((self.INPUTS, Fmi2Causality.input), (self.OUTPUTS, Fmi2Causality.output)):
            for name, size, unit, description in rows:
                for i in range(size or 1):
                    element = name if size is None else f"{name}[{i + 1}]"
                    of = ANGULAR[name] if name in ANGULAR and i >= 3 else unit
                    self._register(Quantity, element, self.values[name], i, causality, description, unit=of)
        for name, (start, unit, description) in self.PARAMETERS.items():
            kind, more = {float: (Quantity, {"unit": unit}), int: (Integer, {}), str: (String, {})}[type(start)]
            more["variability"] = Fmi2Variability.fixed
            self._register(kind, name, self.settings, name, Fmi2Causality.parameter, description, **more)

    def _register(self, kind, name, store, key, causality, description, **more):
        def put(value):
            store[key] = value

        get = lambda: store[key]
        self.register_variable(kind(name, causality=causality, description=description, getter=get, setter=put, **more))

    def to_xml(self, model_options=dict()):
        root = super().to_xml(model_options)
        units = Element("UnitDefinitions")
        for name, base in UNITS.items():
            SubElement(SubElement(units, "Unit", name=name), "BaseUnit", {k: str(v) for k, v in base.items()})
        root.insert(1, units)
        return root

    @abstractmethod
    def plant(self):
        """The plant in its start pose, with its `machine`, `step(forces, h, wrench)` and `outputs()`."""

    def machine(self):
        file = self.settings["machine_file"] or Path(self.resources, "reference_machine.json")
        return json.loads(Path(file).read_text())

    def enter_initialization_mode(self):
        try:
            self.model = self.plant()
        except ImportError as missing:
            version = ".".join(map(str, sys.version_info[:2]))
            text = f"{missing}: the Python {version} that runs {self.modelName}.fmu must find the packages mujoco and numpy (PYTHONPATH)"
            self.log(text, Fmi2Status.error)
            raise RuntimeError(text) from missing
        self._read()

    def do_step(self, current_time, step_size):
        values = self.values
        wrist = [max(-most, min(most, tau)) for tau, most in zip(values["tau_wrist"], self.model.machine["limits"]["tau_wrist_max"])]
        self.model.step(values["f"] + wrist, step_size, values["wrench_env"])
        self._read()
        return all(isfinite(number) for value in values.values() for number in value)

    def _read(self):
        for name, value in self.model.outputs().items():
            self.values[name][:] = map(float, value)
