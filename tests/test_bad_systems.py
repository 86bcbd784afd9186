"""Systems that cannot be run are refused by both masters, each with the reason in `bad_systems/systems.json`.

An entry changes some text of the good system `bad_systems/good.ssd`, which both masters run. Where the native master has another reason, it is
the entry's `native`; null: it runs the system, and the FMPy master says that it does not support it.
"""

import json
from pathlib import Path

import pytest

from fmpy_master import Master
from fmu import Refused
from native import call
from system import BadSystem, System

FOLDER = Path(__file__).parent / "bad_systems"
GOOD = (FOLDER / "good.ssd").read_text()
BAD = {entry["name"]: entry for entry in json.loads((FOLDER / "systems.json").read_text())}


def changed(entry):
    """The good system's text with the entry's edits."""
    text = GOOD
    for old, new in entry["edits"]:
        assert text.count(old) == 1, f"{old} is there {text.count(old)} times"
        text = text.replace(old, new)
    return text


@pytest.fixture
def fmpy(fmus, tmp_path):
    """Runs a structure for two steps in the FMPy master."""

    def run(text):
        path = tmp_path / "system.ssd"
        path.write_text(text)
        system = System.read(path)
        for file in system.components.values():
            if file not in fmus:
                raise BadSystem(f"FMU `{file}` cannot be read")
        master = Master(system, fmus)
        master.record(2e-3, ["hdrm.x[1]"])
        master.free()

    return run


@pytest.fixture
def native(fmu_dir, tmp_path):
    """Runs a structure for two steps in the native master."""

    def run(text):
        path = tmp_path / "system.ssd"
        path.write_text(text)
        return call("cosim", "run", "--system", path, "--fmu-dir", fmu_dir, "--quiet", "--stop-time", "2e-3")

    return run


def test_both_masters_run_the_good_system(fmpy, native):
    fmpy(GOOD)
    done = native(GOOD)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", BAD)
def test_the_fmpy_master_refuses(fmpy, name):
    with pytest.raises((BadSystem, Refused)) as refused:
        fmpy(changed(BAD[name]))
    assert BAD[name]["reason"] in str(refused.value)


@pytest.mark.parametrize("name", BAD)
def test_the_native_master_refuses(native, name):
    done = native(changed(BAD[name]))
    reason = BAD[name].get("native", BAD[name]["reason"])
    if reason is None:
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 1 and reason in done.stderr, (done.returncode, done.stderr)
