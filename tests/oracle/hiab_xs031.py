"""Writes parameters/hiab_xs031.json: what is known of a HIAB XS031 loader crane on a research platform, in the fields of a machine file.

    python tests/oracle/hiab_xs031.py        (needs numpy)

Numbers marked `source` are those of the repository petrovicrgoran/HydraulicManipulatorVDC (G. R. Petrović, BSD 3-clause; masses and inertias
from CAD by J. Koivumäki), which belongs to Petrović and Mattila, Mechanism and Machine Theory 170 (2022) 104680. All else is chosen;
parameters/README.md says why.
"""

import json
from pathlib import Path

import numpy as np

FILE = Path(__file__).resolve().parents[2] / "parameters" / "hiab_xs031.json"

# Source: initializeConstantGeometricData.m, initializeLinearActuatorsData.m, initializeConstantPositionVectors.m. m and rad.
L1, L11 = 1.0071227324212, 0.37610632101293
L2, L21 = 1.132185817991, 0.30901132665325
BETA1, BETA2 = np.arctan2(374.261, 935), np.arctan2(45.757, 373.313)
BETA4 = np.arctan2(88.061, 296.198)
ALPHA1, ALPHA2 = 1.9515432018109, 0.24548563270531
STROKE, X0, L_C = 0.59, 0.83, 0.745
W_FOOT = np.array([0.185, -0.085])  # lift cylinder's foot in the platform's axes
PIN_FOOT2 = np.array([0.098495302558553, 0.01838181329939])  # tilt cylinder's foot from the lift cylinder's pin, A2 axes
PIN2_TELESCOPE = np.array([-0.048858374920227, 0.36587359346146])  # telescope's foot from the tilt cylinder's pin, pin axes
LINK_TIP = np.array([0.40499744871392, -0.13130517281345])  # tip from the last link's origin
ROLL = np.arcsin(0.23999977258511)  # of the boom's profile about its axis
ROD, CLEARANCE = 1.2, 0.041  # of the telescope's cylinder
TELESCOPE = 0.5  # stroke at which the source starts; here it is locked

# Chosen.
# The rocker's pivot A from the tilt joint B: a four-bar linkage that is a triangle but for 6 mm. In this direction no pose has A, B and C in
# line, not with the errors of length of the real world either, and D lies on the side that the machine file asks for.
PIVOT = 6e-3 * np.array([np.cos(np.radians(194)), np.sin(np.radians(194))])
WRIST = 0.75  # size of the wrist relative to the reference machine's


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def turn3(angle):
    R = np.eye(3)
    R[:2, :2] = turn(angle)
    return R


def body(mass, com, inertia, angle=0.0, shift=(0.0, 0.0)):
    """A body given in axes that are turned by `angle` and shifted by `shift` in the plane: mass, com, inertia about it."""
    R = turn3(angle)
    com = R @ np.array(com) + np.append(shift, 0.0)
    return mass, com, R @ np.array(inertia, dtype=float) @ R.T


def together(*bodies):
    mass = sum(m for m, _, _ in bodies)
    com = sum(m * c for m, c, _ in bodies) / mass
    inertia = sum(I + m * (((c - com) @ (c - com)) * np.eye(3) - np.outer(c - com, c - com)) for m, c, I in bodies)
    return mass, com, inertia


def rounded(value, digits=6):
    return [rounded(v, digits) for v in value] if np.ndim(value) else round(float(value), digits) + 0.0


def section(mass, com, I):
    inertia = {"xx": I[0, 0], "yy": I[1, 1], "zz": I[2, 2], "xy": I[0, 1], "xz": I[0, 2], "yz": I[1, 2]}
    return {"mass": rounded(mass), "com": rounded(com), "inertia_com": {k: rounded(v) for k, v in inertia.items()}}


def rod(mass, length, radius):
    """A bar from its body's origin along x."""
    across = mass * (3 * radius**2 + length**2) / 12
    return mass, np.array([length / 2, 0, 0]), np.diag([mass * radius**2 / 2, across, across])


# Points. Boom axes: x along the lift boom, origin O.
foot2 = turn(-BETA2) @ (np.array([L11, 0.0]) + PIN_FOOT2)
B = foot2 + turn(ALPHA2 - BETA2) @ np.array([L2, 0.0])
O = W_FOOT + turn(ALPHA1) @ np.array([L1, 0.0])
# Tilt-boom axes: x along the telescope, origin B.
pin2 = turn(-BETA4) @ np.array([L21, 0.0])
telescope = pin2 + turn(-BETA4) @ PIN2_TELESCOPE
link = telescope + np.array([CLEARANCE + TELESCOPE + ROD, 0.0])
tip = link + np.array([LINK_TIP[0], np.cos(ROLL) * LINK_TIP[1]])
C = np.array([pin2[0] + 0.12, 0.0])  # chosen: where the link between the two lugs is pinned

geometry = {
    "r_T1_O": rounded([*O, 0.0]),
    "L1_2": L11,
    "L2_2": L1,
    "beta1": float(BETA1),
    "beta2": float(BETA2),
    "x0_2": X0,
    "lc_2": L_C,
    "r_O_B": rounded([*B, 0.0]),
    "A_in_boom": rounded(PIVOT, 9),
    "E_in_boom": rounded(foot2 - B),
    "C_in_tilt": rounded(C),
    "d4": L21,
    "d5": rounded(np.hypot(*(pin2 - C))),
    "x0_3": X0,
    "lc_3": L_C,
    "r_B_B4": rounded([*tip, 0.0]),
    "r_B4_A4": rounded([WRIST * 0.2, 0, 0]),
    "r_A4_C4": rounded([WRIST * 0.2, 0, 0]),
    "r_C4_D4": rounded([WRIST * 0.15, 0, 0]),
    "r_D4_T4": rounded([WRIST * 0.4, 0, 0]),
}

# Source: initializeInertiaProperties.m. kg, m, kg·m².
pillar = body(307.29601379, [0.14178771, 0.16555780, 0], [
    [5.892211080, 5.476111360, -0.000019630], [5.476111360, 28.66965601, -0.000024550], [-0.000019630, -0.000024550, 29.78955950],
], ALPHA1, W_FOOT)  # fmt: skip
boom = together(
    body(25.52660174, [0.23805608, 0.13201777, 0], [[0.28426, -0.06487287, 0], [-0.06487287, 0.54237481, 0], [0, 0, 0.6789102]]),
    body(54.58702836, [0.54319901, 0.10543875, 0], [[0.4807139, 0.52924041, 0], [0.52924041, 5.80912352, 0], [0, 0, 5.97255351]],
         ALPHA2, np.array([L11, 0.0]) + PIN_FOOT2),
)  # fmt: skip
cylinder = body(17.36281648, [0.35781210, 0, 0], np.diag([0.03150902, 0.90735702, 0.90763033]))
piston = body(10.34519231, [0.55785997, 0, 0], np.diag([0.0037072, 0.55759812, 0.55785997]))
tilt_boom = together(
    body(33.92850233, [0.60504569, 0.27199376, 0.00002484], [
        [1.18803886, -2.36786418, 0.00280315], [-2.36786418, 6.31493281, 0.00022322], [0.00280315, 0.00022322, 7.40915161],
    ], -BETA4),
    body(9.26136143, [0.62192523, 0, 0], np.diag([0.00662754, 1.48387017, 1.48398069]), 0.0, telescope),
    # The telescope's rod: its CAD axis z is the telescope's axis.
    body(6.73059863, [0.56802906, 0, 0], np.diag([0.00091463, 0.91790043, 0.91789884]), 0.0,
         telescope + np.array([CLEARANCE + TELESCOPE, 0.0])),
)  # fmt: skip
LAST_LINK = 570.18877059  # the last link with the load that hangs on it
LAST_LINK_COM = np.array([0.25466704, -0.13034397])

reference = json.loads((FILE.parent / "reference_machine.json").read_text())


def smaller(name):
    """A body of the reference machine's wrist, of the same shape and material."""
    part = reference["bodies"][name]
    return {
        "mass": rounded(WRIST**3 * part["mass"]),
        "com": rounded([WRIST * c for c in part["com"]]),
        "inertia_com": {k: rounded(WRIST**5 * v) for k, v in part["inertia_com"].items()},
    }


bodies = {
    "T1": section(*pillar),
    "A2": section(*boom),
    "C2": section(*cylinder),
    "D2": section(*piston),
    "A3": section(*tilt_boom),
    "C3": section(*cylinder),
    "D3": section(*piston),
    "RK": section(*rod(2.0, L21, 0.02)),
    "CP": section(*rod(1.0, geometry["d5"], 0.02)),
} | {name: smaller(name) for name in ["A4", "C4", "D4"]}  # fmt: skip

# The last link and its load hang from the wrist: what the wrist does not weigh is payload.
wrist = sum(bodies[name]["mass"] for name in ["A4", "C4", "D4"])
payload = reference["bodies"]["PL"]
share = (LAST_LINK - wrist) / payload["mass"]
bodies["PL"] = {
    "mass": rounded(LAST_LINK - wrist),
    "com": [0.35, 0.0, 0.0],
    "inertia_com": {k: rounded(share * v) for k, v in payload["inertia_com"].items()},
}

machine = {
    "$schema": "machine.schema.json",
    "extends": "sized",
    "geometry": geometry,
    "bodies": bodies,
    "limits": {
        "stroke_2": [0.0, STROKE],
        "stroke_3": [0.0, STROKE],
        "zeta_min_deg": [-57, -8, -140, -180, -110, -180],
        "zeta_max_deg": [57, 80, -12, 180, -10, 180],
    },
    # Chosen by `hdrm-fmu sizing --machine hiab_xs031`: the motor of the reference machine lifts, that of the sized machine's lift axis tilts.
    "emla": {
        "slew": {"M_act": rounded(piston[0])},
        "lift": {
            "R_s": 0.2, "J_m": 0.004, "tau_C": 0.6, "i_max": 100.0, "L_s": L_C, "M_act": rounded(piston[0]),
            "brake": {"torque": 50.0}, "heat": {"C_w": 2000.0, "R_wh": 0.06, "C_h": 15000.0, "R_ha": 0.15},
        },
        "tilt": {
            "R_s": 0.26, "J_m": 0.003, "tau_C": 0.5, "i_max": 80.0, "L_s": L_C, "M_act": rounded(piston[0]),
            "brake": {"torque": 40.0}, "heat": {"C_w": 1600.0, "R_wh": 0.07, "C_h": 13000.0, "R_ha": 0.17},
        },
    },
    "ratings": {
        "lift": {"force_max": 80000.0, "motor_power": 11600.0, "motor_torque": 37.0},
        "tilt": {"force_max": 60000.0, "motor_power": 8500.0, "motor_torque": 27.0},
    },
    "start": {"zeta": rounded(np.radians([0, 45, -90, 0, -45, 0]), 12)},
    # Chosen: the adaptation is as much slower as its payload is heavier and its boom softer on its levers (parameters/README.md).
    "controller": {"gamma": 150.0},
}


def text():
    return json.dumps(machine, indent=1) + "\n"


if __name__ == "__main__":
    FILE.write_text(text())
