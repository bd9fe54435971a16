"""Cameras that take time to get where they are sent: every picture shows where they are at its instant."""

import math

import numpy as np
import pytest

import camrig
from conftest import REPOSITORY

SCENE = str(REPOSITORY / "scenes/minimal.json")
START = {"position": (-4, -4, 3), "pan_deg": 45, "tilt_deg": -20}


def pan_and_tilt_deg(pose):
    x, y, z, w = pose["orientation"]
    ahead = 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)
    return math.degrees(math.atan2(ahead[1], ahead[0])), math.degrees(math.asin(ahead[2]))


def sent(rig, name, **options):
    """A camera that zooms and turns for 1.5 s from world time 0.1 s on."""
    camera = rig.create_camera(name, size=(96, 64), vfov_deg=60, **START, **options)
    rig.step(seconds=0.1)
    reply = camera.set(position=(-4, -4, 3), pan_deg=20, tilt_deg=-10, vfov_deg=20, seconds=1.5)
    return camera, reply


@pytest.mark.parametrize("lens", [None, {"model": "plumb_bob", "coefficients": [-0.2, 0.05, 0, 0, 0]}])
def test_each_frame_is_where_the_camera_is_at_its_instant(lens):
    with camrig.start(SCENE, mode="lockstep") as rig:
        camera, reply = sent(rig, "mine", fps=30, **({"lens": lens} if lens else {}))
        assert reply["arrives_ns"] == 1_600_000_000
        first = camera.truth()["intrinsics"]["fx"]
        last = 32 / math.tan(math.radians(10))
        for _ in range(9):
            rig.step(nanoseconds=212_345_678)
            truth = camera.truth()
            share = min((truth["time_ns"] - 100_000_000) / 1.5e9, 1)
            assert truth["intrinsics"]["fx"] == pytest.approx(first * (last / first) ** share, rel=1e-12)
            assert pan_and_tilt_deg(truth["pose"]) == pytest.approx((45 - 25 * share, -20 + 10 * share), abs=1e-9)
        state = camera.get()
        assert state["vfov_deg"] == pytest.approx(20) and state["world_pose"]["pan_deg"] == pytest.approx(20)


def test_what_a_picture_shows_depends_on_its_instant_alone():
    """A camera of another rate, other steps and another run: the same pictures at the same times."""

    def pictures(fps, step_ns):
        with camrig.start(SCENE, mode="lockstep") as rig:
            camera, _ = sent(rig, "mine", fps=fps)
            seen = {}
            for _ in range(1_800_000_000 // step_ns):
                rig.step(nanoseconds=step_ns)
                frame = camera.frame()
                seen[frame.time_ns] = (frame.image, camera.truth()["pose"])
            return seen

    often, seldom = pictures(50, 20_000_000), pictures("25/3", 600_000_000)
    assert len(seldom) >= 3
    for time_ns, (image, pose) in seldom.items():
        assert np.array_equal(image, often[time_ns][0]), time_ns
        assert pose == often[time_ns][1]
    images = [image for image, _ in often.values()]
    assert sum((a != b).any() for a, b in zip(images, images[1:])) >= 70, "it moves in every picture"


def test_get_tells_what_is_now_and_what_it_tells_makes_a_camera_that_is_so():
    with camrig.start(SCENE, mode="lockstep") as rig:
        camera, _ = sent(rig, "mine", fps=25)
        rig.step(seconds=0.5)
        state = camera.get()
        truth = camera.truth()
        assert state["intrinsics"] == truth["intrinsics"]
        assert {key: state["world_pose"][key] for key in ("position", "orientation")} == truth["pose"]
        assert 20 < state["vfov_deg"] < 60
        twin = rig.call("camera.create", **{**state, "name": "twin"})
        assert twin["intrinsics"] == state["intrinsics"] and twin["pose"] == state["pose"]
        rig.step(seconds=0.1)
        assert rig.call("camera.get", name="twin")["intrinsics"] == state["intrinsics"], "and stands there"
        assert camera.get()["intrinsics"] != state["intrinsics"]


def test_an_event_moves_a_camera_in_its_time():
    with camrig.start(SCENE, mode="lockstep") as rig:
        camera = rig.create_camera("mine", size=(96, 64), fps=25, vfov_deg=60, **START)
        rig.call(
            "event.add",
            name="look",
            when={"at_s": 0.5},
            do=[{"action": "camera", "camera": "mine", "vfov_deg": 30, "pose": {"position": [0, 0, 5]}, "seconds": 1}],
        )
        rig.step(seconds=1)
        assert camera.get()["world_pose"]["position"] == pytest.approx([-2, -2, 4])
        rig.step(seconds=0.52)
        assert camera.get()["world_pose"]["position"] == [0, 0, 5]
        assert camera.get()["vfov_deg"] == pytest.approx(30)


@pytest.mark.parametrize("seconds", [-1, 1e6, "long"])
def test_wrong_seconds_are_an_error_that_changes_nothing(seconds):
    with camrig.start(SCENE, mode="lockstep") as rig:
        camera = rig.create_camera("mine", size=(96, 64), **START)
        before = camera.get()
        with pytest.raises(camrig.CamrigError, match="seconds"):
            rig.call("camera.set", name="mine", vfov_deg=30, seconds=seconds)
        assert camera.get() == before
