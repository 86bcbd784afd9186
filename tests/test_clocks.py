"""Scheduled Execution and clocks of the example `clocks` of fmu-export, which has the variables of the Reference-FMUs' Clocks: by their own
drivers, unchanged in `scheduled/`, by FMPy's FMU3ScheduledExecution, and in cosim, which ticks the clocks in Event Mode."""

import csv
import re
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi3 import FMU3ScheduledExecution

from native import cargo_fmu, program
from test_sizes import pack

SOURCES = Path(__file__).parent / "scheduled"
COMPILED = pytest.mark.skipif(sys.platform != "linux" or not shutil.which("cc"), reason="a program for Linux, made by a C compiler")

#: Time, and ticks of the three clocks and of all, by the table in the Reference-FMUs' Clocks: the first every second, the second at 0, 1, 8
#: and 9, the third at 4.
ROWS = []
for t in range(10):
    first, second, third = t + 1, min(t + 1, 2) + max(t - 7, 0), int(t >= 4)
    ROWS.append([t, first, second, third, first + second + third])


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    out = tmp_path_factory.mktemp("clocks")
    done = pack(out, example="clocks")
    assert done.returncode == 0, done.stderr
    assert "not packed for FMI 2.0: clock `inClock2` is triggered" in done.stderr
    return out / "fmi3" / "Clocks.fmu"


@pytest.fixture(scope="module")
def description(fmu):
    return fmpy.read_model_description(str(fmu), validate=False)


def driver(name, fmu, description, folder):
    """A driver of the Reference-FMUs, compiled, with the FMU unpacked beside it; what it prints."""
    fmpy.extract(str(fmu), str(folder / "Clocks"))
    numbers = ", ".join(f"vr_{v.name} = {v.valueReference}" for v in description.modelVariables)
    (folder / "config.h").write_text(
        "#include <stdint.h>\n#define MODEL_IDENTIFIER Clocks\n#define WINDOWS\n#define N_INPUT_CLOCKS 3\n"
        f'#define INSTANTIATION_TOKEN "{description.instantiationToken}"\n'
        f"#define DEFAULT_STOP_TIME 10\n#define FIXED_SOLVER_STEP 1\ntypedef enum {{ {numbers} }} ValueReference;\n"
    )
    headers = Path(find_spec("fmpy").origin).parent / "c-code"
    windows = ["-D_WIN32"] if name == "scs_threaded" else []
    sources = [SOURCES / f"{name}.c", SOURCES / "Clocks.c"]
    command = ["cc", "-w", *windows, "-DFMI_VERSION=3", f"-I{SOURCES}", f"-I{folder}", f"-I{headers}", *sources, "-o", folder / name, "-ldl", "-lpthread"]
    subprocess.run(command, check=True)
    done = subprocess.run([folder / name], cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Error" not in done.stdout, done.stdout
    return done.stdout


def test_check(fmu):
    done = cargo_fmu("check", fmu)
    assert done.returncode == 0 and " 0 failed" in done.stdout, done.stdout


@COMPILED
def test_synchronous_driver(fmu, description, tmp_path):
    driver("scs_synchronous", fmu, description, tmp_path)
    with open(tmp_path / "scs_synchronous_out.csv") as file:
        rows = list(csv.reader(file))
    assert [[int(cell) for cell in row] for row in rows[1:]] == ROWS


@COMPILED
def test_threaded_driver(fmu, description, tmp_path):
    said = driver("scs_threaded", fmu, description, tmp_path)
    for vr, times in [(1001, 10), (1002, 4), (1003, 1)]:
        assert said.count(f"fmi3ActivateModelPartition ({vr})") == times
    # The output clock ticks at each fifth of 15 ticks; two callbacks may see it as one.
    assert 1 <= said.count("Detected ticking of output clock") <= 3


def test_fmpy(fmu, description, tmp_path):
    """A script on FMPy's FMU3ScheduledExecution."""
    folder = fmpy.extract(str(fmu), str(tmp_path))
    instance = FMU3ScheduledExecution(
        guid=description.instantiationToken, unzipDirectory=folder, modelIdentifier="Clocks", instanceName="scheduled"
    )
    instance.instantiate()
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    for t, *ticks in ROWS:
        instance.activateModelPartition(1001, float(t))
        if t in (0, 1, 8, 9):
            instance.setInt32([2006], [t])
            instance.activateModelPartition(1002, float(t))
        if t == 4:
            instance.activateModelPartition(1003, float(t))
        assert instance.getInt32([2001, 2002, 2003, 2004]) == ticks
    assert instance.getInt32([2005, 2007]) == [18, 1000]
    instance.terminate()
    instance.freeInstance()


def test_cosim_ticks_them(fmu, tmp_path):
    """The first every second and the third when the first has started it; nothing ticks the second."""
    out = tmp_path / "out.csv"
    done = subprocess.run([program("cosim"), "run", fmu, "--stop-time", "9.5", "--step", "0.5", "--csv", out], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "its clock `inClock2` is triggered from outside" in done.stdout + done.stderr
    with open(out) as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        t = float(row["time"])
        value = lambda name: int(float(next(row[key] for key in row if key.endswith(name))))
        assert value("inClock1Ticks") == int(t) + 1
        assert value("inClock3Ticks") == (t >= 4)
        assert value("output3") == 1000 * (t >= 4)


def test_cosim_connects_them(fmu, tmp_path):
    """`outClock` of one ticks `inClock2` of another, with every schedule: at 4 s, when the first one's ticks are five, and at 8 s, when they are
    ten, since the countdown has ticked at 4 s, too. The other then has what the driver's table has of the first and third clock."""
    a, b = (shutil.copy(fmu, tmp_path / f"{name}.fmu") for name in "ab")
    for schedule in ("standard", "jacobi", "gauss-seidel"):
        out = tmp_path / f"{schedule}.csv"
        options = ["--connect", "a.outClock=b.inClock2", "--connect", "a.totalInClockTicks=b.input2", "--stop-time", "9.5", "--step", "0.5"]
        command = [program("cosim"), "run", a, b, *options, "--schedule", schedule, "--signals", "b.*", "--csv", out]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        said = done.stdout + done.stderr
        assert "a: its clock `inClock2` is triggered from outside" in said and "b: its clock" not in said, said
        with open(out) as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 20
        for row in rows:
            t = float(row["time"])
            _, first, _, third, _ = ROWS[int(t)]
            ticks = (t >= 4) + (t >= 8)
            value = lambda name: int(float(row[f"b.{name}"]))
            expected = [first, ticks, third, 5 * (t >= 4) + 10 * (t >= 8)]
            assert [value(name) for name in ("inClock1Ticks", "inClock2Ticks", "inClock3Ticks", "result2")] == expected, (schedule, t, row)


def scheduled_only(fmu, out):
    """The FMU with its Scheduled Execution alone, as the Reference-FMUs' Clocks has it."""
    with zipfile.ZipFile(fmu) as packed, zipfile.ZipFile(out, "w") as to:
        for item in packed.namelist():
            content = packed.read(item)
            if item == "modelDescription.xml":
                content, count = re.subn(rb"<(CoSimulation|ModelExchange)\b[^>]*/>", b"", content)
                assert count > 0 and b"<ScheduledExecution" in content
            to.writestr(item, content)
    return out


def test_cosim_schedules_them(fmu, tmp_path):
    """Without another interface, `cosim` activates the model partitions: the ticks are those of Event Mode, with every schedule and in a
    process of its own. `outClock`, which the fifth and tenth tick cause, activates `inClock2` of the other."""
    a, b = (scheduled_only(fmu, tmp_path / f"{name}.fmu") for name in "ab")
    runs = [["--schedule", schedule] for schedule in ("standard", "jacobi", "gauss-seidel")] + [["--isolate", "all"]] * (sys.platform == "linux")
    for options in runs:
        out = tmp_path / "out.csv"
        connected = ["--connect", "a.outClock=b.inClock2", "--connect", "a.totalInClockTicks=b.input2"]
        command = [program("cosim"), "run", a, b, *connected, "--stop-time", "9.5", "--step", "0.5", *options, "--signals", "a.*,b.*", "--csv", out]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        with open(out) as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 20
        for row in rows:
            t = float(row["time"])
            _, first, _, third, _ = ROWS[int(t)]
            ticks = (t >= 4) + (t >= 8)
            value = lambda name: int(float(row[name]))
            assert [value(f"a.inClock{k}Ticks") for k in (1, 2, 3)] == [first, 0, third], (options, row)
            expected = [first, ticks, third, 5 * (t >= 4) + 10 * (t >= 8)]
            found = [value(f"b.{name}") for name in ("inClock1Ticks", "inClock2Ticks", "inClock3Ticks", "result2")]
            assert found == expected, (options, row)
