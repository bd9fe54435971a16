"""Actors and events through the control socket."""

import json
import math
import shutil
import time

import pytest

import camrig
from conftest import REPOSITORY, stuck_mjpeg_reader, wait_until

STEP_NS = 20_000_000


def scenario(folder):
    """A hundred people in a square with two blocks, and fifty events that meddle with them."""
    shutil.copy(REPOSITORY / "scenes/minimal/mover.glb", folder / "mover.glb")
    walk = {"type": "wander", "area": "square", "pause_s": 1}
    actors = [
        {"name": f"p{i}", "model": "mover", "class": "person", "position": [1 + 1.9 * (i % 10), 1 + 1.9 * (i // 10), 0], "behaviour": walk}
        for i in range(100)
    ]
    group = {"type": "group", "group": "talkers", "position": [5, 5, 0], "area": "square"}
    events = [{"name": "tick", "when": {"every_s": 1}, "do": [{"action": "user", "data": {"tick": True}}]}]
    for i in range(9):
        events += [
            {"name": f"talk{i}", "when": {"at_s": 1 + i}, "do": [{"action": "behave", "actor": f"p{i}", "behaviour": group}]},
            {"name": f"in{i}", "when": {"enter": "corner", "actor": f"p{i + 10}"}, "do": [{"action": "stop", "actor": f"p{i + 10}"}]},
            {"name": f"on{i}", "when": {"event": f"in{i}", "after_s": 1.5}, "do": [{"action": "start", "actor": f"p{i + 10}"}]},
            {"name": f"met{i}", "when": {"meet": [f"p{i + 20}", f"p{i + 21}"], "distance_m": 3}, "do": [{"action": "behave", "actor": f"p{i + 20}", "behaviour": {"type": "follow", "actor": f"p{i + 40}"}}]},
            {"name": f"spawn{i}", "when": {"at_s": 0.5 + i}, "do": [{"action": "spawn", "actor": {"name": f"q{i}", "model": "mover", "class": "person", "position": [19.3, 19.3, 0], "behaviour": walk}}]},
        ]
    events += [
        {"name": "dark", "when": {"at_s": 2}, "do": [{"action": "light", "light": "sun", "flicker_hz": 5, "seconds": 3}]},
        {"name": "gone", "when": {"at_s": 4}, "do": [{"action": "remove", "actor": "p99"}]},
        {"name": "camera", "when": {"at_s": 3}, "do": [{"action": "camera", "camera": "c", "pose": {"position": [0, 0, 9], "look_at": [9, 9, 0]}}]},
        {"name": "leave", "when": {"leave": "corner"}},
    ]
    assert len(events) == 50
    scene = {
        "camrig_scene": 1,
        "name": "scenario",
        "step_ns": STEP_NS,
        "models": {"mover": {"file": "mover.glb"}},
        "areas": {
            "square": {"points": [[0, 0], [20, 0], [20, 20], [0, 20]], "obstacles": [[[9, 9], [10, 9], [10, 10], [9, 10]]]},
            "corner": {"points": [[0, 0], [7, 0], [7, 7], [0, 7]]},
        },
        "lights": [{"name": "sun", "type": "directional", "direction": [0, 0, -1]}],
        "actors": actors,
        "events": events,
    }
    file = folder / "scenario.json"
    file.write_text(json.dumps(scene))
    return str(file)


def lockstep_hashes(file, steps, sometimes):
    with camrig.start(file, mode="lockstep") as rig:
        hashes = {}
        for step in range(steps):
            sometimes(rig, step)
            status = rig.step(nanoseconds=STEP_NS)
            hashes[status["state_ns"]] = status["state_hash"]
        log = [(e["event"], e["world_ns"]) for e in rig.wait_events(timeout=0)["events"]]
    return hashes, log


def test_the_same_world_whoever_films_it(tmp_path):
    """100 actors and 50 events: three runs in lockstep and one in real time, cameras coming and going, are one."""
    file = scenario(tmp_path)
    seconds = 6

    def no_cameras(rig, step):
        pass

    def one_camera(rig, step):
        if step == 0:
            rig.create_camera("c", size=(64, 48), fps=30, position=(-5, -5, 8), look_at=(10, 10, 0))

    def cameras_come_and_go(rig, step):
        if step % 40 == 0:
            rig.create_camera("c", size=(64, 48), fps=25, position=(-5, -5, 8), look_at=(10, 10, 0)).frame()
        if step % 40 == 30:
            rig.camera("c").delete()

    count = seconds * 10**9 // STEP_NS
    runs = [lockstep_hashes(file, count, sometimes) for sometimes in (no_cameras, one_camera, cameras_come_and_go)]
    assert runs[0] == runs[1] == runs[2]
    hashes, log = runs[0]
    assert len(set(hashes.values())) > count // 2
    assert {"dark", "gone", "camera", "leave", "talk3", "spawn5"} <= {name for name, _ in log}

    with camrig.start(file, mode="realtime") as rig:
        compared = set()
        for i in range(10_000):
            status = rig.status()
            if status["state_ns"] > seconds * 10**9:
                break
            if status["state_ns"]:
                assert status["state_hash"] == hashes[status["state_ns"]], status["state_ns"]
                compared.add(status["state_ns"])
            if i % 7 == 0:
                rig.create_camera(f"r{i}", size=(64, 48), fps=10 + i % 50, position=(0, 0, 5), look_at=(9, 9, 0)).frame()
            if i % 7 == 3 and i > 7:
                rig.cameras()[0].delete()
        assert len(compared) > 5


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_actors_come_change_and_go(rig):
    cam = rig.create_camera("c", size=(160, 120), place="main")
    before = cam.frame().image
    guest = rig.spawn_actor("guest", "mover", object_class="box", position=[-2, 0, 0], yaw_deg=90)
    assert guest["behaviour"] == "stand" and guest["applied_ns"] == 0 and abs(guest["yaw_deg"] - 90) < 1e-9
    rig.step(seconds=0.04)
    assert (cam.frame().image != before).any()
    rig.set_actor("guest", behaviour={"type": "go_to", "position": [-2, 2, 0], "speed": 1})
    rig.step(seconds=4)
    there = next(actor for actor in rig.actors() if actor["name"] == "guest")
    assert there["arrived"] and math.dist(there["position"], [-2, 2, 0]) < 0.1
    rig.remove_actor("guest")
    assert [actor["name"] for actor in rig.actors()] == ["mover"]
    for call in (lambda: rig.remove_actor("guest"), lambda: rig.set_actor("guest", yaw_deg=1), lambda: rig.steer({"guest": {}})):
        with pytest.raises(camrig.CamrigError) as caught:
            call()
        assert caught.value.kind == "not_found"


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_clients_hear_of_events(rig):
    rig.add_event("alarm", {"every_s": 1}, [{"action": "user", "data": {"level": 2}}])
    rig.step(seconds=2.5)
    log = rig.wait_events(timeout=0)
    assert [(e["sequence"], e["event"], e["world_ns"], e["data"]) for e in log["events"]] == [
        (1, "alarm", 10**9, [{"level": 2}]),
        (2, "alarm", 2 * 10**9, [{"level": 2}]),
    ]
    assert (log["last"], log["missed"]) == (2, 0)
    assert rig.wait_events(since=2, timeout=0.05)["events"] == []
    rig.remove_event("alarm")
    assert rig.events() == []
    with pytest.raises(camrig.CamrigError) as caught:
        rig.add_event("a", {"event": "a"})
    assert "no event" in str(caught.value) or "fires itself" in str(caught.value)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_waiting_client_is_told_when_it_happens(rig):
    begin = time.monotonic()
    now_s = rig.status()["world_ns"] / 1e9
    rig.add_event("soon", {"at_s": now_s + 4})
    log = rig.wait_events(timeout=30)
    assert [e["event"] for e in log["events"]] == ["soon"]
    assert time.monotonic() - begin > 0.5


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_an_event_moves_a_camera_and_puts_out_the_light(rig):
    cam = rig.create_camera("c", size=(64, 48), fps=25, place="main")
    rig.add_event("look", {"at_s": 0.1}, [{"action": "camera", "camera": "c", "pose": {"position": [0, -6, 3], "look_at": [0, 0, 0]}}])
    rig.add_event(
        "night",
        {"at_s": 0.5},
        [{"action": "light", "light": "sun", "intensity": 0}, {"action": "environment", "sky": [0, 0, 0], "ground": [0, 0, 0], "background": [0, 0, 0]}],
    )
    rig.step(seconds=0.2)
    assert rig.call("camera.get", name="c")["pose"]["position"] == [0, -6, 3]
    assert cam.frame().image.mean() > 20
    rig.step(seconds=0.4)
    assert cam.frame().image.max() <= 2


def test_the_hall_has_an_abandoned_bag(scenes):
    with camrig.start(str(scenes / "hall.json"), mode="lockstep") as rig:
        rig.step(seconds=29.9)
        bag = next(actor for actor in rig.actors() if actor["name"] == "bag")
        assert bag["attached_to"] == "carla" and bag["position"][2] > 0.02
        rig.step(seconds=8)
        actors = {actor["name"]: actor for actor in rig.actors()}
        assert actors["bag"]["attached_to"] == "" and actors["bag"]["position"][2] == 0
        assert math.dist(actors["bag"]["position"], actors["carla"]["position"]) > 3
        told = [e for e in rig.wait_events(timeout=0)["events"] if e["data"]]
        assert [(e["world_ns"], e["data"][0]["abandoned"]) for e in told] == [(30 * 10**9, "bag")]
        assert not any(e["errors"] for e in rig.wait_events(timeout=0)["events"])


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_stuck_reader_does_not_keep_others_from_the_world(rig):
    """Commands while a step waits for a reader: the next instant is drawn already."""
    import threading

    cam = rig.create_camera("c", size=(1920, 1080), fps=25)
    raw = stuck_mjpeg_reader(cam)
    failures = []

    def step():
        try:
            rig.call("world.step", seconds=5, timeout_s=8)  # a reader that takes nothing for ten is closed
        except camrig.CamrigError as problem:
            failures.append(problem)

    stepping = threading.Thread(target=step, daemon=True)
    stepping.start()
    seen = []

    def stands_still():
        seen.append(rig.status()["world_ns"])
        time.sleep(0.3)
        return len(seen) > 3 and seen[-1] == seen[-2] > 0

    wait_until(stands_still, what="the step to wait for the reader")
    late = rig.create_camera("late", size=(64, 48))
    rig.spawn_actor("guest", "mover")
    assert late.frame().time_ns > 0
    assert stepping.is_alive(), "the step did not wait so long"
    stepping.join()
    assert failures and failures[0].kind == "unavailable"
    raw.close()
    rig.step(seconds=0.1)
