"""The engine of the pages (`master/page-files`, `master/cosim-page`) in Node and in Chromium: the coupled run has the native one's
bits, saved states go on as they did, what is refused costs nothing, a trap is named, memory does not grow.

Engine, worker and system are those in `target/web/machine.html` (`cargo xtask web`), or in what MACHINE_PAGE names. With PAGE_BROWSER=webkit in
the environment the browser is WebKit: `xvfb-run python -m pytest`. PAGE_STEPS communication points of the coupled run are compared.
"""

import base64
import csv
import gzip
import hashlib
import json
import os
import re
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import wasmtime
from browser import chromium, noise, webkit
from conftest import FMU_DIR
from fmpy_master import ROOT
from native import call

PAGE = Path(os.environ.get("MACHINE_PAGE", FMU_DIR.parent / "web/machine.html")).resolve()
STEP = 1e-3
STEPS = int(os.environ.get("PAGE_STEPS", 10_000))
# Gathers the frames' history, of which each row comes once: rows of time and values, from the present communication point on.
ROWS = """
  async function rows(engine, names, seconds) {
    const parts = [];
    engine.onframe = ({ history }) => parts.push(history);
    await engine.watch(names);
    await engine.advance(seconds);
    const all = new Float64Array(parts.reduce((n, part) => n + part.length, 0));
    parts.reduce((at, part) => (all.set(part, at), at + part.length), 0);
    return all;
  }
  async function digest(values) {
    const hash = new Uint8Array(await crypto.subtle.digest("SHA-256", values.buffer));
    return [...hash].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  }
  const failure = (promise) => promise.then(() => null, (error) => error.message);
"""


def part(name):
    """What the page carries inside."""
    found = re.search(rf'<script type="([^"]*)" id="part-{name}">\n?(.*?)</script>', PAGE.read_text(), re.S)
    kind, text = found.groups()
    return gzip.decompress(base64.b64decode(text)) if "base64" in kind else text.encode()


def unpack(folder):
    """Engine, worker and system into a folder."""
    assert PAGE.is_file(), f"no page {PAGE}; run `cargo xtask web`"
    for name, file in (("engine", "engine.wasm"), ("worker", "worker.js"), ("system", "system.ssp")):
        (folder / file).write_bytes(part(name))


def opened(folder):
    """A page with them in a browser, which opens from the folder; whoever asks for it quits it."""
    page = folder / "page.html"
    engine = (ROOT / "master/page-files/page/engine.js").read_text().replace("export class", "class")
    inlined = "".join(
        f'<script type="text/plain" id="{name}">{base64.b64encode((folder / name).read_bytes()).decode()}</script>' for name in ("engine.wasm", "system.ssp")
    )
    worker = (folder / "worker.js").read_text()
    page.write_text(
        f"""<!doctype html><meta charset="utf-8"><title>engine</title>{inlined}<script type="text/plain" id="part-worker">{worker}</script>
        <script>{engine}
        const bytes = (id) => Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
        const archives = {{ "system.ssp": bytes("system.ssp") }};
        const open = (system) => Engine.open({{ engine: bytes("engine.wasm"), system }});
        </script>"""
    )
    chrome = webkit() if os.environ.get("PAGE_BROWSER") == "webkit" else chromium()
    chrome.get(page.as_uri())
    return chrome


def told(chrome, script):
    """What a script in the page returns."""
    text = f"const told = arguments[0]; (async () => {{ {ROWS} {script} }})().then((ok) => told([ok]), (error) => told([null, error.message]))"
    ok, *error = chrome.execute_async_script(text)
    assert not error and noise(chrome) == [], error
    return ok


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Engine, worker and archives."""
    folder = tmp_path_factory.mktemp("engine")
    unpack(folder)
    (folder / "broken.ssp").write_bytes(part("system")[:-5000])
    (folder / "text.ssp").write_bytes(b"no archive")
    with zipfile.ZipFile(BytesIO(part("system"))) as system:
        files = {name: system.read(name) for name in system.namelist()}
    own = b'source="resources/Hdrm.fmu" implementation="CoSimulation"'
    assert own in files["SystemStructure.ssd"]
    files["SystemStructure.ssd"] = files["SystemStructure.ssd"].replace(own, own.replace(b"CoSimulation", b"ModelExchange"))
    (folder / "exchange.ssp").write_bytes(archive(files))
    with zipfile.ZipFile(FMU_DIR / "fmi3/Hdrm.fmu") as fmu:
        (folder / "native.fmu").write_bytes(archive({"modelDescription.xml": fmu.read("modelDescription.xml")}))
    return folder


@pytest.fixture(scope="module")
def node(folder):
    def run(script):
        (folder / "script.js").write_text(ROWS + script)
        done = subprocess.run(["node", ROOT / "tests/page_engine.mjs", folder, folder / "script.js"], capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        return json.loads((folder / "told.json").read_text())

    return run


@pytest.fixture(scope="module")
def browser(folder):
    """The same in a page."""
    chrome = opened(folder)
    yield lambda script: told(chrome, script)
    chrome.quit()


@pytest.fixture(params=["node", "browser"])
def either(request):
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("system, structure, steps", [("Manipulator", "SystemStructure.ssd", STEPS), ("Real", "Real.ssd", 2_000)])
def test_the_run_in_the_page_is_the_native_one(either, fmu_dir, tmp_path, system, structure, steps):
    done = call("cosim", "run", "--quiet", "--system", fmu_dir / f"{system}.ssp", "--stop-time", steps * STEP, "--csv", tmp_path / "a.csv", "--signals", "*")
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "a.csv") as file:
        (_, *names), *rows = csv.reader(file)
    native = np.array(rows, dtype=float)
    assert native.shape == (steps + 1, len(names) + 1) and "controller.tip_error_norm" in names and len(names) > 200
    error = names.index("controller.tip_error_norm")
    seen = either(f"""
        const engine = await open(archives["system.ssp"]);
        await engine.restart({{ structure: "{structure}" }});
        const all = await rows(engine, {json.dumps(names)}, {steps * STEP});
        const width = {len(names) + 1};
        const errors = Array.from({{ length: all.length / width }}, (_, k) => all[k * width + {error + 1}]);
        const seen = {{ errors, digest: await digest(all), verdict: await engine.verdict(), end: engine.time }};
        await engine.close();
        return seen;
    """)
    assert seen["errors"] == native[:, error + 1].tolist() and max(seen["errors"]) > 0
    assert seen["digest"] == hashlib.sha256(native.tobytes()).hexdigest()
    assert seen["end"] == native[-1, 0] and not seen["verdict"]["bad"]


def test_model_exchange_in_the_page_is_the_native_one(node, fmu_dir, tmp_path):
    """The structure says that the manipulator is integrated; a saved state goes on as it did."""
    names, end = ["hdrm.zeta[2]", "hdrm.zeta_dot[3]", "hdrm.x[1]"], 0.5
    options = ["--interface", "hdrm=me", "--stop-time", end, "--csv", tmp_path / "a.csv", "--signals", ",".join(names)]
    done = call("cosim", "run", "--quiet", "--fmi", "3", "--system", fmu_dir / "Manipulator.ssp", *options)
    assert done.returncode == 0 and "hdrm is integrated" in done.stdout, done.stdout + done.stderr
    with open(tmp_path / "a.csv") as file:
        native = np.array(list(csv.reader(file))[1:], dtype=float)
    seen = node(f"""
        const engine = await open(archives["exchange.ssp"]);
        await engine.restart({{}});
        const first = await digest(await rows(engine, {json.dumps(names)}, {end}));
        const id = await engine.save();
        const both = [];
        for (let k = 0; k < 2; k += 1) {{
          await engine.restore(id);
          await engine.advance(0.1);
          both.push(await engine.get("hdrm.zeta[2]"));
        }}
        return {{ first, both }};
    """)
    assert seen["first"] == hashlib.sha256(native.tobytes()).hexdigest()
    assert seen["both"][0] == seen["both"][1]


@pytest.mark.parametrize("structure", ["SystemStructure.ssd", "Real.ssd"])
@pytest.mark.parametrize("schedule", ["standard", "gauss-seidel"])
def test_a_saved_state_goes_on_as_it_did(node, structure, schedule):
    seen = node(f"""
        const engine = await open(archives["system.ssp"]);
        await engine.restart({{ structure: "{structure}", schedule: "{schedule}", "hdrm.payload.mass": 200 }});
        await engine.advance(0.3);
        const names = (await engine.variables()).filter((v) => v.causality === "output" && v.type !== "String").map((v) => v.name);
        const id = await engine.save();
        const first = await digest(await rows(engine, names, 0.2));
        await engine.set("hdrm.wrench_env[1]", 5000);
        await engine.advance(0.001);
        const pushed = await digest(await rows(engine, names, 0.2));
        await engine.restore(id);
        const time = engine.time;
        const pushedNow = await engine.get("hdrm.wrench_env[1]");
        const again = await digest(await rows(engine, names, 0.2));
        await engine.forget(id);
        return {{ first, pushed, again, time, pushedNow, refused: await failure(engine.restore(id)) }};
    """)
    assert seen["first"] == seen["again"] != seen["pushed"]
    assert (seen["time"], seen["pushedNow"]) == (pytest.approx(0.3), 0)
    assert "no saved state" in seen["refused"]


def test_what_is_refused_says_why_and_the_run_goes_on(node):
    seen = node("""
        const engine = await open(archives["system.ssp"]);
        const early = await failure(engine.advance(1));
        await engine.restart({ "controller.mode": "pd", "hdrm.payload.mass": 123 });
        await engine.advance(0.05);
        const refused = {
          early,
          value: await failure(engine.restart({ "hdrm.payload.mass": -1 })),
          name: await failure(engine.restart({ "hdrm.payload.mas": 1 })),
          structure: await failure(engine.restart({ structure: "Nothing.ssd" })),
          schedule: await failure(engine.restart({ schedule: "soon" })),
          step: await failure(engine.restart({ step: 0 })),
          fixed: await failure(engine.set("hdrm.zeta_start[1]", 0.1)),
          driven: await failure(engine.set("hdrm.f[1]", 0)),
          output: await failure(engine.set("hdrm.x[1]", 0)),
          bound: await failure(engine.set("emla_1.alpha", 7)),
          watched: await failure(engine.watch(["hdrm.nothing"])),
        };
        const kept = [engine.time, await engine.get("hdrm.payload.mass"), await engine.get("controller.mode")];
        await engine.set("emla_1.alpha", 0.5);
        await engine.advance(0.05);
        const variable = (await engine.variables()).find((v) => v.name === "emla_1.T_ambient");
        return { refused, kept, alpha: await engine.get("emla_1.alpha"), time: engine.time, variable };
    """)
    expected = {
        "early": "nothing runs yet",
        "value": "hdrm",
        "name": "did you mean `hdrm.payload.mass`",
        "structure": "holds no Nothing.ssd",
        "schedule": "standard, jacobi, gauss-seidel",
        "step": "greater than 0 s",
        "fixed": "takes effect by a restart",
        "driven": "the connection from `emla_1.F`",
        "output": "is calculated by its FMU",
        "bound": "emla_1.alpha",
        "watched": "hdrm.nothing",
    }
    for case, words in expected.items():
        assert words in (seen["refused"][case] or "not refused"), (case, seen["refused"])
    assert seen["kept"] == [pytest.approx(0.05), 123, 3]
    assert (seen["alpha"], seen["time"]) == (0.5, pytest.approx(0.1))
    assert seen["variable"]["unit"] == "K" and seen["variable"]["causality"] == "input"


def test_a_pause_before_the_first_run_is_none(node):
    seen = node("""
        const engine = await open(archives["system.ssp"]);
        const frames = [];
        engine.onframe = (frame) => frames.push(frame);
        await engine.pause();
        const before = { frames: frames.length, time: String(engine.time) };
        await engine.restart();
        await engine.advance(0.01);
        return { before, time: engine.time };
    """)
    assert seen["before"] == {"frames": 0, "time": "NaN"} and seen["time"] == pytest.approx(0.01)


def test_broken_archives_get_a_message(node):
    seen = node("""
        const of = (name) => failure(open(archives[name]));
        const messages = { broken: await of("broken.ssp"), text: await of("text.ssp"), native: await of("native.fmu") };
        const engine = await open(archives["system.ssp"]);
        await engine.restart();
        await engine.advance(0.01);
        return { messages, time: engine.time };
    """)
    assert "not a ZIP archive" in seen["messages"]["broken"] and "not a ZIP archive" in seen["messages"]["text"]
    assert "it has no WebAssembly for a page" in seen["messages"]["native"]
    assert seen["time"] == pytest.approx(0.01)


FRAGILE = """(module (memory (export "memory") 1)
  (func (export "fmu_allocate") (param i32) (result i32) (i32.const 1024)) (func (export "fmu_free") (param i32 i32))
  (func (export "fmi3InstantiateCoSimulation") (param i32 i32 i32 i32 i32 i32 i32 i32 i32 i32 i32 i32) (result i32) (i32.const 1))
  (func (export "fmi3FreeInstance") (param i32))
  (func (export "fmi3EnterInitializationMode") (param i32 i32 f64 f64 i32 f64) (result i32) (i32.const 0))
  (func (export "fmi3ExitInitializationMode") (param i32) (result i32) (i32.const 0))
  (func (export "fmi3GetFloat64") (param i32 i32 i32 i32 i32) (result i32) (i32.const 0))
  (func (export "fmi3DoStep") (param i32 f64 f64 i32 i32 i32 i32 i32) (result i32)
    (if (f64.gt (local.get 1) (f64.const TRAP)) (then unreachable))
    (f64.store (local.get 7) (f64.add (local.get 1) (local.get 2))) (i32.const 0)))"""


def fragile():
    """A system of two FMUs, of which `brittle` traps in the step from 0.05 s."""

    def fmu(name, trap):
        description = f"""<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="t"><CoSimulation modelIdentifier="{name}"
          canHandleVariableCommunicationStepSize="true"/><ModelVariables><Float64 name="y" valueReference="1" causality="output"/></ModelVariables>
          <ModelStructure><Output valueReference="1" dependencies=""/></ModelStructure></fmiModelDescription>"""
        module = bytes(wasmtime.wat2wasm(FRAGILE.replace("TRAP", str(trap))))
        return archive({"modelDescription.xml": description, f"binaries/wasm32-unknown-unknown/{name}.wasm": module})

    components = "".join(f'<ssd:Component name="{n}" source="{n}.fmu"/>' for n in ("sound", "brittle"))
    structure = f"""<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="s">
      <ssd:System name="s"><ssd:Elements>{components}</ssd:Elements></ssd:System></ssd:SystemStructureDescription>"""
    return archive({"SystemStructure.ssd": structure, "sound.fmu": fmu("sound", 1e9), "brittle.fmu": fmu("brittle", 0.0495)})


def archive(files):
    packed = BytesIO()
    with zipfile.ZipFile(packed, "w") as to:
        for name, content in files.items():
            to.writestr(name, content)
    return packed.getvalue()


def test_a_trap_is_named_and_a_restart_works(either):
    encoded = base64.b64encode(fragile()).decode()
    seen = either(f"""
        const engine = await open(Uint8Array.from(atob("{encoded}"), (letter) => letter.charCodeAt(0)));
        await engine.restart({{ schedule: "standard" }});
        const first = await failure(engine.advance(1));
        const [time, again, verdict] = [engine.time, await failure(engine.advance(1)), await engine.verdict()];
        await engine.restart({{ schedule: "standard" }});
        const after = await failure(engine.advance(0.04));
        return {{ first, again, time, verdict, after, end: engine.time }};
    """)
    assert seen["first"].startswith("brittle: its WebAssembly failed in fmi3DoStep: ") and "at t = 0.05 s" in seen["first"]
    assert seen["again"] == seen["first"] and seen["verdict"]["bad"] and seen["time"] == pytest.approx(0.05)
    assert seen["after"] is None and seen["end"] == pytest.approx(0.04)


def test_memory_does_not_grow(node):
    seen = node("""
        const engine = await open(archives["system.ssp"]);
        await engine.restart();
        engine.onframe = () => {};
        await engine.watch(["controller.tip_error_norm", "hdrm.x[1]"]);
        const sizes = [];
        for (let round = 0; round < 4; round += 1) {
          for (let k = 0; k < 20; k += 1) {
            const id = await engine.save();
            await engine.set("hdrm.wrench_env[1]", k);
            await engine.advance(0.1);
            if (k % 2) await engine.restore(id);
            await engine.forget(id);
          }
          sizes.push(await engine.memory());
        }
        for (let k = 0; k < 3; k += 1) await engine.restart();
        return [...sizes, await engine.memory()];
    """)
    _, second, third, fourth, restarted = seen
    assert second == third == fourth and restarted <= 1.5 * fourth, seen


def test_play_keeps_pace_and_each_row_comes_once(either):
    seen = either("""
        const engine = await open(archives["system.ssp"]);
        await engine.restart();
        const times = [];
        let frames = 0;
        engine.onframe = ({ history }) => { frames += 1; for (let k = 0; k < history.length; k += 2) times.push(history[k]); };
        await engine.watch(["hdrm.x[1]"]);
        const begin = performance.now();
        await engine.play(0.5);
        while (engine.time < 0.2 || frames < 5) await new Promise((resolve) => setTimeout(resolve, 20));
        await engine.pause();
        const took = (performance.now() - begin) / 1000;
        const at = engine.time;
        await new Promise((resolve) => setTimeout(resolve, 100));
        const later = engine.time;
        return { times, frames, at, later, took };
    """)
    times = np.array(seen["times"])
    assert seen["at"] == seen["later"] and 0.2 <= seen["at"] <= 0.5 * seen["took"] + STEP
    assert np.array_equal(np.rint(times / STEP), np.arange(len(times)))
