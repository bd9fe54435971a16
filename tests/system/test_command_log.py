"""Commands at a world time, worlds that are held, and the log that makes a world again."""

import itertools
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import threading
import time

import pytest
from conftest import stuck_mjpeg_reader, wait_until

import camrig

SMALL = {"size": [160, 120], "vfov_deg": 60, "code_strip": True}


def start(scene="hall", **options):
    return camrig.start(scene, device="cpu", **options)


def commands(seed, people=("anna", "ben", "karl"), cameras=4):
    """Random commands that all succeed, in the order in which they are to be sent."""
    chance = random.Random(seed)
    for number in range(cameras):
        pose = {"position": [chance.uniform(2, 20), chance.uniform(2, 12), 2.8], "look_at": [12, 8, 1]}
        yield "camera.create", {"name": f"cam{number}", "fps": chance.choice([5, 10, "30000/1001"]), "pose": pose, **SMALL, "ptz": {"preset": "dome"}}
    for number in itertools.count():
        camera = f"cam{chance.randrange(cameras)}"
        what = chance.randrange(6)
        if what == 0:
            yield "camera.set", {"name": camera, "vfov_deg": chance.uniform(30, 90), "seconds": chance.choice([0, 0.3])}
        elif what == 1:
            yield "ptz.move", {"camera": camera, "mode": "absolute", "pan_deg": chance.uniform(-60, 60), "tilt_deg": chance.uniform(-30, 0)}
        elif what == 2:
            yield "fault.set", {"camera": camera, "kind": "noise", "severity": chance.random()}
        elif what == 3:
            name = f"guest{number}"
            yield "actor.spawn", {"name": name, "model": "person_1", "class": "person", "position": [chance.uniform(10, 14), chance.uniform(6, 9), 0],
                                  "behaviour": {"type": "go_to", "position": [22, 7.2, 0], "clip": "walk"}}
        elif what == 4:
            yield "actor.steer", {"actors": [{"name": chance.choice(people), "velocity": [chance.uniform(-1, 1), chance.uniform(-1, 1), 0]}]}
        else:
            yield "camera.set", {"name": camera, "fps": chance.choice([5, 8, 10])}


def people_of(rig):
    return [actor["name"] for actor in rig.call("actor.list")["actors"][:3]]


def pictures(rig):
    """The bytes of every camera's newest picture, by its time and number."""
    return {camera.name: (frame.time_ns, frame.sequence, frame.image.tobytes()) for camera in rig.cameras() for frame in [camera.frame()]}


def digest(rig, **params):
    return rig.call("world.digest", **params)


def test_a_command_is_done_at_its_world_time():
    with start(mode="lockstep") as rig:
        rig.call("camera.create", name="cam", fps=10, **SMALL)
        later = rig.client
        answers = {}

        def send():
            answers["camera.set"] = later.call("camera.set", {"name": "cam", "vfov_deg": 40, "at_ns": 250_000_000})

        waiting = threading.Thread(target=send, daemon=True)
        waiting.start()
        wait_until(lambda: digest(rig)["world_ns"] == 0 and rig.call("server.info")["calls"]["camera.set"] == 1)
        rig.step(seconds=0.2)
        assert rig.call("camera.get", name="cam")["vfov_deg"] == pytest.approx(60)
        assert waiting.is_alive()
        rig.step(seconds=0.2)
        waiting.join(5)
        assert not waiting.is_alive() and rig.call("camera.get", name="cam")["vfov_deg"] == pytest.approx(40)
        assert answers["camera.set"]["applied_ns"] <= 250_000_000
        with pytest.raises(camrig.CamrigError, match="at_ns: 100000000 is past; world time is 400000000 ns"):
            rig.call("camera.set", name="cam", vfov_deg=50, at_ns=100_000_000)
        with pytest.raises(camrig.CamrigError, match="more than an hour ahead"):
            rig.call("camera.set", name="cam", vfov_deg=50, at_ns=2 * 3600 * 10**9)
        with pytest.raises(camrig.CamrigError, match="at_ns: must be a world time"):
            rig.call("camera.set", name="cam", vfov_deg=50, at_ns=-1)


def test_steps_of_any_length_and_commands_in_between_give_one_world():
    """Commands at given times, in one long step or in many short ones: the same hash, the same pictures."""

    def run(steps):
        with start(mode="lockstep") as rig:
            people = people_of(rig)
            line = list(itertools.islice(commands(3, people), 16))
            senders = []
            for number, (method, params) in enumerate(line):
                at_ns = 0 if number < 4 else 20_000_000 * (number - 3) + 7
                senders.append(threading.Thread(target=rig.client.call, args=(method, {**params, "at_ns": at_ns}), daemon=True))
                senders[-1].start()
                # One after the other: those of one time are done in the order in which they come.
                wait_until(lambda: sum(rig.call("server.info")["calls"][name] for name in {each for each, _ in line}) == number + 1)
            for nanoseconds in steps:
                rig.step(nanoseconds=nanoseconds)
            for sender in senders:
                sender.join(5)
            return digest(rig)["hash"], pictures(rig)

    one, many = run([600_000_000]), run([50_000_000] * 12)
    assert one == many


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_log_makes_the_same_world_again(tmp_path, mode):
    log = tmp_path / "commands.log"
    with start(mode=mode, args=["--log", str(log)]) as rig:
        for method, params in itertools.islice(commands(5, people_of(rig)), 24):
            rig.call(method, **params)
            rig.step(seconds=0.05) if mode == "lockstep" else time.sleep(0.02)
        if mode == "lockstep":
            before = digest(rig), pictures(rig)
        else:
            world_ns = rig.status()["world_ns"]
            before = digest(rig, at_ns=world_ns + 6_000_000_000), None  # time for the next rig to be asked
    lines = log.read_text().splitlines()
    assert json.loads(lines[0])["camrig_log"] == 1 and len(lines) > 24
    with start(mode=mode, args=["--replay", str(log)]) as rig:
        if mode == "lockstep":
            after = digest(rig), pictures(rig)
        else:
            after = digest(rig, at_ns=before[0]["world_ns"]), None
    # The log's own text is not kept in a rig without a log.
    for told in (before[0], after[0]):
        for key in ("commands", "command_count", "hash"):
            told.pop(key)
    assert after == before


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_saved_world_is_restored_and_compared(tmp_path, mode):
    log = tmp_path / "commands.log"
    with start(mode=mode, args=["--log", str(log)]) as rig:
        people = people_of(rig)
        line = commands(6, people)
        for method, params in itertools.islice(line, 12):
            rig.call(method, **params)
            rig.step(seconds=0.05) if mode == "lockstep" else time.sleep(0.02)
        saved = rig.save("before")
        assert saved["file"] == f"{log}.before.save" and saved["command_count"] == 12
        shown = pictures(rig) if mode == "lockstep" else None
        with pytest.raises(camrig.CamrigError, match="is there already"):
            rig.save("before")
        with pytest.raises(camrig.CamrigError, match="is not a name"):
            rig.save("../before")
        # What comes afterwards is not in it.
        for method, params in itertools.islice(line, 5):
            rig.call(method, **params)
    file = tmp_path / "commands.log.before.save"
    with start(mode=mode, args=["--replay", str(file), "--log", str(tmp_path / "branch.log")]) as rig:
        assert digest(rig)["command_count"] == 12 and rig.status()["world_ns"] >= saved["world_ns"]
        if mode == "lockstep":
            assert digest(rig)["hash"] == saved["hash"] and pictures(rig) == shown
        rig.call("camera.set", name="cam0", vfov_deg=50)  # a branch goes on, without the line of the save
    with start(mode=mode, args=["--replay", str(tmp_path / "branch.log")]) as rig:
        assert digest(rig)["command_count"] == 13
    lines = file.read_text().splitlines()
    told = json.loads(lines[-1])
    file.write_text("\n".join([*lines[:-1], json.dumps({**told, "hash": "0123456789abcdef"})]) + "\n")
    with pytest.raises(camrig.CamrigError, match="is not the world that was saved.*0123456789abcdef"):
        start(mode=mode, args=["--replay", str(file)])
    file.write_text("\n".join([*lines, lines[-2]]) + "\n")
    with pytest.raises(camrig.CamrigError, match=f"line {len(lines) + 1}: nothing comes behind"):
        start(mode=mode, args=["--replay", str(file)])


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_rig_that_does_again_what_was_done_can_be_ended(tmp_path, number):
    log = tmp_path / "long.log"
    with start("minimal", mode="lockstep", args=["--log", str(log)]) as rig:
        rig.create_camera("eye", size=(640, 480), fps=100, place="main")
        rig.step(seconds=1)
        rig.call("camera.set", name="eye", fps=99)
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    lines[-1]["at_ns"] = 36_000_000_000_000  # ten hours later
    log.write_text("".join(json.dumps(line) + "\n" for line in lines))
    control = tmp_path / "rig.sock"
    process = subprocess.Popen([camrig.find_binary(), "--control", str(control), "serve", "minimal", "--mode", "lockstep", "--device", "cpu", "--http", "0", "--rtsp", "0",
                                "--replay", str(log)], stderr=subprocess.PIPE, text=True, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))  # fmt: skip
    time.sleep(3)  # it is at it, and if not, what is asked for is the same
    assert process.poll() is None
    process.send_signal(number)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 1 and "--replay" in said and "was ended" in said
    assert list(tmp_path.iterdir()) == [log]


def test_a_rig_without_a_log_saves_nothing():
    with start("minimal", mode="lockstep") as rig, pytest.raises(camrig.CamrigError, match="keeps no log"):
        rig.save("it")


def test_after_kill_9_the_log_goes_on_where_it_ended(tmp_path):
    log = tmp_path / "commands.log"
    rig = start(mode="lockstep", args=["--log", str(log)])
    line = commands(6, people_of(rig))
    try:
        for method, params in itertools.islice(line, 12):
            rig.call(method, **params)
            rig.step(seconds=0.05)
        before, seen = digest(rig), pictures(rig)
        os.kill(rig.call("server.info")["pid"], signal.SIGKILL)
    finally:
        with pytest.raises(camrig.CamrigError):
            rig.close()
    with log.open("ab") as file:
        file.write(b'{"at_ns":600000000,"method":"camera.set","par')  # cut off
    with start(mode="lockstep", args=["--log", str(log), "--replay", str(log)]) as rig:
        assert digest(rig) == before and pictures(rig) == seen
        rig.call("camera.set", name="cam0", vfov_deg=33)
        rig.step(seconds=0.1)
        before = digest(rig)
    with start(mode="lockstep", args=["--replay", str(log), "--log", str(tmp_path / "copy.log")]) as rig:
        assert digest(rig) == before
    assert (tmp_path / "copy.log").read_bytes() == log.read_bytes()


def test_a_log_of_another_world_is_refused(tmp_path):
    log = tmp_path / "commands.log"
    with start("minimal", mode="lockstep", args=["--log", str(log)]):
        pass
    with pytest.raises(camrig.CamrigError, match="is of another world: scene_hash"):
        start("clock", mode="lockstep", args=["--replay", str(log)])
    with pytest.raises(camrig.CamrigError, match="is of another world: seed was 1, is 7"):
        start("minimal", mode="lockstep", seed=7, args=["--replay", str(log)])
    with pytest.raises(camrig.CamrigError, match="there is something in it"):
        start("minimal", mode="lockstep", args=["--log", str(log)])
    log.write_text(log.read_text() + "nonsense\n")
    with pytest.raises(camrig.CamrigError, match="line 2"):
        start("minimal", mode="lockstep", args=["--replay", str(log)])


def test_a_rig_that_never_served_leaves_its_log_as_it_was(tmp_path):
    log, branch = tmp_path / "commands.log", tmp_path / "branch.log"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        no_port = {"mode": "lockstep", "http": taken.getsockname()[1]}
        with pytest.raises(camrig.CamrigError, match="in use"):
            start("minimal", args=["--log", str(log)], **no_port)
        with start("minimal", mode="lockstep", args=["--log", str(log)]) as rig:
            rig.step(seconds=0.1)
            saved = pathlib.Path(rig.save("it")["file"])
        kept = saved.read_bytes()
        for file in (branch, saved):
            with pytest.raises(camrig.CamrigError, match="in use"):
                start("minimal", args=["--replay", str(saved), "--log", str(file)], **no_port)
            with pytest.raises(camrig.CamrigError, match="is of another world"):
                start("minimal", mode="lockstep", seed=7, args=["--replay", str(saved), "--log", str(file)])
        assert saved.read_bytes() == kept and branch.read_bytes() == b""
        with start("minimal", mode="lockstep", args=["--replay", str(saved), "--log", str(branch)]):
            assert kept.startswith(branch.read_bytes()) and branch.read_bytes()


def test_what_hinders_a_save_is_said_to_clients_of_the_network_too():
    with start("hall", mode="lockstep", tcp=0) as rig, camrig.connect(host="127.0.0.1", port=rig.info()["tcp"]) as far:
        with pytest.raises(camrig.CamrigError, match="keeps no log"):
            far.save("it")


def test_a_held_world_stands_at_its_limit_and_catches_up():
    with start(args=["--held"]) as rig:
        with pytest.raises(camrig.CamrigError, match="this world is held"):
            rig.call("camera.create", name="cam", fps=20, **SMALL)
        rig.call("camera.create", name="cam", fps=20, at_ns=0, **SMALL)
        rig.call("world.limit", until_ns=300_000_000)
        wait_until(lambda: rig.status()["world_ns"] == 300_000_000)
        time.sleep(0.2)
        assert rig.status()["world_ns"] == 300_000_000
        assert rig.camera("cam").frame().time_ns == 300_000_000
        answer = rig.call("world.limit", until_ns=10**15)
        assert answer["limit_ns"] == 10**15
        wait_until(lambda: rig.status()["world_ns"] > 1_000_000_000)
        # It is at its clock again, not behind it by the time it was held.
        def world_s():
            """World time, and between which readings of this machine's clock it was read."""
            before = time.monotonic()
            return rig.status()["world_ns"] * 1e-9, before, time.monotonic()

        def goes_with_it():
            (first, *began), _, (last, *ended) = world_s(), time.sleep(0.3), world_s()
            return ended[0] - began[1] - 0.1 < last - first < ended[1] - began[0] + 0.1

        wait_until(goes_with_it, what="a world that goes as fast as its clock")  # a busy machine holds it up, too


def test_what_differs_is_named():
    with start("crowd", mode="lockstep", seed=1) as one, start("crowd", mode="lockstep", seed=2) as two, start("crowd", mode="lockstep", seed=1) as three:
        for rig in (one, two, three):
            rig.call("camera.create", name="cam", fps=10, **SMALL)
            rig.step(seconds=1)
        a, b, c = (digest(rig, parts=True) for rig in (one, two, three))
        assert a == c and a["hash"] != b["hash"] and a["cameras"] == b["cameras"]
        assert any(name.startswith("actor ") and a["parts"][name] != b["parts"][name] for name in a["parts"])
        # A number that is still to come decides too: the frame of one camera is another one.
        three.call("camera.set", name="cam", fps=20)
        changed = digest(three, parts=True)
        assert changed["world"] == a["world"] and [name for name in a["parts"] if a["parts"][name] != changed["parts"][name]] == ["camera cam"]


def test_identity_is_of_every_file(tmp_path, scenes):
    shutil.copytree(scenes / "clock", tmp_path / "clock")
    shutil.copy(scenes / "clock.json", tmp_path)
    with start("clock") as rig:
        shipped = rig.call("rig.identity")
    with start(tmp_path / "clock.json") as rig:
        copied = rig.call("rig.identity")
    assert shipped == copied and shipped["scene_files"] > 1
    model = next((tmp_path / "clock").glob("*.glb"))
    model.write_bytes(model.read_bytes() + b"\0")
    with start(tmp_path / "clock.json") as rig:
        changed = rig.call("rig.identity")
    assert {key for key in changed if changed[key] != copied[key]} == {"scene_hash"}


def world_again(log):
    """World time and hash of what comes of a log."""
    with start(mode="lockstep", args=["--replay", str(log)]) as rig:
        return {key: digest(rig)[key] for key in ("world_ns", "hash")}


def test_a_log_has_actions_of_which_a_later_one_failed(tmp_path):
    log = tmp_path / "commands.log"
    with start(mode="lockstep", args=["--log", str(log)]) as rig:
        guest = {"name": "guest", "model": "person_1", "class": "person", "position": [12, 8, 0]}
        spawn = {"action": "spawn", "actor": guest}
        rig.step(seconds=0.1)
        with pytest.raises(camrig.CamrigError, match=r"do\[1\]"):
            rig.call("event.act", do=[spawn, spawn])
        with pytest.raises(camrig.CamrigError):
            rig.call("actor.remove", name="nobody")
        assert "guest" in [actor["name"] for actor in rig.call("actor.list")["actors"]]
        rig.step(seconds=0.1)
        before = {key: digest(rig)[key] for key in ("world_ns", "hash")}
    assert world_again(log) == before
    assert "nobody" not in log.read_text()
    # What failed must fail again.
    log.write_text(log.read_text().replace('"failed":true,', ""))
    with pytest.raises(camrig.CamrigError, match=r"line 3: .*do\[1\]"):
        world_again(log)


def test_steps_of_clients_that_do_not_wait_for_each_other_are_all_done_again(tmp_path):
    log = tmp_path / "commands.log"
    with start(mode="lockstep", args=["--log", str(log)]) as rig:
        clients = [threading.Thread(target=rig.client.call, args=("world.step", {"seconds": 2}), daemon=True) for _ in range(8)]
        for client in clients:
            client.start()
        for client in clients:
            client.join(60)
        before = {key: digest(rig)[key] for key in ("world_ns", "hash")}
    assert before["world_ns"] == 16 * 10**9
    assert world_again(log) == before


def test_a_step_that_was_given_up_ends_there_when_it_is_done_again(tmp_path):
    log = tmp_path / "commands.log"
    with start(mode="lockstep", args=["--log", str(log)]) as rig:
        cam = rig.create_camera("c", size=(1920, 1080), fps=100, place="lobby")
        with stuck_mjpeg_reader(cam), pytest.raises(camrig.CamrigError, match="given up"):
            rig.call("world.step", seconds=5, timeout_s=1)
        rig.step(seconds=0.1)
        before = {key: digest(rig)[key] for key in ("world_ns", "hash")}
    assert before["world_ns"] < 5 * 10**9
    assert world_again(log) == before
