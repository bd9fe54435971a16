"""A camera's node: its tracks, its part in the market, what it asks of heads, and its share of the distributed filter."""

from __future__ import annotations

from typing import Any

import numpy as np

from .close_ups import Desk
from .consensus import Icf
from .messages import Message
from .ownership import Ownership
from .sighting import Sighting
from .strategies import Strategy

FILTER_FORGETS_S = 3.0  # without a measurement by anybody


class CameraNode:
    def __init__(self, name: str, cameras: list[str], heads: list[str], strategy: Strategy, seed: int, neighbours: list[str] = (), rate: float = 0.0) -> None:
        """cameras: all of the network. neighbours, rate: of the consensus, which runs where there are neighbours."""
        self.name = name
        self.market = Ownership(name, [peer for peer in cameras if peer != name], strategy, seed)
        self._desk = Desk(self.market, heads)
        self._nodes, self._neighbours, self._rate = len(cameras), list(neighbours), rate
        self._filters: dict[str, Icf] = {}
        self._seen_ns: dict[str, int] = {}
        self._now_ns: int | None = None

    def begin(self, now_ns: int, sightings: list[Sighting]) -> list[Message]:
        dt_s = 0.0 if self._now_ns is None else (now_ns - self._now_ns) / 1e9
        self._now_ns = now_ns
        tracks = self.market.tracks
        tracks.advance(now_ns)
        tracks.see(sightings)
        tracks.settle(self.market.owned)
        out = self.market.begin(now_ns) + self._desk.begin(now_ns)
        if self._neighbours:
            self._measure(dt_s)
        return out

    def receive(self, inbox: list[Message]) -> list[Message]:
        out = []
        for message in inbox:
            if message.kind in ("offer", "released"):
                self._desk.receive(message)
            elif message.kind != "mix":
                out += self.market.receive(message)
        self._mix([message for message in inbox if message.kind == "mix"])
        return out

    def settle(self) -> list[Message]:
        return self.market.settle() + self._desk.settle(self._now_ns or 0)

    def share(self) -> list[Message]:
        objects = {name: {"s": self._seen_ns[name], "v": [*np.round(one.v, 5).tolist(), *np.round(one.V[np.triu_indices(4)], 5).tolist()]} for name, one in self._filters.items()}
        return [Message(self.name, peer, "mix", self._now_ns or 0, {"objects": objects}) for peer in self._neighbours] if objects else []

    def finish(self) -> dict[str, Any]:
        for one in self._filters.values():
            one.estimate()
        self._filters = {name: one for name, one in self._filters.items() if (self._now_ns or 0) - self._seen_ns[name] < FILTER_FORGETS_S * 1e9}
        owned = []
        for name in sorted(self.market.owned):
            track = self.market.tracks.of(name)
            if track is not None:
                one = self._filters.get(name)
                place = one.x if one is not None and one.J.any() else track.kalman.x
                owned.append({"object": name, "owner": self.name, "floor": [round(float(v), 3) for v in place[:2]], "value": round(track.value, 3)})
        return {"owned": owned, "graph": {peer: round(tau, 3) for peer, tau in self.market.graph.links().items()}}

    def _measure(self, dt_s: float) -> None:
        for one in self._filters.values():
            one.predict(dt_s)
        known = set()  # this step's sighting is in it already
        for track in self.market.tracks.all:
            name = track.object
            if name in self.market.owned and name not in self._filters:  # what the owner knows is what all know, N times its share
                self._filters[name] = Icf(self._nodes, track.kalman.x, np.linalg.inv(track.kalman.P) * self._nodes)
                self._seen_ns[name] = track.seen_ns
                known.add(name)
        for name, one in self._filters.items():
            track = self.market.tracks.of(name)
            seen = [track.sighting] if track is not None and track.sighting is not None and name not in known else []
            one.measure((sighting.position, sighting.covariance) for sighting in seen)
            if seen:
                self._seen_ns[name] = self._now_ns or 0

    def _mix(self, inbox: list[Message]) -> None:
        heard: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
        for message in inbox:
            for name, told in message.body["objects"].items():
                V = np.zeros((4, 4))
                V[np.triu_indices(4)] = told["v"][4:]
                heard.setdefault(name, []).append((np.array(told["v"][:4]), V + np.triu(V, 1).T))
                self._seen_ns[name] = max(told["s"], self._seen_ns.get(name, 0))
        for name, shares in heard.items():
            if name in self._filters:
                self._filters[name].mix(shares, self._rate)
            else:  # The sender has had no share of ours in this round, so we take none of its: together all hold what they held.
                self._filters[name] = Icf(self._nodes, np.zeros(4), np.zeros((4, 4)))
