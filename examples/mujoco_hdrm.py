"""The manipulator as a MuJoCo model behind pythonfmu: a third-party plant with the interface of Hdrm.fmu.

Built from the machine JSON alone. Both closed loops are MuJoCo `connect` constraints, so the geometry is a little soft where
Hdrm.fmu is exact; the strokes are computed from the boom angles.
"""

import json
from pathlib import Path

import mujoco
import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

SUBSTEP = 2.5e-4  # s


def turned(angle, p):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * p[0] - s * p[1], s * p[0] + c * p[1]])


def heading(d):
    return np.arctan2(d[1], d[0])


def plane(machine, zeta_2, zeta_3):
    """Boom plane: {body: (position, angle)} of its eleven bodies, and the lift and tilt strokes."""
    g = machine["geometry"]
    O, tilt = np.array(g["r_T1_O"][:2]), zeta_2 + zeta_3
    foot = O + g["L2_2"] * np.array([np.sin(g["beta1"]), -np.cos(g["beta1"])])
    pin = O + turned(zeta_2 - g["beta2"], [g["L1_2"], 0])
    B = O + turned(zeta_2, g["r_O_B"])
    A, E = (B + turned(zeta_2, g[k]) for k in ("A_in_boom", "E_in_boom"))
    C = B + turned(tilt, g["C_in_tilt"])
    D = meeting(A, g["d4"], C, g["d5"], B)
    lift, push = pin - foot, D - E
    c_2, c_3 = np.hypot(*lift), np.hypot(*push)
    frames = {
        "A2": (O, zeta_2 - g["beta2"]),
        "C2": (foot, heading(lift)),
        "D2": (foot + lift * (1 - g["lc_2"] / c_2), heading(lift)),
        "A3": (B, tilt),
        "C3": (E, heading(push)),
        "D3": (E + push * (1 - g["lc_3"] / c_3), heading(push)),
        "RK": (A, heading(D - A)),
        "CP": (C, heading(D - C)),
    }
    return frames, np.array([c_2 - g["x0_2"], c_3 - g["x0_3"]])


def meeting(a, ra, c, rc, away):
    """The point at ra from a and rc from c, on the side of the line ac away from a third point."""
    d = np.hypot(*(c - a))
    u = (c - a) / d
    n = np.array([-u[1], u[0]])
    t = (d**2 + ra**2 - rc**2) / (2 * d)
    return a + t * u - np.sign(n @ (away - a)) * np.sqrt(ra**2 - t**2) * n


def text(values):
    return " ".join(f"{v:.17g}" for v in values)


def mjcf(machine, scale):
    """The model with all joint coordinates zero in the start pose."""
    g, zeta = machine["geometry"], machine["start"]["zeta"]
    frames, _ = plane(machine, zeta[1], zeta[2])
    frames["T1"] = (np.zeros(2), 0.0)
    arm = np.add(g["r_B_B4"], g["r_B4_A4"])

    def inertial(name):
        b = machine["bodies"][name]
        inertia = [scale * b["inertia_com"][k] for k in ("xx", "yy", "zz", "xy", "xz", "yz")]
        return f'<inertial pos="{text(b["com"])}" mass="{scale * b["mass"]:.17g}" fullinertia="{text(inertia)}"/>'

    def body(name, place, joint, *children):
        return f'<body name="{name}" {place}>{joint}{inertial(name)}{"".join(children)}</body>'

    def planar(name, parent, joint, *children):
        (p, angle), (q, base) = frames[name], frames[parent]
        place = f'pos="{text([*turned(-base, p - q), 0])}" euler="0 0 {angle - base:.17g}"'
        return body(name, place, joint, *children)

    def hinge(name, axis, damping=0.0):
        return f'<joint name="{name}" axis="{axis}" damping="{damping:.17g}"/>'

    def rod(name):
        return f'<joint name="{name}" type="slide" axis="1 0 0"/>'

    v = machine["joint_viscous"]
    payload = body("PL", 'pos="0 0 0"', "")
    tip = f'<site name="tip" pos="{text(g["r_D4_T4"])}"/>'
    D4 = body("D4", f'pos="{text(g["r_C4_D4"])}" euler="{zeta[5]:.17g} 0 0"', hinge("zeta_6", "1 0 0", v[5]), payload, tip)
    C4 = body("C4", f'pos="{text(g["r_A4_C4"])}" euler="0 0 {zeta[4]:.17g}"', hinge("zeta_5", "0 0 1", v[4]), D4)
    A4 = body("A4", f'pos="{text(arm)}" euler="{zeta[3]:.17g} 0 0"', hinge("zeta_4", "1 0 0", v[3]), C4)
    A3 = planar("A3", "A2", hinge("zeta_3", "0 0 1", v[2]), A4, planar("CP", "A3", hinge("coupler", "0 0 1")))
    C3 = planar("C3", "A2", hinge("cylinder_3", "0 0 1"), planar("D3", "C3", rod("rod_3")))
    RK = planar("RK", "A2", hinge("rocker", "0 0 1"))
    A2 = planar("A2", "T1", hinge("zeta_2", "0 0 1", v[1]), A3, C3, RK)
    C2 = planar("C2", "T1", hinge("cylinder_2", "0 0 1"), planar("D2", "C2", rod("rod_2")))
    T1 = body("T1", 'pos="0 0 0"', hinge("zeta_1", "0 1 0", v[0]), A2, C2)
    pins = "".join(
        f'<connect body1="{a}" body2="{b}" anchor="{x:.17g} 0 0"/>'
        for a, b, x in (("D2", "A2", g["lc_2"]), ("D3", "RK", g["lc_3"]), ("D3", "CP", g["lc_3"]))
    )
    return f"""<mujoco>
      <compiler angle="radian" balanceinertia="false"/>
      <option gravity="0 {-machine["gravity"]} 0" timestep="{SUBSTEP}" jacobian="dense" iterations="50" tolerance="1e-12">
        <flag contact="disable"/>
      </option>
      <default><equality solref="{2 * SUBSTEP} 1" solimp="0.9999 0.9999 0.001 0.5 2"/></default>
      <worldbody>{T1}</worldbody>
      <equality>{pins}</equality>
    </mujoco>"""


class Plant:
    """The MuJoCo model with forces in and strokes out."""

    FORCED = ["zeta_1", "rod_2", "rod_3", "zeta_4", "zeta_5", "zeta_6"]

    def __init__(self, machine, scale):
        self.machine = machine
        self.m = mujoco.MjModel.from_xml_string(mjcf(machine, scale))
        self.d = mujoco.MjData(self.m)
        self.start = np.array(machine["start"]["zeta"])
        dofs = lambda names: [self.m.joint(name).dofadr[0] for name in names]
        self.forced, self.free = dofs(self.FORCED), dofs([f"zeta_{i}" for i in range(1, 7)])
        self.arm = np.array([machine["geometry"]["r_B"], 1, 1, 1, 1, 1])
        self.hold = self._hold()
        self.apply(self.hold)
        mujoco.mj_forward(self.m, self.d)

    def apply(self, forces):
        self.d.qfrc_applied[self.forced] = self.arm * forces

    def _hold(self):
        """Forces with which all accelerations vanish: these are affine in the forces."""

        def acceleration(forces):
            self.apply(forces)
            mujoco.mj_forward(self.m, self.d)
            return self.d.qacc[self.free].copy()

        rest = acceleration(np.zeros(6))
        unit = np.array([1e4, 1e4, 1e4, 100, 100, 100])
        change = np.column_stack([(acceleration(u) - rest) for u in np.diag(unit)])
        return unit * np.linalg.solve(change, -rest)

    def step(self, forces, h):
        self.apply(forces)
        count = max(1, round(h / SUBSTEP))
        self.m.opt.timestep = h / count
        for _ in range(count):
            mujoco.mj_step(self.m, self.d)
        mujoco.mj_forward(self.m, self.d)

    @property
    def zeta(self):
        return self.start + self.d.qpos[self.free]

    @property
    def zeta_dot(self):
        return self.d.qvel[self.free]

    def strokes(self):
        """Strokes, m, and rod velocities, m/s."""
        (z1, z2, z3), w, g, e = self.zeta[:3], self.zeta_dot, self.machine["geometry"], 1e-6
        at = lambda a, b: plane(self.machine, a, b)[1]
        slope = [(at(z2 + e, z3) - at(z2 - e, z3))[0] / (2 * e), (at(z2, z3 + e) - at(z2, z3 - e))[1] / (2 * e)]
        x = [g["x1_mid"] + g["r_B"] * z1, *at(z2, z3)]
        return np.array(x), np.array([g["r_B"] * w[0], slope[0] * w[1], slope[1] * w[2]])


class MujocoHdrm(Fmi2Slave):
    """FMU: inputs f, tau_wrist; outputs x, x_dot, zeta, zeta_dot, f_hold, tip.position; parameter inertia_scale."""

    description = "Manipulator in MuJoCo, with the interface of Hdrm"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {"f": np.zeros(3), "tau_wrist": np.zeros(3)}
        for name, size in {"x": 3, "x_dot": 3, "zeta": 6, "zeta_dot": 6, "f_hold": 3, "tip.position": 3}.items():
            self.values[name] = np.zeros(size)
        self.inertia_scale = 1.0
        for name, array in self.values.items():
            for i in range(len(array)):
                self._register(name, i, Fmi2Causality.input if name in ("f", "tau_wrist") else Fmi2Causality.output)
        fixed = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        self.register_variable(Real("inertia_scale", **fixed))

    def _register(self, name, i, causality):
        def put(value):
            self.values[name][i] = value

        self.register_variable(
            Real(f"{name}[{i + 1}]", causality=causality, getter=lambda: float(self.values[name][i]), setter=put)
        )

    def enter_initialization_mode(self):
        machine = json.loads(Path(self.resources, "reference_machine.json").read_text())
        self.plant = Plant(machine, self.inertia_scale)
        self._read()

    def do_step(self, current_time, step_size):
        self.plant.step(np.concatenate([self.values["f"], self.values["tau_wrist"]]), step_size)
        self._read()
        return bool(np.isfinite(self.plant.d.qpos).all())

    def _read(self):
        plant, values = self.plant, self.values
        values["x"][:], values["x_dot"][:] = plant.strokes()
        values["zeta"][:], values["zeta_dot"][:] = plant.zeta, plant.zeta_dot
        values["f_hold"][:] = plant.hold[:3]
        values["tip.position"][:] = plant.d.site_xpos[0]
