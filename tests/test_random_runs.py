"""1000 random command lines of `cosim run`: exit code, verdict and files are as the oracle of `random_runs.py` says."""

import random_runs
from native import program


def test_what_a_run_says_is_what_it_did():
    found = random_runs.run_all(program("cosim"), 1000)
    assert not found, "\n".join(found[:20])
