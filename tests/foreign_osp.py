"""Every system of the Open Simulation Platform in a folder, in `cosim` and in libcosim: a table of what runs, what differs, and why not.

    python tests/foreign_osp.py FOLDER [--steps 2000] [--program target/release/cosim]

FOLDER holds repositories with files *OspSystemStructure*.xml; nothing of them is kept here. Both programs make the same fixed steps
(`standard`, BaseStepSize), and all real outputs are compared whenever their simulator has ended a step. libcosim is given a copy with absolute
sources and the algorithm fixedStep. FMUs of FMI 1.0 named `identity` are replaced in both by the one in master/cosim/tests/fmus, which has the
same variables. master/cosim/foreign.md has what was seen, with revisions.
"""

import argparse
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import numpy as np

FMUS = Path(__file__).resolve().parent.parent / "master/cosim/tests/fmus"
REST = (
    "SetDebugLogging Reset GetString SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate "
    "GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives CancelStep GetStatus GetRealStatus GetIntegerStatus "
    "GetBooleanStatus GetStringStatus"
).split()
NAMESPACE = "{http://opensimulationplatform.com/MSMI/OSPSystemStructure}"


def identity(folder):
    """The FMU of FMI 2.0 in place of libcosim's `identity.fmu`, packed."""
    library, packed, rest = folder / "lags.so", folder / "identity.fmu", folder / "rest.c"
    # libcosim loads no library that lacks a function.
    text = 'const char *fmi2GetTypesPlatform() { return "default"; }\nconst char *fmi2GetVersion() { return "2.0"; }\n'
    rest.write_text(text + "".join(f"int fmi2{name}() {{ return 0; }}\n" for name in REST))
    subprocess.run(["cc", "-w", "-shared", "-fPIC", "-o", library, FMUS / "lags.c", rest], check=True)
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(FMUS / "lags.xml", "modelDescription.xml")
        archive.write(library, "binaries/linux64/lags.so")
    return packed


def copied(file, folder, replacement):
    """The system with absolute sources and the algorithm fixedStep, its base step, and the steps of its simulators in base steps."""
    root = ET.parse(file).getroot()
    find = lambda tag: root.find(NAMESPACE + tag)
    for tag in ("Algorithm", "EccoConfiguration"):
        if find(tag) is not None:
            root.remove(find(tag))
    base = find("BaseStepSize")
    base = 0.1 if base is None else float(base.text)
    algorithm = ET.Element(NAMESPACE + "Algorithm")
    algorithm.text = "fixedStep"
    root.insert([child.tag for child in root].index(NAMESPACE + "Simulators"), algorithm)
    every = {}
    for simulator in find("Simulators"):
        source = simulator.get("source")
        if ":" not in source:
            path = (file.parent / source).resolve()
            path = replacement if path.name == "identity.fmu" else path
            simulator.set("source", path.as_uri())
        step = float(simulator.get("stepSize", base))
        every[simulator.get("name")] = max(1, math.floor(round(step * 1e9) / round(base * 1e9)))
    ET.register_namespace("", NAMESPACE[1:-1])
    (folder / "OspSystemStructure.xml").write_bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True))
    for groups in file.parent.glob("*OspModelDescription.xml"):
        (folder / groups.name).write_bytes(groups.read_bytes())
    return base, every


def libcosim(folder, steps):
    """Names of the real outputs, and their values after each step."""
    from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution, observer = CosimExecution.from_osp_config_file(str(folder)), CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    ends, names = [], []
    for slave in execution.slave_infos():
        for variable in execution.slave_variables(slave.index):
            if variable.type == CosimVariableType.REAL.value and variable.causality == CosimVariableCausality.OUTPUT.value:
                ends.append((slave.index, variable.reference))
                names.append(f"{slave.name.decode()}.{variable.name.decode()}")
    rows = []
    for _ in range(steps):
        assert execution.step()
        rows.append([observer.last_real_values(slave, [reference])[0] for slave, reference in ends])
    return names, rows


def elsewhere(folder, steps):
    """The same in a process of its own: it may end its process."""
    done = subprocess.run([sys.executable, __file__, "rows", folder, str(steps)], capture_output=True, text=True, errors="replace")
    lines = [line for line in done.stdout.splitlines() if line.startswith("[[")]
    if not lines:
        return None, (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    return json.loads(lines[-1]), ""


def start_of(file):
    found = re.search(r"<StartTime>\s*([^<\s]+)", file.read_text())
    return float(found[1]) if found else 0.0


def cosim(program, file, stop, folder, more=()):
    """The rows of the program, by name, and why not."""
    out = folder / "run.csv"
    command = [program, "run", file, "--schedule", "standard", "--stop-time", repr(stop), "--quiet", "--csv", out, "--signals", "*", *more]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        return None, done.stderr.strip().splitlines()[-1].removeprefix("error: ")
    with out.open() as text:
        titles, *rows = csv.reader(text)
    return {title: [row[k] for row in rows] for k, title in enumerate(titles)}, ""


def difference(ours, names, rows, every):
    """Largest difference of a real output, of its peak, at the ends of its simulator's steps."""
    worst, compared = 0.0, 0
    for name, column in zip(names, np.array(rows).T):
        step = every[next(s for s in sorted(every, key=len, reverse=True) if name.startswith(f"{s}."))]
        a, b = np.array(ours[name][1:], dtype=float)[step - 1 :: step], column[step - 1 :: step]
        worst, compared = max(worst, np.abs(a - b).max() / (np.abs(b).max() or 1.0)), compared + 1
    return worst, compared


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--steps", type=int, default=2000)
    arguments = parser.parse_args()
    for file in sorted(arguments.folder.rglob("*OspSystemStructure*.xml")):
        title = file.relative_to(arguments.folder)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            _, why = cosim(arguments.program, file, start_of(file) + 0.5, folder)
            as_it_is = f"refused: {why}" if why else "runs"
            base, every = copied(file, folder, identity(folder))
            copy = folder / "OspSystemStructure.xml"
            ours, _ = cosim(arguments.program, copy, start_of(file) + arguments.steps * base, folder, ["--step", repr(base)])
            print(f"{title}: {as_it_is[:300]}")
            if ours is None:
                continue
            found, other = elsewhere(folder, arguments.steps)
            if found is None:
                print(f"  libcosim does not run it: {other[:300]}")
                continue
            worst, count = difference(ours, *found, every)
            print(f"  {arguments.steps} steps of {base} s, {count} real outputs; largest difference from libcosim, of the peak: {worst:.2g}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["rows"]:
        names, rows = libcosim(sys.argv[2], int(sys.argv[3]))
        sys.stdout.write(f"\n{json.dumps([names, rows])}\n")
        sys.stdout.flush()
        os._exit(0)  # some FMUs crash while Python takes them down
    main()
