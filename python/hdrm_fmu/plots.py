"""Figures of runs and studies by matplotlib; each function returns the figure, and writes it if `path` is given.

An actuator has the same colour everywhere: slew, lift and tilt, and the joints that they move. So have the joints of the wrist, and x, y, z.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

_SIZE = (8.0, 4.5)

#: Colours of the actuators slew, lift and tilt and of their joints, then of the joints of the wrist.
COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b")
#: Colours of x, y and z.
_COORDINATES = ("#e377c2", "#7f7f7f", "#17becf")
_NAMES = ("slew", "lift", "tilt")


def _figure(rows=1, height=1.0, share=True):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_SIZE[0], _SIZE[1] * height), layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=share, squeeze=False)[:, 0]


def _done(figure, path):
    if path is not None:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=150)
    return figure


def _axis(name):
    """Number of the actuator or joint, from 0, that a signal belongs to; None if to none."""
    match = re.match(r"emla_(\d)(?:\.|$)", name) or re.search(r"\[(\d)\]$", name)
    axis = int(match[1]) - 1 + 3 * ("wrist" in name) if match else len(COLOURS)
    return axis if axis < len(COLOURS) and not _is_coordinate(name) else None


def _is_coordinate(name):
    return bool(re.search(r"(position|tip_error|tip\.velocity|gravity)\[[123]\]$", name))


def _style(names):
    """Colour and line of each signal of a panel: the colour of its axis, another line for each further signal of that axis."""
    others, seen, styles = iter(range(len(names))), {}, {}
    for name in names:
        axis = _axis(name)
        if _is_coordinate(name):
            colour = _COORDINATES[int(name[-2]) - 1]
        else:
            colour = ("black", "#bcbd22")[next(others) % 2] if axis is None else COLOURS[axis]
        seen[colour] = seen.get(colour, -1) + 1
        styles[name] = {"color": colour, "linestyle": ("-", "--", ":", "-.")[seen[colour] % 4]}
    return styles


def signals(data: xarray.Dataset, names: str | Iterable[str] | None = None, path: str | os.PathLike[str] | None = None) -> Figure:
    """Signals of a run over time, those of one unit in one panel; default: all."""
    names = [str(name) for name in data.data_vars] if names is None else [names] if isinstance(names, str) else list(names)
    by_unit: dict[str, list[str]] = {}
    for name in names:
        by_unit.setdefault(data[name].attrs.get("units", "1"), []).append(name)
    rows = [max(2.0, 0.22 * len(of)) for of in by_unit.values()]
    figure, axes = _figure(len(by_unit), (0.7 + sum(rows)) / _SIZE[1])
    axes[0].get_gridspec().set_height_ratios(rows)
    for axis, (unit, of) in zip(axes, by_unit.items()):
        for name, style in _style(of).items():
            axis.plot(data["time"], data[name], label=name, linewidth=1, **style)
        axis.set_ylabel("number" if unit == "1" else unit)
        axis.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("time / s")
    return _done(figure, path)


#: Views of the tip's path: title, and for both directions the element of the position, its label, and whether it grows to the left or down.
_VIEWS = (
    ("from the side", (1, "x / m (forward)", False), (2, "y / m (up)", False)),
    ("from above", (1, "x / m (forward)", False), (3, "z / m (right)", True)),
    ("from behind", (3, "z / m (right)", False), (2, "y / m (up)", False)),
)
#: Points of a path that are drawn.
_POINTS = 4000


def tip(data: xarray.Dataset, path: str | os.PathLike[str] | None = None) -> Figure:
    """The tip's path in three views of the same scale, with its error as colour, and the error over time."""
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=[1.5, 1.0])
    every = slice(None, None, 1 + len(data["time"]) // _POINTS)
    plant, desired = (np.stack([data[f"{name}[{k}]"] for k in (1, 2, 3)]) for name in ("hdrm.tip.position", "controller.desired.position"))
    time, error = data["time"].to_numpy(), 1e3 * data["controller.tip_error_norm"].to_numpy()
    both = np.concatenate([plant, desired], axis=1)
    middle, half = (both.max(axis=1) + both.min(axis=1)) / 2, 0.55 * max(np.ptp(both, axis=1).max(), 1e-3)
    for k, (title, across, up) in enumerate(_VIEWS):
        view = figure.add_subplot(grid[0, k], aspect="equal")
        view.plot(desired[across[0] - 1, every], desired[up[0] - 1, every], color="0.8", linewidth=5, solid_capstyle="round", label="desired")
        points = plant[[across[0] - 1, up[0] - 1]][:, every].T
        drawn = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), array=error[every][1:], cmap="viridis", linewidth=1.5, label="plant")
        view.add_collection(drawn)
        for place, (element, label, is_reversed) in ((view.xaxis, across), (view.yaxis, up)):
            limits = middle[element - 1] - half, middle[element - 1] + half
            (view.set_xlim if place is view.xaxis else view.set_ylim)(*(limits[::-1] if is_reversed else limits))
            place.set_label_text(label)
        view.set_title(title, fontsize="medium")
        view.grid(alpha=0.3)
        if k == 0:
            view.legend(fontsize="small")
    figure.colorbar(drawn, ax=view, label="tip error / mm", shrink=0.8)
    over_time = figure.add_subplot(grid[1, :])
    over_time.plot(time, error, linewidth=1, color="black")
    motion_start, largest = data.attrs["motion_start"], int(np.argmax(np.where(time >= data.attrs["motion_start"], error, -1.0)))
    over_time.axvline(motion_start, color="grey", linestyle=":", label=f"the motion begins, t = {motion_start:.3f} s")
    over_time.plot(time[largest], error[largest], "o", markersize=5, fillstyle="none", color="black", label=f"largest, t = {time[largest]:.3f} s")
    over_time.set(xlabel="time / s", ylabel="tip error / mm", xlim=(time[0], time[-1]), ylim=(0.0, None))
    over_time.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    over_time.grid(alpha=0.3)
    a = data.attrs
    figure.suptitle(f"tip error in motion: RMSE {_digits(1e3 * a['tip_rmse'])} mm, largest {_digits(1e3 * a['tip_max'])} mm; verdict {a['verdict']}")
    return _done(figure, path)


def _digits(value):
    """Three significant digits, without an exponent."""
    return f"{value:.0f}" if abs(value) >= 100 else np.format_float_positional(value, precision=3, unique=False, fractional=False, trim="k")


def energy(data: xarray.Dataset, path: str | os.PathLike[str] | None = None) -> Figure:
    """Where the actuators' energy went over the motion, of a run with the metrics `energy`: the darker, the later in the chain."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Patch

    losses = ("inverter", "copper", "core", "mechanical")
    actuators = [n.removeprefix("energy_").removesuffix("_copper") for n in data.attrs if n.endswith("_copper")]
    actuators.sort(key=lambda name: (name == "all", name))
    figure, (axis,) = _figure()
    place, bottom = np.arange(len(actuators)), np.zeros(len(actuators))
    colours = ["0.4" if _axis(a) is None else COLOURS[_axis(a)] for a in actuators]
    shade = lambda colour, k: tuple(1.0 - (1.0 - np.array(to_rgb(colour))) * (0.25 + 0.25 * k))
    for k, loss in enumerate(losses):
        values = np.array([data.attrs[f"energy_{a}_{loss}"] for a in actuators]) / 1e3
        axis.bar(place, values, 0.6, bottom=bottom, color=[shade(colour, k) for colour in colours])
        bottom += values
    marks = (("electrical", "taken from the supply", "black"), ("regenerated", "given back to it", "red"))
    for name, label, colour in marks:
        heights = [data.attrs[f"energy_{a}_{name}"] / 1e3 for a in actuators]
        axis.hlines(heights, place - 0.4, place + 0.4, color=colour, label=label)
    for k, total in enumerate(bottom):
        axis.annotate(f"{_digits(total)} kJ lost", (k, total), xytext=(0, 3), textcoords="offset points", ha="center", fontsize="small")
    names = [f"{_NAMES[_axis(a)]}\n{a}" if _axis(a) is not None and _axis(a) < 3 else a for a in actuators]
    axis.set_xticks(place, names)
    axis.set(ylabel="energy over the motion / kJ")
    axis.margins(y=0.1)
    lines = axis.get_legend_handles_labels()[0]
    patches = [Patch(color=shade("0.0", k), label=f"lost: {loss}") for k, loss in enumerate(losses)]
    axis.legend(handles=[*lines, *reversed(patches)], fontsize="small", loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
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
