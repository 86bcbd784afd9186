"""Reference trajectories of the actuator as built, made by SciPy's DOP853; writes rig_golden.json beside this file.

Independent of the Rust code: flux linkages in STATOR coordinates as states, so that the held voltages need no turning; phases a, b, c for
the dead time; bristles, play and temperatures in the same system of differential equations as all else, integrated at 1e-9 from one
switching period to the next. Equations from the books (Krause for the machine, Canudas de Wit et al. for the friction), parameters from
the machine's JSON and the values below, which are those of `Extras::AS_BUILT` (a test compares them).

    python -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy
    /tmp/venv/bin/python tests/oracle/rig_oracle.py

The golden file changes only when the reference actuator's parameters or this script change.
"""

import json
import math
import pathlib

import numpy as np
from scipy.integrate import solve_ivp

from wave import Wave

HERE = pathlib.Path(__file__).resolve().parent
P = json.loads((HERE.parent.parent / "parameters" / "reference_machine.json").read_text())["emla"]
X = {
    "saturation": {"share": 0.2},
    "temperature": {"reference": 293.15, "copper": 0.00393, "magnet": -0.0011},
    "ripple": {"sixth": 0.01, "twelfth": 0.01},
    "cogging": {"torque": 0.06, "per_turn": 24.0},
    "switching": {"dead_time": 2e-6, "i_0": 0.5, "offset": 0.0},
    "friction": {
        **{"breakaway": 1.3, "v_stribeck": 5e-3, "stiffness": 2e8, "damping": 2e5, "screw_drag": 0.5, "screw_loss": 0.026},
        **{"seal": 260.0, "gear_drag": 0.14, "gear_viscous": 0.0012, "gear_loss": 0.05, "windage": 4e-6, "f_smooth": 900.0},
        "asymmetry": 0.0,
    },
    "backlash": {"width": 40e-6, "contact": 5e-6},
    "compliance": {"mount": 6e7, "torsion": 2e4},
    "damping": {"mount": 2e4},  # off but where a case has it
    "losses": {"core": 1.15, "inverter": 1.1},
    "heat": {"C_w": 2e3, "R_wh": 0.06, "C_h": 15e3, "R_ha": 0.15},
}

H = 1e-3  # communication step, s
PERIODS = 8  # switching periods in it
STEPS = 1500
EVERY = 5  # steps between stored rows
T_SW = H / PERIODS
V_DC = 650.0
T_AIR = 293.15
LEAD = P["rho"] / (2 * math.pi)
TRAVEL = LEAD / P["N_gear"]
J = P["J_m"] + P["J_s"] / P["N_gear"] ** 2
ROOT3 = math.sqrt(3)
assert abs(T_SW * P["inverter"]["f_sw"] - 1) < 1e-12


def magnet_flux(theta_e, T_h):
    harmonics = 1 + X["ripple"]["sixth"] * math.cos(6 * theta_e) + X["ripple"]["twelfth"] * math.cos(12 * theta_e)
    return P["lambda_m"] * (1 + X["temperature"]["magnet"] * (T_h - X["temperature"]["reference"])) * harmonics


def resistance(T_w):
    return P["R_s"] * (1 + X["temperature"]["copper"] * (T_w - X["temperature"]["reference"]))


def cogging(theta_m):
    return X["cogging"]["torque"] * math.sin(X["cogging"]["per_turn"] * theta_m)


def current_of_flux(excess_d, lambda_q):
    """i_d and i_q in rotor coordinates; the saturation curve lambda = L i/(1 + a|i|) solved for i."""
    share = X["saturation"]["share"]
    a = share / (1 - share) / P["i_max"]
    return excess_d / P["L_d"], lambda_q / (P["L_q"] - a * abs(lambda_q))


def dead_time(i_d, i_q, theta_e):
    """Lost voltage in rotor coordinates, by way of the phases."""
    lost = []
    for shift in (0.0, 2 * math.pi / 3, -2 * math.pi / 3):
        i = i_d * math.cos(theta_e - shift) - i_q * math.sin(theta_e - shift)
        lost.append(V_DC * X["switching"]["dead_time"] / T_SW * i / math.hypot(i, X["switching"]["i_0"]))
    park = lambda f: 2 / 3 * sum(v * f(theta_e - s) for v, s in zip(lost, (0.0, 2 * math.pi / 3, -2 * math.pi / 3)))
    return park(math.cos), -park(math.sin)


def stiffness(x):
    x = min(max(x, 0.0), P["L_s"])
    screw = x * (P["L_s"] - x) / P["L_s"] / P["EA"] + LEAD**2 * x / P["GJ"]
    rest = 1 / (2 * P["K_br"]) + 1 / P["K_n"] + 1 / P["K_r"] + 1 / X["compliance"]["mount"] + LEAD**2 / X["compliance"]["torsion"]
    return 1 / (screw + rest)


def damping(x, in_parts):
    """Damper over the whole connection. In parts, each with its own, it loses what they lose when each part stretches by F/K_part."""
    if not in_parts:
        return P["C_b"]
    mounting = 1 / X["compliance"]["mount"] + LEAD**2 / X["compliance"]["torsion"]
    screw = 1 / stiffness(x) - mounting
    return (P["C_b"] * screw**2 + X["damping"]["mount"] * mounting**2) * stiffness(x) ** 2


def contact(lead, rate, x, in_parts):
    """Force of the nut on the rod."""
    half = X["backlash"]["width"] / 2
    if abs(lead) <= half:
        return 0.0
    depth = abs(lead) - half
    push = stiffness(x) * depth + damping(x, in_parts) * min(1.0, depth / X["backlash"]["contact"]) * rate * math.copysign(1, lead)
    return math.copysign(max(push, 0.0), lead)


def sliding(v, F):
    f = X["friction"]
    idle = (P["tau_C"] + f["gear_drag"]) / TRAVEL + f["screw_drag"] / LEAD + f["seal"]
    loaded = idle + (f["screw_loss"] + f["gear_loss"]) * F**2 / math.hypot(F, f["f_smooth"])
    loaded *= 1 + f["asymmetry"] * math.copysign(1, v)
    return loaded * (1 + (f["breakaway"] - 1) * math.exp(-((v / f["v_stribeck"]) ** 2)))


def instant(t, y, held, rod, external, in_parts):
    """Everything at one instant; y = excess flux d, flux q (rotor coordinates), theta_m, w_m, z, T_w, T_h, impulse (and x, x_dot)."""
    excess_d, lambda_q, theta_m, w_m, z, T_w, T_h = y[:7]
    theta_e, w_e = P["p"] * theta_m, P["p"] * w_m
    i_d, i_q = current_of_flux(excess_d, lambda_q)
    lambda_d = excess_d + magnet_flux(theta_e, T_h)
    lost_d, lost_q = dead_time(i_d, i_q, theta_e)
    v_d = held[0] * math.cos(theta_e) + held[1] * math.sin(theta_e) - lost_d
    v_q = held[1] * math.cos(theta_e) - held[0] * math.sin(theta_e) - lost_q
    x, x_dot = rod(t) if rod else (y[8], y[9])
    v = TRAVEL * w_m
    F_link = contact(TRAVEL * theta_m - x, v - x_dot, x, in_parts)
    f, g = X["friction"], sliding(v, F_link)
    z_dot = v - f["stiffness"] * abs(v) / g * z
    F_b = f["stiffness"] * z + f["damping"] * math.exp(-((v / f["v_stribeck"]) ** 2)) * z_dot
    tau_e = 1.5 * P["p"] * (lambda_d * i_q - lambda_q * i_d)
    viscous = (P["C_m"] + f["gear_viscous"] + P["C_s"] / P["N_gear"] ** 2 + f["windage"] * abs(w_m)) * w_m
    w_dot = (tau_e + cogging(theta_m) - viscous - TRAVEL * (F_link + F_b)) / J
    F = F_link - P["C_act"] * x_dot
    R = resistance(T_w)
    copper = 1.5 * R * (i_d**2 + i_q**2)
    core = X["losses"]["core"] * (P["core"]["k_h"] + P["core"]["k_e"] * abs(w_e)) * abs(w_e) * (lambda_d**2 + lambda_q**2)
    # Friction: torque times speed less what the bristles keep; link: what does not become spring energy; rod.
    half = X["backlash"]["width"] / 2
    lead = TRAVEL * theta_m - x
    delta = math.copysign(max(abs(lead) - half, 0.0), lead)
    step = 1e-7
    K_slope = (stiffness(x + step) - stiffness(x - step)) / (2 * step)
    rubbed = viscous * w_m + F_b * v - f["stiffness"] * z * z_dot + P["C_act"] * x_dot**2
    rubbed += (F_link - stiffness(x) * delta) * (v - x_dot) - 0.5 * K_slope * x_dot * delta**2
    inner = (T_w - T_h) / X["heat"]["R_wh"]
    rates = [
        v_d - R * i_d + w_e * lambda_q,
        v_q - R * i_q - w_e * lambda_d,
        w_m,
        w_dot,
        z_dot,
        (copper - inner) / X["heat"]["C_w"],
        (core + rubbed + inner - (T_h - T_AIR) / X["heat"]["R_ha"]) / X["heat"]["C_h"],
        F,
    ]
    if not rod:
        rates += [x_dot, (F - external) / P["M_act"]]
    return rates, {"F": F, "i_d": i_d, "i_q": i_q, "x": x, "x_dot": x_dot, "tau_e": tau_e}


def turned(v_d, v_q, theta_e):
    return (v_d * math.cos(theta_e) - v_q * math.sin(theta_e), v_d * math.sin(theta_e) + v_q * math.cos(theta_e))


def start(case):
    """At rest under F_hold: no friction, the current that balances load and cogging, the voltage that holds it."""
    x, F, (T_w, T_h) = case["x"](0), case["F_hold"], case["T_start"]
    lead = F / stiffness(x) + math.copysign(X["backlash"]["width"] / 2, F)
    theta_m = (x + lead) / TRAVEL
    theta_e = P["p"] * theta_m
    flux = magnet_flux(theta_e, T_h)
    i_q = (TRAVEL * F - cogging(theta_m)) / (1.5 * P["p"] * flux)
    share = X["saturation"]["share"]
    lambda_q = P["L_q"] * i_q / (1 + share / (1 - share) * abs(i_q) / P["i_max"])
    lost = dead_time(0.0, i_q, theta_e)
    held = turned(lost[0], resistance(T_w) * i_q + lost[1], theta_e)
    y = [0.0, lambda_q, theta_m, 0.0, 0.0, T_w, T_h, 0.0]
    return y + ([x, 0.0] if case["drive"] == "force" else []), held


def limited(v_d, v_q):
    largest = min(P["v_max"], V_DC / ROOT3)
    return tuple(np.array([v_d, v_q]) * min(1.0, largest / max(math.hypot(v_d, v_q), 1e-300)))


def run(case):
    y, acting = start(case)
    after, rows = acting, []
    # The drive takes the rotor for turned by `offset`: it commands and tells by that.
    in_parts, offset = case.get("damping", False), case.get("offset", 0.0)
    for k in range(STEPS):
        t_k = k * H
        v = limited(case["v_d"](t_k), case["v_q"](t_k))
        external = case["F_ext"](t_k)
        x_k, x_dot_k = case["x"](t_k), case["x"](t_k, 1)
        rod = (lambda t: (x_k + x_dot_k * (t - t_k), x_dot_k)) if case["drive"] == "motion" else None
        if k % EVERY == 0:
            _, now = instant(t_k, y, acting, rod, external, in_parts)
            if offset:
                now["i_d"], now["i_q"] = turned(now["i_d"], now["i_q"], -offset)
            mean = y[7] / H if k else case["F_hold"]
            rows.append([now["F"], mean, now["i_d"], now["i_q"], y[2], y[3], y[4], now["x"], now["x_dot"], y[5], y[6], now["tau_e"]])
        y = [*y[:7], 0.0, *y[8:]]
        for period in range(PERIODS):
            t = t_k + period * T_SW
            acting, after = after, turned(*v, P["p"] * (y[2] + 1.5 * T_SW * y[3]) + offset)
            y = solve_ivp(
                lambda t, y: instant(t, y, acting, rod, external, in_parts)[0],
                (t, t + T_SW), y, method="DOP853", rtol=1e-9, atol=[1e-10, 1e-10, 1e-9, 1e-7, 1e-14, 1e-9, 1e-9, 1e-7] + [1e-13, 1e-11] * (len(y) > 8),
                max_step=T_SW / 2,
            ).y[:, -1].tolist()  # fmt: skip
    return rows


def main():
    EMF = P["p"] * P["lambda_m"] / TRAVEL  # V per m/s
    f, amplitude = 0.8, 9e-3
    swing = 2 * math.pi * f * amplitude
    cases = [
        {
            "name": "a mechanism swings the rod while the motor pushes and pulls: stiction, backlash and full presliding loops",
            **{"drive": "motion", "F_hold": 12e3, "T_start": [330.0, 310.0]},
            **{"x": Wave(0.3 + amplitude, (amplitude, f, -math.pi / 2)), "F_ext": Wave(0.0)},
            **{"v_d": Wave(0.0, (2.0, 2.3, 0.0)), "v_q": Wave(0.0, (EMF * swing, f, 0.0), (16.0, 1.7, 0.6))},
        },
        {
            "name": "a free rod under a load that reverses",
            **{"drive": "force", "F_hold": -8e3, "T_start": [350.0, 320.0]},
            **{"x": Wave(0.25), "F_ext": Wave(0.0, (14e3, 1.9, -0.61))},
            **{"v_d": Wave(-2.0), "v_q": Wave(0.0, (35.0, 1.3, -0.5))},
        },
        {
            "name": "the same mechanism with damping in its parts and a drive that errs in the rotor's angle by 4 degrees",
            **{"drive": "motion", "F_hold": 12e3, "T_start": [330.0, 310.0], "damping": True, "offset": 0.07},
            **{"x": Wave(0.3 + amplitude, (amplitude, f, -math.pi / 2)), "F_ext": Wave(0.0)},
            **{"v_d": Wave(0.0, (2.0, 2.3, 0.0)), "v_q": Wave(0.0, (EMF * swing, f, 0.0), (16.0, 1.7, 0.6))},
        },
    ]  # fmt: skip
    for case in cases:
        rows = run(case)
        case["rows"] = [[float(f"{value:.10g}") for value in row] for row in rows]
        force = np.array(rows)[:, 0]
        print(case["name"], "peak", np.abs(force).max(), "sign changes", int((np.diff(np.sign(force)) != 0).sum()),
              "within play", int((force == 0).sum()), "speed", np.abs(np.array(rows)[:, 5]).max(), "z", np.abs(np.array(rows)[:, 6]).max())  # fmt: skip
    columns = "F F_mean i_d i_q theta_m w_m z x x_dot T_w T_h tau_e".split()
    text = json.dumps({"step": H, "every": EVERY, "v_dc": V_DC, "T_ambient": T_AIR, "extras": X, "columns": columns, "cases": cases}, default=lambda w: w.json())
    (HERE / "rig_golden.json").write_text(text.replace("], [", "],\n[") + "\n")


if __name__ == "__main__":
    main()
