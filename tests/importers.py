"""Runs the packed system in one importer, in a process of its own: `python importers.py NAME FMU_DIR WORK_DIR` prints JSON.

Every importer runs what it is given and nothing else: the packed .ssp with its start values, `END` seconds at 1 ms; and, alone,
the manipulator falling for `ALONE` seconds with no forces.
"""

import ctypes
import json
import logging
import os
import subprocess
import sys
from pathlib import Path

H, END, ALONE = 1e-3, 5.0, 0.5
STROKES = [f"x[{i}]" for i in (1, 2, 3)]
ANGLES = [f"zeta[{i}]" for i in range(1, 7)]


def fmpy_alone(fmu_dir, work):
    import fmpy

    result = fmpy.simulate_fmu(str(fmu_dir / "Hdrm.fmu"), stop_time=ALONE, step_size=H, output_interval=H, output=ANGLES)
    return [float(result[name][-1]) for name in ANGLES]


def fmpy_container(fmu_dir, work):
    """FMPy's container FMU with the components and connections of the SSD, run in FMPy."""
    import fmpy
    from fmpy.container_fmu import Configuration
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy.container_fmu.config import Component, Connection
    from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown

    from fmpy_master import ROOT
    from system import System

    system = System.read(ROOT / "system/SystemStructure.ssd")
    components, variables = {}, {}
    for name, file in system.components.items():
        description = fmpy.read_model_description(str(fmu_dir / file))
        components[name] = Component(name, fmu_dir / file, description)
        variables[name] = {v.name: v for v in description.modelVariables}
        for variable in description.modelVariables:
            variable.type = {"Real": "Float64"}.get(variable.type, variable.type)  # the container speaks FMI 3
    connections = [
        Connection(components[a], [variables[a][x]], components[b], [variables[b][y]])
        for (a, x), (b, y) in ((link.source, link.target) for link in system.links)
    ]
    description = ModelDescription(
        fmiVersion="3.0", modelName="Container", instantiationToken="container",
        coSimulation=CoSimulation(modelIdentifier="container_fmu", fixedInternalStepSize=H, canHandleVariableCommunicationStepSize=True),
        defaultExperiment=DefaultExperiment(startTime="0", stopTime=str(END)),
    )  # fmt: skip
    mappings = {}
    time = ModelVariable(name="time", valueReference=0, type="Float64", causality="independent", variability="continuous")
    description.modelVariables.append(time)
    for name in STROKES:
        variable = ModelVariable(name=f"hdrm.{name}", valueReference=0, type="Float64", causality="output", variability="continuous")
        description.modelVariables.append(variable)
        description.outputs.append(Unknown(variable=variable))
        mappings[variable] = [(components["hdrm"], variables["hdrm"][name])]
    for name, values in system.parameters.items():
        for parameter, value in values.items():
            variable = ModelVariable(
                name=f"{name}.{parameter}", valueReference=0, type="Float64", causality="parameter", variability="fixed", start=str(value)
            )
            description.modelVariables.append(variable)
            mappings[variable] = [(components[name], variables[name][parameter])]
    folder, path = work / "container", work / "Container.fmu"
    folder.mkdir()
    create_container_fmu(Configuration(False, description, list(components.values()), connections, mappings), folder, path)
    result = fmpy.simulate_fmu(str(path), stop_time=END, step_size=H, output_interval=H)
    return [float(result[f"hdrm.{name}"][-1]) for name in STROKES]


def ecos(fmu_dir):
    # The wheel does not bring its libtbb.so.12; that of the tbb wheel, loaded first, is found by name.
    ctypes.CDLL(str(Path(sys.prefix, "lib/libtbb.so.12")), ctypes.RTLD_GLOBAL)
    import ecospy

    ecospy.EcosLib.set_log_level("warn")
    return ecospy


def ecos_alone(fmu_dir, work):
    ecospy = ecos(fmu_dir)
    structure = ecospy.EcosSimulationStructure()
    structure.add_model("hdrm", fmu_dir / "Hdrm.fmu")
    simulation = ecospy.EcosSimulation(H, structure=structure)
    return _ecos(simulation, ALONE, ANGLES)


def ecos_coupled(fmu_dir, work):
    return _ecos(ecos(fmu_dir).EcosSimulation(H, ssp_path=str(fmu_dir / "Manipulator.ssp")), END, STROKES)


def _ecos(simulation, end, names):
    assert simulation.init()
    simulation.step(round(end / H))
    return [simulation.get_real(f"hdrm::{name}") for name in names]


def cosim_alone(fmu_dir, work):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(H * 1e9)
    assert execution.add_local_slave(CosimLocalSlave(str(fmu_dir / "Hdrm.fmu"), "hdrm")) == 0
    return _cosim(execution, ALONE, ANGLES)


def cosim_coupled(fmu_dir, work):
    from libcosimpy.CosimExecution import CosimExecution

    return _cosim(CosimExecution.from_ssp_file(str(fmu_dir / "Manipulator.ssp"), H * 1e9), END, STROKES)


def _cosim(execution, end, names):
    from libcosimpy.CosimObserver import CosimObserver

    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    slave = execution.slave_index_from_instance_name("hdrm")
    references = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
    assert execution.simulate_until(end * 1e9)
    return observer.last_real_values(slave, [references[name] for name in names])


def initialized(fmu_dir, work):
    """The system, and what each connected input is after initialization, by the FMPy master."""
    from fmpy_master import ROOT, Master
    from fmu import Fmu
    from system import System

    system = System.read(ROOT / "system/SystemStructure.ssd")
    fmus = {f: Fmu(fmu_dir / f, work / "unpacked" / f) for f in set(system.components.values())}
    master = Master(system, fmus)
    return system, {link.target: master.instances[link.target[0]].get(link.target[1]) for link in system.links}


def toolbox(fmu_dir, work, sequential):
    """A container FMU of the five instances by fmu-manipulation-toolbox, run in FMPy.

    The toolbox initializes components of a loop of links one by one without each other's values, so that the actuators would
    start at a wrong rod position; the start values say what the inputs are.
    """
    import fmpy

    system, inputs = initialized(fmu_dir, work)
    assembly = {
        "name": "Container.fmu",
        "step_size": H,
        "sequential": sequential,
        "auto_link": False,
        "auto_input": False,
        "auto_output": False,
        "fmu": [f"{name}.fmu" for name in reversed(system.components)],
        "path": {f"{name}.fmu": str(fmu_dir / file) for name, file in system.components.items()},
        "link": [[f"{a}.fmu", x, f"{b}.fmu", y] for (a, x), (b, y) in ((link.source, link.target) for link in system.links)],
        "output": [["hdrm.fmu", name, f"stroke_{i}"] for i, name in enumerate(STROKES)],
        "start": [[f"{component}.fmu", name, value] for (component, name), value in inputs.items()]
        + [[f"{component}.fmu", name, value] for component, values in system.parameters.items() for name, value in values.items()],
    }
    (work / "container.json").write_text(json.dumps(assembly))
    tool = Path(sys.executable).with_name("fmucontainer")
    subprocess.run([tool, "-container", "container.json", "-fmu-directory", "."], cwd=work, check=True, stdout=sys.stderr)
    names = [f"stroke_{i}" for i in range(len(STROKES))]
    result = fmpy.simulate_fmu(str(work / "Container.fmu"), stop_time=END, step_size=H, output_interval=H, output=names)
    return [float(result[name][-1]) for name in names]


def toolbox_parallel(fmu_dir, work):
    return toolbox(fmu_dir, work, sequential=False)


def toolbox_sequential(fmu_dir, work):
    return toolbox(fmu_dir, work, sequential=True)


def main():
    name, fmu_dir, work = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    kept = os.dup(1)
    os.dup2(2, 1)  # importers print; only the result goes to stdout
    values = globals()[name](fmu_dir, work)
    os.write(kept, json.dumps(list(values)).encode())
    os._exit(0)  # some importers crash while Python takes them down; what they computed is out


if __name__ == "__main__":
    main()
