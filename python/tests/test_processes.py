"""FMUs that end the interpreter or change what is not theirs: the call is named, and Python's own handlers run too."""

import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "master/cosim/tests/fmus/hostile.c"
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="h" guid="1"><CoSimulation modelIdentifier="hostile"/><ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
</ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>"""
RUN = """
import os, sys, hdrm_fmu
with hdrm_fmu.System([sys.argv[1]], step=0.1) as system:
    for k in range(9):
        os.chdir(sys.argv[2 + k % 2])
        system.step()
        assert os.path.samefile(os.getcwd(), sys.argv[2 + k % 2]), os.getcwd()
print("done")
"""

pytestmark = pytest.mark.skipif(not sysconfig.get_platform().startswith("linux-x86_64"), reason="a C library for Linux")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile")
    library = folder / "hostile.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-w", "-o", library, SOURCE, "-lm", "-lpthread"], check=True)
    file = folder / "h.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/hostile.so")
    return file


def run(fmu, tmp_path, asked, *options):
    folders = [tmp_path / name for name in ("a", "b")]
    for folder in folders:
        folder.mkdir(exist_ok=True)
    command = [sys.executable, *options, "-c", RUN, str(fmu), *map(str, folders)]
    return subprocess.run(command, env={**os.environ, "HOSTILE": asked}, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        ("exit step", "fmi2DoStep at t = 0.3 s called exit"),
        ("segv step", "fmi2DoStep at t = 0.3 s crashed with a segmentation fault"),
        ("stack step", "fmi2DoStep at t = 0.3 s overflowed its stack"),
        ("abort instantiate", "fmi2Instantiate called abort"),
    ],
)
def test_what_ends_the_interpreter_is_named(fmu, tmp_path, asked, what):
    for options in ((), ("-X", "faulthandler")):
        done = run(fmu, tmp_path, asked, *options)
        assert done.returncode == 3, done.stderr
        assert what in done.stderr
        is_signal = not asked.startswith("exit")
        assert ("most recent call first" in done.stderr) == (bool(options) and is_signal), done.stderr


def test_a_script_may_change_its_folder_between_steps(fmu, tmp_path):
    assert run(fmu, tmp_path, "none none").stdout == "done\n"


def test_other_crashes_are_as_before(fmu, tmp_path):
    script = f"import ctypes, hdrm_fmu\nwith hdrm_fmu.System([{str(fmu)!r}], step=0.1) as s:\n s.step()\nctypes.string_at(8)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == -11, (done.returncode, done.stderr)
    assert "h:" not in done.stderr
