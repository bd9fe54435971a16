"""python -m tools.bench.first_steps [--write]

How long a new user waits on each path of docs/getting-started.md, programs started new each time: seconds of wall clock. What the
user reads and types is not in it. With --write the table goes into docs/getting-started.md. $CAMRIG_BIN names the program.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import cv2

import camrig

from tools.bench import report

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / "docs" / "getting-started.md"


def own_model_in_opencv(folder):
    """`camrig serve box.glb`, a camera, and its first picture in cv2.VideoCapture."""
    start = time.monotonic()
    with report.start(str(REPOSITORY / "scenes/minimal/box.glb"), mode="realtime") as rig:
        cam = rig.create_camera("mine", size=(640, 480), fps=25, position=(4, 3, 2), look_at=(0, 0, 0.5))
        good, picture = cv2.VideoCapture(cam.url("mjpeg")).read()
        assert good and picture.shape == (480, 640, 3)
        return time.monotonic() - start


def shipped_scene(name, place, quality):
    """`camrig serve NAME --quality QUALITY`, and the first picture of one of its cameras in cv2.VideoCapture."""

    def path(folder):
        start = time.monotonic()
        with report.start(str(REPOSITORY / f"scenes/{name}.json"), mode="realtime", quality=quality) as rig:
            assert cv2.VideoCapture(rig.camera(place).url("mjpeg")).read()[0]
            return time.monotonic() - start

    return path


def arrangement_comes_back(folder):
    """A rig that was stopped is started again, and takes three cameras from a file."""
    file = folder / "cameras.json"
    with report.start(str(REPOSITORY / "scenes/hall.json"), mode="realtime") as rig:
        for i in range(3):
            rig.create_camera(f"mine{i}", size=(640, 480), fps=25, position=(8 + i, 4, 2.2), look_at=(12, 9, 1))
        file.write_text(json.dumps(rig.call("camera.list")))
    start = time.monotonic()
    with report.start(str(REPOSITORY / "scenes/hall.json"), mode="realtime") as rig:
        control = rig.call("server.info")["control"]
        create = [camrig.find_binary(), "--control", control, "camera", "create", "--replace", "--file", str(file)]
        subprocess.run(create, check=True, stdout=subprocess.DEVNULL)
        assert cv2.VideoCapture(rig.camera("mine2").url("mjpeg")).read()[0]
        return time.monotonic() - start


def test_of_a_detector(folder):
    """The example of section 7, by pytest."""
    code = re.search(r"```python test\n(.*?)```", PAGE.read_text(), re.S).group(1)
    (folder / "test_mine.py").write_text(code)
    start = time.monotonic()
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", "--rootdir", str(folder), str(folder / "test_mine.py")],
                          cwd=REPOSITORY, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    return time.monotonic() - start


def bag_for_ros(folder):
    """Two seconds of two cameras recorded in lockstep, and every message read by a library for ROS 2 bags."""
    from rosbags.highlevel import AnyReader

    with report.start(str(REPOSITORY / "scenes/hall.json"), mode="lockstep") as rig:
        control = rig.call("server.info")["control"]
        start = time.monotonic()
        record = [camrig.find_binary(), "--control", control, "ros2", "record", str(folder / "bag"), "--cameras", "lobby,gallery", "--seconds", "2"]
        subprocess.run(record, check=True, env=dict(os.environ, CAMRIG_PYTHON=sys.executable), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with AnyReader([folder / "bag"]) as reader:
            assert len([reader.deserialize(data, one.msgtype) for one, _, data in reader.messages()]) > 200
        return time.monotonic() - start


PATHS = (
    ("a model of your own (`box.glb`) to its first picture in OpenCV", own_model_in_opencv),
    ("the `hall`, `simple`, to its first picture in OpenCV", shipped_scene("hall", "lobby", "simple")),
    ("the `hall`, `beautiful`", shipped_scene("hall", "lobby", "beautiful")),
    ("the `street`, `beautiful`", shipped_scene("street", "corner", "beautiful")),
    ("a rig is started again and three saved cameras are back, to a picture of the last", arrangement_comes_back),
    ("the test of section 7", test_of_a_detector),
    ("a bag of 2 s of two cameras, and all its messages read", bag_for_ros),
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    lines = ["| path | seconds, median of 3 |", "|---|---|"]
    for what, path in PATHS:
        took = []
        for _ in range(3):
            with tempfile.TemporaryDirectory() as folder:
                took.append(path(pathlib.Path(folder)))
        lines.append(f"| {what} | {sorted(took)[1]:.2f} |")
        print(lines[-1], flush=True)
    if options.write:
        report.put(PAGE, "first_steps", "\n".join(lines), "`python -m tools.bench.first_steps --write`")


if __name__ == "__main__":
    main()
