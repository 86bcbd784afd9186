"""The page of anyone's FMU, made by `cargo fmu pack --target wasm` and `cargo fmu web` for the battery of `examples/`."""

import io
import math
import zipfile

import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

from browser import chromium, downloaded, drop, firefox, noise, run, shown, until
from conftest import FMU_DIR
from fmpy_master import ROOT
from native import cargo_fmu

BATTERY = ROOT / "examples/battery"
CURRENT = 80.0


@pytest.fixture(scope="module")
def battery(tmp_path_factory):
    """The FMU with WebAssembly, and its page: two commands."""
    folder = tmp_path_factory.mktemp("battery")
    packed = cargo_fmu("pack", "--profile", "release", "--target", "wasm", "--out", folder, cwd=BATTERY)
    assert packed.returncode == 0, packed.stderr
    fmu = folder / "fmi3/Battery.fmu"
    # The engine that `cargo xtask web --profile fmu-fast` has built, if it has; `cargo fmu web` builds its own.
    engine = FMU_DIR.parent / "wasm32-unknown-unknown/fmu-fast/cosim_page.wasm"
    made = cargo_fmu("web", fmu, "--out", folder / "battery.html", *(("--engine", engine) if engine.is_file() else ()))
    assert made.returncode == 0, made.stderr
    return fmu, folder / "battery.html"


@pytest.fixture(scope="module")
def chrome(battery):
    chrome = chromium()
    chrome.get(battery[1].as_uri())
    run(chrome, "await machine.ready")
    yield chrome
    chrome.quit()


@pytest.fixture
def page(chrome):
    yield chrome
    assert noise(chrome) == []


def field(page, name):
    return page.find_element(By.XPATH, f"//div[@class='row']/label[span[text()='{name}' or starts-with(text(), '{name}, ')]]/*[2]")


def put(page, name, value):
    page.execute_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", field(page, name), value)


def run_to(page, stop):
    """A run over earlier ones; the newest one's CSV as columns."""
    page.execute_script("document.getElementById('stop').value = arguments[0]", stop)
    page.execute_script("document.getElementById('csv').disabled = true; document.getElementById('run').click()")
    until(page, lambda: page.find_element(By.ID, "csv").is_enabled())
    lines = downloaded(page, "csv").strip().split("\n")
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    return {name.split(".")[-1]: [row[k] for row in rows] for k, name in enumerate(lines[0].split(","))}


def archive(**files):
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as to:
        for name, data in files.items():
            to.writestr(name.replace("__", "/").replace("_xml", ".xml"), data)
    return content.getvalue()


def test_it_shows_what_the_fmu_has(page):
    assert shown(page, "title") == "Battery"
    assert field(page, "i").get_attribute("type") == "number"
    # Nothing of it has two bounds, between which a slider could move.
    assert page.find_elements(By.CSS_SELECTOR, "#panel input[type=range]") == []
    page.execute_script("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    table = shown(page, "variables")
    for name in ("soc", "v", "T"):
        assert f"\nBattery.{name}\t" in table
        # One FMU by itself needs no name of its component.
        values = run(page, "return Promise.all(given[0].map((name) => machine.get(name)))", [f"Battery.{name}", name, f"fmu.{name}"])
        assert values[0] > 0 and len(set(values)) == 1
    document = page.find_element(By.CSS_SELECTOR, "#documentation iframe").get_attribute("srcdoc")
    assert document == (BATTERY / "documentation/index.html").read_text()


def test_a_run_follows_the_closed_form(page):
    """As `test_the_battery_follows_the_closed_form` has it for the library: a straight line and an exponential."""
    put(page, "i", CURRENT)
    found = run_to(page, 60)
    assert found["time"][-1] == pytest.approx(60)
    soc = 0.9 - CURRENT * 60 / (3600.0 * 50.0)
    v_1 = 0.8e-3 * CURRENT * -math.expm1(-60 / (0.8e-3 * 2.0e4))
    assert found["soc"][-1] == pytest.approx(soc, abs=1e-12)
    assert found["v"][-1] == pytest.approx(3.0 + 1.2 * soc - 1.5e-3 * CURRENT - v_1, abs=1e-10)
    assert shown(page, "verdict") == "no faults"
    assert "i=80" in page.execute_script("return location.hash")


def test_temperatures_are_shown_in_their_display_unit(page):
    """The model computes with kelvin and says `displayUnit="degC"`: t/°C = T/K − 273.15. Saved values stay in kelvin."""
    assert field(page, "T_ambient, degC").get_attribute("value") == "25"
    assert float(field(page, "T_ambient, degC").get_attribute("min")) == -272.15
    put(page, "T_ambient, degC", 40)
    assert "T_ambient=313.15" in page.execute_script("return location.hash")
    put(page, "i", 0)
    found = run_to(page, 60)
    assert 298.15 < found["T"][-1] < 313.15
    assert any(scope.text.startswith("T, degC") for scope in page.find_elements(By.CSS_SELECTOR, ".scope h3"))
    put(page, "T_ambient, degC", 25)


def test_inputs_follow_signals_and_files(page):
    """A step of the current, and one from a CSV file: the charge that has left is the integral of the current."""
    put(page, "i", 0)
    signal = page.find_element(By.CSS_SELECTOR, "#inputs .signal select")
    Select(signal).select_by_visible_text("step")
    for number, value in zip(page.find_elements(By.CSS_SELECTOR, "#inputs .signal input"), (CURRENT, 30)):
        page.execute_script("arguments[0].value = arguments[1]", number, value)
    found = run_to(page, 60)
    # The step takes effect at the first communication point that is not before 30 s.
    assert found["soc"][-1] == pytest.approx(0.9 - CURRENT * 30 / (3600.0 * 50.0), abs=2 * CURRENT / 3600 / 50)
    assert max(found["i"]) == CURRENT and min(found["i"]) == 0
    drop(page, "current.csv", b"time,i\n0,0\n20,40\n60,40\n")
    until(page, lambda: shown(page, "clock") == "60 s" and Select(signal).first_selected_option.text == "file")
    found = run_to(page, 60)
    # Held over each step of 1 s: 2 k for k from 0 to 19, then 40.
    assert found["soc"][-1] == pytest.approx(0.9 - (sum(range(0, 40, 2)) + 40 * 40) / (3600.0 * 50.0), abs=1e-9)
    drop(page, "other.csv", b"time,nothing\n0,1\n")
    until(page, lambda: "No column of other.csv" in shown(page, "message"))
    Select(signal).select_by_visible_text("constant")


def test_runs_lie_over_one_another(page):
    page.find_element(By.ID, "clear").click()
    for current in (10, 20):
        put(page, "i", current)
        run_to(page, 20)
    legends = [scope.text for scope in page.find_elements(By.CSS_SELECTOR, ".scope h3")]
    assert legends and all(legend.count("run ") == 2 for legend in legends)
    colors = page.execute_script("return [...document.querySelectorAll('.scope h3 span')].map((run) => run.style.getPropertyValue('--color'))")
    assert all(colors) and len(set(colors)) == 2


def test_files_that_cannot_run_are_refused_with_the_reason(page):
    """And the model that runs stays."""
    refused = {
        "broken.fmu": (b"this is no archive", "no ZIP archive"),
        "empty.fmu": (archive(readme="x"), "neither an FMU nor an SSP"),
        "native.fmu": (archive(modelDescription_xml="<x/>", **{"binaries__x86_64-linux__m.so": "x"}), "has no WebAssembly"),
        "two.fmu": (archive(modelDescription_xml='<fmiModelDescription fmiVersion="2.0"/>', **{"binaries__linux64__m.so": "x"}), "is of FMI 2.0"),
        "wrong.fmu": (archive(modelDescription_xml="<x/>", **{"binaries__wasm32-wasip2__m.wasm": "x"}), "fmiModelDescription"),
    }
    for name, (content, reason) in refused.items():
        drop(page, name, content)
        until(page, lambda: reason in shown(page, "message"))
    assert "x86_64-linux" not in shown(page, "message")
    assert shown(page, "title") == "Battery"
    put(page, "i", CURRENT)
    assert run_to(page, 10)["soc"][-1] < 0.9


def test_an_fmu_as_it_is_packed_runs_where_it_is_dropped(page, battery):
    page.execute_script("document.getElementById('verdict').textContent = ''")
    drop(page, "Battery.fmu", battery[0].read_bytes())
    until(page, lambda: shown(page, "verdict") == "no faults")
    assert shown(page, "message") == ""
    assert shown(page, "title") == "Battery"


def test_a_run_can_be_stopped(page):
    page.execute_script("document.getElementById('stop').value = 1e7; document.getElementById('run').click()")
    until(page, lambda: page.find_element(By.ID, "halt").is_enabled() and run(page, "return machine.time") > 0)
    page.find_element(By.ID, "halt").click()
    until(page, lambda: "Stopped at" in shown(page, "message"))
    at = run(page, "return machine.time")
    assert 0 < at < 1e7 and run(page, "return machine.time") == at
    assert not page.find_element(By.ID, "halt").is_enabled()


@pytest.mark.parametrize(
    "until_, step, words",
    [("0", "1", "must be after the start"), ("10", "0", "must be greater than 0 s"), ("1", "10", "is longer than the run"), ("10", "3", "no whole number of steps")],
)
def test_a_stop_time_and_a_step_that_do_not_fit_are_said(page, until_, step, words):
    before = page.execute_script("const [stop, step] = ['stop', 'step'].map((id) => document.getElementById(id)); const was = [stop.value, step.value]; [stop.value, step.value] = arguments; return was", until_, step)
    page.execute_script("document.getElementById('run').click()")
    until(page, lambda: words in shown(page, "message"))
    page.execute_script("[document.getElementById('stop').value, document.getElementById('step').value] = arguments[0]", before)


def test_runs_are_named_by_what_differed(page):
    page.find_element(By.ID, "clear").click()
    for current in (10, 20):
        put(page, "i", current)
        run_to(page, 20)
    legend = page.find_element(By.CSS_SELECTOR, ".scope h3").text
    assert ": i = 20" in legend


def test_rows_are_searched(page):
    page.execute_script("const find = document.getElementById('search'); find.value = 'T_amb'; find.dispatchEvent(new Event('input'))")
    shows = page.execute_script("return [...document.querySelectorAll('#inputs .row, #parameters .row')].filter((row) => !row.hidden).map((row) => row.innerText)")
    assert len(shows) == 1 and "T_ambient" in shows[0]
    page.execute_script("const find = document.getElementById('search'); find.value = ''; find.dispatchEvent(new Event('input'))")


def test_a_machines_rows_are_in_groups(chrome, tmp_path):
    """Hundreds of variables of the machine that the live page runs: a group for each component, an array as one row, and at first few plots."""
    system, machine = FMU_DIR.parent / "web/machine.ssp", tmp_path / "machine.html"
    engine = next(file for profile in ("fmu-fast", "fmu-release") if (file := FMU_DIR.parent / f"wasm32-unknown-unknown/{profile}/cosim_page.wasm").is_file())
    assert cargo_fmu("web", system, "--out", machine, "--engine", engine).returncode == 0
    address = chrome.current_url
    chrome.get(machine.as_uri())
    run(chrome, "await machine.ready")
    counts = chrome.execute_script(
        """return ["inputs", "parameters", "plotted"].map((id) => {
          const part = document.getElementById(id);
          return [[...part.querySelectorAll(".group > summary")].map(({ textContent }) => textContent.split(" ")[0]), part.querySelectorAll(".row, label > input[type=checkbox]").length];
        });"""
    )
    for groups, _ in counts[1:]:
        assert {"controller", "emla_1", "emla_2", "emla_3", "hdrm"} <= set(groups), groups
    assert "hdrm" in counts[0][0]
    folds = chrome.execute_script("return [...document.querySelectorAll('#parameters [data-array]')].map(({ dataset, open }) => [dataset.array, open])")
    assert [fold for fold in folds if fold[0].endswith("hdrm.zeta_start")] == [["hdrm.zeta_start", False]], "an array is one row"
    assert 0 < chrome.execute_script("return document.querySelectorAll('.scope').length") <= 6
    assert noise(chrome) == []
    chrome.get(address)
    run(chrome, "await machine.ready")


def test_the_address_holds_signals_and_the_stop_time(page, battery):
    """What an input does over time is in it; a step that it asks for comes in the run that it opens."""
    page.get("about:blank")
    page.get(battery[1].as_uri() + '#Battery.i=0&@until=60&@step=1&@signals=[["Battery.i","step",80,30]]')
    run(page, "await machine.ready")
    until(page, lambda: shown(page, "clock") == "60 s" and shown(page, "verdict") == "no faults")
    assert get_soc(page) == pytest.approx(0.9 - CURRENT * 30 / (3600.0 * 50.0), abs=2 * CURRENT / 3600 / 50)
    page.get("about:blank")
    page.get(battery[1].as_uri())
    run(page, "await machine.ready")


def test_it_runs_in_firefox(battery):
    driver = firefox()
    driver.get(battery[1].as_uri())
    run(driver, "await machine.ready")
    test_a_run_follows_the_closed_form(driver)
    assert noise(driver) == []
    driver.quit()


def get_soc(page):
    return run(page, "return machine.get('Battery.soc')")
