"""`camrig record`: every due frame with labels that agree with the truth, also when the recording is killed in its middle."""

import configparser
import json
import os
import resource
import signal
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

import camrig
import posed_gltf
from conftest import REPOSITORY, wait_until


def journal(folder):
    lines = (folder / "truth.jsonl").read_bytes().split(b"\n")
    return [json.loads(line) for line in lines[:-1]]  # the last is empty, or cut off


def mot_rows(folder):
    text = (folder / "gt" / "gt.txt").read_text()
    return [[float(number) for number in line.split(",")] for line in text.splitlines()]


def kitti_rows(folder, frame):
    return [line.split() for line in (folder / "label_2" / f"{frame:06}.txt").read_text().splitlines()]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Two cameras of different rates, three quarters of a second of the hall."""
    folder = tmp_path_factory.mktemp("recorded") / "set"
    with camrig.start(REPOSITORY / "scenes" / "hall.json", mode="lockstep") as rig:
        for cam in rig.cameras():
            cam.delete()
        fast = rig.create_camera("fast", place="lobby", size=(320, 240), fps=10)
        rig.create_camera("slow", place="gallery", size=(256, 192), fps=4)
        done = rig.record(folder, seconds=0.75)
        picture, truth = fast.frame(), fast.truth()
    return folder, done, picture, truth


def test_instants_that_a_long_exposure_leaves_out_are_no_frames(tmp_path):
    with camrig.start(REPOSITORY / "scenes" / "minimal.json", mode="lockstep") as rig:
        for cam in rig.cameras():
            cam.delete()
        rig.create_camera("slow", place="main", size=(64, 48), fps=10, sensor={"exposure_s": 0.25, "dynamic_framerate": True})
        done = rig.record(tmp_path / "set", seconds=2)
    times = [truth["time_ns"] // 10**6 for truth in journal(tmp_path / "set" / "slow")]
    assert done["frames"] == len(times) >= 6 and [b - a for a, b in zip(times[1:], times[2:])] == [300] * (len(times) - 2)


def test_every_due_frame_of_every_camera_is_there(recorded):
    folder, done, picture, truth = recorded
    assert done["frames"] == 7 + 3 and sorted(done["cameras"]) == ["fast", "slow"]
    assert [t["time_ns"] for t in journal(folder / "fast")] == [n * 100_000_000 for n in range(1, 8)]
    assert [t["time_ns"] for t in journal(folder / "slow")] == [n * 250_000_000 for n in range(1, 4)]
    assert journal(folder / "fast")[-1] == truth
    last = cv2.imread(str(folder / "fast" / "image_2" / "000007.png"))
    np.testing.assert_array_equal(last, picture.image)
    assert not list(folder.rglob("*.XXXXXX")) and not list(folder.rglob("*.part"))


def test_coco_labels_are_the_truth(recorded):
    folder = recorded[0]
    coco = json.loads((folder / "coco.json").read_text())
    images = {image["id"]: image for image in coco["images"]}
    assert len(images) == 10 and len({a["id"] for a in coco["annotations"]}) == len(coco["annotations"])
    categories = {c["id"]: c for c in coco["categories"]}
    assert categories[1]["name"] == "person" and len(categories[1]["keypoints"]) == 17
    for image in images.values():
        assert cv2.imread(str(folder / image["file_name"])).shape[:2] == (image["height"], image["width"])
        truth = journal(folder / image["camera"])[image["frame"] - 1]
        seen = {item["id"]: item for item in truth["objects"] if item["pixels"]}
        mine = [a for a in coco["annotations"] if a["image_id"] == image["id"]]
        assert {a["track_id"] for a in mine} == set(seen)
        for annotation in mine:
            item = seen[annotation["track_id"]]
            assert annotation["bbox"] == item["box"] and annotation["area"] == item["pixels"]
            assert categories[annotation["category_id"]]["name"] == item["class"]
            if "keypoints" in item:
                triples = np.reshape(annotation["keypoints"], (17, 3))
                assert annotation["num_keypoints"] == (triples[:, 2] > 0).sum()
                for (x, y, v), told in zip(triples, item["keypoints"]):
                    assert (x, y, v) == (tuple(told) if told[2] else (0, 0, 0))


@pytest.mark.parametrize("kind", ["bbox", "keypoints"])
def test_cocos_own_tools_read_the_labels_and_score_them_right(recorded, kind):
    """pycocotools, COCO's reference reader: the labels scored against themselves are perfect, moved ones are not."""
    ground = COCO(str(recorded[0] / "coco.json"))
    people = [a for a in ground.loadAnns(ground.getAnnIds(catIds=[1])) if a["num_keypoints"]]
    assert len(people) > 10 and ground.loadCats([1])[0]["name"] == "person"

    def score(shift):
        results = []
        for a in people:
            moved = {"image_id": a["image_id"], "category_id": 1, "score": 1.0}
            if kind == "bbox":
                x, y, w, h = a["bbox"]
                moved["bbox"] = [x + shift * w, y, w, h]
            else:
                points = np.reshape(np.array(a["keypoints"], dtype=float), (17, 3))
                points[:, 0] += shift * a["bbox"][2]
                moved["keypoints"] = points.reshape(-1).tolist()
            results.append(moved)
        run = COCOeval(ground, ground.loadRes(results), kind)
        run.params.catIds = [1]
        run.params.imgIds = sorted({a["image_id"] for a in people})
        run.evaluate()
        run.accumulate()
        run.summarize()
        return run.stats[0]

    perfect = score(0.0)
    assert perfect > 0.99 and score(0.6) < 0.5 * perfect


def test_mot_labels_are_the_truth(recorded):
    folder = recorded[0] / "fast"
    rows = mot_rows(folder)
    truths = journal(folder)
    people = [(frame, item) for frame, truth in enumerate(truths, 1) for item in truth["objects"] if item["class"] == "person"]
    assert len(rows) == len(people) > 20
    for row, (frame, item) in zip(rows, people):
        x, y, w, h = item["box_full"]
        np.testing.assert_allclose(row, [frame, item["id"], x + 1.5, y + 1.5, w, h, 1, 1, item["visible_fraction"]], atol=0.006)
    info = configparser.ConfigParser()
    info.read(folder / "seqinfo.ini")
    assert info["Sequence"]["seqlength"] == "7" and info["Sequence"]["imdir"] == "image_2" and info["Sequence"]["framerate"] == "10"


def test_kitti_boxes_in_space_fall_onto_the_people_in_the_picture(recorded):
    folder = recorded[0] / "fast"
    checked = 0
    for frame, truth in enumerate(journal(folder), 1):
        p2 = next(line for line in (folder / "calib" / f"{frame:06}.txt").read_text().splitlines() if line.startswith("P2:"))
        matrix = np.array(p2.split()[1:], float).reshape(3, 4)
        people = [item for item in truth["objects"] if item["class"] == "person" and item["pixels"]]
        rows = kitti_rows(folder, frame)
        assert len(rows) == len(people)
        for row, item in zip(rows, people):
            assert row[0] == "Pedestrian" and int(row[2]) in (0, 1, 2)
            height, width, length, x, y, z, turn = map(float, row[8:15])
            np.testing.assert_allclose([length, width, height], item["dimensions"], atol=6e-4)
            # The middle of the box, by KITTI's own reading of the line, against the truth's 3D box.
            foot = matrix @ [x, y, z, 1]
            up = np.array(item["center"]) - [0, 0, item["dimensions"][2] / 2]
            np.testing.assert_allclose(foot[:2] / foot[2], posed_gltf.project(truth, up[None])[0], atol=0.2)
            link = posed_gltf.rotation(truth["pose"]["orientation"])
            ahead = np.stack([-link[:, 1], -link[:, 2], link[:, 0]]) @ posed_gltf.rotation(item["orientation"])[:, 0]
            assert abs(np.angle(np.exp(1j * (turn - np.arctan2(-ahead[2], ahead[0]))))) < 1e-3
            checked += 1
    assert checked > 20


def test_calibration_is_read_by_opencv(recorded):
    folder = recorded[0] / "fast"
    truth = journal(folder)[0]
    file = cv2.FileStorage(str(folder / "opencv.yml"), cv2.FILE_STORAGE_READ)
    matrix, k = file.getNode("camera_matrix").mat(), truth["intrinsics"]
    np.testing.assert_array_equal(matrix, [[k["fx"], 0, k["cx"]], [0, k["fy"], k["cy"]], [0, 0, 1]])
    assert file.getNode("distortion_coefficients").mat().shape == (1, 5) and file.getNode("image_width").real() == 320
    assert "distortion_model: plumb_bob" in (folder / "camera_info.yaml").read_text()


def test_a_killed_recording_is_readable_up_to_its_last_frame(tmp_path, programs):
    folder = tmp_path / "set"
    with camrig.start(REPOSITORY / "scenes" / "minimal.json", mode="lockstep") as rig:
        for cam in rig.cameras():
            cam.delete()
        rig.create_camera("a", size=(64, 48), fps=100)
        recorder = programs([camrig.find_binary(), "record", str(folder), "--seconds", "1000000", "--control", rig.info()["control"]])
        try:
            path = folder / "a" / "truth.jsonl"
            wait_until(lambda: recorder.poll() is not None or (path.exists() and path.read_bytes().count(b"\n") >= 30), 120, "30 frames")
        finally:
            recorder.send_signal(signal.SIGKILL)
            recorder.wait()
    truths = journal(folder / "a")
    count = len(truths)
    assert count >= 30 and not (folder / "coco.json").exists()
    assert [t["time_ns"] for t in truths] == [(n + 1) * 10_000_000 for n in range(count)]
    for frame in range(1, count + 1):
        assert cv2.imread(str(folder / "a" / "image_2" / f"{frame:06}.png")).shape == (48, 64, 3)
        kitti_rows(folder / "a", frame)
    (folder / "a" / "truth.jsonl").open("ab").write(b'{"camera": "a", "seq')  # killed in the middle of a line
    repaired = subprocess.run([camrig.find_binary(), "record", str(folder), "--repair", "--json"], capture_output=True, text=True, check=True)
    assert json.loads(repaired.stdout)["frames"] == count
    coco = json.loads((folder / "coco.json").read_text())
    assert len(coco["images"]) == count
    assert all(os.path.exists(folder / image["file_name"]) for image in coco["images"])


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_camera_with_a_clock_is_recorded_when_it_is_due(rig, tmp_path):
    rig.camera("main").set(clock={"phase_ns": 13_000_000, "rate_ppb": 900_000, "trigger_jitter_ns": 5_000_000, "seed": 3})
    rig.create_camera("beside", size=(64, 48), fps=25, place="above")
    assert rig.record(tmp_path / "set", frames=6)["frames"] == 6
    times = {name: [json.loads(line)["time_ns"] for line in (tmp_path / f"set/{name}/truth.jsonl").read_text().splitlines()] for name in ("main", "beside")}
    assert times["beside"] == [40_000_000, 80_000_000, 120_000_000]
    phases = [time_ns % 40_000_000 for time_ns in times["main"]]
    assert len(phases) == 3 and len(set(phases)) == 3 and all(12_900_000 < phase < 18_000_000 for phase in phases)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_running_world_stands_while_it_is_recorded_and_runs_on(rig, tmp_path):
    rig.create_camera("a", size=(64, 48), fps="30000/1001")
    done = rig.record(tmp_path / "set", ["a"], frames=5, format="jpeg")
    assert done["frames"] == 5
    times = [t["time_ns"] for t in journal(tmp_path / "set" / "a")]
    assert np.diff(times).max() <= 33_366_667
    assert cv2.imread(str(tmp_path / "set" / "a" / "image_2" / "000005.jpg")).shape == (48, 64, 3)
    info = configparser.ConfigParser()
    info.read(tmp_path / "set" / "a" / "seqinfo.ini")
    assert float(info["Sequence"]["framerate"]) == pytest.approx(29.97, abs=1e-3)
    assert rig.status()["paused"] is False


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_recording_says_what_is_wrong(rig, tmp_path):
    cam = rig.create_camera("a", size=(64, 48), fps=30)
    with pytest.raises(camrig.CamrigError, match="no camera 'nobody'"):
        rig.record(tmp_path / "one", ["nobody"], frames=1)
    assert not (tmp_path / "one").exists()
    rig.record(tmp_path / "two", [cam], frames=1)
    with pytest.raises(camrig.CamrigError, match="holds a data set"):
        rig.record(tmp_path / "two", [cam], frames=1)
    with pytest.raises(camrig.CamrigError) as caught:
        rig.record(tmp_path / "three", [cam], frames=0)
    assert caught.value.kind == "invalid_argument"
    (tmp_path / "two" / "a" / "truth.jsonl").write_text('{"camera": "a"}\n')
    other = subprocess.run([camrig.find_binary(), "record", str(tmp_path / "two"), "--repair"], capture_output=True, text=True)
    assert other.returncode == 1 and "truth.jsonl: line 1 is no truth" in other.stderr
    empty = subprocess.run([camrig.find_binary(), "record", str(tmp_path), "--repair"], capture_output=True, text=True)
    assert empty.returncode == 1 and "no data set" in empty.stderr


@pytest.fixture(scope="module")
def rich(tmp_path_factory):
    """One camera with everything that can be asked for, and what it saw last; another with depth as PNG."""
    folder = tmp_path_factory.mktemp("rich")
    with camrig.start(REPOSITORY / "scenes" / "hall.json", mode="lockstep") as rig:
        for cam in rig.cameras():
            cam.delete()
        cam = rig.create_camera("eye", place="lobby", size=(321, 240), fps=10)
        rig.record(folder / "npy", depth="npy", masks=True, yolo=True, frames=2)
        last = rig.grab([cam], ["depth", "instance", "truth"])["eye"]
        rig.record(folder / "png", depth="png", frames=1)
        return folder, last, cam.depth()


def test_depth_is_metres_as_npy_and_millimetres_as_png(rich):
    folder, last, later = rich
    depth = np.load(folder / "npy" / "eye" / "depth" / "000002.npy")
    assert depth.dtype == np.float32
    np.testing.assert_array_equal(depth, last["depth"])
    with Image.open(folder / "png" / "eye" / "depth" / "000001.png") as picture:
        millimetres = np.asarray(picture)
    assert millimetres.dtype == np.uint16 or picture.mode.startswith("I")
    near = later < 65.5
    assert near.mean() > 0.5
    np.testing.assert_allclose(millimetres[near], 1000 * later[near], atol=0.5 + 1e-3)
    assert (millimetres[~np.isfinite(later)] == 0).all()


def test_masks_are_the_instance_picture_for_cocos_own_reader(rich):
    folder, last, _ = rich
    with Image.open(folder / "npy" / "eye" / "instance" / "000002.png") as picture:
        ids = np.asarray(picture).astype(np.uint32)
    np.testing.assert_array_equal(ids, last["instance"])
    coco = COCO(str(folder / "npy" / "coco.json"))
    (image,) = [i for i in coco.dataset["images"] if i["frame"] == 2]
    annotations = coco.loadAnns(coco.getAnnIds(imgIds=[image["id"]]))
    assert {a["track_id"] for a in annotations} == set(np.unique(ids)) - {0} and len(annotations) > 5
    for annotation in annotations:
        np.testing.assert_array_equal(coco.annToMask(annotation) == 1, ids == annotation["track_id"])


def test_masks_are_had_as_polygons_that_cocos_own_reader_draws_alike(rich):
    folder, last, _ = rich
    subprocess.run([sys.executable, "-m", "camrig.polygons", str(folder / "npy")], check=True, timeout=60)
    exact, outlined = COCO(str(folder / "npy" / "coco.json")), COCO(str(folder / "npy" / "coco_polygons.json"))
    assert exact.anns.keys() == outlined.anns.keys()
    for annotation in exact.anns.values():
        outside = np.ascontiguousarray(np.pad(exact.annToMask(annotation), 1))
        cv2.floodFill(outside, None, (0, 0), 2, flags=4)  # what this does not reach and is not the mask is a hole
        np.testing.assert_array_equal(outlined.annToMask(outlined.anns[annotation["id"]]) == 1, outside[1:-1, 1:-1] != 2)


def test_yolo_labels_are_where_its_trainer_looks_and_are_the_truth(rich):
    folder, last, _ = rich
    description = yaml.safe_load((folder / "npy" / "yolo.yaml").read_text())
    (pictures,) = description["train"]
    picture = (folder / "npy" / pictures / "000002.png").resolve()  # as Ultralytics does
    assert picture.is_file() and (folder / "npy" / "eye" / "image_2" / "000002.png").samefile(picture)
    label = str(picture).replace("/images/", "/labels/").replace(".png", ".txt")  # as Ultralytics finds it
    rows = [line.split() for line in open(label).read().splitlines()]
    seen = [item for item in last["truth"]["objects"] if item["pixels"]]
    assert len(rows) == len(seen) > 5
    for (number, *box), item in zip(rows, seen):
        assert description["names"][int(number)] == item["class"]
        x, y, w, h = np.array(box, float) * [321, 240, 321, 240]
        np.testing.assert_allclose([x - w / 2, y - h / 2, w, h], item["box"], atol=1e-3)


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_recording_that_is_told_to_end_completes_its_labels_and_the_world_runs_on(tmp_path, stop, programs):
    folder = tmp_path / "set"
    with camrig.start(REPOSITORY / "scenes" / "minimal.json", mode="realtime") as rig:
        rig.create_camera("a", size=(64, 48), fps=100)
        recorder = programs([camrig.find_binary(), "record", str(folder), "--cameras", "a", "--seconds", "1000000", "--json",
                             "--control", rig.info()["control"]], stdout=subprocess.PIPE,
                            preexec_fn=lambda: signal.signal(stop, signal.SIG_DFL))  # these tests may run below nohup
        path = folder / "a" / "truth.jsonl"
        wait_until(lambda: recorder.poll() is not None or (path.exists() and path.read_bytes().count(b"\n") >= 3), 60, "3 frames")
        recorder.send_signal(stop)
        said = json.loads(recorder.communicate(timeout=60)[0])
        assert recorder.returncode == 0 and said["frames"] == len(journal(folder / "a")) >= 3
        assert rig.status()["paused"] is False
    assert len(json.loads((folder / "coco.json").read_text())["images"]) == said["frames"]


def test_a_recording_below_nohup_outlives_its_terminal(tmp_path, programs):
    folder = tmp_path / "set"
    with camrig.start(REPOSITORY / "scenes" / "minimal.json", mode="realtime") as rig:
        rig.create_camera("a", size=(64, 48), fps=100)
        recorder = programs(["nohup", camrig.find_binary(), "record", str(folder), "--cameras", "a", "--seconds", "1000000", "--control", rig.info()["control"]],
                            stdout=subprocess.PIPE)
        path = folder / "a" / "truth.jsonl"
        frames = lambda: path.read_bytes().count(b"\n") if path.exists() else 0
        wait_until(lambda: frames() >= 3, 60, "3 frames")
        recorder.send_signal(signal.SIGHUP)
        there = frames()
        wait_until(lambda: frames() >= there + 10, 60, "ten more")
        assert recorder.poll() is None
        recorder.terminate()
        assert recorder.wait(60) == 0


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_recording_that_takes_too_long_is_a_data_set_and_the_world_runs_on(rig, tmp_path):
    rig.create_camera("a", size=(64, 48), fps=100)
    with pytest.raises(camrig.CamrigTimeout, match="what is there is a data set"):
        rig.record(tmp_path / "set", ["a"], seconds=1_000_000, timeout=5.0)  # time for the first frame
    assert rig.status()["paused"] is False
    assert len(json.loads((tmp_path / "set" / "coco.json").read_text())["images"]) == len(journal(tmp_path / "set" / "a"))


def test_a_rig_that_was_reached_by_tcp_is_recorded_here(tmp_path, monkeypatch):
    """The path of its Unix socket says nothing on another machine."""
    (tmp_path / "token").write_text("a-long-and-secret-token")
    with camrig.start(REPOSITORY / "scenes" / "minimal.json", mode="lockstep", tcp=0, args=["--token-file", str(tmp_path / "token")]) as local:
        port = local.info()["tcp"]
        with camrig.connect(host="127.0.0.1", port=port, token="a-long-and-secret-token") as rig:
            answer = rig.client.call
            monkeypatch.setattr(rig.client, "call", lambda method, params=None, timeout_s=None: (
                {**answer(method, params, timeout_s), "control": "/not/on/this/machine"} if method == "server.info" else answer(method, params, timeout_s)))
            rig.create_camera("a", size=(64, 48))
            assert rig.record(tmp_path / "set", ["a"], frames=2)["frames"] == 2
        with camrig.connect(host="127.0.0.1", http_port=local.info()["http"], token="a-long-and-secret-token") as rig:
            with pytest.raises(camrig.CamrigError, match="not over HTTP"):
                rig.record(tmp_path / "other", ["a"], frames=2)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_full_disk_leaves_whole_frames_and_the_reason(rig, tmp_path):
    """A limit on the size of files stops the journal as a full disk does: in the middle of a line, after a part was written."""
    folder, limit = tmp_path / "set", 15_000
    rig.create_camera("a", size=(64, 48), fps=100)

    def small_disk():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    command = [camrig.find_binary(), "record", str(folder), "--cameras", "a", "--frames", "100", "--control", rig.info()["control"]]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, preexec_fn=small_disk, restore_signals=False, check=False)
    assert done.returncode == 1 and "truth.jsonl: cannot be written: File too large" in done.stderr, done.stderr
    text = (folder / "a" / "truth.jsonl").read_bytes()
    count = text.count(b"\n")
    assert 3 <= count < 100 and text.endswith(b"\n") and len(text) <= limit

    def names(part):
        return sorted(path.name for path in (folder / "a" / part).iterdir())

    def check_frames():
        assert names("image_2") == [f"{n:06}.png" for n in range(1, count + 1)]
        assert names("label_2") == names("calib") == [f"{n:06}.txt" for n in range(1, count + 1)]
        assert {int(row[0]) for row in mot_rows(folder / "a")} <= set(range(1, count + 1))

    check_frames()
    # An older camrig, or a machine that lost its power, leaves this behind.
    with (folder / "a" / "truth.jsonl").open("ab") as cut:
        cut.write(b'{"camera": "a", "seq')
    for part, name in (("image_2", f"{count + 1:06}.png"), ("label_2", f"{count + 1:06}.txt"), ("image_2", f"{count + 2:06}.png.aB3xYz")):
        (folder / "a" / part / name).write_text("half")
    (folder / "a" / "image_2" / "mine.txt").write_text("not a frame")
    repaired = subprocess.run([camrig.find_binary(), "record", str(folder), "--repair", "--json"], capture_output=True, text=True, check=True)
    assert json.loads(repaired.stdout)["frames"] == count
    assert (folder / "a" / "truth.jsonl").read_bytes() == text
    (folder / "a" / "image_2" / "mine.txt").unlink()
    check_frames()
    assert len(json.loads((folder / "coco.json").read_text())["images"]) == count
