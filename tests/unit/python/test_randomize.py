"""Light and clothes by chance: what a seed makes of a scene, and where a plan of `camrig farm record` takes it from."""

import json

import pytest

from camrig import CamrigError
from camrig.farm.batch import plan as plans
from camrig.farm.batch.pointer import assign
from camrig.randomize import changes, main, randomize
from camrig.scene_base import on_its_base, read_scene_file, scene_path

STREET = {
    "camrig_scene": 1,
    "environment": {"exposure": 2.0},
    "lights": [{"name": "sun", "intensity": 1}, {"name": "lamp", "intensity": 3}],
    "actors": [{"name": "anna", "class": "person"}, {"name": "bob/1", "class": "person"}, {"name": "car", "class": "car"}],
    "cameras": [{"name": "eye"}],
}
HALL = {"lights": [{"name": "lamp", "intensity": 3}], "environment": {}}


def test_a_seed_makes_the_same_of_a_scene_for_ever_and_another_something_else():
    made = changes(STREET, 7)
    assert made == changes(STREET, 7)
    assert made["/actors/anna/variant"] == 1082518719 and made["/environment/daylight"]["elevation_deg"] == 14.9320632
    other = changes(STREET, 8)
    assert made.keys() == other.keys() and all(made[place] != other[place] for place in made)


def test_one_kind_and_one_person_do_not_change_with_another():
    both = changes(STREET, 7)
    assert both == changes(STREET, 7, ["light"]) | changes(STREET, 7, ["clothes"])
    assert changes(STREET, 7, ["clothes"], ["anna"])["/actors/anna/variant"] == both["/actors/anna/variant"]
    assert set(changes(STREET, 7, ["clothes"])) == {"/actors/anna/variant", "/actors/bob~11/variant"}
    assert changes(STREET, 7, []) == {}


def test_the_sun_is_up_and_exposed_for_and_where_there_is_none_lamps_vary():
    for seed in range(200):
        made = changes(STREET, seed, ["light"])
        day = made["/environment/daylight"]
        assert 8 <= day["elevation_deg"] <= 68 and 2 <= day["turbidity"] <= 10 and 0 <= day["overcast"] <= 1
        assert 0.5 < made["/environment/exposure"] < 50
        lamps = changes(HALL, seed, ["light"])
        assert set(lamps) == {"/lights/lamp/intensity", "/environment/exposure"}
        assert 1.5 <= lamps["/lights/lamp/intensity"] <= 4.5 and 0.7 < lamps["/environment/exposure"] < 1.42
    by_daylight = {**HALL, "environment": {"daylight": {"azimuth_deg": 0, "elevation_deg": 10}}}
    assert changes(by_daylight, 1, ["light"]) == changes(STREET, 1, ["light"])
    assert sum(changes(STREET, seed, ["light"])["/environment/daylight"]["overcast"] == 0 for seed in range(200)) in range(70, 130)


@pytest.mark.parametrize("scene", ["street-noon", "street-evening", "street-night"])
def test_the_exposure_is_for_the_lux_that_make_white_white(scene):
    made, noon = (changes(on_its_base(read_scene_file(path), path), 5, ["light"]) for path in (scene_path(scene), scene_path("street-noon")))
    lux = json.loads(scene_path(scene).read_text())["environment"]["lux"]
    assert made["/environment/exposure"] * 1e5 / lux == pytest.approx(noon["/environment/exposure"]), "under one sky a street looks alike"
    assert noon == changes(STREET, 5, ["light"]), "daylight without a word of it has 100 klx"


def test_every_change_finds_its_place_in_the_scene():
    scene = json.loads(json.dumps(STREET))
    for place, value in changes(scene, 3).items():
        assign(scene, place, value)
    assert all("variant" in actor for actor in scene["actors"] if actor["class"] == "person") and "variant" not in scene["actors"][2]


def test_an_unknown_kind_is_an_error_that_lists_them():
    with pytest.raises(CamrigError, match="'hats' is none of light, clothes"):
        changes(STREET, 1, ["hats"])


def test_a_scene_on_a_base_is_whole(tmp_path):
    (tmp_path / "low.json").write_text(json.dumps({**STREET, "cameras": [{"name": "eye"}]}))
    high = {"base": "low.json", "environment": {"exposure": None, "glow": 2}, "lights": [{"name": "lamp", "intensity": 9}, {"name": "new", "color": None}],
            "fog": {"far": None}, "cameras": []}
    whole = on_its_base(high, tmp_path / "high.json")
    assert whole["environment"] == {"glow": 2} and "base" not in whole
    assert whole["lights"] == [{"name": "sun", "intensity": 1}, {"name": "lamp", "intensity": 9}, {"name": "new"}]
    assert whole["fog"] == {} and whole["cameras"] == [{"name": "eye"}], "as the rig puts them together"


@pytest.mark.parametrize("base", ["../low.json", "low.txt"])
def test_a_base_lies_beside_its_scene(tmp_path, base):
    with pytest.raises(CamrigError, match="high.json: base: must be a .json file of the same folder"):
        on_its_base({"base": base}, tmp_path / "high.json")


def test_models_of_what_a_shipped_scene_stands_on_are_shipped_too(tmp_path):
    whole = on_its_base({"base": "camrig:street-night"}, tmp_path / "own.json")
    files = [model["file"] for model in whole["models"].values() if "file" in model]
    assert files and all(file.startswith("camrig:") for file in files)


def test_bases_that_stand_on_themselves_are_an_error(tmp_path):
    (tmp_path / "round.json").write_text(json.dumps({"base": "round.json"}))
    with pytest.raises(CamrigError, match="more than 8 files"):
        on_its_base({"base": "round.json"}, tmp_path / "round.json")


def test_a_plan_randomizes_each_world_by_its_seed(tmp_path, monkeypatch):
    (tmp_path / "program").write_bytes(b"camrig")
    monkeypatch.setenv("CAMRIG_BIN", str(tmp_path / "program"))
    (tmp_path / "scene.json").write_text(json.dumps(STREET))

    def shards(**keys):
        (tmp_path / "plan.json").write_text(json.dumps({"camrig_plan": 1, "scene": "scene.json", "seconds": 1, **keys}))
        return plans.load(tmp_path / "plan.json").shards

    made = shards(randomize=["light", "clothes"], set={"/environment/exposure": 1.5}, vary=[{"repeat": 3}])
    assert len({shard.changes["/actors/anna/variant"] for shard in made}) == 3
    for shard in made:
        # What a plan says itself it says for good.
        assert shard.changes == {**changes(STREET, shard.seed), "/environment/exposure": 1.5}
    assert shards(vary=[{"repeat": 3}])[0].changes == {}
    with pytest.raises(CamrigError, match="randomize: must be one of"):
        shards(randomize=["hats"])


def test_a_running_rig_is_told_the_same_by_its_methods(tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps(STREET))

    class Told:
        calls: list = []

        def status(self):
            return {"scene_file": str(tmp_path / "scene.json")}

        def actors(self):
            return [{"name": "anna", "class": "person"}, {"name": "late", "class": "person"}, {"name": "car", "class": "car"}]

        def act(self, *actions):
            self.calls.append(("event.act", actions))

        def set_actor(self, name, **keys):
            self.calls.append(("actor.set", {"name": name, **keys}))

    rig = Told()
    made = randomize(rig, 7)
    assert made == changes(STREET, 7, people=["anna", "late"])
    assert ("actor.set", {"name": "late", "variant": made["/actors/late/variant"]}) in rig.calls
    assert rig.calls[-1] == ("event.act", ({"action": "environment", "daylight": made["/environment/daylight"], "exposure": made["/environment/exposure"]},))


@pytest.mark.parametrize("seed", ["x", "-1", "1.5", "9007199254740992", "9" * 5000])
def test_a_seed_that_is_none_is_told(seed, capsys):
    with pytest.raises(SystemExit):
        main([seed] if seed[0] != "-" else ["--", seed])
    assert "is not a whole number from 0 to 2^53 - 1" in capsys.readouterr().err


def test_lamps_of_a_group_stay_alike_and_units_stay_units():
    lamps = [{"name": name, "group": "row", "intensity": 2} for name in ("a", "b")] + [{"name": "c", "intensity": 2}, {"name": "d", "candela": 40}]
    made = changes({"lights": lamps, "environment": {"lux": 100}}, 7, ["light"])
    assert made["/lights/a/intensity"] == made["/lights/b/intensity"] != made["/lights/c/intensity"]
    assert 20 <= made["/lights/d/candela"] <= 60 and "/lights/d/intensity" not in made
