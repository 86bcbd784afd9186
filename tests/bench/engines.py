"""Cost of the manipulator in MuJoCo and Pinocchio on the same mechanism with the same closed loops (mechanism.xml).

Prints lines of JSON. MuJoCo steps in its own C loop (`nstep`). Pinocchio's Python wheel has no
such loop; the cost of a call from Python, measured as the same call on a one-joint model, is taken off.
"""

import json
import statistics
import time
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

MECHANISM = Path(__file__).resolve().parent / "mechanism.xml"
BATCHES, STEPS = 15, 100


def report(name, times):
    row = {"name": name, "unit": "ns", "median": round(statistics.median(times), 1), "least": round(min(times), 1)}
    print(json.dumps(row), flush=True)


def timed(batch, calls):
    """Times of one call, ns, in BATCHES batches."""
    times = []
    for _ in range(BATCHES):
        start = time.perf_counter()
        batch()
        times.append(1e9 * (time.perf_counter() - start) / calls)
    return times


def run_mujoco():
    """From the middle of the joint range under gravity, 0.1 s at a time; the solver is at MuJoCo's default tolerance."""
    version = mujoco.__version__
    for integrator, name in [
        (mujoco.mjtIntegrator.mjINT_EULER, "step of 1 ms, semi-implicit Euler: one forward dynamics"),
        (mujoco.mjtIntegrator.mjINT_RK4, "step of 1 ms, RK4: four forward dynamics"),
    ]:
        m = mujoco.MjModel.from_xml_path(str(MECHANISM))
        m.opt.integrator, m.opt.tolerance, m.opt.iterations = integrator, 1e-8, 100
        d = mujoco.MjData(m)

        def batch():
            mujoco.mj_resetData(m, d)
            mujoco.mj_step(m, d, nstep=STEPS)

        report(f"MuJoCo {name} (version {version})", timed(batch, STEPS))
        assert np.isfinite(d.qpos).all()


def forward_dynamics(model, constraints):
    """A function without arguments that computes accelerations under constraints, and one for the tree alone."""
    data, datas = model.createData(), pin.StdVec_RigidConstraintData()
    for constraint in constraints:
        datas.append(constraint.createData())
    q, v, tau = pin.neutral(model), np.full(model.nv, 1e-3), np.full(model.nv, 10.0)
    settings = pin.ProximalSettings(1e-10, 1e-10, 1)
    pin.initConstraintDynamics(model, data, constraints, datas)

    def closed():
        pin.constraintDynamics(model, data, q, v, tau, constraints, datas, settings)

    def tree():
        pin.aba(model, data, q, v, tau)

    return closed, tree


def run_pinocchio():
    model, constraints = loops()
    single = pin.Model()
    single.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "only")
    single.appendBodyToJoint(1, pin.Inertia.Random(), pin.SE3.Identity())
    none = type(constraints)()
    mechanism, overhead = forward_dynamics(model, constraints), forward_dynamics(single, none)
    for k, name in enumerate(["forward dynamics with loop constraints", "forward dynamics of the open tree (ABA)"]):
        call = lambda f: timed(lambda: [f() for _ in range(STEPS)], STEPS)
        border = min(call(overhead[k]))
        report(f"Pinocchio {pin.__version__} {name}", [t - border for t in call(mechanism[k])])


def loops():
    model, constraints = pin.buildModelAndLegacyConstraintsFromMJCF(str(MECHANISM))
    assert len(constraints) == 3, f"{len(constraints)} loop closures"
    return model, constraints


def main():
    run_mujoco()
    run_pinocchio()


if __name__ == "__main__":
    main()
