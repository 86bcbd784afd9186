"""A small controller without any model of the machine: cascaded position, speed and current loops for up to three rods,
PD loops for the wrist. Moves each rod by `distance` within `duration` on a smooth curve, after `delay`."""

import json
from pathlib import Path

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

POSITION_GAIN = 8.0  # 1/s
SPEED_BANDWIDTH = 60.0  # rad/s
SPEED_RESET = 15.0  # 1/s
CURRENT_GAIN = 0.9  # V/A
WRIST_STIFFNESS = np.array([6e4, 6e4, 1e4])  # N.m/rad
WRIST_DAMPING = np.array([6e3, 6e3, 1e3])  # N.m.s/rad

INPUTS = {"x": 3, "x_dot": 3, "i_d": 3, "i_q": 3, "w_m": 3, "zeta": 6, "zeta_dot": 6, "tau_hold": 3}
OUTPUTS = {"v_d": 3, "v_q": 3, "tau_wrist": 3, "x_error": 3}
PARAMETERS = {"distance": 3, "timing": 2}  # timing: delay, duration, s


def smooth(s):
    """Quintic from 0 to 1 and its slope."""
    s = min(max(s, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2


class RodController(Fmi2Slave):
    description = "Position control of linear actuators without a model of the machine"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {name: np.zeros(size) for name, size in {**INPUTS, **OUTPUTS, **PARAMETERS}.items()}
        self.values["timing"][:] = [0.5, 2.0]
        for names, causality in ((INPUTS, "input"), (OUTPUTS, "output"), (PARAMETERS, "parameter")):
            for name, size in names.items():
                for i in range(size):
                    self._register(name, i, Fmi2Causality[causality])

    def _register(self, name, i, causality):
        def put(value):
            self.values[name][i] = value

        options = {"variability": Fmi2Variability.tunable} if causality is Fmi2Causality.parameter else {}
        getter = lambda: float(self.values[name][i])
        self.register_variable(Real(f"{name}[{i + 1}]", causality=causality, getter=getter, setter=put, **options))

    def enter_initialization_mode(self):
        self.motor = json.loads(Path(self.resources, "reference_machine.json").read_text())["emla"]
        self.start = None

    def do_step(self, current_time, step_size):
        v = self.values
        if self.start is None:  # the first measurements
            self.start, self.pose = v["x"].copy(), v["zeta"][3:].copy()
            self.integral = v["i_q"].copy()
        delay, duration = v["timing"]
        part, slope = smooth((current_time - delay) / duration)
        x_ref, x_dot_ref = self.start + part * v["distance"], slope / duration * v["distance"]
        v["x_error"][:] = x_ref - v["x"]
        v["v_d"][:], v["v_q"][:] = self._voltages(x_dot_ref + POSITION_GAIN * v["x_error"], step_size)
        v["tau_wrist"][:] = (
            v["tau_hold"] + WRIST_STIFFNESS * (self.pose - v["zeta"][3:]) - WRIST_DAMPING * v["zeta_dot"][3:]
        )
        return True

    def _voltages(self, rod_speed, h):
        m, v = self.motor, self.values
        torque_constant = 1.5 * m["p"] * m["lambda_m"]
        gain = (m["J_m"] + m["J_s"] / m["N_gear"] ** 2) * SPEED_BANDWIDTH / torque_constant
        error = rod_speed * m["N_gear"] * 2 * np.pi / m["rho"] - v["w_m"]
        self.integral += h * SPEED_RESET * gain * error
        i_q = np.clip(gain * error + self.integral, -m["i_max"], m["i_max"])
        w_e = m["p"] * v["w_m"]
        v_d = -w_e * m["L_q"] * v["i_q"] - CURRENT_GAIN * v["i_d"]
        v_q = m["R_s"] * i_q + w_e * (m["lambda_m"] + m["L_d"] * v["i_d"]) + CURRENT_GAIN * (i_q - v["i_q"])
        return v_d, v_q
