"""scenes/schema.json and the scene loader tell the same scenes from the same mistakes.

The loader's half is tests/unit/world/scene_loader_test.cpp, over the same cases. Nothing here starts a rig.
"""

import copy
import json
import re

import jsonschema
import pytest

from conftest import REPOSITORY

CASES = json.loads((REPOSITORY / "tests/unit/world/scene_cases.json").read_text())
SCENES = sorted((REPOSITORY / "scenes").glob("*.json"))
GUIDE = REPOSITORY / "docs/scene-format.md"


@pytest.fixture(scope="module")
def schema():
    loaded = json.loads((REPOSITORY / "scenes/schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(loaded)
    return loaded


@pytest.fixture(scope="module")
def validator(schema):
    return jsonschema.Draft202012Validator(schema)


def edited(case):
    """The scene of the cases with one place set, or removed when the case gives no value."""
    scene = copy.deepcopy(CASES["scene"])
    *path, last = case["at"].split("/")[1:]
    parent = scene
    for key in path:
        parent = parent[int(key) if isinstance(parent, list) else key]
    last = int(last) if isinstance(parent, list) else last
    if "value" in case:
        parent[last] = case["value"]
    else:
        del parent[last]
    return scene


def name_of(case):
    return f"{case['at']}={json.dumps(case.get('value', 'gone'))[:24]}"


@pytest.mark.parametrize("file", [f for f in SCENES if f.name != "schema.json"], ids=lambda f: f.stem)
def test_the_scenes_follow_the_schema(validator, file):
    validator.validate(json.loads(file.read_text()))


def test_the_unedited_cases_follow_the_schema(validator):
    validator.validate(CASES["scene"])


@pytest.mark.parametrize("case", CASES["right"], ids=name_of)
def test_right_edits_follow_the_schema(validator, case):
    validator.validate(edited(case))


@pytest.mark.parametrize("case", CASES["wrong"], ids=name_of)
def test_wrong_edits_are_refused_unless_only_the_loader_can_tell(validator, case):
    assert validator.is_valid(edited(case)) == case.get("beyond_schema", False)


def test_the_example_of_the_guide_follows_the_schema(validator):
    examples = re.findall(r"```json\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    assert len(examples) == 1
    validator.validate(json.loads(examples[0]))


def test_the_guide_names_every_key(schema):
    keys = set()

    def collect(part):
        if isinstance(part, dict):
            keys.update(part.get("properties", {}))
            for value in part.values():
                collect(value)
        elif isinstance(part, list):
            for value in part:
                collect(value)

    collect(schema)
    assert len(keys) > 50
    text = GUIDE.read_text()
    assert [key for key in sorted(keys) if f"`{key}`" not in text] == []
