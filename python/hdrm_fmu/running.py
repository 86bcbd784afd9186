"""The function `run`, and what sweeps and studies share with it: the system of a world, machine files, machines drawn by seed."""

from __future__ import annotations

import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from hdrm_fmu import _native
from hdrm_fmu.errors import BadInput, RunFailed
from hdrm_fmu.files import DATA, MACHINE
from hdrm_fmu.machines import MachineSource, read_machine
from hdrm_fmu.names import choice, whole
from hdrm_fmu.paths import Waypoints
from hdrm_fmu.run_options import RunOptions, complete, explicit
from hdrm_fmu.system import Files, Inputs, System

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack

#: Worlds: `ideal` is the controller's own model; `real` has actuators as built, sensors, a step of delay, and a machine drawn by seed.
WORLDS = ("ideal", "real")
#: Control laws.
MODES = tuple(_native.MODES)


def world_path(world):
    """The package of the system of a world."""
    choice("world", world, WORLDS)
    return DATA / (MACHINE if world == "ideal" else _native.REAL_SYSTEM)


def world_system(world="ideal", real_parameters=_native.REAL_PARAMETERS, **options):
    """The system of a world, not loaded yet; `real_parameters` is the parameter set of the real world, options as of `System`."""
    return System(world_path(world), parameters=[real_parameters] if world == "real" else [], **options)


def case_settings(case, world):
    """Start values of a case whose items are named as the arguments of `run`, and its seed."""
    values = {name: case[name] for name in case if name != "seed"}
    seed = case.get("seed")
    if seed is not None:
        if world != "real":
            raise BadInput(f"seed = {seed}: only the world `real` has machines that are drawn by seed")
        seed = whole("seed", seed, 0)
    return values, seed


@contextmanager
def all_settings(system, values, seed, machine):
    """The start values, with those of the machine drawn by seed and of the machine file, which exists within this context, and its gains by
    the rule; second, a list of these gains in words."""
    if machine is None:
        drawn = None if seed is None else system._native.draw(seed)
        yield {**(dict(drawn.settings) if drawn else {}), **values}, None
    else:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "machine.json"
            file.write_text(machine)
            if not any(name.endswith(".machine_file") for name in system.variables):
                raise BadInput(f"a machine is for FMUs that read a machine file (`machine_file`): `{system.path}` has none")
            try:
                bound, gains = system._native.for_machine(str(file), list(system._values(values).items()))
            except RunFailed as error:
                raise BadInput(f"the machine: {error}") from None
            drawn = None if seed is None else system._native.draw(seed, str(file))
            yield {**dict(bound), **(dict(drawn.settings) if drawn else {}), **values}, gains


@explicit
def run(
    *,
    system: System | Files | None = None,
    inputs: Inputs | None = None,
    trajectory: str | None = None,
    mode: str | None = None,
    world: str = "ideal",
    seed: int | None = None,
    machine: MachineSource | None = None,
    waypoints: Waypoints | None = None,
    step: float | None = None,
    schedule: str | None = None,
    progress: bool = False,
    **options: Unpack[RunOptions],
) -> xarray.Dataset:
    """Run the manipulator over its motion, or another system.

    Parameters
    ----------
    system : what is run in the place of the manipulator: a packed system (`.ssp`), a structure (`.ssd`), an FMU or several, or a `System`, which
        says itself how it is stepped. `world` and `seed` are the manipulator's; `machine` needs FMUs that read a machine file.
    inputs : values over time for inputs that no connection drives, as of `System.run`.
    trajectory : `cubic`, `triangular` or `external`.
    mode : control law, one of `MODES`.
    world : `ideal` (the controller's own model) or `real` (actuators as built, sensors, delay).
    seed : of the machine and of the sensors' errors in the world `real`; default: the machine as drawn, sensors of their own seed. With
        `machine` the manipulator is drawn around that one, which all other FMUs use as it is.
    machine : a machine that all FMUs use: a `Machine`, a shipped one by name (`reference`, `sized`, `hiab_xs031`), a path, or what is in it. In the
        world `real` a shipped machine, or one that extends it, brings its gains; gains that are not given are those of the rule of
        `hdrm-fmu machine gains`, and the findings list them.
    waypoints : path that the tip follows instead of a trajectory: a JSON or CSV file of waypoints or samples, `iso9283-cube` or
        `iso9283-rectangle`, what is in such a JSON file, a DataFrame with the columns of such a CSV file, or positions of the shape (n, 3), m.
        Loads that it picks up act on the manipulator.
    settings : start values by name, such as `{"hdrm.inertia_scale": 1.2}`.
    signals, interval, stop_time, max_error, metrics, progress : as of `System.run`.
    step : communication step, s; default: as of `System`.
    schedule : `gauss-seidel` (default), `jacobi` or `standard`.

    Returns
    -------
    xarray.Dataset of `System.run`: signals of the shape (time,), units and descriptions as attributes; `tip_rmse`, `tip_max` (m, over the
    motion), further metrics and the verdict as attributes of the whole, and what the run is made again with: `world`, `seed`, `machine` (what is in it), `settings`, …

    Raises
    ------
    BadInput : before the run, where a name, a value or a file makes no sense.
    RunFailed : the machine cannot make the motion, such as a path with a waypoint out of reach, which the controller refuses at the start.
    """
    completed = complete(options, run)
    if system is not None:
        other_world = None if world == "ideal" else world
        refuse("is for the manipulator; a `system` of one's own takes `settings`", world=other_world, seed=seed)
    if isinstance(system, System):
        refuse("must be given to the `System`", waypoints=waypoints, step=step, schedule=schedule)
    schedule = schedule or "gauss-seidel"
    text, real_parameters = read_machine(machine)
    if isinstance(system, System):
        chosen = system
    elif system is None:
        chosen = world_system(world, real_parameters, waypoints=waypoints, step=step, schedule=schedule)
    else:
        chosen = System(system, waypoints=waypoints, step=step, schedule=schedule)
    given = {"trajectory": trajectory, "mode": mode, "seed": seed}
    case, settings = {name: value for name, value in given.items() if value is not None}, completed.pop("settings")
    for name in case.keys() & settings.keys():
        raise BadInput(f"`{name}` is given twice, once in settings")
    values, seed = case_settings({**case, **settings}, world)
    about = {"world": None if system is not None else world, "seed": seed, "machine": text, "given": values}
    with all_settings(chosen, values, seed, text) as (values, about["gains"]):
        return chosen._run(inputs, progress, {**completed, "settings": values}, about)


def refuse(why, **given):
    """Refuse arguments that do not belong to this call."""
    for name, value in given.items():
        if value is not None:
            raise BadInput(f"{name} = {value!r} {why}")
