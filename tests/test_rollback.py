"""What masters with step control do, as OMSimulator's: try a step, go back, take two halves, with extrapolated inputs.

Every call must return fmi2OK (`Instance.call` raises at fmi2Warning too).
"""

import numpy as np
import pytest

from fmpy_master import Exchange
from system import levels

SETTINGS = {"controller": {"trajectory": "triangular", "settle_time": 0.1}, "hdrm": {"inertia_scale": 1.2}}


class Rollback:
    """The coupled system by Jacobi with first derivatives of inputs; states of all instances can be kept and brought back."""

    def __init__(self, couple):
        self.master = couple(settings=SETTINGS, schedule="jacobi-derivatives")
        self.instances, self.time = self.master.instances, 0.0
        self.names = {c: [n for n in i.fmu.names("output") if i.fmu.variables[n].type == "Real"] for c, i in self.instances.items()}

    def outputs(self):
        return np.concatenate([i.get(*self.names[c]) for c, i in self.instances.items()])

    def advance(self, h):
        for instance in self.instances.values():
            instance.step(self.time, h)
        self.time += h
        self.master.pass_all()
        return self.outputs()

    def keep(self):
        return self.time, {c: i.save() for c, i in self.instances.items()}

    def back(self, kept):
        self.time, states = kept
        for c, i in self.instances.items():
            i.restore(states[c])

    def drop(self, kept):
        for c, i in self.instances.items():
            i.slave.freeFMUstate(kept[1][c])

    def doubled(self, h):
        """A step of h, taken back, then two of h/2; how far the two ends are apart, relative to what the outputs are."""
        kept, before = self.keep(), self.outputs()
        once = self.advance(h)
        self.back(kept)
        np.testing.assert_array_equal(self.outputs(), before)
        self.advance(h / 2)
        twice = self.advance(h / 2)
        return kept, np.abs(once - twice)


def tip(instances):
    return np.array(instances["hdrm"].get(*(f"tip.position[{i}]" for i in (1, 2, 3))))


def test_steps_taken_back_leave_no_trace(couple):
    """A run in which every step is first tried with twice its size equals, bit for bit, the run without trials."""
    plain, tried = Rollback(couple), Rollback(couple)
    for _ in range(300):
        kept = tried.keep()
        tried.advance(2e-3)
        tried.back(kept)
        tried.drop(kept)
        np.testing.assert_array_equal(tried.advance(1e-3), plain.advance(1e-3))


def test_a_master_with_step_control_tracks(couple):
    """Steps of 0.125 to 6 ms, chosen so that one step and two halves differ by 3 N in the actuators' forces: steps are refused and
    accepted, and the tip is where a fixed step of 0.25 ms has it, to a quarter of what a fixed step of 1 ms is allowed
    (tests/test_closed_loop.py)."""
    run = Rollback(couple)
    forces = np.cumsum([0] + [len(n) for n in run.names.values()])[[1, 2, 3]]
    h, taken, refused, end = 1e-3, [], 0, 1.5
    while run.time < end - 1e-9:
        h = min(h, end - run.time)
        kept, difference = run.doubled(h)
        worst = difference[forces].max() / 3.0  # F is the first output of the actuators; N
        if worst > 1.0 and h > 1.25e-4:
            run.back(kept)
            refused += 1
        else:
            taken.append(h)
        run.drop(kept)
        h = float(np.clip(h * (0.9 / np.sqrt(max(worst, 0.2))), 1.25e-4, 6e-3))
    assert refused > 5 and min(taken) < 0.5 * max(taken), (refused, len(taken), min(taken), max(taken))
    fine = couple(settings=SETTINGS, h=2.5e-4)
    fine.record(end, ["hdrm.x[1]"])
    apart = np.linalg.norm(tip(run.instances) - tip(fine.instances))
    moved = np.linalg.norm(tip(fine.instances) - tip(couple(settings=SETTINGS).instances))
    print(f"{len(taken)} steps of {1e3 * min(taken):.3f} to {1e3 * max(taken):.3f} ms, {refused} refused; tip {1e6 * apart:.2f} um apart")
    assert moved > 0.05 and apart < 5e-6


@pytest.mark.parametrize("mode", ["adaptive", "modular"])  # pd knows no gravity: the wrist starts to fall
def test_initialization_ends_at_rest(fmus, system, mode):
    """Outputs can be read in Initialization Mode before the exchange and after it. Then the actuators hold what the manipulator needs, it
    accelerates nowhere (gravity alone would give 4 rad/s^2), and the voltages are those of the holding currents at standstill, R_s i_q.
    Tolerances: some thousand roundings of the forces and voltages."""
    instances = {name: fmus[file].instance(name) for name, file in system.components.items()}
    instances["controller"].set({"mode": mode})
    for instance in instances.values():
        instance.setup(0.0)
        instance.call("fmi2EnterInitializationMode")
    hdrm, controller = instances["hdrm"], instances["controller"]
    accelerations = [f"zeta_ddot[{i}]" for i in range(1, 7)]
    assert max(map(abs, hdrm.get(*accelerations))) > 1.0
    Exchange(instances, system.links, levels(system, fmus, initialization=True)).run()
    assert max(map(abs, hdrm.get(*accelerations))) < 1e-11
    for k in (1, 2, 3):
        actuator = instances[f"emla_{k}"]
        force, current, resistance = actuator.get("F", "i_q", "R_s")
        assert force == pytest.approx(hdrm.get(f"f_hold[{k}]"), rel=1e-12)
        assert controller.get(f"v_d[{k}]", f"v_q[{k}]") == pytest.approx([0.0, resistance * current], rel=1e-12)
    for instance in instances.values():
        instance.free()


def test_continuous_outputs_of_the_hybrid_actuator_have_derivatives(emla):
    """What extrapolating masters take from it. With alpha > 0 the network counts, which is evaluated once a communication step; what
    follows from it alone is declared discrete, and the derivatives of all others are those of differences between its evaluations."""
    instance = emla.instance()
    instance.start(values={"alpha": 0.5, "x": 0.31, "x_dot": 0.02, "F_hold": 2e4, "v_q": 60.0, "v_d": -4.0})
    for k in range(20):  # away from the equilibrium of the start
        instance.step(k * 1e-3, 1e-3)
    outputs = [v.name for v in emla.variables.values() if v.causality == "output" and v.variability == "continuous"]
    jumps = ("P_loss", "loss.mechanical")  # a mean starts anew with each step, the network's part of the losses is taken anew
    outputs = [o for o in outputs if emla.variables[o].type == "Real" and o not in jumps and not o.endswith("_mean")]
    exact, start, kept, slopes = np.array(instance.derivatives(*outputs)), np.array(instance.get(*outputs)), instance.save(), {}
    for part in (1, 2, 4):  # Richardson, as in tests/test_derivatives.py
        h = 1e-5 / part
        instance.step(0.02, h)
        slopes[part] = (np.array(instance.get(*outputs)) - start) / h
        instance.restore(kept)
    instance.free()
    found = (4 * (2 * slopes[4] - slopes[2]) - (2 * slopes[2] - slopes[1])) / 3
    scale = np.abs(found) * 1e-4 + np.abs(start) * 1e-8 + 1e-9
    assert {o: (a, b) for o, a, b, s in zip(outputs, exact, found, scale) if abs(a - b) > s} == {}
    assert np.count_nonzero(exact) > len(outputs) / 2
