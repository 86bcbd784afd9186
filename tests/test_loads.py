"""Loads that come and go, contact with a plane, a base that tilts, and commanded rates, as importers see them."""

import numpy as np
import pytest
from fmpy_master import ROOT, Master
from fmu import Refused
from system import System

H = 1e-3
ENERGIES = ["energy.kinetic", "energy.potential", "energy.contact", "energy.contact_loss"]
MOVING = {f"zeta_dot_start[{i + 1}]": w for i, w in enumerate([0.2, -0.1, 0.15, 0.3, -0.2, 0.1])}
LOAD = {"load.mass": 170.0, "load.com[1]": 0.2, "load.com[2]": -0.3, "load.com[3]": 0.1}


def rates(instance):
    return np.array(instance.get(*[f"zeta_dot[{i}]" for i in range(1, 7)]))


def test_a_load_comes_with_the_tip_or_with_an_impulse(hdrm):
    """With the tip's velocity nothing jumps; at rest it slows the arm down at once, which costs energy. Outputs before the step are those of the old load."""
    jumps, brought = [], []
    for with_tip in (True, False):
        plant = hdrm.running(**MOVING, **{"load.moves_with_tip": with_tip})
        plant.step(0.0, H)
        before, heights = rates(plant), plant.get("energy.potential")
        plant.set(LOAD)
        assert (rates(plant) == before).all() and plant.get("energy.potential") == heights
        plant.step(H, 1e-7)
        jumps.append(np.abs(rates(plant) - before).max())
        brought.append(plant.get("energy.load"))
        plant.free()
    assert jumps[0] < 1e-5 < 1e-2 < jumps[1]
    assert brought[1] < brought[0]  # what the impact took, besides the weight lifted


def test_the_payload_is_tuned_while_it_runs(hdrm):
    """Heavier, it needs more force to hold; saved states know it, and a mass that is none is discarded."""
    plant = hdrm.running()
    plant.step(0.0, H)
    light = plant.get("f_hold[2]")
    plant.set({"payload.mass": 500.0, "payload.com[2]": 0.1})
    plant.step(H, H)
    heavy, saved = plant.get("f_hold[2]"), plant.serialize()
    assert heavy > 1.1 * light
    plant.set({"payload.mass": 0.0})
    plant.step(2 * H, H)
    empty = plant.outputs()
    assert empty["f_hold[2]"] < 0.9 * light
    plant.deserialize(saved)
    assert plant.get("f_hold[2]") == heavy
    plant.set({"payload.mass": 0.0})
    plant.step(2 * H, H)
    assert plant.outputs() == empty
    for value in (-1.0, 2e5, np.nan):
        with pytest.raises(Refused):
            plant.set({"load.mass": value})
    plant.free()


def test_energy_closes_in_contact(hdrm):
    """The machine falls on a plane: what it has, and what the plane took, is what the constant forces have worked. Viscous friction is off; RK4 errs by some mJ at touch-down."""
    contact = {"contact.offset": 0.9, "contact.stiffness": 1e5, "contact.damping": 2.0, "contact.friction": 0.4, "contact.slip_velocity": 0.02}
    force = {"f[2]": 37e3, "f[3]": 30e3}
    plant = hdrm.running(**contact, **force, **{f"joint_viscous[{i}]": 0.0 for i in range(1, 7)})
    state = lambda: sum(plant.get(*ENERGIES)) - force["f[2]"] * plant.get("x[2]") - force["f[3]"] * plant.get("x[3]")
    start, forces = state(), []
    for k in range(600):
        plant.step(k * H, H)
        forces.append(plant.get("contact.force[2]"))
    assert abs(state() - start) < 0.01
    assert min(forces) == 0.0 and max(forces) > 1e3 and plant.get("energy.contact_loss") > 10.0
    plant.free()


def test_a_base_may_tilt_while_the_machine_runs(hdrm):
    """Rolled by 0.1 rad, a part of gravity turns the slew; an upwards acceleration makes everything heavier by as much."""
    plant = hdrm.running()
    plant.step(0.0, H)
    upright = np.array(plant.get("f_hold[1]", "f_hold[2]"))
    plant.set({"base.tilt[1]": 0.1})
    assert abs(plant.get("f_hold[1]")) > 1000.0 and abs(upright[0]) < 1e-6
    plant.set({"base.tilt[1]": 0.0, "base.acceleration[2]": 0.981})
    assert plant.get("f_hold[2]") == pytest.approx(1.1 * upright[1], rel=1e-12)
    plant.free()


def test_a_turning_base_is_a_slewing_machine(hdrm):
    """Without friction it is the same whether the base or the slew turns about y, and speeds up: the other joints feel the same."""
    accelerations = [f"zeta_ddot[{i}]" for i in range(1, 7)]
    smooth = {f"joint_viscous[{i}]": 0.0 for i in range(1, 7)}
    slewing = hdrm.running(**smooth, **{"zeta_dot_start[1]": 0.4, "zeta_dot_start[3]": -0.2})
    turning = hdrm.running(**smooth, **{"zeta_dot_start[3]": -0.2, "base.angular_velocity[2]": 0.4})
    expected, found = np.array(slewing.get(*accelerations)), np.array(turning.get(*accelerations))
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    turning.set({"base.angular_acceleration[2]": 0.7})
    assert turning.get("zeta_ddot[1]") == pytest.approx(expected[0] - 0.7, rel=1e-9)
    turning.set({"base.angular_velocity[2]": 0.0})
    assert abs(np.array(turning.get(*accelerations[1:])) - expected[1:]).max() > 1e-3
    for plant in (slewing, turning):
        plant.free()


def test_an_operator_leads_the_coupled_machine_by_rates(fmus):
    """Through the packed FMUs: joint rates, then the tip's, then rest; followed within a millimetre, and held at the end of a range with one message."""
    system = System.read(ROOT / "system/SystemStructure.ssd")
    master = Master(system, fmus, {"controller": {"trajectory": "rates"}})
    controller, plant = master.instances["controller"], master.instances["hdrm"]
    worst = 0.0

    def run(seconds):
        nonlocal worst
        for _ in range(round(seconds / master.h)):
            master.step()
            worst = max(worst, controller.get("tip_error_norm"))

    before = plant.get("zeta[5]")
    controller.set({"rate.joint[5]": 0.3})
    run(1.0)
    assert plant.get("zeta[5]") - before == pytest.approx(0.3 - 0.3 * 0.2, abs=0.03)
    height = plant.get("tip.position[2]")
    controller.set({"rate.joint[5]": 0.0, "rate.command": "tip", "rate.tip[2]": 0.1})
    run(1.0)
    controller.set({"rate.tip[2]": 0.0})
    run(1.0)
    assert plant.get("tip.position[2]") - height == pytest.approx(0.1, abs=0.03)
    assert np.abs(rates(plant)).max() < 1e-3 and worst < 1e-3
    master.free()
