"""`python -m hdrm_fmu fmus`, and docs/fmus/smoke-tests.md from the wheel alone: without Rust, without our programs."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import hdrm_fmu
from conftest import ROOT

PAGE = (ROOT / "docs/fmus/smoke-tests.md").read_text()


def block(language):
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return text


def python(folder, *words):
    """Runs this Python with nothing but its own folder on the search path."""
    environment = {**os.environ, "PATH": str(Path(sys.executable).parent)}
    return subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)


def test_the_files_are_written_and_not_overwritten(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there/Emla.fmu").write_text("mine")
    done = python(tmp_path, "-m", "hdrm_fmu", "fmus", "--out", "there")
    assert done.returncode == 1 and "Emla.fmu" in done.stderr and "--force" in done.stderr and "Traceback" not in done.stderr
    assert [path.name for path in (tmp_path / "there").iterdir()] == ["Emla.fmu"] and (tmp_path / "there/Emla.fmu").read_text() == "mine"
    done = python(tmp_path, "-m", "hdrm_fmu", "fmus", "--out", "there", "--force")
    names = {path.name for path in (*hdrm_fmu.fmus().values(), *hdrm_fmu.systems().values())}
    assert done.returncode == 0 and {Path(line).name for line in done.stdout.splitlines()} == names, done.stderr
    assert {path.name for path in (tmp_path / "there").iterdir()} == names >= {"Emla.fmu", "Hdrm.fmu", "Controller.fmu", "Manipulator.ssp"}
    assert all(zipfile.is_zipfile(tmp_path / "there" / name) for name in names)


def test_the_smoke_tests_need_no_rust(tmp_path):
    commands = block("shell").splitlines()
    (write,) = (line for line in commands if line.startswith("python -m hdrm_fmu"))
    done = python(tmp_path, *write.split()[1:])
    assert done.returncode == 0, done.stderr
    (tmp_path / "test_smoke.py").write_text(block("python"))
    (tmp_path / "test_coupled.py").write_text(block("py"))
    assert commands[-1] == "python -m pytest test_smoke.py test_coupled.py"
    done = python(tmp_path, *commands[-1].split()[1:])
    assert done.returncode == 0 and re.search(r"\d+ passed", done.stdout), done.stdout + done.stderr
