"""Lockstep: the world moves by steps only, and the same commands give the same bytes."""

import hashlib
import os
import time

import pytest

import camrig
from conftest import stuck_mjpeg_reader


def run_once(scenes, threads):
    """Hashes of every frame of two moving-world cameras over a second, with a camera moved in the middle."""
    environment = dict(os.environ, LP_NUM_THREADS=str(threads))
    digest = hashlib.sha256()
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=7, env=environment) as rig:
        left = rig.create_camera("left", size=(320, 240), place="lobby")
        right = rig.create_camera("right", size=(160, 120), fps=10, position=(20, 4, 3), look_at=(12, 9, 1))
        for step in range(10):
            if step == 5:
                left.set(vfov_deg=40)
            rig.step(seconds=0.1)
            for cam in (left, right):
                frame = cam.frame()
                digest.update(f"{frame.sequence} {frame.time_ns}".encode())
                digest.update(frame.image.tobytes())
    return digest.hexdigest()


def test_three_runs_are_identical_also_with_other_thread_counts(scenes):
    assert len({run_once(scenes, threads) for threads in (2, 2, 1)}) == 1


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_world_stands_still_between_steps(rig):
    cam = rig.create_camera("c", size=(64, 48))
    first = cam.frame()
    time.sleep(0.2)
    assert rig.status()["world_ns"] == 0
    again = cam.frame()
    assert (again.sequence, again.time_ns) == (first.sequence, first.time_ns)
    assert (again.image == first.image).all()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_step_that_waits_for_a_stuck_reader_names_it(rig):
    """A reader that takes nothing must not hang the step for ever."""

    cam = rig.create_camera("c", size=(1920, 1080), fps=100)
    raw = stuck_mjpeg_reader(cam)
    with pytest.raises(camrig.CamrigError) as caught:
        rig.call("world.step", seconds=5, timeout_s=1)
    assert caught.value.kind == "unavailable"
    assert str(raw.getsockname()[1]) in str(caught.value)
    raw.close()
    rig.step(seconds=0.1)  # the rig goes on


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_stepping_too_far_or_backwards_is_refused(rig):
    for bad in ({"seconds": -1}, {"seconds": 1e9}, {"nanoseconds": -5}, {}, {"seconds": 1, "nanoseconds": 1}, {"seconds": "1"}):
        with pytest.raises(camrig.CamrigError) as caught:
            rig.call("world.step", **bad)
        assert caught.value.kind == "invalid_argument"
    rig.call("world.step", nanoseconds=1)
    assert rig.status()["world_ns"] == 1


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_real_time_cannot_be_stepped_unless_paused(rig):
    with pytest.raises(camrig.CamrigError) as caught:
        rig.step(seconds=1)
    assert "pause" in str(caught.value)
    rig.pause()
    before = rig.status()["world_ns"]
    rig.step(nanoseconds=10**9)
    assert rig.status()["world_ns"] == before + 10**9
    rig.resume()
    assert not rig.status()["paused"]
