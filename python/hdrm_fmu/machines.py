"""The class `Machine`: a machine file, what is wrong with it, its gains, its load chart, and other machines made of it."""

from __future__ import annotations

import io
import json
import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, Union

import pandas

from hdrm_fmu import _native
from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.files import DATA, parameters
from hdrm_fmu.findings import Finding, found
from hdrm_fmu.names import by_name, choice, positive, whole
from hdrm_fmu.paths import TipPath, Waypoints, tip_path

T = TypeVar("T")

#: A machine: the name of a shipped one (as in the programs, or of its file in `parameters()`), the path of a file, or what is in it.
MachineSource = Union["Machine", str, "os.PathLike[str]", Mapping[str, Any]]


@dataclass(frozen=True)
class Check:
    """What `Machine.check` found: `ok` if all FMUs run with the machine; the findings, errors first; the trials in closed loop, one a row, with
    `world`, `hook` (full or empty), `tip_rmse`, `tip_max` (m, over the motion; NaN: the run failed) and `is_verdict` (whether it counts)."""

    ok: bool
    findings: list[Finding]
    trials: pandas.DataFrame


@dataclass(frozen=True)
class Perturbed:
    """A machine drawn by seed, and its gravity in the world frame, m/s², which is no part of a machine file."""

    machine: Machine
    gravity: tuple[float, float, float]

    @property
    def settings(self) -> dict[str, list[float]]:
        """Start values of a run with this gravity."""
        return {"hdrm.gravity": list(self.gravity)}


@dataclass(frozen=True)
class Sizing:
    """What `Machine.sizing` found: for each trajectory the loads of its actuators, in SI units and named as in the JSON of `hdrm-fmu sizing`, and
    how power, force, energy and efficiency depend on the payload; the verdict, `good` or `BAD`; the findings."""

    cases: dict[str, dict[str, Any]]
    verdict: str
    findings: list[Finding]


@dataclass(frozen=True)
class PathMargins:
    """What `Machine.path_check` found: `ok` if the machine can follow the path; the reasons if not; a row for each quantity with its `value`, its
    allowed `min` and `max` (SI units), the `part` of the range that is left, time `t` (s) and `place` where that is least; `duration`, s; root mean
    square of the motors' torques (slew, lift, tilt), N·m."""

    ok: bool
    findings: list[Finding]
    margins: pandas.DataFrame
    duration: float
    motor_torque_rms: tuple[float, float, float]


class Machine:
    """A machine, as `run(machine=…)` and the other functions of the package take it.

    Parameters
    ----------
    source : name of a shipped machine (`reference`, `sized`, `hiab_xs031`), path of a machine file, what is in one as a dictionary
        (`{"extends": "reference", "emla": {"N_gear": 10}}`), or another `Machine`. `BadInput` lists everything that is wrong with it.
    """

    #: Name for titles: of the shipped machine, or of the file without its extension.
    name: str
    #: Text of the machine file with all that it extends, checked.
    text: str
    #: The same with only what differs from a shipped machine, if it is made of one.
    _short: str
    #: Parameter set of the machine in the world `real`.
    real_parameters: str

    def __init__(self, source: MachineSource = "reference") -> None:
        self.name = "machine"
        file = None
        if isinstance(source, Machine):
            self.name, text = source.name, source._short
        elif isinstance(source, Mapping):
            try:
                text = json.dumps(dict(source))
            except (TypeError, ValueError) as error:
                raise BadInput(f"the machine: {error}; it must be what a machine file in JSON holds") from None
        elif isinstance(source, str) and _native.shipped_machine(source) is not None:
            self.name, text = source, json.dumps({"extends": source})
        else:
            try:
                file = Path(parameters().get(str(source), source)).absolute()
                text = file.read_text()
            except (OSError, TypeError, UnicodeDecodeError) as error:
                why = getattr(error, "strerror", error)
                raise BadInput(f"`{source}` cannot be read: {why}; machines that come with the package: {', '.join(_native.MACHINES)}") from None
            self.name = file.stem
        try:
            self.text, self._short, self.real_parameters = _native.whole_machine(text, file)
        except RunFailed as error:
            named = "the machine" if isinstance(source, (Mapping, Machine)) else f"`{source}`"
            raise BadInput(f"{named}: {error}") from None

    def __repr__(self) -> str:
        return f"Machine({self._short})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Machine) and json.loads(self.text) == json.loads(other.text)

    __hash__ = None  # type: ignore[assignment]

    def to_dict(self) -> dict[str, Any]:
        """All that the machine file holds, SI units and radians."""
        whole_file: dict[str, Any] = json.loads(self.text)
        return whole_file

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a machine file, for the programs; with `extends` and only what differs if it is made of a shipped machine."""
        path = Path(path)
        path.write_text(json.dumps(json.loads(self._short), indent=2) + "\n", encoding="utf-8")
        return path

    def check(self, trials: bool = True) -> Check:
        """What `hdrm-fmu machine check` finds: loops that do not close, a start pose that cannot be held, gains that do not fit, and with `trials`
        what happens on the triangular path in both worlds with full and with empty hook (some seconds)."""
        with self._file() as file:
            done = json.loads(_called(_native.check_machine, file, DATA, trials))
        findings = [found(is_bad, text, COMPONENTS) for is_bad, texts in ((True, done["found"]), (False, done["notes"])) for text in texts]
        columns = ["world", "hook", "tip_rmse", "tip_max", "is_verdict"]
        table = pandas.DataFrame(done["trials"], columns=columns).astype({"tip_rmse": float, "tip_max": float})
        return Check(not done["found"], findings, table)

    def gains(self, world: str = "real") -> pandas.DataFrame:
        """The controller's gains by the rule, for actuators as built (`real`) or as the controller knows them (`ideal`): `value`, `unit` and `why`
        by the name of the gain. `gains["value"].to_dict()` are start values of a run."""
        choice("world", world, ("ideal", "real"))
        rows = _called(_native.ruled_gains, self.text, world == "ideal")
        return pandas.DataFrame(rows, columns=["name", "value", "unit", "why"]).set_index("name")

    def scale(self, booms: float) -> Machine:
        """The machine with booms `booms` times as large, of the same shape and material (`hdrm-fmu machine scale`). `check` says what it can hold."""
        text = _called(_native.scaled_machine, self._short, _factor("booms", booms))
        return self._made(text, f"{self.name}_x{booms:g}")

    def perturb(
        self,
        seed: int = 1,
        *,
        mass: float | None = None,
        com: float | None = None,
        second_moment: float | None = None,
        length: float | None = None,
        plumb: float | None = None,
    ) -> Perturbed:
        """The machine with errors drawn by seed, as `run(world="real", seed=…)` draws it.

        Parameters
        ----------
        seed : of the errors.
        mass, second_moment : bounds on the relative errors of masses with their inertia and joint friction, and of second moments of mass.
        com, length : bounds on the errors of each centre of mass along each axis and of each length, m.
        plumb : bound on gravity's angle from the vertical about each horizontal axis, rad.

        Default bounds are those of the world `real`.
        """
        given = {"mass": mass, "com": com, "second_moment": second_moment, "length": length, "plumb": plumb}
        bounds = {name: float(value) for name, value in given.items() if value is not None}
        text, gravity = _called(_native.perturbed_machine, self.text, whole("seed", seed, 0), bounds)
        return Perturbed(self._made(text, f"{self.name}_seed{seed}"), gravity)

    def load_chart(self, dynamic_factor: float = 1.0) -> pandas.DataFrame:
        """The greatest payload at rest over the workspace, one pose a row: `reach_m`, `height_m` of the tip, joint angles `lift_rad`, `tilt_rad`,
        `wrist_2_rad`, `payload_kg` and what limits it, and what may last for ever. All weights count `dynamic_factor` times."""
        csv = _called(_native.load_chart, self.text, _factor("dynamic_factor", dynamic_factor))
        table = pandas.read_csv(io.StringIO(csv), dtype=str)
        return table.astype({name: float for name in table if name.endswith(("_m", "_rad", "_kg"))})

    def draw(self, path: str | os.PathLike[str], dynamic_factor: float = 1.0) -> Path:
        """Draw the machine on a sheet, `.svg` or `.png`: side view with named points, workspace, load chart; return the path."""
        path = Path(path)
        if path.suffix not in (".svg", ".png"):
            raise BadInput(f"`{path}` must end in .svg or .png")
        _called(_native.draw_machine, self.text, self.name, _factor("dynamic_factor", dynamic_factor), path)
        return path

    def sizing(self, *, settings: Mapping[str, object] | None = None, waypoints: Waypoints | None = None, payload_step: float = 10.0) -> Sizing:
        """Loads of motors and actuators compared with their ratings (`hdrm-fmu sizing`), on both trajectories in the world `ideal`.

        Parameters
        ----------
        settings : start values by name; a `trajectory` among them leaves the other out.
        waypoints : path that the tip follows instead, as of `run`.
        payload_step : change of the payload from which the sensitivity is computed, kg; 0: none.
        """
        values = [f"{name}={str(value).lower() if isinstance(value, bool) else value}" for name, value in by_name(settings).items()]
        path = tip_path(waypoints)
        with self._file() as file, _at_hand(path) as follow:
            done = json.loads(_called(_native.sizing_of, file, DATA, values, follow, float(payload_step)).replace(json.dumps(file)[1:-1], self.name))
        findings = [found(*pair, components=COMPONENTS) for pair in zip(done["is_bad"], done["findings"])]
        return Sizing(done["sizing"], done["verdict"], findings)

    def path_check(self, waypoints: Waypoints) -> PathMargins:
        """Whether the machine can follow a path (`hdrm-fmu path check`): the least margins of reach, joints, strokes, speeds, forces, wrist, motors."""
        path = tip_path(waypoints)
        if path is None:
            raise BadInput("waypoints = None: a path is needed")
        with _at_hand(path) as file:
            done = json.loads(_called(_native.path_check, self.text, file))
        rows = [{**row, "min": row["range"][0], "max": row["range"][1]} for row in done["margins"]]
        table = pandas.DataFrame(rows, columns=["quantity", "value", "min", "max", "part", "t", "place"]).set_index("quantity")
        findings = [found(True, text) for text in done["findings"]]
        return PathMargins(not done["refusal"], findings, table, done["duration"], tuple(done["motor_torque_rms"]))

    def _made(self, text: str, name: str) -> Machine:
        made = Machine(json.loads(text))
        made.name = name
        return made

    @contextmanager
    def _file(self) -> Iterator[str]:
        """The machine as a file, which exists within this context, or the name of a shipped one."""
        with tempfile.TemporaryDirectory() as folder:
            yield str(self.write(Path(folder) / f"{self.name}.json"))


#: Components of the manipulator's systems.
COMPONENTS = ("controller", "emla_1", "emla_2", "emla_3", "hdrm")


def _at_hand(path: TipPath | None) -> AbstractContextManager[str | None]:
    return path.at_hand() if path is not None else _nothing()


@contextmanager
def _nothing() -> Iterator[None]:
    yield None


def _factor(name: str, value: float) -> float:
    factor: float | None = positive(name, value, "1")
    if factor is None:
        raise BadInput(f"{name} = None must be a number above 0")
    return factor


def _called(function: Callable[..., T], *arguments: object) -> T:
    """The result of a native function; what it refuses is bad input."""
    try:
        return function(*arguments)
    except RunFailed as error:
        raise BadInput(str(error)) from None


def read_machine(machine: MachineSource | None) -> tuple[str | None, str]:
    """Checked text of a machine file with all that it extends, and the parameter set that belongs to it in the real world; None is no machine."""
    if machine is None:
        return None, _native.REAL_PARAMETERS
    machine = machine if isinstance(machine, Machine) else Machine(machine)
    return machine.text, machine.real_parameters
