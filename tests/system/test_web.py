"""The web page: cameras are made, steered, watched and deleted in it, and what goes wrong is said."""

import json
import math
import os
import subprocess

import numpy as np
import pytest

import camrig
from conftest import REPOSITORY, wait_until
from web_page import chromium, drag, metres_per_pixel, middle, opened, pixels, streams_opened, until, wait_for_picture

CAMRIG = os.environ["CAMRIG_BIN"]


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture
def page(browser, rig):
    with opened(browser, rig.page_url) as shown:
        yield shown


def test_a_camera_is_created_moved_seen_to_move_and_deleted(rig, page):
    page.click("#create")
    page.fill("#new-camera [name=name]", "eye")
    page.select_option("#new-camera [name=place]", "main")
    page.fill("#new-camera [name=width]", "320")
    page.fill("#new-camera [name=height]", "240")
    page.click("#new-camera button[value=ok]")
    until(page, "document.getElementById('stage-name').textContent === 'eye' && document.getElementById('picture').width === 320")
    before = pixels(page)
    pose = rig.camera("eye").get()["pose"]

    page.focus("#view")
    for key in ("ArrowLeft", "ArrowLeft", "ArrowUp", "w"):
        page.keyboard.press(key)
    wait_until(lambda: rig.camera("eye").get()["pose"]["pan_deg"] == pytest.approx(pose["pan_deg"] + 8), what="the pan")
    wait_until(lambda: rig.camera("eye").get()["pose"]["position"] != pose["position"], what="the step ahead")
    assert rig.camera("eye").get()["pose"]["tilt_deg"] == pytest.approx(pose["tilt_deg"] + 4)
    turned = wait_for_picture(page, before, 1)

    page.keyboard.press("+")
    wait_until(lambda: rig.camera("eye").get()["vfov_deg"] < 50, what="the zoom")
    page.get_by_label("Pan right").click()
    wait_until(lambda: rig.camera("eye").get()["pose"]["pan_deg"] == pytest.approx(pose["pan_deg"] + 4), what="the button")
    wait_for_picture(page, turned, 1)

    page.get_by_label("z (m)", exact=True).fill("1.25")
    page.keyboard.press("Enter")
    wait_until(lambda: rig.camera("eye").get()["pose"]["position"][2] == 1.25, what="the number")
    # Parameters that only the rig's table tells of: a number, words, null, and one of an object.
    page.get_by_label("Near (m)").fill("0.2")
    page.keyboard.press("Enter")
    wait_until(lambda: rig.camera("eye").get()["near"] == 0.2, what="near")
    page.get_by_label("Antialias").select_option("ssaa2")
    page.get_by_label("Quality").select_option("fast")
    wait_until(lambda: rig.camera("eye").get()["quality"] == "fast", what="the quality")
    page.get_by_label("Quality").select_option("the rig's")
    page.get_by_label("Exposure (EV)", exact=True).fill("-1.5")
    page.keyboard.press("Enter")
    wait_until(lambda: rig.camera("eye").get()["controls"]["exposure_ev"] == -1.5, what="the exposure")

    def seen():
        camera = rig.camera("eye").get()
        return camera["antialias"], camera["quality"], camera["controls"]["auto_exposure"]

    wait_until(lambda: seen() == ("ssaa2", None, False), what="all that was set")

    with streams_opened(page, "eye_2"):
        page.click("#duplicate")
    wait_until(lambda: [camera.name for camera in rig.cameras()] == ["main", "eye", "eye_2"], what="the copy")
    assert rig.camera("eye_2").get()["pose"]["orientation"] == pytest.approx(rig.camera("eye").get()["pose"]["orientation"])
    assert rig.camera("eye_2").get()["size"] == [320, 240]

    page.click("#delete")
    page.click("#confirm button[value=ok]")
    wait_until(lambda: [camera.name for camera in rig.cameras()] == ["main", "eye"], what="its end")
    until(page, "!document.querySelector('.tile[data-camera=eye_2]')")


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_a_head_is_driven_aimed_and_remembers_places(rig, page):
    camera = rig.create_camera("dome", size=(320, 240), position=(12, 9, 2.8), look_at=(2, 3, 1))
    page.wait_for_selector(".tile[data-camera=dome]")
    page.click(".tile[data-camera=dome]")
    assert page.is_hidden("#head")
    # A head is put on where the parameters are; its own show once it is there.
    fields = page.locator("#fields")
    fields.get_by_label("Ptz").select_option("on")
    fields.get_by_role("group", name="Ptz").get_by_label("Preset").select_option("ideal")  # a sensor has presets too
    wait_until(lambda: (camera.get()["ptz"] or {}).get("preset") == "ideal", what="the head")
    page.wait_for_selector("#head:not([hidden])")
    base = camera.get()["pose"]

    page.focus("#view")
    page.keyboard.press("ArrowLeft")
    wait_until(lambda: camera.ptz.status()["true"]["pan_deg"] == pytest.approx(4), what="the key")
    page.keyboard.press("+")
    wait_until(lambda: camera.ptz.status()["true"]["zoom"] == pytest.approx(1.1), what="the zoom")
    page.get_by_label("New preset").fill("door")
    page.keyboard.press("Enter")
    wait_until(lambda: list(camera.ptz.status()["presets"]) == ["door"], what="the preset")

    # Held away from where it was grabbed it goes on turning to the right, and stands when it is let go.
    x, y = middle(page, "#view")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 150, y, steps=3)
    wait_until(lambda: camera.ptz.status()["pan_deg"] < -90, what="the drive")
    page.mouse.up()
    wait_until(lambda: not camera.ptz.status()["turning"], what="the stand")

    page.get_by_role("button", name="Go").click()
    wait_until(lambda: camera.ptz.status()["true"]["pan_deg"] == pytest.approx(4), what="the preset again")
    box = page.locator("#view").bounding_box()
    focal = camera.get()["shown_intrinsics"]["fx"]
    page.mouse.dblclick(box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"])
    wait_until(lambda: camera.ptz.status()["pan_deg"] == pytest.approx(4 - math.degrees(math.atan(80 / focal)), abs=0.3), what="the aim")
    page.get_by_role("button", name="Home").click()
    wait_until(lambda: camera.ptz.status()["true"]["pan_deg"] == 0, what="home")
    until(page, "document.getElementById('head-facts').textContent.startsWith('pan 0° · tilt 0°')")
    assert camera.get()["pose"] == base


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_a_head_is_driven_by_a_finger_and_zooms_by_wheel_and_pinch(rig, browser):
    camera = rig.create_camera("dome", size=(320, 240), position=(12, 9, 2.8), look_at=(2, 3, 1), ptz={"preset": "ideal"})
    with opened(browser, rig.page_url, has_touch=True) as page:
        page.wait_for_selector(".tile[data-camera=dome]")
        page.tap(".tile[data-camera=dome]")
        page.wait_for_selector("#head:not([hidden])")
        hand = page.context.new_cdp_session(page)
        x, y = middle(page, "#view")

        def touch(kind, *points):
            hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x + dx, "y": y + dy, "id": finger} for finger, (dx, dy) in enumerate(points)]})

        # One finger that is held to the left and upwards is a joystick; lifted, the head stands.
        touch("touchStart", (0, 0))
        touch("touchMove", (-40, -40))
        wait_until(lambda: camera.ptz.status()["pan_deg"] > 5 and camera.ptz.status()["tilt_deg"] > 5, what="the drive by a finger")
        touch("touchEnd")
        wait_until(lambda: not camera.ptz.status()["turning"], what="the stand")
        stands = camera.ptz.status()

        # Two fingers that go apart to the double zoom in by as much, and turn nothing.
        touch("touchStart", (-40, 0), (40, 0))
        for apart in (50, 60, 70, 80):
            touch("touchMove", (-apart, 0), (apart, 0))
        touch("touchEnd")
        wait_until(lambda: camera.ptz.status()["true"]["zoom"] == pytest.approx(2, rel=0.04), what="the pinch")
        assert camera.ptz.status()["pan_deg"] == stands["pan_deg"] and camera.ptz.status()["tilt_deg"] == stands["tilt_deg"]

        page.focus("#view")
        page.mouse.move(x, y)
        page.mouse.wheel(0, -100)
        wait_until(lambda: camera.ptz.status()["true"]["zoom"] == pytest.approx(2.2, rel=0.04), what="the wheel")
        page.mouse.wheel(0, 100)
        wait_until(lambda: camera.ptz.status()["true"]["zoom"] == pytest.approx(2, rel=0.04), what="the wheel, turned back")


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_guard_tours_are_made_of_presets_started_stopped_and_removed(rig, browser):
    from axe_playwright_python.sync_playwright import Axe

    camera = rig.create_camera("dome", size=(320, 240), position=(12, 9, 2.8), look_at=(2, 3, 1), ptz={"preset": "ideal"})
    for name, pan in (("door", 40), ("desk", -40)):
        camera.ptz.move(pan_deg=pan)
        wait_until(lambda: camera.ptz.status()["true"]["pan_deg"] == pan, what="the place")
        camera.ptz.preset_set(name)
    camera.ptz.home_goto()
    with opened(browser, rig.page_url) as page:
        assert page.is_hidden("#tours")
        page.click(".tile[data-camera=dome]")
        page.click("#tours summary")
        tours = page.locator("#tours")
        until(page, "document.querySelector('#tours [name=preset]').options.length === 2")
        for preset, dwell in (("door", "1.5"), ("desk", "4"), ("door", "30")):
            tours.get_by_label("Stop at").select_option(preset)
            tours.get_by_label("for").fill(dwell)
            tours.get_by_role("button", name="Add stop").click()
        tours.get_by_role("button", name="Leave out stop 3").click()
        tours.get_by_label("New tour").fill("round")
        tours.get_by_role("button", name="Make tour").click()
        until(page, "document.getElementById('tour-list').textContent.includes('round: door 1.5 s → desk 4 s')")
        assert camera.ptz.status()["tours"] == {"round": [{"preset": "door", "dwell_s": 1.5, "speed": 1}, {"preset": "desk", "dwell_s": 4, "speed": 1}]}
        until(page, "document.querySelectorAll('#tour-stops li').length === 0")

        tours.get_by_role("button", name="Start tour round").click()
        for pan in (40, -40):
            wait_until(lambda: camera.ptz.status()["true"]["pan_deg"] == pytest.approx(pan), what="a stop of the tour")
        until(page, "document.querySelector('#tour-list li[aria-current]')")
        found = Axe().run(page, context="#stage", options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}).response
        assert [(one["id"], [node["html"][:160] for node in one["nodes"]]) for one in found["violations"]] == []
        tours.get_by_role("button", name="Stop tour round").click()
        wait_until(lambda: camera.ptz.status()["tour"] is None, what="its stop")
        until(page, "!document.querySelector('#tour-list li[aria-current]')")

        # A stop that is gone is said in the rig's words, and a tour that was refused is still there to be mended.
        tours.get_by_label("Stop at").select_option("desk")
        tours.get_by_role("button", name="Add stop").click()
        tours.get_by_label("New tour").fill("again")
        camera.ptz.preset_remove("desk")
        tours.get_by_role("button", name="Make tour").click()
        page.wait_for_selector("#messages .error")
        assert tours.get_by_label("New tour").input_value() == "again"
        tours.get_by_role("button", name="Leave out stop 1").click()
        tours.get_by_label("New tour").fill("")
        page.get_by_label("Dismiss this message").click()
        tours.get_by_role("button", name="Start tour round").click()
        page.wait_for_selector("#messages .error")
        tours.get_by_role("button", name="Remove tour round").click()
        wait_until(lambda: camera.ptz.status()["tours"] == {}, what="its end")
        until(page, "document.querySelectorAll('#tour-list li').length === 0")


def test_blanks_in_the_names_of_presets_and_places_are_kept(browser, tmp_path):
    name = " by  the door "
    scene = {"camrig_scene": 1, "name": "blanks", "base": "camrig:minimal", "places": {name: {"pose": {"position": [-1, -2, 3], "look_at": [0, 0, 0.4]}}}}
    (tmp_path / "blanks.json").write_text(json.dumps(scene))
    with camrig.start(tmp_path / "blanks.json", mode="realtime") as rig:
        head = rig.create_camera("dome", size=(320, 240), place="main", ptz={"preset": "ideal"}).ptz
        head.move(pan_deg=40)
        wait_until(lambda: head.status()["true"]["pan_deg"] == 40, what="the place")
        head.preset_set(name)
        head.home_goto()
        with opened(browser, rig.page_url) as page:
            page.click(".tile[data-camera=dome]")
            page.select_option("#head [name=preset]", value=name)
            page.get_by_role("button", name="Go", exact=True).click()
            wait_until(lambda: head.status()["true"]["pan_deg"] == pytest.approx(40), what="the preset again")
            page.click("#tours summary")
            tours = page.locator("#tours")
            tours.get_by_label("Stop at").select_option(value=name)
            tours.get_by_role("button", name="Add stop").click()
            tours.get_by_label("New tour").fill("round")
            tours.get_by_role("button", name="Make tour").click()
            wait_until(lambda: [stop["preset"] for stop in head.status()["tours"].get("round", [])] == [name], what="the tour")
            page.click("#create")
            page.fill("#new-camera [name=name]", "eye")
            page.select_option("#new-camera [name=place]", value=name)
            page.click("#new-camera button[value=ok]")
            wait_until(lambda: "eye" in [camera.name for camera in rig.cameras()], what="the camera")
            assert rig.camera("eye").get()["pose"]["position"] == [-1, -2, 3]


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_faults_are_set_listed_and_cleared(rig, browser):
    from axe_playwright_python.sync_playwright import Axe

    rig.create_camera("desk", size=(320, 240), place="lobby")
    with opened(browser, rig.page_url) as page:
        page.click(".tile[data-camera=desk]")
        page.click("#faults summary")
        faults = page.locator("#faults")
        until(page, "document.querySelector('#faults [name=kind]').options.length > 20")
        faults.get_by_label("Kind").select_option("corrupt_jpeg")
        faults.get_by_label("mode").select_option("cut")
        faults.get_by_label("keep header").uncheck()
        faults.get_by_label("Severity").fill("0.5")
        faults.get_by_role("button", name="Let it fail").click()
        until(page, "document.getElementById('fault-list').textContent.includes('corrupt jpeg 0.5')")
        (one,) = rig.fault.list("desk")
        assert one["params"] == {"mode": "cut", "amount": 1400, "probability": 1, "keep_header": False, "output": "any"}
        faults.get_by_label("Kind").select_option("freeze")
        faults.get_by_label("for").fill("1000")
        faults.get_by_role("button", name="Let it fail").click()
        until(page, "document.querySelectorAll('#fault-list li').length === 2")
        found = Axe().run(page, context="#stage", options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}).response
        assert [(one["id"], [node["html"][:160] for node in one["nodes"]]) for one in found["violations"]] == []
        for left in (1, 0):
            faults.get_by_role("button", name="Clear").first.click()
            until(page, f"document.querySelectorAll('#fault-list li').length === {left}")
        assert rig.fault.list() == []
        for kind in ("dirt", "black"):
            rig.fault.set("desk", kind)
        until(page, "document.querySelectorAll('#fault-list li').length === 2")
        faults.get_by_role("button", name="Wipe").click()
        until(page, "document.querySelectorAll('#fault-list li').length === 1")
        assert [one["kind"] for one in rig.fault.list()] == ["black"]
        page.click(".tile[data-camera=lobby]")
        until(page, "document.querySelectorAll('#fault-list li').length === 0")


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_all_of_a_camera_is_shown_and_an_object_that_is_whole_is_changed_by_its_parts(rig, browser):
    camera = rig.create_camera("bent", size=(320, 240), place="lobby", lens=("plumb_bob", [-0.2, 0.05, 0, 0, 0]), outputs=["mjpeg"], mount="anna")
    rig.create_camera("plain", size=(64, 48), place="lobby")
    with opened(browser, rig.page_url) as page:
        page.click(".tile[data-camera=bent]")
        fields = page.locator("#fields")
        group = lambda name: fields.get_by_role("group", name=name, exact=True)  # noqa: E731
        shown_texts = lambda page: page.evaluate("[...document.querySelectorAll('#fields label')].map(one => one.textContent)")  # noqa: E731
        # The first controls are pose and picture in a form of their own.
        labels = "[...document.querySelectorAll('#fields label, #fields legend')].map(one => one.textContent.toLowerCase())"
        until(page, f"{labels}.some(one => one.startsWith('outputs'))")
        shown = page.evaluate(labels)
        for name in camera.get():
            own = {"name": "near", "size": "width", "fps": "frames/s", "vfov_deg": "vertical view", "pose": "pan", "hfov_deg": "horizontal"}.get(name)
            assert any(one.startswith(own or name.replace("_", " ")) for one in shown) or name in ("code_strip", "description"), (name, shown)
        assert "mjpeg" in fields.get_by_label("Outputs").text_content()
        assert f"Id {camera.get()['id']}" in shown_texts(page)

        group("Lens").get_by_label("Coefficients").fill("-0.3 0.1 0 0 0")
        page.keyboard.press("Enter")
        wait_until(lambda: camera.get()["lens"]["coefficients"] == [-0.3, 0.1, 0, 0, 0], what="the coefficients")
        assert camera.get()["lens"]["model"] == "plumb_bob"
        group("Mount").get_by_label("Node").fill("head")
        page.keyboard.press("Enter")
        wait_until(lambda: camera.get()["mount"] == {"actor": "anna", "node": "head"}, what="the node")
        mounted = group("Mount").get_by_label("Mount")
        mounted.select_option(index=0)
        wait_until(lambda: camera.get()["mount"] is None, what="the camera off its mount")
        mounted.select_option("on")
        group("Mount").get_by_label("Actor").fill("mei")
        page.keyboard.press("Enter")
        wait_until(lambda: (camera.get()["mount"] or {}).get("actor") == "mei", what="the other mount")
        # What is opened and not filled in is of this camera alone.
        mounted.select_option(index=0)
        wait_until(lambda: camera.get()["mount"] is None, what="the camera off its mount again")
        mounted.select_option("on")
        page.click(".tile[data-camera=plain]")
        until(page, "document.getElementById('stage-name').textContent === 'plain'")
        assert mounted.input_value() != "on" and group("Mount").get_by_label("Actor").is_hidden()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_sensor_is_put_in_and_set_and_what_programs_set_of_it_is_shown(rig, browser):
    """One model: what the page sets, programs that know V4L2 read, and the other way round; pictures are taken so."""
    camera = rig.create_camera("counts", size=(320, 240), fps=20, place="main", outputs=[{"kind": "device", "number": 7}])
    v4l2_ctl = lambda *arguments: subprocess.run([CAMRIG, "exec", "--control", rig.info()["control"], "--", "v4l2-ctl", "-d", "/dev/video7", *arguments],  # noqa: E731
                                                 capture_output=True, text=True, timeout=60, check=True).stdout
    sensor = lambda: camera.get()["sensor"]  # noqa: E731
    with opened(browser, rig.page_url) as page:
        page.click(".tile[data-camera=counts]")
        group = page.locator("#fields").get_by_role("group", name="Sensor", exact=True)
        field = lambda label: group.get_by_label(label, exact=True)  # noqa: E731

        def write(label, text):
            field(label).fill(text)
            page.keyboard.press("Enter")

        choice = lambda label: group.get_by_label(label).first  # noqa: E731
        choice("Sensor").select_option("on")
        wait_until(lambda: sensor() is not None, what="the sensor")
        choice("Preset").select_option("imx290")
        wait_until(lambda: sensor()["preset"] == "imx290" and sensor()["bits"] == 12, what="the preset")
        until(page, "[...document.querySelectorAll('#fields label')].find(one => one.textContent.startsWith('Full well')).querySelector('input').value === '9193'")
        # Small numbers are shown whole.
        assert field("Pixel pitch m (m)").input_value() == "0.0000029" and field("Exposure s (s)").input_value() == "0.01"
        for label, text, key, value in (("Exposure s (s)", "auto", "exposure_s", "auto"), ("Exposure s (s)", "0.004", "exposure_s", 0.004), ("Gain db (dB)", "6.5", "gain_db", 6.5),
                                        ("Focus m (m)", "4.5", "focus_m", 4.5), ("Focus m (m)", "", "focus_m", None), ("White balance (K)", "5000", "white_balance", 5000)):  # fmt: skip
            write(label, text)
            wait_until(lambda: sensor()[key] == value, what=f"{label} {text}")
        choice("Dynamic framerate").select_option("on")
        wait_until(lambda: sensor()["dynamic_framerate"], what="a rate that may fall")
        taken = camera.frame(min_ns=rig.status()["world_ns"] + 1).sensor
        assert (taken["exposure_s"], taken["gain_db"]) == (0.004, 6.5)
        read = v4l2_ctl("-C", "exposure_auto,exposure_absolute,gain,white_balance_temperature,exposure_dynamic_framerate")
        for line in ("exposure_auto: 1", "exposure_absolute: 40", "gain: 65", "white_balance_temperature: 5000", "exposure_dynamic_framerate: 1"):
            assert line in read, read

        v4l2_ctl("-c", "exposure_absolute=25,gain=120,brightness=15")
        until(page, "[...document.querySelectorAll('#fields input')].some(one => one.value === '0.0025')")
        assert field("Gain db (dB)").input_value() == "12"
        controls = page.locator("#fields").get_by_role("group", name="Controls", exact=True)
        assert controls.get_by_label("Brightness").input_value() == "0.15"
        v4l2_ctl("-c", "exposure_auto=3")
        until(page, "[...document.querySelectorAll('#fields input')].some(one => one.value === 'auto')")
        assert field("Exposure s (s)").input_value() == "auto"
        write("Exposure s (s)", "20")
        page.wait_for_selector("#messages .error")
        assert "sensor.exposure_s: must be 1e-6 to 10 s" in page.text_content("#messages")
        page.get_by_label("Dismiss this message").click()


def test_what_the_rig_refuses_is_said_in_its_own_words(rig, page):
    page.click("#create")
    page.fill("#new-camera [name=name]", "main")
    page.click("#new-camera button[value=ok]")
    page.wait_for_selector("#messages .error")
    with pytest.raises(Exception) as refused:
        rig.create_camera("main")
    assert refused.value.message in page.text_content("#messages")
    assert page.is_visible("#new-camera")
    page.keyboard.press("Escape")
    page.get_by_label("Dismiss this message").click()

    page.get_by_label("Frames/s").first.fill("5000")
    page.keyboard.press("Enter")
    page.wait_for_selector("#messages .error")
    assert "fps" in page.text_content("#messages")
    # What was refused is put back.
    until(page, "[...document.querySelectorAll('#fields label')].find(one => one.textContent.startsWith('Frames')).querySelector('input').value === '25'")


def test_what_is_typed_for_a_camera_that_is_deleted_meanwhile_is_set_of_no_other(rig, page):
    main = rig.camera("main").get()
    for label, text, left in (("z (m)", "9", "2.5"), ("Antialias", None, main["antialias"])):
        with streams_opened(page, "eye"):
            rig.create_camera("eye", size=(64, 48), place="main", antialias="ssaa2")
            page.click(".tile[data-camera=eye]")
        field = page.locator(f"#fields label:has-text('{label}')").first.locator("input, select")
        field.focus()
        if text:
            field.fill(text)
        rig.camera("eye").delete()
        until(page, "document.getElementById('stage-name').textContent === 'main'")
        page.keyboard.press("Enter")
        wait_until(lambda: field.input_value() == left, what=f"{label} of the other")
    now = rig.camera("main").get()
    assert (now["pose"], now["antialias"]) == (main["pose"], main["antialias"])
    assert rig.info()["calls"]["camera.set"] == 0


def test_cameras_and_actors_are_dragged_on_the_top_view(rig, page):
    page.wait_for_selector("#map .actor")
    camera = rig.camera("main")
    before = camera.get()["pose"]
    page.click("#map-out")  # from here on the view stands still
    scale = metres_per_pixel(page)
    drag(page, "#map .camera[data-name=main] .body", 30, -20)
    wait_until(lambda: camera.get()["pose"]["position"][0] == pytest.approx(before["position"][0] + 30 * scale, abs=2 * scale), what="x")
    wait_until(lambda: camera.get()["pose"]["position"][1] == pytest.approx(before["position"][1] + 20 * scale, abs=2 * scale), what="y")
    assert camera.get()["pose"]["position"][2] == before["position"][2]

    drag(page, "#map .camera[data-name=main] .handle", 0, -60)
    wait_until(lambda: camera.get()["pose"]["pan_deg"] > before["pan_deg"] + 15, what="the turn to the left")
    assert camera.get()["pose"]["tilt_deg"] == pytest.approx(before["tilt_deg"])

    actor = rig.actors()[0]
    drag(page, f"#map .actor[data-name={actor['name']}] .body", -40, 0)
    wait_until(lambda: rig.actors()[0]["position"][0] == pytest.approx(actor["position"][0] - 40 * scale, abs=2 * scale), what="the actor")

    page.focus("#map .camera[data-name=main]")
    x = camera.get()["pose"]["position"][0]
    page.keyboard.press("ArrowRight")
    wait_until(lambda: camera.get()["pose"]["position"][0] == pytest.approx(x + 0.25), what="the key")
    page.keyboard.press("PageDown")
    assert page.evaluate("document.activeElement.dataset.name") == actor["name"]


def test_a_carried_camera_is_shown_where_it_is_and_is_not_dragged(rig, page):
    page.wait_for_selector("#map .actor")
    actor = rig.actors()[0]
    rig.create_camera("carried", size=(64, 48), mount={"actor": actor["name"]}, position=(0, 0, 1), look_at=(5, 0, 1))
    page.wait_for_selector("#map .camera[data-name=carried]")
    page.click("#map-out")
    one, other = (middle(page, f"#map .{kind}[data-name={name}] .body") for kind, name in (("camera", "carried"), ("actor", actor["name"])))
    assert np.hypot(one[0] - other[0], one[1] - other[1]) < 8
    before = rig.camera("carried").get()["pose"]
    drag(page, "#map .camera[data-name=carried] .body", 30, -20)
    page.focus("#map .camera[data-name=carried]")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("r")  # a key that does turn it, and comes after
    wait_until(lambda: rig.camera("carried").get()["pose"] != before, what="the turn")
    after = rig.camera("carried").get()["pose"]
    assert after["position"] == before["position"] and after["pan_deg"] == pytest.approx(before["pan_deg"] + 5)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_the_truth_lies_where_truth_get_says(rig, page):
    rig.step(seconds=0.2)
    page.click("#truth")
    page.wait_for_selector("#overlay[data-boxes]")
    truth = rig.camera("lobby").truth()
    until(page, f"document.getElementById('overlay').dataset.sequence === '{truth['sequence']}'")
    drawn = {name: box for name, *box in page.evaluate("JSON.parse(document.getElementById('overlay').dataset.boxes)")}
    people = {one["name"]: one["box"] for one in truth["objects"] if one["class"] == "person" and one["box"]}
    assert len(people) >= 3
    for name, box in people.items():
        assert drawn[name] == box
        assert name in page.get_attribute("#overlay", "aria-label")
    # The lower left corner of the box is drawn there and nothing is drawn where no box is.
    name, (x, y, w, h) = max(people.items(), key=lambda one: one[1][3])
    alpha = """([x, y]) => { const copy = new OffscreenCanvas(1, 1).getContext('2d');
        copy.drawImage(document.getElementById('overlay'), -x, -y); return copy.getImageData(0, 0, 1, 1).data[3]; }"""
    assert page.evaluate(alpha, [x, y + h]) > 100
    assert page.evaluate(alpha, [2, 470]) == 0
    # A step brings another truth, of the frame that is shown.
    page.click("#step")
    until(page, f"Number(document.getElementById('overlay').dataset.sequence) > {truth['sequence']}")
    page.click("#truth")
    assert page.get_attribute("#overlay", "data-boxes") is None


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_in_lockstep_a_camera_that_is_changed_while_its_stream_is_being_opened_is_shown_as_it_is_then(page):
    until(page, "document.getElementById('picture').dataset.frames > 0")
    opened_streams = page.evaluate("""async () => {
        const { LiveReader } = await import('./live.js');
        const asked = [], shown = [];
        const really = window.fetch;
        window.fetch = (url, options) => url.startsWith('live?cameras=mine') ? new Promise((answer) => asked.push(answer)) : really(url, options);
        const part = 'Content-Type: image/jpeg\\r\\nContent-Length: 1\\r\\nX-Camera: mine\\r\\nX-Sequence: 7\\r\\n\\r\\n.';
        const reader = new LiveReader((picture) => shown.push(picture), () => {});
        const looks = (fov_deg) => reader.want([{ name: 'mine', sequence: 7, fov_deg }], 'q=80');
        looks(50);
        looks(60);  // the rig drew what it is about to send before that
        asked[0](new Response(new ReadableStream({ start(stream) { stream.enqueue(new TextEncoder().encode(part)); } })));
        while (!shown.length) await new Promise((later) => setTimeout(later, 10));
        for (let look = 0; look < 5; ++look) looks(60);
        window.fetch = really;
        reader.want([], '');
        return asked.length;
    }""")
    assert opened_streams == 2, "one that shows what it was, and one more, that shows what it is"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_time_stands_still_and_goes_by_steps_and_events_are_told(rig, page):
    page.click("#run")
    wait_until(lambda: rig.status()["paused"], what="the pause")
    then = rig.status()["world_ns"]
    page.fill("#step-seconds", "0.4")
    page.click("#step")
    wait_until(lambda: rig.status()["world_ns"] == then + 400_000_000, what="the step")
    page.click("#run")
    wait_until(lambda: not rig.status()["paused"], what="that it runs")

    for level in (1, 2):
        page.fill("#fire [name=data]", f'{{"level": {level}}}')
        page.click("#fire button")
        until(page, f"document.getElementById('feed').textContent.includes('{{\"level\":{level}}}')")
    page.fill("#fire [name=data]", "{")
    page.click("#fire button")
    page.wait_for_selector("#messages .error")
    assert "not JSON" in page.text_content("#messages")

    page.click("#events summary")
    page.fill("#add-event [name=name]", "tick")
    page.fill("#add-event [name=when]", '{"every_s": 0.5}')
    page.click("#add-event button")
    until(page, "[...document.querySelectorAll('#feed b')].filter(one => one.textContent === 'tick').length >= 2")
    page.get_by_label("Remove rule tick").click()
    wait_until(lambda: "tick" not in [event["name"] for event in rig.events()], what="the rule's end")


def test_after_an_error_each_event_is_told_once_and_none_of_a_rig_that_is_gone(rig, page):
    """What waits for events is answered in the rig's stead: by an error, then as another rig does."""
    other = {"sequence": 1, "event": "other", "world_ns": 0, "actor": "", "data": [], "errors": []}
    answers = []

    def answer(route):
        if not answers or "event.wait" not in (route.request.post_data or ""):
            route.fallback()
        elif told := answers.pop(0):
            route.fulfill(json={"jsonrpc": "2.0", "id": 1, **told})

    page.route("**/rpc", answer)
    lines = "[...document.querySelectorAll('#feed li')].map(one => one.textContent.trim()).join('; ')"
    feed = lambda *levels: "; ".join(f'0.00 event.act {{"level":{level}}}' for level in levels)  # noqa: E731
    fire = lambda level: rig.act({"action": "user", "data": {"level": level}})  # noqa: E731
    fire(1)
    until(page, f"{lines} === '{feed(1)}'")
    answers.append({"error": {"code": -32000, "message": "gone"}})
    fire(2)  # the next question is answered by the error
    until(page, f"{lines} === '{feed(2, 1)}'")
    for _ in range(100):
        if not answers:
            break
        page.wait_for_timeout(50)
    fire(3)
    until(page, f"{lines} === '{feed(3, 2, 1)}'")
    # The last is never answered.
    answers.extend([{"error": {"code": -32000, "message": "gone"}}, {"result": {"events": [other], "last": 1, "missed": 0}}, None])
    fire(4)
    until(page, f"{lines} === '0.00 other'")
    page.unroute_all(behavior="ignoreErrors")


def test_two_clients_that_change_the_same_camera_see_the_same_end(rig, page):
    camera = rig.camera("main")
    page.focus("#view")
    for step in range(6):
        page.keyboard.press("ArrowLeft")
        camera.set(fps=10 + step, position=(-6, step / 10, 2.5), look_at=(0, 0, 0.4))
    # Both have been answered (the page wishes for no pose any more): what the rig has now is the end, and all see it.
    until(page, """import('/steer.js').then(steer =>
        steer.poseOf({name: 'main', pose: {position: [], pan_deg: 'none wished'}}).pan_deg === 'none wished')""")
    end = camera.get()
    listed = subprocess.run([str(_camrig()), "camera", "get", "main", "--json", "--control", rig.info()["control"]],
                            check=True, capture_output=True, text=True, timeout=30)
    assert f'"pan_deg":{end["pose"]["pan_deg"]}'.replace(" ", "") in listed.stdout.replace(" ", "")
    shown = "[...document.querySelectorAll('#fields label')].find(one => one.textContent.startsWith('{}')).querySelector('input').value"
    for label, value in (("y (m)", end["pose"]["position"][1]), ("Pan", end["pose"]["pan_deg"]), ("Frames", end["fps"])):
        until(page, f"Math.abs(Number({shown.format(label)}) - {value}) < 0.006")
    assert camera.get()["pose"] == end["pose"]


def _camrig():
    from camrig.launch import find_binary
    return find_binary()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_hidden_page_costs_nothing(rig, page):
    def work():
        stats = rig.stats()
        return [(camera["rendered"], sum(output["encoded"] for output in camera["outputs"])) for camera in stats["cameras"]]

    def readers():
        return sum(camera.get()["readers"] for camera in rig.cameras())

    wait_until(lambda: readers() >= 2, what="the streams")
    page.evaluate("""Object.defineProperty(document, 'hidden', {value: true, configurable: true});
                     document.dispatchEvent(new Event('visibilitychange'))""")
    wait_until(lambda: readers() == 0, what="the streams' end")
    wait_until(lambda: all(not camera["outputs"] for camera in rig.stats()["cameras"]), what="the encoders' end")

    def rests_for_a_second():
        nonlocal calls
        calls, before = rig.info()["calls"], work()
        page.wait_for_timeout(1000)
        return work() == before

    calls = {}
    wait_until(rests_for_a_second, what="an end of what was being drawn when the page was hidden")
    # Nor does it ask anything.
    now = rig.info()["calls"]
    for method in ("world.status", "camera.list", "actor.list", "truth.get", "event.wait"):
        assert now.get(method, 0) == calls.get(method, 0), method
    page.evaluate("""Object.defineProperty(document, 'hidden', {value: false, configurable: true});
                     document.dispatchEvent(new Event('visibilitychange'))""")
    wait_until(lambda: readers() >= 2, what="the streams")
    seen = pixels(page)
    wait_for_picture(page, seen, 0.05)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_twelve_live_pictures_and_the_controls_still_answer(rig, browser):
    for number in range(11):
        rig.create_camera(f"eye_{number}", place="above" if number % 2 else "main", size=(320, 240), fps=15)
    with opened(browser, rig.page_url, viewport={"width": 1600, "height": 1500}) as page:
        until(page, "document.querySelectorAll('.tile canvas[data-frames]').length === 12")
        frames = "Object.fromEntries([...document.querySelectorAll('.tile')].map(one => [one.dataset.camera, Number(one.querySelector('canvas').dataset.frames)]))"
        then = page.evaluate(frames)
        assert len(then) == 12
        # Every one goes on, ten pictures further, while the others do.
        wait_until(lambda: all(now >= then[name] + 10 for name, now in page.evaluate(frames).items()), what="12 live pictures")
        page.click(".tile[data-camera=eye_3]")
        page.focus("#view")
        pan = rig.camera("eye_3").get()["pose"]["pan_deg"]
        page.keyboard.press("ArrowLeft")
        wait_until(lambda: rig.camera("eye_3").get()["pose"]["pan_deg"] == pytest.approx(pan + 4), what="an answer")


def test_instants_with_dropped_pictures_are_counted_under_rates(rig, page):
    rig.step(seconds=0.2)
    instants = rig.stats()["instants"]
    until(page, f"document.querySelector('#rate-table caption')?.textContent.startsWith('{instants} instants, 0 with dropped pictures. ')")


def test_links_lead_to_the_camera(rig, browser):
    rig.create_camera("door", size=(320, 240), outputs=[{"kind": "device", "number": 9}])
    with opened(browser, rig.page_url) as page:
        page.click(".tile[data-camera=door]")
        until(page, "document.getElementById('link-list').textContent.includes('/door')")
        links = page.eval_on_selector_all("#link-list dd code", "all => all.map(one => one.textContent)")
        assert rig.camera("door").url() in links
        assert f'cv2.VideoCapture("{rig.camera("door").url()}")' in links
        assert f"{rig.rtsp_url}/door" in links
        assert "/dev/video9" in links
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.get_by_label("Copy MJPEG").click()
        page.wait_for_selector("#messages .note")
        assert page.evaluate("navigator.clipboard.readText()") == rig.camera("door").url()


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_on_a_phone_nothing_needs_sideways_scrolling(rig, browser, tmp_path):
    with opened(browser, rig.page_url, viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True) as page:
        page.wait_for_selector("#map .actor")
        page.screenshot(path=str(tmp_path / "phone.png"), full_page=True)
        assert page.evaluate("[document.documentElement.scrollWidth, innerWidth]") == [360, 360]
        page.get_by_label("Pan left").tap()
        wait_until(lambda: rig.camera("lobby").get()["pose"]["pan_deg"] > 34, what="the touch")


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_every_control_has_a_name_a_place_in_the_order_of_keys_and_enough_contrast(rig, page):
    from axe_playwright_python.sync_playwright import Axe

    page.wait_for_selector("#map .actor")
    page.click("#events summary")
    found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}).response
    assert [(one["id"], [node["html"][:160] for node in one["nodes"]]) for one in found["violations"]] == []
    assert len(found["passes"]) > 10
    page.click("#create")
    dialog = Axe().run(page, context="#new-camera").response
    assert [(one["id"], one["nodes"][0]["html"][:160]) for one in dialog["violations"]] == []
    page.keyboard.press("Escape")
    # Everything that can be pressed or filled is reached by the tabulator, and is seen to be.
    controls = page.evaluate("[...document.querySelectorAll('button, input, select, textarea')].filter(one => one.checkVisibility() && !one.disabled).length")
    page.evaluate("document.activeElement.blur()")
    reached = set()
    for _ in range(controls + 40):
        page.keyboard.press("Tab")
        where = page.evaluate("""() => { const one = document.activeElement; if (one === document.body) return null;
            one.dataset.reached = '1'; const style = getComputedStyle(one);
            return [one.tagName, one.getAttribute('aria-label') || one.textContent || one.name, style.outlineStyle !== 'none' || one.closest('svg') !== null]; }""")
        if where:
            assert where[2], f"{where[:2]} has the focus and does not show it"
            reached.add(tuple(where[:2]))
    missed = page.evaluate("[...document.querySelectorAll('button, input, select, textarea')].filter(one => one.checkVisibility() && !one.disabled && !one.dataset.reached).map(one => one.outerHTML.slice(0, 100))")
    assert missed == []
    # Nor has any control an empty name in the browser's own tree for screen readers.
    unnamed = page.evaluate("[...document.querySelectorAll('button')].filter(one => one.checkVisibility() && !(one.getAttribute('aria-label') || one.textContent.trim())).length")
    assert unnamed == 0


def test_without_the_key_the_page_looks_and_says_how_to_command(rig, browser):
    with opened(browser, rig.http_url) as page:
        page.focus("#view")
        page.keyboard.press("ArrowLeft")
        page.wait_for_selector("#messages .error")
        assert "#key=" in page.text_content("#messages")
        pan = rig.camera("main").get()["pose"]["pan_deg"]
        # The printed link in the same tab: only the part after # is new, so nothing is loaded again.
        page.goto(rig.page_url)
        until(page, "location.hash === ''")
        page.focus("#view")
        page.keyboard.press("ArrowLeft")
        wait_until(lambda: rig.camera("main").get()["pose"]["pan_deg"] == pytest.approx(pan + 4), what="the pan")
        page.reload()
        assert "key" not in page.url
        page.wait_for_selector("#stage[aria-labelledby] #picture[data-frames]")
        page.focus("#view")
        page.keyboard.press("ArrowLeft")
        wait_until(lambda: rig.camera("main").get()["pose"]["pan_deg"] == pytest.approx(pan + 8), what="the pan after a reload")


def test_a_page_of_another_origin_can_neither_steer_nor_read(rig, browser, tmp_path):
    import http.server
    import threading

    class Silent(http.server.SimpleHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!DOCTYPE html><title>elsewhere</title>")

        def log_message(self, *arguments):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Silent) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://localhost:{other.server_port}/")
        body = '{"jsonrpc":"2.0","id":1,"method":"camera.delete","params":{"name":"main"}}'
        for mode, kind in (("cors", "application/json"), ("no-cors", "text/plain"), ("cors", "text/plain")):
            outcome = page.evaluate(
                """([url, mode, kind, body]) => fetch(url, {method: 'POST', mode, body, headers: {'Content-Type': kind}})
                   .then(reply => reply.type + reply.status, () => 'refused')""", [f"{rig.http_url.rstrip('/')}/rpc", mode, kind, body])
            assert outcome in ("refused", "opaque0"), (mode, kind)
        for path in ("cameras", "live?cameras=main", "cameras/main/truth"):
            read = page.evaluate("url => fetch(url).then(() => 'read', () => 'refused')", f"{rig.http_url.rstrip('/')}/{path}")
            assert read == "refused", path
        page.close()
        other.shutdown()
    assert [camera.name for camera in rig.cameras()] == ["main"]


def test_a_rebound_name_gets_nothing(rig, browser):
    """A foreign page whose name was re-bound to 127.0.0.1 is of our origin for the browser; only the Host tells."""
    from web_page import ARGUMENTS, CHROMIUM

    port = rig.http_url.rstrip("/").rsplit(":", 1)[1]
    rebound = browser.browser_type.launch(executable_path=CHROMIUM, args=[*ARGUMENTS, "--host-resolver-rules=MAP evil.example 127.0.0.1"])
    page = rebound.new_page()
    reply = page.goto(f"http://evil.example:{port}/")
    assert reply.status == 403
    status = page.evaluate("""fetch('/rpc', {method: 'POST', headers: {'Content-Type': 'application/json'},
        body: '{"jsonrpc":"2.0","id":1,"method":"camera.delete","params":{"name":"main"}}'}).then(reply => reply.status)""")
    assert status == 403
    rebound.close()
    assert [camera.name for camera in rig.cameras()] == ["main"]


def test_with_a_token_the_page_works_and_hides_it_and_without_it_nothing_does(browser, tmp_path):
    token = tmp_path / "token"
    token.write_text("a-token-of-the-test\n")
    with camrig.start(str(REPOSITORY / "scenes" / "minimal.json"), mode="lockstep", args=["--token-file", str(token)]) as rig:
        bare = browser.new_page()
        assert bare.goto(rig.http_url).status == 401
        assert bare.request.post(f"{rig.http_url.rstrip('/')}/rpc", data={"jsonrpc": "2.0", "id": 1, "method": "camera.list"}).status == 401
        assert bare.request.get(f"{rig.http_url.rstrip('/')}/live?cameras=main").status == 401
        bare.close()
        with opened(browser, f"{rig.http_url.rstrip('/')}/?token=a-token-of-the-test") as page:
            assert "token" not in page.url
            links = page.text_content("#link-list")
            assert "?token=TOKEN" in links and "a-token-of-the-test" not in links
            page.focus("#view")
            pan = rig.camera("main").get()["pose"]["pan_deg"]
            page.keyboard.press("ArrowLeft")
            wait_until(lambda: rig.camera("main").get()["pose"]["pan_deg"] == pytest.approx(pan + 4), what="the pan")
            assert page.evaluate("document.cookie") == ""
