"""The scenes that come with the program: each starts and every one of its cameras and places shows something."""

import json
import subprocess

import cv2
import numpy as np
import pytest

import camrig
from camrig.projection import Projection
from conftest import REPOSITORY
from test_install import CAMRIG

SCENES = sorted(file.stem for file in (REPOSITORY / "scenes").glob("*.json") if file.stem != "schema")


def shows_something(image):
    """Large patches differ in brightness or colour: it is not one flat wall or empty sky."""
    small = cv2.resize(image, (16, 12), interpolation=cv2.INTER_AREA)
    return np.ptp(small.reshape(-1, 3).astype(int), axis=0).max() > 60


@pytest.mark.parametrize("name", SCENES)
def test_every_camera_and_place_of_a_scene_shows_it(name):
    file = REPOSITORY / "scenes" / f"{name}.json"
    text = json.loads(file.read_text())
    if "base" in text:
        base = json.loads((file.parent / text["base"]).read_text())
        text = base | {"actors": base["actors"] + text.get("actors", [])}
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


def below_the_horizon(cam):
    """Which pixels of a pinhole camera look down."""
    at = Projection.of(cam.get())
    height, width = cam.instances().shape
    v, u = np.mgrid[0:height, 0:width]
    rays = at.world_from_camera[:3, :3] @ np.linalg.inv(at.K) @ np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    return (rays[2] < 0).reshape(height, width)


def test_the_street_shows_people_on_the_crossing_while_cars_wait():
    with camrig.start(str(REPOSITORY / "scenes/street.json"), mode="lockstep") as rig:
        rig.create_camera("far", size=(1920, 1080), vfov_deg=42, position=(-47.5, 0, 5.6), look_at=(0, 0, 0.4))
        cameras = rig.cameras()
        door = rig.create_camera("door", size=(160, 120), vfov_deg=45, position=(-14, 4.5, 1.7), look_at=(-20, 9.6, 0.3))
        for cam in cameras:
            openings = np.argwhere((cam.instances() == 0) & below_the_horizon(cam))
            assert len(openings) == 0, f"{cam.name}: {len(openings)} pixels below the horizon are sky, the first (v, u) {openings[0]}"
        rig.step(seconds=12)
        assert (door.instances()[60:] != 0).all()  # no sky below a shop's door
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


def check(*words, cwd=None):
    return subprocess.run([CAMRIG, "check", *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=60, check=False)


def test_shipped_scenes_are_known_by_name_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clock").mkdir()  # what lies here does not change what the word means
    with camrig.start("clock", mode="lockstep") as rig:
        assert rig.status()["scene"] == "clock"
        assert rig.load("minimal")["scene"] == "minimal"
        with pytest.raises(camrig.CamrigError, match="there are: calibration, clock, crowd, hall, minimal, street") as caught:
            rig.load("hal")
        assert caught.value.kind == "not_found"
        errors = rig.call("scene.check", scene="calibration")["errors"]
        assert errors == [] and rig.status()["scene"] == "minimal"


def test_check_tells_every_error_at_once_and_loads_nothing(tmp_path):
    scene = {"camrig_scene": 1, "name": "x", "models": {"m": {"file": "gone.glb"}}, "cameras": [{"name": "Bad"}, {"name": "a", "fps": "0/1"}]}
    (tmp_path / "wrong.json").write_text(json.dumps(scene))
    (tmp_path / "no.glb").write_bytes(b"\x7fELF")
    done = check("wrong.json", cwd=tmp_path)
    lines = done.stderr.splitlines()
    assert done.returncode == 1 and len(lines) == 3
    for line, begin in zip(lines, ("models.m.file: ", "cameras[0].name: 'Bad'", "cameras[1].fps: '0/1' is not a frame rate")):
        assert line.startswith(f"wrong.json: {begin}")
    as_json = check("--json", "wrong.json", cwd=tmp_path)
    assert as_json.returncode == 1
    assert [error["path"] for error in json.loads(as_json.stdout)["errors"]] == ["models.m.file", "cameras[0].name", "cameras[1].fps"]
    assert "is neither .glb nor .gltf: 4 bytes that begin with '?ELF'" in check("no.glb", cwd=tmp_path).stderr
    assert check("minimal", cwd=tmp_path).returncode == 0


def test_a_scene_of_shapes_and_a_shipped_person_needs_no_file_beside_it(tmp_path):
    scene = {
        "camrig_scene": 1,
        "name": "own",
        "models": {
            "floor": {"shape": "ground", "size": [40, 40]},
            "crate": {"shape": "box", "size": [0.6, 0.4, 0.5]},
            "sky": {"shape": "sky", "radius_m": 100},
            "anna": {"file": "camrig:people/anna"},
        },
        "objects": [
            {"name": "floor", "model": "floor", "class": "ground"},
            {"name": "sky", "model": "sky", "class": "sky"},
            {"name": "crate", "model": "crate", "class": "box", "position": [4, 1, 0]},
        ],
        "actors": [{"name": "anna", "model": "anna", "class": "person", "position": [4, 0, 0], "yaw_deg": 180}],
        "lights": [{"name": "sun", "type": "directional", "direction": [1, 0.5, -1]}],
        "cameras": [{"name": "main", "size": [320, 240], "pose": {"position": [0, 0, 1.5], "look_at": [4, 0, 0.9]}}],
    }
    (tmp_path / "own.json").write_text(json.dumps(scene))
    with camrig.start(tmp_path / "own.json", mode="lockstep") as rig:
        rig.step(seconds=0.1)
        cam = rig.camera("main")
        truth = {item["name"]: item for item in cam.truth()["objects"]}
        assert {name: item["class"] for name, item in truth.items()} == {"floor": "ground", "sky": "sky", "crate": "box", "anna": "person"}
        assert truth["crate"]["dimensions"] == pytest.approx([0.6, 0.4, 0.5])
        ids = cam.instances()
        assert (ids != 0).all()  # there is no void: ground or sky everywhere
        image = cam.frame().image
        assert np.ptp(image[ids == truth["floor"]["id"]].astype(int), axis=0).min() > 30  # its grid
        depth = cam.depth()
        assert np.abs(depth[ids == truth["sky"]["id"]]).max() < 101
        assert depth[200, 160] == pytest.approx(2.824, rel=0.01)  # the floor is level, at z = 0


def test_a_bare_model_stands_on_a_ground_under_a_sky_unless_told_otherwise():
    box = REPOSITORY / "scenes/minimal/box.glb"
    with camrig.start(box, mode="lockstep") as rig:
        rig.step(seconds=0.1)
        cam = rig.cameras()[0]
        assert (cam.instances() != 0).all()
        assert {item["class"] for item in cam.truth()["objects"]} == {"object", "ground", "sky"}
        assert rig.call("world.load", scene=str(box), ground=False)["objects"] == 1
