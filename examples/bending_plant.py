"""A manipulator that bends, whose errors are drawn by a seed, and its natural frequencies."""

from copy import deepcopy
from math import cos, pi, sin

import mujoco
import numpy as np
from mujoco_model import UP, Flexure
from mujoco_plant import Plant

# Dry friction of the six joints, N.m: pins of 30 mm radius under some 60 kN with 0.1, a slewing ring, geared wrist joints.
DRY_FRICTION = (300.0, 200.0, 150.0, 20.0, 20.0, 10.0)


def flexures(machine, stiffness, damping_time):
    """Column, lift and tilt boom with spring constants, N.m/rad; a damper is `damping_time` times its spring.

    A cantilever of length L that is loaded at its end deflects and turns there like a rigid one with a hinge at L/3 and the spring
    4 EI/(3 L): so the tilt boom, which is held from C on. The lift boom is weakest between the pin of its actuator and E, where the
    hinge is half way, on the line from O to B.
    """
    g = machine["geometry"]
    column, lift, tilt = stiffness
    pin, E = g["L1_2"] * cos(g["beta2"]), g["r_O_B"][0] + g["E_in_boom"][0]
    C, end = g["C_in_tilt"][0], g["r_B_B4"][0] + g["r_B4_A4"][0]
    half = (pin + E) / 2
    hinges = (
        ("T1", (0.0, 0.5, 0.0), "0 1 0", column),
        ("A2", (half * cos(g["beta2"]), half * sin(g["beta2"]), 0.0), "0 0 1", lift),
        ("A3", (C + (end - C) / 3, 0.0, 0.0), "0 0 1", tilt),
    )
    return tuple(Flexure(body, point, axis, k, damping_time * k) for body, point, axis, k in hinges)


def drawn(machine, seed, mass, com, dimension):
    """The machine with every body's mass (and inertia) off by up to ±`mass` of it, every coordinate of a centre of mass by ±`com` m and
    every length by ±`dimension` m. Seed 0 draws nothing. Masses scale inertias, so these stay physically consistent."""
    machine = deepcopy(machine)
    if seed == 0:
        return machine
    draw = np.random.default_rng(seed).uniform
    for body in machine["bodies"].values():
        factor = 1 + draw(-mass, mass)
        body["mass"] *= factor
        body["inertia_com"] = {k: factor * v for k, v in body["inertia_com"].items()}
        body["com"] = [v + draw(-com, com) for v in body["com"]]
    for name, value in machine["geometry"].items():
        if isinstance(value, list):
            machine["geometry"][name] = [v and v + draw(-dimension, dimension) for v in value]
        elif not name.startswith("beta"):
            machine["geometry"][name] = value + draw(-dimension, dimension)
    return machine


def tilted_gravity(machine, seed, angle):
    """Gravity in world axes, off the vertical by up to ±`angle` rad about both horizontal axes."""
    about_x, about_z = np.random.default_rng((seed, 1)).uniform(-angle, angle, 2) if seed else (0.0, 0.0)
    down = np.array([sin(about_z), -cos(about_x) * cos(about_z), sin(about_x)])
    return machine["gravity"] * down / np.linalg.norm(down)


def modes(plant):
    """Natural frequencies, Hz, damping ratios and shapes of the structure with all drives locked, in the plant's present pose.

    M y'' + C y' + K y = 0 of the flexures' angles: M is their part of the mass matrix (no closed loop crosses a flexure), K their
    springs and the change of gravity's moments with the angles.
    """
    m, d, bent = plant.m, plant.d, plant.bent
    mujoco.mj_forward(m, d)
    full = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, full)
    M, K, q = full[np.ix_(bent, bent)], np.diag(m.jnt_stiffness[bent]), d.qpos.copy()
    for column, dof in enumerate(bent):
        moments = []
        for step in (1e-5, -1e-5):
            d.qpos[:] = q
            d.qpos[dof] += step
            mujoco.mj_forward(m, d)
            moments.append(d.qfrc_bias[bent].copy())
        K[:, column] += (moments[0] - moments[1]) / 2e-5
    d.qpos[:] = q
    mujoco.mj_forward(m, d)
    root = np.linalg.inv(np.linalg.cholesky(M))
    square, shape = np.linalg.eigh(root @ (K + K.T) / 2 @ root.T)
    w = np.sqrt(square)
    shape = root.T @ shape
    ratio = np.array([y @ np.diag(m.dof_damping[bent]) @ y for y in shape.T]) / (2 * w)
    return w / (2 * pi), ratio, shape


class BendingPlant(Plant):
    """`settings`: the parameters of Bending.fmu by name."""

    def __init__(self, nominal, settings):
        s = settings
        machine = drawn(nominal, s["seed"], s["error.mass"], s["error.com"], s["error.dimension"])
        bending = flexures(machine, [s[f"stiffness.{part}"] for part in ("column", "lift", "tilt")], s["damping_time"])
        gravity = tilted_gravity(machine, s["seed"], s["error.gravity"])
        super().__init__(machine, s["inertia_scale"], bending, gravity, s["friction"] * np.array(DRY_FRICTION))

    def outputs(self):
        rigid, d = self.rigid_tip(), self.d
        return super().outputs() | {
            "tip.rigid_position": rigid,
            "tip.sag": [np.linalg.norm(UP.T @ d.site_xpos[self.tip] - rigid)],
            "flexure": d.qpos[self.bent],
        }
