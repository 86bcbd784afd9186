"""The interface other people's wiring relies on: names with sizes, units, causality."""

ROD = {"x": "m", "x_dot": "m/s", "F_ext": "N", "F_hold": "N"}

BASE_TURNS = {"base.angular_velocity[1..3]": "rad/s", "base.angular_acceleration[1..3]": "rad/s2"}

INPUTS = {
    "Emla": {"v_d": "V", "v_q": "V", **ROD},
    "Rig": {"v_d": "V", "v_q": "V", "v_dc": "V", "T_ambient": "K", **ROD},
    "Sensors": {
        **{"zeta[1..6]": "rad", "zeta_dot[1..6]": "rad/s", "theta_m[1..3]": "rad", "w_m[1..3]": "rad/s", "i_d[1..3]": "A"},
        **{"i_q[1..3]": "A", "F[1..3]": "N", "x[1..3]": "m", "x_dot[1..3]": "m/s"},
    },
    "DcLink": {"i_load[1..3]": "A", "T_ambient": "K"},
    "Hdrm": {
        **{"f[1..3]": "N", "tau_wrist[1..3]": "N.m", "wrench_env[1..3]": "N", "wrench_env[4..6]": "N.m"},
        **{"base.acceleration[1..3]": "m/s2", "base.tilt[1..2]": "rad", **BASE_TURNS, "load.mass": "kg", "load.com[1..3]": "m"},
    },
    "Controller": {
        "zeta[1..6]": "rad",
        "zeta_dot[1..6]": "rad/s",
        "i_d[1..3]": "A",
        "i_q[1..3]": "A",
        "w_m[1..3]": "rad/s",
        "x_dot[1..3]": "m/s",
        "F[1..3]": "N",
        "reference.position[1..3]": "m",
        "reference.velocity[1..3]": "m/s",
        "reference.acceleration[1..3]": "m/s2",
        "reference.orientation[1..4]": "1",
        "reference.angular_velocity[1..3]": "rad/s",
        **{"base.acceleration[1..3]": "m/s2", "base.tilt[1..2]": "rad", **BASE_TURNS},
        **{"rate.joint[1..6]": "rad/s", "rate.tip[1..3]": "m/s", "rate.tip[4..6]": "rad/s"},
    },
}

OUTPUTS = {
    "Rig": {
        **{"F": "N", "F_mean": "N", "x_rod": "m", "x_rod_dot": "m/s", "i_d": "A", "i_q": "A", "theta_m": "rad", "w_m": "rad/s", "tau_e": "N.m"},
        **dict.fromkeys(["P_in", "P_in_mean", "P_out", "P_loss", "P_heat"], "W"),
        **{"i_dc": "A", "T_winding": "K", "T_housing": "K", "efficiency": "1", "efficiency_valid": None},
    },
    "DcLink": {
        **{"v_dc": "V", "v_dc_mean": "V", "i_battery": "A", "v_battery": "V", "soc": "1", "P_brake": "W", "P_loss": "W", "T_battery": "K"},
        **dict.fromkeys(["energy.battery", "energy.load", "energy.brake", "energy.loss", "energy.stored"], "J"),
        **dict.fromkeys(["ready", "precharging", "braking", "limited", "undervoltage"]),
    },
    "Sensors": {
        **{"zeta_measured[1..6]": "rad", "zeta_dot_measured[1..6]": "rad/s", "i_d_measured[1..3]": "A", "i_q_measured[1..3]": "A"},
        **{"w_m_measured[1..3]": "rad/s", "x_dot_measured[1..3]": "m/s", "F_measured[1..3]": "N"},
    },
    "Emla": {
        **dict.fromkeys(["F", "F_mean", "F_phys", "F_hyb"], "N"),
        "x_rod": "m",
        "x_rod_dot": "m/s",
        "i_d": "A",
        "i_q": "A",
        "theta_m": "rad",
        "w_m": "rad/s",
        "tau_e": "N.m",
        **dict.fromkeys(["P_in", "P_out", "P_loss"], "W"),
        "efficiency": "1",
        "efficiency_valid": None,
    },
    "Hdrm": {
        "x[1..3]": "m",
        "x_dot[1..3]": "m/s",
        "zeta[1..6]": "rad",
        "zeta_dot[1..6]": "rad/s",
        "zeta_ddot[1..6]": "rad/s2",
        "f_hold[1..3]": "N",
        "tip.position[1..3]": "m",
        "tip.orientation[1..4]": "1",
        "tip.velocity[1..3]": "m/s",
        "tip.velocity[4..6]": "rad/s",
        **dict.fromkeys(["energy.kinetic", "energy.potential", "energy.load", "energy.contact", "energy.contact_loss"], "J"),
        **{"contact.force[1..3]": "N", "contact.penetration": "m"},
    },
    "Controller": {
        "v_d[1..3]": "V",
        "v_q[1..3]": "V",
        "tau_wrist[1..3]": "N.m",
        "f_required[1..3]": "N",
        "x_dot_required[1..3]": "m/s",
        "desired.position[1..3]": "m",
        "tip_error[1..3]": "m",
        "tip_error_norm": "m",
        **{f"mass_hat.{body}": "kg" for body in "T1 A2 C2 D2 A3 C3 D3 RK CP A4 C4 D4 PL".split()},
        "lyapunov.nu_velocity": "J",
        "lyapunov.nu_adaptation": "J",
        "lyapunov.nu_actuator[1..3]": "J",
        **{"load.mass": "kg", "load.com[1..3]": "m"},
    },
}

ACTUATOR = {
    **{"drive": None, "machine_file": None},
    **dict.fromkeys("p R_s L_d L_q lambda_m J_m C_m tau_C w_C N_gear eta_gear w_eta rho J_s C_s".split()),
    **dict.fromkeys("EA K_br K_n K_r GJ L_s C_b M_act C_act i_max v_max".split()),
}

PARAMETERS = {
    "Emla": {**ACTUATOR, "alpha": "1"},
    "Rig": {**ACTUATOR, "delay": None, **dict.fromkeys("saturation temperature ripple cogging switching friction backlash compliance losses heat".split())},
    "Sensors": dict.fromkeys("seed delay motor_encoder joint_encoder rod_encoder joint_zero speed current force".split()),
    "DcLink": {
        **{"battery.cells": None, "battery.capacity": "A.h", "battery.ocv[1..21]": "V", "battery.soc_start": "1", "battery.T_start": "K"},
        **{"battery.R_0": "Ohm", "battery.R_1": "Ohm", "battery.tau_1": "s", "battery.R_2": "Ohm", "battery.tau_2": "s", "link.C": "F"},
        **{"battery.discharge_limit": "A", "battery.charge_limit": "A", "link.R": "Ohm", "brake.fitted": None, "brake.R": "Ohm"},
        **{"brake.v_on": "V", "brake.v_off": "V", "precharge.on": None, "precharge.R": "Ohm", "v_min": "V", "v_max": "V"},
    },
    "Hdrm": {
        "zeta_start[1..6]": "rad",
        "zeta_dot_start[1..6]": "rad/s",
        "inertia_scale": "1",
        **{"payload.mass": "kg", "payload.com[1..3]": "m", "load.moves_with_tip": None, "load.velocity[1..3]": "m/s", "gravity[1..3]": "m/s2"},
        **{"contact.normal[1..3]": "1", "contact.offset": "m", "contact.stiffness": "N/m", "contact.damping": "s/m"},
        **{"contact.friction": "1", "contact.slip_velocity": "m/s"},
        "joint_viscous[1..6]": "N.m.s/rad",
        "machine_file": None,
    },
    "Controller": {
        "mode": None,
        "trajectory": None,
        "machine_file": None,
        **{"rate.command": None, "rate.joint_max[1..6]": "rad/s", "rate.joint_acceleration_max[1..6]": "rad/s2", "rate.smoothing": "s"},
        **{"rate.tip_max[1]": "m/s", "rate.tip_max[2]": "rad/s", "rate.tip_acceleration_max[1]": "m/s2", "load.told": None},
        **dict.fromkeys("Lambda_position Lambda_orientation kappa_KA K_i K_f K_v lambda_i gamma".split()),
    },
}

TUNABLE = {
    "Emla": ["alpha"],
    "Hdrm": ["payload.mass", "payload.com[1..3]", "load.moves_with_tip", "load.velocity[1..3]"],
    "Rig": [],
    "Sensors": [],
    "DcLink": [],
    "Controller": "mode rate.command load.told Lambda_position Lambda_orientation kappa_KA K_i K_f K_v lambda_i gamma".split(),
}

ENUMERATIONS = {
    ("Emla", "drive"): ["motion", "force"],
    ("Controller", "mode"): [
        "adaptive",
        "modular",
        "pd",
        "modular_integral",
        "pd_integral",
        "pd_gravity",
        "pd_gravity_integral",
        "adaptive_integral",
        "cascade",
        "disturbance_observer",
        "super_twisting",
    ],
    ("Rig", "drive"): ["motion", "force"],
    ("Sensors", "speed"): ["ideal", "difference", "observer"],
    ("Sensors", "force"): ["ideal", "sensor", "absent"],
    ("Controller", "trajectory"): ["cubic", "triangular", "external", "rates", "path"],
    ("Controller", "rate.command"): ["joint", "tip"],
}


def elements(name):
    """`x[1..3]` as x[1], x[2], x[3]."""
    if ".." not in name:
        return [name]
    stem, numbers = name[:-1].split("[")
    first, last = map(int, numbers.split(".."))
    return [f"{stem}[{i}]" for i in range(first, last + 1)]
