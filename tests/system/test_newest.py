"""Nobody gets an old picture after a command: what is asked for next shows it."""

import urllib.request

import cv2
import numpy as np
import pytest


#: Size, and where the camera looks: at the ground or into the sky. Each differs from the one before in the size, the pose or both.
DOWN, UP = {"position": (-6, 0, 2.5), "pan_deg": 0, "tilt_deg": -80}, {"position": (-6, 0, 2.5), "pan_deg": 0, "tilt_deg": 80}
CHANGES = [((320, 240), UP), ((320, 240), DOWN), ((64, 48), DOWN), ((640, 480), UP), ((160, 120), DOWN), ((160, 120), UP),
           ((322, 242), UP), ((64, 64), DOWN), ((800, 600), UP), ((800, 600), DOWN), ((62, 46), UP), ((320, 240), DOWN)]


def looks_up(image):
    """The sky is even and of a blue of 211; the ground has 193."""
    return np.mean(image[:, :, 0]) > 203


def snapshot(cam):
    with urllib.request.urlopen(cam.url("jpg"), timeout=30) as answer:
        return cv2.imdecode(np.frombuffer(answer.read(), np.uint8), cv2.IMREAD_COLOR)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
@pytest.mark.parametrize("ask", ["frame", "snapshot", "truth"])
@pytest.mark.parametrize("is_read", [False, True], ids=["idle", "read"])
def test_what_follows_a_command_shows_it(rig, ask, is_read):
    """In real time, where pictures are under way all the while; `read`: another reader keeps the camera at work."""
    cam = rig.create_camera("c", size=(320, 240), fps=25, code_strip=False, **DOWN)
    for size, pose in CHANGES:
        reader = urllib.request.urlopen(cam.url("mjpeg"), timeout=30) if is_read else None
        if reader:
            reader.read(2000)  # a picture of the camera as it was
        cam.set(size=size, **pose)
        if ask == "truth":
            truth = cam.truth()
            assert tuple(truth["size"]) == size
            shown_up = truth["pose"]["orientation"][1] < 0
        else:
            image = cam.frame().image if ask == "frame" else snapshot(cam)
            assert image.shape[1::-1] == size
            shown_up = looks_up(image)
        assert shown_up == (pose is UP), (size, pose)
        if reader:
            reader.close()
