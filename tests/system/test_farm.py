"""One world on several nodes: processes on this machine, each with a rig of its own, and a NATS server of Debian."""

import contextlib
import itertools
import json
import os
import pathlib
import shlex
import signal
import subprocess
import sys
import threading
import time
import urllib.request

import pytest
from conftest import REPOSITORY, wait_until
from rtsp_client import assert_gst_read_to_the_end
from test_command_log import SMALL, commands, digest, people_of, pictures, start

import camrig
from camrig.places import find_binary

sys.path.insert(0, str(REPOSITORY / "tests" / "farm"))
from live_parts import farm as live_farm  # noqa: E402


@contextlib.contextmanager
def farm(*options, nodes=2, scene="hall"):
    """(rig on the farm's control address, its facts)."""
    read_end, write_end = os.pipe()
    command = [sys.executable, "-m", "camrig.farm", "up", "--scene", scene, "--nodes", str(nodes), "--arg=--device=cpu", "--ready-fd", str(write_end), *options]
    child = subprocess.Popen(command, pass_fds=(write_end,), stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")})
    os.close(write_end)
    said = []
    reader = threading.Thread(target=lambda: said.extend(child.stderr), daemon=True)
    reader.start()
    try:
        with os.fdopen(read_end) as ready:
            line = ready.readline()
        assert line, "".join(said)
        facts = json.loads(line)
        rig = camrig.connect(facts["control"])
        wait_until(lambda: len(nodes_of(rig)) == nodes, 30, "all nodes")
        yield rig, {**facts, "said": said, "child": child}
        rig.call("server.shutdown")
        assert child.wait(20) == 0, "".join(said)
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGTERM)
            try:
                child.wait(10)
            except subprocess.TimeoutExpired:
                child.kill()


def test_it_can_be_ended_while_its_nodes_start():
    command = [sys.executable, "-m", "camrig.farm", "up", "--scene", "hall", "--nodes", "2", "--arg=--device=cpu"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")}) as child:
        try:
            own = pathlib.Path(f"/proc/{child.pid}/task/{child.pid}/children")
            wait_until(lambda: len(own.read_text().split()) == 3, 30, "a bus and two nodes")
            began = time.monotonic()
            child.send_signal(signal.SIGINT)
            said, wrong = child.communicate(timeout=60)
        finally:
            child.kill()
    print(f"ended after {time.monotonic() - began:.1f} s")
    assert child.returncode == 0 and "camrig farm\n" not in said and "Traceback" not in wrong, wrong


def test_a_bus_that_does_not_start_says_why(tmp_path):
    (tmp_path / "file").touch()
    command = [sys.executable, "-m", "camrig.farm", "up", "--scene", "minimal", "--store", str(tmp_path / "file" / "store")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")}, check=False)
    assert done.returncode == 1 and "NATS server" in done.stderr and "storage directory" in done.stderr and "Traceback" not in done.stderr, done


def test_a_bus_that_dies_is_started_again_with_its_log():
    with farm("--mode", "lockstep", scene="minimal") as (rig, facts):
        rig.step(seconds=0.4)
        before = rig.status()["world_ns"]
        bus = next(pid for pid in pathlib.Path(f"/proc/{facts['child'].pid}/task/{facts['child'].pid}/children").read_text().split()
                   if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == "nats-server")
        os.kill(int(bus), signal.SIGKILL)
        wait_until(lambda: any("NATS server has ended (-9)" in line for line in facts["said"]), what="the bus is missed")
        rig.create_camera("behind", size=(160, 120), fps=10)
        assert rig.step(seconds=0.4)["world_ns"] == before + 400_000_000
        assert len(all_nodes(rig)) == 2
        assert len({json.dumps(digest(one)) for one in rigs_of(rig).values()}) == 1


def shows_pictures(*words):
    """Whether a client of HTTP gets two pictures of a stream, however long it takes."""
    with subprocess.Popen(["curl", "-sN", "--max-time", "30", *words], stdout=subprocess.PIPE) as reading:
        got = b""
        while got.count(b"X-Sequence") < 2 and (some := reading.stdout.read1()):
            got += some
        reading.kill()
    return got.count(b"X-Sequence") >= 2


def nodes_of(rig):
    return rig.call("farm.status")["nodes"]


def all_nodes(rig, count=2):
    """One that a busy machine holds up is missing, for a moment."""
    looks = []
    wait_until(lambda: looks.append(nodes_of(rig)) or len(looks[-1]) == count, what=f"{count} nodes")
    return looks[-1]


def rigs_of(rig):
    return {node["node"]: camrig.connect(node["control"]) for node in all_nodes(rig)}


def test_in_lockstep_every_node_shows_what_one_machine_shows():
    """The unmodified client commands two nodes; each camera's pictures are those of a single machine, to the byte."""
    with start(mode="lockstep") as alone:
        people = people_of(alone)
        line = list(itertools.islice(commands(11, people), 37))
        seen = []
        for number, (method, params) in enumerate(line):
            alone.call(method, **params)
            if number >= 3 and number % 6 == 0:
                alone.step(seconds=0.1)
                seen.append(pictures(alone))
    with farm("--mode", "lockstep") as (rig, _):
        shown = []
        for number, (method, params) in enumerate(line):
            rig.call(method, **params)
            if number >= 3 and number % 6 == 0:
                assert rig.step(seconds=0.1)["world_ns"] > 0
                shown.append(pictures(rig))
        assert shown == seen
        owners = {camera["camera"]: camera["node"] for camera in rig.call("farm.status")["cameras"]}
        rigs = rigs_of(rig)
        assert len(owners) == 7 and set(owners.values()) == {"node1", "node2"}
        digests = {name: digest(one) for name, one in rigs.items()}
        assert len(digests) == 2 and len({json.dumps(one) for one in digests.values()}) == 1
        assert [pictures(one) for one in rigs.values()] == [shown[-1]] * 2


def test_in_real_time_nodes_stay_equal_whoever_commands_and_whoever_dies():
    """Three clients command; the sequencer's node is killed; the farm takes commands again, and all nodes are equal."""
    with farm("--no-replace", nodes=3) as (rig, facts):
        people = people_of(rig)
        line = commands(12, people)
        for method, params in itertools.islice(line, 4):
            rig.call(method, **params)
        failed = []

        def client(seed):
            mine = camrig.connect(facts["control"])
            for method, params in itertools.islice(commands(seed, people), 4, 14):
                try:
                    mine.call(method, **params)
                except camrig.CamrigError as problem:
                    # The same on all nodes: that a guest of this name is there already.
                    if problem.kind != "already_exists":
                        failed.append(problem)

        clients = [threading.Thread(target=client, args=(seed,), daemon=True) for seed in (21, 22, 23)]
        for each in clients:
            each.start()
        for each in clients:
            each.join(30)
        assert not failed

        names = {node["node"] for node in all_nodes(rig, 3)}
        sequencer = next(node for node in all_nodes(rig, 3) if node["is_sequencer"])
        began = time.monotonic()
        os.kill(sequencer["pid"], signal.SIGKILL)
        rig.call("camera.set", name="cam0", vfov_deg=44)
        took_s = time.monotonic() - began
        print(f"commands are taken {took_s:.2f} s after the sequencer's death")
        assert took_s < 8
        wait_until(lambda: {node["node"] for node in nodes_of(rig)} == names - {sequencer["node"]}, what="the two others")
        # A rig does not outlive its node.
        wait_until(lambda: not os.path.exists(f"/proc/{sequencer['rig_pid']}") or b"Z" in open(f"/proc/{sequencer['rig_pid']}/stat", "rb").read().split()[2])
        rigs = list(rigs_of(rig).values())
        told = [None] * 2

        def ask(number, at_ns):
            with live_farm.asked_in_time():
                told[number] = digest(rigs[number], at_ns=at_ns)

        for ahead_s in (2, 5, 8):
            told[:] = [None] * 2
            at_ns = (max(one.status()["world_ns"] for one in rigs) // 10**9 + ahead_s) * 10**9 + 1
            asking = [threading.Thread(target=ask, args=(number, at_ns), daemon=True) for number in range(2)]
            for each in asking:
                each.start()
            for each in asking:
                each.join(20)
            if all(told):
                break
        assert told[0] and told[0] == told[1] and told[0]["command_count"] >= 30
        for one in rigs:
            for camera in one.call("stats.get")["cameras"]:
                assert camera["due"] == camera["rendered"] + camera["dropped"] and camera["dropped"] == sum(camera["dropped_for"].values())


def test_a_node_that_joins_late_becomes_equal_and_one_that_differs_is_named_and_replaced():
    with farm(nodes=2) as (rig, facts):
        for method, params in itertools.islice(commands(13, people_of(rig)), 12):
            rig.call(method, **params)
        before = all_nodes(rig)
        victim = next(node for node in before if not node["is_sequencer"])
        os.kill(victim["pid"], signal.SIGKILL)
        known = {node["node"] for node in before}
        others = lambda: [node["node"] for node in nodes_of(rig) if node["node"] not in known and node.get("applied", 0) >= 12]
        wait_until(lambda: len(nodes_of(rig)) == 2 and others(), 30, "a node in its place")
        new = others()[0]
        # Behind the log's back, which nobody can by the node's own rules: a rig that is told something else.
        late = rigs_of(rig)[new]
        for at_ns in (late.status()["world_ns"] + 300_000_000 for _ in range(50)):
            try:
                late.call("actor.steer", actors=[{"name": people_of(rig)[0], "velocity": [1, 0, 0]}], at_ns=at_ns)
                break
            except camrig.CamrigError as error:  # a busy machine may say it too late
                assert "is past" in error.message
        wait_until(lambda: any(f"{new} is stopped" in line for line in facts["said"]), 20, "the node that differs to be found")
        named = lambda: [line for line in facts["said"] if f"{new} stops" in line]
        wait_until(lambda: named(), 10)
        assert f"actor {people_of(rig)[0]}" in named()[0]
        wait_until(lambda: len(nodes_of(rig)) == 2 and any(node["node"] not in {*known, new} for node in nodes_of(rig)), 30, "one in its place")


def test_a_node_of_another_world_cannot_join():
    with farm(nodes=1, scene="minimal") as (rig, facts):
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", "other", "--nats", facts["nats"], "--scene", "minimal", "--seed", "99"]
        other = subprocess.run(command, capture_output=True, text=True, timeout=40, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")})
        assert other.returncode == 1 and "cannot join: seed is 99, the farm's is 1" in other.stderr
        assert "other" not in {node["node"] for node in nodes_of(rig)} and [node["node"] for node in all_nodes(rig, 1)] == ["node1"]


def test_nodes_come_and_go_while_the_farm_runs_and_all_metrics_are_one_page():
    with farm("--metrics", "127.0.0.1:0", nodes=1, scene="minimal") as (rig, facts):
        for number in range(6):
            rig.call("camera.create", name=f"cam{number}", fps=5, **SMALL)
        assert rig.call("farm.scale", nodes=3) == {"nodes": ["node1", "node2", "node3"]}
        all_nodes(rig, 3)  # one that is held up for its lease is away for a moment
        owners = {camera["camera"]: camera["node"] for camera in rig.call("farm.status")["cameras"]}
        assert len(set(owners.values())) > 1
        with urllib.request.urlopen(facts["metrics"]) as page:
            text = page.read().decode()
        for node in ("node1", "node2", "node3"):
            assert f'camrig_farm_node_up{{node="{node}"}} 1' in text and f'camrig_world_time_seconds{{node="{node}"}}' in text
        assert text.count("# TYPE camrig_world_time_seconds ") == 1
        for camera, node in owners.items():
            assert f'camrig_farm_camera_owner{{node="{node}",camera="{camera}"}} 1' in text
        assert rig.call("farm.scale", nodes=1) == {"nodes": ["node1"]}
        assert {camera["node"] for camera in rig.call("farm.status")["cameras"]} == {"node1"}
        assert rig.call("camera.set", name="cam3", vfov_deg=44)["applied_ns"] > 0
        with pytest.raises(camrig.CamrigError, match="nodes: a number from 1"):
            rig.call("farm.scale", nodes=0)


def test_who_is_cut_off_shows_no_standing_pictures_and_comes_back(tmp_path):
    """Its world stands then, and its cameras are others'; so its rig ends, and its readers' connections with it."""
    with live_farm.Farm(tmp_path, "minimal", nodes=2) as far:
        far.rig.call("camera.create", name="cam", fps=5, **SMALL)
        name = next(name for name in far.nodes if name != far.sequencer())
        facts = far.facts_of(name)
        wait_until(lambda: "cam" in [camera.name for camera in camrig.connect(facts["control"]).cameras()], 20, "the node to have the camera too")
        reader = urllib.request.urlopen(f"http://127.0.0.1:{facts['http']}/cameras/cam/stream.mjpg", timeout=30)
        assert reader.read(100)
        far.nodes[name].set_link(False)
        deadline = time.monotonic() + 30
        while reader.read(65536):
            assert time.monotonic() < deadline, "it goes on showing what stands"
        with pytest.raises(OSError):
            urllib.request.urlopen(f"http://127.0.0.1:{facts['http']}/cameras/cam/snapshot.jpg", timeout=30)
        wait_until(lambda: set(far.owners().values()) == {far.sequencer()}, 20, "the camera to be another's")
        far.nodes[name].set_link(True)
        wait_until(lambda: any(node["node"] == name and node["rig_pid"] != facts["rig_pid"] and not node["is_behind"] for node in nodes_of(far.rig)), 30, "it to be back")
        hashes = live_farm.digests_at_one_time(far)
        assert len(hashes) == 2 and len(set(hashes.values())) == 1


def test_who_waits_for_a_bus_that_has_gone_ends_when_told(tmp_path):
    with live_farm.Farm(tmp_path, "minimal", nodes=2) as far:
        far.bus.kill(0)
        waiting = [far.door_process, *(node.process for node in far.nodes.values())]
        wait_until(lambda: all("cut off" in node.log.read_text() for node in far.nodes.values()), 20, "nodes to wait for the bus")
        for process, end in zip(waiting, (signal.SIGTERM, signal.SIGTERM, signal.SIGINT)):
            process.send_signal(end)
        assert [process.wait(10) for process in waiting] == [0, 3, 3]


def test_who_looks_after_a_command_sees_it_on_every_node(tmp_path):
    """Also on one whose clock, and so its world, is late."""
    with live_farm.Farm(tmp_path, "minimal", nodes=1) as far:
        late = live_farm.Node(far, "late", "--clock-ahead-ms", "-300", "--max-skew-ms", "1000")
        try:
            wait_until(lambda: any(node["node"] == "late" and not node["is_behind"] for node in nodes_of(far.rig)), 30, "the second node")
            for number in range(8):
                far.rig.call("camera.create", name=f"cam{number}", fps=5, **SMALL)
                assert far.rig.call("camera.get", name=f"cam{number}")["fps"] == 5  # of its owner
                far.rig.call("camera.set", name=f"cam{number}", fps=8)
                assert far.rig.call("camera.get", name=f"cam{number}")["fps"] == 8
            wait_until(lambda: set(far.owners().values()) == {"node1", "late"}, what="cameras of both")
        finally:
            late.kill()


def test_a_clock_that_is_off_is_named_and_its_node_has_no_cameras(tmp_path):
    with live_farm.Farm(tmp_path, "minimal", nodes=1) as far:
        for number in range(8):
            far.rig.call("camera.create", name=f"cam{number}", fps=5, **SMALL)
        early = live_farm.Node(far, "early", "--clock-ahead-ms", "300")
        try:
            wait_until(lambda: any(node.get("clock_is_off") for node in nodes_of(far.rig)), 30, "the clock to be compared")
            facts = far.facts_of("early")
            assert abs(facts["clock_ahead_ms"] - 300) <= facts["clock_bound_ms"] + 0.1
            assert "its clock is " in early.log.read_text() and set(far.owners().values()) == {"node1"}
            wait_until(lambda: not far.facts_of("early")["is_behind"], 20)
            hashes = live_farm.digests_at_one_time(far)
            assert len(hashes) == 2 and len(set(hashes.values())) == 1  # late or early, it is the same world
        finally:
            early.kill()


def test_a_farm_is_commanded_by_tcp_with_its_token(tmp_path):
    token = tmp_path / "token"
    token.write_text("0123456789abcdef\n")
    far_away = ("--host", "127.0.0.2", "--token-file", str(token))
    with live_farm.Farm(tmp_path, "minimal", nodes=2, node_options=far_away, door_options=("--token-file", str(token), "--tcp", "127.0.0.1:0", "--metrics", "127.0.0.1:0")) as far:
        host, _, port = far.door["tcp"].rpartition(":")
        began = time.monotonic()
        with pytest.raises(camrig.CamrigError, match="shows the farm's token"):
            camrig.connect(host=host, port=int(port), token="fedcba9876543210")
        assert time.monotonic() - began > 0.2  # as a rig does, and it is counted
        with urllib.request.urlopen(far.door["metrics"]) as page:
            assert "camrig_farm_door_wrong_tokens_total 1\n" in page.read().decode()
        rig = camrig.connect(host=host, port=int(port), token="0123456789abcdef")
        rig.call("camera.create", name="cam", fps=5, **SMALL)
        assert rig.camera("cam").frame().image.shape == (120, 160, 3)
        assert all(camera["http"].startswith("http://127.0.0.2:") for camera in rig.call("farm.status")["cameras"])


def test_stock_clients_read_cameras_where_the_farm_says(tmp_path):
    with farm(nodes=2, scene="minimal") as (rig, facts):
        for number in range(4):
            rig.call("camera.create", name=f"eye{number}", fps=10, **SMALL)
        all_nodes(rig, 2)
        one_of_each = {camera["node"]: camera for camera in rig.call("farm.status")["cameras"]}
        assert set(one_of_each) == {"node1", "node2"}
        for camera in one_of_each.values():
            read = ["ffmpeg", "-loglevel", "error", "-rtsp_transport", "tcp", "-i", camera["rtsp"], "-frames:v", "3", "-f", "framecrc", "-"]
            shown = subprocess.run(read, capture_output=True, text=True, timeout=60)
            assert shown.returncode == 0 and len([line for line in shown.stdout.splitlines() if not line.startswith("#")]) == 3, shown.stderr
            assert shows_pictures(camera["http"])
            # GStreamer, by the node's addresses and at the farm's own, which sends it to the node.
            for source in (f"rtspsrc location={camera['rtsp']} protocols=tcp ! rtph264depay ! avdec_h264", f"souphttpsrc location={camera['http']} ! multipartdemux ! jpegdec",
                           f"souphttpsrc location={facts['http']}cameras/{camera['camera']}/stream.mjpg ! multipartdemux ! jpegdec"):
                file = tmp_path / "pictures.rgb"
                played = subprocess.run(["gst-launch-1.0", "-e", *shlex.split(source), "!", "videoconvert", "!", "video/x-raw,format=RGB", "!", "identity", "eos-after=4",
                                         "!", "filesink", f"location={file}"], capture_output=True, timeout=60)
                assert_gst_read_to_the_end(played.returncode, played.stdout, played.stderr)
                assert file.stat().st_size == 3 * 160 * 120 * 3, f"{source}: {played.stderr.decode()}"
        command = lambda *words: subprocess.run([find_binary(), "--control", facts["control"], *words], capture_output=True, text=True, timeout=60)
        assert command("camera", "set", "eye1", "--vfov-deg", "41").returncode == 0
        assert "eye1  160x120   10    41" in command("camera", "list").stdout
        assert command("snapshot", "eye2", "-o", str(tmp_path / "eye2.png")).returncode == 0
        assert (tmp_path / "eye2.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("mode", ["realtime", "lockstep"])
def test_a_farms_cameras_are_recorded_into_one_bag(tmp_path, mode):
    with farm("--mode", mode, nodes=2, scene="minimal") as (rig, facts):
        for number in range(4):
            rig.call("camera.create", name=f"eye{number}", fps=10, **SMALL)
        all_nodes(rig, 2)
        assert {camera["node"] for camera in rig.call("farm.status")["cameras"]} == {"node1", "node2"}
        words = [find_binary(), "--control", facts["control"], "--json", "ros2", "record", str(tmp_path / "bag"), "--seconds", "1", "--cameras", "eye0,eye1,eye2,eye3"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=120, env={**os.environ, "CAMRIG_PYTHON": sys.executable})
        assert done.returncode == 0, done.stderr
        said = json.loads(done.stdout)
        assert all(said["frames"][name] > 0 and said["frames"][name] + said["missing"][name] == 10 for name in ("eye0", "eye1", "eye2", "eye3")), said
        assert mode == "realtime" or not any(said["missing"].values())


def test_nodes_with_a_certificate_say_rtsps(tmp_path):
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", str(key), "-out", str(cert)],
                   capture_output=True, check=True)
    with farm(f"--arg=--rtsp-cert={cert}", f"--arg=--rtsp-key={key}", nodes=1, scene="minimal") as (rig, _):
        url = rig.call("farm.status")["cameras"][0]["rtsp"]
        assert url.startswith("rtsps://")
        shown = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=codec_name", "-of", "csv=p=0", url], capture_output=True, text=True, timeout=60)
        assert shown.stdout == "h264\n", shown.stderr


def test_a_run_that_is_interrupted_leaves_nobody_waiting(tmp_path):
    """Nodes wait for a bus for ever, so who runs a farm must take them along, also before all of it is there."""
    for end, when in ((signal.SIGINT, "node2"), (signal.SIGTERM, "nats0"), (signal.SIGKILL, "node2")):
        folder = tmp_path / f"{end}"
        mark = f"FARM_OF={folder}"
        command = [sys.executable, "tests/farm/live.py", "--only", "lockstep", "--keep", str(folder)]
        environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python"), "FARM_OF": str(folder)}
        running = subprocess.Popen(command, cwd=REPOSITORY, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            wait_until((folder / "lockstep" / f"{when}.log").exists, 60)
            running.send_signal(end)
            said, _ = running.communicate(timeout=120)
            if end != signal.SIGKILL:
                # Where a signal comes while CPython makes an event loop it complains of that one by itself.
                lines = said.splitlines()
                assert running.returncode == 1 and "interrupted" in lines[-1], said
                assert len(lines) == 1 or lines[0].startswith("Exception ignored in: <function BaseEventLoop.__del__"), said
            wait_until(lambda: not processes_with(mark), 60, f"nobody to be left of {mark}")
        finally:
            for pid in processes_with(mark):
                os.kill(pid, signal.SIGKILL)


def processes_with(mark):
    """Those that live and have it in their environment."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if mark.encode() in path.read_bytes().split(b"\0") and path.with_name("stat").read_text().rpartition(")")[2].split()[0] != "Z":
                found.append(int(path.parent.name))
    return found


@pytest.mark.parametrize("words, says", [
    (["up"], "the following arguments are required: --scene"),
    (["node", "--name", "a", "--nats", "nats://x", "--scene", "hall", "--host", "10.0.0.1"], "--host: give --token-file too"),
    (["door", "--nats", "nats://x"], "--control: give the path of the socket"),
    (["node", "--name", "a", "--nats", "nats://x", "--scene", "hall", "--cores", "0"], "--cores: '0' is not a number of cores"),
    (["up", "--scene", "hall", "--metrics", "9090"], "'9090' is not HOST:PORT"),
    (["up", "--scene", "hall", "--http", "0.0.0.0:80"], "--http: of loopback only"),
    (["door", "--nats", "nats://x", "--control", "/tmp/x.sock", "--http", "0.0.0.0:80"], "--http: beyond loopback give --token-file too"),
])
def test_wrong_usage_is_one_line(words, says):
    ran = subprocess.run([sys.executable, "-m", "camrig.farm", *words], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(REPOSITORY / "control/python")})
    assert ran.returncode == 2 and ran.stderr.count("\n") == 1 and says in ran.stderr and ran.stderr.startswith("camrig: ")
