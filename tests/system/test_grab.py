"""Rig.grab, Camera.project and the calibration of a camera in Python, at a real rig."""

import cv2
import numpy as np
import pytest

import camrig

PAIR = {"size": (160, 120), "vfov_deg": 60, "position": (5.0, 4.0, 2.2), "code_strip": True}
LENSES = {
    "pinhole": ("pinhole", []),
    "barrel that folds in the picture": ("plumb_bob", [-1.5, 0.0, 0.0, 0.0, 0.0]),
    "rational": ("rational_polynomial", [0.9, 0.12, 3e-4, -2e-4, 0.004, 1.25, 0.35, 0.03]),
    "fisheye": ("equidistant", [0.02, -0.01, 0.003, -0.0005]),
}


def check_one_instant(got):
    for name, kinds in got.items():
        assert camrig.read_code(kinds["color"]).time_ns == kinds["truth"]["time_ns"] == got.time_ns, name
        seen = {item["id"]: item["pixels"] for item in kinds["truth"]["objects"] if item["pixels"]}
        ids, counts = np.unique(kinds["instance"][kinds["instance"] > 0], return_counts=True)
        assert dict(zip(ids.tolist(), counts.tolist())) == seen
        assert ((kinds["semantic"] > 0) == (kinds["instance"] > 0)).all() and (np.isfinite(kinds["depth"]) >= (kinds["instance"] > 0)).all()
        assert kinds["normal"].shape == (120, 160, 3)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_pictures_by_png_have_the_units_of_raw_ones(rig):
    camera = rig.create_camera("left", look_at=(12, 9, 1), **PAIR)
    raw, png = (camera.frame(kind="depth", format=way).image for way in ("raw", "png"))
    shown = raw < 65.5
    assert png.dtype == np.float32 and shown.any()
    np.testing.assert_allclose(png[shown], raw[shown], rtol=0, atol=0.00051)  # whole millimetres
    assert np.isinf(png[np.isinf(raw)]).all()
    for kind in ("instance", "semantic"):
        raw, png = (camera.frame(kind=kind, format=way).image for way in ("raw", "png"))
        assert png.dtype == np.uint32
        np.testing.assert_array_equal(png, raw)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_a_grab_in_lockstep_is_of_the_instant_at_which_the_world_stands(rig):
    cameras = [rig.create_camera(name, fps=fps, look_at=(12, 9 + fps / 10, 1), **PAIR) for name, fps in (("left", 10), ("right", 4))]
    rig.step(seconds=0.5)
    got = rig.grab(cameras, ["color", "depth", "instance", "semantic", "normal", "truth"])
    assert got.time_ns == 500_000_000
    check_one_instant(got)
    rig.step(seconds=0.1)
    with pytest.raises(camrig.CamrigError, match="different instants"):
        rig.grab(cameras)
    assert rig.grab(cameras[:1]).time_ns == 600_000_000


@pytest.mark.camrig(scene="minimal", mode="realtime")
def test_a_grab_of_a_running_world_finds_cameras_whose_clocks_have_them_due_together_at_other_times(rig):
    for name in ("left", "right"):
        rig.create_camera(name, size=(64, 48), fps=10, place="main", clock={"phase_ns": 13_000_000})
    assert rig.grab(["left", "right"], ["color", "truth"]).time_ns % 100_000_000 == 13_000_000


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_a_grab_of_a_running_world_is_of_one_instant_too_and_the_world_runs_on(rig):
    cameras = [rig.create_camera(name, fps=fps, look_at=(12, 9 + fps / 10, 1), **PAIR) for name, fps in (("left", 10), ("right", 5))]
    instants = []
    for _ in range(3):
        got = rig.grab(cameras, ["color", "depth", "instance", "semantic", "normal", "truth"])
        check_one_instant(got)
        instants.append(got.time_ns)
    assert instants == sorted(set(instants)) and rig.status()["paused"] is False
    rig.pause()
    standing = {rig.camera("right").frame().time_ns, rig.camera("left").frame().time_ns}
    if len(standing) == 1:
        assert rig.grab(cameras).time_ns in standing
    else:
        with pytest.raises(camrig.CamrigError, match="different instants"):
            rig.grab(cameras)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
@pytest.mark.parametrize("name", LENSES)
def test_projected_points_are_the_truths_keypoints_and_centres_through_every_lens(rig, name):
    cam = rig.create_camera("eye", size=(640, 480), place="lobby", intrinsics={"fx": 260, "fy": 262, "cx": 318, "cy": 241}, lens=LENSES[name])
    rig.step(seconds=24)
    truth = cam.truth()
    view = camrig.Projection.of(truth)
    np.testing.assert_array_equal(cam.K, view.K)
    np.testing.assert_array_equal(cam.world_from_camera, view.world_from_camera)
    checked = unseen = 0
    for item in truth["objects"]:
        for told, place in zip(item.get("keypoints", []), item.get("keypoints_world", [])):
            pixel = cam.project([place])[0] if checked == 0 else view.project([place])[0]
            if told[2] == 0 and told[:2] == [0, 0]:
                assert np.isnan(pixel).all()
                unseen += 1
            else:
                np.testing.assert_allclose(pixel, told[:2], atol=1e-6)
                checked += 1
        if not item["clipped"] and item["truncated"] == 0:
            x, y, w, h = item["box_full"]
            middle = view.project([item["center"]])[0]
            assert x - 1e-6 <= middle[0] <= x + w + 1e-6 and y - 1e-6 <= middle[1] <= y + h + 1e-6
    assert checked > 50 and (unseen > 0 or "folds" not in name)
    front = np.array([item["center"] for item in truth["objects"] if not item["clipped"]])
    camera_from_world = np.linalg.inv(cam.world_from_camera)
    project = cv2.fisheye.projectPoints if view.model == "equidistant" else cv2.projectPoints
    by_opencv = project(front[:, None], cv2.Rodrigues(camera_from_world[:3, :3])[0], camera_from_world[:3, 3], cam.K, cam.distortion)[0][:, 0]
    mine = view.project(front)
    known = np.isfinite(mine).all(axis=1)
    assert known.sum() > 5
    np.testing.assert_allclose(mine[known], by_opencv[known], atol=1e-6)
