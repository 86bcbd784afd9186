"""Figures of runs and studies by matplotlib; each function returns the figure, and writes it if `path` is given."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

_SIZE = (8.0, 4.5)


def _figure(rows=1, height=1.0, share=True):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_SIZE[0], _SIZE[1] * height), layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=share, squeeze=False)[:, 0]


def _done(figure, path):
    if path is not None:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=150)
    return figure


def signals(data: xarray.Dataset, names: str | Iterable[str] | None = None, path: str | os.PathLike[str] | None = None) -> Figure:
    """Signals of a run over time, those of one unit in one panel; default: all."""
    names = [str(name) for name in data.data_vars] if names is None else [names] if isinstance(names, str) else list(names)
    by_unit: dict[str, list[str]] = {}
    for name in names:
        by_unit.setdefault(data[name].attrs.get("units", "1"), []).append(name)
    figure, axes = _figure(len(by_unit), 0.35 + 0.5 * len(by_unit))
    for axis, (unit, of) in zip(axes, by_unit.items()):
        for name in of:
            axis.plot(data["time"], data[name], label=name, linewidth=1)
        axis.set_ylabel(unit)
        axis.legend(fontsize="x-small", ncols=2)
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("time / s")
    return _done(figure, path)


def tip(data: xarray.Dataset, path: str | os.PathLike[str] | None = None) -> Figure:
    """The tip's path in the plane of the boom, and its error over time."""
    figure, (plane, error) = _figure(2, 1.5, share=False)
    for name, label in (("controller.desired.position", "desired"), ("hdrm.tip.position", "plant")):
        plane.plot(data[f"{name}[1]"], data[f"{name}[2]"], label=label, linewidth=1)
    plane.set(xlabel="x / m (forward)", ylabel="y / m (up)")
    plane.legend()
    error.plot(data["time"], 1e3 * data["controller.tip_error_norm"], linewidth=1)
    error.axvline(data.attrs["motion_start"], color="grey", linestyle=":")
    error.set(xlabel="time / s", ylabel="tip error / mm")
    figure.suptitle(f"RMSE {1e3 * data.attrs['tip_rmse']:.4f} mm, largest {1e3 * data.attrs['tip_max']:.4f} mm, verdict {data.attrs['verdict']}")
    return _done(figure, path)


def energy(data: xarray.Dataset, path: str | os.PathLike[str] | None = None) -> Figure:
    """Where the actuators' energy went over the motion, of a run with the metrics `energy`."""
    losses = ("copper", "core", "inverter", "mechanical")
    actuators = sorted(n.removeprefix("energy_").removesuffix("_copper") for n in data.attrs if n.endswith("_copper"))
    figure, (axis,) = _figure()
    bottom = np.zeros(len(actuators))
    for loss in losses:
        values = np.array([data.attrs[f"energy_{a}_{loss}"] for a in actuators])
        axis.bar(actuators, values, bottom=bottom, label=f"lost: {loss}")
        bottom += values
    axis.scatter(actuators, [data.attrs[f"energy_{a}_electrical"] for a in actuators], color="black", marker="_", s=400, label="taken")
    axis.scatter(actuators, [data.attrs[f"energy_{a}_regenerated"] for a in actuators], color="green", marker="_", s=400, label="given back")
    axis.set_ylabel("energy over the motion / J")
    axis.legend(fontsize="small")
    return _done(figure, path)


def spread(table: pandas.DataFrame, metric: str = "known_rmse", by: str = "mode", path: str | os.PathLike[str] | None = None, scale: float = 1e3, unit: str = "mm") -> Figure:
    """Distribution of a metric over the rows of a sweep, one box a value of the column `by`; each run is a point."""
    good = table[table["verdict"] != "failed"]
    groups = {str(name): scale * of[metric].dropna().to_numpy() for name, of in good.groupby(by, sort=False)}
    figure, (axis,) = _figure()
    axis.boxplot(list(groups.values()), tick_labels=list(groups), showfliers=False)
    for k, values in enumerate(groups.values(), 1):
        axis.scatter(np.full(len(values), k), values, s=8, alpha=0.5)
    axis.set(ylabel=f"{metric} / {unit}", title=f"{len(good)} runs, {len(table) - len(good)} failed")
    return _done(figure, path)


def indices(table: pandas.DataFrame, path: str | os.PathLike[str] | None = None) -> Figure:
    """Sobol indices with their 95 % confidence intervals, of `studies.sobol`."""
    figure, (axis,) = _figure()
    place = np.arange(len(table))
    for shift, name, label in ((-0.2, "S1", "first order"), (0.2, "ST", "total")):
        axis.bar(place + shift, table[name], 0.4, yerr=table[f"{name}_conf"], capsize=3, label=label)
    axis.set_xticks(place, table["parameter"], rotation=20, ha="right", fontsize="small")
    axis.set_ylabel("Sobol index")
    axis.legend()
    return _done(figure, path)


def tuning(history: pandas.DataFrame, path: str | os.PathLike[str] | None = None) -> Figure:
    """How a tuning went, of `studies.tune`: the objective of each try, and the best so far."""
    figure, (axis,) = _figure()
    axis.semilogy(history.index + 1, history["objective"], ".", label="tried")
    axis.semilogy(history.index + 1, history["objective"].cummin(), label="best so far")
    axis.set(xlabel="run", ylabel="objective")
    axis.legend()
    return _done(figure, path)
