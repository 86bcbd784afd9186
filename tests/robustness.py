"""Misuse of the packed FMUs and of the C border: random calls, threads, long runs, sanitizers, valgrind, Miri, fuzzing. Without options it
does what CI does. `cargo xtask torture` hands its options on to it.

The nightly compiler (`rustup toolchain install nightly`), valgrind (`apt-get install valgrind`) and cargo-fuzz (`cargo install cargo-fuzz`)
are only needed by the options that say so.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
# Calls in CI: about a minute on two cores.
CI_CALLS = 1_000_000
# Its steps cost a hundred times those of the others: it has fewer calls.
SLOW, CI_CALLS_SLOW = "Rig", 40_000
# Steps of each FMU in CI, and of all five instances together.
CI_STEPS = 100_000
# Calls under AddressSanitizer.
ASAN_CALLS = 100_000
# The test that is run under the sanitizers and Miri: the C border of both versions, as importers call it.
BORDER = ["-p", "fmu-export", "--test", "border"]
# Schedules of coupled runs under them. There are no input derivatives in FMI 3.0.
COUPLED = (["gauss-seidel"], ["jacobi", "--input-derivatives"], ["gauss-seidel", "--fmi", 3])
MEMCHECK = ["--leak-check=full", "--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]
HELGRIND = ["--tool=helgrind", "--suppressions=tools/torture/helgrind.supp"]
# Folder in an FMU of each version for this machine.
FOLDERS = {"x86_64": ("linux64", "x86_64-linux"), "aarch64": (None, "aarch64-linux")}


def execute(*command, **options):
    words = list(map(str, command))
    done = subprocess.run(words, cwd=ROOT, **options)
    if done.returncode != 0:
        sys.exit(f"error: `{' '.join(words)}` ended with {done.returncode}\n{done.stderr or ''}")
    return done


def output(*command):
    return execute(*command, stdout=subprocess.PIPE, text=True).stdout


class Suite:
    """The packed FMUs of both versions, and the programs that run them."""

    def __init__(self, is_packed):
        if not is_packed:
            execute("cargo", "xtask", "pack")
        names = sorted(path.stem for path in (ROOT / "modelDescription").glob("*.xml"))
        self.fmus = [folder / f"{name}.fmu" for folder in (TARGET / "fmu", TARGET / "fmu/fmi3") for name in names]
        execute("cargo", "build", "--release", "--workspace", "--bin", "torture", "--bin", "hdrm-fmu")
        self.programs = TARGET / "release"

    def torture(self, *arguments, fmus=None, under=()):
        execute(*under, self.programs / "torture", *arguments, *(self.fmus if fmus is None else fmus))

    def chosen(self, is_slow):
        """The slow FMU, or the others: a seed chooses among the same as in CI."""
        return [fmu for fmu in self.fmus if (fmu.stem == SLOW) == is_slow]

    def endurance(self, steps):
        execute(self.programs / "hdrm-fmu", "endurance", "--steps", steps)

    def check(self):
        """What CI does."""
        for is_slow, calls in ((False, CI_CALLS), (True, CI_CALLS_SLOW)):
            self.torture("calls", "--calls", calls, fmus=self.chosen(is_slow))
        self.torture("exchange")
        self.torture("threads")
        self.torture("long", "--steps", CI_STEPS)
        self.endurance(CI_STEPS)

    def long(self, steps):
        self.torture("long", "--steps", steps)
        self.endurance(steps)
        print(f"long runs: {steps} steps of each of {len(self.fmus)} FMUs alone and of all five instances together")

    def valgrind(self):
        # What is lost once in a life is lost in each: some lives tell as much as a thousand.
        self.torture("life", "--instances", 60, "--loads", 3, under=["valgrind", "--error-exitcode=99", "--keep-debuginfo=yes", *MEMCHECK])
        count = len(self.fmus)
        print(f"memcheck: 60 instances of each of {count} FMUs over 3 loads and unloads: 0 errors, 0 bytes definitely lost")

    def threads(self):
        self.torture("threads", "--threads", 8, "--steps", 2000)
        helgrind = ["valgrind", "--error-exitcode=99", "--keep-debuginfo=yes", *HELGRIND]
        self.torture("threads", "--warm", "--threads", 4, "--steps", 50, under=helgrind)
        count = len(self.fmus)
        print(f"threads: {8 * count} in parallel with 2000 steps each, then {4 * count} with 50 steps each under helgrind: 0 errors")


def nightly(*components):
    """cargo of the nightly toolchain, with these components, and its environment."""
    for component in components:
        execute("rustup", "component", "add", "--toolchain", "nightly", component)
    hidden = ("CARGO", "RUSTUP_TOOLCHAIN")
    return ["rustup", "run", "nightly", "cargo"], {name: value for name, value in os.environ.items() if name not in hidden}


class Sanitized:
    """The tests of the C border, programs and the suite's FMUs, instrumented, with the standard library built for it.

    The executables carry the sanitizer's functions, which the libraries they load look for among their dynamic symbols. A report of any kind
    ends the process with a status of its own.
    """

    def __init__(self, kind, variable, options, packages):
        self.folder = TARGET / f"{kind[0]}san"
        cargo, environment = nightly("rust-src")
        self.environment = environment | {variable: options}
        flags = {"RUSTFLAGS": f"-Zsanitizer={kind} -Clink-arg=-rdynamic"}
        # Named, the target keeps build scripts and macros free of sanitizers.
        host = next(line.removeprefix("host: ") for line in output("rustc", "-vV").splitlines() if line.startswith("host: "))
        suite = sorted(path.parent.name for path in ROOT.glob("fmu-*/Cargo.toml"))
        # All are built of the same packages, so that the features of what they share are the same too.
        packages = [word for name in [*suite, *packages] for word in ("-p", name)]
        more = ["-Zbuild-std", "--target", host, "--target-dir", self.folder, *packages]
        execute(*cargo, "test", *more, *BORDER, env=self.environment | flags)
        build = execute(*cargo, "build", *more, "--message-format", "json-render-diagnostics", env=self.environment | flags, stdout=subprocess.PIPE)
        artifacts = [m for m in map(json.loads, build.stdout.splitlines()) if m["reason"] == "compiler-artifact"]
        self.programs = {m["target"]["name"]: m["executable"] for m in artifacts if m["executable"]}
        libraries = {m["target"]["name"].replace("-", "_"): m["filenames"] for m in artifacts if "cdylib" in m["target"]["crate_types"]}
        machine = FOLDERS[os.uname().machine]
        self.fmus = []
        for version, folder in (("", machine[0]), ("fmi3", machine[1])):
            for package in suite if folder else ():
                library = next(file for file in libraries[package.replace("-", "_")] if file.endswith(".so"))
                self.fmus.append(self.packed(version, folder, package.removeprefix("fmu-"), library))

    def packed(self, version, folder, model, library):
        """An FMU with an instrumented library. Only instrumented programs can load that to ask for its files, so the description is the
        committed one, which must be what the library says: otherwise it makes no instance."""
        descriptions = (ROOT / "modelDescription" / version).glob("*.xml")
        description = next(path for path in descriptions if path.stem.lower() == model)
        identifier = ET.parse(description).getroot().find("CoSimulation").get("modelIdentifier")
        fmu = self.folder / "fmu" / version / f"{identifier}.fmu"
        fmu.parent.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(fmu, "w") as archive:
            archive.write(description, "modelDescription.xml")
            archive.write(library, f"binaries/{folder}/{identifier}.so")
        return fmu

    def run(self, program, *arguments):
        print(f"==> {program} {' '.join(map(str, arguments))}", flush=True)
        files = self.fmus if program == "torture" else []
        execute(self.programs[program], *arguments, *files, env=self.environment)

    def coupled(self, *more):
        """Five instances, over the whole cubic trajectory unless it is said otherwise."""
        for schedule in COUPLED:
            system = ["--system", ROOT / "system/SystemStructure.ssd", "--fmu-dir", self.folder / "fmu"]
            self.run("cosim", "run", "--quiet", *more, "--schedule", *schedule, *system)


def address(calls, seed):
    """AddressSanitizer and LeakSanitizer, with everything that is off by default; the first report ends it."""
    options = (
        "detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1:check_initialization_order=1:"
        "detect_invalid_pointer_pairs=2:exitcode=98"
    )
    built = Sanitized("address", "ASAN_OPTIONS", options, ["torture", "cosim"])
    built.run("torture", "calls", "--calls", calls, "--batch", 5000, "--seed", seed)
    built.run("torture", "life", "--instances", 300, "--loads", 3)
    built.run("torture", "threads", "--threads", 4, "--steps", 50)
    built.coupled()
    print(
        f"AddressSanitizer and LeakSanitizer: tests of the border, {calls} random calls, 300 instances of each of {len(built.fmus)} FMUs over "
        f"3 loads and unloads, 4 threads each, {len(COUPLED)} coupled runs of 5 instances over the whole trajectory: 0 reports"
    )


def thread():
    """ThreadSanitizer; the first report ends it."""
    built = Sanitized("thread", "TSAN_OPTIONS", "halt_on_error=1:exitcode=98", ["torture", "cosim"])
    built.run("torture", "threads", "--threads", 8, "--steps", 100)
    built.coupled("--threads", 3, "--stop-time", 2)
    print(
        f"ThreadSanitizer: tests of the border, 8 threads of each of {len(built.fmus)} FMUs, {len(COUPLED)} coupled runs of 5 instances in "
        "3 threads: 0 reports"
    )


def miri():
    """Miri on the tests of the C border, as far as they need no other process and no millions of steps; the first report ends it."""
    cargo, environment = nightly("miri", "rust-src")
    # The tests write parameter files, and compare runs bit for bit, whose inputs are sines: Miri rounds those at random otherwise.
    environment["MIRIFLAGS"] = "-Zmiri-disable-isolation -Zmiri-deterministic-floats"
    # Safe code makes the descriptions; it would take an interpreter long.
    execute(*cargo, "miri", "test", *BORDER, "--target-dir", TARGET / "miri", "--", "--skip", "xml", env=environment)
    print("Miri: tests of the border of fmu-export: 0 reports")


#: Files of the repository that a fuzz target starts from, besides those in its folder of `tools/fuzz/seeds`.
SHIPPED_SEEDS = {
    "machine_json": ["parameters/reference_machine.json"],
    "model_description": [f"modelDescription/{name}.xml" for name in ("Controller", "Emla", "Hdrm")],
    "surrogate_json": ["parameters/surrogate.json"],
    "system_structure": ["system/SystemStructure.ssd", "system/resources/pd.ssv"],
}


def fuzz(seconds):
    """Each fuzz target for some time, from the repository's inputs; new ones are kept in the target directory."""
    (cargo, environment), folder, total = nightly(), ROOT / "tools/fuzz", 0
    environment["CARGO_TARGET_DIR"] = str(TARGET / "fuzz")
    targets = execute(*cargo, "fuzz", "list", "--fuzz-dir", folder, env=environment, stdout=subprocess.PIPE, text=True).stdout.split()
    for target in targets:
        found = TARGET / "fuzz-corpus" / target
        found.mkdir(parents=True, exist_ok=True)
        for file in SHIPPED_SEEDS.get(target, []):
            shutil.copy(ROOT / file, found)
        corpora = [target, found, *filter(Path.is_dir, [folder / "seeds" / target])]
        limits = [f"-max_total_time={seconds}", "-timeout=20", "-print_final_stats=1", "-print_funcs=0"]
        command = [*cargo, "fuzz", "run", "--fuzz-dir", folder, *corpora, "--", *limits]
        log = execute(*command, env=environment, stderr=subprocess.PIPE, text=True).stderr
        inputs = next(int(line.split(":")[-1]) for line in log.splitlines() if line.startswith("stat::number_of_executed_units:"))
        print(f"{target}: {inputs} inputs in {seconds} s, no complaint", flush=True)
        total += inputs
    print(f"fuzzing: {len(targets)} targets, {total} inputs: 0 crashes, 0 hangs")


def main():
    parser = argparse.ArgumentParser(prog="cargo xtask torture", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--calls", type=int, metavar="NUMBER", help="random calls in total, on all FMUs of both versions of FMI but the slow one")
    add("--seed", type=int, default=1, help="seed of the first batch of random calls")
    add("--replay", type=int, metavar="SEED", help="repeat one batch of random calls, printing every call before it is made")
    add("--long", type=int, metavar="STEPS", help="steps of each FMU alone and of all together; 10000000 are 2.8 h of simulated time")
    asan = "AddressSanitizer and LeakSanitizer on the tests of the C border, on random calls, on lives of instances, on instances in threads"
    add("--asan", action="store_true", help=f"{asan} and on coupled runs (nightly)")
    add("--tsan", action="store_true", help="ThreadSanitizer on the same tests and on instances in threads (nightly)")
    add("--miri", action="store_true", help="Miri on the tests of the C border (nightly)")
    add("--valgrind", action="store_true", help="memcheck on loads, instances and unloads")
    add("--threads", action="store_true", help="helgrind on instances in parallel threads")
    add("--fuzz", type=int, metavar="SECONDS", help="coverage-guided fuzzing, so long for each target (nightly, cargo-fuzz)")
    add("--packed", action="store_true", help="of the FMUs as they lie in target/fmu")
    a = parser.parse_args()
    if a.fuzz is not None:
        fuzz(a.fuzz)
    if a.asan:
        address(a.calls or ASAN_CALLS, a.seed)
    if a.tsan:
        thread()
    if a.miri:
        miri()
    has_calls = a.calls is not None and not a.asan
    of_suite = (has_calls, a.replay is not None, a.long is not None, a.valgrind, a.threads)
    if any(of_suite) or not (a.asan or a.tsan or a.miri or a.fuzz is not None):
        suite = Suite(a.packed)
        if not any(of_suite):
            suite.check()
        if a.replay is not None:
            suite.torture("calls", "--replay", a.replay, fmus=suite.chosen(False))
        if has_calls:
            suite.torture("calls", "--calls", a.calls, "--seed", a.seed, fmus=suite.chosen(False))
        if a.long is not None:
            suite.long(a.long)
        if a.valgrind:
            suite.valgrind()
        if a.threads:
            suite.threads()


if __name__ == "__main__":
    main()
