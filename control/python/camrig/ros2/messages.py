"""ROS 2 messages as bytes: CDR and the texts of their definitions, by rosbags (no ROS needed)."""

from __future__ import annotations

from typing import Any, Iterable, Mapping, Sequence

import numpy as np

from ..errors import CamrigError
from .camera_state import OPTICAL_FROM_LINK, WORLD_FRAME, CameraState

try:
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
except ImportError as problem:
    raise CamrigError("unavailable", f"{problem}; this command needs: pip install 'camrig[ros2]'") from problem

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
TF = "tf2_msgs/msg/TFMessage"
DETECTIONS = "vision_msgs/msg/Detection2DArray"

#: vision_msgs 4 (Humble and later); the common interfaces come with rosbags.
_VISION_MSGS = {
    "vision_msgs/msg/Point2D": "float64 x\nfloat64 y\n",
    "vision_msgs/msg/Pose2D": "vision_msgs/Point2D position\nfloat64 theta\n",
    "vision_msgs/msg/BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y\n",
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score\n",
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"
    ),
    "vision_msgs/msg/Detection2D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox2D bbox\nstring id\n"
    ),
    "vision_msgs/msg/Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections\n",
}

_store = get_typestore(Stores.ROS2_HUMBLE)
for _name, _text in _VISION_MSGS.items():
    _store.register(get_types_from_msg(_text, _name))


def definition(message_type: str) -> str:
    """The text of a type with all it depends on, as a schema of encoding ros2msg holds it."""
    return _store.generate_msgdef(message_type, ros_version=2)[0]


def compressed_image(state: CameraState, stamp_ns: int, jpeg: bytes) -> bytes:
    header = _header(stamp_ns, state.optical_frame)
    return _cdr(COMPRESSED_IMAGE, header=header, format="jpeg", data=np.frombuffer(jpeg, np.uint8))


def image(state: CameraState, stamp_ns: int, rgb: np.ndarray) -> bytes:
    """rgb: HxWx3 uint8."""
    height, width = rgb.shape[:2]
    return _cdr(
        IMAGE,
        header=_header(stamp_ns, state.optical_frame),
        height=height,
        width=width,
        encoding="rgb8",
        is_bigendian=0,
        step=3 * width,
        data=np.ascontiguousarray(rgb).reshape(-1),
    )


def camera_info(state: CameraState, stamp_ns: int) -> bytes:
    return _cdr(
        CAMERA_INFO,
        header=_header(stamp_ns, state.optical_frame),
        height=state.size[1],
        width=state.size[0],
        distortion_model=state.distortion_model,
        d=np.array(state.distortion),
        k=np.array(state.k),
        r=np.array(state.r),
        p=np.array(state.p),
        binning_x=0,
        binning_y=0,
        roi=_make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False),
    )


def camera_pose(state: CameraState, stamp_ns: int, world_frame: str = WORLD_FRAME) -> bytes:
    """map -> <cam>_link, for /tf."""
    return _cdr(TF, transforms=[_transform(stamp_ns, world_frame, state.link_frame, state.position, state.orientation)])


def optical_frames(states: Iterable[CameraState], stamp_ns: int) -> bytes:
    """<cam>_link -> <cam>_optical_frame of all cameras, for /tf_static."""
    origin = (0.0, 0.0, 0.0)
    return _cdr(TF, transforms=[_transform(stamp_ns, s.link_frame, s.optical_frame, origin, OPTICAL_FROM_LINK) for s in states])


def detections(state: CameraState, stamp_ns: int, objects: Iterable[Mapping[str, Any]]) -> bytes:
    """The visible boxes of truth.get. Pixel centres are at integers: the centre of box [x, y, w, h] is x + (w - 1) / 2."""
    header = _header(stamp_ns, state.optical_frame)
    found = [_detection(header, item) for item in objects if item.get("box")]
    return _cdr(DETECTIONS, header=header, detections=found)


def _detection(header: Any, item: Mapping[str, Any]) -> Any:
    x, y, width, height = item["box"]
    centre = _make("vision_msgs/msg/Point2D", x=x + (width - 1) / 2, y=y + (height - 1) / 2)
    unknown = _make(
        "geometry_msgs/msg/PoseWithCovariance",
        pose=_make("geometry_msgs/msg/Pose", position=_vector("Point", (0, 0, 0)), orientation=_quaternion((0, 0, 0, 1))),
        covariance=np.zeros(36),
    )
    hypothesis = _make("vision_msgs/msg/ObjectHypothesis", class_id=str(item["class"]), score=1.0)
    return _make(
        "vision_msgs/msg/Detection2D",
        header=header,
        results=[_make("vision_msgs/msg/ObjectHypothesisWithPose", hypothesis=hypothesis, pose=unknown)],
        bbox=_make(
            "vision_msgs/msg/BoundingBox2D",
            center=_make("vision_msgs/msg/Pose2D", position=centre, theta=0.0),
            size_x=float(width),
            size_y=float(height),
        ),
        id=str(item["id"]),
    )


def _transform(stamp_ns: int, parent: str, child: str, position: Sequence[float], orientation: Sequence[float]) -> Any:
    return _make(
        "geometry_msgs/msg/TransformStamped",
        header=_header(stamp_ns, parent),
        child_frame_id=child,
        transform=_make(
            "geometry_msgs/msg/Transform", translation=_vector("Vector3", position), rotation=_quaternion(orientation)
        ),
    )


def _header(stamp_ns: int, frame_id: str) -> Any:
    seconds, nanoseconds = divmod(stamp_ns, 10**9)
    stamp = _make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    return _make("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)


def _vector(kind: str, xyz: Sequence[float]) -> Any:
    x, y, z = map(float, xyz)
    return _make(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)


def _quaternion(xyzw: Sequence[float]) -> Any:
    x, y, z, w = map(float, xyzw)
    return _make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def _make(message_type: str, **fields: Any) -> Any:
    return _store.types[message_type](**fields)


def _cdr(message_type: str, **fields: Any) -> bytes:
    return bytes(_store.serialize_cdr(_make(message_type, **fields), message_type))
