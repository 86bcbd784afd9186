"""An all-electric heavy-duty manipulator as FMUs: runs, sweeps and studies.

`run` makes one run; `System` steps or runs any system of FMUs; `fmus` gives the FMUs' paths for other importers; `sweep` makes thousands of
runs on Dask; `Machine` is a machine file and what is told of it; `findings` are those of a run; `hdrm_fmu.studies` has Monte Carlo, sensitivity and tuning, `hdrm_fmu.plots` the figures. SI units throughout.
"""

import os

from hdrm_fmu import _native
from hdrm_fmu._native import VERSION as __version__
from hdrm_fmu._native import tip_error
from hdrm_fmu.cases import grid, random
from hdrm_fmu.errors import BadInput, RunFailed, SweepStopped, WrongThread
from hdrm_fmu.files import fmus, parameters, systems
from hdrm_fmu.findings import Finding, findings
from hdrm_fmu.machines import Machine
from hdrm_fmu.names import Variable
from hdrm_fmu.running import MODES, WORLDS, run
from hdrm_fmu.sweeping import sweep
from hdrm_fmu.system import METRICS, SCHEDULES, System

__all__ = [
    "METRICS", "MODES", "SCHEDULES", "WORLDS", "BadInput", "Finding", "Machine", "RunFailed", "SweepStopped", "System", "Variable", "WrongThread", "__version__",
    "findings", "fmus", "grid", "parameters", "random", "run", "sweep", "systems", "tip_error",
]  # fmt: skip

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_native.was_forked)
