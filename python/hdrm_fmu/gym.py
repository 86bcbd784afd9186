"""A Gymnasium environment of the manipulator or any other system, for reinforcement learning. Needs the extra `gym`: `pip install hdrm_fmu[gym]`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from typing import Any

import gymnasium
import numpy as np

from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.names import by_name, positive, whole
from hdrm_fmu.machines import read_machine
from hdrm_fmu.running import all_settings, refuse, world_system
from hdrm_fmu.system import Files, System

Bounds = Mapping[str, "tuple[float, float]"]


class Environment(gymnasium.Env[np.ndarray, np.ndarray]):
    """A system that an agent acts on.

    Parameters
    ----------
    system : what is run: a `System` or its files, default: the manipulator in `world`.
    actions : inputs that no connection drives, or tunable parameters. An action has a number from -1 to 1 for each element of these: the bounds
        of the variable, which `action_units` belong to.
    observations : variables that the agent sees, in their own units (`observation_units`) and within their bounds.
    reward : function of the observation, the action and the `System`, of which it may `get` anything.
    bounds : (low, high) by name, for variables whose FMU declares none, or narrower ones.
    every : communication steps that an action lasts.
    duration : time after which an episode is truncated, s.
    world, machine, settings : as of `run`. In the world `real` each episode draws a machine by the seed of the environment.
    terminated : function like `reward` that says whether an episode is over.
    failure : reward of an action with which the run fails; default: the error is raised.

    An episode also ends when an observation leaves its bounds: `info["left"]` names the variable.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        system: System | Files | None = None,
        *,
        actions: Iterable[str],
        observations: Iterable[str],
        reward: Callable[[np.ndarray, np.ndarray, System], float],
        bounds: Bounds | None = None,
        every: int = 10,
        duration: float = 10.0,
        world: str = "ideal",
        machine: Any = None,
        settings: Mapping[str, object] | None = None,
        terminated: Callable[[np.ndarray, np.ndarray, System], bool] | None = None,
        failure: float | None = None,
    ) -> None:
        self._machine, parameters = read_machine(machine)
        if system is None:
            self.system = world_system(world, parameters, step=1e-3)
        else:
            refuse("is for the manipulator, not for a `system` of one's own", world=None if world == "ideal" else world)
            self.system = system if isinstance(system, System) else System(system)
        self._world, self._settings, self._reward, self._terminated, self._failure = world, by_name(settings), reward, terminated, failure
        self._every, limits = whole("every", every, 1), by_name(bounds)
        self._last = round((positive("duration", duration) or 0.0) / self.system.step_size)
        self._actions, self._observations = tuple(actions), tuple(observations)
        low, high, self.action_units = self._bounds(self._actions, limits)
        self._middle, self._half = (low + high) / 2, (high - low) / 2
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, low.shape, np.float64)
        self._low, self._high, self.observation_units = self._bounds(self._observations, limits)
        self.observation_space = gymnasium.spaces.Box(self._low, self._high, dtype=np.float64)
        if unknown := limits.keys() - {*self._actions, *self._observations}:
            raise BadInput(f"bounds of `{min(unknown)}`: it is no action and no observation")
        self._stack: ExitStack | None = None

    def _bounds(self, names, given):
        """Lower and upper bounds and units of the elements of these variables."""
        rows = []
        for name in names:
            for v in self.system._names.many(name):
                low, high = given.get(name, (v.minimum, v.maximum))
                if low is None or high is None or not (math.isfinite(low) and math.isfinite(high) and low < high):
                    raise BadInput(f"`{v.name}` needs bounds, finite and the first less than the second: bounds={{{name!r}: (low, high)}} in {v.unit or '1'}")
                rows.append((low, high, v.unit or "1"))
        if not rows:
            raise BadInput("an environment needs actions and observations")
        low, high, units = zip(*rows)
        return np.array(low, dtype=float), np.array(high, dtype=float), units

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; `options["settings"]` are start values of this one."""
        super().reset(seed=seed)
        values = {**self._settings, **by_name((options or {}).get("settings"))}
        drawn = int(self.np_random.integers(2**31)) if self._world == "real" else None
        with all_settings(self.system, values, drawn, self._machine) as (settings, _):
            if self._stack is None:
                self._stack = ExitStack()
                before = self.system.settings
                self.system.settings = {**before, **settings}
                try:
                    self._stack.enter_context(self.system)
                finally:
                    self.system.settings = before
            else:
                self.system.reset(settings)
        self._acting, self._seeing = self.system.port(self._actions), self.system.port(self._observations)
        self._steps = 0
        self._seen = self._seeing.get()
        return self._seen, {"seed": drawn}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Set the action, and let time pass."""
        if self._stack is None:
            raise BadInput("`step` comes after `reset`")
        self._acting.set(self._middle + self._half * np.clip(action, -1.0, 1.0))
        self._steps += self._every
        truncated = self._steps >= self._last
        try:
            self.system.step(self._every)
            seen = self._seen = self._seeing.get()
        except RunFailed as error:
            if self._failure is None:
                raise
            return self._seen, self._failure, True, truncated, {"error": str(error)}
        beyond = np.flatnonzero(~((self._low <= seen) & (seen <= self._high)))
        info = {"left": self._seeing.variables[beyond[0]].name} if len(beyond) else {}
        over = bool(info) or bool(self._terminated and self._terminated(seen, action, self.system))
        return seen, float(self._reward(seen, action, self.system)), over, truncated, info

    def close(self) -> None:
        """End the run."""
        if self._stack is not None:
            # What an agent did to the machine is no warning.
            self.system._is_judged = True
            self._stack.close()
            self._stack = None
