"""Whoever leads the live machine by hand: levers, keys, gamepads, clicked waypoints, pushes, the emergency stop."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from browser import drop, pictured, run, shown, until
from machine_page import PAGE, advance, get, opened, page, reopen, restart  # noqa: F401 (fixtures)


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


def test_the_end_of_travel_is_told_on_the_lever(page):
    restart(page, trajectory="rates", controller__settle_time=0)
    slew = page.find_element(By.CSS_SELECTOR, "#levers .lever")
    assert "end of travel" not in slew.text
    run(page, "await machine.set('controller.rate.joint[1]', 0.15)")
    advance(page, 9.0)
    until(page, lambda: "end of travel left" in slew.text)


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
