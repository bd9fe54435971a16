"""Who sees whom in a network of cameras, and how people pass from one to the other: the truth of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Network:
    """What truth.network answers (docs/truth.md): one instant, all cameras."""

    time_ns: int
    #: name, position, objects (how many it sees), ground_m2
    cameras: list[dict[str, Any]]
    #: those that a camera sees: id, name, class, position, seen_by
    objects: list[dict[str, Any]]
    #: of two cameras that share anything: cameras, objects, object_share, ground_m2, ground_share
    overlaps: list[dict[str, Any]]

    def seen_by(self, camera: str) -> dict[str, dict[str, Any]]:
        """What a camera sees of each object, by the object's name."""
        return {item["name"]: one for item in self.objects for one in item["seen_by"] if one["camera"] == camera}

    def who_sees(self, name: str) -> dict[str, dict[str, Any]]:
        """What each camera sees of an object: pixels, visible_fraction, azimuth_deg and so on, by the camera's name."""
        return {one["camera"]: one for item in self.objects if item["name"] == name for one in item["seen_by"]}

    def graph(self, weight: str = "ground_share") -> dict[str, dict[str, float]]:
        """The overlap graph: for each camera its neighbours. weight: objects, object_share, ground_m2 or ground_share."""
        edges: dict[str, dict[str, float]] = {camera["name"]: {} for camera in self.cameras}
        for overlap in self.overlaps:
            a, b = overlap["cameras"]
            if overlap[weight] > 0:
                edges[a][b] = edges[b][a] = overlap[weight]
        return edges


@dataclass(frozen=True)
class Passage:
    """An object came into the view of a camera (``entered``), or left it."""

    time_ns: int
    object_id: int
    name: str
    camera: str
    entered: bool


@dataclass(frozen=True)
class Handover:
    """An object passed from one camera to another: from the one that had it to the one that has it now.

    ``overlap_ns``: for so long both saw it before; below 0, for so long nobody did.
    """

    time_ns: int
    object_id: int
    name: str
    source: str
    target: str
    overlap_ns: int


@dataclass
class _Followed:
    name: str
    #: since when which camera has seen it
    since: dict[str, int] = field(default_factory=dict)
    holder: str | None = None
    #: when its holder saw it last, of an object that nobody sees
    lost_ns: int = 0


class Handovers:
    """The ground truth of hand-overs over time: give it each instant of Rig.visibility in order.

    An object is in the view of a camera that sees ``min_visible`` of it or more, on ``min_pixels`` or more. The first to see it has it (of
    several, that with the most pixels) until it does not see it any more; then that of the others has it which shows most pixels of it, or
    the next that sees it at all.
    """

    def __init__(self, min_visible: float = 0.2, min_pixels: int = 50) -> None:
        self.min_visible = min_visible
        self.min_pixels = min_pixels
        self.passages: list[Passage] = []
        self.handovers: list[Handover] = []
        self._followed: dict[int, _Followed] = {}
        self._time_ns = -1

    def update(self, network: Network) -> tuple[list[Passage], list[Handover]]:
        """What happened since the last instant; all of it is kept in ``passages`` and ``handovers``."""
        if network.time_ns <= self._time_ns:
            raise ValueError(f"update: instants must rise; {network.time_ns} ns comes after {self._time_ns} ns")
        self._time_ns = network.time_ns
        seen: dict[int, dict[str, int]] = {}
        for item in network.objects:
            pixels = {
                one["camera"]: one["pixels"]
                for one in item["seen_by"]
                if one["visible_fraction"] >= self.min_visible and one["pixels"] >= self.min_pixels
            }
            if pixels:
                seen[item["id"]] = pixels
                self._followed.setdefault(item["id"], _Followed(item["name"]))
        passages, handovers = len(self.passages), len(self.handovers)
        for number, followed in self._followed.items():
            self._follow(number, followed, seen.get(number, {}))
        return self.passages[passages:], self.handovers[handovers:]

    def _follow(self, number: int, followed: _Followed, pixels: dict[str, int]) -> None:
        now = self._time_ns
        for camera in sorted(pixels.keys() | followed.since.keys()):
            if (camera in pixels) != (camera in followed.since):
                self.passages.append(Passage(now, number, followed.name, camera, camera in pixels))
        had = followed.holder in followed.since
        followed.since = {camera: followed.since.get(camera, now) for camera in pixels}
        if followed.holder in pixels:
            return
        if had:
            followed.lost_ns = now
        if not pixels:
            return
        target = max(sorted(pixels), key=lambda camera: pixels[camera])
        if followed.holder is not None:
            overlap_ns = followed.lost_ns - followed.since[target]
            self.handovers.append(Handover(now, number, followed.name, followed.holder, target, overlap_ns))
        followed.holder = target
