"""What pip says of the package's build before anything is compiled."""

import os
import subprocess
import sys

import pytest

from conftest import ROOT


def hook(call, path):
    return subprocess.run([sys.executable, "-c", f"import backend; backend.{call}"], cwd=ROOT / "python", env={**os.environ, "PATH": path}, capture_output=True, text=True)


@pytest.mark.parametrize("call", ["get_requires_for_build_wheel()", "get_requires_for_build_editable()", "build_wheel('.')"])
def test_without_cargo_one_sentence_says_what_to_install(tmp_path, call):
    done = hook(call, str(tmp_path))
    (line,) = done.stderr.splitlines()
    assert done.returncode == 1 and "no `cargo`" in line and "https://rustup.rs" in line and "wheel" in line


def test_how_long_it_takes_is_said_before_it_starts(tmp_path):
    """With a cargo that fails: nothing is compiled."""
    cargo = tmp_path / "cargo"
    cargo.write_text("#!/bin/sh\necho \"cargo was called: $*\" >&2; exit 1\n")
    cargo.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = hook("build_wheel('.')", path)
    assert done.returncode == 1 and "3 to 5 minutes on two cores" in done.stdout and "--profile pip --package xtask -- wheel --prepare --quick" in done.stderr
    done = hook("build_wheel('.', {'lto': 'yes'})", path)
    assert "about 10 minutes" in done.stdout and done.stderr.startswith("cargo was called: xtask wheel --prepare\n")
    done = hook("build_wheel('.', {'lto': 'perhaps'})", path)
    assert done.stdout == "" and done.stderr == "--config-settings lto=perhaps: must be yes or no.\n"
