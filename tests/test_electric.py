"""The machine fed by a battery (`system/Electric.ssd`): energy back to its source, chopper, capped pack, precharge, other people's batteries."""

import json
import sys

import numpy as np
import pytest

from fmpy_master import ROOT, Master
from fmu import Fmu
from native import call, cargo_fmu, recorded
from system import System

ELECTRIC = ROOT / "system/Electric.ssd"
SIGNALS = ["dclink.v_dc", "dclink.i_battery", "dclink.soc", "dclink.ready", "emla_2.i_dc", "emla_2.tripped", "controller.tip_error_norm"]


@pytest.fixture(scope="module")
def electric():
    return System.read(ELECTRIC)


def energies(fmu_dir, path, *options, system=None):
    """What `hdrm-fmu energy` writes, and how it ended."""
    system = system or ["--system", ELECTRIC, "--fmu-dir", fmu_dir]
    done = call("hdrm-fmu", "energy", *system, "--json", path, *options)
    return json.loads(path.read_text()) if path.is_file() else None, done


def test_both_masters_run_it_bit_for_bit_alike(electric, fmus, fmu_dir, tmp_path):
    """Boolean wires, currents as bonds and, with precharge, an event in the link included."""
    settings = {"dclink": {"precharge.on": True, "precharge.R": 5.0}}
    words = {"dclink": {"precharge.on": "true", "precharge.R": 5.0}}
    for schedule in ("gauss-seidel", "jacobi", "standard"):
        options = ["--system", ELECTRIC, "--fmu-dir", fmu_dir, "--stop-time", 0.4, "--schedule", schedule]
        native = recorded(tmp_path / "run.csv", SIGNALS, *options, settings=words)
        master = Master(electric, fmus, settings, schedule)
        np.testing.assert_array_equal(master.record(0.4, SIGNALS)[1], native)
        master.free()
        assert native[0, 3] == 0 and native[-1, 3] == 1, "precharge has come to its end"


def left_open(s):
    """Energy from the pack that is nowhere, J."""
    source = s["source"]
    given = source["battery"] - source["brake"] - source["lost"] - source["stored"]
    return given - s["residual"] - s["work"] - s["shift"] - s["lost"] - s["stored"]


@pytest.mark.parametrize("schedule", ["gauss-seidel", "jacobi"])
def test_energy_closes_back_to_the_battery(fmu_dir, tmp_path, schedule):
    """Both trajectories: from the pack = losses + work + stored + what the bonds and the exchange at the rods make or lose, to 1e-6 of what
    went through the bonds."""
    found, done = energies(fmu_dir, tmp_path / "energy.json", "--schedule", schedule, "--check")
    assert done.returncode == 0, done.stdout + done.stderr
    for trajectory in ("cubic", "triangular"):
        s = found["supply"][trajectory]
        source = s["source"]
        left = left_open(s)
        print(f"{schedule}, {trajectory}: left open {left / s['throughput']:.1e}, bonds {s['residual'] / s['throughput']:.1e} of {s['throughput']:.0f} J")
        assert abs(left) <= 1e-6 * s["throughput"] and abs(s["residual"]) <= 1e-3 * s["throughput"]
        assert source["battery"] > 1000.0 and s["lost"] > 1000.0
        for balance in found["energy"][trajectory]:
            assert balance["efficiency"] is None or 0 < balance["efficiency"] < 1


def test_the_chopper_takes_what_a_full_pack_cannot(fmu_dir, tmp_path):
    """A full pack takes nothing: what the lowered boom gives back lifts the voltage to the chopper's threshold and is burnt."""
    found, done = energies(fmu_dir, tmp_path / "full.json", "--set", "dclink.battery.soc_start=1")
    assert done.returncode == 0, done.stderr
    for s in found["supply"].values():
        ranges = {r["name"]: r for r in s["ranges"]}
        assert s["source"]["brake"] > 100.0 and s["trouble"] == []
        assert 745.0 < ranges["v_dc"]["greatest"] < 755.0
        assert ranges["i_battery"]["least"] > -1.0 and ranges["soc"]["greatest"] == 1.0


def test_a_capped_pack_trips_the_drives_and_says_so(fmu_dir, tmp_path):
    signals = ["dclink.v_dc", "dclink.undervoltage", "emla_1.tripped", "emla_2.tripped", "emla_3.tripped", "hdrm.zeta[2]", "hdrm.zeta[3]"]
    options = ["--system", ELECTRIC, "--fmu-dir", fmu_dir, "--set", "dclink.battery.discharge_limit=0.5", "--stop-time", "12"]
    done = call("cosim", "run", "--quiet", "--csv", tmp_path / "capped.csv", "--signals", ",".join(signals), *options)
    assert done.returncode == 0, done.stderr
    said = done.stdout + done.stderr
    assert "undervoltage, v_dc" in said and "the pack gives no more than 0.5" in said
    columns = np.genfromtxt(tmp_path / "capped.csv", delimiter=",", names=True, deletechars="")
    rows = np.column_stack([columns[name] for name in signals])
    assert np.isfinite(rows).all() and rows[-1, 2:5].all() and rows[:, 1].any()
    first = int(np.argmax(rows[:, 3]))
    assert rows[0, 2:5].sum() == 0 and first > 0
    # The brakes hold the boom: what remains is the elasticity of screw and nut.
    assert np.ptp(rows[first + 2000 :, 5:], axis=0).max() < 1e-3
    checked, done = energies(fmu_dir, tmp_path / "capped.json", "--set", "dclink.battery.discharge_limit=0.5", "--check")
    assert done.returncode not in (0, 1) and "`emla_2.tripped` is true from" in done.stdout, done.stdout
    # Also through the trip every joule is somewhere: brakes that grip move the rods between two exchanges, which is counted.
    for s in checked["supply"].values():
        print(f"tripped: left open {left_open(s) / s['throughput']:.1e}, at the rods {s['shift']:.3f} J of {s['throughput']:.0f} J")
        assert abs(left_open(s)) <= 1e-6 * s["throughput"] and abs(s["shift"]) <= 1e-3 * s["throughput"]


def test_actuators_as_built_take_the_place_of_the_idealised_ones(fmu_dir, tmp_path):
    """The variant with `Rig` on all wires of `Emla`: energy closes to 1e-5, the full pack's chopper burns, and a capped pack trips drives whose
    brakes hold. The bristles of the friction are composed with the rest to second order, which leaves more open than `Emla` does."""
    system = ["--system", fmu_dir / "Electric.ssp", "--variant", "as_built.ssd"]
    found, done = energies(fmu_dir, tmp_path / "built.json", "--check", system=system)
    assert done.returncode == 0, done.stdout + done.stderr
    for s in found["supply"].values():
        print(f"as built: left open {left_open(s) / s['throughput']:.1e} of {s['throughput']:.0f} J")
        assert abs(left_open(s)) <= 1e-5 * s["throughput"] and s["source"]["battery"] > 1000.0
    capped, done = energies(fmu_dir, tmp_path / "capped.json", "--set", "dclink.battery.discharge_limit=0.5", system=system)
    assert done.returncode == 0, done.stderr
    for s in capped["supply"].values():
        tripped = [name for name, _ in s["trouble"]]
        assert {f"emla_{k}.tripped" for k in (1, 2, 3)} <= set(tripped), tripped
        print(f"as built, tripped: left open {left_open(s) / s['throughput']:.1e}, at the rods {s['shift']:.3f} J of {s['throughput']:.0f} J")
        assert abs(left_open(s)) <= 1e-5 * s["throughput"]
    signals = ["dclink.ready", "emla_2.tripped", "controller.tip_error_norm", "hdrm.zeta[2]"]
    rows = recorded(tmp_path / "precharge.csv", signals, *system, "--stop-time", 6, settings={"dclink": {"precharge.on": "true"}})
    ready = int(np.argmax(rows[:, 0]))
    assert 1700 < ready < 1900 and not rows[:, 1].any() and np.ptp(rows[:ready, 3]) < 1e-6
    assert rows[5000:, 2].max() < 5e-4


def test_no_trip_during_precharge(fmu_dir, tmp_path):
    signals = ["dclink.v_dc", "dclink.ready", "emla_2.tripped", "emla_3.tripped", "controller.tip_error_norm", "hdrm.zeta[2]"]
    options = ["--system", ELECTRIC, "--fmu-dir", fmu_dir, "--stop-time", 8]
    rows = recorded(tmp_path / "precharge.csv", signals, *options, settings={"dclink": {"precharge.on": "true"}})
    ready = int(np.argmax(rows[:, 1]))
    # R C ln(1/(1 - 0.95)) = 50.14 ohm * 12 mF * 3.0 = 1.80 s.
    assert rows[0, 0] == 0 and 1700 < ready < 1900
    assert not rows[:, 2:4].any()
    assert np.ptp(rows[:ready, 5]) < 1e-6, "the brakes hold the boom meanwhile"
    assert rows[4000:, 4].max() < 2e-5, "and the machine tracks afterwards"


@pytest.fixture(scope="module")
def others(fmus, pythonfmu, tmp_path_factory):
    """The systems with other people's batteries, and their FMUs."""
    sys.path.insert(0, str(ROOT / "examples"))
    from build import build, electric_systems

    folder = tmp_path_factory.mktemp("batteries")
    done = cargo_fmu("pack", "--profile", "release", "--out", folder, cwd=ROOT / "examples/battery")
    assert done.returncode == 0, done.stderr
    paths = [build("pack.py", folder), folder / "Battery.fmu"]
    return electric_systems(folder), fmus | {path.name: Fmu(path, folder / path.stem) for path in paths}


def test_other_peoples_batteries_take_its_place(others):
    """A pack by pythonfmu and the crate of `examples/battery`: the machine tracks, and the battery gives what the drives take."""
    for path in others[0]:
        system, rows = System.read(path), None
        voltage = "dclink.v_dc" if path.stem == "Pack" else "dclink.v"
        names = [voltage, "dclink.soc", "controller.tip_error_norm", *(f"emla_{k}.energy.in" for k in (1, 2, 3)), *(f"emla_{k}.i_dc_mean" for k in (1, 2, 3))]
        master = Master(system, others[1], {"controller": {"trajectory": "triangular", "settle_time": 0.5}})
        times, rows = master.record(2.0, names)
        master.free()
        given = np.sum(rows[1:, 6:].sum(axis=1) * 0.5 * (rows[1:, 0] + rows[:-1, 0])) * 1e-3
        taken = rows[-1, 3:6].sum() - rows[0, 3:6].sum()
        print(f"{path.stem}: {given:.3f} J by the battery's voltage, {taken:.3f} J taken")
        assert 500.0 < rows[:, 0].min() and rows[:, 0].max() < 750.0
        assert rows[-1, 1] < rows[0, 1] and rows[500:, 2].max() < 3e-5
        assert abs(given - taken) < 2e-3 * np.abs(np.diff(rows[:, 3:6].sum(axis=1))).sum()


def test_sizing_beside_the_ratings(fmu_dir, tmp_path):
    """Tables, CSV and figures; and a machine whose ratings are exceeded ends with a code of its own."""
    options = ["--system", ELECTRIC, "--fmu-dir", fmu_dir, "--csv", tmp_path / "sizing.csv", "--json", tmp_path / "sizing.json", "--figures", tmp_path]
    done = call("hdrm-fmu", "sizing", *options, "--check")
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "sizing.json").read_text())["sizing"]
    for trajectory, sizing in found.items():
        slew, lift, tilt = sizing["axes"]
        assert lift["torque"]["rms"] > 10 * slew["torque"]["rms"] and lift["force"]["peak"] < lift["ratings"]["force_max"]
        assert 293.0 < slew["temperatures"]["winding"] < tilt["temperatures"]["winding"] < lift["temperatures"]["winding"] < 330.0
        # A kilogram at the tip costs the lift force: a boom of some 5 m on an arm of some 0.7 m at the rod.
        assert 30.0 < sizing["payload"][1]["per_kg"]["force"] < 120.0
        assert (tmp_path / f"sizing_{trajectory}.svg").is_file() and (tmp_path / f"sizing_{trajectory}.png").is_file()
    assert (tmp_path / "sizing.csv").read_text().count("emla_2") == 2 * 20
    small = call("hdrm-fmu", "sizing", *options[:4], "--payload-step", 0, "--set", "emla_2.i_max=10", "--check")
    assert small.returncode not in (0, 1) and "emla_2: phase current, peak" in small.stdout
