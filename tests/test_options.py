"""Each option of every program and mode acts, or is refused by name. The list of options is that of `--help`: a new one without an entry fails here.

An entry says how it is shown: `Acts` by other results than without the option, `Refused` by a part of the message.
"""

import json
import os
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import pytest

import traits
from fmpy_master import ROOT
from native import program


class Acts(NamedTuple):
    """With these words the results differ from those of the command `on`."""

    words: str
    on: str = "plain"


class Refused(NamedTuple):
    """With these words the command ends with a message that holds this part."""

    words: str
    part: str
    on: str = "plain"


class Told(NamedTuple):
    """Not tried: why."""

    why: str


#: Commands of `cosim run` with FMUs, in a folder with what `files` makes. a and c are of FMI 2.0, b of 3.0; in d and e the input acts at once on the
#: output; c says nothing of that.
CHAIN = "a.fmu b.fmu --connect a.y=b.u --set a.u=1 --set b.d=0.5 --step 0.1 --csv out.csv --signals * --quiet"
FMUS = {
    "plain": f"run {CHAIN}",
    "alone": "run a.fmu --step 0.1 --csv out.csv --signals * --quiet",
    "mute": "run c.fmu b.fmu --connect c.y=b.u --set c.u=1 --step 0.1 --quiet",
    "loop": "run d.fmu e.fmu --connect d.y=e.u --connect e.y=d.u --set d.d=0.5 --set d.u=1 --set e.d=-0.5 --quiet --csv out.csv",
    "jacobi": f"run {CHAIN.replace('b.', 'f.')} --schedule jacobi",
    "varied": f"run c.fmu {CHAIN} --connect b.y=c.u --doubling-tolerance 1e-2 --step-limits 1e-4,0.5",
    "noisy": f"run {CHAIN} --noise b.u=0.1",
    "diverging": "run c.fmu g.fmu --connect c.y=g.u --connect g.y=c.u --set c.d=-2 --set g.d=1 --fault g.u=bias:1e-3@0.1 --quiet --step 0.01",
    "fed": f"run {CHAIN.replace('--set a.u=1', '')} --input spare.csv",
}
OF_SYSTEM = {
    "plain": "run o.ssp --set mass.x=1 --step 0.1 --csv out.csv --signals * --quiet",
    "ssd": "run o.ssd --set mass.x=1 --step 0.1 --csv out.csv --signals * --quiet",
    "loop": "run loop.ssp --set spring.d=0.5 --set mass.d=-0.5 --step 0.1 --quiet --csv out.csv",
    "mute": "run mute.ssp --variant half.ssd --set mass.x=1 --step 0.1 --quiet",
    "replaced": "run o.ssp --fmu spring=b.fmu --set mass.x=1 --step 0.1 --csv out.csv --signals * --quiet",
    "energy": "run o.ssp --set mass.x=1 --energy-tolerance 1e-2 --step-limits 1e-4,0.5 --csv out.csv --quiet",
}
NEEDS_SYSTEM = "is for a system, a packed .ssp or a .ssd"
#: Of both.
COMMON = {
    "--step": Acts("--step 0.05"),
    "--start-time": Acts("--start-time 0.5"),
    "--stop-time": Acts("--stop-time 0.5"),
    "--tolerance": Refused("--tolerance 2", "--tolerance 2: a relative tolerance must be above 0 and below 1"),
    "--allow-nonfinite": Refused("--allow-nonfinite absent*", "--allow-nonfinite: no variable of type Real matches `absent*`"),
    "--set": Acts("--set {first}.k=3"),
    "--threads": Refused("--threads 0", "0 threads: there must be at least 1"),
    "--check": Acts("--check", "diverging"),
    "--quiet": Told("the progress bar is on terminals only"),
    "--doubling-tolerance": Acts("--doubling-tolerance 1e-3"),
    "--repeat-steps": Acts("--repeat-steps"),
    "--snapshot": Acts("--snapshot 0.5=saved.snapshot"),
    "--resume": Acts("--resume {first}.snapshot"),
    "--fault": Acts("--fault {wire}=bias:1"),
    "--noise": Acts("--noise {wire}=0.1"),
    "--scenario": Acts("--scenario {first}.json"),
    "--csv": Acts("--csv more.csv"),
    "--signals": Acts("--signals {first}.y"),
    "--interval": Acts("--interval 0.2"),
}
RUN_FMUS = COMMON | {
    "--system": Refused("--system o.ssp", "cannot be used with"),
    "--connect": Acts("--connect a.m=b.n"),
    "--fmu-dir": Refused("--fmu-dir .", "--fmu-dir " + NEEDS_SYSTEM),
    "--fmi": Refused("--fmi 2", "--fmi " + NEEDS_SYSTEM),
    "--fmu": Refused("--fmu a=c.fmu", "--fmu " + NEEDS_SYSTEM),
    "--map": Refused("--map a=names.ssm", "--map " + NEEDS_SYSTEM),
    "--variant": Refused("--variant other.ssd", "--variant " + NEEDS_SYSTEM),
    "--feedthrough": Acts("--feedthrough c", "mute"),
    "--interface": Refused("--interface a=me", "offers Co-Simulation only, no Model Exchange"),
    "--solver": Refused("--solver a=stiff", "only components of Model Exchange are integrated here"),
    "--isolate": Refused("--isolate x", "--isolate x: the system has no component of this name; it has a, b"),
    "--prefer": Refused("--prefer x", "--prefer x: it must be library or wasm"),
    "--call-timeout": Refused("--call-timeout 1", "--call-timeout is for components in processes of their own"),
    "--memory-limit": Refused("--memory-limit 1GB", "--memory-limit is for components in processes of their own"),
    "--rate": Acts("--rate b=0.05"),
    "--solve-loops": Acts("--solve-loops", "loop"),
    "--parameters": Acts("--parameters a.ssv"),
    "--schedule": Acts("--schedule standard"),
    "--input-derivatives": Acts("--input-derivatives", "jacobi"),
    "--between": Acts("--between extrapolated"),
    "--strict": Refused("--strict", "--strict: inputs that nothing drives or sets: a.n, b.n"),
    "--energy-tolerance": Refused("--energy-tolerance 1e-2", "the system has no power bond"),
    "--energy-scale": Refused("--energy-scale 2", "--energy-tolerance"),
    "--step-limits": Acts("--step-limits 1e-3,2e-3", "varied"),
    "--step-change": Acts("--step-change 0.95,1.01", "varied"),
    "--step-controller": Acts("--step-controller 0.5,0.2,0.15", "varied"),
    "--input": Acts("--input in.csv", "alone"),
    "--input-column": Acts("--input-column a.u=spare", "fed"),
    "--seed": Acts("--seed 1", "noisy"),
}
RUN_SYSTEM = COMMON | {
    "--system": Refused("--system o.ssp", "cannot be used with"),
    "--connect": Refused("--connect mass.y=spring.n", "--connect mass.y=spring.n: it is for FMUs without a structure"),
    "--fmu-dir": Refused("--fmu-dir absent", "absent/unit.fmu"),
    "--fmi": Refused("--fmi 3", "fmi3"),
    "--fmu": Refused("--fmu spring=absent.fmu", "absent.fmu"),
    "--map": Acts("--map names.ssm", "replaced"),
    "--variant": Acts("--variant other.ssd"),
    "--feedthrough": Acts("--feedthrough mass", "mute"),
    "--interface": Refused("--interface spring=me", "offers Co-Simulation only, no Model Exchange"),
    "--solver": Refused("--solver spring=stiff", "only components of Model Exchange are integrated here"),
    "--isolate": Refused("--isolate x", "--isolate x: the system has no component of this name"),
    "--prefer": Refused("--prefer x", "--prefer x: it must be library or wasm"),
    "--call-timeout": Refused("--call-timeout 1", "--call-timeout is for components in processes of their own"),
    "--memory-limit": Refused("--memory-limit 1GB", "--memory-limit is for components in processes of their own"),
    "--rate": Acts("--rate spring=0.05"),
    "--solve-loops": Acts("--solve-loops", "loop"),
    "--parameters": Acts("--parameters mass.ssv"),
    "--schedule": Acts("--schedule standard"),
    "--input-derivatives": Acts("--schedule jacobi --input-derivatives"),
    "--between": Acts("--between balanced"),
    "--strict": Refused("--strict", "--strict: inputs that nothing drives or sets keep their start values: spring.n, mass.n"),
    "--check": Acts("--check", "lacking"),
    "--energy-tolerance": Acts("--energy-tolerance 1e-2 --quiet", "free"),
    "--energy-scale": Acts("--energy-scale 100", "energy"),
    "--step-limits": Acts("--step-limits 1e-3,2e-3", "energy"),
    "--step-change": Acts("--step-change 0.5,1.1", "energy"),
    "--step-controller": Acts("--step-controller 0.5,0.2,0.15", "energy"),
    "--input": Acts("--input mass.csv"),
    "--input-column": Acts("--input-column mass.n=spare2", "fed"),
    "--seed": Acts("--seed 1", "noisy"),
}
OF_SYSTEM |= {
    "noisy": OF_SYSTEM["plain"] + " --noise spring.u=0.1",
    "fed": OF_SYSTEM["plain"] + " --input spare.csv",
    "lacking": "run lacking.ssp --variant lacking.ssd --quiet",
    "free": "run o.ssp --set mass.x=1 --csv out.csv",
}
#: What `--system` and its companions do in the other commands of `cosim`.
SYSTEM = {name: RUN_SYSTEM[name] for name in ("--fmi", "--fmu", "--variant", "--parameters", "--interface", "--solver", "--isolate", "--prefer", "--call-timeout", "--memory-limit", "--rate", "--feedthrough", "--solve-loops", "--fmu-dir",
    "--map")}
BENCH_BASES = {name: words.replace("run ", "bench --repeat 1 --system ").replace(" --quiet", "") for name, words in OF_SYSTEM.items()}
BENCH = SYSTEM | {
    **{name: COMMON[name] for name in ("--step", "--start-time", "--stop-time", "--tolerance", "--allow-nonfinite", "--set", "--threads", "--csv", "--signals", "--interval")},
    **{name: RUN_SYSTEM[name] for name in ("--schedule", "--input-derivatives", "--between", "--strict", "--check")},
    "--feedthrough": Acts("--feedthrough mass --csv out.csv", "mute"),
    "--system": Refused("--system absent.ssp", "absent.ssp", "none"),
    "--repeat": Refused("--repeat 0", "0 is not in 1.."),
    "--json": Acts("--json"),
}
BENCH_BASES["none"] = "bench"
WIRING_BASES = {
    "plain": "wiring --system o.ssp", "replaced": "wiring --system o.ssp --fmu spring=b.fmu", "loop": "wiring --system loop.ssp", "none": "wiring",
    "mute": "wiring --system mute.ssp --variant half.ssd",
}  # fmt: skip
MADE_BY_NO_RUN = "says how a run is made, and this command makes none"
OF_RUNS = {
    "--solver": "--solver spring=stiff", "--isolate": "--isolate all", "--prefer": "--prefer wasm", "--call-timeout": "--call-timeout 1", "--memory-limit": "--memory-limit 1GB",
}  # fmt: skip
WIRING = SYSTEM | {name: Refused(words, f"{name} {MADE_BY_NO_RUN}") for name, words in OF_RUNS.items()} | {"--system": Acts("--system o.ssp", "none"), "--try": Acts("--try"), "--fmu": Acts("--fmu spring=d.fmu"), "--map": Refused("--map spring=absent.ssm", "absent.ssm")}
INFO_BASES = {"plain": "info o.ssp", "fmu": "info a.fmu"}
INFO = {
    "--fmu-dir": Refused("--fmu-dir .", "--fmu-dir is for systems", "fmu"),
    "--variant": Acts("--variant other.ssd"),
    "--json": Acts("--json"),
}
#: Program, command, its bases, its table, and words of its own.
COSIM = [
    ("run", FMUS, RUN_FMUS, {"first": "a", "wire": "b.u"}),
    ("run", OF_SYSTEM, RUN_SYSTEM, {"first": "mass", "wire": "spring.u"}),
    ("bench", BENCH_BASES, BENCH, {"first": "mass"}),
    ("wiring", WIRING_BASES, WIRING, {}),
    ("info", INFO_BASES, INFO, {}),
]


def options(name, *command):
    """The options that a command has, by its own help."""
    text = subprocess.run([program(name), *command, "--help"], capture_output=True, text=True).stdout
    assert text, (name, command)
    return set(re.findall(r"^\s+(?:-\w, )?(--[\w-]+)", text, re.M)) - {"--help", "--version"}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("options")
    library = traits.compiled(folder)
    for name, version, on in (("a", 2, ""), ("b", 3, "u"), ("c", 2, None), ("d", 2, "u"), ("e", 2, "u"), ("f", 2, ""), ("g", 2, None)):
        traits.pack(folder / f"{name}.fmu", library, version, on)
    parts = {"spring": "resources/unit.fmu", "mass": "resources/unit.fmu"}
    half = traits.structure(parts, traits.OSCILLATOR[:1])
    traits.oscillator(folder / "o.ssp", folder / "a.fmu", {"other.ssd": half})
    traits.oscillator(folder / "loop.ssp", folder / "d.fmu")
    traits.oscillator(folder / "mute.ssp", folder / "c.fmu", {"half.ssd": half})
    lacking = traits.structure(parts, traits.OSCILLATOR).replace('<ssd:Connector name="z" kind="output"/>', '<ssd:Connector name="zz" kind="output"/>')
    traits.oscillator(folder / "lacking.ssp", folder / "a.fmu", {"lacking.ssd": lacking})
    (folder / "o.ssd").write_text(traits.structure({name: "a.fmu" for name in parts}, traits.OSCILLATOR))
    (folder / "a.ssv").write_text(traits.parameter_set({"a.k": 3.0}))
    (folder / "mass.ssv").write_text(traits.parameter_set({"mass.k": 3.0, "mass.n": 2}))
    for name, model in (("a", "b"), ("mass", "spring")):
        event = {"time": 0.2, "model": model, "variable": "u", "action": "override", "value": 5}
        (folder / f"{name}.json").write_text(json.dumps({"events": [event], "end": 0.5}))
    (folder / "in.csv").write_text("time,a.u\n0,1\n0.5,2\n")
    (folder / "mass.csv").write_text("time,mass.n\n0,1\n0.5,2\n")
    (folder / "spare.csv").write_text("time,spare,spare2\n0,1.5,3\n0.5,2,4\n")
    (folder / "names.ssm").write_text(
        '<ssm:ParameterMapping xmlns:ssm="m" xmlns:ssc="c" version="1.0"><ssm:MappingEntry source="u" target="u">'
        '<ssc:LinearTransformation factor="2"/></ssm:MappingEntry></ssm:ParameterMapping>'
    )
    for base, name in ((FMUS, "a"), (OF_SYSTEM, "mass")):
        command = [program("cosim"), *base["plain"].replace(" --csv out.csv --signals *", "").split(), "--snapshot", f"0.5={name}.snapshot"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder


#: Options that a command may have several times.
REPEATABLE = {"--set", "--connect", "--fmu", "--noise"}


def results(files, folder, name, words):
    """What a command does in a copy of a folder: exit code, what it prints but times, and the files that it makes."""
    shutil.copytree(files, folder)
    before = set(os.listdir(folder))
    done = subprocess.run([program(name), *words], cwd=folder, capture_output=True, text=True, timeout=60)
    said = re.sub(r"(simulated in|x real time|factor: median).*|\d+ x real time|\"real_time_factor\":\{[^}]*\}", "", done.stdout)
    made = {file: (folder / file).is_file() and (folder / file).read_bytes() for file in sorted(set(os.listdir(folder)) - before)}
    return (done.returncode, re.sub(r"[\d.]+ x$", "", said), done.stderr, made), done


def disagreement(name, files, folder, bases, entry, own):
    """Where an entry is not as it says, or nothing."""
    base, words = ([own.get(word, word).format(**own) for word in text.split()] for text in (bases[entry.on], entry.words))
    found, done = results(files, folder, name, with_options(base, words))
    if isinstance(entry, Refused):
        if done.returncode in (1, 2) and entry.part in done.stderr:
            return None
        return f"{words} must be refused with `{entry.part}`: {found[:3]}"
    plain, _ = results(files, folder / "base", name, base)
    if found == plain:
        return f"{words} changes nothing: {plain[:3]}"
    return f"{words}: {done.stderr}" if done.returncode not in (0, 2 if "--check" in words else 0) and plain[0] == 0 else None


def with_options(base, words):
    """A command with further options; one that it has already gets the other value, unless it may be repeated."""
    if words and words[0] in base and words[0] not in REPEATABLE:
        k = base.index(words[0])
        base = base[:k] + base[k + 2 :]
    return base + words


def disagreements(name, files, folder, bases, table, own):
    """Those of a whole table, as text."""
    tried = [(option, entry) for option, entry in table.items() if not isinstance(entry, Told)]
    with ThreadPoolExecutor() as pool:
        found = pool.map(lambda one: disagreement(name, files, folder / one[0], bases, one[1], own), tried)
        return [f"{option}: {what}" for (option, _), what in zip(tried, found) if what]


@pytest.mark.parametrize("command, bases, table, own", COSIM, ids=["run FMUs", "run a system", "bench", "wiring", "info"])
def test_each_option_of_cosim_acts_or_is_refused(files, tmp_path, command, bases, table, own):
    assert options("cosim", command) == set(table)
    wrong = disagreements("cosim", files, tmp_path, bases, table, own)
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("given", ["--set spring.n=1 --set mass.n=1", "--input given.csv", "--scenario given.json", "--parameters given.ssv"])
def test_inputs_that_a_run_gives_values_are_no_gaps(files, tmp_path, given):
    folder = shutil.copytree(files, tmp_path / "here")
    (folder / "given.csv").write_text("time,spring.n,mass.n\n0,1,2\n")
    events = [{"time": 0.2, "model": name, "variable": "n", "action": "override", "value": 5} for name in ("spring", "mass")]
    (folder / "given.json").write_text(json.dumps({"events": events}))
    (folder / "given.ssv").write_text(traits.parameter_set({"spring.n": 1, "mass.n": 2}))
    run = [program("cosim"), "run", "o.ssp", "--set", "mass.x=1", "--quiet", "--strict"]
    refused = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    assert refused.returncode == 1 and "spring.n, mass.n" in refused.stderr
    done = subprocess.run([*run, *given.split()], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and "keep their start values" not in done.stdout, done.stderr


def test_advice_can_be_followed(files, tmp_path):
    """What a message says is to be done: the same command with it runs, and the message is gone."""
    folder = shutil.copytree(files, tmp_path / "here")

    def run(words):
        done = subprocess.run([program("cosim"), *words.split()], cwd=folder, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    for base, said, advice in [
        (FMUS["loop"], "--solve-loops asks for", "--solve-loops"),
        (FMUS["mute"], "--feedthrough COMPONENT", "--feedthrough c"),
        (FMUS["alone"] + " --fault a.u=bias:1", "no input file gives `a.u` a value", "--input in.csv"),
        (FMUS["plain"] + " --input-derivatives", "needs --schedule jacobi", "--schedule jacobi"),
        (FMUS["plain"].replace("b.fmu", "f.fmu").replace("b.", "f.") + " --between end --schedule jacobi", "schedule gauss-seidel", "gauss-seidel"),
        (FMUS["plain"] + " --step-limits 1e-3,0.1", "needs --energy-tolerance or --doubling-tolerance", "--doubling-tolerance 1e-2"),
        ("run o.ssp --quiet --set k=2", "name the component: component.k", "mass.k"),
        ("run o.ssp --quiet --set mass.kk=2", "did you mean `mass.k`?", "mass.k"),
        ("bench --repeat 1", "--system FILE", "--system o.ssp"),
    ]:
        code, text = run(base)
        assert said in text, (base, text)
        option = "--schedule" if advice == "gauss-seidel" else "--set" if advice == "mass.k" else None
        if option:
            words = base.split()
            k = len(words) - 1 - words[::-1].index(option)
            words[k + 1] = advice if option == "--schedule" else f"{advice}=2"
            followed = " ".join(words)
        else:
            followed = f"{base} {advice}"
        code, text = run(followed)
        assert code == 0 and said not in text, (followed, text)


SHARED = "one setup for all commands: tried with `run`"
#: What names the machine and how it is run, for `hdrm-fmu run`; GAP is a structure that lacks a connection.
MACHINE = {
    "--system": Refused("--system absent.ssp", "absent.ssp"),
    "--fmu-dir": Refused("--fmu-dir absent", "absent/"),
    "--fmi": Refused("--fmi 3 --fmu-dir absent", "absent/fmi3/"),
    "--fmu": Refused("--fmu hdrm=absent.fmu", "absent.fmu"),
    "--map": Refused("--map hdrm=absent.ssm", "absent.ssm"),
    "--variant": Refused("--variant absent.ssd", "absent.ssd"),
    "--feedthrough": Refused("--feedthrough absent", "--feedthrough absent"),
    "--interface": Acts("--interface hdrm=me"),
    "--solver": Refused("--solver hdrm=stiff", "only components of Model Exchange are integrated here"),
    "--isolate": Refused("--isolate x", "--isolate x: the system has no component of this name"),
    "--prefer": Refused("--prefer x", "--prefer x: it must be library or wasm"),
    "--call-timeout": Refused("--call-timeout 1", "--call-timeout is for components in processes of their own"),
    "--memory-limit": Refused("--memory-limit 1GB", "--memory-limit is for components in processes of their own"),
    "--rate": Acts("--rate hdrm=0.0005"),
    "--solve-loops": Told("the machine has no loops: tried with cosim"),
    "--parameters": Refused("--parameters absent.ssv", "absent.ssv"),
    "--machine": Acts("--machine sized"),
    "--step": Acts("--step 0.002"),
    "--start-time": Refused("--start-time nan", "--start-time NaN: the start must be a finite time"),
    "--stop-time": Acts("--stop-time 0.01"),
    "--tolerance": COMMON["--tolerance"],
    "--allow-nonfinite": COMMON["--allow-nonfinite"],
    "--schedule": Acts("--schedule jacobi"),
    "--input-derivatives": Refused("--input-derivatives", "needs --schedule jacobi"),
    "--between": Acts("--between extrapolated"),
    "--threads": Refused("--threads 0", "0 threads"),
    "--set": Acts("--set hdrm.payload.mass=80"),
    "--strict": Refused("--strict --system GAP", "--strict: "),
    "--check": Acts("--check --max-error 1e-12"),
    "--waypoints": Acts("--waypoints six-joints"),
}
#: The same for the other commands: three show that they read the setup.
SETUP = {name: Told(SHARED) for name in MACHINE} | {
    "--parameters": MACHINE["--parameters"],
    "--set": Refused("--set absent=1", "`absent`"),
    "--waypoints": Refused("--waypoints absent.json", "absent.json"),
}
SHORT = "--stop-time 0.02"
SLOW = "takes long: tests/test_worlds.py"
#: By command: bases and table.
STUDIES = {
    "run": (
        {"plain": f"run {SHORT} --set settle_time=0 --quiet --csv out.csv --signals *"},
        MACHINE
        | {
            "--trajectory": Acts("--trajectory external"),
            "--mode": Acts("--mode pd"),
            "--inertia-scale": Acts("--inertia-scale 2"),
            "--csv": Acts("--csv more.csv"),
            "--signals": Acts("--signals *.F"),
            "--interval": Acts("--interval 0.01"),
            "--mcap": Acts("--mcap m.mcap"),
            "--max-error": Acts("--max-error 1e-12"),
            "--quiet": Told("the progress bar is on terminals only"),
        },
    ),
    "compare": (
        {"plain": f"compare {SHORT}", "files": f"compare {SHORT} --csv-dir ."},
        SETUP
        | {
            "--trajectory": Acts("--trajectory triangular"),
            "--inertia-scale": Acts("--inertia-scale 2"),
            "--csv-dir": Acts("--csv-dir ."),
            "--interval": Acts("--interval 0.01", "files"),
        },
    ),
    "table": (
        {"plain": f"table --study payload {SHORT}", "noise": f"table --study noise {SHORT}", "rivals": f"table --study rivals --law pd {SHORT}"},
        SETUP
        | {
            "--world": Refused("--world strict-rigid", "--study payload does not exist in the strict-rigid world"),
            "--study": Acts("--study tip-load"),
            "--seed": Acts("--seed 2", "noise"),
            "--seeds": Refused("--seeds 2", "--seeds is for", "rivals"),
            "--law": Refused("--law pd", "--law is for comparisons of laws"),
            "--csv": Refused("--csv t.csv --study inertia --study rivals", "--csv is for one table at a time"),
            "--json": Acts("--json t.json"),
        },
    ),
    "testbed": (
        {"plain": f"testbed {SHORT}"},
        SETUP
        | {
            "--testbed": Refused("--testbed absent.ssp", "absent.ssp"),
            "--rig-testbed": Told("read after the first testbed's runs, which take long"),
            "--lag": Refused("--lag=-1", "--lag must be finite"),
            "--csv-dir": Told("takes long"),
            "--json": Told("takes long"),
        },
    ),
    "stability": (
        {"plain": f"stability {SHORT}"},
        SETUP | {"--world": Refused("--world strict", "--world strict: "), "--inertia-scale": Told("takes long"), "--json": Told("takes long")},
    ),
    "energy": ({"plain": f"energy {SHORT}"}, SETUP | {"--csv": Acts("--csv e.csv"), "--json": Acts("--json e.json")}),
    "sizing": (
        {"plain": f"sizing {SHORT}"},
        SETUP
        | {
            "--payload-step": Acts("--payload-step 0"),
            "--figures": Told("tests/test_electric.py"),
            "--csv": Acts("--csv s.csv"),
            "--json": Acts("--json s.json"),
        },
    ),
    "endurance": (
        {"plain": "endurance --steps 3000"},
        SETUP
        | {
            "--stop-time": Refused(SHORT, "--stop-time cannot be used here"),
            "--steps": Acts("--steps 2000"),
            "--edges": Acts("--edges 0.1 0.1 0.1"),
            "--period": Acts("--period 7"),
            "--mode": Acts("--mode pd"),
            "--inertia-scale": Acts("--inertia-scale 2"),
        },
    ),
    "draws": (
        {"plain": f"draws --seeds 1 {SHORT}"},
        SETUP
        | {
            "--world": Refused("--world ideal", "--world ideal: "),
            "--bounds": Acts("--bounds 1"),
            "--seed": Acts("--seed 2"),
            "--seeds": Acts("--seeds 2"),
            "--mode": Acts("--mode pd"),
            "--trajectory": Acts("--trajectory cubic"),
            "--store": Acts("--store kept"),
            "--json": Acts("--json d.json"),
        },
    ),
    "weighing": (
        {"plain": "weighing"},
        SETUP
        | {"--stop-time": Refused(SHORT, "--stop-time cannot be used here"), "--shift": Refused("--shift 0.3", "three numbers")}
        | dict.fromkeys(["--mode", "--payload", "--store", "--csv", "--json"], Told(SLOW)),
    ),
    "rest": (
        {"plain": "rest"},
        SETUP
        | {"--stop-time": Refused(SHORT, "--stop-time cannot be used here"), "--world": Refused("--world strict-rigid", "the worlds ideal and real")}
        | dict.fromkeys(["--law", "--follows", "--poses", "--seed", "--store", "--csv", "--json"], Told(SLOW)),
    ),
    "tournament": (
        {"plain": "tournament"},
        SETUP | dict.fromkeys(["--law", "--budget", "--tuning-seeds", "--trial-seeds", "--seeds", "--path", "--ideal-wrist", "--again", "--store", "--json"], Told(SLOW)),
    ),
    "margins": (
        {"plain": "margins"},
        SETUP
        | {"--stop-time": Refused(SHORT, "--stop-time cannot be used here")}
        | dict.fromkeys(["--law", "--place", "--payload", "--store", "--csv", "--json"], Told(SLOW)),
    ),
    "evaluate": (
        {"plain": "evaluate run.csv --set settle_time=0", "json": "evaluate run.csv --set settle_time=0 --json j.json"},
        SETUP
        | {name: Refused(words, MADE_BY_NO_RUN) for name, words in {
            "--stop-time": SHORT, "--input-derivatives": "--input-derivatives", "--between": "--between extrapolated", "--threads": "--threads 2",
            "--interface": "--interface hdrm=me", **OF_RUNS,
            "--rate": "--rate hdrm=0.0005", "--feedthrough": "--feedthrough hdrm", "--solve-loops": "--solve-loops",
        }.items()}
        | {
            "--step": Acts("--step 0.002", "json"),
            "--schedule": Acts("--schedule jacobi", "json"),
            "--check": Acts("--check --max-error 1e-12"),
            "--max-error": Acts("--max-error 1e-12"),
            "--json": Acts("--json j.json"),
            "--signals": Refused("--signals", "cannot be used with"),
        },
    ),
    "report": (
        {"plain": "report"},
        SETUP
        | {
            "--waypoints": Refused("--waypoints absent.json", "absent.json"),
            "--tournament": Refused("--tournament absent.json", "absent.json"),
            "--margins": Refused("--margins absent.json", "absent.json"),
            "--testbed": Refused("--testbed absent.ssp", "absent.ssp"),
            "--bending": Told("needs MuJoCo: tests/test_report.py"),
            "--out": Told("tests/test_report.py"),
            "--figures": Told("tests/test_report.py"),
        },
    ),
    "machine perturb": (
        {"plain": "machine perturb"},
        {
            "--seed": Acts("--seed 2"),
            "--machine": Acts("--machine sized"),
            "--mass": Acts("--mass 0.2"),
            "--com": Acts("--com 0.2"),
            "--second-moment": Acts("--second-moment 0.3"),
            "--length": Acts("--length 0.02"),
            "--plumb": Acts("--plumb 3"),
            "--out": Acts("--out other.json"),
        },
    ),
    "machine scale": (
        {"plain": "machine scale --booms 1.1 --output m.json"},
        {"--booms": Acts("--booms 1.2"), "--machine": Acts("--machine sized"), "--output": Acts("--output n.json")},
    ),
    "machine check": ({"plain": "machine check reference"}, {"--no-trials": Acts("--no-trials")}),
    "machine gains": (
        {"plain": "machine gains reference"},
        {"--world": Acts("--world ideal"), "--output": Acts("--output gains.ssv")},
    ),
    "machine draw": (
        {"plain": "machine draw reference"},
        {"--output": Acts("--output m.png"), "--dynamic-factor": Acts("--dynamic-factor 1.3"), "--csv": Acts("--csv chart.csv")},
    ),
    "machine export": (
        {"plain": "machine export reference"},
        {"--mjcf": Acts("--mjcf m.xml"), "--urdf": Acts("--urdf m.urdf")},
    ),
    "machine pack": ({"plain": "machine pack reference --out packed"}, {"--out": Acts("--out other")}),
    "machine scene": ({"plain": "machine scene"}, {"--out": Acts("--out other.json"), "--page": Refused("--page absent.html", "absent.html")}),
    "path check": (
        {"plain": "path check six-joints"},
        {"--machine": Acts("--machine hiab_xs031"), "--figures": Acts("--figures ."), "--json": Acts("--json p.json")},
    ),
    "path show": ({"plain": "path show six-joints"}, {"--machine": Acts("--machine hiab_xs031")}),
    "plot": ({"plain": "plot run.csv"}, {"--signals": Acts("--signals *.tip_error_norm"), "--out": Acts("--out drawn")}),
    "train": (
        {"plain": "train --data absent.csv"},
        {"--data": Refused("", "absent.csv"), "--resume": Told("tests of studies/surrogate")}
        | dict.fromkeys(["--seed", "--cells", "--epochs", "--out", "--checkpoint"], Told("takes long")),
    ),
    "surrogate data": ({"plain": "surrogate data"}, dict.fromkeys(["--profiles", "--seconds", "--seed", "--out"], Told("takes long"))),
    "surrogate plots": (
        {"plain": "surrogate plots --data absent.csv"},
        {"--data": Refused("", "absent.csv"), "--network": Refused("--network absent.json", "absent.json"), "--out": Told("takes long")},
    ),
    "surrogate compare": (
        {"plain": "surrogate compare"},
        {"--network": Refused("--network absent.json", "absent.json")}
        | dict.fromkeys(["--seed", "--profiles", "--seconds", "--covered", "--machines", "--out"], Told("takes long")),
    ),
    "surrogate calibrate": (
        {"plain": "surrogate calibrate"},
        {"--network": Refused("--network absent.json", "absent.json"), "--profiles": Told("takes long"), "--out": Told("takes long")},
    ),
    "surrogate loop": (
        {"plain": "surrogate loop --run absent.csv"},
        {"--network": Refused("--network absent.json", "absent.json"), "--run": Refused("", "absent.csv"), "--start": Told("takes long")},
    ),
}  # fmt: skip
KIT = {
    "new": {"--fmu-export": "tests/test_cargo_fmu.py", "--example": "tests/test_cargo_fmu.py"},
    "pack": dict.fromkeys(["--package", "--example", "--target", "--out", "--profile", "--size"], "builds: tests/test_cargo_fmu.py"),
    "check": dict.fromkeys(["--strict", "--timeout", "--only"], "fmi/fmu-check/tests"),
    "web": {"--out": "tests/test_model_page.py", "--engine": "tests/test_wasm.py", "--profile": "below"},
}


@pytest.fixture(scope="module")
def machine(fmu_dir, tmp_path_factory):
    folder = tmp_path_factory.mktemp("machine")
    text = (ROOT / "system/SystemStructure.ssd").read_text()
    (wire,) = [line for line in text.splitlines() if 'endElement="controller" endConnector="i_d[1]"' in line]
    (folder / "gap.ssd").write_text(text.replace(wire, ""))
    run = [program("hdrm-fmu"), "run", *SHORT.split(), "--set", "settle_time=0", "--quiet", "--csv", "run.csv", "--signals", "*", "--system", fmu_dir / "Manipulator.ssp"]
    subprocess.run(run, cwd=folder, check=True, capture_output=True)
    return folder


@pytest.mark.parametrize("command", STUDIES)
def test_each_option_of_hdrm_fmu_acts_or_is_refused(fmu_dir, machine, tmp_path, monkeypatch, command):
    monkeypatch.setenv("FMU_DIR", str(fmu_dir))
    bases, table = STUDIES[command]
    assert options("hdrm-fmu", *command.split()) == set(table)
    wrong = disagreements("hdrm-fmu", machine, tmp_path, bases, table, {"GAP": "gap.ssd"})
    assert not wrong, "\n".join(wrong)


def test_the_options_of_cargo_fmu_have_tests():
    for command, table in KIT.items():
        assert options("cargo-fmu", "fmu", command) == set(table)
    refused = subprocess.run([program("cargo-fmu"), "fmu", "web", "a.fmu", "--out", "a.html", "--engine", "e.wasm", "--profile", "dev"], capture_output=True)
    assert refused.returncode == 2 and b"cannot be used with" in refused.stderr
