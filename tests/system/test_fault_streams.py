"""Streams that fail: damaged H.264, HTTP parts that lie, and the truth of what dirt hides."""

import contextlib
import json
import os
import socket
import struct
import subprocess
import threading
import time
import urllib.request

import numpy as np
import pytest

import camrig
from conftest import wait_until
from fault_books import books_balance  # noqa: F401 (a fixture)
from rtsp_client import let_the_asked_key_come, unless_held_up
from test_faults import RtpPackets


def decoded(rig, name, frames=40):
    """What ffmpeg makes of the H.264 stream: its complaints, and its pictures."""
    done = subprocess.run(["ffmpeg", "-hide_banner", "-loglevel", "warning", "-rtsp_transport", "tcp", "-i", f"{rig.rtsp_url}/{name}", "-frames:v",
                           str(frames), "-vf", "scale=80:60", "-f", "rawvideo", "-pix_fmt", "gray", "-"], capture_output=True, timeout=40,
                          stdin=subprocess.DEVNULL)
    return done.stderr.decode(), np.frombuffer(done.stdout, np.uint8).reshape(-1, 60, 80)


def nals(rig, name, count, path):
    """Types of the NAL units that GStreamer's depayloader gives, of `count` of them."""
    subprocess.run(["gst-launch-1.0", "-q", "rtspsrc", f"location={rig.rtsp_url}/{name}", "protocols=tcp", "!", "rtph264depay", "!",
                    "video/x-h264,stream-format=byte-stream,alignment=nal", "!", "identity", f"eos-after={count}", "!", "filesink",
                    f"location={path}"], timeout=40, check=False, capture_output=True)
    return [part[0] & 31 for part in path.read_bytes().split(b"\x00\x00\x01")[1:]]


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_damaged_h264_reaches_the_readers_of_its_camera_alone(rig):
    for name in ("desk", "well"):
        rig.create_camera(name, size=(320, 240), fps=25, place="lobby", outputs=[{"kind": "rtsp", "key_interval_s": 0.4}])
    assert decoded(rig, "desk", 20)[0] == ""
    rig.fault.set("desk", "corrupt_video", mode="bitflip", amount=200)
    assert "error" in decoded(rig, "desk")[0].lower()
    assert decoded(rig, "well", 20)[0] == ""
    rig.fault.clear("desk")
    assert decoded(rig, "desk", 20)[0] == "", "the next key frame heals it"


@pytest.mark.camrig(scene="scenes/hall.json", mode="realtime")
def test_slices_of_h264_are_missing_or_those_of_key_frames(rig, tmp_path):
    rig.create_camera("desk", size=(320, 240), fps=25, place="lobby", outputs=[{"kind": "rtsp", "key_interval_s": 0.4}])
    slices = lambda types: sum(1 <= one <= 5 for one in types) / types.count(6)  # an SEI unit for each picture
    clean = nals(rig, "desk", 150, tmp_path / "clean")
    assert clean.count(5) >= 4
    rig.fault.set("desk", "corrupt_video", mode="drop_nal", probability=0.5)
    some = nals(rig, "desk", 400, tmp_path / "some")  # of so many pictures a share of a half is told from chance
    assert 0.3 < slices(some) / slices(clean) < 0.7
    rig.fault.clear("desk")
    rig.fault.set("desk", "corrupt_video", mode="drop_idr", probability=1.0)
    keyless = nals(rig, "desk", 150, tmp_path / "keyless")
    assert keyless.count(5) == 0 and keyless.count(1) > 20
    assert keyless.count(7) > 3, "parameter sets still come"


def keep_parts(stream, into):
    """Each whole JPEG of an MJPEG stream by its frame's number, until the stream ends."""
    try:
        while line := stream.readline():
            if line.startswith(b"Content-Length: "):
                length = int(line.split()[1])
            if line.startswith(b"X-Sequence: "):
                sequence = int(line.split()[1])
            if line == b"\r\n":
                into[sequence] = stream.read(length)
                stream.readline()
    except (OSError, ValueError, AttributeError):
        pass  # it was closed


def raw_stream(cam, size):
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        data = b""
        while len(data) < size:
            data += stream.read1(65536)
    return data


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_parts_announce_a_wrong_length_or_lack_their_boundary(rig):
    cam = rig.create_camera("desk", size=(160, 120), fps=25)

    def parts(data):
        """(announced, sent, has boundary) of each whole part."""
        found = []
        for part in data.split(b"Content-Type: image/jpeg\r\n")[1:-1]:
            head, body = part.split(b"\r\n\r\n", 1)
            announced = int(head.split(b"Content-Length: ")[1].split(b"\r\n")[0])
            found.append((announced, body.rindex(b"\xff\xd9") + 2, body.endswith(b"--frame\r\n")))
        return found

    assert all(announced == sent and bounded for announced, sent, bounded in parts(raw_stream(cam, 40000)))
    rig.fault.set("desk", "bad_part", mode="length", probability=1.0)
    wrong = parts(raw_stream(cam, 40000))[2:]
    assert wrong and all(announced == sent + sent // 2 and bounded for announced, sent, bounded in wrong)
    rig.fault.clear("desk")
    rig.fault.set("desk", "bad_part", mode="boundary", probability=0.5)
    some = parts(raw_stream(cam, 120000))[2:]
    assert all(announced == sent for announced, sent, _ in some)
    assert 0.2 < np.mean([bounded for _, _, bounded in some]) < 0.8


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_truth_says_how_much_dirt_hides_and_stays_clean(rig):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    rig.step(seconds=0.04)
    clean, before = cam.frame().image.astype(float), cam.truth()
    assert before["covered_fraction"] == 0
    hidden = []
    for severity in (0.3, 0.6, 1.0):
        rig.fault.set("desk", "dirt", severity=severity, coverage=0.5, spot=0.2)
        rig.step(seconds=0.04)
        hidden.append(cam.truth()["covered_fraction"])
        rig.fault.clear("desk")
    assert hidden == pytest.approx([0.15, 0.3, 0.5], abs=0.01)
    rig.fault.set("desk", "covered", severity=0.5)
    rig.step(seconds=0.04)
    truth, shown = cam.truth(), cam.frame().image.astype(float)
    assert truth["objects"] and [one["id"] for one in truth["objects"]] == [one["id"] for one in before["objects"]]
    rows = (shown.sum(axis=(1, 2)) < 0.75 * clean.sum(axis=(1, 2))).mean()  # half of the light is 0.73 of the code
    assert truth["covered_fraction"] == pytest.approx(rows, abs=0.05)


def light_of(codes):
    """Linear light of sRGB codes (IEC 61966-2-1), 0 to 1."""
    codes = codes / 255.0
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def code_of(light):
    light = np.clip(light, 0.0, 1.0)
    return 255.0 * np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_the_mask_of_what_dirt_hides_makes_the_picture_of_the_clean_one(rig):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    rig.create_camera("twin", size=(320, 240), fps=25, place="lobby")
    rig.step(seconds=0.04)
    assert not cam.soiling().any()
    veil = {"red": 0.5, "green": 0.4, "blue": 0.3}
    rig.fault.set("desk", "dirt", severity=0.8, coverage=0.6, spot=0.2, **veil)
    rig.step(seconds=0.04)
    both = rig.grab(["desk", "twin"], ["color", "soiling", "truth"])
    mask, truth = both["desk"]["soiling"], both["desk"]["truth"]
    assert mask.shape == (240, 320) and mask.dtype == np.uint8 and not both["twin"]["soiling"].any()
    assert (mask > 127).mean() == pytest.approx(truth["covered_fraction"], abs=1e-9)
    assert 0.45 < truth["covered_fraction"] < 0.51
    # picture = scene * (1 - alpha) + veil * alpha in linear light: within a code, for an alpha that the mask's byte may stand for.
    scene, front = light_of(both["twin"]["color"]), np.array([veil["blue"], veil["green"], veil["red"]])
    ends = [code_of((1 - alpha) * scene + alpha * front) for alpha in (np.clip((mask[:, :, None] + half) / 255.0, 0, 1) for half in (-0.5, 0.5))]
    shown = both["desk"]["color"].astype(float)
    assert (shown >= np.minimum(*ends) - 1).all() and (shown <= np.maximum(*ends) + 1).all()
    assert np.abs(shown - both["twin"]["color"]).max() > 30
    # Of each object truth counts the pixels under it, and stays otherwise as it is for the clean camera.
    ids = cam.instances()
    assert truth["objects"]
    for one, clean in zip(truth["objects"], both["twin"]["truth"]["objects"], strict=True):
        assert one["pixels_soiled"] == ((ids == one["id"]) & (mask > 127)).sum()
        assert one["visible_fraction_soiled"] == pytest.approx((one["pixels"] - one["pixels_soiled"]) / one["pixels_alone"])
        assert {key: value for key, value in one.items() if "soiled" not in key} == {key: value for key, value in clean.items() if "soiled" not in key}
    with urllib.request.urlopen(f"{rig.http_url}/cameras/desk/soiling.png", timeout=30) as png:
        import cv2

        assert np.array_equal(cv2.imdecode(np.frombuffer(png.read(), np.uint8), cv2.IMREAD_UNCHANGED), mask)
    with pytest.raises(camrig.CamrigError, match="soiling comes raw or as png"):
        cam.frame(kind="soiling", format="jpeg")
    assert truth["focus_error_px"] == 0
    rig.fault.set("desk", "defocus", severity=0.5, radius=0.02)
    rig.step(seconds=0.04)
    assert cam.truth()["focus_error_px"] == pytest.approx(0.5 * 0.02 * 320)


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_a_wiper_takes_dirt_from_the_glass_and_leaves_tape_and_other_cameras(rig):
    cams = {name: rig.create_camera(name, size=(320, 240), fps=25, place="lobby") for name in ("desk", "well", "clean")}
    for name in ("desk", "well"):
        for kind in ("dirt", "drops", "condensation"):
            rig.fault.set(name, kind)
    rig.step(seconds=0.04)
    assert cams["desk"].truth()["covered_fraction"] > 0.5
    assert rig.fault.wipe("desk") == 3 and rig.fault.wipe("desk") == 0
    rig.step(seconds=0.04)
    shown = rig.grab(list(cams), ["color", "soiling"])
    assert np.array_equal(shown["desk"]["color"], shown["clean"]["color"]) and not shown["desk"]["soiling"].any()
    assert not np.array_equal(shown["well"]["color"], shown["clean"]["color"])
    rig.fault.set("desk", "covered")
    rig.fault.set("desk", "knock")
    assert rig.fault.wipe("desk") == 0 and len(rig.fault.list("desk")) == 2
    done = subprocess.run([os.environ["CAMRIG_BIN"], "fault", "wipe", "well", "--control", rig.call("server.info")["control"]], capture_output=True,
                          text=True, timeout=60)
    assert done.stdout.strip() == "3 wiped away", done.stderr
    with pytest.raises(camrig.CamrigError, match="nobody"):
        rig.fault.wipe("nobody")


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
@pytest.mark.parametrize("mode", ["bitflip", "zero", "truncate", "cut"])
def test_truth_says_which_bytes_of_a_jpeg_came_wrong(rig, mode):
    cams = {name: rig.create_camera(name, size=(320, 240), fps=25, place="lobby") for name in ("desk", "well")}
    got = {name: {} for name in cams}
    with contextlib.ExitStack() as stack:
        for name, cam in cams.items():
            stream = stack.enter_context(urllib.request.urlopen(cam.url(), timeout=30))
            threading.Thread(target=keep_parts, args=(stream, got[name]), daemon=True).start()
        wait_until(lambda: all(got.values()), what="the first pictures")
        fault = rig.fault.set("desk", "corrupt_jpeg", mode=mode, amount=300, output="mjpeg")
        rig.step(seconds=0.04)
        outputs = cams["desk"].truth()["outputs"]
        wait_until(lambda: all(1 in pictures for pictures in got.values()), what="the pictures")
    damaged, whole = got["desk"][1], got["well"][1]  # of one scene: the same but for the fault
    (harm,) = outputs["mjpeg"]["damaged"]
    assert outputs["rtsp"]["damaged"] == [] and outputs["mjpeg"]["more_damaged"] == 0
    assert (harm["fault"], harm["kind"], harm["mode"], harm["size"], harm["times"]) == (fault["id"], "corrupt_jpeg", mode, len(whole), 1)
    if mode in ("truncate", "cut"):
        ((offset, count),) = harm["runs"]
        assert count == harm["bytes"] == 300 and damaged == whole[:offset] + whole[offset + count:]
    else:
        wrong = [i for i in range(len(whole)) if damaged[i] != whole[i]]
        told = [i for offset, count in harm["runs"] for i in range(offset, offset + count)]
        assert harm["bytes"] == len(wrong) and told == wrong[:len(told)]
        assert len(told) == len(wrong) or len(harm["runs"]) == 64


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_truth_says_where_a_part_was_cut_and_how_often(rig):
    cam = rig.create_camera("desk", size=(320, 240), fps=25, place="lobby")
    got = [{}, {}]
    with contextlib.ExitStack() as stack:
        for into in got:
            stream = stack.enter_context(urllib.request.urlopen(cam.url(), timeout=30))
            threading.Thread(target=keep_parts, args=(stream, into), daemon=True).start()
        wait_until(lambda: all(got), what="the first pictures")
        rig.fault.set("desk", "cut_part", probability=1.0)
        rig.step(seconds=0.04)
        (harm,) = cam.truth()["outputs"]["mjpeg"]["damaged"]
    assert (harm["kind"], harm["mode"], harm["times"]) == ("cut_part", "truncate", 2)
    assert harm["runs"] == [[harm["size"] // 2, harm["bytes"]]] and harm["bytes"] == harm["size"] - harm["size"] // 2


class H264Slices:
    """The slices of each picture of an H.264 stream, put together from its RTP packets (RFC 6184)."""

    def __init__(self, url):
        self.packets, self.pictures, self._slices, self._unit = RtpPackets(url), [], [], b""
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            while True:
                channel, packet = self.packets.next()
                if channel == 0:
                    self._take(packet[12:], bool(packet[1] & 0x80))
        except (OSError, ValueError, struct.error, AssertionError):
            pass  # it was closed

    def _take(self, payload, is_last):
        if payload[0] & 31 == 28:  # a piece of a unit, FU-A
            begins, ends = payload[1] & 0x80, payload[1] & 0x40
            self._unit = (bytes([payload[0] & 0xE0 | payload[1] & 31]) if begins else self._unit) + payload[2:]
            units = [self._unit] if ends else []
        elif payload[0] & 31 == 24:  # several, STAP-A
            units, at = [], 1
            while at < len(payload):
                size = int.from_bytes(payload[at:at + 2])
                units.append(payload[at + 2:at + 2 + size])
                at += 2 + size
        else:
            units = [payload]
        self._slices += [unit for unit in units if 1 <= unit[0] & 31 <= 5]
        if is_last:
            self.pictures.append(self._slices)
            self._slices = []

    def close(self):
        with contextlib.suppress(OSError):  # the rig has ended it
            self.packets.socket.shutdown(socket.SHUT_RDWR)  # close() alone leaves it open for the thread that reads
        self.packets.socket.close()


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_truth_says_which_bytes_of_h264_came_wrong(rig):
    unless_held_up(rig, lambda moments: check_bytes_of_h264(rig, moments))


def check_bytes_of_h264(rig, moments):
    moments.append(time.monotonic())
    cams = {name: rig.create_camera(name, size=(320, 240), fps=25, place="lobby", outputs=[{"kind": "rtsp", "key_interval_s": 0.4}]) for name in ("desk", "well")}
    streams = {}

    def step():
        """The slices of the picture as the failing camera's readers and the other's have them, and what truth says."""
        counts = {name: len(stream.pictures) for name, stream in streams.items()}
        moments.append(time.monotonic())
        rig.step(seconds=0.04)
        wait_until(lambda: all(len(stream.pictures) > counts[name] for name, stream in streams.items()), what="the pictures")
        assert cams["well"].truth()["outputs"]["rtsp"]["damaged"] == []
        return streams["desk"].pictures[-1], streams["well"].pictures[-1], cams["desk"].truth()["outputs"]["rtsp"]["damaged"]

    def begin():
        """Both streams, whose encoders have been shown the same: the world that stands, once, and a step's picture, which is the key picture that was asked for.

        What is sent again to one of them, as when the other is opened late, counts for its encoder's key pictures and its rate.
        """
        for _ in range(20):
            streams.update({name: H264Slices(f"{rig.rtsp_url}/{name}") for name in cams})
            wait_until(lambda: all(stream.pictures for stream in streams.values()), what="the first pictures")
            let_the_asked_key_come()
            step()
            if all([[one[0] & 31 for one in picture] for picture in stream.pictures] == [[5], [5]] for stream in streams.values()):
                return
            for stream in streams.values():
                stream.close()
            wait_until(lambda: not any(camera["outputs"] for camera in rig.stats()["cameras"]), what="the end of the streams")
        raise AssertionError("of 20 pairs of streams none was shown the same")

    def bytes_told(harm):
        """Whether each of the access unit's last bytes is as it was, from its end on."""
        return {harm["size"] - offset - i for offset, count in harm["runs"] for i in range(count)}

    def bytes_wrong(desk, well, start_code):
        """The same by what came; slices come last, one behind the other with their start codes."""
        wrong, behind = set(), 0
        for mine, right in zip(reversed(desk), reversed(well)):
            wrong |= {behind + len(right) - i for i in range(len(right)) if mine[i] != right[i]}
            behind += len(right) + start_code
        return wrong

    try:
        begin()
        moments[:] = [time.monotonic()]
        for _ in range(10):
            desk, well, damaged = step()
            assert desk == well and damaged == []
        rig.fault.set("desk", "corrupt_video", mode="bitflip", amount=30, probability=1.0)
        for _ in range(5):
            desk, well, (harm,) = step()
            assert (harm["kind"], harm["mode"], harm["times"], harm["more_runs"]) == ("corrupt_video", "bitflip", 1, 0)
            assert [len(one) for one in desk] == [len(one) for one in well]
            assert all(mine[:12] == right[:12] for mine, right in zip(desk, well)), "headers stay"
            assert harm["bytes"] == sum(count for _, count in harm["runs"])
            assert bytes_told(harm) in (bytes_wrong(desk, well, 3), bytes_wrong(desk, well, 4))
        rig.fault.clear("desk")
        rig.fault.set("desk", "corrupt_video", mode="drop_nal", probability=1.0)
        count = len(streams["well"].pictures)
        moments.append(time.monotonic())
        rig.step(seconds=0.04)
        (harm,) = cams["desk"].truth()["outputs"]["rtsp"]["damaged"]
        wait_until(lambda: len(streams["well"].pictures) > count, what="the picture")
        slices = streams["well"].pictures[-1]
        assert harm["mode"] == "drop_nal" and sum(count for _, count in harm["runs"]) == harm["bytes"]
        assert harm["bytes"] - sum(map(len, slices)) in (3 * len(slices), 4 * len(slices))
        rig.fault.clear("desk")
        moments.append(time.monotonic())
        rig.step(seconds=0.04)
        assert cams["desk"].truth()["outputs"]["rtsp"]["damaged"] == []
    finally:
        for stream in streams.values():
            stream.close()


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_a_recording_has_the_masks_of_what_dirt_hides(rig, tmp_path):
    import cv2

    cam = rig.create_camera("desk", size=(160, 120), fps=25, place="lobby")
    rig.fault.set("desk", "dirt", severity=0.5)
    rig.record(tmp_path / "set", [cam], frames=2, soiling=True)
    truths = [json.loads(line) for line in (tmp_path / "set/desk/truth.jsonl").read_text().splitlines()]
    for number, truth in enumerate(truths, 1):
        mask = cv2.imread(str(tmp_path / f"set/desk/soiling/{number:06}.png"), cv2.IMREAD_UNCHANGED)
        assert mask.shape == (120, 160) and (mask > 127).mean() == pytest.approx(truth["covered_fraction"])
    assert len(truths) == 2 and truths[-1]["covered_fraction"] > 0.2


def philox_unit(seed, stream, counter):
    """Philox4x32-10 (Salmon et al., SC 2011), the first 53 bits of a block as a number in [0, 1)."""
    low, high = (lambda v: v & 0xFFFFFFFF), (lambda v: v >> 32)
    words, keys = [low(counter), high(counter), low(stream), high(stream)], [low(seed), high(seed)]
    for _ in range(10):
        first, second = 0xD2511F53 * words[0], 0xCD9E8D57 * words[2]
        words = [high(second) ^ words[1] ^ keys[0], low(second), high(first) ^ words[3] ^ keys[1], low(first)]
        keys = [low(keys[0] + 0x9E3779B9), low(keys[1] + 0xBB67AE85)]
    return ((words[1] << 32 | words[0]) >> 11) / 2**53


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_frames_that_are_lost_are_those_of_the_hash_of_seed_fault_and_frame(rig):
    cam, got = rig.create_camera("desk", size=(64, 48), fps=25), {}
    with urllib.request.urlopen(cam.url(), timeout=30) as stream:
        threading.Thread(target=keep_parts, args=(stream, got), daemon=True).start()
        wait_until(lambda: 0 in got, what="the first picture")
        fault = rig.fault.set("desk", "drop", probability=0.8, severity=0.5, seed=99)
        delivered = []
        for frame in range(1, 101):
            rig.step(seconds=0.04)
            truth = cam.truth()
            assert truth["sequence"] == frame
            delivered += [frame] * truth["delivered"]
        rig.fault.clear("desk")
        rig.step(seconds=0.04)
        wait_until(lambda: 101 in got, what="the last picture")
    assert delivered == [frame for frame in range(1, 101) if philox_unit(99, 3 << 60 | fault["id"] << 8, frame) >= 0.4]
    assert sorted(got) == [0, *delivered, 101]
    assert 45 < len(delivered) < 75
