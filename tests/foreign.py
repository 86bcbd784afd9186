"""Which FMUs and system structures of a folder `cosim` opens and runs, and why not: a table.

    python tests/foreign.py FOLDER [--program target/release/cosim]

Other tools' test data are not kept here; master/cosim/foreign.md has what was seen, with revisions.
"""

import argparse
import subprocess
from pathlib import Path

#: Files that are tried.
KINDS = {".fmu", ".ssp", ".ssd"}
#: Seconds after which a run has taken too long; what takes longer is run once more, to 1 s.
LIMIT = 60


def tried(program, file, *options):
    """`runs`, `opens` or `no`, and the first thing that is said."""
    command = [program, "run", file, "--quiet", "--schedule", "standard", *options]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LIMIT, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        if options:
            return "opens", f"still running after {LIMIT} s"
        return tried(program, file, "--stop-time", "1")
    lines = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    if done.returncode == 0:
        return "runs", next((line.strip() for line in done.stdout.splitlines() if "simulated" in line), "")
    reason = lines[0].removeprefix("error: ") if lines else f"exit code {done.returncode}"
    opens = "cannot be loaded" not in reason and "cannot be read" not in reason
    return ("opens" if opens else "no"), reason


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    arguments = parser.parse_args()
    files = sorted(file for file in arguments.folder.rglob("*") if file.suffix in KINDS)
    counts = {"runs": 0, "opens": 0, "no": 0}
    for file in files:
        result, text = tried(arguments.program, file)
        counts[result] += 1
        print(f"{result:6} {file.relative_to(arguments.folder)}: {text[:160]}")
    print(f"{len(files)} files: {counts['runs']} run, {counts['opens']} open only, {counts['no']} do not open")


if __name__ == "__main__":
    main()
