"""Cameras whose clocks lie: what stock clients read off them is what was asked for, and truth says both times."""

import calendar
import itertools
import os
import re
import struct
import subprocess
import sys
import threading
import time
import urllib.request

import numpy as np
import pytest

import camrig
from conftest import wait_until
from rtsp_client import LibavReader, RtspReader, libav_program, new_ones, strictly_rising, take  # noqa: F401 (a fixture)
from test_faults import RtpPackets
from test_onvif import TOKEN, listens, post, security
from ports import free_port

SECONDS = float(os.environ.get("CAMRIG_CLOCK_SECONDS", "4"))  # docs/clocks.md has the figures of 60
TICK_NS = 10**9 / 90_000

DEVICE_READER = """
import cv2, sys
import camrig
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
for _ in range(int(sys.argv[2])):
    ok, image = capture.read()
    assert ok
    print(round(capture.get(cv2.CAP_PROP_POS_MSEC) * 1000), camrig.read_code(image).time_ns)
"""


def line_through(world_ns, error_ns):
    """Drift in ppb and error at the middle, by least squares."""
    middle = sum(world_ns) // len(world_ns)
    slope, at_middle = np.polyfit([(t - middle) / 1e9 for t in world_ns], error_ns, 1)
    return slope, at_middle, middle


def realtime_minus_monotonic():
    pairs = []
    for _ in range(50):
        before, real, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        pairs.append((after - before, real - (before + after) // 2))
    return min(pairs)[1]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_device_shows_offset_and_drift_and_no_step(rig, programs):
    offset_ns, drift_ppb = -250_000_000, 80_000
    cam = rig.create_camera("lobby", size=(256, 64), fps=50, code_strip=True, outputs=[{"kind": "device", "number": 7}],
                            clock={"offset_ns": offset_ns, "drift_ppb": drift_ppb})
    frame = rig.call("frame.get", camera="lobby")
    monotonic_at_0 = frame["monotonic_ns"] - frame["time_ns"]
    reader = programs([os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--",
                       sys.executable, "-c", DEVICE_READER, "/dev/video7", str(int(50 * SECONDS))], stdout=subprocess.PIPE, text=True)
    readers = lambda: [r for c in rig.stats()["cameras"] for o in c["outputs"] for r in o["readers"] if r["delivered"] > 20]
    wait_until(readers, what="a program that reads the device")
    step_at_ns = rig.status()["world_ns"] + 10**9
    cam.set(clock={"step_ns": -3600 * 10**9, "step_at_ns": step_at_ns})
    out, _ = reader.communicate(timeout=60 + SECONDS)
    assert reader.returncode == 0
    rows = [tuple(map(int, line.split())) for line in out.splitlines()]
    # After a second without a picture the last one comes again, and those after it may be stamped later than they are, to come after that.
    shown = [list(sent) for _, sent in itertools.groupby(rows, key=lambda row: row[1])]
    held_up = [now[0][1] for before, now in itertools.pairwise(shown) if len(before) > 1 or now[0][1] - before[0][1] >= 10**9]
    rows = [row for row, *_ in shown if not any(0 <= row[1] - begin < 200_000_000 for begin in held_up)]
    assert len(rows) > 25 * SECONDS
    assert strictly_rising([stamp for stamp, _ in rows])
    errors = [stamp * 1000 - (world + monotonic_at_0) for stamp, world in rows]
    drift, at_middle, middle = line_through([world for _, world in rows], errors)
    off = at_middle - (offset_ns + drift_ppb * middle / 1e9)
    print(f"device: {len(rows)} frames, drift {drift:.1f} ppb, off by {off:.0f} ns")
    assert abs(drift - drift_ppb) < 100
    assert abs(off) < 1000
    wait_until(lambda: cam.truth()["time_ns"] > step_at_ns, what="the step")
    truth = cam.truth()  # the time of day was set, meanwhile
    assert truth["stamp_ns"] == truth["time_ns"] + offset_ns + drift_ppb * truth["time_ns"] // 10**9 - 3600 * 10**9
    assert truth["steady_ns"] == truth["monotonic_ns"] + offset_ns + drift_ppb * truth["time_ns"] // 10**9


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_a_sensors_stamp_is_by_its_clock_when_the_exposure_begins(rig):
    drift_ppb, step_ns = 1_000_000, 3600 * 10**9
    cam = rig.create_camera("desk", size=(160, 120), fps=25, place="lobby", sensor={"exposure_s": 0.02, "readout_s": 0.01},
                            clock={"drift_ppb": drift_ppb, "step_ns": step_ns, "step_at_ns": 390_000_000})
    rig.step(seconds=0.36)

    def check(steps):
        frame, truth = cam.frame(), cam.truth()
        begin_ns = truth["exposure_start_ns"]
        assert begin_ns == truth["time_ns"] - 20_000_000 - 119 * truth["row_ns"]
        error_ns = begin_ns * drift_ppb // 10**9
        assert frame.steady_ns - frame.monotonic_ns == truth["steady_ns"] - truth["monotonic_ns"] == begin_ns + error_ns - truth["time_ns"]
        assert frame.stamp_ns == truth["stamp_ns"] == begin_ns + error_ns + steps * step_ns
        return frame

    check(0)
    rig.step(seconds=0.04)  # 0.40 s, of an exposure from 0.37 s on: the clock is set at 0.39 s
    check(0)
    rig.step(seconds=0.04)
    check(1)
    for kind in ("freeze", "black"):  # what shows an earlier picture, or none, is stamped as any other
        fault = rig.fault.set("desk", kind)
        rig.step(seconds=0.04)
        check(1)
        rig.step(seconds=0.04)
        assert cam.soiling().any() == 0 and cam.frame(kind="soiling").stamp_ns == check(1).stamp_ns
        rig.fault.clear(id=fault["id"])
    cam.set(clock={"drift_ppb": drift_ppb, "offset_ns": 5})
    rig.step(seconds=0.08)
    assert cam.frame().stamp_ns == cam.truth()["stamp_ns"]


def first_sendings(frames):
    """By world time; a picture that is sent again has a stamp that is made up."""
    first = {}
    for frame in frames:
        if frame.code:
            first.setdefault(frame.code.time_ns, frame)
    return first


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
@pytest.mark.parametrize("kind", ["rtsp", "rtsp-mjpeg"])
def test_sender_reports_tell_the_cameras_time_of_day(rig, libav_program, kind):
    offset_ns, drift_ppb, step_ns = 12_345_678_901, -70_000, 3600 * 10**9
    cam = rig.create_camera("lobby", size=(256, 64), fps=50, code_strip=True, clock={"offset_ns": offset_ns, "drift_ppb": drift_ppb})
    frame = rig.call("frame.get", camera="lobby")
    realtime_at_0 = frame["monotonic_ns"] - frame["time_ns"] + realtime_minus_monotonic()
    reader = LibavReader(libav_program, cam.url(kind))
    wait_until(lambda: len(first_sendings(reader.timed())) >= 50 * SECONDS, 60 + SECONDS, "frames with absolute times")
    before = reader.timed()
    cam.set(clock={"offset_ns": offset_ns + step_ns})
    stepped = lambda: [frame for frame in first_sendings(reader.timed()).values() if frame.wall_us - before[-1].wall_us > 3000 * 10**6]
    wait_until(stepped, 30, "the step")
    after = stepped()[0]
    reader.close()
    fresh = first_sendings(before)
    assert strictly_rising([frame.pts for frame in reader.frames])
    world = list(fresh)[1:]
    errors = [fresh[t].wall_us * 1000 - (t + realtime_at_0) for t in world]
    drift, at_middle, middle = line_through(world, errors)
    off = at_middle - (offset_ns + drift_ppb * middle / 1e9)
    ticks, _, _ = line_through(world, [fresh[t].pts * TICK_NS - t for t in world])
    print(f"{kind}: {len(world)} frames, drift {drift:.1f} ppb, off by {off:.0f} ns; RTP time drifts {ticks:.1f} ppb")
    coarse = 4 / SECONDS  # a tick is 11 us: one in ten million shows after a minute only
    assert abs(drift - drift_ppb) < max(100, 2000 * coarse)
    assert abs(ticks - drift_ppb) < max(100, 2000 * coarse)
    assert abs(off) < TICK_NS
    late = after.wall_us * 1000 - (after.code.time_ns + realtime_at_0) - step_ns
    assert abs(late - (offset_ns + drift_ppb * after.code.time_ns / 1e9)) < 2 * TICK_NS


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_the_message_in_the_picture_and_its_stamp_are_on_the_cameras_clock(rig):
    offset_ns = -5 * 10**9
    right = rig.create_camera("right", size=(160, 120))
    wrong = rig.create_camera("wrong", size=(160, 120), clock={"offset_ns": offset_ns, "drift_ppb": 100_000})
    told, = {p.times.realtime_ns - p.times.monotonic_ns for p in take(RtspReader(right.url("rtsp")), 3)}
    pictures = [p for p in itertools.islice(new_ones(RtspReader(wrong.url("rtsp")).pictures()), 40) if p.realtime_ns]
    assert len(pictures) > 20
    for p in pictures[5:]:
        assert p.times.realtime_ns == p.times.monotonic_ns + told + offset_ns + p.times.world_ns // 10_000
        assert 0 <= p.times.realtime_ns - p.realtime_ns <= TICK_NS + 2


NOISY = {"offset_ns": 3_000_000, "drift_ppb": 40_000, "walk_ns": 2_000, "jitter_ns": 50_000, "phase_ns": 5_000_000, "rate_ppb": -200_000,
         "trigger_jitter_ns": 400_000, "seed": 11}


def run_of_a_noisy_camera():
    """Times and pictures, step by step."""
    with camrig.start("scenes/minimal.json", mode="lockstep") as rig:
        rig.create_camera("right", size=(160, 120), fps=25, code_strip=True)
        cam = rig.create_camera("wrong", size=(160, 120), fps=25, code_strip=True, clock=NOISY)
        rows = []
        for step in range(40):
            rig.step(seconds=0.05)
            if step == 15:
                cam.set(clock={"state": "ntp"})
            if step == 25:
                cam.set(clock={"state": "free", "drift_ppb": -9_000, "rate_ppb": 5_000})
            frame, truth = cam.frame(), cam.truth()
            assert (frame.time_ns, frame.stamp_ns) == (truth["time_ns"], truth["stamp_ns"])
            rows.append((frame.sequence, frame.time_ns, frame.stamp_ns, frame.image.tobytes()))
        return rows


def test_a_run_with_all_that_is_random_replays_to_the_byte():
    first = run_of_a_noisy_camera()
    assert first == run_of_a_noisy_camera()
    assert len({stamp - at for _, at, stamp, _ in first}) > 30


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_phase_and_rate_move_the_exposures_and_not_the_stamps(rig):
    """Every frame of 20 s, as a reader of the device has them; the books say that there was no other."""
    rig.create_camera("right", size=(256, 64), fps=25, code_strip=True)
    cam = rig.create_camera("wrong", size=(256, 64), fps=25, code_strip=True, outputs=[{"kind": "mjpeg"}],
                            clock={"phase_ns": 7_000_001, "rate_ppb": 1_000_000})
    instants = [7_000_001 + n * 10**18 // (25 * (10**9 + 10**6)) for n in range(520)]
    with urllib.request.urlopen(cam.url("mjpeg"), timeout=20) as stream:
        seen = []

        def parts():
            fields = {}
            for line in stream:
                name, _, value = line.decode("latin-1").strip().partition(": ")
                fields[name] = value
                if name == "X-Stamp-Ns" and (shown := (int(fields["X-World-Time-Ns"]), int(value))) not in seen[-1:]:  # it may be sent again
                    seen.append(shown)
                if len(seen) > 501:
                    return

        thread = threading.Thread(target=parts, daemon=True)
        thread.start()
        wait_until(lambda: seen, what="the first picture")
        rig.step(seconds=20.007)
        books = next(c for c in rig.stats()["cameras"] if c["name"] == "wrong")
        due = sum(t <= 20_007_000_000 for t in instants)
        assert books["due"] == due == 501 and books["dropped"] == 0
        wait_until(lambda: len(seen) > 501, what="all pictures")
        thread.join(20)
    assert [t for t, _ in seen[1:]] == instants[:501]
    assert all(stamp == t for t, stamp in seen)
    reply = rig.call("frame.get", camera="right")
    assert reply["time_ns"] % 40_000_000 == 0 and "stamp_ns" not in reply


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_without_a_clock_nothing_is_told_of_one(rig):
    cam = rig.create_camera("lobby", size=(160, 120), clock={"offset_ns": 5})
    get = lambda: urllib.request.urlopen(cam.url("mjpeg").replace("stream.mjpg", "snapshot.jpg"), timeout=20)
    with get() as reply:
        assert int(reply.headers["X-Stamp-Ns"]) - int(reply.headers["X-World-Time-Ns"]) == 5
        assert abs(float(reply.headers["X-Timestamp"]) - time.time()) < 60
        pixels = reply.read()
    cam.set(clock=None)
    assert cam.get()["clock"] is None
    with get() as reply:
        assert not {"X-Stamp-Ns", "X-Timestamp"} & set(reply.headers)
        assert reply.read() == pixels
    assert not {"stamp_ns", "steady_ns"} & (set(cam.truth()) | set(rig.call("frame.get", camera="lobby")))


@pytest.mark.parametrize("clock, where", [({"rate_ppb": 1_000_001}, "clock.rate_ppb"), ({"phase_ns": -1}, "clock.phase_ns"),
                                          ({"state": "gps"}, "clock.state"), ({"offset_ns": 0.5}, "clock.offset_ns"),
                                          ({"offset_ns": 3 * 10**18}, "clock.offset_ns"), ({"drift": 3}, "clock.drift")])
@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_what_no_clock_is_gets_an_error_that_says_where(rig, clock, where):
    with pytest.raises(camrig.CamrigError, match=where) as caught:
        rig.create_camera("lobby", clock=clock)
    assert caught.value.kind == "invalid_argument"


def test_an_onvif_device_tells_the_cameras_time_and_judges_by_it(tmp_path):
    """Clients whose logins fail because the camera's clock is wrong are met in the field; so is asking it for its time first."""
    token_file, port = tmp_path / "token", free_port()
    token_file.write_text(TOKEN + "\n")
    with camrig.start("minimal", mode="lockstep", args=["--token-file", str(token_file)]) as rig:
        cam = rig.create_camera("dome", size=(160, 120), clock={"offset_ns": 400 * 10**9}, outputs=[{"kind": "onvif", "port": port}])
        wait_until(lambda: listens(port), what="the camera's port")

        def told():
            status, text, _ = post(port, "<tds:GetSystemDateAndTime/>")
            assert status == 200
            values = dict(part.split(">", 1) for part in text.replace("tt:", "").split("<") if part[:3] in ("Yea", "Mon", "Day", "Hou", "Min", "Sec"))
            return calendar.timegm(tuple(int(values[name]) for name in ("Year", "Month", "Day", "Hour", "Minute", "Second")))

        def told_by_events():
            """Of a new subscription: its own times, and those of a pull and of the messages in it."""
            ask = lambda operation, path, nonce: post(port, operation, security(TOKEN, nonce, -offset_s), path=path)[1]
            made = ask("<tev:CreatePullPointSubscription/>", "/onvif/device_service", os.urandom(16))
            path = re.search("Address>http://127.0.0.1:[0-9]+([^<]+)", made)[1]
            pulled = ask("<tev:PullMessages><tev:Timeout>PT20S</tev:Timeout><tev:MessageLimit>9</tev:MessageLimit></tev:PullMessages>", path, os.urandom(16))
            assert "NotificationMessage" in pulled, pulled
            seconds = lambda found: calendar.timegm(time.strptime(found, "%Y-%m-%dT%H:%M:%SZ"))
            now = [seconds(one) for one in re.findall(r'(?:CurrentTime>|UtcTime=")([0-9TZ:-]+)', made + pulled)]
            ends = [seconds(one) for one in re.findall("TerminationTime>([0-9TZ:-]+)<", made + pulled)]
            assert len(now) > 2 and len(ends) == 2
            return now, ends

        def assert_events_are_by_the_clock():
            now, ends = told_by_events()
            assert all(abs(one - time.time() - offset_s) < 10 for one in now), (now, offset_s)
            assert all(abs(one - time.time() - offset_s - 60) < 70 for one in ends), (ends, offset_s)

        offset_s = 400
        assert_events_are_by_the_clock()
        asks = lambda age_s, nonce: post(port, "<trt:GetProfiles/>", security(TOKEN, nonce, age_s))[0]
        assert abs(told() - time.time() - 400) < 5
        assert asks(0, b"a" * 16) == 400
        assert asks(-400, b"b" * 16) == 200  # a client that has asked for the time
        cam.set(clock={"offset_ns": 0})
        offset_s = 0
        assert_events_are_by_the_clock()
        assert abs(told() - time.time()) < 5
        assert asks(0, b"c" * 16) == 200
        assert asks(-400, b"d" * 16) == 400


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
@pytest.mark.parametrize("offset_ns", [-5 * 10**9, 5 * 10**9])
def test_rtp_time_goes_on_when_a_clock_is_given_to_a_camera_in_the_middle(rig, offset_ns):
    """It is steady, and what it is wrong by from the begin is nobody's to see."""
    cam = rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "rtsp"}])
    packets = RtpPackets(cam.url("rtsp"))
    stamps = []
    while len(stamps) < 60:
        channel, packet = packets.next()
        stamp = struct.unpack(">I", packet[4:8])[0]
        if channel == 0 and stamp not in stamps[-1:]:
            stamps.append(stamp)
            if len(stamps) == 20:
                cam.set(clock={"offset_ns": offset_ns, "drift_ppb": 20_000})
            if len(stamps) == 40:
                cam.set(clock=None)
    steps = [(b - a) % 2**32 for a, b in zip(stamps[1:], stamps[2:])]  # a stream begins with the latest picture
    lost = rig.stats()["cameras"][-1]["dropped"]  # on a busy machine
    assert all(3000 <= step <= 3600 * (25 + lost) for step in steps), (steps, lost)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_stamps_of_a_device_are_what_truth_says_when_jitter_is_larger_than_the_period(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=50, clock={"jitter_ns": 200_000_000, "drift_ppb": -1_000_000, "seed": 3})
    steady, stamps = [], []
    for _ in range(50):
        rig.step(seconds=0.02)
        truth = cam.truth()
        steady.append(truth["steady_ns"] - truth["monotonic_ns"] + truth["time_ns"])
        stamps.append(truth["stamp_ns"])
    assert all(b > a + 1000 for a, b in zip(steady, steady[1:])), "never back, and no two in a microsecond"
    assert any(b < a for a, b in zip(stamps, stamps[1:])), "the time of day has all of it"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_an_event_that_gives_a_camera_another_clock_moves_its_exposures_too(rig):
    cam = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    rig.add_event("late", {"at_s": 0.45}, [{"action": "camera", "camera": "cam", "clock": {"phase_ns": 13_000_000}}])
    shown = []
    for _ in range(9):
        rig.step(seconds=0.1)
        shown.append(cam.frame().time_ns // 10**6)
    assert shown == [100, 200, 300, 400, 500, 513, 613, 713, 813]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_events_set_a_clock_as_often_as_somebody_would(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=10)
    offsets = {0.3: 3600 * 10**9, 0.6: -2 * 10**9, 0.9: 5}
    for at, offset_ns in offsets.items():
        rig.call("event.add", name=f"set_{int(10 * at)}", when={"at_s": at},
                 do=[{"action": "camera", "camera": "desk", "clock": {"offset_ns": offset_ns, "drift_ppb": 1000}}])
    errors = []
    for _ in range(12):
        rig.step(seconds=0.1)
        truth = cam.truth()
        errors.append(truth["stamp_ns"] - truth["time_ns"] if "stamp_ns" in truth else None)
    drift = [(i + 1) * 100_000 // 1000 * 1 for i in range(12)]
    expected = [None, None] + [3600 * 10**9] * 3 + [-2 * 10**9] * 3 + [5] * 4
    assert [None if error is None else error - more for error, more in zip(errors, drift)] == expected


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_text_in_the_picture_is_the_cameras_time_of_day(rig):
    """A camera that is a second ahead shows now what a right one shows a second later."""
    right, ahead, plain = (rig.create_camera(name, size=(320, 240), fps=25, position=(0, 0, 2), look_at=(5, 0, 1), clock_text=name != "plain",
                                             clock={"offset_ns": 10**9} if name == "ahead" else None) for name in ("right", "ahead", "plain"))
    text = lambda camera: camera.frame().image[-9:, :115].copy()
    rig.step(seconds=1)
    before, early = text(right), text(ahead)
    assert (before != early).any()
    assert {tuple(pixel) for pixel in before.reshape(-1, 3)} == {(0, 0, 0), (255, 255, 255)}
    rig.step(seconds=1)
    assert (text(right) == early).all()
    assert (right.frame().image[:-9] == plain.frame().image[:-9]).all(), "nothing else of the picture is touched"
    with pytest.raises(camrig.CamrigError, match="clock_text: a picture of 64x24 has no room"):
        rig.create_camera("small", size=(64, 24), clock_text=True)
