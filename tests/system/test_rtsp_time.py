"""RTP stamps, sender reports and messages in the picture tell when a frame was taken; streams end and come back."""

import itertools
import re
import socket
import struct
import subprocess
import sys
import time

import cv2
import pytest

import camrig
from conftest import REPOSITORY, wait_until
from rtsp_client import LibavReader, RtspReader, assert_gst_read_to_the_end, ended, gst_launch, libav_program, new_ones, read_aside, run, stepping, stop, strictly_rising, take, unwrapped, without_repeats

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")

TICK_NS = 10**9 / 90_000


@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_two_cameras_give_one_instant_the_same_time(rig, kind):
    """Independent readers; frames are paired by their sender reports alone."""
    cameras = [rig.create_camera(name, size=(320, 240), code_strip=True) for name in ("left", "right")]
    readers = [read_aside(cam.url(kind)) for cam in cameras]
    known = lambda: [[p for p in list(new_ones(list(pictures)))[1:] if p.realtime_ns] for _, pictures, _ in readers]  # the first may be one that is sent again

    def both_know():
        """75 pictures each, from when both streams run and both have a report."""
        left, right = known()
        begin_ns = max(left[0].realtime_ns, right[0].realtime_ns) if left and right else 0
        return begin_ns and all(sum(p.realtime_ns >= begin_ns for p in pictures) >= 75 for pictures in (left, right))

    wait_until(both_know, 60, "75 pictures with their times from each")
    stop(*readers)
    without = [sum(p.realtime_ns is None for p in new_ones(pictures)) for _, pictures, _ in readers]
    assert max(without) < 15, "the first sender report came late"
    times = [[p.realtime_ns for p in pictures] for pictures in known()]
    pairs = [(a, b) for a in times[0] for b in times[1] if abs(a - b) < 10**7]
    assert len(pairs) > 40
    assert max(abs(a - b) for a, b in pairs) <= TICK_NS
    if kind == "rtsp":  # the message in the picture says the same, and which frame it is
        by_report = [{p.realtime_ns: p.times for p in pictures} for pictures in known()]
        for a, b in pairs:
            left, right = by_report[0][a], by_report[1][b]
            assert (left.world_ns, left.monotonic_ns, left.realtime_ns) == (right.world_ns, right.monotonic_ns, right.realtime_ns)
            assert 0 <= left.realtime_ns - a <= TICK_NS + 2


@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_two_ffmpeg_readers_pair_frames_of_one_instant_by_their_reports(rig, libav_program, kind):
    """Frames with the same absolute time show the same world time, through pause, resume and another frame rate."""
    cameras = [rig.create_camera(name, size=(320, 240), fps=25, code_strip=True) for name in ("left", "right")]
    read = lambda: [LibavReader(libav_program, cam.url(kind)) for cam in cameras]
    have = lambda readers, count: wait_until(lambda: all(len(r.timed()) >= count for r in readers), 40, f"{count} frames with absolute times")
    first = read()
    have(first, 20)
    rig.pause()
    have(first, max(len(r.timed()) for r in first) + 2)  # the last picture comes again
    rig.resume()
    have(first, max(len(r.timed()) for r in first) + 20)
    for cam in cameras:
        cam.set(fps=10)
    assert [reader.wait() for reader in first] == [0, 0]  # their streams ended
    second = read()
    have(second, 15)
    for reader in second:
        reader.close()

    shown = []  # per camera: {absolute time: world time}; pictures that came again are left out
    for before, after in zip(first, second):
        assert strictly_rising([frame.pts for frame in before.frames]) and strictly_rising([frame.pts for frame in after.frames])
        frames = before.timed() + after.timed()
        assert strictly_rising([frame.wall_us for frame in frames])
        assert all(frame.code for frame in frames)
        fresh = [b for a, b in itertools.pairwise(frames) if b.code.sequence != a.code.sequence]
        shown.append({frame.wall_us: frame.code.time_ns for frame in fresh})
    pairs = [(a, b) for a in shown[0] for b in shown[1] if abs(a - b) < 5_000]
    assert len(pairs) > 40
    assert all(shown[0][a] == shown[1][b] for a, b in pairs)
    skew_us = max(abs(a - b) for a, b in pairs)
    print(f"{kind}: {len(pairs)} pairs, skew at most {skew_us} us")
    assert skew_us <= TICK_NS / 1000


def test_the_message_in_the_picture_agrees_with_its_code_strip(rig, tmp_path):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    reader = RtspReader(cam.url("rtsp"))
    pictures = take(reader, 90)
    assert all(p.times for p in pictures)
    shown = without_repeats(p.times.sequence for p in pictures)
    assert strictly_rising(shown) and len(shown) > 15  # of twice as many as are sent again at most (OPENING_REPEATS)
    for p in pictures:
        if p.times.sequence == pictures[0].times.sequence:
            continue  # it may show the moment the camera was made, and be sent again
        assert p.times.world_ns == p.times.sequence * 40_000_000
    for p in pictures:
        assert abs(p.times.realtime_ns - time.time_ns()) < 60 * 10**9


def test_stamps_rise_through_pause_resume_and_follow_the_clock(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    reader = RtspReader(cam.url("rtsp"))
    pictures = take(reader, 20)
    rig.pause()
    standing = take(reader, 4)  # the last picture comes again while the world stands still
    while standing[-1].times.sequence != standing[-2].times.sequence:
        standing.append(take(reader, 1)[0])
    held_ns = rig.status()["world_ns"]
    rig.resume()
    moving = take(reader, 20)
    everything = pictures + standing + moving
    stamps = unwrapped([p.stamp for p in everything])
    assert strictly_rising(stamps)
    assert moving[-1].times.world_ns > held_ns
    # World time stood still, stamps did not: they follow CLOCK_MONOTONIC.
    fresh = [(s, p.times) for s, p in zip(stamps, everything)]
    seen, firsts = set(), []
    for stamp, times in fresh:
        if times.sequence not in seen:
            firsts.append((stamp, times.monotonic_ns))
        seen.add(times.sequence)
    for (s0, t0), (s1, t1) in itertools.pairwise(firsts[1:]):
        assert abs((s1 - s0) - (t1 - t0) * 9 / 100_000) <= 1.001


def test_a_paused_world_can_be_opened_and_shows_its_picture(rig):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    rig.pause()
    sequence = cam.frame().sequence
    for kind in ("rtsp", "rtsp-mjpeg"):
        capture = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG)
        ok, image = capture.read()
        assert ok and camrig.read_code(image).sequence == sequence
        again = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG)  # one more joins the stream that stands still
        ok, image = again.read()
        assert ok and camrig.read_code(image).sequence == sequence


@pytest.mark.parametrize("change", [{"fps": 10}, {"size": (160, 120)}, {"outputs": [{"kind": "rtsp", "bitrate_kbps": 300}]}])
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_a_changed_camera_ends_its_streams_and_they_can_come_back(rig, change, kind):
    cam = rig.create_camera("lobby", size=(320, 240), code_strip=True)
    if kind == "rtsp-mjpeg" and "outputs" in change:
        change = {"outputs": [{"kind": "rtsp", "codec": "mjpeg", "quality": 40}]}
    capture = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG)
    assert capture.read()[0]
    cam.set(**change)
    shapes = set()
    for _ in range(200):
        ok, image = capture.read()
        if not ok:
            break
        shapes.add(image.shape)
    else:
        pytest.fail("the stream did not end")
    assert shapes <= {(240, 320, 3)}  # never another size in one stream
    width, height = cam.get()["size"]
    ok, image = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG).read()
    assert ok and image.shape == (height, width, 3)


def test_moving_a_camera_does_not_end_its_stream(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    reader = RtspReader(cam.url("rtsp"))
    take(reader, 5)
    cam.set(position=(1, 2, 3), vfov_deg=40)
    assert len(take(reader, 20)) == 20


@pytest.mark.parametrize("transport", ["tcp", "udp"])
def test_a_deleted_camera_says_bye_and_ffmpeg_ends_well(rig, tmp_path, transport, programs):
    cam = rig.create_camera("lobby", size=(320, 240))
    recorder = programs(["ffmpeg", "-v", "error", "-rtsp_transport", transport, "-i", cam.url("rtsp"), "-c", "copy", "-flush_packets", "1", str(tmp_path / "a.h264")])
    wait_until(lambda: (tmp_path / "a.h264").exists() and (tmp_path / "a.h264").stat().st_size > 0, what="a recording")
    reader = RtspReader(cam.url("rtsp"))
    take(reader, 3)
    cam.delete()
    assert len(take(reader, 1000)) < 1000
    assert recorder.wait(20) == 0
    with pytest.raises(ConnectionError, match="404"):
        RtspReader(cam.url("rtsp"))
    rig.create_camera("lobby", size=(160, 120))
    assert len(take(RtspReader(cam.url("rtsp")), 5)) == 5


def test_nobody_watches_nothing_is_drawn(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    state = lambda: next(c for c in rig.stats()["cameras"] if c["name"] == "lobby")
    assert state()["outputs"] == []
    reader = RtspReader(cam.url("rtsp"))
    take(reader, 3)
    assert [r["kind"] for o in state()["outputs"] for r in o["readers"]] == ["rtsp"]
    reader.close()
    wait_until(lambda: state()["outputs"] == [], what="the encoder to stop")


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_lockstep_delivers_every_frame_to_every_reader(rig, kind):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, code_strip=True)
    rig.step(seconds=0.2)
    readers = [read_aside(cam.url(kind)) for _ in range(3)]
    wait_until(lambda: all(len(pictures) >= 1 for _, pictures, _ in readers), what="first pictures")
    for _ in range(5):
        rig.step(seconds=0.4)
    sequences = lambda pictures: [p.times.sequence for p in pictures]
    if kind == "rtsp":
        wait_until(lambda: all(55 in sequences(pictures) for _, pictures, _ in readers), what="the last frame")
        for _, pictures, _ in readers:
            assert [n for n, _ in itertools.groupby(sequences(pictures))][-50:] == list(range(6, 56))
    else:  # by their bytes, of which the code strip makes others in each frame
        frames = lambda pictures: [b"".join(payloads) for payloads, _ in itertools.groupby(p.payloads for p in pictures)]
        wait_until(lambda: all(len(frames(pictures)) >= 51 for _, pictures, _ in readers), what="the last frame")
        assert all(len(frames(pictures)) == len(set(frames(pictures))) == 51 for _, pictures, _ in readers)
        assert len({tuple(frames(pictures)) for _, pictures, _ in readers}) == 1, "all have the same"
    reader = [r for c in rig.stats()["cameras"] for o in c["outputs"] for r in o["readers"]][0]
    assert reader["offered"] == reader["delivered"] == 50 and reader["dropped"] == 0


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_step_that_waits_for_a_stuck_rtsp_reader_names_its_stream(rig):
    cam = rig.create_camera("lobby", size=(1920, 1080), fps=25, outputs=[{"kind": "rtsp", "codec": "mjpeg"}])
    reader = RtspReader(cam.url("rtsp-mjpeg"))
    reader.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    take(reader, 1)  # and not one byte more
    with pytest.raises(camrig.CamrigError) as caught:
        rig.call("world.step", seconds=20, timeout_s=2)
    assert caught.value.kind == "unavailable" and "/lobby/mjpeg" in str(caught.value)
    reader.close()
    rig.step(seconds=0.2)


def test_the_documented_client_prints_capture_times(rig):
    cam = rig.create_camera("lobby", size=(320, 240))
    done = run(sys.executable, str(REPOSITORY / "docs/examples/rtsp_times.py"), cam.url("rtsp"), "40")
    assert done.returncode == 0, done.stderr.decode()
    lines = done.stdout.decode().splitlines()
    assert len(lines) == 40
    shown = [re.search(r"taken (\d+\.\d+|\(no report yet\))  sequence (\d+)  world \d+\.\d+ s  taken (\d+\.\d+)", line) for line in lines]
    # What is sent again, on a busy machine, has a stamp that is made up.
    last = [line for before, line in itertools.pairwise(shown) if line[2] != before[2]][-1]
    assert abs(float(last[1]) - float(last[3])) < 15e-6


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_stock_programs_read_in_lockstep(rig, tmp_path, kind, programs):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25, code_strip=True)
    depay = "rtph264depay" if kind == "rtsp" else "rtpjpegdepay"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    ffmpeg = programs(["ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-i", cam.url(kind), "-c", "copy", "-frames:v", "40", str(tmp_path / "a.mkv")], **pipes)
    gst = programs(gst_launch(f"rtspsrc location={cam.url(kind)} protocols=tcp latency=0 ! {depay} ! identity eos-after=40 ! fakesink"), **pipes)
    with stepping(rig):
        capture = cv2.VideoCapture(cam.url(kind), cv2.CAP_FFMPEG)
        sequences = [camrig.read_code(capture.read()[1]).sequence for _ in range(40)]
        capture.release()  # the world waits for whoever reads no more
        out, err = ended(gst)
        assert ended(ffmpeg) == (b"", b"") and ffmpeg.returncode == 0
    assert_gst_read_to_the_end(gst.returncode, out, err)
    assert sequences == sorted(sequences) and sequences[-1] > 5


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_reader_that_joins_is_told_of_no_packet_that_it_does_not_get(rig):
    """GStreamer's reader waits for ever for the packets between the one that RTP-Info names and the first that comes."""
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    with stepping(rig):
        _, _, other = read_aside(cam.url("rtsp-mjpeg"))  # the stream runs while they join
        for _ in range(20):
            reader = RtspReader(cam.url("rtsp-mjpeg"))
            packet, channel = b"", 1
            while channel != 0:
                _, channel, size = struct.unpack("!cBH", reader.take(4))
                packet = reader.take(size)
            named = re.search(r"seq=(\d+)", reader.answer.get("rtp-info", ""))
            assert named is None or int(named[1]) == struct.unpack_from("!H", packet, 2)[0]
            reader.close()
        other.socket.shutdown(socket.SHUT_RDWR)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_first_picture_of_a_reader_that_joins_is_a_key_picture(rig):
    """A decoder shows nothing of what comes before, and complains."""
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    with stepping(rig):
        _, _, other = read_aside(cam.url("rtsp"))  # the stream runs while they join
        for _ in range(30):
            reader = RtspReader(cam.url("rtsp"))
            channel = 1
            while channel != 0:
                _, channel, size = struct.unpack("!cBH", reader.take(4))
                packet = reader.take(size)
            # An aggregation packet (RFC 6184, 5.7.1) of an access unit delimiter and the parameter sets of a key picture.
            assert (packet[12] & 0x1F, packet[15] & 0x1F, packet[19] & 0x1F) == (24, 9, 7)
            reader.close()
        other.socket.shutdown(socket.SHUT_RDWR)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_nothing_but_rtp_and_rtcp_reaches_a_reader(rig, kind):
    """Also in lockstep, where the end of each picture is watched for on its way out."""
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    reader = RtspReader(cam.url(kind))
    pictures = reports = 0
    with stepping(rig):
        while pictures < 20 or reports < 2:
            magic, channel, size = struct.unpack("!cBH", reader.take(4))
            packet = reader.take(size)
            assert magic == b"$" and channel in (0, 1)
            assert size >= 12 and packet[0] >> 6 == 2, f"{size} bytes that are neither RTP nor RTCP"
            pictures += channel == 0 and packet[1] >> 7
            reports += channel == 1
        reader.close()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_step_takes_no_longer_than_its_frames_need(rig):
    """A sent picture lets its step go at once; it does not wait for the repeat that comes after a second."""
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    _, pictures, _ = read_aside(cam.url("rtsp"))
    wait_until(lambda: pictures, what="the first picture")
    started = time.monotonic()
    rig.step(seconds=2)
    assert time.monotonic() - started < 25  # 50 frames; it was 50 s when the last packet was kept
