"""The Python of docs/studies/python.md is run as it stands there, each section from its beginning, in an empty folder."""

import os
import re
import subprocess
import sys

import pytest

from conftest import ROOT

PAGE = (ROOT / "docs/studies/python.md").read_text()
SECTIONS = {title: text for title, text in re.findall(r"^## ([^\n]*)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)}


def snippets(section):
    return re.findall(r"^```python\n(.*?)^```", SECTIONS[section], re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("section", ["A machine", "A script in the loop"])
def test_a_section_runs(section, tmp_path):
    given = "import hdrm_fmu\nfrom hdrm_fmu import *\n"
    (tmp_path / "section.py").write_text(given + "\n".join(snippets(section)))
    environment = {**os.environ, "PATH": os.path.dirname(sys.executable)}
    done = subprocess.run([sys.executable, "section.py"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
