"""Devices come and go, and outlive a rig that is killed."""

import os
import signal
import time

import pytest

import camrig
from conftest import (HAS_CONTROL_NODE, LEFT, NAMES, RIGHT, SIZE, SPARE, create, gray_of, is_camera, needs_control_node, start_rig,
                      wait_until)
from v4l2_reader import V4l2Reader

CYCLES = 1000


def descriptors(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


def test_a_thousand_cameras_come_and_go(rig):
    pid = rig.call("server.info")["pid"]
    node = f"/dev/video{SPARE}"
    before = descriptors(pid)
    started = time.monotonic()
    for cycle in range(CYCLES):
        camera = create(rig, SPARE, size=(16, 16), code_strip=False)
        if HAS_CONTROL_NODE:
            wait_until(lambda: os.path.exists(node), what=f"{node} of cycle {cycle}")
        camera.delete()
        if HAS_CONTROL_NODE:
            wait_until(lambda: not os.path.exists(node), what=f"{node} to go in cycle {cycle}")
    print(f"{CYCLES} cycles in {time.monotonic() - started:.1f} s")
    wait_until(lambda: descriptors(pid) <= before, what="descriptors to be given back")
    create(rig, SPARE)
    wait_until(lambda: is_camera(SPARE), what=node)
    with V4l2Reader(SPARE, "YUYV", SIZE) as reader:
        assert reader.card == NAMES[SPARE]
        reader.take(3)
    rig.camera("spare").delete()


@needs_control_node
def test_a_device_that_is_read_goes_when_its_reader_does(rig):
    camera = create(rig, SPARE)
    wait_until(lambda: is_camera(SPARE), what="spare")
    with V4l2Reader(SPARE, "YUYV", SIZE) as reader:
        reader.take(2)
        camera.delete()
        wait_until(lambda: "is still open in some program" in rig.log, what="a word about it")
        assert os.path.exists(f"/dev/video{SPARE}")
    wait_until(lambda: not os.path.exists(f"/dev/video{SPARE}"), what="the device to go")


def test_a_waiting_reader_survives_a_rig_that_is_killed_and_started_again(station):
    with V4l2Reader(LEFT, "YUYV", SIZE) as reader:
        before = reader.take(3)[-1]
        os.kill(station.rig.call("server.info")["pid"], signal.SIGKILL)
        killed = time.monotonic()
        with pytest.raises(camrig.CamrigError, match="signal 9"):
            station.rig.close()
        assert os.path.exists(f"/dev/video{LEFT}") and os.path.exists(f"/dev/video{RIGHT}")

        station.rig = start_rig()
        for number in (LEFT, RIGHT):
            create(station.rig, number)
        pictures = [reader.next(timeout_s=60)]
        print(f"{time.monotonic() - killed:.1f} s without a picture")
        pictures += [reader.next() for _ in range(5)]
    assert pictures[-1].stamp_us > before.stamp_us
    assert pictures[-1].sequence > before.sequence
    assert camrig.read_code(gray_of(pictures[-1].data)) is not None
    wait_until(lambda: is_camera(RIGHT), what="right")
    with V4l2Reader(RIGHT, "YUYV", SIZE) as reader:
        assert reader.card == NAMES[RIGHT]
        reader.take(3)


def test_an_ending_rig_takes_the_devices_along_that_it_made(station):
    create(station.rig, SPARE)
    wait_until(lambda: is_camera(SPARE), what="spare")
    station.rig.close()
    assert os.path.exists(f"/dev/video{SPARE}") == (not HAS_CONTROL_NODE)
    for number in (LEFT, RIGHT):  # the killed rig's
        assert os.path.exists(f"/dev/video{number}")
