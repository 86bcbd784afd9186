"""One FMU alone: reset, repeatability, folders, machine files, long runs that nobody controls."""

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from conftest import NAMES, WORLD
from fmu import Fmu

ROD = {"x": 0.31, "x_dot": 0.0, "F_hold": 12e3, "v_q": 17.0, "v_d": -3.0}
INPUTS = {"Emla": ROD, "Hdrm": {"f[2]": 41e3, "f[3]": 31e3, "tau_wrist[2]": 120.0}, "Controller": {"zeta[2]": 0.69}, "Rig": ROD}
INPUTS["Sensors"] = {"theta_m[2]": 3.0, "F[1]": 9e3, "current": True, "force": "sensor", "motor_encoder": True, "speed": "observer"}

INPUTS["DcLink"] = {"i_load[1]": 50.0, "i_load[3]": -5.0, "battery.soc_start": 0.97}


@pytest.fixture(params=(*NAMES, *WORLD))
def fmu(request, fmus):
    """Each of them in turn."""
    return fmus[f"{request.param}.fmu"]


def trajectory(instance, steps=200, h=1e-3, start=0.0):
    """Outputs after each step."""
    rows = [instance.outputs()]
    for k in range(steps):
        instance.step(start + k * h, h)
        rows.append(instance.outputs())
    return rows


def test_reset_gives_the_same_run(fmu):
    """After fmi2Reset an instance is as after fmi2Instantiate: defaults again, then the same run bit for bit."""
    inputs = INPUTS[fmu.identifier]
    instance = fmu.instance().start(0.0, inputs)
    first = trajectory(instance)
    instance.call("fmi2Reset")
    instance.start()
    for name in inputs:
        start = fmu.variables[name].start
        assert instance.get(name) == (start == "true" if start in ("true", "false") else float(start))
    instance.call("fmi2Reset")
    instance.start(0.0, inputs)
    assert trajectory(instance) == first
    instance.free()


def test_two_instances_run_alike_and_apart(fmu):
    """Interleaved with one that has other inputs, a run stays the same bit for bit."""
    inputs = INPUTS[fmu.identifier]
    alone = trajectory(fmu.instance().start(0.0, inputs), 50)
    one, other = fmu.instance().start(0.0, inputs), fmu.instance().start()
    rows = [one.outputs()]
    for k in range(50):
        other.step(k * 1e-3, 1e-3)
        one.step(k * 1e-3, 1e-3)
        rows.append(one.outputs())
    assert rows == alone
    assert other.outputs() != rows[-1]


def test_instances_in_threads(fmu):
    """Eight instances in four threads (ctypes gives up the interpreter's lock in each call): all as one alone."""
    alone = trajectory(fmu.instance().start(0.0, INPUTS[fmu.identifier]), 100)
    instances = [fmu.instance() for _ in range(8)]

    def run(instance):
        return trajectory(instance.start(0.0, INPUTS[fmu.identifier]), 100)

    with ThreadPoolExecutor(4) as pool:
        assert all(rows == alone for rows in pool.map(run, instances))


@pytest.mark.parametrize("fmu", ["Emla", "Hdrm", "Rig", "Sensors", "DcLink"], indirect=True)
def test_start_time_does_not_matter(fmu):
    """A plant started at t = 7.5 s moves as from 0 s (the controller's reference is bound to the time)."""
    early = trajectory(fmu.instance().start(0.0, INPUTS[fmu.identifier]), 20, 2**-10)
    late = trajectory(fmu.instance().start(7.5, INPUTS[fmu.identifier]), 20, 2**-10, start=7.5)
    assert early == late


@pytest.mark.parametrize("location", [None, "file:{}/resources", "file://localhost{}/resources/", "file:///nowhere", "nonsense"])
def test_resource_location(fmu, location):
    """The defaults are embedded: any or no resources folder gives the same run."""
    resources = location and location.format(fmu.folder)
    instance = fmu.instance(resources=resources).start(0.0, INPUTS[fmu.identifier])
    assert trajectory(instance, 5) == trajectory(fmu.instance().start(0.0, INPUTS[fmu.identifier]), 5)
    assert len(instance.messages) == (1 if location == "nonsense" else 0)
    instance.free()


def test_folder_with_spaces_and_letters(fmu_dir, hdrm, tmp_path):
    """An FMU and a machine file in a folder whose name is not plain ASCII, by absolute path and relative to the resources."""
    folder = tmp_path / "Größe 2 % #1 – 機械"
    folder.mkdir()
    fmu = Fmu(fmu_dir / "Hdrm.fmu", folder / "unpacked")
    text = Path(fmu.folder, "resources/reference_machine.json").read_text()
    Path(fmu.folder, "resources/leicht – é.json").write_text(with_payload(text, 12.5))
    unencoded = fmu.folder.replace("%", "%25")
    for resources in (Path(fmu.folder, "resources").as_uri(), f"file://{unencoded}/resources"):
        instance = fmu.instance(name="größe", resources=resources)
        instance.set({"machine_file": "leicht – é.json"})
        instance.start()
        assert instance.get("payload.mass") == 12.5
        assert instance.get("machine_file") == "leicht – é.json"
        instance.free()


def with_payload(text, mass):
    machine = json.loads(text)
    machine["bodies"]["PL"]["mass"] = mass
    return json.dumps(machine)


@pytest.fixture
def light_machine(hdrm, tmp_path):
    """The reference machine with another payload, stiffer viscous friction and another winding."""
    machine = json.loads(Path(hdrm.folder, "resources/reference_machine.json").read_text())
    machine["bodies"]["PL"]["mass"] = 123.0
    machine["joint_viscous"][1] = 77.0
    machine["emla"]["R_s"] = 0.31
    machine["controller"]["gamma"] = 61.0
    path = tmp_path / "light.json"
    path.write_text(json.dumps(machine))
    return str(path)


CHANGED = {"Emla": ("R_s", 0.31), "Rig": ("R_s", 0.31), "Hdrm": ("payload.mass", 123.0), "Controller": ("gamma", 61.0)}


@pytest.mark.parametrize("fmu", CHANGED, indirect=True)
def test_machine_file_changes_the_machine(fmu, light_machine):
    name, value = CHANGED[fmu.identifier]
    inputs = INPUTS[fmu.identifier]
    instance = fmu.instance().start(0.0, inputs | {"machine_file": light_machine})
    assert instance.get(name) == value
    ordinary = fmu.instance().start(0.0, inputs)
    assert ordinary.get(name) != value
    if fmu.identifier != "Controller":  # its gamma shows only once it adapts
        assert trajectory(instance, 50) != trajectory(ordinary, 50)
    instance.call("fmi2Reset")
    instance.start()
    assert instance.get(name) == ordinary.get(name)


def test_start_values_written_back_leave_the_machine_file_in_force(emla, light_machine):
    """An importer that writes back every start value of the description has set nothing: the file counts, and what is read is in force."""
    starts = {v.name: v.start for v in emla.description.modelVariables if v.causality == "parameter" and v.type == "Real"}
    for order in ("file first", "file last"):
        instance = emla.instance()
        sets = [{"machine_file": light_machine}, {name: float(value) for name, value in starts.items()}]
        for values in sets if order == "file first" else reversed(sets):
            instance.set(values)
        instance.start(0.0, INPUTS["Emla"])
        assert instance.get("R_s") == 0.31 != float(starts["R_s"])
        instance.free()


def test_order_of_setting_does_not_matter(hdrm, light_machine):
    """A parameter set by the importer wins over the file, before or after it, and the file over the default."""
    runs = []
    for order in (["file", "mass", "pose"], ["pose", "mass", "file"], ["mass", "file", "pose"]):
        sets = {"file": {"machine_file": light_machine}, "mass": {"payload.mass": 50.0}, "pose": {"zeta_start[2]": 0.5}}
        instance = hdrm.instance()
        for key in order:
            instance.set(sets[key])
        instance.start()
        assert instance.get("payload.mass", "zeta_start[2]", "joint_viscous[2]") == [50.0, 0.5, 77.0]
        runs.append(trajectory(instance, 20))
    assert runs[0] == runs[1] == runs[2]


def test_manipulator_nobody_controls(hdrm):
    """60 s, first without any force, then with random forces to 70 kN and wrist torques: the end stops are reached and hold. They are stiff
    springs: the rods come to rest within them, the light wrist presses less than a degree into its own."""
    machine = json.loads(Path(hdrm.folder, "resources/reference_machine.json").read_text())
    limits = [machine["limits"][f"stroke_{i}"] for i in (1, 2, 3)]
    limits += np.radians([machine["limits"]["zeta_min_deg"][3:], machine["limits"]["zeta_max_deg"][3:]]).T.tolist()
    lower, upper = np.array(limits).T
    names = [f"x[{i}]" for i in (1, 2, 3)] + [f"zeta[{i}]" for i in (4, 5, 6)]
    beyond = []
    for seed in (None, 7):
        random, instance, rows = np.random.default_rng(seed), hdrm.running(), []
        for k in range(60_000):
            if seed is not None and k % 250 == 0:
                force, torque = random.uniform(-70e3, 70e3, 3), random.uniform(-2500, 2500, 3)
                values = {f"f[{i + 1}]": force[i] for i in range(3)} | {f"tau_wrist[{i + 1}]": torque[i] for i in range(3)}
                instance.set(values)
            instance.step(k * 1e-3, 1e-3)
            if k % 10 == 0:
                rows.append(instance.get(*names))
        instance.free()
        beyond.append(np.maximum(lower - np.min(rows, axis=0), np.max(rows, axis=0) - upper))
    print(f"furthest beyond the limits, m and rad: {beyond}")
    allowed = np.array([0.0, 0.0, 0.0, 0.0175, 0.0175, 0.0175])
    assert (beyond < allowed).all()
    assert beyond[1][0] > -1e-3 and (beyond[1][3:] > 0.0).all(), "no end stop was reached"


@pytest.mark.parametrize("drive, tolerance", [("motion", 1e-3), ("force", 1e-6)])
def test_actuator_with_any_voltage(emla, drive, tolerance):
    """60 s of random voltages (beyond v_max too), loads and rod motions: the energy that went in is what came out, was lost and is stored.
    Tolerances in parts of the energy turned over, about twice what the integration of the stiff screw leaves: with the rod moved from outside
    full voltage twists it with some MN."""
    names = ["energy.in", "energy.out", "energy.loss", "energy.stored"]
    random, x, x_dot = np.random.default_rng(11), 0.35, 0.0
    instance = emla.instance().start(0.0, {"drive": drive, "x": x})
    first = last = np.array(instance.get(*names))
    turnover, worst = 0.0, 0.0
    for k in range(60_000):
        if k % 100 == 0:
            (v_d, v_q), load = random.uniform(-600, 600, 2), random.uniform(-70e3, 70e3)
            x_dot = random.uniform(0.0, 0.2) * (1 if x < 0.35 else -1)
            instance.set({"v_d": v_d, "v_q": v_q, "F_ext": load, "x_dot": x_dot})
        instance.set({"x": x})
        instance.step(k * 1e-3, 1e-3)
        x += x_dot * 1e-3
        energy = np.array(instance.get(*names))
        turnover += np.abs(energy - last)[:3].sum()
        supplied, *rest = energy - first
        last, worst = energy, max(worst, abs(supplied - sum(rest)))
    instance.free()
    print(f"{drive}: {worst:.3g} J of {turnover:.3g} J")
    assert turnover > 1e7 and worst < tolerance * turnover


def test_steps_of_any_size_end_where_they_should(hdrm):
    """Variable communication steps come to the fixed-step result: the substep does not depend on how a second is cut."""
    ends = {}
    for label, cuts in {"fixed": np.full(1000, 1e-3), "random": np.random.default_rng(3).uniform(2e-4, 2e-3, 2000)}.items():
        instance = hdrm.instance().start(0.0, {"f[2]": 30e3, "f[3]": 20e3})
        t = 0.0
        for h in cuts:
            h = min(h, 1.0 - t)
            if h <= 1e-12:
                break
            instance.step(t, h)
            t += h
        ends[label] = np.array(instance.get(*(f"zeta[{i}]" for i in range(1, 7))))
        instance.free()
    # RK4 with substeps below 1 ms: its error over 1 s of free fall is some 1e-12 rad.
    assert np.abs(ends["fixed"] - ends["random"]).max() < 1e-10
    assert np.abs(ends["fixed"] - np.array([0, 0.698, -1.396, 0, -0.873, 0])).max() > 1e-2, "the arm did not move"


def test_steps_converge_at_the_order_of_the_method(hdrm):
    """RK4: half the step, a sixteenth of the difference; the wrist turns fast, so that it stands above rounding."""

    def angles(count):
        instance, h = hdrm.running(**{"zeta_dot_start[1]": 1.1, "zeta_dot_start[4]": 5.0, "zeta_dot_start[6]": 6.0}), 0.25 / count
        for k in range(count):
            instance.step(k * h, h)
        found = np.array(instance.get(*(f"zeta[{i}]" for i in range(1, 7))))
        instance.free()
        return found

    coarse, middle, fine = (angles(count) for count in (512, 1024, 2048))
    assert 10 < np.abs(coarse - middle).max() / np.abs(middle - fine).max() < 24


def test_nothing_is_printed(fmu, tmp_path):
    """A fresh process that uses and misuses an FMU, with stdout and stderr caught at the file descriptors."""
    script = f"""
        import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})
        from fmu import Fmu
        fmu = Fmu({fmu.path!r}, {str(tmp_path / "again")!r})
        i = fmu.instance(logging=True).start()
        for k in range(10): i.step(k * 1e-3, 1e-3)
        assert i.status("fmi2DoStep", -5.0, -1.0, 1) == 3
        i.free()
        assert not fmu.instance(guid="wrong").component
    """
    done = subprocess.run([sys.executable, "-c", dedent(script)], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")
