"""A script in the loop: the processor times of one get, and of steps with 7 gets and 1 set, next to FMPy and MuJoCo, interleaved in one run.

    python tests/bench/script.py [--rounds 15]

Needs the package hdrm_fmu and FMPy; MuJoCo if it is installed. Prints medians, and the ratios that docs/studies/python.md states.
"""

import argparse
import importlib.util
import statistics
import time
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave

import hdrm_fmu

STEPS, GETS = 300, 3000
NAMES = ["emla_1.F", "emla_2.F", "emla_3.F", "hdrm.zeta[1]", "hdrm.zeta[2]", "hdrm.x[1]", "hdrm.x[2]"]


def timed(call, count):
    """Processor time of one of `count` calls, us."""
    start = time.thread_time()
    call(count)
    return 1e6 * (time.thread_time() - start) / count


def repeated(call):
    def loop(count):
        for _ in range(count):
            call()

    return loop


def fmpy_instance(path):
    """An actuator in FMPy, and the value reference of its force."""
    description = fmpy.read_model_description(str(path))
    reference = next(v.valueReference for v in description.modelVariables if v.name == "F")
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(path)), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="emla")
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, reference


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15, metavar="N", help="rounds, in each of which all is measured (default: %(default)s)")
    rounds = parser.parse_args().rounds
    emla = hdrm_fmu.fmus()["Emla"]
    fmu, reference = fmpy_instance(emla)
    with hdrm_fmu.System(emla) as alone, hdrm_fmu.System(hdrm_fmu.systems()["Manipulator"], settings={"trajectory": "external"}, step=1e-3) as whole:
        alone_force = alone.port("Emla.F", float)
        ports = [whole.port(name, float) for name in NAMES]
        target = whole.port("controller.reference.position[1]", float)
        held = target.get() or whole.get("controller.desired.position[1]", float)
        target.set(held)
        several = whole.port(NAMES)

        def with_ports():
            target.set(held)
            whole.step()
            for port in ports:
                port.get()

        def with_names():
            whole.set("controller.reference.position[1]", held)
            whole.step()
            for name in NAMES:
                whole.get(name)

        def with_one_port():
            target.set(held)
            whole.step()
            several.get()

        calls = {
            "one get by a port": (repeated(alone_force.get), GETS),
            "one get by name": (repeated(lambda: alone.get("Emla.F")), GETS),
            "one get of FMPy": (repeated(lambda: fmu.getReal([reference])), GETS),
            "steps by step(n)": (whole.step, STEPS),
            "steps by step()": (repeated(whole.step), STEPS),
            "steps with 1 set and 7 gets by ports": (repeated(with_ports), STEPS),
            "steps with 1 set and 7 gets by name": (repeated(with_names), STEPS),
            "steps with 1 set and 1 get of 7": (repeated(with_one_port), STEPS),
        }
        if importlib.util.find_spec("mujoco"):
            import mujoco

            model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("mechanism.xml")))
            data = mujoco.MjData(model)
            calls["steps of the bare manipulator in MuJoCo"] = (repeated(lambda: mujoco.mj_step(model, data)), STEPS)
        rows = [{name: timed(*call) for name, call in calls.items()} for _ in range(rounds)]
        alone._is_judged = whole._is_judged = True
    median = lambda of: statistics.median(map(of, rows))
    for name in calls:
        print(f"{name:42} {median(lambda row: row[name]):9.2f} us")
    print(f"get by a port over FMPy's:        {median(lambda r: r['one get by a port'] / r['one get of FMPy']):.2f}")
    print(f"get by name over FMPy's:          {median(lambda r: r['one get by name'] / r['one get of FMPy']):.2f}")
    plain = "steps by step(n)"
    for name in calls:
        if name.startswith("steps with"):
            print(f"{name}: {median(lambda r: r[name] - r[plain]):.1f} us above step(n)")


if __name__ == "__main__":
    main()
