"""The scene of a variant: a shipped or given scene with some of its values changed, in a folder of its own; and the hash of all that it is made of."""

from __future__ import annotations

import copy
import functools
import json
import os
import struct
from pathlib import Path
from typing import Any, Iterator, Mapping
from urllib.parse import unquote

from ...scene_base import on_its_base, read_scene_file, scene_files, scene_path
from .hashing import canonical, file_hash, text_hash
from .pointer import PointerError, assign

_MAX_HEAD_BYTES = 16 << 20
_MAX_MODEL_BYTES = 256 << 20
_SHIPPED = "camrig:"
_LIGHT = ".light"
_ENVIRONMENT = "/environment/"
_DAYLIGHT = _ENVIRONMENT + "daylight"
#: Made by daylight: the rig refuses a scene that says them beside it.
_MADE_BY_DAYLIGHT = ("ambient", "background")


def read_scene(scene: str) -> dict[str, Any]:
    """All of it, its base put in."""
    path = scene_path(scene)
    return on_its_base(read_scene_file(path), path)


def varied(scene: Mapping[str, Any], cameras: list[Any] | None, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The scene with these cameras instead of its own, then with the changes, whose keys are places (pointer.py). Cameras lose their outputs:
    nobody but the recording watches. Daylight that comes takes the place of the scene's own ambient light and background. Raises PointerError."""
    made = copy.deepcopy(dict(scene))
    if cameras is not None:
        made["cameras"] = copy.deepcopy(cameras)
    if _DAYLIGHT in changes and isinstance(environment := made.get("environment"), dict):
        for key in _MADE_BY_DAYLIGHT:
            place = _ENVIRONMENT + key
            if not any(change == place or change.startswith(f"{place}/") for change in changes):
                environment.pop(key, None)
    if any(place.startswith(_ENVIRONMENT) for place in changes):
        made.setdefault("environment", {})  # a scene need not say anything of it
    for place, value in changes.items():
        try:
            assign(made, place, copy.deepcopy(value))
        except PointerError as wrong:
            raise PointerError(f"{place}: {wrong}") from None
    for camera in made.get("cameras", []):
        if isinstance(camera, dict):
            camera.pop("outputs", None)
    return made


def write_varied(scene: str, made: Mapping[str, Any], folder: Path) -> Path:
    """The changed scene as a file in that folder, which sees all files that the scene it was made from sees."""
    original = scene_path(scene)
    folder.mkdir()
    for beside in original.parent.iterdir():
        if beside.name != original.name:
            (folder / beside.name).symlink_to(beside)
    own = folder / original.with_suffix(_LIGHT).name
    if not own.exists() and (light := _light(original)):
        own.symlink_to(light)
    file = folder / original.name
    file.write_text(canonical(made), encoding="utf-8")
    return file


def scene_hash(scene: str, made: Mapping[str, Any]) -> str:
    """SHA-256 of a changed scene with every file that it names: models, what glTF models refer to, films, and its baked light."""
    path = scene_path(scene)
    files = {name: file_hash(file) for name, file in _assets(path, made)}
    return text_hash([made, files])


def _light(scene: Path) -> Path | None:
    """What was baked for a scene, or else for one that it stands on."""
    return next((light for file in scene_files(scene) if (light := file.with_suffix(_LIGHT)).is_file()), None)


def _assets(scene: Path, made: Mapping[str, Any]) -> Iterator[tuple[str, Path]]:
    if light := _light(scene):
        yield "light", light
    for text in _texts(made):
        if text.startswith(_SHIPPED):
            name = text.removeprefix(_SHIPPED)
            file = scene_path("minimal").parent / (name if Path(name).suffix else name + ".glb")
        elif "\0" in text or len(text) > 1000:
            continue
        else:
            file = scene.parent / text
        try:
            is_file = file.is_file()
        except OSError:  # a text that is too long for a name
            continue
        if is_file:
            yield text, file
            for uri in _referred(str(file), file.stat().st_mtime_ns):
                if os.path.isfile(referred := file.parent / unquote(uri, errors="surrogateescape")):
                    yield f"{text}/{uri}", referred


@functools.lru_cache(maxsize=4096)
def _referred(model: str, mtime_ns: int) -> list[str]:
    """The URIs of files that a glTF model refers to; read once while it stays as it is."""
    if not model.endswith((".gltf", ".glb")):
        return []
    try:
        with open(model, "rb") as file:
            if model.endswith(".glb"):  # its first chunk, behind a head of 12 bytes
                (size,) = struct.unpack("<I", file.read(16)[12:])
                file.seek(20)
                told = json.loads(file.read(min(size, _MAX_HEAD_BYTES)))
            else:
                told = json.loads(file.read(_MAX_MODEL_BYTES))
        uris = [part.get("uri") for key in ("buffers", "images") for part in told.get(key, [])]
    except (OSError, ValueError, struct.error, AttributeError):
        return []  # camrig says what is wrong with it
    return [uri for uri in uris if isinstance(uri, str) and not uri.startswith("data:")]


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from _texts(one)
    elif isinstance(value, list):
        for one in value:
            yield from _texts(one)
