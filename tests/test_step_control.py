"""Communication steps that are chosen, on the quarter car of Sadjina et al. (arXiv 1602.06434), compared with its exact motion."""

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


OSCILLATOR = Case(4.0, d=0.0, height=0.0, s_start=0.1)
ROAD = Case(16.0, time=0.5, period=4.0, load=WEIGHT)


@pytest.mark.parametrize(
    "case, options, gain",
    [
        (Case(8.0), ["--energy-tolerance", "1e-4"], 2.0),
        (Case(8.0), ["--energy-tolerance", "1e-4", "--repeat-steps"], 2.0),
        (Case(8.0), ["--doubling-tolerance", "1e-3"], 1.5),
        (ROAD, ["--energy-tolerance", "1e-3", "--repeat-steps"], 2.0),
        (OSCILLATOR, ["--energy-tolerance", "1e-3"], 1 / 1.2),
    ],
    ids=["energy", "energy repeated", "doubling", "road up and down, energy repeated", "no slow phase"],
)
def test_a_fast_and_a_slow_phase_take_fewer_steps_than_fixed_ones(quarter_car, case, options, gain):
    """After an edge of the road the wheel swings fast and dies away. Fixed steps are of first order: the number of steps that gives an error
    is that of one run times the ratio of the errors. Found 2.3, 2.3, 2.0, 3.5, and 1.0 where there is no slow phase; nothing here depends on how
    busy the machine is."""
    fixed_steps, fixed_error, _ = run(program("cosim"), quarter_car, case, ["--step", "1e-3"])
    steps, error, column = run(program("cosim"), quarter_car, case, options)
    print(f"{fixed_steps} fixed steps: {fixed_error:.2e}; {steps} by {options}: {error:.2e}")
    assert gain * steps < fixed_steps * fixed_error / error
    made = column["step"][1:]
    np.testing.assert_allclose(np.cumsum(made), column["time"][1:], rtol=1e-12)
    # Lengths are differences of times up to 16 s, which are rounded by some 2e-15 s.
    assert made.min() >= 1e-5 - 1e-14 and made.max() <= 1e-2 + 1e-14


@pytest.mark.parametrize("case, part", [(Case(8.0), 0.3), (OSCILLATOR, 0.05)], ids=["linear", "oscillator"])
def test_balanced_inputs_are_of_second_order(quarter_car, case, part):
    """What effort and flow lacked over a step is added to them over the next one: an error of second order, a fourth at half the step to the
    terms of third order (10 % allowed), and at 1 ms a part of that of held inputs without mean efforts. Found 0.23 and 0.012."""

    def error(step, *options):
        return run(program("cosim"), quarter_car, case, ["--step", step, *options])[1]

    balanced = [error(h, "--between", "balanced") for h in ("1e-3", "5e-4")]
    assert balanced[0] / balanced[1] == pytest.approx(4, rel=0.1)
    assert balanced[0] < part * error("1e-3", "--schedule", "jacobi")
