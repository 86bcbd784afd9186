"""Oracle of the manipulator on a base that moves: Lagrange's equations with a base pose that is a function of time.

    python tests/oracle/moving_base.py        (versions: tests/oracle/requirements.txt)

writes `moving_base.json`, which `machine/hdrm/tests/moving_base.rs` reads. The poses are those of `mechanism.py`, moved along with the base;
no velocity, Coriolis, centrifugal or Euler force is written down. It may change when the reference parameters or the meaning of a field
change, never to follow the Rust code.
"""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import golden
from lagrangian import crooked_machine, mass_properties, moving, vee
from mechanism import X, Z, frame, reference_machine, solve

GOLDEN = Path(__file__).with_name("moving_base.json")
CASES_PER_MACHINE = 25
SEED = 20261122


def base_pose(tilt, a, w, w_dot, t):
    """Rotation and origin of the base at the time t: tilted at 0, where it has the acceleration a, the angular velocity w and its rate
    w_dot, all in its own axes. The velocity of its origin is 0 then; any other gives the same forces."""
    tilted = (frame(X, tilt[0], jnp.zeros(3)) @ frame(Z, tilt[1], jnp.zeros(3)))[:3, :3]
    turned = w * t + w_dot * t**2 / 2
    K = jnp.cross(turned, jnp.eye(3)).T  # K v = turned x v
    # The exponential up to t³: two derivatives at 0 are exact.
    return tilted @ (jnp.eye(3) + K + K @ K / 2 + K @ K @ K / 6), tilted @ a * t**2 / 2


def make(machine, inertia_scale, payload_mass):
    m, com, I = mass_properties(machine, inertia_scale, payload_mass)
    g = machine["gravity"]
    viscous = jnp.array(machine["joint_viscous"])

    def world(zeta, base, t):
        """Rotations and centres of mass of the bodies in an inertial frame."""
        R_b, r_b = base_pose(*base, t)
        T = solve(machine, zeta)[0]
        R = R_b @ T[:, :3, :3]
        centres = jnp.einsum("kij,kj->ki", R, com) + T[:, :3, 3] @ R_b.T + r_b
        return R, centres

    def velocities(zeta, zeta_dot, base, t):
        (R, _), (R_dot, v) = jax.jvp(lambda z, s: world(z, base, s), (zeta, t), (zeta_dot, jnp.ones(())))
        return v, vee(jnp.einsum("kji,kjl->kil", R, R_dot))

    def lagrangian(zeta, zeta_dot, base, t):
        v, w = velocities(zeta, zeta_dot, base, t)
        kinetic = 0.5 * jnp.sum(m * jnp.sum(v * v, axis=1)) + 0.5 * jnp.einsum("ki,kij,kj->", w, I, w)
        return kinetic - g * jnp.sum(m * world(zeta, base, t)[1][:, 1])

    def momenta(zeta, zeta_dot, base, t):
        """Linear and angular momentum about the inertial frame's origin, in its axes."""
        v, w = velocities(zeta, zeta_dot, base, t)
        R, centres = world(zeta, base, t)
        p = m[:, None] * v
        spin = jnp.einsum("kij,kjl,kl->i", R, I, w)
        return p.sum(axis=0), jnp.cross(centres, p).sum(axis=0) + spin

    @jax.jit
    def expected(zeta, zeta_dot, f, tau, W_env, tilt, a, w, w_dot):
        base, now = (tilt, a, w, w_dot), jnp.zeros(())
        Jx = jax.jacfwd(lambda z: solve(machine, z)[2])(zeta)
        T4 = solve(machine, zeta)[1]
        dT4 = jax.jacfwd(lambda z: solve(machine, z)[1])(zeta)
        v_tip = T4[:3, :3].T @ dT4[:3, 3, :]
        w_tip = vee(jnp.moveaxis(jnp.einsum("ji,jlk->ilk", T4[:3, :3], dT4[:3, :3, :]), -1, 0)).T
        J_tip = jnp.concatenate([v_tip, w_tip])
        Q = Jx.T @ f + jnp.concatenate([jnp.zeros(3), tau]) + J_tip.T @ W_env - viscous * zeta_dot
        of_rates = jax.grad(lagrangian, argnums=1)
        M = jax.hessian(lagrangian, argnums=1)(zeta, zeta_dot, base, now)
        _, drift = jax.jvp(lambda z, t: of_rates(z, zeta_dot, base, t), (zeta, now), (zeta_dot, jnp.ones(())))
        zeta_ddot = jnp.linalg.solve(M, Q - drift + jax.grad(lagrangian)(zeta, zeta_dot, base, now))

        # What the base exerts: Newton's and Euler's law for the whole machine.
        along = lambda z, z_dot, t: momenta(z, z_dot, base, t)
        _, (force, moment) = jax.jvp(along, (zeta, zeta_dot, now), (zeta_dot, zeta_ddot, jnp.ones(())))
        R_b, _ = base_pose(*base, now)
        centres = world(zeta, base, now)[1]
        weights = -g * m[:, None] * jnp.array([0.0, 1.0, 0.0])
        R_tip, r_tip = R_b @ T4[:3, :3], R_b @ T4[:3, 3]
        f_env, m_env = R_tip @ W_env[:3], R_tip @ W_env[3:]
        force = force - weights.sum(axis=0) - f_env
        moment = moment - jnp.cross(centres, weights).sum(axis=0) - jnp.cross(r_tip, f_env) - m_env
        return {
            "zeta_ddot": zeta_ddot,
            "base_wrench": jnp.concatenate([R_b.T @ force, R_b.T @ moment]),
        }

    return expected


def plant(rng, machine, inertia_scale, payload_mass):
    expected = make(machine, inertia_scale, payload_mass)
    cases = []
    for _ in range(CASES_PER_MACHINE):
        given = {
            **moving(rng, machine["limits"]),
            "tilt": rng.uniform(-0.4, 0.4, 2),
            "acceleration": rng.uniform(-2, 2, 3),
            "angular_velocity": rng.uniform(-1, 1, 3),
            "angular_acceleration": rng.uniform(-2, 2, 3),
        }
        cases.append({**given, **expected(*given.values())})
    as_lists = [{k: np.asarray(v).tolist() for k, v in case.items()} for case in cases]
    return {"machine": machine, "inertia_scale": inertia_scale, "payload_mass": payload_mass, "cases": as_lists}


def main():
    rng = np.random.default_rng(SEED)
    plants = [plant(rng, reference_machine(), 1.0, 300.0), plant(rng, crooked_machine(rng), 1.37, 217.0)]
    golden.write(GOLDEN, {"jax": jax.__version__, "plants": plants})


if __name__ == "__main__":
    main()
