"""FMUs whose only binary is WebAssembly: `cosim` runs them by `cosim-wasm`, with the bits of their libraries, and ends those that trap, hang
or eat memory by name. `cargo xtask test --nightly` builds the program; elsewhere these tests are left out."""

import os
import shutil
import subprocess
import zipfile

import pytest

from conftest import FMU_DIR, NAMES, WORLD
from native import call, program
from test_wasm import WASM_DIR
from wasm_host import module_of

HOST = shutil.which(os.environ.get("COSIM_WASM", FMU_DIR.parent / "release/cosim-wasm"))
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(HOST is None, reason="`cosim-wasm` is not built: `cargo xtask cosim-wasm`"),
    pytest.mark.skipif(not (WASM_DIR / "Hdrm.fmu").is_file(), reason=f"no FMUs with WebAssembly in {WASM_DIR}"),
]
EXCHANGE = ["Emla", "Hdrm", "DcLink"]
#: Bodies of a function: it traps, never ends, or takes memory for ever.
TRAPS, HANGS, EATS = b"\0\0", b"\0\x03\x40\x0c\0\x0b\0", b"\0\x03\x40\x41\x80\x02\x40\0\x1a\x0c\0\x0b\0"


def cosim(*arguments, **options):
    environment = os.environ | {"COSIM_WASM": str(HOST)} | options.pop("env", {})
    return call("cosim", "run", *arguments, "--quiet", env=environment, **options)


def repacked(path, to, change=lambda component: component, keeps_library=False):
    """A copy of an FMU without its library, with a changed component."""
    with zipfile.ZipFile(path) as fmu, zipfile.ZipFile(to, "w") as new:
        for name in fmu.namelist():
            if name.endswith(".wasm"):
                new.writestr(name, change(fmu.read(name)))
            elif keeps_library or not name.startswith("binaries/"):
                new.writestr(name, fmu.read(name))
    return to


def table(to, *arguments):
    done = cosim(*arguments, "--step", "0.001", "--csv", to, "--signals", "*")
    assert done.returncode == 0, done.stderr
    return to.read_bytes(), done.stdout


@pytest.mark.parametrize(("name", "interface"), [*((name, "cs") for name in (*NAMES, *WORLD)), *((name, "me") for name in EXCHANGE)])
def test_an_fmu_alone(name, interface, tmp_path):
    only = repacked(WASM_DIR / f"{name}.fmu", tmp_path / f"{name}.fmu")
    options = ["--interface", interface, "--stop-time", "0.3"]
    expected, _ = table(tmp_path / "native.csv", WASM_DIR / f"{name}.fmu", *options)
    found, printed = table(tmp_path / "wasm.csv", only, *options)
    assert found == expected
    assert ("is integrated (Model Exchange" in printed) == (interface == "me")
    assert f"from WebAssembly, in a process of its own: {name}" in printed
    assert table(tmp_path / "both.csv", WASM_DIR / f"{name}.fmu", *options, "--prefer", "wasm")[0] == expected


@pytest.mark.parametrize("schedule", ["standard", "gauss-seidel"])
@pytest.mark.parametrize("interface", ["cs", "me"])
def test_the_coupled_machine(schedule, interface, tmp_path):
    """Five components in processes of their own, with the manipulator's and the actuators' states."""
    taken = {"controller": "Controller", "hdrm": "Hdrm", **{f"emla_{k}": "Emla" for k in (1, 2, 3)}}
    given = [word for name, fmu in taken.items() for word in ("--fmu", f"{name}={WASM_DIR / fmu}.fmu")]
    given += ["--system", FMU_DIR / "Manipulator.ssp", "--schedule", schedule, "--stop-time", "0.1", "--interface", f"emla_*={interface}"]
    expected, _ = table(tmp_path / "native.csv", *given)
    assert table(tmp_path / "wasm.csv", *given, "--prefer", "wasm")[0] == expected


def number(data, at):
    value = shift = 0
    while True:
        value, at = value | (data[at] & 0x7F) << shift, at + 1
        if data[at - 1] < 0x80:
            return value, at
        shift += 7


def with_body(component, export, body):
    """The component, with this body of the function that its module exports under this name."""
    module = module_of(component)
    sections, at = {}, 8
    while at < len(module):
        size, begin = number(module, at + 1)
        sections[module[at]], at = begin, begin + size
    count, at = number(module, sections[7])
    functions = {}
    for _ in range(count):
        size, at = number(module, at)
        name, kind = module[at : at + size].decode(), module[at + size]
        functions[name], at = number(module, at + size + 1)
    count, at = number(module, sections[2])
    imported = 0
    for _ in range(count):
        for _ in range(2):
            size, at = number(module, at)
            at += size
        imported += 1
        assert module[at] == 0, "imports functions only"
        _, at = number(module, at + 1)
    count, at = number(module, sections[10])
    for _ in range(functions[export] - imported):
        size, at = number(module, at)
        at += size
    size, at = number(module, at)
    changed = body + b"\x01" * (size - len(body) - 1) + b"\x0b"  # nop, end
    return component.replace(module, module[:at] + changed + module[at + size :])


@pytest.mark.parametrize(
    ("body", "options", "reason"),
    [
        (TRAPS, [], "wasm trap: wasm `unreachable` instruction executed"),
        (HANGS, ["--call-timeout", "1"], "fmi3DoStep at t = 0 s gave no answer within 1 s"),
        (EATS, ["--memory-limit", "200MB"], "memory"),
    ],
    ids=["traps", "hangs", "eats memory"],
)
def test_one_that_fails_is_named(body, options, reason, tmp_path):
    export = "fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.do-step"
    bad = repacked(WASM_DIR / "DcLink.fmu", tmp_path / "DcLink.fmu", lambda component: with_body(component, export, body))
    done = cosim(bad, "--step", "0.1", "--stop-time", "1", "--csv", tmp_path / "out.csv", *options, timeout=60)
    assert done.returncode == 1 and reason in done.stderr, done.stderr
    assert len((tmp_path / "out.csv").read_text().splitlines()) >= 2
    left = subprocess.run(["pgrep", "-f", str(bad)], capture_output=True, text=True).stdout
    assert left == ""


def test_what_is_missing_is_said(tmp_path):
    only = repacked(WASM_DIR / "DcLink.fmu", tmp_path / "DcLink.fmu")
    alone = tmp_path / "cosim"
    shutil.copy(program("cosim"), alone)
    words = [str(alone), "run", str(only), "--step", "0.1", "--stop-time", "1"]
    environment = {k: v for k, v in os.environ.items() if k != "COSIM_WASM"} | {"PATH": ""}
    done = subprocess.run(words, capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and "its WebAssembly is run by the program `cosim-wasm`" in done.stderr
    for content, reason in ((b"text", "magic"), (b"\0asm\x0d\0\x01\0", "no FMU of FMI-LS-WASM")):
        bad = repacked(only, tmp_path / "Bad.fmu", lambda _: content)
        done = cosim(bad, "--step", "0.1", "--stop-time", "1")
        assert done.returncode == 1 and reason in done.stderr, done.stderr
