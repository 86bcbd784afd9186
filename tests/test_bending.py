"""The bending plant: springs and frequencies against statics written by hand, its energy, and the machine's controller on it."""

import json
import sys
from copy import deepcopy
from math import acos, pi, sqrt

import numpy as np
import pytest

from fmpy_master import ROOT, Master
from fmu import Fmu, Refused
from system import System

sys.path.insert(0, str(ROOT / "examples"))

from bending import FULL_REACH, Bending  # noqa: E402
from bending_plant import BendingPlant, modes  # noqa: E402
from build import bending_system, build, strict_system  # noqa: E402

MACHINE = json.loads((ROOT / "parameters/reference_machine.json").read_text())
SETTINGS = {name: start for name, (start, _, _) in Bending.PARAMETERS.items()}


@pytest.fixture(scope="module")
def built(fmus, pythonfmu, tmp_path_factory):
    """The bending FMU with ours, and the system that they make."""
    folder = tmp_path_factory.mktemp("bending")
    path = build("bending.py", folder)
    return fmus | {path.name: Fmu(path, folder / "Bending")}, System.read(bending_system(folder))


def plant(zeta=None, **settings):
    machine = deepcopy(MACHINE)
    machine["start"]["zeta"] = zeta or machine["start"]["zeta"]
    return BendingPlant(machine, SETTINGS | settings)


def hung_on_the_booms(zeta):
    """What hangs on the flexures of lift and tilt boom: mass, place in the boom plane as a complex number, inertia about z; and the
    place of each hinge. Planar trigonometry from the machine's JSON, with the wrist stretched or bent in the plane; a boom is cut as a
    uniform bar is, at the same share of its length."""
    g, bodies = MACHINE["geometry"], MACHINE["bodies"]
    at = lambda origin, angle, p: origin + np.exp(1j * angle) * complex(p[0], p[1])
    lift, tilt, hand = zeta[1], zeta[1] + zeta[2], zeta[1] + zeta[2] + zeta[4]
    O = complex(g["r_T1_O"][0], g["r_T1_O"][1])
    B = at(O, lift, g["r_O_B"])
    A, E, C = at(B, lift, g["A_in_boom"]), at(B, lift, g["E_in_boom"]), at(B, tilt, g["C_in_tilt"])
    # The four-bar's apex by the law of cosines, above the line from A to C.
    side = abs(C - A)
    D = A + g["d4"] * np.exp(1j * (np.angle(C - A) + acos((g["d4"] ** 2 + side**2 - g["d5"] ** 2) / (2 * g["d4"] * side))))
    A4 = at(B, tilt, np.add(g["r_B_B4"], g["r_B4_A4"]))
    C4 = at(A4, tilt, g["r_A4_C4"])
    D4 = at(C4, hand, g["r_C4_D4"])
    push = np.angle(D - E)
    places = {
        "C3": (E, push),
        "D3": (D - g["lc_3"] * np.exp(1j * push), push),
        "RK": (A, np.angle(D - A)),
        "CP": (C, np.angle(D - C)),
        "A4": (A4, tilt),
        "C4": (C4, hand),
        "D4": (D4, hand),
        "PL": (D4, hand),
    }
    mass = lambda name: bodies[name]["mass"]
    parts = {name: (mass(name), at(*place, bodies[name]["com"]), bodies[name]["inertia_com"]["zz"]) for name, place in places.items()}
    beams = {"A2": (O, lift, 0.7, lift - g["beta2"]), "A3": (B, tilt, 0.22 + 1.48 / 3, tilt)}
    hinges = {}
    for name, (root, angle, along, frame) in beams.items():
        centre, I = at(root, frame, bodies[name]["com"]), bodies[name]["inertia_com"]
        hinges[name] = root + along * np.exp(1j * angle)
        # A bar of length l, height h: I_zz = m (l² + h²)/12; its length runs along the body's smallest moment.
        axis = np.linalg.eigh([[I["xx"], I["xy"]], [I["xy"], I["yy"]]])
        small, large = axis[0]
        length = sqrt(6 * (large + I["zz"] - small) / mass(name))
        height = sqrt(max(0, 12 * I["zz"] / mass(name) - length**2))
        along = axis[1][:, 0] * np.sign(axis[1][0, 0])
        direction = np.exp(1j * frame) * complex(*along)
        far = 0.5 - ((hinges[name] - centre) / direction).real / length
        m, middle = far * mass(name), centre + (1 - far) / 2 * length * direction
        parts[name] = (m, middle, m * ((far * length) ** 2 + height**2) / 12)
    return parts, hinges


BEHIND = {"A2": ("A2", "C3", "D3", "RK", "CP", "A3", "A4", "C4", "D4", "PL"), "A3": ("A3", "A4", "C4", "D4", "PL")}


@pytest.mark.parametrize("zeta", [MACHINE["start"]["zeta"], FULL_REACH], ids=["start", "full reach"])
def test_booms_bend_as_the_weight_behind_their_hinges_asks(zeta):
    """Angle = moment / spring. By hand the levers are those of the unbent machine: 0.3 % of an angle of 3 mrad. The tilt boom is bent
    also where the lift boom has turned it, by as little. The whole tilt boom hangs on the lift boom, so its near part is added."""
    bent = plant(zeta)
    parts, hinges = hung_on_the_booms(zeta)
    angles = dict(zip(("T1", "A2", "A3"), bent.outputs()["flexure"]))
    tip, sag = bent.outputs()["tip.position"], 0j
    for name, spring in (("A2", SETTINGS["stiffness.lift"]), ("A3", SETTINGS["stiffness.tilt"])):
        moment = sum(-9.81 * parts[p][0] * (parts[p][1] - hinges[name]).real for p in BEHIND[name])
        if name == "A2":
            moment += -9.81 * near_part(parts, zeta)[0] * (near_part(parts, zeta)[1] - hinges[name]).real
        assert angles[name] == pytest.approx(moment / spring, rel=5e-3)
        sag += 1j * moment / spring * (complex(tip[0], tip[1]) - hinges[name])
    found = bent.outputs()["tip.sag"][0]
    print(f"angles {1e3 * angles['A2']:.3f}, {1e3 * angles['A3']:.3f} mrad; sag {1e3 * found:.3f} mm, by hand {1e3 * abs(sag):.3f} mm")
    assert abs(angles["T1"]) < 1e-4, "gravity hardly twists the column"
    assert found == pytest.approx(abs(sag), rel=0.01)


def near_part(parts, zeta):
    """Mass, centre and inertia of the tilt boom between B and its hinge: the whole less the far part."""
    g, body = MACHINE["geometry"], MACHINE["bodies"]["A3"]
    lift, tilt = zeta[1], zeta[1] + zeta[2]
    B = complex(g["r_T1_O"][0], g["r_T1_O"][1]) + np.exp(1j * lift) * g["r_O_B"][0]
    m, whole = body["mass"], B + np.exp(1j * tilt) * complex(*body["com"][:2])
    far, centre, inertia = parts["A3"]
    near = m - far
    at = (m * whole - far * centre) / near
    rest = body["inertia_com"]["zz"] - inertia - far * abs(centre - whole) ** 2 - near * abs(at - whole) ** 2
    return near, at, rest


def test_frequency_of_the_lift_boom_alone_is_spring_over_inertia():
    """The other springs made stiff, one mode is left: (2 pi f)² = (k - gravity's share)/J, and that share, some 20 kN.m, is 0.2 % of k."""
    stiff = {"stiffness.column": 1e13, "stiffness.tilt": 1e13}
    f, _, _ = modes(plant(FULL_REACH, **stiff))
    parts, hinges = hung_on_the_booms(FULL_REACH)
    all_parts = [*(parts[p] for p in BEHIND["A2"]), near_part(parts, FULL_REACH)]
    J = sum(inertia + m * abs(at - hinges["A2"]) ** 2 for m, at, inertia in all_parts)
    by_hand = sqrt(SETTINGS["stiffness.lift"] / J) / (2 * pi)
    print(f"{f[0]:.3f} Hz, by hand {by_hand:.3f} Hz")
    assert f[0] == pytest.approx(by_hand, rel=3e-3)


def test_first_natural_frequency_at_full_reach():
    f, ratio, _ = modes(plant(FULL_REACH))
    print(f"natural frequencies {np.round(f, 2)} Hz, damping ratios {np.round(1e2 * ratio, 2)} %")
    assert 4 < f[0] < 8 and 0.01 < ratio[0] < 0.02


def test_a_stiff_plant_is_the_rigid_manipulator(hdrm):
    """Springs of 1e13 N.m/rad, no friction, no errors: strokes and tip to rounding, forces to the softness of MuJoCo's constraints."""
    springs = {f"stiffness.{part}": 1e13 for part in ("column", "lift", "tilt")}
    theirs, ours = plant(**springs, friction=0.0).outputs(), hdrm.running()
    for name, tolerance in {"x": 1e-9, "zeta": 1e-12, "tip.position": 1e-8, "tip.orientation": 1e-8, "f_hold": 50.0}.items():
        found = ours.get(*[f"{name}[{i + 1}]" for i in range(len(theirs[name]))])
        np.testing.assert_allclose(theirs[name], found, atol=tolerance, err_msg=name)
    assert theirs["energy.potential"][0] == pytest.approx(ours.get("energy.potential"), rel=1e-8)
    ours.free()


def test_it_rests_where_it_starts_also_with_errors_and_payload():
    """Held by f_hold and the wrist's holding torques, with no dry friction that could help. MuJoCo's soft pins give way by micrometres;
    a tip that fell freely would be 12 mm lower."""
    bent = plant(seed=3, inertia_scale=1.4, friction=0.0)
    start = bent.outputs()
    for _ in range(50):
        bent.step(bent.hold, 1e-3)
    end = bent.outputs()
    moved = np.linalg.norm(end["tip.position"] - start["tip.position"])
    print(f"after 50 ms the tip is {1e6 * moved:.1f} um from where it was")
    assert moved < 5e-5 and np.abs(end["zeta"] - start["zeta"]).max() < 5e-5


def test_a_free_structure_rings_at_the_frequency_that_the_model_says():
    """All drives locked by strong dampers; the payload is dropped by 1 mrad of the tilt boom. Zero crossings of the lift boom's angle."""
    bent = plant(FULL_REACH, friction=0.0, **{"stiffness.column": 1e13, "stiffness.tilt": 1e13})
    bent.m.dof_damping[[*bent.forced, *bent.free]] = 1e12
    bent.d.qpos[bent.bent[1]] += 1e-3
    rest = bent.outputs()["flexure"][1] - 1e-3
    angle = []
    for _ in range(1000):
        bent.step(bent.hold, 1e-3)
        angle.append(bent.d.qpos[bent.bent[1]] - rest)
    angle = np.array(angle)
    crossings = np.flatnonzero(np.diff(np.sign(angle)))
    found = (len(crossings) - 1) / 2 / (1e-3 * (crossings[-1] - crossings[0]))
    assert found == pytest.approx(modes(bent)[0][0], rel=0.01)
    ratio = modes(bent)[1][0]
    peaks = [np.abs(angle[a:b]).max() for a, b in zip(crossings, crossings[1:])]
    assert np.log(peaks[0] / peaks[-1]) / (pi * (len(peaks) - 1)) == pytest.approx(ratio, rel=0.05)


def test_errors_follow_the_seed():
    tips = {seed: tuple(plant(seed=seed).outputs()["tip.position"]) for seed in (0, 1, 2)}
    assert tips[1] == tuple(plant(seed=1).outputs()["tip.position"]) and len(set(tips.values())) == 3
    off = np.linalg.norm(np.subtract(tips[1], tips[0]))
    assert 1e-4 < off < 2e-2
    masses = [body["mass"] / MACHINE["bodies"][name]["mass"] for name, body in plant(seed=1).machine["bodies"].items()]
    assert 0.6 <= min(masses) < 0.9 and 1.1 < max(masses) <= 1.4


def run(built, until, names, **settings):
    fmus, system = built
    master = Master(system, fmus, {"hdrm": settings, "controller": {"settle_time": 0.5, "trajectory": "triangular"}}, h=5e-4)
    times, rows = master.record(until, names)
    master.free()
    return times, dict(zip(names, rows.T))


def test_our_controller_tracks_on_the_bending_plant_and_energy_is_accounted_for(built):
    """What the controller can know stays within 0.7 mm from half a second of motion on; the sag it cannot see. Work of the actuators and
    the wrist is what the plant's energies gained and its joints lost. A step's force is held, so its work is force times stroke without
    an error of quadrature; what is left is the error of MuJoCo's first-order integration and its soft pins."""
    forces = [f"emla_{i}.F_mean" for i in (1, 2, 3)] + [f"controller.tau_wrist[{i}]" for i in (1, 2, 3)]
    motion = [f"hdrm.x[{i}]" for i in (1, 2, 3)] + [f"hdrm.zeta[{i}]" for i in (4, 5, 6)]
    energies = [f"hdrm.energy.{kind}" for kind in ("kinetic", "potential", "elastic", "loss")]
    probes = ["controller.tip_error_norm", "hdrm.tip.sag"]
    times, found = run(built, 3.0, [*forces, *motion, *energies, *probes], seed=2)
    moving = times > 1.0
    error, sag = 1e3 * found[probes[0]][moving], 1e3 * found[probes[1]][moving]
    print(f"known tip error at most {error.max():.3f} mm, sag {sag.min():.2f} to {sag.max():.2f} mm")
    assert error.max() < 0.7 and 3.0 < sag.min()
    # Torques of the wrist act over the step after they were read, mean forces over the step before.
    work = turned = 0.0
    for k, (force, place) in enumerate(zip(forces, motion)):
        step = np.diff(found[place])
        power = (found[force][1:] if k < 3 else found[force][:-1]) * step
        work, turned = work + power.sum(), turned + np.abs(power).sum()
    gained = sum(found[name][-1] - found[name][0] for name in energies)
    lost = found[energies[3]][-1]
    print(f"work {work:.2f} J of {turned:.0f} J turned over, energies gained {gained:.2f} J, of which lost {lost:.2f} J")
    assert abs(work - gained) < 2e-4 * turned
    assert lost > 20.0 and turned > 500.0
    # The exchange does not ring: forces change smoothly from step to step.
    assert all(np.abs(np.diff(found[f], 2)[1000:]).max() < 200.0 for f in forces[:3])


def test_the_machine_as_built_is_controlled_on_the_bending_plant(built, tmp_path):
    """The world `strict`: its wrist has no brakes; the supervisor watches (2), and the tip is kept, within 5 mm."""
    names = ["controller.supervisor.state", "controller.tip_error_norm"]
    _, found = run((built[0], System.read(strict_system(tmp_path))), 2.0, names, seed=1)
    assert (found[names[0]] == 2).all() and found[names[1]].max() < 5e-3, found


def test_two_runs_are_equal_bit_for_bit(built):
    names = ["hdrm.tip.position[1]", "hdrm.x[2]", "emla_3.F"]
    one, other = (run(built, 0.2, names, seed=5)[1] for _ in range(2))
    assert all((one[name] == other[name]).all() for name in names)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # pythonfmu logs its last message without a category
def test_without_mujoco_the_reason_is_said(built, monkeypatch):
    for name in ("bending_plant", "mujoco_plant"):
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    instance = built[0]["Bending.fmu"].instance(logging=True)
    with pytest.raises(Refused, match="mujoco.*Bending.fmu must find the packages mujoco and numpy"):
        instance.start()  # fatal: this instance must not be called again, nor freed
