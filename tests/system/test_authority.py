"""Who may command a rig: its own user, without being asked; other users of the machine look, and nothing of theirs is trusted."""

import json
import os
import pathlib
import shutil
import socket
import stat
import subprocess
import tempfile
import urllib.request

import pytest

import camrig
from conftest import REPOSITORY, wait_until

SCENE = str(REPOSITORY / "scenes" / "minimal.json")
STRANGER = 65534


def as_stranger(what):
    """What `what()` gives, run by another user of this machine: JSON through a pipe."""
    if os.geteuid() != 0:
        pytest.skip("only root can be another user too")
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.setgroups([])
            os.setgid(STRANGER)
            os.setuid(STRANGER)
            os.write(writing, json.dumps(what()).encode())
        except BaseException as problem:  # noqa: BLE001  (told to the parent)
            os.write(writing, json.dumps(f"{type(problem).__name__}: {problem}").encode())
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as answer:
        text = answer.read()
    os.waitpid(child, 0)
    return json.loads(text)


def post(rig, method, params=None, key=None):
    """The answer to a bare POST /rpc, as curl would send it."""
    headers = {"Content-Type": "application/json", **({"Authorization": f"Bearer {key}"} if key else {})}
    body = json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params or {}}).encode()
    with urllib.request.urlopen(urllib.request.Request(f"{rig.http_url}/rpc", body, headers), timeout=30) as reply:
        return json.load(reply)


def over_tcp(port, *lines):
    with socket.create_connection(("127.0.0.1", port), timeout=30) as raw:
        raw.sendall("".join(json.dumps({"jsonrpc": "2.0", "id": 1, **line}) + "\n" for line in lines).encode())
        raw.shutdown(socket.SHUT_WR)
        return [json.loads(line) for line in raw.makefile()]


def kind(answer):
    return answer["error"]["data"]["kind"] if "error" in answer else "done"


def serve(*arguments, **options):
    """The end of a `camrig serve` that does not come up."""
    return subprocess.run([os.environ["CAMRIG_BIN"], "serve", SCENE, "--http", "0", "--rtsp", "0", *arguments],
                          capture_output=True, text=True, timeout=60, check=False, **options)


@pytest.fixture(scope="module")
def rig():
    with camrig.start(SCENE, mode="lockstep", tcp=0) as running:
        yield running


def test_another_user_of_the_machine_looks_but_does_not_command(rig):
    info = rig.info()
    rig.http_url  # asked before: the stranger does not reach the Unix socket
    assert as_stranger(lambda: [camera["name"] for camera in post(rig, "camera.list")["result"]["cameras"]]) == ["main"]
    assert as_stranger(lambda: urllib.request.urlopen(f"{rig.http_url}/cameras/main/snapshot.jpg", timeout=30).status) == 200
    for method, params in (("server.shutdown", {}), ("world.load", {"scene": SCENE}), ("camera.delete", {"name": "main"})):
        assert as_stranger(lambda: kind(post(rig, method, params))) == "unauthorized"  # noqa: B023
        assert as_stranger(lambda: kind(post(rig, method, params, key="0" * 48))) == "unauthorized"  # noqa: B023
        assert as_stranger(lambda: [kind(answer) for answer in over_tcp(info["tcp"], {"method": method, "params": params})]) == ["unauthorized"]  # noqa: B023
    assert "PermissionError" in as_stranger(lambda: pathlib.Path(info["key_file"]).read_text())
    assert "PermissionError" in as_stranger(lambda: socket.socket(socket.AF_UNIX).connect(info["control"]))
    assert [camera.name for camera in rig.cameras()] == ["main"]


def test_what_is_refused_says_how_to_do_it(rig):
    refused = post(rig, "world.step", {"seconds": 1})["error"]["message"]
    assert "#key=" in refused and "Authorization: Bearer" in refused and "camrig call server.info" in refused
    key = pathlib.Path(json.loads(subprocess.run([os.environ["CAMRIG_BIN"], "call", "server.info", "--control", rig.info()["control"]],
                                                 capture_output=True, check=True, timeout=30).stdout)["key_file"])
    assert stat.S_IMODE(key.stat().st_mode) == 0o600 and stat.S_IMODE(key.parent.stat().st_mode) == 0o700
    assert kind(post(rig, "world.step", {"seconds": 0.2}, key=key.read_text().strip())) == "done"


def test_programs_of_the_rigs_user_command_without_being_asked(rig):
    port = int(rig.http_url.rsplit(":", 1)[1])
    tcp = rig.info()["tcp"]
    for name, options in (("a", {"control": rig.http_url}), ("b", {"control": rig.page_url}), ("c", {"host": "127.0.0.1", "http_port": port}),
                          ("d", {"host": "127.0.0.1", "port": tcp}), ("e", {"host": "localhost", "port": tcp})):
        with camrig.connect(**options) as other:
            other.create_camera(name, size=(64, 48)).delete()
    made = subprocess.run([os.environ["CAMRIG_BIN"], "camera", "create", "f", "--size", "64x48", "--position", "0,0,1", "--control", f"127.0.0.1:{tcp}"],
                          capture_output=True, text=True, timeout=30, check=False)
    assert made.returncode == 0, made.stderr
    rig.camera("f").delete()
    for wrong in ({"http_port": port}, {"port": tcp}):
        with pytest.raises(camrig.CamrigError) as refused:
            camrig.connect(host="127.0.0.1", token="not-the-key-of-it", **wrong).create_camera("g")
        assert refused.value.kind == "unauthorized"


def test_the_key_is_gone_with_its_rig():
    with camrig.start(SCENE) as short:
        key = pathlib.Path(short.info()["key_file"])
        assert key.exists() and key.read_text().strip() not in json.dumps(short.info()) and key.read_text().strip() in short.page_url
    assert not key.exists()


def test_with_open_loopback_everybody_commands_and_with_read_only_the_socket_alone():
    with camrig.start(SCENE, mode="lockstep", tcp=0, args=["--open-loopback"]) as rig:
        assert kind(post(rig, "world.step", {"seconds": 0.2})) == "done" and "key_file" not in rig.info() and "#" not in rig.page_url
        assert [kind(answer) for answer in over_tcp(rig.info()["tcp"], {"method": "world.step", "params": {"seconds": 0.2}})] == ["done"]
    with camrig.start(SCENE, mode="lockstep", tcp=0, args=["--read-only"]) as rig:
        for answer in (post(rig, "world.step", {"seconds": 1}), *over_tcp(rig.info()["tcp"], {"method": "world.step", "params": {"seconds": 1}})):
            assert kind(answer) == "unauthorized" and rig.info()["control"] in answer["error"]["message"]
        assert kind(post(rig, "world.status")) == "done"
        assert rig.step(seconds=0.2)["world_ns"] == 200_000_000


def test_a_runtime_folder_of_somebody_else_is_told_and_not_used(tmp_path):
    folder = tmp_path / "camrig"
    folder.mkdir()
    os.chown(folder, STRANGER, STRANGER)
    with camrig.start(SCENE, env={"XDG_RUNTIME_DIR": str(tmp_path)}) as rig:
        assert list(folder.iterdir()) == [] and "key_file" not in rig.info()
        assert f"{folder}: belongs to user {STRANGER}" in rig.log and "rm -r" in rig.log
        link = next(word for word in rig.log.split() if "#key=" in word)
        with camrig.connect(link) as other:
            other.create_camera("a", size=(64, 48))


def test_what_somebody_prepared_beside_the_socket_is_neither_used_nor_written_through(tmp_path):
    victim = tmp_path / "precious"
    victim.write_text("everything I own")
    control = tmp_path / "c.sock"
    for prepared in (tmp_path / "c.sock.d" / "devices.tree" / "dev", tmp_path / "c.sock.devices.tree" / "dev"):
        prepared.mkdir(parents=True)
        (prepared / "video10").symlink_to(victim)
        for folder in (prepared, prepared.parent, prepared.parent.parent):
            if folder != tmp_path:
                os.chown(folder, STRANGER, STRANGER)
    ended = serve("--control", str(control))
    assert ended.returncode == 1 and f"{control}.d: belongs to user {STRANGER}" in ended.stderr and "--control" in ended.stderr
    shutil.rmtree(tmp_path / "c.sock.d")
    (tmp_path / "c.sock.d").symlink_to(tmp_path)
    ended = serve("--control", str(control))
    assert ended.returncode == 1 and f"{control}.d: is no folder" in ended.stderr
    assert victim.read_text() == "everything I own"


def test_a_socket_of_somebody_else_is_told_nothing():
    """Whoever takes the name in /tmp first must not hear what the user commands."""
    if os.geteuid() != 0:
        pytest.skip("only root can be another user too")
    folder = tempfile.mkdtemp(dir="/tmp")  # which strangers can reach, unlike pytest's own
    os.chmod(folder, 0o1777)
    path = os.path.join(folder, "camrig.sock")
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.setgid(STRANGER)
            os.setuid(STRANGER)
            trap = socket.socket(socket.AF_UNIX)
            trap.bind(path)
            trap.listen()
            os.chmod(path, 0o777)  # which says that it listens
            for _ in range(2):
                connection = trap.accept()[0]
                os.write(writing, connection.recv(1000) + b".")
        finally:  # whatever happens: the tests go on in the other process
            os._exit(0)
    os.close(writing)
    try:
        wait_until(lambda: os.path.exists(path) and stat.S_IMODE(os.stat(path).st_mode) == 0o777, what="the trap")
        told = subprocess.run([os.environ["CAMRIG_BIN"], "call", "server.shutdown", "--control", path], capture_output=True, text=True, timeout=30, check=False)
        assert told.returncode == 1 and f"served by user {STRANGER}" in told.stderr, told.stderr
        with pytest.raises(camrig.CamrigError, match=f"served by user {STRANGER}") as refused:
            camrig.connect(path)
        assert refused.value.kind == "unauthorized"
        with os.fdopen(reading, "rb") as heard:
            assert heard.read() == b".."
        ended = serve("--control", path)
        assert ended.returncode == 1 and f"belongs to user {STRANGER}" in ended.stderr
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)
        shutil.rmtree(folder)


def test_a_second_rig_at_the_same_socket_says_what_is_wrong(rig):
    ended = serve("--control", rig.info()["control"])
    assert ended.returncode == 1 and ended.stderr.count("\n") == 1
    assert f"control socket {rig.info()['control']}: another rig lives there" in ended.stderr
    assert rig.status()["cameras"] == 1


def test_a_ready_descriptor_that_nobody_opened_is_an_error_and_not_one_of_the_rigs_own(tmp_path):
    ended = serve("--control", str(tmp_path / "c"), "--ready-fd", "3", stdin=subprocess.DEVNULL)
    assert ended.returncode == 1 and "--ready-fd 3" in ended.stderr and "3>" in ended.stderr


def test_a_scene_that_is_a_link_to_a_private_file_tells_nothing_of_it_over_the_network(rig, tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("zebra:x:0:0")
    links = []
    for name, target in (("there.json", secret), ("missing.json", tmp_path / "nothing")):
        links.append(tmp_path / name)
        links[-1].symlink_to(target)
    with camrig.connect(rig.http_url) as other:
        told = []
        for link in links:
            with pytest.raises(camrig.CamrigError) as refused:
                other.load(link)
            told.append((refused.value.kind, refused.value.message.replace(link.name, "")))
        assert told[0] == told[1] and "zebra" not in told[0][1] and "log" in told[0][1]
    with pytest.raises(camrig.CamrigError, match="not JSON"):
        rig.load(links[0])


def test_a_check_tells_nothing_of_a_foreign_file_over_the_network(rig, tmp_path):
    (tmp_path / "private.json").write_text('{"camrig_scene": 1, "name": "mine", "zebra": 7}')
    with camrig.connect(rig.http_url) as other:
        with pytest.raises(camrig.CamrigError, match="only in the rig's log") as refused:
            other.call("scene.check", scene=str(tmp_path / "private.json"))
        assert "zebra" not in refused.value.message
        assert other.call("scene.check", scene="minimal")["errors"] == []
    assert "zebra" in str(rig.call("scene.check", scene=str(tmp_path / "private.json"))["errors"])


def test_clients_that_are_gone_hold_no_places(rig):
    """Also those who wait for what comes never, in a world that stands, and whose requests are as many as are taken at a time."""
    path = rig.info()["control"]
    late = {"jsonrpc": "2.0", "id": 1, "method": "camera.set", "params": {"name": "main", "vfov_deg": 50, "at_ns": 5 * 10**9}}
    for number in range(80):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(path)
            client.sendall((json.dumps(late) + "\n").encode() * (70 if number % 16 == 5 else 1))
            if number < 60:  # the requests are there before the end is
                assert rig.status()["cameras"] == 1
    with camrig.connect(path) as other:
        assert other.status()["cameras"] == 1


def test_the_file_of_a_backdrop_tells_nothing_of_itself_over_the_network(rig, tmp_path):
    (tmp_path / "there.png").write_text("zebra:x:0:0")
    with camrig.connect(rig.http_url) as other:
        camera = other.create_camera("eye", size=(64, 48))
        told = set()
        for name in ("there.png", "none.png"):
            backdrop = {"kind": "plate", "file": str(tmp_path / name)}
            proxies = {**backdrop, "file": str(REPOSITORY / "scenes" / "none.png"), "proxies": {"file": backdrop["file"]}}
            for command in (lambda: camera.set(backdrop=backdrop), lambda: other.create_camera("two", size=(64, 48), backdrop=backdrop), lambda: camera.set(backdrop=proxies)):
                with pytest.raises(camrig.CamrigError) as refused:
                    command()
                told.add(refused.value.message.replace(name, ""))
        assert len(told) == 1 and "only in the rig's log" in told.pop()
        with pytest.raises(camrig.CamrigError, match="no such file"):
            camera.set(backdrop={"kind": "plate", "file": str(REPOSITORY / "scenes" / "none.png")})
        with pytest.raises(camrig.CamrigError, match="absolute path"):
            camera.set(backdrop={"kind": "plate", "file": "none.png"})
    with pytest.raises(camrig.CamrigError, match="no such file"):
        rig.camera("eye").set(backdrop={"kind": "plate", "file": str(tmp_path / "none.png")})


def test_of_the_scenes_own_folder_the_network_is_told_what_is_missing_but_not_where_a_link_leads(tmp_path):
    own = tmp_path / "scenes"
    own.mkdir()
    (own / "scene.json").write_text('{"camrig_scene": 1, "name": "empty"}')
    (own / "link.json").symlink_to(tmp_path / "nothing")
    with camrig.start(own / "scene.json") as rig, camrig.connect(rig.http_url) as other:
        with pytest.raises(camrig.CamrigError, match="no such file"):
            other.load(own / "missing.json")
        with pytest.raises(camrig.CamrigError, match="only in the rig's log"):
            other.load(own / "link.json")


def test_the_link_of_an_ipv6_address_has_its_brackets(tmp_path):
    with camrig.start(SCENE, args=["--host", "::1"]) as rig:
        link = next(word for word in rig.log.split() if "#key=" in word)
        assert link.startswith("http://[::1]:") and "http://::1" not in rig.log
        with camrig.connect(link.split("#")[0]) as other:
            other.create_camera("a", size=(64, 48))
