"""Poses of the 13 bodies from the geometry alone, written for automatic differentiation.

Independent of the Rust code on purpose: it composes 4x4 matrices, places D by intersecting two
circles and takes actuator directions by atan2. No velocity, gear ratio or Jacobian is written
down anywhere; JAX differentiates.
"""

import json
from pathlib import Path

import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)

REPOSITORY = Path(__file__).resolve().parents[2]
REFERENCE = REPOSITORY / "parameters" / "reference_machine.json"
BODIES = ["T1", "A2", "C2", "D2", "A3", "C3", "D3", "RK", "CP", "A4", "C4", "D4", "PL"]


def reference_machine():
    return json.loads(REFERENCE.read_text())


def merged(base, own):
    """Objects field by field, all else as a whole: what `extends` means in a machine file."""
    if not (isinstance(base, dict) and isinstance(own, dict)):
        return own
    return {**base, **{key: merged(base.get(key), value) for key, value in own.items()}}


def mechanism_of(name):
    """The shipped machine of that name, with the actuators of the reference machine, which no oracle of the mechanism knows."""
    own = json.loads((REFERENCE.parent / f"{name}.json").read_text())
    return merged(reference_machine(), {key: own[key] for key in ["geometry", "bodies", "limits", "start"]})


def frame(axis, angle, shift):
    """4x4 pose: shifted by `shift`, then turned about `axis` by `angle`."""
    a = jnp.asarray(axis, dtype=float)
    K = jnp.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    R = jnp.eye(3) + jnp.sin(angle) * K + (1 - jnp.cos(angle)) * K @ K
    top = jnp.concatenate([R, jnp.asarray(shift, dtype=float).reshape(3, 1)], axis=1)
    return jnp.concatenate([top, jnp.array([[0.0, 0.0, 0.0, 1.0]])], axis=0)


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
STAY = (0.0, 0.0, 0.0)


def point(T, p):
    """Point `p` (two or three coordinates) of frame T in T's parent."""
    p = jnp.asarray(p, dtype=float)
    p = jnp.concatenate([p, jnp.zeros(3 - p.shape[0])])
    return T[:3, :3] @ p + T[:3, 3]


def pose_between(start, end, along=0.0):
    """Frame in the plane at distance `along` from `start`, x towards `end`; also the distance."""
    d = end - start
    length = jnp.hypot(d[0], d[1])
    angle = jnp.arctan2(d[1], d[0])
    shift = start + along * jnp.array([jnp.cos(angle), jnp.sin(angle), 0.0])
    return frame(Z, angle, shift), length


def circle_intersection(a, ra, c, rc, away_from):
    """The point at ra from a and at rc from c, on the side of line ac away from a third point."""
    ac = (c - a)[:2]
    distance = jnp.sqrt(ac @ ac)
    u = ac / distance
    n = jnp.array([-u[1], u[0]])
    t = (distance**2 + ra**2 - rc**2) / (2 * distance)
    s = jnp.sqrt(ra**2 - t**2)
    side = -jnp.sign(n @ (away_from - a)[:2])
    return jnp.append(a[:2] + t * u + side * s * n, a[2])


def solve(machine, zeta):
    """World poses of all bodies and of the tip, and the three strokes."""
    g = machine["geometry"]
    slew = frame(Y, zeta[0], STAY)

    # Everything below in T1's axes until `slew` is applied.
    O = jnp.asarray(g["r_T1_O"], dtype=float)
    boom = frame(Z, zeta[1], O)  # boom axes at O
    A2 = frame(Z, zeta[1] - g["beta2"], O)
    foot = O + g["L2_2"] * jnp.array([jnp.sin(g["beta1"]), -jnp.cos(g["beta1"]), 0.0])
    pin = point(A2, [g["L1_2"]])
    C2, c_2 = pose_between(foot, pin)
    D2, _ = pose_between(foot, pin, along=c_2 - g["lc_2"])

    B = point(boom, g["r_O_B"])
    boom_at_B = frame(Z, zeta[1], B)
    A3 = frame(Z, zeta[1] + zeta[2], B)
    A = point(boom_at_B, g["A_in_boom"])
    E = point(boom_at_B, g["E_in_boom"])
    C = point(A3, g["C_in_tilt"])
    D = circle_intersection(A, g["d4"], C, g["d5"], away_from=B)
    C3, c_3 = pose_between(E, D)
    D3, _ = pose_between(E, D, along=c_3 - g["lc_3"])
    RK, _ = pose_between(A, D)
    CP, _ = pose_between(C, D)

    B4 = A3 @ frame(X, 0.0, g["r_B_B4"])
    A4 = B4 @ frame(X, zeta[3], g["r_B4_A4"])
    C4 = A4 @ frame(Z, zeta[4], g["r_A4_C4"])
    D4 = C4 @ frame(X, zeta[5], g["r_C4_D4"])
    T4 = D4 @ frame(X, 0.0, g["r_D4_T4"])

    in_T1 = [frame(X, 0.0, STAY), A2, C2, D2, A3, C3, D3, RK, CP, A4, C4, D4, D4]
    poses = jnp.stack([slew @ T for T in in_T1])
    strokes = jnp.array([g["x1_mid"] + g["r_B"] * zeta[0], c_2 - g["x0_2"], c_3 - g["x0_3"]])
    return poses, slew @ T4, strokes


def tensor(I):
    return jnp.array(
        [[I["xx"], I["xy"], I["xz"]], [I["xy"], I["yy"], I["yz"]], [I["xz"], I["yz"], I["zz"]]]
    )
