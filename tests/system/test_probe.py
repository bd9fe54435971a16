"""camrig probe measures what a program gets, through the same doors as any program."""

import json
import os
import socket
import subprocess
import threading
import time
import urllib.request

import pytest

CAMRIG = os.environ["CAMRIG_BIN"]


def run_probe(*arguments, timeout=60):
    done = subprocess.run([CAMRIG, "probe", "--json", *arguments], capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def run_probe_exec(rig, *arguments, timeout=60):
    control = rig.call("server.info")["control"]
    done = subprocess.run([CAMRIG, "exec", "--control", control, "--", CAMRIG, "probe", "--json", *arguments],
                          capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


COUNT = ("--frames", "30", "--seconds", "60")  # a busy machine takes longer, and the numbers are the same


def check_two_synchronous_sources(report, size):
    first, second = report["sources"]
    for source in (first, second):
        assert source["size"] == size
        assert source["pictures"] == 30
        assert source["rate"] == pytest.approx(29 / source["seconds"])
        assert source["strips"] == source["pictures"]
        assert source["torn"] == source["out_of_order"] == 0
        assert source["repeats"] <= source["seconds"] - 1, "after a second without a picture the last one comes again, on a busy machine"
        assert source["latency_ms"]["p50"] > 0 and source["latency_by"] == "stamp"
    (skew,) = report["skew"]
    assert (skew["source"], skew["reference"]) == (second["source"], first["source"])
    # They show the same instants, but for those that a busy machine did not let the first have.
    assert 0 < skew["common"] <= skew["pictures"] <= skew["common"] + first["drops"]
    assert skew["stamp_max_ns"] == 0  # and say so, to the nanosecond (devices: microsecond)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_two_streams_over_http_are_synchronous(rig):
    cameras = [rig.create_camera(name, size=(320, 240), fps=20, code_strip=True) for name in ("a", "b")]
    report = run_probe(*COUNT, *(camera.url() for camera in cameras))
    check_two_synchronous_sources(report, [320, 240])
    assert all(source["kind"] == "http" for source in report["sources"])


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
@pytest.mark.parametrize("fourcc", ["YUYV", "MJPG", "YU12", "NV12", "BGR3"])
def test_two_devices_are_synchronous(rig, fourcc):
    for name, number in (("a", 7), ("b", 8)):
        rig.create_camera(name, size=(320, 240), fps=20, code_strip=True, outputs=[{"kind": "device", "number": number}])
    report = run_probe_exec(rig, *COUNT, "--format", fourcc, "/dev/video7", "/dev/video8")
    check_two_synchronous_sources(report, [320, 240])
    assert all(source["kind"] == "device" and source["format"] == fourcc for source in report["sources"])


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_device_and_a_stream_show_the_same_instants(rig):
    camera = rig.create_camera("a", size=(320, 240), fps=20, code_strip=True, outputs=[{"kind": "device", "number": 7}])
    report = run_probe_exec(rig, *COUNT, "/dev/video7", camera.url())
    assert [source["pictures"] for source in report["sources"]] == [30, 30]
    (skew,) = report["skew"]
    assert 0 < skew["common"] <= skew["pictures"] <= skew["common"] + report["sources"][0]["drops"]
    assert skew["stamp_max_ns"] < 1000  # V4L2 stamps count microseconds


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_rtsp_shows_the_same_instants_as_http(rig):
    camera = rig.create_camera("a", size=(320, 240), fps=20, code_strip=True, outputs=[{"kind": "rtsp", "codec": "h264"}])
    report = run_probe(*COUNT, "--timeout", "20", camera.url(), rig.rtsp_url + "/a")
    http, rtsp = report["sources"]
    assert (rtsp["kind"], rtsp["format"], rtsp["size"]) == ("rtsp", "H264", [320, 240])
    assert rtsp["strips"] > 0 and rtsp["torn"] == rtsp["out_of_order"] == 0
    assert rtsp["latency_ms"]["p50"] > 0  # by sender reports, or by the world time in the pixels
    (skew,) = report["skew"]
    assert 0 < skew["common"] <= skew["pictures"] <= skew["common"] + http["drops"]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_lower_rate_meets_the_higher_one(rig):
    rig.create_camera("a", size=(320, 240), fps=20, code_strip=True)
    rig.create_camera("b", size=(320, 240), fps=5, code_strip=True)
    report = run_probe("--frames", "20", "--seconds", "60", *(rig.camera(name).url() for name in ("a", "b")))
    (skew,) = report["skew"]
    # Every picture of b is one of a, too, but for those that a busy machine did not let a have.
    assert 0 < skew["common"] <= skew["pictures"] <= skew["common"] + report["sources"][0]["drops"]
    words = subprocess.run([CAMRIG, "probe", "--seconds", "0.5", rig.camera("a").url()], capture_output=True, text=True, timeout=60, check=True)
    assert "RATE" in words.stdout and "LATENCY" in words.stdout


def fails_with(*arguments, within_s=30):
    begun = time.monotonic()
    done = subprocess.run([CAMRIG, "probe", *arguments], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert time.monotonic() - begun < within_s
    return done.stderr


def test_sources_that_are_not_there_are_told_in_one_line():
    assert "camrig exec" in fails_with("/dev/video250")
    assert "/dev/null" in fails_with("/dev/null")
    assert "cannot connect" in fails_with("http://127.0.0.1:1/stream.mjpg")
    assert "give a /dev/videoN" in fails_with("ftp://127.0.0.1/")
    assert "http://HOST" in fails_with("http://")
    assert fails_with("--timeout", "2", "rtsp://127.0.0.1:1/a")


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_pages_that_are_no_stream_are_told_in_one_line(rig):
    assert "404" in fails_with(rig.http_url + "/cameras/nobody/stream.mjpg")
    assert "no MJPEG stream" in fails_with(rig.http_url + "/cameras/main/snapshot.jpg")


def test_a_server_that_says_nothing_costs_bounded_time():
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = "http://127.0.0.1:%d/" % server.getsockname()[1]
        assert "no answer in time" in fails_with("--timeout", "1", address)

        def accept_and_begin():
            connection, _ = server.accept()
            connection.recv(4096)
            connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=f\r\n\r\n--f\r\n")
            stop.wait(30)
            connection.close()

        stop = threading.Event()
        thread = threading.Thread(target=accept_and_begin, daemon=True)
        server.accept()[0].close()  # the one above
        thread.start()
        assert "no picture" in fails_with("--timeout", "4", address)
        stop.set()
        thread.join(10)


def chunked(server, jpeg, parts):
    """Streams as an ESP32 camera does: HTTP/1.1, chunked, no Content-Length in the parts."""
    connection, _ = server.accept()
    with connection:
        connection.recv(4096)
        connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=12ab\r\nTransfer-Encoding: chunked\r\n\r\n")
        for _ in range(parts):
            for piece in (b"\r\n--12ab\r\n", b"Content-Type: image/jpeg\r\n\r\n", jpeg[: len(jpeg) // 2], jpeg[len(jpeg) // 2 :]):
                connection.sendall(b"%x\r\n%s\r\n" % (len(piece), piece))


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_chunked_stream_without_lengths_is_read(rig):
    jpeg = urllib.request.urlopen(rig.http_url + "/cameras/main/snapshot.jpg", timeout=30).read()
    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=chunked, args=(server, jpeg, 10), daemon=True)
        thread.start()
        report = run_probe("--frames", "8", "http://127.0.0.1:%d/" % server.getsockname()[1])
        thread.join(10)
    (source,) = report["sources"]
    assert source["pictures"] == 8 and source["torn"] == 0 and source["strips"] == 0
    assert source["latency_ms"] is None and report["skew"] == []
