"""What a process of its own costs: `cosim run` with and without `--isolate all`, in interleaved pairs, a table.

    python tests/bench/isolated.py FILE.fmu [--program target/release/cosim] [--pairs 9] [--steps 20000]

Copies of the FMU run next to each other, without connections between them. A row has the median of what the processes add to a communication
step, divided by the number of components, with the smallest and largest of the pairs.
"""

import argparse
import os
import re
import statistics
import subprocess
from pathlib import Path


def seconds(program, fmu, copies, schedule, steps, isolated):
    """Computing time of a run, without loading and initialization."""
    words = [program, "run", *(f"c{k}={fmu}" for k in range(copies)), "--schedule", schedule, "--threads", "1", "--quiet"]
    words += ["--step", "1e-3", "--stop-time", str(steps / 1000), "--signals", "*", "--csv", os.devnull, "--interval", str(steps / 1000)]
    done = subprocess.run([*words, *(["--isolate", "all"] if isolated else [])], check=True, capture_output=True, text=True)
    return float(re.search(r"simulated in ([\d.]+) s", done.stdout)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--pairs", type=int, default=9)
    parser.add_argument("--steps", type=int, default=20000)
    a = parser.parse_args()
    print(f"{len(os.sched_getaffinity(0))} cores, load {os.getloadavg()[0]:.1f}\n")
    print("| schedule | components | in the program, µs a step | added by processes, µs a step and component |\n|---|--:|--:|--:|")
    for schedule in ("standard", "gauss-seidel"):
        for copies in (1, 2, 5):
            run = lambda isolated: 1e6 * seconds(a.program, a.fmu, copies, schedule, a.steps, isolated) / a.steps
            pairs = [(run(False), run(True)) for _ in range(a.pairs)]
            own = statistics.median(pair[0] for pair in pairs)
            added = sorted((pair[1] - pair[0]) / copies for pair in pairs)
            print(f"| `{schedule}` | {copies} | {own:.1f} | {statistics.median(added):.1f} ({added[0]:.1f} to {added[-1]:.1f}) |", flush=True)


if __name__ == "__main__":
    main()
