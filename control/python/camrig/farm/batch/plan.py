"""A plan: which shards a data set has, read from a JSON file."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Iterator, Mapping

from ...errors import CamrigError
from ...places import find_binary
from ...json_checks import Wrong, check_choice, check_integer, check_list, check_number, check_object, check_text, inside, read_json
from ...randomize import KINDS, changes as randomized
from .hashing import canonical, file_hash, seed_of
from .pointer import PointerError
from .scene_file import read_scene, scene_hash, varied
from .shard import MAX_CAMERAS, MAX_SHARDS, Pictures, Shard
from .variants import Row, rows_of

MAX_FILE_BYTES = 64 << 20
_MAX_FAULTS = 1000
_MAX_SECONDS = 1e9
_QUALITIES = ("fast", "simple", "beautiful")
#: What a plan says of every variant, and `vary` of some.
_VARIED = ("scene", "seed", "quality", "device", "start_s", "seconds", "cameras", "faults", "randomize")
_KEYS = {"camrig_plan", "description", "master_seed", "shard_seconds", "pictures", "set", "vary", *_VARIED}


@dataclass(frozen=True)
class Plan:
    text: dict[str, Any]  #: as it was read
    shards: list[Shard]  #: each of them once, in the order of the table


def load(path: str | os.PathLike[str]) -> Plan:
    """Reads a plan; CamrigError names the file and the place of what is wrong, as in ``sweep.json: vary[0].sobol./lights/sun: ..``."""
    where = os.fspath(path)
    value = read_json(where, MAX_FILE_BYTES)
    try:
        return Plan(value, list(_shards(_checked(value), Path(where).absolute().parent)))
    except Wrong as wrong:
        raise CamrigError("invalid_argument", f"{where}: {wrong}") from None


def _checked(plan: Any) -> Mapping[str, Any]:
    check_object(plan, "", _KEYS)
    if plan.get("camrig_plan") != 1:
        raise Wrong("camrig_plan", "must be 1, the format's number")
    check_object(plan.get("set", {}), "set")
    for place in plan.get("set", {}):
        if not place.startswith("/"):
            raise Wrong(inside("set", place), "must be a place in the scene, as /environment/exposure")
    return plan


def _shards(plan: Mapping[str, Any], folder: Path) -> Iterator[Shard]:
    master = check_integer(plan.get("master_seed", 0), "master_seed", 0, 2**53)
    pictures = _pictures(plan.get("pictures", {}))
    shard_ns = _ns(plan["shard_seconds"], "shard_seconds", 1e-3) if "shard_seconds" in plan else None
    common = {key: plan[key] for key in _VARIED if key in plan}
    changes, program, scenes = plan.get("set", {}), file_hash(find_binary()), _Scenes(folder)
    seen: dict[str, int] = {}
    for number, row in enumerate(rows_of(plan.get("vary", []), master)):
        place = f"variant {number}"
        for key in row:
            if not key.startswith("/") and key not in (*_VARIED, "repeat"):
                raise Wrong("vary", f"'{key}' is neither a place in the scene (as /lights/0/intensity) nor one of {', '.join(_VARIED)}")
        told = {**common, **changes, **row}
        for shard in _of_variant(place, told, row, master, shard_ns, pictures, program, scenes):
            if (earlier := seen.setdefault(shard.id, number)) != number:
                how = "a fixed seed makes repeats the same; leave seed out" if "repeat" in row and "seed" in told else 'for more of one, add {"repeat": N}'
                raise Wrong("vary", f"variants {earlier} and {number} are the same; {how}")
            if len(seen) > MAX_SHARDS:
                raise Wrong("vary", f"makes more than {MAX_SHARDS} shards; take longer ones (shard_seconds)")
            yield shard


def _of_variant(place: str, told: Mapping[str, Any], row: Row, master: int, shard_ns: int | None, pictures: Pictures, program: str,
                scenes: _Scenes) -> Iterator[Shard]:
    """The shards of one row of the table: one, or one for each `shard_seconds` of it."""
    if "scene" not in told or "seconds" not in told:
        raise Wrong("scene" if "scene" not in told else "seconds", "is missing")
    cameras = told.get("cameras")
    if cameras is not None:
        check_list(cameras, f"{place}: cameras", MAX_CAMERAS)
    faults = told.get("faults", [])
    if not isinstance(faults, list) or len(faults) > _MAX_FAULTS or not all(isinstance(fault, dict) for fault in faults):
        raise Wrong(f"{place}: faults", f"must be a list of at most {_MAX_FAULTS} objects, as fault.set takes them")
    scene = scenes.name(check_text(told["scene"], f"{place}: scene"))
    # By what the row says and not by its number: a plan that grows keeps its frames.
    seed = check_integer(told.get("seed", seed_of(master, "row", row)), f"{place}: seed", 0, 2**53)
    kinds = [check_choice(kind, f"{place}: randomize", KINDS) for kind in check_list(told.get("randomize", []), f"{place}: randomize", len(KINDS))] if told.get("randomize") else []
    changes = {key: value for key, value in told.items() if key.startswith("/")}
    if kinds:
        # Chance changes the scene as the plan has it; what the plan says stays.
        changes = {**randomized(scenes.varied(place, scene, None, changes), seed, kinds), **changes}
    start_ns, length_ns = _ns(told.get("start_s", 0), f"{place}: start_s", 0), _ns(told["seconds"], f"{place}: seconds", 1e-3)
    common = dict(
        scene=scene, scene_hash=scenes.hash(place, scene, cameras, changes), program_hash=program, cameras=cameras, changes=changes, faults=faults,
        seed=seed,
        quality=check_choice(told.get("quality", "simple"), f"{place}: quality", _QUALITIES),
        device=str(told.get("device", "cpu")), pictures=pictures)
    step_ns = shard_ns or length_ns
    for begin_ns in range(start_ns, start_ns + length_ns, step_ns):
        yield Shard(start_ns=begin_ns, end_ns=min(begin_ns + step_ns, start_ns + length_ns), **common)


class _Scenes:
    """Scenes of a plan, each read once; hashes, each computed once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._read: dict[str, dict[str, Any]] = {}
        self._hashes: dict[str, str] = {}

    def name(self, scene: str) -> str:
        """A word names a shipped scene, of every machine's own; a path is one from the plan's folder."""
        is_word = "/" not in scene and "." not in scene
        return scene if is_word or not (self._folder / scene).is_file() else str(self._folder / scene)

    def varied(self, place: str, scene: str, cameras: list[Any] | None, changes: Mapping[str, Any]) -> dict[str, Any]:
        """All of it, its base put in, with these cameras and changes; Wrong names the place in the plan of one that leads nowhere."""
        if scene not in self._read:
            self._read[scene] = read_scene(scene)
        try:
            return varied(self._read[scene], cameras, changes)
        except PointerError as wrong:
            raise Wrong(place, str(wrong)) from None

    def hash(self, place: str, scene: str, cameras: list[Any] | None, changes: Mapping[str, Any]) -> str:
        key = canonical([scene, cameras, changes])
        if key not in self._hashes:
            made = self.varied(place, scene, cameras, changes)
            if not made.get("cameras"):
                raise Wrong(f"{place}: cameras", f"are missing: {scene} has none of its own")
            self._hashes[key] = scene_hash(scene, made)
        return self._hashes[key]


def _pictures(told: Any) -> Pictures:
    check_object(told, "pictures", {field.name for field in fields(Pictures)})
    check_choice(told.get("format", "jpeg"), "pictures.format", ("png", "jpeg"))
    check_choice(told.get("depth"), "pictures.depth", ("npy", "png", None))
    for key in ("flow", "masks", "soiling", "yolo"):
        check_choice(told.get(key, False), f"pictures.{key}", (True, False))
    return Pictures(**told)


def _ns(seconds: Any, place: str, low: float) -> int:
    return round(check_number(seconds, place, low, _MAX_SECONDS) * 1e9)
