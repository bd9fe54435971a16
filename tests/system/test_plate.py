"""`camrig plate`: the camera and the light of a photo, found as a user does, and people that fit into it."""

import json
import os
import subprocess

import cv2
import numpy as np
import pytest

import camrig
from conftest import REPOSITORY

CAMRIG = os.environ["CAMRIG_BIN"]


def plate(*arguments, good=True):
    done = subprocess.run([CAMRIG, "--json", "plate", *map(str, arguments)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode == 0) == good, done.stderr
    if good:
        return json.loads(done.stdout)
    assert done.stderr.count("\n") == 1, "one line"
    return done.stderr


def clicks(cam, points, error_px=0.0, seed=1):
    """Where a user clicks at points of the world, on whole pixels or a little off."""
    off = np.random.default_rng(seed).normal(0, error_px, (len(points), 2)) if error_px else 0
    return [{"px": px.tolist(), "m": list(m)} for px, m in zip(cam.project(np.array(points, float)) + off, points)]


GROUND = [(5, -2, 0), (5, 2, 0), (9, -4, 0), (9, 4, 0), (15, -6, 0), (15, 5, 0), (22, 0, 0), (9, 0, 1.2), (15, 1, 2)]


@pytest.mark.camrig(scene="street", mode="lockstep", seed=5)
def test_a_photo_is_calibrated_and_a_person_in_it_has_its_size(rig, tmp_path):
    """The photo is a picture of the street without people; its camera is known, and found again from clicks alone."""
    for actor in rig.actors():
        rig.remove_actor(actor["name"])
    true = rig.create_camera("true", place="corner", size=(1280, 960), fps=25)
    rig.step(seconds=0.04)
    cv2.imwrite(str(tmp_path / "corner.png"), true.frame().image)
    # Places on the ground all over the picture, and some a little higher.
    sight = np.linalg.inv(true.K)
    world = true.world_from_camera
    points = []
    for n, px in enumerate([(150, 900), (1100, 880), (300, 700), (900, 720), (640, 800), (500, 620), (1000, 600), (200, 560)]):
        ray = world[:3, :3] @ sight @ [*px, 1]
        foot = world[:3, 3] - ray * world[2, 3] / ray[2]
        points.append((*foot[:2].round(2), 0.0 if n % 3 else 0.9))
    (tmp_path / "clicks.json").write_text(json.dumps({"points": clicks(true, points, 0.4), "click_px": 0.4}))
    (tmp_path / "gate.json").write_text(json.dumps({
        "camrig_scene": 1, "name": "gate", "models": {"anna": {"file": "camrig:people/anna"}},
        "environment": {"ambient": {"sky": [0.4, 0.4, 0.4]}},
        "actors": [{"name": "anna", "model": "anna", "class": "person", "position": [*points[4][:2], 0]}]}))
    found = plate("calibrate", tmp_path / "clicks.json", "--photo", tmp_path / "corner.png", "--scene", tmp_path / "gate.json", "--name", "gate",
                  "-o", tmp_path / "camera.json")
    assert found["verdict"] == "good", found["reason"]
    is_at, was_at = np.array(found["camera"]["pose"]["position"]), world[:3, 3]
    assert (np.abs(is_at - was_at) <= 1.5 * np.array(found["half_95"]["position"])).all()
    assert abs(found["camera"]["intrinsics"]["fx"] - true.K[0, 0]) <= 1.5 * found["half_95"]["focal_px"]
    assert len(found["residuals"]) == len(points) and max(each["px"] for each in found["residuals"]) < 2

    plate("light", "--sun", "150,40", "--scene", tmp_path / "gate.json")
    with camrig.start(str(tmp_path / "gate.json"), mode="lockstep") as mine:
        mine.step(seconds=0.04)
        gate = mine.camera("gate")
        (anna,) = gate.truth()["objects"]
        head = max(p[2] for p in [(0, 0, anna["dimensions"][2])])
        foot_px, head_px = true.project(np.array([[*anna["position"][:2], 0], [*anna["position"][:2], head]], float))
        assert anna["pixels"] > 1000
        assert anna["box_full"][3] == pytest.approx(abs(foot_px[1] - head_px[1]), abs=0.06 * anna["box_full"][3])  # feet have a length
        mine_px = gate.project(np.array([[*anna["position"][:2], 0], [*anna["position"][:2], head]], float))
        assert np.abs((mine_px[0] - mine_px[1]) - (foot_px - head_px)).max() < 1.0
        # The entry alone makes the same camera in another rig.
        entry = json.loads((tmp_path / "camera.json").read_text())
        assert entry["backdrop"]["file"] == "corner.png" and entry["pose"] == found["camera"]["pose"]
        assert [light["name"] for light in json.loads((tmp_path / "gate.json").read_text())["lights"]] == ["sun"]
    # A camera that has a smaller size keeps it.
    scene = json.loads((tmp_path / "gate.json").read_text())
    scene["cameras"][0]["size"] = [640, 480]
    (tmp_path / "gate.json").write_text(json.dumps(scene))
    plate("calibrate", tmp_path / "clicks.json", "--photo", tmp_path / "corner.png", "--scene", tmp_path / "gate.json", "--name", "gate")
    with camrig.start(str(tmp_path / "gate.json"), mode="lockstep") as mine:
        half = mine.camera("gate").get()
        assert half["size"] == [640, 480] and half["intrinsics"]["fx"] == pytest.approx(found["camera"]["intrinsics"]["fx"] / 2)


YARD = {"camrig_scene": 1, "name": "yard",
        "environment": {"ambient": {"sky": [0.2, 0.24, 0.3], "ground": [0.1, 0.1, 0.1]}, "exposure": 0.8},
        "models": {"floor": {"shape": "box", "size": [60, 60, 0.1], "color": [0.5, 0.45, 0.4], "roughness": 1}, "post": {"shape": "box", "size": [0.6, 0.6, 2.5]}},
        "objects": [{"name": "floor", "model": "floor", "class": "ground", "position": [0, 0, -0.1]},
                    {"name": "post", "model": "post", "class": "post", "position": [9, 0, 0]}],
        "lights": [{"name": "sun", "type": "directional", "color": [1, 0.95, 0.85], "intensity": 1.0, "direction": [0.2, 0.7, -0.8]}],
        "cameras": [{"name": "eye", "size": [960, 720], "fps": 25, "vfov_deg": 50, "pose": {"position": [0, 0, 4], "tilt_deg": -18}}]}


def test_sun_and_sky_are_read_off_a_photo(tmp_path):
    """The photo is drawn with shadows; direction, sun to sky per channel and gain come back as they were put in."""
    (tmp_path / "yard.json").write_text(json.dumps(YARD))
    sun = YARD["lights"][0]
    direction = np.array(sun["direction"]) / np.linalg.norm(sun["direction"])
    with camrig.start(str(tmp_path / "yard.json"), mode="lockstep", quality="beautiful") as rig:
        rig.step(seconds=0.04)
        eye = rig.camera("eye")
        cv2.imwrite(str(tmp_path / "yard.png"), eye.frame().image)
        edge = np.array([9 - 0.3, -0.3, 2.5])  # one of its corners, whose shadow is one too
        top, foot, tip = eye.project(np.array([edge, [*edge[:2], 0], edge - direction * edge[2] / direction[2]]))
        shade, light = eye.project(np.array([[9.2, 0.75, 0], [9.2, -2, 0]]))
        (tmp_path / "eye.json").write_text(json.dumps({key: eye.get()[key] for key in ("name", "size", "intrinsics", "pose", "fps")}))

    def box(px, side=9):
        return ",".join(str(int(round(v)) - side // 2) for v in px) + f",{side},{side}"

    found = plate("light", tmp_path / "yard.png", "--camera", tmp_path / "eye.json", "--shadow", ":".join(f"{u},{v}" for u, v in (top, foot, tip)),
                  "--lit", box(light), "--shaded", box(shade), "--white", box(light), "--reflectance", 0.45)
    got = found["lights"][0]
    assert np.array(got["direction"]) == pytest.approx(direction, abs=1e-4)
    assert found["shadow_of_m"] == pytest.approx(2.5, abs=1e-3) and 0.01 < found["deviation_deg"] < 3
    sky = np.array(YARD["environment"]["ambient"]["sky"])
    total = sky + sun["intensity"] * np.array(sun["color"]) * -direction[2]
    assert found["environment"]["ambient"]["sky"] == pytest.approx((sky / total).tolist(), rel=0.03)
    assert (np.array(got["color"]) * got["intensity"]).tolist() == pytest.approx((np.array(sun["color"]) / total).tolist(), rel=0.02)
    albedo = np.array(YARD["models"]["floor"]["color"])
    assert (np.array(found["backdrop"]["plate_gain"]) * 0.45).tolist() == pytest.approx((0.8 * albedo * total).tolist(), rel=0.02)
    # The same sun by date and place: north is where the azimuth says.
    again = plate("light", "--sun", f"{found['azimuth_deg']},{found['elevation_deg']}")
    assert again["lights"][0]["direction"] == pytest.approx(got["direction"])


def test_the_light_of_a_photo_takes_the_place_of_daylight(tmp_path):
    scene = tmp_path / "noon.json"
    scene.write_text(json.dumps({"camrig_scene": 1, "name": "noon", "environment": {"daylight": {"azimuth_deg": 150, "elevation_deg": 40}},
                                 "lights": [{"name": "lamp", "type": "point", "position": [0, 0, 3], "candela": 800}]}))
    plate("light", "--sun", "150,40", "--scene", scene)
    subprocess.run([CAMRIG, "check", str(scene)], check=True, timeout=60)


@pytest.mark.parametrize("base, put_out", [("camrig:street-evening", []), ("camrig:hall", ["daylight"]), ("camrig:street", [])])
def test_the_light_of_a_photo_takes_the_place_of_that_of_a_base(tmp_path, base, put_out):
    scene = tmp_path / "corner.json"
    scene.write_text(json.dumps({"camrig_scene": 1, "name": "corner", "base": base}))
    plate("light", "--sun", "150,40", "--scene", scene)
    lights = {light["name"]: light for light in json.loads(scene.read_text())["lights"]}
    assert sorted(lights) == sorted(["sun", *put_out])
    assert lights["sun"]["intensity"] > 0 and all(lights[name]["intensity"] == 0 for name in put_out)
    subprocess.run([CAMRIG, "check", str(scene)], check=True, timeout=60)


def test_noise_and_edges_are_read_off_a_photo(tmp_path):
    random = np.random.default_rng(3)
    soft = cv2.GaussianBlur(np.tile(np.where(np.arange(640) < 320, 60.0, 150.0), (480, 1))[..., None].repeat(3, 2), (0, 0), 0.8)
    soft = np.roll(soft, 0, 0) + np.linspace(0, 60, 480)[:, None, None]
    noisy = soft + random.normal(0, 1, soft.shape) * np.sqrt(0.01 * soft + 0.7**2)
    cv2.imwrite(str(tmp_path / "photo.png"), np.clip(noisy.round(), 0, 255).astype(np.uint8))
    found = plate("light", tmp_path / "photo.png", "--noise", "--edge", "300,20,40,30")["backdrop"]
    for level in (80, 180):
        assert found["noise"]["k"] * level + found["noise"]["read"] ** 2 == pytest.approx(0.01 * level + 0.49, rel=0.12)
    assert 0.5 < found["edge_px"] < 1.0


def test_what_is_wrong_is_said_in_one_line(tmp_path):
    size = ("--size", "1280x720")
    assert "points: none are given" in plate("calibrate", *size, good=False)
    assert "size" in plate("calibrate", "--point", "1,2=3,4", good=False)
    assert "--point, U,V=X,Y,Z: takes" in plate("calibrate", *size, "--point", "1,2=3", good=False)
    line = [f"--point={100 + 10 * n},{400 - n}={n},{2 * n}" for n in range(5)]
    assert "on one line" in plate("calibrate", *size, *line, good=False)
    (tmp_path / "clicks.json").write_text('{"points": [{"px": [1, 2], "m": [1, 2], "mm": 3}]}')
    assert "points[0].mm" in plate("calibrate", tmp_path / "clicks.json", *size, good=False)
    (tmp_path / "clicks.json").write_text('{"points": [{"px": [1, 2], "m": [1, 2')
    assert "line 1" in plate("calibrate", tmp_path / "clicks.json", *size, good=False)
    (tmp_path / "clicks.json").write_text('{"points": {}}')
    assert "points: expected a list" in plate("calibrate", tmp_path / "clicks.json", *size, "--point", "1,2=3,4", good=False)
    assert "none.png" in plate("calibrate", "--photo", tmp_path / "none.png", good=False)
    assert "nothing is asked for" in plate("light", good=False)
    assert "--time: " in plate("light", "--time", "noon", "--place", "1,2", good=False)
    assert "--shadow: needs the camera" in plate("light", "--shadow", "1,2:3,4:5,6", good=False)
    assert "need the PHOTO" in plate("light", "--noise", good=False)
    assert "cannot be read" in plate("light", "--sun", "1,40", "--scene", tmp_path / "none.json", good=False)


def test_the_page_of_backdrops_works(tmp_path):
    """Its clicks are those of a camera 3.2 m up, tilted by 16 degrees, of 48 degrees."""
    page = (REPOSITORY / "docs" / "backdrops.md").read_text()
    commands = [block.split("```")[0] for block in page.split("```sh\n")[1:]]
    commands = [block for block in commands if "camrig plate" in block]
    assert len(commands) == 2
    cv2.imwrite(str(tmp_path / "gate.png"), np.full((960, 1280, 3), 90, np.uint8))
    (tmp_path / "gate.json").write_text('{"camrig_scene": 1, "name": "gate", "seed": 3}')
    for block in commands:
        subprocess.run(["bash", "-euc", f"camrig() {{ {CAMRIG} \"$@\"; }}\n{block}"], cwd=tmp_path, check=True, timeout=60)
    scene = json.loads((tmp_path / "gate.json").read_text())
    assert list(scene)[:3] == ["camrig_scene", "name", "seed"] and scene["lights"][0]["name"] == "sun"
    assert scene["cameras"][0]["pose"]["position"] == pytest.approx([0, 0, 3.2], abs=0.05)
    clicks_block = next(block.split("```")[0] for block in page.split("```json\n") if '"heights"' in block.split("```")[0])
    (tmp_path / "clicks.json").write_text(clicks_block)
    found = plate("calibrate", tmp_path / "clicks.json", "--photo", tmp_path / "gate.png")
    assert found["camera"]["pose"]["tilt_deg"] == pytest.approx(-16, abs=0.3)
    assert found["camera"]["intrinsics"]["fx"] == pytest.approx(1078.1, rel=0.02)
    done = subprocess.run([CAMRIG, "check", str(tmp_path / "gate.json")], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
