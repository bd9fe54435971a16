"""`camrig view` under a person's hands: a real window on a real X server, mouse and keys by xdotool."""

import contextlib
import json
import math
import os
import signal
import subprocess
import time

import numpy as np
import pytest

import camrig
from conftest import REPOSITORY, wait_until
from test_install import CAMRIG, run
from virtual_display import VirtualDisplay

WIDTH, HEIGHT = 1280, 830
# The parts of the window have fixed places: tools/view/panels.h.
SCENE_X, SCENE_WIDTH, SCENE_HEIGHT = 260, WIDTH - 260 - 300, HEIGHT - 170
NEW, SAVE = (45, 18), (130, 41)
VFOV_SLIDER_RIGHT, NEW_RTSP, ADD_RTSP = (1170, 81), (1036, 221), (1023, 422)
CODE_STRIP = (997, 811)  # below what a new output of RTSP is made with, and the outputs, of which there is one
STEP_200_MS = (476, 678)
# Of a camera without outputs. With a fault there is a line more above all but FAULTS.
FAULTS, FAULT_KIND, DIRT, SEVERITY_QUARTER, SECONDS, COVERAGE_THIRD, SET_DIRT = (1030, 272), (1060, 291), (1030, 384), (1050, 315), (1060, 338), (1060, 361), (1022, 473)
FIRST_FAULT_X, SHOWN_FAULT = (1016, 289), (1070, 289)
WIPE = (1063, 490)  # with a fault
# Of a camera without outputs and, below SENSOR, with a sensor; FOCUS after six turns of the wheel.
CONTROLS, BRIGHTNESS_HIGH = (1000, 573), (1120, 708)
SENSOR, SENSOR_ON, PRESET, IMX290, EXPOSURE, GAIN_HALF, FOCUS = (1000, 407), (1018, 427), (1100, 450), (1030, 525), (1060, 496), (1084, 519), (1120, 497)


class View:
    """The running window, and where the world's points are in it."""

    def __init__(self, rig, display, file):
        self.rig, self.display = rig, display
        command = [CAMRIG, "view", "--control", rig.info()["control"], "--file", file, "--width", str(WIDTH), "--height", str(HEIGHT)]
        self.process = subprocess.Popen(command, env={"DISPLAY": display.name, "PATH": "/usr/bin:/bin"}, stderr=subprocess.PIPE, text=True)
        self.own = f"view_{self.process.pid}"

    def wait_open(self):
        self.display.move_window("camrig view", 0, 0)
        self.wait_settled()

    def eye(self):
        return self.rig.camera(self.own).get()

    def wait_settled(self):
        """Until the world in the window is what the view's camera shows; lines over it are little of it."""
        wait_until(lambda: self.own in [camera.name for camera in self.rig.cameras()], what="the view's camera")
        wait_until(lambda: self.eye()["size"] == [SCENE_WIDTH, SCENE_HEIGHT], what="the view's size")

        def is_same():
            shown = self.display.picture()[0:SCENE_HEIGHT, SCENE_X:SCENE_X + SCENE_WIDTH].astype(int)
            own = self.rig.camera(self.own).frame().image  # of the size before, until the camera's next instant
            return own.shape == shown.shape and np.median(np.abs(shown - own)) < 3

        wait_until(is_same, what="the world in the window")

    def basis(self):
        """Rows: right, down, ahead of the eye, in the world."""
        pan, tilt = (math.radians(self.eye()["pose"][key]) for key in ("pan_deg", "tilt_deg"))
        ahead = np.array([math.cos(tilt) * math.cos(pan), math.cos(tilt) * math.sin(pan), math.sin(tilt)])
        right = np.array([math.sin(pan), -math.cos(pan), 0])
        return np.stack([right, np.cross(ahead, right), ahead])

    def focal(self):
        return SCENE_HEIGHT / 2 / math.tan(math.radians(30))

    def on_screen(self, point):
        x, y, z = self.basis() @ (np.array(point) - self.eye()["pose"]["position"])
        assert z > 0
        return SCENE_X + SCENE_WIDTH / 2 + self.focal() * x / z, SCENE_HEIGHT / 2 + self.focal() * y / z

    def wait_grip(self, place):
        """Until the dot of the camera that is chosen is drawn there: before that nothing can be dragged."""
        wait_until(lambda: np.abs(self.display.picture()[place[1], place[0]].astype(int) - (40, 190, 255)).max() < 4, what=f"the camera's dot at {place}")

    def on_plane(self, screen, height):
        """The world's point under a place of the window, at a height."""
        eye = np.array(self.eye()["pose"]["position"])
        ray = np.array([screen[0] - SCENE_X - SCENE_WIDTH / 2, screen[1] - SCENE_HEIGHT / 2, self.focal()]) @ self.basis()
        return eye + ray * (height - eye[2]) / ray[2]

    def handle_of(self, name):
        pose = self.rig.camera(name).get()["pose"]
        pan, tilt = math.radians(pose["pan_deg"]), math.radians(pose["tilt_deg"])
        return np.array(pose["position"]) + 1.2 * np.array([math.cos(tilt) * math.cos(pan), math.cos(tilt) * math.sin(pan), math.sin(tilt)])

    def close(self, how=signal.SIGTERM):
        self.process.send_signal(how)
        assert self.process.wait(20) == 0, self.process.stderr.read()


@pytest.fixture
def display():
    with VirtualDisplay(WIDTH, HEIGHT) as server:
        yield server


@pytest.fixture
def view(rig, display, tmp_path):
    window = View(rig, display, tmp_path / "cameras.json")
    try:
        window.wait_open()
        yield window
    finally:
        window.process.kill()
        window.process.wait()


def names(rig):
    return [camera.name for camera in rig.cameras()]


def arrangement(rig):
    """What a camera is, without how it lives."""
    lives = ("id", "sequence", "readers", "applied_ns", "world_pose")
    return [{key: value for key, value in camera.items() if key not in lives} for camera in rig.call("camera.list")["cameras"]]


def expect_same(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected):
        assert one.keys() == other.keys() and one["name"] == other["name"] and one["fps"] == other["fps"]
        for key in ("position", "orientation"):
            assert one["pose"][key] == pytest.approx(other["pose"][key], abs=1e-9)
        assert one["intrinsics"] == pytest.approx(other["intrinsics"]) and one["lens"] == other["lens"]


@pytest.mark.slow
@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep", args=["--quality", "fast"])
def test_three_cameras_placed_by_mouse_come_back_after_a_restart(rig, display, view, tmp_path):
    places = [(420, 470), (560, 520), (760, 480)]
    for i, place in enumerate(places):
        display.click(*NEW)
        name = "cam" if i == 0 else f"cam_{i + 1}"
        wait_until(lambda: name in names(rig), what=name)
        cam = rig.camera(name)
        start = cam.get()["pose"]["position"]
        hold = [round(v) for v in view.on_screen(start)]
        view.wait_grip(hold)
        goal = view.on_plane(np.array(place) + view.on_screen(start) - hold, start[2])
        display.drag(hold, place)
        wait_until(lambda: np.linalg.norm(cam.get()["pose"]["position"] - goal) < 0.03, what=f"{name} at {goal}, not {cam.get()['pose']['position']}")
    # The last is chosen: its ring turns it.
    handle = [round(v) for v in view.on_screen(view.handle_of("cam_3"))]
    before = rig.camera("cam_3").get()["pose"]
    display.drag(handle, (handle[0] - 120, handle[1] - 10))
    wait_until(lambda: rig.camera("cam_3").get()["pose"]["pan_deg"] > before["pan_deg"] + 5, what="cam_3 turned to the left")
    assert rig.camera("cam_3").get()["pose"]["position"] == pytest.approx(before["position"])
    display.click(*VFOV_SLIDER_RIGHT)
    wait_until(lambda: rig.camera("cam_3").get()["vfov_deg"] > 130, what="a wide field of view")

    display.click(*SAVE)
    saved = tmp_path / "cameras.json"
    wait_until(saved.exists, what="the saved arrangement")
    assert [camera["name"] for camera in json.loads(saved.read_text())["cameras"]] == ["lobby", "entrance", "gallery", "cam", "cam_2", "cam_3"]
    assert rig.status()["world_ns"] == 0, "the view has stepped a world that is not its own"
    view.close()
    assert view.own not in names(rig)

    placed = arrangement(rig)
    hall = REPOSITORY / "scenes/hall.json"
    with camrig.start(hall, mode="lockstep", args=["--quality", "fast"]) as again:
        run(CAMRIG, "camera", "create", "--control", again.info()["control"], "--file", saved, "--replace")
        expect_same(arrangement(again), placed)
    # And as the cameras of a scene file.
    scene = json.loads(hall.read_text())
    scene["cameras"] = json.loads(saved.read_text())["cameras"]
    (tmp_path / "hall").symlink_to(REPOSITORY / "scenes/hall")
    (tmp_path / "mine.json").write_text(json.dumps(scene))
    with camrig.start(tmp_path / "mine.json", mode="lockstep", args=["--quality", "fast"]) as mine:
        expect_same(arrangement(mine), placed)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_cameras_are_duplicated_changed_and_deleted_and_the_world_steps_when_told(rig, display, view):
    cam = rig.camera("main")
    display.click_to_change((60, 65), VFOV_SLIDER_RIGHT)  # its name in the list, whose line is marked by the mouse alone too
    display.key("ctrl+d")
    wait_until(lambda: "main_2" in names(rig), what="the duplicate")
    twin = rig.camera("main_2")
    assert twin.get()["intrinsics"] == pytest.approx(cam.get()["intrinsics"])
    assert np.linalg.norm(np.subtract(twin.get()["pose"]["position"], cam.get()["pose"]["position"])) == pytest.approx(0.6)
    wait_until(lambda: display.picture()[257, 245].sum() > 60, what="the duplicate to be chosen")
    display.click_to_change(NEW_RTSP, ADD_RTSP)
    display.click_to_change(ADD_RTSP, CODE_STRIP)  # the output has a line, which moves what is below
    wait_until(lambda: [output["kind"] for output in twin.get()["outputs"]] == ["rtsp"], what="the output")
    display.click(*CODE_STRIP)
    wait_until(lambda: twin.get()["code_strip"], what="a parameter that only the rig's table tells of")
    kept = twin.get()
    display.key("Delete", "Escape")  # asked, and answered with no
    display.key("Delete", "Return")
    wait_until(lambda: names(rig) == ["main", view.own], what="the deletion")
    display.key("ctrl+z")
    wait_until(lambda: "main_2" in names(rig), what="the camera deleted by mistake")
    again = rig.camera("main_2").get()
    assert {key: again[key] for key in kept if key not in ("id", "sequence", "applied_ns", "readers")} == {
        key: kept[key] for key in kept if key not in ("id", "sequence", "applied_ns", "readers")}
    assert rig.status()["world_ns"] == 0
    display.click(*STEP_200_MS)
    wait_until(lambda: rig.status()["world_ns"] == 200_000_000, what="the step")
    view.wait_settled()
    display.xdotool("windowkill", display.wait_window("camrig view"))  # what is left when the X server goes away
    view.process.wait(20)
    assert names(rig) == ["main", "main_2"], view.process.stderr.read()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_its_panel_of_faults_sets_one_as_its_controls_say_shows_and_clears_it(rig, display, view):
    display.click_to_change((60, 65), VFOV_SLIDER_RIGHT)
    display.click_to_change(FAULTS, FAULT_KIND)
    display.click_to_change(FAULT_KIND, DIRT)  # the kinds, of which it is the fifth
    display.click_to_change(DIRT, SET_DIRT)
    is_shown = lambda: not np.array_equal(display.around(SHOWN_FAULT), none)
    for _ in range(5):  # until no key was lost
        display.click(*SEVERITY_QUARTER)
        display.click(*COVERAGE_THIRD)
        display.write(SECONDS, "2")
        none = display.around(SHOWN_FAULT)
        display.click(*SET_DIRT)
        wait_until(is_shown, what="the fault in the window")
        (fault,) = rig.fault.list("main")
        if fault["end_ns"] == 2_000_000_000 and fault["severity"] < 0.3 and fault["params"]["coverage"] < 0.4:
            break
        rig.fault.clear("main")
        wait_until(lambda: not is_shown(), what="the fault to leave the window")
    assert fault["kind"] == "dirt" and 0.2 < fault["severity"] < 0.3
    assert 0.25 < fault["params"]["coverage"] < 0.4 and fault["params"]["spot"] == 0.1, "what nobody touched is the rig's default"
    assert (fault["start_ns"], fault["end_ns"]) == (0, 2_000_000_000)
    rig.step(seconds=0.04)
    assert rig.camera("main").soiling().any()
    for clear in (FIRST_FAULT_X, WIPE):
        display.click(*clear)
        wait_until(lambda: not rig.fault.list("main"), what="the fault to be cleared")  # a window that is slow must still see the mouse there
        display.xdotool("mousemove", *SECONDS)  # what the mouse is over looks otherwise
        wait_until(lambda: not is_shown(), what="the fault to leave the window")
        display.click(*SET_DIRT)
        wait_until(is_shown, what="the fault in the window again")
    view.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_clicks_that_a_slow_window_finds_late_are_where_they_were_made(rig, display, view):
    view.process.send_signal(signal.SIGSTOP)
    for _ in range(2):
        display.xdotool("mousemove", *NEW, "click", 1, "mousemove", *SECONDS)
    view.process.send_signal(signal.SIGCONT)
    wait_until(lambda: len(names(rig)) == 4, what="two new cameras beside those of the scene and of the window")
    view.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_two_cameras_are_made_though_the_rig_has_not_made_the_first_when_the_second_is_asked_for(rig, display, view):
    pid = rig.info()["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        for _ in range(2):
            display.click(*NEW)
            time.sleep(0.5)  # for the window to find the click; where it needs longer the rig answers between, as in the tests above
    finally:
        os.kill(pid, signal.SIGCONT)
    wait_until(lambda: {"cam", "cam_2"} <= set(names(rig)), what="both cameras")
    view.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_sensor_is_put_in_and_set_and_what_others_set_of_it_is_shown(rig, display, view):
    cam = rig.camera("main")
    sensor = lambda: cam.get()["sensor"]

    def write(place, text, is_there):
        """Again until no key was lost."""
        for _ in range(5):
            display.write(place, text)
            with contextlib.suppress(AssertionError):
                return wait_until(is_there, 4)
        raise AssertionError(f"{text} was not taken: {sensor()}")

    display.click_to_change((60, 65), VFOV_SLIDER_RIGHT)
    display.click_to_change(CONTROLS, BRIGHTNESS_HIGH)
    display.click(*BRIGHTNESS_HIGH)
    wait_until(lambda: 0.3 < cam.get()["controls"]["brightness"] < 0.7, what="the brightness")
    display.click_to_change(CONTROLS, BRIGHTNESS_HIGH)  # closed again
    display.click_to_change(SENSOR, SENSOR_ON)
    assert sensor() is None
    display.click_to_change(SENSOR_ON, EXPOSURE)
    wait_until(lambda: sensor() is not None, what="the sensor")
    display.click_to_change(PRESET, IMX290)
    display.click(*IMX290)
    wait_until(lambda: sensor()["preset"] == "imx290" and sensor()["full_well_e"] == 9193, what="the preset")
    for text, value in (("auto", "auto"), ("0.004", 0.004)):
        write(EXPOSURE, text, lambda: sensor()["exposure_s"] == value)
    gain = lambda: display.picture()[GAIN_HALF[1] - 8 : GAIN_HALF[1] + 8, GAIN_HALF[0] - 60 : GAIN_HALF[0] + 60]
    wait_until(lambda: (display.picture()[EXPOSURE[1], EXPOSURE[0] - 20 : EXPOSURE[0] + 40].std() > 0), what="the exposure to be shown")
    none = gain()
    display.click(*GAIN_HALF)
    wait_until(lambda: 20 < sensor()["gain_db"] < 28, what="the gain")
    display.xdotool("mousemove", 600, 300)
    wait_until(lambda: not np.array_equal(gain(), none), what="the gain to be shown")
    rig.step(seconds=0.04)
    taken = cam.frame().sensor
    assert taken["exposure_s"] == 0.004 and taken["gain_db"] == sensor()["gain_db"]
    cam.set(sensor={"gain_db": 0})
    wait_until(lambda: np.array_equal(gain(), none), what="what another has set to be shown")
    for _ in range(6):
        display.click(1240, 600, button=5)  # the wheel, beside all controls
    wait_until(lambda: display.picture()[FOCUS[1], FOCUS[0] - 100 : FOCUS[0]].std() > 0, what="the end of the sensor")
    write(FOCUS, "4.5", lambda: sensor()["focus_m"] == 4.5)
    assert (sensor()["exposure_s"], sensor()["gain_db"], sensor()["preset"]) == (0.004, 0, "imx290")
    view.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_it_asks_before_it_overwrites_or_deletes_and_a_drag_is_undone(rig, display, view, tmp_path):
    saved = tmp_path / "cameras.json"
    saved.write_text("somebody's work")
    display.click(*NEW)
    wait_until(lambda: "cam" in names(rig), what="cam")
    cam = rig.camera("cam")
    start = cam.get()["pose"]["position"]
    hold = [round(v) for v in view.on_screen(start)]
    view.wait_grip(hold)
    display.drag(hold, (hold[0] + 60, hold[1] + 40))
    wait_until(lambda: np.linalg.norm(np.subtract(cam.get()["pose"]["position"], start)) > 0.1, what="the drag")
    display.key("ctrl+z")
    wait_until(lambda: cam.get()["pose"]["position"] == pytest.approx(start), what="the drag undone")
    # Edits are done in order, so what follows a refused one shows that it was refused.
    display.key("ctrl+s", "Escape", "Delete", "Escape", "ctrl+d")
    wait_until(lambda: "cam_2" in names(rig), what="the duplicate")
    assert "cam" in names(rig) and saved.read_text() == "somebody's work"
    display.key("ctrl+s", "Return")
    wait_until(lambda: saved.read_text() != "somebody's work", what="the overwritten file")
    assert [camera["name"] for camera in json.loads(saved.read_text())["cameras"]] == ["main", "cam", "cam_2"]
    view.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_the_world_is_flown_through_and_paused(rig, display, view):
    display.key("space")
    wait_until(lambda: rig.status()["paused"], what="the pause")
    view.wait_settled()
    before = view.eye()["pose"]
    display.xdotool("mousemove", SCENE_X + 300, 300, "sleep", 0.1, "keydown", "w")
    wait_until(lambda: np.linalg.norm(np.subtract(view.eye()["pose"]["position"], before["position"])) > 0.3, what="flying")
    display.xdotool("keyup", "w")

    def look_round():
        """The world follows the mouse: a drag to the right turns to the left, as many radians as pixels by focal length."""
        goal_deg = view.eye()["pose"]["pan_deg"] + math.degrees(100 / view.focal())
        display.pull((SCENE_X + 300, 300), (SCENE_X + 400, 300), button=3)
        try:
            wait_until(lambda: view.eye()["pose"]["pan_deg"] == pytest.approx(goal_deg, abs=0.5), 4)
            return True
        except AssertionError:  # the window has noticed the button late
            return False
        finally:
            display.let_go(button=3)

    assert any(look_round() for _ in range(5))
    view.wait_settled()
    # Somebody deletes the view's camera: it takes another.
    rig.camera(view.own).delete()
    wait_until(lambda: view.own in names(rig), what="the view's camera to come back")
    display.key("space")
    wait_until(lambda: not rig.status()["paused"], what="play")
    view.close(signal.SIGINT)
    assert view.own not in names(rig)


def test_without_a_display_or_a_rig_it_says_what_to_do(tmp_path, rig):
    for control, word in ((rig.info()["control"], "DISPLAY"), (str(tmp_path / "none"), "camrig serve")):
        done = subprocess.run([CAMRIG, "view", "--control", control], env={"PATH": "/usr/bin:/bin"}, capture_output=True, text=True, timeout=60, check=False)
        # What else is there comes from libraries: libwayland says that it has no folder either.
        ours = [line for line in done.stderr.splitlines() if line.startswith("camrig")]
        assert done.returncode == 1 and len(ours) == 1 and word in ours[0]
