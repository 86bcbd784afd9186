"""The file of C types that the kit is compared with is what a C compiler makes of the standard's headers, which FMPy brings."""

import importlib.util
import shutil
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "kit/fmu-export/tests/c_types/headers.py"


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler `cc`")
def test_the_committed_types_are_those_of_the_headers():
    spec = importlib.util.spec_from_file_location("headers", SCRIPT)
    headers = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(headers)
    assert headers.FILE.read_text() == headers.lines()
