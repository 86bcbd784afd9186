"""What a worker of a sweep runs: one case."""

from __future__ import annotations

import hashlib
import json
from typing import NamedTuple

from hdrm_fmu import _native
from hdrm_fmu.errors import RunFailed
from hdrm_fmu.files import identity
from hdrm_fmu.paths import TipPath
from hdrm_fmu.running import all_settings, world_path
from hdrm_fmu.system import System, forget_systems


class WrongWorker(RuntimeError):
    """A worker whose version or system differs, so that its results would."""


def check_worker(expected, spec, key):
    """Refuse a worker of another version, or whose system differs from the one with this key; return its version."""
    if identity() != expected:
        raise WrongWorker(f"a worker has hdrm_fmu {identity()}, but the sweep is started with {expected}")
    forget_systems()
    if system_key(spec) != key:
        raise WrongWorker(f"a worker has other contents in `{_system(spec).path}`, its parameter sets or FMUs")
    return identity()


class Case(NamedTuple):
    """A checked case: start values by full name, the seed of its machine, the path that it follows."""

    values: dict[str, str]
    seed: int | None
    path: TipPath | None


def _system(spec, path=None):
    options = {"step": spec["step"], "schedule": spec["schedule"], "waypoints": path}
    path = spec["path"] or world_path(spec["world"])
    return System(path, variant=spec["variant"], parameters=spec["parameters"], **options)


def case_key(spec, case):
    """Name of a case's result: a hash of all that it depends on. The machine of a seed follows from the rest."""
    with all_settings(system := _system(spec, case.path), case.values, None, spec["machine"]) as (settings, _):
        numbers = system._key(settings, spec["stop_time"])
    options = {name: spec[name] for name in ("signals", "interval", "max_error", "metrics")}
    text = json.dumps([identity(), numbers, case.seed, options], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def system_key(spec):
    """A hash of the system that all cases share."""
    return case_key(spec, Case({}, None, None))


def start_case(spec, case):
    """Start a case and end it at once, so that the controller checks its path."""
    system = _system(spec, case.path)
    with all_settings(system, case.values, case.seed, spec["machine"]) as (system.settings, _), system:
        system._is_judged = True


def run_case(expected, spec, case, key):
    """Metrics, verdict, and the time series if signals are recorded; of a failed run the error. Any other error does not belong to the case,
    and is raised."""
    if identity() != expected:
        raise WrongWorker(f"a worker has hdrm_fmu {identity()}, but the sweep is started with {expected}")
    if case_key(spec, case) != key:
        raise WrongWorker("a worker finds other contents in the files of a case: they differ there, or have changed since the sweep began")
    _native.reuse_instances()
    system = _system(spec, case.path)
    options = {name: spec[name] for name in ("interval", "stop_time", "max_error", "metrics")}
    signals = spec["signals"]
    try:
        with all_settings(system, case.values, case.seed, spec["machine"]) as (settings, _):
            data = system.run(settings=settings, signals=[] if signals is None else signals, **options)
    except RunFailed as error:
        return {"verdict": "failed", "findings": "", "error": str(error)}, None
    metrics = {name: value for name, value in data.attrs.items() if isinstance(value, float) and name not in ("elapsed", "step")}
    result = {"verdict": data.attrs["verdict"], "findings": data.attrs["findings"], "error": "", **metrics}
    return result, None if signals is None else data
