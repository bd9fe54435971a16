"""Bags of a real rig, read by two libraries that need no ROS: mcap with mcap-ros2-support, and rosbags."""

import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import time
import urllib.request
import warnings

import cv2
import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import camrig
from conftest import wait_until
from rtsp_client import gst_reads

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from mcap_ros2.reader import read_ros2_messages

HALL = {"scene": "scenes/hall.json", "mode": "lockstep"}
MINIMAL = {"scene": "scenes/minimal.json", "mode": "lockstep"}
FOUR = ("left", "right", "slow", "ntsc")
PERIODS = {"left": (25, 1), "right": (25, 1), "slow": (10, 1), "ntsc": (30000, 1001)}


def command(rig, *arguments):
    binary = os.environ.get("CAMRIG_BIN") or camrig.find_binary()
    return [binary, "--control", rig.call("server.info")["control"], *map(str, arguments)]


def record(rig, *arguments, code=0):
    """Runs `camrig ros2 record`; returns its summary, or with another code what it said."""
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    done = subprocess.run(command(rig, "--json", "ros2", "record", *arguments), capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout) if code == 0 else done.stderr


def stamp_ns(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def messages(bag):
    """All messages by topic, decoded by mcap-ros2-support; each log time is the stamp."""
    found = {}
    for path in sorted(bag.glob("*.mcap")):
        for message in read_ros2_messages(str(path)):
            found.setdefault(message.channel.topic, []).append(message.ros_msg)
            header = message.ros_msg.transforms[0].header if hasattr(message.ros_msg, "transforms") else message.ros_msg.header
            assert message.log_time_ns == message.publish_time_ns == stamp_ns(header)
    return found


def counts_by_rosbags(bag):
    """Message counts by topic, each message decoded by rosbags with the definitions of the bag itself."""
    store = get_typestore(Stores.EMPTY)
    counts = {}
    with Reader(bag) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, _, data in reader.messages():
            store.deserialize_cdr(data, connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
        assert reader.message_count == sum(counts.values())
        assert counts == {connection.topic: connection.msgcount for connection in reader.connections if connection.msgcount}
    return counts


def wait_for_pictures(bag, count):
    """Until so many were flushed into a bag that is being recorded."""
    soi = b"\xff\xd8\xff"
    wait_until(lambda: sum(path.read_bytes().count(soi) for path in bag.glob("*.mcap")) >= count, timeout_s=60, what=f"{count} pictures")


def make_four(rig):
    lens = {"model": "plumb_bob", "coefficients": [-0.2, 0.05, 0.001, -0.002, 0.01]}
    rig.create_camera("left", size=(160, 120), fps=25, place="lobby", code_strip=True)
    rig.create_camera("right", size=(192, 108), fps=25, hfov_deg=80, position=(20, 4, 3), look_at=(12, 9, 1), code_strip=True)
    rig.create_camera("slow", size=(160, 120), fps=10, lens=lens, position=(2, 3, 2.8), look_at=(12, 9, 1), code_strip=True)
    rig.create_camera("ntsc", size=(160, 120), fps="30000/1001", place="desk", code_strip=True)


def due_ns(camera, after_ns, until_ns):
    num, den = PERIODS[camera]
    grid = (n * den * 10**9 // num for n in range(until_ns * num // (den * 10**9) + 2))
    return [ns for ns in grid if after_ns < ns <= until_ns]


@pytest.mark.camrig(**HALL)
def test_a_lockstep_bag_has_every_frame_of_every_camera_at_its_instant(rig, tmp_path):
    make_four(rig)
    rig.step(seconds=0.33)
    summary = record(rig, tmp_path / "bag", "--cameras", ",".join(FOUR), "--seconds", 2)
    assert rig.status()["world_ns"] == summary["world_ns"] == 2_330_000_000

    found = messages(tmp_path / "bag")
    assert counts_by_rosbags(tmp_path / "bag") == {topic: len(items) for topic, items in found.items()}
    for camera in FOUR:
        expected = due_ns(camera, 330_000_000, 2_330_000_000)
        pictures, infos = found[f"/{camera}/image_raw/compressed"], found[f"/{camera}/camera_info"]
        assert [stamp_ns(m.header) for m in pictures] == [stamp_ns(m.header) for m in infos] == expected
        assert summary["frames"][camera] == len(expected) and summary["missing"][camera] == 0
        for picture in pictures:
            # The instant is in the pixels too.
            assert picture.format == "jpeg" and picture.header.frame_id == f"{camera}_optical_frame"
            image = cv2.imdecode(np.frombuffer(bytes(picture.data), np.uint8), cv2.IMREAD_COLOR)
            assert camrig.read_code(image).time_ns == stamp_ns(picture.header)
    assert [stamp_ns(m.header) for m in found["/left/camera_info"]] == [stamp_ns(m.header) for m in found["/right/camera_info"]]
    poses = {(stamp_ns(t.header), t.child_frame_id) for m in found["/tf"] for t in m.transforms}
    assert poses == {(ns, f"{camera}_link") for camera in FOUR for ns in due_ns(camera, 330_000_000, 2_330_000_000)}


@pytest.mark.slow
@pytest.mark.camrig(**MINIMAL)
def test_a_minute_of_four_cameras(rig, tmp_path):
    """Split into files, every message decodes, and the cameras agree on every instant."""
    for name in ("a", "b", "c", "d"):
        rig.create_camera(name, size=(64, 48), fps=10, place="main")
    summary = record(rig, tmp_path / "bag", "--cameras", "a,b,c,d", "--seconds", 60, "--split-seconds", 20)
    assert sum(summary["frames"].values()) == 2400 and not any(summary["missing"].values())
    found = messages(tmp_path / "bag")
    assert counts_by_rosbags(tmp_path / "bag") == {topic: len(items) for topic, items in found.items()}
    stamps = [[stamp_ns(m.header) for m in found[f"/{name}/image_raw/compressed"]] for name in ("a", "b", "c", "d")]
    assert stamps == [[n * 10**8 for n in range(1, 601)]] * 4
    assert len(list((tmp_path / "bag").glob("*.mcap"))) == 3


@pytest.mark.camrig(**HALL)
def test_calibrations_are_those_of_the_cameras(rig, tmp_path):
    make_four(rig)
    record(rig, tmp_path / "bag", "--cameras", ",".join(FOUR), "--seconds", 0.2)
    found = messages(tmp_path / "bag")
    for camera in FOUR:
        is_set = rig.camera(camera).get()
        info = found[f"/{camera}/camera_info"][0]
        wanted = is_set["intrinsics"]
        fx, fy, cx, cy = (wanted[key] for key in ("fx", "fy", "cx", "cy"))
        assert [info.width, info.height] == is_set["size"]
        assert list(info.k) == [fx, 0, cx, 0, fy, cy, 0, 0, 1]
        assert list(info.p) == [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]
        assert list(info.r) == [1, 0, 0, 0, 1, 0, 0, 0, 1]
        assert info.distortion_model == "plumb_bob"
        assert list(info.d) == (is_set["lens"]["coefficients"] or [0] * 5)


@pytest.mark.camrig(**MINIMAL)
def test_the_bag_alone_says_where_things_are_in_the_pictures(rig, tmp_path):
    """The pose chain of /tf and /tf_static, K and D, used with OpenCV alone, lead from a pixel of one camera to that of another:
    the depth that the second one sees is the one that follows from the first."""
    lenses = {
        "one": {"model": "plumb_bob", "coefficients": [-0.25, 0.06, 0.002, -0.003, 0.01]},
        "two": {"model": "rational_polynomial", "coefficients": [0.3, 0.05, -0.002, 0.001, 0.02, 0.5, 0.1, 0.01]},
    }
    cameras = {
        "one": rig.create_camera("one", size=(160, 120), fps=10, lens=lenses["one"], vfov_deg=50, position=(-5, -2, 3), look_at=(0, 0, 0.4)),
        "two": rig.create_camera("two", size=(192, 108), fps=10, lens=lenses["two"], hfov_deg=70, position=(-3, 4, 2), pan_deg=-50, tilt_deg=-20, roll_deg=20),
    }
    record(rig, tmp_path / "bag", "--cameras", "one,two", "--seconds", 0.1)
    depths = {name: camera.depth() for name, camera in cameras.items()}
    found = messages(tmp_path / "bag")

    def matrix(transform):
        t, q = transform.transform.translation, transform.transform.rotation
        result = np.eye(4)
        x, y, z, w = q.x, q.y, q.z, q.w
        result[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        result[:3, 3] = t.x, t.y, t.z
        return result

    edges = {t.child_frame_id: t for topic in ("/tf", "/tf_static") for m in found[topic] for t in m.transforms}

    def map_from_optical(name):
        optical, link = edges[f"{name}_optical_frame"], edges[f"{name}_link"]
        assert (optical.header.frame_id, link.header.frame_id) == (f"{name}_link", "map")
        return matrix(link) @ matrix(optical)

    infos = {name: found[f"/{name}/camera_info"][0] for name in cameras}
    k, d = ({name: np.array(values(info)) for name, info in infos.items()} for values in (lambda i: np.reshape(i.k, (3, 3)), lambda i: i.d))
    v, u = np.mgrid[0 : depths["one"].shape[0], 0 : depths["one"].shape[1]]
    seen = np.isfinite(depths["one"])
    pixels = np.stack([u[seen], v[seen]], axis=1).astype(float)
    rays = np.vstack([cv2.undistortPoints(pixels, k["one"], d["one"]).reshape(-1, 2).T, np.ones(len(pixels))])
    points = map_from_optical("one") @ np.vstack([rays * depths["one"][seen], np.ones(len(pixels))])

    two_from_map = np.linalg.inv(map_from_optical("two"))
    rotation, _ = cv2.Rodrigues(two_from_map[:3, :3])
    pixels, _ = cv2.projectPoints(points[:3].T, rotation, two_from_map[:3, 3], k["two"], d["two"])
    expected = (two_from_map @ points)[2]
    column, row = np.rint(pixels.reshape(-1, 2)).astype(int).T
    height, width = depths["two"].shape
    inside = (expected > 0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    assert inside.sum() > 2000
    error = np.abs(depths["two"][row[inside], column[inside]] - expected[inside]) / expected[inside]
    # Half a pixel of rounding on a slanted ground, and what one camera sees and the other does not.
    assert np.median(error) < 0.01
    assert (error < 0.03).mean() > 0.8


@pytest.mark.camrig(**MINIMAL)
def test_a_moved_camera_moves_in_the_bag_from_its_instant_on(rig, tmp_path, programs):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, vfov_deg=60, position=(-5, 0, 2), look_at=(0, 0, 0))
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    # The recorder only follows: this test steps the world.
    recorder = programs(
        command(rig, "ros2", "record", tmp_path / "bag", "--cameras", "cam", "--follow", "--seconds", 1), env=environment, stdout=subprocess.PIPE
    )
    wait_until(lambda: camera.get()["readers"] == 1, what="the recorder's stream")
    rig.step(seconds=0.5)
    wait_for_pictures(tmp_path / "bag", 5)
    camera.set(position=(-4, 1, 3), vfov_deg=30)
    rig.step(seconds=0.5)
    assert recorder.wait(60) == 0
    found = messages(tmp_path / "bag")
    assert [stamp_ns(m.header) for m in found["/cam/camera_info"]] == [n * 10**8 for n in range(1, 11)]
    positions = [m.transforms[0].transform.translation for m in found["/tf"]]
    assert [(p.x, p.y, p.z) for p in positions] == [(-5, 0, 2)] * 5 + [(-4, 1, 3)] * 5
    focal = [m.k[4] for m in found["/cam/camera_info"]]
    assert focal[:5] == [focal[0]] * 5 and focal[5:] == [focal[5]] * 5 and focal[5] > 2 * focal[0]


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("raw", [(), ("--raw",)])
def test_poses_and_lenses_of_a_camera_on_its_way_are_those_of_the_instant(rig, tmp_path, raw):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, vfov_deg=60, position=(-5, 0, 2), look_at=(0, 0, 0))
    camera.set(position=(-4, 1, 3), vfov_deg=30, seconds=2)
    record(rig, tmp_path / "bag", "--cameras", "cam", "--seconds", 1, *raw)
    found = messages(tmp_path / "bag")
    positions = [m.transforms[0].transform.translation for m in found["/tf"]]
    now = camera.get()
    assert len(positions) == 10 and now["world_pose"]["position"][0] < -4.1
    assert [positions[-1].x, positions[-1].y, positions[-1].z] == now["world_pose"]["position"]
    focal = [m.k[4] for m in found["/cam/camera_info"]]
    assert focal[-1] == now["shown_intrinsics"]["fy"] and len(set(focal)) == 10
    assert len({p.x for p in positions}) == 10


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("raw", [(), ("--raw",)])
def test_a_camera_whose_clock_is_its_own_is_recorded_at_its_own_instants(rig, tmp_path, raw):
    rig.create_camera("cam", size=(64, 48), fps=10, place="main", clock={"phase_ns": 7_000_000})
    rig.create_camera("other", size=(64, 48), fps=10, place="main")
    record(rig, tmp_path / "bag", "--seconds", 0.3, "--cameras", "cam,other", *raw)
    found = messages(tmp_path / "bag")
    assert [stamp_ns(m.header) for m in found["/cam/camera_info"]] == [7_000_000, 107_000_000, 207_000_000]
    assert [stamp_ns(m.header) for m in found["/other/camera_info"]] == [100_000_000, 200_000_000, 300_000_000]


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("options", [("--raw",), ("--detections",)])
def test_no_frame_of_a_camera_whose_trigger_comes_late_is_passed_over(rig, tmp_path, options):
    rig.create_camera("cam", size=(64, 48), fps=10, place="main", clock={"trigger_jitter_ns": 50_000_000, "phase_ns": 80_000_000, "seed": 5})
    summary = record(rig, tmp_path / "bag", "--seconds", 3, "--cameras", "cam", *options)
    stamps = [stamp_ns(m.header) for m in messages(tmp_path / "bag")["/cam/camera_info"]]
    assert summary["missing"]["cam"] == 0 and [(ns - 80_000_000) // 10**8 for ns in stamps][:29] == list(range(29))


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("fault, raw", [("drop", ()), ("drop", ("--raw",)), ("stall", ()), ("late", ()), ("restart", ())])
def test_frames_that_a_fault_keeps_back_are_missing_and_end_no_recording(rig, tmp_path, fault, raw):
    rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    # Who refuses readers does so from after the first is there.
    how = {"drop": {"probability": 1}, "restart": {"start_s": 0.05}}.get(fault, {})
    rig.fault.set("cam", fault, end_s=0.55, **how)
    summary = record(rig, tmp_path / "bag", "--cameras", "cam", "--seconds", 1, *raw)
    stamps = [stamp_ns(m.header) // 10**8 for m in messages(tmp_path / "bag")["/cam/camera_info"]]
    assert stamps[-4:] == [7, 8, 9, 10] and summary["frames"]["cam"] == len(stamps)
    # Which are late or in time is the stream's, and who was refused may come back after the next picture.
    assert summary["missing"]["cam"] == 10 - len(stamps) and (6 in stamps or fault == "restart") and (len(stamps) <= 5 or fault == "late")


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("raw", [(), ("--raw",)])
def test_a_camera_whose_every_frame_is_kept_back_is_told_with_all_it_misses(rig, tmp_path, raw):
    for name in ("cam", "seen"):
        rig.create_camera(name, size=(64, 48), fps=10, place="main")
    rig.fault.set("cam", "drop", probability=1)
    summary = record(rig, tmp_path / "bag", "--cameras", "cam,seen", "--seconds", 1, *raw)
    assert summary["frames"] == {"cam": 0, "seen": 10} and summary["missing"] == {"cam": 10, "seen": 0}


@pytest.mark.camrig(**MINIMAL)
def test_a_camera_that_shows_nothing_is_told_when_who_follows_is_stopped(rig, tmp_path, programs):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    rig.fault.set("cam", "drop", probability=1)
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    recorder = programs(command(rig, "--json", "ros2", "record", tmp_path / "bag", "--cameras", "cam", "--follow"), env=environment, stdout=subprocess.PIPE)
    wait_until(lambda: camera.get()["readers"] == 1, what="the recorder's stream")
    rig.step(seconds=1)
    recorder.send_signal(signal.SIGINT)
    said = json.loads(recorder.communicate(timeout=60)[0])
    assert recorder.returncode == 0 and said["frames"] == {"cam": 0} and said["missing"] == {"cam": 10}


@pytest.mark.camrig(**MINIMAL)
def test_raw_pictures_are_exact(rig, tmp_path):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    record(rig, tmp_path / "bag", "--cameras", "cam", "--seconds", 0.3, "--raw")
    last = messages(tmp_path / "bag")["/cam/image_raw"][-1]
    assert (last.encoding, last.step, stamp_ns(last.header)) == ("rgb8", 192, 300_000_000)
    assert np.array_equal(np.frombuffer(bytes(last.data), np.uint8).reshape(48, 64, 3), camera.frame().image[:, :, ::-1])


@pytest.mark.camrig(**MINIMAL)
def test_detections_are_the_truth_of_the_frame_where_the_rig_has_truth(rig, tmp_path):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    arguments = (tmp_path / "bag", "--cameras", "cam", "--seconds", 0.3, "--detections")
    record(rig, *arguments)
    found = messages(tmp_path / "bag")["/cam/detections"]
    assert [stamp_ns(m.header) for m in found] == [100_000_000, 200_000_000, 300_000_000]
    boxes = {str(item["id"]): item["box"] for item in camera.truth()["objects"] if item["box"]}
    assert boxes and {d.id for d in found[-1].detections} == set(boxes)
    for detection in found[-1].detections:
        x, y, width, height = boxes[detection.id]
        centre = detection.bbox.center.position
        assert (centre.x, centre.y, detection.bbox.size_x, detection.bbox.size_y) == (x + (width - 1) / 2, y + (height - 1) / 2, width, height)


@pytest.mark.camrig(**MINIMAL)
def test_jpeg_bytes_are_those_of_the_rig(rig, tmp_path):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    record(rig, tmp_path / "bag", "--cameras", "cam", "--seconds", 0.3, "--quality", 50)
    with urllib.request.urlopen(camera.url("jpg", quality=50)) as answer:
        assert bytes(messages(tmp_path / "bag")["/cam/image_raw/compressed"][-1].data) == answer.read()


def test_the_same_rig_gives_the_same_bag(scenes, tmp_path):
    digests = []
    for run in ("first", "second"):
        with camrig.start(str(scenes / "minimal.json"), mode="lockstep", seed=3) as other:
            other.create_camera("cam", size=(64, 48), fps=10, place="main")
            record(other, tmp_path / run / "bag", "--cameras", "cam,main", "--seconds", 0.5)
        digests.append({m: hashlib.sha256(repr(items).encode()).hexdigest() for m, items in messages(tmp_path / run / "bag").items()})
    assert digests[0] == digests[1]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_recorder_that_is_killed_leaves_a_bag_that_opens(rig, tmp_path, programs):
    for name in ("a", "b"):
        rig.create_camera(name, size=(64, 48), fps=20, place="main")
    bag = tmp_path / "bag"
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    recorder = programs(command(rig, "ros2", "record", bag, "--cameras", "a,b"), env=environment, stderr=subprocess.DEVNULL)

    def flushed():
        try:
            with Reader(bag) as reader:
                return reader.message_count
        except Exception:  # not there yet
            return 0

    wait_until(lambda: flushed() > 100, timeout_s=60, what="a hundred messages")
    before = flushed()
    os.kill(recorder.pid, signal.SIGKILL)
    recorder.wait()
    found = messages(bag)
    assert sum(len(items) for items in found.values()) >= before
    assert len(found["/a/image_raw/compressed"]) >= 10 and found["/tf_static"]
    assert counts_by_rosbags(bag) == {topic: len(items) for topic, items in found.items()}


@pytest.mark.camrig(**MINIMAL)
def test_a_full_disk_ends_a_recording_with_one_line_and_a_bag_that_opens(rig, tmp_path):
    """A limit on the size of files takes a part of the data and then no more, as a full disk does."""
    rig.create_camera("a", size=(64, 48), fps=100, place="main")

    def small_disk():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    bag = tmp_path / "bag"
    done = subprocess.run(command(rig, "ros2", "record", bag, "--cameras", "a", "--raw", "--seconds", 1), env=dict(os.environ, CAMRIG_PYTHON=sys.executable),
                          capture_output=True, text=True, timeout=120, preexec_fn=small_disk, restore_signals=False, check=False)
    assert done.returncode == 1 and "bag_0.mcap: cannot be written: File too large; the bag holds what came before" in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    found = messages(bag)
    held = counts_by_rosbags(bag)
    assert {topic: count for topic, count in held.items() if count} == {topic: len(items) for topic, items in found.items()}


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_in_real_time_frames_are_recorded_or_counted_as_missing(rig, tmp_path):
    for name in ("a", "b"):
        rig.create_camera(name, size=(64, 48), fps=50, place="main")
    before = time.time_ns()
    summary = record(rig, tmp_path / "bag", "--cameras", "a,b", "--seconds", 2, "--clock", "wall")
    after = time.time_ns()
    found = messages(tmp_path / "bag")
    stamps = {name: [stamp_ns(m.header) for m in found[f"/{name}/camera_info"]] for name in ("a", "b")}
    for name, times in stamps.items():
        assert summary["frames"][name] == len(times) > 0
        assert len(times) + summary["missing"][name] == 100  # 2 s at 50 frames/s
        assert times == sorted(set(times)) and before <= times[0] and times[-1] <= after
    # Where both have a frame of an instant, the stamp is the same to the nanosecond: others are half a period apart.
    both = sorted(stamps["a"] + stamps["b"])
    assert all(step == 0 or step > 10_000_000 for step in np.diff(both))


@pytest.mark.camrig(**MINIMAL)
def test_a_camera_that_goes_or_changes_its_size_ends_no_recording(rig, tmp_path, programs):
    kept = rig.create_camera("kept", size=(64, 48), fps=10, place="main")
    gone = rig.create_camera("gone", size=(64, 48), fps=10, place="main")
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    recorder = programs(command(rig, "ros2", "record", tmp_path / "bag", "--cameras", "kept,gone", "--follow", "--seconds", 0.6), env=environment)
    wait_until(lambda: kept.get()["readers"] == gone.get()["readers"] == 1, what="the recorder's streams")
    rig.step(seconds=0.2)
    wait_for_pictures(tmp_path / "bag", 4)
    gone.delete()
    kept.set(size=(80, 60))
    wait_until(lambda: kept.get()["readers"] == 1, what="the recorder's new stream")
    rig.step(seconds=0.4)
    assert recorder.wait(60) == 0
    found = messages(tmp_path / "bag")
    infos = found["/kept/camera_info"]
    assert [stamp_ns(m.header) for m in infos] == [n * 10**8 for n in range(1, 7)]
    assert [m.width for m in infos] == [64] * 2 + [80] * 4
    assert [stamp_ns(m.header) for m in found["/gone/camera_info"]] == [10**8, 2 * 10**8]


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("options", [("--follow",), ("--follow", "--seconds", 1)])
def test_another_world_ends_a_recording_with_what_came_before(rig, tmp_path, programs, options):
    camera = rig.create_camera("cam", size=(64, 48), fps=10, place="main")
    rig.step(seconds=0.4)
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    recorder = programs(command(rig, "ros2", "record", tmp_path / "bag", "--cameras", "cam", *options), env=environment, stderr=subprocess.PIPE)
    wait_until(lambda: camera.get()["readers"] == 1, what="the recorder's stream")
    rig.step(seconds=0.3)
    wait_for_pictures(tmp_path / "bag", 3)
    rig.load("minimal")
    said = recorder.communicate(timeout=60)[1].decode()
    assert recorder.returncode == 1 and "another world was loaded" in said and len(said.strip().splitlines()) == 1, said
    assert [stamp_ns(m.header) for m in messages(tmp_path / "bag")["/cam/camera_info"]] == [500_000_000, 600_000_000, 700_000_000]


def loads_between_steps(rig, scene) -> bool:
    """Loads another world; False while a step of somebody else is in progress, for which a load is refused."""
    try:
        rig.load(scene)
    except camrig.CamrigError as refused:
        if refused.kind != "unavailable":
            raise
        return False
    return True


@pytest.mark.camrig(**MINIMAL)
@pytest.mark.parametrize("raw", [(), ("--raw",)])
def test_another_world_ends_a_recording_that_steps_it(rig, tmp_path, programs, raw):
    rig.create_camera("cam", size=(64, 48), fps=100, place="main")
    rig.step(seconds=0.4)
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    recorder = programs(command(rig, "ros2", "record", tmp_path / "bag", "--cameras", "cam", "--seconds", 1000, *raw), env=environment, stderr=subprocess.PIPE)
    wait_until(lambda: rig.status()["world_ns"] >= 600_000_000, what="some instants")
    wait_until(lambda: loads_between_steps(rig, "minimal"), what="a moment between two steps of the recorder")
    said = recorder.communicate(timeout=60)[1].decode()
    assert recorder.returncode == 1 and "another world was loaded" in said and len(said.strip().splitlines()) == 1, said
    stamps = [stamp_ns(m.header) for m in next(items for topic, items in messages(tmp_path / "bag").items() if "image_raw" in topic)]
    assert len(stamps) >= 15 and stamps == [410_000_000 + n * 10_000_000 for n in range(len(stamps))]


@pytest.mark.camrig(**MINIMAL)
def test_what_cannot_be_recorded_is_said_and_leaves_nothing(rig, tmp_path):
    bag = tmp_path / "bag"
    assert "--seconds" in record(rig, bag, code=1)
    assert "nobody" in record(rig, bag, "--seconds", 1, "--cameras", "nobody", code=1)
    assert "--split-size" in record(rig, bag, "--seconds", 1, "--split-size", "3x", code=2)
    assert "--raw" in record(rig, bag, "--follow", "--raw", code=1)
    assert not bag.exists()
    bag.mkdir()
    assert "exists" in record(rig, bag, "--seconds", 0.1, code=1)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_the_pipelines_for_gscam2_play(rig, tmp_path):
    rig.create_camera("h264", size=(64, 48), fps=10, place="main")
    rig.create_camera("jpeg", size=(64, 48), fps=10, place="main", outputs=[{"kind": "rtsp", "codec": "mjpeg"}])
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    subprocess.run(command(rig, "ros2", "files", tmp_path), check=True, env=environment, stdout=subprocess.DEVNULL)
    for camera in ("h264", "jpeg"):
        pipeline = yaml.safe_load((tmp_path / "gscam2" / f"{camera}.yaml").read_text())["/**"]["ros__parameters"]["gscam_config"]
        gst_reads(f"{pipeline} ! video/x-raw,format=RGB,width=64,height=48 ! identity eos-after=5 ! fakesink sync=false")


def ros_reads(calibration):
    """What ROS's own C++ parser reads (Debian's camera-calibration-parsers-tools)."""
    out = calibration.with_suffix(".out.yaml")
    subprocess.run(["/usr/lib/camera_calibration_parsers/convert", calibration, out], check=True, capture_output=True)
    return yaml.safe_load(out.read_text())


@pytest.mark.camrig(**MINIMAL)
def test_files_of_a_real_rig_are_read_by_the_parser_of_ros(rig, tmp_path):
    rig.create_camera(
        "cam", size=(64, 48), intrinsics={"fx": 500 / 3, "fy": 167.25, "cx": 31.5, "cy": 23.1}, position=(-5, 0, 2), look_at=(0, 0, 0),
        lens={"model": "equidistant", "coefficients": [-0.01, 0.002, 1e-05, 0.0]},
        outputs=[{"kind": "device", "number": 20}],
    )  # fmt: skip
    environment = dict(os.environ, CAMRIG_PYTHON=sys.executable)
    done = subprocess.run(command(rig, "ros2", "files", tmp_path / "ros"), capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert "camera cam: usb_cam, v4l2_camera, gscam2" in done.stdout
    info, is_set = ros_reads(tmp_path / "ros" / "camera_info" / "cam.yaml"), rig.camera("cam").get()["intrinsics"]
    fx, fy, cx, cy = (is_set[key] for key in ("fx", "fy", "cx", "cy"))
    assert (info["image_width"], info["image_height"], info["camera_name"]) == (64, 48, "cam")
    assert (info["distortion_model"], info["distortion_coefficients"]["data"]) == ("equidistant", [-0.01, 0.002, 1e-05, 0])
    assert info["camera_matrix"]["data"] == [fx, 0, cx, 0, fy, cy, 0, 0, 1] and fx == 500 / 3
    # The same as what `camrig camera calibration` gives.
    printed = subprocess.run(command(rig, "camera", "calibration", "cam"), check=True, capture_output=True, text=True).stdout
    assert yaml.safe_load(printed) == yaml.safe_load((tmp_path / "ros" / "camera_info" / "cam.yaml").read_text())
