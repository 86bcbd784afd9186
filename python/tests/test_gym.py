"""The environment of Gymnasium, and the example."""

import importlib.util
import warnings
from pathlib import Path

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from hdrm_fmu import BadInput, fmus
from hdrm_fmu.gym import Environment

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/gym_reach.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("gym_reach", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def motor(**options):
    bounds = {"v_q": (-40.0, 40.0), "i_q": (-500.0, 500.0)}
    reward = lambda seen, action, system: -abs(seen[0] - 5.0) - abs(action[0]) * system.get("i_d", float)
    return Environment(fmus()["Emla"], actions=["v_q"], observations=["i_q"], reward=reward, settings={"x": 0.4}, duration=0.1, **{"bounds": bounds, **options})


@pytest.mark.parametrize("world", ["ideal", "real"])
def test_the_checker_of_gymnasium_has_nothing_to_say(example, world):
    env = example.environment(world=world)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env, skip_render_check=True)


def test_the_example_learns_nothing_but_moves(example):
    env = example.environment()
    start, _ = env.reset(seed=1)
    still = example.episode(env, lambda seen: start / 6.0, 1)
    moved = example.episode(env, lambda seen: (seen + 0.1 * (example.GOAL - seen)) / 6.0, 1)
    env.close()
    assert moved > still + 1.0


def test_bounds_and_units_are_those_of_the_variables():
    env = motor()
    assert env.action_units == ("V",) and env.observation_units == ("A",)
    assert env.observation_space.high == 500.0 and env.action_space.high == 1.0
    env.reset(seed=3)
    seen, reward, terminated, truncated, _ = env.step(np.array([0.1]))
    assert env.system.get("v_q") == pytest.approx(4.0) and seen[0] > 0 and reward < 0 and not (terminated or truncated)
    again = motor()
    again.reset(seed=3)
    assert again.step(np.array([0.1]))[0] == seen
    env.close()
    left = motor(bounds={"v_q": (-40.0, 40.0), "i_q": (-0.1, 0.1)})
    left.reset()
    *_, terminated, _, info = left.step(np.array([1.0]))
    assert terminated and info == {"left": "Emla.i_q"}
    with pytest.raises(BadInput, match=r"`Emla.i_q` needs bounds.* in A"):
        motor(bounds={"v_q": (-1.0, 1.0), "i_q": (0.0, np.inf)})
    with pytest.raises(BadInput, match="no action and no observation"):
        motor(bounds={"v_q": (-1.0, 1.0), "i_q": (-9.0, 9.0), "i_d": (-1.0, 1.0)})


def test_seeds_draw_the_machines_of_the_real_world(example):
    env = example.environment(world="real")
    seen = [env.reset(seed=seed)[0] for seed in (1, 2, 1)]
    env.close()
    assert np.array_equal(seen[0], seen[2]) and not np.array_equal(seen[0], seen[1])
