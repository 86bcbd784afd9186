"""The manipulator as an environment of Gymnasium: the tip is to reach a point, whose place an agent moves as the controller's reference.

    pip install hdrm_fmu[gym]
    python examples/gym_reach.py

Prints the reward of two agents: one that keeps still, one that moves the reference to the goal.
"""

import numpy as np

from hdrm_fmu.gym import Environment

GOAL = np.array([3.3, 1.0, 0.2])
REFERENCE, TIP = "controller.reference.position", "hdrm.tip.position"


def environment(**options):
    """The tip's distance from the goal is what each action costs, m; the action is the reference, m."""
    bounds = {REFERENCE: (-6.0, 6.0), TIP: (-6.0, 6.0)}
    reward = lambda seen, action, system: -float(np.linalg.norm(seen - GOAL))
    settings = {"trajectory": "external"}
    return Environment(actions=[REFERENCE], observations=[TIP], reward=reward, bounds=bounds, every=20, duration=2.0, settings=settings, **options)


def episode(env, agent, seed):
    """Sum of the rewards."""
    seen, _ = env.reset(seed=seed)
    total, over = 0.0, False
    while not over:
        seen, reward, terminated, truncated, _ = env.step(agent(seen))
        total, over = total + reward, terminated or truncated
    return total


def main():
    env = environment()
    start, _ = env.reset(seed=1)
    print(f"keeps still:       {episode(env, lambda seen: start / 6.0, 1):8.3f} m")
    toward = lambda seen: (seen + 0.1 * (GOAL - seen)) / 6.0
    print(f"moves to the goal: {episode(env, toward, 1):8.3f} m")
    env.close()


if __name__ == "__main__":
    main()
