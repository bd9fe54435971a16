"""Lines and servers that fail: late frames, refused connections, restarts, slow lines, packets out of order, other sources and sizes."""

import os
import socket
import struct
import subprocess
import threading
import time
import urllib.error
import urllib.request

import cv2
import numpy as np
import pytest

import camrig
from conftest import wait_until
from fault_books import books_balance, check_books  # noqa: F401 (a fixture)
from rtsp_client import jitter_program, stepping, unless_held_up  # noqa: F401 (a fixture)
from test_faults import RtpPackets, parts, rtcp_starts


def camera_books(rig, name):
    return next(one for one in rig.stats()["cameras"] if one["name"] == name)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_late_frames_come_with_their_own_stamps_and_the_rest_when_it_is_over(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25)
    rig.step(seconds=0.2)
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        parts(stream, 1)
        wait_until(lambda: camera_books(rig, "desk")["outputs"], what="a reader")
        rig.step(seconds=0.04)
        begin = parts(stream, 1)[0][1]
        rig.fault.set("desk", "late", frames=10, output="mjpeg")
        rig.step(seconds=0.4)  # ten frames, none of which comes
        rig.step(seconds=0.04)
        assert parts(stream, 1)[0][1] == begin + 1
        rig.step(seconds=0.04)
        assert parts(stream, 1)[0][1] == begin + 2
        check_books(rig, on_way=12)
        truth = cam.truth()
        assert [one["kind"] for one in truth["faults"]] == ["late"]
        assert truth["outputs"]["mjpeg"] == {"fate": "sent", "late_frames": 10, "late_ns": 400_000_000, "refuses": False, "size": [160, 120], "bad_part": None,
                                             "damaged": [], "more_damaged": 0}
        assert (truth["outputs"]["rtsp"]["late_frames"], truth["outputs"]["rtsp"]["late_ns"]) == (0, 0)
        rig.fault.clear("desk")
        rig.step(seconds=0.04)
        rig.step(seconds=0.04)
        last = begin
        while last < begin + 14:
            last, before = parts(stream, 1)[0][1], last
            assert last > before
        check_books(rig)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_who_comes_is_refused_and_who_is_there_stays(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "mjpeg"}, {"kind": "rtsp"}])
    there = urllib.request.urlopen(cam.url(), timeout=30)
    packets = RtpPackets(cam.url("rtsp"))
    parts(there, 3), packets.take(3)
    rig.fault.set("desk", "refuse")
    told = lambda kind: {one["output"] for one in rig.fault.log("desk")["events"] if one["kind"] == kind}
    wait_until(lambda: told("closed") == {"mjpeg", "rtsp"}, what="the outputs to close")
    parts(there, 5)
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(cam.url(), timeout=30)
    assert refused.value.code == 503 and b"refuses connections" in refused.value.read()
    with pytest.raises(AssertionError, match="503"):
        RtpPackets(cam.url("rtsp"))
    parts(there, 10), packets.take(10)
    check_books(rig)
    rig.fault.clear("desk")
    wait_until(lambda: told("open") == {"mjpeg", "rtsp"}, what="the outputs to open")
    parts(urllib.request.urlopen(cam.url(), timeout=30), 3)
    RtpPackets(cam.url("rtsp")).take(3)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_log_says_who_was_refused_and_when_readers_came_back(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "mjpeg"}, {"kind": "rtsp"}])
    rig.create_camera("well", size=(160, 120), fps=25)
    rig.step(seconds=0.2)
    told = lambda since=0: [(one["kind"], one["output"], one["world_ns"] // 1_000_000) for one in rig.fault.log("desk", since=since)["events"]]
    has_reader = lambda: any(output["readers"] for output in camera_books(rig, "desk")["outputs"])
    before_ns = time.time_ns()

    def refused():
        with pytest.raises(urllib.error.HTTPError) as answer:
            urllib.request.urlopen(cam.url(), timeout=30)
        assert answer.value.code == 503

    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        parts(stream, 1)
        wait_until(has_reader, what="a reader")
        rig.step(seconds=0.08)
        rig.fault.set("desk", "restart", output="mjpeg")
        rig.step(seconds=0.04)
        refused()
        rig.step(seconds=0.04)
        refused()
        cleared = rig.call("fault.clear", camera="desk")["applied_ns"]
        rig.step(seconds=0.04)
    expected = [("good", "mjpeg", 240), ("closed", "mjpeg", 320), ("thrown_out", "mjpeg", 320), ("refused", "mjpeg", 320), ("refused", "mjpeg", 360),
                ("open", "mjpeg", 400)]
    assert told() == expected
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        parts(stream, 1)
        wait_until(has_reader, what="a reader")
        rig.step(seconds=0.04)
        # It waits for pictures that do not come, and has one again.
        rig.fault.set("desk", "stall", output="mjpeg")
        rig.step(seconds=0.08)
        rig.fault.clear("desk")
        rig.step(seconds=0.12)
        # So it does where the driver gives none.
        rig.fault.set("desk", "drop", probability=1.0)
        rig.step(seconds=0.08)
        rig.fault.clear("desk")
        rig.step(seconds=0.04)
        assert told(since=6) == [("good", "mjpeg", 440), ("good", "mjpeg", 560), ("good", "mjpeg", 760)]
        assert 440_000_000 - cleared == 80_000_000, "the time that it took to come back, in world time"
        rig.fault.set("desk", "refuse", output="rtsp")
        rig.step(seconds=0.04)
        with pytest.raises(AssertionError, match="503"):
            RtpPackets(cam.url("rtsp"))
        assert told(since=9) == [("closed", "rtsp", 800), ("refused", "rtsp", 800)]
    log = rig.fault.log()
    assert log["last"] == 11 and log["missed"] == 0 and {one["camera"] for one in log["events"]} == {"desk"}
    assert [one["peer"].rpartition(":")[0] for one in log["events"] if one["kind"] in ("refused", "thrown_out")][:3] == ["127.0.0.1"] * 3
    times = [one["real_ns"] for one in log["events"]]
    assert before_ns < times[0] and times == sorted(times) and times[-1] < time.time_ns()
    said = subprocess.run([os.environ["CAMRIG_BIN"], "fault", "log", "desk", "--since", "9", "--control", rig.control], capture_output=True, text=True, check=True, timeout=30)
    assert [line.split()[3:6] for line in said.stdout.splitlines()[1:]] == [["desk", "rtsp", "closed"], ["desk", "rtsp", "refused"]]
    with pytest.raises(camrig.CamrigError, match="no camera"):
        rig.fault.log("nobody")
    assert rig.fault.log("well")["events"] == []


def ssrc_of(packets, count):
    """The sources of so many RTP packets, in order, without repetitions in a row; and their sequence numbers."""
    sources, numbers = [], []
    while len(numbers) < count:
        channel, packet = packets.next()
        if channel != 0:
            continue
        numbers.append(struct.unpack(">H", packet[2:4])[0])
        source = struct.unpack(">I", packet[8:12])[0]
        if not sources or sources[-1] != source:
            sources.append(source)
    return sources, numbers


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_restart_throws_readers_out_refuses_them_and_comes_back_as_another_source(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "rtsp"}])
    other = rig.create_camera("other", size=(160, 120), fps=25, outputs=[{"kind": "rtsp"}])
    well, packets = RtpPackets(other.url("rtsp")), RtpPackets(cam.url("rtsp"))
    before = ssrc_of(packets, 5)[0]
    fault = rig.fault.set("desk", "restart", output="rtsp")
    ended = False
    deadline = time.monotonic() + 20
    while not ended and time.monotonic() < deadline:
        channel, packet = packets.next()
        ended = channel == 1 and 203 in [packet[i + 1] for i in rtcp_starts(packet)]
    assert ended, "an RTCP BYE"
    with pytest.raises(AssertionError, match="503"):
        RtpPackets(cam.url("rtsp"))
    ssrc_of(well, 10)
    rig.fault.clear(id=fault["id"])
    after = []

    def is_back():
        """For who connects again and again, as readers do: the server is there from the next due frame on."""
        try:
            after[:] = ssrc_of(RtpPackets(cam.url("rtsp")), 5)[0]
        except (AssertionError, OSError, struct.error):
            return False
        return True

    wait_until(is_back, what="the server")
    assert len(before) == len(after) == 1 and before != after
    check_books(rig)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_rtp_goes_on_as_another_source_in_the_middle_of_a_session(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "rtsp"}])
    packets = RtpPackets(cam.url("rtsp"))
    assert len(ssrc_of(packets, 10)[0]) == 1
    rig.fault.set("desk", "new_ssrc", period_s=0.5)
    sources, _ = ssrc_of(packets, 150)
    assert len(set(sources)) == len(sources) >= 3
    rig.fault.clear("desk")
    wait_until(lambda: len(ssrc_of(packets, 50)[0]) == 1, what="one source, behind what was on its way")
    check_books(rig)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_packets_are_overtaken_and_none_is_lost(rig):
    cam = rig.create_camera("desk", size=(640, 480), fps=25, place="lobby", outputs=[{"kind": "rtsp", "codec": "mjpeg"}])
    with stepping(rig):  # which waits for the reader: what is missing was lost by the fault
        packets = RtpPackets(cam.url("rtsp") + ("" if cam.url("rtsp").endswith("/mjpeg") else "/mjpeg"))
        well = packets.take(50)
        assert well == [(well[0] + i) % 65536 for i in range(50)]
        rig.fault.set("desk", "packet_reorder", probability=0.3, distance=4)
        packets.take(300)
        numbers = packets.take(600)
        packets.socket.shutdown(socket.SHUT_RDWR)
    low = min(numbers, key=lambda n: (n - numbers[0] + 32768) % 65536)
    order = [(n - low) % 65536 for n in numbers]
    late = sum(later < earlier for earlier, later in zip(order, order[1:]))
    assert late > 30
    assert len(set(order)) == len(order)
    assert len(set(range(max(order))) - set(order)) <= 10, "but for the ends of what was looked at, all are there"
    check_books(rig)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
@pytest.mark.parametrize("kind, params", [("packet_loss", {"probability": 0.2}), ("bandwidth", {"kbit_per_s": 2000, "queue_s": 0.02})])
def test_gstreamer_misses_the_packets_that_truth_calls_lost(rig, jitter_program, kind, params):
    unless_held_up(rig, lambda moments: check_missed(rig, jitter_program, kind, params, moments))


def check_missed(rig, jitter_program, kind, params, moments):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby", outputs=[{"kind": "rtsp"}])
    reader = subprocess.Popen([jitter_program, f"{rig.rtsp_url}/desk/mjpeg"], stdout=subprocess.PIPE, text=True)

    def step(pictures):
        """As many packets as truth says were lost; in the pace of the clock, for the reader waits for packets by it."""
        lost = 0
        for _ in range(pictures):
            moments.append(time.monotonic())
            rig.step(seconds=0.04)
            for harm in cam.truth()["outputs"]["rtsp"]["damaged"]:
                assert (harm["kind"], harm["mode"], harm["times"]) == (kind, "lost", 1)
                assert harm["bytes"] == sum(size for _, size in harm["runs"]) < harm["size"] and harm["more_runs"] == 0
                lost += len(harm["runs"])
            time.sleep(0.03)
        return lost

    try:
        assert reader.stdout.readline() == "playing\n"
        assert step(25) == 0
        rig.fault.set("desk", kind, **params)
        lost = step(40)
        assert lost > 40
        rig.fault.clear("desk")
        assert step(25) == 0
        cam.delete()
        pushed, missed, late = map(int, reader.communicate(timeout=30)[0].split())
        # What came after it was given up for lost, on a busy machine, is late and was missed.
        assert missed - late == lost and pushed > lost
    finally:
        reader.kill()
        reader.wait()


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_delayed_packets_come_behind_those_of_later_pictures_and_none_is_lost(rig):
    unless_held_up(rig, lambda moments: check_delayed(rig, moments))


def check_delayed(rig, moments):
    cam = rig.create_camera("desk", size=(640, 480), fps=25, place="lobby", outputs=[{"kind": "rtsp", "bitrate_kbps": 20_000}])
    packets, pictures = RtpPackets(f"{rig.rtsp_url}/desk/mjpeg"), {}

    def take(count):
        """(number, how many pictures behind the newest it came) of each packet."""
        taken = []
        while len(taken) < count:
            channel, packet = packets.next()
            if channel == 0:
                moments.append(time.monotonic())
                number, stamp = struct.unpack(">xxHI", packet[:8])
                picture = pictures.setdefault(stamp, len(pictures))
                taken.append((number, len(pictures) - 1 - picture))
        return taken

    with stepping(rig):  # which goes on: no step waits for a packet that comes with a later one
        assert all(behind == 0 for _, behind in take(100))
        rig.fault.set(cam.name, "packet_delay", probability=0.3, delay_s=0.2)
        take(400)
        some = take(1500)
        late = sum(behind > 0 for _, behind in some)
        assert {behind for _, behind in some} == {0, 4}, "it comes before what is sent five pictures later"
        assert 0.2 < late / len(some) < 0.4
        rig.fault.clear("desk")
        rest = take(1500)
    numbers = [(number - some[0][0] + 32768) % 65536 for number, _ in some + rest]
    assert len(set(numbers)) == len(numbers)
    begin, end = max(numbers[:200]), min(numbers[-200:])
    assert set(range(begin, end)) <= set(numbers), "but for the ends of what was looked at, all are there"
    assert all(behind == 0 for _, behind in rest[-500:])


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_a_slow_line_carries_what_it_is_told_and_the_same_frames_again(rig):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    rig.step(seconds=0.2)
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        read = []
        reader = threading.Thread(target=lambda: read.extend(iter_parts(stream)), daemon=True)
        reader.start()
        wait_until(lambda: camera_books(rig, "desk")["outputs"], what="a reader")
        rig.step(seconds=1)
        last = cam.frame().sequence
        wait_until(lambda: read and read[-1][1] == last, what="the last picture of the step")
        free = sum(len(jpeg) for jpeg, _ in read[-20:]) / 20 * 25 * 8 / 1000  # kbit/s
        fault = rig.fault.set("desk", "bandwidth", kbit_per_s=free / 4, queue_s=0.1)
        wait_until(lambda: len(read) >= 25, what="what was sent")
        begin, lost, due = len(read), [], []
        for _ in range(100):
            rig.step(seconds=0.04)
            truth = cam.truth()
            due.append(truth["sequence"])
            for harm in truth["outputs"]["mjpeg"]["damaged"]:
                assert (harm["fault"], harm["kind"], harm["mode"], harm["times"]) == (fault["id"], "bandwidth", "lost", 1)
                assert harm["runs"] == [[0, harm["size"]]] and harm["bytes"] == harm["size"] > 1000
                lost.append(truth["sequence"])
        books = camera_books(rig, "desk")["outputs"][0]["readers"][0]
        wait_until(lambda: len(read) - begin >= 100 - books["fault"], what="what was sent")
        carried = sum(len(jpeg) for jpeg, _ in read[begin:]) * 8 / 1000 / 4
        assert free / 4 * 0.9 < carried < free / 4 * 1.15
        assert books["fault"] == len(lost) > 60
        assert [sequence for _, sequence in read[begin:]] == [sequence for sequence in due if sequence not in lost]
        check_books(rig)


def iter_parts(stream):
    """Without what is sent again when nothing new comes."""
    last = None
    while True:
        try:
            part = parts(stream, 1)[0]
        except (EOFError, ValueError, KeyError, OSError):
            return
        if part[1] != last:
            yield part
        last = part[1]


@pytest.mark.parametrize("args", [(), ("--device", "llvmpipe", "--convert-on", "device")])
def test_a_picture_of_another_size_reaches_the_stream_and_nobody_else(scenes, args):
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", args=args) as rig:
        check_other_size(rig)


def check_other_size(rig):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    rig.step(seconds=0.2)
    rig.fault.set("desk", "other_size", share=0.5, output="mjpeg")
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        parts(stream, 1)
        wait_until(lambda: camera_books(rig, "desk")["outputs"], what="a reader")
        rig.step(seconds=0.04)
        jpeg = parts(stream, 1)[0][0]
        picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert picture.shape[:2] == (120, 160)
        assert cam.frame().image.shape[:2] == (240, 320)
        small = cv2.resize(cam.frame().image, (160, 120), interpolation=cv2.INTER_AREA)
        assert np.abs(small.astype(int) - picture.astype(int)).mean() < 8, "of the same scene"
        assert camera_books(rig, "desk")["outputs"][0]["readers"][0]["damaged"] >= 1
        check_books(rig)
