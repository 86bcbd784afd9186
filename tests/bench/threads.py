"""Threads of `cosim`, compared with two processes with half of the components each, and with ecos and libcosim; and what it decides by itself.

    FMU_DIR=target/fmu python tests/bench/threads.py [--copies 1 4 16 64] [--rounds 5] [--others ecos libcosim] [--pairs 21]

`busy` are six components that do nothing but work for 1 ms (a C compiler is needed), a number is that of copies of the packed machine in one
system, in the schedule `standard`, which is that of the others, too (tests/requirements.txt; they write no files). All are measured in turn;
of each the median counts. Printed are µs a step, and quotients: what two threads gain compared with one, how near they come to two processes (1: as
near as can be, on a machine that does nothing else), and how many times as long as the better of one and two threads the others take. Then, for
each of these systems, how much longer `cosim run` takes by itself than with `--threads 1`, in pairs.
"""

import argparse
import ctypes
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

H = 1e-3
COUNTER = Path(__file__).resolve().parents[2] / "master/cosim/tests/fmus/counter.c"
BUSY, BUSY_STEPS = 6, 300
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="counter" guid="{1}"><CoSimulation modelIdentifier="counter"
canHandleVariableCommunicationStepSize="true"/><ModelVariables><ScalarVariable name="y" valueReference="1" causality="output"><Real/>
</ScalarVariable></ModelVariables><ModelStructure><Outputs><Unknown index="1" dependencies=""/></Outputs></ModelStructure></fmiModelDescription>"""


def copied(package: Path, count: int, target: Path) -> Path:
    """The packed system `count` times, flat, as the others read it."""
    with zipfile.ZipFile(package) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            if not name.endswith(".ssd"):
                new.writestr(name, old.read(name))
        text = re.sub('<ssc:Annotation type="io.github.hdrm-fmu.alarms">.*?</ssc:Annotation>', "", old.read("standard.ssd").decode(), flags=re.DOTALL)
        for block in ("Elements", "Connections"):
            one = re.search(f"(?<=<ssd:{block}>).*(?=</ssd:{block}>)", text, re.DOTALL).group()
            named = re.compile(r'(<ssd:Component name="|(?:start|end)Element=")')
            text = text.replace(one, "".join(named.sub(rf"\g<1>m{k}_", one) for k in range(count)))
        new.writestr("SystemStructure.ssd", text)
    return target


def busy(count: int, loops: int, folder: Path) -> Path:
    """Components that count to `loops` in each step."""
    library, fmu, structure = folder / "counter.so", folder / f"counter-{loops}.fmu", folder / f"busy-{count}-{loops}.ssd"
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", f"-DLOOPS={loops}", "-o", library, COUNTER], check=True)
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/counter.so")
    elements = "".join(f'<ssd:Component name="c{k}" source="{fmu.name}"/>' for k in range(count))
    structure.write_text(
        '<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="busy">'
        f'<ssd:System name="busy"><ssd:Elements>{elements}</ssd:Elements></ssd:System></ssd:SystemStructureDescription>'
    )
    return structure


def one_ms(cosim: str, folder: Path) -> int:
    """So far a component counts in 1 ms."""
    guess = 100_000
    return round(guess * 1e3 / step(start(cosim, busy(1, guess, folder), 1, BUSY_STEPS)))


def start(cosim: str, system: Path, threads: int, steps: int) -> subprocess.Popen:
    command = [cosim, "bench", "--system", system, "--threads", threads, "--schedule", "standard", "--step", H, "--stop-time", steps * H]
    return subprocess.Popen([str(part) for part in [*command, "--repeat", 1, "--json"]], stdout=subprocess.PIPE, text=True)


def step(process: subprocess.Popen) -> float:
    """µs a communication step."""
    out, _ = process.communicate()
    assert process.returncode == 0, out
    result = json.loads(out)
    return 1e6 * result["step_s"] / result["real_time_factor"]["median"]


def ecos(package: Path):
    ctypes.CDLL(str(Path(sys.prefix, "lib/libtbb.so.12")), ctypes.RTLD_GLOBAL)
    import ecospy

    ecospy.EcosLib.set_log_level("warn")
    simulation = ecospy.EcosSimulation(H, ssp_path=str(package))
    assert simulation.init(parameter_set="hybrid")
    return simulation, simulation.step


def libcosim(package: Path):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(str(package), H * 1e9)
    assert execution.step()
    return execution, lambda steps: execution.step(steps)


OTHERS = {"ecos": ecos, "libcosim": libcosim}


def other(name: str, package: Path, steps: int) -> list[float]:
    """The same by another program, in a process of its own; none where that crashes, as ecos does at times with many components."""
    out = subprocess.run([sys.executable, __file__, "--of", name, package, str(steps)], stdout=subprocess.PIPE, text=True)
    if out.returncode != 0:
        print(f"{name} ended with {out.returncode}", file=sys.stderr)
    return [] if out.returncode != 0 else [float(out.stdout.split()[-1])]


def other_here(name: str, package: Path, steps: int) -> float:
    kept, run = OTHERS[name](package)
    before = time.perf_counter()
    run(steps)
    return 1e6 * (time.perf_counter() - before) / steps


def compared(args, label: str, whole: Path, half: Path, share: float, steps: int, others) -> None:
    """A row. Each of the two processes runs `half`, of which only a `share` of the time counts."""
    found: dict[str, list[float]] = {name: [] for name in ("one", "two", "processes", *others)}
    for _ in range(args.rounds):
        found["one"].append(step(start(args.cosim, whole, 1, steps)))
        found["two"].append(step(start(args.cosim, whole, 2, steps)))
        both = [start(args.cosim, half, 1, steps) for _ in range(2)]
        found["processes"].append(share * max(step(process) for process in both))
        for name in others:
            found[name] += other(name, whole, steps)
    one, two, processes, *rest = (statistics.median(values or [math.nan]) for values in found.values())
    row = f"{label:6} {one:9.1f} {two:10.1f} {processes:12.1f} {one / two:15.2f} {processes / two:19.2f}"
    print(row + "".join(f" {value:9.1f} {value / min(one, two):6.2f}" for value in rest), flush=True)


def by_itself(args, label: str, system: Path, steps: int) -> None:
    """`cosim run` compared with itself on one thread."""

    def seconds(*more: str) -> float:
        command = [args.cosim, "run", "--quiet", "--system", str(system), "--step", str(H), "--stop-time", str(steps * H), *more]
        out = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
        return float(re.search(r"simulated in ([\d.]+) s", out).group(1))

    ratios = sorted(seconds() / seconds("--threads", "1") for _ in range(args.pairs))
    print(f"{label:8} {statistics.median(ratios):6.3f} (from {ratios[0]:.3f} to {ratios[-1]:.3f})", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copies", type=int, nargs="*", default=[1, 4, 16, 64])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=20000, help="of one machine; with n copies an n-th of it")
    parser.add_argument("--others", nargs="*", choices=OTHERS, default=list(OTHERS))
    parser.add_argument("--pairs", type=int, default=21, help="of a run by itself and one in one thread")
    parser.add_argument("--cosim", default="target/release/cosim")
    parser.add_argument("--of", nargs=3, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.of:
        print(other_here(args.of[0], Path(args.of[1]), int(args.of[2])))
        return
    package = Path(os.environ.get("FMU_DIR", "target/fmu")) / "Manipulator.ssp"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        loops = one_ms(args.cosim, folder)
        six, three = busy(BUSY, loops, folder), busy(BUSY // 2, loops, folder)
        print(f"load {os.getloadavg()[0]:.1f}, cores {os.cpu_count()}")
        print("       1 thread  2 threads  2 processes  2 threads gain  beside 2 processes" + "".join(f" {name:>9}  times" for name in args.others))
        compared(args, "busy", six, three, 1.0, BUSY_STEPS, [])
        for count in args.copies:
            whole = copied(package, count, folder / f"{count}.ssp")
            half = copied(package, max(count // 2, 1), folder / f"half-{count}.ssp")
            # One machine cannot be halved: each process has a whole one.
            compared(args, str(count), whole, half, 0.5 if count == 1 else 1.0, max(args.steps // count, 200), args.others)
        if args.pairs:
            print(f"time by itself in that of one thread, median of {args.pairs} pairs (load {os.getloadavg()[0]:.1f})")
            by_itself(args, "busy", six, 2 * BUSY_STEPS)
            for count in args.copies:
                by_itself(args, str(count), copied(package, count, folder / f"{count}.ssp"), 3 * max(args.steps // count, 200))


if __name__ == "__main__":
    main()
