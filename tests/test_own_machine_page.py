"""The live page of a machine of one's own: picture, limits, ratings, load chart and numbers are its, and it moves as natively.

The page is made from `target/web/machine.html` (`cargo xtask web`, or what MACHINE_PAGE names) by `hdrm-fmu machine scene --page`.
"""

import csv
import json
import math

import pytest

import native
from browser import chromium, noise, run, shown, until
from conftest import FMU_DIR
from fmpy_master import ROOT
from machine_page import PAGE, get, reopen, restart

MACHINE = "hiab_xs031"
# What differs from the shipped crane: another payload, another rating, another end of travel.
DEGREES = [-41, -6, -133, -180, -105, -180], [41, 77, -15, 180, -11, 180]
OWN = {
    "extends": MACHINE,
    "bodies": {"PL": {"mass": 240}},
    "ratings": {"lift": {"force_max": 91e3}},
    "limits": {"zeta_min_deg": DEGREES[0], "zeta_max_deg": DEGREES[1], "stroke_2": [0.01, 0.57]},
}
FILE_NAME = "forester.json"
GEOMETRY = json.loads((ROOT / f"parameters/{MACHINE}.json").read_text())["geometry"]


@pytest.fixture(scope="module")
def page(file):
    out = file.with_name("forester.html")
    made = native.call("hdrm-fmu", "machine", "scene", file, "--page", PAGE, "--out", out)
    assert made.returncode == 0, made.stderr
    chrome = chromium()
    chrome.get(out.as_uri())
    run(chrome, "await machine.ready")
    yield chrome
    assert noise(chrome) == []
    chrome.quit()


def length(*names):
    return math.hypot(*map(sum, zip(*(GEOMETRY[name] for name in names))))


def test_the_picture_has_the_lengths_of_the_file(page):
    """Distances between the joints as they are drawn, in a pose away from the start; the FMU's tip is where the drawn one is."""
    restart(page, trajectory="triangular", controller__settle_time=0.1)
    run(page, "await machine.advance(1.5)")
    until(page, lambda: shown(page, "clock") == "1.50 s")
    places = {name: run(page, "return machine.scene.bodyPlace(given[0]).position.toArray()", name) for name in ("T1", "A2", "C2", "A3", "C3", "A4", "C4", "D4")}
    tip = [get(page, f"hdrm.tip.position[{k}]") for k in (1, 2, 3)]
    drawn = {
        ("r_T1_O",): math.dist(places["T1"], places["A2"]),
        ("r_O_B",): math.dist(places["A2"], places["A3"]),
        ("r_B_B4", "r_B4_A4"): math.dist(places["A3"], places["A4"]),
        ("r_A4_C4",): math.dist(places["A4"], places["C4"]),
        ("r_C4_D4",): math.dist(places["C4"], places["D4"]),
        ("r_D4_T4",): math.dist(places["D4"], tip),
    }
    assert drawn == {names: pytest.approx(length(*names), abs=1e-6) for names in drawn}
    assert math.dist(places["A2"], places["C2"]) == pytest.approx(GEOMETRY["L2_2"], abs=1e-6), "the lift cylinder's foot"
    assert float(page.execute_script("return document.getElementById('stage').dataset.drawingError")) < 1e-9


def test_limits_ratings_and_payload_are_those_of_the_file(page):
    restart(page, trajectory="rates")
    ends = run(page, "return [...document.querySelectorAll('#joints input')].map(({ min, max }) => [Number(min), Number(max)])")
    assert ends == [pytest.approx([math.radians(a), math.radians(b)]) for a, b in zip(*DEGREES)]
    strokes, rated = run(page, "return [machine.monitor.machine.strokes, machine.monitor.machine.rated]")
    assert strokes[1:] == [[0.01, 0.57], [0, 0.59]] and rated == [12e3, 91e3, 60e3]
    run(page, "await machine.advance(0.1)")
    until(page, lambda: shown(page, "clock") == "0.10 s")
    bars = run(page, "return [...document.querySelectorAll('#readout meter')].map(({ value }) => value)")
    assert bars == [pytest.approx(abs(get(page, f"emla_{k}.F")) / force, abs=1e-9) for k, force in zip((1, 2, 3), rated)]
    assert get(page, "hdrm.payload.mass") == 240
    payload = "const row = [...document.querySelectorAll('#panel .row')].find((row) => row.firstChild.textContent === 'Payload');"
    assert run(page, payload + "const { value, max } = row.querySelector('input'); return [Number(value), Number(max)]") == [240, 480]


def test_the_page_names_the_machine(page):
    assert page.title == "Live machine: forester" and shown(page, "subject").startswith("The machine forester")
    assert page.execute_script("return document.querySelector('h1').textContent") == "Live manipulator: forester"
    assert "payload is 240 kg" in page.execute_script("return document.getElementById('size').textContent")


def test_the_load_chart_is_that_of_the_command(page, file):
    """Each corner of a curve lies between poses of `machine draw --csv`; its payload is between those of the nearest of them."""
    chart = file.with_name("chart.csv")
    assert native.call("hdrm-fmu", "machine", "draw", file, "--output", file.with_name("m.svg"), "--csv", chart).returncode == 0
    with chart.open() as lines:
        points = [[float(row[name]) for name in ("reach_m", "height_m", "payload_kg")] for row in csv.DictReader(lines) if row["payload_kg"]]
    curves = run(page, "return machine.monitor.machine.chart")
    assert len(curves) > 3
    for curve in curves:
        for reach, height, *_ in curve["pieces"][::10]:
            near = sorted(points, key=lambda point: math.dist(point[:2], (reach, height)))[:6]
            payloads = [payload for *_, payload in near]
            assert 0.97 * min(payloads) <= curve["payload"] <= 1.03 * max(payloads)


@pytest.mark.parametrize("world", ["ideal", "real"])
def test_it_moves_as_natively(page, file, world):
    """Bit for bit, on what a run takes with the machine in each world."""
    table, options = file.with_name(f"{world}.csv"), ["--system", FMU_DIR / {"ideal": "Manipulator.ssp", "real": "Real.ssp"}[world]]
    names = ["hdrm.zeta[2]", "emla_2.F", "controller.tip_error_norm"]
    ran = native.call(
        "hdrm-fmu", "run", "--machine", file, "--trajectory", "triangular", "--stop-time", 0.6, "--set", "controller.settle_time=0.1",
        "--csv", table, "--signals", ",".join(names), *options,
    )  # fmt: skip
    assert table.is_file(), ran.stderr
    with table.open() as lines:
        last = list(csv.DictReader(lines))[-1]
    restart(page, trajectory="triangular", world=world, controller__settle_time=0.1)
    run(page, "await machine.advance(0.6)")
    found = {name: get(page, name) for name in names}
    assert found == {name: float(next(value for head, value in last.items() if head.startswith(name))) for name in names}


def test_it_opens_moving_and_a_lever_takes_over(page):
    reopen(page, page.current_url.split("#")[0])
    start = get(page, "hdrm.zeta_start[1]")
    until(page, lambda: abs(get(page, "hdrm.zeta[1]") - start) > 1e-3)
    page.execute_script("const lift = document.querySelectorAll('#levers input')[1]; lift.value = 0.5; lift.dispatchEvent(new Event('input'))")
    until(page, lambda: "You lead now" in shown(page, "message"))
    until(page, lambda: get(page, "controller.rate.joint[2]") == pytest.approx(0.05))
    assert get(page, "controller.rate.joint[1]") == 0, "what the task was to do has ended"
