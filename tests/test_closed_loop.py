"""The coupled machine through the FMPy master: tracking of the three controllers, beside the native master's numbers."""

import csv
import subprocess

import numpy as np
import pytest

from fmpy_master import ROOT, tip_rmse
from native import hdrm_fmu

SSD = ROOT / "system/SystemStructure.ssd"
MODES = {"adaptive": 1, "modular": 2, "pd": 3}
TRAJECTORIES = {"cubic": 1, "triangular": 2}
SCALES = (1.4, 1.2, 1.0, 0.8, 0.6)
# Tip RMSE of the paper's adaptive controller, mm, for these inertias.
PAPER = {"cubic": (2.4, 1.9, 1.5, 2.9, 3.6), "triangular": (4.2, 3.5, 2.9, 5.0, 6.0)}
SIGNALS = ["controller.tip_error_norm", "hdrm.tip.position[1]", "emla_2.F", "emla_3.i_q", "controller.v_q[1]"]


def run(couple, trajectory, mode, scale, signals=SIGNALS[:1], **options):
    """Times and rows over a whole trajectory, and the tip RMSE in mm."""
    settings = {"controller": {"mode": MODES[mode], "trajectory": TRAJECTORIES[trajectory]}, "hdrm": {"inertia_scale": scale}}
    master = couple(settings=settings, **options)
    controller = master.instances["controller"]
    times, rows = master.record(controller.get("motion_end"), signals)
    rmse = 1e3 * tip_rmse(times, rows[:, 0], controller.get("settle_time"))
    print(f"{trajectory} {mode} x{scale} {options}: tip RMSE {rmse:.4f} mm")
    return times, rows, rmse


def native(fmu_dir, tmp_path, trajectory, mode, scale, *more):
    """The same by `hdrm-fmu run`, from its CSV."""
    path = tmp_path / "native.csv"
    arguments = [hdrm_fmu(), "run", "--system", SSD, "--fmu-dir", fmu_dir, "--quiet", "--csv", path, "--signals", ",".join(SIGNALS)]
    arguments += ["--trajectory", trajectory, "--mode", mode, "--inertia-scale", scale, *more]
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with path.open() as file:
        titles, *rows = csv.reader(file)
    columns = dict(zip((title.split(" ")[0] for title in titles), np.array(rows, dtype=float).T))
    return np.column_stack([columns[s] for s in SIGNALS])


@pytest.mark.parametrize("trajectory, scale", [("triangular", 1.0), ("triangular", 1.2)])
def test_fmpy_and_native_master_agree(couple, fmu_dir, tmp_path, trajectory, scale):
    """Two masters, one in Rust and one in Python, that share nothing but the SSD: the same numbers bit for bit."""
    _, rows, _ = run(couple, trajectory, "adaptive", scale, SIGNALS)
    expected = native(fmu_dir, tmp_path, trajectory, "adaptive", scale)
    assert rows.shape == expected.shape
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.parametrize("schedule, options", [("jacobi", []), ("jacobi-derivatives", ["--input-derivatives"])])
def test_fmpy_and_native_master_agree_on_jacobi(couple, fmu_dir, tmp_path, schedule, options):
    _, rows, _ = run(couple, "triangular", "adaptive", 1.2, SIGNALS, schedule=schedule)
    expected = native(fmu_dir, tmp_path, "triangular", "adaptive", 1.2, "--schedule", "jacobi", *options)
    np.testing.assert_array_equal(rows, expected)


@pytest.mark.parametrize("trajectory", TRAJECTORIES)
@pytest.mark.parametrize("scale", [1.0, 1.2])
def test_adaptive_controller_tracks(couple, trajectory, scale):
    check_adaptive(couple, trajectory, scale)


@pytest.mark.slow
@pytest.mark.parametrize("trajectory", TRAJECTORIES)
@pytest.mark.parametrize("scale", [1.4, 0.8, 0.6])
def test_adaptive_controller_tracks_in_the_other_cells(couple, trajectory, scale):
    check_adaptive(couple, trajectory, scale)


def check_adaptive(couple, trajectory, scale):
    rmse = run(couple, trajectory, "adaptive", scale)[2]
    assert rmse <= 0.15
    assert rmse <= PAPER[trajectory][SCALES.index(scale)]


def check_order(couple, trajectory, scale):
    adaptive, modular, pd = (run(couple, trajectory, mode, scale)[2] for mode in MODES)
    assert adaptive < modular < pd


def test_adaptation_and_model_help(couple):
    """With a heavier machine than known: adaptive better than modular better than PD."""
    check_order(couple, "triangular", 1.2)


@pytest.mark.slow
@pytest.mark.parametrize("trajectory", TRAJECTORIES)
@pytest.mark.parametrize("scale", [1.4, 1.2, 0.8, 0.6])
def test_adaptation_and_model_help_in_every_uncertain_cell(couple, trajectory, scale):
    check_order(couple, trajectory, scale)


@pytest.mark.parametrize("schedule", ["jacobi", "jacobi-derivatives"])
def test_jacobi_schedule_tracks(couple, schedule):
    assert run(couple, "triangular", "adaptive", 1.2, schedule=schedule)[2] <= 0.3


def test_coupling_error_of_the_schedules(couple):
    """Against Gauss-Seidel at a quarter of the step: Gauss-Seidel and Jacobi with derivatives within 20 um at the tip,
    plain Jacobi within 100 um."""
    tips = {}
    for schedule, h in [("gauss-seidel", 2.5e-4), ("gauss-seidel", 1e-3), ("jacobi-derivatives", 1e-3), ("jacobi", 1e-3)]:
        settings = {"controller": {"trajectory": 2, "settle_time": 0.0}}
        master = couple(settings=settings, schedule=schedule, h=h)
        tips[schedule, h] = master.record(3.0, [f"hdrm.tip.position[{i}]" for i in (1, 2, 3)])[1][:: round(1e-3 / h)]
    exact = tips.pop(("gauss-seidel", 2.5e-4))
    errors = {key: np.linalg.norm(tip - exact, axis=1).max() for key, tip in tips.items()}
    print({key: f"{1e6 * error:.2f} um" for key, error in errors.items()})
    assert errors["gauss-seidel", 1e-3] < 20e-6
    assert errors["jacobi-derivatives", 1e-3] < 20e-6
    assert errors["jacobi", 1e-3] < 100e-6
