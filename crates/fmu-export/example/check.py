"""Checks the example with FMPy: schema, rules, a run against the closed form, reset, states, file: python check.py <fmu>."""

import math
import sys

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu


def closed_form(t, m, d, k, x0):
    """Free swing of the damped linear oscillator from rest at x0."""
    delta, w = d / (2 * m), math.sqrt(k / m - (d / (2 * m)) ** 2)
    return x0 * np.exp(-delta * t) * (np.cos(w * t) + delta / w * np.sin(w * t))


def main(path):
    problems = validate_fmu(path)
    assert not problems, problems
    description = fmpy.read_model_description(path, validate=True, validate_variable_names=True, validate_model_structure=True)

    # RK4 at 1 ms misses 4e-11 of the amplitude (see the test of the model).
    result = fmpy.simulate_fmu(path, stop_time=5.0, output_interval=0.01, output=["x[1]", "energy"])
    error = np.abs(result["x[1]"] - closed_form(result["time"], 2.0, 1.5, 80.0, 0.1)).max()
    assert error < 1e-10, error
    heavy = {"parameter_file": "heavy.txt", "spring": 1}
    result = fmpy.simulate_fmu(path, stop_time=5.0, output_interval=0.01, output=["x[1]"], start_values=heavy)
    error_heavy = np.abs(result["x[1]"] - closed_form(result["time"], 20.0, 4.5, 80.0, 0.1)).max()
    assert error_heavy < 1e-10, error_heavy

    vr = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    runs = []
    for _ in range(2):
        fmu.setupExperiment(startTime=0.0, stopTime=1.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        states = []
        for k in range(10):
            if k == 5:
                saved = fmu.serializeFMUstate(fmu.getFMUstate())
            fmu.setReal([vr["F[1]"]], [math.sin(k)])
            fmu.doStep(k * 0.1, 0.1)
            states.append(fmu.getReal([vr["x[1]"], vr["v[1]"], vr["a[1]"]]))
        runs.append(states)
        fmu.reset()
    assert runs[0] == runs[1]
    fmu.setFMUstate(fmu.deSerializeFMUstate(saved))
    for k in range(5, 10):
        fmu.setReal([vr["F[1]"]], [math.sin(k)])
        fmu.doStep(k * 0.1, 0.1)
        assert fmu.getReal([vr["x[1]"], vr["v[1]"], vr["a[1]"]]) == runs[0][k]
    assert fmu.getDirectionalDerivative([vr["a[1]"]], [vr["F[1]"]], [3.0]) == [1.5]
    fmu.terminate()
    fmu.freeInstance()
    print(f"valid; error {error:.1e} m and {error_heavy:.1e} m with the file; states continue bit for bit")


if __name__ == "__main__":
    main(sys.argv[1])
