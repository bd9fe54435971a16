"""A sensor's numbers on /dev/videoN, read by programs that know nothing of camrig."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from compliance import complaints

CAMRIG = os.environ["CAMRIG_BIN"]
pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
STAND = {"position": [-6, 0, 2.5], "look_at": [0, 0, 0.5]}
# The same numbers in every picture: nothing random, nothing that moves in it.
STILL = {"prnu": 0, "dsnu_e": 0, "row_noise_e": 0, "hot_pixels_ppm": 0, "white_balance": 6500}
DOWN = {"position": [0, 0, 50], "look_at": [0, 0.001, 100]}

AS_OPENCV = """
import sys, cv2
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*sys.argv[2]))
ok, image = capture.read()
assert ok
print(image.dtype, image.shape, image.mean())
"""


def run_exec(rig, *command):
    done = subprocess.run([CAMRIG, "exec", "--control", rig.call("server.info")["control"], "--", *command],
                          capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def listed(rig, number):
    return re.findall(r"'(.{4})' \(", run_exec(rig, "v4l2-ctl", "-d", f"/dev/video{number}", "--list-formats"))


def captured(rig, number, fourcc, file, dtype, size):
    """The bytes of a buffer, as v4l2-ctl writes them."""
    width, height = size
    run_exec(rig, "v4l2-ctl", "-d", f"/dev/video{number}", f"--set-fmt-video=pixelformat={fourcc},width={width},height={height}",
             "--stream-mmap", "--stream-count=1", f"--stream-to={file}")
    return np.fromfile(file, dtype).reshape(height, width)


def test_numbers_are_offered_by_cameras_that_count_them(rig):
    pictures = ["YUYV", "MJPG", "YU12", "NV12", "BGR3"]
    for number, (sensor, more) in enumerate((
        (None, []),
        ({"preset": "ideal"}, []),
        ({"preset": "imx219"}, ["RG10", "RG16", "RGGB"]),
        ({"preset": "imx477", "filter": "bggr"}, ["BG12", "BYR2", "BA81"]),
        ({"preset": "imx477", "filter": "gbrg", "bits": 10}, ["GB10", "GB16", "GBRG"]),
        ({"preset": "ov9281"}, ["Y10 ", "Y16 ", "GREY"]),
        ({"preset": "imx249"}, ["Y12 ", "Y16 ", "GREY"]),
        ({"filter": "mono", "bits": 16}, ["Y16 ", "GREY"]),
        ({"filter": "mono", "bits": 9}, ["Y10 ", "Y16 ", "GREY"]),
    )):
        rig.create_camera(f"cam{number}", size=(320, 240), **STAND, **({"sensor": sensor} if sensor else {}),
                          outputs=[{"kind": "device", "number": number}])
        assert listed(rig, number) == pictures + more, sensor
    # Numbers are not scaled.
    every = run_exec(rig, "v4l2-ctl", "-d", "/dev/video2", "--list-formats-ext")
    assert every.count("Size: Discrete 160x120") == 5 and every.count("Size: Discrete 320x240") == 8
    rig.create_camera("odd", size=(321, 241), **STAND, sensor={"preset": "ov9281"}, outputs=[{"kind": "device", "number": 20}])
    assert listed(rig, 20) == pictures


@pytest.mark.parametrize("preset, fourccs", [("ov9281", ("Y10 ", "Y16 ", "GREY")), ("imx219", ("RG10", "RG16", "RGGB")), ("imx249", ("Y12 ", "Y16 ", "GREY"))])
def test_v4l2_ctl_reads_the_numbers_that_frame_get_gives(rig, tmp_path, preset, fourccs):
    size = (320, 240)
    sensor = {**STILL, "preset": preset, "exposure_s": 0.002}
    cam = rig.create_camera("counts", size=size, fps=25, **DOWN, sensor=sensor, outputs=[{"kind": "device", "number": 7}])
    asked = cam.frame(kind="sensor")
    bits, mean = asked.sensor["bits"], asked.image.mean()
    assert asked.sensor["black_level"] + 20 < mean < 2 ** bits - 20
    own, wide, narrow = (captured(rig, 7, fourcc, tmp_path / "raw", dtype, size)
                         for fourcc, dtype in zip(fourccs, ("<u2", "<u2", "u1"), strict=True))
    # Other pictures of the same light: the same means, at each place of a mosaic.
    for y, x in ((0, 0), (0, 1), (1, 0), (1, 1)):
        here = asked.image[y::2, x::2].mean()
        assert own[y::2, x::2].mean() == pytest.approx(here, rel=0.005)
        assert wide[y::2, x::2].mean() == pytest.approx(here * 2 ** (16 - bits), rel=0.005)
        assert narrow[y::2, x::2].mean() == pytest.approx(here / 2 ** (bits - 8) - 0.5, abs=0.5)
    assert own.max() < 2 ** bits and (wide % 2 ** (16 - bits) == 0).all()
    assert own.std() == pytest.approx(asked.image.std(), rel=0.05)  # noise too
    cam.set(sensor=None)
    assert "Y10 " not in listed(rig, 7) and "RG10" not in listed(rig, 7)


def test_opencv_and_ffmpeg_read_what_they_can(rig, tmp_path):
    cam = rig.create_camera("counts", size=(320, 240), fps=25, **DOWN, sensor={**STILL, "preset": "ov9281", "exposure_s": 0.002},
                            outputs=[{"kind": "device", "number": 7}])
    mean = cam.frame(kind="sensor").image.mean()
    for fourcc, kind, factor in (("Y10 ", "uint16", 1), ("Y16 ", "uint16", 64), ("GREY", "uint8", 0.25)):
        said = run_exec(rig, sys.executable, "-c", AS_OPENCV, "/dev/video7", fourcc)
        dtype, value = said.split()[0], float(said.strip().split()[-1])
        assert dtype == kind and value == pytest.approx(mean * factor, abs=max(1, factor)), said  # of 8 bits the lowest are cut off
    for name, dtype, factor in (("gray16le", "<u2", 64), ("gray", "u1", 0.25)):
        raw = tmp_path / name
        run_exec(rig, "ffmpeg", "-v", "error", "-y", "-f", "v4l2", "-pixel_format", name, "-i", "/dev/video7", "-frames:v", "1",
                 "-f", "rawvideo", str(raw))
        assert np.fromfile(raw, dtype).mean() == pytest.approx(mean * factor, abs=max(1, factor))


def test_pictures_and_numbers_are_read_beside_each_other(rig, tmp_path):
    rig.create_camera("counts", size=(320, 240), fps=25, **DOWN, code_strip=True, sensor={**STILL, "preset": "imx219", "exposure_s": 0.002},
                      outputs=[{"kind": "device", "number": 7}])
    reader = subprocess.Popen([CAMRIG, "exec", "--control", rig.call("server.info")["control"], "--", "v4l2-ctl", "-d", "/dev/video7",
                               "--set-fmt-video=pixelformat=RG10,width=320,height=240", "--stream-mmap", "--stream-count=30"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        run_exec(rig, sys.executable, "-c",
                 "import cv2, camrig\nc = cv2.VideoCapture('/dev/video7', cv2.CAP_V4L2)\n"
                 "codes = [camrig.read_code(c.read()[1]).sequence for _ in range(8)]\n"
                 "assert codes == sorted(codes) and len(set(codes)) > 4, codes")  # on a busy machine the last one comes again
        assert reader.wait(60) == 0, reader.stdout.read()
    finally:
        reader.kill()


@pytest.mark.slow
def test_v4l2_compliance_finds_nothing_where_there_are_numbers(rig):
    rig.create_camera("counts", size=(320, 240), fps=20, **STAND, sensor={"preset": "imx219", "exposure_s": "auto"},
                      outputs=[{"kind": "device", "number": 7}])
    report = run_exec(rig, "v4l2-compliance", "-d", "/dev/video7", "-s")
    assert not complaints(report), report[-3000:]
