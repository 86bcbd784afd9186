"""Paths of files: followed by the FMU and by the programs, and refused before the start where they are wrong."""

import json

import numpy as np
import pytest
from fmpy_master import ROOT, Master
from fmu import Refused
from native import call
from system import System

EXAMPLE = ROOT / "examples/paths/two_pickups.json"
PATH = 5


@pytest.fixture
def follow(controller, tmp_path):
    """An instance of the controller that follows what is given: points relative to the start, or a text."""

    def running(path, **values):
        file = tmp_path / "path.json"
        file.write_text(path if isinstance(path, str) else json.dumps({"relative": True, "waypoints": [{"position": p} for p in path]}))
        return controller.running(trajectory=PATH, path_file=str(file), settle_time=0.0, **values)

    return running


def test_the_reference_follows_the_file(follow):
    instance = follow([[0, 0, 0], [-0.2, 0.1, 0]])
    length, speed, acceleration, jerk = np.hypot(0.2, 0.1), 0.1, 0.2, 1.0
    assert instance.get("motion_end") == pytest.approx(length / speed + speed / acceleration + acceleration / jerk, abs=1e-12)
    before = np.array(instance.get(*[f"desired.position[{i}]" for i in (1, 2, 3)]))
    for k in range(3000):
        instance.step(k * 1e-3, 1e-3)
    after = np.array(instance.get(*[f"desired.position[{i}]" for i in (1, 2, 3)]))
    assert after - before == pytest.approx([-0.2, 0.1, 0], abs=1e-12)
    instance.free()


@pytest.mark.parametrize("path, expected", [
    ([[0, 0, 0], [2.5, 0, 0]], "waypoint 2 is 5.5"),
    ([[0, 0, 0], [0.88, 0, 0]], "joint 3 (tilt) = "),
    ([[0, 0, 0]], "a path has 1 waypoint(s), it must have at least two"),
    ('{"waypoints": [{"position": [0, 0, 0], "dwel": 1}, {"position": [1, 0, 0]}]}', "did you mean `dwell`?"),
    ("t,x,y,z\n0,3,1,0\n1,3,1,0.1\n1,3,1,0\n", "must be later than that of the sample before"),
])  # fmt: skip
def test_a_wrong_path_is_refused_before_the_start(follow, path, expected):
    with pytest.raises(Refused) as refused:
        follow(path)
    assert expected in str(refused.value)


def test_the_check_can_be_switched_off_and_a_path_is_needed(follow, controller):
    follow([[0, 0, 0], [0.88, 0, 0]], path_check=False).free()
    with pytest.raises(Refused, match="path_file"):
        controller.running(trajectory=PATH)
    with pytest.raises(Refused, match="iso9283-cube and iso9283-rectangle"):
        controller.running(trajectory=PATH, path_file="nothing.json")


def test_a_path_runs_in_another_master_as_in_the_native_one(system, fmus, tmp_path):
    path = tmp_path / "short.json"
    path.write_text(json.dumps({"relative": True, "waypoints": [{"position": [0, 0, 0]}, {"position": [-0.05, 0.02, 0.03]}]}))
    master = Master(system, fmus, {"controller": {"trajectory": PATH, "path_file": str(path), "settle_time": 0.5}})
    rows = master.record(2.0, ["controller.tip_error_norm", "hdrm.tip.position[1]"])[1]
    error, x = np.array(rows).T[-2:]
    assert np.abs(error).max() < 1e-4
    assert x[-1] - x[0] == pytest.approx(-0.05, abs=1e-4)


def test_a_variant_of_the_package_has_the_wires_for_loads(fmu_dir, fmus, tmp_path):
    """Any importer's: what the controller's path picks up hangs at the manipulator, which in the default structure learns nothing of it."""
    path = tmp_path / "pickup.json"
    load = {"mass": 50.0, "com": [0.1, 0.0, 0.0]}
    waypoints = [{"position": [0, 0, 0], "dwell": 0.3, "load": load}, {"position": [-0.02, 0, 0]}]
    path.write_text(json.dumps({"relative": True, "waypoints": waypoints}))
    brought = {}
    for name in ("SystemStructure.ssd", "loads.ssd"):
        system = System.read(fmu_dir / "Manipulator.ssp", name)
        master = Master(system, fmus, {"controller": {"trajectory": PATH, "path_file": str(path), "settle_time": 0.1}})
        for _ in range(200):
            master.step()
        brought[name] = master.instances["hdrm"].get("energy.load")
        height = master.instances["hdrm"].get("tip.position[2]")
        master.free()
    assert brought["SystemStructure.ssd"] == 0.0
    assert brought["loads.ssd"] == pytest.approx(50.0 * 9.81 * height, rel=0.2)  # the load is a little below the tip


def test_the_check_says_what_is_left(tmp_path):
    done = call("hdrm-fmu", "path", "check", EXAMPLE, "--figures", tmp_path, "--json", tmp_path / "path.json")
    assert done.returncode == 0, done.stderr
    assert "20 waypoints" in done.stdout and "the machine can do this path" in done.stdout
    found = json.loads((tmp_path / "path.json").read_text())
    least = min(found["margins"], key=lambda margin: margin["part"])
    assert 0 < least["part"] < 0.1 and least["quantity"].startswith("force of "), "near the edge of what the machine lifts"
    assert "force of lift" in (tmp_path / "margins_two_pickups.svg").read_text()
    path = json.loads(EXAMPLE.read_text())
    for waypoint in path["waypoints"]:
        if "load" in waypoint:
            waypoint["load"]["mass"] *= 1.1
    (tmp_path / "heavy.json").write_text(json.dumps(path))
    done = call("hdrm-fmu", "path", "check", tmp_path / "heavy.json")
    assert done.returncode == 1 and "force of" in done.stderr and "beyond" in done.stderr


def test_a_test_path_measures_its_accuracy(fmu_dir):
    done = call("hdrm-fmu", "run", "--quiet", "--system", fmu_dir / "Manipulator.ssp", "--waypoints", "iso9283-rectangle:2")
    assert done.returncode == 0, done.stderr
    accuracy, repeatability = done.stdout.split("repeatab. RT\n")[1].split()[:2]
    assert 0 < float(accuracy) < 0.1 and 0 <= float(repeatability) < 0.1


def test_what_repeats_is_learnt_from_lap_to_lap(fmu_dir, controller, tmp_path):
    """A machine drawn in the strict world passes the paper's triangle six times: without learning the last lap has 0.6 to 1 of the first one's error."""
    machine = ["draws", "--system", fmu_dir / "Real.ssp", "--world", "strict-rigid", "--bounds", "1", "--seed", "401", "--seeds", "1"]
    done = call("hdrm-fmu", *machine, "--trajectory", "triangle-laps", "--set", "controller.learning=0.8", "--json", tmp_path / "laps.json")
    assert "1 kept, 0 stopped" in done.stdout and "known error of each lap" in done.stdout, done.stdout + done.stderr
    [draw] = json.loads((tmp_path / "laps.json").read_text())["machines"]
    assert len(draw["laps"]) == 6 and draw["laps"][-1] < 0.6 * draw["laps"][0], draw
    with pytest.raises(Refused, match="`learning` = 0.8 needs a path of equal laps"):
        controller.running(learning=0.8)
    done = call("hdrm-fmu", *machine, "--trajectory", "triangel")
    assert done.returncode == 2 and "a built-in path (iso9283-cube, iso9283-rectangle, six-joints, triangle-laps) or a file" in done.stderr


def test_a_saved_lap_goes_on_with_the_same_bits(follow):
    """Laps of 1 mm, so that no drive is at its limit while the measured angles stand still: the state holds what was learnt and what the lap adds."""
    corners = [{"position": p, "dwell": 0.3} for p in ([0, 0, 0], [0, 0.001, 0], [0.001, 0.001, 0])]
    instance = follow(json.dumps({"relative": True, "laps": 9, "waypoints": corners}), learning=0.8, current_loop=True)
    outputs = ["lap", *[f"learnt.shift[{k}]" for k in (1, 2, 3)], *[f"i_q_required[{k}]" for k in (1, 2, 3)]]

    def go_on(first, last):
        seen = []
        for k in range(first, last):
            instance.step(k * 1e-3, 1e-3)
            seen.append(instance.get(*outputs))
        return seen

    before = go_on(0, 6000)
    assert before[-1][0] > 1 and any(before[-1][1:4]), "it learns"
    state = instance.save()
    after = go_on(6000, 8000)
    instance.restore(state)
    assert go_on(6000, 8000) == after
    instance.free()
