"""The bytes of ROS messages: laid out by hand here, and decoded by a library that shares nothing with the one that wrote them."""

import struct

import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from camrig.ros2 import messages
from camrig.ros2.camera_state import CameraState
from test_ros2_camera_state import reply

LENS = {"model": "rational_polynomial", "coefficients": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]}


@pytest.fixture
def state():
    return CameraState.of(reply(lens=LENS))


def decode(message_type, data):
    schema = Schema(id=1, name=message_type, encoding="ros2msg", data=messages.definition(message_type).encode())
    return DecoderFactory().decoder_for("cdr", schema)(data)


def cdr_header(seconds, nanoseconds, frame):
    """Little-endian CDR; strings count their 0; offsets count from behind the first four bytes."""
    text = frame.encode() + b"\0"
    return b"\0\1\0\0" + struct.pack("<iII", seconds, nanoseconds, len(text)) + text


def pad(data, alignment):
    return data + b"\0" * (-(len(data) - 4) % alignment)


def test_compressed_image_is_laid_out_as_cdr_says(state):
    data = messages.compressed_image(state, 3_000_000_007, b"\xff\xd8jpeg")
    expected = pad(cdr_header(3, 7, "cam_optical_frame"), 4) + struct.pack("<I", 5) + b"jpeg\0"
    expected = pad(expected, 4) + struct.pack("<I", 6) + b"\xff\xd8jpeg"
    assert data == expected


def test_camera_info_aligns_its_doubles_to_eight_bytes(state):
    data = messages.camera_info(state, 5_000_000_000)
    expected = pad(cdr_header(5, 0, "cam_optical_frame"), 4) + struct.pack("<III", 480, 640, 20) + b"rational_polynomial\0"
    expected = pad(pad(expected, 4) + struct.pack("<I", 8), 8) + struct.pack("<8d", *LENS["coefficients"])
    expected += struct.pack("<9d9d12d", *state.k, *state.r, *state.p) + struct.pack("<II", 0, 0) + struct.pack("<IIII?", 0, 0, 0, 0, False)
    assert data == expected


def test_every_type_decodes_to_what_went_in(state):
    rgb = np.arange(480 * 640 * 3, dtype=np.uint32).astype(np.uint8).reshape(480, 640, 3)
    image = decode(messages.IMAGE, messages.image(state, 1, rgb[:, ::-1]))
    assert (image.width, image.height, image.step, image.encoding, image.is_bigendian) == (640, 480, 1920, "rgb8", 0)
    assert bytes(image.data) == rgb[:, ::-1].tobytes()

    info = decode(messages.CAMERA_INFO, messages.camera_info(state, 2))
    assert (info.header.stamp.sec, info.header.stamp.nanosec, info.header.frame_id) == (0, 2, "cam_optical_frame")
    assert list(info.d) == LENS["coefficients"] and list(info.k) == list(state.k) and list(info.p) == list(state.p)

    pose = decode(messages.TF, messages.camera_pose(state, 10**9)).transforms[0]
    assert (pose.header.frame_id, pose.child_frame_id, pose.header.stamp.sec) == ("map", "cam_link", 1)
    assert (pose.transform.translation.x, pose.transform.translation.y, pose.transform.translation.z) == (1, 2, 3)

    optical = decode(messages.TF, messages.optical_frames([state], 0)).transforms[0]
    assert (optical.header.frame_id, optical.child_frame_id) == ("cam_link", "cam_optical_frame")
    assert (optical.transform.rotation.x, optical.transform.rotation.w) == (-0.5, 0.5)


def test_detections_are_the_visible_boxes(state):
    objects = [
        {"id": 7, "name": "anna", "class": "person", "box": [10, 20, 5, 8]},
        {"id": 8, "name": "hidden", "class": "person", "box": None},
    ]
    found = decode(messages.DETECTIONS, messages.detections(state, 4, objects)).detections
    assert len(found) == 1
    box = found[0].bbox
    # Pixels 10 to 14 and 20 to 27: pixel centres are at integers.
    assert (box.center.position.x, box.center.position.y, box.size_x, box.size_y) == (12, 23.5, 5, 8)
    assert (found[0].id, found[0].results[0].hypothesis.class_id, found[0].results[0].hypothesis.score) == ("7", "person", 1)
