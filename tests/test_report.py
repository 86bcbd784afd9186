"""The report of `hdrm-fmu report`: in a headless browser without a network it shows its plots and the slider moves the arm.

Needs Chromium and ChromeDriver of the system (Debian: chromium, chromium-driver). Where there are none it is skipped, except with
REPORT_BROWSER=required in the environment, as in CI.
"""

import os
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select, WebDriverWait

from native import hdrm_fmu

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# A cut-off motion: 2 s of it are enough to see things move, and the runs stay short.
STOP_TIME = "6"


@pytest.fixture(scope="module")
def written(fmu_dir, tmp_path_factory):
    """Folder with report.html and figures/."""
    folder = tmp_path_factory.mktemp("report")
    subprocess.run(
        [hdrm_fmu(), "report", "--system", fmu_dir / "Manipulator.ssp", "--stop-time", STOP_TIME]
        + ["--out", folder / "report.html", "--figures", folder / "figures"],
        check=True,
    )
    return folder


@pytest.fixture(scope="module")
def browser(written):
    binary = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if not (binary and driver):
        missing = "no Chromium with ChromeDriver on this machine (Debian: apt-get install chromium chromium-driver)"
        if os.environ.get("REPORT_BROWSER") == "required":
            pytest.fail(missing)
        pytest.skip(missing)
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for flag in (
        "headless=new",
        "no-sandbox",
        "disable-dev-shm-usage",
        "use-angle=swiftshader",
        "enable-unsafe-swiftshader",
        "disable-background-networking",
        "disable-component-update",
        "disable-sync",
        "no-first-run",
        "window-size=1400,1000",
        # Nothing is reachable: the page must do without.
        "host-resolver-rules=MAP * ~NOTFOUND",
    ):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    chrome = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    chrome.set_script_timeout(60)
    chrome.get((written / "report.html").as_uri())
    WebDriverWait(chrome, 120).until(lambda b: b.execute_script("return document.readyState") == "complete")
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
    # Advice of Chromium on speed (software renderer, a canvas of plotly.js that is read back) is no error.
    advice = ("GPU stall", "willReadFrequently")
    noise = [e for e in browser.get_log("browser") if e["level"] != "INFO" and not any(a in e["message"] for a in advice)]
    assert noise == []


def test_plots_hold_curves(browser):
    plots = browser.execute_script(
        "return [...document.querySelectorAll('.js-plotly-plot')].map((p) => [p.id || p.className, p.data.map((t) => (t.x ?? []).length)])"
    )
    assert len(plots) >= 30
    assert [name for name, lengths in plots if not lengths or min(lengths) == 0] == []
    for trajectory in ("cubic", "triangular"):
        names = browser.execute_script(f"return document.getElementById('path-{trajectory}').data.map((t) => t.name)")
        assert names == ["PD", "modular", "adaptive", "desired"]


def test_paths_in_space_are_drawn(browser):
    browser.execute_script("document.getElementById('path-cubic').scrollIntoView()")
    drawn = "return document.querySelectorAll('#path-cubic canvas').length"
    WebDriverWait(browser, 30).until(lambda b: b.execute_script(drawn) > 0)


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
    before = picture(browser, "#scene")
    colours = len(np.unique(before.reshape(-1, 3), axis=0))
    assert colours > 200, "body, ground and shadow have many shades"
    assert (picture(browser, "#scene") == before).all(), "nothing moves without the slider"
    assert move(browser, 1.0) == float(STOP_TIME)
    moved = np.abs(picture(browser, "#scene") - before).max(axis=2) > 30
    assert 0.002 < moved.mean() < 0.5, "the arm moves, the ground does not"
    move(browser, 0.0)
    assert (picture(browser, "#scene") == before).all(), "and back"


def test_play_and_pause(browser):
    move(browser, 0.0)
    button = browser.find_element(By.ID, "play")
    button.click()
    WebDriverWait(browser, 30).until(lambda b: shown_time(b) > 0.3)
    button.click()
    stopped = shown_time(browser)
    time.sleep(0.5)
    assert shown_time(browser) == stopped


def test_another_run_can_be_chosen(browser):
    move(browser, 1.0)
    cubic = picture(browser, "#scene")
    select = Select(browser.find_element(By.ID, "animation-run"))
    select.select_by_visible_text("triangular, PD")
    assert (picture(browser, "#scene") != cubic).any()
    select.select_by_index(0)
    assert (picture(browser, "#scene") == cubic).all()


def test_size(written):
    assert (written / "report.html").stat().st_size < 15e6


def test_figures_are_written_as_png_and_svg(written):
    figures = sorted(f.name for f in (written / "figures").iterdir())
    kinds = ("actuators", "adaptation", "testbed_lift", "testbed_tilt", "tip_error", "tip_path")
    stems = [f"{kind}_{t}" for kind in kinds for t in ("cubic", "triangular")]
    expected = sorted(f"{s}.{e}" for s in [*stems, "robustness"] for e in ("png", "svg"))
    assert figures == expected
    for name in figures:
        content = (written / "figures" / name).read_bytes()
        assert content.startswith(b"\x89PNG" if name.endswith("png") else b"<svg")
        assert len(content) > 5000, name
