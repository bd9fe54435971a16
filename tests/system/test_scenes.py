"""The scenes that come with the program: each starts and every one of its cameras and places shows something."""

import json

import cv2
import numpy as np
import pytest

import camrig
from conftest import REPOSITORY

SCENES = sorted(file.stem for file in (REPOSITORY / "scenes").glob("*.json") if file.stem != "schema")


def shows_something(image):
    """Large patches differ in brightness or colour: it is not one flat wall or empty sky."""
    small = cv2.resize(image, (16, 12), interpolation=cv2.INTER_AREA)
    return np.ptp(small.reshape(-1, 3).astype(int), axis=0).max() > 60


@pytest.mark.parametrize("name", SCENES)
def test_every_camera_and_place_of_a_scene_shows_it(name):
    file = REPOSITORY / "scenes" / f"{name}.json"
    text = json.loads(file.read_text())
    with camrig.start(str(file), mode="lockstep") as rig:
        cameras = rig.cameras()
        assert [camera.name for camera in cameras] == [camera["name"] for camera in text["cameras"]]
        cameras += [rig.create_camera(f"at_{place}", place=place, size=(320, 240)) for place in text.get("places", {})]
        rig.step(seconds=2)
        for camera in cameras:
            frame = camera.frame()
            assert frame.time_ns > 1_900_000_000
            assert shows_something(frame.image), f"{name}: {camera.name}"
        assert rig.status()["actors"] == len(text.get("actors", []))


def seen(cameras, object_class):
    return {item["name"] for camera in cameras for item in camera.truth()["objects"] if item["class"] == object_class and item["pixels"] > 60}


def test_the_street_shows_people_on_the_crossing_while_cars_wait():
    with camrig.start(str(REPOSITORY / "scenes/street.json"), mode="lockstep") as rig:
        cameras = rig.cameras()
        rig.step(seconds=12)
        fired = [event["event"] for event in rig.wait_events(timeout=0)["events"]]
        assert fired == ["red", "walk"]
        on_lanes = [a["name"] for a in rig.actors() if a["class"] == "person" and abs(a["position"][1]) < 3.3]
        assert len(on_lanes) >= 3
        assert len(seen(cameras, "person") & set(on_lanes)) >= 3
        assert len(seen(cameras, "car")) >= 8
        assert seen(cameras, "traffic_light") and all("red" in lamp for lamp in seen(cameras, "traffic_light"))
        near = [a for a in rig.actors() if a["class"] == "car" and abs(a["position"][0]) < 14 and abs(a["position"][1]) < 3]
        assert near and all(np.hypot(*a["velocity"][:2]) < 0.2 for a in near)
        rig.step(seconds=17)
        assert rig.wait_events(timeout=0)["events"][-1]["event"] == "green"
        cars = [a for a in rig.actors() if a["class"] == "car" and abs(a["position"][0]) < 40 and abs(a["position"][1]) < 3]
        assert any(np.hypot(*a["velocity"][:2]) > 3 for a in cars)


def test_the_crowd_is_a_hundred_people_and_most_are_seen():
    with camrig.start(str(REPOSITORY / "scenes/crowd.json"), mode="lockstep") as rig:
        rig.step(seconds=5)
        assert sum(actor["class"] == "person" for actor in rig.actors()) == 100
        assert len(seen(rig.cameras(), "person")) > 80
