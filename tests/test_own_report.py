"""The report of a machine of one's own: it names the machine, has none of the paper's numbers, and shows the whole machine."""

import subprocess

import pytest

from browser import chromium, noise
from native import call, hdrm_fmu

# Every run of the report, some minutes.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def page(fmu_dir, tmp_path_factory):
    folder = tmp_path_factory.mktemp("own")
    machine = folder / "long.json"
    assert call("hdrm-fmu", "machine", "scale", "--booms", 2, "--output", machine).returncode == 0
    report = folder / "report.html"
    # Half a second of each run is enough for a page.
    command = ["report", "--system", fmu_dir / "Manipulator.ssp", "--machine", machine, "--set", "controller.settle_time=0.1", "--stop-time", "0.6", "--out", report]
    subprocess.run([hdrm_fmu(), *command], check=True)
    chrome = chromium()
    chrome.get(report.as_uri())
    yield chrome
    assert noise(chrome) == []
    chrome.quit()


def test_it_names_the_machine_and_drops_the_papers_numbers(page):
    assert page.title == "Co-simulation report: long"
    assert page.execute_script("return document.querySelector('h1').textContent") == "long: an all-electric manipulator"
    page.execute_script("plotAll()")
    shown = page.execute_script("return ['cards', 'tracking', 'robustness'].map((id) => document.getElementById(id).innerText.toLowerCase())")
    assert all(words not in part for part in shown for words in ("in the paper", "paper, adaptive", "paper, rmse", "paper's"))
    names = page.execute_script("return document.getElementById('robustness-plot').data.map(({ name }) => name)")
    assert set(names) == {"adaptive", "modular", "PD"}


def test_the_camera_sees_the_whole_machine(page):
    """All joints of a machine with booms twice as long lie inside the picture."""
    seen = page.execute_script(
        """
        const camera = document.getElementById("machine").drawing.camera;
        return document.getElementById("machine").drawing.groups.map((group) => group.position.clone().project(camera).toArray());
        """
    )
    assert all(abs(x) < 1 and abs(y) < 1 and z < 1 for x, y, z in seen)
