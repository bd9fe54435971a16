"""Every camera is a network camera: stock programs read it by RTSP."""

import itertools
import json
import socket

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until
from rtsp_client import (OPENING_REPEATS, RtspReader, asked, gst_reads, has_its_asked_key, is_key_frame, read_aside, record, run, strictly_rising, take,
                         unwrapped, without_repeats)

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")


def codes_of(paths):
    return [camrig.read_code(cv2.imread(str(path))) for path in paths]


@pytest.mark.parametrize("transport", ["tcp", "udp"])
def test_ffprobe_knows_what_it_is(rig, transport):
    cam = rig.create_camera("lobby", size=(640, 480), fps=25)
    done = run("ffprobe", "-v", "error", "-rtsp_transport", transport, "-of", "json", "-show_streams", cam.url("rtsp"))
    assert done.returncode == 0 and done.stderr == b"", done.stderr.decode()
    stream = json.loads(done.stdout)["streams"][0]
    assert (stream["codec_name"], stream["width"], stream["height"]) == ("h264", 640, 480)
    assert (stream["pix_fmt"], stream["color_range"], stream["color_space"]) == ("yuv420p", "tv", "smpte170m")
    assert (stream["color_primaries"], stream["color_transfer"]) == ("bt709", "iec61966-2-1")
    assert stream["r_frame_rate"] == "25/1" and stream["profile"] == "Main" and stream["has_b_frames"] == 0


@pytest.mark.parametrize("transport", ["tcp", "udp"])
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_ffmpeg_reads_it(rig, tmp_path, kind, transport):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    # Each picture that came, once: by default ffmpeg fills gaps in time, which a busy machine has, with copies.
    done = run("ffmpeg", "-v", "error", "-rtsp_transport", transport, "-i", cam.url(kind), "-fps_mode", "passthrough", "-frames:v", "150", str(tmp_path / "%03d.png"))
    assert done.returncode == 0, done.stderr.decode()
    codes = codes_of(sorted(tmp_path.glob("*.png")))
    assert len(codes) == 150 > 3 * OPENING_REPEATS and None not in codes
    assert all(a.sequence <= b.sequence for a, b in zip(codes, codes[1:]))  # after a second without one the rig sends the last one again
    assert len({code.sequence for code in codes}) > 75


@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_opencv_reads_it(rig, kind):
    cam = rig.create_camera("lobby", size=(640, 480), code_strip=True)
    capture = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG)
    assert capture.isOpened()
    sequences = []
    for _ in range(150):
        ok, image = capture.read()
        assert ok and image.shape == (480, 640, 3)
        sequences.append(camrig.read_code(image).sequence)
    shown = without_repeats(sequences)
    assert strictly_rising(shown) and len(shown) > 75


@pytest.mark.parametrize("protocol", ["tcp", "udp"])
@pytest.mark.parametrize("kind, decoder", [("rtsp", "rtph264depay ! avdec_h264"), ("rtsp-mjpeg", "rtpjpegdepay ! jpegdec idct-method=islow")])  # its fast one garbles code strips
def test_gstreamer_reads_it(rig, tmp_path, kind, decoder, protocol):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    pipeline = f"rtspsrc location={cam.url(kind)} protocols={protocol} latency=0 ! {decoder} ! videoconvert ! " \
               f"identity eos-after=151 ! pngenc ! multifilesink location={tmp_path}/%03d.png"
    gst_reads(pipeline)
    codes = codes_of(sorted(tmp_path.glob("*.png")))
    assert len(codes) >= 150
    shown = without_repeats(code.sequence for code in codes if code)
    assert strictly_rising(shown) and len(shown) > 75


@pytest.mark.parametrize("encoder", ["x264enc", "openh264enc"])
def test_the_decoded_picture_is_the_snapshot(scenes, tmp_path, encoder):
    """Matrix and range are signalled (or what programs assume) and right, no pixel moves, and no picture waits for the next."""
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", args=["--rtsp-encoder", encoder]) as rig:
        compare_decoded(rig, tmp_path, limit=2.0 if encoder == "x264enc" else 3.5)  # openh264enc spends less on a key frame
        cam = rig.create_camera("lobby_2", place="lobby", size=(320, 240), fps=25)
        thread, pictures, reader = read_aside(cam.url("rtsp"))
        wait_until(lambda: pictures, what="the first picture")
        rig.step(seconds=1)
        last = cam.frame().sequence
        wait_until(lambda: pictures[-1].times.sequence == last, what="the last picture of the step")
        sequences = [number for number, _ in itertools.groupby(picture.times.sequence for picture in pictures)]
        assert sequences[-25:] == list(range(last - 24, last + 1))
        reader.socket.shutdown(socket.SHUT_RDWR)
        thread.join()


def compare_decoded(rig, tmp_path, limit):
    cam = rig.create_camera("desk_2", place="desk", size=(640, 480),
                            outputs=[{"kind": "rtsp", "bitrate_kbps": 20000, "preset": "medium"}])
    rig.step(seconds=1)
    exact = cam.frame(format="png").image.astype(np.int32)
    for kind, limit in (("rtsp", limit), ("rtsp-mjpeg", 2.5)):
        png = tmp_path / f"{kind}.png"
        done = run("ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-probesize", "32", "-analyzeduration", "0", "-i", cam.url(kind), "-frames:v", "1",
                   "-sws_flags", "accurate_rnd+full_chroma_int+bilinear", str(png))
        assert done.returncode == 0, done.stderr.decode()
        difference = cv2.imread(str(png)).astype(np.int32) - exact
        print(f"{kind}: mean difference {np.abs(difference).mean():.2f}, of the channels' means {difference.mean(axis=(0, 1)).round(2)}")
        assert np.abs(difference).mean() < limit
        assert np.abs(difference.mean(axis=(0, 1))).max() < 0.7  # a wrong matrix or range tints or shades the picture


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_profile_and_key_interval_are_those_asked_for(rig, tmp_path, programs):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, outputs=[{"kind": "rtsp", "profile": "baseline", "key_interval_s": 0.4}])
    record(rig, programs, cam.url("rtsp"), 45, tmp_path / "a.mkv")
    done = run("ffprobe", "-v", "error", "-of", "json", "-show_entries", "stream=profile:packet=flags", str(tmp_path / "a.mkv"))
    found = json.loads(done.stdout)
    assert found["streams"][0]["profile"] == "Constrained Baseline"
    keys = [number for number, packet in enumerate(found["packets"]) if "K" in packet["flags"]]
    assert keys[0] == 0 and {b - a for a, b in zip(keys[1:], keys[2:])} == {10}


def test_a_client_that_joins_gets_a_key_frame_at_once_and_many_share_one(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, outputs=[{"kind": "rtsp", "key_interval_s": 60}])
    thread, watched, watcher = read_aside(cam.url("rtsp"), join=asked)
    wait_until(lambda: len(watched) > 25 and has_its_asked_key(watched), what="a second of the stream")
    own = sum(map(is_key_frame, list(watched)))
    joining = [RtspReader(cam.url("rtsp")) for _ in range(4)]
    for reader in joining:
        shown = take(reader, 20)
        assert any(is_key_frame(picture) for picture in shown)
        reader.close()
    wait_until(lambda: shown[-1].stamp in [picture.stamp for picture in list(watched)], what="the pictures of those who joined")
    watcher.socket.shutdown(socket.SHUT_RDWR)
    thread.join()
    watcher.close()
    stamps = unwrapped([picture.stamp for picture in watched if is_key_frame(picture)])
    assert 1 <= own <= 2  # the stream's first, and the one that the first reader asked for
    assert 1 <= len(stamps) - own <= 4  # one to four for those who joined
    assert all(b - a >= 0.45 * 90_000 for a, b in zip(stamps, stamps[1:])), "key frames come closer together than half a second"


def test_an_odd_size_loses_its_last_column_and_row(rig, tmp_path):
    cam = rig.create_camera("odd", size=(321, 241))
    capture = cv2.VideoCapture(cam.url("rtsp"), cv2.CAP_FFMPEG)
    ok, image = capture.read()
    assert ok and image.shape == (240, 320, 3)
    rig.pause()
    exact = cam.frame().image[:240, :320].astype(np.int32)
    assert np.abs(image.astype(np.int32) - exact).mean() < 6


def test_mjpeg_of_a_size_that_rtp_cannot_carry_is_refused_with_a_way_out(rig):
    cam = rig.create_camera("odd", size=(324, 240))
    done = run("ffprobe", "-v", "error", cam.url("rtsp-mjpeg"))
    assert done.returncode != 0
    assert b"415" in done.stderr and b"H.264 at /odd or MJPEG over HTTP" in done.stderr
    assert run("ffprobe", "-v", "error", cam.url("rtsp")).returncode == 0


def test_an_unknown_camera_is_not_found_and_the_answer_names_those_there_are(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    done = run("ffprobe", "-v", "error", cam.url("rtsp") + "x")
    assert b"404" in done.stderr and b"/lobby " in done.stderr
