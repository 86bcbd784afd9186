"""One FMU by itself in `cosim` and in FMPy's slave driven by hand: the same start, stop, tolerance, steps and inputs; equal to the last bit?

    python tests/alone.py FOLDER [--program target/release/cosim] [--steps 1000]

tries every FMU of a folder, each in a process of its own, and prints a table. master/cosim/foreign.md has what was seen of other people's.
"""

import argparse
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np

from fmu import Refused, opened

#: Types whose values `cosim` writes as numbers that FMPy gives, too.
WRITTEN = ("Real", "Integer", "Boolean", "Enumeration")


def outputs(fmu):
    """Names of the outputs that are compared."""
    return [name for name in fmu.names("output") if fmu.variables[name].type in WRITTEN]


def start_and_step(fmu):
    """Start time and step that the FMU asks for, s; as in `cosim`."""
    experiment = fmu.description.defaultExperiment
    found = lambda name, default: float(getattr(experiment, name, None) or default)
    return found("startTime", 0.0), found("stepSize", 1e-3)


def told(fmu, start, h, steps):
    """Stop time and tolerance that `cosim` tells an FMU: the end of the last step, and what its description asks for."""
    stop = start + steps * h
    last = start + (math.floor((stop - start) / h + 1e-6) - 1) * h
    tolerance = getattr(fmu.description.defaultExperiment, "tolerance", None)
    return {"stop": max(stop, last + h), "tolerance": float(tolerance) if tolerance and float(tolerance) > 0 else None}


def by_fmpy(fmu, start, h, steps, inputs=None, settings=None):
    """Rows of the outputs at the communication points; `inputs` by time are set at each before it is read. What a step that fails leaves out."""
    has_events = fmu.description.fmiVersion.startswith("3.") and fmu.description.coSimulation.hasEventMode
    instance = fmu.instance("alone", logging=True, staged=bool(has_events))
    if not instance.component:
        raise Refused("instantiation", None, instance.text)
    instance.enter_initialization(start, values=settings, **told(fmu, start, h, steps))
    instance.exit_initialization()
    names, rows = outputs(fmu), []
    for k in range(steps + 1):
        if k > 0:  # initialization ends in Event Mode
            instance.enter_events()
        if inputs:
            instance.set(inputs(start + k * h))
        values = instance.get(*names)
        rows.append([float(value) for value in (values if len(names) > 1 else [values])])
        if k == steps:
            break
        try:
            instance.leave_events()
            instance.step(start + k * h, h)
        except Refused:
            break
    instance.free()
    return np.array(rows)


def by_cosim(program, path, names, start, h, steps, inputs=None, settings=None):
    """The same rows of `cosim run`."""
    with tempfile.TemporaryDirectory() as folder:
        out, component = Path(folder, "run.csv"), Path(path).stem
        command = [program, "run", path, "--quiet", "--step", repr(h), "--stop-time", repr(start + steps * h), "--csv", out]
        command += ["--signals", ",".join(f"{component}.{name}" for name in names)]
        command += [option for name, value in (settings or {}).items() for option in ("--set", f"{component}.{name}={value}")]
        if inputs:
            rows = [(start + k * h, inputs(start + k * h)) for k in range(steps + 1)]
            given = Path(folder, "inputs.csv")
            with given.open("w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(["time", *(f"{component}.{name}" for name in rows[0][1])])
                writer.writerows([repr(t), *map(repr, values.values())] for t, values in rows)
            command += ["--input", given]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL)
        if done.returncode != 0:
            raise RuntimeError(next((line for line in done.stderr.splitlines() if line.startswith("error: ")), done.stderr[-200:]))
        with out.open() as file:
            titles, *rows = csv.reader(file)
    columns = dict(zip(titles, np.array(rows, dtype=float).T))
    return np.column_stack([columns[f"{component}.{name}"] for name in names])


def compared(program, path, steps):
    """What is said of an FMU."""
    with tempfile.TemporaryDirectory() as folder:
        version = fmpy.read_model_description(str(path), validate=False).fmiVersion
        if version.startswith("1."):
            return f"FMI {version}: cosim runs FMI 2.0 and 3.0"
        fmu = opened(path, folder)
        names, (start, h) = outputs(fmu), start_and_step(fmu)
        if not names:
            return "no outputs"
        theirs = by_fmpy(fmu, start, h, steps)
        ours = by_cosim(program, path, names, start, h, steps)
    rows = min(len(ours), len(theirs))
    same = ours[:rows].tobytes() == theirs[:rows].tobytes()
    found = f"FMI {fmu.description.fmiVersion}, {len(names)} outputs, {rows - 1} steps of {h} s: "
    if not same:
        where = np.argwhere(ours[:rows] != theirs[:rows])[0]
        found += f"{names[where[1]]} differs after {where[0]} steps, {ours[tuple(where)]!r} and {theirs[tuple(where)]!r}"
    return found + ("every bit" if same else "") + ("" if len(ours) == len(theirs) else f"; {len(ours)} and {len(theirs)} points")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--steps", type=int, default=1000)
    arguments = parser.parse_args()
    if arguments.folder.is_file():
        print("\n= " + compared(arguments.program, arguments.folder, arguments.steps), flush=True)
        return
    for file in sorted(arguments.folder.rglob("*.fmu")):
        command = [sys.executable, __file__, file, "--program", arguments.program, "--steps", arguments.steps]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace")
        said = [line.removeprefix("= ") for line in done.stdout.splitlines() if line.startswith("= ")]
        print(f"{file.relative_to(arguments.folder)}: {(said or done.stderr.strip().splitlines() or [f'exit code {done.returncode}'])[-1]}")


if __name__ == "__main__":
    main()
