"""What `hdrm-fmu` leaves to the programs beside it: they are started by the same words, and their exit codes are its own."""

import shutil
import subprocess

from native import call, hdrm_fmu


def test_options_and_errors_are_those_of_the_other_program(tmp_path):
    for words, option in [
        (["report"], "--bending"),
        (["plot"], "--signals"),
        (["machine", "draw"], "--dynamic-factor"),
        (["train"], "--epochs"),
        (["surrogate", "compare"], "--network"),
    ]:
        for asked in [[*words, "--help"], ["help", *words]]:
            done = call("hdrm-fmu", *asked)
            assert done.returncode == 0 and option in done.stdout, (asked, done.stderr)
    failed = call("hdrm-fmu", "plot", tmp_path / "absent.csv")
    assert failed.returncode == 1 and "absent.csv" in failed.stderr
    wrong = call("hdrm-fmu", "plot", "--no-such-option")
    assert wrong.returncode == 2 and "--no-such-option" in wrong.stderr


def test_a_program_that_is_not_there_is_named(tmp_path):
    alone = shutil.copy(hdrm_fmu(), tmp_path)
    for words, package in [(["plot", "run.csv"], "report"), (["train"], "surrogate")]:
        done = subprocess.run([alone, *words], capture_output=True, text=True)
        assert done.returncode == 1 and done.stdout == ""
        for part in [f"`hdrm-fmu-{package}`", str(tmp_path), f"cargo build --release --package {package}"]:
            assert part in done.stderr, done.stderr
