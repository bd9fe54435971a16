"""Scene files that stand on others (`base`), put together as the rig does (core/world/scene_base.h)."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any, Iterator

from .errors import CamrigError
from .places import find_binary, find_scene

_MAX_SCENE_BYTES = 16 << 20
_MAX_BASES = 8
_SHIPPED = "camrig:"


def scene_path(scene: str) -> Path:
    """The file of a scene: "hall" is a shipped one, as for `camrig serve`; anything else is a path."""
    is_word = "/" not in scene and "." not in scene
    if is_word and (folder := os.environ.get("CAMRIG_SCENES")):
        return Path(folder, f"{scene}.json")
    return Path(find_scene(f"scenes/{scene}.json" if is_word else scene, find_binary())).absolute()


def read_scene_file(path: Path) -> dict[str, Any]:
    """The file's JSON, its `base` as it is."""
    try:
        with open(path, "rb") as file:
            text = file.read(_MAX_SCENE_BYTES + 1)
    except OSError as problem:
        raise CamrigError("not_found", f"{path}: {problem.strerror}") from None
    try:
        value = json.loads(text) if len(text) <= _MAX_SCENE_BYTES else None
    except (ValueError, RecursionError) as problem:
        raise CamrigError("invalid_argument", f"{path}: is not JSON: {problem}; a scene file is asked for, no bare model") from None
    if not isinstance(value, dict) or not isinstance(value.get("cameras", []), list):
        raise CamrigError("invalid_argument", f"{path}: is no scene file")
    return value


def on_its_base(document: dict[str, Any], path: Path) -> dict[str, Any]:
    """All of a scene: what `document`, of the file `path`, says over what its bases say."""
    changes = []
    for _, below in _chain(document, path):
        changes.append({key: value for key, value in document.items() if key != "base"})
        document = below
    made = copy.deepcopy(document)
    for change in reversed(changes):
        _put_over(made, change)
    return made


def scene_files(path: Path) -> list[Path]:
    """A scene's file and those that it stands on, nearest first."""
    return [path, *(file for file, _ in _chain(read_scene_file(path), path))]


def _chain(document: dict[str, Any], path: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """What a document, of the file `path`, stands on, nearest first."""
    at, are_shipped = path, False  # and what they stand on
    for _ in range(_MAX_BASES):
        if "base" not in document:
            return
        named = document["base"]
        if not isinstance(named, str):
            raise CamrigError("invalid_argument", f"{at}: base: must be a text")
        if named.startswith(_SHIPPED):
            at, are_shipped = scene_path(named.removeprefix(_SHIPPED)), True
        elif "/" in named or not named.endswith(".json"):
            raise CamrigError("invalid_argument", f"{at}: base: must be a .json file of the same folder, or camrig: and the name of a shipped scene")
        else:
            at = at.parent / named
        document = read_scene_file(at)
        if are_shipped:
            _name_as_shipped(document)
        yield at, document
    if "base" in document:
        raise CamrigError("invalid_argument", f"{path}: base: more than {_MAX_BASES} files stand on each other")


def _is_named(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(one, dict) and isinstance(one.get("name"), str) for one in value)


def _put_over(base: dict[str, Any], change: dict[str, Any]) -> None:
    for key, value in change.items():
        kept = base.get(key)
        if value is None:
            base.pop(key, None)
        elif isinstance(value, dict):
            if not isinstance(kept, dict):
                kept = base[key] = {}
            _put_over(kept, value)
        elif kept and _is_named(kept) and _is_named(value):
            for item in value:
                same = next((one for one in kept if one["name"] == item["name"]), None)
                if same is None:
                    kept.append(same := {})
                _put_over(same, item)
        else:
            base[key] = copy.deepcopy(value)


def _name_as_shipped(document: dict[str, Any]) -> None:
    """Models of a shipped scene, for a file that lies elsewhere."""
    for model in document.get("models", {}).values():
        if isinstance(model, dict) and isinstance(model.get("file"), str) and not model["file"].startswith(_SHIPPED):
            model["file"] = _SHIPPED + model["file"]
