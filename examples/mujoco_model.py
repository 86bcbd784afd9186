"""The manipulator as a MuJoCo model, rigid or bending, built from the machine JSON alone.

Both closed loops are MuJoCo `connect` constraints, so the geometry is a little soft where Hdrm.fmu is exact; the strokes are
computed from the boom angles. All joint coordinates are zero in the start pose. Points of the boom plane are complex numbers.
"""

from cmath import exp, phase
from dataclasses import dataclass
from math import copysign, cos, sin, sqrt

import numpy as np

SUBSTEP = 2.5e-4  # s


@dataclass(frozen=True)
class Flexure:
    """A virtual hinge that cuts a beam in two: body, point and axis in the body's frame, spring N.m/rad, damper N.m.s/rad."""

    body: str
    point: tuple
    axis: str
    stiffness: float
    damping: float

    @property
    def name(self):
        return f"flexure_{self.body}"


def plane(machine, zeta_2, zeta_3):
    """Boom plane: {body: (position, angle)} of its eight bodies, and the lift and tilt strokes."""
    g = machine["geometry"]
    point = lambda p: complex(p[0], p[1])
    boom, tilt = exp(1j * zeta_2), exp(1j * (zeta_2 + zeta_3))
    O = point(g["r_T1_O"])
    foot = O + g["L2_2"] * complex(sin(g["beta1"]), -cos(g["beta1"]))
    pin = O + g["L1_2"] * exp(1j * (zeta_2 - g["beta2"]))
    B = O + boom * point(g["r_O_B"])
    A, E = (B + boom * point(g[k]) for k in ("A_in_boom", "E_in_boom"))
    C = B + tilt * point(g["C_in_tilt"])
    D = meeting(A, g["d4"], C, g["d5"], B)
    lift, push = pin - foot, D - E
    c_2, c_3 = abs(lift), abs(push)
    frames = {
        "A2": (O, zeta_2 - g["beta2"]),
        "C2": (foot, phase(lift)),
        "D2": (foot + lift * (1 - g["lc_2"] / c_2), phase(lift)),
        "A3": (B, zeta_2 + zeta_3),
        "C3": (E, phase(push)),
        "D3": (E + push * (1 - g["lc_3"] / c_3), phase(push)),
        "RK": (A, phase(D - A)),
        "CP": (C, phase(D - C)),
    }
    return frames, np.array([c_2 - g["x0_2"], c_3 - g["x0_3"]])


def meeting(a, ra, c, rc, away):
    """The point at ra from a and rc from c, on the side of the line ac away from a third point."""
    d = abs(c - a)
    u = (c - a) / d
    t = (d**2 + ra**2 - rc**2) / (2 * d)
    side = ((away - a) / u).imag
    return a + u * complex(t, -copysign(sqrt(ra**2 - t**2), side))


def text(values):
    return " ".join(f"{v:.17g}" for v in values)


def matrix(inertia):
    xx, yy, zz, xy, xz, yz = (inertia[k] for k in ("xx", "yy", "zz", "xy", "xz", "yz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertial(mass, com, inertia):
    entries = [inertia[i] for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return f'<inertial pos="{text(com)}" mass="{mass:.17g}" fullinertia="{text(entries)}"/>'


def cut(mass, com, inertia, point):
    """A body in two along its longest axis, at a point of it: mass, centre and inertia of the part nearer to the frame's origin, then
    of the other. The body is taken for the uniform box of its inertia, so both parts together have exactly its mass properties."""
    moments, axes = np.linalg.eigh(inertia)
    square = 6 * (np.sum(moments) - 2 * moments) / mass  # of the box's edges: I_x = m (y² + z²)/12
    long = np.argmax(square)
    length, along = sqrt(square[long]), axes[:, long]
    if along @ com < 0:
        along = -along
    share = 0.5 + along @ (np.asarray(point) - com) / length
    if not 0 < share < 1:
        raise ValueError(f"the flexure at {point} must lie within the beam of length {length:.3f} m around {com}")
    parts = []
    for part, offset in ((share, (share - 1) / 2), (1 - share, share / 2)):
        edges = np.where(np.arange(3) == long, square * part**2, square)
        inner = axes @ np.diag(part * mass * (np.sum(edges) - edges) / 12) @ axes.T
        parts.append((part * mass, com + offset * length * along, inner))
    return parts


def mjcf(machine, scale=1.0, flexures=(), gravity=None):
    """The model in the machine's start pose; `gravity` in world axes, m/s²."""
    g, zeta = machine["geometry"], machine["start"]["zeta"]
    frames, _ = plane(machine, zeta[1], zeta[2])
    frames["T1"] = (0j, 0.0)
    arm = np.add(g["r_B_B4"], g["r_B4_A4"])
    cuts = {flexure.body: flexure for flexure in flexures}

    def body(name, place, joint, near="", far=""):
        """`near` hangs before the flexure, if the body has one, `far` behind it."""
        b = machine["bodies"][name]
        whole = scale * b["mass"], np.array(b["com"]), scale * matrix(b["inertia_com"])
        if name not in cuts:
            return f'<body name="{name}" {place}>{joint}{inertial(*whole)}{near}{far}</body>'
        flexure = cuts[name]
        inner, outer = (inertial(*part) for part in cut(*whole, flexure.point))
        hinge = f'<joint name="{flexure.name}" pos="{text(flexure.point)}" axis="{flexure.axis}"'
        hinge += f' stiffness="{flexure.stiffness:.17g}" damping="{flexure.damping:.17g}"/>'
        outer = f'<body name="{name}_far">{hinge}{outer}{far}</body>'
        return f'<body name="{name}" {place}>{joint}{inner}{near}{outer}</body>'

    def planar(name, parent, joint, near="", far=""):
        (p, angle), (q, base) = frames[name], frames[parent]
        r = exp(-1j * base) * (p - q)
        return body(name, f'pos="{text([r.real, r.imag, 0])}" euler="0 0 {angle - base:.17g}"', joint, near, far)

    def hinge(name, axis, damping=0.0):
        return f'<joint name="{name}" axis="{axis}" damping="{damping:.17g}"/>'

    def rod(name):
        return f'<joint name="{name}" type="slide" axis="1 0 0"/>'

    v = machine["joint_viscous"]
    payload = body("PL", 'pos="0 0 0"', "")
    tip = f'<site name="tip" pos="{text(g["r_D4_T4"])}"/>'
    D4 = body("D4", f'pos="{text(g["r_C4_D4"])}" euler="{zeta[5]:.17g} 0 0"', hinge("zeta_6", "1 0 0", v[5]), payload + tip)
    C4 = body("C4", f'pos="{text(g["r_A4_C4"])}" euler="0 0 {zeta[4]:.17g}"', hinge("zeta_5", "0 0 1", v[4]), D4)
    A4 = body("A4", f'pos="{text(arm)}" euler="{zeta[3]:.17g} 0 0"', hinge("zeta_4", "1 0 0", v[3]), C4)
    CP = planar("CP", "A3", hinge("coupler", "0 0 1"))
    A3 = planar("A3", "A2", hinge("zeta_3", "0 0 1", v[2]), near=CP, far=A4)
    C3 = planar("C3", "A2", hinge("cylinder_3", "0 0 1"), planar("D3", "C3", rod("rod_3")))
    RK = planar("RK", "A2", hinge("rocker", "0 0 1"))
    A2 = planar("A2", "T1", hinge("zeta_2", "0 0 1", v[1]), far=A3 + C3 + RK)
    C2 = planar("C2", "T1", hinge("cylinder_2", "0 0 1"), planar("D2", "C2", rod("rod_2")))
    T1 = body("T1", f'pos="0 0 0" euler="0 {zeta[0]:.17g} 0"', hinge("zeta_1", "0 1 0", v[0]), far=A2 + C2)
    pins = "".join(
        f'<connect body1="{a}" body2="{b}" anchor="{x:.17g} 0 0"/>'
        for a, b, x in (("D2", "A2", g["lc_2"]), ("D3", "RK", g["lc_3"]), ("D3", "CP", g["lc_3"]))
    )
    return f"""<mujoco>
      <compiler angle="radian" balanceinertia="false"/>
      <option gravity="{text([0, -machine["gravity"], 0] if gravity is None else gravity)}" timestep="{SUBSTEP}"
              jacobian="dense" iterations="50" tolerance="1e-12">
        <flag contact="disable" energy="enable"/>
      </option>
      <default><equality solref="{2 * SUBSTEP} 1" solimp="0.9999 0.9999 0.001 0.5 2"/></default>
      <worldbody>{T1}</worldbody>
      <equality>{pins}</equality>
    </mujoco>"""
