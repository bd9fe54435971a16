"""Cameras whose picture is a photo that people walk in."""

import contextlib
import fcntl
import json
import signal
import socket
import struct
import threading
import time

import cv2
import numpy as np
import pytest

import camrig
from conftest import REPOSITORY, wait_until

CORNER = {"place": "corner", "size": (640, 480), "fps": 25}


def empty_street(rig, path, **camera):
    """The street as a camera sees it with nobody in it, as a file; the street is then as it was."""
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    cam = rig.create_camera("before", **{**CORNER, **camera})
    rig.step(seconds=0.04)
    picture = cam.frame().image
    cv2.imwrite(str(path), picture)
    rig.load("street")
    return picture


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_plate_of_the_street_is_the_street(rig, tmp_path):
    """Pictures, depth, ids and truth are those of a camera that sees the scene itself."""
    plate = tmp_path / "street.png"
    empty = empty_street(rig, plate)
    seen = rig.create_camera("seen", **CORNER)
    shown = rig.create_camera("shown", **CORNER, backdrop={"file": str(plate), "proxies": {"scene": "proxies"}})
    people = 0
    for _ in range(5):
        rig.step(seconds=0.4)
        assert np.array_equal(seen.frame().image, shown.frame().image)
        assert not np.array_equal(seen.frame().image, empty)
        for kind in ("depth", "instance", "semantic", "normal"):
            assert np.array_equal(seen.frame(kind=kind).image, shown.frame(kind=kind).image), kind
        assert np.array_equal(seen.flow(), shown.flow(), equal_nan=True)
        of_scene, of_plate = seen.truth(), shown.truth()
        assert of_plate["objects"] == of_scene["objects"]
        assert (of_scene["depth_source"], of_scene["backdrop"], of_scene["ignore"]) == ("render", None, [])
        assert (of_plate["depth_source"], of_plate["backdrop"]) == ("proxy", {"kind": "plate", "file": str(plate)})
        people += sum(one["class"] == "person" and one["pixels"] > 100 for one in of_plate["objects"])
    assert people > 5


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_pose_that_is_a_degree_off_is_seen_and_truth_stays_that_of_the_picture(rig, tmp_path):
    """People are drawn where that camera has them, and truth says so; the photo, clicks and another camera say that it is wrong."""
    photo = tmp_path / "street.png"
    empty = empty_street(rig, photo, quality="fast")
    seen = rig.create_camera("seen", **CORNER, quality="fast")
    pose = seen.get()["pose"]
    right, wrong = (rig.create_camera(name, size=CORNER["size"], fps=25, quality="fast", intrinsics=seen.get()["intrinsics"], position=pose["position"],
                                      pan_deg=pose["pan_deg"], tilt_deg=pose["tilt_deg"] + off_deg, roll_deg=pose["roll_deg"],
                                      backdrop={"file": str(photo), "proxies": {"scene": "proxies"}}) for name, off_deg in (("right", 0), ("wrong", 1)))
    rig.step(seconds=0.8)
    movers = [actor["id"] for actor in rig.actors()]
    ids, changed = wrong.frame(kind="instance").image, (wrong.frame().image != empty).any(-1)
    drawn = np.isin(ids, movers)
    # Windows are glass, which has no ids; a few pixels of anybody may have the colour that the photo has there.
    assert np.mean(changed[drawn]) > 0.98 and np.mean(drawn[changed]) > 0.85, (np.mean(changed[drawn]), np.mean(drawn[changed]))
    for one in wrong.truth()["objects"]:
        if one["id"] in movers and one["box"] is not None:
            assert tuple(one["box"]) == cv2.boundingRect((ids == one["id"]).astype(np.uint8)), one
    # Looking higher by a degree, the camera has everybody lower by its focal length times that.
    at = {name: {one["id"]: one for one in cam.truth()["objects"] if one["class"] == "person" and one["visible_fraction"] == 1 and one["truncated"] == 0}
          for name, cam in (("seen", seen), ("right", right), ("wrong", wrong))}
    degree_px = seen.K[1, 1] * np.tan(np.radians(1))
    both = at["seen"].keys() & at["wrong"].keys()
    shifts = [at["wrong"][n]["box"][1] - at["seen"][n]["box"][1] for n in both]
    assert len(both) > 3 and degree_px > 5 and np.abs(np.array(shifts) - degree_px).max() < 0.2 * degree_px + 1, (degree_px, shifts)
    boxes = {name: {n: one["box"] for n, one in people.items()} for name, people in at.items()}
    assert all(boxes["right"][n] == box for n, box in boxes["seen"].items() if n in boxes["right"]) and len(boxes["right"].keys() & boxes["seen"].keys()) > 3
    street = seen.frame().image
    assert np.array_equal(right.frame().image, street) and not np.array_equal(wrong.frame().image, street)
    # Places that were measured: their clicks are off by as much, and give the pose that is right.
    places = np.array([[x, y, 0] for x in (-3, 0, 4, 8) for y in (-4, 0, 3)] + [[3, 0, 2], [0, 3, 2.5]], float)
    clicks = seen.project(places)
    shown = ~np.isnan(clicks).any(-1) & (clicks > 0).all(-1) & (clicks < CORNER["size"]).all(-1)
    places, clicks = places[shown], clicks[shown]
    residuals = wrong.project(places) - clicks
    assert len(places) >= 5 and (np.abs(residuals[:, 1] - degree_px) < 0.2 * degree_px).all(), residuals
    found = rig.calibrate_plate(CORNER["size"], points=[{"px": px.tolist(), "m": m.tolist()} for px, m in zip(clicks, places)],
                                intrinsics=wrong.get()["intrinsics"])["camera"]["pose"]
    assert wrong.get()["pose"]["tilt_deg"] - found["tilt_deg"] == pytest.approx(1, abs=0.01)


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_stream_of_another_size_shows_the_photo_scaled_once(rig, tmp_path):
    plate = tmp_path / "street.png"
    empty = empty_street(rig, plate, size=(1280, 960))
    backdrop = {"file": str(plate), "proxies": {"scene": "hidden", "boxes": [{"position": [10, 0, 0], "size": [1, 1, 1]}]},
                "ignore": [{"polygon_px": [[100, 200], [140, 200], [140, 300]], "object_class": "car"}]}
    half = rig.create_camera("half", **CORNER, backdrop=backdrop)
    done = rig.record(tmp_path / "set", ["half"], frames=1)
    coco = json.loads((tmp_path / "set" / "coco.json").read_text())
    assert done["frames"] == 1
    assert [[*one["bbox"], one["segmentation"]] for one in coco["annotations"] if one["iscrowd"]] == [
        [50.25, 100.25, 20.0, 50.0, [[50.25, 100.25, 70.25, 100.25, 70.25, 150.25]]]]
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    rig.step(seconds=0.04)
    linear = np.where(empty / 255 <= 0.04045, empty / 255 / 12.92, ((empty / 255 + 0.055) / 1.055) ** 2.4)
    mean = linear.reshape(480, 2, 640, 2, 3).mean(axis=(1, 3))
    codes = 255 * np.where(mean <= 0.0031308, 12.92 * mean, 1.055 * mean ** (1 / 2.4) - 0.055)
    assert np.abs(half.frame().image - codes).max() < 0.51
    assert half.truth()["ignore"] == [{"polygon_px": [[49.75, 99.75], [69.75, 99.75], [69.75, 149.75]], "class": "car"}]
    assert half.truth()["objects"] == []
    # What a camera answers makes it again.
    again = rig.call("camera.create", **{**half.get(), "name": "again", "outputs": []})
    assert again["backdrop"] == half.get()["backdrop"]


def with_orientation(jpeg, orientation):
    """The JPEG as a camera held upright writes it."""
    tiff = b"MM\0*\0\0\0\x08" + b"\0\x01" + struct.pack(">HHIHH", 0x0112, 3, 1, orientation, 0) + b"\0\0\0\0"
    body = b"Exif\0\0" + tiff
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:]


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_what_is_wrong_is_said_with_its_place(rig, tmp_path):
    picture = np.full((480, 640, 3), 90, np.uint8)
    good, wide, turned, upright = (tmp_path / name for name in ("good.png", "wide.png", "turned.jpg", "upright.jpg"))
    cv2.imwrite(str(good), picture)
    cv2.imwrite(str(wide), picture[:360])
    jpeg = cv2.imencode(".jpg", picture)[1].tobytes()
    turned.write_bytes(with_orientation(jpeg, 6))
    upright.write_bytes(with_orientation(jpeg, 1))
    cut, text = tmp_path / "cut.png", tmp_path / "text.png"
    cut.write_bytes(good.read_bytes()[:300])
    text.write_text("no picture")
    ground = {"ground": {"polygon_m": [[1, -9], [30, -9], [30, 9]]}}
    pose = {"position": [0, 0, 2], "pan_deg": 0}

    def refused(file=good, proxies=ground, **more):
        with pytest.raises(camrig.CamrigError) as error:
            rig.call("camera.create", name="gate", pose=pose, backdrop={"file": str(file), "proxies": proxies}, **more)
        return str(error.value)

    assert "backdrop.file: must be an absolute path" in refused("gate.png")
    assert "backdrop.file" in refused(tmp_path / "none.png") and "none.png" in refused(tmp_path / "none.png")
    assert "a picture of 640x360 for a camera of 640x480" in refused(wide)
    assert "is stored turned (Exif orientation 6); save it upright" in refused(turned)
    assert "PNG: " in refused(cut) and "neither a PNG nor a JPEG" in refused(text)
    assert "backdrop.proxies: there are none" in refused(proxies={})
    assert "backdrop.proxies.file: " in refused(proxies={"file": str(tmp_path / "none.glb")})
    assert "ground.polygon_px[1]: is over the horizon" in refused(proxies={"ground": {"polygon_px": [[9, 400], [9, 20], [99, 400]]}})
    assert "cutouts[0].foot_px: is over the horizon" in refused(
        proxies={"cutouts": [{"polygon_px": [[9, 9], [20, 9], [20, 99]], "foot_px": [15, 100]}]})
    foot = {"foot_px": [320, 400]}
    assert "cutouts[0]: give one of polygon_px and mask" in refused(proxies={"cutouts": [foot]})
    assert "cutouts[0].mask: " in refused(proxies={"cutouts": [{**foot, "mask": str(wide)}]})
    assert "is 640x360, and the picture is 640x480" in refused(proxies={"cutouts": [{**foot, "mask": str(wide)}]})
    assert "good.png: marks nothing" in refused(proxies={"cutouts": [{**foot, "mask": str(good)}]})
    assert "ptz: a camera with a backdrop stands still" in refused(ptz={})
    cam = rig.create_camera("gate", position=(0, 0, 2), pan_deg=0, backdrop={"file": str(upright), "proxies": {**ground, "scene": "hidden"}})
    with pytest.raises(camrig.CamrigError, match="seconds: a camera with a backdrop stands still"):
        rig.call("camera.set", name="gate", pose=pose, seconds=2)
    with pytest.raises(camrig.CamrigError, match="has a backdrop"):
        rig.fault.set("gate", "knock")
    rig.step(seconds=0.04)
    assert np.abs(cam.frame().image.astype(int) - 90).max() <= 1


def test_the_example_of_the_guide_is_a_scene(tmp_path):
    page = (REPOSITORY / "docs" / "backdrops.md").read_text()
    (tmp_path / "gate.json").write_text(page.split("```json")[1].split("```")[0])
    photo = np.random.default_rng(4).integers(0, 256, (720, 1280, 3), np.uint8)
    cv2.imwrite(str(tmp_path / "gate.jpg"), photo)
    with camrig.start(str(tmp_path / "gate.json"), mode="lockstep") as rig:
        gate = rig.camera("gate")
        seen = []
        for _ in range(12):
            rig.step(seconds=1.0)
            truth = gate.truth()
            seen += [one["visible_fraction"] for one in truth["objects"] if one["name"] == "anna"]
        assert len(seen) == 12 and min(seen) < 0.9 < max(seen), "she goes behind the pole"


def test_a_scene_file_has_its_photo_beside_it(tmp_path):
    cv2.imwrite(str(tmp_path / "gate.png"), np.full((120, 160, 3), 60, np.uint8))
    camera = {"name": "gate", "size": [160, 120], "pose": {"position": [0, 0, 2], "tilt_deg": -10},
              "backdrop": {"kind": "plate", "file": "gate.png", "proxies": {"ground": {"polygon_m": [[1, -9], [30, -9], [30, 9], [1, 9]]}}}}
    scene = tmp_path / "gate.json"
    scene.write_text(json.dumps({"camrig_scene": 1, "name": "gate", "cameras": [camera]}))
    with camrig.start(str(scene), mode="lockstep") as rig:
        rig.step(seconds=0.04)
        gate = rig.camera("gate")
        assert (gate.frame().image == 60).all()
        depth = gate.depth()
        assert np.isinf(depth[0]).all() and np.isfinite(depth[100, 80])
    camera["backdrop"]["file"] = "nowhere.png"
    scene.write_text(json.dumps({"camrig_scene": 1, "name": "gate", "cameras": [camera]}))
    with pytest.raises(camrig.CamrigError, match=r"cameras\[0\]\.backdrop\.file: .*nowhere\.png"):
        camrig.start(str(scene), mode="lockstep").close()


@pytest.mark.camrig(scene="minimal", mode="lockstep")
def test_a_mask_cuts_out_what_it_marks(rig, tmp_path):
    """As far as its foot is away, pixel by pixel."""
    photo, mask = tmp_path / "gate.png", tmp_path / "tree.png"
    cv2.imwrite(str(photo), np.full((240, 320, 3), 90, np.uint8))
    marks = np.zeros((240, 320), np.uint8)
    cv2.circle(marks, (160, 120), 40, 255, -1)
    cv2.imwrite(str(mask), marks)
    cutout = {"mask": str(mask), "foot_px": [160, 200]}
    cam = rig.create_camera("gate", size=(320, 240), position=(0, 0, 2), pan_deg=0, backdrop={"file": str(photo), "proxies": {"scene": "hidden", "cutouts": [cutout]}})
    rig.step(seconds=0.04)
    depth = cam.frame(kind="depth").image
    assert np.array_equal(np.isfinite(depth), marks > 0)
    foot_m = 2 / ((200 - cam.K[1, 2]) / cam.K[1, 1])
    assert depth[marks > 0] == pytest.approx(foot_m, rel=1e-3)  # its plane faces the foot, half a pixel aside
    assert rig.call("camera.get", name="gate")["backdrop"]["proxies"]["cutouts"][0]["mask"] == str(mask)


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "place.png"
    cv2.imwrite(str(path), np.full((48, 64, 3), 90, np.uint8))
    return path


def plate_of(photo):
    return {"file": str(photo), "proxies": {"scene": "proxies"}}


@contextlib.contextmanager
def being_read(path):
    """Until the end of this, reading the file takes. Gives what waits until somebody reads it."""
    with open(path, "r+b") as file:
        fcntl.fcntl(file, fcntl.F_SETSIG, signal.SIGURG)  # which does nothing
        fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)  # who opens it waits
        try:
            yield lambda: wait_until(lambda: fcntl.fcntl(file, fcntl.F_GETLEASE) == fcntl.F_RDLCK, what="a reader")
        finally:
            fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_UNLCK)


def lines_to(rig, *requests):
    """A connection on which these were sent."""
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(30)
    client.connect(rig.info()["control"])
    client.sendall("".join(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": params}) + "\n" for method, params in requests).encode())
    return client


def answers(client, count):
    with client, client.makefile() as lines:
        return [json.loads(lines.readline()) for _ in range(count)]


@pytest.mark.parametrize("way", ["control", "http"])
def test_nobody_waits_while_a_backdrop_is_read(rig, photo, way):
    camera = rig.create_camera("eye", size=(64, 48))
    with camrig.connect(rig.info()["control"] if way == "control" else rig.http_url) as asks, camrig.connect(rig.http_url) as other:
        with being_read(photo) as begun:
            asking = threading.Thread(target=lambda: asks.camera("eye").set(backdrop=plate_of(photo)))
            asking.start()
            begun()
            assert rig.status()["cameras"] == other.status()["cameras"]
            assert asking.is_alive() and camera.get()["backdrop"] is None
        asking.join()
    assert camera.get()["backdrop"]["file"] == str(photo)


def test_what_is_sent_behind_a_backdrop_is_done_behind_it(rig, photo):
    camera = rig.create_camera("eye", size=(64, 48), vfov_deg=50)
    with being_read(photo) as begun:
        client = lines_to(rig, ("camera.set", {"name": "eye", "vfov_deg": 40, "backdrop": plate_of(photo)}), ("camera.set", {"name": "eye", "vfov_deg": 30}))
        begun()
        assert camera.get()["vfov_deg"] == pytest.approx(50)
    assert [answer["result"]["vfov_deg"] for answer in answers(client, 2)] == pytest.approx([40, 30])
    assert camera.get()["vfov_deg"] == pytest.approx(30)


@pytest.mark.camrig(mode="realtime", args=["--held"])
def test_a_backdrop_comes_at_its_time_however_long_it_is_read(rig, photo):
    """As a farm gives commands: the world may run on only behind the command, on that connection."""
    rig.call("world.limit", until_ns=300_000_000)
    with being_read(photo) as begun:
        params = {"name": "eye", "size": [64, 48], "backdrop": plate_of(photo), "at_ns": 400_000_000}
        client = lines_to(rig, ("camera.create", params), ("world.limit", {"until_ns": 10**12}))
        begun()
        wait_until(lambda: rig.status()["world_ns"] == 300_000_000, what="the limit")
        time.sleep(0.2)
        assert rig.status()["world_ns"] == 300_000_000
    assert answers(client, 2)[0]["result"]["applied_ns"] == 400_000_000


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_log_with_backdrops_makes_the_same_cameras_again(tmp_path, mode):
    """The world that is made again does not run on while a large one is read."""
    photo, log = tmp_path / "place.png", tmp_path / "commands.log"
    cv2.imwrite(str(photo), np.random.default_rng(1).integers(0, 255, (1920, 2560, 3), np.uint8))
    with camrig.start("minimal", mode=mode, device="cpu", args=["--log", str(log)]) as rig:
        camera = rig.create_camera("eye", size=(64, 48))
        for vfov_deg in (50, 40):
            camera.set(vfov_deg=vfov_deg, backdrop=plate_of(photo))
            camera.set(vfov_deg=vfov_deg + 5)
            if mode == "lockstep":
                rig.step(seconds=0.05)
        world_ns = rig.status()["world_ns"]
        before = rig.call("world.digest", at_ns=world_ns + (mode == "realtime") * 6_000_000_000)  # time for the next rig to be asked
    with camrig.start("minimal", mode=mode, device="cpu", args=["--replay", str(log)]) as rig:
        after = rig.call("world.digest", at_ns=before["world_ns"])
        assert rig.camera("eye").get()["backdrop"]["file"] == str(photo)
    assert (after["cameras"], after["world"]) == (before["cameras"], before["world"])
