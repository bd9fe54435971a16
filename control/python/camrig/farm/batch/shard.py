"""A shard: one file of a data set, and all that decides what is in it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Mapping

from .hashing import text_hash

#: Of what a shard holds and how it is named; another number makes other names.
FORMAT = 1
#: Of a plan, and of a scene as the rig takes it.
MAX_SHARDS, MAX_CAMERAS = 1_000_000, 256


@dataclass(frozen=True)
class Pictures:
    """What is kept of each frame, as `camrig record` has it: `format` png or jpeg, `depth` npy, png or None."""

    format: str = "jpeg"
    depth: str | None = None
    flow: bool = False
    masks: bool = False
    soiling: bool = False
    yolo: bool = False


@dataclass(frozen=True)
class Shard:
    """Frames due after `start_ns` and up to `end_ns` of world time, of all cameras of a scene with `changes` (places and values) made to it.

    `scene_hash` is that of the changed scene with its files, `program_hash` that of the camrig program: a shard that would be drawn otherwise has
    another name.
    """

    scene: str
    scene_hash: str
    program_hash: str
    seed: int
    start_ns: int
    end_ns: int
    cameras: list[Any] | None
    changes: Mapping[str, Any]
    faults: list[Any]
    quality: str
    device: str
    pictures: Pictures

    @property
    def id(self) -> str:
        """16 hex digits that stand for all of it; the name of its file."""
        told = dataclasses.asdict(self)
        for part_of_scene in ("scene", "cameras", "changes"):
            del told[part_of_scene]  # where a scene lies changes nothing; the others are in its hash
        return text_hash([FORMAT, told])[:16]

    def to_json(self) -> dict[str, Any]:
        return dataclasses.asdict(self)

    @staticmethod
    def from_json(told: Mapping[str, Any]) -> Shard:
        return Shard(**{**told, "pictures": Pictures(**told["pictures"])})
