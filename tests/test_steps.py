"""Communication steps of changing size, coupled: the same motion in the limit, approached at the order of the method."""

import numpy as np
import pytest

from fmpy_master import SCHEDULES, Master

UNTIL, FINEST = 0.4, 6400
ANGLES = [f"zeta[{i}]" for i in range(1, 7)]
PATTERNS = {"even": [1.0], "uneven": [1.6, 0.7, 0.4, 1.3]}


class Uneven(Master):
    """A master that is told every communication point."""

    def __init__(self, times, *arguments, **options):
        self.times = times
        super().__init__(*arguments, **options)

    @property
    def time(self):
        return self.times[self.steps]

    @property
    def h(self):
        return self.times[self.steps + 1] - self.times[self.steps]

    @h.setter
    def h(self, _):
        """The master's constant step, which is not used."""


@pytest.fixture
def angles(system, fmus):
    """Joint angles after `count` steps to UNTIL, their sizes as `pattern` says; the tip moves from 0.05 s on."""

    def angles(count, pattern, schedule):
        times = np.concatenate([[0.0], np.cumsum(np.tile(pattern, count // len(pattern)))]) * UNTIL / max(count, 1)
        master = Uneven(times.tolist(), system, fmus, settings={"controller": {"settle_time": 0.05}}, schedule=schedule)
        while master.steps < count:
            master.step()
        found = np.array(master.instances["hdrm"].get(*ANGLES))
        master.free()
        return found

    return angles


@pytest.mark.parametrize("schedule", SCHEDULES)
def test_uneven_steps_converge_to_the_result_of_fine_even_ones(angles, schedule):
    """The controller holds its voltages over a step: first order. Against a reference of FINEST even steps, itself off by
    c/FINEST, halving all steps divides the difference by (1/n - 1/FINEST) / (1/2n - 1/FINEST); terms of second order change
    that by some per cent. Second order would divide by 4.3 and 5.4 where 2.1 and 2.3 are expected."""
    reference = angles(FINEST, PATTERNS["even"], schedule)
    assert np.abs(reference - angles(0, PATTERNS["even"], schedule)).max() > 1e-3, "the arm did not move"
    for name, pattern in PATTERNS.items():
        counts = (400, 800, 1600)
        # Uneven steps are worse by the mean square of their size.
        size = np.mean(np.square(pattern))
        errors = [np.abs(angles(n, pattern, schedule) - reference).max() for n in counts]
        for n, coarse, fine in zip(counts, errors, errors[1:]):
            expected = (size / n - 1 / FINEST) / (size / (2 * n) - 1 / FINEST)
            assert coarse / fine == pytest.approx(expected, rel=0.05), (name, n, errors)
