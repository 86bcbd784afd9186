"""Machine files as their users meet them: what differs alone, everything wrong at once, other sizes, drawings, load charts that are true."""

import csv
import json
import runpy

import pytest
from jsonschema import Draft202012Validator

from fmpy_master import ROOT
from fmu import Refused
from native import call

PARAMETERS = ROOT / "parameters"
SHORT = ["--stop-time", "0.02"]


@pytest.fixture
def machine(fmu_dir):
    return ["--system", fmu_dir / "Manipulator.ssp"]


def write(path, value):
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(value))
    return path


def test_every_fmu_reads_what_differs_and_the_name_of_a_shipped_machine(fmus, tmp_path):
    write(tmp_path / "base" / "slow.json", {"extends": "sized", "gravity": 3.7})
    path = write(tmp_path / "mine.json", {"extends": "base/slow.json", "emla": {"R_s": 0.123}, "bodies": {"PL": {"mass": 77.0}}})
    read = {"Emla": ("R_s", 0.123), "Rig": ("R_s", 0.123), "Hdrm": ("payload.mass", 77.0), "Controller": None}
    for name, value in read.items():
        for machine in (str(path), "hiab_xs031"):
            instance = fmus[f"{name}.fmu"].instance()
            instance.set({"machine_file": machine})
            instance.enter_initialization()
            assert instance.get("machine_file") == machine
            if value and machine == str(path):
                assert instance.get(value[0]) == value[1]
            instance.free()


@pytest.mark.parametrize("content, words", [
    ({"extends": "referense"}, ["`referense`", "did you mean `reference`?"]),
    ({"extends": "mine.json"}, ["must not extend itself"]),
    ({"extends": "reference", "emla": {"r_S": 1}}, ["`emla.r_S` is an unknown field; did you mean `R_s`?"]),
])  # fmt: skip
def test_a_wrong_base_or_field_is_refused_by_every_fmu(fmus, tmp_path, content, words):
    path = write(tmp_path / "mine.json", content)
    for name in ["Emla", "Rig", "Hdrm", "Controller"]:
        instance = fmus[f"{name}.fmu"].instance()
        with pytest.raises(Refused) as refusal:
            instance.set({"machine_file": str(path)})
        assert all(word in refusal.value.text for word in words), refusal.value.text
        instance.free()


def test_check_tells_everything_at_once(tmp_path):
    wrong = {
        "extends": "reference",
        "emla": {"lift": {"R_s": -1}, "tilt": {"L_dd": 3}},
        "geometry": {"d4": "long"},
        "limits": {"stroke_2": [0.5, 0.1]},
    }
    done = call("hdrm-fmu", "machine", "check", write(tmp_path / "wrong.json", wrong))
    assert done.returncode == 1
    assert sorted(done.stdout.splitlines()) == [
        "`emla.lift.R_s` = -1 must be finite and > 0",
        "`emla.tilt.L_dd` is an unknown field; did you mean `L_d`?",
        '`geometry.d4` = "long" must be a number',
        "`limits.stroke_2` = [0.5, 0.1] must be finite with minimum < maximum",
    ]
    for name in ["reference", "sized", "hiab_xs031"]:
        assert call("hdrm-fmu", "machine", "check", name).returncode == 0
    open_loop = write(tmp_path / "open.json", {"extends": "reference", "geometry": {"d5": 0.01}})
    done = call("hdrm-fmu", "machine", "check", open_loop)
    assert done.returncode == 1 and done.stdout.startswith("`geometry`: the four-bar does not close"), done.stdout + done.stderr
    part = call("hdrm-fmu", "machine", "check", write(tmp_path / "part.json", {"gravity": 1.6}))
    assert part.returncode == 1 and "`bodies` is missing" in part.stdout and 'needs "extends": "reference"' in part.stderr


def geared(path, gear, lead_mm, edge_time=3.0):
    """The reference machine with other gears and screws."""
    paths = {"triangular": {"edge_time": edge_time}}
    return write(path, {"extends": "reference", "emla": {"N_gear": gear, "rho": lead_mm / 1000}, "trajectories": paths})


@pytest.mark.parametrize("gear, lead_mm, edge_time", [(6, 8, 3), (8, 12, 3), (10, 8, 6), (14, 12, 6)])
def test_a_machine_with_other_gears_runs_with_the_gains_of_the_rule(tmp_path, machine, gear, lead_mm, edge_time):
    """In both worlds, with full and empty hook; and with booms 40 % heavier than the controller knows, without swinging."""
    file = geared(tmp_path / "mine.json", gear, lead_mm, edge_time)
    done = call("hdrm-fmu", "machine", "check", file)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("tip error RMSE") == 4 and "tried in closed loop" in done.stdout
    heavy = ["--set", "controller.trajectory=triangular", "--set", "controller.mode=adaptive", "--set", "hdrm.inertia_scale=1.4", "--check"]
    done = call("hdrm-fmu", "run", *machine, "--machine", file, *heavy)
    assert done.returncode == 0 and "gains by the rule" in done.stdout and "alpha = 0" in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("mass", [31, 98, 140])
def test_a_machine_for_light_loads_is_kept_with_an_empty_hook(tmp_path, mass):
    """Gains for a light payload make the wrist of an empty hook swing up slowly: the supervisor leaves it until it is found."""
    done = call("hdrm-fmu", "machine", "check", write(tmp_path / "light.json", {"extends": "reference", "bodies": {"PL": {"mass": mass}}}))
    assert done.returncode == 0 and "real world, hook empty: tip error RMSE 0." in done.stdout, done.stdout


@pytest.mark.parametrize("gear", [8, 11])
def test_a_crane_whose_slew_has_little_force_is_kept(tmp_path, gear):
    """Its motor sticks by more than a quarter of what the rated force asks for; that is no brake that drags."""
    own = {"extends": "hiab_xs031", "emla": {"N_gear": gear, "rho": 0.0098}, "trajectories": {"triangular": {"edge_time": 6}}}
    done = call("hdrm-fmu", "machine", "check", write(tmp_path / "crane.json", own))
    assert done.returncode == 0 and done.stdout.count("real world, hook") >= 2, done.stdout


def test_a_path_too_fast_for_the_gears_is_refused_with_the_reason(tmp_path):
    done = call("hdrm-fmu", "machine", "check", geared(tmp_path / "fast.json", 10, 8))
    assert done.returncode == 1 and "motor speed of emla_2: up to" in done.stdout and "is too fast for motors" in done.stdout, done.stdout
    assert call("hdrm-fmu", "machine", "check", "--no-trials", tmp_path / "fast.json").returncode == 0


def test_a_machine_without_gains_is_refused_unless_the_user_gives_one(tmp_path, machine):
    """Motors that weigh a hundred times what the booms do."""
    file = geared(tmp_path / "heavy.json", 80, 8)
    assert "no `controller.Lambda_position`" in call("hdrm-fmu", "machine", "check", file).stdout
    done = call("hdrm-fmu", "run", *machine, "--machine", file, *SHORT)
    assert done.returncode == 1 and "no `controller.Lambda_position`" in done.stderr
    own = tmp_path / "own.ssv"
    assert call("hdrm-fmu", "machine", "gains", "reference", "--world", "ideal", "--output", own).returncode == 0
    for given in ["--set", "controller.Lambda_position=20"], ["--parameters", own]:
        done = call("hdrm-fmu", "run", *machine, "--machine", file, *SHORT, *given)
        assert done.returncode == 0 and "Lambda_position =" not in done.stdout, done.stdout + done.stderr


def test_a_start_that_no_motor_holds_for_ever_is_noted(tmp_path):
    weak = {"extends": "reference", "emla": {"lift": {"heat": {"C_w": 2e3, "R_wh": 0.06, "C_h": 15e3, "R_ha": 1.5}}}}
    done = call("hdrm-fmu", "machine", "check", write(tmp_path / "weak.json", weak))
    assert done.returncode == 0, done.stderr
    assert "note: the start pose cannot be held for ever: motor torque of lift = " in done.stdout and "winding at 155 °C" in done.stdout


def test_a_sheet_is_svg_or_png(tmp_path):
    done = call("hdrm-fmu", "machine", "draw", "reference", "--output", tmp_path / "sheet.pdf")
    assert done.returncode == 1 and "must end in .svg or .png" in done.stderr


def test_the_schema_takes_what_the_program_takes():
    schema = json.loads((PARAMETERS / "machine.schema.json").read_text())
    assert json.loads(call("hdrm-fmu", "machine", "schema").stdout) == schema
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    for file in ["reference_machine", "sized_machine", "hiab_xs031"]:
        validator.validate(json.loads((PARAMETERS / f"{file}.json").read_text()))
    for wrong in [
        {"gravity": 9.81},
        {"extends": "reference", "gravitas": 3},
        {"extends": "reference", "emla": {"R_s": -1}},
        {"extends": "reference", "emla": {"lift": {"R_s": 0}}},
        {"extends": "reference", "geometry": {"r_O_B": [1, 2]}},
    ]:
        assert not validator.is_valid(wrong), wrong


def test_a_machine_of_another_size_extends_the_one_it_is_made_of_and_runs(machine, tmp_path):
    file = tmp_path / "long.json"
    done = call("hdrm-fmu", "machine", "scale", "--booms", "1.1", "--output", file)
    assert done.returncode == 0, done.stderr
    long = json.loads(file.read_text())
    assert long["extends"] == "reference" and "ratings" not in long
    assert long["geometry"]["d4"] == pytest.approx(1.1 * 0.34)
    assert long["bodies"]["A2"]["mass"] == pytest.approx(1.1**3 * 290)
    assert call("hdrm-fmu", "run", *machine, *SHORT, "--machine", file).returncode == 0
    refused = call("hdrm-fmu", "machine", "scale", "--booms", "0", "--output", file)
    assert refused.returncode == 1 and "--booms 0 must be finite and > 0" in refused.stderr


def test_one_option_names_the_machine_for_all_fmus(machine, tmp_path):
    named = call("hdrm-fmu", "run", *machine, *SHORT, "--machine", "hiab_xs031", "--quiet")
    emla = [f"emla_{k}" for k in (1, 2, 3)]
    files = [f"{c}.machine_file=hiab_xs031" for c in [*emla, "hdrm", "controller"]] + [f"{c}.axis={c[-1]}" for c in emla]
    each = call("hdrm-fmu", "run", *machine, *SHORT, "--quiet", *(x for f in files for x in ("--set", f)))
    numbers = [[line for line in done.stdout.splitlines() if "simulated in" not in line] for done in (named, each)]
    assert named.returncode == 0 and numbers[0] == numbers[1], named.stderr
    for system in ["Electric.ssp", "Testbed.ssp"]:
        other = call("hdrm-fmu", "run", "--system", machine[1].with_name(system), *SHORT, "--machine", "hiab_xs031", "--quiet")
        assert "--machine" not in other.stderr, other.stderr
    wrong = write(tmp_path / "wrong.json", {"extends": "reference", "gravity": -1})
    refused = call("hdrm-fmu", "run", *machine, "--machine", wrong)
    assert refused.returncode == 1 and "`gravity` = -1" in refused.stderr


def test_the_loader_crane_is_what_its_script_writes():
    script = runpy.run_path(str(ROOT / "tests/oracle/hiab_xs031.py"))
    assert script["text"]() == (PARAMETERS / "hiab_xs031.json").read_text(), "python tests/oracle/hiab_xs031.py"


def edge_of(name, tmp_path):
    """Two places of the load chart, limited by a force: joint angles, payload, number of the actuator and name of the limit."""
    chart, picture = tmp_path / "chart.csv", tmp_path / "sheet.svg"
    done = call("hdrm-fmu", "machine", "draw", name, "--output", picture, "--csv", chart)
    assert done.returncode == 0 and "<svg" in picture.read_text()[:200], done.stderr
    rows = list(csv.DictReader(chart.open()))
    assert all(float(r["lasting_kg"]) <= float(r["payload_kg"]) for r in rows)
    places = [r for r in rows if r["limit"].startswith("force of ") and float(r["payload_kg"]) > 100]
    assert len(places) > 500
    for row in (places[len(places) // 5], places[4 * len(places) // 5]):
        zeta = [0, float(row["lift_rad"]), float(row["tilt_rad"]), 0, float(row["wrist_2_rad"]), 0]
        axis = ["slew", "lift", "tilt"].index(row["limit"].removeprefix("force of ")) + 1
        yield zeta, float(row["payload_kg"]), axis, row["limit"]


@pytest.mark.parametrize("name", ["reference", "hiab_xs031"])
def test_the_edge_of_the_load_chart_is_that_of_a_run(machine, tmp_path, name):
    """Held at 0.98 of the payload nothing is beyond its rating; at 1.05 the verdict names what the chart names."""
    for zeta, payload, axis, _ in edge_of(name, tmp_path):
        for share, is_beyond in [(0.98, False), (1.05, True)]:
            held = {"extends": name, "start": {"zeta": zeta}, "bodies": {"PL": {"mass": share * payload}}}
            file = write(tmp_path / "held.json", held)
            run = call("hdrm-fmu", "run", *machine, "--machine", file, "--stop-time", "0.5", "--quiet")
            assert run.returncode == 0, run.stderr
            forces = [line for line in run.stdout.splitlines() if "force of emla" in line]
            assert bool(forces) == is_beyond, run.stdout
            assert not is_beyond or any(f"force of emla_{axis}:" in line for line in forces), run.stdout


@pytest.mark.parametrize("name, com", [("reference", [0.0, 0.05, 0.04]), ("hiab_xs031", [0.05, 0.0, 0.0])])
def test_the_edge_of_the_load_chart_is_that_of_a_path(machine, tmp_path, name, com):
    """Half of the payload is there, the rest is picked up on a path, at the payload's centre of mass: up to 0.98 the path is let through and
    its run holds; at 1.05 the check refuses it by the chart's limit, and without the check the run's verdict names the same."""
    modular = ["--mode", "modular", "--quiet", "--set", "controller.settle_time=0"]
    for zeta, payload, axis, limit in edge_of(name, tmp_path):
        half = {"extends": name, "start": {"zeta": zeta}, "bodies": {"PL": {"mass": 0.5 * payload}}}
        file = write(tmp_path / "half.json", half)

        def run(share, *options):
            load = {"mass": (share - 0.5) * payload, "com": com, "over": 1.5}
            points = [{"position": [0, 0, 0], "dwell": 2.0, "load": load}, {"position": [0, 0, 0.003]}]
            path = {"relative": True, "limits": {"speed": 0.01, "acceleration": 0.02, "jerk": 0.1}, "waypoints": points}
            path = write(tmp_path / "path.json", path)
            return call("hdrm-fmu", "run", *machine, "--machine", file, "--waypoints", path, *modular, *options)

        held = run(0.98)
        assert held.returncode == 0 and "verdict: good" in held.stdout, held.stdout + held.stderr
        refused = run(1.05)
        assert refused.returncode == 1 and "at waypoint 1" in refused.stderr and f"{limit} = " in refused.stderr, refused.stderr
        tried = run(1.05, "--set", "controller.path_check=false")
        assert tried.returncode == 0 and f"force of emla_{axis}: up to" in tried.stdout, tried.stdout + tried.stderr
