"""Fixtures: the packed FMUs (environment variable FMU_DIR, default target/fmu), unpacked once."""

import atexit
import json
import os
import sys
from pathlib import Path

import pytest

from fmpy_master import ROOT, Master
from fmu import Fmu
from system import System

FMU_DIR = Path(os.environ.get("FMU_DIR", ROOT / "target/fmu")).resolve()  # as the caller's shell means it
NAMES = ("Emla", "Hdrm", "Controller")
WORLD = ("Rig", "Sensors", "DcLink")  # what makes the world real
CI = os.environ.get("CI", "") not in ("", "0", "false")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """In continuous integration nothing may be skipped: what is missing there is a failure."""
    report = yield
    if report.skipped and CI:
        report.outcome, report.longrepr = "failed", f"skipped, which is a failure where CI is set: {call.excinfo.value}"
    return report


@pytest.fixture(scope="session")
def pythonfmu(request):
    """For who loads an FMU of pythonfmu here: this process ends without finalizers, with the exit code of its tests.

    At a process's usual end the library of pythonfmu (0.7.0) frees its state by a static destructor and, after it, by a finalizer
    (`finalizePythonInterpreter`), which writes into freed memory: some processes abort after all tests have passed.
    """

    def leave():
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(request.session.exitstatus))

    atexit.register(leave)


@pytest.fixture(scope="module")
def file(request, tmp_path_factory):
    """The machine OWN of a test file, written as its FILE_NAME says."""
    path = tmp_path_factory.mktemp("own") / request.module.FILE_NAME
    path.write_text(json.dumps(request.module.OWN))
    return path


@pytest.fixture(scope="session")
def fmu_dir():
    assert (FMU_DIR / "Hdrm.fmu").is_file(), f"no FMUs in {FMU_DIR}; run `cargo xtask pack`"
    return FMU_DIR


@pytest.fixture(scope="session")
def fmus(fmu_dir, tmp_path_factory):
    """The FMUs by file name."""
    folder = tmp_path_factory.mktemp("fmus")
    return {f"{n}.fmu": Fmu(fmu_dir / f"{n}.fmu", folder / n) for n in (*NAMES, *WORLD)}


@pytest.fixture(scope="session")
def emla(fmus):
    return fmus["Emla.fmu"]


@pytest.fixture(scope="session")
def hdrm(fmus):
    return fmus["Hdrm.fmu"]


@pytest.fixture(scope="session")
def controller(fmus):
    return fmus["Controller.fmu"]


@pytest.fixture(params=NAMES)
def fmu(request, fmus):
    """Each of the three of the ideal machine in turn."""
    return fmus[f"{request.param}.fmu"]


@pytest.fixture(scope="session")
def system():
    return System.read(ROOT / "system/SystemStructure.ssd")


@pytest.fixture
def couple(system, fmus):
    """Makes masters of the shipped system; frees their instances."""
    made = []

    def couple(**options):
        made.append(Master(system, fmus, **options))
        return made[-1]

    yield couple
    for master in made:
        master.free()
