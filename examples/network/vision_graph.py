"""The vision graph: to whom a camera's objects go, learnt from hand-overs alone as ants find paths.

Esterle, Lewis, Yao, Rinner: Socio-economic vision graph generation and handover in distributed smart camera networks, ACM TOSN 10(2), 2014.
"""

from __future__ import annotations

EVAPORATION = 0.995  # of a link's pheromone, each step
DEPOSIT = 1.0  # at each hand-over


class VisionGraph:
    """The links of one camera to others."""

    def __init__(self) -> None:
        self._pheromone: dict[str, float] = {}

    def evaporate(self) -> None:
        """Once a step: what is not used is forgotten, so that the graph follows cameras that fail or are moved."""
        for peer in self._pheromone:
            self._pheromone[peer] *= EVAPORATION

    def reinforce(self, peer: str) -> None:
        """An object has gone to `peer`."""
        self._pheromone[peer] = self._pheromone.get(peer, 0.0) + DEPOSIT

    def pheromone(self, peer: str) -> float:
        return self._pheromone.get(peer, 0.0)

    def strongest(self) -> float:
        return max(self._pheromone.values(), default=0.0)

    def links(self) -> dict[str, float]:
        return dict(sorted(self._pheromone.items()))
