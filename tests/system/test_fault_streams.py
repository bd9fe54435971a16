"""Streams that fail: damaged H.264, HTTP parts that lie, and the truth of what dirt hides."""

import subprocess
import urllib.request

import numpy as np
import pytest

from fault_books import books_balance  # noqa: F401 (a fixture)


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
    some = nals(rig, "desk", 150, tmp_path / "some")
    assert 0.3 < slices(some) / slices(clean) < 0.7
    rig.fault.clear("desk")
    rig.fault.set("desk", "corrupt_video", mode="drop_idr", probability=1.0)
    keyless = nals(rig, "desk", 150, tmp_path / "keyless")
    assert keyless.count(5) == 0 and keyless.count(1) > 20
    assert keyless.count(7) > 3, "parameter sets still come"


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
