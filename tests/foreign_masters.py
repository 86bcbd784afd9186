"""The crane and the quarter car of libcosim's test data in `cosim`, libcosim and ecos, step by step: a table of what differs, and why.

    python tests/foreign_masters.py FOLDER [--steps 10000] [--program target/release/cosim]

FOLDER holds the files of github.com/open-simulation-platform/libcosim; nothing of them is kept here. All of them exchange values once a step
(`standard`), from the same start values. What they do not have in common is the arithmetic of time: where a step begins and how long it is.
The master of these tests makes each run a second time with the arithmetic of the other program; where that is the same to the last bit, the
arithmetic is all that differs. master/cosim/foreign.md has what was seen, with revisions.
"""

import argparse
import csv
import ctypes
import json
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from fmpy_master import Master
from fmu import opened
from system import System

H = 1e-4
FMUS = "tests/data/fmi2"

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="System">
"""

#: Systems: FMUs and start values by component, connections, further signals. Those of the crane are the ones of libcosim's demo.
AXES = (1, 2, 3)
SYSTEMS = {
    "crane": {
        "components": {
            "CraneController": ("CraneController.fmu", {}),
            "KnuckleBoomCrane": ("KnuckleBoomCrane.fmu", {"Spring_Joint.k": 0.005, "mt0_init": 69.0}),
        },
        "links": [
            *((f"CraneController.p_Crane.e[{k}]", f"KnuckleBoomCrane.p_Crane.e[{k}]") for k in AXES),
            *((f"KnuckleBoomCrane.p_Crane.f[{k}]", f"CraneController.p_Crane.f[{k}]") for k in AXES),
            *((f"KnuckleBoomCrane.Act_Limits[{k}]", f"CraneController.Act_Limits[{k}]") for k in AXES),
        ],
    },
    "quarter car": {
        "components": {
            "chassis": ("quarter_truck/Chassis.fmu", {"mass": 400.0, "initialPositionY": 0.1, "timeStep": 1e-5}),
            "wheel": ("quarter_truck/Wheel.fmu", {"mass": 40.0, "timeStep": 1e-5}),
        },
        "links": [("chassis.velocity", "wheel.in_vel"), ("wheel.out_spring_damper_f", "chassis.force")],
        "more": ["chassis.position", "wheel.position"],
    },
}


def pack(system, data, file):
    """An .ssp that all of them read: Real connectors, one bound set a component."""
    text, ends = HEAD + '<ssd:System name="System"><ssd:Elements>', [end for link in system["links"] for end in link]
    for name, (fmu, values) in system["components"].items():
        own = {end.split(".", 1)[1]: k % 2 for k, end in enumerate(ends) if end.startswith(f"{name}.")}
        connectors = "".join(f'<ssd:Connector name="{v}" kind="{("output", "input")[k]}"><ssc:Real/></ssd:Connector>' for v, k in own.items())
        reals = "".join(f'<ssv:Parameter name="{v}"><ssv:Real value="{value!r}"/></ssv:Parameter>' for v, value in values.items())
        bound = f"""<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" name="initialValues">
            <ssv:Parameters>{reals}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"""
        source = f"resources/{Path(fmu).name}"
        text += f'<ssd:Component name="{name}" source="{source}"><ssd:Connectors>{connectors}</ssd:Connectors>{bound if reals else ""}</ssd:Component>'
    connection = '<ssd:Connection startElement="{}" startConnector="{}" endElement="{}" endConnector="{}"/>'
    links = "".join(connection.format(*a.split(".", 1), *b.split(".", 1)) for a, b in system["links"])
    text += f"</ssd:Elements><ssd:Connections>{links}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        for fmu, _ in system["components"].values():
            archive.write(data / FMUS / fmu, f"resources/{Path(fmu).name}")


def signals(system):
    return [*dict.fromkeys(start for start, _ in system["links"]), *system.get("more", ())]


def libcosim(package, names, steps):
    """Time there is a whole number of nanoseconds; a step ends at the double nearest to it."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution, observer = CosimExecution.from_ssp_file(str(package), round(H * 1e9)), CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    ends = []
    for name in names:
        component, variable = name.split(".", 1)
        slave = execution.slave_index_from_instance_name(component)
        ends.append((slave, next(v.reference for v in execution.slave_variables(slave) if v.name.decode() == variable)))
    rows = []
    for _ in range(steps):
        assert execution.step()
        rows.append([observer.last_real_values(slave, [reference])[0] for slave, reference in ends])
    return rows


def ecos(package, names, steps):
    """Time there is a sum: t += h."""
    ctypes.CDLL(str(Path(sys.prefix, "lib/libtbb.so.12")), ctypes.RTLD_GLOBAL)
    import ecospy

    simulation = ecospy.EcosSimulation(H, ssp_path=str(package))
    assert simulation.init(parameter_set="initialValues")
    rows = []
    for _ in range(steps):
        simulation.step()
        rows.append([simulation.get_real(name.replace(".", "::", 1)) for name in names])
    return rows


PROGRAMS = {"libcosim": libcosim, "ecos": ecos}


def nanoseconds(k):
    """Start and length of step k as libcosim gives them to an FMU (time.hpp)."""
    begin, end = (round(H * 1e9) * n / 1e9 for n in (k, k + 1))
    return begin, end - begin


def multiples(k):
    """As `cosim`."""
    return k * H, H


def sums(k, known=[0.0]):
    """As ecos."""
    while len(known) <= k:
        known.append(known[-1] + H)
    return known[k], H


CLOCKS = {"cosim": multiples, "libcosim": nanoseconds, "ecos": sums}


def by_hand(package, names, steps, clock):
    """The master of these tests with another clock."""

    class Clocked(Master):
        def interval(self):
            return clock(self.steps)

    system = System.read(package)
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(package) as archive:
        archive.extractall(folder)
        fmus = {file: opened(Path(folder, source), Path(folder, Path(file).stem)) for file, source in system.sources.items()}
        master = Clocked(system, fmus, schedule="standard", h=H)
        return master.record(steps * H, names)[1][1:]


def cosim(program, package, names, steps, folder):
    out = folder / "run.csv"
    command = [program, "run", package, "--schedule", "standard", "--step", H, "--stop-time", steps * H, "--quiet", "--csv", out]
    subprocess.run([str(part) for part in (*command, "--signals", ",".join(names))], check=True, stdout=subprocess.DEVNULL)
    with out.open() as file:
        titles, *rows = csv.reader(file)
    columns = dict(zip(titles, np.array(rows, dtype=float).T))
    return np.column_stack([columns[name] for name in names])[1:]


def elsewhere(*arguments):
    """The rows of this program with these arguments, in a process of its own: some programs end theirs."""
    done = subprocess.run([sys.executable, __file__, *map(str, arguments)], capture_output=True, text=True, errors="replace")
    lines = [line for line in done.stdout.splitlines() if line.startswith("[[")]
    if not lines:
        return None, (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    return np.array(json.loads(lines[-1])), ""


def difference(a, b):
    """Largest difference of a signal, of its peak."""
    peaks = np.abs(a).max(axis=0)
    return (np.abs(a - b).max(axis=0) / np.where(peaks > 0.0, peaks, 1.0)).max()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--steps", type=int, default=10_000)
    arguments = parser.parse_args()
    for title, system in SYSTEMS.items():
        names = signals(system)
        with tempfile.TemporaryDirectory() as folder:
            package = Path(folder, "system.ssp")
            pack(system, arguments.folder, package)
            ours = cosim(arguments.program, package, names, arguments.steps, Path(folder))
            hand, why = elsewhere("rows", "cosim", package, arguments.steps, *names)
            print(f"{title}, {arguments.steps} steps of {H} s, {len(names)} signals; largest difference of a signal, of its peak")
            print(f"  cosim compared with the master of these tests: {why or difference(ours, hand)}")
            for program in PROGRAMS:
                theirs, why = elsewhere("rows", program, package, arguments.steps, *names)
                if theirs is None:
                    print(f"  {program} does not run it: {why}")
                    continue
                hand, _ = elsewhere("rows", f"clock of {program}", package, arguments.steps, *names)
                print(f"  cosim compared with {program}: {difference(ours, theirs):.2g}; with the clock of {program}: {difference(hand, theirs):.2g}")


def rows(what, package, steps, *names):
    """What `elsewhere` asks for."""
    if what in PROGRAMS:
        found = PROGRAMS[what](package, names, int(steps))
    else:
        found = by_hand(Path(package), names, int(steps), CLOCKS[what.removeprefix("clock of ")]).tolist()
    sys.stdout.write(f"\n{json.dumps(found)}\n")
    sys.stdout.flush()
    os._exit(0)  # some of them crash while Python takes them down


if __name__ == "__main__":
    rows(*sys.argv[2:]) if sys.argv[1:2] == ["rows"] else main()
