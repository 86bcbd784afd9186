"""Single faults on `Real.ssp`, by `hdrm-fmu faults`: those that a machine without monitors was thrown by are stopped in time."""

import json

from native import call

THROWN = ("controller.zeta[2] freeze", "controller.zeta[3] freeze", "controller.zeta[5] freeze", "sensors.zeta[2] bias", "emla_2.i_q_required freeze")


def test_faults_that_threw_the_machine_are_stopped(fmu_dir, tmp_path):
    only = [option for name in THROWN for option in ("--only", name)]
    found = tmp_path / "faults.json"
    call("hdrm-fmu", "faults", "--system", fmu_dir / "Real.ssp", "--path", "triangular", "--payload", 300, *only, "--json", found, "--check")
    runs = json.loads(found.read_text())["faults"]
    assert len(runs) == 3 * len(THROWN)
    for run in runs:
        assert run["fate"] == "stopped" and run["braked"] < 1, run


def test_faults_at_rest_are_stopped_though_a_push_is_none(fmu_dir, tmp_path):
    """With an empty hook, which a push of 300 N may turn (test_worlds.py): a tenth of a wrist drive's torque, and all of it."""
    only, found = ["--only", "tau_wrist[1] limit", "--only", "tau_wrist[2] bias"], tmp_path / "found.json"
    done = call("hdrm-fmu", "faults", "--system", fmu_dir / "Real.ssp", "--path", "rest", "--payload", 0, *only, "--json", found, "--check")
    runs = json.loads(found.read_text())["faults"]
    assert done.returncode == 0 and [run["fate"] for run in runs] == ["stopped"] * 6, runs
