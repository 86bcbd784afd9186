"""The live machine's page in a headless browser without a network: it moves at once and as natively, obeys its settings and addresses, and goes back."""

import re

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

import native
from browser import downloaded, drop, noise, run, shown, until
from machine_page import PAGE, advance, get, opened, page, reopen, restart, slide  # noqa: F401 (fixtures)

MOST_BYTES = 6e6


def test_the_page_opens_from_a_folder_and_moves(opened):
    """Nobody has touched it. How long that takes is measured by `bench/page.py`."""
    run(opened, "await machine.ready")
    start = get(opened, "hdrm.zeta_start[1]")
    until(opened, lambda: abs(get(opened, "hdrm.zeta[1]") - start) > 1e-3)
    assert PAGE.stat().st_size <= MOST_BYTES
    assert noise(opened) == []
    asked = opened.execute_script("return performance.getEntriesByType('resource').map((e) => e.name)")
    assert [a for a in asked if not a.startswith(("data:", "blob:"))] == []
    assert opened.execute_script("return document.querySelectorAll('.scope').length") == 3


def test_the_tip_follows_as_natively(page):
    """The error on the cube is that of `hdrm-fmu run --trajectory cubic`: 0.0021 mm over the motion, here the largest of 2 s of it."""
    restart(page, trajectory="cubic", controller__settle_time=0.5)
    worst = 0.0
    for _ in range(20):
        advance(page, 0.1)
        worst = max(worst, get(page, "controller.tip_error_norm"))
    assert 1e-7 < worst < 2e-5


def test_a_slider_that_is_tunable_acts_at_once(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.2)
    before, at = get(page, "emla_2.F"), page.execute_script("return machine.time")
    slide(page, "Payload", 600)
    until(page, lambda: get(page, "hdrm.payload.mass") == 600)
    assert page.execute_script("return machine.time") == at, "without a restart"
    advance(page, 1.0)
    assert abs(get(page, "emla_2.F")) > abs(before) + 5000, "300 kg at 3 m outweigh 5 kN at the lift rod"


def test_a_slider_that_is_fixed_restarts_and_says_so(page):
    restart(page, trajectory="rates")
    advance(page, 0.2)
    slide(page, "All bodies heavier than planned", 40)
    until(page, lambda: page.execute_script("return machine.time") == 0)
    until(page, lambda: "started again" in shown(page, "message"))
    assert get(page, "hdrm.inertia_scale") == pytest.approx(1.4)
    assert "hdrm.inertia_scale=1.4" in page.execute_script("return location.hash")


def test_what_is_refused_changes_nothing(page):
    restart(page, trajectory="rates")
    advance(page, 0.3)
    with pytest.raises(RuntimeError, match="trajectory"):
        restart(page, trajectory="nowhere")
    with pytest.raises(RuntimeError, match="restart"):
        run(page, "await machine.set('hdrm.inertia_scale', 1.2)")
    assert page.execute_script("return machine.time") == pytest.approx(0.3)
    assert get(page, "controller.trajectory") == 4


def test_an_address_reproduces_a_run(page):
    """The address of a run, opened anew, gives the same numbers in every digit."""
    restart(page, trajectory="triangular", world="real", controller__settle_time=0.1, hdrm__payload__mass=250)
    address = page.current_url
    assert "world=real" in address
    advance(page, 0.5)
    names = ["hdrm.tip.position[1]", "hdrm.tip.position[2]", "emla_2.F", "controller.tip_error_norm"]
    first = [get(page, name) for name in names]
    reopen(page, address)
    run(page, "await machine.pause()")
    run(page, "document.getElementById('restart').click()")
    until(page, lambda: page.execute_script("return machine.time") == 0)
    advance(page, 0.5)
    assert [get(page, name) for name in names] == first


def test_undo_goes_back_ten_seconds(page):
    """And what follows is what followed before, bit for bit."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    for _ in range(13):
        advance(page, 1.0)
    end = get(page, "hdrm.zeta[2]")
    run(page, "await machine.set('hdrm.payload.mass', 500)")
    page.find_element(By.ID, "undo").click()
    until(page, lambda: page.execute_script("return machine.time") < 4)
    at = page.execute_script("return machine.time")
    assert at == pytest.approx(3.0, abs=0.51)
    assert get(page, "hdrm.payload.mass") == 300
    until(page, lambda: "Back" in shown(page, "message"))
    advance(page, 13.0 - at)
    assert get(page, "hdrm.zeta[2]") == end


def test_ghosts_run_beside_it(page):
    """Another law has another error on the same path and push; the ghost keeps its law."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts=pd" in page.execute_script("return location.hash"))
    advance(page, 1.5)

    machine, ghost = (get(page, "controller.tip_error_norm", *law) for law in ((), ("pd",)))
    assert ghost > 10 * machine > 0, (ghost, machine)
    until(page, lambda: re.search(r"tip error\s[\d.]\S* mm\s+pd\s[\d.]\S* mm", shown(page, "readout")))
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts" not in page.execute_script("return location.hash"))


def test_what_is_set_reaches_the_ghosts(page):
    """A ghost under the machine's own law answers as the machine does, in every digit."""
    restart(page, trajectory="rates", controller__settle_time=0, controller__mode="pd")
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts=pd" in page.execute_script("return location.hash"))
    names = ["hdrm.payload.mass", "hdrm.wrench_env[3]", "emla_2.F", "hdrm.zeta[1]", "controller.tip_error_norm"]
    advance(page, 0.2)
    before = [get(page, name, "pd") for name in names]
    assert before == [get(page, name) for name in names]
    slide(page, "Payload", 500)
    run(page, "await machine.set('hdrm.wrench_env[3]', 300)")
    until(page, lambda: get(page, "hdrm.payload.mass", "pd") == 500)
    advance(page, 0.3)
    after = [get(page, name, "pd") for name in names]
    assert after == [get(page, name) for name in names]
    assert all(a != b for a, b in zip(after, before)), (before, after)
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts" not in page.execute_script("return location.hash"))


@pytest.mark.parametrize("world, variable", [("real", "emla_1.compliance.mount"), ("electric", "dclink.battery.soc_start")])
def test_worlds(page, world, variable):
    restart(page, trajectory="rates")
    page.execute_script("document.getElementById('world').closest('details').open = true")
    Select(page.find_element(By.ID, "world")).select_by_value(world)
    until(page, lambda: "Started again" in shown(page, "message") and f"world={world}" in page.execute_script("return location.hash"))
    assert get(page, variable) > 0
    advance(page, 0.2)
    assert get(page, "controller.tip_error_norm") < 5e-3


def test_the_load_chart_is_that_of_the_command(page, tmp_path):
    """On each curve the payloads of `machine draw --csv`, linear between its poses, are the curve's. Points are rounded to 1 mm, over which
    the payload changes by at most 1.5 kg (1000 kg over 0.7 m)."""
    assert native.call("hdrm-fmu", "machine", "draw", "reference", "--output", tmp_path / "machine.svg", "--csv", tmp_path / "chart.csv").returncode == 0
    rows = np.genfromtxt(tmp_path / "chart.csv", delimiter=",", skip_header=1, usecols=(0, 1, 5))
    payload = LinearNDInterpolator(rows[:, :2], rows[:, 2])
    curves = page.execute_script("return JSON.parse(document.getElementById('scene').textContent).chart")
    assert len(curves) == 6
    for curve in curves:
        found = payload(np.array(curve["pieces"])[:, :2])
        assert len(found) > 20
        # The other triangles of the same poses bend the curve where the limit changes.
        assert np.nanmedian(abs(found - curve["payload"])) < 1.5 and np.nanmax(abs(found - curve["payload"])) < 0.05 * curve["payload"]
    assert page.execute_script("return machine.scene.curves.some(({ mesh }) => mesh.visible)") is False
    page.execute_script("document.getElementById('show-chart').click()")
    until(page, lambda: page.execute_script("return [...document.querySelectorAll('.payload:not([hidden])')].map((text) => text.textContent)")[:1] == ["300 kg"])
    assert page.execute_script("return machine.scene.curves.every(({ mesh }) => mesh.visible)")
    page.execute_script("document.getElementById('show-chart').click()")


def test_a_long_run_is_kept_in_little_memory(page):
    """Of 10⁶ s: newest stretches as fine as ever, older ones coarser, every peak kept, times in order. Moments to look back at are as many."""
    restart(page, trajectory="rates")
    kept = run(
        page,
        """const { monitor } = machine;
        const trace = [...monitor.scopes.values()][0].traces[0];
        for (let t = 1; t < 1e6; t += 1) trace.push(t, t === 77 ? 99 : 0);
        const { indices, high, stretch } = trace;
        const found = [indices.length, indices.every((at, k) => k === 0 || at > indices[k - 1]), Math.max(...high), indices.at(-1) * stretch];
        const history = new Float64Array(1 + monitor.names.length);
        for (let t = 1; t < 1e5; t += 1) { history[0] = t; monitor.frame({ history, values: history.slice(1) }); }
        const times = monitor.past.map(({ time }) => time);
        return [...found, times.length, times.every((at, k) => k === 0 || at > times[k - 1]), times.at(-1) - times.at(-2)];""",
    )
    restart(page, trajectory="rates")
    assert kept[0] <= 30_000 and kept[4] <= 12_000
    assert kept[1] and kept[5], "in order"
    assert kept[2] == 99 and kept[3] == pytest.approx(1e6, abs=1.1) and kept[6] == 1


def test_ghosts_that_are_ticked_at_once(page):
    """Four within one turn: all of them run, and what is shown is what runs."""
    restart(page, trajectory="rates")
    run(page, "machine.play()")
    page.execute_script("document.querySelectorAll('#ghosts input').forEach((box) => box.click())")
    until(page, lambda: "ghosts=adaptive%2Cmodular%2Cpd%2Cmodular_integral" in page.execute_script("return location.hash"))
    now = page.execute_script("return machine.time")
    until(page, lambda: page.execute_script("return machine.time") > now)
    assert get(page, "controller.mode", "pd") != get(page, "controller.mode", "modular")
    assert page.execute_script("return [...document.querySelectorAll('#ghosts input')].every((box) => box.checked)")
    page.execute_script("document.querySelectorAll('#ghosts input').forEach((box) => box.click())")
    until(page, lambda: "ghosts" not in page.execute_script("return location.hash"))
    run(page, "await machine.pause()")


CLICKER = """
  let seed = given[0];
  const draw = (n) => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32 * n) | 0;
  // What opens a dialogue of the browser or keeps a file stays out.
  const out = ["waypoint-file", "settings-file", "csv", "settings", "link", "picture", "full"];
  const restarts = "#world, #trajectory, #restart, #ghosts input, #first-minute li button, #explained button, .row:has(.restarts) *";
  document.querySelectorAll("details").forEach((part) => (part.open = true));
  const began = performance.now();
  const counts = {};
  for (let k = 0; k < given[1]; k += 1) {
    const all = [...document.querySelectorAll("button, select, input:not([hidden])")].filter((one) => !one.disabled && !out.includes(one.id) && !one.closest("[hidden]"));
    const one = all[draw(all.length)];
    counts[one.tagName] = (counts[one.tagName] ?? 0) + 1;
    // A run that starts takes long: one in thirty of them is enough.
    if (one.matches(restarts) && draw(30)) continue;
    if (draw(5) === 0) {
      const code = ["KeyA", "KeyW", "KeyE", "KeyP", "KeyL", "KeyO", "Space", "Period", "Backspace", "Escape"][draw(10)];
      for (const kind of ["keydown", "keyup"]) one.dispatchEvent(new KeyboardEvent(kind, { code, key: code.replace("Key", "").toLowerCase(), bubbles: true, cancelable: true }));
    } else if (one.tagName === "SELECT") {
      one.selectedIndex = draw(one.options.length);
      one.dispatchEvent(new Event("change", { bubbles: true }));
    } else if (one.type === "range") {
      one.value = Number(one.min) + draw(1000) / 1000 * (one.max - one.min);
      for (const kind of ["input", "change", "pointerup"]) one.dispatchEvent(new Event(kind, { bubbles: true }));
    } else one.click();
    if (k % 8 === 0) await new Promise((turn) => setTimeout(turn));
  }
  await machine.pause();
  return [counts, performance.now() - began];
"""


@pytest.fixture(scope="module")
def clicks():
    """How many random ones; in Firefox fewer."""
    return 2000


def test_any_order_of_clicks_ends_in_a_running_page(page, clicks):
    """Random ones: nothing is thrown, the panel shows what runs, and the machine still starts and moves."""
    restart(page, trajectory="rates")
    counts, took = run(page, CLICKER, 52, clicks)
    assert counts["BUTTON"] > clicks / 4 and counts["INPUT"] > 0.15 * clicks
    assert noise(page) == []
    ticked = page.execute_script("return [...document.querySelectorAll('#ghosts input:checked')].map((box) => box.value)")
    for law in ticked:
        assert get(page, "hdrm.zeta[1]", law) is not None
    if page.execute_script("return document.getElementById('play').textContent").startswith("❚"):
        run(page, "await machine.pause()")
    page.execute_script("document.querySelectorAll('#ghosts input:checked').forEach((box) => box.click())")
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    before = get(page, "hdrm.zeta[2]")
    run(page, "document.getElementById('play').click()")
    until(page, lambda: abs(get(page, "hdrm.zeta[2]") - before) > 1e-3)
    print(f"{clicks} clicks took {took / 1000:.1f} s")
    # Whatever is left of them (a click that sets waypoints, say) is not for the next test.
    reopen(page, PAGE.as_uri())


def test_an_address_holds_what_was_changed_while_it_ran(page):
    """A load that is picked up and a slider, each at its step: whoever opens the link gets the same numbers."""
    restart(page, trajectory="triangular", controller__settle_time=0.1)
    advance(page, 0.237)
    page.execute_script("document.getElementById('hang').click()")
    until(page, lambda: get(page, "hdrm.load.mass") == 150)
    advance(page, 0.1)
    slide(page, "Payload", 420)
    until(page, lambda: "420" in page.current_url)
    advance(page, 0.4)
    names = ["hdrm.tip.position[1]", "emla_2.F", "controller.tip_error_norm", "hdrm.load.mass", "hdrm.payload.mass"]
    first = [get(page, name) for name in names]
    address = page.current_url
    reopen(page, address)
    run(page, "await machine.pause()")
    page.execute_script("document.getElementById('restart').click()")
    until(page, lambda: page.execute_script("return machine.time") == 0)
    advance(page, 0.737)
    assert [get(page, name) for name in names] == first
    assert page.current_url == address


def test_a_link_is_copied_where_there_is_no_clipboard(page):
    """As over plain http."""
    run(page, "Object.defineProperty(navigator, 'clipboard', { value: undefined, configurable: true })")
    run(page, "window.copied = null; document.addEventListener('copy', () => { window.copied = document.activeElement.value; }, { once: true })")
    page.execute_script("document.getElementById('link').closest('details').open = true")
    page.find_element(By.ID, "link").click()
    until(page, lambda: "link is copied" in shown(page, "message"))
    assert page.execute_script("return window.copied").startswith("file:")


def test_a_bad_address_offers_the_usual_settings(page):
    try:
        page.get("about:blank")
        page.get(PAGE.as_uri() + "#trajectory=nowhere")
        until(page, lambda: "as this address asks" in shown(page, "broken"))
        page.find_element(By.XPATH, "//button[text()='Start with the usual settings']").click()
        until(page, lambda: page.execute_script("return machine.time > 0.1"))
        page.get("about:blank")
        page.get(PAGE.as_uri() + "#changes=nothing")
        until(page, lambda: "`changes` in it is no JSON" in shown(page, "broken"))
    finally:
        reopen(page, PAGE.as_uri())


def test_a_red_bar_ends_with_its_cause_and_can_be_closed(page):
    bar = page.find_element(By.ID, "broken")
    for closes in (False, True):
        restart(page, trajectory="rates", controller__settle_time=0)
        run(page, "await machine.set('hdrm.wrench_env[2]', -14000)")
        advance(page, 0.3)
        until(page, bar.is_displayed)
        if closes:
            page.execute_script("document.getElementById('broken-close').click()")
        else:
            run(page, "await machine.set('hdrm.wrench_env[2]', 0)")
            advance(page, 3.0)
        until(page, lambda: not bar.is_displayed())
    assert run(page, "return machine.verdict()")["bad"], "the run's checks remember it"


def test_a_gain_goes_back_to_its_usual_value_and_says_what_it_does(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    usual = get(page, "controller.Lambda_position")
    slide(page, "Stiffness of position", 10)
    until(page, lambda: get(page, "controller.Lambda_position") == 10)
    row = "const row = [...document.querySelectorAll('#panel .row')].find((row) => row.firstChild.textContent === 'Stiffness of position');"
    assert len(page.execute_script(row + "return row.firstChild.title")) > 20
    page.execute_script(row + "row.querySelector('button').click()")
    until(page, lambda: get(page, "controller.Lambda_position") == usual)


def test_words_are_those_of_a_cab(page):
    """What a visitor reads, not how the variables are called."""
    restart(page, world="real", trajectory="rates", controller__settle_time=0)
    words = page.execute_script("return document.body.textContent")
    for text in ("Controlled by", "Simulation checks", "× real time", "Compare with another controller", "Add play, friction, sensor errors", "Adaptation speed", "Sensor delay"):
        assert text in words
    until(page, lambda: shown(page, "verdict") == "no faults")
    levers = "return [...document.querySelectorAll('#levers .lever b span')].map((one) => one.textContent)"
    assert page.execute_script(levers) == ["Slew", "Lift", "Tilt", "Wrist roll", "Wrist bend", "Wrist turn"]
    sheets = "return [...document.querySelectorAll('#panel .row > span, #panel legend, #panel summary')].map((one) => one.textContent)"
    named = [text for text in page.execute_script(sheets) if "_" in text or "." in text]
    assert named == [], "names of variables"


def test_each_gain_says_what_it_does_and_can_be_reset(page):
    rows = page.execute_script(
        """return [...document.querySelectorAll("[data-sheet=law] > .row")].filter((row) => row.querySelector("input[type=range]")).map((row) =>
          [row.firstChild.textContent, row.firstChild.title, Boolean(row.querySelector("button.back"))]);"""
    )
    assert len(rows) >= 6
    for label, hint, has_reset in rows:
        assert len(hint) > 20 and has_reset, label


def test_the_first_line_says_what_the_page_is_with_links(page):
    """The paper by its address; parts, sources, licence and documentation one click away."""
    reopen(page, PAGE.as_uri())
    run(page, "await machine.pause()")
    about = page.find_element(By.CSS_SELECTOR, "#first-minute .about")
    assert about.is_displayed() and "manipulator" in about.text and "computed live" in about.text
    assert about.find_element(By.TAG_NAME, "a").get_attribute("href").startswith("https://arxiv.org/")
    what = page.find_element(By.ID, "what")
    page.find_element(By.ID, "about-link").click()
    until(page, lambda: what.get_property("open") and what.is_displayed())
    for text in ("Hdrm", "Emla", "Controller", "README.md", "docs/machine", "Licence"):
        assert text in what.text


def test_two_tasks_explain_the_machine(page):
    """Adaptation: after some seconds the machine errs less than the ghost that trusts the data sheet. Play: it is there, and its scopes are."""
    page.execute_script("document.getElementById('explain-adaptation').click()")
    until(page, lambda: "ghosts=modular" in page.current_url)
    advance(page, 6.0)
    worst = {"": 0.0, "modular": 0.0}
    for _ in range(10):
        advance(page, 0.2)
        for law in worst:
            worst[law] = max(worst[law], get(page, "controller.tip_error_norm", *([law] if law else [])))
    assert worst["modular"] > 3 * worst[""] > 0, worst
    titles = "return [...document.querySelectorAll('.scope h3')].map((title) => title.textContent)"
    assert any("Learnt masses" in title for title in page.execute_script(titles))
    page.execute_script("document.getElementById('explain-play').click()")
    until(page, lambda: "world=real" in page.current_url)
    assert get(page, "emla_2.backlash.width") == pytest.approx(2e-4)
    assert any("Rod speeds" in title for title in page.execute_script(titles))


def test_moments_and_settings_lead_back(page):
    """A kept moment, and the downloaded settings as a file: law, load and payload are as they were."""
    restart(page, trajectory="path", controller__path_file="iso9283-cube:1", controller__mode="pd_gravity", hdrm__payload__mass=220)
    advance(page, 0.1)
    page.execute_script("document.getElementById('save').click()")
    until(page, lambda: page.execute_script("return document.getElementById('moments').textContent"))
    kept = downloaded(page, "settings")
    advance(page, 0.3)
    page.execute_script("document.querySelector('#moments button').click()")
    until(page, lambda: page.execute_script("return machine.time") == pytest.approx(0.1))
    slide(page, "Payload", 400)
    until(page, lambda: get(page, "hdrm.payload.mass") == 400)
    drop(page, "machine.json", kept.encode())
    until(page, lambda: "Settings of the file" in shown(page, "message"))
    assert (get(page, "controller.mode"), get(page, "hdrm.payload.mass")) == (6, 220) and "iso9283-cube" in page.current_url


def test_recording(page):
    """Every communication point is in the CSV; after a step back it ends where the run is."""
    restart(page, trajectory="rates")
    page.execute_script("document.getElementById('record').click()")
    advance(page, 0.25)
    until(page, lambda: page.find_element(By.ID, "csv").is_enabled())
    lines = downloaded(page, "csv").strip().split("\n")
    assert lines[0].startswith("time,hdrm.zeta[1] [rad]") and "controller.tip_error_norm [m]" in lines[0] and "emla_2.F [N]" in lines[0]
    until(page, lambda: re.fullmatch(r"Download CSV \(0\.2\d* s\)", page.find_element(By.ID, "csv").get_property("textContent")))
    times = [float(line.split(",")[0]) for line in lines[1:]]
    assert times[-1] == pytest.approx(0.25) and len(times) >= 250
    assert all(b - a == pytest.approx(1e-3) for a, b in zip(times[-200:], times[-199:]))
    page.execute_script("document.getElementById('record').click()")


def test_the_verdict_and_the_end(page):
    """A machine that is asked too much is said to be lost."""
    restart(page, trajectory="rates", controller__settle_time=0)
    until(page, lambda: shown(page, "verdict") == "no faults")
    run(page, "await machine.set('hdrm.wrench_env[2]', -60000)")
    advance(page, 0.4)
    until(page, lambda: page.find_element(By.ID, "broken").is_displayed())
    assert any(word in shown(page, "broken") for word in ("broken", "lost", "Overloaded"))
