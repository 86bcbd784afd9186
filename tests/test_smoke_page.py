"""The page docs/fmus/smoke-tests.md: what stands there is run as it stands there, in a folder like the one that it describes."""

import os
import re
import resource
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import yaml

from conftest import NAMES
from fmpy_master import ROOT
from native import program

BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", (ROOT / "docs/fmus/smoke-tests.md").read_text(), re.MULTILINE | re.DOTALL)


def blocks(language):
    return [text for found, text in BLOCKS if found == language]


def workflows():
    """Commands of each CI service's file."""
    github, gitlab = map(yaml.safe_load, blocks("yaml"))
    (job,) = github["jobs"].values()
    return [[step["run"] for step in job["steps"] if "run" in step], gitlab["fmus"]["script"]]


@pytest.fixture
def folder(fmu_dir, tmp_path):
    """Somebody's repository, with fmus/ and test_smoke.py."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for name in [*(f"{name}.fmu" for name in NAMES), "Manipulator.ssp"]:
        shutil.copy(fmu_dir / name, fmus)
    shutil.copy(program("cosim"), fmus)
    (test,) = blocks("python")
    (tmp_path / "test_smoke.py").write_text(test)
    return tmp_path


def shell(folder, commands):
    """Run commands as a CI service does; CPU time in s with the result."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(["bash", "-e", "-c", commands], cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize("commands", [*("\n".join(commands) for commands in workflows()), "".join(blocks("sh"))], ids=["github", "gitlab", "page"])
def test_the_commands_pass_within_ten_seconds(folder, commands):
    done, seconds = shell(folder, commands)
    assert done.returncode == 0, done.stdout + done.stderr
    print(f"{seconds:.1f} s of CPU time")
    assert seconds < 10.0


def test_a_bad_verdict_has_the_exit_code_of_the_page(folder):
    (command,) = blocks("bash")
    done, _ = shell(folder, command)
    assert f"exit code {done.returncode}" in command and "verdict: BAD" in done.stdout, done.stdout


def test_a_damaged_fmu_fails_them(folder):
    """A unit that no base unit is given for."""
    path = folder / "fmus/Hdrm.fmu"
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["modelDescription.xml"] = files["modelDescription.xml"].replace(b'unit="rad/s2"', b'unit="rad/s9"')
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    done, _ = shell(folder, "python -m pytest test_smoke.py")
    assert done.returncode == 1 and "1 failed" in done.stdout and "rad/s9" in done.stdout, done.stdout
