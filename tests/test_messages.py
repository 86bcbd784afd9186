"""What `hdrm-fmu` says to whom makes a mistake, and what it leaves unsaid because it is none."""

import json

import pytest

from fmpy_master import ROOT
from native import call

SHORT = ["--quiet", "--stop-time", "0.02"]


@pytest.fixture
def machine(fmu_dir):
    return ["--system", fmu_dir / "Manipulator.ssp"]


@pytest.mark.parametrize("system", ["Manipulator.ssp", "Electric.ssp"])
def test_a_shipped_system_has_forgotten_nothing(fmu_dir, system):
    done = call("hdrm-fmu", "run", "--system", fmu_dir / system, *SHORT)
    assert done.returncode == 0 and "does not mention" not in done.stdout, done.stdout


def test_an_input_that_was_forgotten_is_still_named(fmu_dir, tmp_path):
    """The wrist's torques are left out; a link voltage is given to one of three actuators, so that the others lack it."""
    text = (ROOT / "system/SystemStructure.ssd").read_text()
    lines = [line for line in text.splitlines() if 'endConnector="tau_wrist[' not in line]
    text = "\n".join(line for line in lines if not ('name="tau_wrist[' in line and 'kind="input"' in line))
    path = tmp_path / "system.ssd"
    path.write_text(text)
    run = ["run", "--system", path, "--fmu-dir", fmu_dir, *SHORT]
    (told,) = [line for line in call("hdrm-fmu", *run).stdout.splitlines() if "does not mention" in line]
    assert told.endswith(": hdrm.tau_wrist"), told
    (told,) = [line for line in call("hdrm-fmu", *run, "--set", "emla_1.v_dc=650").stdout.splitlines() if "does not mention" in line]
    assert told.endswith(": emla_2.v_dc, emla_3.v_dc, hdrm.tau_wrist"), told


def test_a_path_that_the_machine_cannot_do_is_told_line_by_line(machine, tmp_path):
    far = tmp_path / "far.json"
    far.write_text(json.dumps({"waypoints": [{"position": [9, 9, 9], "speed": 0.2}, {"position": [9, 9, 8]}]}))
    refused = call("hdrm-fmu", "run", *machine, "--waypoints", far, "--quiet")
    first, *others = refused.stderr.splitlines()
    assert refused.returncode == 1 and first.startswith(f"error: path `{far}`: the machine cannot do this path: waypoint 1 is"), first
    assert len(others) > 3 and all(line.startswith("  ") and "; " not in line for line in others), others
    assert all("fmi2" not in line for line in [first, *others[:-1]]), refused.stderr  # only the last line may say which call it was


def test_semicolons_in_a_csv_file_are_named(machine, tmp_path):
    run, path = tmp_path / "run.csv", tmp_path / "path.csv"
    run.write_text("time;controller.tip_error_norm\n0;1\n")
    path.write_text("x;y;z\n1;2;3\n")
    for arguments in (["evaluate", run, *machine], ["path", "show", path], ["run", *machine, *SHORT, "--waypoints", path]):
        refused = call("hdrm-fmu", *arguments)
        assert refused.returncode == 1 and "separated by semicolons (`;`)" in refused.stderr, refused.stderr


def test_a_machine_that_is_given_twice_is_refused(machine):
    refused = call("hdrm-fmu", "run", *machine, *SHORT, "--machine", "sized", "--set", "hdrm.machine_file=reference")
    assert refused.returncode == 1 and "`hdrm.machine_file` is set (--set), but --machine sized binds it too" in refused.stderr, refused.stderr


def test_a_negative_step_is_refused_by_name(machine):
    refused = call("hdrm-fmu", "run", *machine, *SHORT, "--step", "-0.001")
    assert refused.returncode == 1 and "--step" in refused.stderr and "-0.001" in refused.stderr, refused.stderr


def test_an_fmu_in_place_of_a_system_is_named(fmu_dir):
    refused = call("hdrm-fmu", "run", "--system", fmu_dir / "Emla.fmu", *SHORT)
    assert refused.returncode == 1 and "FMU" in refused.stderr and "UTF-8" not in refused.stderr, refused.stderr


def test_an_unknown_variable_gets_the_nearest_one(machine):
    refused = call("hdrm-fmu", "run", *machine, *SHORT, "--set", "controller.gama=5")
    assert refused.returncode == 1 and "did you mean `gamma`" in refused.stderr.replace("controller.gamma", "gamma"), refused.stderr


def test_a_wrong_mean_of_a_bond_names_its_place(fmu_dir, tmp_path):
    text = (ROOT / "system/SystemStructure.ssd").read_text()
    path = tmp_path / "system.ssd"
    path.write_text(text.replace('stepMean="F_mean"', 'stepMean="F_maen"', 1))
    refused = call("hdrm-fmu", "run", "--system", path, "--fmu-dir", fmu_dir, *SHORT)
    assert refused.returncode == 1 and f"`{path}`, line " in refused.stderr, refused.stderr
    assert "power bond of emla_1.F: emla_1.F_maen: model `Emla` has no variable `F_maen`" in refused.stderr
