"""The examples of docs/ros2.md run as they stand."""

import os

from rosbags.rosbag2 import Reader

from test_docs import blocks, environment, hall, shell  # noqa: F401  (fixtures)


def test_the_examples_of_the_ros2_page_run(hall, environment, tmp_path):  # noqa: F811
    examples = blocks("docs/ros2.md", "sh")
    assert len(examples) == 3
    for example in examples:
        shell(example, hall, dict(environment, CAMRIG_PYTHON=str(tmp_path / "venv/bin/python")), tmp_path)
    for file in ("camera_info/front.yaml", "usb_cam/front.yaml", "v4l2_camera/front.yaml", "gscam2/lobby.yaml", "launch/tf_static.launch.py"):
        assert (tmp_path / "ros" / file).is_file()
    with Reader(tmp_path / "walk") as reader:
        topics = {connection.topic: connection.msgcount for connection in reader.connections}
    assert topics["/front/image_raw/compressed"] > 0 and topics["/lobby/camera_info"] > 0 and topics["/tf_static"] == 1
    assert os.path.exists(tmp_path / "walk" / "walk_0.mcap")
