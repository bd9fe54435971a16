"""The truth against computations that share nothing with camrig: OpenCV's projection of a mesh posed in numpy, worlds with the
other objects taken away, planes and spheres, differences of positions."""

import json
import shutil
import subprocess
import urllib.request

import numpy as np
import pytest

import camrig
import posed_gltf
from conftest import REPOSITORY

COCO = ["nose", "left_eye", "right_eye", "left_ear", "right_ear", "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
        "left_wrist", "right_wrist", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle"]
PEOPLE = {
    # name: model, position, yaw, clip. Eva is near, Max half behind her, Ada apart from both, Bob hidden by the wall.
    "eva": ("person_9", [5.0, 0.2, 0.0], 170.0, "talk"),
    "max": ("person_4", [6.5, 0.55, 0.0], 200.0, "wait"),
    "ada": ("person_1", [7.0, -2.0, 0.0], -20.0, "idle"),
    "bob": ("person_2", [12.0, 3.2, 0.0], 90.0, "idle"),
}
CAMERA = dict(size=(640, 480), vfov_deg=50, position=(0.3, 0.1, 1.9), look_at=(6, -0.3, 0.9))
LENSES = {
    "pinhole": None,
    "barrel": {"model": "plumb_bob", "coefficients": [-0.28, 0.07, 0.0005, -0.0008, 0.0]},
}


def write_scene(folder, people=PEOPLE, extra_objects=(), models=()):
    """A floor, a wall, and these people standing on it."""
    scene = {
        "camrig_scene": 1, "name": "truth",
        "models": {"wall": {"file": "wall.glb"}},
        "objects": [{"name": "wall", "model": "wall", "class": "wall", "position": [10, 3, 0]}],
        "lights": [{"name": "sun", "type": "directional", "intensity": 0.8, "direction": [0.4, 0.6, -1]}],
        "actors": [],
    }
    posed_gltf.write_glb(folder / "wall.glb", [[0, 0, 1.5], [0, 3, 1.5], [0, 3, -1.5], [0, 0, -1.5]], [[0, 1, 2], [0, 2, 3]])
    for name, (model, position, yaw, clip) in people.items():
        shutil.copy(REPOSITORY / "scenes" / "hall" / f"{model}.glb", folder)
        scene["models"][model] = {"file": f"{model}.glb", "front": "+z"}
        scene["actors"].append({"name": name, "model": model, "class": "person", "position": position, "yaw_deg": yaw,
                                "behaviour": {"type": "stand", "clip": clip}})
    scene["models"].update({name: {"file": file} for name, file in models})
    scene["objects"] += extra_objects
    path = folder / "scene.json"
    path.write_text(json.dumps(scene))
    return path


def by_name(truth):
    return {item["name"]: item for item in truth["objects"]}


def world_of(name, points):
    """World places of points of a person's model."""
    _, position, yaw, _ = PEOPLE[name]
    return points @ (posed_gltf.about_z(yaw) @ posed_gltf.about_z(90)).T + position


@pytest.fixture(scope="module", params=LENSES)
def scene(request, tmp_path_factory):
    """A stepped world of people, its truth, and the posed models; once for all tests."""
    folder = tmp_path_factory.mktemp("truth")
    with camrig.start(write_scene(folder), mode="lockstep") as rig:
        options = {"lens": LENSES[request.param]} if LENSES[request.param] else {}
        cam = rig.create_camera("eye", fps=25, **CAMERA, **options)
        rig.step(seconds=1.24)
        yield rig, cam, cam.truth()


def report(what, differences):
    """For the table in docs/truth.md (pytest -s)."""
    print(f"{what}: largest {np.max(differences):.1e}, mean {np.mean(differences):.1e}, of {np.size(differences)}")


def test_boxes_and_keypoints_are_those_of_opencv(scene):
    rig, cam, truth = scene
    assert truth["time_ns"] == 1_240_000_000
    boxes, points, centers = [], [], []
    for name, (model, position, yaw, clip) in PEOPLE.items():
        if name == "bob":
            continue
        told = by_name(truth)[name]
        glb = posed_gltf.Glb(REPOSITORY / "scenes" / "hall" / f"{model}.glb")
        seconds = (truth["time_ns"] / 1e9) % glb.clip_duration(clip)
        surface = world_of(name, glb.surface(clip, seconds))
        pixels = posed_gltf.project(truth, surface)
        low, high = pixels.min(0), pixels.max(0)
        boxes.append(np.abs(np.r_[low, high - low] - told["box_full"]))
        named = glb.keypoints(clip, seconds)
        for keypoint, (x, y, v), place in zip(COCO, told["keypoints"], told["keypoints_world"]):
            expected = world_of(name, named[keypoint][None])
            points.append(np.abs(posed_gltf.project(truth, expected)[0] - [x, y]))
            np.testing.assert_allclose(place, expected[0], atol=1e-5)
        own = (surface - position) @ posed_gltf.about_z(yaw)
        np.testing.assert_allclose(told["dimensions"], own.max(0) - own.min(0), atol=1e-4)
        center = posed_gltf.about_z(yaw) @ (0.5 * (own.max(0) + own.min(0))) + position
        centers.append(np.abs(center - told["center"]))
        np.testing.assert_allclose(told["position"], position, atol=1e-12)
        np.testing.assert_allclose(posed_gltf.rotation(told["orientation"]), posed_gltf.about_z(yaw), atol=1e-12)
    report("boxes, px", boxes)
    report("keypoints, px", points)
    report("3D centres, m", centers)
    assert np.max(boxes) < 0.1 and np.max(points) < 0.01 and np.max(centers) < 1e-4


def test_what_nobody_wears_is_in_no_box(tmp_path):
    """A full box is as the visible one of somebody who stands alone, in whatever clothes."""
    apart = []
    for variant in range(6):
        folder = tmp_path / str(variant)
        folder.mkdir()
        path = write_scene(folder, people={"eva": PEOPLE["eva"]})
        scene = json.loads(path.read_text())
        scene["objects"], scene["actors"][0]["variant"] = [], variant
        path.write_text(json.dumps(scene))
        with camrig.start(path, mode="lockstep") as rig:
            cam = rig.create_camera("eye", fps=25, size=(640, 480), vfov_deg=30, position=(0.3, 0.1, 1.2), look_at=(5, 0.2, 1))
            rig.step(seconds=0.2)
            (told,) = cam.truth()["objects"]
            x, y, w, h = told["box"]
            # Middles of pixels lie up to half a pixel within.
            apart.append(np.abs(np.array([x - 0.5, y - 0.5, x + w - 0.5, y + h - 0.5]) - np.r_[told["box_full"][:2], np.add(told["box_full"][:2], told["box_full"][2:])]).max())
    print(f"visible boxes and full ones: up to {max(apart):.2f} px apart")
    assert max(apart) < 1.5, apart


def test_visible_boxes_and_pixels_are_those_of_the_instance_picture(scene):
    rig, cam, truth = scene
    ids, classes = cam.instances(), cam.frame(kind="semantic").image
    assert set(np.unique(ids)) - {0} == {item["id"] for item in truth["objects"] if item["pixels"]}
    for item in truth["objects"]:
        mask = ids == item["id"]
        assert item["pixels"] == mask.sum()
        if not mask.any():
            assert item["box"] is None
            continue
        rows, columns = np.nonzero(mask)
        assert item["box"] == [columns.min(), rows.min(), columns.max() - columns.min() + 1, rows.max() - rows.min() + 1]
        assert item["class_number"] == truth["classes"][item["class"]]
        assert (classes[mask] == item["class_number"]).all()
        # What is seen lies inside of the full box, but for the half pixel that a centre may be from an edge.
        x, y, w, h = item["box_full"]
        assert x - 0.6 < columns.min() and columns.max() < x + w + 0.6 and y - 0.6 < rows.min() and rows.max() < y + h + 0.6
    assert (classes[ids == 0] == 0).all()


def test_occlusion_is_what_worlds_without_the_others_show(scene, tmp_path):
    rig, cam, truth = scene
    told, ids = by_name(truth), cam.instances()
    lens = {} if truth["lens"]["model"] == "pinhole" else {"lens": truth["lens"]}
    for name in PEOPLE:
        folder = tmp_path / name
        folder.mkdir()
        path = write_scene(folder, people={name: PEOPLE[name]})
        scene = json.loads(path.read_text())
        scene["objects"] = []
        path.write_text(json.dumps(scene))
        with camrig.start(path, mode="lockstep") as alone:
            eye = alone.create_camera("eye", fps=25, **CAMERA, **lens)
            alone.step(seconds=1.24)
            mask = eye.instances() != 0
        assert told[name]["pixels_alone"] == mask.sum()
        assert told[name]["visible_fraction"] == (mask & (ids == told[name]["id"])).sum() / mask.sum()
        assert (mask[ids == told[name]["id"]]).all()
        others = ids[mask & (ids != told[name]["id"])]
        expected = None if others.size == 0 else np.bincount(others[others != 0]).argmax()
        assert told[name]["occluded_by"] == expected
    assert told["eva"]["visible_fraction"] == 1 and told["ada"]["visible_fraction"] == 1
    assert 0.2 < told["max"]["visible_fraction"] < 0.9 and told["max"]["occluded_by"] == told["eva"]["id"]
    assert told["bob"]["visible_fraction"] == 0 and told["bob"]["occluded_by"] == told["wall"]["id"] and told["bob"]["box"] is None


def test_keypoints_know_what_hides_them(scene):
    rig, cam, truth = scene
    told, depth = by_name(truth), cam.depth()
    ids = cam.instances()
    points = dict(zip(COCO, told["eva"]["keypoints"]))
    # Eva looks at the camera, Ada away from it.
    assert all(points[name][2] == 2 for name in ("nose", "left_eye", "right_eye", "left_shoulder", "right_shoulder", "left_knee"))
    assert all(dict(zip(COCO, told["ada"]["keypoints"]))[name][2] == 1 for name in ("nose", "left_eye", "right_eye"))
    assert all(v == 1 for _, _, v in told["bob"]["keypoints"])
    seen = {v for _, _, v in told["max"]["keypoints"]}
    assert seen == {1, 2}
    # All of them anew from the pictures: what lies nearer at a point's pixel hides it; its own body only if it is nearer by
    # more than the skin or the limbs are thick.
    eye, ahead = np.array(truth["pose"]["position"]), posed_gltf.rotation(truth["pose"]["orientation"])[:, 0]
    hidden_by_others = 0
    for item in (told[name] for name in PEOPLE):
        for i, ((x, y, v), place) in enumerate(zip(item["keypoints"], item["keypoints_world"])):
            if not (-0.5 <= x < 639.5 and -0.5 <= y < 479.5):
                assert v == 0
                continue
            row, column = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
            is_own = ids[row, column] == item["id"]
            tolerance = (0.05 if i < 5 else 0.15) if is_own else 0.0
            assert v == (2 if depth[row, column] >= (np.array(place) - eye) @ ahead - tolerance else 1), (item["name"], COCO[i])
            hidden_by_others += v == 1 and not is_own
    assert hidden_by_others >= 17  # all of Bob's


def test_truncation_is_the_share_of_the_full_box_outside(tmp_path):
    with camrig.start(write_scene(tmp_path, people={"eva": PEOPLE["eva"]}), mode="lockstep") as rig:
        cam = rig.create_camera("near", size=(320, 240), vfov_deg=40, position=(2.5, 0, 1.6), look_at=(5, 0.75, 1.6))
        told = by_name(cam.truth())["eva"]
        x, y, w, h = told["box_full"]
        inside = (min(x + w, 319.5) - max(x, -0.5)) * (min(y + h, 239.5) - max(y, -0.5))
        assert 0.2 < told["truncated"] < 0.9
        assert told["truncated"] == pytest.approx(1 - inside / (w * h), abs=1e-12)
        assert not told["clipped"]
        assert {v for _, _, v in told["keypoints"]} >= {0, 2}
        whole = by_name(rig.create_camera("whole", fps=25, **CAMERA).truth())["eva"]
        assert whole["truncated"] == 0 and 0 not in {v for _, _, v in whole["keypoints"]}


def test_identity_is_the_same_in_all_cameras(scene):
    rig, cam, truth = scene
    back = rig.create_camera("back", size=(320, 240), vfov_deg=60, position=(15, 5, 2.5), look_at=(9, 1.5, 1))
    other = by_name(back.truth())
    assert other["bob"]["pixels"] > 0
    for name, item in by_name(truth).items():
        if name in other:
            for key in ("id", "class", "position", "orientation", "dimensions", "velocity", "center"):
                assert other[name][key] == item[key]
    back.delete()


def test_depth_of_planes_and_spheres_is_analytic(tmp_path):
    positions, indices = posed_gltf.sphere()
    posed_gltf.write_glb(tmp_path / "sphere.glb", positions, indices)
    # A plane that leans away: through (9, 0, 0), 30 degrees off the vertical.
    lean = np.radians(30)
    corners = [[0 + y * np.sin(lean), y * np.cos(lean), z] for y in (-20, 20) for z in (-20, 20)]
    posed_gltf.write_glb(tmp_path / "plane.glb", corners, [[0, 1, 3], [0, 3, 2]])
    path = write_scene(tmp_path, people={}, models=[("sphere", "sphere.glb"), ("plane", "plane.glb")], extra_objects=[
        {"name": "ball", "model": "sphere", "position": [5, 0.4, 1.2]}, {"name": "plane", "model": "plane", "position": [9, 0, 0]}])
    with camrig.start(path, mode="lockstep") as rig:
        cam = rig.create_camera("eye", size=(640, 480), vfov_deg=50, position=(0.3, 0.1, 1.9), look_at=(6, -0.3, 0.9))
        truth, depth, ids = cam.truth(), cam.depth().astype(float), cam.instances()
    k = truth["intrinsics"]
    columns, rows = np.meshgrid(np.arange(640), np.arange(480))
    link = posed_gltf.rotation(truth["pose"]["orientation"])
    world_from_optical = np.stack([-link[:, 1], -link[:, 2], link[:, 0]], 1)
    rays = np.stack([(columns - k["cx"]) / k["fx"], (rows - k["cy"]) / k["fy"], np.ones((480, 640))], -1) @ world_from_optical.T
    eye = np.array(truth["pose"]["position"])

    normal = np.array([np.cos(lean), 0, -np.sin(lean)])
    plane = (normal @ (np.array([9, 0, 0]) - eye)) / (rays @ normal)
    on_plane = ids == by_name(truth)["plane"]["id"]
    plane_error = np.abs(depth / plane - 1)[on_plane]

    center = np.array([5, 0.4, 1.2]) - eye
    a, b, c = (rays**2).sum(-1), rays @ center, center @ center - 1
    root = b * b - a * c
    ball = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
    hit = rays * ball[..., None] - center
    facing = -(hit * rays).sum(-1) / np.sqrt(a)  # cosine of the angle to the surface; towards the rim the mesh is no sphere
    on_ball = (ids == by_name(truth)["ball"]["id"]) & (facing > 0.7)
    ball_error = np.abs(depth / ball - 1)[on_ball]
    report("depth of a plane, relative", plane_error)
    report("depth of a sphere, relative", ball_error)
    assert on_plane.sum() > 100_000 and on_ball.sum() > 5000
    assert plane_error.max() < 1e-5 and ball_error.max() < 1e-5
    assert np.isinf(depth[ids == 0]).all()


def test_velocity_is_the_difference_of_positions():
    with camrig.start(REPOSITORY / "scenes" / "hall.json", mode="lockstep") as rig:
        cam = rig.create_camera("all", size=(64, 48), fps=1000, vfov_deg=100, position=(2, 3, 4), look_at=(14, 8, 0))
        rig.step(nanoseconds=2_003_000_000)
        truths = [by_name(cam.truth())]
        for _ in range(3):
            rig.step(nanoseconds=1_000_000)
            truths.append(by_name(cam.truth()))
        moving = [name for name, item in truths[0].items() if np.linalg.norm(item["velocity"]) > 0.5]
        assert len(moving) >= 5
        differences = []
        for name in moving:
            for before, after in zip(truths, truths[1:]):  # within one step of 10 ms the world moves on straight lines
                moved = np.subtract(after[name]["position"], before[name]["position"]) / 1e-3
                differences.append(np.abs(moved - after[name]["velocity"]))
        report("velocity, m/s", differences)
        assert np.max(differences) < 1e-6


def test_truth_comes_by_http_and_the_command_line_too(scene):
    rig, cam, truth = scene
    with urllib.request.urlopen(f"{rig.http_url}/cameras/eye/truth") as reply:
        assert reply.headers["content-type"].startswith("application/json")
        assert json.load(reply) == truth
    control = rig.info()["control"]
    run = subprocess.run([camrig.find_binary(), "truth", "eye", "--json", "--control", control], capture_output=True, text=True, check=True)
    assert json.loads(run.stdout) == truth
    words = subprocess.run([camrig.find_binary(), "truth", "eye", "--control", control], capture_output=True, text=True, check=True).stdout
    assert "eva" in words and "hidden" in words
    with pytest.raises(camrig.CamrigError) as caught:
        rig.call("truth.get", camera="nobody")
    assert caught.value.kind == "not_found"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_truth_costs_nothing_when_nobody_asks(rig):
    def truths():
        stages = {stage["name"]: stage["count"] for stage in rig.stats()["stages"]}
        return stages["truth"], stages["draw"]

    cam = rig.create_camera("a", size=(160, 120), fps=25)
    start = truths()
    for _ in range(10):
        rig.step(seconds=0.04)
        cam.frame()
    made, draws = truths()
    assert made == 0 and draws - start[1] == 10  # one draw a frame, none of them for truth
    cam.truth()
    assert truths()[0] == 1


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_truth_waits_for_its_instant(rig):
    cam = rig.create_camera("a", size=(64, 48), fps=25)
    rig.step(seconds=0.08)
    assert cam.truth(min_ns=80_000_000)["time_ns"] == 80_000_000
    with pytest.raises(camrig.CamrigError, match="stands still"):
        rig.client.call("truth.get", {"camera": "a", "min_ns": 10**12}, timeout_s=20)
