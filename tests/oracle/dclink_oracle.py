"""Reference trajectories of the DC link and of a published cell, made by SciPy's DOP853; writes dclink_golden.json beside this file.

Independent of the Rust code: the circuit's nodes by Kirchhoff's laws, energies in the same system of differential equations, integrated at
1e-12 from one event to the next; the events (limits, chopper, precharge) by SciPy's own root finding.

The published cell is `Modelica.Electrical.Batteries.Examples.CCCV_CellRC` of the Modelica Standard Library 4.0.0: a cell of 5 A.h with two RC
elements is charged from a state of charge of 0.1 with 25 A up to 4.2 V, then at 4.2 V, over 1200 s. Parameters are those of its records
`TransientData.ExampleData` and `CCCV_CellRC`; left out is the self-discharge of 1 mA (4e-5 of the current), and the table of the open-circuit
voltage is joined by straight lines at steps of 0.05 where the library draws a smooth curve through the same points.

    python -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    /tmp/venv/bin/python tests/oracle/dclink_oracle.py

The golden file changes only when this script changes.
"""

import json
import math
import pathlib

import numpy as np
from scipy.integrate import solve_ivp

HERE = pathlib.Path(__file__).resolve().parent
H = 1e-3  # communication step, s
EVERY = 25  # communication points between two rows

OCV = [3.000, 3.100, 3.175, 3.205, 3.225, 3.240, 3.250, 3.257, 3.263, 3.268, 3.272, 3.276, 3.280, 3.284, 3.288, 3.292]
OCV += [3.296, 3.300, 3.306, 3.325, 3.400]
P = {
    **{"cells": 200, "capacity": 20.0, "R_0": 0.12, "R": [0.08, 0.05], "tau": [30.0, 0.7], "discharge_limit": 60.0, "charge_limit": 20.0},
    **{"soc_low": 0.05, "soc_high": 0.95, "heat_capacity": 60e3, "heat_resistance": 0.5, "T_start": 293.15, "T_ambient": 288.15},
    **{"C": 12e-3, "R_line": 0.02, "R_brake": 20.0, "v_on": 750.0, "v_off": 730.0, "R_precharge": 50.0, "share": 0.95},
}

#: Loads: offset, then (amplitude, frequency, phase) of sines, A, Hz, rad; each drive takes its share of the sum.
CASES = {
    "limits": {"soc_start": 0.6, "precharge": False, "load": [15.0, [70.0, 0.8, 0.3], [9.0, 7.0, 1.0]], "until": 2.0},
    "full": {"soc_start": 0.999, "precharge": False, "load": [-22.0, [25.0, 1.3, 0.0]], "until": 2.0},
    "precharge": {"soc_start": 0.3, "precharge": True, "load": [0.0], "until": 2.5},
}
SHARES = [0.5, 0.2, 0.3]


def open_circuit(soc):
    return P["cells"] * np.interp(soc, np.linspace(0, 1, 21), OCV)


def allowed(soc):
    give = P["discharge_limit"] * min(1.0, soc / P["soc_low"])
    return give, P["charge_limit"] * min(1.0, (1.0 - soc) / (1.0 - P["soc_high"]))


def current(x, mode):
    soc, v_1, v_2, v_c = x[:4]
    give, take = allowed(soc)
    R = P["R_0"] + P["R_line"] + (0.0 if mode["ready"] else P["R_precharge"])
    free = (open_circuit(soc) - v_1 - v_2 - v_c) / R
    return free, {"free": free, "give": give, "take": -take}[mode["limit"]]


def rates(x, mode, i_load):
    soc, v_1, v_2, v_c, T = x[:5]
    _, i = current(x, mode)
    through_1, through_2 = v_1 / P["R"][0], v_2 / P["R"][1]
    C_1, C_2 = P["tau"][0] / P["R"][0], P["tau"][1] / P["R"][1]
    i_brake = v_c / P["R_brake"] if mode["brake"] else 0.0
    heat = P["R_0"] * i * i + v_1 * through_1 + v_2 * through_2
    v_oc = open_circuit(soc)
    lead = (v_oc - v_1 - v_2 - P["R_0"] * i - v_c) * i  # wiring, precharge and limit: what the pack gives less what arrives
    return [
        -i / (3600.0 * P["capacity"]),
        (i - through_1) / C_1,
        (i - through_2) / C_2,
        (i - i_brake - i_load) / P["C"],
        (heat - (T - P["T_ambient"]) / P["heat_resistance"]) / P["heat_capacity"],
        v_oc * i,
        v_c * i_load,
        v_c * i_brake,
        heat + lead,
    ]


def ends(mode):
    """Functions that rise through 0 where the mode ends, with what they change."""
    over = lambda x: current(x, mode)[0] - allowed(x[0])[0]
    under = lambda x: -allowed(x[0])[1] - current(x, mode)[0]
    found = {
        "free": [(over, ("limit", "give")), (under, ("limit", "take"))],
        "give": [(lambda x: -over(x), ("limit", "free"))],
        "take": [(lambda x: -under(x), ("limit", "free"))],
    }[mode["limit"]]
    if mode["brake"]:
        found.append((lambda x: P["v_off"] - x[3], ("brake", False)))
    else:
        found.append((lambda x: x[3] - P["v_on"], ("brake", True)))
    if not mode["ready"]:
        found.append((lambda x: x[3] - P["share"] * (open_circuit(x[0]) - x[1] - x[2]), ("ready", True)))
    return found


def limited(x, mode):
    free, (give, take) = current(x, {**mode, "limit": "free"})[0], allowed(x[0])
    return {**mode, "limit": "give" if free > give else "take" if free < -take else "free"}


def step(x, mode, i_load):
    """One communication step; also the number of events in it."""
    t, count = 0.0, 0
    mode = limited(x, mode)
    while True:
        functions = ends(mode)
        events = []
        for function, _ in functions:
            event = lambda t, x, function=function: function(x)
            event.terminal, event.direction = True, 1
            events.append(event)
        done = solve_ivp(lambda t, x: rates(x, mode, i_load), (t, H), x, method="DOP853", rtol=1e-12, atol=1e-13, events=events)
        x = done.y[:, -1]
        if done.status == 0:
            return x, mode, count
        t, count = done.t[-1], count + 1
        fired = next(k for k, times in enumerate(done.t_events) if len(times))
        name, value = functions[fired][1]
        mode = {**mode, name: value}
        if name == "ready":
            mode = limited(x, mode)


def wave(load, t):
    return load[0] + sum(a * math.sin(2.0 * math.pi * f * t + p) for a, f, p in load[1:])


def run(case):
    v_oc = open_circuit(case["soc_start"])
    x = np.array([case["soc_start"], 0.0, 0.0, 0.0 if case["precharge"] else v_oc, P["T_start"], 0.0, 0.0, 0.0, 0.0])
    mode = {"limit": "free", "brake": False, "ready": not case["precharge"]}
    rows, events = [], 0
    for k in range(round(case["until"] / H)):
        x, mode, count = step(x, mode, wave(case["load"], k * H))
        events += count
        if (k + 1) % EVERY == 0:
            rows.append([(k + 1) * H, *x, current(x, mode)[1], float(mode["brake"]), float(mode["ready"])])
    names = "t soc v_1 v_2 v_dc T battery load brake loss i braking ready".split()
    return {**case, "events": events, "columns": names, "rows": rows}


# The published cell.
RI = 4.2 / 1200
CELL = {"charge": 18000.0, "R_0": 0.7 * RI, "R": [0.2 * RI, 0.1 * RI], "tau": [60.0, 10.0], "I": 25.0, "V": 4.2, "soc_start": 0.1}
TABLE = [0.595, 0.744, 0.761, 0.774, 0.786, 0.795, 0.804, 0.811, 0.818, 0.826, 0.835, 0.843, 0.855, 0.871, 0.888, 0.905]
TABLE += [0.926, 0.943, 0.964, 0.980, 1.00]


def charged():
    """Rows of the cell's charging: time, charge, terminal voltage, current into it; and when 4.2 V is reached."""
    ocv = lambda soc: 4.2 * np.interp(soc, np.linspace(0, 1, 21), TABLE)
    inner = lambda x: ocv(x[0]) + x[1] + x[2]
    held = lambda x: (CELL["V"] - inner(x)) / CELL["R_0"]

    def slope(x, i):
        return [i / CELL["charge"], *((CELL["R"][k] * i - x[1 + k]) / CELL["tau"][k] for k in (0, 1))]

    full = lambda t, x: inner(x) + CELL["R_0"] * CELL["I"] - CELL["V"]
    full.terminal, full.direction = True, 1
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.5, "dense_output": True}
    first = solve_ivp(lambda t, x: slope(x, CELL["I"]), (0, 1200), [CELL["soc_start"], 0, 0], events=full, **options)
    switch = first.t[-1]
    second = solve_ivp(lambda t, x: slope(x, held(x)), (switch, 1200), first.y[:, -1], **options)
    rows = []
    for t in range(20, 1201, 20):
        x = first.sol(t) if t <= switch else second.sol(t)
        i = CELL["I"] if t <= switch else held(x)
        rows.append([float(t), x[0], inner(x) + CELL["R_0"] * i, i])
    return {"switch": switch, "columns": ["t", "soc", "v", "i"], "rows": rows, **CELL, "ocv": [4.2 * y for y in TABLE]}


if __name__ == "__main__":
    golden = {"h": H, "shares": SHARES, "parameters": {**P, "ocv": OCV}, "cases": {name: run(case) for name, case in CASES.items()}}
    golden["cell"] = charged()
    (HERE / "dclink_golden.json").write_text(json.dumps(golden) + "\n")
    print({name: case["events"] for name, case in golden["cases"].items()}, golden["cell"]["switch"], golden["cell"]["rows"][-1])
