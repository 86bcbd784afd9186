"""`cargo fmu` as its users call it: a new crate, the battery of `examples/`, and an FMU that another tool made."""

import json
import math
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from conftest import FMU_DIR
from fmpy_master import ROOT
from native import cargo_fmu, libpython
from test_edited_resources import edited

BATTERY = ROOT / "examples/battery"


def packed(folder, out):
    done = cargo_fmu("pack", "--profile", "release", "--out", out, cwd=folder)
    assert done.returncode == 0, done.stderr
    (path,) = Path(out).glob("*.fmu")
    return path


@pytest.fixture(scope="module")
def battery(tmp_path_factory):
    return packed(BATTERY, tmp_path_factory.mktemp("battery"))


def test_the_battery_follows_the_closed_form(battery):
    """At a constant current the charge is a straight line and the RC pair an exponential. The solver of order 4 errs by 1.3e-11 of v_1
    (see the test of the model), and v is printed by FMPy as it is."""
    i, t = 80.0, 60.0
    result = fmpy.simulate_fmu(str(battery), stop_time=t, output_interval=1.0, start_values={"i": i}, output=["v", "soc", "T"])
    soc = 0.9 - i * t / (3600.0 * 50.0)
    v_1 = 0.8e-3 * i * -math.expm1(-t / (0.8e-3 * 2.0e4))
    assert result["time"][-1] == pytest.approx(t)
    assert result["soc"][-1] == pytest.approx(soc, abs=1e-12)
    assert result["v"][-1] == pytest.approx(3.0 + 1.2 * soc - 1.5e-3 * i - v_1, abs=1e-10)
    assert 298.15 < result["T"][-1] < 299.15


def test_the_battery_passes_the_check(battery):
    done = cargo_fmu("check", battery)
    assert done.returncode == 0, done.stdout
    assert " 0 failed" in done.stdout


def test_files_and_notices_are_packed_by_convention(battery):
    with zipfile.ZipFile(battery) as archive:
        assert archive.read("documentation/index.html") == (BATTERY / "documentation/index.html").read_bytes()
        notices = archive.read("documentation/licenses/third-party.txt").decode()
        licence = archive.read("documentation/licenses/license.txt").decode()
    assert licence.startswith("Licence: MIT OR Apache-2.0\n")
    assert "\nserde 1." in notices and "\nfmu-export 0." in notices and "Permission is hereby granted" in notices
    assert str(ROOT) not in notices and str(Path.home()) not in notices


def own_tests(folder):
    """Those of a new crate, which must pass without a warning."""
    # As `cargo fmu pack` sets the profile, so that what the battery needed is not compiled again.
    settings = ["profile.release.panic='unwind'", "profile.release.strip='symbols'"]
    command = ["cargo", "test", "--release", "--quiet", *(word for setting in settings for word in ("--config", setting))]
    environment = os.environ | {"CARGO_TARGET_DIR": str(FMU_DIR.parent / "stand-alone")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "warning" not in done.stderr, done.stdout + done.stderr
    return done.stdout


def test_a_new_crate_passes_its_own_tests(tmp_path):
    made = cargo_fmu("new", "heat-store", cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    assert "2 passed" in own_tests(tmp_path / "heat-store")
    again = cargo_fmu("new", "heat-store", cwd=tmp_path)
    assert again.returncode == 1 and "heat-store is already there" in again.stderr
    wrong = cargo_fmu("new", "Heat Store", cwd=tmp_path)
    assert wrong.returncode == 1 and "the name `Heat Store` must be" in wrong.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["heat-store"]


def test_a_table_edited_in_the_archive_counts(tmp_path):
    """All efficiencies are 50 % in the archive's own file: the drive draws twice its mechanical power, in both versions and interfaces."""
    made = cargo_fmu("new", "mapper", "--example", "map", cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    assert " passed" in own_tests(tmp_path / "mapper")
    archive, table = packed(tmp_path / "mapper", tmp_path / "fmu"), "resources/efficiency.csv"

    def power(archive, kind="CoSimulation"):
        values = {"speed": 100.0, "torque": 10.0}
        return fmpy.simulate_fmu(str(archive), fmi_type=kind, stop_time=1.0, start_values=values, output=["P"])["P"][-1]

    lines = zipfile.ZipFile(archive).read(table).decode().splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("speed"))
    flat = [*lines[: head + 1], *(line.rsplit(",", 1)[0] + ",50" for line in lines[head + 1 :] if line.strip())]
    for folder in ("", "fmi3"):
        own = archive.parent / folder / archive.name
        assert power(own) == pytest.approx(1481.6, abs=0.1)
        other = edited(own, tmp_path / "Edited.fmu", {table: "\n".join(flat) + "\n"})
        assert [power(other, kind) for kind in ("CoSimulation", "ModelExchange")] == [2000.0, 2000.0]
        gone = edited(own, tmp_path / "Gone.fmu", {table: None})
        assert power(gone) == power(own)
        bad = edited(own, tmp_path / "Bad.fmu", {table: "\n".join([*flat, "1,2,3,4"]) + "\n"})
        said = []
        with pytest.raises(Exception):  # noqa: B017 (FMPy's own)
            fmpy.simulate_fmu(str(bad), fmi_type="CoSimulation", stop_time=1.0, debug_logging=True, logger=lambda *its: said.append(its[-1]))
        texts = " ".join(text.decode() if isinstance(text, bytes) else str(text) for text in said)
        assert f"line {len(flat) + 1}" in texts and "efficiency.csv" in texts, texts


@pytest.mark.parametrize("example", ["battery", "events"])
def test_the_examples_pass_their_own_tests(example, tmp_path):
    made = cargo_fmu("new", f"my-{example}", "--example", example, cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    assert " passed" in own_tests(tmp_path / f"my-{example}")


@pytest.fixture(scope="module")
def rod(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rod")
    made = cargo_fmu("new", "my-rod", "--example", "rod", cwd=folder)
    assert made.returncode == 0, made.stderr
    assert " passed" in own_tests(folder / "my-rod")
    return packed(folder / "my-rod", folder / "fmu")


def heated_rod(t, n=50):
    """Temperatures of the cells after one end has jumped by 100 K: a straight line less waves, each of which decays on its own."""
    i, k = np.arange(n) + 0.5, np.arange(1, n + 1)[:, None]
    waves, line = np.sin(np.pi * k * i / n), 100.0 * (1.0 - i / n)
    parts = waves @ line / np.where(k[:, 0] < n, n / 2, n)
    rates = 4 * n**2 * np.sin(np.pi * k[:, 0] / (2 * n)) ** 2 * 400.0 * 1e-4 / 0.5 / 170.0
    return 293.15 + line - (parts * np.exp(-rates * t)) @ waves


def test_the_rod_keeps_the_tolerance_that_is_asked_for(rod):
    """Errors of internal steps add up, and conduction damps them: less than ten times the tolerance, of 300 K. Without one it is that of
    the model, 1e-6. FMI 3.0 gives the same bits."""
    ends = {"T_end[1]": 393.15}
    for tolerance in [None, 1e-3, 1e-9]:
        run = {"stop_time": 100.0, "output_interval": 10.0, "relative_tolerance": tolerance}
        result = fmpy.simulate_fmu(str(rod), **run, fmi_type="CoSimulation", start_values=ends, output=[f"T[{i + 1}]" for i in range(50)])
        found = np.array(list(result[-1])[1:])
        error = np.max(np.abs(found - heated_rod(100.0)))
        assert error < 10 * 300.0 * (tolerance or 1e-6)
        fmi3 = {"fmi_type": "CoSimulation", "start_values": {"T_end": [393.15, 293.15]}, "output": ["T"]}
        result = fmpy.simulate_fmu(str(rod.parent / "fmi3" / rod.name), **run, **fmi3)
        assert np.array_equal(result["T"][-1], found)
    assert error > 1e-12


def test_the_rod_passes_the_check(rod):
    done = cargo_fmu("check", rod)
    assert done.returncode == 0, done.stdout


SLAVE = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Lag(Fmi2Slave):
    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.u, self.y = 0.0, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input, variability=Fmi2Variability.continuous, start=0.0))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, h):
        self.y += h * (self.u - self.y)
        return True
'''


def test_an_fmu_of_fmi_3_of_another_tool(fmu_dir, tmp_path):
    """A container of fmu-manipulation-toolbox, which has no Event Mode: nothing is asked of it that FMI 3.0 forbids. Inside is an FMU
    of ours, which would refuse a get after a set."""
    inside = {"fmu": ["Emla.fmu"], "path": {"Emla.fmu": str(fmu_dir / "fmi3/Emla.fmu")}}
    automatic = {"auto_link": False, "auto_input": True, "auto_output": True}
    (tmp_path / "container.json").write_text(json.dumps({"name": "Container.fmu", "step_size": 1e-3, **automatic, **inside}))
    command = [Path(sys.executable).with_name("fmucontainer"), "-container", "container.json", "-fmu-directory", ".", "-fmi", "3"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    done = cargo_fmu("check", "Container.fmu", cwd=tmp_path)
    assert done.returncode == 1
    assert "FMI 3.0, co-simulation" in done.stdout and "made by FMUContainer" in done.stdout
    assert "pass         modelDescription.xml is UTF-8, well-formed, and valid by the schema" in done.stdout
    assert "pass         it initializes and steps; every number" in done.stdout
    assert "pass         an input that is set is read back bit for bit" in done.stdout
    assert "not checked  an input acts at once only on outputs" in done.stdout
    assert "pass         NaN and infinity are refused" in done.stdout
    assert "a step beyond the stop time gave fmi3OK, expected fmi3Error" in done.stdout


def test_an_fmu_of_another_tool(tmp_path):
    """pythonfmu's FMU: what is said of its description, and that it needs Python around it; with that it runs through every row."""
    (tmp_path / "lag.py").write_text(SLAVE)
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", "lag.py"], cwd=tmp_path, check=True, capture_output=True)
    bare = cargo_fmu("check", "Lag.fmu", cwd=tmp_path, environment={"LD_PRELOAD": ""})
    assert bare.returncode == 1
    assert "made by PythonFMU" in bare.stdout
    assert "FAILS        InitialUnknowns lists exactly what is computed in initialization" in bare.stdout
    assert "FAILS        the library loads" in bare.stdout and "undefined symbol: _Py" in bare.stdout
    assert "not checked  everything else" in bare.stdout
    if not libpython():  # a Python without a shared library: no program but itself can load such an FMU
        return
    packages = os.pathsep.join(path for path in sys.path if path)
    through = cargo_fmu("check", "Lag.fmu", cwd=tmp_path, environment={"LD_PRELOAD": libpython(), "PYTHONPATH": packages})
    assert "pass         it initializes and steps" in through.stdout, through.stdout
    assert "FAILS        a step to the stop time is done, one beyond it refused" in through.stdout
    assert "not robust   NaN and infinity are refused" in through.stdout
