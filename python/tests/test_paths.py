"""Your own paths: the program's run bit for bit, from a file or from points, in sweeps, and refused before the start."""

import csv
import json
import subprocess

import numpy as np
import pandas
import pytest

import hdrm_fmu
from conftest import program
from hdrm_fmu import BadInput, RunFailed, System, studies, sweep

#: Picked up at 1.6 s and set down at the end, some centimetres from where the tip starts.
PATH = {
    "relative": True,
    "limits": {"speed": 0.12, "acceleration": 0.8, "jerk": 8.0},
    "waypoints": [
        {"position": [0.0, 0.05, 0.0], "dwell": 0.4, "load": {"mass": 80, "com": [0.1, 0, 0], "over": 0.3}},
        {"position": [0.03, 0.05, 0.02], "blend": 0.01},
        {"position": [0.03, 0.0, 0.02], "dwell": 0.4, "load": {"mass": 0, "over": 0.3}},
    ],
}
QUICK = {"settings": {"settle_time": 0.1}}
FAR = {"relative": True, "waypoints": [{"position": [0.1, 0, 0]}, {"position": [3.0, 0, 0]}]}


@pytest.fixture
def path(tmp_path):
    (tmp_path / "lift.json").write_text(json.dumps(PATH))
    return tmp_path / "lift.json"


@pytest.mark.parametrize("world", ["ideal", "real"])
def test_a_run_on_a_path_is_that_of_the_program_bit_for_bit(world, path, tmp_path):
    ssp = {"ideal": ["--system", hdrm_fmu.systems()["Manipulator"]], "real": ["--system", hdrm_fmu.systems()["Real"], "--parameters", "resources/real.ssv"]}
    options = (*ssp[world], "--mode", "modular_integral", "--set", "settle_time=0.1", "--csv", tmp_path / "run.csv", "--quiet")
    done = subprocess.run([program(), "run", "--waypoints", path, *map(str, options)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "run.csv").open() as f:
        titles, *rows = csv.reader(f)
    run = hdrm_fmu.run(waypoints=path, world=world, mode="modular_integral", **QUICK)
    assert titles == ["time", *run.data_vars] and run.attrs["waypoints"] == str(path)
    for name, column in zip(titles, np.array(rows, dtype=float).T):
        np.testing.assert_array_equal(run[name].to_numpy().view("u8"), column.view("u8"), err_msg=name)
    assert f"RMSE {1e3 * run.attrs['tip_rmse']:.4f} mm, max {1e3 * run.attrs['tip_max']:.4f} mm" in done.stdout


def test_the_load_reaches_the_manipulator(path):
    run = hdrm_fmu.run(waypoints=path, signals=["hdrm.load.mass", "emla_2.F"], interval=0.1, **QUICK)
    mass = run["hdrm.load.mass"]
    assert mass[0] == mass[-1] == 0.0 and mass.max() == 80.0
    light = {**PATH, "waypoints": [{k: v for k, v in w.items() if k != "load"} for w in PATH["waypoints"]]}
    without = hdrm_fmu.run(waypoints=light, signals=["emla_2.F"], interval=0.1, **QUICK)
    # With the tip 4.1 m from the boom's joint and the actuator's lever below 0.9 m, 80 kg ask for more than 3 kN.
    assert abs(run["emla_2.F"] - without["emla_2.F"]).max() > 3e3


def test_a_path_is_a_file_what_is_in_it_a_table_or_positions(path, tmp_path):
    options = {"signals": ["emla_2.F", "hdrm.tip.position"], "stop_time": 0.5, **QUICK}
    assert hdrm_fmu.run(waypoints=path, **options).equals(hdrm_fmu.run(waypoints=PATH, **options))
    start = hdrm_fmu.run(signals=["hdrm.tip.position"], stop_time=1e-3)
    start = np.array([float(start[f"hdrm.tip.position[{k}]"][0]) for k in (1, 2, 3)])
    positions = start + [[0.0, 0.05, 0.0], [0.05, 0.05, 0.1 / 3.0]]
    table = pandas.DataFrame(positions, columns=["x", "y", "z"])
    table.to_csv(tmp_path / "points.csv", index=False)
    runs = [hdrm_fmu.run(waypoints=of, **options) for of in (positions, positions.tolist(), table, tmp_path / "points.csv")]
    assert all(run.equals(runs[0]) for run in runs) and not runs[0].equals(hdrm_fmu.run(waypoints=PATH, **options))
    lines, curve = (hdrm_fmu.run(waypoints=of, **{**options, "stop_time": None}).time[-1] for of in (table, table.assign(t=[0.0, 5.0])))
    assert lines + 1.0 < curve  # the samples' times count
    cube = hdrm_fmu.run(waypoints="iso9283-cube:1", **{**options, "stop_time": 3.0})
    assert cube.attrs["waypoints"] == "iso9283-cube:1" and float(abs(np.diff(cube["hdrm.tip.position[1]"])).max()) > 1e-5


def test_a_system_on_a_path_stepped_by_a_script(path):
    whole = System(hdrm_fmu.systems()["Manipulator"], waypoints=path, **QUICK).run(signals=["hdrm.load.mass"], stop_time=1.0)
    with System(hdrm_fmu.systems()["Manipulator"], waypoints=path, **QUICK) as s:
        s.step(1000)
        assert s.get("hdrm.load.mass") == float(whole["hdrm.load.mass"][-1]) > 0.0


def test_sweeps_over_paths_and_on_one(two_workers, path, tmp_path):
    """A column of paths, compared with the same path for all cases: the same rows, equal to runs; another file at the same place is another case."""
    quick = {**QUICK, "stop_time": 0.8, "client": two_workers, "progress": False}
    cases = pandas.DataFrame({"waypoints": [str(path), "iso9283-cube:1"], "hdrm.inertia_scale": [1.1, 0.9]})
    over = sweep(cases, out=tmp_path / "over", **quick)
    on = sweep(cases.iloc[:1, 1:], out=tmp_path / "on", waypoints=path, **quick)
    for row, scale in zip((*over.to_dict("records"), *on.to_dict("records")), (1.1, 0.9, 1.1)):
        run = hdrm_fmu.run(waypoints=row.get("waypoints", path), stop_time=0.8, settings={**QUICK["settings"], "hdrm.inertia_scale": scale}, signals=[])
        assert row["verdict"] == run.attrs["verdict"] and row["tip_rmse"] == run.attrs["tip_rmse"] > 0.0
    path.write_text(json.dumps({**PATH, "limits": {"speed": 0.05}}))
    again = sweep(cases, out=tmp_path / "over", **quick)
    assert again["key"][1] == over["key"][1] and again["key"][0] != over["key"][0] and again["tip_rmse"][0] != over["tip_rmse"][0]


def test_monte_carlo_on_a_path(two_workers, path, tmp_path):
    table = studies.monte_carlo([3], out=tmp_path / "mc", waypoints=path, stop_time=0.5, client=two_workers, progress=False, **QUICK)
    run = hdrm_fmu.run(world="real", seed=3, mode="adaptive_integral", waypoints=path, stop_time=0.5, signals=[], metrics=("tracking",), **QUICK)
    assert list(table.columns[:2]) == ["mode", "seed"] and table["known_rmse"][0] == run.attrs["known_rmse"] > 0.0
    assert len(studies.summary(table)) == 1


def test_a_path_that_only_some_cases_can_follow_is_a_failed_row(two_workers, path, tmp_path):
    heavy = {**PATH["waypoints"][0], "load": {"mass": 5000}}
    path.write_text(json.dumps({**PATH, "waypoints": [heavy, *PATH["waypoints"][1:]]}))
    cases = pandas.DataFrame({"waypoints": [str(path)] * 2, "controller.path_check": [True, False]})
    table = sweep(cases, out=tmp_path / "some", stop_time=0.2, client=two_workers, progress=False, **QUICK)
    assert list(table["verdict"] == "failed") == [True, False]
    assert f"path `{path}`" in table["error"][0] and "waypoint 1" in table["error"][0] and "force of lift" in table["error"][0]


@pytest.mark.parametrize(
    ("waypoints", "reason"),
    [
        ("/nowhere.csv", "path `/nowhere.csv` cannot be read: No such file or directory; the built-in paths are iso9283-cube"),
        ("iso9283-cube:many", "path `iso9283-cube:many`"),
        ({"waypoint": []}, "did you mean `waypoints`"),
        ({"waypoints": [{"position": [1, 2]}, {"position": [1, 2, 3]}]}, "waypoint 1: `position` = \\[1,2\\] must be a list of 3 numbers"),
        ({"waypoints": [{"position": [1, 2, float("nan")]}]}, "must hold what a path file in JSON holds"),
        ([[1.0, 2.0, 3.0], [1.0, float("nan"), 3.0]], "waypoint 2: `y` = left out must be given"),
        ([[1.0, 2.0], [1.0, 3.0]], "shape \\(2, 2\\); positions must have the shape \\(n, 3\\)"),
        ([[1.0, 2.0, 3.0]], "it must have at least two"),
        (pandas.DataFrame({"x": [1.0], "y": [1.0], "zz": [1.0]}), "did you mean `z`"),
        (5, "waypoints have the shape \\(\\)"),
        ("five", "cannot be read"),
        (object(), "must be a file, a dictionary, a DataFrame, or positions"),
    ],
)
def test_what_is_no_path_is_refused(waypoints, reason, tmp_path):
    with pytest.raises(BadInput, match=reason):
        hdrm_fmu.run(waypoints=waypoints)
    with pytest.raises(BadInput, match=reason):
        sweep(pandas.DataFrame({"mode": ["pd"]}), waypoints=waypoints, out=tmp_path / "x")
    assert not (tmp_path / "x").exists()


def test_what_the_machine_cannot_do_is_said_before_it_moves(tmp_path):
    """With the words of the program, which name the waypoint; a sweep of which no case can follow its path is not begun."""
    (tmp_path / "far.json").write_text(json.dumps(FAR))
    far = str(tmp_path / "far.json")
    arguments = [program(), "run", "--system", str(hdrm_fmu.systems()["Manipulator"]), "--waypoints", far, "--quiet"]
    said = subprocess.run(arguments, capture_output=True, text=True).stderr
    with pytest.raises(RunFailed) as caught:
        hdrm_fmu.run(waypoints=far)
    reason = f"path `{far}`: the machine cannot do this path: waypoint 2 is "
    assert reason in str(caught.value) and reason in said
    with pytest.raises(RunFailed, match="path `waypoints`: the machine cannot do this path: waypoint 2"):
        hdrm_fmu.run(waypoints=FAR)
    cases = pandas.DataFrame({"hdrm.inertia_scale": [1.0, 1.1]})
    for cases, options in ((cases, {"waypoints": far}), (cases.assign(waypoints=far), {})):
        with pytest.raises(BadInput, match="waypoint 2 is"):
            sweep(cases, out=tmp_path / "x", **options)
    assert not (tmp_path / "x").exists()


def test_what_else_says_where_the_tip_goes_is_refused(path, tmp_path):
    for options in ({"trajectory": "cubic"}, {"settings": {"path_file": "mine.json"}}):
        with pytest.raises(BadInput, match="is given together with waypoints"):
            hdrm_fmu.run(waypoints=path, **options)
    with pytest.raises(BadInput, match="`controller.trajectory` = cubic is given together with waypoints"):
        sweep(pandas.DataFrame({"trajectory": ["cubic"]}), waypoints=path, out=tmp_path / "x")
    with pytest.raises(BadInput, match="no component has the inputs `load.mass`"):
        System(hdrm_fmu.systems()["Testbed"], waypoints=path).run()
    with pytest.raises(BadInput, match="there is no keyword `waypoint`; did you mean `waypoints`"):
        hdrm_fmu.run(waypoint=path)
