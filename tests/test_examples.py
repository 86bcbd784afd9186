"""Each of the three replaced by somebody else's FMU, made with pythonfmu: the rest works on, and tracks."""

import os
import sys
from dataclasses import replace

import numpy as np
import pytest

from fmpy_master import ROOT, Master
from fmu import Fmu
from native import call, evaluated, libpython
from system import System

EXAMPLES = ROOT / "examples"


@pytest.fixture(scope="module")
def all_fmus(fmus, pythonfmu, tmp_path_factory):
    """Ours and those of the examples."""
    sys.path.insert(0, str(EXAMPLES))
    from build import SCRIPTS, build

    folder = tmp_path_factory.mktemp("examples")
    paths = [build(script, folder) for script in SCRIPTS]
    return fmus | {path.name: Fmu(path, folder / path.stem) for path in paths}


def test_mujoco_plant_holds_its_pose_with_our_forces(all_fmus, hdrm):
    """Built from the same JSON: strokes equal to rounding, holding forces to the softness of MuJoCo's constraints."""
    theirs, ours = all_fmus["MujocoHdrm.fmu"].running(), hdrm.running()
    for name, tolerance in {"x": 1e-9, "zeta": 1e-12, "tip.position": 1e-9, "f_hold": 50.0}.items():
        size = 6 if name == "zeta" else 3
        names = [f"{name}[{i + 1}]" for i in range(size)]
        np.testing.assert_allclose(theirs.get(*names), ours.get(*names), atol=tolerance, err_msg=name)
    theirs.free()
    ours.free()


def test_the_plant_as_pythonfmu_builds_it_takes_the_place_of_ours(fmu_dir, all_fmus):
    """In the native program: its description says nothing of dependencies, which is told, and the controller tracks."""
    plant = all_fmus["MujocoHdrm.fmu"]
    assert all(unknown.dependencies is None for unknown in plant.description.outputs)
    if not libpython():  # a Python without a shared library: no program but itself can load such an FMU
        return
    packages = os.pathsep.join(path for path in sys.path if path)
    options = ("--system", fmu_dir / "Manipulator.ssp", "--fmu", f"hdrm={plant.path}", "--trajectory", "triangular", "--set", "settle_time=0.3")
    for _ in range(4):  # pythonfmu's finalizers made one process in three abort
        done = call("hdrm-fmu", "run", *options, "--stop-time", "0.5", "--quiet", env=os.environ | {"LD_PRELOAD": libpython(), "PYTHONPATH": packages})
        assert done.returncode == 0, done.stderr
        assert "verdict: good" in done.stdout and "read right after the step" in done.stdout and "hdrm.x[1]" in done.stdout


def test_our_controller_tracks_with_the_mujoco_plant(system, all_fmus, tmp_path):
    """The adaptive controller does not know that the plant is MuJoCo's."""
    theirs = replace(system, components=system.components | {"hdrm": "MujocoHdrm.fmu"})
    settings = {"controller": {"trajectory": 2, "settle_time": 0.5}}
    master = Master(theirs, all_fmus, settings)
    times, rows = master.record(4.0, ["controller.tip_error_norm", "hdrm.tip.position[1]"])
    master.free()
    found = evaluated(tmp_path, times, ["controller.tip_error_norm"], rows[:, :1], settings=settings)
    rmse = 1e3 * found["metrics"]["tip_rmse"]
    print(f"tip RMSE with MuJoCo's plant {rmse:.4f} mm")
    assert np.ptp(rows[:, 1]) > 0.4, "the tip did not go along the first edge"
    assert rmse <= 0.01


def test_mujoco_plant_agrees_with_ours(system, all_fmus):
    """Under the PD controller, which knows no model and so hides nothing: tip and actuator forces of the two plants."""
    rows = {}
    names = [*(f"hdrm.tip.position[{i}]" for i in (1, 2, 3)), *(f"emla_{k}.F_mean" for k in (1, 2, 3))]
    for plant in ("Hdrm.fmu", "MujocoHdrm.fmu"):
        settings = {"controller": {"trajectory": "triangular", "mode": "pd", "settle_time": 0.5}}
        master = Master(replace(system, components=system.components | {"hdrm": plant}), all_fmus, settings)
        rows[plant] = master.record(3.0, names)[1][500:]
        master.free()
    ours, theirs = rows.values()
    tip = np.linalg.norm(ours[:, :3] - theirs[:, :3], axis=1).max()
    force = np.abs(ours[:, 3:] - theirs[:, 3:]).max(axis=0) / np.abs(ours[:, 3:]).max()
    print(f"tips at most {1e6 * tip:.1f} um apart, forces {1e2 * force} % of the largest")
    assert np.ptp(ours[:, 0]) > 0.3
    assert tip < 2e-6 and force.max() < 1e-4


def test_somebody_elses_controller_moves_our_machine(all_fmus):
    """All three rods at once by a few centimetres; without a model of the machine the error stays below a quarter of a millimetre."""
    system = System.read(EXAMPLES / "rod_controller.ssd")
    distance = [0.06, -0.05, 0.04]
    settings = {"controller": {f"distance[{i + 1}]": d for i, d in enumerate(distance)}}
    master = Master(system, all_fmus, settings)
    names = [f"controller.x_error[{i}]" for i in (1, 2, 3)] + [f"hdrm.x[{i}]" for i in (1, 2, 3)]
    _, rows = master.record(system.stop, names)
    master.free()
    print(f"largest rod errors {1e3 * np.abs(rows[:, :3]).max(axis=0)} mm")
    np.testing.assert_allclose(rows[-1, 3:] - rows[0, 3:], distance, atol=1e-5)
    assert np.abs(rows[:, :3]).max() < 2.5e-4


def test_our_actuator_moves_somebody_elses_load(all_fmus):
    """One mass of 3.2 t against 15 kN, 10 cm in 2 s; energy into it is what the actuator says it gave."""
    system = System.read(EXAMPLES / "one_mass.ssd")
    master = Master(system, all_fmus, {"controller": {"distance[1]": 0.1}})
    names = ["controller.x_error[1]", "load.x", "emla.energy.out", "emla.energy.in"]
    _, rows = master.record(system.stop, names)
    master.free()
    print(f"largest rod error {1e3 * np.abs(rows[:, 0]).max()} mm")
    assert np.abs(rows[:, 0]).max() < 2e-4
    moved = rows[-1, 1] - rows[0, 1]
    assert moved == pytest.approx(0.1, abs=1e-5)
    # Work against the constant force, and friction 5e3 N.s/m x mean square speed x time (quintic: 10/7 d^2/T).
    work = 15e3 * moved + 5e3 * 10 / 7 * 0.1**2 / 2.0
    print(f"energy given {rows[-1, 2]:.2f} J, taken by the load {work:.2f} J")
    assert rows[-1, 2] == pytest.approx(work, rel=2e-4)
    assert rows[-1, 3] > rows[-1, 2]
