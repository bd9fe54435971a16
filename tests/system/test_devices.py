"""Programs that know nothing of camrig open /dev/videoN, without a kernel module and without root."""

import os
import subprocess
import sys

import pytest

import camrig

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")

READER = """
import cv2, sys
import camrig
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
assert capture.isOpened()
last = -1
for _ in range(int(sys.argv[2])):
    ok, image = capture.read()
    assert ok
    code = camrig.read_code(image)
    assert code.sequence > last
    last = code.sequence
print("shape", image.shape)
"""


def run_exec(rig, *command, timeout=60):
    return subprocess.run([os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--", *command],
                          capture_output=True, text=True, timeout=timeout, check=False)


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


def test_a_deleted_camera_is_unplugged_and_its_number_is_free(rig):
    cam = rig.create_camera("a", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    with pytest.raises(camrig.CamrigError) as caught:
        rig.create_camera("b", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    assert caught.value.kind == "already_exists"
    cam.delete()
    assert run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--all").returncode != 0
    rig.create_camera("b", size=(320, 240), outputs=[{"kind": "device", "number": 3}])
    assert run_exec(rig, "v4l2-ctl", "-d", "/dev/video3", "--all").returncode == 0
