"""The report of `hdrm-fmu report`: in a headless browser without a network it shows its plots and the slider moves the arm.
"""

import base64
import json
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import chromium, noise, remarks, until
from fmpy_master import ROOT
from native import call, hdrm_fmu

# A cut-off motion: 2 s of it are enough to see things move, and the runs stay short.
STOP_TIME = "6"
TRAJECTORIES = ("cubic", "triangular")
MODES = ("adaptive", "modular", "pd")
RECORDED = ROOT / "docs/studies/recorded"


@pytest.fixture(scope="module")
def written(fmu_dir, tmp_path_factory):
    """Folder with report.html and figures/."""
    folder = tmp_path_factory.mktemp("report")
    subprocess.run(
        [hdrm_fmu(), "report", "--system", fmu_dir / "Manipulator.ssp", "--stop-time", STOP_TIME]
        + ["--out", folder / "report.html", "--figures", folder / "figures"]
        + [f"--{study}={RECORDED / study}.json" for study in ("tournament", "margins")],
        check=True,
    )
    return folder


@pytest.fixture(scope="module")
def browser(written):
    chrome = chromium()
    chrome.get((written / "report.html").as_uri())
    until(chrome, lambda: chrome.execute_script("return document.readyState") == "complete")
    loaded = chrome.execute_script("return performance.getEntriesByType('navigation')[0].loadEventEnd / 1000")
    print(f"report.html: {(written / 'report.html').stat().st_size / 1e6:.2f} MB, loaded in {loaded:.1f} s")
    drawn = chrome.execute_script("return document.querySelectorAll('.js-plotly-plot').length")
    assert drawn < 5, "plots are drawn when they are seen"
    chrome.execute_script("document.getElementById('robustness-figure').scrollIntoView()")
    until(chrome, lambda: chrome.execute_script("return document.querySelectorAll('#robustness-plot.js-plotly-plot').length"))
    chrome.execute_script("plotAll(); window.scrollTo(0, 0)")
    yield chrome
    chrome.quit()


def picture(browser, selector):
    """What a canvas shows, scaled down: rows of RGB."""
    values = browser.execute_script(
        """
        const small = document.createElement("canvas");
        [small.width, small.height] = [160, 90];
        const context = small.getContext("2d");
        context.drawImage(document.querySelector(arguments[0]), 0, 0, small.width, small.height);
        return Array.from(context.getImageData(0, 0, small.width, small.height).data);
        """,
        selector,
    )
    return np.array(values).reshape(90, 160, 4)[..., :3]


def move(browser, share):
    """Put the time slider at this share of the run, as dragging it does; the time shown, s."""
    browser.execute_script(
        """
        const slider = document.getElementById("time");
        slider.value = Number(slider.min) + arguments[0] * (slider.max - slider.min);
        slider.dispatchEvent(new Event("input"));
        """,
        share,
    )
    return shown_time(browser)


def shown_time(browser):
    return float(browser.find_element(By.ID, "clock").text.removesuffix(" s"))


def test_the_page_makes_no_noise_and_asks_for_nothing(browser):
    asked = browser.execute_script("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [a for a in asked if not a.startswith(("data:", "blob:"))] == []
    assert noise(browser) == []


def test_names_are_text_and_markup_in_them_runs_nothing(browser):
    """What files name is shown as it is; and if markup got in, neither its scripts nor its pictures would load."""
    hostile = "<img src=x onerror=\"document.title = 'run'\"><b>bold</b>"
    title, shown = browser.execute_script(
        """
        const name = arguments[0], before = document.title;
        const place = added("conditions", html`<p title="${name}">${[name, html`<i>${name}</i>`]}</p>`);
        const shown = [place.innerText, place.querySelector("p").title, place.querySelectorAll("img, b").length];
        place.innerHTML = name;
        return [before, shown];
        """,
        hostile,
    )
    assert shown == [2 * hostile, hostile, 0]
    time.sleep(0.5)
    assert browser.title == title
    refused = [entry["message"] for entry in browser.get_log("browser") if "Content Security Policy" in entry["message"]]
    assert any("img-src" in message for message in refused) and any("script-src" in message for message in refused), refused
    browser.execute_script("document.querySelector('#conditions > div:last-child').remove()")


def test_plots_hold_curves(browser):
    plots = browser.execute_script(
        "return [...document.querySelectorAll('.js-plotly-plot')].map((p) => [p.id || p.className, p.data.map((t) => (t.x ?? []).length)])"
    )
    assert len(plots) >= 30
    assert [name for name, lengths in plots if not lengths or min(lengths) == 0] == []
    for trajectory in TRAJECTORIES:
        names = browser.execute_script(f"return document.getElementById('path-{trajectory}').data.map((t) => t.name)")
        assert names == ["PD", "modular", "adaptive", "desired"]


def test_recorded_studies_are_shown(browser):
    """Laws tuned alike in the order of the file, and a mark for each margin."""
    laws = [row["law"] for row in json.loads((RECORDED / "tournament.json").read_text())["rows"]]
    shown = browser.execute_script("return [...document.querySelectorAll('#tournament-table tr td:first-child')].map((cell) => cell.textContent)")
    assert shown == [law.replace("_", " ") for law in laws]
    marks = browser.execute_script("return document.getElementById('margins-plot').data.flatMap((trace) => trace.x)")
    margins = json.loads((RECORDED / "margins.json").read_text())["margins"]
    assert sorted(marks) == sorted(margin["stable"] for margin in margins)


def test_a_file_of_another_study_is_refused(fmu_dir, tmp_path):
    files = ["--margins", RECORDED / "tournament.json", "--out", tmp_path / "report.html"]
    done = call("hdrm-fmu", "report", "--system", fmu_dir / "Manipulator.ssp", *files)
    assert done.returncode == 1 and "no list `margins` is in it" in done.stderr and not (tmp_path / "report.html").exists()


def test_paths_in_space_are_drawn(browser):
    browser.execute_script("document.getElementById('path-cubic').scrollIntoView()")
    drawn = "return document.querySelectorAll('#path-cubic canvas').length"
    until(browser, lambda: browser.execute_script(drawn) > 0)


@pytest.mark.parametrize("trajectory", TRAJECTORIES)
def test_the_whole_path_is_in_view(browser, trajectory):
    """All points lie between the ends of the axes, which have one scale, and the corners of their box project into the picture."""
    corners, ends, lengths, shown = browser.execute_script(
        """
        const plot = document.getElementById(`path-${arguments[0]}`);
        const { xaxis, yaxis, zaxis, aspectratio: ratio, camera } = plot._fullLayout.scene;
        const axes = [xaxis, yaxis, zaxis];
        const lengths = axes.map((a, k) => (a.range[1] - a.range[0]) / [ratio.x, ratio.y, ratio.z][k]);
        const ends = ["x", "y", "z"].map((n) => plot.data.flatMap((t) => [Math.min(...t[n]), Math.max(...t[n])]));
        const { eye, center } = camera;
        const minus = (a, b) => a.map((v, k) => v - b[k]), dot = (a, b) => a.reduce((s, v, k) => s + v * b[k], 0);
        const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        const unit = (a) => a.map((v) => v / Math.hypot(...a));
        const from = [eye.x, eye.y, eye.z], to = [center.x, center.y, center.z];
        const forward = unit(minus(to, from)), right = unit(cross(forward, [0, 0, 1])), up = cross(right, forward);
        const corners = [];
        for (const x of [-0.5, 0.5]) for (const y of [-0.5, 0.5]) for (const z of [-0.5, 0.5]) {
          const ray = minus([x * ratio.x, y * ratio.y, z * ratio.z], from);
          corners.push([dot(ray, right) / dot(ray, forward), dot(ray, up) / dot(ray, forward)]);
        }
        return [corners, ends, lengths, axes.map((a) => a.range)];
        """,
        trajectory,
    )
    for points, (low, high) in zip(ends, shown, strict=True):
        assert low < min(points) and max(points) < high
    assert np.ptp(lengths) < 1e-9 * max(lengths), "a metre is as long on each axis"
    # Plotly's camera sees 45 degrees of height, and more of width, as no picture here is higher than wide.
    assert np.abs(corners).max() < np.tan(np.radians(22.5))


@pytest.mark.parametrize("width", [1400, 800])
def test_no_text_covers_other_text(browser, width):
    """Title, legend and buttons of each plot lie apart, and the page is not wider than the window."""
    height = browser.get_window_size()["height"]
    browser.set_window_size(width, height)
    script = """
        const found = [];
        for (const plot of document.querySelectorAll(".js-plotly-plot")) {
          if (plot.hidden) continue;
          const boxes = [".gtitle", ".legend", ".modebar"].map((s) => [s, plot.querySelector(s)?.getBoundingClientRect()]).filter(([, b]) => b?.width);
          boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
            if (p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom) found.push(`${plot.id}: ${a} and ${b}`);
          }));
        }
        return [found, document.documentElement.scrollWidth <= window.innerWidth];
        """
    redrawn = """
        const plots = [...document.querySelectorAll(".js-plotly-plot")].filter((plot) => plot.offsetParent);
        return window.innerWidth <= arguments[0] && plots.every((plot) => Math.abs(plot._fullLayout.width - plot.clientWidth) < 2);
        """
    try:
        # Plotly redraws some time after a resize.
        until(browser, lambda: browser.execute_script(redrawn, width))
        assert browser.execute_script(script) == [[], True]
    finally:
        browser.set_window_size(1400, height)


def data(browser, expression):
    return browser.execute_script(f"return data.{expression}")


def samples(text):
    """The page's numbers: base64 of little-endian 32-bit floats."""
    return np.frombuffer(base64.b64decode(text), "<f4")


def test_the_page_says_what_its_numbers_are(browser):
    reading = browser.find_element(By.ID, "reading").text
    assert "Plant and controller share one model here" in reading
    assert "t = 4 s" in reading
    runs = [r for r in data(browser, "runs") if r["mode"] == "adaptive"]
    assert f"{1000 * max(r['whole_max'] for r in runs):.4f} mm" in reading
    assert f"{1000 * max(r['max'] for r in runs):.4f} mm" in reading


def test_other_errors_are_those_of_the_command(browser, fmu_dir, tmp_path):
    """Each study has a table of what `table --study` computes, and names its worst case."""
    file = tmp_path / "cells.json"
    subprocess.run(
        [hdrm_fmu(), "table", "--study", "payload", "--study", "tip-load", "--system", fmu_dir / "Manipulator.ssp"]
        + ["--stop-time", STOP_TIME, "--json", file],
        check=True,
    )
    found = json.loads(file.read_text())
    blocks = browser.find_elements(By.CSS_SELECTOR, "#studies .study")
    titles = [block.find_element(By.TAG_NAME, "h3").text for block in blocks]
    assert titles == ["Motor and transmission parameters", "Payload", "Sensor noise", "Unknown load on the tip"]
    rows = [len(block.find_elements(By.CSS_SELECTOR, "tr")) - 2 for block in blocks]
    assert rows == [16, 2, 3, 3]
    for name, block in (("payload", blocks[1]), ("tip-load", blocks[3])):
        cells = {(c["case"], c["trajectory"], c["mode"]): c for c in found[name]}
        for row in block.find_elements(By.CSS_SELECTOR, "tr")[2:]:
            case, *shown = [td.text for td in row.find_elements(By.TAG_NAME, "td")]
            expected = [cells[case, t, m] for t in TRAJECTORIES for m in MODES]
            assert shown == [f"{1000 * c['rmse_m']:.3f} ({1000 * c['max_m']:.3f})" for c in expected]
        worst = max((c for c in found[name] if c["mode"] == "adaptive"), key=lambda c: c["rmse_m"])
        sentence = f"Worst case of the adaptive controller: {worst['case']}, {worst['trajectory']}, RMSE {1000 * worst['rmse_m']:.3f} mm"
        assert sentence in block.find_element(By.TAG_NAME, "p").text


def test_stability_is_shown_as_tables_and_curves(browser):
    runs = data(browser, "stability.runs")
    names = [f"{t}, {law} law, {step} ms" for t in TRAJECTORIES for law in ("paper", "shipped") for step in ("1", "0.25")]
    for table in ("functions", "bound"):
        rows = browser.find_elements(By.CSS_SELECTOR, f"#stability-{table} tr")[2:]
        assert [row.find_element(By.TAG_NAME, "td").text for row in rows] == names
    for run, row in zip(runs, browser.find_elements(By.CSS_SELECTOR, "#stability-bound tr")[2:], strict=True):
        assert row.find_elements(By.TAG_NAME, "td")[1].text == f"{100 * run['exceeded']:.1f} %"
        # Independent of the table: a mean of the curve is that of the excess, a largest value is none but the curve's.
        curves = {name: samples(text) for name, text in run["curves"].items()}
        excess = curves["nu_dot"] + curves["dissipation"]
        assert np.allclose(excess, curves["bodies"] + curves["actuators"] + curves["cuts"], atol=1e-4)
        assert (excess <= curves["excess_max"] + 1e-4).all()
        assert curves["excess_max"].max() == pytest.approx(run["excess"]["max"], abs=1e-4)
        assert (curves["excess_max"] > 0).any() == (run["exceeded"] > 0)
    gains = [[td.text for td in row.find_elements(By.TAG_NAME, "td")] for row in browser.find_elements(By.CSS_SELECTOR, "#stability-gains tr")[1:]]
    assert [row[-1] for row in gains] == ["fails", "holds", "holds"]
    for row in gains:
        value, bound = (float(text.replace("−", "-")) for text in row[2:4])
        assert (value >= bound) == (row[-1] == "holds")
    select = Select(browser.find_element(By.ID, "stability-run"))
    before = browser.execute_script("return Array.from(document.getElementById('l-excess').data[0].y)")
    select.select_by_visible_text("triangular, paper law, 0.25 ms")
    assert browser.execute_script("return Array.from(document.getElementById('l-excess').data[0].y)") != before


def test_the_efficiency_map_is_that_of_the_actuator(browser, emla):
    """Points of both quadrants, computed here through FMPy; the system blends a fifth of the network in."""
    page = data(browser, "efficiency_map")
    loads, speeds = np.array(page["loads"]), np.array(page["speeds"])
    assert (speeds < 0).sum() == (speeds > 0).sum() > 10
    for i, j in ((10, 5), (20, len(speeds) - 8), (27, len(speeds) // 2)):
        instance = emla.running(F_hold=loads[i], x_dot=speeds[j], alpha=0.2)
        assert instance.get("efficiency_valid")
        for surface, name in (("physics", "efficiency_phys"), ("network", "efficiency_net"), ("hybrid", "efficiency")):
            shown = samples(page[surface]).reshape(len(loads), len(speeds))[i, j]
            assert shown == pytest.approx(instance.get(name), abs=1e-6), (surface, loads[i], speeds[j])
    assert browser.execute_script("return document.getElementById('map-hybrid').data[0].z.length") == len(loads)


def test_the_keyboard_reaches_all_controls(browser):
    controls = browser.find_elements(By.CSS_SELECTOR, "select, input, button, nav a, #machine, .scroll")
    assert len(controls) > 20
    assert [c.get_attribute("id") for c in controls if c.get_property("tabIndex") < 0] == []
    scene = browser.find_element(By.ID, "machine")
    before = picture(browser, "#machine")
    scene.send_keys(Keys.SHIFT, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    assert (picture(browser, "#machine") != before).any(), "the scene turns"
    view = Select(browser.find_element(By.ID, "animation-view"))
    view.select_by_value("side")
    view.select_by_value("whole")


def test_the_testbed_is_shown(browser):
    rows = browser.find_elements(By.CSS_SELECTOR, "#testbed-table tr")[1:]
    shown = [row.find_element(By.TAG_NAME, "td").text for row in rows]
    assert shown == ["lift, cubic", "tilt, cubic", "lift, triangular", "tilt, triangular"]
    assert browser.find_element(By.ID, "testbed").is_displayed()


def test_the_table_has_the_papers_column(browser):
    rows = browser.find_elements(By.CSS_SELECTOR, "#robustness-table tr")[1:]
    paper = [row.find_elements(By.TAG_NAME, "td")[-1].text for row in rows]
    # [paper] Table (tab:rmse_uncertainties), m to mm.
    assert paper == ["2.4", "1.9", "1.5", "2.9", "3.6", "4.2", "3.5", "2.9", "5.0", "6.0"]


def test_the_canvas_is_not_blank_and_the_slider_moves_the_arm(browser):
    assert move(browser, 0.0) == 0.0
    before = picture(browser, "#machine")
    colours = len(np.unique(before.reshape(-1, 3), axis=0))
    assert colours > 200, "body, ground and shadow have many shades"
    assert (picture(browser, "#machine") == before).all(), "nothing moves without the slider"
    assert move(browser, 1.0) == float(STOP_TIME)
    moved = np.abs(picture(browser, "#machine") - before).max(axis=2) > 30
    assert 0.002 < moved.mean() < 0.5, "the arm moves, the ground does not"
    move(browser, 0.0)
    assert (picture(browser, "#machine") == before).all(), "and back"


def test_play_and_pause(browser):
    move(browser, 0.0)
    button = browser.find_element(By.ID, "play")
    button.click()
    until(browser, lambda: shown_time(browser) > 0.3)
    button.click()
    stopped = shown_time(browser)
    time.sleep(0.5)
    assert shown_time(browser) == stopped


def test_another_run_can_be_chosen(browser):
    move(browser, 1.0)
    cubic = picture(browser, "#machine")
    select = Select(browser.find_element(By.ID, "animation-run"))
    select.select_by_visible_text("triangular, PD")
    assert (picture(browser, "#machine") != cubic).any()
    select.select_by_index(0)
    assert (picture(browser, "#machine") == cubic).all()


def test_size(written):
    """Of a run of 6 s; one of 24 s, of which most curves bend for 20 s, has 1.4 MB more."""
    assert (written / "report.html").stat().st_size < 4.5e6


def test_curves_are_those_of_the_runs(browser, written):
    """What is left out of a curve lies on the lines between what is kept: the largest error of the table is on the curve."""
    for run in data(browser, "runs"):
        whole = browser.execute_script(
            "const run = data.runs.find((r) => r.trajectory === arguments[0] && r.mode === arguments[1] && r.scale === arguments[2]);"
            "return [series(run, 'controller.tip_error_norm').y.length, Math.max(...series(run, 'controller.tip_error_norm').y)]",
            run["trajectory"],
            run["mode"],
            run["scale"],
        )
        assert whole[0] == round(float(STOP_TIME) / 0.004) + 1
        # The curve has every fourth point, to 1 %.
        assert 0.9 * run["whole_max"] < whole[1] < 1.011 * run["whole_max"]


def test_the_animation_begins_with_the_motion(browser):
    browser.execute_script("document.getElementById('animation-run').dispatchEvent(new Event('change'))")
    run = data(browser, "runs[0]")
    assert run["motion_start"] == 4 and float(browser.execute_script("return document.getElementById('clock').value").removesuffix(" s")) >= 4


def test_it_is_dark_where_that_is_wanted(browser):
    colour = "return getComputedStyle(document.querySelector(arguments[0])).backgroundColor.match(/\\d+/g).map(Number)"
    paper = "return document.getElementById('robustness-plot')._fullLayout.paper_bgcolor"
    day = browser.execute_script(paper)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
    try:
        browser.execute_script("document.getElementById('robustness-figure').scrollIntoView()")
        until(browser, lambda: browser.execute_script(paper) != day)
        for part in ("body", "#robustness", ".card", "select"):
            assert max(browser.execute_script(colour, part)) < 70, part
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": ""}]})
        browser.execute_script("plotAll()")


def test_axe_has_no_remark(browser):
    assert remarks(browser) == []


def test_it_fits_a_phone(browser):
    try:
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
        until(browser, lambda: browser.execute_script("return window.innerWidth") == 390)
        until(browser, lambda: browser.execute_script("return document.documentElement.scrollWidth") <= 390)
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_tiles_stand_beside_the_papers_and_after_the_caveat(browser):
    tiles = [tile.text for tile in browser.find_elements(By.CSS_SELECTOR, ".card")]
    assert all("here, simulated" in tile and "in the paper" in tile for tile in tiles)
    assert "1.5 mm" in tiles[0] and "2.9 mm" in tiles[1]
    order = "return document.getElementById('reading').compareDocumentPosition(document.getElementById('cards')) & Node.DOCUMENT_POSITION_FOLLOWING"
    assert browser.execute_script(order)


def test_figures_are_written_as_png_and_svg(written):
    figures = sorted(f.name for f in (written / "figures").iterdir())
    kinds = ("actuators", "adaptation", "stability", "testbed_lift", "testbed_tilt", "tip_error", "tip_path")
    stems = [f"{kind}_{t}" for kind in kinds for t in ("cubic", "triangular")]
    expected = sorted(f"{s}.{e}" for s in [*stems, "robustness"] for e in ("png", "svg"))
    assert figures == expected
    for name in figures:
        content = (written / "figures" / name).read_bytes()
        assert content.startswith(b"\x89PNG" if name.endswith("png") else b"<svg")
        assert len(content) > 5000, name
