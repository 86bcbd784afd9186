"""The machine as built where it was not tuned: other mountings, delays, loads, motors, friction, on `Real.ssp` as it opens but for the plant.

Each run is kept, stopped or lost. Lost: the tip is off by more than a millimetre over the motion, or a rod's force ripples by more than 1 kN
around its mean over 0.15 s in the last 3 s; as drawn these are 0.06 mm and 0.25 kN, swinging has 1.7 to 8 mm or tens of kN.
Stopped: the controller took the brakes."""

import json
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from native import call, recorded

AXES = ("emla_1", "emla_2", "emla_3")
DRAWN = {"hdrm": {"inertia_scale": 1.4}, "sensors": {"seed": 1007, "joint_zero": "false"}, "controller": {"trajectory": "triangular"}}
FRICTION = {"friction.screw_drag": 0.5, "friction.seal": 260, "friction.gear_drag": 0.14, "friction.screw_loss": 0.026, "friction.gear_loss": 0.05}
axes = lambda **values: {axis: {name.replace("__", "."): value for name, value in values.items()} for axis in AXES}
friction = lambda factor: {axis: {name: factor * value for name, value in FRICTION.items()} for axis in AXES}
mount = lambda stiffness: axes(compliance__mount=stiffness)
late = lambda steps: {"sensors": {"delay": steps}}
payload = lambda mass: {"hdrm": {"payload.mass": mass}}
inertia = lambda scale: {"hdrm": {"inertia_scale": scale}}

STOPPING = 5  # of the supervisor's states, and what follows it

TWELVE = {
    "as drawn": {},
    "mounting 42 N/um": mount(4.2e7),
    "mounting 30 N/um": mount(3e7),
    "readings two steps late": late(2),
    "payload 400 kg": payload(400),
    "empty hook": payload(1),
    "mounting 120 N/um": mount(1.2e8),
    "backlash x 3": axes(backlash__width=120e-6),
    "friction x 2": friction(2),
    "breakaway 2": axes(friction__breakaway=2),
    "hot motors": axes(T_winding_start=393.15, T_housing_start=363.15),
    "no joint friction": {"hdrm": {f"joint_viscous[{i}]": 0 for i in range(1, 7)}},
}
MARGINS = {
    "readings three steps late": late(3),
    "friction x 0.5": friction(0.5),
    "inertia x 0.6": inertia(0.6),
    "inertia x 1.6": inertia(1.6),
    "resistance + 40 %": axes(R_s=0.28),
    "magnets - 40 %": axes(lambda_m=0.114),
    "magnets + 40 %": axes(lambda_m=0.266),
    "inductance - 40 %": axes(L_d=0.00156, L_q=0.00156),
    "rotor + 40 %": axes(J_m=0.0056),
    "rotor - 40 %": axes(J_m=0.0024),
}
PAIRS = [
    ("readings three steps late", "mounting 30 N/um"),
    ("readings three steps late", "payload 400 kg"),
    ("readings three steps late", "empty hook"),
    ("readings three steps late", "rotor - 40 %"),
    ("mounting 30 N/um", "payload 400 kg"),
    ("mounting 30 N/um", "empty hook"),
    ("mounting 30 N/um", "magnets - 40 %"),
    ("empty hook", "inertia x 0.6"),
]


def joined(*parts):
    """Settings of a plant over those of the drawn one."""
    whole = {component: dict(values) for component, values in DRAWN.items()}
    for part in parts:
        for component, values in part.items():
            whole.setdefault(component, {}).update(values)
    return whole


def outcome(fmu_dir, file, settings, *options):
    """kept, stopped or lost, and the tip's RMS error over the motion, mm."""
    tip, desired = ([f"{name}[{i}]" for i in (1, 2, 3)] for name in ("hdrm.tip.position", "controller.desired.position"))
    signals = [*tip, *desired, *(f"{axis}.F" for axis in AXES), "controller.supervisor.state"]
    rows = recorded(file, signals, "--system", fmu_dir / "Real.ssp", "--stop-time", 13.75, *options, settings=settings)
    error = 1e3 * np.linalg.norm(rows[4000:, 0:3] - rows[4000:, 3:6], axis=1)
    forces = rows[-3000:, 6:9]
    mean = np.stack([np.convolve(F, np.ones(150) / 150, "same") for F in forces.T], axis=1)
    ripple = np.sqrt(np.mean((forces - mean)[150:-150] ** 2, axis=0)).max()
    rms = float(np.sqrt(np.mean(error**2)))
    if rows[-1, 9] >= STOPPING:
        return "stopped", rms
    return ("kept" if rms < 1.0 and ripple < 1e3 else "lost"), rms


def outcomes(fmu_dir, folder, plants, **controller):
    settings = {name: joined(plant, {"controller": controller}) for name, plant in plants.items()}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = {name: pool.submit(outcome, fmu_dir, folder / f"{k}.csv", s) for k, (name, s) in enumerate(settings.items())}
    found = {name: run.result() for name, run in runs.items()}
    print("\n".join(f"{name:50} {kind:8} {rms:.3f} mm" for name, (kind, rms) in found.items()))
    return found


@pytest.mark.parametrize("mode", ["adaptive_integral", "adaptive", "modular_integral"])
def test_twelve_plants_are_kept(fmu_dir, tmp_path, mode):
    found = outcomes(fmu_dir, tmp_path, TWELVE, mode=mode)
    assert {kind for kind, _ in found.values()} == {"kept"}
    if mode == "adaptive_integral":
        assert found["as drawn"][1] < 1.3 * 0.077, "what the gains before had, tuned to this plant"


def test_margins_and_pairs_are_kept(fmu_dir, tmp_path):
    every = TWELVE | MARGINS
    plants = MARGINS | {f"{a}, {b}": merged(every[a], every[b]) for a, b in PAIRS}
    found = outcomes(fmu_dir, tmp_path, plants, mode="adaptive_integral")
    assert {kind for kind, _ in found.values()} == {"kept"}


def merged(a, b):
    return {component: a.get(component, {}) | b.get(component, {}) for component in a | b}


def test_a_plant_that_swings_is_lost(fmu_dir, tmp_path):
    """The measure itself: without the drives' current loop and with the gains before, two of the plants swing."""
    before = {"supervisor": "false", "K_v": 884.566, "omega_d": 100, "gamma": 60, "Lambda_position": 10, "omega_tip": 2.5, "weighing_time": 0, "current_loop": "false"}
    plants = {name: merged(TWELVE[name], axes(current_loop="false")) for name in ("mounting 30 N/um", "empty hook")}
    found = outcomes(fmu_dir, tmp_path, plants, mode="adaptive_integral", **before)
    assert {kind for kind, _ in found.values()} == {"lost"}


STRANGER = {"extends": "reference", "geometry": {"r_B_B4": [2.1, 0, 0]}, "bodies": {"PL": {"mass": 500}}}


@pytest.mark.parametrize("name", ["reference", "hiab_xs031", "stranger"])
def test_machines_are_kept_with_the_gains_of_the_rule(fmu_dir, tmp_path, name):
    """As it is, 20 % heavier, and on a mounting half as stiff; a machine that asks for other gains than those that ship is told which by
    `machine check`, gets them in a run, and is warned where the user's gain is another."""
    machine = name
    if name == "stranger":
        machine = tmp_path / "stranger.json"
        machine.write_text(json.dumps(STRANGER))
    gains, system = tmp_path / "gains.ssv", ["--system", fmu_dir / "Real.ssp"]
    assert call("hdrm-fmu", "machine", "gains", machine, "--output", gains).returncode == 0
    told = [call("hdrm-fmu", "machine", "check", machine).stdout]
    for own in [], ["--set", "controller.gamma=250"]:
        told.append(call("hdrm-fmu", "run", *system, "--machine", machine, "--stop-time", 0.01, *own).stdout)
    assert ("lowest mode" in told[0]) == (name == "stranger"), told
    assert ("gains by the rule" in told[1], "machine gains" in told[1]) == (name != "reference", False), told
    assert ("machine gains" in told[2]) == (name != "reference") and "gamma = 1000," not in told[2], told
    files = {component: {"machine_file": machine} for component in ("hdrm", "controller")}
    files |= {axis: {"machine_file": machine, "axis": k} for k, axis in enumerate(AXES, 1)}
    law = {"controller": {"mode": "adaptive_integral"}}
    for k, plant in enumerate([inertia(1.0), inertia(1.2), merged(inertia(1.0), mount(3e7))]):
        kind, rms = outcome(fmu_dir, tmp_path / f"{k}.csv", joined(plant, files, law), "--parameters", gains)
        print(name, k, kind, f"{rms:.3f} mm")
        assert kind == "kept", (plant, rms)
