"""Saved states in the middle of a coupled run: the run continues bit for bit, also in a fresh process from bytes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SIGNALS = ["controller.tip_error_norm", "controller.mass_hat.PL", "emla_2.F", "emla_3.i_q", "emla_1.P_in", "hdrm.zeta[2]"]
# Short settling, so that the machine moves, and adapts, when it is saved.
SETTINGS = {"controller": {"settle_time": 0.1, "trajectory": 2}, "hdrm": {"inertia_scale": 1.2}}
SAVED, END = 0.35, 0.6

CONTINUE = """
import json, sys
sys.path.insert(0, sys.argv[1])
import test_states
print(json.dumps(test_states.continued(sys.argv[2], sys.argv[3], sys.argv[4])))
"""


def rows(master, until):
    return master.record(until, SIGNALS)[1].tolist()


def continued(fmu_dir, states, folder):
    """In another process: new instances that were never initialized take the states and go on."""
    from fmpy_master import ROOT, Master
    from fmu import Fmu
    from system import System

    system = System.read(ROOT / "system/SystemStructure.ssd")
    fmus = {f: Fmu(Path(fmu_dir, f), Path(folder, f)) for f in set(system.components.values())}
    master = Master(system, fmus)
    for name, instance in master.instances.items():
        instance.call("fmi2Reset")
        instance.deserialize(Path(states, name).read_bytes())
    master.steps = round(SAVED / master.h)
    return rows(master, END)


@pytest.fixture
def reference(couple):
    """A run without interruption from SAVED to END."""
    master = couple(settings=SETTINGS)
    master.record(SAVED, SIGNALS)
    return rows(master, END)


def test_two_runs_are_equal_bit_for_bit(couple, reference):
    again = couple(settings=SETTINGS)
    again.record(SAVED, SIGNALS)
    assert rows(again, END) == reference
    assert reference[0] != reference[-1]


def test_a_restored_run_continues_bit_for_bit(couple, reference):
    master = couple(settings=SETTINGS)
    master.record(SAVED, SIGNALS)
    states = {name: instance.save() for name, instance in master.instances.items()}
    for _ in range(2):
        assert rows(master, END) == reference
        for name, instance in master.instances.items():
            instance.restore(states[name])
        master.steps = round(SAVED / master.h)
    for name, state in states.items():
        master.instances[name].slave.freeFMUstate(state)


def test_a_serialized_run_continues_in_a_fresh_process(couple, reference, fmu_dir, tmp_path):
    master = couple(settings=SETTINGS)
    master.record(SAVED, SIGNALS)
    for name, instance in master.instances.items():
        (tmp_path / name).write_bytes(instance.serialize())
    arguments = [sys.executable, "-c", CONTINUE, str(Path(__file__).parent), fmu_dir, tmp_path, tmp_path / "fmus"]
    done = subprocess.run(list(map(str, arguments)), capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == reference


def test_states_may_be_saved_in_every_mode(fmu):
    """Instantiated, Initialization Mode, Step Complete, Terminated: a copy brings back the mode too."""
    instance = fmu.instance()
    instantiated = instance.save()
    instance.setup()
    instance.call("fmi2EnterInitializationMode")
    initialization = instance.save()
    instance.call("fmi2ExitInitializationMode")
    first = instance.outputs()
    instance.step(0.0, 1e-3)
    second = instance.outputs()
    instance.call("fmi2Terminate")
    terminated = instance.save()
    instance.restore(initialization)
    instance.call("fmi2ExitInitializationMode")
    assert instance.outputs() == first
    instance.restore(terminated)
    assert instance.outputs() == second and instance.status("fmi2DoStep", 1e-3, 1e-3, 1) == 3
    instance.restore(instantiated)
    assert instance.start().outputs() == first
    instance.free()


def test_a_restored_state_can_take_another_way(hdrm):
    """As in an importer that tries a step again with half the size: the tried step leaves no trace."""
    plain, trying = (hdrm.instance().start(0.0, {"f[2]": 20e3}) for _ in range(2))
    state = trying.save()
    trying.step(0.0, 2e-3)
    trying.set({"f[2]": -50e3})
    trying.step(2e-3, 1e-3)
    trying.restore(state)
    for instance in (plain, trying):
        instance.step(0.0, 1e-3)
    assert trying.outputs() == plain.outputs() and trying.get("f[2]") == 20e3
