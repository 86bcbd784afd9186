"""The class `Machine` says what the program says, bit for bit; findings are data."""

import csv
import json
import subprocess

import numpy as np
import pytest

import hdrm_fmu
from conftest import program
from hdrm_fmu import BadInput, Machine, findings, systems

#: A machine that the trials refuse: its path asks for more than the motors' speed.
FAST = {"extends": "reference", "emla": {"N_gear": 10, "rho": 0.01}}


def said(*arguments, expected=0):
    done = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == expected, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def fast(tmp_path):
    return Machine(FAST).write(tmp_path / "fast.json")


def test_a_machine_is_what_its_file_holds(fast):
    machine = Machine(fast)
    assert machine == Machine(FAST) == Machine(machine) == Machine(machine.to_dict()) and machine != Machine()
    assert machine.name == "fast" and Machine("sized").name == "sized"
    assert json.loads(fast.read_text())["extends"] == "reference" and machine.to_dict()["emla"]["N_gear"] == 10
    with pytest.raises(BadInput, match=r"(?s)emla.r_s.*did you mean.*R_s.*bodies.T1.mass. = -1"):
        Machine({"extends": "reference", "emla": {"r_s": 0.1}, "bodies": {"T1": {"mass": -1}}})
    with pytest.raises(BadInput, match="nowhere.json.*reference, sized, hiab_xs031"):
        Machine("nowhere.json")


def test_check_finds_what_the_program_finds(fast):
    lines = said("machine", "check", fast, expected=1).splitlines()
    check = Machine(fast).check()
    notes = [line.removeprefix("note: ") for line in lines if line.startswith("note: ")]
    assert [f.text for f in check.findings if f.severity == "bad"] == [line for line in lines if not line.startswith("note: ")]
    assert [f.text for f in check.findings if f.severity == "note"] == notes and not check.ok
    assert any("motor speed" in f.text and f.subject == "emla_2" for f in check.findings if f.severity == "bad")
    trials = check.trials
    assert list(trials["world"]) == ["ideal", "ideal", "real", "real"] and list(trials["hook"]) == ["full", "empty"] * 2
    for trial, note in zip(trials.itertuples(), notes):
        assert f"RMSE {1e3 * trial.tip_rmse:.3f} mm, max {1e3 * trial.tip_max:.3f} mm" in note
    assert list(trials["is_verdict"]) == [True, False, True, True]


@pytest.mark.parametrize("machine", ["reference", "sized", "hiab_xs031"])
def test_shipped_machines_are_without_findings_at_rest(machine):
    """The parameter set of the real world belongs to the shipped machine, whose name must not be lost."""
    check = Machine(machine).check(trials=False)
    assert check.ok and check.trials.empty
    lines = said("machine", "check", machine, "--no-trials").splitlines()[:-1]
    assert [f"note: {f.text}" for f in check.findings] == lines


@pytest.mark.parametrize("world", ["ideal", "real"])
def test_gains_are_those_of_the_program(fast, world):
    gains = Machine(fast).gains(world)
    lines = said("machine", "gains", fast, "--world", world).splitlines()
    assert [(line.split()[0], float(line.split()[1])) for line in lines] == list(gains["value"].items())
    assert all(line.endswith(why) and f" {unit} " in line for line, why, unit in zip(lines, gains["why"], gains["unit"]))
    with pytest.raises(BadInput, match="world"):
        Machine().gains("bending")


def test_other_machines_are_those_of_the_program(tmp_path, fast):
    of = {"--machine": fast}
    options = [word for pair in of.items() for word in pair]
    said("machine", "scale", "--booms", "1.4", *options, "--output", tmp_path / "scaled.json")
    assert Machine(fast).scale(1.4) == Machine(tmp_path / "scaled.json") != Machine(fast)
    assert json.loads(Machine(fast).scale(1.4).write(tmp_path / "s.json").read_text())["extends"] == "reference"
    text = said("machine", "perturb", "--seed", "7", "--length", "0.002", *options, "--out", tmp_path / "drawn.json")
    drawn = Machine(fast).perturb(7, length=0.002)
    assert drawn.machine == Machine(tmp_path / "drawn.json")
    assert all(f"hdrm.gravity[{k}]={value}" in text for k, value in enumerate(drawn.settings["hdrm.gravity"], 1))
    for wrong in (0.0, -1.0, float("nan"), "big"):
        with pytest.raises(BadInput, match="booms"):
            Machine().scale(wrong)
    with pytest.raises(BadInput, match="seed"):
        Machine().perturb(1.5)


def test_the_load_chart_and_the_sheet_are_those_of_the_program(tmp_path):
    said("machine", "draw", "hiab_xs031", "--dynamic-factor", "1.1", "--output", tmp_path / "a.svg", "--csv", tmp_path / "chart.csv")
    machine = Machine("hiab_xs031")
    chart = machine.load_chart(1.1)
    with (tmp_path / "chart.csv").open() as file:
        titles, *rows = csv.reader(file)
    assert list(chart) == titles and len(chart) == len(rows) > 1000
    for name, column in zip(titles, zip(*rows)):
        assert list(chart[name]) == (list(column) if "limit" in name else [float(text) for text in column]), name
    assert chart["payload_kg"].max() > 100 and {"reach_m", "limit", "lasting_kg"} <= {*chart}
    drawn = machine.draw(tmp_path / "b.svg", 1.1)
    assert drawn.read_bytes() == (tmp_path / "a.svg").read_bytes()
    assert machine.draw(tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")
    for wrong, match in (({"path": tmp_path / "b.pdf"}, "svg"), ({"path": tmp_path / "b.svg", "dynamic_factor": 0}, "dynamic_factor")):
        with pytest.raises(BadInput, match=match):
            machine.draw(**wrong)


def test_sizing_is_that_of_the_program(tmp_path, fast):
    options = ("--system", systems()["Manipulator"], "--machine", fast, "--set", "trajectory=triangular", "--payload-step", "0")
    text = said("sizing", *options, "--json", tmp_path / "sizing.json")
    of_program = json.loads((tmp_path / "sizing.json").read_text())
    sizing = Machine(fast).sizing(settings={"trajectory": "triangular"}, payload_step=0)
    assert sizing.cases == of_program["sizing"] and len(sizing.cases["as set"]["axes"]) == 3
    assert sizing.verdict == of_program["verdict"] == "BAD" and [f.text for f in sizing.findings] == [text.replace(str(fast), "fast") for text in of_program["findings"]]
    assert all(str(f) in text.replace(str(fast), "fast") for f in sizing.findings) and any(f.severity == "bad" for f in sizing.findings)
    with pytest.raises(BadInput, match="trajectry"):
        Machine().sizing(settings={"trajectry": "cubic"})


def test_a_path_is_checked_as_the_program_does(tmp_path):
    machine = Machine("sized")
    said("path", "check", "iso9283-cube", "--machine", "sized", "--json", tmp_path / "good.json")
    found = machine.path_check("iso9283-cube")
    of_program = json.loads((tmp_path / "good.json").read_text())
    assert found.ok and found.findings == [] and found.duration == of_program["duration"] and list(found.motor_torque_rms) == of_program["motor_torque_rms"]
    for (name, row), known in zip(found.margins.iterrows(), of_program["margins"], strict=True):
        row = {**row, "quantity": name, "range": [row["min"], row["max"]]}
        assert {key: row[key] for key in known} == known
    beyond = machine.path_check([[3.0, 1.1, 0.0], [9.0, 1.1, 0.0]])
    assert not beyond.ok and beyond.findings[0].severity == "bad"
    with pytest.raises(BadInput, match="nowhere.csv"):
        machine.path_check("nowhere.csv")


def test_a_run_takes_a_machine():
    options = {"stop_time": 0.2, "signals": ["hdrm.zeta", "emla_2.F"]}
    first, second = (hdrm_fmu.run(machine=machine, **options) for machine in (Machine(FAST), FAST))
    assert first.attrs["hash"] == second.attrs["hash"]
    np.testing.assert_array_equal(first["emla_2.F"], second["emla_2.F"])


def test_findings_of_a_run_are_data(tmp_path):
    options = {"trajectory": "triangular", "settings": {"K_f": 5e-5, "settle_time": 0.2}, "stop_time": 3.0}
    run = hdrm_fmu.run(**options)
    words = ("--trajectory", "triangular", "--set", "controller.K_f=5e-5", "--set", "settle_time=0.2", "--stop-time", "3")
    printed = said("run", "--quiet", "--system", systems()["Manipulator"], *words)
    found = findings(run)
    assert [f"  {finding}" for finding in found] == printed[printed.index("verdict: BAD") :].splitlines()[1:]
    assert "\n".join(map(str, found)) == run.attrs["findings"]
    subjects = {finding.subject for finding in found if finding.severity == "bad"}
    assert "emla_2" in subjects and "emla_2.F" in subjects, subjects
    assert {finding.severity for finding in found} == {"bad", "note"}
    again = run.drop_vars(list(run.data_vars)).copy()
    again.to_netcdf(tmp_path / "run.nc", engine="scipy")
    import xarray

    with xarray.open_dataset(tmp_path / "run.nc", engine="scipy") as read:
        assert findings(read) == found
