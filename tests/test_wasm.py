"""FMUs as WebAssembly: the plain module and the component of FMI-LS-WASM do what the library of Linux does, bit for bit."""

import base64
import gzip
import hashlib
import json
import os
import shutil
import struct
import subprocess
from ctypes import byref, c_double, c_size_t, c_void_p
from functools import cache
from pathlib import Path

import pytest
import wasmtime
from wasmtime import component as components

from browser import chromium, run
from conftest import FMU_DIR, NAMES, WORLD
from fmu import DISCARD, ERROR, FATAL, Refused
from native import cargo_fmu
from system import Parameter, System
from wasm_host import ENGINE, Component, FmuWasm, Lost, Plain, module_of

# Copies of the FMUs of FMI 3.0 with WebAssembly; `cargo xtask test` makes them.
WASM_DIR = Path(os.environ.get("WASM_DIR", FMU_DIR.parent / "wasm")).resolve()
ALL = (*NAMES, *WORLD)
STEPS, H = int(os.environ.get("WASM_STEPS", 10_000)), 1e-3
STEPS_SCRIPT = Path(__file__).with_name("wasm_steps.mjs")
BYTES = "return trace(Uint8Array.from(atob(given[0]), (letter) => letter.charCodeAt(0)), given[1])"
LARGEST = 700_000  # bytes of a module, compressed: 660 000 of those that are handed out, whose whole program is optimised at once; these are 6 % larger


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wasm")
    if not (WASM_DIR / "Hdrm.fmu").is_file():
        pytest.skip(f"no FMUs with WebAssembly in {WASM_DIR}; tests/README.md says how they are made")
    return {name: FmuWasm(WASM_DIR / f"{name}.fmu", folder / name) for name in ALL}


@pytest.fixture(params=ALL)
def fmu(request, fmus):
    return fmus[request.param]


def hosts(fmu):
    """An instance of the library, of the plain module and of the component."""
    return [fmu.instance(), Plain(fmu), Component(fmu)]


def reals(fmu, causality):
    return [name for name in fmu.names(causality) if fmu.access(name) == "Float64"]


def get_reals(instance, names):
    if isinstance(instance, Component):
        return instance.method("get-float64", [instance.reference(name) for name in names])
    n = sum(map(instance.fmu.length, names))
    data = (c_double * n)()
    instance.call("fmi3GetFloat64", instance.references(names), c_size_t(len(names)), data, c_size_t(n))
    return list(data)


def set_reals(instance, names, values):
    if isinstance(instance, Component):
        return instance.method("set-float64", [instance.reference(name) for name in names], values)
    data = (c_double * len(values))(*values)
    instance.call("fmi3SetFloat64", instance.references(names), c_size_t(len(names)), data, c_size_t(len(values)))


def derivative(instance, kind, unknowns, knowns, seed):
    if isinstance(instance, Component):
        return instance.derivative(kind, unknowns, knowns, seed)
    of = knowns if kind == "adjoint" else unknowns
    data, n = (c_double * sum(map(instance.fmu.length, of)))(), len(seed)
    lists = [x for names in (unknowns, knowns) for x in (instance.references(names), c_size_t(len(names)))]
    instance.call(f"fmi3Get{kind.title()}Derivative", *lists, (c_double * n)(*seed), c_size_t(n), data, c_size_t(len(data)))
    return list(data)


def bits(values):
    return struct.pack(f"<{len(values)}d", *values)


def outcome(call, *arguments):
    """What a call gives, or its status and message."""
    try:
        given = call(*arguments)
    except Refused as refused:
        return refused.status, refused.text
    return bits(given) if isinstance(given, list) else given


def around(fmu, name):
    """Start values of an input, and how far it is moved from them: little, so that it stays what the model is for, and within its bounds."""
    variable = fmu.variables[name]
    start = [float(v) for v in (variable.start or "0").split()]
    is_bounded = any(bound and float(bound) in start for bound in (variable.min, variable.max))
    return (start * fmu.length(name))[: fmu.length(name)], 0.0 if is_bounded else 1e-3 * float(variable.nominal or 1.0)


def moved(places, k):
    """Values of inputs at step k, of whole numbers, the same on every machine; each 97th time one is out of its bounds."""
    values = []
    for j, (start, scale) in enumerate(places):
        values += [s + scale * ((k * 7919 + (j + i) * 104729) % 2001 - 1000) / 1000 for i, s in enumerate(start)]
    if k % 97 == 96:
        values[k % len(values)] = float("nan")
    return values


def trace(instance, steps):
    """A hash of all outputs after each tenth step, before which the inputs were set, and what was not done."""
    fmu, lost = instance.fmu, []
    inputs, outputs = reals(fmu, "input"), reals(fmu, "output")
    digest, places = hashlib.sha256(), [around(fmu, name) for name in inputs]
    for k in range(steps):
        calls = [lambda: instance.step(k * H, H)]
        if k % 10 == 0:
            calls.insert(0, lambda: set_reals(instance, inputs, moved(places, k // 10)))
        for call in calls:
            if (failed := outcome(call)) is not None:
                lost.append((k, *failed))
        if k % 10 == 0:
            digest.update(bits(get_reals(instance, outputs)))
    return digest.hexdigest(), lost


def plan(fmu):
    """What `wasm_steps.mjs` is to do, as `trace` does it."""
    variable = lambda name: [fmu.variables[name].valueReference, fmu.length(name)]
    inputs = [dict(zip(("start", "scale"), around(fmu, name)), variable=variable(name)) for name in reals(fmu, "input")]
    return {
        "token": fmu.description.guid,
        "parameters": [[variable(name), value] for name, value in parameters(fmu).items()],
        "inputs": inputs,
        "outputs": [variable(name) for name in reals(fmu, "output")],
        "steps": STEPS,
        "h": H,
    }


@pytest.fixture
def in_node(tmp_path):
    def run(module, plan):
        script = f"""import {{ readFileSync }} from "node:fs"; import {{ trace }} from {json.dumps(STEPS_SCRIPT.as_uri())};
            console.log(JSON.stringify(await trace(readFileSync("module.wasm"), {json.dumps(plan)})));"""
        (tmp_path / "module.wasm").write_bytes(module)
        done = subprocess.run(["node", "--input-type=module", "-e", script], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    if shutil.which("node") is None:
        pytest.skip("there is no node")
    return run


@pytest.fixture(scope="module")
def in_browser(tmp_path_factory):
    page = tmp_path_factory.mktemp("page") / "page.html"
    page.write_text(f"<!doctype html><title>steps</title><script>{STEPS_SCRIPT.read_text().replace('export async', 'async')}</script>")
    chrome = chromium()
    chrome.get(page.as_uri())
    yield lambda module, plan: run(chrome, BYTES, base64.b64encode(module).decode(), plan)
    chrome.quit()


def parameters(fmu):
    """The network weighs fully, where there is one: its arithmetic is the same on every target."""
    return {"alpha": 1.0} if fmu.identifier == "Emla" else {}


def traced(fmu, instance):
    """Trace and state in the end."""
    for name, value in parameters(fmu).items():
        instance.set(name, value)
    instance.initialize()
    return trace(instance, STEPS), instance.serialize()


@cache
def of_library(fmu):
    (digest, lost), state = traced(fmu, fmu.instance())
    assert {status for _, status, _ in lost} == {DISCARD} and STEPS // 1000 <= len(lost) <= STEPS // 100, (len(lost), lost[:3])
    return (digest, lost), state


def test_steps_outputs_and_discards_are_those_of_the_library(fmu):
    for host in (Plain, Component):
        assert traced(fmu, host(fmu)) == of_library(fmu), host


@pytest.mark.parametrize("where", ["in_node", "in_browser"])
def test_steps_outputs_and_discards_in_node_and_a_browser(fmu, where, request):
    (digest, lost), _ = of_library(fmu)
    assert request.getfixturevalue(where)(module_of(fmu.bytes), plan(fmu)) == [digest, [[k, status] for k, status, _ in lost]]


def coupled(fmus, host):
    """A hash of all outputs of the five coupled FMUs, which exchange them before each step, while the tip moves; and the largest tip error, m."""
    system = System.read(FMU_DIR / "Manipulator.ssp", "standard.ssd")
    parts = {name: host(fmus[Path(file).stem]) for name, file in system.components.items()}
    inputs = {name: {n: around(part.fmu, n)[0] for n in reals(part.fmu, "input")} for name, part in parts.items()}
    outputs = {name: reals(part.fmu, "output") for name, part in parts.items()}
    element = {(name, e): (n, i) for name, part in parts.items() for n in inputs[name] for i, e in enumerate(part.fmu.elements(n))}
    system.parameters["controller"]["settle_time"] = Parameter(0.0, "Real", "s")
    for name, part in parts.items():
        for variable, parameter in system.parameters[name].items():
            if (name, variable) in element:
                n, i = element[name, variable]
                inputs[name][n][i] = parameter.value
            else:
                part.set(variable, parameter.value)
        set_reals(part, list(inputs[name]), sum(inputs[name].values(), []))
        part.initialize()
    digest, largest = hashlib.sha256(), 0.0
    for k in range(STEPS // 10):
        found = {}
        for name, part in parts.items():
            values = get_reals(part, outputs[name])
            digest.update(bits(values))
            found.update(zip(((name, e) for n in outputs[name] for e in part.fmu.elements(n)), values))
        largest = max(largest, found["controller", "tip_error_norm"])
        for link in system.links:
            n, i = element[link.target]
            inputs[link.target[0]][n][i] = found[link.source]
        for name, part in parts.items():
            set_reals(part, list(inputs[name]), sum(inputs[name].values(), []))
            part.step(k * H, H)
    return digest.hexdigest(), largest


def test_the_coupled_run_is_that_of_the_libraries(fmus):
    digest, largest = coupled(fmus, lambda fmu: fmu.instance())
    assert 0 < largest < 1e-3, "the machine follows"
    for host in (Plain, Component):
        assert coupled(fmus, host)[0] == digest, host


def test_states_are_saved_carried_and_reset(fmu):
    """The bytes of one open in the others, which go on from there with the same bits; reset brings back the beginning."""
    outputs, traces = reals(fmu, "output"), []
    native, plain, component = hosts(fmu)
    first = []
    for instance in (native, plain, component):
        instance.initialize()
        first.append(bits(get_reals(instance, outputs)))
        trace(instance, 20)
    data = native.serialize()
    saved = plain.save()
    trace_of = lambda instance: [bits(get_reals(instance, outputs)) for k in range(20, 25) if instance.step(k * H, H) is None]
    traces.append(trace_of(native))
    traces.append(trace_of(plain))
    plain.call("fmi3SetFMUState", saved)
    traces.append(trace_of(plain))
    component.step(20 * H, H)
    component.restore(data)
    traces.append(trace_of(component))
    assert all(found == traces[0] for found in traces)
    for instance in (native, plain):
        instance.call("fmi3Reset")
    component.method("reset")
    for instance in (native, plain, component):
        assert bits(get_reals(instance.initialize(), outputs)) == first[0]
    with pytest.raises(Refused) as refused:
        component.restore(data[:-1])
    assert refused.value.status == ERROR


@pytest.mark.parametrize("kind", ["directional", "adjoint"])
def test_derivatives_are_those_of_the_library(fmu, kind):
    inputs, outputs = reals(fmu, "input"), reals(fmu, "output")
    seeded = outputs if kind == "adjoint" else inputs
    seed = [0.5 + 0.25 * k for k in range(sum(map(fmu.length, seeded)))]
    found = []
    for instance in hosts(fmu):
        instance.initialize().step(0.0, H)
        found.append(outcome(derivative, instance, kind, outputs, inputs, seed))
    provided = f'provides{kind.title()}Derivatives="true"' in (fmu.folder / "modelDescription.xml").read_text()
    assert isinstance(found[0], bytes) == provided, found[0]
    assert found[1] == found[0] and found[2] == found[0]


def test_dependencies_are_those_of_the_library(fmu):
    native, _, component = [instance.initialize() for instance in hosts(fmu)]
    for name in reals(fmu, "output"):
        reference, n = native.references([name])[0], c_size_t()
        native.call("fmi3GetNumberOfVariableDependencies", reference, byref(n))
        assert component.method("get-number-of-variable-dependencies", reference) == n.value
        rows = component.method("get-variable-dependencies", reference)
        assert len(rows) == n.value
        for row in map(vars, rows):
            assert row["dependent-value-reference"] == reference and row["kind"] == "dependent"
            assert row["element-index-of-dependent"] < fmu.length(name)


def test_strings_and_messages(fmus):
    controller = fmus["Controller"]
    plain, component = Plain(controller), Component(controller)
    for instance in (controller.instance(), plain, component):
        with pytest.raises(Refused) as refused:
            instance.set("path_file", "way.json")
        assert refused.value.status == ERROR and "way.json" in refused.value.text
        instance.set("path_file", "iso9283-cube:1")
        assert [v.decode() if isinstance(v, bytes) else v for v in instance.get("path_file")] == ["iso9283-cube:1"]
    assert "no files but those that its host places" in plain.text and plain.text == component.text
    plain.place_file("way.json", "{")
    with pytest.raises(Refused) as refused:
        plain.set("path_file", "way.json")
    assert "no files" not in refused.value.text and "way.json" in refused.value.text
    wrong = "{00000000-0000-0000-0000-000000000000}"
    assert Plain(controller, token=wrong).c == 0
    refused = Component(controller, token=wrong)
    assert refused.this is None and f"instantiationToken = {wrong} must be" in refused.text


def test_event_mode_and_tuning(fmus):
    """What an importer does that handles events."""
    hdrm = fmus["Hdrm"]
    found = []
    for instance in (hdrm.instance(event_mode=True), Plain(hdrm, event_mode=True), Component(hdrm, event_mode=True)):
        own = isinstance(instance, Component)
        call = lambda name: instance.method(name) if own else instance.call("fmi3" + name.title().replace("-", ""))
        instance.initialize()
        call("enter-step-mode")
        for k in range(5):
            call("enter-event-mode")
            instance.set("tau_wrist", 1.0, -2.0, 0.5 * k)
            instance.update()
            call("enter-step-mode")
            instance.step(k * H, H)
        found.append(bits(get_reals(instance, reals(hdrm, "output"))))
    assert found[1] == found[0] and found[2] == found[0]


def test_a_step_is_looked_at_from_within(fmus):
    """Intermediate updates, of a variable that is asked for."""
    hdrm = fmus["Hdrm"]
    for kind in (Plain, Component):
        instance = kind(hdrm, required=["energy.kinetic"]).initialize()
        for k in range(3):
            instance.step(k * H, H)
        assert instance.updates == [(k * H + H, False, True, True, False) for k in range(3)]
        instance = kind(hdrm).initialize()
        instance.step(0.0, H)
        assert instance.updates == []


def test_a_component_imports_callbacks_alone_and_modules_are_small(fmu):
    component = components.Component(ENGINE, fmu.bytes)
    names = set(component.type.imports(ENGINE))
    own = {f"fmi:fmi3/{name}@3.0.0" for name in ("types", "callbacks", "intermediate-update-callbacks")}
    assert names == own
    assert set(component.type.exports(ENGINE)) == {f"fmi:fmi3/{name}@3.0.0" for name in ("common", "co-simulation", "model-exchange")}
    module = module_of(fmu.bytes)
    assert len(gzip.compress(module, 9)) <= LARGEST
    for text in (b"/root/", b"/home/", b"/work/"):
        assert text not in module.replace(b"/home/registry", b"")


def test_the_check_has_no_complaint(fmu):
    done = cargo_fmu("check", "--only", "FMI-LS-WASM", "--strict", fmu.path)
    assert done.returncode == 0 and "world `co-simulation-fmu`" in done.stdout, done.stdout
    done = cargo_fmu("check", "--only", "nothing but types", "--strict", fmu.path)
    assert done.returncode == 0 and " 0 failed" in done.stdout, done.stdout


@pytest.fixture(scope="module")
def lag(tmp_path_factory):
    """A new crate whose model panics at a certain input, packed with WebAssembly."""
    folder = tmp_path_factory.mktemp("new")
    assert cargo_fmu("new", "lag", cwd=folder).returncode == 0
    source = folder / "lag/src/lib.rs"
    text = source.read_text()
    line = "        dx.y = (u.u - self.y) / p.time_constant;\n"
    assert line in text
    source.write_text(text.replace(line, f'        assert!(u.u != 13.0, "thirteen is too much");\n{line}'))
    done = cargo_fmu("pack", "--profile", "release", "--target", "wasm", "--out", folder / "fmu", cwd=folder / "lag")
    assert done.returncode == 0, done.stderr
    return FmuWasm(folder / "fmu/fmi3/Lag.fmu", folder / "unpacked")


def test_a_new_model_packs_without_a_change_and_a_panic_is_a_trap(lag):
    """The host hears what happened, the instance of WebAssembly is lost, others live."""
    for kind in (Plain, Component):
        lost, other = [kind(lag, logging=False).initialize() for _ in range(2)]
        lost.set("u", 13.0)
        with pytest.raises(Lost, match="unreachable"):
            lost.step(0.0, H)
        status, category, text = lost.messages[-1]
        assert (status, category) == (FATAL, "logStatusError")
        assert "thirteen is too much" in text and "src/lib.rs" in text
        other.set("u", 1.0)
        other.step(0.0, H)
        assert 0.0 < other.get("y")[0] < 1e-2
    native = lag.instance().initialize()
    native.set("u", 13.0)
    with pytest.raises(Refused, match="thirteen is too much"):
        native.step(0.0, H)


@pytest.mark.parametrize("model, reason", [
    ("fmi3/Hdrm.fmu", "Hdrm.fmu: it has no WebAssembly (binaries/wasm32-wasip2/Hdrm.wasm)"),
    ("Hdrm.fmu", "Hdrm.fmu: it is of FMI 2.0, for which there is no WebAssembly: take the FMU of FMI 3.0 instead"),
    ("Manipulator.ssp", "Manipulator.ssp: resources/Controller.fmu: it has no WebAssembly (binaries/wasm32-wasip2/Controller.wasm)"),
])
def test_what_has_no_webassembly_gets_no_page(tmp_path, model, reason):
    """Of a package that FMU is named that cannot run in a page."""
    done = cargo_fmu("web", FMU_DIR / model, "--engine", "none.wasm", "--out", tmp_path / "page.html")
    assert done.returncode == 1 and reason in done.stderr, done.stderr
    assert not (tmp_path / "page.html").exists()
