"""docs/getting-started.md, docs/recipes.md and docs/devices.md do what they say: their blocks run as they stand, but for the ports, in their order and
in an environment as a reader has it. docs/troubleshooting.md quotes what is said."""

import json
import os
import re
import subprocess

import pytest

import camrig
from conftest import REPOSITORY
from ports import free_port
from rtsp_client import assert_gst_read_to_the_end
from test_docs import blocks, environment, hall, ported, run, shell  # noqa: F401  (fixtures)


def test_getting_started_works_from_the_first_block_to_the_last(hall, environment, tmp_path):  # noqa: F811
    found = blocks("docs/getting-started.md", "sh")
    said = {block.split("\n")[0]: shell(block, hall, environment, tmp_path) for block in found}
    assert len(said) == len(found) >= 5
    front = next(text for block, text in said.items() if "--position 8,4,2.2" in block)
    assert "(480, 640, 3)" in front
    kept = next(text for block, text in said.items() if "> cameras.json" in block)
    assert [line.split()[0] for line in kept.splitlines()[-3:]] == ["lobby", "entrance", "gallery"]
    assert '"front"' in (tmp_path / "cameras.json").read_text()

    # And back again, as the text promises.
    run(["bash", "-euc", "camrig camera delete lobby; camrig camera delete entrance; camrig camera delete gallery; camrig camera create --file cameras.json"],
        env=environment, cwd=tmp_path)
    assert [camera.name for camera in hall.cameras()] == ["lobby", "entrance", "gallery", "front"]
    assert hall.camera("front").get()["pose"]["pan_deg"] == pytest.approx(40)

    (program,) = blocks("docs/getting-started.md", "python")
    assert "(480, 640, 3)" in run(["python", "-c", program], env=environment, cwd=tmp_path)

    (test,) = blocks("docs/getting-started.md", "python test")
    (tmp_path / "test_detector.py").write_text(test + "\n\ndef test_without_a_marker(rig):\n    rig.create_camera('a').frame()\n")
    assert "2 passed" in run(["python", "-m", "pytest", "-q", "test_detector.py"], env=environment, cwd=tmp_path)


def test_the_recipes_work(hall, environment, tmp_path):  # noqa: F811
    for block in blocks("docs/recipes.md", "sh"):
        if not block.startswith("gst-launch-1.0"):
            shell(block, hall, environment, tmp_path)
            continue
        for line in ported(block, hall).splitlines():  # each judged by more than how it ends
            done = subprocess.run(["bash", "-euc", line], env=environment, cwd=tmp_path, capture_output=True, timeout=120, check=False)
            assert_gst_read_to_the_end(done.returncode, done.stdout, done.stderr)
    assert (tmp_path / "ros2").is_dir() and (tmp_path / "both.mp4").stat().st_size > 10_000
    (program,) = blocks("docs/recipes.md", "python")
    assert "(480, 640, 3)" in run(["python", "-c", ported(program, hall)], env=environment, cwd=tmp_path)


def test_cameras_are_made_onvif_devices_as_the_page_says(hall, environment, tmp_path):  # noqa: F811
    made = re.findall("^camrig camera create .*--onvif.*$", (REPOSITORY / "docs/onvif.md").read_text(), re.MULTILINE)
    for line in made:
        port = free_port()
        run(["bash", "-euc", re.sub("--onvif [0-9]+", f"--onvif {port}", line)], env=environment, cwd=tmp_path)
        (output,) = [output for output in hall.camera(line.split()[3]).get()["outputs"] if output["kind"] == "onvif"]
        assert output["port"] == port and output.get("move_status") == ("none" if "--onvif-move-status none" in line else None)
    assert len(made) == 2


def test_the_devices_page_works(hall, environment, tmp_path):  # noqa: F811
    (block,) = blocks("docs/devices.md", "sh")
    # OpenCV asks every camera for 640x480; this one's nearest size of its own shape is that.
    assert "(360, 640, 3)" in shell(block, hall, environment, tmp_path)
    assert (tmp_path / "door.mp4").stat().st_size > 10_000


def test_the_sensor_page_works(hall, environment, tmp_path):  # noqa: F811
    for block in blocks("docs/sensor.md", "sh"):
        if "sensor fit" in block:
            continue  # of pictures of a real camera: test_sensor_fit.py makes some
        shell(block, hall, environment, tmp_path)
    assert (tmp_path / "picture.raw").stat().st_size == 2 * 640 * 480
    assert hall.camera("night").get()["sensor"]["lux"] == 5
    (program,) = blocks("docs/sensor.md", "python")
    shell("pip install ./control/python", hall, environment, tmp_path)
    electrons, black_level, exposure_s = (float(word) for word in run(["python", "-c", program], env=environment, cwd=tmp_path).split())
    assert electrons > 0 and black_level > 0 and exposure_s == 0.004


def test_the_page_of_heads_works(hall, environment, tmp_path):  # noqa: F811
    (block,) = blocks("docs/ptz.md", "sh")
    shell(block, hall, environment, tmp_path)
    assert hall.camera("dome").ptz.status()["tour"] is not None


def test_the_page_of_clocks_works(hall, environment, tmp_path):  # noqa: F811
    (block,) = blocks("docs/clocks.md", "sh")
    shell(block, hall, environment, tmp_path)
    assert hall.camera("gate").get()["clock"] == {**hall.camera("gate").get()["clock"], "state": "ntp", "offset_ns": 0, "drift_ppb": 50_000}
    assert hall.camera("garage").get()["clock"]["phase_ns"] == 13_000_000


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_the_page_of_the_python_package_works(rig, tmp_path, monkeypatch):
    """Its programs one after the other at one rig, as they share names; the one that connects elsewhere and the test are not run."""
    monkeypatch.chdir(tmp_path)
    known = {"camrig": camrig, "rig": rig, "cam": rig.camera("lobby")}
    programs = [block for block in blocks("control/python/README.md", "python") if "10.0.0.5" not in block and "pytest.mark" not in block]
    assert len(programs) == 5
    for program in programs[1:]:
        exec(compile(program, "control/python/README.md", "exec"), known)
    assert len(known["shot"]) == 2 and all(len(kinds) == 6 for kinds in known["shot"].values())
    assert (tmp_path / "dataset" / "yolo.yaml").is_file()
    exec(compile(programs[0], "control/python/README.md", "exec"), {})
    assert (tmp_path / "mine.png").is_file()


def test_troubleshooting_quotes_what_is_really_said(hall, environment, tmp_path):  # noqa: F811
    """Each message of the page is provoked; `...` in the page stands for what differs."""
    page = (REPOSITORY / "docs" / "troubleshooting.md").read_text()
    minimal = str(REPOSITORY / "scenes" / "minimal.json")
    other, http = str(tmp_path / "other.sock"), hall.http_url.rstrip("/")

    def failing(*command):
        done = subprocess.run([str(word) for word in command], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 1, (command, done.stdout, done.stderr)
        return done.stderr

    scene = json.loads((REPOSITORY / "scenes" / "minimal.json").read_text())
    scene["models"], scene["objects"], scene["actors"] = {}, [], [{"name": "a", "model": "nobody"}]
    (tmp_path / "bad.json").write_text(json.dumps(scene))
    (tmp_path / "token").write_text("0123456789abcdef")
    taken = tmp_path / "taken.sock"
    (tmp_path / "taken.sock.d").mkdir()
    os.chown(tmp_path / "taken.sock.d", 65534, 65534)
    with camrig.start(minimal, mode="lockstep", args=["--token-file", str(tmp_path / "token")]) as closed:
        unauthorized = run(["curl", "-si", closed.http_url + "/cameras"])
    said = {
        "Address already in use": failing("camrig", "serve", minimal, "--control", other, "--rtsp", 0, "--http", http.rsplit(":", 1)[1]),
        "another rig": failing("camrig", "serve", minimal, "--control", environment["CAMRIG_CONTROL"], "--rtsp", 0, "--http", 0),
        "device ... does not exist": failing("camrig", "serve", minimal, "--control", other, "--rtsp", 0, "--http", 0, "--device", 99),
        "belongs to user ... needs a private folder of that name": failing("camrig", "serve", minimal, "--control", taken, "--rtsp", 0, "--http", 0),
        "--ready-fd 3: no file is open": failing("camrig", "serve", minimal, "--control", other, "--rtsp", 0, "--http", 0, "--ready-fd", 3),
        "host ... can be reached by others, so it needs a token": failing("camrig", "serve", minimal, "--control", other, "--host", "0.0.0.0"),
        "bad.json: actors[0].model: ...": failing("camrig", "serve", "bad.json", "--control", other, "--rtsp", 0, "--http", 0),
        "no rig at ...": failing("camrig", "--control", other, "camera", "list"),
        "HTTP/1.1 401": unauthorized,
        "HTTP/1.1 403": run(["curl", "-si", "-H", "Host: example.org", http + "/cameras"]),
        "Host ... is not this server's": run(["curl", "-s", "-H", "Host: example.org", http + "/cameras"]),
        "DROPPED": run(["camrig", "stats"], env=environment),
        "dropped_for": run(["camrig", "--json", "stats"], env=environment),
        "X-World-Time-Ns": run(["curl", "-s", "-o", "/dev/null", "-D", "-", http + "/cameras/lobby/snapshot.jpg"]),
        "no answer from the rig": (REPOSITORY / "control/web/page/rpc.js").read_text(),
    }
    for quote, text in said.items():
        assert f"`{quote}`" in page, quote
        assert re.search(".*".join(map(re.escape, quote.split("..."))), text, re.DOTALL), (quote, text)
    # Nothing is quoted as said by the rig that is not provoked above.
    for symptom in re.findall(r"^\| ([^|]*) \|", page.split("## A program")[0], re.MULTILINE):
        for quote in re.findall(r"`([^`]*)`", symptom):
            assert quote in said, quote
    node = subprocess.run(["v4l2-ctl", "-d", "/dev/video7", "--all"], capture_output=True, text=True, check=False)
    assert node.returncode != 0, "/dev/video7 is there without camrig exec"
    for command in re.findall(r"`(camrig [a-z][^`]*?)`", page):
        words = command.split()[1:3]
        words = words[:1] if words[0] in ("exec", "probe", "call", "stats", "snapshot") else words
        run(["camrig", *words, "--help"], env=environment)
