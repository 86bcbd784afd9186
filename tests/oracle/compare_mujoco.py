"""The manipulator as a MuJoCo model with closed loops, compared with the Lagrangian oracle.

    python tests/oracle/compare_mujoco.py

Loops are closed by `connect` constraints, which MuJoCo regularises (they are springs with a finite
impedance), so accelerations agree as far as that allows; the script prints how far.
"""

import json

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from lagrangian import GOLDEN, make
from mechanism import BODIES, solve


def inertial(body, factor):
    i = body["inertia_com"]
    full = [i[k] * factor for k in ("xx", "yy", "zz", "xy", "xz", "yz")]
    return (
        f'<inertial pos="{vector(body["com"])}" mass="{body["mass"] * factor:.17g}" '
        f'fullinertia="{vector(full)}"/>'
    )


def vector(values):
    return " ".join(f"{v:.17g}" for v in values)


def pose(world, parent, child):
    """pos and quat attributes of a child frame in its parent, both given in the world."""
    T = np.linalg.inv(parent) @ child
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).reshape(9))
    return f'pos="{vector(T[:3, 3])}" quat="{vector(quat)}"'


def model(plant):
    """MJCF in the pose zeta = middle of the joint range, where all loops are closed."""
    machine = plant["machine"]
    limits = machine["limits"]
    middle = np.radians(0.5 * (np.array(limits["zeta_min_deg"]) + limits["zeta_max_deg"]))
    poses, tip, _ = solve(machine, middle)
    world = dict(zip(BODIES, np.asarray(poses)))
    g = machine["geometry"]
    share = {name: plant["inertia_scale"] for name in BODIES}
    share["PL"] *= plant["payload_mass"] / machine["bodies"]["PL"]["mass"]
    damping = machine["joint_viscous"]

    def body(name, parent, joint, children=""):
        T = np.eye(4) if parent is None else world[parent]
        return (
            f'<body name="{name}" {pose(world, T, world[name])}>{joint}'
            f'{inertial(machine["bodies"][name], share[name])}{children}</body>'
        )

    def hinge(name, axis, i=None):
        d = 0 if i is None else damping[i]
        return f'<joint name="{name}" type="hinge" axis="{axis}" damping="{d:.17g}"/>'

    def rod(name):
        return f'<joint name="{name}" type="slide" axis="1 0 0"/>'

    payload = body("PL", "D4", "")
    site = f'<site name="tip" {pose(world, world["D4"], np.asarray(tip))}/>'
    d4 = body("D4", "C4", hinge("zeta_6", "1 0 0", 5), payload + site)
    c4 = body("C4", "A4", hinge("zeta_5", "0 0 1", 4), d4)
    a4 = body("A4", "A3", hinge("zeta_4", "1 0 0", 3), c4)
    cp = body("CP", "A3", hinge("coupler", "0 0 1"))
    a3 = body("A3", "A2", hinge("zeta_3", "0 0 1", 2), cp + a4)
    d3 = body("D3", "C3", rod("rod_3"))
    c3 = body("C3", "A2", hinge("cylinder_3", "0 0 1"), d3)
    rk = body("RK", "A2", hinge("rocker", "0 0 1"))
    a2 = body("A2", "T1", hinge("zeta_2", "0 0 1", 1), a3 + c3 + rk)
    d2 = body("D2", "C2", rod("rod_2"))
    c2 = body("C2", "T1", hinge("cylinder_2", "0 0 1"), d2)
    t1 = body("T1", None, hinge("zeta_1", "0 1 0", 0), a2 + c2)

    def pin(a, b, x):
        return f'<connect body1="{a}" body2="{b}" anchor="{x:.17g} 0 0"/>'

    return f"""<mujoco>
      <compiler angle="radian" balanceinertia="false"/>
      <option gravity="0 {-machine["gravity"]:.17g} 0" timestep="0.001" integrator="Euler"
              jacobian="dense" solver="Newton" iterations="200" tolerance="1e-16">
        <flag contact="disable" eulerdamp="disable"/>
      </option>
      <default><equality solref="0.002 1" solimp="0.9999 0.9999 0.001 0.5 2"/></default>
      <worldbody>{t1}</worldbody>
      <equality>
        {pin("D2", "A2", g["lc_2"])}
        {pin("D3", "RK", g["lc_3"])}
        {pin("D3", "CP", g["lc_3"])}
      </equality>
    </mujoco>"""


PARENT = {
    "T1": None, "A2": "T1", "C2": "T1", "D2": "C2", "A3": "A2", "C3": "A2", "D3": "C3",
    "RK": "A2", "CP": "A3", "A4": "A3", "C4": "A4", "D4": "C4",
}  # fmt: skip
JOINT = {
    "T1": "zeta_1", "A2": "zeta_2", "C2": "cylinder_2", "D2": "rod_2", "A3": "zeta_3",
    "C3": "cylinder_3", "D3": "rod_3", "RK": "rocker", "CP": "coupler",
    "A4": "zeta_4", "C4": "zeta_5", "D4": "zeta_6",
}  # fmt: skip
AXIS = {"T1": "y", "D2": "slide", "D3": "slide", "A4": "x", "D4": "x"}


def joint_values(machine, zeta):
    """Coordinate of each of the 12 joints, from relative poses of the oracle's bodies."""
    poses = dict(zip(BODIES, solve(machine, zeta)[0]))
    values = []
    for name, parent in PARENT.items():
        T = poses[name] if parent is None else jnp.linalg.inv(poses[parent]) @ poses[name]
        values.append(
            {
                "x": lambda: jnp.arctan2(T[2, 1], T[1, 1]),
                "y": lambda: jnp.arctan2(T[0, 2], T[0, 0]),
                "z": lambda: jnp.arctan2(T[1, 0], T[0, 0]),
                "slide": lambda: T[0, 3],
            }[AXIS.get(name, "z")]()
        )
    return jnp.stack(values)


class Comparison:
    """One plant in MuJoCo and in the oracle."""

    def __init__(self, plant):
        machine = plant["machine"]
        limits = machine["limits"]
        middle = np.radians(0.5 * (np.array(limits["zeta_min_deg"]) + limits["zeta_max_deg"]))
        self.cases = plant["cases"]
        self.r_B = machine["geometry"]["r_B"]
        self.m = mujoco.MjModel.from_xml_string(model(plant))
        self.d = mujoco.MjData(self.m)
        self.expected = make(machine, plant["inertia_scale"], plant["payload_mass"])
        self.values = jax.jit(lambda z: joint_values(machine, z))
        self.rates = jax.jit(
            lambda z, w: jax.jvp(lambda z: joint_values(machine, z), (z,), (w,))[1]
        )
        self.reference = self.values(middle)

    def dof(self, joint):
        return self.m.joint(joint).dofadr[0]

    def set_state(self, zeta, zeta_dot):
        joints = list(JOINT.values())
        positions = [self.m.joint(name).qposadr[0] for name in joints]
        self.d.qpos[positions] = np.asarray(self.values(zeta) - self.reference)
        self.d.qvel[[self.dof(name) for name in joints]] = np.asarray(self.rates(zeta, zeta_dot))

    def set_forces(self, f, tau, W):
        m, d = self.m, self.d
        d.qfrc_applied[:] = 0
        forces = {"zeta_1": self.r_B * f[0], "rod_2": f[1], "rod_3": f[2]}
        forces |= {f"zeta_{4 + i}": tau[i] for i in range(3)}
        for joint, force in forces.items():
            d.qfrc_applied[self.dof(joint)] = force
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        site = m.site("tip").id
        R = d.site_xmat[site].reshape(3, 3)
        body = m.site_bodyid[site]
        mujoco.mj_applyFT(m, d, R @ W[:3], R @ W[3:], d.site_xpos[site], body, d.qfrc_applied)

    def errors(self, speed):
        """Relative errors of the six accelerations, rates scaled by `speed`."""
        independent = [self.dof(f"zeta_{i + 1}") for i in range(6)]
        errors = []
        for case in self.cases:
            zeta, zeta_dot = np.array(case["zeta"]), np.array(case["zeta_dot"]) * speed
            f, tau, W = (np.array(case[k]) for k in ("f", "tau", "W_env"))
            self.set_state(zeta, zeta_dot)
            self.set_forces(f, tau, W)
            mujoco.mj_forward(self.m, self.d)
            exact = np.asarray(self.expected(zeta, zeta_dot, f, tau, W)["zeta_ddot"])
            error = np.linalg.norm(self.d.qacc[independent] - exact) / np.linalg.norm(exact)
            errors.append(error)
        return np.array(errors)


def main():
    plants = json.loads(GOLDEN.read_text())["plants"]
    print(f"MuJoCo {mujoco.__version__}: relative error of zeta_ddot (median, largest)")
    for name, plant in zip(["reference", "crooked"], plants):
        comparison = Comparison(plant)
        for speed in [0.0, 1.0]:
            errors = comparison.errors(speed)
            state = "moving" if speed else "at rest"
            print(f"  {name:10} {state:8} {np.median(errors):.1e} {errors.max():.1e}", flush=True)


if __name__ == "__main__":
    main()
