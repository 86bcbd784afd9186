"""The native programs as their users meet them: what is set counts or is refused, a run says what it is worth, paths are the shell's."""

import csv
import json
import os
import shutil
import subprocess
import sys

import pytest

from fmpy_master import ROOT
from native import call, hdrm_fmu

SHORT = ["--stop-time", "0.02"]


@pytest.fixture
def machine(fmu_dir):
    return ["--system", fmu_dir / "Manipulator.ssp"]


@pytest.mark.parametrize("command, setting", [
    ("table", "hdrm.inertia_scale=2"),
    ("table", "mode=pd"),
    ("stability", "controller.omega_i=3"),
    ("compare", "controller.mode=pd"),
    ("endurance", "controller.trajectory=cubic"),
])  # fmt: skip
def test_what_a_command_varies_itself_cannot_be_set(machine, command, setting):
    steps = ["--steps", "100"] if command == "endurance" else SHORT
    done = call("hdrm-fmu", command, *machine, *steps, "--set", setting)
    name = setting.split("=")[0].split(".")[-1]
    assert done.returncode == 1
    assert (done.stdout + done.stderr).count(f".{name}` is set (--set), but this command varies it itself") == 1


def test_a_set_that_binds_what_a_command_varies_is_refused(machine):
    done = call("hdrm-fmu", "table", *machine, *SHORT, "--parameters", "resources/triangular.ssv")
    assert done.returncode == 1 and "`controller.trajectory` is set (parameter set" in done.stderr


def test_everything_else_that_is_set_counts(machine):
    table = ["table", *machine, "--stop-time", "0.2", "--set", "settle_time=0"]
    plain, heavy = (call("hdrm-fmu", *table, *more).stdout for more in ([], ["--set", "hdrm.payload.mass=80"]))
    assert "adaptive" in plain and plain != heavy


def test_what_is_set_on_the_machine_counts_on_the_testbed(machine):
    """The feedback on rods' positions works on the testbed only: in the machine the tip is controlled."""
    bed = ["testbed", *machine, "--stop-time", "4.5"]
    plain, other = (call("hdrm-fmu", *bed, *more).stdout for more in ([], ["--set", "controller.Lambda_rod=1"]))
    assert "lift" in plain and plain != other


def test_a_variable_of_one_component_needs_no_component(machine):
    runs = [call("cosim", "run", *machine, *SHORT, "--quiet", "--set", name) for name in ("gamma=5", "controller.gamma=5")]
    assert [run.returncode for run in runs] == [0, 0]
    refused = call("cosim", "run", *machine, *SHORT, "--set", "alpha=0.1")
    assert refused.returncode == 1 and "several components have a variable `alpha`" in refused.stderr
    refused = call("cosim", "run", *machine, *SHORT, "--set", "gama=5")
    assert refused.returncode == 1 and "no component of the system has a variable `gama`" in refused.stderr


@pytest.mark.parametrize("arguments, finding", [
    (["--set", "controller.K_f=0", "--stop-time", "6"], "current of emla_2: at its limit of 100 A"),
    (["--set", "hdrm.payload.mass=3000", "--stop-time", "1"], "force of emla_2: up to"),
    (["--set", "controller.machine_file=HASTY", "--stop-time", "4.3"], "rod speed of lift: up to"),
    (["--trajectory", "external", "--stop-time", "1"], "nothing drives controller.reference.position"),
    (["--stop-time", "5", "--max-error", "1e-7"], "tip error: up to"),
])  # fmt: skip
def test_a_bad_run_says_so(machine, tmp_path, arguments, finding):
    """HASTY: a machine file with 0.05 s for each edge of the trajectory."""
    hasty = json.loads((ROOT / "parameters/reference_machine.json").read_text())
    hasty["trajectories"]["cubic"]["edge_time"] = 0.05
    (tmp_path / "hasty.json").write_text(json.dumps(hasty))
    arguments = [argument.replace("HASTY", str(tmp_path / "hasty.json")) for argument in arguments]
    bad = call("hdrm-fmu", "run", *machine, "--quiet", *arguments, "--check")
    assert bad.returncode == 2 and "verdict: BAD" in bad.stdout and finding in bad.stdout, bad.stdout
    assert call("hdrm-fmu", "run", *machine, "--quiet", *arguments).returncode == 0


@pytest.mark.parametrize("trajectory, mode", [("cubic", "adaptive"), ("triangular", "pd")])
def test_a_good_run_is_good(machine, trajectory, mode):
    conditions = ["--trajectory", trajectory, "--mode", mode, "--max-error", "0.01"]
    good = call("hdrm-fmu", "run", *machine, "--quiet", *conditions, "--check")
    assert good.returncode == 0 and "BAD" not in good.stdout, good.stdout


def test_a_warning_is_printed_once(machine):
    text = call("hdrm-fmu", "run", *machine, "--quiet", "--set", "controller.K_f=0", "--stop-time", "0.1").stdout
    assert text.count("stability conditions") == 1


def test_a_step_that_is_too_long_is_named_before_the_symptom(machine):
    failed = call("hdrm-fmu", "run", *machine, "--quiet", "--step", "0.01")
    assert failed.returncode == 1 and "the communication step of 0.01 s is too long" in failed.stderr, failed.stderr


def test_the_last_step_ends_at_the_stop_time(machine, tmp_path):
    path = tmp_path / "run.csv"
    done = call("hdrm-fmu", "run", *machine, "--quiet", "--step", "0.003", "--stop-time", "0.01", "--csv", path)
    assert done.returncode == 0, done.stderr
    names, *rows = csv.reader(path.open())
    assert names[:2] == ["time", "controller.tip_error_norm"] and len(names) < 50
    assert [float(row[0]) for row in rows] == [0.0, 0.003, 0.006, 0.009000000000000001, 0.01]
    assert "hdrm.x[1],m" in (tmp_path / "run.units.csv").read_text().splitlines()


def test_an_interval_thins_the_rows_and_a_failed_run_keeps_its_rows(machine, tmp_path):
    path = tmp_path / "run.csv"
    log = ["--quiet", "--csv", path, "--interval", "0.005"]
    assert call("hdrm-fmu", "run", *machine, *log, *SHORT).returncode == 0
    assert [float(line.split(",")[0]) for line in path.read_text().splitlines()[1:]] == [0.0, 0.005, 0.01, 0.015, 0.02]
    assert call("hdrm-fmu", "plot", path).returncode == 0 and (tmp_path / "run.svg").is_file()
    for file in tmp_path.iterdir():
        file.unlink()
    failed = call("hdrm-fmu", "run", *machine, "--quiet", "--csv", path, "--step", "0.01", "--stop-time", "5")
    assert failed.returncode == 1 and "the rows up to t = " in failed.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.csv", "run.units.csv"]
    assert 0 < float(path.read_text().splitlines()[-1].split(",")[0]) < 5


def test_paths_are_the_shells_and_errors_say_where_was_looked(fmu_dir, tmp_path):
    unset = {name: value for name, value in os.environ.items() if name not in ("FMU_DIR", "CARGO_TARGET_DIR")}

    def here(*arguments, env=unset):
        return subprocess.run(["./hdrm-fmu", "run", *arguments], cwd=tmp_path, capture_output=True, text=True, env=env)

    shutil.copy(hdrm_fmu(), tmp_path)
    shutil.copy(fmu_dir / "Manipulator.ssp", tmp_path)
    beside = here("--quiet", *SHORT, "--csv", "here.csv")
    assert beside.returncode == 0 and (tmp_path / "here.csv").is_file(), beside.stderr
    (tmp_path / "fmus").mkdir()
    (tmp_path / "Manipulator.ssp").rename(tmp_path / "fmus/Manipulator.ssp")
    missing = here("--quiet", *SHORT)
    assert missing.returncode == 1 and f"{tmp_path}/fmu/Manipulator.ssp" in missing.stderr and "xtask" not in missing.stderr
    found = here("--quiet", *SHORT, env={**unset, "FMU_DIR": "fmus"})
    assert found.returncode == 0, found.stderr
    absent = here("--system", "absent.ssp")
    assert absent.returncode == 1 and f"`absent.ssp` cannot be read (looked for {tmp_path}/absent.ssp)" in absent.stderr


def test_a_structure_finds_its_fmus_without_a_folder_being_named(fmu_dir):
    structure = ["--system", ROOT / "system/SystemStructure.ssd", "--quiet", *SHORT]
    done = call("cosim", "run", *structure, env={**os.environ, "FMU_DIR": str(fmu_dir)})
    assert done.returncode == 0, done.stderr


def test_a_reader_that_goes_away_is_no_panic(machine):
    program = subprocess.Popen(
        [hdrm_fmu(), "run", *map(str, machine), "--quiet", *SHORT], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    program.stdout.close()
    assert program.wait(60) == 0 and program.stderr.read() == ""
    program.stderr.close()


def test_strict_runs_the_shipped_system(machine):
    """Inputs that it does not mention (external references, loads) keep their start values, and this is said."""
    done = call("cosim", "run", *machine, "--quiet", *SHORT, "--strict")
    assert done.returncode == 0, done.stderr
    assert "does not mention keep their start values" in done.stdout and "hdrm.wrench_env" in done.stdout


def test_forgotten_wires_are_reported_and_strict_refuses_them(fmu_dir, tmp_path):
    """An input that was wired, and a connector that the FMU lacks."""
    text = (ROOT / "system/SystemStructure.ssd").read_text()
    (wire,) = [line for line in text.splitlines() if 'endElement="controller" endConnector="i_d[1]"' in line]
    text = text.replace(wire, "").replace("</ssd:Connectors>", '<ssd:Connector name="T_hot" kind="output"/></ssd:Connectors>', 1)
    path = tmp_path / "system.ssd"
    path.write_text(text)
    run = ["run", "--system", path, "--fmu-dir", fmu_dir, "--quiet", *SHORT]
    done = call("cosim", *run, "--check")
    assert done.returncode == 2 and "connectors that the FMUs do not have: controller.T_hot" in done.stdout, done.stderr
    assert "controller.i_d" in next(line for line in done.stdout.splitlines() if "nothing drives or sets" in line)
    strict = call("cosim", *run, "--strict")
    assert strict.returncode == 1 and "--strict: connectors that the FMUs do not have: controller.T_hot" in strict.stderr
    assert strict.stderr.count("controller.i_d") == 1 and "wrench_env" not in strict.stderr
    assert "controller.i_d" in call("cosim", "wiring", "--system", path, "--fmu-dir", fmu_dir).stdout


def test_the_bending_world_runs_with_the_python_that_has_mujoco(tmp_path, fmu_dir):
    """One command: it makes the plant beside the packed machine, starts itself with Python inside, and prints the laws together with the bound."""
    for name in ("Manipulator.ssp", "Controller.fmu", "Emla.fmu"):
        shutil.copy(fmu_dir / name, tmp_path)
    machine = ["--world", "bending", "--seeds", "1", "--law", "adaptive", "--stop-time", "4.05"]
    here = os.environ | {"FMU_DIR": str(tmp_path)}
    done = call("hdrm-fmu", "table", *machine, env=here | {"HDRM_FMU_PYTHON": sys.executable})
    assert done.returncode == 0, done.stderr
    assert "sag max, mm" in done.stdout and "adaptive: at most" in done.stdout
    missing = call("hdrm-fmu", "table", *machine, env=here | {"HDRM_FMU_PYTHON": str(tmp_path / "python")})
    assert missing.returncode == 1 and "pip install pythonfmu mujoco numpy" in missing.stderr


def test_a_perturbed_machine_is_that_of_the_real_world_and_runs(tmp_path, machine):
    file = tmp_path / "machine.json"
    perturb = ["machine", "perturb", "--out", file]
    done = call("hdrm-fmu", *perturb, "--seed", "7", "--second-moment", "0.3")
    assert done.returncode == 0 and "hdrm.gravity[1]=" in done.stdout, done.stderr
    drawn, nominal = json.loads(file.read_text()), json.loads((ROOT / "parameters/reference_machine.json").read_text())
    assert 0 < abs(drawn["bodies"]["A2"]["mass"] / nominal["bodies"]["A2"]["mass"] - 1) <= 0.4
    assert call("hdrm-fmu", "run", *machine, *SHORT, "--set", f"hdrm.machine_file={file}").returncode == 0
    refused = call("hdrm-fmu", *perturb, "--mass", "1")
    assert refused.returncode == 1 and "`mass` = 1 must be at least 0 and below 1" in refused.stderr
