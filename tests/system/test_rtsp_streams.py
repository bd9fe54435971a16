"""The sub stream, H.265, and settings of streams that change while they are read: stock programs see them."""

import base64
import itertools
import json
import pathlib
import re
import time

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until
from rtsp_client import OPENING_REPEATS, RtspReader, gst_reads, new_ones, read_aside, record, run, stepping, stop, take

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")


def probed(url):
    done = run("ffprobe", "-v", "error", "-rtsp_transport", "tcp", "-of", "json", "-show_streams", url)
    assert done.returncode == 0 and done.stderr == b"", done.stderr.decode()
    return json.loads(done.stdout)["streams"][0]


def test_the_sub_stream_is_smaller_and_slower_and_its_pictures_are_those_of_the_main_stream(rig):
    cam = rig.create_camera("lobby", size=(640, 480), fps=25, code_strip=True)
    sub = probed(cam.url("rtsp-sub"))
    assert (sub["codec_name"], sub["width"], sub["height"]) == ("h264", 320, 240)
    readers = [read_aside(cam.url(kind)) for kind in ("rtsp", "rtsp-sub")]
    assert "a=framerate:12.5" in readers[1][2].sdp, "what ffprobe measures it guesses from a few pictures"
    wait_until(lambda: len(list(new_ones(list(readers[1][1])))) > 40, what="three seconds of the sub stream")
    shown = [list(pictures) for _, pictures, _ in readers]  # what comes later may be lost after the books were read
    books = next(camera for camera in rig.stats()["cameras"] if camera["name"] == cam.name)
    of_sub = next(output for output in books["outputs"] if output["format"] == "raw i420 320x240")
    lost = books["dropped"] + of_sub["dropped"] + sum(reader["dropped"] for reader in of_sub["readers"])  # on a busy machine
    stop(*readers)
    main, small = ({p.times.sequence: p for p in list(new_ones(pictures))[1:] if p.realtime_ns} for pictures in shown)  # the first may be one that is sent again
    both = sorted(main.keys() & small.keys())
    assert len(both) > 25
    for sequence in both:
        assert main[sequence].times == small[sequence].times
        assert abs(main[sequence].realtime_ns - small[sequence].realtime_ns) <= 1, "the reports of both streams name one time"
    steps = [b - a for a, b in itertools.pairwise(sorted(small))][5:]
    # Every second frame. Where that was lost the next one is taken, and the one after it is the usual one again: two odd steps.
    assert sum(step % 2 for step in steps) <= 2 * lost, (steps, lost)
    assert sum(max(step // 2 - 1, 0) for step in steps) <= lost, (steps, lost)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_reader_that_has_paused_holds_no_step_up(rig):
    cam = rig.create_camera("cam", size=(160, 120), fps=10, place="main")
    with stepping(rig):
        reader, other = (RtspReader(cam.url("rtsp")) for _ in range(2))
        take(reader, 2)
    other.ask("TEARDOWN", other.url)
    reader.ask("PAUSE", reader.url)
    begun = time.monotonic()
    for _ in range(30):
        rig.step(seconds=0.1)
    assert time.monotonic() - begun < 20  # each that waits for a reader ends after 10 s, with an error
    with stepping(rig):
        reader.ask("PLAY", reader.url)
        assert len(take(reader, 3)) == 3


@pytest.mark.camrig(scene="hall", mode="lockstep")
def test_the_sub_stream_is_the_main_picture_scaled(rig, tmp_path):
    cam = rig.create_camera("desk_2", place="desk", size=(640, 480),
                            outputs=[{"kind": "rtsp", "stream": "sub", "size": [320, 240], "bitrate_kbps": 20000, "preset": "medium"}])
    rig.step(seconds=1)
    exact = cv2.resize(cam.frame(format="png").image, (320, 240), interpolation=cv2.INTER_AREA).astype(np.int32)
    done = run("ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-probesize", "32", "-analyzeduration", "0", "-i", cam.url("rtsp-sub"), "-frames:v", "1",
               "-sws_flags", "accurate_rnd+full_chroma_int+bilinear", str(tmp_path / "sub.png"))
    assert done.returncode == 0, done.stderr.decode()
    difference = cv2.imread(str(tmp_path / "sub.png")).astype(np.int32) - exact
    assert np.abs(difference).mean() < 2.5
    assert np.abs(difference.mean(axis=(0, 1))).max() < 0.7


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_opening_and_closing_the_sub_stream_costs_the_main_stream_nothing(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    with stepping(rig, 0.04):
        main = read_aside(cam.url("rtsp"))
        wait_until(lambda: len(main[1]) > 10, what="the main stream")
        for _ in range(3):
            sub = read_aside(cam.url("rtsp-sub"))
            wait_until(lambda: len(sub[1]) > 5, what="the sub stream")
            stop(sub)
        seen = len(main[1])
        wait_until(lambda: len(main[1]) > seen + 10, what="more of the main stream")
    stop(main)
    # One that is sent again while an encoder takes long may have no times.
    sequences = [number for number, _ in itertools.groupby(p.times.sequence for p in main[1] if p.times)]
    steady = sequences[5:]
    assert steady == list(range(steady[0], steady[-1] + 1))


def test_nobody_reads_the_sub_stream_and_nothing_is_scaled_or_encoded(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    main = read_aside(cam.url("rtsp"))
    wait_until(lambda: len(main[1]) > 10, what="the main stream")
    formats = lambda: [output["format"] for camera in rig.call("stats.get")["cameras"] if camera["name"] == "lobby" for output in camera["outputs"]]
    assert formats() == ["raw i420"]
    sub = read_aside(cam.url("rtsp-sub"))
    wait_until(lambda: sorted(formats()) == ["raw i420", "raw i420 160x120"], what="the scaled pictures")
    stop(sub)
    wait_until(lambda: formats() == ["raw i420"], what="their end")
    stop(main)


@pytest.mark.parametrize("kind", ["rtsp", "rtsp-sub"])
@pytest.mark.parametrize("transport", ["tcp", "udp"])
def test_h265_is_read_by_ffmpeg_and_gstreamer(rig, tmp_path, kind, transport):
    stream = "sub" if kind == "rtsp-sub" else "main"
    size = {"size": [320, 240]} if stream == "sub" else {}
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, code_strip=True,
                            outputs=[{"kind": "rtsp", "codec": "h265", "stream": stream, "fps": 25, "bitrate_kbps": 1500, **size}])
    known = probed(cam.url(kind))
    assert (known["codec_name"], known["width"], known["height"], known["pix_fmt"]) == ("hevc", 320, 240, "yuv420p")
    assert (known["color_range"], known["color_space"], known["color_primaries"], known["color_transfer"]) == ("tv", "smpte170m", "bt709", "iec61966-2-1")
    assert known["r_frame_rate"] == "25/1" and known["profile"] == "Main" and known["has_b_frames"] == 0
    # Each picture that came, once: by default ffmpeg fills gaps in time, which a busy machine has, with copies.
    done = run("ffmpeg", "-v", "error", "-rtsp_transport", transport, "-i", cam.url(kind), "-fps_mode", "passthrough", "-frames:v", "150", str(tmp_path / "f%03d.png"))
    assert done.returncode == 0, done.stderr.decode()
    gst_reads(f"rtspsrc location={cam.url(kind)} protocols={transport} latency=0 ! rtph265depay ! avdec_h265 ! videoconvert ! "
              f"identity eos-after=151 ! pngenc ! multifilesink location={tmp_path}/g%03d.png")
    for files in ("f*.png", "g*.png"):
        codes = [camrig.read_code(cv2.imread(str(path))) for path in sorted(tmp_path.glob(files))]
        assert len(codes) >= 150 > 3 * OPENING_REPEATS and None not in codes[1:]
        assert len({code.sequence for code in codes if code}) > 75


def h265_units(payloads):
    """(Type, bytes) of the NAL units of RTP payloads; of one in fragments the first (RFC 7798, 4.4)."""
    for payload in payloads:
        kind = payload[0] >> 1 & 63
        if kind == 48:
            at = 2
            while at + 2 < len(payload):
                size = int.from_bytes(payload[at:at + 2], "big")
                yield payload[at + 2] >> 1 & 63, payload[at + 2:at + 2 + size]
                at += 2 + size
        elif kind != 49:
            yield kind, payload
        elif payload[2] & 0x80:
            yield payload[2] & 63, payload[3:]


# x265enc begins with parameter sets that end with memory that was never written, which may look like slices before the key picture.
def test_an_h265_stream_begins_with_parameter_sets_and_a_key_picture_and_nothing_else(monkeypatch):
    monkeypatch.setenv("MALLOC_PERTURB_", "165")  # glibc: what new memory is filled with
    with camrig.start("scenes/minimal.json", mode="realtime") as rig:
        cam = rig.create_camera("lobby", size=(320, 240), fps=25, outputs=[{"kind": "rtsp", "codec": "h265"}])
        for _ in range(5):  # a busy machine may be late; a stream that loses its first key picture loses it each time
            begin = cam.frame().sequence
            reader = RtspReader(cam.url("rtsp"))
            first = next(reader.pictures())
            reader.close()
            if (late := first.times.sequence - begin) < 10:
                break
            wait_until(lambda: not rig.stats()["cameras"][-1]["outputs"], what="the stream to end")
    assert late < 10, "without its time the first key picture would be lost, and the second comes after 13"
    units = list(h265_units(first.payloads))
    kinds = [kind for kind, _ in units]
    assert set(kinds) == {32, 33, 34, 39, 20} and kinds[-1] == 20, kinds
    sets = {kind: {unit for of, unit in units if of == kind} for kind in (32, 33, 34)}
    told = {kind: {base64.b64decode(found)} for kind, found in zip((32, 33, 34), re.findall(r"sprop-[vsp]ps=([^;\s]+)", reader.sdp), strict=True)}
    assert sets == told, "one of each kind, and the description has it"
    assert len(min(sets[34])) < 12


def test_the_decoded_h265_picture_is_the_snapshot_and_tells_when_it_was_taken(scenes, tmp_path):
    with camrig.start(str(scenes / "hall.json"), mode="lockstep") as rig:
        cam = rig.create_camera("desk_2", place="desk", size=(640, 480), outputs=[{"kind": "rtsp", "codec": "h265", "bitrate_kbps": 20000, "preset": "medium"}])
        rig.step(seconds=1)
        exact = cam.frame(format="png").image.astype(np.int32)
        errors = {}
        for kind in ("rtsp", "rtsp-mjpeg"):
            png = tmp_path / f"{kind}.png"
            done = run("ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-probesize", "32", "-analyzeduration", "0", "-i", cam.url(kind), "-frames:v", "1",
                       "-sws_flags", "accurate_rnd+full_chroma_int+bilinear", str(png))
            assert done.returncode == 0, done.stderr.decode()
            difference = cv2.imread(str(png)).astype(np.int32) - exact
            errors[kind] = np.abs(difference).mean()
            print(f"{kind}: mean difference {errors[kind]:.2f}, of the channels' means {difference.mean(axis=(0, 1)).round(2)}")
            assert np.abs(difference.mean(axis=(0, 1))).max() < 0.7  # a wrong matrix or range tints or shades the picture
        assert errors["rtsp"] < 2.5 and errors["rtsp-mjpeg"] < 2.5
        # No picture waits for the next: what a step made has been read when it is over.
        reader = read_aside(cam.url("rtsp"))
        wait_until(lambda: reader[1], what="the first picture")
        rig.step(seconds=1)
        frame = cam.frame()
        wait_until(lambda: reader[1][-1].times.sequence == frame.sequence, what="the last picture of the step")
        assert reader[1][-1].times.world_ns == frame.time_ns
        sequences = [number for number, _ in itertools.groupby(picture.times.sequence for picture in reader[1])]
        assert sequences[-25:] == list(range(frame.sequence - 24, frame.sequence + 1))
        stop(reader)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_settings_that_change_show_in_the_stream_and_only_in_theirs(rig, tmp_path, programs):
    cam = rig.create_camera("lobby", size=(640, 480), fps=25)

    def recorded(kind, frames):
        path = tmp_path / f"{time.monotonic_ns()}.mkv"
        record(rig, programs, cam.url(kind), frames, path)
        found = json.loads(run("ffprobe", "-v", "error", "-of", "json", "-show_entries", "stream=codec_name,width,height:packet=flags,size", str(path)).stdout)
        keys = [number for number, packet in enumerate(found["packets"]) if "K" in packet["flags"]]
        return found["streams"][0], {b - a for a, b in zip(keys[1:], keys[2:])}, sum(int(packet["size"]) for packet in found["packets"])

    sub = {"kind": "rtsp", "stream": "sub", "fps": 25, "key_interval_s": 0.4}
    main = read_aside(cam.url("rtsp"))
    wait_until(lambda: main[1], what="the main stream")
    cam.set(outputs=[sub])
    stream, keys, _ = recorded("rtsp-sub", 45)
    assert (stream["codec_name"], stream["width"], stream["height"], keys) == ("h264", 320, 240, {10})
    with stepping(rig):
        watched = read_aside(cam.url("rtsp-sub"))
        wait_until(lambda: watched[1], what="the sub stream")
        cam.set(outputs=[{**sub, "size": [160, 120], "key_interval_s": 0.2, "codec": "h265"}])
        watched[0].join(20)
        assert not watched[0].is_alive(), "its readers are sent away"
    stream, keys, _ = recorded("rtsp-sub", 45)
    assert (stream["codec_name"], stream["width"], stream["height"], keys) == ("hevc", 160, 120, {5})
    with stepping(rig):
        seen = len(main[1])
        wait_until(lambda: len(main[1]) > seen + 10, what="the main stream, which goes on")
        assert main[0].is_alive()
    cam.set(outputs=[])
    assert recorded("rtsp-sub", 5)[0]["width"] == 320
    stop(main)


def test_settings_that_cannot_be_are_refused(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    for output, why in (
        ({"stream": "sub", "size": [640, 480]}, "more than the camera's 320x240"),
        ({"stream": "sub", "size": [8, 8]}, "16x16 to 8192x8192"),
        ({"size": [160, 120]}, "only the sub stream"),
        ({"stream": "sub", "fps": 0.01}, "1/10 to 1000"),
        ({"codec": "vp9"}, "h265"),
        ({"codec": "h265", "bitrate_kbps": 5}, "16 to 200000"),
    ):
        with pytest.raises(camrig.CamrigError, match=re.escape(why)):
            cam.set(outputs=[{"kind": "rtsp", **output}])
    with pytest.raises(camrig.CamrigError, match="is the same output as"):
        cam.set(outputs=[{"kind": "rtsp"}, {"kind": "rtsp", "codec": "h265"}])
    assert cam.get()["outputs"] == []


def test_without_its_encoder_a_stream_says_what_to_install(scenes, tmp_path, monkeypatch):
    where = pathlib.Path(run("pkg-config", "--variable=pluginsdir", "gstreamer-1.0").stdout.decode().strip())
    plugins = tmp_path / "plugins"
    plugins.mkdir()
    for plugin in where.glob("libgst*.so"):
        if plugin.name != "libgstx265.so":
            (plugins / plugin.name).symlink_to(plugin)
    monkeypatch.setenv("GST_PLUGIN_SYSTEM_PATH_1_0", str(plugins))
    monkeypatch.setenv("GST_REGISTRY_1_0", str(tmp_path / "registry.bin"))
    with camrig.start(str(scenes / "minimal.json"), mode="realtime", args=["--onvif", "0"]) as rig:
        cam = rig.create_camera("lobby", size=(320, 240), fps=25, outputs=[{"kind": "rtsp", "codec": "h265"}])
        done = run("ffprobe", "-v", "error", cam.url("rtsp"))
        assert done.returncode != 0 and b"415" in done.stderr and b"gstreamer1.0-plugins-bad" in done.stderr
        assert run("ffprobe", "-v", "error", cam.url("rtsp-sub")).returncode == 0
