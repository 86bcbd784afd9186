"""The page docs/machine/crane.md: what stands there is run as it stands there, in a folder with nothing but the crane's file and the live page."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fmpy_master import ROOT
from native import program

BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", (ROOT / "docs/machine/crane.md").read_text(), re.MULTILINE | re.DOTALL)
MADE = ["crane.svg", "load-chart.csv", "run.csv", "packed/Real_crane.ssp", "packed/fmi3/Hdrm_crane.fmu", "crane.xml", "crane.html"]


@pytest.fixture(scope="module")
def folder(fmu_dir, tmp_path_factory):
    folder = tmp_path_factory.mktemp("crane")
    ((_, crane), *_) = BLOCKS
    (folder / "crane.json").write_text(crane)
    shutil.copy(fmu_dir.parent / "web/machine.html", folder)
    return folder


def done(folder, fmu_dir, command):
    """What a command prints; it takes the programs of the build, and says how long it took."""
    paths = [str(Path(program("hdrm-fmu")).parent), str(Path(sys.executable).parent), os.environ["PATH"]]
    began = time.monotonic()
    ran = subprocess.run(command, cwd=folder, env=os.environ | {"PATH": os.pathsep.join(paths), "FMU_DIR": str(fmu_dir)}, capture_output=True, text=True)
    assert ran.returncode == 0, f"{command}: {ran.stdout}{ran.stderr}"
    print(f"{time.monotonic() - began:6.1f} s  {command[-1].splitlines()[0]}")
    return ran.stdout


def test_from_a_file_to_fmus_mujoco_and_the_page(folder, fmu_dir):
    said = ""
    for language, text in BLOCKS[1:]:
        if language == "python":
            said += done(folder, fmu_dir, [sys.executable, "-c", text])
        for command in text.splitlines() if language == "sh" else []:
            said += done(folder, fmu_dir, ["bash", "-c", command])
    assert [name for name in MADE if not (folder / name).is_file()] == []
    assert said.count("verdict: good") == 2 and "BAD" not in said


@pytest.mark.slow
def test_its_report(folder, fmu_dir):
    ((_, command),) = [block for block in BLOCKS if block[0] == "bash"]
    done(folder, fmu_dir, ["bash", "-c", command])
    assert "crane: an all-electric manipulator" in (folder / "report.html").read_text()
