"""The function `sweep`: thousands of runs on Dask, whose results survive workers and schedulers that die."""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import os
import queue
import sys
import time
import warnings
from typing import TYPE_CHECKING, Any

import pandas

from hdrm_fmu import _native
from hdrm_fmu.cases import rows
from hdrm_fmu.errors import BadInput, RunFailed, SweepStopped
from hdrm_fmu.files import identity
from hdrm_fmu.paths import Waypoints, check_free, tip_path
from hdrm_fmu.run_options import RunOptions, complete, explicit
from hdrm_fmu.machines import read_machine
from hdrm_fmu.running import case_settings, refuse, world_system
from hdrm_fmu.store import Store, check_folder, read_rows
from hdrm_fmu.system import System, forget_systems
from hdrm_fmu.tasks import Case, case_key, check_worker, run_case, start_case, system_key

if TYPE_CHECKING:
    from distributed import Client
    from typing_extensions import Unpack

#: Rows after which, and seconds after which, results are written.
FLUSH_ROWS, FLUSH_SECONDS = 64, 10.0
#: Cases under way for each thread of the workers: enough to keep them busy, few enough to keep memory flat.
IN_FLIGHT = 4
#: Seconds without a scheduler or workers after which a sweep stops.
PATIENCE = 120.0

OWN = ("case", "key", "verdict", "findings", "error")


@explicit
def sweep(
    cases: pandas.DataFrame,
    *,
    out: str | os.PathLike[str],
    world: str = "ideal",
    system: System | str | os.PathLike[str] | None = None,
    machine: str | os.PathLike[str] | dict[str, Any] | None = None,
    waypoints: Waypoints | None = None,
    step: float | None = None,
    schedule: str | None = None,
    client: Client | None = None,
    progress: bool = True,
    **options: Unpack[RunOptions],
) -> pandas.DataFrame:
    """Run every case of a table, in parallel, and keep the results in a folder.

    Parameters
    ----------
    cases : DataFrame, one row a run, one column a parameter by name (`mode`, `trajectory`, `hdrm.inertia_scale`, …; `seed`: machine of the
        world `real`; `waypoints`: a path's file or name); `grid` and `random` make such tables.
    out : folder of the results. A folder of the same sweep is completed: nothing in it is run again, and cases may be added. A case whose
        files have changed is another case: it is run, and a warning counts the results from before, which stay in the folder.
    system : `System`, or path of one, instead of the manipulator in `world`. Workers must see the same file.
    settings : start values of all cases.
    signals : signals whose time series are kept, one Parquet file a case in `out/series`; default: none.
    client : `distributed.Client`; default: a cluster of processes on this machine's cores, for this sweep alone.
    machine, waypoints, interval, stop_time, max_error, metrics : as of `run`.
    step, schedule : as of `run`; default: 1 ms and `gauss-seidel`, or those of the `System`.

    Returns
    -------
    DataFrame in the order of the cases: the cases, metrics in SI units, `verdict` (`good`, `BAD` or `failed`), `findings`, `error`.
    Order and number of workers change no bit of it.

    Raises
    ------
    BadInput : before the first run and before anything is written, where a name, a value, the folder or a worker does not fit, or a path is
        refused in all cases that follow it.
    SweepStopped : the cluster is gone. What is there is kept; the same call goes on from it.
    """
    completed, table = complete(options, sweep), rows(cases)
    forget_systems()
    for name in cases.columns:
        if name in OWN:
            raise BadInput(f"a column of cases cannot be named `{name}`: the results have one of that name")
    text, real_parameters = read_machine(machine)
    chosen = chosen_system(world, system, step, schedule, real_parameters)
    path = tip_path(chosen.waypoints if waypoints is None else waypoints)
    common = {**chosen.settings, **completed.pop("settings")}
    signals, metrics = completed["signals"], completed["metrics"]
    spec = {
        "world": world if system is None else None,
        "path": None if system is None else str(chosen.path.resolve()),
        "variant": chosen.variant,
        "parameters": list(chosen.parameters),
        "machine": text,
        "step": float(chosen.step_size),
        "schedule": chosen.schedule,
        **completed,
        "signals": None if signals is None else chosen.signals(signals),
        "metrics": metrics if isinstance(metrics, str) else list(metrics),
    }
    _check_client(client)
    chosen._check({**spec, "settings": None})
    planned = [_plan(chosen, spec, common, path, case) for case in table]
    _check_paths(spec, planned)
    shared = system_key(spec)
    # Where the files lie makes no difference, what they hold does.
    places = ("machine", "path", "variant", "parameters")
    manifest = {"version": identity(), "columns": list(cases.columns), "system": shared, **{k: v for k, v in spec.items() if k not in places}}
    manifest["settings"] = {name: str(value) for name, value in common.items()}
    texts = {"machine": spec["machine"], "waypoints": None if path is None else path.content}
    manifest |= {name: None if text is None else hashlib.sha256(text.encode()).hexdigest() for name, text in texts.items()}
    keys = [case_key(spec, case) for case in planned]
    check_folder(out, manifest)
    own, done = None, read_rows(out)
    if client is None and not done.keys() >= set(keys):
        client = own = _local()
    try:
        if client is not None:
            _check_workers(client, spec, shared)
        store = Store(out, manifest)
        try:
            done = store.read()
            missing = {key: plan for key, plan in zip(keys, planned) if key not in done}
            with _Bar(len(set(keys)), len(set(keys)) - len(missing), progress) as bar:
                for key, result, series in _results(client, spec, missing) if missing else ():
                    store.add({"key": key, **result}, series)
                    bar.update()
                    if store.pending >= FLUSH_ROWS or time.monotonic() - bar.flushed > FLUSH_SECONDS:
                        store.flush()
                        bar.flushed = time.monotonic()
            store.flush()
            frame = _frame(cases, keys, store.read())
            earlier = store.finish(frame, list(cases.columns))
            if earlier:
                text = f"{out} also holds {earlier} results of these cases from before their files were changed; they are kept there, but not used"
                warnings.warn(text, stacklevel=2)
            return frame
        finally:
            store.close()
    finally:
        if own is not None:
            own.close()
            own.cluster.close()


def chosen_system(world="ideal", system=None, step=None, schedule=None, real_parameters=_native.REAL_PARAMETERS):
    """The system that a sweep runs: `system`, which may be a path, else that of `world`."""
    if isinstance(system, System):
        refuse("must be given to the `System`", step=step, schedule=schedule)
        changes = (system.disconnect, system.replace, system.maps, system.feedthrough, system.scenario, system.faults, system.allow_nonfinite)
        changes += (system.interface, system.solver)
        told = system.names or system.start_time is not None or system.tolerance
        if any(changes) or system.fault_seed is not None or system.solve_loops or system.strict or system.files[1:] or told:
            raise BadInput("a sweep runs systems as their files have them, without disconnected inputs, replaced FMUs, options for them, and `strict`")
    if system is not None:
        refuse("is for the manipulator, not for a `system` of one's own", world=None if world == "ideal" else world)
    step, schedule = 1e-3 if step is None else step, schedule or "gauss-seidel"
    if system is None:
        return world_system(world, real_parameters, step=step, schedule=schedule)
    return system if isinstance(system, System) else System(system, step=step, schedule=schedule)


def _plan(system, spec, common, path, case):
    """A case with checked start values and path; its own override those that are common to all cases."""
    case = dict(case)
    own = case.pop("waypoints", None)
    if own is not None:
        if not isinstance(own, str):
            raise BadInput(f"column `waypoints`: {own!r} must be the path of a file or the name of a built-in path")
        path = tip_path(own)
    values, seed = case_settings(case, spec["world"])
    every, common_seed = case_settings(common, spec["world"])
    seed = common_seed if seed is None else seed
    names = system._sized({**every, **values})._names
    values = {**names.settings(every), **names.settings(values, "parameter or column")}
    check_free(path, values)
    return Case(values, seed, path)


def _check_paths(spec, planned):
    """Refuse a path on which no case starts: the controller checks it before it moves."""
    refused: dict[str, str | None] = {}
    for case in planned:
        if case.path is None or refused.get(case.path.content, "") is None:
            continue
        try:
            start_case(spec, case)
            refused[case.path.content] = None
        except RunFailed as error:
            refused.setdefault(case.path.content, str(error))
    for reason in refused.values():
        if reason is not None:
            raise BadInput(reason)


def _check_client(client):
    from distributed import Client

    if client is not None and not isinstance(client, Client):
        raise BadInput(f"client = {client!r} must be a distributed.Client")


def _check_guard():
    """Refuse a script whose processes would call this sweep again, since each imports the script."""
    frame, main = sys._getframe(), sys.modules["__main__"]
    while frame is not None and not (frame.f_code.co_name == "<module>" and frame.f_globals is vars(main)):
        frame = frame.f_back
    file = getattr(main, "__file__", None)
    if frame is None or file is None or not os.path.isfile(file):
        return
    with open(file, "rb") as source:
        called = [part for part in ast.parse(source.read()).body if part.lineno <= frame.f_lineno <= (part.end_lineno or 0)]
    if not any(isinstance(part, ast.If) and "__name__" in ast.unparse(part.test) for part in called):
        raise BadInput(f"{file}, line {frame.f_lineno}: a sweep starts processes that import this script: write `if __name__ == \"__main__\":` before the call, or give a client")


def _local():
    from distributed import Client, LocalCluster

    _check_guard()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    cluster = LocalCluster(n_workers=cores, threads_per_worker=1, processes=True, dashboard_address=None)
    return Client(cluster)


def _check_workers(client, spec, key):
    """Every worker must have this version of the package, and the system. The first question needs no package there."""
    client.wait_for_workers(1, timeout=PATIENCE)
    versions = client.run(importlib.metadata.version, "hdrm_fmu", on_error="return")
    own = importlib.metadata.version("hdrm_fmu")
    for worker, version in versions.items():
        if isinstance(version, BaseException):
            raise BadInput(f"the worker {worker} has no package hdrm_fmu; install this wheel there")
        if version != own:
            raise BadInput(f"the worker {worker} has hdrm_fmu {version}, but {own} is here")
    for worker, found in client.run(check_worker, identity(), spec, key, on_error="return").items():
        if isinstance(found, BaseException):
            raise BadInput(f"the worker {worker} cannot take part: {found}")


def _results(client, spec, missing):
    """(key, result, series) as they come, each once. Cases of a dead worker run on another one; cases that a restarted scheduler has lost are
    submitted again."""
    waiting = list(missing.items())[::-1]
    flying, finished = {}, queue.SimpleQueue()
    last = time.monotonic()
    width = IN_FLIGHT
    address, security, again = client.scheduler.address, client.security, None
    try:
        while waiting or flying:
            try:
                if client.status == "running":
                    width = max(1, sum(client.nthreads().values())) * IN_FLIGHT
                while waiting and len(flying) < width and client.status == "running":
                    key, case = waiting[-1]
                    future = client.submit(run_case, identity(), spec, case, key, key=f"hdrm_fmu-{key}", retries=3)
                    waiting.pop()
                    flying[key] = future
                    future.add_done_callback(finished.put)
            except (OSError, TimeoutError, RuntimeError) as error:
                _wait_or_stop(last, error)
            try:
                finished.get(timeout=0.5)
            except queue.Empty:
                pass
            for key, future in list(flying.items()):
                if future.status in ("cancelled", "lost"):
                    waiting.append((key, missing[key]))
                    del flying[key]
                elif future.status in ("finished", "error"):
                    outcome = _outcome(future)
                    del flying[key]
                    if outcome is None:
                        waiting.append((key, missing[key]))
                        continue
                    last = time.monotonic()
                    yield key, *outcome
            if client.status == "closed":
                client = again = _connected_again(address, security)
                waiting += [(key, missing[key]) for key in flying]
                flying.clear()
                last = time.monotonic()
            if time.monotonic() - last > PATIENCE and not (client.status == "running" and client.nthreads()):
                _wait_or_stop(last, "there is no scheduler or no worker")
    finally:
        if client.status == "running":
            client.cancel(list(flying.values()))
        if again is not None:
            again.close()


def _connected_again(address, security):
    """A client of the scheduler at an address, once there is one again."""
    from distributed import Client

    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        try:
            return Client(address, security=security, timeout=10)
        except (OSError, TimeoutError):
            time.sleep(0.5)
    raise SweepStopped(f"there has been no Dask scheduler at {address} for {PATIENCE:.0f} s; the same call goes on from what is there")


def _wait_or_stop(last, reason):
    if time.monotonic() - last > PATIENCE:
        raise SweepStopped(f"no result for {PATIENCE:.0f} s: {reason}; the same call goes on from what is there") from None
    time.sleep(0.2)


def _outcome(future):
    """What a case gave; None where its result was lost on the way."""
    from distributed import CancelledError, KilledWorker

    try:
        return future.result(timeout=30)
    except (CancelledError, OSError, TimeoutError):
        return None
    except KilledWorker as error:
        return {"verdict": "failed", "findings": "", "error": f"its workers died: {error}"}, None


def _frame(cases, keys, done):
    """The table in the order of the cases; columns by name, so that they do not depend on which case ended first."""
    found = pandas.DataFrame([done[key] for key in keys])
    order = ["key", "verdict", "findings", "error"]
    columns = cases.reset_index(drop=True)
    metrics = sorted(c for c in found.columns if c not in order and c not in columns.columns and c != "case")
    return pandas.concat([columns, found[metrics + order[1:] + order[:1]]], axis=1)


class _Bar:
    """A progress bar over the cases, if it is shown."""

    def __init__(self, total, initial, shown):
        from tqdm.auto import tqdm

        self._bar = tqdm(total=total, initial=initial, unit="runs", disable=not shown)
        self.flushed = time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._bar.close()

    def update(self):
        self._bar.update()
