"""Which nodes a network has, from its plan: the JSON that the conductor writes and every program and replay reads."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camrig.frame_times import due_ns, rate_of

from .camera_node import CameraNode
from .central_node import CENTRE, CentralNode, Reporter
from .close_ups import HeadNode
from .node import Node
from .strategies import STRATEGIES

NEIGHBOURS = 2  # of the consensus: each camera's nearest ones, both ways


@dataclass(frozen=True)
class Plan:
    cameras: dict[str, dict[str, Any]]  #: fixed cameras by name: calibration, as camera.get answers it
    heads: dict[str, dict[str, Any]]  #: cameras on heads
    strategy: str = "ASM"  #: one of STRATEGIES, or central
    rounds: int = 0  #: of consensus a step
    loss: float = 0.0  #: share of messages that links lose
    seed: int = 1
    fps: float = 4.0  #: pictures a second of each camera

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def period_s(self) -> float:
        return 1 / self.fps

    def frame_ns(self, number: int) -> int:
        """World time of the picture of that number."""
        return due_ns(rate_of(self.fps), number)

    def names(self) -> list[str]:
        """Of all programs."""
        return sorted([*self.cameras, *self.heads, *([CENTRE] if self.strategy == "central" else [])])


def make_node(plan: Plan, name: str) -> Node:
    if name in plan.heads:
        camera = plan.heads[name]
        focal_heights = camera["intrinsics"]["fy"] / camera["size"][1]
        # A report is of the picture before; the head is there a period later.
        return HeadNode(name, camera["pose"]["position"], camera["pose"]["pan_deg"], camera["pose"]["tilt_deg"], focal_heights, plan.period_s)
    if plan.strategy == "central":
        return CentralNode() if name == CENTRE else Reporter(name)
    graph = communication_graph(plan) if plan.rounds else {}
    rate = 1 / (1 + max(map(len, graph.values()), default=0))
    return CameraNode(name, sorted(plan.cameras), sorted(plan.heads), STRATEGIES[plan.strategy], plan.seed, graph.get(name, []), rate)


def communication_graph(plan: Plan) -> dict[str, list[str]]:
    """Each camera and its NEIGHBOURS nearest, both ways; parts that hang together by no link are joined by their nearest pair."""
    names = sorted(plan.cameras)
    place = {name: np.array(plan.cameras[name]["pose"]["position"]) for name in names}
    def away(a: str, b: str) -> float:
        return float(np.linalg.norm(place[a] - place[b]))
    links = {frozenset((name, peer)) for name in names for peer in sorted((one for one in names if one != name), key=lambda one: away(name, one))[:NEIGHBOURS]}
    while True:
        reached = {names[0]} if names else set()
        while grown := {one for link in links if link & reached for one in link} - reached:
            reached |= grown
        if len(reached) == len(names):
            return {name: sorted(next(iter(link - {name})) for link in links if name in link) for name in names}
        links.add(frozenset(min(((a, b) for a in reached for b in names if b not in reached), key=lambda pair: away(*pair))))
