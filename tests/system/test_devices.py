"""Programs that know nothing of camrig open /dev/videoN, without a kernel module and without root."""

import json
import os
import subprocess
import sys
import urllib.request

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")

READER = """
import cv2, sys
import camrig
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
assert capture.isOpened()
last, new, at = -1, 0, 0.0
for _ in range(int(sys.argv[2])):
    ok, image = capture.read()
    assert ok
    code = camrig.read_code(image)
    if code.sequence == last:  # the last one comes again, after a second without a picture, stamped half a second in the past
        assert capture.get(cv2.CAP_PROP_POS_MSEC) - at > 400
        continue
    assert code.sequence > last
    last, new, at = code.sequence, new + 1, capture.get(cv2.CAP_PROP_POS_MSEC)
assert new > int(sys.argv[2]) // 2
print("shape", image.shape)
"""


def exec_at(control, *command, timeout=60, cwd=None, **variables):
    return subprocess.run([os.environ["CAMRIG_BIN"], "exec", "--control", control, "--", *command], cwd=cwd, env={**os.environ, **variables},
                          capture_output=True, text=True, timeout=timeout, check=False)


def run_exec(rig, *command, timeout=60):
    return exec_at(rig.call("server.info")["control"], *command, timeout=timeout)


def test_opencv_opens_a_device_that_the_kernel_does_not_have(rig):
    rig.create_camera("lobby", size=(640, 480), code_strip=True, outputs=[{"kind": "device", "number": 7}])
    assert not os.path.exists("/dev/video7")
    done = run_exec(rig, sys.executable, "-c", READER, "/dev/video7", "25")
    assert done.returncode == 0, done.stderr
    assert "shape (480, 640, 3)" in done.stdout


def test_v4l2_ctl_lists_and_streams_it(rig):
    rig.create_camera("lobby", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    listed = run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--list-formats-ext")
    assert "YUYV" in listed.stdout and "320x240" in listed.stdout
    streamed = run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--stream-mmap", "--stream-count=10")
    assert streamed.returncode == 0, streamed.stderr


# libudev takes only what lies on a file system like the kernel's /sys.
SEES_CAMERA = """
import ctypes, os
libc = ctypes.CDLL(None, use_errno=True)
libc.realpath.restype = ctypes.c_char_p
os.chdir("/")
os.close(os.open("/dev/video3", os.O_RDWR))
about = (ctypes.c_long * 32)()
assert libc.fstatfs(os.open("/sys/class/video4linux/video3", os.O_RDONLY), about) == 0
assert about[0] == 0x62656572, hex(about[0])
room = ctypes.create_string_buffer(4096)
for name, real in ((b"/dev/v4l/by-id/../../video3", b"/dev/video3"), (b"/sys/dev/char/81:3/name", b"/sys/class/video4linux/video3/name")):
    found = libc.realpath(name, room)
    assert found == real, (found, ctypes.get_errno())
"""


def test_however_a_rig_is_named_its_devices_stay_in_sight_of_a_program_that_goes_elsewhere(rig, tmp_path):
    rig.create_camera("lobby", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    folder, socket = os.path.split(rig.call("server.info")["control"])
    (tmp_path / "link").symlink_to(folder)
    for control, cwd in ((f"{folder}/{socket}", None), (socket, folder), (f"{tmp_path}/link/{socket}", None)):
        done = exec_at(control, sys.executable, "-c", SEES_CAMERA, cwd=cwd)
        assert done.returncode == 0, f"{control}: {done.stderr}"


def test_devices_of_a_rig_in_a_folder_that_is_called_as_theirs(programs, scenes, tmp_path):
    folder = tmp_path / "my.tree"
    folder.mkdir()
    control = os.path.relpath(folder / "s", tmp_path)
    ready, told = os.pipe()
    programs([os.environ["CAMRIG_BIN"], "serve", scenes / "minimal.json", "--http", "0", "--rtsp", "0", "--control", control, "--ready-fd", str(told)], cwd=tmp_path,
             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, pass_fds=(told,))
    os.close(told)
    with os.fdopen(ready) as pipe:
        assert pipe.readline(), "it does not start"
    with camrig.connect(folder / "s") as rig:
        assert rig.call("server.info")["devices"] == f"{folder}/s.d/devices"  # whoever reads it may be elsewhere
        rig.create_camera("lobby", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
        done = exec_at(str(folder / "s"), sys.executable, "-c", SEES_CAMERA)
        assert done.returncode == 0, done.stderr


def test_a_library_whose_name_the_loader_would_split_is_refused_with_the_way_out(rig, tmp_path):
    for name in ("with blank", "with:colon"):
        (tmp_path / name).touch()
        done = exec_at(rig.call("server.info")["control"], "true", CAMRIG_DEVICE_LIBRARY=str(tmp_path / name))
        assert done.returncode == 1 and name in done.stderr and "CAMRIG_DEVICE_LIBRARY" in done.stderr, done.stderr


def test_the_books_name_the_programs_that_read_a_device(rig):
    rig.create_camera("lobby", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    program = subprocess.Popen([os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--",
                                "v4l2-ctl", "-d", "/dev/video3", "--stream-mmap"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def books():
        outputs = next(camera["outputs"] for camera in rig.call("stats.get")["cameras"] if camera["name"] == "lobby")
        return [reader for output in outputs for reader in output["readers"] if reader["peer"].startswith("/dev/video3 read by")]

    try:
        wait_until(lambda: books() and books()[0]["delivered"] >= 3, what="pictures that v4l2-ctl took")
        book = books()[0]
        assert book["peer"] == f"/dev/video3 read by v4l2-ctl (process {program.pid})" and book["offered"] >= book["delivered"]
    finally:
        program.kill()
        program.wait()
    wait_until(lambda: not books(), what="its end")


def test_a_deleted_camera_is_unplugged_and_its_number_is_free(rig):
    cam = rig.create_camera("a", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("b", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    assert caught.value.kind == "already_exists"
    cam.delete()
    assert run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--all").returncode != 0
    rig.create_camera("b", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    assert run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--all").returncode == 0


def sampling_of(jpeg: bytes) -> list[tuple[int, int]]:
    """Horizontal and vertical sampling factors of the components, from the frame header (SOF0)."""
    at = 2
    while jpeg[at + 1] != 0xC0:
        at += 2 + int.from_bytes(jpeg[at + 2:at + 4], "big")
    return [(jpeg[at + 11 + 3 * i] >> 4, jpeg[at + 11 + 3 * i] & 15) for i in range(jpeg[at + 9])]


def captured_mjpg(rig, number: int, file) -> bytes:
    """A picture as the device gives it, untouched."""
    done = run_exec(rig, "ffmpeg", "-v", "error", "-y", "-f", "v4l2", "-input_format", "mjpeg", "-i", f"/dev/video{number}", "-c", "copy",
                    "-frames:v", "1", "-f", "mjpeg", str(file))
    assert done.returncode == 0, done.stderr
    return file.read_bytes()


def as_guvcview_reads_it(file, size: tuple[int, int]) -> np.ndarray:
    """guvcview has libavcodec decode a picture and takes the planes it gets for 4:2:2, whatever they are."""
    width, height = size
    planes = subprocess.run(["ffmpeg", "-v", "error", "-i", str(file), "-f", "rawvideo", "-"], stdout=subprocess.PIPE, check=True).stdout
    luma, u, v = (np.frombuffer(planes, np.uint8, count, start) for start, count in (
        (0, width * height), (width * height, width * height // 2), (width * height * 3 // 2, width * height // 2)))
    chroma = [np.repeat(plane.reshape(height, width // 2), 2, axis=1) for plane in (v, u)]
    return cv2.cvtColor(np.dstack([luma.reshape(height, width), *chroma]), cv2.COLOR_YCrCb2BGR)


def test_mjpg_is_422_as_most_webcams_send_it_and_some_readers_take_for_granted(rig, tmp_path):
    size, file = (320, 240), tmp_path / "picture.jpg"
    cam = rig.create_camera("lobby", size=size, outputs=[{"kind": "device", "number": 5}])
    jpeg = captured_mjpg(rig, 5, file)
    assert sampling_of(jpeg) == [(2, 1), (1, 1), (1, 1)]
    right = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert abs(as_guvcview_reads_it(file, size).astype(int) - right).mean() < 2
    assert abs(right.astype(int) - cam.frame().image).mean() < 8  # people and colours where they are

    cam.set(outputs=[{"kind": "device", "number": 5, "subsampling": "4:2:0"}])
    assert sampling_of(captured_mjpg(rig, 5, file)) == [(2, 2), (1, 1), (1, 1)]
    page = f"http://127.0.0.1:{rig.call('server.info')['http']}/cameras/lobby/snapshot.jpg"
    with urllib.request.urlopen(page, timeout=20) as answer:
        assert sampling_of(answer.read()) == [(2, 2), (1, 1), (1, 1)]


def test_a_kernel_device_that_this_machine_cannot_have_is_an_error_and_nothing_is_made(rig):
    number = 8
    if os.path.exists("/sys/module/v4l2loopback"):
        pytest.skip("this machine has the module: tests/vm is about it")
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("hallway", size=(320, 240), outputs=[{"kind": "v4l2", "number": number}])
    assert "v4l2loopback" in str(caught.value)
    assert "hallway" not in [camera.name for camera in rig.cameras()]
    cam = rig.create_camera("hallway", size=(320, 240))
    with pytest.raises(camrig.CamrigError):
        cam.set(size=(640, 480), outputs=[{"kind": "v4l2", "number": number}])
    assert rig.call("camera.get", name="hallway")["size"] == [320, 240]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_world_whose_cameras_want_a_device_that_cannot_be_theirs_changes_nothing(rig, tmp_path):
    rig.create_camera("mine", size=(160, 120), outputs=[{"kind": "device", "number": 47}])
    rig.step(seconds=1)
    before = rig.call("world.status")
    camera = lambda name, number: {"name": name, "size": [160, 120], "outputs": [{"kind": "device", "number": number}]}
    for name, cameras, number in (("taken", [camera("theirs", 47)], 47), ("twice", [camera("one", 48), camera("two", 48)], 48)):
        scene = tmp_path / f"{name}.json"
        scene.write_text(json.dumps({"camrig_scene": 1, "name": name, "cameras": cameras}))
        with pytest.raises(camrig.CamrigError, match=str(number)):
            rig.load(scene)
        assert rig.call("world.status") == before
        assert {camera.name for camera in rig.cameras()} == {"main", "mine"}
