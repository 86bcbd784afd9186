"""Runs FMUs in one importer, in a process of its own, and prints what came out as JSON:

    python importers.py IMPORTER alone MODEL FMU_DIR WORK_DIR     one FMU driven by `driven`, `ALONE` seconds
    python importers.py IMPORTER coupled SSP FMU_DIR WORK_DIR     the packed system SSP, a file of FMU_DIR, with its own values, `COUPLED` seconds

Every importer gets the files as they are packed and nothing else, in steps of `H`.
"""

import csv
import ctypes
import json
import logging
import math
import os
import subprocess
import sys
from pathlib import Path

from interoperability import MODELS, ROOT

H, ALONE, COUPLED = 1e-3, 0.5, 6.0
STEPS, EVERY = round(ALONE / H), round(0.5 / H)

POSE = json.loads((ROOT / "parameters/reference_machine.json").read_text())["start"]["zeta"]
#: What is compared of an FMU alone.
OUTPUTS = {
    "Emla": ["F", "i_d", "i_q", "w_m", "energy.in"],
    "Hdrm": [*(f"zeta[{i}]" for i in range(1, 7)), *(f"x[{i}]" for i in (1, 2, 3)), *(f"tip.position[{i}]" for i in (1, 2, 3))],
    "Controller": [*(f"{v}[{i}]" for v in ("v_d", "v_q", "tau_wrist") for i in (1, 2, 3)), "mass_hat.PL"],
}
#: What is compared of the coupled system, by model.
SIGNALS = {
    "Emla": [f"emla_{k}.i_q" for k in (1, 2, 3)],
    "Hdrm": [f"hdrm.x[{k}]" for k in (1, 2, 3)],
    "Controller": [f"controller.v_q[{k}]" for k in (1, 2, 3)],
}
ALL = [signal for model in MODELS for signal in SIGNALS[model]]


def driven(model, t):
    """Inputs of an FMU alone at time t; at t = 0 they are its start values."""
    s, c = (lambda w: math.sin(w * t)), (lambda w: 1.0 - math.cos(w * t))
    if model == "Emla":
        return {"v_d": -20.0 * s(8.0), "v_q": 60.0 * s(5.0), "x": 0.3 + 0.004 * c(6.0), "x_dot": 0.024 * s(6.0)}
    if model == "Hdrm":
        forces = {"f[1]": 2e4 * s(6.0), "f[2]": -9e4 * t, "f[3]": -7e4 * t}
        return forces | {"tau_wrist[1]": 50.0 * s(9.0), "tau_wrist[2]": -300.0 * t, "tau_wrist[3]": 20.0 * t}
    angles = {f"zeta[{i}]": POSE[i - 1] + 0.003 * i * c(4.0 + i) for i in range(1, 7)}
    rates = {f"zeta_dot[{i}]": 0.003 * i * (4.0 + i) * s(4.0 + i) for i in range(1, 7)}
    currents = {f"{v}[{k}]": a * s(3.0 + k) for v, a in (("i_d", 1.5), ("i_q", 20.0), ("w_m", 40.0), ("F", 3e4)) for k in (1, 2, 3)}
    return angles | rates | currents | {f"x_dot[{k}]": 0.01 * s(5.0 + k) for k in (1, 2, 3)}


def table(model):
    """Time and inputs at all communication points: titles and rows."""
    rows = [{"time": k * H} | driven(model, k * H) for k in range(STEPS + 1)]
    return list(rows[0]), [list(row.values()) for row in rows]


def simulated(path, model=None, names=None, end=ALONE):
    """Rows of an FMU run by FMPy, driven by the inputs of `model` where one is given."""
    import fmpy
    import numpy as np

    signals = None
    if model:
        titles, rows = table(model)
        signals = np.array([tuple(row) for row in rows], dtype=[(title, float) for title in titles])
    names = names or OUTPUTS[model]
    result = fmpy.simulate_fmu(str(path), stop_time=end, step_size=H, output_interval=H, input=signals, output=names)
    return [[float(row[name]) for name in names] for row in result][1:]


class FMPy:
    def alone(self, model, fmu_dir, work):
        return simulated(fmu_dir / f"{model}.fmu", model)

    def coupled(self, package, work):
        from fmpy_master import Master
        from fmu import Fmu
        from system import System

        system = System.read(package)
        fmus = {file: Fmu(package.parent / file, work / file) for file in set(system.components.values())}
        return Master(system, fmus, h=H).record(COUPLED, ALL)[1][EVERY::EVERY].tolist()


class Ecos:
    def __init__(self):
        # The wheel does not bring its libtbb.so.12; that of the tbb wheel, loaded first, is found by name.
        ctypes.CDLL(str(Path(sys.prefix, "lib/libtbb.so.12")), ctypes.RTLD_GLOBAL)
        import ecospy

        ecospy.EcosLib.set_log_level("warn")
        self.ecospy = ecospy

    def alone(self, model, fmu_dir, work):
        structure = self.ecospy.EcosSimulationStructure()
        structure.add_model("fmu", fmu_dir / f"{model}.fmu")
        simulation = self.ecospy.EcosSimulation(H, structure=structure)
        assert simulation.init()
        rows = []
        for k in range(STEPS):
            for name, value in driven(model, k * H).items():
                simulation.set_real(f"fmu::{name}", value)
            simulation.step()
            rows.append([simulation.get_real(f"fmu::{name}") for name in OUTPUTS[model]])
        return rows

    def coupled(self, package, work):
        simulation = self.ecospy.EcosSimulation(H, ssp_path=str(package))
        assert simulation.init(parameter_set="hybrid")  # ecos applies no parameter set that is not asked for by name
        assert simulation.get_real("emla_1::alpha") == 0.2
        rows = []
        for _ in range(round(COUPLED / H) // EVERY):
            simulation.step(EVERY)
            rows.append([simulation.get_real(name.replace(".", "::", 1)) for name in ALL])
        return rows


class Libcosim:
    def __init__(self):
        from libcosimpy.CosimExecution import CosimExecution
        from libcosimpy.CosimObserver import CosimObserver

        self.Execution, self.observer = CosimExecution, CosimObserver.create_last_value()

    def reader(self, execution, slave):
        """Slave index and references by name."""
        index = execution.slave_index_from_instance_name(slave)
        return index, {v.name.decode(): v.reference for v in execution.slave_variables(index)}

    def alone(self, model, fmu_dir, work):
        from libcosimpy.CosimManipulator import CosimManipulator
        from libcosimpy.CosimSlave import CosimLocalSlave

        execution = self.Execution.from_step_size(H * 1e9)
        assert execution.add_local_slave(CosimLocalSlave(str(fmu_dir / f"{model}.fmu"), "fmu")) == 0
        override = CosimManipulator.create_override()
        assert execution.add_manipulator(override) and execution.add_observer(self.observer)
        slave, references = self.reader(execution, "fmu")
        rows = []
        for k in range(STEPS):
            inputs = driven(model, k * H)
            assert override.slave_real_values(slave, [references[n] for n in inputs], list(inputs.values()))
            assert execution.step()
            rows.append(list(self.observer.last_real_values(slave, [references[n] for n in OUTPUTS[model]])))
        return rows

    def coupled(self, package, work):
        execution = self.Execution.from_ssp_file(str(package), H * 1e9)
        assert execution.add_observer(self.observer)
        ends = [name.split(".", 1) for name in ALL]
        slaves = {component: self.reader(execution, component) for component, _ in ends}
        rows = []
        for k in range(1, round(COUPLED / H) // EVERY + 1):
            assert execution.simulate_until(round(k * EVERY * H * 1e9))
            found = [(slaves[c][0], slaves[c][1][name]) for c, name in ends]
            rows.append([self.observer.last_real_values(index, [reference])[0] for index, reference in found])
        return rows


class Fmuloader:
    """Calls of the C functions from Python; of FMI 3.0, scalars only."""

    def alone(self, model, fmu_dir, work):
        import fmpy
        from fmuloader.fmi3 import Fmi3Slave

        path = fmu_dir / f"{model}.fmu"
        description = fmpy.read_model_description(str(path))
        references = {v.name: v.valueReference for v in description.modelVariables}
        slave = Fmi3Slave(str(path), model_identifier=model)
        slave.instantiate_co_simulation("fmu", instantiation_token=description.instantiationToken)
        slave.enter_initialization_mode(start_time=0.0, stop_time=ALONE)
        slave.exit_initialization_mode()
        rows = []
        for k in range(STEPS):
            inputs = driven(model, k * H)
            slave.set_float64([references[name] for name in inputs], list(inputs.values()))
            slave.do_step(k * H, H)
            rows.append(slave.get_float64([references[name] for name in OUTPUTS[model]]))
        slave.terminate()
        slave.free_instance()
        return rows


class FmiSim:
    """rust-fmi's command line: one FMU, inputs and outputs as CSV."""

    PROGRAM = os.environ.get("FMI_SIM", "fmi-sim")

    def alone(self, model, fmu_dir, work):
        titles, rows = table(model)
        with (work / "in.csv").open("w", newline="") as file:
            csv.writer(file).writerows([titles, *([repr(value) for value in row] for row in rows)])
        command = [self.PROGRAM, "--model", fmu_dir / f"{model}.fmu", "-i", "in.csv", "-o", "out.csv"]
        command += ["co-simulation", "-s", "0", "-f", ALONE, "--output-interval", H]
        subprocess.run(list(map(str, command)), cwd=work, check=True, stdout=subprocess.DEVNULL)
        with (work / "out.csv").open() as file:
            found = list(csv.DictReader(file))
        return [[float(row[name]) for name in OUTPUTS[model]] for row in found][1:]


def main():
    importer, kind, model, fmu_dir, work = sys.argv[1:]
    fmu_dir, work = Path(fmu_dir), Path(work)
    logging.disable(logging.INFO)
    kept = os.dup(1)
    os.dup2(2, 1)  # importers print; only the result goes to stdout
    from containers import FMPyContainer, ToolboxParallel, ToolboxSequential

    classes = (FMPy, FMPyContainer, Ecos, Libcosim, Fmuloader, FmiSim, ToolboxParallel, ToolboxSequential)
    runner = {c.__name__: c for c in classes}[importer]()
    values = runner.alone(model, fmu_dir, work) if kind == "alone" else runner.coupled(fmu_dir / model, work)
    os.write(kept, json.dumps(values).encode())
    os._exit(0)  # some importers crash while Python takes them down; what they computed is out


if __name__ == "__main__":
    main()
