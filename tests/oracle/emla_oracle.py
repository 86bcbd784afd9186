"""Reference trajectories of the actuator, made by SciPy's DOP853; writes emla_golden.json beside this file.

Independent of the Rust code: flux linkages as states instead of currents, motor and screw as two
inertias, and the gear as a constraint whose two torques and two accelerations are solved from four
linear equations. Voltages are held over each millisecond, rod motion and external force are continuous.

    python -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    /tmp/venv/bin/python tests/oracle/emla_oracle.py

The golden file changes only when the reference actuator's parameters or this script change.
"""

import json
import math
import pathlib

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from golden import write
from wave import Wave

HERE = pathlib.Path(__file__).resolve().parent
PARAMETERS = HERE.parent.parent / "parameters" / "reference_machine.json"
P = json.loads(PARAMETERS.read_text())["emla"]

H = 1e-3  # communication step, s
STEPS = 2000
EVERY = 4  # steps between stored rows
LEAD = P["rho"] / (2 * math.pi)
TRAVEL = LEAD / P["N_gear"]


def compliance(x):
    x = min(max(x, 0.0), P["L_s"])
    screw = x * (P["L_s"] - x) / P["L_s"] / P["EA"]
    supports = 1 / (2 * P["K_br"]) + 1 / P["K_n"] + 1 / P["K_r"]
    return screw + supports + P["rho"] ** 2 * x / (4 * math.pi**2 * P["GJ"])


def gear_torques(w_m, tau_e, F_nut):
    """Motor acceleration from the unknowns (motor and screw acceleration, gear torque in and out)."""
    w_s = w_m / P["N_gear"]
    load = P["C_s"] * w_s + LEAD * F_nut
    drive = math.copysign(1.0, load) * math.tanh(w_m / P["w_eta"])  # 1: motor drives, -1: load drives
    k = (1 + drive) / 2 / P["eta_gear"] + (1 - drive) / 2 * P["eta_gear"]
    friction = P["C_m"] * w_m + P["tau_C"] * math.tanh(w_m / P["w_C"])
    matrix = np.array(
        [
            [P["J_m"], 0, 1, 0],  # J_m a_m + tau_in = tau_e - friction
            [0, P["J_s"], 0, -1],  # J_s a_s - tau_out = -load
            [1, -P["N_gear"], 0, 0],  # a_m = N a_s
            [0, 0, P["N_gear"], -k],  # N tau_in = k tau_out
        ]
    )
    return np.linalg.solve(matrix, [tau_e - friction, -load, 0, 0])


def currents(y):
    return (y[0] - P["lambda_m"]) / P["L_d"], y[1] / P["L_q"]


def spring(theta_m, w_m, x, x_dot):
    return P["C_b"] * (TRAVEL * w_m - x_dot) + (TRAVEL * theta_m - x) / compliance(x)


def rhs(t, y, v, case):
    """y = lambda_d, lambda_q, theta_m, w_m, impulse of F (and x, x_dot with a free rod)."""
    i_d, i_q = currents(y)
    theta_m, w_m = y[2:4]
    free = len(y) == 7
    x, x_dot = y[5:7] if free else (case["x"](t), case["x"](t, 1))
    force = spring(theta_m, w_m, x, x_dot)
    tau_e = 1.5 * P["p"] * (y[0] * i_q - y[1] * i_d)
    F = force - P["C_act"] * x_dot
    dy = [
        v[0] - P["R_s"] * i_d + P["p"] * w_m * y[1],
        v[1] - P["R_s"] * i_q - P["p"] * w_m * y[0],
        w_m,
        gear_torques(w_m, tau_e, force)[0],
        F,
    ]
    if free:
        dy += [x_dot, (F - case["F_ext"](t)) / P["M_act"]]
    return dy


def start(case):
    """Steady motion at the start velocity that delivers F_hold."""
    x, x_dot = case["x"](0), case["x"](0, 1)
    w_m = x_dot / TRAVEL
    force = case["F_hold"] + P["C_act"] * x_dot
    torque = brentq(lambda tau: gear_torques(w_m, tau, force)[0], -200, 200, xtol=1e-14, rtol=1e-15)
    i_q = torque / (1.5 * P["p"] * P["lambda_m"])
    y = [P["lambda_m"], P["L_q"] * i_q, (x + force * compliance(x)) / TRAVEL, w_m, 0.0]
    return y + ([x, x_dot] if "F_ext" in case else [])


def voltages(t, y, case):
    """A plain current and speed control, so that the run stays in the actuator's range; rounded to
    millivolts, because these numbers go into the golden file and are the inputs of both codes."""
    i_d, i_q = currents(y)
    w_ref, w_e = case["x"](t, 1) / TRAVEL, P["p"] * y[3]
    i_ref = case["load"](t) * TRAVEL / (1.5 * P["p"] * P["lambda_m"]) + 0.5 * (w_ref - y[3])
    v_d = P["R_s"] * i_d - w_e * y[1] - 0.9 * (i_d - case["i_d"](t))
    v_q = P["R_s"] * i_q + w_e * y[0] + 0.9 * (i_ref - i_q)
    return round(v_d, 3), round(v_q, 3)


def run(case):
    """The states every `EVERY` steps, each with the voltages of the steps that lead to it."""
    y, rows, volts, impulse = start(case), [], [], 0.0
    free = len(y) == 7
    for k in range(STEPS + 1):
        t = k * H
        if k % EVERY == 0:
            x, x_dot = y[5:7] if free else (case["x"](t), case["x"](t, 1))
            F = spring(y[2], y[3], x, x_dot) - P["C_act"] * x_dot
            state = [F, impulse / H if k else case["F_hold"], *currents(y), y[3], x]
            rows.append({"volts": volts, "state": state})
            volts = []
        if k == STEPS:
            return rows
        v = voltages(t, y, case)
        volts.append(v)
        y[4] = 0.0
        scale = [1e-3, 1e-3, 1.0, 1.0, 1.0, 1e-3, 1e-3][: len(y)]
        options = dict(method="DOP853", rtol=1e-12, atol=1e-12 * np.array(scale))
        solution = solve_ivp(rhs, (t, t + H), y, args=(v, case), **options)
        assert solution.success, solution.message
        y = list(solution.y[:, -1])
        impulse = y[4]


def cases():
    """Speed and load of different periods, so that all four quadrants and load reversals occur."""
    x = Wave(0.31, (0.008, 1.0, 0.3), (0.0009, 2.3, 1.1))
    load = Wave(5000.0, (37000.0, 0.5, 0.6), (2500.0, 3.1, 0.0))
    common = {"x": x, "load": load, "i_d": Wave(-1.0, (4.0, 1.7, 0.2)), "F_hold": load(0.0)}
    return {"motion": common, "force": common | {"F_ext": load}}


def main():
    golden = {"made_by": "tests/oracle/emla_oracle.py", "h": H, "cases": {}}
    golden["columns"] = ["F", "F_mean", "i_d", "i_q", "w_m", "x"]
    for name, case in cases().items():
        rows = run(case)
        inputs = {k: v.json() for k, v in case.items() if k in ("x", "F_ext")}
        golden["cases"][name] = inputs | {"F_hold": case["F_hold"], "rows": rows}
        F, i_d, i_q, w, x = np.array([row["state"] for row in rows])[:, [0, 2, 3, 4, 5]].T
        volts = np.array([v for row in rows for v in row["volts"]])
        quadrants = [int(np.sum((np.sign(F) == f) & (np.sign(w) == s))) for f in (1, -1) for s in (1, -1)]
        ranges = [f"{n} {v.min():.5g}..{v.max():.5g}" for n, v in
                  [("F", F), ("i_d", i_d), ("i_q", i_q), ("w_m", w), ("x", x), ("v", volts)]]
        print(f"{name}: {', '.join(ranges)}; rows with (F, w) ++ +- -+ --: {quadrants}")
    write(HERE / "emla_golden.json", golden)


if __name__ == "__main__":
    main()
