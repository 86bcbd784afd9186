"""Communication steps that are chosen, on the quarter car of Sadjina et al. (arXiv 1602.06434), beside its exact motion."""

import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import FMU_DIR
from native import program

sys.path.insert(0, str(Path(__file__).parent / "bench"))
from steps import WEIGHT, Case, packed, run  # noqa: E402


@pytest.fixture(scope="module")
def quarter_car(tmp_path_factory):
    """The packed example; `cargo xtask test` leaves its FMUs beside the folder of the FMUs."""
    folder = FMU_DIR.parent / "fmu-examples"
    assert (folder / "Chassis.fmu").is_file(), f"cargo xtask pack --package fmu-chassis --package fmu-wheel --profile release --out {folder}"
    return packed(folder, tmp_path_factory.mktemp("quarter_car"))


@pytest.mark.parametrize("exponent", [1.0, 0.5], ids=["linear", "exponent 0.5"])
def test_fixed_steps_converge_to_the_exact_motion(quarter_car, exponent):
    """Gauss-Seidel with a velocity that is held is of first order: half the step, half the error, to the terms of second order, which are
    some h w = 1e-3 * 64 / s of it; 10 % is allowed."""
    errors = [run(program("cosim"), quarter_car, Case(2.0, exponent=exponent), ["--step", h])[1] for h in ("1e-3", "5e-4")]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert errors[0] < 5e-3


def test_fast_and_slow_phases_take_less_than_half_of_the_steps(quarter_car):
    """The road goes up and down; after each edge the wheel swings fast and dies away. Fixed steps are of first order: the number that
    gives an error is that of one run times the ratio of the errors. Deterministic: the same on a busy machine."""
    case = Case(16.0, time=0.5, period=4.0, load=WEIGHT)
    fixed_steps, fixed_error, _ = run(program("cosim"), quarter_car, case, ["--step", "1e-3"])
    for options in (["--energy-tolerance", "1e-3", "--repeat-steps"], ["--doubling-tolerance", "1e-3"]):
        steps, error, column = run(program("cosim"), quarter_car, case, options)
        print(options, steps, error, "fixed", fixed_steps, fixed_error)
        assert 2 * steps < fixed_steps * fixed_error / error
        made = column["step"][1:]
        np.testing.assert_allclose(np.cumsum(made), column["time"][1:], rtol=1e-12)
        assert made.min() >= 1e-5 * (1 - 1e-6) and made.max() <= 1e-2 * (1 + 1e-9)
        # The controller keeps the error of most steps near what is allowed, or the step at its limits.
        assert np.median(column["step_error"][1:]) < 2
