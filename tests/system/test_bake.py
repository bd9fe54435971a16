"""`camrig bake`: a scene's light in a file beside it, what quality beautiful makes of it, and what becomes of a file that is no longer right."""

import base64
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

import camrig
import posed_gltf
from conftest import REPOSITORY

CAMRIG = os.environ["CAMRIG_BIN"]

#: A room with a lamp and a closed box; nothing of the sky comes in.
ROOM = {
    "camrig_scene": 1, "name": "room",
    "environment": {"ambient": {"sky": [0.6, 0.6, 0.6], "ground": [0.6, 0.6, 0.6]}},
    "models": {
        "floor": {"shape": "box", "size": [6, 6, 0.2], "color": [0.5, 0.5, 0.5]}, "side": {"shape": "box", "size": [0.2, 6, 3], "color": [0.5, 0.5, 0.5]},
        "end": {"shape": "box", "size": [5.6, 0.2, 3], "color": [0.5, 0.5, 0.5]}, "crate": {"shape": "box", "size": [0.8, 0.8, 0.8], "color": [0.5, 0.1, 0.1]},
    },
    "objects": [
        {"name": "floor", "model": "floor", "position": [0, 0, -0.2]}, {"name": "roof", "model": "floor", "position": [0, 0, 3]},
        {"name": "east", "model": "side", "position": [2.9, 0, 0]}, {"name": "west", "model": "side", "position": [-2.9, 0, 0]},
        {"name": "north", "model": "end", "position": [0, 2.9, 0]}, {"name": "south", "model": "end", "position": [0, -2.9, 0]},
        {"name": "crate", "model": "crate", "position": [0.5, 0.5, 0]},
    ],
    "lights": [{"name": "lamp", "type": "point", "position": [-0.5, 0, 2.4], "intensity": 2}],
    "events": [{"name": "off", "when": {"at_s": 1}, "do": [{"action": "light", "light": "lamp", "intensity": 0}]}],
    "cameras": [{"name": "eye", "size": [320, 240], "vfov_deg": 70, "pose": {"position": [-2.4, -2.4, 2], "pan_deg": 45, "tilt_deg": -25}, "quality": "beautiful"}],
}
COARSE = ("--texels-per-m", "6", "--rays", "64")


def bake(*words, code=0):
    done = subprocess.run([CAMRIG, "bake", *map(str, words)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    scene = tmp_path_factory.mktemp("bake") / "room.json"
    scene.write_text(json.dumps(ROOM))
    bake(scene, *COARSE)
    return scene


def pictures(scene: pathlib.Path, **options):
    """Before and after the lamp is switched off, as mean codes."""
    with camrig.start(str(scene), mode="lockstep", **options) as rig:
        rig.step(seconds=0.5)
        lit = rig.camera("eye").frame().image.astype(int)
        rig.step(seconds=1)
        return lit, rig.camera("eye").frame().image.astype(int)


def quad(x0, x1, y0, y1, z):
    """Faces up; corners as a file has them (y up)."""
    return [[x0, z, -y0], [x1, z, -y0], [x1, z, -y1], [x0, z, -y1]], [[0, 1, 2], [0, 2, 3]]


def test_under_a_seat_without_a_bottom_it_is_dark(tmp_path):
    """Only its upper side is there: rays from below meet its back."""
    for name, place in (("floor", (-4, 4, -4, 4, 0)), ("seat", (-1, 1, -1, 1, 0.6))):
        posed_gltf.write_glb(tmp_path / f"{name}.glb", *quad(*place), double_sided=False)
    scene = {"camrig_scene": 1, "name": "seat", "environment": {"ambient": {"sky": [0.6] * 3, "ground": [0] * 3}}, "lights": [],
             "models": {name: {"file": f"{name}.glb"} for name in ("floor", "seat")}, "objects": [{"name": name, "model": name} for name in ("floor", "seat")],
             "cameras": [{"name": "eye", "size": [64, 48], "quality": "beautiful", "vfov_deg": 20, "pose": {"position": [-0.9, 0, 0.4], "look_at": [0, 0, 0]}}]}
    (tmp_path / "seat.json").write_text(json.dumps(scene))
    bake(tmp_path / "seat.json", "--texels-per-m", "4", "--rays", "64")
    with camrig.start(str(tmp_path / "seat.json"), mode="lockstep", device="cpu") as rig:
        rig.step(seconds=0.1)
        below = rig.camera("eye").frame().image[..., 1].mean()
        rig.camera("eye").set(position=[-3.4, 3, 0.4], look_at=[-2.5, 3, 0])
        rig.step(seconds=0.1)
        beside = rig.camera("eye").frame().image[..., 1].mean()
    assert below < 0.7 * beside and beside > 150, (below, beside)


@pytest.mark.parametrize("device", ["cpu", "llvmpipe"])
def test_a_room_is_lit_by_its_lamp_and_no_more_when_it_is_switched_off(room, tmp_path, device):
    lit, dark = pictures(room, device=device)
    assert lit.mean() > 60 and dark.max() <= 2  # no sky comes in, and the switch took no bake
    (tmp_path / "room.json").write_text(room.read_text())
    _, plain = pictures(tmp_path / "room.json", device=device)
    assert plain.mean() > 60  # without the file the sky shines through walls
    # Behind the crate the floor has only what walls reflect: darker than beside it, and not black.
    with camrig.start(str(room), mode="lockstep", device=device) as rig:
        rig.step(seconds=0.5)
        eye = rig.camera("eye")
        (u, v), (su, sv) = eye.project(np.array([[-0.6, 1.2, 0], [1.25, 0.75, 0]]))
        picture = eye.frame().image.astype(int)
    assert 4 < picture[int(sv), int(su)].mean() < 0.8 * picture[int(v), int(u)].mean()


def test_the_same_scene_gives_the_same_bytes(room, tmp_path):
    bake(room, *COARSE, "--threads", "1", "-o", tmp_path / "again.light")
    assert (tmp_path / "again.light").read_bytes() == room.with_suffix(".light").read_bytes()


def test_a_light_of_another_state_is_told_and_left_alone(room, tmp_path):
    scene = tmp_path / "room.json"
    changed = json.loads(room.read_text())
    changed["objects"][-1]["position"][0] += 0.1
    scene.write_text(json.dumps(changed))
    (tmp_path / "room.light").write_bytes(room.with_suffix(".light").read_bytes())
    assert "up to date" in bake(room, "--check").stdout
    told = bake(scene, "--check", code=1).stderr
    assert told.startswith("camrig: bake: ") and "room.light: the scene's shapes, materials or lamps are others since it was baked" in told
    stale, _ = pictures(scene)
    (tmp_path / "room.light").unlink()
    assert (stale == pictures(scene)[0]).all()
    for damaged, said in ((b"camrig light 6\nnothing", "ends too early"), (b"camrig light 4\nnothing", "is no light of this version of camrig")):
        (tmp_path / "room.light").write_bytes(damaged)
        assert (stale == pictures(scene)[0]).all()
        told = bake(scene, "--check", code=1).stderr
        assert "room.light: " in told and said in told


@pytest.mark.parametrize("name", ["hall", "crowd", "street", "street-night"])
def test_shipped_scenes_have_the_light_of_their_shapes(name):
    # After a change of one: tools/assets/light NAME.
    assert "up to date" in bake(name, "--check").stdout


def test_the_light_of_all_shipped_scenes_is_no_more_than_25_mb():
    files = list((REPOSITORY / "scenes").glob("*.light"))
    assert {file.stem for file in files} == {"hall", "crowd", "street"}
    assert sum(file.stat().st_size for file in files) < 25e6


def test_a_shipped_scene_is_drawn_with_its_light_by_its_name_alone(tmp_path):
    bare = tmp_path / "scenes"
    shutil.copytree(REPOSITORY / "scenes", bare, symlinks=True, ignore=shutil.ignore_patterns("*.light"))
    pictures = []
    for scene in ("hall", bare / "hall.json"):
        with camrig.start(scene, mode="lockstep") as rig:
            cam = rig.create_camera("c", place="lobby", size=(160, 120), quality="beautiful")
            rig.step(seconds=0.04)
            pictures.append(cam.frame().image.astype(int))
    assert np.abs(pictures[0] - pictures[1]).mean() > 5


def test_what_is_wrong_is_said_in_one_line(room, tmp_path):
    assert "none.json" in bake(tmp_path / "none.json", code=1).stderr
    assert bake(tmp_path / "none.json", code=1).stderr.count("\n") == 1
    assert "--rays" in bake(room, "--rays", "3", code=2).stderr
    empty = tmp_path / "empty.json"
    empty.write_text(json.dumps({"camrig_scene": 1, "name": "empty", "models": {}, "objects": []}))
    assert "nothing in this scene stands still and is lit" in bake(empty, code=1).stderr


@pytest.mark.parametrize("bounces", [3, 40])  # the latter are more than add anything
def test_a_bake_that_was_ended_goes_on_where_it_was_and_gives_the_same_bytes(room, tmp_path, bounces, programs):
    options = (room, "--texels-per-m", "10", "--rays", "256", "--bounces", bounces)
    whole, out = tmp_path / "whole.light", tmp_path / "ended.light"
    bake(*options, "-o", whole)
    part = pathlib.Path(f"{out}.part")

    def is_far():
        with contextlib.suppress(FileNotFoundError):  # not there yet, or done and renamed
            return part.read_bytes().split(b"\n")[0].endswith(f" passes {bounces}".encode())
        return False

    for _ in range(10):
        process = programs([CAMRIG, "bake", *map(str, options), "-o", out], stderr=subprocess.DEVNULL)
        while process.poll() is None and not is_far():
            time.sleep(0.01)
        process.kill()
        process.wait()
        if part.exists():
            break
        out.unlink()  # it was done before this was given the time to look
    assert part.exists() and not out.exists()
    shares = [float(share) for share in re.findall(r"([0-9.]+) %", bake(*options, "-o", out).stderr)]
    assert not [share for share in shares if 5 < share < 20]  # what was found was not found again
    assert out.read_bytes() == whole.read_bytes() and not part.exists()
    # What was found for other options, or is cut short, is not taken.
    part.write_bytes(b"camrig bake 1 something else\n")
    bake(*options, "-o", out)
    assert out.read_bytes() == whole.read_bytes()


#: A floor that mirrors, and a lamp on the wall behind it.
MIRROR = {
    **ROOM, "name": "mirror", "events": [], "lights": [],
    "objects": [*(item for item in ROOM["objects"] if item["name"] not in ("floor", "crate")), {"name": "mirror", "model": "mirror", "position": [0, 0, -0.2]}, {"name": "panel", "model": "panel", "position": [2.75, 0, 1]}],
    "cameras": [{**ROOM["cameras"][0], "pose": {"position": [-2.4, 0, 1.5], "pan_deg": 0, "tilt_deg": -25}}],
}


def box(size, **material):
    """A box that stands on z = 0, as glTF has it: z along -y, x along x, y up."""
    x, y, z = size[0] / 2, size[2], size[1] / 2
    corners = [(sx * x, h, sz * z) for h in (0, y) for sz in (1, -1) for sx in (-1, 1)]
    faces = [((0, -1, 0), (0, 2, 3, 1)), ((0, 1, 0), (4, 5, 7, 6)), ((0, 0, 1), (0, 1, 5, 4)), ((0, 0, -1), (3, 2, 6, 7)), ((-1, 0, 0), (2, 0, 4, 6)), ((1, 0, 0), (1, 3, 7, 5))]
    positions = np.array([corners[i] for _, face in faces for i in face], np.float32)
    normals = np.array([normal for normal, face in faces for _ in face], np.float32)
    indices = np.array([4 * i + k for i in range(6) for k in (0, 1, 2, 0, 2, 3)], np.uint16)
    parts = [positions.tobytes(), normals.tobytes(), indices.tobytes()]
    views = [{"buffer": 0, "byteOffset": sum(map(len, parts[:i])), "byteLength": len(part)} for i, part in enumerate(parts)]
    return {
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": sum(map(len, parts)), "uri": "data:application/octet-stream;base64," + base64.b64encode(b"".join(parts)).decode()}],
        "bufferViews": views, "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": positions.min(0).tolist(), "max": positions.max(0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": 24, "type": "VEC3"}, {"bufferView": 2, "componentType": 5123, "count": 36, "type": "SCALAR"}],
        "materials": [material], "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0, "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_transmission"],
    }


def test_a_mirror_shows_what_is_there_and_where_it_is(tmp_path):
    scene = dict(MIRROR, models={**ROOM["models"], "mirror": {"file": "mirror.gltf"}, "panel": {"file": "panel.gltf"}})
    black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}
    (tmp_path / "mirror.gltf").write_text(json.dumps(box((6, 6, 0.2), pbrMetallicRoughness={**black, "roughnessFactor": 0.02})))
    (tmp_path / "panel.gltf").write_text(json.dumps(box((0.1, 1, 1), pbrMetallicRoughness=black, emissiveFactor=[1, 1, 1], extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 8}})))
    file = tmp_path / "mirror.json"
    file.write_text(json.dumps(scene))
    bake(file, *COARSE)
    with camrig.start(str(file), mode="lockstep") as rig:
        rig.step(seconds=0.5)
        eye = rig.camera("eye")
        picture = eye.frame().image.astype(int).sum(axis=2)
        # The panel from y = -0.5 to 0.5 and z = 1 to 2 at x = 2.7 stands as far below the floor as above it.
        (left, top), (right, bottom) = eye.project(np.array([[2.7, 0.5, -1], [2.7, -0.5, -2]]))
        floor_row = int(eye.project(np.array([[2.7, 0, 0]]))[0][1])
        rig.act({"action": "environment", "glow": 0})
        rig.step(seconds=0.5)
        dark = eye.frame().image.astype(int).sum(axis=2)
    rows, columns = np.nonzero(picture[floor_row + 2:] > 0.5 * picture[floor_row + 2:].max())
    assert abs(columns.mean() - (left + right) / 2) < 3
    assert abs(rows.mean() + floor_row + 2 - (top + bottom) / 2) < 6
    assert (right - left) * 0.7 < np.ptp(columns) < (right - left) * 1.4
    assert dark[floor_row + 2:].max() < 0.1 * picture[floor_row + 2:].max()


def test_it_ends_at_once_when_it_is_interrupted_and_leaves_nothing(room, tmp_path, programs):
    out = tmp_path / "never.light"
    process = programs([CAMRIG, "bake", room, "--texels-per-m", "30", "--rays", "2048", "-o", out], stderr=subprocess.PIPE, text=True)
    assert "%" in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=20)
    assert process.returncode == 1 and "it was ended" in told and not out.exists()
