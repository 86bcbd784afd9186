"""Measures what everything costs, as `cargo xtask bench` calls it once all is built.

    python tests/bench/measure.py time OPTIONS           # one table, with other engines measured in the same run
    python tests/bench/measure.py instructions OPTIONS   # counted by valgrind's callgrind, compared with tools/benches/instructions.json

Instruction counts repeat from run to run where times do not, so they show a loss of a few per cent; they are not times. They are those of
one compiler and one C library, so the record holds its environment, and elsewhere more growth is accepted.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "tools/benches/instructions.json"
# Growth over the recorded count that is still accepted, and the same with another compiler, C library or valgrind than those recorded.
GROWTH, GROWTH_ELSEWHERE = 0.03, 0.15
# Most instructions of set + step + get through FMI 3.0, in those through FMI 2.0.
MOST_IN_3 = 1.1
# Bench program and call.
CALLS = (
    ("dynamics", "forward dynamics"),
    ("dynamics", "manipulator outputs"),
    ("step", "actuator step of 1 ms (motion-driven)"),
    ("step", "surrogate evaluation"),
    ("controller", "controller output + step (adaptive)"),
)
COUPLED = "coupled step of 1 ms, cosim, no recording"
RECORDED = "coupled step of 1 ms, cosim with CSV"
# The paper's table, 30 runs; the ratio is the gain by the cores of the machine.
ALL_CORES, ONE_CORE = "hdrm-fmu table, all cores", "hdrm-fmu table, one core"
# Three calls at the border, which cost what the border costs.
IN_RUST, IN_C = "set of 4 + step + get of 4, Rust (fmu-export)", "set of 4 + step + get of 4, C by hand"
# Rows that are compared, by the beginnings of their names; the ratio is that of the second over the first.
COMPARISONS = (
    ("forward dynamics", "Pinocchio"),
    ("forward dynamics", "MuJoCo"),
    ("manipulator step of 1 ms (RK4)", "MuJoCo"),
    ("set of 4 + step + get of 4, Rust", "set of 4 + step + get of 4, C"),
    ("MuJoCo step of 1 ms, RK4", COUPLED),
    ("coupled step of 1 ms, cosim,", "coupled step of 1 ms, FMPy"),
    ("coupled step of 1 ms, cosim,", RECORDED),
    (ALL_CORES, ONE_CORE),
)
ENGINES = "engines.py"
SCRIPTS = (ENGINES, "fmpy_coupled.py", "footprint.py")


def output(command, **options):
    return subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True, **options).stdout


class Archive:
    """What is needed of a packed FMU."""

    def __init__(self, path):
        self.path = path
        with zipfile.ZipFile(path) as archive:
            self.root = ET.fromstring(archive.read("modelDescription.xml"))
        self.name = self.root.get("modelName")
        self.token = self.root.get("guid") or self.root.get("instantiationToken")

    def library(self, folder, work):
        """The library for this machine, unpacked."""
        with zipfile.ZipFile(self.path) as archive:
            name = next(name for name in archive.namelist() if name.startswith(f"binaries/{folder}/"))
            file = work / Path(name).name
            file.write_bytes(archive.read(name))
        return file

    def reference(self, variable):
        return next(v.get("valueReference") for v in self.root.find("ModelVariables") if v.get("name") == variable)


class Built:
    """What was built: packed FMUs, programs, and programs in C."""

    def __init__(self, arguments):
        self.fmus, self.platform, self.work = arguments.fmu, arguments.platform, arguments.work
        self.folder = self.fmus[0].parent
        self.cosim, self.hdrm_fmu, self.integrators = arguments.cosim, arguments.hdrm_fmu, arguments.integrators
        self.programs = dict(text.split("=", 1) for text in arguments.program)
        self.work.mkdir(parents=True, exist_ok=True)

    def coupled(self):
        """`cosim bench` on the packed system: the cubic trajectory, adaptive."""
        sets = ["--set", "controller.trajectory=cubic", "--set", "controller.mode=adaptive"]
        return [self.cosim, "bench", "--system", self.folder / "Manipulator.ssp", *sets]

    def compiled(self, source, *options):
        """A C source of this folder, compiled."""
        program = (self.work / source).with_suffix(".out")
        subprocess.run([os.environ.get("CC", "cc"), "-O2", "-o", program, ROOT / "tests/bench" / source, *options], check=True)
        return program

    def overhead(self):
        """The same FMU from Rust and from C under the same C program."""
        driver, in_c = self.compiled("overhead.c", "-ldl"), self.compiled("integrators.c", "-shared", "-fPIC")
        fmu = Archive(self.integrators)
        in_rust = fmu.library(self.platform, self.work)
        return [[driver, name, library, fmu.token] for name, library in ((IN_RUST, in_rust), (IN_C, in_c))]


def measurements(text):
    """Rows that a program has measured, a line of JSON each."""
    return [(row["name"], row["unit"], row["median"], row["least"]) for row in map(json.loads, text.splitlines())]


def coupled_step(name, text):
    """`cosim bench --json`: its real-time factor as the time of a coupled step."""
    said = json.loads(text)
    median, least = (1e9 * said["step_s"] / said["real_time_factor"][key] for key in ("median", "best"))
    return [(name, "ns", median, least)]


def jobs(built, ratios, python):
    """Pairs of a command and what makes rows of its output and of its time in s; run once a round."""

    def coupled(name, *more):
        return [*built.coupled(), "--stop-time", "10", "--repeat", "3", "--json", *more], lambda text, _: coupled_step(name, text)

    def table(name, threads):
        limit = [] if threads is None else ["env", f"RAYON_NUM_THREADS={threads}"]
        command = [*limit, built.hdrm_fmu, "table", "--system", built.folder / "Manipulator.ssp"]
        return command, lambda _, seconds: [(name, "s", seconds, seconds)]

    def rows(command):
        return command, lambda text, _: measurements(text)

    found = [] if ratios else [rows([program]) for program in built.programs.values()]
    found.append(coupled(COUPLED))
    if not ratios:
        found.append(coupled(RECORDED, "--signals", "*", "--csv", built.work / "bench.csv"))
        found += [table(ONE_CORE, 1), table(ALL_CORES, None)]
    found += map(rows, built.overhead())
    scripts = ([ENGINES] if ratios else SCRIPTS) if python else []
    return found + [rows([sys.executable, ROOT / "tests/bench" / script, built.folder]) for script in scripts]


def timed(arguments):
    values = {}
    work = jobs(Built(arguments), arguments.ratios, not arguments.no_python)
    for k in range(1, max(arguments.rounds, 1) + 1):
        for command, read in work:
            print(f"round {k}: {command[0]}", file=sys.stderr)
            start = time.perf_counter()
            text = output(command)
            for name, unit, median, least in read(text, time.perf_counter() - start):
                row = values.setdefault(name, (unit, [], []))
                row[1].append(median)
                row[2].append(least)
    print(machine() + "\n")
    print(table({name: (unit, statistics.median_high(medians), min(least)) for name, (unit, medians, least) in values.items()}), end="")


def table(rows):
    """Rows (unit, median, least) by name as a table, and ratios of others' costs to ours."""
    lines = [f"| {'measurement':<72} | {'median':>12} | {'least':>12} | unit |", f"|:{'-' * 72}-|-{'-' * 12}:|-{'-' * 12}:|:-----|"]
    lines += [f"| {name:<72} | {median:>12.1f} | {least:>12.1f} | {unit:<4} |" for name, (unit, median, least) in rows.items()] + [""]
    for beginning, others in COMPARISONS:
        base = next((name for name in rows if name.startswith(beginning)), None)
        for other in (name for name in rows if base and name.startswith(others)):
            median, least = (rows[other][k] / rows[base][k] for k in (1, 2))
            lines.append(f"- {other} / {base}: {median:.2f} (least: {least:.2f})")
    for name, (_, median, least) in rows.items():
        if ", cosim" in name:
            lines.append(f"- {name}: {1e6 / median:.0f} x real time (best: {1e6 / least:.0f})")
    return "\n".join(lines) + "\n"


def machine():
    """Processor, load and compiler of this run."""
    cpuinfo = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    processor = next((line.split(": ")[1] for line in cpuinfo.splitlines() if line.startswith("model name")), "unknown")
    system, load = f"{platform.system().lower()} {platform.machine()}", " ".join(f"{x:.2f}" for x in os.getloadavg())
    return f"{processor}, {os.cpu_count()} cores, {system}, load average at the end: {load}; {output(['rustc', '--version']).strip()}"


def environment():
    """System, compiler, C library and valgrind."""
    first = [output([program, "--version"]).splitlines()[0] for program in ("rustc", "ldd", "valgrind")]
    return [f"{platform.system().lower()} {platform.machine()}", *first]


def per_call(few, many, command):
    """Instructions per call, from the difference of two runs: what the start of the program costs drops out."""

    def total(n):
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command(n)]
        said = subprocess.run(list(map(str, valgrind)), capture_output=True, text=True).stderr
        counts = [line.split("Collected :")[1] for line in said.splitlines() if "Collected :" in line]
        if not counts:
            sys.exit(f"error: callgrind gave no count: {said}")
        return int(counts[0])

    return max(total(many) - total(few), 0) // (many - few)


def count(built):
    counts = {call: per_call(100, 200, lambda n: [built.programs[name], "--count", call, n]) for name, call in CALLS}
    # In motion, which starts after 4 s of settling; long enough that a list that grows in between does not count.
    coupled = per_call(4600, 5600, lambda n: [*built.coupled(), "--repeat", 1, "--stop-time", 1e-3 * n])
    counts["coupled step of 1 ms"] = coupled
    driver = built.compiled("overhead.c", "-ldl")
    for fmu in map(Archive, built.fmus):
        command = [driver, fmu.name, fmu.library(built.platform, built.work), fmu.token]
        counts[f"first instance of {fmu.name}"] = per_call(0, 1, lambda n: [*command, n, 0])
    for command in built.overhead():
        counts[command[1]] = per_call(1000, 2000, lambda n: [*command, 1, n])
    return dict(sorted(counts.items()))


def compared(counts, recorded, limit):
    """Prints counts together with the recorded ones; what has grown by more than the limit, or is not recorded, ends the program."""
    print(f"{'instructions per call':<44} {'now':>12} {'recorded':>12} {'growth':>8}")
    grown = []
    for call, now in counts.items():
        if call not in recorded:
            sys.exit(f"error: `{call}` is not recorded")
        growth = now / recorded[call] - 1
        print(f"{call:<44} {now:>12} {recorded[call]:>12} {100 * growth:>7.1f}%")
        grown += [call] * (growth > limit)
    if grown:
        sys.exit(f"error: more than {100 * limit:.0f} % above the record: {', '.join(grown)}")


def borders(built):
    """What a call costs through FMI 3.0 compared with FMI 2.0: one library, both C interfaces."""
    driver = built.compiled("borders.c", "-ldl")

    def both(fmu, *call):
        two, three = Archive(fmu), Archive(fmu.parent / "fmi3" / fmu.name)
        library = two.library(built.platform, built.work)
        commands = ([driver, number, library, fmu.token, *call] for number, fmu in ((2, two), (3, three)))
        return [per_call(1000, 2000, lambda n: [*command, n]) for command in commands]

    two, three = both(built.integrators, "step", 0, 4, 4)
    print(f"set of 4 + step + get of 4: {two} through FMI 2.0, {three} through FMI 3.0")
    if three > MOST_IN_3 * two:
        sys.exit(f"error: through FMI 3.0 it must be at most {MOST_IN_3} times as much")
    hdrm = built.folder / "Hdrm.fmu"
    six, array = both(hdrm, "get", Archive(hdrm).reference("zeta[1]"), 6)
    print(f"get of 6: {six} by six references of FMI 2.0, {array} by one of FMI 3.0")
    if array >= six:
        sys.exit("error: one reference must cost less than six")


def instructions(arguments):
    built = Built(arguments)
    if arguments.record:
        record = json.dumps({"environment": environment(), "counts": count(built)}, indent=2, ensure_ascii=False) + "\n"
        RECORD.write_text(record)
        print(record)
        return
    recorded, limit = json.loads(RECORD.read_text()), GROWTH
    if environment() != recorded["environment"]:
        limit = GROWTH_ELSEWHERE
        there, here = ", ".join(recorded["environment"]), ", ".join(environment())
        print(f"recorded with {there}; here with {here}: growth may reach {limit}")
    compared(count(built), recorded["counts"], limit)
    borders(built)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("time", "instructions"))
    parser.add_argument("--fmu", type=Path, action="append", required=True, help="packed FMU of the suite, beside its systems")
    parser.add_argument("--platform", required=True, help="folder of this machine's libraries in an FMU of FMI 2.0")
    parser.add_argument("--integrators", type=Path, required=True, help="packed example of fmu-export")
    parser.add_argument("--work", type=Path, required=True, help="folder for what is compiled and unpacked")
    parser.add_argument("--cosim", required=True)
    parser.add_argument("--hdrm-fmu", required=True)
    parser.add_argument("--program", action="append", default=[], metavar="NAME=PATH", help="bench program of a crate")
    parser.add_argument("--record", action="store_true", help="record the counts")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--ratios", action="store_true", help="only the two ratios that have an aim")
    parser.add_argument("--no-python", action="store_true", help="without other engines and the FMPy master")
    arguments = parser.parse_args()
    {"time": timed, "instructions": instructions}[arguments.what](arguments)


if __name__ == "__main__":
    main()
