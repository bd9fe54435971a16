"""The web page of photos: from a user's photo to a scene file that runs, in a headless Chromium as a person does it."""

import contextlib
import json
import math
import os
import subprocess

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until
from web_page import chromium, held, let_go, until

CAMRIG = os.environ["CAMRIG_BIN"]
SIZE = (1280, 960)


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    """The shipped street with nobody in it, as a photo, and its camera as the rig knows it."""
    file = tmp_path_factory.mktemp("photo") / "My Corner.png"
    with camrig.start("street", mode="lockstep", seed=5) as rig:
        for actor in rig.actors():
            rig.remove_actor(actor["name"])
        true = rig.create_camera("true", place="corner", size=SIZE, fps=25)
        rig.step(seconds=0.04)
        cv2.imwrite(str(file), true.frame().image)
        return file, true.K, true.world_from_camera


class Plate:
    """The page: clicks at pixels of the photo, not of the screen."""

    def __init__(self, page, known):
        self.page, (self.K, self.world) = page, known

    def place(self, px):
        view = json.loads(self.page.get_attribute("#plate", "data-view"))
        box = self.page.locator("#plate").bounding_box()
        return [box[side] + (value + 0.5) * view["scale"] + view[side] for side, value in zip("xy", px)]

    def tool(self, value):
        self.page.check(f"#tools [value={value}]")

    def click(self, *pixels):
        for px in pixels:
            self.page.mouse.click(*self.place(px))

    def drag(self, px, to):
        self.page.mouse.move(*self.place(px))
        self.page.mouse.down()
        for part in (0.3, 0.7, 1.0):
            self.page.mouse.move(*self.place([a + part * (b - a) for a, b in zip(px, to)]))
        self.page.mouse.up()

    def ground(self, px):
        """Where the true camera sees the ground."""
        ray = self.world[:3, :3] @ np.linalg.inv(self.K) @ [*px, 1]
        return (self.world[:3, 3] - ray * self.world[2, 3] / ray[2])[:2]

    def pixel(self, m):
        seen = self.K @ (np.linalg.inv(self.world) @ [*m, 1])[:3]
        return seen[:2] / seen[2]

    def add_points(self, *pixels):
        """Clicks at places of the ground and tells where they are."""
        self.tool("point")
        for px in pixels:
            number = self.page.locator("#points li").count() + 1
            self.click(px)
            for axis, value in zip("xy", self.ground(px)):
                self.page.get_by_label(f"point {number}: {axis} (m)").fill(f"{value:.3f}")
            self.page.keyboard.press("Enter")

    def calibrate(self):
        self.page.click("#calibrate")

    def settle(self):
        """Until the page has done what answers that have come bring: an answer and a picture that are asked for now come after them."""
        self.page.evaluate("import('/rpc.js').then(({call}) => call('world.status')).then(() => fetch('cameras/main/snapshot.png'))"
                           ".then((reply) => reply.blob()).then(createImageBitmap).then(() => {})")


@contextlib.contextmanager
def plate_page(rig, browser, photo):
    context = browser.new_context(viewport={"width": 1440, "height": 1000}, accept_downloads=True)
    page = context.new_page()
    page.set_default_timeout(20_000)
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    try:
        page.goto(rig.page_url)  # the key comes with the printed link, and stays with the tab
        page.click("header a[href='plate.html']")
        page.set_input_files("#photo-file", str(photo[0]))
        until(page, "document.getElementById('photo-facts').textContent === 'My Corner.png · 1280×960'")
        until(page, "document.getElementById('plate').dataset.view !== undefined")
        yield Plate(page, photo[1:])
    finally:
        context.close()
    assert said == [], said


@pytest.fixture
def opened_plate(rig, browser, photo):
    with plate_page(rig, browser, photo) as plate:
        yield plate


CLICKS = [(150, 900), (1100, 880), (300, 700), (1000, 600)]


def test_a_photo_becomes_a_scene_that_runs(rig, opened_plate, photo, tmp_path):
    plate, page = opened_plate, opened_plate.page
    plate.add_points(*CLICKS)
    page.get_by_label("Error of a click (px)").fill("1")
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera")
    found = json.loads(page.get_attribute("#answer", "data-camera"))

    # The very answer of the method, and the camera that took it, as sure as it says it is.
    points = [{"px": [float(page.get_by_label(f"point {n}: Point {axis} (px)").input_value()) for axis in "uv"],
               "m": [float(page.get_by_label(f"point {n}: {axis} (m)").input_value()) for axis in "xyz"]} for n in range(1, 5)]
    for px, point in zip(CLICKS, points):
        assert point["px"] == pytest.approx(px, abs=1.5)
    told = rig.calibrate_plate(SIZE, points=points, click_px=1)
    assert found == told["camera"]
    half = told["half_95"]
    assert (np.abs(np.array(found["pose"]["position"]) - plate.world[:3, 3]) <= 1.5 * np.array(half["position"])).all()
    assert abs(found["intrinsics"]["fx"] - plate.K[0, 0]) <= 1.5 * half["focal_px"]
    assert page.text_content("#verdict") == told["reason"]
    assert "±" in page.text_content("#answer")
    for n, residual in enumerate(told["residuals"], 1):
        assert page.locator(f"#points li:nth-child({n}) output").text_content() == f"{residual['px']:.2f} px"

    # The figure goes where it is dragged, and is as tall there as a person of 1.75 m.
    until(page, "JSON.parse(document.getElementById('plate').dataset.standing ?? '[]').length === 2")
    standing = lambda: json.loads(page.get_attribute("#plate", "data-standing"))  # noqa: E731
    plate.drag(standing()[0], (420, 640))
    wait_until(lambda: standing()[0] == pytest.approx((420, 640), abs=2), what="the figure")
    x, y, _ = json.loads(page.get_attribute("#plate", "data-place"))
    assert (x, y) == pytest.approx(plate.ground((420, 640)), abs=2 * told["ground_m_95"])
    foot, head = standing()
    assert foot[1] - head[1] == pytest.approx(plate.pixel((x, y, 0))[1] - plate.pixel((x, y, 1.75))[1], rel=0.03)

    # Shapes: people may walk in one piece of ground, and go behind the others.
    walkable = [(200, 900), (1080, 900), (900, 620), (380, 620)]
    plate.tool("walkable")
    plate.click(*walkable)
    page.click("#done")
    plate.tool("obstacle")
    plate.click((560, 760), (700, 760), (690, 730), (570, 730))
    page.click("#done")
    page.get_by_label("Height of shape 2 (m)").fill("1.1")
    page.keyboard.press("Enter")
    plate.tool("wall")
    plate.click((100, 600), (330, 590))
    page.focus("#plate")
    page.keyboard.press("Enter")
    plate.tool("cutout")
    plate.click((800, 500), (830, 500), (830, 660), (800, 660), (815, 660))
    page.click("#done")
    assert page.locator("#shapes li").count() == 4
    plate.drag(walkable[0], (220, 890))
    until(page, "document.querySelector('#shapes input:nth-of-type(2)').value.startsWith('220,890 ') || "
                "Math.abs(Number(document.querySelector('#shapes input:nth-of-type(2)').value.split(',')[0]) - 220) < 1.5")

    # Light by sliders.
    for name, value in (("azimuth_deg", 210), ("elevation_deg", 35), ("sun", 0.5)):
        page.locator(f"#light [name={name}]").fill(str(value))
    until(page, "document.querySelector('#light output[data-of=sun]').textContent === '× 0.50'")

    page.fill("#save [name=name]", "gate")
    page.fill("#save [name=width]", "640")
    page.fill("#save [name=people]", "4")
    wait_until(lambda: page.locator("#light [name=elevation_deg]").input_value() == "35", what="the sun")
    with page.expect_download() as waiting:
        page.click("#save button.main")
    assert waiting.value.suggested_filename == "gate.json"
    waiting.value.save_as(tmp_path / "gate.json")
    scene = json.loads((tmp_path / "gate.json").read_text())
    assert page.input_value("#scene") == (tmp_path / "gate.json").read_text()
    sun = scene["lights"][0]
    light = rig.plate_light(sun=[210, 35])
    assert sun["direction"] == light["lights"][0]["direction"] and sun["intensity"] == pytest.approx(0.5 * light["lights"][0]["intensity"])
    (camera,) = scene["cameras"]
    assert (camera["name"], camera["size"], camera["backdrop"]["file"]) == ("my_corner", [640, 480], "My Corner.png")
    proxies = camera["backdrop"]["proxies"]
    assert [len(proxies[key]) for key in ("boxes", "cutouts", "walkable")] == [2, 1, 1]
    box, wall = proxies["boxes"]
    assert box["size"][2] == 1.1 and box["position"][:2] == pytest.approx(plate.ground((630, 745)), abs=0.5)
    ends = np.array([plate.ground((100, 600)), plate.ground((330, 590))])
    assert wall["size"][0] == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=0.05) and wall["size"][2] == 3
    assert wall["position"][:2] == pytest.approx(ends.mean(0), abs=0.06 + 2 * told["ground_m_95"])

    # The program takes it and runs it: people of their size walk where they may.
    (tmp_path / photo[0].name).write_bytes(photo[0].read_bytes())
    checked = subprocess.run([CAMRIG, "check", str(tmp_path / "gate.json")], capture_output=True, text=True, timeout=60, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    with camrig.start(str(tmp_path / "gate.json"), mode="lockstep") as mine:
        mine.step(seconds=2)
        gate = mine.camera("my_corner")
        assert gate.get()["backdrop"]["picture_size"] == list(SIZE)
        people = [one for one in gate.truth()["objects"] if one["class"] == "person"]
        assert len(people) == 4 and len(mine.actors()) == 4
        seen = [one for one in people if one["box_full"] and not one["truncated"]]
        assert seen
        for one in seen:
            near = np.array([*one["position"][:2], 0])
            tall = abs(plate.pixel(near)[1] - plate.pixel(near + [0, 0, one["dimensions"][2]])[1]) / 2  # the stream is half as large
            assert one["box_full"][3] == pytest.approx(tall, rel=0.15)  # feet have a length


def test_what_is_wrong_is_said_where_it_is(rig, opened_plate):
    plate, page = opened_plate, opened_plate.page
    problem = lambda row: page.locator(f"{row} .problem").text_content()  # noqa: E731
    plate.calibrate()
    until(page, "document.getElementById('problem').textContent.startsWith('points: none are given')")
    plate.add_points(*CLICKS, (640, 800))
    plate.tool("point")
    plate.click((700, 700))
    plate.calibrate()
    until(page, "document.getElementById('problem').textContent === 'See points[5].'")
    assert problem("#points li:nth-child(6)") == "points[5].m: give x and y in metres"
    page.get_by_label("Remove point 6").click()
    # The third was given a place 3 m away: the rig names it.
    x = page.get_by_label("point 3: x (m)")
    good = x.input_value()
    x.fill(str(float(good) + 3))
    page.keyboard.press("Enter")
    page.get_by_label("Error of a click (px)").fill("1")
    plate.calibrate()
    until(page, "document.querySelector('#points li:nth-child(3) .problem').textContent.startsWith('points[2]: is ')")
    assert x.get_attribute("aria-invalid") == "true"
    x.fill("much")
    page.keyboard.press("Enter")
    until(page, "document.querySelector('#points li:nth-child(3) .problem').textContent.includes(\"'much' is not a number\")")
    x.fill(good)
    page.keyboard.press("Enter")
    page.get_by_label("Vertical view (°)").fill("200")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.querySelector('[data-problem=vfov_deg]').textContent.startsWith('vfov_deg: ')")
    page.get_by_label("Vertical view (°)").fill("")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera && !document.getElementById('problem').textContent")
    # A corner over the horizon, and no file is made of it.
    plate.tool("walkable")
    plate.click((200, 900), (1080, 900), (640, 20))
    page.click("#done")
    until(page, "document.querySelector('#shapes .problem').textContent === 'corner 3 is over the horizon of the ground'")
    page.click("#save button.main")
    page.wait_for_selector("#messages .error")
    assert "shape 1: corner 3 is over the horizon" in page.text_content("#messages")
    assert page.is_hidden("#scene")


def test_heights_lines_and_a_shadow_do_too_and_all_by_keys(rig, opened_plate):
    """Nothing needs a mouse: a cross goes about by arrow keys, space clicks."""
    plate, page = opened_plate, opened_plate.page
    plate.tool("height")
    page.focus("#plate")
    for key in ["Shift+ArrowLeft"] * 3 + [" "] + ["ArrowUp"] * 10 + [" "]:
        page.keyboard.press(key)
    assert [page.get_by_label(f"height 1: {end} {axis} (px)").input_value() for end in ("Foot", "Head") for axis in "uv"] == ["637", "480", "637", "380"]
    page.get_by_label("Remove height 1").click()
    # The focal length is known, people of known height stand about, and the camera's height follows.
    plate.add_points(*CLICKS)
    plate.tool("line_z")
    post = plate.ground((500, 620))
    plate.click(plate.pixel((*post, 0)), plate.pixel((*post, 2)))
    plate.tool("height")
    plate.click(plate.pixel((*post, 0)), plate.pixel((*post, 2.2)))
    page.get_by_label("height 1: Height (m)").fill("2.2")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera")
    residuals = page.eval_on_selector_all("#points output, #heights output, #lines output", "all => all.map(one => one.textContent)")
    assert len(residuals) == 6 and all(float(one.removesuffix(" px")) < 2 for one in residuals)
    # The sun, from the shadow that a post of 2 m would throw.
    light = rig.plate_light(sun=[250, 30])
    direction = np.array(light["lights"][0]["direction"])
    top = np.array([*post, 2.0])
    plate.tool("shadow")
    plate.click(plate.pixel(top), plate.pixel((*post, 0)), plate.pixel(top - direction * 2 / direction[2]))
    until(page, "Math.abs(document.querySelector('#light [name=azimuth_deg]').value - 250) < 4 && Math.abs(document.querySelector('#light [name=elevation_deg]').value - 30) < 3")
    page.fill("#light [name=time]", "2026-06-21T13:08:00+02:00")
    page.fill("#light [name=place]", "52.5, 13.4")
    page.keyboard.press("Enter")
    until(page, "document.querySelector('#light output[data-of=azimuth_deg]').textContent === '180°' && document.querySelector('#light output[data-of=elevation_deg]').textContent === '61°'")


def test_the_photo_of_a_camera_of_the_rig_is_shown_with_its_lens(rig, opened_plate, photo, tmp_path):
    """Its stream is half as large as its photo: all pixels are the photo's, as in its backdrop."""
    plate, page = opened_plate, opened_plate.page
    camera = rig.create_camera("gate", size=(640, 480), position=(0, 0, 4), tilt_deg=-15, pan_deg=0, vfov_deg=50, lens=("plumb_bob", [-0.2, 0.03, 0, 0, 0]),
                               backdrop={"file": str(photo[0]), "plate_gain": [0.9, 1, 1.1], "proxies": {"ground": {"polygon_m": [[3, -12], [40, -12], [40, 12], [3, 12]]}}})
    page.reload()
    until(page, "[...document.getElementById('photo-camera').options].some(one => one.value === 'gate')")
    page.select_option("#photo-camera", "gate")
    until(page, "document.getElementById('photo-facts').textContent === 'My Corner.png · 1280×960'")
    until(page, "JSON.parse(document.getElementById('plate').dataset.standing ?? '[]').length === 2")
    plate.tool("figure")
    plate.click((260, 700))
    standing = lambda: json.loads(page.get_attribute("#plate", "data-standing"))  # noqa: E731
    wait_until(lambda: standing()[0] == pytest.approx((260, 700), abs=1.5), what="the figure")
    place = json.loads(page.get_attribute("#plate", "data-place"))
    foot, head = camera.project(np.array([place, [*place[:2], 1.75]], float))
    for shown, of_rig in zip(standing(), (foot, head)):
        assert shown == pytest.approx(2 * (of_rig + 0.5) - 0.5, abs=0.01)
    was = camera.get()
    page.fill("#save [name=people]", "1")
    page.click("#copy")
    until(page, "document.getElementById('scene').value")
    scene = json.loads(page.input_value("#scene"))
    backdrop = scene["cameras"][0]["backdrop"]
    assert backdrop["proxies"] == {"ground": camera.get()["backdrop"]["proxies"]["ground"]}
    assert (backdrop["file"], backdrop["plate_gain"]) == ("My Corner.png", [0.9, 1, 1.1])
    assert scene["actors"][0]["position"][:2] == pytest.approx(place[:2])
    assert math.isclose(backdrop["intrinsics"]["fx"], 2 * camera.get()["intrinsics"]["fx"])
    (tmp_path / "My_Corner.json").write_text(json.dumps(scene))
    (tmp_path / photo[0].name).write_bytes(photo[0].read_bytes())
    checked = subprocess.run([CAMRIG, "check", str(tmp_path / "My_Corner.json")], capture_output=True, text=True, timeout=60, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr

    # What is drawn is the camera's at once, beside what it had.
    plate.tool("obstacle")
    plate.click((560, 760), (700, 760), (690, 730), (570, 730))
    page.click("#done")
    page.click("#apply")
    until(page, "document.getElementById('messages').textContent.includes('camera gate has it')")
    (box,) = camera.get()["backdrop"]["proxies"]["boxes"]
    assert box["size"][2] == 1 and camera.get()["backdrop"]["proxies"]["ground"] == backdrop["proxies"]["ground"]
    for of, key in (("pose", "position"), ("pose", "orientation"), ("lens", "coefficients")):
        assert camera.get()[of][key] == pytest.approx(was[of][key])
    assert camera.get()["intrinsics"] == pytest.approx(was["intrinsics"])


def test_a_shape_has_the_role_that_was_chosen(rig, opened_plate, photo):
    """What catches or hides only is so in the file and in the camera of the rig; what is walkable is no shape."""
    plate, page = opened_plate, opened_plate.page
    camera = rig.create_camera("roles", size=(640, 480), position=(0, 0, 4), tilt_deg=-15, pan_deg=0, vfov_deg=50,
                               backdrop={"file": str(photo[0]), "proxies": {"ground": {"polygon_m": [[3, -12], [40, -12], [40, 12], [3, 12]], "role": "holdout"}}})
    page.reload()
    until(page, "[...document.getElementById('photo-camera').options].some(one => one.value === 'roles')")
    page.select_option("#photo-camera", "roles")
    until(page, "JSON.parse(document.getElementById('plate').dataset.standing ?? '[]').length === 2")
    assert page.get_by_label("Level ground").input_value() == "holdout"
    for tool, corners in (("walkable", [(200, 900), (1080, 900), (900, 620)]), ("obstacle", [(560, 760), (700, 760), (690, 730), (570, 730)]),
                          ("wall", [(100, 700), (330, 690)]), ("cutout", [(800, 500), (830, 500), (830, 660), (815, 660)])):
        plate.tool(tool)
        plate.click(*corners)
        page.click("#done")
    assert [page.get_by_label(f"Role of shape {n}").is_visible() for n in (1, 2, 3, 4)] == [False, True, True, True]
    page.get_by_label("Role of shape 2").select_option("catcher")
    page.get_by_label("Role of shape 4").select_option("holdout")
    plate.drag((815, 660), (815, 664))
    page.get_by_label("Level ground").select_option("catcher")
    # Of a shape that is gone the next one keeps its own.
    page.get_by_label("Remove shape 1").click()
    assert [page.get_by_label(f"Role of shape {n}").input_value() for n in (1, 2, 3)] == ["catcher", "both", "holdout"]
    page.fill("#save [name=people]", "0")
    page.click("#copy")
    until(page, "document.getElementById('scene').value")
    page.click("#apply")
    until(page, "document.getElementById('messages').textContent.includes('camera roles has it')")
    of_file = json.loads(page.input_value("#scene"))["cameras"][0]["backdrop"]["proxies"]
    for proxies in (of_file, camera.get()["backdrop"]["proxies"]):
        assert [one.get("role", "both") for one in proxies["boxes"] + proxies["cutouts"] + [proxies["ground"]]] == ["catcher", "both", "holdout", "catcher"]


def test_distances_and_heights_are_measured_in_the_photo(rig, opened_plate):
    plate, page = opened_plate, opened_plate.page
    ends = [(360, 740), (940, 650)]  # away from the points, which would be dragged instead
    post = plate.ground((500, 620))
    plate.tool("distance")
    plate.click(*ends)
    assert page.text_content("#measured li output") == "calibrate first"
    plate.add_points(*CLICKS)
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera")
    plate.tool("standing")
    plate.click(plate.pixel((*post, 0)), plate.pixel((*post, 2)))
    until(page, "[...document.querySelectorAll('#measured li output')].filter(one => one.textContent.endsWith(' m')).length === 2")
    metres = [float(text.removesuffix(" m")) for text in page.eval_on_selector_all("#measured output", "all => all.map(one => one.textContent)")]
    # As good as four clicks at pixels of the screen.
    assert metres[0] == pytest.approx(np.linalg.norm(plate.ground(ends[0]) - plate.ground(ends[1])), rel=0.03)
    assert metres[1] == pytest.approx(2, rel=0.03)
    plate.drag(plate.pixel((*post, 2)), plate.pixel((*post, 1)))
    until(page, "Math.abs(parseFloat(document.querySelectorAll('#measured li output')[1].textContent) - 1) < 0.05")
    plate.drag(ends[1], (940, 5))
    until(page, "document.querySelector('#measured li output').textContent === 'over the horizon of the ground'")
    page.get_by_label("Remove measure 1").click()
    assert page.locator("#measured li").count() == 1


def test_a_search_of_clicks_that_have_changed_meanwhile_is_not_taken_for_theirs(rig, opened_plate):
    plate, page = opened_plate, opened_plate.page
    plate.add_points(*CLICKS, (640, 800))
    verdict = lambda: page.text_content("#verdict")  # noqa: E731
    stale = "Clicks have changed since: calibrate again."

    def fill(label, text):
        page.get_by_label(label).fill(text)
        page.keyboard.press("Enter")

    with held(page, "**/rpc", "plate.calibrate") as waiting:
        for change in (lambda: page.get_by_label("Remove point 5").click(), lambda: fill("Error of a click (px)", "1")):
            plate.calibrate()
            change()
            let_go(page, waiting)
            plate.settle()
            assert page.is_visible("#answer") and verdict() == stale
        plate.calibrate()
        let_go(page, waiting)
        plate.settle()
        assert verdict() not in ("Not calibrated yet.", stale)
        # Nor is a refusal.
        fill("Vertical view (°)", "200")
        plate.calibrate()
        fill("Vertical view (°)", "")
        let_go(page, waiting)
        plate.settle()
        assert page.text_content("[data-problem=vfov_deg]") == ""


def test_a_search_of_another_photo_is_not_taken_for_that_of_the_one_that_is_shown(rig, opened_plate, tmp_path):
    plate, page = opened_plate, opened_plate.page
    cv2.imwrite(str(tmp_path / "other.png"), np.full((480, 640, 3), 128, np.uint8))
    plate.add_points(*CLICKS)
    with held(page, "**/rpc", "plate.calibrate") as waiting:
        plate.calibrate()
        page.set_input_files("#photo-file", str(tmp_path / "other.png"))
        until(page, "document.getElementById('photo-facts').textContent === 'other.png · 640×480'")
        let_go(page, waiting)
        plate.settle()
    assert page.is_hidden("#answer") and page.text_content("#verdict") == "Not calibrated yet."


def test_the_photo_that_was_chosen_last_is_shown_whichever_comes_last(rig, browser, photo):
    for name in ("first", "second"):
        rig.create_camera(name, size=(320, 240), position=(0, 0, 4), tilt_deg=-15, pan_deg=0, vfov_deg=50,
                          backdrop={"file": str(photo[0]), "proxies": {"ground": {"polygon_m": [[3, -12], [40, -12], [40, 12], [3, 12]]}}})
    with plate_page(rig, browser, photo) as plate:
        page = plate.page
        until(page, "document.getElementById('photo-camera').options.length === 3")
        with held(page, "**/first/snapshot.png") as waiting:
            page.select_option("#photo-camera", "first")
            page.select_option("#photo-camera", "second")
            until(page, "document.querySelector('#save [name=camera]').value === 'second'")
            let_go(page, waiting)
            plate.settle()
            assert page.input_value("#save [name=camera]") == "second"
            page.select_option("#photo-camera", "first")
            page.set_input_files("#photo-file", str(photo[0]))
            until(page, "document.querySelector('#save [name=camera]').value === 'my_corner'")
            let_go(page, waiting)
            plate.settle()
            assert page.input_value("#save [name=camera]") == "my_corner"


def test_lens_and_intrinsics_that_are_known_are_typed_or_come_from_a_file(rig, opened_plate, tmp_path):
    plate, page = opened_plate, opened_plate.page
    plate.add_points(*CLICKS)
    page.fill("#known [name=intrinsics]", "900, 900, 639.5")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.querySelector('[data-problem=intrinsics]').textContent === 'intrinsics: give four numbers, fx, fy, cx and cy'")
    k = plate.K
    page.fill("#known [name=intrinsics]", ", ".join(str(value) for value in (k[0, 0], k[1, 1], k[0, 2], k[1, 2])))
    page.select_option("#known [name=lens]", "plumb_bob")
    page.fill("#known [name=coefficients]", "0.001 0 0")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.querySelector('[data-problem=lens]').textContent.startsWith('lens: ')")
    page.fill("#known [name=coefficients]", "0.001 0 0 0 0")
    page.keyboard.press("Enter")
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera")
    found = json.loads(page.get_attribute("#answer", "data-camera"))
    assert found["intrinsics"]["fx"] == pytest.approx(k[0, 0]) and found["lens"]["coefficients"][0] == 0.001
    # What fSpy wrote: its camera looks along -z with y up.
    rows = plate.world.copy()
    rows[:3, 1:3] *= -1
    known = tmp_path / "corner.fspy.json"
    known.write_text(json.dumps({"imageWidth": SIZE[0], "imageHeight": SIZE[1], "horizontalFieldOfView": 2 * math.atan(SIZE[0] / 2 / k[0, 0]),
                                 "principalPoint": {"x": 0, "y": 0}, "cameraTransform": {"rows": rows.tolist()}}))
    page.set_input_files("#known [name=camera_files]", str(known))
    plate.calibrate()
    until(page, "document.getElementById('problem').textContent || document.querySelector('[data-problem=intrinsics]').textContent.includes('file')")
    page.fill("#known [name=intrinsics]", "")
    page.fill("#known [name=coefficients]", "")
    page.select_option("#known [name=lens]", "")
    for number in range(len(CLICKS), 0, -1):
        page.get_by_label(f"Remove point {number}").click()
    plate.calibrate()
    until(page, "document.getElementById('verdict').textContent.startsWith('unknown: as the file has it')")
    pose = json.loads(page.get_attribute("#answer", "data-camera"))["pose"]
    assert pose["position"] == pytest.approx(plate.world[:3, 3].tolist(), abs=1e-6)


def test_every_control_of_the_page_of_photos_has_a_name_and_enough_contrast(opened_plate):
    from axe_playwright_python.sync_playwright import Axe

    plate, page = opened_plate, opened_plate.page
    plate.add_points(*CLICKS)
    plate.calibrate()
    until(page, "document.getElementById('answer').dataset.camera")
    plate.tool("walkable")
    plate.click((200, 900), (1080, 900), (640, 620))
    page.click("#done")
    found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}).response
    assert [(one["id"], [node["html"][:160] for node in one["nodes"]]) for one in found["violations"]] == []
    assert len(found["passes"]) > 10


def test_a_photo_that_is_told_of_twice_is_taken_once(opened_plate):
    """A file that was chosen before the page's script ran is found by the script, and its event may come after: what was clicked meanwhile stays."""
    plate, page = opened_plate, opened_plate.page
    plate.add_points(CLICKS[0])
    page.dispatch_event("#photo-file", "change")
    for _ in range(3):  # as long as it takes to read it again
        page.evaluate("createImageBitmap(document.getElementById('photo-file').files[0]).then(() => {})")
    assert page.locator("#points li").count() == 1


def test_on_a_phone_the_page_of_photos_needs_no_sideways_scrolling(rig, browser, photo):
    context = browser.new_context(viewport={"width": 360, "height": 740}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(rig.page_url.replace("/#", "/plate.html#"))
    page.set_input_files("#photo-file", str(photo[0]))
    until(page, "document.getElementById('photo-facts').textContent.startsWith('My Corner.png')")
    until(page, "document.getElementById('plate').dataset.view !== undefined")
    view = json.loads(page.get_attribute("#plate", "data-view"))
    page.locator("#plate").scroll_into_view_if_needed()
    box = page.locator("#plate").bounding_box()
    page.touchscreen.tap(box["x"] + 640.5 * view["scale"] + view["x"], box["y"] + 700.5 * view["scale"] + view["y"])
    until(page, "document.querySelectorAll('#points li').length === 1")
    assert float(page.get_by_label("point 1: Point u (px)").input_value()) == pytest.approx(640, abs=5)
    assert page.evaluate("[document.documentElement.scrollWidth, innerWidth]") == [360, 360]
    context.close()


def test_without_the_key_the_page_of_photos_says_how_to_command(rig, browser, photo):
    page = browser.new_page()
    page.goto(rig.http_url + "/plate.html")
    page.wait_for_selector("#messages .error")
    assert "#key=" in page.text_content("#messages")
    page.close()
