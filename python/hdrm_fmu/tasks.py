"""What a worker does: one case."""

from hdrm_fmu import _native
from hdrm_fmu.errors import RunFailed
from hdrm_fmu.files import identity
from hdrm_fmu.running import all_settings, world_system
from hdrm_fmu.system import System


class WrongWorker(RuntimeError):
    """A worker that would compute something else."""


def check_worker(expected, spec):
    """Refuse a worker of another version, or one that does not have the system; else say what it has."""
    if identity() != expected:
        raise WrongWorker(f"a worker has hdrm_fmu {identity()}, but the sweep is started with {expected}")
    system = _system(spec)
    if spec["digest"] is not None and system.digest != spec["digest"]:
        raise WrongWorker(f"a worker has another file as `{system.path}`")
    system._load()
    return identity()


def _system(spec):
    options = {"step": spec["step"], "schedule": spec["schedule"]}
    if spec["path"] is None:
        return world_system(spec["world"], **options)
    return System(spec["path"], variant=spec["variant"], parameters=spec["parameters"], **options)


def run_case(expected, spec, values, seed):
    """Metrics, verdict, and the time series where signals are asked for; of a failed run the error. Anything else that goes wrong is not of
    the case, and is raised."""
    if identity() != expected:
        raise WrongWorker(f"a worker has hdrm_fmu {identity()}, but the sweep is started with {expected}")
    _native.reuse_instances()
    system = _system(spec)
    wanted = spec["signals"]
    try:
        with all_settings(system, values, seed, spec["machine"]) as settings:
            data = system.run(
                settings=settings,
                signals=[] if wanted is None else wanted,
                interval=spec["interval"],
                stop_time=spec["stop_time"],
                max_error=spec["max_error"],
                metrics=spec["metrics"],
            )
    except RunFailed as error:
        return {"verdict": "failed", "findings": "", "error": str(error)}, None
    metrics = {name: value for name, value in data.attrs.items() if isinstance(value, float) and name not in ("elapsed", "step")}
    result = {"verdict": data.attrs["verdict"], "findings": data.attrs["findings"], "error": "", **metrics}
    return result, None if wanted is None else data
