"""The class `System`: any system of FMUs, run as a whole or stepped by a script."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterable, Mapping
from contextlib import contextmanager
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Union

import numpy as np
import pandas
import xarray

from hdrm_fmu import _native
from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.files import DATA, digest, identity
from hdrm_fmu.findings import ATTRIBUTE, as_json, as_text, found
from hdrm_fmu.names import TRUTHS, Names, Variable, by_name, choice, positive, whole
from hdrm_fmu.paths import FILE, TRAJECTORY, Waypoints, check_free, tip_path
from hdrm_fmu.run_options import RunOptions, complete, explicit
from hdrm_fmu.stepping import Stepped, shape

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: A packed system, a structure, or one or several FMUs without one, by name if they are to have names of their own.
Files = Union[str, "os.PathLike[str]", Iterable[Union[str, "os.PathLike[str]"]], Mapping[str, Union[str, "os.PathLike[str]"]]]
#: Values over time of inputs: a table, or what another run returned.
Inputs = Union[pandas.DataFrame, xarray.Dataset]
#: Orders of exchange and stepping that the master knows.
SCHEDULES = ("gauss-seidel", "jacobi", "standard")
#: Metrics besides the tip error, which a run computes on request.
METRICS = ("tracking", "energy")


@lru_cache(maxsize=8)
def _loaded(_stamp, has_loads, **source):
    try:
        system = _native.System({**source, "fmu_dirs": [DATA], "has_loads": has_loads})
    except RunFailed as error:
        raise BadInput(str(error)) from None
    rows = [Variable(*row) for row in system.variables()]
    return system, Names(rows, dict(system.components()), *system.connectors())


def _chosen(given):
    """One word for all components, or words by name, as `cosim` takes them."""
    named = given.items() if isinstance(given, Mapping) else ()
    return (given,) if isinstance(given, str) else tuple(f"{name}={word}" for name, word in named)


def forget_systems():
    """Have every system read from its files again, whatever their times say."""
    _loaded.cache_clear()


class System(Stepped):
    """Any system of FMUs: a packed `.ssp`, an `.ssd`, whose FMUs lie where it says or come with this package, or FMUs without a structure.

    Parameters
    ----------
    path : path of the system, or of an FMU, or several FMUs, each a component named after its file; `{"a": "X.fmu", "b": "X.fmu"}` gives names.
    connect : connections between these FMUs: `Plant.y=Controller.measured`, from an output to an input.
    variant : structure to take from a packed system, such as `triangular_pd.ssd`; default: its first.
    parameters : parameter sets (`.ssv`), in the packed system or files, applied in this order.
    disconnect : inputs (`component.variable`) whose connections are left out, so that a script can drive them.
    replace : FMUs (paths) that take the places of components, by the component's name.
    maps : parameter mappings (`.ssm`) from the structure's names to those of the FMU of a component, by the component's name.
    feedthrough : components whose outputs may be read again after inputs were set at the same communication point, although they do not
        declare on which inputs they depend.
    interface : `"me"` for Model Exchange, `"cs"` for Co-Simulation, of a single FMU or by the component's name or pattern: `{"emla_*": "me"}`;
        default: Co-Simulation, if the FMU has it, or what the structure says.
    solver : method by which components of Model Exchange are integrated, `"explicit"`, `"stiff"` or `"fixed:1e-4"` (s), for all or by name.
    isolate : components that live in processes of their own, `"all"`, names or patterns, on Linux: what crashes or hangs there ends the run,
        and not this Python. The program `cosim` on PATH hosts them.
    call_timeout, memory_limit : longest time of a call, s, and most memory (`"500MB"`) of such a process.
    prefer : what runs of FMUs that have both, `"library"` or `"wasm"` (by the program `cosim-wasm`).
    solve_loops : solve algebraic loops, as `cosim run --solve-loops`, instead of refusing them.
    settings : start values by name, applied last; the component may be left out where one alone has the variable. Of structural parameters of
        FMI 3.0 they say how large arrays are.
    waypoints : path that the controller follows, as of `run`.
    step : communication step, s; default: what the system asks for, else its FMUs, else 1 ms. The shipped systems run at 1 ms.
    start_time : s; default: that of the system's default experiment, else the earliest of its FMUs.
    tolerance : relative tolerance that the FMUs are told; default: the one that each declares.
    schedule : `gauss-seidel`, `jacobi` or `standard`.
    scenario : events that alter variables: a file of libcosim's scenarios, as JSON.
    faults : what is done to values on their way, such as `emla_2.x=bias:0.001@1..2`, as `cosim run --fault` takes it.
    fault_seed : seed of what is random in faults; default: 0. Refused where no fault draws random numbers.
    allow_nonfinite : variables that may be NaN or infinite, by name or pattern; otherwise such a value ends the run, or in an output that no
        connection passes on makes the verdict BAD.
    strict : refuse a system with connectors that its FMUs do not have, inputs that nothing drives, or values that match nothing.

    Nothing is loaded before it is needed. As a context manager it is a run that the script steps:

    >>> with System(systems()["Manipulator"], settings={"trajectory": "external"}) as s:   # doctest: +SKIP
    ...     s.set("controller.reference.position", [4.0, 1.5, 0.0])
    ...     s.step(1000)
    ...     s.get("controller.tip_error_norm")
    ...     s.result().attrs["verdict"]
    """

    def __init__(
        self,
        path: Files,
        *,
        connect: Iterable[str] = (),
        variant: str | None = None,
        parameters: Iterable[str | os.PathLike[str]] = (),
        disconnect: Iterable[str] = (),
        replace: Mapping[str, str | os.PathLike[str]] | None = None,
        maps: Mapping[str, str | os.PathLike[str]] | None = None,
        feedthrough: Iterable[str] = (),
        interface: str | Mapping[str, str] | None = None,
        solver: str | Mapping[str, str] | None = None,
        isolate: str | Iterable[str] = (),
        call_timeout: float | None = None,
        memory_limit: str | None = None,
        prefer: str = "library",
        solve_loops: bool = False,
        settings: Mapping[str, object] | None = None,
        waypoints: Waypoints | None = None,
        step: float | None = None,
        start_time: float | None = None,
        tolerance: float | None = None,
        schedule: str = "gauss-seidel",
        strict: bool = False,
        scenario: str | os.PathLike[str] | None = None,
        faults: Iterable[str] = (),
        fault_seed: int | None = None,
        allow_nonfinite: Iterable[str] = (),
    ) -> None:
        self.names = tuple(path) if isinstance(path, Mapping) else ()
        paths = path.values() if isinstance(path, Mapping) else [path] if isinstance(path, (str, os.PathLike)) else path
        self.files = tuple(Path(p) for p in paths)
        if not self.files:
            raise BadInput("no system is named, and no FMU")
        self.path = self.files[0]
        self.connect = tuple(connect)
        if len(self.files) > 1 or self.names or self.path.suffix == ".fmu":
            self._only_fmus(variant, replace, maps)
        elif self.connect:
            raise BadInput(f"connect = {list(self.connect)} is for FMUs without a structure; `{self.path}` has one")
        self.variant = variant
        self.parameters = tuple(str(p) for p in parameters)
        self.disconnect = tuple(disconnect)
        self.replace = tuple((name, str(fmu)) for name, fmu in (replace or {}).items())
        self.maps = tuple((name, str(file)) for name, file in (maps or {}).items())
        self.feedthrough = tuple(feedthrough)
        self.interface, self.solver = _chosen(interface), _chosen(solver)
        self.isolate = (isolate,) if isinstance(isolate, str) else tuple(isolate)
        self.call_timeout, self.memory_limit, self.prefer = call_timeout, memory_limit, prefer
        self.solve_loops = solve_loops
        self.settings = by_name(settings)
        self.waypoints = waypoints
        self._step = step
        self.start_time, self.tolerance = start_time, tolerance
        self.schedule = schedule
        self.strict = strict
        self.scenario = None if scenario is None else str(scenario)
        self.faults = (faults,) if isinstance(faults, str) else tuple(faults)
        self.fault_seed = fault_seed
        self.allow_nonfinite = (allow_nonfinite,) if isinstance(allow_nonfinite, str) else tuple(allow_nonfinite)
        self._session = None

    def _only_fmus(self, variant, replace, maps):
        """FMUs without a structure have no variants and no names to replace."""
        others = [str(file) for file in self.files if file.suffix != ".fmu"]
        if others:
            raise BadInput(f"several files must all be FMUs (.fmu); {', '.join(others)} is none")
        for name, value in (("variant", variant), ("replace", replace), ("maps", maps)):
            if value:
                raise BadInput(f"{name} = {value!r} is for a system structure; FMUs without one are given as they are")

    def _load(self):
        has_loads = self._tip_path is not None and self._tip_path.has_loads
        source = {"files": tuple(map(str, self.files)), "names": self.names, "connect": self.connect, "variant": self.variant, "parameters": self.parameters}
        source |= {"disconnect": self.disconnect, "replaced": self.replace, "maps": self.maps, "feedthrough": self.feedthrough}
        source |= {"interfaces": self.interface, "solvers": self.solver, "solve_loops": self.solve_loops}
        source |= {"isolate": self.isolate, "call_timeout": self.call_timeout, "memory_limit": self.memory_limit, "prefer": self.prefer}
        stamp = self._stamp()
        loaded = _loaded(stamp, has_loads, sizes=(), **source)
        sizes = tuple(f"{name}={value}" for name, value in loaded[1].sizes(self.settings).items())
        return _loaded(stamp, has_loads, sizes=sizes, **source) if sizes else loaded

    def _sized(self, settings):
        """This system, or a copy with the sizes of arrays that start values give."""
        names, settings = self._names, by_name(settings)
        own, sizes = names.sizes(self.settings), names.sizes(settings)
        if sizes.items() <= own.items():
            return self
        other = copy.copy(self)
        kept = {name: value for name, value in self.settings.items() if not names.sizes({name: value}).keys() & sizes.keys()}
        other.settings, other._session = {**kept, **sizes}, None
        return other

    @property
    def step_size(self) -> float:
        """Communication step, s: the one given, else the one that the system asks for."""
        return self._step_until(None)

    def _step_until(self, stop_time):
        return self._native.step(self.start_time, stop_time) if self._step is None else self._step

    @cached_property
    def _tip_path(self):
        return tip_path(self.waypoints)

    def _stamp(self):
        """Times and sizes of the files, which change if a file does; what lies in the folder of an `.ssd` and its `resources` is among them."""
        try:
            beside = [p for pattern in ("*", "resources/**/*") for p in sorted(self.path.parent.glob(pattern))] if self.path.suffix == ".ssd" else []
            # A parameter set may also lie in the packed system.
            sets = [p for p in map(Path, self.parameters) if p.is_file()]
            files = (*self.files, *beside, *sets, *(Path(file) for _, file in (*self.replace, *self.maps)))
            found = [(p.name, p.stat()) for p in files]
            return tuple((name, s.st_mtime_ns, s.st_ctime_ns, s.st_ino, s.st_size) for name, s in found)
        except OSError as error:
            raise BadInput(f"`{error.filename}` cannot be read: {error.strerror}") from None

    @property
    def _native(self):
        return self._load()[0]

    @property
    def _names(self):
        return self._load()[1]

    @property
    def digest(self) -> str:
        """SHA-256 of the system's file."""
        return digest(self.path)

    @property
    def variables(self) -> dict[str, Variable]:
        """All variables (`Variable`: unit, description, bounds, driver, …) by name."""
        return dict(self._names.all)

    @property
    def components(self) -> dict[str, str]:
        """Components and the files of their FMUs, in the order in which they are stepped."""
        return dict(self._native.components())

    def signals(self, patterns: str | Iterable[str] | None = None) -> list[str]:
        """Names of the signals that patterns choose (`*`: any text); without patterns those that are recorded by default."""
        if patterns is None:
            return self._native.signals(None)
        chosen = []
        if isinstance(patterns, str):
            patterns = [patterns]
        if not isinstance(patterns, Iterable) or not all(isinstance(p, str) for p in patterns):
            raise BadInput(f"signals = {patterns!r} must be names or patterns")
        for pattern in patterns:
            if "*" in pattern:
                names = self._matching(pattern)
            else:
                names = [v.name for v in self._names.many(pattern, "signal")]
                if self._names.all[names[0]].type == "String":
                    raise BadInput(f"`{pattern}` is a text, which cannot be recorded")
            chosen += [n for n in names if n not in chosen]
        return chosen

    def _matching(self, pattern):
        try:
            return self._native.signals([pattern])
        except RunFailed as error:
            raise BadInput(str(error)) from None

    def _values(self, settings):
        """The start values of the system and these, by full name, as text."""
        names, allows = self._names, bool(self.allow_nonfinite)
        return {**names.settings(self.settings, allows=allows), **names.settings(by_name(settings), allows=allows)}

    def _conditions(self, settings=None, stop_time=None):
        values = self._values(settings)
        check_free(self._tip_path, values)
        choice("schedule", self.schedule, SCHEDULES)
        step, stop = positive("step", self._step), positive("stop_time", stop_time)
        conditions = {"settings": list(values.items()), "step": step, "stop_time": stop, "schedule": self.schedule, "strict": self.strict}
        seed = None if self.fault_seed is None else whole("fault_seed", self.fault_seed, 0)
        altered = {"inputs": None, "scenario": self.scenario, "faults": list(self.faults), "fault_seed": seed}
        told = {"start_time": _number("start_time", self.start_time), "tolerance": _number("tolerance", self.tolerance)}
        if told["tolerance"] is not None and not 0 < told["tolerance"] < 1:
            raise BadInput(f"tolerance = {self.tolerance!r}: a relative tolerance must be above 0 and below 1")
        return {**conditions, **altered, **told, "allow_nonfinite": list(self.allow_nonfinite)}

    @contextmanager
    def _on_path(self, conditions):
        """The conditions with the path that the tip follows, whose file exists within this context."""
        if self._tip_path is None:
            yield conditions
            return
        with self._tip_path.at_hand() as file:
            follow = self._names.settings({TRAJECTORY: "path", FILE: file})
            yield {**conditions, "settings": [*conditions["settings"], *follow.items()]}

    def _key(self, settings, stop_time):
        """A hash of all that the numbers of a run depend on: contents of FMUs, files and structure, start values, schedule, times."""
        sized = self._sized(settings)
        with sized._on_path(sized._conditions(settings, stop_time)) as conditions:
            return sized._native.key(conditions)

    @explicit
    def check(self, **options: Unpack[RunOptions]) -> list[str]:
        """Check the keywords of `run` without running; return the names of the signals."""
        completed = complete(options, self.check)
        return self._sized(completed["settings"])._check(completed)

    def _check(self, options):
        interval, metrics = options["interval"], options["metrics"]
        self._conditions(options["settings"], options["stop_time"])
        positive("max_error", options["max_error"], "m")
        if isinstance(metrics, str):
            raise BadInput(f"metrics = {metrics!r} must be a list of names")
        for metric in metrics:
            choice("metric", metric, METRICS)
        if metrics and not self._native.is_machine():
            raise BadInput(f"the metrics {', '.join(metrics)} are those of the manipulator, which `{self.path}` is not")
        if options["max_error"] is not None and not self._native.is_machine():
            raise BadInput(f"max_error = {options['max_error']} is about the tip of the manipulator, which `{self.path}` is not")
        if interval is not None:
            step = self._step_until(options["stop_time"])
            steps = positive("interval", interval) / step
            if not (steps >= 0.5 and abs(steps - round(steps)) <= 1e-6 * steps):
                raise BadInput(f"interval = {interval} s must be a multiple of the communication step, {step} s")
        return self.signals(options["signals"])

    @explicit
    def run(self, *, inputs: Inputs | None = None, progress: bool = False, **options: Unpack[RunOptions]) -> xarray.Dataset:
        """Run to the stop time, else to the end of the motion, else to that of the system's default experiment.

        Parameters
        ----------
        inputs : values over time for inputs that no connection drives: a DataFrame whose index is time, s, and whose columns are named
            `component.variable` or after inputs of the system; units other than those of the inputs are in `attrs["units"]`, by column.
            Or a Dataset as this method returns it, whose variables have units. Continuous inputs are linear between rows, all others hold the
            value of the row before.
        settings : start values by name, after those of the system.
        signals : names or patterns (`*`: any text, an array by its name); default: a useful few.
        interval : time between two recorded points, s, a multiple of the communication step; default: every step.
        stop_time : s.
        max_error : largest tip error with which the verdict is good, m.
        metrics : further metrics, of `tracking` and `energy`.
        progress : show a bar.

        Returns
        -------
        xarray.Dataset with one variable of the shape (time,) for each signal; `time` in s; the name of an array or matrix gives all that is
        recorded of it, of the shape (time, …). Its attributes hold the verdict (`good` or `BAD`),
        what was found, and the metrics in SI units.

        Raises
        ------
        BadInput : before the run, where a name, a value or a file makes no sense.
        RunFailed : the run could not be completed; its `result` is this Dataset with the rows until then, `time` that of the last, s.
        """
        return self._run(inputs, progress, complete(options, self.run), {})

    def _run(self, inputs, progress, completed, about):
        """`run`; `about` says of a run of the manipulator what it was given."""
        sized = self._sized(completed["settings"])
        if sized is not self:
            return sized._run(inputs, progress, completed, about)
        completed |= {"signals": self._check(completed), "metrics": list(completed["metrics"])}
        conditions = {**self._conditions(completed["settings"], completed["stop_time"]), "inputs": _columns(inputs, self._names)}
        self._check_altered(conditions)
        bar = _Bar() if progress else None
        try:
            with self._on_path(conditions) as on_path:
                about = {**about, "hash": self._native.key(on_path)}
                done = self._native.run(on_path, completed, bar)
        except RunFailed as error:
            if error.result is not None:
                error.result = self._dataset(error.result, conditions, about)
            raise
        finally:
            if bar:
                bar.close()
        return self._dataset(done, conditions, about)

    def _check_altered(self, conditions):
        """Check inputs over time, faults, scenario and names of variables before the run."""
        if conditions["inputs"] or self.faults or self.scenario or self.fault_seed is not None or self.allow_nonfinite:
            try:
                self._native.check(conditions)
            except RunFailed as error:
                raise BadInput(str(error)) from None

    def _dataset(self, done, conditions, about):
        given = about.get("given")
        given = conditions["settings"] if given is None else self._names.settings({**self.settings, **given}, allows=bool(self.allow_nonfinite))
        variables = {}
        for name, column in done["columns"].items():
            v = self._names.all[name]
            attributes = {"units": v.unit or "1", "long_name": v.description}
            variables[name] = ("time", np.frombuffer(column), attributes)
        time = ("time", np.frombuffer(done["time"]), {"units": "s", "long_name": "time"})
        data = Result(variables, coords={"time": time})
        components = list(self.components)
        findings = [found(is_bad, text, components) for is_bad, text in done["findings"]]
        if about.get("gains"):
            findings.append(found(False, f"gains by the rule for the machine: {about['gains']}", components))
        data.attrs = {
            "verdict": "BAD" if done["is_bad"] else "good",
            "findings": as_text(findings),
            ATTRIBUTE: as_json(findings),
            **done["metrics"],
            "system": self.path.name,
            **{name: about[name] for name in ("world", "seed", "machine", "hash") if about.get(name) is not None},
            "version": identity(),
            "settings": json.dumps(dict(given)),
            "waypoints": "" if self._tip_path is None else self._tip_path.name,
            **({"path": self._tip_path.text} if self._tip_path is not None and self._tip_path.text is not None else {}),
            "schedule": self.schedule,
            "step": float(self._step_until(conditions["stop_time"])),
            "simulated": done["simulated"],
            "elapsed": done["elapsed"],
        }
        return data


class Result(xarray.Dataset):
    """A Dataset with a variable for each signal; the name of an array or matrix gives all of its elements, of the shape (time, …)."""

    __slots__ = ()

    def __getitem__(self, key):
        if isinstance(key, str) and key not in self.variables:
            elements = [n for n in self.data_vars if str(n).rpartition("[")[0] == key]
            if elements:
                of = shape(key, elements)
                values = np.stack([self.variables[n].to_numpy() for n in elements], axis=-1)
                dims = [f"{key}_{k}" for k in range(1, 1 + len(of))]
                return xarray.DataArray(values.reshape(-1, *of), {"time": self["time"]}, ["time", *dims], key, self.variables[elements[0]].attrs)
        return super().__getitem__(key)


def _columns(inputs, names):
    """Times, and columns with names and units, of a DataFrame or of another run."""
    if inputs is None:
        return None
    if isinstance(inputs, xarray.Dataset):
        units = {name: variable.attrs.get("units") for name, variable in inputs.data_vars.items() if variable.attrs.get("units") != "1"}
        inputs = inputs.to_dataframe()
    elif isinstance(inputs, pandas.DataFrame):
        units = inputs.attrs.get("units", {})
    else:
        raise BadInput(f"inputs must be a DataFrame with time (s) as index and columns named component.variable, not {type(inputs).__name__}")
    times, columns = _times(inputs.index), []
    for k, name in enumerate(inputs.columns):
        columns.append((str(name), units.get(name), _numbers(f"column `{name}`", inputs.iloc[:, k], _words(names, str(name)))))
    return times, columns


def _number(name, value):
    if value is None:
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise BadInput(f"{name} = {value!r} must be a number") from None


def _words(names, name):
    """Words that stand for values of the variable `name`, with their numbers: items of an enumeration, or truth values."""
    try:
        variable = names.one(name)
    except BadInput:  # an input of the system, or refused later
        return {}
    return TRUTHS if variable.type == "Boolean" else variable.items


def _times(index):
    """The index in seconds: numbers are seconds, differences of times have their own unit."""
    if isinstance(index, pandas.TimedeltaIndex):
        return index.total_seconds().tolist()
    if isinstance(index, (pandas.DatetimeIndex, pandas.PeriodIndex)):
        raise BadInput(
            f"inputs: the index holds dates, such as {index[0]}; it must be time in s from the start of the run, or a TimedeltaIndex: "
            "`inputs.index - inputs.index[0]`"
        )
    return _numbers("the index, which is time in s,", index)


def _numbers(what, values, words={}):
    """The values as numbers, of which `words` has some by name."""
    if any(isinstance(value, str) and value in words for value in values):
        values = [words.get(value, value) if isinstance(value, str) else value for value in values]
    try:
        return np.asarray(values, dtype=float).tolist()
    except (TypeError, ValueError) as error:
        known = f", or one of {', '.join(words)}" if words else ""
        raise BadInput(f"inputs: {what} must hold numbers{known}: {error}") from None


class _Bar:
    """A bar over the steps of a run."""

    def __init__(self):
        from tqdm.auto import tqdm

        self._bar = tqdm(unit="steps", leave=False)

    def __call__(self, done, steps):
        self._bar.total = steps
        self._bar.update(done - self._bar.n)

    def close(self):
        self._bar.close()


__all__ = ["METRICS", "SCHEDULES", "RunFailed", "System"]
