"""Linearization of a system that is stepped, for `System.linearize`."""

from __future__ import annotations

from functools import partial

import numpy as np

from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.names import whole

#: Change of an input relative to the range between its bounds, or to its value, and the singular value relative to the largest that counts.
DELTA, TOLERANCE = 1e-4, 1e-6


def linearize(system, inputs, outputs, every, horizon, order, tolerance, delta):
    """See `System.linearize`."""
    import control

    every, horizon = whole("every", every, 1), whole("horizon", horizon, 2)
    acting, seeing = system.port(list(inputs)), system.port(list(outputs))
    names = [v.name for v in acting.variables]
    at, back = acting.get(), _way_back(system)
    scale = [v.maximum - v.minimum if None not in (v.minimum, v.maximum) else max(1.0, abs(u)) for v, u in zip(acting.variables, at)]
    steps = np.array([(delta or {}).get(name, DELTA * of) for name, of in zip(names, scale)], dtype=float)
    if unknown := (delta or {}).keys() - set(names):
        raise BadInput(f"delta of `{min(unknown)}`: it is none of the inputs {', '.join(names)}")

    def answer(change):
        """Outputs at once and after each sample, of which the first has changed inputs."""
        back()
        acting.set(at + change)
        seen = [seeing.get()]
        for k in range(2 * horizon):
            system.step(every)
            if k == 0:
                acting.set(at)
            seen.append(seeing.get())
        return np.array(seen)

    impulses = np.eye(len(at)) * steps
    # Shape (samples, outputs, inputs).
    markov = np.stack([(answer(x) - answer(-x)) / (2 * step) for x, step in zip(impulses, steps)], axis=-1)
    back()
    direct, markov = markov[0], markov[1:]
    hankel = lambda first: np.block([[markov[i + j + first] for j in range(horizon)] for i in range(horizon)])
    u, s, v = np.linalg.svd(hankel(0))
    rank = int(np.sum(s > tolerance * s[0])) if s[0] > 0 else 0
    n = rank if order is None else whole("order", order, 0)
    if n > len(s) - max(markov.shape[1:]):
        raise BadInput(f"order = {n} is too much for horizon = {horizon} samples: give a longer horizon, or a larger tolerance")
    root = np.sqrt(s[:n])
    left, right = u[:, :n] * root, root[:, None] * v[:n]
    a = (u[:, :n] / root).T @ hankel(1) @ (v[:n].T / root) if n else np.zeros((0, 0))
    b, c = right[:, : len(at)], left[: len(seeing.variables)]
    # Names of signals of `control` have no dots.
    titles = {"inputs": [n.replace(".", "_") for n in names], "outputs": [v.name.replace(".", "_") for v in seeing.variables]}
    return control.StateSpace(a, b, c, direct, every * system.step_size, **titles)


def _way_back(system):
    """Goes back to the present point: by a saved state, or at the start of a run by starting it anew."""
    try:
        return partial(system.restore, system.save())
    except RunFailed:
        if system.time != system._from:
            raise
        return partial(system._start, system._again)
