"""Other systems than the manipulator, and inputs over time: the same numbers and the same errors as `cosim run`."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import numpy as np
import pandas
import pytest

import hdrm_fmu
from conftest import program
from hdrm_fmu import BadInput, RunFailed, System

TIMES = [0.0, 0.004, 0.01]
#: One actuator whose rod is held, under a voltage that rises and falls.
INPUTS = pandas.DataFrame({"Emla.v_q": [0.0, 8.0, 3.0], "Emla.x": [0.4, 0.4, 0.4]}, index=TIMES)


def cosim(tmp_path, *arguments):
    """Columns of the CSV of `cosim run`, and what it prints."""
    found = os.environ.get("COSIM", str(Path(program()).with_name("cosim")))
    assert os.access(found, os.X_OK), f"{found}: build it by `cargo build --release --bin cosim`, or name it in COSIM"
    out = tmp_path / "out.csv"
    done = subprocess.run([found, "run", *map(str, arguments), "--csv", str(out), "--quiet"], capture_output=True, text=True)
    if done.returncode:
        return None, done.stderr
    with out.open() as f:
        titles, *rows = csv.reader(f)
    return dict(zip(titles, np.array(rows, dtype=float).T)), done.stdout


def as_file(tmp_path, inputs=INPUTS):
    path = tmp_path / "in.csv"
    inputs.to_csv(path, index_label="time")
    return path


def equal(run, columns):
    assert list(columns) == ["time", *run.data_vars]
    for name, column in columns.items():
        np.testing.assert_array_equal(run[name].to_numpy().view("u8"), column.view("u8"), err_msg=name)


def test_an_fmu_alone_is_that_of_cosim_bit_for_bit(tmp_path):
    emla = hdrm_fmu.fmus()["Emla"]
    run = hdrm_fmu.run(system=emla, inputs=INPUTS, stop_time=0.01, step=5e-4, settings={"alpha": 0.2}, signals=["Emla.*"])
    options = ("--stop-time", 0.01, "--step", 5e-4, "--set", "alpha=0.2", "--signals", "Emla.*")
    columns, printed = cosim(tmp_path, emla, "--input", as_file(tmp_path), *options)
    equal(run, columns)
    assert run["Emla.F"].attrs["units"] == "N" and np.ptp(run["Emla.F"].to_numpy()) > 1.0
    held = hdrm_fmu.run(system=emla, stop_time=0.01, step=5e-4, settings={"alpha": 0.2}, signals=["Emla.*"])
    assert not held.equals(run), "the inputs count"
    findings = [line.strip() for line in printed.splitlines() if line.strip().startswith("- ")]
    assert findings[0].split(":")[0] in run.attrs["findings"]


def test_several_fmus_without_a_structure(tmp_path):
    fmus = hdrm_fmu.fmus()
    files, connections = [fmus["Hdrm"], fmus["Emla"]], ["Hdrm.x[1]=Emla.x", "Hdrm.x_dot[1]=Emla.x_dot", "Emla.F=Hdrm.f[1]"]
    run = hdrm_fmu.run(system=System(files, connect=connections), stop_time=0.01, signals=["*.F", "Hdrm.x[1]"])
    connect = [option for text in connections for option in ("--connect", text)]
    equal(run, cosim(tmp_path, *files, *connect, "--stop-time", 0.01, "--signals", "*.F,Hdrm.x[1]")[0])
    assert (run["Emla.F"] != run["Emla.F"][0]).any()
    with pytest.raises(BadInput, match="this input is driven already"):
        System(files, connect=[*connections, "Hdrm.x[2]=Emla.x"]).variables


def test_one_fmu_runs_twice_from_a_start_time(tmp_path):
    link = hdrm_fmu.fmus()["DcLink"]
    twice = System({"a=b": link, "c": link}, start_time=2.0, tolerance=1e-6, settings={"a=b.T_ambient": 300.0})
    run = twice.run(stop_time=2.01, signals=["c.v_dc", "a=b.v_dc", "a=b.T_ambient"])
    options = ("--start-time", 2, "--stop-time", 2.01, "--tolerance", 1e-6, "--set", "a=b.T_ambient=300")
    named = (f"a=b={link}", f"c={link}", "--signals", "c.v_dc,a=b.v_dc,a=b.T_ambient")
    equal(run, cosim(tmp_path, *named, *options)[0])
    assert run.time[0] == 2.0 and (run["a=b.T_ambient"] == 300.0).all()
    with twice as stepped:
        stepped.step()
        assert stepped.time == 2.0 + twice.step_size
    for wrong, reason in (({"tolerance": -1.0}, "tolerance"), ({"start_time": "now"}, "start_time")):
        with pytest.raises(BadInput, match=reason):
            System(link, **wrong).run(stop_time=0.01)


def test_a_whole_run_is_the_input_of_another():
    """What the controller puts out drives an actuator that stands alone."""
    whole = hdrm_fmu.run(stop_time=0.05, signals=["controller.v_q", "hdrm.x", "hdrm.x_dot"])
    names = {"controller.v_q[2]": "Emla.v_q", "hdrm.x[2]": "Emla.x", "hdrm.x_dot[2]": "Emla.x_dot"}
    frame = whole.to_dataframe()[list(names)].rename(columns=names)
    options = {"system": hdrm_fmu.fmus()["Emla"], "stop_time": 0.05, "signals": ["Emla.x", "Emla.v_q", "Emla.F"]}
    run = hdrm_fmu.run(inputs=frame, **options)
    for there, here in names.items():
        if here in run:
            np.testing.assert_array_equal(run[here], whole[there])
    assert hdrm_fmu.run(inputs=whole[list(names)].rename(names), **options).equals(run)
    frame["Emla.x"] *= 1000.0
    frame.attrs["units"] = {"Emla.x": "mm"}
    np.testing.assert_allclose(hdrm_fmu.run(inputs=frame, **options)["Emla.x"], run["Emla.x"], rtol=1e-15)


def test_faults_and_scenarios_are_those_of_cosim(tmp_path):
    manipulator = hdrm_fmu.systems()["Manipulator"]
    options = {"settings": {"settle_time": 0.01}, "stop_time": 0.1, "signals": ["hdrm.x", "emla_2.x"]}
    set_there = ("--set", "controller.settle_time=0.01", "--stop-time", 0.1, "--signals", "hdrm.x[*],emla_2.x")
    faults = ["emla_2.x=bias:1e-5@0.02..0.05", "emla_1.v_q=noise:0.5"]
    run = hdrm_fmu.run(system=System(manipulator, faults=faults, fault_seed=7), **options)
    columns, _ = cosim(tmp_path, manipulator, "--fault", faults[0], "--fault", faults[1], "--seed", 7, "--step", 1e-3, *set_there)
    equal(run[[name for name in columns if name != "time"]], columns)
    usual = hdrm_fmu.run(system=manipulator, **options)
    assert not run.equals(usual) and "emla_2.x" in run.attrs["findings"]
    scenario = tmp_path / "scenario.json"
    event = {"time": 0.03, "model": "emla_2", "variable": "v_q", "action": "bias", "value": 20.0}
    scenario.write_text(json.dumps({"events": [event], "end": 0.1}))
    run = hdrm_fmu.run(system=System(manipulator, scenario=scenario), **options)
    columns, _ = cosim(tmp_path, manipulator, "--scenario", scenario, "--step", 1e-3, *set_there)
    equal(run[[name for name in columns if name != "time"]], columns)
    assert not run.equals(usual)
    for wrong, reason in (({"faults": "emla_2.x=bend:2"}, "bend"), ({"faults": ["emla_9.x=freeze"]}, "emla_9"), ({"scenario": "/no.json"}, "no.json")):
        with pytest.raises(BadInput, match=reason):
            System(manipulator, **wrong).run(stop_time=0.01)


NUMBERS = """<fmiModelDescription fmiVersion="2.0" modelName="numbers" guid="g"><CoSimulation modelIdentifier="numbers"/><ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="at" valueReference="2" causality="parameter" variability="fixed"><Real start="1e9"/></ScalarVariable>
<ScalarVariable name="kind" valueReference="3" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable></ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure></fmiModelDescription>"""


@pytest.mark.skipif(sys.platform != "linux" or not shutil.which("cc"), reason="a library for Linux, made by a C compiler")
def test_numbers_that_are_not_finite(tmp_path):
    """Through a wire they end the run, in an output that nothing reads they spoil it, allowed ones pass."""
    source = Path(__file__).parents[2] / "master/cosim/tests/fmus/numbers.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", tmp_path / "numbers.so", source, "-lm"], check=True)
    files = [tmp_path / "a.fmu", tmp_path / "b.fmu"]
    for file in files:
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("modelDescription.xml", NUMBERS)
            archive.write(tmp_path / "numbers.so", "binaries/linux64/numbers.so")

    def run(connect=(), settings=None, **options):
        return System(files, connect=connect, step=0.1, **options).run(settings=settings, stop_time=1.0, signals=["b.u"])

    wrong = {"a.at": 0.42, "a.kind": 1}
    with pytest.raises(RunFailed, match="`a.y` became NaN at t = 0.5 s"):
        run(["a.y=b.u"], wrong)
    spoilt = run((), wrong)
    assert spoilt.attrs["verdict"] == "BAD" and "`a.y` became NaN at t = 0.5 s" in spoilt.attrs["findings"]
    assert run(["a.y=b.u"], wrong, allow_nonfinite=["a.y", "b.y"]).attrs["verdict"] == "good"
    assert np.isnan(run(["a.y=b.u"], wrong, allow_nonfinite="a.*")["b.u"][-1])
    with pytest.raises(BadInput, match="must be finite"):
        run((), {"a.u": np.nan})
    with pytest.raises(RunFailed, match="`a.u` = nan: it must be a finite number"):
        run((), {"a.u": np.nan}, allow_nonfinite=["b.*"])
    assert np.isinf(run((), {"b.u": np.inf}, allow_nonfinite=["b.u"])["b.u"][0])
    with pytest.raises(BadInput, match="no variable of type Real matches `c.y`"):
        run(allow_nonfinite=["c.y"])


SIZES = """<fmiModelDescription fmiVersion="3.0" modelName="sizes" instantiationToken="t"><CoSimulation modelIdentifier="sizes"/><ModelVariables>
<UInt64 name="n" valueReference="1" causality="structuralParameter" start="3" min="0" max="8"/>
<Float64 name="x0" valueReference="3" causality="parameter" variability="fixed" start="10 20 30"><Dimension valueReference="1"/></Float64>
<Float64 name="u" valueReference="4" causality="input" start="1 2 3"><Dimension valueReference="1"/></Float64>
<Float64 name="x" valueReference="5" causality="output"><Dimension valueReference="1"/></Float64>
</ModelVariables><ModelStructure><Output valueReference="5" dependencies=""/></ModelStructure></fmiModelDescription>"""


@pytest.mark.skipif(sys.platform != "linux" or not shutil.which("cc"), reason="a library for Linux, made by a C compiler")
def test_structural_parameters_change_the_sizes_of_arrays(tmp_path):
    """x' = u for each element: in closed form, with wires of other sizes than the FMU declares; a session takes the sizes of its settings."""
    source = Path(__file__).parents[2] / "master/cosim/tests/fmus/sizes.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-w", "-o", tmp_path / "sizes.so", source], check=True)
    files = [tmp_path / "a.fmu", tmp_path / "b.fmu"]
    for file in files:
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("modelDescription.xml", SIZES)
            archive.write(tmp_path / "sizes.so", "binaries/x86_64-linux/sizes.so")
    system = System(files, connect=["a.x=b.u"], step=0.5)
    for n in (5, 2):
        sizes = {"a.n": n, "b.n": n}
        run = system.run(settings={**sizes, "a.u": np.arange(n) + 2.0, f"a.x0[{n}]": 0.0}, signals=["a.x", "b.x"], stop_time=1.0)
        assert len(run.data_vars) == 2 * n
        for k in range(n):
            u, x0 = k + 2.0, 10.0 * (k + 1.0) * (k + 1 < n)
            assert run[f"a.x[{k + 1}]"].values.tolist() == [x0, x0 + u / 2, x0 + u]
            assert float(run[f"b.x[{k + 1}]"][-1]) == 10.0 * (k + 1.0) + x0 + u / 4
    assert system._key({"a.n": 4, "b.n": 4}, 1.0) != system._key({"a.n": 5, "b.n": 5}, 1.0)
    with System(files[0], settings={"n": 6}, step=0.5) as running:
        running.step()
        assert running.get("x").tolist() == [10.5, 21.0, 31.5, 42.0, 52.5, 63.0]
        with pytest.raises(BadInput, match="`a.n` cannot be set during a run: sizes of arrays depend on it"):
            running.set("n", 3)
    with pytest.raises(BadInput, match="`a.n` = 9 must be at most 8"):
        system.run(settings={"a.n": 9})
    with pytest.raises(BadInput, match="`a.x` has 5 elements, and `b.u` has 3"):
        system.run(settings={"a.n": 5}, stop_time=1.0)
    with pytest.raises(BadInput, match=r"`a.x0\[4\]`"):
        system.run(settings={"a.x0[4]": 1.0}, stop_time=1.0)


def test_a_reference_from_outside_moves_the_manipulator():
    start = hdrm_fmu.run(stop_time=1e-3, signals=["controller.desired.position"]).isel(time=0)
    position = [float(start[f"controller.desired.position[{k}]"]) for k in (1, 2, 3)]
    rows = {f"controller.reference.position[{k}]": [x, x + (0.02 if k == 2 else 0.0)] for k, x in zip((1, 2, 3), position)}
    inputs = pandas.DataFrame(rows, index=[0.0, 0.5])
    run = hdrm_fmu.run(trajectory="external", inputs=inputs, stop_time=0.5, signals=["hdrm.tip.position"])
    assert "reference.position" not in run.attrs["findings"], "the inputs drive it"
    still = hdrm_fmu.run(trajectory="external", stop_time=0.01)
    assert still.attrs["verdict"] == "BAD" and "nothing drives controller.reference.position" in still.attrs["findings"]
    risen = run["hdrm.tip.position[2]"]
    assert 0.015 < float(risen[-1] - risen[0]) < 0.025


NESTED = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="Outer">
  <ssd:System name="Outer">
    <ssd:Connectors>
      <ssd:Connector name="push" kind="input"><ssc:Real unit="V"/></ssd:Connector>
      <ssd:Connector name="force" kind="output"><ssc:Real unit="N"/></ssd:Connector>
    </ssd:Connectors>
    <ssd:Elements>
      <ssd:System name="drive">
        <ssd:Connectors>
          <ssd:Connector name="v" kind="input"><ssc:Real unit="V"/></ssd:Connector>
          <ssd:Connector name="F" kind="output"><ssc:Real unit="N"/></ssd:Connector>
        </ssd:Connectors>
        <ssd:Elements>
          <ssd:Component name="emla" source="Emla.fmu">
            <ssd:Connectors>
              <ssd:Connector name="v_q" kind="input"><ssc:Real unit="V"/></ssd:Connector>
              <ssd:Connector name="F" kind="output"><ssc:Real unit="N"/></ssd:Connector>
            </ssd:Connectors>
          </ssd:Component>
        </ssd:Elements>
        <ssd:Connections>
          <ssd:Connection startConnector="v" endElement="emla" endConnector="v_q"/>
          <ssd:Connection startElement="emla" startConnector="F" endConnector="F"/>
        </ssd:Connections>
      </ssd:System>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startConnector="push" endElement="drive" endConnector="v"/>
      <ssd:Connection startElement="drive" startConnector="F" endConnector="force"/>
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
"""


def test_nested_systems_and_connectors_of_the_outer_one(tmp_path):
    path = tmp_path / "outer.ssd"
    path.write_text(NESTED)
    inputs = pandas.DataFrame({"push": [0.0, 8.0]}, index=[0.0, 0.01])
    run = hdrm_fmu.run(system=path, inputs=inputs, settings={"alpha": 0.2, "drive.emla.x": 0.4}, stop_time=0.01, signals=["force", "v_q"])
    alone = {"Emla.v_q": [0.0, 8.0]}
    other = hdrm_fmu.run(
        system=hdrm_fmu.fmus()["Emla"],
        inputs=pandas.DataFrame(alone, index=[0.0, 0.01]),
        settings={"alpha": 0.2, "x": 0.4},
        stop_time=0.01,
        signals=["F", "v_q"],
    )
    np.testing.assert_array_equal(run["drive.emla.F"], other["Emla.F"])
    np.testing.assert_array_equal(run["drive.emla.v_q"], other["Emla.v_q"])
    constant = hdrm_fmu.run(system=path, settings={"push": 8.0}, stop_time=0.01, signals=["drive.emla.v_q"])
    assert (constant["drive.emla.v_q"] == 8.0).all()


def test_the_step_is_that_of_the_system_where_none_is_given(tmp_path):
    path = tmp_path / "stepped.ssd"
    osp = """<ssd:DefaultExperiment><ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm
        xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations"><osp:FixedStepAlgorithm baseStepSize="0.002"/></osp:Algorithm>
        </ssc:Annotation></ssd:Annotations></ssd:DefaultExperiment></ssd:SystemStructureDescription>"""
    path.write_text(NESTED.replace("</ssd:SystemStructureDescription>", osp))
    run = hdrm_fmu.run(system=path, stop_time=0.01)
    assert (len(run.time), run.attrs["step"], System(path).step_size) == (6, 0.002, 0.002)
    assert "communication step is 0.002 s, as the system structure asks" in run.attrs["findings"]
    assert hdrm_fmu.run(system=path, step=1e-3, stop_time=0.01).attrs["step"] == 1e-3
    for name in hdrm_fmu.systems():
        assert System(hdrm_fmu.systems()[name]).step_size == 1e-3, name


@pytest.mark.parametrize(
    ("inputs", "reason"),
    [
        ({"Emla.v_qq": [0.0, 8.0, 3.0]}, "column `Emla.v_qq`: `Emla.v_qq`; did you mean `Emla.v_q`"),
        ({"Emla.F": [0.0, 8.0, 3.0]}, "column `Emla.F`: `Emla.F` is no input that takes numbers; it is of type Real, output"),
        ({"Emla.v_q": [0.0, float("nan"), 3.0]}, "column `Emla.v_q`: at 0.004 s `NaN` is not a number from -10000 to 10000"),
        ({"Emla.v_q": [0.0, "much", 3.0]}, "column `Emla.v_q` must hold numbers: could not convert string to float: 'much'"),
        ({"Emla.v_q": [0.0, 8.0, 3.0], "v_q": [0.0, 8.0, 3.0]}, "column `v_q`: the column `Emla.v_q` gives this input, too"),
    ],
)
def test_wrong_inputs_are_refused_as_cosim_refuses_them(tmp_path, inputs, reason):
    emla, frame = hdrm_fmu.fmus()["Emla"], pandas.DataFrame(inputs, index=TIMES)
    with pytest.raises(BadInput) as refused:
        hdrm_fmu.run(system=emla, inputs=frame, stop_time=0.01)
    assert reason in str(refused.value)
    _, error = cosim(tmp_path, emla, "--input", as_file(tmp_path, frame), "--stop-time", 0.01)
    column = reason.partition(":")[0]
    assert error and ("column" not in column or column.removesuffix(" must hold numbers") in error)


def test_wrong_tables_of_inputs_are_refused():
    emla = hdrm_fmu.fmus()["Emla"]
    backwards = INPUTS.set_axis([0.0, 0.01, 0.004])
    twice = pandas.DataFrame([[1.0, 2.0]], columns=["Emla.v_q", "Emla.v_q"], index=[0.0])
    for inputs, reason in (
        (backwards, "the time 0.004 s must not be less than the one before, 0.01 s"),
        (INPUTS.set_axis(pandas.to_datetime(["2026-01-01", "2026-01-02", "2026-01-03"])), "the index holds dates, such as 2026-01-01 00:00:00"),
        (INPUTS.set_axis(["now", "then", "later"]), "the index, which is time in s, must hold numbers"),
        (twice, "two columns are named `Emla.v_q`"),
        (INPUTS[:0], "the input table has no rows"),
        ({"Emla.v_q": 8.0}, "inputs must be a DataFrame with time \\(s\\) as index"),
    ):
        with pytest.raises(BadInput, match=reason):
            hdrm_fmu.run(system=emla, inputs=inputs, stop_time=0.01)
    driven = pandas.DataFrame({"emla_2.v_q": [0.0]}, index=[0.0])
    with pytest.raises(BadInput, match=r"column `emla_2.v_q`: the connection from `controller.v_q\[2\]` drives it"):
        hdrm_fmu.run(inputs=driven, stop_time=0.01)


@pytest.mark.parametrize("unit", ("s", "ms", "us", "ns"))
def test_differences_of_times_have_their_own_unit(unit):
    emla, options = hdrm_fmu.fmus()["Emla"], {"stop_time": 0.01, "step": 1e-3}
    index = pandas.to_timedelta(np.round(1e9 * np.asarray(TIMES)).astype("int64"), unit="ns").as_unit("ns")
    coarse = index.as_unit(unit) if unit != "s" else index
    same = hdrm_fmu.run(system=emla, inputs=INPUTS.set_axis(coarse), **options)
    assert same.equals(hdrm_fmu.run(system=emla, inputs=INPUTS.set_axis(coarse.total_seconds()), **options))
    assert float(same.time[-1]) == 0.01


def test_truth_values_and_items_may_be_words():
    emla, options = hdrm_fmu.fmus()["Emla"], {"stop_time": 0.01, "step": 1e-3}
    frame = INPUTS.assign(**{"Emla.enable": [True, False, True]})
    expected = hdrm_fmu.run(system=emla, inputs=frame, **options)
    for words in (["True", "False", "True"], ["true", "false", "true"], [1, 0, 1]):
        assert hdrm_fmu.run(system=emla, inputs=frame.assign(**{"Emla.enable": words}), **options).equals(expected)
    with pytest.raises(BadInput, match="column `Emla.enable` must hold numbers, or one of True, False, true, false"):
        hdrm_fmu.run(system=emla, inputs=frame.assign(**{"Emla.enable": ["on", "off", "on"]}), **options)


def test_what_belongs_to_another_system_is_refused(tmp_path):
    fmus = hdrm_fmu.fmus()
    for options, reason in (
        ({"seed": 1}, "seed = 1 is for the manipulator"),
        ({"world": "real"}, "world = 'real' is for the manipulator"),
        ({"trajectory": "cubic"}, "there is no parameter `trajectory`"),
        ({"max_error": 1e-3}, "max_error = 0.001 is about the tip of the manipulator"),
    ):
        with pytest.raises(BadInput, match=reason):
            hdrm_fmu.run(system=fmus["Emla"], stop_time=0.01, **options)
    with pytest.raises(BadInput, match="must be given to the `System`"):
        hdrm_fmu.run(system=System(fmus["Emla"]), step=1e-3)
    with pytest.raises(BadInput, match="schedule = 'gauss-seidel' must be given to the `System`"):
        hdrm_fmu.run(system=System(fmus["Emla"], schedule="jacobi"), schedule="gauss-seidel")
    with pytest.raises(BadInput, match="seed 3: it is for faults that draw random numbers"):
        System(fmus["Emla"], fault_seed=3).run(stop_time=0.01)
    for make, reason in (
        (lambda: System([fmus["Emla"], "machine.ssp"]), "several files must all be FMUs"),
        (lambda: System(fmus["Emla"], variant="pd.ssd"), "is for a system structure"),
        (lambda: System("a.ssd", connect=["a.y=b.u"]), "for FMUs without a structure"),
        (lambda: System([]), "no system is named"),
        (lambda: System(hdrm_fmu.systems()["Manipulator"], feedthrough=["hrdm"]).variables, "feedthrough `hrdm`"),
        (lambda: System(fmus["Emla"], feedthrough=["Emla"]).variables, "feedthrough `Emla`: its outputs declare"),
        (lambda: System(fmus["Emla"], interface={"hdrm": "me"}).variables, "interface hdrm=me: the system has no component of this name"),
        (lambda: System(fmus["Emla"], solver="stiff").variables, "solver `stiff`: only components of Model Exchange"),
    ):
        with pytest.raises(BadInput, match=reason):
            make()
    path = tmp_path / "outer.ssd"
    path.write_text(NESTED.replace('name="v_q" kind="input"', 'name="v_q" kind="input"/><ssd:Connector name="v_d" kind="input"'))
    hdrm_fmu.run(system=path, stop_time=0.01)
    with pytest.raises(RunFailed, match=r"--strict|strict.*drive.emla.v_d"):
        hdrm_fmu.run(system=System(path, strict=True), stop_time=0.01)
    with System(path, strict=True) as stepped:  # Its inputs are set by this script.
        stepped.step()


def test_the_interface_is_chosen_as_cosim_does(tmp_path):
    """A run, a script that steps it, and `cosim run` give the same numbers, which are not those of Co-Simulation."""
    path = hdrm_fmu.systems()["Manipulator"]
    chosen = {"interface": {"emla_*": "me"}, "solver": {"emla_2": "explicit"}}
    run = System(path, **chosen).run(stop_time=0.02, signals=["emla_2.F"])
    assert "emla_2 is integrated (Model Exchange, explicit)" in run.attrs["findings"]
    options = ["--interface", "emla_*=me", "--solver", "emla_2=explicit", "--signals", "emla_2.F"]
    expected, printed = cosim(tmp_path, "--system", path, "--stop-time", "0.02", *options)
    assert expected is not None, printed
    found = run["emla_2.F"].to_numpy()
    assert found.tolist() == expected["emla_2.F"].tolist()
    with System(path, **chosen) as stepped:
        stepped.step(20)
        assert stepped.get("emla_2.F") == found[-1]
    alone = System(hdrm_fmu.fmus()["Emla"], interface="me").run(stop_time=0.02)
    assert "Emla is integrated (Model Exchange)" in alone.attrs["findings"]


def test_components_live_in_processes_of_their_own(monkeypatch):
    """The same numbers, by a run and by a script that steps it; limits without a process are refused. The program of a process is on PATH."""
    monkeypatch.setenv("PATH", str(Path(program()).parent), prepend=os.pathsep)
    path, fmus = hdrm_fmu.systems()["Manipulator"], hdrm_fmu.fmus()
    plain = System(path).run(stop_time=0.02, signals=["emla_2.F"])["emla_2.F"].values.tolist()
    for isolate in ("all", ["emla_*", "hdrm"]):
        run = System(path, isolate=isolate, call_timeout=60.0, memory_limit="2GB").run(stop_time=0.02, signals=["emla_2.F"])
        assert run["emla_2.F"].values.tolist() == plain
    with System(path, isolate="emla_2") as stepped:
        stepped.step(20)
        assert stepped.get("emla_2.F") == plain[-1]
    for given, reason in (
        ({"isolate": "hdrm"}, "isolate hdrm: the system has no component of this name"),
        ({"call_timeout": 1.0}, "call.timeout is for components in processes of their own"),
        ({"isolate": "all", "memory_limit": "5"}, "memory.limit 5: it must be a size"),
        ({"prefer": "java"}, "prefer java: it must be library or wasm"),
    ):
        with pytest.raises(BadInput, match=reason):
            System(fmus["Emla"], **given).variables  # noqa: B018


def test_a_plant_with_names_of_its_own(tmp_path):
    """A mapping leads the structure's force to the mean force of the step, which is another number."""
    mapping = tmp_path / "own.ssm"
    mapping.write_text(
        '<ssm:ParameterMapping xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" version="1.0">'
        '<ssm:MappingEntry source="F" target="F_mean"/></ssm:ParameterMapping>'
    )
    manipulator, emla = hdrm_fmu.systems()["Manipulator"], hdrm_fmu.fmus()["Emla"]
    named = System(manipulator, replace={"emla_1": emla}, maps={"emla_1": mapping})
    options = {"settings": {"settle_time": 0.01}, "stop_time": 0.1, "signals": ["hdrm.x"]}
    run, usual = (s.run(**options) for s in (named, System(manipulator)))
    assert not run["hdrm.x[1]"].equals(usual["hdrm.x[1]"])


def test_a_run_that_fails_keeps_its_rows(tmp_path):
    """The rows that `cosim` keeps too, and that a run without the failure has until then."""
    manipulator, fault = hdrm_fmu.systems()["Manipulator"], "emla_1.v_q=bias:1e6@0.0205..1"
    system, options = System(manipulator, faults=[fault]), {"interval": 2e-3, "signals": ["emla_1.v_q", "emla_1.F"]}
    with pytest.raises(RunFailed) as caught:
        system.run(stop_time=0.1, **options)
    result, last = caught.value.result, caught.value.time
    assert result.attrs["verdict"] == "BAD" and str(caught.value).splitlines()[0] in result.attrs["findings"]
    assert last == float(result["time"][-1]) == result.attrs["simulated"] == 0.02
    until = hdrm_fmu.run(system=manipulator, stop_time=last, **options)
    np.testing.assert_array_equal(result["emla_1.F"], until["emla_1.F"])
    found = os.environ.get("COSIM", str(Path(program()).with_name("cosim")))
    out = tmp_path / "out.csv"
    written = ("--signals", "emla_1.v_q,emla_1.F", "--csv", out, "--interval", "2e-3", "--step", "1e-3", "--fault", fault)
    arguments = (found, "run", "--quiet", manipulator, "--stop-time", "0.1", *written)
    assert subprocess.run([str(a) for a in arguments], capture_output=True).returncode == 1
    np.testing.assert_array_equal(pandas.read_csv(out)["emla_1.F"], result["emla_1.F"])
    emla = hdrm_fmu.fmus()["Emla"]
    with pytest.raises(RunFailed) as caught:
        hdrm_fmu.run(system=emla, settings={"machine_file": "nowhere.json"}, stop_time=0.01)
    assert caught.value.result is None and caught.value.time is None


def interrupted_after(seconds, call):
    """Computing time that Ctrl-C takes to end a call, s; also where a shell has started the tests with Ctrl-C ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.process_time()
    with pytest.raises(KeyboardInterrupt):
        call()
    signal.signal(signal.SIGINT, before)
    return time.process_time() - start - seconds


def test_ctrl_c_ends_runs_and_steps():
    manipulator = hdrm_fmu.systems()["Manipulator"]
    assert interrupted_after(1.0, lambda: hdrm_fmu.run(stop_time=1e4, settings={"trajectory": "external"})) < 0.5
    with System(manipulator, settings={"trajectory": "external"}) as running:
        assert interrupted_after(0.5, lambda: running.step(10**7)) < 0.5
        now = running.time
        assert now > 0.0 and running.step() == pytest.approx(now + 1e-3, abs=1e-9)
