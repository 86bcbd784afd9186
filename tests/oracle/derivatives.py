"""Oracle of the derivatives: JAX differentiates the Lagrangian of the manipulator and a second model of the actuator.

    python tests/oracle/derivatives.py        (versions: requirements.txt)

writes `derivatives.json`: for random states, inputs and directions the derivatives of the outputs along a direction of the inputs,
and in time with the inputs changing at given rates. `tests/test_derivatives.py` (manipulator, through the FMU) and
`machine/emla/tests/oracle_derivatives.rs` read it. It may change when the reference parameters or the meaning of an output change,
never to follow the Rust code.

No derivative is written down here. The actuator differs from the Rust code as that of `emla_oracle.py` does: flux linkages as
states, two inertias and a gear constraint, losses of the mechanics as what the balance of power leaves.
"""

import math
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

import golden
from lagrangian import make
from mechanism import reference_machine, solve

GOLDEN = Path(__file__).with_name("derivatives.json")
SEED = 20261121
CASES = 24
MACHINE = reference_machine()
P = MACHINE["emla"]
LEAD = P["rho"] / (2 * math.pi)
TRAVEL = LEAD / P["N_gear"]


# Manipulator

INERTIA_SCALE, PAYLOAD = 1.2, 217.0
EXPECTED = make(MACHINE, INERTIA_SCALE, PAYLOAD)


def quaternion(R):
    """w, x, y, z with w > 0, for turns below half a revolution."""
    w = 0.5 * jnp.sqrt(1 + jnp.trace(R))
    return jnp.stack([w, *(jnp.stack([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4 * w))])


def hdrm_outputs(zeta, zeta_dot, f, tau, W_env):
    """By the names of the FMU's outputs."""
    y = EXPECTED(zeta, zeta_dot, f, tau, W_env)
    R = y["tip_rotation"].reshape(3, 3)
    out = {name: y[name] for name in ("x", "x_dot", "zeta_ddot", "f_hold", "tau_hold")}
    return out | {
        "zeta": zeta,
        "zeta_dot": zeta_dot,
        "tip.position": y["tip_position"],
        "tip.orientation": quaternion(R),
        "tip.velocity": jnp.concatenate([R @ y["tip_twist"][:3], R @ y["tip_twist"][3:]]),
        "energy.kinetic": y["kinetic"],
        "energy.potential": y["potential"],
    }


@jax.jit
def hdrm_derivatives(state, u, du, u_dot):
    zero = jnp.zeros(6)
    y, along = jax.jvp(hdrm_outputs, (*state, *u), (zero, zero, *du))
    _, rate = jax.jvp(hdrm_outputs, (*state, *u), (state[1], y["zeta_ddot"], *u_dot))
    return along, rate


def hdrm_case(rng):
    limits = MACHINE["limits"]
    low, high = np.radians(limits["zeta_min_deg"]), np.radians(limits["zeta_max_deg"])
    state = (low + (high - low) * rng.uniform(0.05, 0.95, 6), rng.uniform(-1, 1, 6))
    wrist = 0.9 * np.array(limits["tau_wrist_max"])
    sizes = [np.full(3, 6e4), wrist, np.array([4e3] * 3 + [1e3] * 3)]
    draw = lambda: [s * rng.uniform(-1, 1, len(s)) for s in sizes]
    u, du, u_dot = draw(), draw(), draw()
    while np.linalg.norm(quaternion(solve(MACHINE, state[0])[1][:3, :3])[0]) < 0.1:
        state = (low + (high - low) * rng.uniform(0.05, 0.95, 6), state[1])
    along, rate = hdrm_derivatives(state, u, du, u_dot)
    names = ("f", "tau_wrist", "wrench_env")
    named = {key: dict(zip(names, v)) for key, v in [("u", u), ("du", du), ("u_dot", u_dot)]}
    return {"zeta_start": state[0], "zeta_dot_start": state[1], **named, "along": along, "rate": rate}


# Actuator

U = ["v_d", "v_q", "x", "x_dot", "F_ext"]


def compliance(x):
    screw = x * (P["L_s"] - x) / P["L_s"] / P["EA"]
    return screw + 1 / (2 * P["K_br"]) + 1 / P["K_n"] + 1 / P["K_r"] + P["rho"] ** 2 * x / (4 * math.pi**2 * P["GJ"])


def emla(s, u, residual, free):
    """Rates of the states and outputs. `residual` = alpha dF is held; `free`: the rod is a mass, else it follows u."""
    lam = s[:2]
    theta_m, w_m = s[2], s[3]
    x, x_dot = (s[4], s[5]) if free else (u[2], u[3])
    i = jnp.stack([(lam[0] - P["lambda_m"]) / P["L_d"], lam[1] / P["L_q"]])
    size = jnp.sqrt(u[0] ** 2 + u[1] ** 2)
    v = u[:2] * jnp.where(size > P["v_max"], P["v_max"] / size, 1.0)
    tau_e = 1.5 * P["p"] * (lam[0] * i[1] - lam[1] * i[0])
    spring = P["C_b"] * (TRAVEL * w_m - x_dot) + (TRAVEL * theta_m - x) / compliance(x)
    F = spring - P["C_act"] * x_dot

    def gear(sign_of, w):
        drive = jnp.sign(sign_of) * jnp.tanh(w / P["w_eta"])
        return (1 + drive) / 2 / P["eta_gear"] + (1 - drive) / 2 * P["eta_gear"]

    load = P["C_s"] * w_m / P["N_gear"] + LEAD * (spring - residual)
    friction = P["C_m"] * w_m + P["tau_C"] * jnp.tanh(w_m / P["w_C"])
    k = gear(load, w_m)
    matrix = [[P["J_m"], 0, 1, 0], [0, P["J_s"], 0, -1], [1, -P["N_gear"], 0, 0], [0, 0, P["N_gear"], -k]]
    a_m = jnp.linalg.solve(jnp.array(matrix), jnp.stack([tau_e - friction, -load, 0.0, 0.0]))[0]
    copper = 1.5 * P["R_s"] * (i @ i)
    w_e = jnp.abs(P["p"] * w_m)
    core = (P["core"]["k_h"] * w_e + P["core"]["k_e"] * w_e**2) * (lam @ lam)
    inv, amplitude = P["inverter"], jnp.sqrt(i @ i)
    mean = 2 * amplitude / math.pi
    inverter = 3 * (inv["v_0"] * mean + inv["r_0"] * amplitude**2 / 2) + 6 / math.pi * inv["f_sw"] * inv["k_sw"] * inv["v_dc"] * amplitude
    P_in = 1.5 * (v @ i) + core + inverter
    P_out = (u[4] if free else F) * x_dot
    motion = jnp.stack([x_dot, (F - u[4]) / P["M_act"]]) if free else jnp.zeros(2)
    electric = jnp.stack([v[0] - P["R_s"] * i[0] + P["p"] * w_m * lam[1], v[1] - P["R_s"] * i[1] - P["p"] * w_m * lam[0]])
    rates = jnp.concatenate([electric, jnp.stack([w_m, a_m]), motion])
    # Quasi-static force: what is left when nothing accelerates and the rod goes with the nut.
    left = tau_e - friction
    torque = P["N_gear"] * left / gear(left, w_m)
    F_phys = (torque - P["C_s"] * w_m / P["N_gear"]) / LEAD - P["C_act"] * TRAVEL * w_m
    outputs = {
        "F": F, "F_phys": F_phys, "x_rod": x, "x_rod_dot": x_dot, "i_d": i[0], "i_q": i[1], "theta_m": theta_m, "w_m": w_m,
        "tau_e": tau_e, "P_in": P_in, "P_out": P_out, "P_copper": copper, "P_core": core, "P_inverter": inverter,
    }  # fmt: skip
    return rates, outputs


def stored(s, u, free):
    x, x_dot = (s[4], s[5]) if free else (u[2], u[3])
    i_d, i_q = (s[0] - P["lambda_m"]) / P["L_d"], s[1] / P["L_q"]
    field = 0.75 * (P["L_d"] * i_d**2 + P["L_q"] * i_q**2)
    turning = 0.5 * (P["J_m"] + P["J_s"] / P["N_gear"] ** 2) * s[3] ** 2
    spring = 0.5 * (TRAVEL * s[2] - x) ** 2 / compliance(x)
    return field + turning + spring + (0.5 * P["M_act"] * x_dot**2 if free else 0.0)


def emla_outputs(s, u, residual, free):
    rates, y = emla(s, u, residual, free)
    # The rod moves with its velocity; nothing else of the inputs is in the stored energy.
    moving = jnp.array([0.0, 0.0, 1.0, 0.0, 0.0]) * u[3]
    _, E_dot = jax.jvp(lambda s, u: stored(s, u, free), (s, u), (rates, moving))
    lost = y["P_in"] - y["P_out"] - E_dot
    mechanical = lost - y["P_copper"] - y["P_core"] - y["P_inverter"]
    return y | {"P_loss": lost, "P_mech": mechanical, "E_stored": stored(s, u, free)}


def emla_derivatives(s, u, du, u_dot, residual, free):
    outputs = lambda s, u: emla_outputs(s, u, residual, free)
    _, along = jax.jvp(outputs, (s, u), (jnp.zeros_like(s), du))
    rates, y = emla(s, u, residual, free)
    _, rate = jax.jvp(outputs, (s, u), (rates, u_dot))
    energies = emla_outputs(s, u, residual, free)
    rate |= {"E_in": y["P_in"], "E_out": y["P_out"], "E_loss": energies["P_loss"]}
    return along, rate


def emla_case(rng, free):
    x, x_dot = rng.uniform(0.05, 0.75), rng.uniform(0.01, 0.07) * rng.choice([-1, 1])
    F = rng.uniform(5e3, 70e3) * rng.choice([-1, 1])
    i_d, i_q = rng.uniform(-5, 5), rng.uniform(3, 40) * np.sign(F)
    w_m = x_dot / TRAVEL * rng.uniform(0.95, 1.05)
    theta_m = (x + F * float(compliance(x))) / TRAVEL
    residual = rng.uniform(-2e3, 2e3)
    volts = rng.choice([150.0, 900.0])  # inside and beyond the limit
    u = np.array([*rng.uniform(-volts, volts, 2), x, x_dot, rng.uniform(-7e4, 7e4)])
    sizes = np.array([100.0, 100.0, 1e-4, 1e-2, 1e4])
    du, u_dot = sizes * rng.uniform(-1, 1, 5), 10 * sizes * rng.uniform(-1, 1, 5)
    u_dot[2] = x_dot
    s = np.array([P["lambda_m"] + P["L_d"] * i_d, P["L_q"] * i_q, theta_m, w_m, x, x_dot])
    along, rate = emla_derivatives(s, u, du, u_dot, residual, free)
    state = {"i_d": i_d, "i_q": i_q, "theta_m": theta_m, "w_m": w_m, "x": x, "x_dot": x_dot, "alpha_dF": residual}
    named = {key: dict(zip(U, v)) for key, v in [("u", u), ("du", du), ("u_dot", u_dot)]}
    return {"drive": "Force" if free else "Motion", "state": state, **named, "along": along, "rate": rate}


def main():
    rng = np.random.default_rng(SEED)
    hdrm = {"inertia_scale": INERTIA_SCALE, "payload.mass": PAYLOAD, "cases": [hdrm_case(rng) for _ in range(CASES)]}
    emla = [emla_case(rng, k % 2 == 1) for k in range(2 * CASES)]
    golden.write(GOLDEN, {"jax": jax.__version__, "hdrm": hdrm, "emla": emla})


if __name__ == "__main__":
    main()
