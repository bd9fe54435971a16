"""`camrig farm record`: every shard exactly once in effect, whoever is killed; what others read of it is what `camrig record` writes."""

import contextlib
import filecmp
import io
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import webdataset
import yaml
from PIL import Image
from pycocotools.coco import COCO

import camrig
from conftest import REPOSITORY, wait_until

SIZE = (96, 64)
PLAN = {
    "camrig_plan": 1, "master_seed": 3, "scene": "scenes/minimal.json", "quality": "fast", "seconds": 0.6, "shard_seconds": 0.3,
    "cameras": [{"name": "left", "place": "main", "size": SIZE, "fps": 50}, {"name": "top", "place": "above", "size": SIZE, "fps": 20}],
    "pictures": {"format": "png", "masks": True, "yolo": True, "depth": "npy"},
    "vary": [{"rows": [{"/lights/sun/intensity": 0.3, "/cameras/top/quality": "simple"}, {"/lights/sun/intensity": 0.9, "/cameras/top/quality": "fast"}]},
             {"repeat": 2}],
}
SHARDS, FRAMES = 8, 8 * (15 + 6)


def write_plan(folder, **changes):
    path = folder / "sweep.json"
    path.write_text(json.dumps({**PLAN, "scene": str(REPOSITORY / "scenes" / "minimal.json"), **changes}))
    return path


def command(plan, out, *options):
    return [camrig.find_binary(), "farm", "record", str(plan), "--out", str(out), "--json", *map(str, options)]


def record(plan, out, *options, **how):
    return subprocess.run(command(plan, out, *options), capture_output=True, text=True, timeout=300, check=False, **how)


def manifest(folder):
    return [json.loads(line) for line in (folder / "manifest.jsonl").read_text().splitlines()]


def differences(one, other):
    names = {str(path.relative_to(root)) for root in (one, other) for path in root.rglob("*") if path.is_file()}
    return sorted(name for name in names if not ((one / name).is_file() and (other / name).is_file() and filecmp.cmp(one / name, other / name, shallow=False)))


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    """The set of a run that nothing disturbed, and what the run said."""
    folder = tmp_path_factory.mktemp("quiet")
    done = record(write_plan(folder), folder / "set", "--workers", 2)
    assert done.returncode == 0, done.stderr
    return folder / "set", json.loads(done.stdout)


def children(pid):
    """The processes below one and their commands."""
    found = {}
    try:
        for child in Path(f"/proc/{pid}/task").glob("*/children"):
            for below in map(int, child.read_text().split()):
                found[below] = Path(f"/proc/{below}/cmdline").read_bytes().split(b"\0")
                found.update(children(below))
    except OSError:
        pass  # it has ended meanwhile
    return found


def test_a_set_has_every_frame_of_its_plan(quiet):
    folder, said = quiet
    told = manifest(folder)
    assert said["there"] == said["drawn"] == len(told) == SHARDS and said["frames"] == sum(one["frames"] for one in told) == FRAMES
    assert said["compared"] == 1 and said["failed"] == []
    assert sorted(path.name for path in (folder / "shards").iterdir()) == sorted(f"{one['shard']}.{end}" for one in told for end in ("tar", "json"))
    # The world of a variant goes on from shard to shard.
    for first, second in zip(told[::2], told[1::2]):
        assert first["state_hash"][1] == second["state_hash"][0] != second["state_hash"][1]
    checked = subprocess.run([camrig.find_binary(), "farm", "check", str(folder)], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr


def test_whoever_is_killed_the_set_is_the_same(quiet, tmp_path):
    """Drawers, their camrigs and who hands out, each killed in the middle of shards."""
    plan = write_plan(tmp_path)
    kinds = ["record", "drawer", "camrig", "record", "drawer", "camrig"]
    for attempt in range(3):  # where the machine holds us up the run ends before all were killed
        out = tmp_path / f"set{attempt}"
        killed = kill_while_it_draws(plan, out, kinds)
        if killed == kinds:
            break
    assert killed == kinds, "not all were killed; the run was too quick"
    assert differences(quiet[0], out) == []


def kill_while_it_draws(plan, out, kinds):
    """Who was killed until the set was there."""
    chance = random.Random(5)
    due = dict(zip(sorted(chance.sample(range(1, SHARDS), 6)), kinds))
    killed = []
    for _ in range(3):
        with subprocess.Popen(command(plan, out, "--workers", 3), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
            while run.poll() is None:
                done = len(list(out.glob("shards/*.tar")))
                kind = next((kind for count, kind in due.items() if count <= done), None)
                below = children(run.pid)
                victims = [pid for pid, words in below.items() if (b"serve" in words if kind == "camrig" else b"camrig.farm.batch.draw" in words)]
                if kind and victims:
                    with contextlib.suppress(ProcessLookupError):  # it has just ended: another one, next time
                        os.kill(run.pid if kind == "record" else chance.choice(victims), signal.SIGKILL)
                        killed.append(kind)
                        del due[next(iter(due))]
                time.sleep(0.01)
            said = run.communicate()
        if run.returncode != -signal.SIGKILL:
            break
    assert run.returncode == 0, said
    return killed


@pytest.mark.parametrize("killed", ["record", "drawer"])
def test_nobody_draws_on_for_one_that_is_dead(tmp_path, killed):
    """In the middle of a shard of hours."""
    plan = write_plan(tmp_path, seconds=100_000, vary=[])
    plan.write_text(plan.read_text().replace('"shard_seconds": 0.3, ', ""))
    with subprocess.Popen(command(plan, tmp_path / "set", "--workers", 1, "--max-retries", 0), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        try:
            wait_until(lambda: run.poll() is not None or any(b"record" in words and b"--seconds" in words for words in children(run.pid).values()), 60, "a recording")
            assert run.poll() is None
            below = children(run.pid)
            drawer = next(pid for pid, words in below.items() if b"camrig.farm.batch.draw" in words)
            os.kill(run.pid if killed == "record" else drawer, signal.SIGKILL)
            wait_until(lambda: not any(is_running(pid) for pid in below), 20, f"the end of {below}")
        finally:
            run.kill()


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_the_plan_of_the_guide_is_one(tmp_path):
    page = (REPOSITORY / "docs" / "farm-record.md").read_text()
    (tmp_path / "sweep.json").write_text(page.split("```json\n")[1].split("```")[0])
    told = subprocess.run([camrig.find_binary(), "farm", "plan", str(tmp_path / "sweep.json")], capture_output=True, text=True, check=True).stdout.splitlines()
    assert len(told) == 16 * 2 * 3 * 2 and {json.loads(line)["scene"] for line in told} == {"hall"}


def test_what_is_there_is_not_drawn_again_and_a_plan_may_grow(tmp_path):
    plan = write_plan(tmp_path, vary=[{"product": {"/lights/sun/intensity": [0.5]}}], seconds=0.3)
    first = json.loads(record(plan, tmp_path / "set", "--verify", 0).stdout)
    assert first["drawn"] == 1 and first["compared"] == 0
    plan = write_plan(tmp_path, vary=[{"product": {"/lights/sun/intensity": [0.9, 0.5]}}], seconds=0.3)
    second = json.loads(record(plan, tmp_path / "set", "--verify", 0).stdout)
    assert (second["there"], second["drawn"]) == (2, 1)
    refused = record(write_plan(tmp_path, vary=[], seconds=0.3), tmp_path / "set")
    assert refused.returncode == 1 and "holds 2 shards that this plan has not" in refused.stderr


def test_webdataset_reads_the_shards(quiet):
    paths = sorted(str(path) for path in (quiet[0] / "shards").glob("*.tar"))
    samples = list(webdataset.WebDataset(paths, shardshuffle=False).decode("pil"))
    assert len({sample["__key__"] for sample in samples}) == len(samples) == FRAMES
    for sample in samples[::20]:
        assert sample["png"].size == SIZE and tuple(sample["json"]["size"]) == SIZE and "monotonic_ns" not in sample["json"]
        assert np.load(io.BytesIO(sample["depth.npy"])).shape == SIZE[::-1] if isinstance(sample["depth.npy"], bytes) else sample["depth.npy"].shape == SIZE[::-1]
        assert sample["__key__"].split("_")[1] == sample["json"]["camera"]


def test_an_export_is_what_a_recording_would_have_written(quiet, tmp_path):
    """The first shard, recorded by hand: every file of the export is that of the recording, but for the names of sequences and the machine's clock."""
    exported = tmp_path / "exported"
    done = subprocess.run([camrig.find_binary(), "farm", "export", str(quiet[0]), "--out", str(exported), "--format", "yolo", "--json"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["frames"] == FRAMES
    coco = COCO(str(exported / "coco.json"))
    assert len(coco.imgs) == FRAMES and all((exported / image["file_name"]).is_file() for image in coco.imgs.values()) and len(coco.anns) > FRAMES

    told = manifest(quiet[0])[0]
    scene = json.loads((REPOSITORY / "scenes" / "minimal.json").read_text())
    scene["cameras"] = json.loads(json.dumps(PLAN["cameras"]))
    scene["lights"][0]["intensity"] = told["changes"]["/lights/sun/intensity"]
    scene["cameras"][1]["quality"] = told["changes"]["/cameras/top/quality"]
    (tmp_path / "minimal").symlink_to(REPOSITORY / "scenes" / "minimal")
    (tmp_path / "minimal.json").write_text(json.dumps(scene))
    with camrig.start(tmp_path / "minimal.json", mode="lockstep", seed=told["seed"], quality="fast", device="cpu") as rig:
        rig.record(tmp_path / "by_hand", seconds=0.3, depth="npy", masks=True, yolo=True)
    for name in ("left", "top"):
        mine, its = exported / f"{told['shard']}_{name}", tmp_path / "by_hand" / name
        assert differences(mine, its) == ["seqinfo.ini", "truth.jsonl"]
        assert (mine / "seqinfo.ini").read_text() == (its / "seqinfo.ini").read_text().replace(f"name={name}", f"name={mine.name}")
        for line, other in zip((mine / "truth.jsonl").open(), (its / "truth.jsonl").open(), strict=True):
            truth = json.loads(other)
            del truth["monotonic_ns"]
            assert json.loads(line) == truth
    again = tmp_path / "again"
    subprocess.run([camrig.find_binary(), "farm", "export", str(quiet[0]), "--out", str(again)], check=True, capture_output=True)
    assert differences(exported, again) == []


def test_an_export_of_worlds_with_other_classes_names_each_object_right(tmp_path):
    """Each world numbers its classes as it meets them: here they meet the same ones in another order, and one of them meets another one."""
    objects = json.loads((REPOSITORY / "scenes" / "minimal.json").read_text())["objects"]
    renamed = [{**objects[1], "class": "statue"}, objects[0]]
    plan = write_plan(tmp_path, vary=[{"product": {"/objects": [objects, renamed]}}], seconds=0.1)
    assert (done := record(plan, tmp_path / "set", "--verify", 0)).returncode == 0, done.stderr
    exported = tmp_path / "exported"
    subprocess.run([camrig.find_binary(), "farm", "export", str(tmp_path / "set"), "--out", str(exported), "--format", "yolo"], check=True, capture_output=True)

    coco = json.loads((exported / "coco.json").read_text())
    categories = {category["id"]: category["name"] for category in coco["categories"]}
    images = {image["id"]: image for image in coco["images"]}
    names = yaml.safe_load((exported / "yolo.yaml").read_text())["names"]
    assert sorted(names) == list(range(len(names)))  # Ultralytics takes no others
    assert sorted(names.values()) == sorted(categories.values()) == ["box", "ground", "statue"]
    numbers = set()
    for camera in json.loads((exported / "dataset.json").read_text())["cameras"]:
        for frame, line in enumerate((exported / camera / "truth.jsonl").open(), 1):
            truth = json.loads(line)
            numbers.add(json.dumps(truth["classes"]))
            seen = [(item["id"], item["class"]) for item in truth["objects"] if item["pixels"]]
            in_yolo = [names[int(row.split()[0])] for row in (exported / camera / "labels" / f"{frame:06}.txt").read_text().splitlines()]
            assert in_yolo == [name for _, name in seen]
            of_frame = [one for one in coco["annotations"] if (images[one["image_id"]]["camera"], images[one["image_id"]]["frame"]) == (camera, frame)]
            assert [(one["track_id"], categories[one["category_id"]]) for one in of_frame] == seen
    assert len(numbers) == 2


def test_variants_differ_as_the_plan_says(quiet):
    """More sun, brighter pictures."""
    brightness = {}
    for told in manifest(quiet[0])[::2]:
        (sample,) = [one for one in webdataset.WebDataset(str(quiet[0] / "shards" / f"{told['shard']}.tar"), shardshuffle=False) if one["__key__"].endswith("left_000001")]
        brightness.setdefault(told["changes"]["/lights/sun/intensity"], []).append(np.asarray(Image.open(io.BytesIO(sample["png"]))).mean())
    assert len(brightness[0.3]) == len(brightness[0.9]) == 2 and min(brightness[0.9]) > max(brightness[0.3]) + 10
    assert len({told["seed"] for told in manifest(quiet[0])}) == 4


def test_a_shard_that_cannot_be_drawn_is_listed_and_the_others_are_there(tmp_path):
    plan = write_plan(tmp_path, seconds=0.2, vary=[{"rows": [{"faults": []}, {"faults": [{"camera": "left", "kind": "melted"}]}, {"faults": [{"camera": "top", "kind": "black"}]}]}])
    done = record(plan, tmp_path / "set", "--max-retries", 1, "--workers", 2)
    said = json.loads(done.stdout)
    (failed,) = json.loads((tmp_path / "set" / "failed.json").read_text())
    assert done.returncode == 3 and said["there"] == 2 and said["failed"] == [failed["shard"]] and failed["tries"] == 2 and "melted" in failed["error"]
    black = manifest(tmp_path / "set")[1]
    assert black["faults"] == [{"camera": "top", "kind": "black"}]
    pictures = {one["__key__"]: np.asarray(Image.open(io.BytesIO(one["png"]))).max()
                for one in webdataset.WebDataset(str(tmp_path / "set" / "shards" / f"{black['shard']}.tar"), shardshuffle=False)}
    assert {picture > 0 for key, picture in pictures.items() if "_left_" in key} == {True}
    assert {picture > 0 for key, picture in pictures.items() if "_top_" in key} == {False}


def test_a_full_disk_ends_the_run_with_whole_shards_and_the_reason(tmp_path):
    """A limit on the size of files stops the shard as a full disk does; with room the run goes on."""
    plan = write_plan(tmp_path, seconds=0.3, vary=[{"repeat": 2}])

    def small_disk():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    done = record(plan, tmp_path / "set", "--workers", 1, preexec_fn=small_disk, restore_signals=False)
    assert done.returncode == 1 and "File too large" in done.stderr and "0 of 2 shards are there, whole: make room and run this again" in done.stderr, done.stderr
    assert not list((tmp_path / "set").rglob("*.part")) and not list((tmp_path / "set").rglob("*.tar"))
    assert json.loads(record(plan, tmp_path / "set", "--workers", 2, "--verify", 0).stdout)["there"] == 2


def test_another_build_does_not_draw_into_a_set(quiet, tmp_path):
    """A program that differs by a byte behind its end runs as the same, and is another build."""
    other = tmp_path / "camrig"
    other.write_bytes(Path(camrig.find_binary()).read_bytes() + b"\0")
    other.chmod(0o755)
    refused = subprocess.run([sys.executable, "-m", "camrig.farm", "record", str(write_plan(tmp_path)), "--out", str(quiet[0])], capture_output=True, text=True, check=False,
                             env={**os.environ, "CAMRIG_BIN": str(other), "CAMRIG_SCENES": str(REPOSITORY / "scenes"), "PYTHONPATH": str(REPOSITORY / "control" / "python")})
    assert refused.returncode == 1 and "is drawn by another build of camrig" in refused.stderr and refused.stderr.count("\n") == 1
