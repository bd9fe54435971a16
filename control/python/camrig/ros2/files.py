"""What the stock ROS 2 camera drivers need to run on a rig: calibrations, parameters, launch files, static transforms."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Mapping

from ..camera import Camera
from ..errors import CamrigError
from ..rig import Rig
from .camera_state import OPTICAL_FROM_LINK, WORLD_FRAME, CameraState, camera_info_yaml, yaml_number

#: pixel_format of usb_cam by the format that a device gives; it takes no other of those that camrig has.
_USB_CAM_FORMATS = {"YUYV": "yuyv2rgb", "MJPG": "mjpeg2rgb"}
#: A rig with a token asks for digest authentication: this user, the token as password.
_RTSP_USER = "camrig"


@dataclass
class FileSet:
    """Files by their path below the target directory, and what the user should know."""

    files: dict[str, str] = field(default_factory=dict)
    private: set[str] = field(default_factory=set)  # hold the rig's token
    drivers: dict[str, list[str]] = field(default_factory=dict)  # by camera
    notes: list[str] = field(default_factory=list)

    def add(self, path: str, text: str) -> None:
        self.files[path] = text


def make_files(rig: Rig, cameras: tuple[str, ...] = (), world_frame: str = WORLD_FRAME) -> FileSet:
    replies = {reply["name"]: reply for reply in rig.call("camera.list")["cameras"]}
    for name in cameras:
        if name not in replies:
            raise CamrigError("not_found", f"no camera '{name}'; the rig has: {', '.join(sorted(replies)) or 'none'}")
    chosen = [replies[name] for name in cameras] if cameras else list(replies.values())
    if not chosen:
        raise CamrigError("not_found", "the rig has no camera; make one with: camrig camera create NAME")

    result = FileSet()
    by_driver: dict[str, list[str]] = {"usb_cam": [], "v4l2_camera": [], "gscam2": []}
    states = [CameraState.of(reply) for reply in chosen]
    for state, reply in zip(states, chosen):
        result.add(f"camera_info/{state.name}.yaml", camera_info_yaml(state))
        parameters = {
            "usb_cam": _usb_cam(state, reply, result),
            "v4l2_camera": _v4l2_camera(state, reply, result),
            "gscam2": _gscam2(rig, state, reply),
        }
        result.drivers[state.name] = [driver for driver, found in parameters.items() if found]
        for driver, found in parameters.items():
            if found:
                path = f"{driver}/{state.name}.yaml"
                result.add(path, _ros_parameters(found))
                by_driver[driver].append(state.name)
                if driver == "gscam2" and rig.token:
                    result.private.add(path)
        if "usb_cam" not in result.drivers[state.name] and "v4l2_camera" not in result.drivers[state.name]:
            result.notes.append(f"camera {state.name} is no /dev/videoN: for usb_cam and v4l2_camera give it an output (camera set {state.name} --device N)")
    for driver, names in by_driver.items():
        if names:
            result.add(f"launch/{driver}.launch.py", _driver_launch(driver, names))
    result.add("launch/tf_static.launch.py", _tf_launch(states, world_frame))
    return result


def write_files(directory: Path, files: FileSet, force: bool = False) -> dict[str, str]:
    """Returns path -> "written" or "unchanged". A file that is there with other content is an error, and then nothing at all
    is written; with `force` it is replaced."""
    outcome: dict[str, str] = {}
    in_the_way = []
    for path, text in files.files.items():
        target = directory / path
        same = target.is_file() and target.read_text(errors="replace") == text
        outcome[path] = "unchanged" if same else "written"
        if target.exists() and not same:
            in_the_way.append(path)
    if in_the_way and not force:
        raise CamrigError(
            "already_exists", f"{directory} has these files with other content: {', '.join(in_the_way)}; nothing was written; --force replaces them"
        )
    for path, text in files.files.items():
        if outcome[path] == "unchanged":
            continue
        target = directory / path
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = target.with_name(target.name + ".new")
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600 if path in files.private else 0o666)
        with open(descriptor, "w") as out:
            out.write(text)
        os.replace(temporary, target)
    return outcome


# Drivers

def _devices(reply: Mapping[str, Any]) -> list[tuple[int, tuple[str, ...]]]:
    """Numbers of /dev/videoN with the formats it gives; user-space devices give all."""
    found = []
    for output in reply.get("outputs", []):
        if output.get("kind") == "device":
            found.append((output["number"], ("YUYV", "MJPG")))
        elif output.get("kind") == "v4l2":
            found.append((output["number"], (output.get("format") or "YUYV",)))
    return found


def _device_size(state: CameraState, result: FileSet) -> tuple[int, int]:
    width, height = state.size[0] & ~1, state.size[1] & ~1
    if (width, height) != state.size:
        note = f"camera {state.name}: devices have even sizes, {width}x{height}; its calibration is for {state.size[0]}x{state.size[1]}: choose an even size"
        if note not in result.notes:
            result.notes.append(note)
    return width, height


def _usb_cam(state: CameraState, reply: Mapping[str, Any], result: FileSet) -> dict[str, Any] | None:
    for number, formats in _devices(reply):
        for fourcc in formats:
            if fourcc in _USB_CAM_FORMATS:
                width, height = _device_size(state, result)
                return {
                    "video_device": f"/dev/video{number}",
                    "camera_name": state.name,
                    "frame_id": state.optical_frame,
                    "pixel_format": _USB_CAM_FORMATS[fourcc],
                    "io_method": "mmap",
                    "image_width": width,
                    "image_height": height,
                    "framerate": float(state.rate),
                    "brightness": -1,  # leave alone; the driver's default would set 50
                }
    return None


def _v4l2_camera(state: CameraState, reply: Mapping[str, Any], result: FileSet) -> dict[str, Any] | None:
    for number, formats in _devices(reply):
        if "YUYV" in formats:
            return {
                "video_device": f"/dev/video{number}",
                "camera_frame_id": state.optical_frame,
                "pixel_format": "YUYV",
                "output_encoding": "rgb8",
                "image_size": list(_device_size(state, result)),
                "time_per_frame": [state.rate.denominator, state.rate.numerator],
            }
    return None


def _gscam2(rig: Rig, state: CameraState, reply: Mapping[str, Any]) -> dict[str, Any]:
    """RTSP where the rig serves it, the main stream unless the camera's output says MJPEG; else the HTTP stream."""
    camera = Camera(rig, state.name)
    by_rtsp = bool(rig.info().get("rtsp"))
    if by_rtsp:
        codecs = {output.get("codec", "h264") for output in reply.get("outputs", []) if output.get("kind") == "rtsp" and output.get("stream", "main") == "main"}
        as_mjpeg = "mjpeg" in codecs
        login = f" user-id={_RTSP_USER} user-pw={rig.token}" if rig.token else ""
        decode = "rtpjpegdepay ! jpegdec" if as_mjpeg else "rtph265depay ! avdec_h265" if "h265" in codecs else "rtph264depay ! avdec_h264"
        url = camera.url("rtsp-mjpeg" if as_mjpeg else "rtsp")
        source = f"rtspsrc location={url} protocols=tcp latency=0{login} ! {decode}"
    else:
        source = f"souphttpsrc location={camera.url('mjpeg')} is-live=true ! multipartdemux ! jpegdec"
    return {
        "gscam_config": f"{source} ! videoconvert",
        "camera_name": state.name,
        "frame_id": state.optical_frame,
        "image_encoding": "rgb8",
        "sync_sink": False,
        "use_gst_timestamps": by_rtsp,  # parts of an MJPEG stream have none
    }


# Texts

def _ros_parameters(values: Mapping[str, Any]) -> str:
    lines = ["/**:", "  ros__parameters:"]
    for name, value in values.items():
        text = yaml_number(value) if isinstance(value, float) else json.dumps(value)
        lines.append(f"    {name}: {text}")
    return "\n".join(lines) + "\n"


_EXECUTABLES = {"usb_cam": "usb_cam_node_exe", "v4l2_camera": "v4l2_camera_node", "gscam2": "gscam_main"}
_NODES = {"usb_cam": "usb_cam", "v4l2_camera": "v4l2_camera", "gscam2": "gscam_publisher"}


def _driver_launch(driver: str, names: list[str]) -> str:
    return f'''"""{driver} for each of these cameras, as /NAME/image_raw and /NAME/camera_info.

Made by `camrig ros2 files`. The folder may be moved as a whole.
"""

from pathlib import Path

from launch import LaunchDescription
from launch_ros.actions import Node

FOLDER = Path(__file__).resolve().parent.parent
CAMERAS = {json.dumps(names)}


def generate_launch_description():
    return LaunchDescription(
        [
            Node(
                package="{driver}",
                executable="{_EXECUTABLES[driver]}",
                name="{_NODES[driver]}",
                namespace=camera,
                parameters=[
                    str(FOLDER / "{driver}" / f"{{camera}}.yaml"),
                    {{"camera_info_url": f"file://{{FOLDER}}/camera_info/{{camera}}.yaml"}},
                ],
                output="screen",
            )
            for camera in CAMERAS
        ]
    )
'''


def _tf_launch(states: list[CameraState], world_frame: str) -> str:
    def row(name: str, parent: str, child: str, position: tuple[float, ...], orientation: tuple[float, ...]) -> str:
        return f"    ({json.dumps(name)}, {json.dumps(parent)}, {json.dumps(child)}, {position!r}, {orientation!r}),\n"

    rows = ""
    for state in states:
        rows += row(f"{state.name}_pose", world_frame, state.link_frame, state.position, state.orientation)
        rows += row(f"{state.name}_optical", state.link_frame, state.optical_frame, (0.0, 0.0, 0.0), OPTICAL_FROM_LINK)
    return f'''"""Where the cameras are: {world_frame} -> NAME_link (x forward, y left, z up) -> NAME_optical_frame (z forward, x right, y down).

Made by `camrig ros2 files` from the poses of that moment; make it anew after a camera was moved.
"""

from launch import LaunchDescription
from launch_ros.actions import Node

# name of the node, parent, child, translation x y z, rotation x y z w
TRANSFORMS = [
{rows}]


def generate_launch_description():
    return LaunchDescription(
        [
            Node(
                package="tf2_ros",
                executable="static_transform_publisher",
                name=name,
                arguments=[
                    "--x", str(x), "--y", str(y), "--z", str(z),
                    "--qx", str(qx), "--qy", str(qy), "--qz", str(qz), "--qw", str(qw),
                    "--frame-id", parent, "--child-frame-id", child,
                ],
            )
            for name, parent, child, (x, y, z), (qx, qy, qz, qw) in TRANSFORMS
        ]
    )
'''
