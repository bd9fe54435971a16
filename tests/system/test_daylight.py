"""Times of day, lamps and the tone curve, as a user meets them: from pictures."""

import json
import os
import subprocess

import numpy as np
import pytest

import camrig
from camrig import tone

pytestmark = pytest.mark.camrig(scene="scenes/street-evening.json", mode="lockstep")

CORNER = {"size": (320, 240), "place": "corner", "quality": "beautiful"}


def mean(cam, rig):
    rig.step(seconds=0.04)
    return cam.frame().image.astype(float).mean(axis=(0, 1))


def test_the_street_has_an_evening_a_night_and_a_noon():
    seen = {}
    for name in ("street-noon", "street-evening", "street-night"):
        with camrig.start(name, mode="lockstep") as rig:
            seen[name] = mean(rig.create_camera("c", **CORNER), rig)
    blue, _, red = range(3)
    warmth = {name: value[red] / value[blue] for name, value in seen.items()}
    assert warmth["street-night"] > warmth["street-evening"] > warmth["street-noon"]
    assert seen["street-night"].mean() < 0.5 * seen["street-noon"].mean()


def test_lamps_go_out_and_the_sun_sets_at_once(rig):
    cam = rig.create_camera("c", **CORNER)
    before = mean(cam, rig).mean()
    rig.act({"action": "environment", "daylight": {"azimuth_deg": 300, "elevation_deg": -9}})
    by_lamps = mean(cam, rig).mean()
    rig.act({"action": "light", "light": "lamps", "intensity": 0})
    without = mean(cam, rig).mean()
    assert before > 1.5 * by_lamps > 3 * without


def test_the_command_line_acts_too(rig):
    control = ["--control", rig.call("server.info")["control"]]
    act = lambda *actions: subprocess.run([os.environ["CAMRIG_BIN"], "event", "act", *map(json.dumps, actions), *control], capture_output=True, text=True, timeout=60)
    done = act({"action": "light", "light": "lamps", "intensity": 0}, {"action": "environment", "exposure": 2})
    assert done.returncode == 0, done.stderr
    for name, why in (("lamp_9", "do[0].light: no light 'lamp_9'"), ("lamp_1", "do[0].light: 'lamp_1' is switched with its group 'lamps'; name that")):
        wrong = act({"action": "light", "light": name})
        assert wrong.returncode == 1
        assert why in wrong.stderr


def test_fog_comes_and_goes_and_depth_knows_nothing_of_it(rig):
    cam = rig.create_camera("c", **CORNER)
    mean(cam, rig)
    clear, depth = cam.frame().image.astype(float), cam.depth()
    half = 0.5 / json.load(open("scenes/street-evening.json"))["environment"]["exposure"]
    rig.act({"action": "environment", "fog": {"visibility_m": 40, "color": [half, half, half]}})
    rig.step(seconds=0.04)
    foggy = cam.frame().image.astype(float)
    far = np.isfinite(depth) & (depth > 80)
    assert far.sum() > 500
    assert np.abs(foggy[far] - 188).max() <= 3  # linear 0.5
    assert foggy.std() < clear.std()
    with pytest.raises(camrig.CamrigError, match="fog.visibility_m"):
        rig.act({"action": "environment", "fog": {"visibility_m": -1}})
    rig.act({"action": "environment", "fog": {"visibility_m": 0}})
    rig.step(seconds=0.04)
    moved = np.abs(cam.frame().image.astype(float) - clear).max(axis=2) > 8
    assert moved.mean() < 0.1  # people and cars alone


def test_a_camera_is_exposed_beside_the_scene(rig):
    cams = [rig.create_camera(f"c{ev}", exposure_ev=ev, **{**CORNER, "quality": "simple"}) for ev in (0, 1)]
    rig.step(seconds=0.04)
    once, twice = (cam.frame().image for cam in cams)
    rig.act({"action": "environment", "exposure": 2 * json.load(open("scenes/street-evening.json"))["environment"]["exposure"]})
    rig.step(seconds=0.04)
    assert twice.astype(float).mean() > 1.15 * once.mean()
    # The same instant's light, but for what moved.
    again = cams[0].frame().image.astype(float)
    assert np.median(np.abs(again - twice)) == 0


def test_light_comes_back_out_of_a_beautiful_picture(tmp_path):
    # A floor of 0.5 under clouds, so in no sun, where white is what they give.
    file = tmp_path / "floor.json"
    file.write_text(json.dumps({
        "camrig_scene": 1, "name": "floor", "environment": {"lux": 300 + 21000, "daylight": {"azimuth_deg": 0, "elevation_deg": 90, "overcast": 1, "ground": [1, 1, 1]}},
        "models": {"floor": {"shape": "ground", "size": [40, 40], "color": [0.5, 0.5, 0.5], "roughness": 1, "grid_m": 0}},
        "objects": [{"name": "floor", "model": "floor"}]}))
    with camrig.start(file, mode="lockstep") as rig:
        cam = rig.create_camera("c", size=(64, 64), quality="beautiful", position=(0, 0, 3), look_at=(0.01, 0, 0))
        rig.step(seconds=0.04)
        light = tone.light_of(cam.frame().image[24:40, 24:40])
    # glTF's material at roughness 1, seen squarely: what the surface lets through to the base, and what it mirrors.
    assert np.allclose(light, 0.5 * 0.96 + 0.04 * (1 - np.log(2)), atol=0.006), light.mean()


def test_a_scene_may_say_only_what_it_has_otherwise(tmp_path):
    file = tmp_path / "dim.json"
    file.write_text(json.dumps({"camrig_scene": 1, "name": "dim", "base": "camrig:minimal", "environment": {"exposure": 0.25}}))
    checked = subprocess.run([os.environ["CAMRIG_BIN"], "check", str(file)], capture_output=True, text=True, timeout=60)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    pictures = []
    for scene in ("minimal", file):
        with camrig.start(scene, mode="lockstep") as rig:
            rig.step(seconds=0.04)
            pictures.append(rig.camera("main").frame().image.astype(float).mean())
    assert pictures[1] < 0.7 * pictures[0]
