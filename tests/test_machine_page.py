"""The live machine's page in a headless browser without a network: it moves at once, obeys levers, sliders, keys and addresses, and goes back.

The page is `target/web/machine.html` (`cargo xtask web`), or what MACHINE_PAGE names.
"""

import json
import math
import os
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial.transform import Rotation
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

import native
from browser import chromium, downloaded, drop, noise, pictured, remarks, run, shown, until
from conftest import FMU_DIR

PAGE = Path(os.environ.get("MACHINE_PAGE", FMU_DIR.parent / "web/machine.html")).resolve()
MOST_BYTES = 6e6


@pytest.fixture(scope="module")
def opened():
    """The browser, with the page as it opens."""
    assert PAGE.is_file(), f"no page {PAGE}; run `cargo xtask web`"
    chrome = chromium()
    chrome.get(PAGE.as_uri())
    yield chrome
    chrome.quit()


@pytest.fixture
def page(opened):
    """The page, paused, with no message from before."""
    run(opened, "await machine.ready; await machine.pause(); document.getElementById('message').textContent = ''")
    yield opened
    assert noise(opened) == []


def get(chrome, name, *ghost):
    return run(chrome, "return machine.get(...given)", name, *ghost)


def restart(chrome, **settings):
    """Paused at the start of a run with these settings; `__` stands for a dot."""
    run(chrome, "await machine.pause(); await machine.restart(given[0])", {k.replace("__", "."): v for k, v in settings.items()})


def reopen(chrome, address):
    chrome.get("about:blank")
    chrome.get(address)
    run(chrome, "await machine.ready")


def advance(chrome, seconds):
    run(chrome, "await machine.advance(given[0])", seconds)


def slide(chrome, label, value):
    """Moves a slider of the panel and lets it go."""
    chrome.execute_script(
        """
        const row = [...document.querySelectorAll("#panel .row")].find((row) => row.firstChild.textContent === arguments[0]);
        row.closest("details").open = true;
        const field = row.querySelector("input");
        field.value = arguments[1];
        field.dispatchEvent(new Event("input"));
        field.dispatchEvent(new Event("change"));
        """,
        label,
        value,
    )


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


def test_the_machine_is_drawn_where_the_fmu_has_it(page):
    """The page solves the closed loops itself: its tip and its strokes are those of the FMU to rounding, also away from the start."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    advance(page, 2.0)
    until(page, lambda: shown(page, "clock") == "2.00 s")
    assert float(page.find_element(By.ID, "stage").get_attribute("data-drawing-error")) < 1e-9
    # Once nothing moves the picture has all the points of the screen, whatever it had before.
    until(page, lambda: page.execute_script("const { width, clientWidth } = document.getElementById('machine'); return width === clientWidth"))


def test_the_tip_follows_as_natively(page):
    """The error on the cube is that of `hdrm-fmu run --trajectory cubic`: 0.0021 mm over the motion, here the largest of 2 s of it."""
    restart(page, trajectory="cubic", controller__settle_time=0.5)
    worst = 0.0
    for _ in range(20):
        advance(page, 0.1)
        worst = max(worst, get(page, "controller.tip_error_norm"))
    assert 1e-7 < worst < 2e-5


def test_levers_on_the_screen_and_keys_move_the_joints(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    run(page, "machine.play()")
    before = get(page, "hdrm.zeta[2]")
    body = page.find_element(By.TAG_NAME, "body")
    ActionChains(page).key_down("w", body).perform()
    until(page, lambda: get(page, "hdrm.zeta[2]") > before + 0.01)
    ActionChains(page).key_up("w", body).perform()
    until(page, lambda: get(page, "controller.rate.joint[2]") == 0)
    slew = page.find_element(By.CSS_SELECTOR, "#levers input")
    before = get(page, "hdrm.zeta[1]")
    ActionChains(page).click_and_hold(slew).move_by_offset(40, 0).perform()
    until(page, lambda: get(page, "hdrm.zeta[1]") < before - 0.01)  # to the right
    ActionChains(page).release().perform()
    until(page, lambda: get(page, "controller.rate.joint[1]") == 0)
    assert slew.get_property("value") == "0", "it springs back"
    assert page.execute_script("return document.activeElement === document.body"), "keys lead again"


def test_a_lever_takes_over_from_a_path_where_the_machine_stands(page):
    restart(page, trajectory="path", controller__path_file="six-joints", controller__settle_time=0.1)
    advance(page, 1.5)
    joints = range(1, 7)
    stands, began = ([get(page, f"hdrm.{name}[{k}]") for k in joints] for name in ("zeta", "zeta_start"))
    body = page.find_element(By.TAG_NAME, "body")
    ActionChains(page).key_down("s", body).perform()
    until(page, lambda: "You lead now" in shown(page, "message"))
    ActionChains(page).key_up("s", body).perform()
    assert page.find_element(By.ID, "trajectory").get_property("value") == "rates joint"
    assert [get(page, f"hdrm.zeta_start[{k}]") for k in joints] == stands
    assert all(abs(now - then) > 1e-3 for now, then in zip(stands, began)), "all six joints had moved"


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


def test_a_push_and_a_load_reach_the_machine(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.2)
    page.find_element(By.ID, "push").click()
    until(page, lambda: sum(get(page, f"hdrm.wrench_env[{k}]") ** 2 for k in (1, 2, 3)) > 299**2)
    before = get(page, "controller.tip_error_norm")
    advance(page, 0.1)
    assert get(page, "controller.tip_error_norm") > before + 1e-5
    advance(page, 0.3)
    until(page, lambda: get(page, "hdrm.wrench_env[3]") == 0)
    page.find_element(By.ID, "hang").click()
    until(page, lambda: get(page, "hdrm.load.mass") == 150)
    page.find_element(By.ID, "hang").click()
    until(page, lambda: get(page, "hdrm.load.mass") == 0)


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


def test_ghosts_are_where_the_machine_is(page):
    """In time: however long it takes to advance and to go back, a ghost under the machine's own law is the machine, in every digit."""
    restart(page, trajectory="cubic", controller__settle_time=0.1, controller__mode="pd")
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts=pd" in page.execute_script("return location.hash"))
    both = lambda: (page.execute_script("return machine.time"), *[get(page, "hdrm.zeta[2]", *law) for law in ((), ("pd",))])
    found = []
    for seconds in (0.2, 3.0, 6.0, 5.0):
        advance(page, seconds)
        found.append(both())
    page.find_element(By.ID, "undo").click()
    until(page, lambda: "Back" in shown(page, "message"))
    found.append(both())
    advance(page, 1.0)
    found.append(both())
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts" not in page.execute_script("return location.hash"))
    assert all(machine == ghost for _, machine, ghost in found), found
    assert [time for time, *_ in found[:4]] == pytest.approx([0.2, 3.2, 9.2, 14.2], abs=1e-9)


@pytest.mark.parametrize("world, variable", [("real", "emla_1.compliance.mount"), ("electric", "dclink.battery.soc_start")])
def test_worlds(page, world, variable):
    restart(page, trajectory="rates")
    page.execute_script("document.getElementById('world').closest('details').open = true")
    Select(page.find_element(By.ID, "world")).select_by_value(world)
    until(page, lambda: "Started again" in shown(page, "message") and f"world={world}" in page.execute_script("return location.hash"))
    assert get(page, variable) > 0
    advance(page, 0.2)
    assert get(page, "controller.tip_error_norm") < 5e-3


def test_waypoints_of_a_file(page):
    """A file that is dropped becomes the path, from where the machine stands; a wrong one is refused with the reason."""
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.1)
    points = [{"position": [3.0, 1.1, 0.0], "dwell": 0.1}, {"position": [2.9, 1.2, 0.1]}]
    drop(page, "path.json", json.dumps({"waypoints": points}).encode())
    until(page, lambda: "waypoints" in shown(page, "message"))
    advance(page, 3.0)
    assert get(page, "controller.desired.position[1]") < 3.05
    drop(page, "path.json", json.dumps({"waypoints": [{"position": [9.0, 1.1, 0.0]}, points[1]]}).encode())
    until(page, lambda: "out of reach" in shown(page, "message"))


def test_waypoints_that_are_clicked(page):
    """In the boom's plane: two of them become the path."""
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.05)
    page.execute_script("document.getElementById('waypoint-click').click()")
    canvas = page.find_element(By.ID, "machine")
    for x, y in ((150, 40), (130, 20)):
        ActionChains(page).move_to_element_with_offset(canvas, x, y).click().perform()
    until(page, lambda: "follows your waypoints" in shown(page, "message"))
    page.execute_script("document.getElementById('waypoint-click').click()")
    way = run(page, "return JSON.parse(JSON.parse(new URLSearchParams(location.hash.slice(1)).get('files')).waypoints)")
    assert [abs(point["position"][2]) < 1e-3 for point in way["waypoints"]] == [True, True], "the machine looks straight ahead"
    page.execute_script("document.getElementById('waypoint-clear').click()")


def test_the_tip_is_pushed_by_dragging(page):
    """The farther, the harder; let go, the force ends."""
    restart(page, trajectory="rates", controller__settle_time=0)
    page.execute_script("document.querySelector('[data-view=side]').click()")
    pictured(page)
    force = lambda: sum(get(page, f"hdrm.wrench_env[{k}]") ** 2 for k in (1, 2, 3)) ** 0.5
    ball = run(
        page,
        """const { clientWidth, clientHeight } = document.getElementById("machine");
        const eye = new THREE.PerspectiveCamera(35, clientWidth / clientHeight, 0.05, 60);
        eye.position.set(1.6, 1.5, 5.9);
        eye.lookAt(1.6, 1.4, 0);
        eye.updateMatrixWorld();
        const tip = await Promise.all([1, 2, 3].map((k) => machine.get(`hdrm.tip.position[${k}]`)));
        const { x, y } = new THREE.Vector3(...tip).project(eye);
        return [Math.round(0.5 * x * clientWidth), Math.round(-0.5 * y * clientHeight)];""",
    )
    canvas = page.find_element(By.ID, "machine")
    ActionChains(page).move_to_element_with_offset(canvas, *ball).click_and_hold().move_by_offset(30, 0).perform()
    until(page, lambda: force() > 10)
    weak = force()
    ActionChains(page).move_by_offset(60, 0).perform()
    until(page, lambda: force() > 2 * weak)
    ActionChains(page).release().perform()
    until(page, lambda: force() == 0)


def test_any_body_is_pushed(page):
    """The wrench at the tip has the power of the force at the body, whatever the motion: velocity of the tip by the FMU, that of the body's point
    by central differences of what is drawn, over h = 1 ms. Their error is h²/6 of its third derivative: with corners of 20 rad/s at 0.5 m/s
    7e-5 m/s, and the FMU's velocity differs from that of a rigid machine by rounding."""
    restart(page, trajectory="path", controller__path_file="six-joints", controller__settle_time=0.1)
    advance(page, 1.2)
    joints = lambda: run(page, "return Promise.all([1, 2, 3, 4, 5, 6].map((k) => machine.get(`hdrm.zeta[${k}]`)))")
    place = """const { scene } = machine, grip = { name: given[0], point: given[1] };
        scene.pose(scene.drawing.groups, given[2]); scene.grip = grip;
        return scene.gripPlace().toArray();"""
    force = np.array([200.0, 300.0, -400.0])
    for name, point in (("A2", [1.2, 0.1, 0.0]), ("A3", [0.8, 0.0, 0.1]), ("D2", [0.3, 0.0, 0.0]), ("D4", [0.1, 0.05, 0.0])):
        advance(page, 0.35)
        before = run(page, place, name, point, joints())
        advance(page, 1e-3)
        run(page, place, name, point, joints())
        until(page, lambda: run(page, "return machine.monitor.now('zeta')") == joints())
        run(page, "machine.scene.push(given[0])", force.tolist())
        until(page, lambda: get(page, "hdrm.wrench_env[1]") != 0)
        run(page, "await machine.advance(0)")  # All of it has come.
        wrench = np.array([get(page, f"hdrm.wrench_env[{k}]") for k in range(1, 7)])
        velocity = np.array([get(page, f"hdrm.tip.velocity[{k}]") for k in range(1, 7)])
        w, x, y, z = (get(page, f"hdrm.tip.orientation[{k}]") for k in range(1, 5))
        turn = Rotation.from_quat([x, y, z, w])
        run(page, "machine.scene.push([0, 0, 0])")
        until(page, lambda: get(page, "hdrm.wrench_env[6]") == 0)
        run(page, "await machine.advance(0)")
        advance(page, 1e-3)
        after = run(page, place, name, point, joints())
        speed = (np.array(after) - before) / 2e-3
        assert np.linalg.norm(speed) > 0.01, name
        power = turn.apply(wrench[:3]) @ velocity[:3] + turn.apply(wrench[3:]) @ velocity[3:]
        assert power == pytest.approx(force @ speed, abs=1e-4 * np.linalg.norm(force)), name


def test_the_boom_is_pushed_by_dragging(page):
    """Sideways: the slew gives way, and the force ends when it is let go."""
    restart(page, trajectory="rates", controller__settle_time=0)
    page.execute_script("document.querySelector('[data-view=top]').click()")
    until(page, lambda: shown(page, "clock") == "0.00 s")
    boom = run(
        page,
        """const { scene } = machine, { clientWidth, clientHeight } = scene.canvas;
        // The camera looks from its new place once it has been drawn.
        await new Promise((turn) => requestAnimationFrame(() => requestAnimationFrame(turn)));
        const group = scene.bodyPlace("A2");
        const { x, y } = new THREE.Vector3(1, 0.1, 0).applyQuaternion(group.quaternion).add(group.position).project(scene.drawing.camera);
        return [Math.round(0.5 * x * clientWidth), Math.round(-0.5 * y * clientHeight)];""",
    )
    canvas = page.find_element(By.ID, "machine")
    ActionChains(page).move_to_element_with_offset(canvas, *boom).click_and_hold().move_by_offset(0, 60).perform()
    force = lambda: sum(get(page, f"hdrm.wrench_env[{k}]") ** 2 for k in (1, 2, 3)) ** 0.5
    until(page, lambda: force() > 10)
    assert run(page, "return machine.scene.grip.name") == "A2"
    assert run(page, "return machine.scene.arrow.visible")
    rests = get(page, "hdrm.zeta[1]")
    advance(page, 0.1)
    assert abs(get(page, "hdrm.zeta[1]") - rests) > 1e-6
    ActionChains(page).release().perform()
    until(page, lambda: force() == 0)
    page.execute_script("document.querySelector('[data-view=wide]').click()")


def test_arrows_show_the_forces_of_the_rods(page):
    """Lift and tilt carry the machine: each arrow lies along its rod, out of it where the rod pushes, and is as long as the force asks."""
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.2)
    until(page, lambda: shown(page, "clock") == "0.20 s")
    arrows = lambda: run(
        page,
        """const { rods, drawing } = machine.scene;
        return rods.map((rod, k) => {
          const [x, y, z] = new THREE.Vector3(0, 1, 0).applyQuaternion(rod.quaternion).toArray();
          const along = new THREE.Vector3(1, 0, 0).applyQuaternion(machine.scene.bodyPlace(["T1", "D2", "D3"][k]).quaternion);
          return [rod.visible, along.dot(new THREE.Vector3(x, y, z)), rod.scale.y];
        });""",
    )
    forces = [get(page, f"emla_{k}.F") for k in (1, 2, 3)]
    for force, (visible, along, length) in list(zip(forces, arrows()))[1:]:
        assert visible and along == pytest.approx(math.copysign(1, force), abs=1e-6)
        assert length == pytest.approx(0.15 + 0.6 * abs(force) / 70e3, rel=1e-3)
    run(page, "await machine.set('hdrm.wrench_env[2]', 20000)")  # Lifted at its tip the machine hangs: the lift rod pulls.
    advance(page, 0.2)
    until(page, lambda: shown(page, "clock") == "0.40 s")
    assert get(page, "emla_2.F") < 0 and arrows()[1][1] == pytest.approx(-1, abs=1e-6)


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


def test_a_gamepad_leads(page):
    """One with the standard layout: the left stick to the right slews to the right."""
    restart(page, trajectory="rates", controller__settle_time=0)
    pad = "navigator.getGamepads = () => [{ connected: true, id: 'pad', axes: given[0], buttons: [] }]"
    run(page, pad + "; await new Promise((turn) => requestAnimationFrame(() => requestAnimationFrame(turn)))", [0, 0, 0, 0])  # at rest
    run(page, pad, [1, 0, 0, 0])
    until(page, lambda: get(page, "controller.rate.joint[1]") == pytest.approx(-0.15))
    run(page, "navigator.getGamepads = () => []")
    until(page, lambda: get(page, "controller.rate.joint[1]") == 0)


def pads(page, *pads, first=()):
    """These gamepads are there, each as (name, axes), for two pictures; before them `first` for one, however busy the machine is."""
    run(
        page,
        """const show = (pads) => {
          const shown = pads.map(([id, axes], index) => ({ connected: true, index, id, axes, buttons: [] }));
          navigator.getGamepads = () => shown;
          return new Promise(requestAnimationFrame);
        };
        if (given[0].length) await show(given[0]);
        await show(given[1]);
        await show(given[1]);""",
        first,
        pads,
    )


def test_a_gamepad_that_is_first_seen_while_it_is_moved_rests_at_zero(page):
    """A browser shows a pad once it is moved. Let go, it leads nothing; an axis that stands still elsewhere rests there."""
    restart(page, trajectory="rates", controller__settle_time=0)
    rate = lambda k: get(page, f"controller.rate.joint[{k}]")
    pads(page, ("trial", [1, 0, -1, 0]), first=[("trial", [0.8, 0, -1, 0])])
    until(page, lambda: rate(1) == pytest.approx(-0.15))
    assert rate(6) == 0, "a trigger that rests at -1 commands nothing"
    pads(page, ("trial", [0, 0, -1, 0]))
    until(page, lambda: rate(1) == 0)
    run(page, "await new Promise((turn) => setTimeout(turn, 1500))")  # The trigger stands still: that is its rest.
    pads(page, ("trial", [0, 0, -0.4, 0]))
    until(page, lambda: rate(6) < -0.1)
    pads(page)
    until(page, lambda: rate(6) == 0)
    assert "unplugged: trial" in shown(page, "message")


def test_two_sticks_lead_and_their_axes_can_be_changed(page):
    """As in a crane's cab: the second device has the right hand's levers; a lever takes the axis that is moved for it."""
    restart(page, trajectory="rates", controller__settle_time=0)
    rate = lambda k: get(page, f"controller.rate.joint[{k}]")
    pads(page, ("left", [0, 0]), ("right", [0, 0]))
    pads(page, ("left", [0, -1]), ("right", [0, -1]))
    until(page, lambda: rate(2) == pytest.approx(0.1) and rate(3) == pytest.approx(0.1))
    pads(page, ("left", [0, 0]), ("right", [0, 0]))
    page.execute_script("document.querySelector('#pad-rows tr:nth-child(4) button').click()")
    pads(page, ("left", [0, 0]), ("right", [1, 0]))
    until(page, lambda: rate(4) == pytest.approx(0.5))
    assert "axis 1 of device 2" in page.execute_script("return document.getElementById('pad-rows').textContent")
    page.execute_script("document.getElementById('pad-reset').click()")
    pads(page)
    until(page, lambda: rate(4) == 0)


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


def test_letters_lead_while_a_list_has_the_focus(page):
    """Else A would choose "all six joints"."""
    restart(page, trajectory="rates", controller__settle_time=0)
    run(page, "machine.play()")
    page.execute_script("document.getElementById('trajectory').focus()")
    ActionChains(page).key_down("a").perform()
    until(page, lambda: get(page, "controller.rate.joint[1]") == pytest.approx(0.15))
    ActionChains(page).key_up("a").perform()
    until(page, lambda: get(page, "controller.rate.joint[1]") == 0)
    assert page.find_element(By.ID, "trajectory").get_property("value") == "rates joint"


def test_keys_are_named_as_they_are_printed(page):
    """On a French keyboard the key of A is a Q."""
    caps = "return [...document.querySelectorAll('#levers .lever:first-child kbd')].map((cap) => cap.textContent)"
    press = "document.dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyA', key: given })); document.dispatchEvent(new KeyboardEvent('keyup', { code: 'KeyA', key: given }))"
    page.execute_script(press.replace("given", "arguments[0]"), "q")
    assert page.execute_script(caps) == ["Q", "D"] and "Q" in page.execute_script("return document.getElementById('keys').textContent")
    page.execute_script(press.replace("given", "arguments[0]"), "a")
    assert page.execute_script(caps) == ["A", "D"]


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


def test_a_waypoint_that_cannot_be_reached_is_taken_back(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    advance(page, 0.05)
    page.execute_script("document.getElementById('waypoint-here').click(); document.getElementById('waypoint-click').click(); document.querySelector('[data-view=side]').click()")
    canvas = page.find_element(By.ID, "machine")
    ActionChains(page).move_to_element_with_offset(canvas, -420, -60).click().perform()
    until(page, lambda: "cannot reach" in shown(page, "message"))
    assert page.execute_script("return document.getElementById('waypoint-count').textContent").startswith("1,")
    page.execute_script("document.getElementById('waypoint-click').click(); document.getElementById('waypoint-back').click()")
    assert "No waypoints" in page.execute_script("return document.getElementById('waypoint-count').textContent")


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


@pytest.mark.parametrize("world", ["ideal", "real", "electric"])
def test_the_emergency_stop_and_the_reset(page, world):
    """The supervisor brakes all, in words, also where the drives themselves tell of trips; after the reset the levers lead again."""
    restart(page, world=world, trajectory="rates", controller__settle_time=0.5, controller__supervisor="true")
    lever = lambda rate: run(page, "await machine.set('controller.rate.joint[1]', given[0])", rate)
    lever(0.1)
    advance(page, 1.5)
    page.execute_script("document.getElementById('emergency').click()")
    until(page, lambda: get(page, "controller.tripped[1]"))
    advance(page, 1.5)
    assert get(page, "controller.supervisor.state") == 7
    until(page, lambda: "emergency stop" in shown(page, "broken"))
    stands = get(page, "hdrm.zeta[1]")
    advance(page, 0.5)
    # The lever asks for 0.05 rad in this time. The ideal machine has no brakes: held by its drives it swings about its rest, 3.3 mrad at most,
    # with a period of 1.2 s, and loses 1/e in a second.
    assert abs(get(page, "hdrm.zeta[1]") - stands) < (5e-3 if world == "ideal" else 1e-3), "it stands, though the lever is not at rest"
    lever(0)
    page.find_element(By.ID, "reset").click()
    until(page, lambda: get(page, "controller.reset"))
    assert not get(page, "controller.tripped[1]")
    advance(page, 0.5)
    until(page, lambda: not page.find_element(By.ID, "broken").is_displayed())
    lever(0.1)
    before = get(page, "hdrm.zeta[1]")
    advance(page, 1.0)
    assert get(page, "hdrm.zeta[1]") > before + 0.05
    if world != "ideal":
        with pytest.raises(RuntimeError, match="override:VALUE. replaces"):
            run(page, "await machine.set('controller.tripped[1]', true)")
        with pytest.raises(RuntimeError, match="override of `controller.tripped.1.`"):
            run(page, "await machine.set('controller.tripped[1]', 'override:perhaps')")


def test_the_end_of_travel_is_told_on_the_lever(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    slew = page.find_element(By.CSS_SELECTOR, "#levers .lever")
    assert "end of travel" not in slew.text
    run(page, "await machine.set('controller.rate.joint[1]', 0.15)")
    advance(page, 9.0)
    until(page, lambda: "end of travel left" in slew.text)


def test_the_tip_meets_the_floor_and_is_warned_of_it(page):
    reopen(page, PAGE.as_uri())
    run(page, "await machine.pause()")
    assert get(page, "hdrm.contact.stiffness") > 0
    restart(page, trajectory="rates", controller__settle_time=0, hdrm__contact__stiffness=2e5, hdrm__contact__damping=1)
    run(page, "await machine.set('controller.rate.joint[2]', -0.1)")
    advance(page, 3.3)
    until(page, lambda: "floor" in shown(page, "broken"))
    advance(page, 1.0)
    assert get(page, "hdrm.contact.force[2]") > 100
    until(page, lambda: run(page, "return machine.scene.contact.visible"))


def test_tasks_follow_one_another_until_a_lever_is_touched(page):
    reopen(page, PAGE.as_uri())
    assert page.execute_script("return document.getElementById('trajectory').value") == "path six-joints"
    Select(page.find_element(By.ID, "speed")).select_by_value("Infinity")
    until(page, lambda: page.execute_script("return document.getElementById('trajectory').value") == "triangular")
    Select(page.find_element(By.ID, "speed")).select_by_value("1")
    body = page.find_element(By.TAG_NAME, "body")
    ActionChains(page).key_down("w", body).perform()
    until(page, lambda: page.execute_script("return document.getElementById('trajectory').value") == "rates joint")
    ActionChains(page).key_up("w", body).perform()
    run(page, "await machine.pause()")
    advance(page, 5)
    run(page, "machine.play()")
    now = page.execute_script("return machine.time")
    until(page, lambda: page.execute_script("return machine.time") > now + 0.3)
    assert page.execute_script("return document.getElementById('trajectory').value") == "rates joint", "no task follows"


def test_arcs_show_the_ranges_of_the_joints(page):
    """From end to end, about the joint: angles of the arc's corners seen from its middle."""
    spans = page.execute_script(
        """const { arcs, data } = machine.scene;
        return arcs.map(([arc], k) => {
          const at = arc.geometry.attributes.position.array;
          const angles = Array.from({ length: at.length / 3 }, (_, i) => Math.atan2(at[3 * i + 1], at[3 * i]));
          const [least, most] = data.joints[k + 1];
          const jumps = angles.sort((a, b) => a - b).map((angle, i) => (angles[(i + 1) % angles.length] - angle + 2 * Math.PI) % (2 * Math.PI));
          return [2 * Math.PI - Math.max(...jumps), most - least];
        });"""
    )
    for span, span_of_joint in spans:
        assert span == pytest.approx(span_of_joint, abs=0.2), "a band's width at its ends"


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


def test_a_person_and_a_grid_give_the_scale(page):
    """Their sizes in the picture's metres: someone of 1.8 m with helmet who stands on the floor, and squares of 1 m."""
    low, high = page.execute_script(
        """const found = machine.scene.drawing.scene.children.filter(({ position: { x, z }, geometry }) => geometry && x === -0.9 && z === -0.4);
        const heights = found.flatMap(({ geometry, position }) => { geometry.computeBoundingBox(); const { min, max } = geometry.boundingBox; return [min.y + position.y, max.y + position.y]; });
        return [Math.min(...heights), Math.max(...heights)];"""
    )
    assert low == pytest.approx(0.0, abs=0.02) and high == pytest.approx(1.8, abs=0.02)
    corners = page.execute_script("return [...machine.scene.drawing.ground.children[1].geometry.attributes.position.array].filter((_, k) => k % 3 < 2)")
    edges = np.unique(np.round(corners, 6))
    assert len(edges) > 10 and np.diff(edges) == pytest.approx(1.0)


@pytest.mark.parametrize("width", [1400, 390])
def test_a_message_covers_no_button(page, width):
    try:
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 600})
        until(page, lambda: page.execute_script("return window.innerWidth") == width)
        page.execute_script("document.getElementById('message').textContent = 'Word '.repeat(80); document.getElementById('message').classList.add('shown')")
        covered = """const box = document.getElementById("message").getBoundingClientRect();
        return [...document.querySelectorAll("#stage button, #stage select")].filter((one) => one.checkVisibility()).filter((one) => {
          const { left, right, top, bottom } = one.getBoundingClientRect();
          return right > box.left && left < box.right && bottom > box.top && top < box.bottom;
        }).map((one) => one.textContent || one.title);"""
        assert page.execute_script(covered) == []
    finally:
        page.execute_script("document.getElementById('message').classList.remove('shown'); document.getElementById('message').textContent = ''")
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_wheel_shows_more_of_the_run(page):
    """Of all scopes at once; a double click shows the usual part."""
    lengths = "return [...machine.monitor.scopes.values()].map(({ scope }) => scope.length)"
    wheel = "const canvas = document.querySelector('.scope canvas'); for (let k = 0; k < 3; k += 1) canvas.dispatchEvent(new WheelEvent('wheel', { deltaY: 100, cancelable: true }))"
    page.execute_script(wheel)
    assert page.execute_script(lengths) == pytest.approx([12 * 1.15**3] * 3)
    page.execute_script("document.querySelector('.scope canvas').dispatchEvent(new MouseEvent('dblclick', { cancelable: true }))")
    assert page.execute_script(lengths) == [12] * 3


def test_a_joints_slider_leads_it_there_and_ends_at_its_limits(page):
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    least, most = page.execute_script("return JSON.parse(document.getElementById('scene').textContent).joints[0]")
    slider = "document.querySelector('#joints input')"
    assert page.execute_script(f"return [Number({slider}.min), Number({slider}.max)]") == pytest.approx([least, most], abs=1e-6)
    page.execute_script(f"{slider}.value = 0.12; {slider}.dispatchEvent(new Event('input'))")
    run(page, "machine.play()")
    until(page, lambda: abs(get(page, "hdrm.zeta[1]") - 0.12) < 3e-3 and get(page, "controller.rate.joint[1]") == 0)
    assert page.find_element(By.ID, "trajectory").get_property("value") == "rates joint"
    until(page, lambda: "7° of" in page.execute_script("return document.getElementById('joints').textContent"))


def test_the_picture_is_kept_and_fills_the_screen(page):
    kept = run(
        page,
        """const made = URL.createObjectURL;
        const blob = await new Promise((found) => {
          URL.createObjectURL = (blob) => { found(blob); URL.createObjectURL = made; return "data:,"; };
          document.getElementById("picture").click();
        });
        const shown = await createImageBitmap(blob);
        const { clientWidth: width, clientHeight: height } = document.getElementById("machine");
        const canvas = new OffscreenCanvas(64, 36);
        canvas.getContext("2d").drawImage(shown, 0, 0, 64, 36);
        const colours = new Set(new Uint32Array(canvas.getContext("2d").getImageData(0, 0, 64, 36).data.buffer));
        return [blob.type, shown.width === width && shown.height === height, colours.size];""",
    )
    assert kept[:2] == ["image/png", True] and kept[2] > 50, "it is no blank one"
    page.find_element(By.ID, "full").click()
    until(page, lambda: page.execute_script("return document.fullscreenElement?.id") == "stage")
    page.find_element(By.ID, "full").click()
    until(page, lambda: page.execute_script("return document.fullscreenElement") is None)


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


def test_tip_path_and_ghosts_err_from_one_origin(page):
    """All that is drawn enlarged starts at the reference, which is drawn where it is."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts=pd" in page.current_url)
    where = "const s = machine.scene; return [s.reference, s.error, s.errors[0]].map((m) => m.position.toArray()).concat([Array.from(s.way.points.slice(3 * s.way.count - 3, 3 * s.way.count))])"
    three = lambda name, *law: [get(page, f"{name}[{k}]", *law) for k in (1, 2, 3)]
    for gain in ("1000", "100"):
        Select(page.find_element(By.ID, "error-gain")).select_by_visible_text(gain)
        advance(page, 0.5)
        pictured(page)
        reference, error, ghost, way = run(page, where)
        desired = three("controller.desired.position")
        assert reference == pytest.approx(desired, abs=1e-9)
        for drawn, law in ((error, ()), (ghost, ("pd",))):
            tip = three("hdrm.tip.position", *law)
            assert drawn == pytest.approx([d + float(gain) * (p - d) for d, p in zip(desired, tip)], abs=1e-5)
        assert sum((a - b) ** 2 for a, b in zip(way, error)) ** 0.5 < 2e-3, "the way is drawn each millimetre"
    page.execute_script("document.querySelector('#ghosts [value=pd]').click()")
    until(page, lambda: "ghosts" not in page.current_url)


def test_axe_has_no_remark(page):
    page.execute_script("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    assert remarks(page) == []


def test_one_can_look_back_at_the_whole_run(page):
    """One cursor in the picture and the scopes: both show what was, and again what is when the run goes on. The wheel shows more of it."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    drawn = lambda: run(page, "return machine.scene.drawing.groups.map((g) => [...g.position.toArray(), ...g.quaternion.toArray()])")
    clock = lambda: shown(page, "clock")
    advance(page, 2.0)
    until(page, lambda: clock() == "2.00 s")
    early = drawn()
    for _ in range(14):
        advance(page, 1.0)
    until(page, lambda: clock() == "16.00 s")
    late = drawn()
    look = "const scrub = document.getElementById('scrub'); scrub.value = arguments[0]; scrub.dispatchEvent(new Event('input'))"
    # One scope is drawn with a picture, in turn: the legend is of this moment once all of them are.
    ends = lambda: page.execute_script("return [...machine.monitor.scopes.values()].map(({ scope }) => scope.end)")
    legend = lambda: until(page, lambda: len(set(ends())) == 1) and page.execute_script("return document.querySelector('.scope h3 span').textContent")
    page.execute_script(look, 2.0)
    until(page, lambda: clock() == "2.00 s")
    # What is kept has single precision.
    until(page, lambda: all(a == pytest.approx(b, abs=1e-6) for a, b in zip(drawn(), early)))
    there = legend()
    page.execute_script(look, 16.0)
    until(page, lambda: clock() == "16.00 s")
    assert legend() != there
    until(page, lambda: all(a == pytest.approx(b, abs=1e-6) for a, b in zip(drawn(), late)))
    page.execute_script(look, 2.0)
    until(page, lambda: clock() == "2.00 s")
    advance(page, 0.1)
    until(page, lambda: clock() == "16.10 s")


def test_it_prints_picture_and_scopes(page):
    try:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        shows = "return ['stage', 'scopes', 'panel', 'levers', 'message'].filter((id) => getComputedStyle(document.getElementById(id)).display !== 'none')"
        assert page.execute_script(shows) == ["stage", "scopes"]
        assert page.execute_script("return getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@pytest.mark.parametrize("force", [0, -14000])
def test_the_numbers_at_an_axis_differ_and_are_evenly_spaced(page, force):
    """Whatever a scope shows: values that are large, small or nearly alike."""
    run(
        page,
        """window.axes = new Map();
        const { clearRect, fillText } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.clearRect = function (...at) { axes.set(this.canvas, []); clearRect.apply(this, at); };
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
          if (this.textAlign === "right" && /^[−0-9.]+$/.test(text)) axes.get(this.canvas)?.push(Number(text.replace("−", "-")));
          fillText.call(this, text, ...at);
        };
        window.unhook = () => Object.assign(CanvasRenderingContext2D.prototype, { clearRect, fillText });""",
    )
    try:
        restart(page, trajectory="rates", controller__settle_time=0)
        run(page, "await machine.set('hdrm.wrench_env[2]', given[0])", force)
        advance(page, 0.6)
        numbers = lambda: page.execute_script("return [...axes].filter(([canvas]) => canvas.isConnected).map(([, numbers]) => numbers)")
        until(page, lambda: len(numbers()) >= 3 and all(len(axis) >= 2 for axis in numbers()))
        for axis in numbers():
            steps = [b - a for a, b in zip(axis, axis[1:])]
            assert min(steps) > 0 and max(steps) < 1.01 * min(steps), axis
    finally:
        page.execute_script("unhook()")


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


def test_the_keyboard_reaches_all_controls(page):
    page.execute_script("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    controls = page.find_elements(By.CSS_SELECTOR, "select, input:not([hidden]), button, summary, #machine")
    assert len(controls) > 50
    named = "return arguments[0].ariaLabel || arguments[0].labels?.[0]?.textContent.trim() || arguments[0].textContent.trim()"
    for control in controls:
        assert control.get_property("tabIndex") == 0
        assert page.execute_script(named, control), control.get_attribute("outerHTML")
    restart(page, trajectory="rates")
    before = page.execute_script("return machine.time")
    body = page.find_element(By.TAG_NAME, "body")
    body.send_keys(".")
    until(page, lambda: page.execute_script("return machine.time") > before)
    body.send_keys(Keys.SPACE)
    until(page, lambda: page.execute_script("return machine.time") > before + 0.1)
    body.send_keys(Keys.SPACE)
    until(page, lambda: "Run" in shown(page, "play"))


@pytest.mark.parametrize("width", [1400, 390])
def test_nothing_is_wider_than_the_window(page, width):
    try:
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 600})
        until(page, lambda: page.execute_script("return window.innerWidth") == width)
        until(page, lambda: page.execute_script("return document.documentElement.scrollWidth") <= width)
        stage = page.find_element(By.ID, "stage").rect
        assert stage["width"] > 0.6 * min(width, 1000) and stage["height"] > 250
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_it_waits_where_motion_is_reduced_and_is_dark_where_that_is_wanted(page):
    wanted = {"prefers-reduced-motion": "reduce", "prefers-color-scheme": "dark"}
    try:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": name, "value": value} for name, value in wanted.items()]})
        reopen(page, PAGE.as_uri())
        assert "Run" in shown(page, "play") and page.execute_script("return machine.time") == 0
        ground = page.execute_script("return getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)")
        assert max(ground) < 60
        page.find_element(By.ID, "play").click()
        until(page, lambda: page.execute_script("return machine.time") > 0.1)
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": name, "value": ""} for name in wanted]})


def test_the_verdict_and_the_end(page):
    """A machine that is asked too much is said to be lost."""
    restart(page, trajectory="rates", controller__settle_time=0)
    until(page, lambda: shown(page, "verdict") == "no faults")
    run(page, "await machine.set('hdrm.wrench_env[2]', -60000)")
    advance(page, 0.4)
    until(page, lambda: page.find_element(By.ID, "broken").is_displayed())
    assert any(word in shown(page, "broken") for word in ("broken", "lost", "Overloaded"))


def test_without_a_picture_it_says_why():
    chrome = chromium("disable-3d-apis")
    chrome.get(PAGE.as_uri())
    until(chrome, lambda: chrome.find_element(By.ID, "broken").is_displayed())
    assert "no WebGL 2" in shown(chrome, "broken")
    chrome.quit()
