"""The machine as built: `Rig` in the place of `Emla`, `Sensors` between plants and controller (`system/Real.ssd`)."""

import numpy as np
import pytest

from fmpy_master import ROOT, Master
from native import recorded
from system import System

REAL = ROOT / "system/Real.ssd"
ACTUATORS = ("emla_1", "emla_2", "emla_3")
EXTRAS = "saturation temperature ripple cogging switching friction backlash compliance losses heat".split()
EVERY_EXTRA_OFF = {name: dict.fromkeys(EXTRAS, False) for name in ACTUATORS}
ENCODERS = dict.fromkeys(["motor_encoder", "joint_encoder", "rod_encoder", "joint_zero", "current"], False)
EVERY_SENSOR_OFF = {"sensors": {**ENCODERS, "speed": "ideal", "force": "ideal", "delay": 0}}
SIGNALS = ["controller.tip_error_norm", "hdrm.tip.position[1]", "hdrm.tip.position[2]", "emla_2.F", "emla_3.i_q", "controller.v_q[1]"]


def rows(system, fmus, until, signals=SIGNALS, **settings):
    master = Master(system, fmus, settings)
    try:
        return master.record(until, signals)[1]
    finally:
        master.free()


def words(settings):
    """As the command line takes them."""
    return {c: {v: str(value).lower() for v, value in values.items()} for c, values in settings.items()}


@pytest.fixture(scope="module")
def real():
    return System.read(REAL)


def test_both_masters_run_it_bit_for_bit_alike(real, fmus, fmu_dir, tmp_path):
    """Noise, drawn errors, stiction and the sampling inverter included, with the readings of this instant and of the one before."""
    signals = [*SIGNALS, "sensors.w_m_measured[2]", "sensors.F_measured[2]", "emla_2.presliding", "emla_2.T_winding"]
    for delay in (0, 1):
        native = recorded(tmp_path / "real.csv", signals, "--system", REAL, "--fmu-dir", fmu_dir, "--stop-time", 0.5, settings={"sensors": {"delay": delay}})
        np.testing.assert_array_equal(rows(real, fmus, 0.5, signals, sensors={"delay": delay}), native)


def test_with_everything_off_it_is_the_idealised_machine(bare, fmus, system):
    """Without extras, sensor errors, network and gains for this machine. Tolerances: 1e-6 of the peaks for what the integration of `Emla` in substeps of 0.25 ms
    leaves (its errors act on the control, so the voltage differs as the force does)."""
    settings = {"controller": {"trajectory": "triangular"}}
    found = rows(bare, fmus, 6.0, **settings, **EVERY_EXTRA_OFF, **EVERY_SENSOR_OFF)
    settings["controller"]["alpha"] = 0.0
    expected = rows(system, fmus, 6.0, **settings, **{name: {"alpha": 0.0} for name in ACTUATORS})
    worst, peak = np.abs(found - expected).max(axis=0), np.abs(expected).max(axis=0)
    print(dict(zip(SIGNALS, worst / peak)))
    assert (worst[1:3] < 1e-7 * peak[1:3]).all() and (worst[3:] < 1e-5 * peak[3:]).all()


def differs(found, plain):
    return np.abs(found - plain).max() > 0


WARM = {"T_winding_start": 350.0, "T_housing_start": 330.0}


@pytest.fixture(scope="module")
def bare(fmu_dir):
    """Without the gains for this machine: with all extras off its drives cannot have current loops, which need the inverter's clock."""
    return System.read(fmu_dir / "Real.ssp", "bare.ssd")


@pytest.mark.parametrize("extra", EXTRAS)
def test_each_extra_shows(bare, fmus, extra):
    """Alone, on machines that are warm."""
    signals = [*SIGNALS, "emla_2.loss.inverter", "emla_2.T_winding"]
    off = {name: values | WARM for name, values in EVERY_EXTRA_OFF.items()}
    on = {name: values | {extra: True} for name, values in off.items()}
    assert differs(rows(bare, fmus, 0.05, signals, **on, **EVERY_SENSOR_OFF), rows(bare, fmus, 0.05, signals, **off, **EVERY_SENSOR_OFF))


SWITCHES = [{name: True} for name in ENCODERS] + [{"speed": kind} for kind in ("difference", "observer")]
SWITCHES += [{"force": kind} for kind in ("sensor", "absent")] + [{"delay": 1}]


@pytest.mark.parametrize("switch", SWITCHES, ids=str)
def test_each_sensor_error_shows(bare, fmus, switch):
    """Alone, in the readings; the machine starts in motion, so that the controller has something to do."""
    signals = [f"sensors.{name}_measured[2]" for name in ("zeta", "theta_m", "w_m", "x_dot", "i_q", "F", "x")]
    run = lambda sensors: rows(bare, fmus, 0.02, signals, hdrm={"zeta_dot_start[2]": 0.01}, **EVERY_EXTRA_OFF, sensors=sensors)
    plain = EVERY_SENSOR_OFF["sensors"]
    assert differs(run(plain | switch), run(plain))


def test_a_seed_is_another_machine(real, fmus):
    one, other, again = (rows(real, fmus, 0.1, sensors={"seed": seed}) for seed in (1, 2, 1))
    assert differs(one, other) and not differs(one, again)


@pytest.mark.parametrize("drive", ["motion", "force"])
def test_power_and_heat_balance_of_the_rig(fmus, drive):
    """What went in came out, was lost or is stored, to 1e-3 of what was turned over; what was lost in motor and gear is the heat held and given."""
    names = ["energy.in", "energy.out", "energy.loss", "energy.stored", "energy.loss_inverter", "energy.heat", "energy.thermal"]
    random, x, x_dot = np.random.default_rng(11), 0.35, 0.0
    instance = fmus["Rig.fmu"].instance().start(0.0, {"drive": drive, "x": x})
    first, turnover, before = np.array(instance.get(*names)), 0.0, np.zeros(3)
    for k in range(5000):
        if k % 100 == 0:
            x_dot = random.uniform(0.0, 0.06) * (1 if x < 0.35 else -1)
            emf = 4 * 0.19 / (0.016 / 2 / np.pi / 6) * x_dot
            instance.set({"v_q": emf + random.uniform(-20, 20), "F_ext": random.uniform(-20e3, 20e3), "x_dot": x_dot})
        instance.set({"x": x})
        instance.step(k * 1e-3, 1e-3)
        x += x_dot * 1e-3
        energy = np.array(instance.get(*names))
        turnover += np.abs(energy[:3] - before).sum()
        before = energy[:3]
    instance.free()
    supplied, given, lost, stored, inverter, heat, thermal = energy - first
    print(f"{drive}: {supplied - given - lost - stored:.3g} J of {turnover:.3g} J; heat {lost - inverter - heat - thermal:.3g} J of {lost:.3g} J")
    assert turnover > 1e3 and abs(supplied - given - lost - stored) < 1e-3 * turnover
    assert abs(lost - inverter - heat - thermal) < 1e-6 * lost


def test_noise_moves_no_estimate_of_a_machine_at_rest(fmu_dir, tmp_path):
    """Within 5 s it does: there a machine may be about to move. Then the estimates stay as they are, to the last bit."""
    names = ["controller.mass_hat.A2", "controller.mass_hat.PL"]
    settings = {"controller": {"trajectory": "rates"}}
    made = recorded(tmp_path / "rest.csv", names, "--system", fmu_dir / "Real.ssp", "--stop-time", 10, "--interval", 1, settings=settings)
    assert (made[1] != made[4]).all() and (made[6] == made[10]).all()
