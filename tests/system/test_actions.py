"""The twelve functional actions that a multi-camera simulator must be able to do, each through a real rig."""

import concurrent.futures
import time
import urllib.request

import cv2
import numpy as np
import pytest

import camrig
from rtsp_client import strictly_rising, without_repeats

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")


def test_what_is_done_while_the_world_stands_is_there_at_once(rig):
    cam = rig.create_camera("c", size=(64, 48), position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    last = rig.call("event.wait", since=0, timeout_s=0)["last"]
    with concurrent.futures.ThreadPoolExecutor(1) as aside, camrig.connect(control=rig.call("server.info")["control"]) as second:
        told = aside.submit(second.call, "event.wait", since=last, timeout_s=30)
        time.sleep(0.2)  # it waits; were it to come later, it would be answered from the log
        rig.call("event.act", do=[{"action": "user", "data": {"n": 1}}, {"action": "camera", "camera": "c", "pose": {"position": [1, 2, 3], "look_at": [0, 0, 0]}}])
        begun = time.monotonic()
        assert [event["data"] for event in told.result(20)["events"]] == [[{"n": 1}]] and time.monotonic() - begun < 20
    assert cam.get()["pose"]["position"] == [1, 2, 3]
    rig.call("event.act", do=[{"action": "camera", "camera": "c", "pose": {"position": [3, 2, 1], "look_at": [0, 0, 0]}}])
    cam.delete()
    again = rig.create_camera("c", size=(64, 48), position=(5, 5, 5), look_at=(0, 0, 0.5))
    rig.step(seconds=0.1)
    assert again.get()["pose"]["position"] == [5, 5, 5], "what was done to the camera of that name before is not done to it"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_change_that_a_pause_overtakes_shows_in_the_paused_world(rig):
    cam = rig.create_camera("c", size=(64, 48), fps="1/10", position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    before = cam.frame().image
    cam.set(position=(0, 0, 9), look_at=(0.1, 0, 0))
    rig.pause()
    assert (cam.frame(timeout=5).image != before).any() and cam.truth()["pose"]["position"] == [0, 0, 9]


@pytest.mark.camrig(scene="scenes/crowd.json", mode="realtime")
def test_the_digest_of_a_world_that_runs_is_always_answered(rig):
    for camera in rig.cameras():
        camera.delete()  # now the world is brought on by who asks
    times = []
    for _ in range(300):
        times.append(rig.call("world.digest")["world_ns"])
        time.sleep(0.013)  # a step and a bit: each finds the world behind
    assert times == sorted(times)


def test_connect(rig):
    with camrig.connect(control=rig.call("server.info")["control"]) as second:
        assert second.status()["scene"] == rig.status()["scene"]


def test_create_a_camera_with_any_configuration(rig):
    cam = rig.create_camera(
        "any", size=(321, 243), fps="30000/1001", intrinsics={"fx": 300, "fy": 310, "cx": 150.5, "cy": 120},
        position=(3, 2, 1.5), look_at=(0, 0, 0.5), near=0.1, far=500, quality="fast", code_strip=True)
    state = cam.get()
    assert state["size"] == [321, 243]
    assert state["fps"] == "30000/1001"
    assert state["intrinsics"] == {"fx": 300, "fy": 310, "cx": 150.5, "cy": 120}
    assert state["quality"] == "fast"
    assert cam.frame().image.shape == (243, 321, 3)


@pytest.mark.parametrize("size", [(16, 16), (17, 31), (99, 99), (160, 120), (640, 480), (1279, 719), (1920, 1080), (4096, 2160)])
def test_resolutions_from_tiny_to_4k_and_odd_ones(rig, size):
    cam = rig.create_camera("c", size=size, position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    rig.step(seconds=0.04)
    image = cam.frame().image
    assert image.shape == (size[1], size[0], 3)
    assert image.std() > 1  # a picture, not a blank


@pytest.mark.parametrize("size", [(15, 16), (16, 15), (8193, 16), (0, 0), (-1, 10)])
def test_sizes_beyond_the_limits_are_refused(rig, size):
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("c", size=size)
    assert caught.value.kind == "invalid_argument"
    assert "size" in str(caught.value)


def test_a_second_camera_of_one_name_is_refused(rig):
    rig.create_camera("twin")
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("twin")
    assert caught.value.kind == "already_exists"
    assert [c["name"] for c in rig.call("camera.list")["cameras"]].count("twin") == 1


@pytest.mark.parametrize("fps, step_s, frames", [("1/10", 20, 2), (1, 3, 3), (25, 0.2, 5), ("30000/1001", 1.001, 30), (1000, 0.05, 50)])
def test_rates_from_a_tenth_to_a_thousand(rig, fps, step_s, frames):
    cam = rig.create_camera("c", size=(16, 16), fps=fps)
    before = cam.frame().sequence
    rig.step(seconds=step_s)
    assert cam.frame().sequence - before == frames


@pytest.mark.parametrize("fps", [0, -1, 1001, "1/11", "a", "1/0"])
def test_impossible_rates_are_refused(rig, fps):
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("c", fps=fps)
    assert caught.value.kind == "invalid_argument"


def test_delete_a_camera(rig):
    cam = rig.create_camera("gone")
    cam.delete()
    with pytest.raises(camrig.CamrigError) as caught:
        cam.frame()
    assert caught.value.kind == "not_found"
    rig.create_camera("gone")  # the name is free again


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_stream_one_camera(rig):
    cam = rig.create_camera("c", size=(320, 240), code_strip=True, position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    capture = cv2.VideoCapture(cam.url())
    assert capture.isOpened()
    codes = []
    for _ in range(10):
        ok, image = capture.read()
        assert ok
        codes.append(camrig.read_code(image))
    sequences = without_repeats(code.sequence for code in codes)
    assert strictly_rising(sequences) and len(sequences) > 2


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_stream_several_cameras_and_several_streams_at_once(rig):
    cameras = [rig.create_camera(f"c{i}", size=(160, 120), fps=10, code_strip=True) for i in range(4)]
    captures = [cv2.VideoCapture(cam.url()) for cam in cameras for _ in range(2)]
    seen = [set() for _ in captures]
    for _ in range(6):
        for capture, numbers in zip(captures, seen):
            ok, image = capture.read()
            assert ok
            numbers.add(camrig.read_code(image).camera)
    assert all(len(numbers) == 1 for numbers in seen)  # every stream shows its own camera only
    assert len({n for numbers in seen for n in numbers}) == 4


class StreamReader:
    """Reads a camera's MJPEG stream. Each picture carries its number, so that none is taken for another."""

    def __init__(self, cam):
        self.response = urllib.request.urlopen(cam.url(), timeout=60)
        self.read(cam.frame().sequence)  # the stream begins with the picture that is there

    def read(self, sequence):
        """The picture of this number: the stream brings every one."""
        while line := self.response.readline():
            if not line.lower().startswith(b"content-length:"):
                continue
            length = int(line.split(b":")[1])
            while self.response.readline().strip():
                pass  # the other headers of the part
            image = cv2.imdecode(np.frombuffer(self.response.read(length), np.uint8), cv2.IMREAD_COLOR)
            code = camrig.read_code(image)
            if code.sequence >= sequence:
                assert code.sequence == sequence
                return image, code
        raise AssertionError("the stream ended")


def difference(a, b):
    return np.abs(a.astype(int) - b).mean()


def test_move_while_streaming_and_see_it_in_the_stream(rig):
    cam = rig.create_camera("c", size=(256, 192), code_strip=True, position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    stream = StreamReader(cam)
    rig.step(seconds=0.08)
    standing, before = stream.read(1)[0], stream.read(2)[0]
    reply = cam.set(position=(-3, 2, 1.5), look_at=(0, 0, 0.5))
    rig.step(seconds=0.04)
    after, code = stream.read(3)  # no number is missing where the camera was changed
    assert code.time_ns > reply["applied_ns"]
    assert difference(standing, before) * 2 < difference(before, after)  # the code strip differs anyway


def test_change_field_of_view_and_rate_while_streaming(rig):
    cam = rig.create_camera("c", size=(256, 192), code_strip=True, vfov_deg=60, position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    stream = StreamReader(cam)
    rig.step(seconds=0.04)
    wide = stream.read(1)[0]
    cam.set(vfov_deg=20)
    rig.step(seconds=0.04)
    narrow, code = stream.read(2)
    assert difference(wide, narrow) > 5  # the code strip makes up for 2
    assert code.time_ns == 80_000_000
    cam.set(fps=5)
    assert cam.get()["fps"] == 5
    rig.step(seconds=0.52)
    assert [stream.read(n)[1].time_ns for n in (3, 4, 5)] == [200_000_000, 400_000_000, 600_000_000]


def test_jpeg_and_png_are_sound(rig, tmp_path):
    cam = rig.create_camera("c", size=(161, 121), position=(3, 2, 1.5), look_at=(0, 0, 0.5))
    raw = cam.frame().image
    png = cv2.imread(str(cam.snapshot(tmp_path / "a.png")))
    jpeg = cv2.imread(str(cam.snapshot(tmp_path / "a.jpg")))
    assert np.array_equal(raw, png)
    error = np.abs(raw.astype(int) - jpeg)
    assert jpeg.shape == raw.shape and error.mean() < 3
