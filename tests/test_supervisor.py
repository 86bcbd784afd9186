"""The controller's supervisor on `Real.ssp` as it opens, with gains that no plant stands: adaptation frozen, gains lowered, machine stopped, each where
the action before does not suffice. The plants that are kept, on which it must do nothing, are those of `test_plants.py`.

A rod ripples by the root mean square of its force around a mean over 0.15 s: 0.25 kN as drawn, tens of kN where it swings."""

import csv
import re

import numpy as np
import pytest

from native import call, named
from test_plants import AXES, TWELVE, joined, mount, payload

WATCHING, FROZEN, LOWERED, STOPPED = 2, 3, 4, 7
LIMIT = 1.2 * 70e3
FLAGS = [f"controller.{name}[{k}]" for name in ("enable", "brake") for k in (1, 2, 3)]
OFF = {"controller": {"supervisor": "false"}}
# With a part of it alone the machine does not swing.
WHOLE = {f"kappa_share[{k}]": 1 for k in (1, 2, 3)}
# Lost without the supervisor: how far it must go, and gains or plant.
CASES = {
    "frozen": (FROZEN, {"controller": {"gamma": 10}}),
    "lowered": (LOWERED, mount(3e7) | {"controller": {"gamma": 40} | WHOLE}),
    "stopped": (STOPPED, {"controller": {"kappa_KA": 120, "Lambda_orientation": 30} | WHOLE}),
    "too heavy": (STOPPED, payload(600)),
}


def run(fmu_dir, file, *plants):
    """Forces of the rods, N, stages of the supervisor, and enable and brake of each axis, a row a step."""
    signals = [*(f"{axis}.F" for axis in AXES), "controller.supervisor.state", *FLAGS]
    settings = named(joined(*plants, {"controller": {"mode": "adaptive_integral"}}))
    done = call("hdrm-fmu", "run", "--system", fmu_dir / "Real.ssp", "--stop-time", 13.75, "--csv", file, "--signals", ",".join(signals), *settings)
    assert done.returncode == 0, done.stderr
    with open(file) as lines:
        titles, *rows = csv.reader(lines)
    columns = dict(zip(titles, zip(*rows)))
    number = lambda text: {"true": 1.0, "false": 0.0}.get(text) if text in ("true", "false") else float(text)
    table = np.array([[number(text) for text in columns[signal]] for signal in signals]).T
    return table[:, :3], table[:, 3], table[:, 4:7], table[:, 7:], done.stdout + done.stderr


def ripple(forces):
    """Of the rod that ripples most, over the last 2 s, N."""
    last = forces[-2000:]
    mean = np.stack([np.convolve(F, np.ones(150) / 150, "same") for F in last.T], axis=1)
    return np.sqrt(np.mean((last - mean)[150:-150] ** 2, axis=0)).max()


@pytest.mark.parametrize("name", CASES)
def test_no_further_than_needed(fmu_dir, tmp_path, name):
    stage, plant = CASES[name]
    forces, stages, enable, brake, text = run(fmu_dir, tmp_path / "run.csv", plant)
    print(name, stages[-1], f"{np.abs(forces).max():.0f} N, ripple {ripple(forces):.0f} N")
    assert stages.max() == stages[-1] == stage
    assert np.all(np.diff(stages) >= 0), "what was done stays done"
    assert np.abs(forces).max() < 1.2 * LIMIT and ripple(forces) < 1e3
    is_stopped = stage == STOPPED
    assert np.all(brake[-1] == is_stopped) and np.all(enable[-1] != is_stopped)
    released = np.flatnonzero(enable[:, 0] == 0)
    if is_stopped:
        closed = released[0] - np.flatnonzero(brake[:, 0])[0]
        assert abs(closed - 50) <= 1, f"the gates stay on until the brakes have closed: {closed} ms"
    words = {
        FROZEN: "supervisor of controller: it froze the adaptation,",
        LOWERED: "supervisor of controller: it froze the adaptation and lowered the gains",
        STOPPED: "the supervisor stops the machine: `controller.supervisor.state`",
    }
    assert words[stage] in text and "it stopped the machine" not in text, "a stop is told by the alarm of the system alone"
    assert ("verdict: BAD" in text) or not is_stopped


def test_cosim_says_that_the_machine_was_stopped(fmu_dir):
    """The systems declare it; the master knows no machine. What only froze or lowered is no alarm."""
    for name, code in ("stopped", 2), ("lowered", 0):
        settings = named(joined(CASES[name][1], {"controller": {"mode": "adaptive_integral"}}))
        done = call("cosim", "run", "--quiet", "--check", "--system", fmu_dir / "Real.ssp", "--stop-time", 5, *settings)
        said = re.search(r"! the supervisor stops the machine: `controller.supervisor.state` is (stopping|braking), first at t = ", done.stdout)
        assert done.returncode == code and bool(said) == (code == 2), done.stdout


@pytest.mark.parametrize("name", ["frozen", "lowered", "stopped"])
def test_without_it_the_machine_swings(fmu_dir, tmp_path, name):
    forces, stages, *_ = run(fmu_dir, tmp_path / "run.csv", CASES[name][1], OFF)
    assert np.all(stages == 1) and ripple(forces) > 5e3


def test_where_it_does_nothing_it_changes_no_bit(fmu_dir, tmp_path):
    for plant in ("as drawn", "readings two steps late"):
        with_it, without = (run(fmu_dir, tmp_path / "run.csv", TWELVE[plant], more)[:2] for more in ({}, OFF))
        assert np.all(with_it[1] == WATCHING) and np.all(without[1] == 1)
        assert np.array_equal(with_it[0], without[0])


def test_a_prediction_over_voltages_that_no_drive_follows_is_refused(fmu_dir):
    done = call("hdrm-fmu", "run", "--system", fmu_dir / "Real.ssp", "--stop-time", 0.1, "--set", "controller.delay=1")
    assert done.returncode == 1 and "`delay` = 1 with `current_loop` = true" in done.stderr
