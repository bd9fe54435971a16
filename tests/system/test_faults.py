"""Cameras that fail: what stock clients get, what truth says, and that nobody else notices."""

import hashlib
import io
import json
import os
import re
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.parse
import urllib.request

import numpy as np
import pytest

import camrig
from conftest import wait_until
from fault_books import books_balance, check_books  # noqa: F401 (a fixture)
from rtsp_client import stepping, strictly_rising, without_repeats

PICTURE_KINDS = ["defocus", "dirt", "covered", "exposure", "white_balance", "noise", "banding", "dead_pixels", "dead_rows", "mirrored",
                 "upside_down", "black"]
BODY_KINDS = ["knock", "sag", "vibration"]


def md5(image):
    return hashlib.md5(image.tobytes()).hexdigest()


def run(scenes, faults, steps=40, fps=25):
    """(sequence, hash) of two cameras' pictures after each step; `faults` are set on the first before step 10."""
    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=7) as rig:
        cameras = [rig.create_camera(name, size=(320, 240), fps=fps, place="lobby") for name in ("faulty", "well")]
        shown = []
        for step in range(steps):
            if step == 10:
                for kind, params in faults:
                    rig.fault.set("faulty", kind, **params)
            rig.step(seconds=1 / fps)
            shown.append([(frame.sequence, md5(frame.image)) for frame in (camera.frame() for camera in cameras)])
        check_books(rig)
        return shown


def test_a_run_replays_to_the_byte_and_other_cameras_do_not_notice(scenes):
    faults = [(kind, {"severity": 0.6}) for kind in PICTURE_KINDS[:9] + BODY_KINDS + ["freeze", "duplicate", "drop"]]
    first, again, without = run(scenes, faults), run(scenes, faults), run(scenes, [])
    assert first == again
    assert [well for _, well in first] == [well for _, well in without]
    assert first[:10] == without[:10]
    assert [faulty for faulty, _ in first[10:]] != [faulty for faulty, _ in without[10:]]


def test_a_frozen_camera_repeats_for_as_long_as_it_was_told(scenes):
    shown = run(scenes, [("freeze", {"end_s": 1.0})])  # from world time 0.4 s, of frame 10, until before frame 25
    hashes = [picture for (_, picture), _ in shown]
    assert [sequence for (sequence, _), _ in shown] == list(range(1, 41))
    assert len(set(hashes[9:24])) == 1
    assert len(set(hashes[:10] + hashes[24:])) == 26, "the hall moves"


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
@pytest.mark.parametrize("kind", BODY_KINDS)
def test_a_knocked_camera_shows_what_truth_says_and_believes_its_calibration(rig, kind):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    rig.step(seconds=0.1)
    before = cam.get()["world_pose"]
    assert cam.truth()["pose_believed"] == cam.truth()["pose"]
    rig.fault.set("desk", kind, **({"tilt_deg_per_h": -36000} if kind == "sag" else {}))
    rig.step(seconds=0.5)
    truth = cam.truth()
    assert cam.get()["world_pose"] == before
    assert truth["pose_believed"]["orientation"] == pytest.approx(before["orientation"])
    assert truth["pose"]["position"] == pytest.approx(before["position"])
    assert np.abs(np.subtract(truth["pose"]["orientation"], before["orientation"])).max() > 1e-4
    # A camera that truly stands there shows the same picture.
    twin = rig.create_camera("twin", size=(320, 240), fps=25, vfov_deg=cam.get()["vfov_deg"], position=truth["pose"]["position"],
                             orientation=truth["pose"]["orientation"])
    difference = np.abs(cam.frame().image.astype(int) - twin.frame().image.astype(int))
    assert difference.mean() < 0.5
    # And every corner of the world is where that pose puts it, to 1e-4 px, and not where the calibration does.
    told, seen_by_twin = ({one["id"]: np.array(one["box_full"]) for one in camera["objects"] if not one["clipped"]} for camera in (truth, twin.truth()))
    assert told.keys() == seen_by_twin.keys() and len(told) > 3
    assert max(np.abs(told[one] - seen_by_twin[one]).max() for one in told) < 1e-4
    assert (cam.instances() != twin.instances()).mean() < 1e-4


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_books_say_what_a_fault_kept_back(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, place="lobby")
    stream = urllib.request.urlopen(cam.url(), timeout=30)
    threading.Thread(target=lambda: [None for _ in iter(lambda: stream.read1(65536), b"")], daemon=True).start()
    camera = lambda: next(one for one in rig.stats()["cameras"] if one["name"] == "desk")
    wait_until(lambda: camera()["outputs"] and camera()["outputs"][0]["readers"], what="a reader")
    rig.fault.set("desk", "drop", severity=0.5, probability=1.0)
    rig.step(seconds=4)
    rig.fault.clear("desk")
    rig.fault.set("desk", "stall", output="mjpeg")
    rig.step(seconds=1)
    rig.fault.clear("desk")
    rig.step(seconds=1)
    books = camera()["outputs"][0]
    assert books["due"] == 150
    assert 30 < books["fault"] < 70
    assert books["due"] == books["received"] + books["fault"] + books["not_drawn"]
    assert books["kept_back"] == 25
    assert books["received"] == books["encoded"] + books["dropped"] + books["failed"] + books["kept_back"]
    assert camera()["dropped_for"]["fault"] == books["fault"]
    reader = books["readers"][0]
    assert reader["offered"] == reader["delivered"] + reader["dropped"] == books["received"]
    assert reader["fault"] == 25


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_books_balance_where_a_failing_camera_is_overloaded_too(rig):
    cameras = [rig.create_camera(f"c{i}", size=(1280, 720), fps=60, place="lobby") for i in range(8)]
    streams = [urllib.request.urlopen(camera.url(), timeout=30) for camera in cameras]
    for stream in streams:
        threading.Thread(target=lambda stream=stream: [None for _ in iter(lambda: stream.read1(65536), b"")], daemon=True).start()
    rig.fault.set("c0", "drop", probability=0.5, burst_frames=3)
    rig.fault.set("c0", "stall", severity=0.3, period_s=0.3)
    rig.fault.set("c1", "freeze", severity=0.5)
    dropped_for = lambda name: next(one for one in rig.stats()["cameras"] if one["name"] == name)["dropped_for"]
    both = lambda: dropped_for("c0")["fault"] > 30 and dropped_for("c0")["overload"] + dropped_for("c0")["own_cost"] > 30
    wait_until(both, timeout_s=60, what="frames lost by the fault and by overload")

    def state():
        """While nothing moves: the number of the newest frame that was due, the frames in the books of the camera, and in those of its output."""
        rig.pause()
        check_books(rig)
        books = next(one for one in rig.stats()["cameras"] if one["name"] == "c0")
        counted = cameras[0].get()["sequence"], books["due"] + books["idle"], books["outputs"][0]["due"]
        rig.resume()
        return counted

    begin = state()
    time.sleep(1)
    due, booked, offered = (after - before for before, after in zip(begin, state()))
    assert due == booked == offered > 30
    not_drawn = []
    wait_until(lambda: not_drawn or not_drawn.extend(truth for truth in [cameras[2].truth()] if truth["not_drawn"]), timeout_s=60, what="the truth of a frame that was not drawn")
    assert not_drawn[0]["not_drawn"] in ("overload", "own_cost", "request")
    assert {way["fate"] for way in not_drawn[0]["outputs"].values()} == {"not_drawn"}
    for camera in cameras[1:]:
        camera.delete()
    check_books(rig)


def parts(stream, count):
    """(JPEG bytes, sequence) of an MJPEG stream."""
    found = []
    while len(found) < count:
        headers = {}
        while (line := stream.readline()).strip() or not headers:
            if not line:
                raise EOFError("the stream has ended")
            if b":" in line:
                key, value = line.split(b":", 1)
                headers[key.strip().lower()] = value.strip()
        found.append((stream.read(int(headers[b"content-length"])), int(headers[b"x-sequence"])))
    return found


def skip_to(stream, sequence):
    """Reads on to the picture of that number: a reader on a busy machine is behind."""
    while parts(stream, 1)[0][1] < sequence:
        pass


def streamed(scenes, kind):
    """Hash of each JPEG of a stream by its number, of a run in which the camera fails for frames 10 to 19; and of another camera's."""
    got = {"desk": {}, "well": {}}

    def read(stream, into):
        try:
            while True:
                for jpeg, sequence in parts(stream, 1):
                    into[sequence] = hashlib.md5(jpeg).hexdigest()
        except (EOFError, ValueError, KeyError, OSError):
            pass  # it has ended

    with camrig.start(str(scenes / "hall.json"), mode="lockstep", seed=3) as rig:
        for name, into in got.items():
            stream = urllib.request.urlopen(rig.create_camera(name, size=(320, 240), fps=25, place="lobby").url(), timeout=30)
            threading.Thread(target=read, args=(stream, into), daemon=True).start()
        wait_until(lambda: all(into for into in got.values()), what="the first pictures")
        if kind:
            rig.fault.set("desk", kind, start_s=0.4, end_s=0.8, severity=0.5 if kind == "black" else 1)
        rig.step(seconds=1.6)
        wait_until(lambda: all(40 in into for into in got.values()), what="the last pictures")
        check_books(rig)
    return got["desk"], got["well"]


@pytest.mark.parametrize("kind", ["freeze", "black", "drop", "knock"])
def test_after_a_fault_a_stream_has_the_bytes_that_it_would_have_had_anyhow(scenes, kind):
    desk, well = streamed(scenes, kind)
    clean, other = streamed(scenes, None)
    assert well == other
    if kind == "drop":
        assert set(clean) - set(desk) <= set(range(10, 20)) and len(set(clean) - set(desk)) > 0
    else:
        assert [sequence for sequence in clean if desk[sequence] != clean[sequence]] == list(range(11 if kind == "freeze" else 10, 20))
    assert [desk[sequence] for sequence in range(20, 41)] == [clean[sequence] for sequence in range(20, 41)]


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
@pytest.mark.parametrize("kind", ["freeze", "black"])
def test_a_stream_goes_on_with_the_same_bytes_and_nothing_is_drawn(rig, kind):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        moving = parts(stream, 10)
        assert len({jpeg for jpeg, _ in moving}) > 5
        rig.fault.set("desk", kind)
        skip_to(stream, cam.frame().sequence + 2)
        drawn = rig.stats()["renderer"]["views"]
        same = parts(stream, 20)
        assert rig.stats()["renderer"]["views"] == drawn
        assert len({jpeg for jpeg, _ in same}) == 1
        sequences = without_repeats(sequence for _, sequence in same)
        assert strictly_rising(sequences) and len(sequences) > 5, "not only the same one again"
        rig.fault.clear("desk")
        skip_to(stream, cam.frame().sequence + 2)
        assert len({jpeg for jpeg, _ in parts(stream, 10)}) > 5


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_a_damaged_jpeg_reaches_the_stream_and_nobody_else(rig):
    import cv2
    import PIL.Image

    cam = rig.create_camera("desk", size=(320, 240), fps=20, place="lobby")
    rig.fault.set("desk", "corrupt_jpeg", mode="truncate", amount=3000, probability=0.5, output="mjpeg")
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        got = parts(stream, 40)[1:]
    cut = [sequence for jpeg, sequence in got if not jpeg.endswith(b"\xff\xd9")]
    assert 8 < len(cut) < 32
    for jpeg in (jpeg for jpeg, sequence in got if sequence in cut):
        assert cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) is None
        with pytest.raises(OSError, match="truncated"):
            PIL.Image.open(io.BytesIO(jpeg)).load()
    with urllib.request.urlopen(f"{rig.http_url}/cameras/desk/snapshot.jpg", timeout=30) as snapshot:
        jpeg = snapshot.read()
    assert jpeg.endswith(b"\xff\xd9") and cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) is not None
    rig.fault.clear("desk")
    rig.fault.set("desk", "corrupt_jpeg", mode="bitflip", amount=100)
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        for jpeg, _ in parts(stream, 12)[1:]:  # of which one may be sent again
            assert jpeg.startswith(b"\xff\xd8")
            assert cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) is not None, "decoders take it"
        camera = next(one for one in rig.stats()["cameras"] if one["name"] == "desk")
        assert sum(reader["damaged"] for output in camera["outputs"] for reader in output["readers"]) >= 9


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_disconnected_stream_ends_and_can_be_opened_again(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25)
    other = rig.create_camera("other", size=(160, 120), fps=25)
    stream, well = urllib.request.urlopen(cam.url(), timeout=30), urllib.request.urlopen(other.url(), timeout=30)
    parts(stream, 3), parts(well, 3)
    fault = rig.fault.set("desk", "disconnect", output="mjpeg")
    while stream.read1(65536):
        pass  # ends
    parts(well, 10)
    rig.fault.clear(id=fault["id"])
    assert len(parts(urllib.request.urlopen(cam.url(), timeout=30), 5)) == 5


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_connections_are_reset_without_an_end(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "mjpeg"}, {"kind": "rtsp"}])
    other = RtpPackets(rig.create_camera("other", size=(160, 120), fps=25, outputs=[{"kind": "rtsp"}]).url("rtsp"))
    by_rtsp = RtpPackets(cam.url("rtsp"))
    place = urllib.parse.urlparse(cam.url())
    by_http = socket.create_connection((place.hostname, place.port), timeout=20)
    by_http.sendall(f"GET {place.path} HTTP/1.1\r\nHost: {place.hostname}\r\n\r\n".encode())
    assert by_http.recv(1000)
    by_rtsp.take(5)
    rig.fault.set("desk", "disconnect", reset=True)
    with pytest.raises(ConnectionResetError):
        while by_http.recv(1 << 16):
            pass
    reports = []
    with pytest.raises(ConnectionResetError):
        while True:
            channel, packet = by_rtsp.next()
            reports += [packet] * (channel == 1)
    assert 203 not in [packet[at + 1] for packet in reports for at in rtcp_starts(packet)], "a BYE"
    other.take(20)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_cut_part_ends_the_stream_in_the_middle_of_a_picture(rig):
    cam = rig.create_camera("lobby", size=(320, 240), fps=25)
    rig.fault.set("lobby", "cut_part", probability=1.0)
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        everything = b"".join(iter(lambda: stream.read1(65536), b""))
    announced = [int(one) for one in re.findall(rb"Content-Length: (\d+)", everything)]
    last = everything[everything.rindex(b"\r\n\r\n") + 4:]
    assert last.startswith(b"\xff\xd8") and len(last) == announced[-1] // 2


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_stalled_stream_sends_nothing_and_goes_on(rig):
    rig.create_camera("lobby", size=(160, 120), fps=25)
    reader = socket.create_connection(urllib.parse.urlparse(rig.http_url).netloc.split(":"), timeout=30)
    reader.sendall(b"GET /cameras/lobby/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n")
    reader.recv(1 << 16)
    rig.fault.set("lobby", "stall", output="mjpeg")
    reader.settimeout(3)  # a stream without new pictures repeats the last one after 2 s
    deadline = time.monotonic() + 12
    with pytest.raises(TimeoutError):
        while time.monotonic() < deadline:
            assert reader.recv(1 << 16)
    rig.fault.clear("lobby")
    reader.settimeout(30)
    assert reader.recv(1 << 16)
    reader.close()


DEVICE_PROGRAM = """
import cv2, sys
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
frames = 0
while True:
    ok, _ = capture.read()
    if not ok:
        break
    frames += 1
    print(frames, capture.get(cv2.CAP_PROP_POS_MSEC), flush=True)
"""


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_programs_see_their_device_unplugged(rig, programs):
    rig.create_camera("desk", size=(320, 240), fps=25, outputs=[{"kind": "device", "number": 7}])
    program = [os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--", sys.executable, "-c", DEVICE_PROGRAM,
               "/dev/video7"]
    reader = programs(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(10):
        assert reader.stdout.readline()
    fault = rig.fault.set("desk", "disconnect", output="device")
    set_ms = time.monotonic() * 1e3
    out, err = reader.communicate(timeout=20)
    assert reader.returncode == 0, err
    assert sum(float(line.split()[1]) > set_ms for line in out.splitlines()) <= 3, "within a few frames"
    rig.fault.clear(id=fault["id"])
    again = programs(program, stdout=subprocess.PIPE, text=True)
    for _ in range(5):
        assert again.stdout.readline(), "it can be opened again"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_loopback_device_is_not_unplugged_and_the_refusal_says_why(rig):
    rig.create_camera("desk", size=(160, 120))
    with pytest.raises(camrig.CamrigError, match="v4l2loopback device cannot be unplugged") as refused:
        rig.fault.set("desk", "disconnect", output="v4l2")
    assert refused.value.kind == "unsupported"
    assert rig.fault.list() == []


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_errors_name_what_is_wrong(rig):
    rig.create_camera("desk", size=(160, 120))
    for params, kind, words in [({"kind": "mood"}, "invalid_argument", "is none of knock, sag"),
                                ({"kind": "drop", "severity": 2}, "invalid_argument", "severity: must be 0 to 1"),
                                ({"kind": "drop", "params": {"probability": 3}}, "invalid_argument", "params.probability: must be 0 to 1"),
                                ({"kind": "black", "params": {"period_s": 1}}, "invalid_argument", "params.period_s"),
                                ({"kind": "black", "start_s": 5, "end_s": 4}, "invalid_argument", "end_s: must be after start_s")]:
        with pytest.raises(camrig.CamrigError, match=words) as wrong:
            rig.call("fault.set", camera="desk", **params)
        assert wrong.value.kind == kind
    with pytest.raises(camrig.CamrigError, match="give id or camera"):
        rig.fault.clear()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_the_command_line_sets_lists_and_clears(rig):
    rig.create_camera("desk", size=(160, 120))
    control = ["--control", rig.call("server.info")["control"]]
    camrig_bin = os.environ["CAMRIG_BIN"]
    say = lambda *words: subprocess.run([camrig_bin, "fault", *words, *control], capture_output=True, text=True, timeout=30)
    done = say("set", "desk", "drop", "--severity", "0.5", "--burst-frames", "8", "--end-s", "1000")
    assert done.returncode == 0, done.stderr
    listed = rig.fault.list("desk")
    assert [(one["kind"], one["severity"], one["params"]["burst_frames"], one["end_ns"]) for one in listed] == [("drop", 0.5, 8, 1000 * 10**9)]
    assert "drop" in say("list").stdout
    assert say("clear", "desk").stdout.strip() == "1 cleared"
    assert rig.fault.list() == []
    assert "burst_frames" not in say("kinds").stdout and "--burst-frames" in say("kinds").stdout


class RtpPackets:
    """The sequence numbers of a stream's RTP packets, over the RTSP connection (RFC 2326, 10.12)."""

    def __init__(self, url):
        parsed = urllib.parse.urlparse(url)
        self.socket = socket.create_connection((parsed.hostname, parsed.port), timeout=20)
        self.file, self.url, self.cseq, self.session = self.socket.makefile("rb"), url, 0, ""
        control = re.findall(rb"a=control:(\S+)", self.ask("DESCRIBE", url)[1])[-1].decode()
        control = control if control.startswith("rtsp:") else f"{url}/{control}"
        self.session = self.ask("SETUP", control, "Transport: RTP/AVP/TCP;unicast;interleaved=0-1")[0]["session"].split(";")[0]
        self.ask("PLAY", url)

    def ask(self, method, url, *headers):
        self.cseq += 1
        lines = [f"{method} {url} RTSP/1.0", f"CSeq: {self.cseq}", *([f"Session: {self.session}"] if self.session else []), *headers]
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while (status := self.file.readline()).startswith(b"$"):
            raise AssertionError("packets before the answer")
        assert b"200" in status, status
        answer = {}
        while line := self.file.readline().strip():
            key, value = line.decode().split(":", 1)
            answer[key.lower()] = value.strip()
        return answer, self.file.read(int(answer.get("content-length", 0)))

    def next(self):
        """Channel and packet: 0 is RTP, 1 RTCP."""
        mark, channel, length = struct.unpack(">cBH", self.file.read(4))
        assert mark == b"$"
        return channel, self.file.read(length)

    def take(self, count):
        numbers = []
        while len(numbers) < count:
            channel, packet = self.next()
            if channel == 0:
                numbers.append(struct.unpack(">H", packet[2:4])[0])
        return numbers


def rtcp_starts(packet):
    """Where the reports of a compound RTCP packet begin (RFC 3550, 6.1)."""
    at = 0
    while at + 4 <= len(packet):
        yield at
        at += 4 * (1 + struct.unpack(">H", packet[at + 2:at + 4])[0])


def lost_of(numbers):
    steps = [(b - a) % 65536 for a, b in zip(numbers, numbers[1:])]
    return sum(steps) - len(steps), sum(steps)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
@pytest.mark.parametrize("codec, size, fps", [("", (640, 480), 50), ("/mjpeg", (320, 240), 10)])
def test_lost_rtp_packets_are_missing_numbers_and_a_stalled_stream_is_silent(rig, codec, size, fps):
    cam = rig.create_camera("desk", size=size, fps=fps, place="lobby", outputs=[{"kind": "rtsp", "bitrate_kbps": 20_000}])
    with stepping(rig):  # which waits for the reader: what is missing was lost by the fault
        packets = RtpPackets(f"{rig.rtsp_url}/{cam.name}{codec}")
        assert lost_of(packets.take(150))[0] == 0
        rig.fault.set("desk", "packet_loss", probability=0.2)
        wait_until(lambda: lost_of(packets.take(50))[0] > 0, what="the first loss, behind what was on its way")
        lost, sent = lost_of(packets.take(400))
        assert 0.13 < lost / sent < 0.27
        rig.fault.clear("desk")
        wait_until(lambda: lost_of(packets.take(50))[0] == 0, what="the end of the losses")  # by chance one time in 70 000
        assert lost_of(packets.take(100))[0] == 0
        rig.fault.set("desk", "stall", output="rtsp")
        silent = 0  # reports of 0.1 to 0.3 s without a picture between
        for _ in range(3000):
            channel, _ = packets.next()
            silent = silent + 1 if channel == 1 else 0
            if silent == 8:
                break
        assert silent == 8
        rig.fault.clear("desk")
        packets.take(200)


def test_the_examples_of_the_page_run(scenes, tmp_path):
    page = (scenes.parent / "docs" / "faults.md").read_text()
    (commands, python, event) = [re.findall(rf"^```{language}\n(.*?)^```", page, re.MULTILINE | re.DOTALL) for language in ("", "python", "json")]
    done = subprocess.run([sys.executable, "-c", python[0]], capture_output=True, text=True, timeout=60, cwd=scenes.parent)
    assert done.returncode == 0, done.stderr
    assert "'kind': 'drop'" in done.stdout
    with camrig.start(str(scenes / "minimal.json")) as rig:
        rig.create_camera("lobby", size=(160, 120))
        environment = dict(os.environ, CAMRIG_CONTROL=rig.call("server.info")["control"])
        for line in commands[0].splitlines():
            words = line.split("#")[0].split()
            done = subprocess.run([os.environ["CAMRIG_BIN"], *words[1:]], capture_output=True, text=True, timeout=30, env=environment)
            assert done.returncode == 0, done.stderr
        spec = json.loads(event[0])
        rig.call("event.add", **spec)
