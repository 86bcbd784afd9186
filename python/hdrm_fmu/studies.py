"""Studies made of many runs: Monte Carlo, sensitivity (Sobol indices), tuning of gains."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas

from hdrm_fmu import _native
from hdrm_fmu.cases import grid
from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.names import unknown, whole
from hdrm_fmu.machines import Machine
from hdrm_fmu.running import refuse, run, world_system
from hdrm_fmu.sweeping import chosen_system, sweep

#: Share of a range's logarithm within which a gain counts as being at its bound.
AT_BOUND = 0.01


def monte_carlo(
    seeds: int | Iterable[int],
    *,
    out: str | os.PathLike[str],
    modes: Iterable[str] = ("adaptive_integral",),
    trajectories: Iterable[str] | None = None,
    **options: Any,
) -> pandas.DataFrame:
    """Runs in the world `real` over machines and sensors drawn by seed: bodies' masses, inertias and centres of mass, lengths, plumb, zeros
    and offsets of the sensors.

    Parameters
    ----------
    seeds : number of machines, or the seeds themselves.
    modes, trajectories : compared on the same machines; default: `cubic`. With `waypoints` all follow that path, and trajectories are refused.
    out, **options : as of `sweep`.

    Returns
    -------
    DataFrame of `sweep` with the metrics `tracking`: `known_rmse` (m) is the error that a controller which reads joints can know.
    """
    seeds = list(range(1, seeds + 1) if isinstance(seeds, int) else seeds)
    columns = {"mode": list(modes)}
    if options.get("waypoints") is None:
        columns["trajectory"] = ["cubic"] if trajectories is None else list(trajectories)
    else:
        refuse("is for runs without waypoints, which all follow that path", trajectories=trajectories)
    cases = grid(**columns, seed=seeds)
    options.setdefault("metrics", ("tracking",))
    return sweep(cases, out=out, world="real", **options)


def summary(table: pandas.DataFrame, metric: str = "known_rmse", by: Iterable[str] = ("mode", "trajectory")) -> pandas.DataFrame:
    """Median, 95 % quantile and worst of a metric for each group; failed runs count as infinite."""
    values = table.assign(**{metric: table[metric].where(table["verdict"] != "failed", math.inf)})
    groups = values.groupby([c for c in by if c in table.columns], sort=False)[metric]
    return pandas.DataFrame(groups.agg(median="median", q95=lambda v: v.quantile(0.95, interpolation="higher"), worst="max", runs="size"))


def sobol(
    ranges: Mapping[str, tuple[float, float]],
    *,
    out: str | os.PathLike[str],
    base: int = 64,
    seed: int = 1,
    metric: str = "tip_rmse",
    second_order: bool = False,
    **options: Any,
) -> pandas.DataFrame:
    """Sobol indices of a metric by SALib: which parameter makes how much of its variance.

    Parameters
    ----------
    ranges : (low, high) by name of the parameter.
    base : size of the base sample, a power of 2; `base * (k + 2)` runs for k parameters, twice k with `second_order`.
    seed : of the sample's scrambling and of the confidence intervals.
    metric : column of the sweep.
    out, **options : as of `sweep`.

    Returns
    -------
    DataFrame with a row a parameter: first-order and total index, `S1` and `ST`, with their 95 % confidence intervals.
    """
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as sample

    if base < 2 or base & (base - 1):
        raise BadInput(f"base = {base} must be a power of 2")
    system = chosen_system(options.get("world", "ideal"), options.get("system"))
    _check_ranges(ranges, system._names)
    options["metrics"] = sorted({*options.get("metrics", ()), *_metrics(metric, system)})
    names = list(ranges)
    problem = {"num_vars": len(names), "names": names, "bounds": [list(ranges[n]) for n in names]}
    values = sample.sample(problem, base, calc_second_order=second_order, seed=seed)
    table = sweep(pandas.DataFrame(values, columns=names), out=out, **options)
    failed = table["verdict"] == "failed"
    if failed.any():
        raise BadInput(f"{failed.sum()} of {len(table)} runs failed, the first: {table.loc[failed, 'error'].iloc[0]}; narrow the ranges")
    found = analysis.analyze(problem, table[metric].to_numpy(), calc_second_order=second_order, seed=seed)
    return pandas.DataFrame({"parameter": names, **{n: found[n] for n in ("S1", "S1_conf", "ST", "ST_conf")}})


def tune(
    gains: Mapping[str, tuple[float, float]],
    *,
    metric: str = "tip_rmse",
    trajectory: str = "cubic",
    held_out: str = "triangular",
    runs: int = 60,
    **options: Any,
) -> tuple[dict[str, Any], pandas.DataFrame]:
    """Find gains that make a metric small on one trajectory, and judge them on another.

    In the world `real` with a `machine`, the second try takes the gains by the rule of `hdrm-fmu machine gains`. A third of the tries is a coarse scan of the whole ranges (SciPy's Halton sequence on the gains' logarithms); SciPy's Nelder–Mead goes on
    from the best of it. Tries with a run that fails or has the verdict BAD are counted and never chosen, unless all are such.

    Parameters
    ----------
    gains : (low, high) by name, both > 0. The first try is the start value of the FMU, or the middle where that is outside.
    metric : what is made small; an attribute of `run`.
    trajectory, held_out : on which the gains are searched, and judged.
    runs : number of tries, at most.
    **options : as of `run`; with `world="real"` and `seeds` the mean over these machines is taken.

    Returns
    -------
    (result, history): `result` has the gains found (`gains`), those at a bound of their range, where the best may lie beyond (`at_bound`), the
    number of tries that were bad (`bad`), the gains at the start and, of a machine in the world `real`, by the rule (`rule`), and the metric on both trajectories before and after; `history` is a
    DataFrame of all tries, with the number of bad runs of each.
    """
    from scipy.optimize import minimize
    from scipy.stats.qmc import Halton

    system = world_system(options.get("world", "ideal"))
    names = system._names
    _check_ranges(gains, names)
    for on in (trajectory, held_out):
        names.settings({"trajectory": on})
    metrics, runs = _metrics(metric, system), whole("runs", runs, 1)
    seeds = options.pop("seeds", [None])
    fixed = dict(options.pop("settings", {}) or {})
    low, high, start = [], [], []
    for name, (lower, upper) in gains.items():
        if lower <= 0:
            raise BadInput(f"`{name}` from {lower} to {upper}: both must be more than 0")
        first = float(names.one(name).start or "nan")
        low.append(math.log(lower))
        high.append(math.log(upper))
        start.append(math.log(first) if lower <= first <= upper else (low[-1] + high[-1]) / 2)
    tried: list[dict[str, float]] = []

    def measure(values, on):
        """The metric, infinite where a run fails, and the number of runs that are bad."""
        found, bad = [], 0
        for seed in seeds:
            try:
                made = run(trajectory=on, seed=seed, settings={**fixed, **values}, signals=[], metrics=metrics, **options).attrs
            except RunFailed:
                made = {metric: math.inf, "verdict": "failed"}
            found.append(made[metric])
            bad += made["verdict"] != "good"
        return float(np.mean(found)), bad

    def attempt(logs):
        values = {name: float(np.clip(math.exp(x), *gains[name])) for name, x in zip(gains, logs)}
        objective, bad = measure(values, trajectory)
        tried.append({**values, "objective": objective, "bad": bad})

    def best(among):
        """Index of the best try, a good one where there is one."""
        return min(among, key=lambda k: (tried[k]["bad"] > 0, tried[k]["objective"]))

    def objective(logs):
        attempt(logs)
        last = tried[-1]
        return math.inf if last["bad"] and not tried[best(range(len(tried)))]["bad"] else last["objective"]

    attempt(start)
    ruled = _ruled(options, gains)
    if ruled and runs > 1:
        attempt([math.log(ruled.get(name, math.exp(first))) for name, first in zip(gains, start)])
    for point in Halton(len(gains), seed=1).random(max(0, min(runs // 3, runs - len(tried)))):
        attempt(np.array(low) + point * (np.array(high) - np.array(low)))
    left = runs - len(tried)
    if left > 0:
        first = tried[best(range(len(tried)))]
        limits = {"maxfev": left, "xatol": 1e-2, "fatol": 0.0}
        logs = [math.log(first[name]) for name in gains]
        minimize(objective, logs, method="Nelder-Mead", bounds=list(zip(low, high)), options=limits)
    found = tried[best(range(len(tried)))]
    gained, before = ({name: of[name] for name in gains} for of in (found, tried[0]))
    near = [min(math.log(gained[n]) - lower, upper - math.log(gained[n])) / (upper - lower) for n, lower, upper in zip(gains, low, high)]
    for name, value in ruled.items():
        if name in ("gamma", "controller.gamma") and gained[name] < value / 2:
            warnings.warn(
                f"{name} = {gained[name]:.3g} adapts faster than the lowest mode of this machine allows on actuators as built; the rule of "
                f"`hdrm-fmu machine gains` gives {value:.3g}, outside of the range or not the best on these runs",
                stacklevel=2,
            )
    result = {
        "gains": gained,
        "at_bound": [name for name, share in zip(gains, near) if share < AT_BOUND],
        "bad": sum(t["bad"] > 0 for t in tried),
        "start": before,
        "rule": ruled,
        trajectory: {"before": tried[0]["objective"], "after": found["objective"]},
        held_out: {"before": measure(before, held_out)[0], "after": measure(gained, held_out)[0]},
    }
    return result, pandas.DataFrame(tried)


def _ruled(options, gains):
    """The values of these gains by the rule; none without a machine on actuators as built."""
    if options.get("world") != "real" or options.get("machine") is None:
        return {}
    rule = Machine(options["machine"]).gains()["value"]
    return {name: float(rule[name.removeprefix("controller.")]) for name in gains if name.removeprefix("controller.") in rule}


def _metrics(metric, system):
    """The value of the option `metrics` with which a run has a metric."""
    actuators = [name.removesuffix(".energy.in") for name in system.variables if name.endswith(".energy.in")]
    known = _native.metric_names([*actuators, "all"])
    if metric not in known:
        raise unknown("metric", metric, known)
    return (known[metric],) if known[metric] else ()


def _check_ranges(ranges, names):
    """Refuse ranges that are none, and those of unknown parameters."""
    if not ranges:
        raise BadInput("there are no parameters")
    for name, bounds in ranges.items():
        try:
            lower, upper = map(float, bounds)
        except (TypeError, ValueError):
            raise BadInput(f"`{name}`: {bounds!r} must be a pair of numbers (low, high)") from None
        if not lower < upper:
            raise BadInput(f"`{name}` from {lower} to {upper}: the second must be more than the first")
        for bound in (lower, upper):
            names.settings({name: bound})
