"""One HTTP address for a farm: its page in Chromium, curl and ffmpeg, and who may do what."""

import contextlib
import http.client
import json
import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest
import test_web_plate
from conftest import REPOSITORY, wait_until
from test_command_log import SMALL
from test_farm import all_nodes, farm, nodes_of, rigs_of, shows_pictures
from web_page import chromium, opened, pixels, until, wait_for_picture

import camrig

sys.path.insert(0, str(REPOSITORY / "tests" / "farm"))
from live_parts import farm as live_farm  # noqa: E402


photo = test_web_plate.photo


def ask(url, *, post=None, **headers):
    """(status, body as text)"""
    body = None if post is None else json.dumps(post).encode()
    fields = {name.replace("_", "-"): value for name, value in headers.items()} | ({"Content-Type": "application/json"} if body else {})
    try:
        with urllib.request.urlopen(urllib.request.Request(url, body, fields), timeout=30) as reply:
            return reply.status, reply.read().decode("latin-1")
    except urllib.error.HTTPError as refused:
        return refused.code, refused.read().decode("latin-1")


def call(url, method, params=None, **headers):
    """The result, or the kind of the error."""
    status, text = ask(url + "rpc", post={"jsonrpc": "2.0", "id": 1, "method": method, "params": params or {}}, **headers)
    answer = json.loads(text)
    return answer["result"] if "result" in answer else answer["error"].get("kind") or answer["error"]["data"]["kind"]


def owner_of(rig, camera):
    return next(each["node"] for each in rig.call("farm.status")["cameras"] if each["camera"] == camera)


def one_camera_of_each(rig):
    for number in range(6):
        rig.call("camera.create", name=f"eye{number}", fps=10, **SMALL)
    all_nodes(rig, 2)  # one that is held up for its lease is away for a moment
    found = {owner_of(rig, f"eye{number}"): f"eye{number}" for number in range(6)}
    assert set(found) == {"node1", "node2"}
    return found


def curl(*words):
    return subprocess.run(["curl", "-s", *words], capture_output=True, timeout=60).stdout


def test_the_page_of_a_farm_shows_all_cameras_and_commands_all_nodes():
    with farm("--no-replace", scene="minimal") as (rig, facts), chromium() as browser:
        cameras = one_camera_of_each(rig)
        assert rig.page_url.startswith(facts["http"] + "#key=")  # what Python says is the farm's page, not a node's
        with opened(browser, rig.page_url) as page:
            for camera in cameras.values():  # of either node
                until(page, f"document.querySelector('.tile[data-camera={camera}] canvas').dataset.frames > 2")
            page.click("#create")
            page.fill("#new-camera [name=name]", "made")
            page.select_option("#new-camera [name=place]", "main")
            page.fill("#new-camera [name=width]", "320")
            page.fill("#new-camera [name=height]", "240")
            page.click("#new-camera button[value=ok]")
            until(page, "document.getElementById('stage-name').textContent === 'made' && document.getElementById('picture').width === 320")
            before, pan = pixels(page), rig.camera("made").get()["pose"]["pan_deg"]
            page.focus("#view")
            for _ in range(3):
                page.keyboard.press("ArrowLeft")
            for name, one in rigs_of(rig).items():
                wait_until(lambda: one.camera("made").get()["pose"]["pan_deg"] == pytest.approx(pan + 12), what=f"the pan on {name}")
            wait_for_picture(page, before, 1)

        with opened(browser, facts["http"]) as page:  # without the key
            until(page, "document.getElementById('picture').dataset.frames > 2")
            page.focus("#view")
            page.keyboard.press("ArrowRight")
            page.wait_for_selector("text=commands need this farm's key")
            assert [one.camera("made").get()["pose"]["pan_deg"] for one in rigs_of(rig).values()] == [pytest.approx(pan + 12)] * 2
            # A node dies: the page that is open shows its camera again, by the other.
            dying = next(node for node in all_nodes(rig) if not node["is_sequencer"])
            os.kill(dying["pid"], signal.SIGKILL)
            wait_until(lambda: len(nodes_of(rig)) == 1, what="the node to be gone")
            frames = f"Number(document.querySelector('.tile[data-camera={cameras[dying['node']]}] canvas').dataset.frames)"
            until(page, f"{frames} > {page.evaluate(frames) + 5}")


def test_stock_clients_reach_each_camera_at_the_farms_address_whoever_owns_it():
    with farm("--no-replace", scene="minimal") as (rig, facts):
        cameras = one_camera_of_each(rig)
        ports = {node["node"]: node["http"] for node in all_nodes(rig)}
        for node, camera in cameras.items():
            url = f"{facts['http']}cameras/{camera}/stream.mjpg"
            assert f"Location: http://127.0.0.1:{ports[node]}/cameras/{camera}/stream.mjpg?fps=5\r\n".encode() in curl("-D", "-", url + "?fps=5")
            assert shows_pictures("-L", url)
            assert shows_pictures("-H", "Sec-Fetch-Site: same-origin", url)  # as the page's own
            shown = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", url, "-frames:v", "3", "-f", "framecrc", "-"], capture_output=True, text=True, timeout=60)
            assert shown.returncode == 0 and len([line for line in shown.stdout.splitlines() if not line.startswith("#")]) == 3, shown.stderr
            assert curl(f"{facts['http']}cameras/{camera}/snapshot.jpg").startswith(b"\xff\xd8")
        # As the page does it: on one connection, each camera from its owner.
        live = ["curl", "-sN", "--max-time", "20", f"{facts['http']}live?cameras={','.join(cameras.values())}&width=160"]
        streams = lambda: [f'camrig_http_streams{{node="{node}"}} {count}\n' in ask(facts["http"] + "metrics")[1] for node in ports for count in (0, 1)]
        wait_until(lambda: streams() == [True, False] * 2, what="the streams above to be closed")
        with subprocess.Popen(live, stdout=subprocess.PIPE) as watching:
            shows = b""
            while not all(shows.count(f"X-Camera: {camera}\r\n".encode()) >= 2 for camera in cameras.values()):
                some = watching.stdout.read1()
                assert some, shows[:1000]
                shows += some
            wait_until(lambda: streams() == [False, True] * 2, what="one stream of each node")
            watching.kill()

        (staying, _), (dying, camera) = sorted(cameras.items(), key=lambda each: next(node["is_sequencer"] for node in all_nodes(rig) if node["node"] == each[0]), reverse=True)
        stream = f"{facts['http']}cameras/{camera}/stream.mjpg"
        passed = urllib.request.urlopen(urllib.request.Request(stream, headers={"Sec-Fetch-Site": "same-origin"}), timeout=30)
        assert passed.read(100)
        died = time.monotonic()
        os.kill(next(node["pid"] for node in all_nodes(rig) if node["node"] == dying), signal.SIGKILL)
        with contextlib.suppress(OSError, http.client.IncompleteRead):  # it ends
            while passed.read(65536):
                assert time.monotonic() < died + 30, "it goes on"
        wait_until(lambda: curl("-LN", "--max-time", "2", stream).count(b"X-Sequence") >= 2, 20, "the stream at the same URL")
        assert curl(f"{facts['http']}cameras/{camera}/snapshot.jpg").startswith(b"\xff\xd8") and owner_of(rig, camera) == staying


def test_the_page_of_photos_works_through_the_farm(photo, tmp_path):
    """What it does with a rig it does here, of either node: a photo becomes a scene, and a camera's picture is a photo."""
    with farm(scene="minimal") as (rig, _), chromium() as browser:
        for number, does in enumerate((test_web_plate.test_a_photo_becomes_a_scene_that_runs, test_web_plate.test_the_photo_of_a_camera_of_the_rig_is_shown_with_its_lens)):
            (tmp_path / str(number)).mkdir()
            with test_web_plate.plate_page(rig, browser, photo) as plate:
                does(rig, plate, photo, tmp_path / str(number))


def test_without_the_key_one_looks_and_a_page_of_another_origin_does_neither():
    with farm(scene="minimal") as (rig, facts):
        rig.call("camera.create", name="eye", fps=5, **SMALL)
        url, wish = facts["http"], {"name": "eye", "vfov_deg": 33}
        with open(facts["key_file"]) as file:
            key = {"Authorization": f"Bearer {file.read().strip()}"}
        assert os.stat(facts["key_file"]).st_mode & 0o777 == 0o600
        assert {camera["name"] for camera in call(url, "camera.list")["cameras"]} >= {"eye"}
        wait_until(lambda: len(call(url, "farm.status")["nodes"]) == 2, what="both nodes")
        # What goes into the log, what is the door's, and what a node alone knows to be more than looking.
        for method in ("camera.set", "world.step", "farm.scale", "server.shutdown", "plate.calibrate", "world.save"):
            assert call(url, method, wish) == "unauthorized"
            assert call(url, method, wish, Authorization="Bearer 0123456789abcdef") == "unauthorized"
        assert call(url, "plate.calibrate", wish, **key) == "invalid_argument"
        assert call(url, "camera.set", wish, **key)["vfov_deg"] == pytest.approx(33)
        for foreign in ({"Origin": "http://evil.example"}, {"Sec_Fetch_Site": "cross-site"}, {"Host": "evil.example"}):
            assert call(url, "camera.set", {"name": "eye", "vfov_deg": 44}, **key, **foreign) == "unauthorized"
        for foreign in ({"Referer": "http://evil.example/x"}, {"Sec_Fetch_Site": "same-site"}, {"Host": "evil.example"}):
            for path in ("cameras/eye/snapshot.jpg", "cameras/eye/stream.mjpg", "metrics", "cameras"):
                assert ask(url + path, **foreign)[0] == 403
        assert rig.camera("eye").get()["vfov_deg"] == pytest.approx(33)
        # The same protocol as on its socket, within bounds.
        both = ask(url + "rpc", post=[{"jsonrpc": "2.0", "id": each, "method": "world.status"} for each in (1, 2)])
        assert [answer["id"] for answer in json.loads(both[1])] == [1, 2]
        assert ask(url + "rpc", post={"jsonrpc": "2.0", "method": "world.status"}) == (204, "")
        assert ask(url + "rpc", post="x" * (1 << 20))[0] == 413 and ask(url + "rpc")[0] == 405
        for params in ("x", [1]):
            assert call(url, "camera.list", params) == call(url, "camera.set", params, **key) == "invalid_argument"
        longest = b'{"id":1,"method":"camera.get","params":{"name":"%s"}}' % (b"x" * ((1 << 20) - 51))
        with urllib.request.urlopen(urllib.request.Request(url + "rpc", longest, {"Content-Type": "application/json"}), timeout=30) as reply:
            assert len(longest) == 1 << 20 and json.load(reply)["error"]["message"] == "the request is too long"
        all_nodes(rig)  # none is taken for dead
        assert b"is a path" in curl("-X", "OPTIONS", "--request-target", "*", url)
        for target in ("*", "@127.0.0.1:1/x", "x:1/x", "//127.0.0.1:1/x", "/cameras/../x"):
            assert curl("--path-as-is", "--request-target", target, "-o", os.devnull, "-w", "%{http_code}", url) in (b"400", b"404"), target
        assert b"HTTP/1.1 415" in curl("-D", "-", "-d", "{}", url + "rpc")
        assert call(url, "frame.get", {"camera": "eye", "encoding": "bytes"}, **key) == "invalid_argument"
        # Python finds the key by itself.
        host, _, port = url.removeprefix("http://").rstrip("/").partition(":")
        camrig.connect(f"http://{host}:{port}").call("camera.set", name="eye", vfov_deg=55)
        # The other node follows the log.
        wait_until(lambda: [one.camera("eye").get()["vfov_deg"] for one in rigs_of(rig).values()] == [pytest.approx(55)] * 2, what="both nodes' field of view")
    assert not os.path.exists(facts["key_file"])


def test_with_a_token_every_request_shows_it(tmp_path):
    token = tmp_path / "token"
    token.write_text("0123456789abcdef\n")
    far_away = ("--host", "127.0.0.2", "--token-file", str(token))
    with live_farm.Farm(tmp_path, "minimal", nodes=2, node_options=far_away, door_options=("--token-file", str(token), "--http", "127.0.0.1:0")) as far:
        far.rig.call("camera.create", name="cam", fps=5, **SMALL)
        url, known = far.door["http"], {"Authorization": "Bearer 0123456789abcdef"}
        for path in ("", "cameras", "cameras/cam/stream.mjpg", "metrics", "?token=fedcba9876543210"):
            assert ask(url + path)[0] == 401
        assert call(url, "camera.set", {"name": "cam", "vfov_deg": 33}, **known)["vfov_deg"] == pytest.approx(33)
        assert "key_file" not in call(url, "server.info", **known) and "key_file" not in far.door
        # A token in the URL goes along; one in a header field would not, so the stream comes from here.
        stream = f"{url}cameras/cam/stream.mjpg"
        assert b"Location: http://127.0.0.2:" in curl("-D", "-", stream + "?token=0123456789abcdef")
        for words in (["-LN", stream + "?token=0123456789abcdef"], ["-N", "-H", "Authorization: Bearer 0123456789abcdef", stream]):
            assert shows_pictures(*words)
        opening = urllib.request.urlopen(url + "?token=0123456789abcdef", timeout=30)
        assert "HttpOnly" in opening.headers["Set-Cookie"] and "SameSite=Strict" in opening.headers["Set-Cookie"]
        assert ask(url + "cameras/cam/snapshot.jpg", Cookie=opening.headers["Set-Cookie"].split(";")[0])[0] == 200
