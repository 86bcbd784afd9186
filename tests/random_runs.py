"""Random command lines of `cosim run`, compared with an oracle of a few lines: exit code, verdict, and the files that are there afterwards.

    python tests/random_runs.py [--count 10000] [--seed 1] [--only NUMBER] [--program target/release/cosim]

The systems are chains and an oscillator of small FMUs that misbehave on request (`traits`), of FMI 2.0 and 3.0. What a line is to do is known when it
is made: some of its options are wrong and must be named, some components fail, stop or end the process at a known time. Everything follows from the
seed; a line that disagrees is printed with its number, for `--only`.
"""

import argparse
import csv
import errno
import math
import os
import random
import re
import shlex
import stat
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import traits

#: Exit code where an FMU ended the process.
ENDED = 3
STEP, STOP = 0.1, 1.0


class Line:
    """A command line, and what is known of it."""

    def __init__(self, number, seed, pool, folder):
        self.random = random.Random(f"{seed} {number}")
        self.pool, self.folder = pool, folder
        self.options, self.wrong = [], []
        self.step, self.stop, self.check = STEP, STOP, False
        self.outputs, self.csv, self.kind, self.at = set(), None, None, math.inf
        self.culprit, self.connected, self.varies, self.repeats, self.altered = None, False, False, False, set()
        self.interval, self.given = 1, set()
        self.is_system = self.chance(0.25)
        files = [pool / "o.ssp"] if self.is_system else [pool / f"{c}.fmu" for c in "abc"[: self.random.randint(1, 3)]]
        self.components = ["spring", "mass"] if self.is_system else [f.stem for f in files]
        self.inputs = [("mass.y", "spring.u"), ("spring.y", "mass.u")] if self.is_system else []
        if not self.is_system:
            self.inputs = [(f"{a}.y", f"{b}.u") for a, b in zip(self.components, self.components[1:])]
        self.options += [*map(str, files)]
        if not self.is_system:
            self.options += [option for a, b in self.inputs for option in ("--connect", f"{a}={b}")]
        # What has to come first, since others depend on it.
        self.steps()
        self.trait()
        chosen = self.random.sample(ACTS, self.random.randint(0, 6))
        for act in sorted(chosen, key=ACTS.index):
            act(self)
        for mistake in self.random.sample(MISTAKES, self.random.choice((0, 0, 0, 1, 2))):
            mistake(self)
        self.output()

    def chance(self, share):
        return self.random.random() < share

    def add(self, *words, wrong=None):
        """Adds words; `wrong` is a part of the message that refuses them."""
        self.options += map(str, words)
        if wrong is not None:
            self.wrong.append(str(wrong))

    def pick(self, *items):
        return self.random.choice(items)

    def write(self, name, text):
        file = self.folder / name
        file.write_text(text)
        return file

    # What is always decided.

    def steps(self):
        if self.chance(0.3):
            self.step = self.pick(0.05, 0.1, 0.2)
            self.add("--step", self.step)
        if self.chance(0.3):
            self.stop = self.pick(0.4, 0.6, 2.0)
            self.add("--stop-time", self.stop)
        self.add("--schedule", schedule := self.pick("standard", "jacobi", "gauss-seidel"))
        self.schedule = schedule
        if self.chance(0.4):
            self.check = True
            self.add("--check")

    def trait(self):
        if self.chance(0.5):
            return
        self.culprit, self.kind = self.random.choice(self.components), self.random.choice(traits.TRAITS[1:])
        self.at = self.pick(0.1, 0.3, 0.4, 0.75, 1.0, 3.0)
        self.add("--set", f"{self.culprit}.kind={traits.TRAITS.index(self.kind)}", "--set", f"{self.culprit}.at={self.at}")
        self.connected = any(a == f"{self.culprit}.y" for a, _ in self.inputs)

    def output(self):
        if self.chance(0.25):
            return
        self.csv = self.folder / "out.csv"
        way = self.pick("new", "new", "old", "link", "pipe", "device", "missing")
        if way == "old":
            self.csv.write_text("old\n")
        elif way == "link":
            self.csv.symlink_to("target.csv")
            self.outputs.add("target.csv")
        elif way == "pipe":
            os.mkfifo(self.csv)
        elif way == "device":
            self.csv = Path("/dev/null")
        elif way == "missing" and self.chance(0.2):
            self.csv = self.folder / "no" / "out.csv"
            self.wrong.append("out.csv")
        elif self.chance(0.05):
            self.csv = Path(self.options[0])
            self.wrong.append(self.csv.name)
        self.way = way
        self.outputs |= {"out.csv", "out.units.csv"} if way not in ("device", "pipe") else set()
        self.add("--csv", self.csv)
        if self.chance(0.5):
            self.add("--signals", self.pick("*", "*.y", f"{self.components[0]}.y", f"{self.components[-1]}.z,*.y"))
        if not self.varies and self.chance(0.3):
            self.interval = self.pick(2, 3, 5)
            self.add("--interval", f"{self.interval * self.step:.6g}")
            if math.isclose(self.interval * self.step, float(f"{self.interval * self.step:.6g}")) is False:
                self.wrong.append("interval")

    # What each option is to do.

    def start_value(self):
        self.add("--set", f"{self.random.choice(self.components)}.k={self.pick(0.5, -2, 3)}")

    def parameters(self):
        self.add("--parameters", self.write("set.ssv", traits.parameter_set({f"{self.components[0]}.d": 0.0, f"{self.components[-1]}.n": 3})))
        self.given.add(f"{self.components[-1]}.n")

    def rate(self):
        self.add("--rate", f"{self.random.choice(self.components)}={self.step / self.pick(1, 2, 4)}")

    def feedthrough(self):
        component = self.random.choice(self.components)
        # Only c says nothing of dependencies.
        self.add("--feedthrough", component, wrong=None if component == "c" else f"--feedthrough {component}")

    def loops(self):
        self.add("--solve-loops")

    def threads(self):
        self.add("--threads", self.pick(1, 2, 3))

    def input_file(self):
        if self.is_system:
            return
        column = f"{self.components[0]}.u"
        rows = "".join(f"{t},{self.random.uniform(-1, 1)}\n" for t in (0, 0.25, 0.5))
        self.add("--input", self.write("in.csv", f"time,{column}\n{rows}"))
        self.altered.add(column)
        self.given.add(column)

    def scenario(self):
        if self.is_system or f"{self.components[0]}.u" in self.altered:
            return
        event = '{"time": 0.2, "model": "%s", "variable": "u", "action": "override", "value": 2}' % self.components[0]
        self.add("--scenario", self.write("s.json", f'{{"events": [{event}], "end": 0.5}}'))
        self.given.add(f"{self.components[0]}.u")

    def fault(self):
        if not self.inputs:
            return
        wire = self.random.choice(self.inputs)[self.pick(0, 1)]
        effect = self.pick("bias:0.5", "gain:2", "override:1", "freeze", "drop:0.5", f"delay:{2 * self.step:.6g}", "noise:0.1")
        if effect.startswith("delay") and self.varies:
            return
        # A fault may hold a bad number back, or make numbers that are not finite.
        self.altered.add(wire)
        self.add("--fault", f"{wire}={effect}{self.pick('', '@0.2', '@..0.3', '@0.1..0.5')}")
        if effect.startswith(("drop", "noise")) and self.chance(0.5):
            self.add("--seed", self.random.randint(0, 99))

    def between(self):
        way = self.pick("held", "extrapolated", "interpolated", "end")
        only_sequential = way in ("interpolated", "end") and self.schedule != "gauss-seidel"
        self.add("--between", way, wrong="gauss-seidel" if only_sequential else None)

    def doubling(self):
        if self.altered & {b for pair in self.inputs for b in pair} or self.varies:
            return
        self.varies = self.repeats = True
        self.add("--doubling-tolerance", "1e-2")

    def repeated(self):
        if self.varies:
            return
        self.varies = self.repeats = True
        self.add("--repeat-steps")

    def snapshot(self):
        self.add("--snapshot", f"{self.pick(0, 0.2, 0.35)}={self.folder / 'saved'}")
        self.outputs.add("saved")

    def strict(self):
        driven = self.given | {end for _, end in self.inputs}
        inputs = {f"{c}.{v}" for c in self.components for v in "un"}
        self.add("--strict", wrong=None if inputs <= driven else "--strict")

    # Mistakes, each with a part of the message that refuses it.

    def no_file(self):
        option = self.pick("--parameters", *(o for o in ("--input", "--scenario", "--resume") if o not in self.options))
        self.add(option, self.folder / "absent.file", wrong="absent.file")

    def option_of_systems(self):
        if self.is_system:
            self.add("--connect", "spring.z=mass.n", wrong="--connect")
            return
        words = self.pick(("--variant", "x.ssd"), ("--fmu-dir", "/"), ("--fmi", "2"), ("--fmu", "a=b.fmu"), ("--map", "a=b.ssm"))
        self.add(*words, wrong=words[0])

    def unknown_name(self):
        option, value = self.pick(("--set", "q.k=1"), ("--rate", "q=0.1"), ("--feedthrough", "q"), ("--fault", "q.u=freeze"), ("--noise", "q.u=1"))
        self.add(option, value, wrong="q")

    def bad_value(self):
        component = self.components[0]
        option, value, part = self.pick(
            ("--set", f"{component}.k=soft", "soft"),
            ("--set", f"{component}.n=1.5", "1.5"),
            ("--threads", "0", "threads"),
            ("--rate", f"{component}=0.0333", "0.0333"),
            ("--snapshot", f"9={self.folder / 'late'}", "--snapshot"),
            ("--fault", f"{component}.u=bend:2", "bend"),
        )
        if option not in ("--threads",) or "--threads" not in self.options:
            self.add(option, value, wrong=part)

    def lonely(self):
        """An option without the one that it needs."""
        words = [("--energy-scale", "2"), ("--step-limits", "0.01,0.1"), ("--step-change", "0.2,1.5"), ("--input-column", "a.u=b")]
        if "noise" not in str(self.options) and "drop" not in str(self.options):
            words.append(("--seed", "3"))
        if self.repeats:
            words = words[:1]
        option, value = self.random.choice(words)
        if option not in self.options and ("--input" not in self.options or option != "--input-column"):
            self.add(option, value, wrong="seed" if option == "--seed" else {"--input-column": "--input"}.get(option, option))


ACTS = [
    Line.start_value, Line.parameters, Line.rate, Line.feedthrough, Line.loops, Line.threads, Line.between, Line.doubling, Line.repeated,
    Line.input_file, Line.scenario, Line.fault, Line.snapshot, Line.strict,
]  # fmt: skip
MISTAKES = [Line.no_file, Line.option_of_systems, Line.unknown_name, Line.bad_value, Line.lonely]


def listing(folder):
    """What is in a folder: names, with what changes if a file does."""
    found = {}
    for path in folder.rglob("*"):
        s = path.lstat()
        # What goes through a pipe changes its time, not the pipe.
        is_pipe = stat.S_ISFIFO(s.st_mode)
        found[str(path.relative_to(folder))] = (stat.S_IFMT(s.st_mode), s.st_ino, s.st_size, 0 if is_pipe else s.st_mtime_ns)
    return found


def rows_of(text):
    """Times and values of a CSV file; enumerations and texts do not occur."""
    rows = [[float(cell) for cell in row] for row in list(csv.reader(text.splitlines()))[1:]]
    return [row[0] for row in rows], [value for row in rows for value in row[1:]]


def disagreements(line, done, changed, left, text):
    """Where a run is not as it must be: the oracle. `text` is the CSV file."""
    code, said = done.returncode, done.stdout + done.stderr
    is_bad = "verdict: BAD" in said
    ended = code == ENDED
    more = changed - line.outputs
    if ended:  # What a process leaves that ends early goes at the next start.
        more = {name for name in more if not re.fullmatch(r"\..*\.part", name)}
    if more:
        yield f"touched {sorted(more)}"
    if left and not ended:
        yield f"left {left} in the folder for temporary files"
    if line.wrong:
        if code not in (1, 2) or not any(part in done.stderr for part in line.wrong):
            yield f"exit code {code}, though `{line.wrong}` is wrong"
        if changed:
            yield f"refused, and touched {sorted(changed)}"
        return
    reached = line.at <= line.stop + 1e-9
    kind = line.kind if reached else None
    ends_process = kind in ("exits", "aborts", "crashes")
    fails = kind in ("fails", "destroys", "discards")
    passes = kind in ("not a number", "infinite") and line.connected
    times, values = rows_of(text) if text is not None and text != "old\n" else ([], [])
    is_whole = bool(times) and line.stop - times[-1] < line.interval * line.step * (1 - 1e-9)
    is_finite = all(map(math.isfinite, values))
    # Exit code 0 only if finite and complete.
    if code == 0 and line.csv and text is not None and not is_whole and kind not in ("terminates", "exits"):
        yield f"exit code 0, and the rows end at {times[-1:]}"
    if code == 0 and line.check and not is_finite:
        yield "exit code 0 with --check, and numbers that are not finite"
    if code == 2 and not (line.check and is_bad) or code == 0 and line.check and is_bad:
        yield f"exit code {code} with the verdict {'BAD' if is_bad else 'good'}"
    if ends_process:
        if code != ENDED:
            yield f"exit code {code}, though `{line.culprit}` {kind}"
        if line.culprit not in done.stderr:
            yield f"`{line.culprit}` {kind}, and nobody says so"
    elif fails or passes and not line.altered:
        # Steps that are repeated until they are too short: the message does not name the component yet.
        is_named = line.culprit in done.stderr or line.repeats and "however short" in done.stderr
        if code != 1 or not is_named:
            yield f"exit code {code}, though `{line.culprit}` {kind}"
    elif passes or kind == "terminates":
        if code not in (0, 1, 2):
            yield f"exit code {code}"
    elif code not in (0, 2):
        yield f"exit code {code}, though nothing is wrong"
    if (fails or passes) and code not in (0, 2) and line.csv and text is not None:
        last = (math.ceil((line.at - 1e-9) / line.step) - 1) * line.step
        last -= math.fmod(last + 1e-9, line.interval * line.step) - 1e-9
        if not line.varies and not passes and (not times or abs(times[-1] - last) > 1e-9 and times[-1] < last):
            yield f"the rows end at {times[-1:]}, not at {last}"
    if kind == "terminates" and code == 0 and times and times[-1] < line.at - (1 + line.interval) * line.step:
        yield f"ended at {line.at}, the rows at {times[-1:]}"


def make_pool(folder):
    """The FMUs and systems of all lines."""
    library = traits.compiled(folder)
    for name, version, on in (("a", 2, ""), ("b", 3, "u"), ("c", 2, None)):
        traits.pack(folder / f"{name}.fmu", library, version, on)
    traits.oscillator(folder / "o.ssp", folder / "a.fmu")
    return folder


def let_go(pipe, reader):
    """Ends a thread that reads a pipe, also if nobody has opened the pipe to write."""
    while reader.is_alive():
        try:
            os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
        except OSError as e:
            if e.errno != errno.ENXIO:  # The thread does not read yet, or no longer.
                raise
        reader.join(0.02)


def tried(program, pool, number, seed, is_shown=False):
    """Runs the line of this number; the command and where it disagrees."""
    with tempfile.TemporaryDirectory() as top:
        folder, temporary = Path(top) / "here", Path(top) / "tmp"
        folder.mkdir()
        temporary.mkdir()
        line = Line(number, seed, pool, folder)
        command = [str(program.resolve()), "run", *line.options, "--quiet"]
        before, before_pool, piped = listing(folder), listing(pool), []
        reader = None
        if line.csv and line.csv.is_fifo():
            reader = threading.Thread(target=lambda: piped.append(line.csv.read_text()), daemon=True)
            reader.start()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=os.environ | {"TMPDIR": str(temporary)}, cwd=folder)
        except subprocess.TimeoutExpired:
            return command, ["it does not end"]
        if reader:
            let_go(line.csv, reader)
        after = listing(folder)
        changed = {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}
        text = piped[0] if piped else None
        if not reader and line.csv and line.csv.is_file():
            text = line.csv.read_text(errors="replace")
        if text is not None and not text.startswith("time"):
            text = None if text != "old\n" else text
        found = list(disagreements(line, done, changed, sorted(os.listdir(temporary)), text))
        if listing(pool) != before_pool:
            found.append("the FMUs have changed")
        if is_shown:
            print(done.returncode, done.stdout, done.stderr, text, sep="\n")
        return command, [f"{what}\n    {done.stderr.strip()[:600]}" for what in found]


def run_all(program, count, seed=1, first=0):
    """Runs lines; returns those that disagree as text."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        fmus = make_pool(Path(folder))
        done = pool.map(lambda number: (number, *tried(program, fmus, number, seed)), range(first, first + count))
        return [f"{number}: {shlex.join(command)}\n  " + "\n  ".join(found) for number, command, found in done if found]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="command lines (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of all of them (default: %(default)s)")
    parser.add_argument("--only", type=int, metavar="NUMBER", help="run one of them and show what it prints")
    parser.add_argument("--program", type=Path, help="default: the newest build beside FMU_DIR")
    a = parser.parse_args()
    if a.program is None:
        from native import program

        a.program = program("cosim")
    if a.only is not None:
        with tempfile.TemporaryDirectory() as folder:
            command, found = tried(a.program, make_pool(Path(folder)), a.only, a.seed, is_shown=True)
            print(re.sub(r"/tmp/\S*/", "", shlex.join(command)), *found, sep="\n")
        return
    found = run_all(a.program, a.count, a.seed)
    print(*found, f"{a.count} command lines, {len(found)} disagree", sep="\n")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
