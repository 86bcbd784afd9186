"""Copies of the packed machine in one system: `cosim` in one and in two threads, beside two processes with half of the copies each.

    FMU_DIR=target/fmu python tests/bench/threads.py [--copies 1 4 16 64] [--rounds 5] [--cosim target/release/cosim]

All are measured in turn, several times; of each the median counts. Printed are µs a step, and what two threads gain beside one thread and
beside two processes (1: as much as these; meaningful on a machine that does nothing else).
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import tempfile
import zipfile
from pathlib import Path

SYSTEM = re.compile(r"<ssd:System .*</ssd:System>", re.DOTALL)


def copied(package: Path, count: int, target: Path) -> Path:
    """The packed system `count` times, as systems in a system without further connections."""
    with zipfile.ZipFile(package) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            if not name.endswith(".ssd"):
                new.writestr(name, old.read(name))
        text = old.read("SystemStructure.ssd").decode()
        one = SYSTEM.search(text).group()
        copies = "".join(re.sub(r' name="[^"]*"', f' name="m{k}"', one, count=1) for k in range(1, count + 1))
        many = f'<ssd:System name="many"><ssd:Elements>{copies}</ssd:Elements></ssd:System>'
        new.writestr("SystemStructure.ssd", text.replace(one, many))
    return target


def start(cosim: str, system: Path, threads: int, schedule: str, time: float) -> subprocess.Popen:
    command = [cosim, "bench", "--system", system, "--threads", threads, "--schedule", schedule, "--stop-time", time, "--repeat", 1, "--json"]
    return subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, text=True)


def step(process: subprocess.Popen) -> float:
    """µs a communication step."""
    out, _ = process.communicate()
    assert process.returncode == 0, out
    result = json.loads(out)
    return 1e6 * result["step_s"] / result["real_time_factor"]["median"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copies", type=int, nargs="+", default=[1, 4, 16, 64])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--schedule", default="standard")
    parser.add_argument("--steps", type=int, default=20000, help="of one machine; with n copies an n-th of it")
    parser.add_argument("--cosim", default="target/release/cosim")
    args = parser.parse_args()
    package = Path(os.environ.get("FMU_DIR", "target/fmu")) / "Manipulator.ssp"
    with tempfile.TemporaryDirectory() as folder:
        print("copies  1 thread  2 threads  2 processes  2 threads gain  beside 2 processes")
        for count in args.copies:
            whole = copied(package, count, Path(folder) / f"{count}.ssp")
            half = copied(package, max(count // 2, 1), Path(folder) / f"half-{count}.ssp")
            time = max(args.steps // count, 200) * 1e-3
            found = {"one": [], "two": [], "processes": []}
            for _ in range(args.rounds):
                found["one"].append(step(start(args.cosim, whole, 1, args.schedule, time)))
                found["two"].append(step(start(args.cosim, whole, 2, args.schedule, time)))
                both = [start(args.cosim, half, 1, args.schedule, time) for _ in range(2)]
                found["processes"].append(max(step(process) for process in both))
            one, two, processes = (statistics.median(found[name]) for name in found)
            # One machine cannot be halved: each process has a whole one.
            share = 0.5 if count == 1 else 1.0
            print(f"{count:6} {one:9.1f} {two:10.1f} {processes * share:12.1f} {one / two:15.2f} {processes * share / two:19.2f}")


if __name__ == "__main__":
    main()
