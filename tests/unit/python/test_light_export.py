"""What tools/bench/light tells a path tracer: geometry, camera, units. Needs no path tracer."""

from __future__ import annotations

import json
import math
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))
from tools.bench.light import compare, export  # noqa: E402
from tools.bench.light.gltf import Glb  # noqa: E402


def write_glb(path: Path, *, node: dict | None = None) -> None:
    """A triangle in glTF's xy plane that looks along its +z."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], "<f4")
    normals = np.tile(np.array([0, 0, 1], "<f4"), (3, 1))
    binary = positions.tobytes() + normals.tobytes() + np.arange(3, dtype="<u4").tobytes()
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, **(node or {})}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.4, 0.3, 1], "metallicFactor": 0, "roughnessFactor": 0.7}}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": size} for start, size in ((0, 36), (36, 36), (72, 12))],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
    }).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)) + struct.pack("<I4s", len(text), b"JSON") + text
                     + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def scene_of(**objects) -> dict:
    return {"camrig_scene": 1, "name": "s", "models": {"t": {"file": "camrig:t"}}, "objects": [{"name": "o", "model": "t", **objects}]}


def test_a_triangle_lies_where_the_scene_places_it(tmp_path):
    write_glb(tmp_path / "t.glb")
    surface, = export.read(scene_of(position=[10, 20, 30], yaw_deg=90, scale=2), tmp_path).surfaces
    # glTF (x, y, z) is world (x, -z, y), doubled, a quarter turn counter-clockwise, moved.
    assert np.allclose(surface.positions, [[10, 20, 30], [10, 22, 30], [10, 20, 34]])
    assert np.allclose(surface.normals, [[1, 0, 0]] * 3)
    assert surface.material.base_color == (0.5, 0.4, 0.3, 1) and surface.material.roughness == 0.7


def test_a_mirrored_node_keeps_its_front(tmp_path):
    write_glb(tmp_path / "t.glb", node={"scale": [-1, 1, 1]})
    primitive, = Glb(tmp_path / "t.glb").primitives()
    a, b, c = primitive.positions[primitive.triangles[0]]
    assert np.dot(np.cross(b - a, c - a), primitive.normals[0]) > 0


def test_equal_materials_become_one_mesh(tmp_path):
    write_glb(tmp_path / "t.glb")
    scene = scene_of()
    scene["objects"].append({"name": "p", "model": "t", "position": [5, 0, 0]})
    surface, = export.read(scene, tmp_path).surfaces
    assert np.allclose(surface.positions[surface.triangles[1]][:, 0], [5, 6, 5])


def test_units_of_lights(tmp_path):
    scene = {**scene_of(), "objects": [], "lights": [
        {"name": "sun", "type": "directional", "color": [1, 0.5, 0], "intensity": 2, "direction": [0, 0, -4]},
        {"name": "lamp", "type": "point", "intensity": 3, "position": [1, 2, 3]},
    ]}
    sun, lamp = export.read(scene, tmp_path).lights
    assert np.allclose(sun.value, [2 * math.pi, math.pi, 0]) and np.allclose(sun.direction, [0, 0, -1])
    assert np.allclose(lamp.value, 3 * math.pi) and np.allclose(lamp.position, [1, 2, 3])
    scene["lights"][1]["range"] = 4
    with pytest.raises(ValueError, match="lamp"):
        export.read(scene, tmp_path)


def test_the_hemisphere_term_is_what_two_half_environments_give():
    """Lambert ball under a sky: irradiance / pi by integrating over directions, against camrig's mix by the normal."""
    random = np.random.default_rng(1)
    z = random.uniform(-1, 1, 400_000)
    turn = random.uniform(0, 2 * math.pi, z.size)
    directions = np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], 1)
    radiance = np.where(z > 0, 0.9, 0.3)
    for tilt_deg in (0, 30, 90, 140, 180):
        tilt = math.radians(tilt_deg)
        normal = np.array([math.sin(tilt), 0, math.cos(tilt)])
        gathered = 4 * np.mean(radiance * np.maximum(directions @ normal, 0))
        assert gathered == pytest.approx(0.3 + 0.6 * (0.5 + 0.5 * math.cos(tilt)), abs=0.01)


def test_the_eye_is_that_of_the_camera():
    k = np.array([[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])
    assert export.eye((320, 240), k, np.eye(4)).vfov_deg == pytest.approx(math.degrees(2 * math.atan(0.4)))
    k[0, 2] = 160
    with pytest.raises(ValueError, match="middle"):
        export.eye((320, 240), k, np.eye(4))


def test_codes_and_light_are_inverse():
    codes = np.arange(256.0)
    assert np.allclose(export.codes(export.light_of(codes)), codes, atol=1e-3)
    assert export.codes(np.array([0.5]), 4.0)[0] == pytest.approx(255)


def test_still_scene_keeps_what_stands_and_reads_shipped_models():
    shipped = json.loads((ROOT / "scenes" / "street.json").read_text())
    scene = export.still(shipped)
    assert "actors" not in scene and scene["models"]["van"]["file"] == "camrig:street/van"
    exported = export.read(scene, ROOT / "scenes")
    assert sum(len(surface.triangles) for surface in exported.surfaces) > 100_000
    assert len({surface.material.name for surface in exported.surfaces}) >= 14


def test_error_is_told_without_the_noise_of_the_reference():
    random = np.random.default_rng(2)
    truth = np.full((120, 160, 3), 100.0)
    halves = tuple(truth + random.normal(0, 8, truth.shape) for _ in range(2))
    assert compare.mean_square(truth + 5, halves) == pytest.approx(25, abs=1.0)
    assert compare.noise(halves) == pytest.approx(8 / math.sqrt(2), rel=0.02)
    assert compare.decibels(255**2 / 1000) == pytest.approx(30)


def test_the_level_is_found():
    light = np.random.default_rng(3).uniform(0.1, 0.6, (50, 60, 3))
    assert compare.best_factor(export.codes(light * 1.3), light) == pytest.approx(1.3, rel=1e-3)


def test_daylight_is_sun_sky_and_what_the_ground_sends_back_by_the_scenes_lux(tmp_path):
    day = {"azimuth_deg": 90, "elevation_deg": 40, "turbidity": 3, "ground": [0.5, 0.5, 0.5]}
    scene = {**scene_of(), "objects": [], "environment": {"daylight": day, "lux": 50e3, "exposure": 0.5},
             "lights": [{"name": "sun", "type": "directional", "intensity": 7, "direction": [0, 0, -1]}]}
    exported = export.read(scene, tmp_path)
    sun, = exported.lights
    # In the east: along x, as azimuth counts from y (north) clockwise.
    assert np.allclose(sun.direction, [-math.cos(math.radians(40)), 0, -math.sin(math.radians(40))])
    level = exported.sky + sun.value / math.pi * math.sin(math.radians(40))
    assert np.allclose(exported.ground, 0.5 * level) and exported.has_tone_curve
    # 66 klx of sun and sky (core/daylight, as tests/unit/daylight has it) in units of 50 klx.
    assert level @ [0.2126, 0.7152, 0.0722] == pytest.approx(66.3 / 50, rel=0.03)
    # All of the sky gives level ground its light: the mean over directions that weigh alike there.
    up, pan = np.sqrt((np.arange(64)[:, None] + 0.5) / 64), 2 * math.pi * (np.arange(128) + 0.5) / 128
    flat = np.sqrt(1 - up * up)
    towards = np.stack([flat * np.cos(pan), flat * np.sin(pan), np.broadcast_to(up, (64, 128))], axis=-1)
    assert np.allclose(exported.daylight.radiance(towards).mean(axis=(0, 1)), exported.sky, rtol=0.01)
    brightest = exported.daylight.radiance(towards).sum(axis=2).argmax()
    assert towards.reshape(-1, 3)[brightest] @ -sun.direction > 0.95
    # Under clouds all light is the sky's: 300 + 21000 sin(elevation) lux (Krochmann and Seidl).
    clouded = export.read({**scene, "environment": {"daylight": {**day, "overcast": 1}, "lux": 1}}, tmp_path)
    assert np.allclose(clouded.sky, 300 + 21000 * math.sin(math.radians(40))) and not clouded.lights[0].value.any()
    with pytest.raises(ValueError, match="no time"):
        export.read({**scene, "environment": {"daylight": {"time": "2026-06-21T12:00:00Z"}}}, tmp_path)


def test_the_sky_is_left_out_and_the_tone_curve_is_camrigs(tmp_path):
    scene = scene_of()
    scene["models"]["sky"] = {"shape": "sky"}
    scene["objects"].append({"name": "sky", "model": "sky"})
    assert [item["name"] for item in export.still(scene)["objects"]] == ["o"]
    light = np.array([[[0.02, 0.3, 0.5], [0.9, 1.5, 2.0]]])
    picture = export.codes(light, is_toned=True)
    assert (picture < 255).all() and not np.allclose(picture, export.codes(light))
    assert np.allclose(export.light_of(picture, is_toned=True), light, rtol=1e-6)
