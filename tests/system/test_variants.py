"""People and cars that differ by a number, and light and clothes by chance, as pictures show them."""

import json
import subprocess

import numpy as np
import pytest

import camrig
from camrig.farm.batch.scene_file import read_scene, varied, write_varied
from camrig.randomize import changes
from camrig.scene_base import on_its_base, read_scene_file, scene_path

PEOPLE = ("anna", "ben", "clara", "ivan")


@pytest.fixture
def scene(tmp_path):
    """Four people in a row on grey ground; each by a variant where `variant` is told."""

    def scene_(variant=None):
        told = {} if variant is None else {"variant": variant}
        file = tmp_path / "row.json"
        file.write_text(json.dumps({
            "camrig_scene": 1, "name": "row", "models": {"ground": {"shape": "ground"}, **{name: {"file": f"camrig:people/{name}"} for name in PEOPLE}},
            "objects": [{"name": "ground", "model": "ground"}],
            "lights": [{"name": "sun", "type": "directional", "intensity": 0.8, "direction": [1, 0.5, -1]}],
            "actors": [{"name": name, "model": name, "class": "person", "position": [0, 1.5 - k, 0], "yaw_deg": 180, **told} for k, name in enumerate(PEOPLE)],
        }))
        return file

    return scene_


def pictures(scene, quality="simple", device="cpu", change=lambda rig: None):
    """Before and after the change, while nobody moves."""
    with camrig.start(scene, mode="lockstep", device=device) as rig:
        eye = rig.create_camera("eye", size=(320, 160), fps=10, vfov_deg=40, position=(-5, 0, 1.4), look_at=(0, 0, 1), quality=quality, antialias="none")
        rig.step(seconds=0.2)
        before = eye.frame().image.astype(int)
        change(rig)
        rig.step(seconds=0.1)
        return before, eye.frame().image.astype(int), rig.actors()


def differing(a, b):
    """Share of the pixels that differ by more than 12 codes."""
    return float((np.abs(a - b).max(axis=2) > 12).mean())


@pytest.mark.parametrize("quality", ["fast", "simple", "beautiful"])
def test_one_number_is_one_look_and_another_is_another(scene, quality):
    plain, _, actors = pictures(scene(), quality)
    assert all(actor["variant"] is None for actor in actors)
    five, _, actors = pictures(scene(5), quality)
    again, _, _ = pictures(scene(5), quality)
    six, _, _ = pictures(scene(6), quality)
    assert all(actor["variant"] == 5 for actor in actors)
    assert (five == again).all()
    assert min(differing(plain, five), differing(five, six), differing(plain, six)) > 0.03


def test_who_stands_still_is_dressed_anew_at_once(scene):
    before, after, actors = pictures(scene(5), change=lambda rig: rig.set_actor("ben", variant=6))
    assert {actor["name"]: actor["variant"] for actor in actors} == {"anna": 5, "ben": 6, "clara": 5, "ivan": 5}
    changed = np.abs(after - before).max(axis=2) > 12
    assert changed[:, 80:160].mean() > 0.02 and not changed[:, 170:].any() and not changed[:, :70].any()


@pytest.mark.parametrize("quality", ["simple", "beautiful"])
def test_opengl_shows_the_same_looks(scene, quality):
    ours, _, _ = pictures(scene(5), quality)
    theirs, _, _ = pictures(scene(5), quality, device="llvmpipe")
    assert differing(ours, theirs) < 0.01


def test_a_wrong_variant_is_an_error_that_says_so(scene):
    with camrig.start(scene(), mode="lockstep") as rig, pytest.raises(camrig.CamrigError, match="variant"):
        rig.set_actor("anna", variant=-1)


def test_a_seed_makes_light_and_clothes_of_a_running_world_and_of_a_plan_alike(tmp_path):
    def seen(seed):
        with camrig.start("crowd", mode="lockstep", device="cpu") as rig:
            made = rig.randomize(seed)
            rig.step(seconds=0.1)
            assert all(actor["variant"] == made[f"/actors/{actor['name']}/variant"] for actor in rig.actors())
            return made, rig.create_camera("eye", place="west", size=(320, 240), fps=10).frame().image.astype(int)

    made, picture = seen(3)
    again, same = seen(3)
    other, another = seen(4)
    assert made == again == changes(read_scene_file(scene_path("crowd")), 3) and (picture == same).all()
    assert made != other and differing(picture, another) > 0.5
    assert 50 < picture.mean() < 200 and 50 < another.mean() < 200


def test_what_a_scenes_base_has_can_be_changed_too(tmp_path):
    path = scene_path("street-noon")
    made = changes(on_its_base(read_scene_file(path), path), 9)
    file = write_varied("street-noon", varied(read_scene("street-noon"), None, made), tmp_path / "scene")
    subprocess.run([camrig.find_binary(), "check", file], check=True)
    with camrig.start(file, mode="lockstep") as rig:
        assert {actor["variant"] for actor in rig.actors() if actor["class"] == "person"} == {value for place, value in made.items() if place.endswith("/variant")}


@pytest.mark.parametrize("name", ["street", "minimal"])
def test_a_plans_daylight_goes_with_a_scene_that_has_light_of_its_own(tmp_path, name):
    file = write_varied(name, varied(read_scene(name), None, changes(read_scene(name), 4, ["light"])), tmp_path / "scene")
    subprocess.run([camrig.find_binary(), "check", file], check=True)


@pytest.mark.parametrize("name", ["street-evening", "street-night"])
def test_the_day_that_chance_makes_is_exposed_for_whatever_was_white_before(name):
    with camrig.start(name, mode="lockstep", device="cpu") as rig:
        eye = rig.create_camera("eye", size=(160, 120), fps=10, position=(-12, -2, 6), look_at=(0, 0, 1))
        rig.randomize(3, ["light"])
        rig.step(seconds=0.1)
        assert 50 < eye.frame().image.mean() < 200


def test_the_command_line_randomizes_a_running_rig(scene):
    with camrig.start(scene(), mode="lockstep") as rig:
        told = subprocess.run([camrig.find_binary(), "--control", rig.control, "--json", "randomize", "7", "--only", "clothes"], check=True, capture_output=True, text=True)
        assert json.loads(told.stdout) == {f"/actors/{actor['name']}/variant": actor["variant"] for actor in rig.actors()}
        wrong = subprocess.run([camrig.find_binary(), "--control", rig.control, "randomize", "-1"], capture_output=True, text=True)
        assert wrong.returncode == 2 and len(wrong.stderr.splitlines()) == 1
