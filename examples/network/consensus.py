"""The information-weighted consensus filter (ICF).

Kamal, Farrell, Roy-Chowdhury: Information weighted consensus filters and their application in distributed camera networks, IEEE TAC 58(12), 2013. Every node adds to a
share 1/N of what it knew what its own camera measured; nodes then average with their neighbours, and N times the average is what a central Kalman filter would know.
Nodes that see nothing take part as the others do, which is what the filter is for. WiSE-Mnet++ has it as its ICF.
"""

from __future__ import annotations

from typing import Iterable

import numpy as np

from .kalman import H, motion


class Icf:
    """One node's filter of one object."""

    def __init__(self, nodes: int, x: np.ndarray, J: np.ndarray) -> None:
        """nodes: how many are in the network. x: state (4). J: its information (inverse covariance); zeros for a node that knows nothing yet."""
        self._nodes = nodes
        self.x, self.J = np.array(x, float), np.array(J, float)
        self.v, self.V = np.zeros(4), np.zeros((4, 4))

    def predict(self, dt_s: float) -> None:
        if not self.J.any():
            return
        f, q = motion(dt_s)
        self.x = f @ self.x
        self.J = np.linalg.inv(f @ np.linalg.pinv(self.J) @ f.T + q)

    def measure(self, measurements: Iterable[tuple[np.ndarray, np.ndarray]]) -> None:
        """Begins a step with this camera's own measurements: positions (2) with their covariances (2 x 2); none for one that does not see it."""
        self.v, self.V = self.J @ self.x / self._nodes, self.J / self._nodes
        for position, covariance in measurements:
            weight = H.T @ np.linalg.inv(covariance)
            self.v, self.V = self.v + weight @ position, self.V + weight @ H

    def mix(self, neighbours: Iterable[tuple[np.ndarray, np.ndarray]], rate: float) -> None:
        """One round: towards what the neighbours hold, each (v, V) as it was before the round. rate: below 1 over the largest degree of the graph."""
        dv, dV = np.zeros(4), np.zeros((4, 4))
        for v, V in neighbours:
            dv, dV = dv + (v - self.v), dV + (V - self.V)
        self.v, self.V = self.v + rate * dv, self.V + rate * dV

    def estimate(self) -> None:
        """Ends a step: the state and its information follow from v and V."""
        self.J = self._nodes * self.V
        if self.J.any():
            self.x = np.linalg.pinv(self.V) @ self.v
