"""Cameras that move a little before one photo, which the shapes of its place carry; shapes from depth images and glTF files; who stays on walkable ground."""

import json
import math
import os
import re
import subprocess

import cv2
import numpy as np
import pytest

import camrig
from conftest import REPOSITORY
from test_backdrops import CORNER, empty_street

CAMRIG = os.environ["CAMRIG_BIN"]
BACKDROPS = REPOSITORY / "docs" / "backdrops.md"


def taken_by(cam):
    """What a projected picture needs of the camera that took it."""
    told = cam.get()
    pose = {key: told["pose"][key] for key in ("position", "orientation")}
    return {"taken_from": pose, "intrinsics": told["intrinsics"]}


def off(a, b):
    return np.abs(a.astype(int) - b.astype(int)).max(-1)


def averaged(picture, factor):
    """The picture in a smaller size, each pixel the mean of the light under it, as a lens and a sensor have it."""
    value = np.arange(256) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)[picture]
    height, width = picture.shape[:2]
    light = linear.reshape(height // factor, factor, width // factor, factor, 3).mean((1, 3))
    return np.round(255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)).astype(np.uint8)


def enlarged(intrinsics, factor):
    """Of a picture with so many times the pixels."""
    return {key: factor * value + ((factor - 1) / 2 if key.startswith("c") else 0) for key, value in intrinsics.items()}


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_camera_moves_before_a_photo_as_before_the_street(rig, tmp_path):
    """From the photo's place it is the plate; moved by 30 cm it is the street seen from there, but for what the photo cannot show."""
    photo = tmp_path / "street.png"
    cv2.imwrite(str(photo), averaged(empty_street(rig, photo, size=(2560, 1920)), 2))
    proxies = {"scene": "proxies"}
    plate = rig.create_camera("plate", **CORNER, backdrop={"file": str(photo), "proxies": proxies})
    seen = rig.create_camera("seen", **CORNER)
    taken = taken_by(seen)
    # Those of the photo's own pixels, of which the stream has half as many; the mean of 16 of `fine` is what is right.
    fine = rig.create_camera("fine", size=(2560, 1920), fps=25, intrinsics=enlarged(taken["intrinsics"], 4), **taken["taken_from"])
    taken["intrinsics"] = enlarged(taken["intrinsics"], 2)
    cam = rig.create_camera("moves", **CORNER, backdrop={"kind": "projected", "file": str(photo), "proxies": proxies, **taken})
    rig.step(seconds=0.4)
    assert off(plate.frame().image, cam.frame().image).max() <= 1
    assert cam.truth()["objects"] == seen.truth()["objects"]
    truth = cam.truth()
    assert (truth["depth_source"], truth["backdrop"]) == ("proxy", {"kind": "projected", "file": str(photo)})
    pose = seen.get()["pose"]
    x, y, z = pose["position"]
    beside = {"position": [x + 0.2, y + 0.2, z + 0.1], "pan_deg": pose["pan_deg"] + 1, "tilt_deg": pose["tilt_deg"] - 1, "roll_deg": 0.5}
    for name in ("seen", "moves", "fine"):
        rig.call("camera.set", name=name, pose=beside, seconds=1)
    for seconds in (0.4, 1.0):
        rig.step(seconds=seconds)
        for kind in ("depth", "instance", "semantic", "normal"):
            assert np.array_equal(seen.frame(kind=kind).image, cam.frame(kind=kind).image), kind
        assert cam.truth()["objects"] == seen.truth()["objects"]
        street, projected = averaged(fine.frame().image, 4), cam.frame().image
        difference = off(street, projected)
        assert np.mean(difference <= 8) > 0.93, np.mean(difference <= 8)
        assert difference.mean() < off(street, plate.frame().image).mean() / 3
    # Where it differs is what the photo does not show, or detail as small as its pixels.
    took = rig.create_camera("took", size=(1280, 960), intrinsics=taken["intrinsics"], **taken["taken_from"], fps=25,
                             backdrop={"file": str(photo), "proxies": proxies})
    rig.step(seconds=0.04)
    guide = {}
    exec(re.search(r"```python\n(import numpy as np\n\ndef seen_by_photo.*?)```", BACKDROPS.read_text(), re.DOTALL)[1], guide)
    seen_there = guide["seen_by_photo"](cam, took)
    difference = off(averaged(fine.frame().image, 4), cam.frame().image)
    nobody = ~np.isin(cam.frame(kind="instance").image, [actor["id"] for actor in rig.actors()])
    assert 0.01 < np.mean(~seen_there) < 0.2, np.mean(~seen_there)
    of_seen, of_unseen = difference[nobody & seen_there], difference[nobody & ~seen_there]
    # Not 99 %: what is finer than a pixel of the photo (frames of windows far away, joints of stones) is blurred by its bilinear samples, and so is each
    # edge. With one row of samples, or a photo of the stream's own size, it is 90 %.
    assert np.mean(of_seen <= 8) > 0.95 and of_unseen.mean() > 3 * of_seen.mean(), (np.mean(of_seen <= 8), of_seen.mean(), of_unseen.mean())
    # It may be knocked and shaken, mounted and turned by a head.
    rig.fault.set("moves", "knock")
    rig.step(seconds=0.2)
    with pytest.raises(camrig.CamrigError, match="has a backdrop"):
        rig.fault.set("plate", "knock")


def test_what_a_projected_picture_lacks_is_said_with_its_place(rig, tmp_path):
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), np.full((480, 640, 3), 90, np.uint8))
    ground = {"ground": {"polygon_m": [[1, -9], [30, -9], [30, 9]]}}
    good = {"kind": "projected", "file": str(photo), "proxies": ground, "taken_from": {"position": [0, 0, 2]},
            "intrinsics": {"fx": 500, "fy": 500, "cx": 319.5, "cy": 239.5}}

    def refused(without=None, **more):
        backdrop = {key: value for key, value in {**good, **more}.items() if key != without}
        with pytest.raises(camrig.CamrigError) as error:
            rig.call("camera.create", name="gate", pose={"position": [0, 0, 2]}, backdrop=backdrop)
        return error.value.message

    assert "backdrop.taken_from: is missing" in refused("taken_from")
    assert "backdrop.intrinsics: is missing" in refused("intrinsics")
    assert "backdrop.taken_from: is that of a projected picture, and the kind is plate" in refused(kind="plate")
    assert "backdrop.lens.model: " in refused(lens={"model": "glass"})
    rig.create_camera("gate", position=(0, 0, 2), pan_deg=0, backdrop=good)
    rig.call("camera.set", name="gate", pose={"position": [0.1, 0, 2], "pan_deg": 3}, zoom=1.5)
    told = rig.call("camera.get", name="gate")
    rig.call("camera.create", **{**told, "name": "again"})
    assert rig.call("camera.get", name="again")["backdrop"] == told["backdrop"]


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_depth_image_hides_who_goes_behind(rig, tmp_path):
    """The photo's depth as camrig itself tells it, for all shapes: who is hidden and how far away things are is as in the street, within what its numbers can say."""
    photo, depth = tmp_path / "street.png", tmp_path / "depth.png"
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    before = rig.create_camera("before", **CORNER)
    rig.step(seconds=0.04)
    cv2.imwrite(str(photo), before.frame().image)
    metres = before.depth()
    cv2.imwrite(str(depth), np.where(metres < 65, np.round(metres * 1000), 0).astype(np.uint16))
    rig.load("street")
    seen = rig.create_camera("seen", **CORNER)
    proxies = {"scene": "hidden", "depth": {"file": str(depth)}}
    shown = rig.create_camera("shown", **CORNER, backdrop={"file": str(photo), "proxies": proxies})
    people = 0
    for _ in range(5):
        rig.step(seconds=0.4)
        ids = seen.frame(kind="instance").image
        wanted = np.where(np.isin(ids, [actor["id"] for actor in rig.actors()]), ids, 0)
        got = shown.frame(kind="instance").image
        both = (wanted != 0) | (got != 0)
        # Feet stand within half a per cent of the ground, and a wheel within its kerb.
        assert np.mean((wanted == got)[both]) > 0.95, np.mean((wanted == got)[both])
        known = (wanted == 0) & (got == 0) & (seen.depth() < 65)
        there, told = seen.depth()[known], shown.depth()[known]
        near = np.abs(told - there) / there
        assert np.quantile(near, 0.99) < 0.0035 and near.mean() < 0.002
        people += sum(one["class"] == "person" and one["pixels"] > 100 for one in shown.truth()["objects"])
    assert people > 5
    assert shown.truth()["depth_source"] == "proxy"

    def refused(**wrong):
        with pytest.raises(camrig.CamrigError) as error:
            rig.call("camera.create", name="other", place="corner", size=[640, 480],
                     backdrop={"file": str(photo), "proxies": {"depth": {"file": str(depth), **wrong}}})
        return error.value.message

    small, colour = tmp_path / "small.png", tmp_path / "colour.png"
    cv2.imwrite(str(small), np.full((48, 64), 900, np.uint16))
    cv2.imwrite(str(colour), np.full((480, 640, 3), 90, np.uint8))
    assert "backdrop.proxies.depth.file: " in refused(file=str(small)) and "is 64x48, and the picture is 640x480" in refused(file=str(small))
    assert "has to be gray, of 16 bits" in refused(file=str(colour))
    assert "backdrop.proxies.depth.unit_m: " in refused(unit_m=0)


PLACE = {"ground": {"polygon_m": [[1, -9], [30, -9], [30, 9], [1, 9]]}, "walkable": [{"polygon_m": [[4, -4], [12, -4], [12, 4], [4, 4]]}]}


def gate(tmp_path, **more):
    """A scene with a photo and walkable ground, loaded by a rig."""
    cv2.imwrite(str(tmp_path / "gate.png"), np.full((480, 640, 3), 90, np.uint8))
    scene = {"camrig_scene": 1, "name": "gate", "models": {"anna": {"file": "camrig:people/anna"}},
             "actors": [{"name": "anna", "model": "anna", "class": "person", "position": [6, 0, 0]}],
             "cameras": [{"name": "gate", "size": [640, 480], "vfov_deg": 48, "pose": {"position": [0, 0, 4.2], "tilt_deg": -14},
                          "backdrop": {"file": "gate.png", "proxies": PLACE}}], **more}
    file = tmp_path / "gate.json"
    file.write_text(json.dumps(scene))
    return file


def test_people_that_commands_make_or_move_stay_on_what_is_walkable(rig, tmp_path):
    rig.load(str(gate(tmp_path)))
    said = "is outside of what is walkable (cameras[0].backdrop.proxies.walkable)"

    def refused(method, **params):
        with pytest.raises(camrig.CamrigError) as error:
            rig.call(method, **params)
        assert said in str(error.value), error.value
        return error.value.message

    anna = {"model": "anna", "class": "person"}
    assert refused("actor.spawn", name="bea", position=[2, 0, 0], **anna).startswith("position: ")
    assert refused("actor.spawn", name="bea", position=[5, 0, 0], **anna, behaviour={"type": "go_to", "position": [13, 0, 0]}).startswith("behaviour.position: ")
    assert refused("actor.set", name="anna", position=[6, 5, 0]).startswith("position: ")
    assert refused("actor.set", name="anna", behaviour={"type": "go_to", "position": [20, 0, 0]}).startswith("behaviour.position: ")
    assert refused("actor.steer", actors=[{"name": "anna", "position": [6, 5, 0], "seconds": 1}]).startswith("actors[0].position: ")
    rig.call("actor.set", name="anna", position=[11.9, 3.9, 0])
    rig.call("actor.spawn", name="bea", position=[5, 0, 0], **anna, behaviour={"type": "go_to", "position": [11, 0, 0]})
    # A drone, or a car on its road, is nobody who walks.
    rig.call("actor.spawn", name="drone", model="anna", **{"class": "drone"}, position=[2, 0, 5])
    rig.call("actor.set", name="drone", position=[50, 0, 5])


def test_people_of_a_scene_file_stand_on_what_is_walkable(tmp_path):
    wrong = gate(tmp_path, actors=[{"name": "anna", "model": "anna", "class": "person", "position": [2, 0, 0]},
                                   {"name": "bea", "model": "anna", "class": "person", "position": [6, 0, 0], "behaviour": {"type": "go_to", "position": [6, 9, 0]}}])
    checked = subprocess.run([CAMRIG, "check", str(wrong)], capture_output=True, text=True, timeout=60, check=False)
    assert checked.returncode == 1
    assert "actors[0].position: is outside of what is walkable" in checked.stdout + checked.stderr
    assert "actors[1].behaviour.position: is outside of what is walkable" in checked.stdout + checked.stderr


def test_other_programs_files_of_a_camera_are_taken_by_the_method(rig):
    ros = ("image_width: 800\nimage_height: 600\ncamera_name: gate\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 399.5, 0, 500, 299.5, 0, 0, 1]}\n"
           "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0, 0, 0, 0]}\n")
    pose = {"position": [0, 0, 4], "pan_deg": 3, "tilt_deg": -20}
    camera = {"size": [800, 600], "intrinsics": {"fx": 500, "fy": 500, "cx": 399.5, "cy": 299.5}, "lens": {"model": "plumb_bob", "coefficients": [-0.1, 0, 0, 0, 0]}, "pose": pose}
    places = [[6, 2, 0], [6, -2, 0], [14, -5, 0], [14, 6, 0], [9, 1, 2.5]]
    clicks = [{"px": px, "m": m} for px, m in zip(rig.call("plate.project", camera=camera, points=places)["px"], places)]
    found = rig.calibrate_plate((800, 600), points=clicks, camera_files={"gate.yaml": ros})
    assert found["camera"]["pose"]["position"] == pytest.approx(pose["position"], abs=1e-4)
    assert found["camera"]["lens"] == camera["lens"]
    fspy = json.dumps({"principalPoint": {"x": 0, "y": 0}, "imageWidth": 800, "imageHeight": 600, "horizontalFieldOfView": 2 * math.atan(0.8),
                       "cameraTransform": {"rows": [[1, 0, 0, 1], [0, 0, -1, -5], [0, 1, 0, 2], [0, 0, 0, 1]]}})
    known = rig.call("plate.calibrate", camera_files={"a.fspy.json": fspy})
    assert known["verdict"] == "unknown" and known["camera"]["pose"]["position"] == pytest.approx([1, -5, 2]) and "ground" in known
    colmap = {"cameras.txt": "1 PINHOLE 800 600 500 500 400 300\n", "images.txt": "1 1 0 0 0 0 0 0 1 a.jpg\n\n2 1 0 0 0 0 0 0 1 b.jpg\n\n"}
    assert rig.call("plate.calibrate", camera_files=colmap, camera_image="b.jpg")["camera"]["intrinsics"]["cx"] == 399.5

    def refused(**params):
        with pytest.raises(camrig.CamrigError) as error:
            rig.call("plate.calibrate", **params)
        return error.value.message

    assert refused(camera_files=colmap).startswith("camera_files: images.txt: name the image")
    assert "and this one is 600x800" in refused(size=[600, 800], camera_files={"a.json": fspy})
    assert refused(size=[800, 600], camera_files=["a.json"]).startswith("camera_files: expected an object")
    assert refused(size=[800, 600], points=clicks, camera_image="b.jpg").startswith("camera_image: is that of camera_files")
    assert refused(points=clicks).startswith("size: ")
