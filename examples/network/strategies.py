"""When a camera offers its objects to others, and to whom: the strategies of CamSim.

Esterle, Lewis, Yao, Rinner (ACM TOSN 10(2), 2014); Lewis, Esterle, Chandra, Rinner, Torresen, Yao (ACM TAAS 10(2), 2015). The six names are the first letter of when
(active, passive) and two of whom (broadcast, smooth, step): ABC ASM AST PBC PSM PST.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from .chance import chance
from .vision_graph import VisionGraph

STEP_LEAST = 0.1  # STEP asks everybody with this probability at least, so that new links are found
LOSING = 0.1  # a passive camera offers what it sees less well than this, and worse than before


@dataclass(frozen=True)
class Strategy:
    name: str
    is_active: bool
    audience: str  #: broadcast, smooth, step or nobody

    def offers(self, value: float, before: float) -> bool:
        """Whether to offer an object that is seen with `value`, and was with `before` a step ago. Active: always. Passive: when it is about to be lost, or is."""
        if self.audience == "nobody":
            return False
        return self.is_active or value <= 0.0 or (value < LOSING and value < before)

    def asks(self, peers: Sequence[str], graph: VisionGraph, *what: object) -> list[str]:
        """Whom of `peers` to ask. `what` is what the random numbers are drawn for: seed, names, object, time. Nobody drawn: everybody is asked."""
        if self.audience == "nobody":
            return []
        if self.audience == "broadcast":
            return list(peers)
        chosen = [peer for peer in peers if chance(*what, peer) < self.probability(graph, peer)]
        return chosen or list(peers)

    def probability(self, graph: VisionGraph, peer: str) -> float:
        """That `peer` is asked."""
        if self.audience == "smooth":
            return (1.0 + graph.pheromone(peer)) / (1.0 + graph.strongest())
        if self.audience == "step":
            return min(max(graph.pheromone(peer), STEP_LEAST), 1.0)
        return 1.0 if self.audience == "broadcast" else 0.0


STRATEGIES = {strategy.name: strategy for strategy in (
    Strategy("ABC", True, "broadcast"), Strategy("ASM", True, "smooth"), Strategy("AST", True, "step"),
    Strategy("PBC", False, "broadcast"), Strategy("PSM", False, "smooth"), Strategy("PST", False, "step"),
    Strategy("none", False, "nobody"),
)}  # fmt: skip
