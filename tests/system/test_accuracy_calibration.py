"""Calibrations come in and go out by command, and OpenCV recovers from pictures what was put in."""

import json
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml

from conftest import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tools" / "bench"))
from accuracy import boards, measure  # noqa: E402
from accuracy.lenses import LENSES, PINHOLES, Camera  # noqa: E402

ROUND_TRIP = ("EuRoC cam0", "rational, mild", "fisheye 160 deg")
SCENE = REPOSITORY / "scenes" / "calibration.json"


@pytest.fixture(scope="module")
def rig():
    with measure.rig_of(SCENE) as rig:
        yield rig


@pytest.fixture
def command(rig, tmp_path):
    """Runs `camrig ...` at the rig; returns its output, or with fails=True its one line of complaint."""

    def run(*arguments, fails=False):
        environment = dict(os.environ, CAMRIG_CONTROL=rig.info()["control"], ROS_HOME=str(tmp_path / "ros"))
        done = subprocess.run([os.environ["CAMRIG_BIN"], *map(str, arguments)], env=environment, capture_output=True, text=True, timeout=60)
        assert (done.returncode == 1) == fails, done.stderr
        return done.stderr if fails else done.stdout

    return run


@pytest.fixture(autouse=True)
def no_cameras_left(rig):
    yield
    for camera in rig.cameras():
        if camera.name not in ("front", "all"):
            camera.delete()


def opencv_file(path, camera):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", camera.size[0])
    storage.write("image_height", camera.size[1])
    storage.write("camera_matrix", camera.matrix)
    if camera.model == "equidistant":
        storage.write("fisheye_model", 1)
    if camera.model != "pinhole":
        storage.write("distortion_coefficients", np.array([camera.coefficients]))
    storage.release()


def of_yaml(text):
    """(matrix, model, coefficients, size) as ROS's Python tools read a camera_info file."""
    info = yaml.safe_load(text)
    matrix = np.array(info["camera_matrix"]["data"], dtype=float).reshape(3, 3)
    assert np.array_equal(np.array(info["rectification_matrix"]["data"], dtype=float).reshape(3, 3), np.eye(3))
    projection = np.array(info["projection_matrix"]["data"], dtype=float).reshape(3, 4)
    assert np.array_equal(projection[:, :3], matrix) and not projection[:, 3].any()
    return matrix, info["distortion_model"], info["distortion_coefficients"]["data"], (info["image_width"], info["image_height"])


@pytest.mark.parametrize("suffix", ["yml", "yaml", "json"])
@pytest.mark.parametrize("camera", [PINHOLES[1], *(c for c in LENSES if c.name in ROUND_TRIP)], ids=lambda c: c.name)
def test_a_calibration_saved_by_opencv_comes_out_as_ros_reads_it_and_goes_back(command, tmp_path, camera, suffix):
    opencv_file(tmp_path / f"real.{suffix}", camera)
    command("camera", "create", "real", "--calibration", tmp_path / f"real.{suffix}")
    text = command("camera", "calibration", "real")
    matrix, model, coefficients, size = of_yaml(text)
    assert np.array_equal(matrix, camera.matrix)
    assert size == camera.size
    assert model == ("plumb_bob" if camera.model == "pinhole" else camera.model)
    assert tuple(coefficients) == (camera.coefficients or (0,) * 5)
    # OpenCV reads ROS's file too, given the header it wants.
    (tmp_path / "ros.yml").write_text("%YAML:1.0\n---\n" + text)
    command("camera", "create", "again", "--calibration", tmp_path / "ros.yml")
    again, real = (json.loads(command("camera", "get", name, "--json")) for name in ("again", "real"))
    for key in ("size", "intrinsics", "lens"):
        assert again[key] == real[key]
    assert real["lens"]["model"] == camera.model and tuple(real["lens"]["coefficients"]) == camera.coefficients


def test_it_is_written_where_a_ros_driver_looks(command, tmp_path):
    command("camera", "create", "cam0", "--size", "320x240")
    command("camera", "calibration", "cam0", "--ros")
    written = (tmp_path / "ros" / "camera_info" / "cam0.yaml").read_text()
    assert yaml.safe_load(written)["camera_name"] == "cam0"
    assert written == command("camera", "calibration", "cam0")


def test_a_kalibr_camera_is_chosen_by_name(command, tmp_path):
    chain = {
        f"cam{i}": {
            "camera_model": "pinhole", "distortion_model": "none", "distortion_coeffs": [], "resolution": [752, 480],
            "intrinsics": [458.0 + i, 457.0, 367.0, 248.0], "rostopic": f"/cam{i}/image_raw",
        }
        for i in range(2)
    }
    (tmp_path / "chain.yaml").write_text(yaml.safe_dump(chain))
    assert "say which: cam0, cam1" in command("camera", "create", "k", "--calibration", tmp_path / "chain.yaml", fails=True)
    command("camera", "create", "k", "--calibration", tmp_path / "chain.yaml", "--calibration-camera", "cam1")
    assert json.loads(command("camera", "get", "k", "--json"))["intrinsics"]["fx"] == 459.0


def test_set_puts_a_calibration_on_a_camera_and_size_goes_with_it(command, tmp_path):
    opencv_file(tmp_path / "real.yml", Camera("real", size=(320, 200), fx=200, fy=201, cx=150, cy=99))
    command("camera", "create", "c", "--size", "640x480")
    command("camera", "set", "c", "--calibration", tmp_path / "real.yml")
    camera = json.loads(command("camera", "get", "c", "--json"))
    assert camera["size"] == [320, 200] and camera["intrinsics"] == {"fx": 200, "fy": 201, "cx": 150, "cy": 99}


@pytest.mark.parametrize(
    "change, reason",
    [
        ({"image_width": None}, "image_width"),
        ({"distortion_model": "plumb_bob", "coefficients": [0.1, 0.2]}, "plumb_bob takes 5 numbers"),
        ({"distortion_model": "plumb_bob", "coefficients": [0, 0, 0, float("nan"), 0]}, "finite"),
        ({"distortion_model": "plumb_bob", "coefficients": [-1e7, 0, 0, 0, 0]}, "no rising branch"),
        ({"distortion_model": "equidistant", "coefficients": [0, 0, 0, 0, 0]}, "takes 4 coefficients, not 5"),
        ({"distortion_model": "rational_polynomial", "coefficients": [0] * 5}, "rational_polynomial takes 8 numbers"),
        ({"camera_matrix": [0, 0, 320, 0, 500, 240, 0, 0, 1]}, "fx"),
        ({"camera_matrix": [500, 3, 320, 0, 500, 240, 0, 0, 1]}, "skew"),
    ],
    ids=lambda v: v if isinstance(v, str) else "",
)
def test_a_bad_calibration_is_refused_with_the_reason_and_makes_no_camera(command, tmp_path, change, reason):
    info = {
        "image_width": 640, "image_height": 480, "camera_name": "x", "distortion_model": change.get("distortion_model", "plumb_bob"),
        "camera_matrix": {"rows": 3, "cols": 3, "data": change.get("camera_matrix", [500, 0, 320, 0, 500, 240, 0, 0, 1])},
    }
    coefficients = change.get("coefficients", [0] * 5)
    info["distortion_coefficients"] = {"rows": 1, "cols": len(coefficients), "data": coefficients}
    if "image_width" in change:
        del info["image_width"]
    (tmp_path / "bad.yaml").write_text(yaml.safe_dump(info))
    complaint = command("camera", "create", "bad", "--calibration", tmp_path / "bad.yaml", fails=True)
    assert reason in complaint and "bad.yaml" in complaint and complaint.count("\n") == 1
    assert "bad" not in [c["name"] for c in json.loads(command("camera", "list", "--json"))["cameras"]]


def test_a_calibration_for_another_size_is_refused(command, tmp_path):
    opencv_file(tmp_path / "real.yml", PINHOLES[0])
    complaint = command("camera", "create", "c", "--size", "320x240", "--calibration", tmp_path / "real.yml", fails=True)
    assert "is for pictures of 640x480, not 320x240" in complaint
    (tmp_path / "old.xml").write_text("<?xml version='1.0'?>\n<opencv_storage></opencv_storage>\n")
    assert "XML" in command("camera", "create", "c", "--calibration", tmp_path / "old.xml", fails=True)


def test_what_camera_get_prints_makes_the_camera_again(command, rig, tmp_path):
    command("camera", "create", "first", "--position", "-0.6,0.1,1.6", "--look-at", "0,0,1.5", "--hfov-deg", "50")
    (tmp_path / "first.json").write_text(command("camera", "get", "first", "--json"))
    command("camera", "create", "second", "--file", tmp_path / "first.json")
    first, second = (rig.camera(name).frame().image for name in ("first", "second"))
    assert np.array_equal(first, second)


def test_opencv_detects_the_charuco_board_where_it_is(rig):
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((8, 6), 1 / 16, 3 / 64, dictionary)
    camera = Camera("charuco", fx=700, fy=700)
    view = boards.looking((-0.6, 0.1, 0.9), (0.5, 0.0, 0.75))
    cam = rig.create_camera("charuco", **camera.options(), **view.options())
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(cam.frame().image)
    assert ids is not None and len(ids) == 7 * 5
    places = np.array([0.5, 4 / 16, 0.75 + 3 / 16]) + board.getChessboardCorners()[ids.ravel()] @ np.array([[0, -1.0, 0], [0, 0, -1.0], [1.0, 0, 0]])
    assert np.abs(corners.reshape(-1, 2) - camera.project(view.optical(places))).max() < 1.0  # no anti-aliasing here
