"""Bad input gets a clear error or a closed connection; the rig goes on and nothing leaks."""

import json
import os
import random
import select
import socket
import subprocess
import urllib.parse

import pytest

import camrig
from conftest import REPOSITORY, control_socket, wait_until

pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")


def some_glb() -> bytes:
    return next(iter(sorted((REPOSITORY / "scenes" / "minimal").glob("*.glb")))).read_bytes()


def test_damaged_glb_files_are_errors_that_name_the_file(rig, tmp_path):
    original = some_glb()
    rng = random.Random(1)
    refused = set()
    for case in range(60):
        data = bytearray(original)
        if case < 20:
            data = data[: rng.randrange(len(data))]
        elif case < 50:
            for _ in range(rng.choice([1, 10, 200])):
                data[rng.randrange(len(data))] = rng.randrange(256)
        else:
            data = bytearray(rng.randbytes(rng.randrange(1, 5000)))
        path = tmp_path / f"damaged_{case}.glb"
        path.write_bytes(data)
        try:
            rig.load(str(path))  # some flipped bytes hit nothing that matters
        except camrig.CamrigError as error:
            assert error.kind in ("invalid_argument", "unsupported", "resource_exhausted"), error
            assert path.name in str(error)
            refused.add(case)
    assert refused >= {*range(20), *range(50, 60)} and len(refused) > 30, "cut off, at random, and some of the flipped"
    rig.load(str(REPOSITORY / "scenes" / "minimal.json"))
    assert rig.status()["scene"] == "minimal"


def test_a_file_of_cameras_that_replaces_says_what_is_taken(rig, tmp_path):
    rig.create_camera("a", size=(64, 48), outputs=[{"kind": "device", "number": 40}])
    (tmp_path / "b.json").write_text(json.dumps({"name": "b", "outputs": [{"kind": "device", "number": 40}]}))
    done = subprocess.run([os.environ["CAMRIG_BIN"], "--control", rig.control, "camera", "create", "--file", str(tmp_path / "b.json"), "--replace"],
                          capture_output=True, text=True, timeout=30)
    assert done.returncode == 1 and "40" in done.stderr and "camera a" in done.stderr, done.stderr


@pytest.mark.parametrize("change, place", [
    ({"colour": 1}, "colour"),
    ({"environment": {"background": [0, 0]}}, "environment.background"),
    ({"objects": [{"name": "x", "model": "nothing"}]}, "objects[0].model"),
    ({"cameras": [{"name": "Bad Name"}]}, "cameras[0].name"),
    ({"actors": [{"name": "a", "model": "nothing", "behaviour": {"type": "stand"}}]}, "actors[0].model"),
    ({"models": {"m": {"file": "../../../etc/passwd"}}}, "models.m"),
])
def test_bad_scenes_name_file_and_json_path(rig, tmp_path, change, place):
    scene = {"camrig_scene": 1, "name": "bad", **change}
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(scene))
    with pytest.raises(camrig.CamrigError) as caught:
        rig.load(str(path))
    assert "bad.json" in str(caught.value) and place in str(caught.value)
    assert rig.status()["scene"] == "minimal"  # nothing has changed


def test_a_missing_texture_is_an_error_that_names_it(rig, tmp_path):
    (tmp_path / "m.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"}, "images": [{"uri": "wood.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]}))
    with pytest.raises(camrig.CamrigError) as caught:
        rig.load(str(tmp_path / "m.gltf"))
    assert "wood.png" in str(caught.value)


@pytest.mark.parametrize("pose", [
    '{"position":[NaN,0,0]}', '{"position":[1e999,0,0]}', '{"position":[0,0,0],"look_at":[0,0,0]}',
    '{"position":[0,0,0],"orientation":[0,0,0,0]}', '{"position":[1e300,0,0]}', '{"position":[0,0]}',
    '{"position":[0,0,0],"look_at":[1,0,0],"pan_deg":3}', '{}', '7'])
def test_poses_that_are_none_are_refused(rig, pose):
    raw = control_socket(rig)
    raw.sendall(('{"jsonrpc":"2.0","id":1,"method":"camera.create","params":{"name":"c","pose":%s}}\n' % pose).encode())
    reply = json.loads(raw.makefile().readline())
    assert reply["error"]["data"]["kind"] == "invalid_argument"
    assert rig.cameras() == [] or "c" not in [c.name for c in rig.cameras()]


def test_100_megabytes_of_json_do_not_grow_the_rig(rig, process):
    before = process.rss_kib()
    raw = control_socket(rig)
    chunk = b'{"a":[' + b"1," * 500_000
    sent = 0
    try:
        while sent < 100_000_000:
            raw.sendall(chunk)
            sent += len(chunk)
    except OSError:
        pass  # closed in the middle is fine too
    assert process.rss_kib() - before < 32 * 1024
    try:
        answers = raw.makefile("rb").read()  # up to the end of the connection
        assert json.loads(answers)["error"]["data"]["kind"] == "resource_exhausted"
    except ConnectionError:
        pass
    assert rig.status()["scene"] == "minimal"


def test_a_client_that_never_reads_is_closed_and_costs_no_memory(rig, process):
    rig.create_camera("c", size=(640, 480))
    before = process.rss_kib()
    raw = control_socket(rig)
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
    request = b'{"jsonrpc":"2.0","id":1,"method":"frame.get","params":{"camera":"c","format":"raw"}}\n'
    raw.settimeout(1)
    try:
        for _ in range(20_000):
            raw.sendall(request)
    except OSError:
        pass
    assert process.rss_kib() - before < 200 * 1024
    closed = select.poll()
    closed.register(raw, select.POLLRDHUP)
    assert closed.poll(20_000), "still open"
    wait_until(lambda: process.rss_kib() - before < 64 * 1024, what="the memory of its answers to be given back")
    assert rig.status()["scene"] == "minimal"
    raw.close()


def test_a_batch_of_large_pictures_costs_no_more_than_one_of_them(rig, process):
    """Eight raw pictures of 48 MB in one request: what does not fit is refused before it is drawn."""
    rig.create_camera("c", size=(4096, 2900))
    before = process.rss_kib()
    process.forget_peak()
    raw = control_socket(rig)
    one = '{"jsonrpc":"2.0","id":%d,"method":"frame.get","params":{"camera":"c","format":"raw"}}'
    raw.sendall(("[" + ",".join(one % number for number in range(8)) + "]\n" + one % 8 + "\n").encode())
    lines = raw.makefile("rb")
    answers = json.loads(lines.readline())
    assert [answer["id"] for answer in answers] == list(range(8))
    assert len(answers[0]["result"]["data"]) == (4096 * 2900 * 4 + 2) // 3 * 4
    for answer in answers[1:]:
        assert answer["error"]["data"]["kind"] == "resource_exhausted"
        assert "one at a time" in answer["error"]["message"]
    del answers
    assert "result" in json.loads(lines.readline())  # the connection goes on
    assert process.peak_kib() - before < 450 * 1024


def test_clients_that_vanish_in_the_middle_leave_nothing(rig, process):
    cam = rig.create_camera("c", size=(320, 240))
    url = urllib.parse.urlparse(cam.url())

    def vanish():
        raw = socket.create_connection((url.hostname, url.port))
        raw.sendall(f"GET {url.path} HTTP/1.1\r\nHost: {url.netloc}\r\n\r\n".encode())
        raw.recv(1000)
        raw.close()
        control = control_socket(rig)
        control.sendall(b'{"jsonrpc":"2.0","id":1,"method":"frame.get","params":{"camera":"c"')
        control.close()

    def nobody_reads():
        wait_until(lambda: rig.call("camera.get", name="c")["readers"] == 0, what="the end of the readers")

    # What the first picture opens stays: it is drawn whether or not the first client is gone by then.
    cam.frame()
    vanish()
    rig.step(seconds=0.2)
    nobody_reads()
    fds = process.fds()
    for _ in range(50):
        vanish()
    rig.step(seconds=0.2)
    wait_until(lambda: process.fds() <= fds, what="descriptors of vanished clients to be closed")
    nobody_reads()


@pytest.mark.slow
def test_a_thousand_create_delete_cycles_leak_nothing(rig, process):
    def cycle(count):
        for _ in range(count):
            cam = rig.create_camera("c", size=(64, 48), code_strip=False)
            cam.frame()
            rig.step(nanoseconds=40_000_000)
            cam.delete()

    cycle(100)
    rss, fds, threads = process.rss_kib(), process.fds(), process.threads()
    cycle(1000)
    wait_until(lambda: process.fds() == fds, what="all descriptors to be closed")
    assert process.threads() == threads
    assert process.rss_kib() - rss < 4 * 1024


@pytest.mark.parametrize("line, code", [
    (b"{", -32700), (b"[]", -32600), (b"1", -32600), (b'{"jsonrpc":"1.0","id":1,"method":"x"}', -32600),
    (b'{"jsonrpc":"2.0","id":1,"method":"no.such"}', -32601),
    (b'{"jsonrpc":"2.0","id":1,"method":"camera.get","params":[1]}', -32602),
    (b'{"jsonrpc":"2.0","id":1,"method":"camera.get","params":{"name":"x","nme":1}}', -32602),
    (b'{"jsonrpc":"2.0","id":1,"method":"camera.get"}', -32602),
    (b"\xff\xfe{}", -32700)])
def test_wrong_messages_get_the_code_of_the_standard(rig, line, code):
    raw = control_socket(rig)
    raw.sendall(line + b"\n")
    assert json.loads(raw.makefile().readline())["error"]["code"] == code


def test_a_message_that_is_too_long_is_refused_and_the_next_call_is_answered(rig):
    for size in [1_100_000] * 10 + [50_000_000] * 3:
        with pytest.raises(camrig.CamrigError, match="a message has at most 1048576 bytes") as caught:
            rig.call("camera.get", name="x" * size)
        assert caught.value.kind == "resource_exhausted"
        assert rig.status()["scene"] == "minimal"


def test_serving_what_cannot_be_served_is_one_clear_line(tmp_path):
    program = os.environ["CAMRIG_BIN"]
    for arguments, word in ((["serve", str(tmp_path / "none.json")], "none.json"),
                            (["serve", str(REPOSITORY / "scenes/minimal.json"), "--host", "0.0.0.0"], "token"),
                            (["serve", str(REPOSITORY / "scenes/minimal.json"), "--device", "99"], "device")):
        done = subprocess.run([program, *arguments, "--http", "0", "--rtsp", "0", "--control", str(tmp_path / "s")],
                              capture_output=True, text=True, timeout=60)
        assert done.returncode == 1
        assert word in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1


def test_a_start_with_too_little_memory_is_one_clear_line(tmp_path):
    """120 MB of address space; whichever thread it is that finds none."""
    scene = REPOSITORY / "scenes" / "minimal.json"
    command = f"ulimit -v 120000; exec {os.environ['CAMRIG_BIN']} serve {scene} --http 0 --rtsp 0 --control {tmp_path}/small.sock"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, (done.returncode, done.stderr)
    assert done.stderr.startswith("camrig: ") and len(done.stderr.splitlines()) == 1, done.stderr
    assert not (tmp_path / "small.sock").exists()


def test_a_rig_of_another_version_is_said_to_be_one(tmp_path):
    """An answer without a field that this command shows is neither made up nor shown as a parser's error."""
    import threading

    path = str(tmp_path / "old.sock")
    with socket.socket(socket.AF_UNIX) as old:
        old.bind(path)
        old.listen()

        def answer():
            for _ in range(2):
                with old.accept()[0] as client, client.makefile("rw") as lines:
                    request = json.loads(lines.readline())
                    result = {"cameras": [{"name": "a", "size": [64, 48]}]} if request["method"] == "camera.list" else {"name": "a"}
                    lines.write(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}) + "\n")
                    lines.flush()

        threading.Thread(target=answer, daemon=True).start()
        for words in (["camera", "list"], ["camera", "get", "a"]):
            done = subprocess.run([os.environ["CAMRIG_BIN"], *words, "--control", path], capture_output=True, text=True, timeout=30)
            assert done.returncode == 1 and "another version" in done.stderr and "json.exception" not in done.stderr, done.stderr


@pytest.mark.parametrize("what_lacks", ["cameras", "size"])
def test_a_recording_of_a_rig_of_another_version_lets_its_world_go(tmp_path, what_lacks):
    """An exception in the middle left the world paused."""
    import threading

    camera = {"name": "a", "size": [64, 48], "fps": 25, "clock": None}
    status = {"mode": "realtime", "paused": False, "world_ns": 0, "scene": "s", "seed": 1}
    results = {
        "camera.list": {} if what_lacks == "cameras" else {"cameras": [camera]},
        "world.status": status,
        "truth.get": {"time_ns": 40_000_000, "sequence": 1},
        "frame.get": {"time_ns": 40_000_000, "sequence": 1, "data": ""}}
    asked = []
    path = str(tmp_path / "old.sock")
    with socket.socket(socket.AF_UNIX) as old:
        old.bind(path)
        old.listen()

        def answer():
            with old.accept()[0] as client, client.makefile("rw") as lines:
                for line in lines:
                    request = json.loads(line)
                    asked.append(request["method"])
                    lines.write(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": results.get(request["method"], {})}) + "\n")
                    lines.flush()

        thread = threading.Thread(target=answer, daemon=True)
        thread.start()
        done = subprocess.run([os.environ["CAMRIG_BIN"], "record", str(tmp_path / "set"), "--masks", "--depth", "npy", "--frames", "1", "--control", path],
                              capture_output=True, text=True, timeout=30)
        thread.join(20)
    assert done.returncode == 1 and "another version" in done.stderr and "json.exception" not in done.stderr, done.stderr
    assert what_lacks == "cameras" or asked[-1] == "world.resume", asked
    assert ("world.pause" in asked) == ("world.resume" in asked)


def test_a_field_of_view_that_is_none_is_told_in_few_digits(rig):
    with pytest.raises(camrig.CamrigError, match=r"vfov_deg: 200 deg is no field of view"):
        rig.create_camera("wide", size=(64, 48), vfov_deg=200)
