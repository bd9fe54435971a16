"""Runs as root inside the virtual machine (tests/vm/run.py): one rig for all tests, started before the module is loaded."""

import os
import subprocess
import time

import numpy as np
import pytest

import camrig

LOOPBACK = os.environ["CAMRIG_LOOPBACK"]
GENERATION = tuple(map(int, LOOPBACK.split(".")[:2]))
HAS_CONTROL_NODE = GENERATION >= (0, 13)
ONE_READER = GENERATION >= (0, 13)
STAMPS_ARE_INSTANTS = GENERATION >= (0, 14)
SIZE = (160, 120)  # drawn by llvmpipe on an emulated processor
FPS = 5
LEFT, RIGHT, SPARE = 10, 11, 12
NAMES = {LEFT: "left", RIGHT: "right", SPARE: "spare"}
VIEW = {"position": (-6, 0, 2.5), "look_at": (0, 0, 0.4)}


def wait_until(condition, timeout_s=60.0, what="condition"):
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"timed out after {timeout_s} s waiting for {what}"
        time.sleep(0.01)


def is_camera(number: int) -> bool:
    """Does the device say that it captures? That is when programs find it."""
    done = subprocess.run(["v4l2-ctl", "-d", f"/dev/video{number}", "-D"], capture_output=True, text=True, check=False)
    return "Video Capture\n" in done.stdout.split("Device Caps")[-1]


def gray_of(picture: bytes, size=SIZE) -> np.ndarray:
    """The luma of a YUYV picture."""
    return np.frombuffer(picture, np.uint8).reshape(size[1], size[0], 2)[:, :, 0]


def load_module() -> None:
    parameters = ["devices=0"]
    if not HAS_CONTROL_NODE:
        parameters = [f"devices={len(NAMES)}", "video_nr=" + ",".join(map(str, NAMES)), "card_label=" + ",".join(NAMES.values()),
                      "exclusive_caps=" + ",".join("1" for _ in NAMES), "max_buffers=4"]
    subprocess.run(["insmod", f"/tmp/modules/v4l2loopback-{LOOPBACK}.ko", *parameters], check=True)


os.environ.setdefault("CAMRIG_STOP_TIMEOUT_S", "60")  # an emulated processor


def start_rig(**options) -> camrig.Rig:
    return camrig.start("scenes/minimal.json", mode="realtime", device="cpu", quality="fast", timeout=120, **options)


def create(rig: camrig.Rig, number: int, **options) -> camrig.Camera:
    output = {"kind": "v4l2", "number": number, **options.pop("output", {})}
    return rig.create_camera(NAMES[number], **{"size": SIZE, "fps": FPS, "code_strip": True, **VIEW, **options}, outputs=[output])


class Station:
    """The running rig; a test may replace it."""

    def __init__(self) -> None:
        self.rig = start_rig()
        with pytest.raises(camrig.CamrigError) as caught:
            create(self.rig, LEFT)
        self.refusal = caught.value
        self.cameras_without_module = [camera.name for camera in self.rig.cameras() if camera.name in NAMES.values()]
        load_module()
        for number in (LEFT, RIGHT):
            create(self.rig, number)
        for number in (LEFT, RIGHT):
            wait_until(lambda: is_camera(number), what=f"/dev/video{number}")


_station: Station | None = None
# 0.12 has no such thing: tests of it are not for that machine (and none is ever skipped).
needs_control_node = pytest.mark.control_node


def pytest_configure(config):
    config.addinivalue_line("markers", "control_node: only for modules that have /dev/v4l2loopback")


def pytest_collection_modifyitems(items):
    if not HAS_CONTROL_NODE:
        items[:] = [item for item in items if not item.get_closest_marker("control_node")]


@pytest.fixture
def station(request) -> Station:
    global _station
    if _station is None:
        _station = Station()
    return _station


@pytest.fixture
def rig(station) -> camrig.Rig:
    return station.rig


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    outcome = yield
    report = outcome.get_result()
    if report.failed and _station is not None:
        report.sections.append(("camrig log", _station.rig.log))
        report.sections.append(("kernel log", subprocess.run(["dmesg"], capture_output=True, text=True, check=False).stdout[-3000:]))


def pytest_sessionfinish():
    if _station is not None:
        _station.rig.close()
