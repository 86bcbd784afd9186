"""Oracle of the tip's contact with a plane: the Lagrangian machine of `lagrangian.py` under constant drive forces falls onto a plane and
slides on it, integrated by SciPy's DOP853.

    python tests/oracle/contact.py        (versions: tests/oracle/requirements.txt)

writes `contact.json`, which `machine/hdrm/tests/contact.rs` reads. It may change when the reference parameters or the law change, never to
follow the Rust code.
"""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from scipy.integrate import solve_ivp

import golden
from lagrangian import make
from mechanism import reference_machine, solve

GOLDEN = Path(__file__).with_name("contact.json")
CONTACT = {"normal": [0.3, 1.0, -0.2], "offset": 1.87, "stiffness": 2.3e5, "damping": 3.7, "friction": 0.37, "slip_velocity": 0.05}
STATE = {"zeta": [0.1, 0.68, -1.37, 0.2, -0.85, 0.1], "zeta_dot": [0.05, -0.1, -0.1, 0.0, 0.05, 0.0]}
DRIVES = {"f": [500.0, 36e3, 29e3], "tau": [-60.0, 120.0, 10.0]}
TIMES = np.linspace(0.0, 0.6, 7)


def main():
    machine = reference_machine()
    plant = make(machine, 1.0, 300.0)
    f, tau = jnp.array(DRIVES["f"]), jnp.array(DRIVES["tau"])
    n = jnp.array(CONTACT["normal"])
    n = n / jnp.linalg.norm(n)
    k, c, mu, v_s = (CONTACT[name] for name in ("stiffness", "damping", "friction", "slip_velocity"))
    tip = lambda zeta: solve(machine, zeta)[1]

    @jax.jit
    def rates(y):
        zeta, zeta_dot = y[:6], y[6:12]
        T, T_dot = jax.jvp(tip, (zeta,), (zeta_dot,))
        v = T_dot[:3, 3]
        depth, depth_dot = CONTACT["offset"] - n @ T[:3, 3], -(n @ v)
        v_t = v - n * (n @ v)
        F_n = jnp.where(depth > 0, k * depth * jnp.maximum(0.0, 1.0 + c * depth_dot), 0.0)
        force = F_n * n - mu * F_n * v_t / jnp.sqrt(v_t @ v_t + v_s**2)
        elastic = jnp.where(depth > 0, k * depth * depth_dot, 0.0)
        wrench = jnp.concatenate([T[:3, :3].T @ force, jnp.zeros(3)])
        zeta_ddot = plant(zeta, zeta_dot, f, tau, wrench)["zeta_ddot"]
        return jnp.concatenate([zeta_dot, zeta_ddot, jnp.array([-(force @ v) - elastic])]), force, depth

    start = np.concatenate([STATE["zeta"], STATE["zeta_dot"], [0.0]])
    solution = solve_ivp(lambda _, y: np.asarray(rates(jnp.array(y))[0]), (0.0, TIMES[-1]), start, method="DOP853", t_eval=TIMES, rtol=1e-11, atol=1e-12, max_step=1e-3)
    rows = []
    for t, y in zip(solution.t, solution.y.T):
        _, force, depth = rates(jnp.array(y))
        rows.append({"t": t, "zeta": y[:6].tolist(), "zeta_dot": y[6:12].tolist(), "loss": y[12], "force": force.tolist(), "depth": float(max(depth, 0.0))})
    golden.write(GOLDEN, {"contact": CONTACT, "start": STATE, "drives": DRIVES, "rows": rows})
    for row in rows:
        print(f"{row['t']:.1f} s: depth {1e3 * row['depth']:.3f} mm, force {np.round(row['force'], 1)} N, loss {row['loss']:.2f} J")


if __name__ == "__main__":
    main()
