"""A script in the loop: ports, saved states, recording, verdict, threads and processes."""

import os
import shutil
import subprocess
import sys
import threading
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

import hdrm_fmu
from hdrm_fmu import BadInput, RunFailed, System, WrongThread, systems

SIGNALS = ["controller.tip_error", "emla_2.F"]


@pytest.fixture
def still():
    """The manipulator, whose reference a script gives."""
    with System(systems()["Manipulator"], settings={"trajectory": "external"}, step=1e-3) as stepped:
        yield stepped
        stepped._is_judged = True


def test_ports_read_and_set_whole_values(still):
    place, force = still.port("controller.reference.position", np.ndarray), still.port("emla_2.F", float)
    start = still.get("controller.desired.position")
    assert place.shape == start.shape == (3,) and isinstance(force.get(), float)
    place.set(start + [0.0, 0.01, 0.0])
    still.step(500)
    assert np.array_equal(place.get(), start + [0.0, 0.01, 0.0]) and force.get() == still.get("emla_2.F") == still.get("emla_2.F", float)
    assert abs(still.get("hdrm.tip.position[2]") - start[1] - 0.01) < 0.01
    both = still.get(["emla_2.F", "hdrm.zeta"])
    assert both["emla_2.F"] == force.get() and np.array_equal(both["hdrm.zeta"], still.get("hdrm.zeta"))
    flat = still.port(["emla_2.F", "hdrm.zeta"]).get()
    assert np.array_equal(flat, [both["emla_2.F"], *both["hdrm.zeta"]])
    still.set({"controller.reference.position[1]": 1.25, "controller.reference.position[2]": 2})
    assert list(place.get()[:2]) == [1.25, 2.0]


def test_a_port_refuses_what_set_refuses(still):
    place = still.port("controller.reference.position")
    before = place.get()
    for wrong, reason in (([1.0, 2.0], "shape"), ([1.0, np.nan, 0.0], "finite"), ([1.0, "a", 0.0], "number"), ([[1.0, 2.0, 3.0]], "shape")):
        with pytest.raises(BadInput, match=reason):
            place.set(wrong)
    for name, reason in (("emla_2.F", "kind `output`"), ("hdrm.tau_wrist", "drives it"), ("controller.settle_time", "give it in settings")):
        with pytest.raises(BadInput, match=reason):
            still.port(name).set(0.5)
    for values in ({"controller.reference.position": before, "controller.reference.position[1]": 1.0}, {"emla_2.F": 1.0, "controller.reference.position": before + 1}):
        with pytest.raises(BadInput):
            still.set(values)
    with pytest.raises(BadInput, match="is no ndarray"):
        still.get("emla_2.F", np.ndarray)
    assert np.array_equal(place.get(), before)


def test_reset_and_saved_states_repeat_the_run_bit_for_bit(still):
    still.record(SIGNALS)
    force = still.port("emla_2.F")

    def go_on(count, target):
        still.set("controller.reference.position", target)
        still.step(count)
        return still.result()

    at = still.get("controller.desired.position")
    go_on(100, at + [0.0, 0.005, 0.0])
    state = still.save()
    one = go_on(100, at)
    still.restore(state)
    assert still.time == pytest.approx(0.1)
    other = go_on(100, at + [0.01, 0.0, 0.0])
    still.restore(state)
    again = go_on(100, at)
    assert again.equals(one) and not other.equals(one) and len(one.time) == 201
    still.reset()
    assert still.time == 0.0
    go_on(100, at + [0.0, 0.005, 0.0])
    assert go_on(100, at).equals(one) and force.get() == one["emla_2.F"][-1]
    with pytest.raises(RunFailed, match="saved before the reset"):
        still.restore(state)
    still.reset({"hdrm.payload.mass": 80.0})
    still.step(100)
    assert force.get() != one["emla_2.F"][100]


def test_what_is_recorded_is_what_run_returns():
    options = {"settings": {"settle_time": 0.02}, "signals": SIGNALS, "interval": 0.002}
    whole = hdrm_fmu.run(stop_time=0.1, step=1e-3, **options)
    with System(systems()["Manipulator"], settings=options["settings"], step=1e-3) as stepped:
        stepped.record(SIGNALS, interval=0.002)
        stepped.step(60)
        stepped.step(40)
        result = stepped.result()
    assert type(result) is type(whole) and result.equals(whole)
    same = ("tip_rmse", "tip_max", "motion_start", "verdict", "findings", "settings", "residual_peak", "simulated")
    assert {n: result.attrs[n] for n in same} == {n: whole.attrs[n] for n in same}
    error = whole["controller.tip_error"]
    assert error.dims == ("time", "controller.tip_error_1") and error.attrs["units"] == "m"
    assert np.array_equal(error[:, 1], whole["controller.tip_error[2]"])
    with pytest.raises(KeyError):
        whole["controller.tip"]


def test_a_bad_verdict_is_told():
    bad = {"K_f": 0.0, "settle_time": 0.1}
    with pytest.warns(UserWarning, match="BAD.*force of emla_2"), System(systems()["Manipulator"], settings=bad, step=1e-3) as stepped:
        stepped.step(1500)
    whole = hdrm_fmu.run(settings=bad, stop_time=1.5, signals=[])
    with System(systems()["Manipulator"], settings=bad, step=1e-3) as stepped:
        for _ in range(1500):
            stepped.step()
        assert stepped.result().attrs["findings"] == whole.attrs["findings"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with System(systems()["Manipulator"]) as stepped:
            stepped.step(300)


def test_a_script_that_sets_the_reference_drives_the_machine(still):
    still.step(10)
    assert "nothing drives controller.reference.position" in still.result().attrs["findings"] and still.result().attrs["verdict"] == "BAD"
    still.set("controller.reference.position", still.get("controller.desired.position"))
    still.step(10)
    assert still.result().attrs["verdict"] == "good"


def test_only_its_own_thread_and_process_step_a_system(still):
    force, raised = still.port("emla_2.F"), []

    def elsewhere():
        for call in (still.step, force.get, still.save, lambda: still.set("controller.reference.position[1]", 1.0)):
            with pytest.raises(WrongThread, match="another"):
                call()
            raised.append(call)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert len(raised) == 4
    before = force.get()
    if sys.platform == "linux":
        child = os.fork()
        if child == 0:
            code = 1
            try:
                still.step()
            except WrongThread as error:
                code = 0 if "forked" in str(error) else 2
            os._exit(code)
        assert os.waitpid(child, 0)[1] == 0
    assert force.get() == before and still.step() == pytest.approx(1e-3)


def test_linearization_has_the_poles_of_the_motor():
    """Oracle: at rest and without magnets the windings are two RL circuits, whose sampled poles are exp(−R h / L) and gains 1/R. RK4 misses a
    step's factor e^z by z⁵/120, 2e-11 here; the singular values that are left out are below 1e-6 of the largest."""
    r, l_d, l_q, h = 0.31, 1.7e-3, 2.3e-3, 1e-4
    with System(hdrm_fmu.fmus()["Emla"], settings={"x": 0.4, "alpha": 0.0, "R_s": r, "L_d": l_d, "L_q": l_q, "lambda_m": 1e-6}, step=h) as stepped:
        stepped._is_judged = True
        stepped.step(100)
        before, time = stepped.get("i_q"), stepped.time
        found = stepped.linearize(["v_d", "v_q"], ["i_d", "i_q"], horizon=60)
        assert (stepped.time, stepped.get("i_q")) == (time, before)
        with pytest.raises(BadInput, match="none of the inputs"):
            stepped.linearize(["v_d"], ["i_d"], delta={"v_q": 1.0})
    exact = [np.exp(-r * h / l_q), np.exp(-r * h / l_d)]
    assert found.dt == h and found.input_labels == ["Emla_v_d", "Emla_v_q"]
    np.testing.assert_allclose(sorted(found.poles().real), sorted(exact), rtol=1e-5)
    np.testing.assert_allclose(found.dcgain(), np.eye(2) / r, rtol=1e-4, atol=1e-4 / r)


MATRIX = """<fmiModelDescription fmiVersion="3.0" modelName="sizes" instantiationToken="t"><CoSimulation modelIdentifier="sizes"/><ModelVariables>
<Float64 name="x0" valueReference="3" causality="parameter" variability="fixed" start="1 2 3 4 5 6"><Dimension start="2"/><Dimension start="3"/></Float64>
<Float64 name="u" valueReference="4" causality="input" start="1 2 3 4 5 6"><Dimension start="2"/><Dimension start="3"/></Float64>
<Float64 name="x" valueReference="5" causality="output"><Dimension start="2"/><Dimension start="3"/></Float64>
</ModelVariables><ModelStructure><Output valueReference="5" dependencies=""/></ModelStructure></fmiModelDescription>"""


@pytest.mark.skipif(sys.platform != "linux" or not shutil.which("cc"), reason="a library for Linux, made by a C compiler")
def test_matrices_are_whole(tmp_path):
    """x' = u for each element of matrices of 2 by 3."""
    source = (Path(__file__).parents[2] / "master/cosim/tests/fmus/sizes.c").read_text()
    (tmp_path / "sizes.c").write_text(source.replace("s->n = 3;", "s->n = 6;"))
    subprocess.run(["cc", "-shared", "-fPIC", "-w", "-o", tmp_path / "sizes.so", tmp_path / "sizes.c"], check=True)
    with zipfile.ZipFile(tmp_path / "a.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", MATRIX)
        archive.write(tmp_path / "sizes.so", "binaries/x86_64-linux/sizes.so")
    system, start, rates = System(tmp_path / "a.fmu", step=0.5), 10.0 * np.arange(1.0, 7.0).reshape(2, 3), np.array([[1.5, 0.0, -2.0], [4.0, 5.0, 0.25]])
    run = system.run(signals=["x"], settings={"u": rates}, stop_time=1.0)
    assert run["a.x"].shape == (3, 2, 3) and np.array_equal(run["a.x"][2], start + rates)
    with system as stepped:
        stepped.set("u", rates)
        stepped.step(2)
        assert np.array_equal(stepped.get("x"), start + rates) and np.array_equal(stepped.get("u"), rates)
        stepped.set("u[2,1]", 7.0)
        assert stepped.get("u")[1, 0] == 7.0
        with pytest.raises(BadInput, match="shape"):
            stepped.set("u", rates.T)
