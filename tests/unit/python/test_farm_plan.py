"""Plans of `camrig farm`: the table of variants, places in scenes, seeds and names of shards; and how shards are handed out."""

import argparse
import collections
import errno
import hashlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import types
from pathlib import Path

import pytest

from camrig import CamrigError
from camrig.farm.batch import check, export
from camrig.farm.batch import plan as plans
from camrig.farm.batch import record as recording
from camrig.json_checks import Wrong
from camrig.farm.batch import draw
from camrig.farm.batch.draw import _seconds
from camrig.farm.batch.hashing import seed_of
from camrig.farm.batch.pointer import PointerError, assign
from camrig.farm.batch.pools import run_drawer
from camrig.farm.batch.progress import Progress, duration, line
from camrig.farm.batch.record import MAX_LOST, Run, chosen_again
from camrig.farm.batch.scene_file import read_scene, varied, write_varied
from camrig.farm.batch.scratch import scratch
from camrig.farm.batch.shard import Shard
from camrig.farm.batch.store import Differs, Store
from camrig.farm.batch.variants import rows_of
from camrig.farm.own_folder import OwnFolder

SCENE = {"camrig_scene": 1, "lights": [{"name": "sun", "intensity": 1}], "environment": {"exposure": 1}, "models": {"box": {"file": "box.glb"}},
         "cameras": [{"name": "eye", "outputs": [{"kind": "device", "number": 3}]}]}


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Loads a plan beside a scene of its own; `programs` are what takes the place of camrig."""
    (tmp_path / "program").write_bytes(b"camrig")
    (tmp_path / "box.glb").write_bytes(b"a box")
    (tmp_path / "scene.json").write_text(json.dumps(SCENE))
    monkeypatch.setenv("CAMRIG_BIN", str(tmp_path / "program"))

    def load_(**keys):
        (tmp_path / "plan.json").write_text(json.dumps({"camrig_plan": 1, "scene": "scene.json", "seconds": 1, **keys}))
        return plans.load(tmp_path / "plan.json").shards

    return load_


def ids(shards):
    return [shard.id for shard in shards]


def test_a_table_is_the_product_of_its_blocks():
    rows = rows_of([{"rows": [{"scene": "a"}, {"scene": "b"}]}, {"product": {"/x": [1, 2], "/y": [3]}}, {"repeat": 2}], 0)
    assert len(rows) == 2 * 2 * 2 and rows[0] == {"scene": "a", "/x": 1, "/y": 3, "repeat": 0} and rows[-1] == {"scene": "b", "/x": 2, "/y": 3, "repeat": 1}


@pytest.mark.parametrize("way", ["sobol", "latin_hypercube"])
def test_samples_fill_the_space_evenly_and_are_the_same_for_ever(way):
    axes = {"/a": {"min": 0, "max": 16}, "/b": {"min": 1, "max": 10000, "scale": "log"}, "/c": {"choices": ["x", "y"]}, "/n": {"min": 1, "max": 4, "scale": "integer"}}
    rows = rows_of([{way: axes, "count": 16}], 5)
    assert rows == rows_of([{way: axes, "count": 16}], 5) != rows_of([{way: axes, "count": 16}], 6)
    # What sets both apart from random numbers: one point in each sixteenth of every axis.
    assert sorted(int(row["/a"]) for row in rows) == list(range(16))
    assert collections.Counter(row["/c"] for row in rows) == {"x": 8, "y": 8}
    assert collections.Counter(row["/n"] for row in rows) == {1: 4, 2: 4, 3: 4, 4: 4}
    assert sum(row["/b"] < 100 for row in rows) == 8


def test_sobols_numbers_are_those_that_were_published_with_a_plan():
    (first, *_) = rows_of([{"sobol": {"/a": {"min": 0, "max": 1}, "/b": {"min": 0, "max": 1}}, "count": 3}], 1)
    assert first == {"/a": 0.136890861206, "/b": 0.239965141751}  # another version of scipy that gave others would make other data sets


@pytest.mark.parametrize("blocks, said", [
    ([{"sobol": {"/a": {"min": 0, "max": 1}}}], "vary[0].count: goes with"),
    ([{"product": {"/a": []}}], "vary[0].product./a: must be a list of 1 to"),
    ([{"product": {"/a": [1]}}, {"rows": [{"/a": 2}]}], "vary[1]: '/a' is varied by an earlier block"),
    ([{"product": {"/a": [1, 2]}}, {"rows": [{"/b": 1}, {"/a": 9}]}], "vary[1]: '/a' is varied by an earlier block"),
    ([{"latin_hypercube": {"/a": {"min": 2, "max": 1}}, "count": 2}], "vary[0].latin_hypercube./a.max: must be over min"),
    ([{"sobol": {"/a": {"min": 0, "max": 1, "scale": "log"}}, "count": 2}], "vary[0].sobol./a.min: must be over 0"),
    ([{"product": {"/a": list(range(1000)), "/b": list(range(1000))}}], "makes 1000000 variants; at most"),
    ([{"repeat": 1, "rows": []}], "vary[0]: must have one of"),
    ([{"repeats": 1}], "vary[0].repeats: is unknown; known:"),
])
def test_what_is_wrong_with_a_table_is_told_with_its_place(blocks, said):
    with pytest.raises(Wrong) as caught:
        rows_of(blocks, 0)
    assert said in str(caught.value)


def test_places_are_found_by_number_and_by_name():
    document = {"lights": [{"name": "sun", "intensity": 1}, {"name": "lamp"}], "a/b": {}}
    assign(document, "/lights/lamp/intensity", 5)
    assign(document, "/lights/0/intensity", 2)
    assign(document, "/lights/-", {"name": "new"})
    assign(document, "/a~1b/c", 7)
    assert document == {"lights": [{"name": "sun", "intensity": 2}, {"name": "lamp", "intensity": 5}, {"name": "new"}], "a/b": {"c": 7}}
    for wrong, said in (("/lights/moon/intensity", "no /lights/moon; there are sun, lamp, new"), ("/light/0", "no /light; there are a/b, lights"),
                        ("/lights/sun/name/x", "has a text at"), ("/lights/3", "no /lights/3")):
        with pytest.raises(PointerError) as caught:
            assign(document, wrong, 1)
        assert said in str(caught.value)


def test_a_scene_on_a_base_is_drawn_with_what_its_plan_and_its_base_say(load, tmp_path):
    (tmp_path / "high.json").write_text(json.dumps({"base": "scene.json", "environment": {"exposure": 2}}))
    told = dict(scene="high.json", cameras=[{"name": "top"}], set={"/lights/sun/intensity": 4})
    (shard,) = load(**told)
    made = varied(read_scene(shard.scene), shard.cameras, shard.changes)
    assert made == {**SCENE, "environment": {"exposure": 2}, "lights": [{"name": "sun", "intensity": 4}], "cameras": [{"name": "top"}]}
    (tmp_path / "scene.light").write_bytes(b"baked")
    (lit,) = load(**told)
    write_varied(shard.scene, made, tmp_path / "made")
    assert (tmp_path / "made" / "high.light").read_bytes() == b"baked"
    (tmp_path / "scene.json").write_text(json.dumps({**SCENE, "fog": 1}))
    (other,) = load(**told)
    assert len({shard.id, lit.id, other.id}) == 3, "what decides how a shard is drawn is in its name"


def test_daylight_that_comes_takes_the_place_of_the_scenes_own_light(load):
    scene = {**SCENE, "environment": {"ambient": {"sky": [1, 1, 1]}, "background": [0, 0, 1], "exposure": 1}}
    day = {"/environment/daylight": {"azimuth_deg": 0, "elevation_deg": 30}}
    assert varied(scene, None, day)["environment"] == {"exposure": 1, "daylight": day["/environment/daylight"]}
    # What a plan says is left to the rig, which says what is wrong with it.
    said = varied(scene, None, {**day, "/environment/ambient/sky": [0, 0, 0], "/environment/background": [1, 0, 0]})["environment"]
    assert said["ambient"] == {"sky": [0, 0, 0]} and said["background"] == [1, 0, 0]
    assert varied(scene, None, {"/environment/exposure": 2})["environment"] == {**scene["environment"], "exposure": 2}


def test_chance_changes_the_scene_as_the_plan_has_it(load, tmp_path):
    (one,) = load(seed=3, randomize=["light"])
    (other,) = load(seed=3, randomize=["light"], set={"/environment/lux": 50000})
    assert other.changes["/environment/exposure"] == pytest.approx(one.changes["/environment/exposure"] / 2), "white is drawn as white at half the light"
    (tmp_path / "scene.json").write_text(json.dumps({key: value for key, value in SCENE.items() if key != "environment"}))
    (bare,) = load(seed=3, randomize=["light"])
    assert varied(read_scene(bare.scene), None, bare.changes)["environment"]["daylight"] == one.changes["/environment/daylight"]


def test_models_of_a_shipped_base_and_files_with_escaped_names_are_in_the_name(load, tmp_path, monkeypatch):
    monkeypatch.setenv("CAMRIG_SCENES", str(tmp_path / "shipped"))
    (tmp_path / "shipped" / "low").mkdir(parents=True)
    (tmp_path / "shipped" / "low.json").write_text(json.dumps({**SCENE, "models": {"own": {"file": "low/own.glb"}, "anna": {"file": "camrig:low/anna"}}}))
    (tmp_path / "scene.json").write_text(json.dumps({"base": "camrig:low", "models": {"box": {"file": "box.gltf"}}}))
    (tmp_path / "box.gltf").write_text(json.dumps({"images": [{"uri": "my%20wood.png"}, {"uri": "plain.png"}, {"uri": "%00"}, {"uri": "x" * 999}]}))
    names = {load()[0].id}
    for file in ("shipped/low/own.glb", "shipped/low/anna.glb", "my wood.png", "plain.png"):
        (tmp_path / file).write_bytes(b"something")
        names.add(load()[0].id)
    assert len(names) == 5


def test_a_shard_of_any_world_time_is_reached_by_steps_that_the_rig_takes(load, monkeypatch, tmp_path):
    class World:
        now_ns, steps, recorded = 0, [], []

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def status(self):
            return {"world_ns": self.now_ns, "state_hash": str(self.now_ns)}

        def step(self, *, nanoseconds, timeout):
            assert 0 < nanoseconds <= 86400 * 10**9, "as world.step has it"
            self.now_ns += nanoseconds
            self.steps.append(nanoseconds)

        def record(self, to, *, seconds, **_):
            self.recorded.append(self.now_ns)
            self.now_ns += 10**9  # the last due frame

    world = World()
    monkeypatch.setattr(draw.launch, "start", lambda *_, **__: world)
    (shard,) = load(start_s=200_000, seconds=100_000)
    told = draw._record(shard, tmp_path / "scene.json", tmp_path / "set", 1)
    assert told["state_hash"] == ["200000000000000", "300000000000000"] and world.recorded == [200_000 * 10**9]
    assert len(world.steps) == 3 + 2
    assert draw._go_to(world, world.now_ns, 1) is None and len(world.steps) == 5


def test_a_plan_is_cut_into_shards_that_leave_no_gap(load):
    shards = load(seconds=1, start_s=0.5, shard_seconds=0.3)
    assert [(shard.start_ns, shard.end_ns) for shard in shards] == [(500_000_000, 800_000_000), (800_000_000, 1_100_000_000), (1_100_000_000, 1_400_000_000),
                                                                    (1_400_000_000, 1_500_000_000)]
    assert len({shard.seed for shard in shards}) == 1 and len(set(ids(shards))) == 4
    assert Shard.from_json(json.loads(json.dumps(shards[1].to_json()))).id == shards[1].id


def test_rows_keep_their_seeds_and_names_when_a_plan_grows(load):
    few = load(vary=[{"product": {"/environment/exposure": [1, 2]}}])
    more = load(vary=[{"product": {"/environment/exposure": [3, 2, 1]}}])
    assert set(ids(few)) < set(ids(more)) and len({shard.seed for shard in more}) == 3
    assert not set(ids(few)) & set(ids(load(vary=[{"product": {"/environment/exposure": [1, 2]}}], master_seed=1)))


def test_whatever_changes_the_frames_changes_the_name(load, tmp_path):
    names = {load()[0].id, load(quality="fast")[0].id, load(pictures={"masks": True})[0].id, load(faults=[{"camera": "eye", "kind": "black"}])[0].id,
             load(set={"/environment/exposure": 2})[0].id, load(start_s=1)[0].id, load(seed=3)[0].id, load(cameras=[{"name": "other"}])[0].id}
    (tmp_path / "box.glb").write_bytes(b"another box")
    names.add(load()[0].id)
    (tmp_path / "scene.light").write_bytes(b"its light")
    names.add(load()[0].id)
    (tmp_path / "program").write_bytes(b"camrig, another build")
    names.add(load()[0].id)
    assert len(names) == 11


@pytest.mark.parametrize("keys, said", [
    ({"camera": []}, "plan.json: camera: is unknown; known:"),
    ({"pictures": {"format": "gif"}}, "plan.json: pictures.format: must be one of png, jpeg"),
    ({"pictures": {"mask": True}}, "plan.json: pictures.mask: is unknown"),
    ({"set": {"exposure": 1}}, "plan.json: set.exposure: must be a place in the scene"),
    ({"set": {"/lights/moon/intensity": 1}}, "plan.json: variant 0: /lights/moon/intensity: the scene has no /lights/moon; there are sun"),
    ({"randomize": ["light"], "set": {"/lights/moon/intensity": 1}}, "plan.json: variant 0: /lights/moon/intensity: the scene has no /lights/moon; there are sun"),
    ({"vary": [{"product": {"qualty": ["fast"]}}]}, "plan.json: vary: 'qualty' is neither a place"),
    ({"vary": [{"product": {"quality": ["fast", "best"]}}]}, "plan.json: variant 1: quality: must be one of"),
    ({"vary": [{"rows": [{"/environment/exposure": 1}, {"/environment/exposure": 1}]}]}, "plan.json: vary: variants 0 and 1 are the same"),
    ({"seed": 3, "vary": [{"repeat": 3}]}, "plan.json: vary: variants 0 and 1 are the same; a fixed seed makes repeats the same"),
    ({"seconds": -1}, "plan.json: variant 0: seconds: must be 0"),
    ({"cameras": []}, "plan.json: variant 0: cameras: must be a list of 1"),
    ({"camrig_plan": 2}, "plan.json: camrig_plan: must be 1"),
    ({"scene": "nowhere.json"}, "nowhere.json: No such file"),
])
def test_what_is_wrong_with_a_plan_is_told_with_its_place(load, keys, said):
    with pytest.raises(CamrigError) as caught:
        load(**keys)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_seeds_depend_on_names_alone():
    assert seed_of(1, "a") == seed_of(1, "a") != seed_of("1", "a") and 0 <= seed_of(2) < 2**53
    assert len({seed_of(0, "row", number) for number in range(10_000)}) == 10_000


def test_seconds_for_the_recorder_are_exactly_the_nanoseconds():
    for nanoseconds in (1_000_000, 570_000_000, 290_000_000, 1_100_000_000, 123_456_789, 10**15 + 7):
        assert int(_seconds(nanoseconds) * 1e9) == nanoseconds


class Pool:
    """Answers by the name of a shard, out of a list for each; then draws."""

    slots = 3

    def __init__(self, store, answers):
        self._store, self._answers, self.jobs, self.drawn = store, answers, [], []

    def submit(self, name, job):
        self.jobs.append(name)
        assert len(self.jobs) <= self.slots

    def finished(self, timeout_s):
        name = self.jobs.pop(0)
        self.drawn.append(name)
        if self._answers.get(name):
            return [(name, {"error": self._answers[name].pop(0)})]
        return [(name, {"told": self._store.publish(name, lambda file: told(file, name)) if "#" not in name else {"frames": 1}})]

    def close(self):
        pass


def told(file, name, data=b"frames"):
    file.write(data)
    return {"shard": name, "bytes": len(data), "sha256": str(data), "frames": 1}


@pytest.fixture
def run(load, tmp_path):
    """Hands out 5 shards with those answers; gives the run, the pool and the shards' names."""
    shards = load(vary=[{"repeat": 5}])
    store = Store(tmp_path / "set")

    def run_(answers=lambda names: {}, verify=0.0, max_failed=20):
        options = argparse.Namespace(verify=verify, max_retries=2, max_failed=max_failed, timeout_s=1)
        with store.held({"version": "1", "program": "x"}, {}, ids(shards)):
            run = Run(store, shards, options)
            pool = Pool(store, answers(ids(shards)))
            run.run(pool)
        return run, pool, ids(shards)

    run_.store = store
    return run_


def failing(kind, count):
    return [{"kind": kind, "text": "it did not work"}] * count


def test_what_is_there_is_not_drawn_again(run):
    first, pool, names = run()
    assert sorted(pool.drawn) == sorted(names) and first.drawn == first.frames == 5
    second, pool, _ = run()
    assert pool.drawn == [] and second.drawn == 0
    run.store.shard_path(names[2]).write_bytes(b"cut")  # not as long as it should be
    assert run()[1].drawn == [names[2]]


def test_a_shard_that_fails_is_tried_again_and_then_listed(run):
    done, pool, names = run(lambda names: {names[1]: failing("shard", 2), names[3]: failing("shard", 99)})
    assert collections.Counter(pool.drawn) == {names[0]: 1, names[1]: 3, names[2]: 1, names[3]: 3, names[4]: 1}
    (failed,) = done.failed
    assert failed["shard"] == names[3] and failed["error"] == "it did not work" and failed["tries"] == 3


def test_killed_workers_are_borne_longer_but_not_for_ever(run):
    done, pool, names = run(lambda names: {names[0]: failing("lost", MAX_LOST), names[1]: failing("lost", MAX_LOST + 1)})
    assert [one["shard"] for one in done.failed] == [names[1]] and pool.drawn.count(names[0]) == MAX_LOST + 1


@pytest.mark.parametrize("kind, said", [("disk", "0 of 5 shards are there, whole: make room"), ("machine", "it did not work"), ("differs", "it did not work")])
def test_what_no_retry_helps_against_ends_the_run(run, kind, said):
    with pytest.raises(CamrigError, match=said):
        run(lambda names: {names[0]: failing(kind, 1)})


def test_a_run_in_which_all_fails_ends_early(run):
    with pytest.raises(CamrigError, match="more than 1 shards failed"):
        run(lambda names: {name: failing("shard", 99) for name in names}, max_failed=1)


def test_some_shards_are_drawn_twice(run):
    done, pool, names = run(verify=0.4)
    again = chosen_again(names, 0.4)
    assert done.compared == len(again) == 2 and {name.partition("#")[0] for name in pool.drawn if "#" in name} == again
    assert len(chosen_again(names, 0.001)) == 1 and not chosen_again(names, 0)


def test_a_shard_that_comes_out_otherwise_is_not_taken(run):
    names = run()[2]
    assert run.store.publish(names[0], lambda file: told(file, names[0]))["frames"] == 1  # the same: it stays
    with pytest.raises(Differs, match="drawn twice, it came out as"):
        run.store.publish(names[0], lambda file: told(file, names[0], b"others"))
    with pytest.raises(Differs):
        run.store.compare(names[0], lambda file: told(file, names[0], b"others"))
    assert run.store.shard_path(names[0]).read_bytes() == b"frames" and not list(run.store.shards.glob("*.part"))


def test_a_folder_takes_one_build_one_plan_and_one_run_at_a_time(tmp_path):
    store, mine = Store(tmp_path / "set"), {"version": "1", "program": "x"}
    with store.held(mine, {}, ["a"]):
        store.publish("a", lambda file: told(file, "a"))
        with pytest.raises(CamrigError, match="another camrig farm record draws into it"), Store(tmp_path / "set").held(mine, {}, ["a"]):
            pass
    for others, names, said in (({"version": "1", "program": "y"}, ["a"], "another build of camrig"), (mine, ["b"], "holds 1 shards that this plan has not, as a.tar")):
        with pytest.raises(CamrigError, match=said), store.held(others, {}, names):
            pass
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "photo.jpg").touch()
    with pytest.raises(CamrigError, match="holds photo.jpg; give another folder"), Store(tmp_path / "mine").held(mine, {}, ["a"]):
        pass


def sound(file, name):
    """A shard of no frames that a check finds as its manifest says."""
    data = bytes(1024)
    return {**told(file, name, data), "sha256": hashlib.sha256(data).hexdigest(), "seed": 1, "pictures": {"yolo": False}, "picture_suffix": ".png",
            "cameras": [{"name": "eye", "frames": 0, "files": {}}]}


def test_a_check_finds_a_byte_and_a_manifest_of_paths_is_refused(tmp_path):
    store, name = Store(tmp_path / "set"), "0123456789abcdef"
    with store.held({}, {}, [name]):
        store.publish(name, lambda file: sound(file, name))
        assert store.write_manifest([name]) == 1
    (line,) = store.manifest()
    assert store.problem_of(line) is None
    for data, said in ((b"\1" + bytes(1023), "other bytes"), (bytes(1023), "1023 bytes, the manifest says 1024")):
        store.shard_path(name).write_bytes(data)
        assert said in store.problem_of(line)
    (eye,) = line["cameras"]
    for wrong in ({**line, "shard": "../../etc/passwd"}, {**line, "cameras": [{**eye, "name": "../x"}]}, {**line, "cameras": [{**eye, "files": {"../y": ""}}]}, [1]):
        (store.folder / "manifest.jsonl").write_text(json.dumps(wrong) + "\n")
        with pytest.raises(CamrigError, match="line 1: .*(must be|is unknown)"):
            list(store.manifest())


def test_a_set_that_a_broken_run_left_is_told_by_who_reads_it(tmp_path, capsys):
    names = [f"{number:016x}" for number in range(4)]
    store = Store(tmp_path / "set")

    def checked():
        code = check.main([str(store.folder), "--json"])
        said = capsys.readouterr()
        assert json.loads(said.out)["problems"] == []
        return code, json.loads(said.out)["lacks"], said.err

    with store.held({}, {}, names):
        for name in names[:2]:
            store.publish(name, lambda file, name=name: sound(file, name))
        store.write_manifest(names)
    assert checked() == (1, "the manifest has 2 of 4 planned shards", f"camrig: {store.folder}: the manifest has 2 of 4 planned shards: run camrig farm record again\n")
    with store.held({}, {}, names):  # killed before it wrote the manifest
        store.publish(names[2], lambda file: sound(file, names[2]))
    assert checked()[:2] == (1, "the manifest has 2 of 4 planned shards, and shards/ has 1 that it has not")
    with pytest.raises(CamrigError, match="give a new folder"):
        export.main([str(store.folder), "--out", str(tmp_path)])
    assert "the manifest has 2 of 4 planned shards, and shards/ has 1 that it has not: run camrig farm record again" in capsys.readouterr().err
    (store.folder / "planned.json").unlink()  # of a camrig that wrote none
    assert checked()[:2] == (1, "shards/ has 1 that the manifest has not")
    with store.held({}, {}, names):
        store.publish(names[3], lambda file: sound(file, names[3]))
        store.write_manifest(names)
    assert checked() == (0, None, "")


def test_the_manifest_is_written_when_there_is_no_room_for_the_list_of_failures(load, tmp_path, monkeypatch):
    def no_room(self, failed):
        raise OSError(errno.ENOSPC, "No space left on device")

    plan = types.SimpleNamespace(shards=load(vary=[{"repeat": 2}]), text={})
    monkeypatch.setattr(recording, "_version", lambda: "1")
    monkeypatch.setattr(recording, "_pool", lambda options: Pool(Store(tmp_path / "set"), {}))
    monkeypatch.setattr(Store, "write_failed", no_room)
    with pytest.raises(OSError, match="No space left"):
        recording.record(plan, argparse.Namespace(out=tmp_path / "set", verify=0.0, max_retries=2, max_failed=20, timeout_s=1))
    assert len((tmp_path / "set" / "manifest.jsonl").read_text().splitlines()) == 2


def test_only_what_a_dead_drawer_left_is_removed(tmp_path, monkeypatch):
    """Not what somebody has called alike, and not what a living one works in."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for name in ("camrig-drawer-mine", "camrig-farm", "camrig-drawer-dead"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").touch()
        os.utime(tmp_path / name, (0, 0))
    (tmp_path / "camrig-drawer-dead" / ".camrig-drawer.lock").touch()
    (tmp_path / "camrig-drawer-link").symlink_to(tmp_path / "camrig-farm")
    with scratch() as first:
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        with scratch() as second:
            assert first.is_dir() and second.is_dir() and tempfile.gettempdir() == str(second)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["camrig-drawer-link", "camrig-drawer-mine", "camrig-farm"]
    assert (tmp_path / "camrig-farm" / "file").exists()


def test_what_a_process_that_was_killed_left_goes_and_what_lives_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    program = ("import os, signal; from camrig.farm.own_folder import OwnFolder; own = OwnFolder('camrig-node-'); (own.path / 'rig.sock').touch(); "
               "print(own.path, flush=True); os.kill(os.getpid(), signal.SIGKILL)")
    killed = subprocess.run([sys.executable, "-c", program], env={**os.environ, "TMPDIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)},
                            capture_output=True, text=True, check=False, timeout=60)
    left = Path(killed.stdout.strip())
    assert killed.returncode == -signal.SIGKILL and left.is_dir()
    mine, other = OwnFolder("camrig-node-"), OwnFolder("camrig-node-")
    assert not left.exists() and mine.path.is_dir() and other.path.is_dir()
    other.close()
    assert not other.path.exists()
    del mine
    assert not list(tmp_path.iterdir())


def test_the_bar_says_rate_and_time_left():
    assert line(100, 40, 500, 2, collections.deque([(10.0, 20, 100), (30.0, 40, 500)])) == " 40 %  40/100 shards  500 frames, 20.0/s  2 failed  58 s left"
    assert [duration(s) for s in (59, 61, 3700)] == ["59 s", "1 min 01 s", "1 h 01 min"]
    out = io.StringIO()
    bar = Progress(10, 0, out)
    bar.show(1, 10, 0)
    assert out.getvalue() == ""  # a file gets a line now and then
    bar.show(10, 100, 0, is_last=True)
    assert out.getvalue().startswith("100 %  10/10 shards  100 frames")


def test_a_drawer_that_is_killed_before_it_takes_its_job_is_lost_and_no_error():
    class Killer(set):
        def add(self, child):
            child.kill()
            child.wait()
            super().add(child)

    running = Killer()
    assert run_drawer({}, running) == {"error": {"kind": "lost", "text": "its process ended by signal 9"}}
    assert not running
