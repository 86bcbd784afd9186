"""What the live machine's page shows: machine and ghosts where the FMUs have them, forces, ranges, scopes, and that it fits every window."""

import math

import numpy as np
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

from browser import chromium, pictured, remarks, run, shown, until
from machine_page import PAGE, advance, get, opened, page, reopen, restart  # noqa: F401 (fixtures)


def test_the_machine_is_drawn_where_the_fmu_has_it(page):
    """The page solves the closed loops itself: its tip and its strokes are those of the FMU to rounding, also away from the start."""
    restart(page, trajectory="cubic", controller__settle_time=0.1)
    advance(page, 2.0)
    until(page, lambda: shown(page, "clock") == "2.00 s")
    assert float(page.find_element(By.ID, "stage").get_attribute("data-drawing-error")) < 1e-9
    # Once nothing moves the picture has all the points of the screen, whatever it had before.
    until(page, lambda: page.execute_script("const { width, clientWidth } = document.getElementById('machine'); return width === clientWidth"))


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


def test_the_wheel_shows_more_of_the_run(page):
    """Of all scopes at once; a double click shows the usual part."""
    lengths = "return [...machine.monitor.scopes.values()].map(({ scope }) => scope.length)"
    wheel = "const canvas = document.querySelector('.scope canvas'); for (let k = 0; k < 3; k += 1) canvas.dispatchEvent(new WheelEvent('wheel', { deltaY: 100, cancelable: true }))"
    page.execute_script(wheel)
    assert page.execute_script(lengths) == pytest.approx([12 * 1.15**3] * 3)
    page.execute_script("document.querySelector('.scope canvas').dispatchEvent(new MouseEvent('dblclick', { cancelable: true }))")
    assert page.execute_script(lengths) == [12] * 3


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


def test_it_prints_picture_and_scopes(page):
    try:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        shows = "return ['stage', 'scopes', 'panel', 'levers', 'message'].filter((id) => getComputedStyle(document.getElementById(id)).display !== 'none')"
        assert page.execute_script(shows) == ["stage", "scopes"]
        assert page.execute_script("return getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    finally:
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_without_a_picture_it_says_why():
    chrome = chromium("disable-3d-apis")
    chrome.get(PAGE.as_uri())
    until(chrome, lambda: chrome.find_element(By.ID, "broken").is_displayed())
    assert "no WebGL 2" in shown(chrome, "broken")
    chrome.quit()


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


def test_axe_has_no_remark(page):
    page.execute_script("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    assert remarks(page) == []
