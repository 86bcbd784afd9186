"""Temperatures and energies of a warm drive, made by SciPy's DOP853; writes heat_golden.json beside this file.

The actuator of emla_oracle.py, moved and loaded as there, with currents as states, resistance and magnets at the temperatures of winding
and housing at every instant, and two thermal nodes that its losses warm.

    python -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    /tmp/venv/bin/python tests/oracle/heat_oracle.py
"""

import math

import emla_oracle as drive
import numpy as np
from emla_oracle import H, LEAD, P, TRAVEL
from golden import write
from scipy.integrate import solve_ivp

STEPS = 500
C_W, R_WH, C_H, R_HA = 2e3, 0.06, 15e3, 0.15
REFERENCE, COPPER, MAGNET = 293.15, 0.00393, -0.0011
AIR, START = 285.0, (351.0, 328.0)


def losses(y, v, x, x_dot):
    """Copper, iron, inverter and mechanical losses, W, the currents' rates and the motor's acceleration."""
    i_d, i_q, theta_m, w_m, T_w, T_h = y[:6]
    R = P["R_s"] * (1 + COPPER * (T_w - REFERENCE))
    lam_d = P["L_d"] * i_d + P["lambda_m"] * (1 + MAGNET * (T_h - REFERENCE))
    lam_q = P["L_q"] * i_q
    w_e = P["p"] * w_m
    tau_e = 1.5 * P["p"] * (lam_d * i_q - lam_q * i_d)
    force = drive.spring(theta_m, w_m, x, x_dot)
    a_m, a_s, tau_in, tau_out = drive.gear_torques(w_m, tau_e, force)
    w_s = w_m / P["N_gear"]
    i = math.hypot(i_d, i_q)
    inv = P["inverter"]
    core = (P["core"]["k_h"] * abs(w_e) + P["core"]["k_e"] * w_e**2) * (lam_d**2 + lam_q**2)
    conduction = 3 * (2 / math.pi * inv["v_0"] * i + inv["r_0"] * i * i / 2)
    switching = 6 / math.pi * inv["f_sw"] * inv["k_sw"] * inv["v_dc"] * i
    friction = (P["C_m"] * w_m + P["tau_C"] * math.tanh(w_m / P["w_C"])) * w_m
    gear = tau_in * w_m - tau_out * w_s
    screw = P["C_s"] * w_s**2
    slip = TRAVEL * w_m - x_dot
    stretch = TRAVEL * theta_m - x
    # The stiffness varies with x, which moves or takes energy; by a central difference of the compliance.
    d = 1e-6
    slope = (1 / drive.compliance(x + d) - 1 / drive.compliance(x - d)) / (2 * d)
    mechanical = friction + gear + screw + P["C_b"] * slip**2 + P["C_act"] * x_dot**2 - 0.5 * slope * x_dot * stretch**2
    rates = [
        (v[0] - R * i_d + w_e * lam_q) / P["L_d"],
        (v[1] - R * i_q - w_e * lam_d) / P["L_q"],
        w_m,
        a_m,
    ]
    return 1.5 * R * i * i, core, conduction + switching, mechanical, rates


def rhs(t, y, v, case):
    copper, core, inverter, mechanical, rates = losses(y, v, case["x"](t), case["x"](t, 1))
    inner, given = (y[4] - y[5]) / R_WH, (y[5] - AIR) / R_HA
    warming = [(copper - inner) / C_W, (core + mechanical + inner - given) / C_H]
    return rates + warming + [copper + core + inverter + mechanical, inverter, given]


def main():
    case = drive.cases()["motion"]
    psi, x_dot = drive.start(case), case["x"](0, 1)
    flux = P["lambda_m"] * (1 + MAGNET * (START[1] - REFERENCE))
    i_q = psi[1] / P["L_q"] * P["lambda_m"] / flux
    y, volts, rows = [0.0, i_q, psi[2], x_dot / TRAVEL, *START, 0.0, 0.0, 0.0], [], []
    for k in range(STEPS):
        t = k * H
        cold = [P["L_d"] * y[0] + P["lambda_m"], P["L_q"] * y[1], y[2], y[3]]
        v = drive.voltages(t, cold, case)
        volts.append(v)
        scale = np.array([1, 1, 1, 1, 1e-3, 1e-3, 1, 1, 1])
        solution = solve_ivp(rhs, (t, t + H), y, args=(v, case), method="DOP853", rtol=1e-12, atol=1e-12 * scale)
        assert solution.success, solution.message
        y = list(solution.y[:, -1])
        if (k + 1) % 50 == 0:
            rows.append({"volts": volts, "state": y[4:]})
            volts = []
    golden = {"made_by": "tests/oracle/heat_oracle.py", "air": AIR, "start": START, "F_hold": case["F_hold"], "x": case["x"].json(),
              "columns": ["T_winding", "T_housing", "energy.loss", "energy.loss_inverter", "energy.heat"], "rows": rows}
    write(drive.HERE / "heat_golden.json", golden)
    print(rows[-1]["state"])


if __name__ == "__main__":
    main()
