"""Oracle of the manipulator: Lagrange's equations from the poses of `mechanism.py` alone.

    python tests/oracle/lagrangian.py        (versions: tests/oracle/requirements.txt)

writes `manipulator.json`, which `machine/hdrm/tests/oracle.rs` reads. It may change when the
reference parameters or the meaning of a field change, never to follow the Rust code.
"""

import copy
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import golden
from mechanism import BODIES, mechanism_of, reference_machine, solve, tensor

GOLDEN = Path(__file__).with_name("manipulator.json")
CASES_PER_MACHINE = 110
SEED = 20240611


def mass_properties(machine, inertia_scale, payload_mass):
    """Masses, centres of mass and inertias about them."""
    bodies = [machine["bodies"][name] for name in BODIES]
    share = [1.0] * 12 + [payload_mass / machine["bodies"]["PL"]["mass"]]
    factor = inertia_scale * jnp.array(share)
    m = factor * jnp.array([b["mass"] for b in bodies])
    com = jnp.array([b["com"] for b in bodies])
    I = factor[:, None, None] * jnp.stack([tensor(b["inertia_com"]) for b in bodies])
    return m, com, I


def vee(W):
    return jnp.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)


def make(machine, inertia_scale, payload_mass):
    """The function (zeta, zeta_dot, f, tau, W_env) -> expected quantities of one plant."""
    m, com, I = mass_properties(machine, inertia_scale, payload_mass)
    g = machine["gravity"]
    viscous = jnp.array(machine["joint_viscous"])

    def kinetic(zeta, zeta_dot):
        poses = lambda z: solve(machine, z)[0]
        T, T_dot = jax.jvp(poses, (zeta,), (zeta_dot,))
        R, R_dot = T[:, :3, :3], T_dot[:, :3, :3]
        v = jnp.einsum("kij,kj->ki", R_dot, com) + T_dot[:, :3, 3]
        w = vee(jnp.einsum("kji,kjl->kil", R, R_dot))  # body axes: Rᵀ R_dot
        return 0.5 * jnp.sum(m * jnp.sum(v * v, axis=1)) + 0.5 * jnp.einsum("ki,kij,kj->", w, I, w)

    def potential(zeta):
        T = solve(machine, zeta)[0]
        height = jnp.einsum("kj,kj->k", T[:, 1, :3], com) + T[:, 1, 3]
        return g * jnp.sum(m * height)

    def tip_jacobian(zeta):
        """Twist of T4 in T4 axes per joint rate."""
        T = solve(machine, zeta)[1]
        dT = jax.jacfwd(lambda z: solve(machine, z)[1])(zeta)
        R = T[:3, :3]
        v = R.T @ dT[:3, 3, :]
        w = vee(jnp.moveaxis(jnp.einsum("ji,jlk->ilk", R, dT[:3, :3, :]), -1, 0)).T
        return jnp.concatenate([v, w])

    @jax.jit
    def expected(zeta, zeta_dot, f, tau, W_env):
        poses, T4, x = solve(machine, zeta)
        Jx = jax.jacfwd(lambda z: solve(machine, z)[2])(zeta)
        J_tip = tip_jacobian(zeta)
        Q = Jx.T @ f + jnp.concatenate([jnp.zeros(3), tau]) + J_tip.T @ W_env - viscous * zeta_dot
        # d/dt(dT/dzeta_dot) - dT/dzeta + dU/dzeta = Q
        M = jax.hessian(kinetic, argnums=1)(zeta, zeta_dot)
        momentum = jax.grad(kinetic, argnums=1)
        _, momentum_rate = jax.jvp(lambda z: momentum(z, zeta_dot), (zeta,), (zeta_dot,))
        dT = jax.grad(kinetic, argnums=0)(zeta, zeta_dot)
        dU = jax.grad(potential)(zeta)
        return {
            "zeta_ddot": jnp.linalg.solve(M, Q - momentum_rate + dT - dU),
            "x": x,
            "x_dot": Jx @ zeta_dot,
            "f_hold": dU[:3] / jnp.diagonal(Jx),
            "tau_hold": dU[3:],
            "kinetic": kinetic(zeta, zeta_dot),
            "potential": potential(zeta),
            "tip_position": T4[:3, 3],
            "tip_rotation": T4[:3, :3].reshape(9),
            # Twist in T4 axes
            "tip_twist": J_tip @ zeta_dot,
        }

    return expected


def crooked_machine(rng):
    """A machine without the symmetries of the reference: nothing in the plane, nothing round."""
    machine = copy.deepcopy(reference_machine())
    g = machine["geometry"]
    for name in ["r_T1_O", "r_O_B", "r_B_B4", "r_B4_A4", "r_A4_C4", "r_C4_D4", "r_D4_T4"]:
        g[name] = [float(v + d) for v, d in zip(g[name], rng.uniform(-0.07, 0.07, 3))]
    for name in ["A_in_boom", "E_in_boom", "C_in_tilt"]:
        g[name] = [float(v + d) for v, d in zip(g[name], rng.uniform(-0.013, 0.013, 2))]
    for name in ["r_B", "x1_mid", "beta1", "beta2", "L1_2", "L2_2", "d4", "d5", "lc_2", "lc_3"]:
        g[name] = float(g[name] * rng.uniform(0.98, 1.02))
    for body in machine["bodies"].values():
        body["mass"] = float(body["mass"] * rng.uniform(0.8, 1.2))
        body["com"] = [float(c + d) for c, d in zip(body["com"], rng.uniform(-0.09, 0.09, 3))]
        # Inertia of a random cloud of points: physical, and full.
        size = np.sqrt(np.trace(np.asarray(tensor(body["inertia_com"]))) / body["mass"])
        cloud = rng.normal(size=(8, 3)) * size * np.array([1.0, 0.5, 0.3])
        cloud -= cloud.mean(axis=0)
        I = body["mass"] / 8 * (np.sum(cloud**2) * np.eye(3) - cloud.T @ cloud)
        body["inertia_com"] = {
            "xx": I[0, 0], "yy": I[1, 1], "zz": I[2, 2],
            "xy": I[0, 1], "xz": I[0, 2], "yz": I[1, 2],
        }
    machine["joint_viscous"] = [float(d * rng.uniform(0.5, 1.5)) for d in machine["joint_viscous"]]
    machine["gravity"] = 9.79
    return machine


def moving(rng, limits):
    """A state within the limits, with forces and torques on it."""
    low, high = np.radians(limits["zeta_min_deg"]), np.radians(limits["zeta_max_deg"])
    return {
        "zeta": rng.uniform(low, high),
        "zeta_dot": rng.uniform(-1.5, 1.5, 6),
        "f": rng.uniform(-70e3, 70e3, 3),
        "tau": rng.uniform(-1, 1, 3) * limits["tau_wrist_max"],
        "W_env": rng.uniform(-1, 1, 6) * np.array([4e3] * 3 + [1e3] * 3),
    }


def plant(rng, machine, inertia_scale, payload_mass):
    expected = make(machine, inertia_scale, payload_mass)
    cases = []
    for _ in range(CASES_PER_MACHINE):
        given = moving(rng, machine["limits"])
        cases.append({**given, **expected(*given.values())})
    as_lists = [{k: np.asarray(v).tolist() for k, v in case.items()} for case in cases]
    return {
        "machine": machine,
        "inertia_scale": inertia_scale,
        "payload_mass": payload_mass,
        "cases": as_lists,
    }


def main():
    rng = np.random.default_rng(SEED)
    plants = [
        plant(rng, reference_machine(), 1.0, 300.0),
        plant(rng, crooked_machine(rng), 1.37, 217.0),
        plant(rng, mechanism_of("hiab_xs031"), 1.0, 490.0),
    ]
    golden.write(GOLDEN, {"jax": jax.__version__, "plants": plants})


if __name__ == "__main__":
    main()
