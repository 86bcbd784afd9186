"""Importers that put FMUs into one container FMU, which FMPy runs: FMPy's own and fmu-manipulation-toolbox's."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

from importers import ALL, COUPLED, EVERY, H, OUTPUTS, driven, simulated


class FMPyContainer:
    def alone(self, model, fmu_dir, work):
        inputs = [("fmu", name) for name in driven(model, 0.0)]
        outputs = [("fmu", name) for name in OUTPUTS[model]]
        path = self._make(fmu_dir, work, {"fmu": f"{model}.fmu"}, [], inputs, outputs, {})
        return simulated(path, model)

    def coupled(self, package, work):
        from system import System

        system = System.read(package)
        outputs = [tuple(name.split(".", 1)) for name in ALL]
        values = {c: {n: p.value for n, p in found.items()} for c, found in system.parameters.items()}
        path = self._make(package.parent, work, system.components, system.links, [], outputs, values)
        return simulated(path, names=ALL, end=COUPLED)[EVERY - 1 :: EVERY]

    def _make(self, fmu_dir, work, files, links, inputs, outputs, parameters):
        """A container with these components (name: file), connections, inputs, outputs and parameter values; its path."""
        import fmpy
        from fmpy.container_fmu import Configuration
        from fmpy.container_fmu.cli import create_container_fmu
        from fmpy.container_fmu.config import Component, Connection
        from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown

        components, variables = {}, {}
        for name, file in files.items():
            description = fmpy.read_model_description(str(fmu_dir / file))
            components[name] = Component(name, fmu_dir / file, description)
            variables[name] = {v.name: v for v in description.modelVariables}
            for variable in description.modelVariables:
                variable.type = {"Real": "Float64"}.get(variable.type, variable.type)  # the container speaks FMI 3
        connections = [
            Connection(components[a], [variables[a][x]], components[b], [variables[b][y]])
            for (a, x), (b, y) in ((link.source, link.target) for link in links)
        ]
        description = ModelDescription(
            fmiVersion="3.0", modelName="Container", instantiationToken="container",
            coSimulation=CoSimulation(
                modelIdentifier="container_fmu", fixedInternalStepSize=H, canHandleVariableCommunicationStepSize=True
            ),
            defaultExperiment=DefaultExperiment(startTime="0", stopTime="1"),
        )  # fmt: skip
        time = ModelVariable(name="time", valueReference=0, type="Float64", causality="independent", variability="continuous")
        description.modelVariables.append(time)
        mappings = {}

        def expose(ends, causality, variability, start=None):
            for component, name in ends:
                value = variables[component][name].start if start is None else start[component][name]
                variable = ModelVariable(
                    name=name if len(files) == 1 else f"{component}.{name}",
                    valueReference=0,
                    type="Float64",
                    causality=causality,
                    variability=variability,
                    start=None if causality == "output" else str(value),
                )
                description.modelVariables.append(variable)
                mappings[variable] = [(components[component], variables[component][name])]
                if causality == "output":
                    description.outputs.append(Unknown(variable=variable))

        expose(inputs, "input", "continuous")
        expose(outputs, "output", "continuous")
        expose([(c, name) for c, values in parameters.items() for name in values], "parameter", "fixed", parameters)
        folder, path = work / "container", work / "Container.fmu"
        folder.mkdir()
        create_container_fmu(Configuration(False, description, list(components.values()), connections, mappings), folder, path)
        return path


class Toolbox:
    """fmu-manipulation-toolbox: a container from a JSON description, which for the coupled system it writes from the .ssp itself."""

    sequential = False

    def alone(self, model, fmu_dir, work):
        inputs, outputs = driven(model, 0.0), OUTPUTS[model]
        assembly = self._settings() | {"fmu": [f"{model}.fmu"], "path": {f"{model}.fmu": str(fmu_dir / f"{model}.fmu")}}
        assembly["input"] = [[name, f"{model}.fmu", name] for name in inputs]
        assembly["output"] = [[f"{model}.fmu", name, name] for name in outputs]
        return simulated(self._make(assembly, work), model)

    def coupled(self, package, work):
        shutil.copy(package, work)
        self._run(work, f"Manipulator.ssp:{H}", "-dump-json")
        assembly = json.loads((work / "Manipulator-dump.json").read_text()) | self._settings()
        # The dump knows neither parameter values nor outputs. The manipulator must come first: see docs/fmus/interoperability.md.
        files = {"hdrm": "Hdrm", "emla_1": "Emla", "emla_2": "Emla-1", "emla_3": "Emla-2", "controller": "Controller"}
        names = {component: f"Manipulator.dir/{file}.fmu" for component, file in files.items()}
        assert sorted(names.values()) == sorted(assembly["fmu"])
        assembly["fmu"] = list(names.values())
        ends = {f"signal_{i}": signal.split(".", 1) for i, signal in enumerate(ALL)}
        assembly["output"] = [[names[component], name, signal] for signal, (component, name) in ends.items()]
        assembly["start"] = [[names[component], "alpha", 0.2] for component in names if component != "hdrm"]
        return simulated(self._make(assembly, work), names=list(ends), end=COUPLED)[EVERY - 1 :: EVERY]

    def _settings(self):
        automatic = dict.fromkeys(("auto_link", "auto_input", "auto_output"), False)
        return {"name": "Container.fmu", "step_size": H, "sequential": self.sequential, **automatic}

    def _make(self, assembly, work):
        (work / "container.json").write_text(json.dumps(assembly))
        self._run(work, "container.json")
        return work / "Container.fmu"

    def _run(self, work, *arguments):
        tool = Path(sys.executable).with_name("fmucontainer")
        subprocess.run([tool, "-container", *arguments, "-fmu-directory", "."], cwd=work, check=True, stdout=sys.stderr)


class ToolboxParallel(Toolbox):
    pass


class ToolboxSequential(Toolbox):
    sequential = True
