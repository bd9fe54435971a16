"""Lockstep: the world moves by steps only, and the same commands give the same bytes."""

import hashlib
import os
import threading
import time

import pytest

import camrig
from conftest import stuck_mjpeg_reader, wait_until


def run_once(scenes):
    """Hashes of every frame of two moving-world cameras over a second, with a camera moved in the middle."""
    digest = hashlib.sha256()
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=7) as rig:
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


def test_runs_are_identical_also_with_another_thread_count(scenes):
    """The threads that draw are as many as cores; with one core to run on there is one."""
    digests = [run_once(scenes)]
    everywhere = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(everywhere)})  # the rig inherits it
    try:
        digests.append(run_once(scenes))
    finally:
        os.sched_setaffinity(0, everywhere)
    assert digests[0] == digests[1]


# What the C library finds on a processor without fused multiply-add: other variants of sin, cos, atan2, log, pow, ...
WITHOUT_FMA = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-AVX2,-AVX2_Usable,-FMA_Usable,-FMA4,-AVX"}


#: One of each part of the arithmetic of cameras: lenses, `beautiful`, a head under way, a sensor with all its noise.
CAMERAS = {
    "fisheye": {"lens": {"model": "equidistant", "coefficients": [0.02, -0.01, 0.003, -0.001]}, "intrinsics": {"fx": 45, "fy": 45, "cx": 79.5, "cy": 59.5}},
    "plumb_bob": {"lens": {"model": "plumb_bob", "coefficients": [-0.28, 0.07, 0.001, -0.0005, 0]}, "hfov_deg": 80},
    "beautiful": {"quality": "beautiful"},
    "head": {"ptz": {"preset": "dome", "seed": 3}},
    "sensor": {"sensor": {"preset": "imx219", "exposure_s": 0.004}},
}


def pictures(rig):
    """Of each of CAMERAS what its picture, its depth and its truth say, by their bytes."""
    cameras = [rig.create_camera(name, size=(160, 120), fps=10, place="west", **how) for name, how in CAMERAS.items()]
    rig.camera("head").ptz.move(pan_deg=40, tilt_deg=-15, zoom=2)
    rig.step(seconds=0.7)  # the head is on its way
    found = {}
    for cam in cameras:
        kinds = ["color", "depth"] + ["sensor"] * (cam.name == "sensor")
        for kind in kinds:
            found[cam.name, kind] = hashlib.sha256(cam.frame(kind=kind).image.tobytes()).hexdigest()
        found[cam.name, "truth"] = {key: value for key, value in cam.truth().items() if key not in ("monotonic_ns", "steady_ns")}
    return found


def test_the_world_is_the_same_on_a_processor_without_fused_multiply_add(scenes):
    """On one that has none anyhow both runs are the same run."""

    def state(environment):
        with camrig.start(str(scenes / "crowd.json"), mode="lockstep", seed=1, env=environment) as rig:
            rig.step(seconds=60)
            status = rig.status()
            return {"world_ns": status["world_ns"], "state_hash": status["state_hash"], **pictures(rig)}

    assert state({}) == state(WITHOUT_FMA)


@pytest.mark.camrig(scene="scenes/crowd.json", mode="lockstep")
def test_a_step_of_hours_lets_commands_through_and_ends_with_the_rig(rig):
    """No camera is watched: nothing to draw, yet a day of a crowd's steps is the work of an hour."""
    outcome = []

    def step():
        try:
            rig.step(seconds=24 * 3600, timeout=60)
        except camrig.CamrigError as error:
            outcome.append(error.kind)

    stepping = threading.Thread(target=step, daemon=True)
    with camrig.connect(control=rig.call("server.info")["control"]) as second:
        stepping.start()
        wait_until(lambda: second.status()["world_ns"] > 0, what="the step to begin")
        first = second.status()["world_ns"]
        wait_until(lambda: second.status()["world_ns"] > first, what="the world to go on between two answers")
        second.call("server.shutdown")
    stepping.join(20)
    assert not stepping.is_alive()
    assert outcome


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
    for _ in range(3):  # on a machine that holds the rig up for a second it is first its encoding that is named
        with pytest.raises(camrig.CamrigError) as caught:
            rig.call("world.step", seconds=5, timeout_s=1)
        assert caught.value.kind == "unavailable"
        if "encoding of camera" not in str(caught.value):
            break
    assert str(raw.getsockname()[1]) in str(caught.value)
    raw.close()
    rig.step(seconds=0.1)  # the rig goes on


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_stepping_too_far_or_backwards_is_refused(rig):
    for bad in ({"seconds": -1}, {"seconds": 1e9}, {"nanoseconds": -5}, {}, {"seconds": 1, "nanoseconds": 1}, {"seconds": "1"}):
        with pytest.raises(camrig.CamrigError) as caught:
            rig.call("world.step", **bad)
        assert caught.value.kind == "invalid_argument"
    with pytest.raises(camrig.CamrigError, match="^invalid_argument: seconds: "):  # in the unit that was given
        rig.step(seconds=-1)
    rig.call("world.step", nanoseconds=1)
    assert rig.status()["world_ns"] == 1
    rig.step(seconds=1 / 3)
    assert rig.status()["world_ns"] == 333_333_334


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
