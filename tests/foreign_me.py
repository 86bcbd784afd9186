"""Model Exchange of a folder's FMUs: `cosim --interface me` compared with FMPy and CVode, a table.

    python tests/foreign_me.py FOLDER [--program target/release/cosim]

Truth is CVode with a tolerance of 1e-10; `cosim` and CVode run with 1e-6 and the same communication step. Errors are relative to the peak of
each signal; those of the worst signal are printed, at the 99th percentile of the samples, so that a jump that is sampled on its two sides
counts only if it is early or late by several samples. The last column is how often the derivatives were evaluated, compared with CVode.
"""

import argparse
import csv
import hashlib
import json
import re
import statistics
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

#: Samples of a run, seconds after which a run has taken too long, and signals that are compared.
SAMPLES, LIMIT, MOST = 500, 60, 40
TOLERANCE = 1e-6
SELF = Path(__file__).resolve()


def cvode(file, tolerance, step, stop, names):
    """Runs in a process of its own: prints the samples and the number of derivatives as JSON."""
    import fmpy
    from fmpy.sundials import CVodeSolver

    count, own = [0], CVodeSolver.f
    CVodeSolver.f = lambda self, *arguments: (count.__setitem__(0, count[0] + 1), own(self, *arguments))[1]
    description = fmpy.read_model_description(file, validate=False)
    result = fmpy.simulate_fmu(
        file, model_description=description, validate=False, fmi_type="ModelExchange", relative_tolerance=float(tolerance), output_interval=float(step), stop_time=float(stop), output=json.loads(names),
        record_events=False, set_stop_time=False, apply_default_start_values=False, logger=lambda *arguments: None,
    )  # fmt: skip
    print("\n" + json.dumps({"time": list(result["time"]), "count": count[0], **{n: [float(x) for x in result[n]] for n in json.loads(names)}}))


def fmpys(file, *arguments):
    command = [sys.executable, SELF, "--cvode", file, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=3 * LIMIT, stdin=subprocess.DEVNULL)
    if done.returncode:
        return None, (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    return json.loads(done.stdout.splitlines()[-1]), ""


def ours(program, file, step, stop, names, interface="me"):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.csv"
        signals = [word for name in names for word in ("--signals", f"x.{name}")]
        command = [program, "run", f"x={file}", "--interface", interface, "--quiet", "--schedule", "standard", "--step", repr(step), "--stop-time", repr(stop)]
        command += ["--tolerance", repr(TOLERANCE), "--csv", out, *signals]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LIMIT, stdin=subprocess.DEVNULL)
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
            return None, (lines or [f"exit code {done.returncode}"])[0].removeprefix("error: ")
        rows = list(csv.reader(out.open()))
        columns = dict(zip([name.removeprefix("x.") for name in rows[0]], zip(*[[float(x) for x in row] for row in rows[1:]])))
        work = re.search(r"(\d+) steps, (\d+) rejected, (\d+) right-hand sides, (\d+) events(.*stiff)?", done.stdout)
        columns["work"] = [int(work[k]) for k in range(1, 5)] + [bool(work[5])] if work else None
        return columns, ""


def compared_names(description):
    """Outputs, else states and other continuous variables."""
    is_real = lambda v: v.type in ("Real", "Float64") and not v.dimensions and '"' not in v.name  # noqa: E731
    outputs = [v.name for v in description.modelVariables if is_real(v) and v.causality == "output"]
    others = [v.name for v in description.modelVariables if is_real(v) and v.variability in ("continuous", None) and v.causality == "local"]
    states = [u.variable.derivative.name for u in description.derivatives if u.variable.derivative and is_real(u.variable.derivative)]
    return list(dict.fromkeys(outputs + states + ([] if outputs or states else others)))[:MOST]


def worst(result, truth, names):
    """The largest error of a signal, relative to its peak."""
    errors = [0.0]
    for name in names:
        peak = max(max(abs(x) for x in truth[name]), 1e-9)
        n = min(len(result[name]), len(truth[name]))
        differences = sorted(abs(a - b) / peak for a, b in zip(result[name][:n], truth[name][:n]))
        errors.append(differences[min(n - 1, int(0.99 * n))])
    return max(errors)


def row(program, file):
    import fmpy

    try:
        description = fmpy.read_model_description(file, validate=False)
    except Exception as error:  # noqa: BLE001
        return None, f"FMPy cannot read it: {error}"[:100]
    e = description.defaultExperiment
    start, stop = float(e.startTime or 0) if e else 0.0, float(e.stopTime or 1) if e else 1.0
    stop = stop if stop > start else start + 1.0
    step, names = (stop - start) / SAMPLES, compared_names(description)
    try:
        own, why = ours(program, file, step, stop, names)
        if own is None:
            return None, why
        truth, why = fmpys(file, "1e-10", repr(step), repr(stop), json.dumps(names))
        reference, why_not = fmpys(file, repr(TOLERANCE), repr(step), repr(stop), json.dumps(names))
    except subprocess.TimeoutExpired as late:
        return None, f"still running after {late.timeout} s"
    ticks = any(v.type == "Clock" for v in description.modelVariables)
    if ticks or truth is None or reference is None:
        why = "FMPy ticks no clocks" if ticks else f"FMPy: {why or why_not}"[:90]
        slave, _ = ours(program, file, step, stop, names, "cs")
        by = f"differs by {worst(own, slave, names):.1e} from Co-Simulation; " if slave else ""
        return {"own": None}, by + why
    errors = [worst(result, truth, names) for result in (own, reference)]
    return {"own": errors[0], "cvode": errors[1], "work": own["work"], "count": reference["count"], "states": len(description.derivatives)}, ""


def offers(file):
    """Whether it offers Model Exchange with a library for Linux."""
    try:
        archive = zipfile.ZipFile(file)
        text = archive.read("modelDescription.xml").decode("latin1")
        folders = ("binaries/linux64/", "binaries/x86_64-linux/")
        has_library = any(name.startswith(folders) and name.endswith(".so") for name in archive.namelist())
    except Exception:  # noqa: BLE001
        return False
    return has_library and "<ModelExchange" in text and not re.search(r'fmiVersion\s*=\s*"1', text)


def main():
    if sys.argv[1:2] == ["--cvode"]:
        return cvode(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default="target/release/cosim")
    parser.add_argument("--only", default="", help="part of the paths that are run")
    arguments = parser.parse_args()
    seen, ratios, counts = set(), [], {"good": 0, "worse": 0, "alone": 0, "refused": 0}
    for file in sorted(arguments.folder.rglob("*.fmu")):
        digest = hashlib.sha256(file.read_bytes()).digest()
        if digest in seen or arguments.only not in str(file) or not offers(file):
            continue
        seen.add(digest)
        found, text = row(arguments.program, file)
        name = file.relative_to(arguments.folder)
        if found is None or found["own"] is None:
            kind = "refused" if found is None else "alone"
            print(f"{kind:7} {name}: {text}", flush=True)
        else:
            good = found["own"] <= max(found["cvode"], 10 * TOLERANCE)
            kind = "good" if good else "worse"
            steps, rejected, evaluations, events, stiff = found["work"]
            ratio = evaluations / found["count"] if found["count"] and evaluations else 0.0
            if ratio and not stiff:
                ratios.append(ratio)
            method = "stiff" if stiff else ""
            print(
                f"{kind:7} {name}: error {found['own']:.1e} (CVode {found['cvode']:.1e}), {evaluations} right-hand sides (CVode {found['count']}, "
                f"x {ratio:.2f}), {events} events, {found['states']} states {method}",
                flush=True,
            )
        counts[kind] += 1
    print(f"{sum(counts.values())} FMUs: {counts}")
    if ratios:
        print(f"right-hand sides compared with CVode where not stiff: median {statistics.median(ratios):.2f}, largest {max(ratios):.2f}")


if __name__ == "__main__":
    main()
