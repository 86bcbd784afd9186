"""What sweeps are for: Monte Carlo, sensitivity, tuning."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas

from hdrm_fmu import _native
from hdrm_fmu.cases import grid
from hdrm_fmu.errors import BadInput
from hdrm_fmu.names import unknown, whole
from hdrm_fmu.running import run, world_system
from hdrm_fmu.sweeping import chosen_system, sweep


def monte_carlo(
    seeds: int | Iterable[int],
    *,
    out: str | os.PathLike[str],
    modes: Iterable[str] = ("adaptive_integral",),
    trajectories: Iterable[str] = ("cubic",),
    **options: Any,
) -> pandas.DataFrame:
    """Runs in the world `real` over machines and sensors drawn by seed: bodies' masses, inertias and centres of mass, lengths, plumb, zeros
    and offsets of the sensors.

    Parameters
    ----------
    seeds : number of machines, or the seeds themselves.
    modes, trajectories : compared on the same machines; with `waypoints` all follow that path instead of a trajectory.
    out, **options : as of `sweep`.

    Returns
    -------
    DataFrame of `sweep` with the metrics `tracking`: `known_rmse` (m) is the error that a controller which reads joints can know.
    """
    seeds = list(range(1, seeds + 1) if isinstance(seeds, int) else seeds)
    columns = {"mode": list(modes), "trajectory": list(trajectories), "seed": seeds}
    if options.get("waypoints") is not None:
        del columns["trajectory"]
    cases = grid(**columns)
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
    """Find gains that make a metric small on one trajectory, by SciPy's Nelder–Mead on their logarithms, and judge them on another.

    Parameters
    ----------
    gains : (low, high) by name, both > 0; the search begins at the start value of the FMU, or in the middle where that is outside.
    metric : what is made small; an attribute of `run`.
    trajectory, held_out : on which the gains are searched, and judged.
    runs : at most.
    **options : as of `run`; with `world="real"` and `seeds` the mean over these machines is taken.

    Returns
    -------
    (result, history): `result` has the gains found, and the metric on both trajectories before and after; `history` is a DataFrame of all tries.
    """
    from scipy.optimize import minimize

    system = world_system(options.get("world", "ideal"))
    names = system._names
    _check_ranges(gains, names)
    for on in (trajectory, held_out):
        names.settings({"trajectory": on})
    asked, runs = _metrics(metric, system), whole("runs", runs, 1)
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
    tried = []

    def measure(values, on):
        found = [
            run(trajectory=on, seed=seed, settings={**fixed, **values}, signals=[], metrics=asked, **options).attrs for seed in seeds
        ]
        return float(np.mean([f[metric] for f in found]))

    def objective(logs):
        values = dict(zip(gains, np.exp(logs).tolist()))
        tried.append({**values, "objective": measure(values, trajectory)})
        return tried[-1]["objective"]

    before = dict(zip(gains, np.exp(start).tolist()))
    limits = {"maxfev": runs, "xatol": 1e-2, "fatol": 0.0}
    minimize(objective, start, method="Nelder-Mead", bounds=list(zip(low, high)), options=limits)
    history = pandas.DataFrame(tried)
    best = history.iloc[int(history["objective"].argmin())]
    gained = {name: float(best[name]) for name in gains}
    result = {
        "gains": gained,
        "start": before,
        trajectory: {"before": tried[0]["objective"], "after": float(best["objective"])},
        held_out: {"before": measure(before, held_out), "after": measure(gained, held_out)},
    }
    return result, history


def _metrics(metric, system):
    """What a run must be asked for so that it has a metric."""
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
