"""The page docs/master/cosim-tutorial.md: its plant and its controller, packed and run by the commands that stand there."""

import csv
import os
import re
import subprocess
import sys
import zipfile

import pytest

from fmpy_master import ROOT
from native import cargo_fmu, libpython, program
from test_ssp import complaints

PAGE = (ROOT / "docs/master/cosim-tutorial.md").read_text()
SECTION = PAGE[PAGE.index("## Install") : PAGE.index("## Where to read on")]
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", SECTION, re.MULTILINE | re.DOTALL)


def blocks(language):
    return [text for found, text in BLOCKS if found == language]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of the page, with both FMUs."""
    folder = tmp_path_factory.mktemp("two")
    assert cargo_fmu("new", "mass", cwd=folder).returncode == 0
    (plant,), (controller,) = blocks("rust"), blocks("python")
    (folder / "mass/src/lib.rs").write_text(plant)
    (folder / "pid.py").write_text(controller)
    packed = cargo_fmu("pack", "--out", "..", cwd=folder / "mass")
    assert packed.returncode == 0, packed.stderr
    built = subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", "pid.py"], cwd=folder, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder


def cosim(folder, *more, **environment):
    (line,) = [line for line in blocks("sh")[1].splitlines() if line.startswith("cosim run")]
    command = [str(program("cosim")), *line.split()[1:], *more]
    return subprocess.run(command, cwd=folder, env=os.environ | environment, capture_output=True, text=True)


def test_the_two_parts_run_as_the_page_says(folder):
    if not libpython():  # a Python without a shared library: no program but itself can load such an FMU
        return
    done = cosim(folder, LD_PRELOAD=libpython())
    assert done.returncode == 0, done.stderr
    for told in ("the communication step is 0.01 s, as `Mass` asks", "Mass.measured, Pid.force", "only one end has a unit"):
        assert told in done.stdout, told
    with (folder / "loop.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["time"]) == 10.0
    assert abs(float(rows[-1]["Mass.measured"]) - 0.5) < 1e-6


def test_the_package_on_the_page_gives_the_same_numbers(folder):
    """It complies with the schema, too."""
    (structure,) = blocks("xml")
    assert complaints("SystemStructure.ssd", structure) == []
    with zipfile.ZipFile(folder / "Loop.ssp", "w") as package:
        package.writestr("SystemStructure.ssd", structure)
        for name in ("Mass.fmu", "Pid.fmu"):
            package.write(folder / name, f"resources/{name}")
    if not libpython():
        return
    assert cosim(folder, LD_PRELOAD=libpython()).returncode == 0
    (line,) = re.findall(r"`cosim (run --system Loop.ssp [^`]*)`", SECTION)
    command = [str(program("cosim")), *line.split(), "--csv", "package.csv"]
    done = subprocess.run(command, cwd=folder, env=os.environ | {"LD_PRELOAD": libpython()}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = [(folder / name).read_text().splitlines()[1:] for name in ("loop.csv", "package.csv")]
    assert rows[0] == rows[1] and len(rows[0]) == 1001


def test_without_python_inside_the_error_says_what_to_do(folder):
    done = cosim(folder, LD_PRELOAD="")
    assert done.returncode == 1
    assert "Pid.fmu" in done.stderr and "start it with LD_PRELOAD=" in done.stderr and "docs/master/cosim-tutorial.md" in done.stderr
