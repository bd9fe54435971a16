"""Unmodified programs watch the rig: OpenCV, ffmpeg, ffprobe, curl."""

import json
import subprocess

import cv2
import numpy as np
import pytest

import camrig
from rtsp_client import strictly_rising, without_repeats

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")


def run(*command, timeout=60):
    return subprocess.run(command, capture_output=True, timeout=timeout, check=False)


def test_opencv_opens_the_stream(rig):
    cam = rig.create_camera("lobby", size=(640, 480), code_strip=True)
    capture = cv2.VideoCapture(cam.url())
    assert capture.isOpened()
    shown = []
    for _ in range(25):
        ok, image = capture.read()
        assert ok and image.shape == (480, 640, 3)
        shown.append(camrig.read_code(image).sequence)
    assert strictly_rising(shown := without_repeats(shown)) and len(shown) > 5


def test_ffmpeg_reads_the_stream(rig, tmp_path):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    done = run("ffmpeg", "-v", "error", "-i", cam.url(), "-frames:v", "10", str(tmp_path / "%02d.png"))
    assert done.returncode == 0, done.stderr.decode()
    assert done.stderr == b""
    codes = [camrig.read_code(cv2.imread(str(path))) for path in sorted(tmp_path.glob("*.png"))]
    assert len(codes) == 10
    assert strictly_rising(shown := without_repeats(code.sequence for code in codes)) and len(shown) > 2


def test_ffprobe_knows_what_it_is(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    done = run("ffprobe", "-v", "error", "-of", "json", "-show_streams", cam.url())
    stream = json.loads(done.stdout)["streams"][0]
    assert (stream["codec_name"], stream["width"], stream["height"]) == ("mjpeg", 320, 240)
    assert stream["pix_fmt"] == "yuvj420p"


def test_curl_takes_snapshots(rig):
    rig.create_camera("lobby", size=(320, 240))
    base = f"{rig.http_url.rstrip('/')}/cameras/lobby/snapshot"
    for suffix, content_type in (("jpg", "image/jpeg"), ("png", "image/png")):
        done = run("curl", "-sS", "-i", f"{base}.{suffix}")
        head, _, body = done.stdout.partition(b"\r\n\r\n")
        assert b"200" in head.splitlines()[0]
        assert content_type.encode() in head
        assert b"x-world-time-ns" in head.lower()
        assert cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)


def test_a_low_rate_and_quality_can_be_asked_for(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, code_strip=True)
    capture = cv2.VideoCapture(cam.url(fps=5, quality=50))
    codes = []
    for _ in range(6):
        ok, image = capture.read()
        assert ok
        codes.append(camrig.read_code(image))
    # One frame in each fifth of a second; the very first is the latest at hand.
    shown = without_repeats(code.time_ns for code in codes)[1:]
    assert strictly_rising([time_ns * 5 // 10**9 for time_ns in shown]) and len(shown) > 1


def test_list_health_and_metrics(rig):
    rig.create_camera("lobby", size=(320, 240))
    base = rig.http_url.rstrip("/")
    assert run("curl", "-sS", "-f", f"{base}/healthz").returncode == 0
    assert b"lobby" in run("curl", "-sS", f"{base}/cameras").stdout
    metrics = run("curl", "-sS", f"{base}/metrics").stdout.decode()
    assert "# TYPE" in metrics and "lobby" in metrics
    assert run("curl", "-sS", "-f", f"{base}/").returncode == 0


def test_rpc_over_http(rig):
    base = rig.http_url.rstrip("/")
    done = run("curl", "-sS", "-H", "Content-Type: application/json", "-d",
               '{"jsonrpc":"2.0","id":1,"method":"world.status"}', f"{base}/rpc")
    assert json.loads(done.stdout)["result"]["mode"] == "realtime"


def test_a_deleted_camera_ends_its_stream_and_can_come_back(rig):
    cam = rig.create_camera("lobby", size=(160, 120))
    capture = cv2.VideoCapture(cam.url())
    assert capture.read()[0]
    cam.delete()
    for _ in range(200):
        if not capture.read()[0]:
            break
    else:
        pytest.fail("the stream did not end")
    rig.create_camera("lobby", size=(320, 240))
    capture = cv2.VideoCapture(cam.url())
    ok, image = capture.read()
    assert ok and image.shape == (240, 320, 3)
