"""A run that a script steps: the part of `System` that is used inside of `with System(…) as s:`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

import numpy as np

from hdrm_fmu import _native, linear
from hdrm_fmu.errors import BadInput, WrongThread
from hdrm_fmu.names import Variable, by_name, text, whole

if TYPE_CHECKING:
    import control
    import xarray

T = TypeVar("T", float, np.ndarray)
S = TypeVar("S", bound="Stepped")
SavedState = _native.SavedState


def shape(name, variables):
    """Shape of the value that `name` means, of which these are the names of its variables: () of a scalar, that of the array or matrix if these
    are all of its elements in order."""
    if len(variables) == 1 and not variables[0].rpartition("[")[0].endswith(name):
        return ()
    places = [tuple(int(k) - 1 for k in n[n.rindex("[") + 1 : -1].split(",")) for n in variables]
    found = tuple(max(of) + 1 for of in zip(*places)) if len({len(p) for p in places}) == 1 else ()
    return found if places == list(np.ndindex(found)) else (len(variables),)


class Port(Generic[T]):
    """Variables of a run whose names are resolved: a scalar, a whole array or matrix, or several variables as one array of the shape (n,)."""

    __slots__ = ("_allows", "_high", "_is_real", "_low", "_native", "_refusal", "shape", "variables")

    def __init__(self, session: Any, variables: list[Variable], shape: tuple[int, ...], allows: bool) -> None:
        self.variables, self.shape, self._allows = variables, shape, allows
        self._refusal = next(filter(None, map(_refusal, variables)), None)
        self._native = session.port([v.name for v in variables], self._refusal is None)
        largest = np.finfo(float).max
        self._is_real = not allows and all(v.type == "Real" for v in variables)
        low = [-largest if v.minimum is None else v.minimum for v in variables]
        high = [largest if v.maximum is None else v.maximum for v in variables]
        self._low: Any = low[0] if shape == () else np.array(low).reshape(shape)
        self._high: Any = high[0] if shape == () else np.array(high).reshape(shape)

    def get(self) -> T:
        """Present value: a float, or an array of `shape`; items of enumerations and Booleans as numbers."""
        if self.shape == ():
            return self._native.get()
        return np.frombuffer(self._native.get_all()).reshape(self.shape)  # type: ignore[return-value]

    def set(self, value: Any) -> None:
        """Set an input that no connection drives, or a tunable parameter, from the present time on."""
        if self.shape == () and self._is_real and self._refusal is None and isinstance(value, float) and self._low <= value <= self._high:
            self._native.set(value)
        else:
            self._native.set_all(self._numbers(value).tobytes())

    def _numbers(self, value):
        """The checked numbers of `value`."""
        if self._refusal is not None:
            raise BadInput(self._refusal)
        if self._is_real and isinstance(value, (np.ndarray, list, tuple)):
            with suppress(TypeError, ValueError):
                numbers = np.asarray(value, dtype=float)
                if numbers.shape == self.shape and np.all((self._low <= numbers) & (numbers <= self._high)):
                    return numbers
        elements = np.asarray(value, dtype=object)
        if elements.shape not in (self.shape, (len(self.variables),)):
            name = self.variables[0].name.partition("[")[0]
            raise BadInput(f"`{name}` has {len(self.variables)} elements, of the shape {self.shape}, but the shape {elements.shape} was given")
        return np.array([_number(v, text(v, element, self._allows)) for v, element in zip(self.variables, elements.ravel())], dtype=float)


def _number(v, given):
    if v.type == "Boolean":
        return given == "true"
    return float(v.items.get(given, given))


def _refusal(v):
    """Why a variable cannot be set during a run."""
    if v.driver:
        return f"`{v.name}` cannot be set: `{v.driver}` drives it; leave the connection out by disconnect=[\"{v.name}\"]"
    if v.causality == "structuralparameter":
        return f"`{v.name}` cannot be set during a run: sizes of arrays depend on it; give it in settings"
    if v.causality in ("output", "local", "independent"):
        return f"`{v.name}` cannot be set: it is a variable of the kind `{v.causality}`"
    if v.causality != "input" and v.variability != "tunable":
        return f"`{v.name}` cannot be set during a run: it is {v.variability}; give it in settings"
    return None


class Stepped:
    """What a script does with a system inside of its context."""

    # Of `System`.
    _check: Any
    _dataset: Any
    allow_nonfinite: tuple[str, ...]
    _session: Any

    def __enter__(self: S) -> S:
        if self._session is not None:
            raise RuntimeError("this system is being stepped already")
        self._start(None)
        return self

    def _start(self, settings):
        """Start the run, or start it anew."""
        if self._sized(settings) is not self:
            raise BadInput("sizes of arrays cannot be set in `reset`: give them in the settings of the `System`")
        native, names = self._load()
        conditions = self._conditions(settings)
        with self._on_path(conditions) as on_path:
            if self._session is None:
                self._session, self._known, self._ports = native.start(on_path), names, {}
            else:
                native.restart(self._session, on_path)
        self._started, self._again, self._is_judged = conditions, settings, False
        self._from = self._session.time()

    def __exit__(self, kind: object, *_: object) -> None:
        # A process that was forked leaves the run alone.
        with suppress(WrongThread):
            if kind is None and not self._is_judged:
                found = [text for is_bad, text in self._session.result(None)["findings"] if is_bad]
                if found:
                    warnings.warn(f"the verdict on the run that was stepped is BAD: {'; '.join(found)}", stacklevel=2)
        self._session, self._ports = None, {}

    def _running(self):
        if self._session is None:
            raise RuntimeError("a system is stepped inside of `with System(…) as s:`")
        return self._session

    @property
    def time(self) -> float:
        """Present time of the run that is stepped, s."""
        return self._running().time()

    def step(self, count: int = 1) -> float:
        """Make `count` communication steps; the time then, s."""
        return self._running().step(count if type(count) is int and count > 0 else whole("count", count, 1))

    @overload
    def port(self, name: str, kind: type[T]) -> Port[T]: ...
    @overload
    def port(self, name: str, kind: None = None) -> Port[Any]: ...
    @overload
    def port(self, name: Sequence[str], kind: None = None) -> Port[np.ndarray]: ...
    def port(self, name, kind=None):
        """The variable, array or matrix of this name, or all variables of a list of names in the order of a flat array, to be read and set
        often. A port stays valid until the run ends, also after `reset` and `restore`. `kind`, float or numpy.ndarray, says what the value is."""
        key = name if isinstance(name, str) else tuple(name)
        found = self._ports.get(key)
        if found is None:
            session = self._running()
            if isinstance(name, str):
                variables = self._known.many(name)
                of = shape(name, [v.name for v in variables])
            else:
                variables = [v for n in key for v in self._known.many(n)]
                of = (len(variables),)
            found = self._ports[key] = Port(session, variables, of, bool(self.allow_nonfinite))
        if kind is not None and (kind is float) != (found.shape == ()):
            raise BadInput(f"`{name}` has the shape {found.shape}: it is no {kind.__name__}")
        return found

    @overload
    def get(self, name: str, kind: type[T]) -> T: ...
    @overload
    def get(self, name: str, kind: None = None) -> Any: ...
    @overload
    def get(self, name: Sequence[str], kind: None = None) -> dict[str, Any]: ...
    def get(self, name, kind=None):
        """Present value of a variable: a float, or an array with the shape of the array or matrix. With `kind`, float or numpy.ndarray, it
        is checked to be that. Of a list of names a dictionary, read in one call."""
        if isinstance(name, str):
            return self.port(name, kind).get()
        values, parts, first = self.port(name).get(), {}, 0
        for n in name:
            of = self.port(n)
            end = first + len(of.variables)
            parts[n] = values[first] if of.shape == () else values[first:end].reshape(of.shape)
            first = end
        return parts

    def set(self, name: str | Mapping[str, object], value: object = None) -> None:
        """Set an input that no connection drives, or a tunable parameter, from the present time on; arrays and matrices whole or by element;
        several as a dictionary, whose values are all checked before the first is set."""
        values = {name: value} if isinstance(name, str) else by_name(name)
        texts = [n for n in values if self._is_text(n)]
        for n in texts:
            v = self._known.one(n)
            if why := _refusal(v):
                raise BadInput(why)
        ports = {n: self.port(n) for n in values if n not in texts}
        if len(ports) == 1 == len(values):
            ports.popitem()[1].set(next(iter(values.values())))
            return
        names = [v.name for port in ports.values() for v in port.variables]
        if twice := {n for n in names if names.count(n) > 1}:
            raise BadInput(f"`{min(twice)}` is given twice")
        if ports:
            numbers = [np.ravel(port._numbers(values[n])) for n, port in ports.items()]
            self.port(list(ports))._native.set_all(np.concatenate(numbers).tobytes())
        for n in texts:
            v = self._known.one(n)
            self._running().set_text(v.name, text(v, values[n]))

    def _is_text(self, name):
        self._running()
        return name not in self._ports and self._known.many(name, "input")[0].type in ("String", "Binary")

    def reset(self, settings: Mapping[str, object] | None = None) -> None:
        """Start the run anew from its start time, with these start values after those of the system. What is recorded is recorded again; saved
        states cannot be restored any more."""
        self._running()
        self._start(settings)

    def save(self) -> SavedState:
        """Save the state of all FMUs, what is recorded and the findings, to be restored in this run; every FMU must be able to."""
        return self._running().save()

    def restore(self, state: SavedState) -> None:
        """Continue from a saved state, bit for bit as from there before."""
        self._running().restore(state)

    def record(self, signals: Any = None, interval: float | None = None) -> None:
        """Record signals from the present time on, `signals` and `interval` as of `run`."""
        session = self._running()
        session.record(self._check({"interval": interval, "metrics": (), "settings": None, "stop_time": None, "max_error": None, "signals": signals}), interval)

    def linearize(
        self,
        inputs: Sequence[str],
        outputs: Sequence[str],
        *,
        every: int = 1,
        horizon: int = 50,
        order: int | None = None,
        tolerance: float = linear.TOLERANCE,
        delta: Mapping[str, float] | None = None,
    ) -> control.StateSpace:
        """The system near its present state as a `control.StateSpace` in discrete time, from inputs that no connection drives to any
        variables: realized from the differences that a change of each input, up and down, makes (Ho and Kalman). Names of its signals have `_` for
        dots. Needs `control`: `pip install hdrm_fmu[control]`.

        Every FMU must save its state, or the run be at its start. The state is that of now afterwards.

        Parameters
        ----------
        every : communication steps a sample.
        horizon : samples that the slowest motion of interest shows itself in; twice as many are made for each change.
        order : number of states; default: as many as have a singular value of at least `tolerance` relative to the largest.
        delta : changes of inputs by full name, in their units; default: 1e-4 of the range between the bounds, else of the value or of 1.
        """
        self._running()
        return linear.linearize(self, inputs, outputs, every, horizon, order, tolerance, delta)

    def result(self, max_error: float | None = None) -> xarray.Dataset:
        """The Dataset that `run` returns, of the run until now: what is recorded, the verdict, the findings, the metrics of the tip. Without it
        a verdict that is BAD is a warning at the end of the context."""
        done = self._running().result(max_error)
        self._is_judged = True
        return self._dataset(done, self._started, {})
