"""Files for the ROS 2 camera drivers."""

import json
import runpy
import sys
import types

import pytest
import yaml

import camrig
from camrig.ros2.__main__ import main
from camrig.ros2.files import make_files, write_files
from test_ros2_camera_state import reply


@pytest.fixture
def cameras(fake):
    """A fake rig with a user-space device, a module device in MJPG, one with MJPEG by RTSP and one without outputs."""
    outputs = {
        "user": [{"kind": "device", "number": 7}],
        "module": [{"kind": "v4l2", "number": 3, "format": "MJPG"}],
        "net": [{"kind": "rtsp", "codec": "mjpeg"}],
        "plain": [],
    }
    for name, value in outputs.items():
        fake.cameras[name] = reply(name=name, outputs=value, fps="30000/1001")
    fake.cameras["module"]["size"] = [641, 480]
    return fake


@pytest.fixture
def files(cameras, client_rig):
    return make_files(client_rig)


def parameters(files, path):
    return yaml.safe_load(files.files[path])["/**"]["ros__parameters"]


def test_every_camera_has_a_calibration_where_its_driver_looks(files):
    """camera_info_manager looks for $ROS_HOME/camera_info/NAME.yaml; NAME is v4l2_camera's card label, that of the rig's devices."""
    for name in ("user", "module", "net", "plain"):
        assert yaml.safe_load(files.files[f"camera_info/{name}.yaml"])["camera_name"] == name


def test_drivers_get_only_cameras_that_they_can_open(files):
    assert files.drivers == {
        "user": ["usb_cam", "v4l2_camera", "gscam2"],
        "module": ["usb_cam", "gscam2"],  # v4l2_camera knows no MJPG
        "net": ["gscam2"],
        "plain": ["gscam2"],
    }
    assert any("plain" in note and "--device" in note for note in files.notes)
    assert any("module" in note and "640x480" in note for note in files.notes)


def test_usb_cam_parameters(files):
    assert parameters(files, "usb_cam/user.yaml") == {
        "video_device": "/dev/video7",
        "camera_name": "user",
        "frame_id": "user_optical_frame",
        "pixel_format": "yuyv2rgb",
        "io_method": "mmap",
        "image_width": 640,
        "image_height": 480,
        "framerate": pytest.approx(29.97002997),
        "brightness": -1,
    }
    module = parameters(files, "usb_cam/module.yaml")
    assert (module["pixel_format"], module["image_width"], module["video_device"]) == ("mjpeg2rgb", 640, "/dev/video3")


def test_v4l2_camera_parameters(files):
    assert parameters(files, "v4l2_camera/user.yaml") == {
        "video_device": "/dev/video7",
        "camera_frame_id": "user_optical_frame",
        "pixel_format": "YUYV",
        "output_encoding": "rgb8",
        "image_size": [640, 480],
        "time_per_frame": [1001, 30000],
    }


def test_gscam2_takes_rtsp_else_http(files, cameras, client_rig):
    plain, net = parameters(files, "gscam2/plain.yaml"), parameters(files, "gscam2/net.yaml")
    assert plain["gscam_config"].startswith("rtspsrc location=rtsp://127.0.0.1:8555/plain ") and plain["use_gst_timestamps"]
    assert "location=rtsp://127.0.0.1:8555/net/mjpeg " in net["gscam_config"] and "rtpjpegdepay" in net["gscam_config"]
    cameras.handlers["server.info"] = lambda params: {"http": 8123, "rtsp": 0}
    plain = parameters(make_files(client_rig), "gscam2/plain.yaml")
    assert "http://127.0.0.1:8123/cameras/plain/stream.mjpg" in plain["gscam_config"] and not plain["use_gst_timestamps"]


class Node(types.SimpleNamespace):
    def __init__(self, **arguments):
        super().__init__(**arguments)


def launched(path, monkeypatch):
    """The nodes of a launch file, by a stand-in for ROS 2's launch."""
    launch, launch_ros, actions = types.ModuleType("launch"), types.ModuleType("launch_ros"), types.ModuleType("launch_ros.actions")
    launch.LaunchDescription, actions.Node = list, Node
    for module in (launch, launch_ros, actions):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    return runpy.run_path(str(path))["generate_launch_description"]()


def test_launch_files_start_the_drivers_with_these_files(files, tmp_path, monkeypatch):
    write_files(tmp_path / "ros", files)
    moved = (tmp_path / "ros").rename(tmp_path / "moved")  # the folder may be moved
    for driver, names in (("usb_cam", ["user", "module"]), ("v4l2_camera", ["user"]), ("gscam2", ["user", "module", "net", "plain"])):
        nodes = launched(moved / "launch" / f"{driver}.launch.py", monkeypatch)
        assert [node.namespace for node in nodes] == names
        for node in nodes:
            assert node.package == driver
            file, overrides = node.parameters
            assert yaml.safe_load(open(file))["/**"]["ros__parameters"]
            url = overrides["camera_info_url"]
            assert url.startswith("file:///") and yaml.safe_load(open(url[len("file://") :]))["camera_name"] == node.namespace


def test_static_transforms_go_from_the_map_to_every_optical_frame(files, tmp_path, monkeypatch):
    write_files(tmp_path, files)
    nodes = launched(tmp_path / "launch" / "tf_static.launch.py", monkeypatch)
    found = [dict(zip(node.arguments[::2], node.arguments[1::2])) for node in nodes]
    assert [(t["--frame-id"], t["--child-frame-id"]) for t in found[:2]] == [("map", "user_link"), ("user_link", "user_optical_frame")]
    assert [float(found[0][axis]) for axis in ("--x", "--y", "--z", "--qw")] == [1, 2, 3, 1]
    assert [float(found[1][axis]) for axis in ("--qx", "--qy", "--qz", "--qw")] == [-0.5, 0.5, -0.5, 0.5]
    assert len({node.name for node in nodes}) == 8


def test_nothing_is_overwritten_without_force(files, tmp_path):
    assert set(write_files(tmp_path, files).values()) == {"written"}
    assert set(write_files(tmp_path, files).values()) == {"unchanged"}
    edited = tmp_path / "camera_info" / "net.yaml"
    edited.write_text("mine")
    (tmp_path / "usb_cam" / "user.yaml").unlink()
    with pytest.raises(camrig.CamrigError) as caught:
        write_files(tmp_path, files)
    assert caught.value.kind == "already_exists" and "camera_info/net.yaml" in caught.value.message
    assert edited.read_text() == "mine"
    assert not (tmp_path / "usb_cam" / "user.yaml").exists()  # nothing at all was written
    outcome = write_files(tmp_path, files, force=True)
    assert {path for path, what in outcome.items() if what == "written"} == {"usb_cam/user.yaml", "camera_info/net.yaml"}
    assert edited.read_text() != "mine"


def test_a_token_is_in_a_private_file_only(cameras, tmp_path):
    with camrig.connect(tmp_path / "control.sock", token="secret-token") as rig:
        files = make_files(rig)
    write_files(tmp_path / "ros", files)
    for path, text in files.files.items():
        assert ("secret-token" in text) <= ((tmp_path / "ros" / path).stat().st_mode & 0o077 == 0), path
    assert "secret-token" in files.files["gscam2/plain.yaml"]


def test_the_command_writes_the_chosen_cameras_and_says_what(cameras, tmp_path, capsys):
    target = tmp_path / "ros"
    assert main(["--control", str(tmp_path / "control.sock"), "--json", "files", str(target), "--cameras", "user", "--world-frame", "world"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert set(said["files"]) == {str(path.relative_to(target)) for path in target.rglob("*") if path.is_file()}
    assert said["drivers"] == {"user": ["usb_cam", "v4l2_camera", "gscam2"]}
    assert '"world"' in (target / "launch" / "tf_static.launch.py").read_text()
    with pytest.raises(camrig.CamrigError) as caught:
        main(["--control", str(tmp_path / "control.sock"), "files", str(target), "--cameras", "nobody"])
    assert "nobody" in caught.value.message and "user" in caught.value.message
