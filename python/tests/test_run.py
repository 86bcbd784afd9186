"""One run: the same numbers as the program's, units, errors before anything runs."""

import csv
import inspect
import json
import pickle
import subprocess
import sys

import numpy as np
import pandas
import pytest

import hdrm_fmu
from conftest import program
from hdrm_fmu import BadInput, RunFailed, System, plots, studies, systems

SHORT = {"stop_time": 0.3, "settings": {"settle_time": 0.1, "hdrm.inertia_scale": 1.2}}


@pytest.fixture(scope="module")
def short():
    return hdrm_fmu.run(trajectory="triangular", mode="modular", metrics=("tracking", "energy"), **SHORT)


def test_a_run_is_that_of_the_program_bit_for_bit(short, tmp_path):
    """The CSV has the shortest digits that read back as the same number."""
    file = tmp_path / "run.csv"
    options = ("--system", hdrm_fmu.systems()["Manipulator"], "--trajectory", "triangular", "--mode", "modular", "--inertia-scale", "1.2")
    options += ("--set", "settle_time=0.1", "--stop-time", "0.3", "--csv", file, "--quiet")
    done = subprocess.run([program(), "run", *map(str, options)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with file.open() as f:
        titles, *rows = csv.reader(f)
    columns = dict(zip(titles, np.array(rows, dtype=float).T))
    assert list(columns) == ["time", *short.data_vars]
    for name, column in columns.items():
        np.testing.assert_array_equal(short[name].to_numpy().view("u8"), column.view("u8"), err_msg=name)
    assert f"RMSE {1e3 * short.attrs['tip_rmse']:.4f} mm, max {1e3 * short.attrs['tip_max']:.4f} mm" in done.stdout


def test_units_descriptions_and_verdict_are_attributes(short):
    assert short["time"].attrs["units"] == "s"
    force = short["emla_2.F"]
    assert force.attrs["units"] == "N" and "force" in force.attrs["long_name"].lower()
    assert short.attrs["verdict"] in ("good", "BAD")
    strict = hdrm_fmu.run(max_error=1e-12, **SHORT)
    assert strict.attrs["verdict"] == "BAD" and "tip error" in strict.attrs["findings"]


def test_metrics_have_one_definition(short, tmp_path):
    """Oracle: NumPy on the signals. Sums of n squares in another order: n ε. Those of other importers' runs are these too."""
    moving = short.time.to_numpy() >= 0.1
    error = short["controller.tip_error_norm"].to_numpy()
    rmse = np.sqrt(np.mean(error[moving] ** 2))
    assert short.attrs["tip_rmse"] == pytest.approx(rmse, rel=300 * np.finfo(float).eps)
    assert short.attrs["tip_max"] == error[moving].max()
    again = hdrm_fmu.tip_error(short.time.to_numpy(), error, 0.1)
    assert all(short.attrs[name] == value for name, value in again.items())
    options = ("--system", str(hdrm_fmu.systems()["Manipulator"]), "--set", "settle_time=0.1", "--json", str(tmp_path / "run.json"))
    short[["controller.tip_error_norm"]].to_dataframe().to_csv(tmp_path / "run.csv")
    done = subprocess.run([program(), "evaluate", str(tmp_path / "run.csv"), *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "run.json").read_text())["metrics"] == again


def test_signals_interval_and_arrays():
    data = hdrm_fmu.run(signals=["hdrm.zeta", "*.F"], interval=0.05, stop_time=0.2)
    assert list(data.data_vars) == [f"hdrm.zeta[{k}]" for k in range(1, 7)] + [f"emla_{k}.F" for k in (1, 2, 3)]
    np.testing.assert_allclose(data.time, [0.0, 0.05, 0.1, 0.15, 0.2], rtol=1e-15)


def test_a_machine_of_ones_own_and_one_drawn_by_seed():
    machine = json.loads(hdrm_fmu.parameters()["reference_machine"].read_text())
    options = {"signals": ["emla_2.F"], "interval": 0.1, "stop_time": 0.1}
    assert all(name in hdrm_fmu.parameters() for name in ("hiab_xs031", "sized_machine")) and not any("schema" in n for n in hdrm_fmu.parameters())
    same = hdrm_fmu.run(machine=machine, **options)
    assert same.equals(hdrm_fmu.run(**options)) and same.equals(hdrm_fmu.run(machine="reference_machine", **options))
    one, again, other = (hdrm_fmu.run(world="real", seed=seed, **options)["emla_2.F"].to_numpy() for seed in (1, 1, 2))
    assert (one == again).all() and (one != other).any()
    machine["bodies"] = {}
    with pytest.raises(BadInput):
        hdrm_fmu.run(machine=machine, **options)


def test_a_machine_brings_its_gains_into_the_real_world():
    options = {"world": "real", "stop_time": 1.0, "signals": ["controller.tip_error_norm"]}
    own, reference = (hdrm_fmu.run(machine="hiab_xs031", settings={"controller.gamma": gamma}, **options) for gamma in (1000, 250))
    assert not own.equals(reference)
    for machine in ("hiab_xs031", {"extends": "hiab_xs031"}):
        assert hdrm_fmu.run(machine=machine, **options).equals(own)


def test_a_machine_with_other_gears_takes_the_gains_of_the_rule_as_in_the_program(tmp_path):
    """With the reference machine's gains it swings: 10.9 mm. A gain of one's own stays, and the rule's others fit it."""
    mine, file = {"extends": "reference", "emla": {"N_gear": 10}}, tmp_path / "mine.json"
    file.write_text(json.dumps(mine))
    options = {"trajectory": "triangular", "mode": "adaptive", "stop_time": 5.0, "signals": []}
    data = hdrm_fmu.run(machine=mine, **options)
    told = ["--set", "controller.trajectory=triangular", "--set", "controller.mode=adaptive", "--stop-time", "5"]
    command = [program(), "run", "--system", hdrm_fmu.systems()["Manipulator"], "--machine", file, *told]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert 0 < data.attrs["tip_rmse"] < 1e-4 and f"RMSE {1e3 * data.attrs['tip_rmse']:.4f} mm" in done.stdout
    (line,) = [line for line in data.attrs["findings"].splitlines() if "gains by the rule for the machine: " in line]
    assert line.rpartition("rule for ")[2].partition(": ")[2] in done.stdout and "K_f = " in line and "alpha = 0" in line
    own = hdrm_fmu.run(machine=mine, settings={"controller.K_f": 2.4e-4}, **options).attrs["findings"]
    assert "gains by the rule" in own and "K_f = " not in own and "K_v = " in own
    frame = pandas.DataFrame({"trajectory": ["triangular"], "mode": ["adaptive"]})
    assert hdrm_fmu.sweep(frame, machine=mine, stop_time=5.0, out=tmp_path / "sweep")["tip_rmse"].item() == data.attrs["tip_rmse"]
    with pytest.raises(BadInput, match="geometry.x0_2"):
        hdrm_fmu.run(machine={"extends": "reference", "geometry": {"x0_2": 1.2}}, **options)
    with pytest.raises(BadInput, match="no `controller.Lambda_position`"):
        hdrm_fmu.run(machine={"extends": "reference", "emla": {"N_gear": 80, "rho": 0.008}}, **options)


def test_a_machine_drawn_around_another_is_that_of_the_program(tmp_path):
    """`machine` and `seed` together: the same known error as a row of `table --world real --machine`."""
    options = ["--world", "real", "--machine", "hiab_xs031", "--seeds", "1", "--law", "modular", "--stop-time", "4.2", "--csv", tmp_path / "runs.csv"]
    command = [program(), "table", *options, "--system", hdrm_fmu.systems()["Real"]]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (row,) = [row for row in csv.DictReader((tmp_path / "runs.csv").open()) if row["trajectory"] == "cubic"]
    drawn = {"world": "real", "machine": "hiab_xs031", "mode": "modular", "stop_time": 4.2, "signals": [], "metrics": ("tracking",)}
    one, other = (hdrm_fmu.run(seed=seed, **drawn).attrs["known_rmse"] for seed in (1, 2))
    assert one == float(row["known rmse [m]"]) != other


def test_machines_have_the_names_of_the_program():
    options = {"signals": ["emla_2.F"], "interval": 0.1, "stop_time": 0.1}
    assert hdrm_fmu.run(machine="reference", **options).equals(hdrm_fmu.run(**options))
    assert hdrm_fmu.run(machine="sized", **options).equals(hdrm_fmu.run(machine="sized_machine", **options))


def test_a_failed_run_has_an_error_of_its_own_name():
    assert (RunFailed.__name__, RunFailed.__module__) == ("RunFailed", "hdrm_fmu")
    assert pickle.loads(pickle.dumps(RunFailed("why"))).args == ("why",)


def test_a_machine_that_extends_another_beside_its_file(tmp_path):
    (tmp_path / "base.json").write_text(json.dumps({"extends": "sized", "bodies": {"PL": {"mass": 80}}}))
    (tmp_path / "mine.json").write_text(json.dumps({"extends": "base.json"}))
    options = {"signals": ["emla_1.i_q", "emla_2.F"], "interval": 0.1, "stop_time": 0.1}
    mine, base, sized, usual = (
        hdrm_fmu.run(machine=machine, **options)
        for machine in (tmp_path / "mine.json", {"extends": "sized", "bodies": {"PL": {"mass": 80}}}, "sized_machine", None)
    )
    assert mine.equals(base) and not mine["emla_2.F"].equals(sized["emla_2.F"])
    assert not sized["emla_1.i_q"].equals(usual["emla_1.i_q"])  # the slew's motor is another one


def test_a_script_in_the_loop_makes_the_same_run():
    """Stepped one by one with the reference from outside, and the controller's commands passed on by the script."""
    manipulator = hdrm_fmu.systems()["Manipulator"]
    steps = 50
    whole = System(manipulator).run(signals=["hdrm.zeta", "emla_1.i_q"], stop_time=steps * 1e-3)
    with System(manipulator) as s:
        assert s.step(steps) == s.time == whole.time[-1]
        np.testing.assert_array_equal(s.get("hdrm.zeta"), [whole[f"hdrm.zeta[{k}]"][-1] for k in range(1, 7)])
        assert s.get(["emla_1.i_q"]) == {"emla_1.i_q": float(whole["emla_1.i_q"][-1])}
    wire = [f"controller.tau_wrist[{k}]" for k in (1, 2, 3)]
    looped = System(manipulator, disconnect=[f"hdrm.tau_wrist[{k}]" for k in (1, 2, 3)])
    with looped as s:
        for _ in range(steps):
            s.set("hdrm.tau_wrist", list(s.get(wire).values()))
            s.step()
        assert abs(s.get("hdrm.zeta") - [float(whole[f"hdrm.zeta[{k}]"][-1]) for k in range(1, 7)]).max() < 1e-6
        s.set("controller.Lambda_position", 7.5)
        assert s.get("controller.Lambda_position") == 7.5
        for name, value, reason in (
            ("controller.zeta[1]", 0.0, "`hdrm.zeta[1]` drives it"),
            ("hdrm.inertia_scale", 1.0, "it is fixed"),
            ("hdrm.tau_wrist", [1.0], "has 3 elements"),
            ("hdrm.tau_wrist[1]", float("inf"), "must be finite"),
        ):
            with pytest.raises(BadInput, match=reason.replace("[", r"\[")):
                s.set(name, value)
    with pytest.raises(RuntimeError, match="inside of"):
        looped.step()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"settings": {"hdrm.inertia_scael": 1.0}}, "did you mean `hdrm.inertia_scale`"),
        ({"settings": {"controler.mode": "pd"}}, "did you mean `controller.mode`"),
        ({"settings": {"inertia_scale": float("nan")}}, "must be finite"),
        ({"settings": {"inertia_scale": -1.0}}, "must be at least"),
        ({"settings": {"inertia_scale": "heavy"}}, "must be a number"),
        ({"settings": {"emla_1.F": 1.0}}, "cannot be set"),
        ({"mode": "adaptiv"}, "did you mean `adaptive`"),
        ({"world": "reel"}, "did you mean `real`"),
        ({"seed": 1}, "only the world `real`"),
        ({"signals": ["hdrm.zetta"]}, "did you mean `hdrm.zeta"),
        ({"signals": ["*.nothing"]}, "no signal matches"),
        ({"interval": 1.5e-3}, "multiple of the communication step"),
        ({"metrics": ("tracing",)}, "did you mean `tracking`"),
        ({"stop_time": float("nan")}, "must be finite"),
        ({"schedule": "gauss"}, "schedule"),
        ({"machine": "/nowhere.json"}, "cannot be read"),
        ({"machine": "refrence_machine"}, "come with the package: reference, sized, hiab_xs031"),
        ({"machine": 5}, "cannot be read"),
        ({"settings": ["pd"]}, "must be a dictionary"),
        ({"settings": {"mode": 77}}, "no item of `controller.mode` `77`"),
        ({"settings": {"inertia_scale": 1.1, "hdrm.inertia_scale": 1.2}}, "is given twice"),
        ({"signals": [5]}, "must be names or patterns"),
        ({"interval": "often"}, "must be a number of s"),
        ({"max_error": float("nan")}, "must be finite"),
        ({"metrics": "tracking"}, "must be a list"),
        ({"world": "real", "seed": float("nan")}, "must be a whole number"),
        ({"step": "fine"}, "must be a number of s"),
        ({"stop_tim": 1.0}, "there is no keyword `stop_tim`; did you mean `stop_time`"),
        ({"trajctory": "cubic"}, "did you mean `trajectory`"),
    ],
)
def test_bad_input_is_refused_with_the_nearest_name(options, reason):
    with pytest.raises(BadInput, match=reason.replace("[", r"\[").replace("*", r"\*")):
        hdrm_fmu.run(**options)


def test_what_is_public_is_typed_and_documented():
    public = [getattr(hdrm_fmu, name) for name in hdrm_fmu.__all__]
    public += [of for module in (plots, studies) for name, of in vars(module).items() if not name.startswith("_") and getattr(of, "__module__", "") == module.__name__]
    public += [getattr(System, name) for name in dir(System) if not name.startswith("_")]
    functions = [f.fget if isinstance(f, property) else f for f in public]
    functions = [f for f in functions if inspect.isfunction(f)]
    assert len(functions) > 20
    for function in functions:
        signature = inspect.signature(function)
        assert inspect.getdoc(function), function
        if function not in (System.get, System.port):  # have types for each kind of name
            untyped = [p.name for p in signature.parameters.values() if p.name != "self" and p.annotation is p.empty]
            assert not untyped and signature.return_annotation is not signature.empty, function


def test_what_an_fmu_refuses_is_an_exception_with_its_text():
    import pickle

    with pytest.raises(RunFailed, match="emla_1.*nowhere") as caught:
        hdrm_fmu.run(settings={"emla_1.machine_file": "/nowhere.json"}, stop_time=0.1)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    with pytest.raises(BadInput, match="cannot be read"):
        System("/nowhere.ssp").run()
    manipulator = hdrm_fmu.systems()["Manipulator"]
    for options, reason in (({"variant": "no.ssd"}, "holds no no.ssd"), ({"disconnect": ["hdrm.x"]}, "no connection"), ({"parameters": ["no.ssv"]}, "no.ssv")):
        with pytest.raises(BadInput, match=reason):
            System(manipulator, **options).run()


def test_instances_are_reset_and_used_again_without_a_trace():
    from hdrm_fmu import _native

    options = {"signals": ["emla_2.F", "hdrm.zeta"], "stop_time": 0.05}
    fresh = [hdrm_fmu.run(mode=mode, **options) for mode in ("pd", "adaptive")]
    _native.reuse_instances()
    assert _native.kept_instances() == 0
    for _ in range(2):
        for mode, expected in zip(("pd", "adaptive"), fresh):
            assert hdrm_fmu.run(mode=mode, **options).equals(expected)
        assert _native.kept_instances() == 5


def test_fmus_load_in_fmpy():
    from fmpy import simulate_fmu

    assert {"Emla", "Hdrm", "Controller", "Rig", "Sensors"} <= set(hdrm_fmu.fmus())
    result = simulate_fmu(str(hdrm_fmu.fmus()["Hdrm"]), stop_time=0.01, step_size=1e-3, output=["zeta[2]"])
    assert len(result) == 11


def test_the_demo_needs_no_rust(tmp_path):
    """With no program in PATH; its figures are pictures of some size."""
    done = subprocess.run(
        [sys.executable, "-m", "hdrm_fmu", "demo", "--out", str(tmp_path)], env={"PATH": str(tmp_path), "HOME": str(tmp_path)}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "verdict good" in done.stdout
    for name in ("tip.png", "energy.png"):
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG" and (tmp_path / name).stat().st_size > 20_000


def test_attributes_make_the_run_again():
    """A run with a machine of one's own, drawn by seed, from its attributes alone, bit for bit; none is a file that is gone."""
    machine = {"extends": "reference", "emla": {"N_gear": 7.5}}
    options = {"stop_time": 0.05, "signals": ["hdrm.x", "controller.tip_error"]}
    first = hdrm_fmu.run(world="real", seed=4, machine=machine, mode="adaptive_integral", settings={"settle_time": 0.01}, **options)
    about = first.attrs
    assert "/tmp" not in json.dumps(about) and len(about["hash"]) >= 32 and about["version"].startswith(hdrm_fmu.__version__)
    again = hdrm_fmu.run(world=about["world"], seed=about["seed"], machine=json.loads(about["machine"]), settings=json.loads(about["settings"]), **options)
    assert again.equals(first) and again.attrs["hash"] == about["hash"]
    other = hdrm_fmu.run(world="real", seed=5, machine=machine, mode="adaptive_integral", settings={"settle_time": 0.01}, **options)
    assert other.attrs["hash"] != about["hash"]


def test_a_machine_for_a_system_of_ones_own():
    options = {"stop_time": 0.05, "signals": ["hdrm.x"], "settings": {"settle_time": 0.0}}
    system = System(systems()["Manipulator"], step=1e-3)
    usual, sized = (hdrm_fmu.run(system=system, machine=machine, **options) for machine in (None, "sized"))
    assert not sized.equals(usual)
    assert sized.equals(hdrm_fmu.run(machine="sized", **options))
    with pytest.raises(BadInput, match="read a machine file"):
        hdrm_fmu.run(system=hdrm_fmu.fmus()["DcLink"], machine="sized", stop_time=0.01)


def test_help_names_every_keyword():
    for function in (hdrm_fmu.run, hdrm_fmu.sweep, System.run, System.check):
        shown = inspect.signature(function)
        assert {"settings", "signals", "interval", "stop_time", "max_error", "metrics"} <= shown.parameters.keys() and "options" not in shown.parameters
