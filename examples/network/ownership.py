"""Who owns what: one camera's part in the market of objects.

An owner says when it loses an object (strategies.py), asks others, and sells to who sees it best (auction.py). What this adds to CamSim's market is what pictures demand: objects have
to be found and recognised, and links lose messages. Whoever sees somebody nobody has told it of claims them; owners answer, and who once lost such a person gives their name back.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .auction import vickrey
from .kalman import Kalman
from .messages import Message
from .sighting import alike, pack, unpack
from .strategies import Strategy
from .tracks import CONFIRMED, Track, Tracks
from .vision_graph import VisionGraph

GATE = 9.2  # squared Mahalanobis distance within which two nodes speak of one person: 99 %
NEAR_M = 2.0  # and no farther than that
SAME_LOOKS = 0.75  # likeness of colours of one person seen from two sides, at the same place ...
KNOWN_LOOKS = 0.88  # ... and anywhere that can be walked to
WALK_M_S = 2.0
PATIENCE_S = 3.0  # an owner goes on searching for so long
REMEMBER_S = 30.0  # and knows the person again for so long
RECHECK_S = 5.0  # an object of another owner of which nothing was heard is claimed again


@dataclass
class Auction:
    asked: list[str]
    reserve: float
    bids: dict[str, float] = field(default_factory=dict)


class Ownership:
    def __init__(self, name: str, peers: list[str], strategy: Strategy, seed: int) -> None:
        self.name, self._peers, self._strategy, self._seed = name, peers, strategy, seed
        self.tracks, self.graph = Tracks(), VisionGraph()
        self.owned: set[str] = set()
        self.heads: dict[str, str] = {}  #: the head that looks at an object, which goes with it
        self._sold: dict[str, str] = {}  #: objects whose buyer has not said that it has them
        self._lost: dict[str, Track] = {}
        self._auctions: dict[str, Auction] = {}
        self._claims: dict[int, Track] = {}
        self._now_ns = 0

    def begin(self, now_ns: int) -> list[Message]:
        """After the tracks have seen the picture of `now_ns`."""
        self._now_ns = now_ns
        self.owned |= set(self._sold)  # the award or its answer was lost
        self._sold.clear()
        self.graph.evaporate()
        self._forget()
        self._claims = {track.number: track for track in self.tracks.all if self._is_news(track)}
        out = [self._say(peer, "claim", token=number, value=round(track.value, 3), **self._looks(track)) for number, track in self._claims.items() for peer in self._peers]
        self._auctions = {}
        for name in sorted(self.owned):
            track = self.tracks.of(name)
            if track is not None and self._strategy.offers(track.value, track.before):
                asked = self._strategy.asks(self._peers, self.graph, self._seed, self.name, name, now_ns)
                self._auctions[name] = Auction(asked, track.value)
                out += [self._say(peer, "search", object=name, **self._looks(track)) for peer in asked]
        return out

    def receive(self, message: Message) -> list[Message]:
        return getattr(self, f"_on_{message.kind}")(message.sender, message.time_ns, **message.body)

    def settle(self) -> list[Message]:
        out = []
        for name, auction in self._auctions.items():
            winner = vickrey(self.name, auction.reserve, auction.bids).winner
            if winner == self.name or name not in self.owned:
                continue
            self.owned.discard(name)
            self._sold[name] = winner
            extra = {"head": self.heads.pop(name)} if name in self.heads else {}
            out.append(self._say(winner, "start", object=name, **extra, **self._looks(self.tracks.of(name))))
            out += [self._say(peer, "stop", object=name) for peer in auction.asked if peer != winner]
        for number, track in self._claims.items():  # nobody knows them
            self._own(track, f"{self._now_ns // 10**6:07d}-{self.name}-{number}")
        self._auctions, self._claims = {}, {}
        return out

    # What others say

    def _on_search(self, sender: str, time_ns: int, object: str, **looks: object) -> list[Message]:
        track = self._match(time_ns, **looks)
        if track is None:
            return []
        if track.object in self.owned and track.object != object:
            if track.object < object:  # one person with two names keeps the older
                return [self._say(sender, "owned", object=track.object, was=object)]
            self._drop(track.object)
        track.object, track.told_ns = object, self._now_ns
        return [self._say(sender, "found", object=object, value=round(track.value, 3))] if track.value > 0 else []

    def _on_found(self, sender: str, time_ns: int, object: str, value: float) -> list[Message]:
        if object in self._auctions:  # else it comes late
            self._auctions[object].bids[sender] = value
        return []

    def _on_start(self, sender: str, time_ns: int, object: str, x: list[float], p: float, colours: str, token: int | None = None, head: str | None = None) -> list[Message]:
        if token is not None:
            track = self._claims.pop(token, None)
            if track is None:
                return []
        else:
            track = self.tracks.of(object) or self._match(time_ns, x, p, colours) or self.tracks.adopt(_kalman(x, p), unpack(colours))
        if track.object in self.owned and track.object != object:
            object, _ = min(track.object, object), self._drop(track.object)
        self._own(track, object)
        if head is not None:
            self.heads[object] = head
        return [self._say(sender, "taken", object=object)]

    def _on_taken(self, sender: str, time_ns: int, object: str) -> list[Message]:
        if self._sold.get(object) == sender:
            del self._sold[object]
            self.graph.reinforce(sender)
        self._lost.pop(object, None)
        return []

    def _on_stop(self, sender: str, time_ns: int, object: str) -> list[Message]:
        track = self.tracks.of(object)
        if track is not None and object not in self.owned:
            track.told_ns = self._now_ns
        return []

    def _on_claim(self, sender: str, time_ns: int, token: int, value: float, **looks: object) -> list[Message]:
        track = self._match(time_ns, **looks)
        if track is not None and track.object in self.owned:
            return [self._say(sender, "owned", object=track.object, token=token)]
        if track is not None and track.number in self._claims and (value, sender) > (round(track.value, 3), self.name):
            del self._claims[track.number]  # two claim one person: who sees better does
        if name := self._remembered(time_ns, **looks):
            return [self._say(sender, "start", object=name, token=token, **{"x": looks["x"], "p": looks["p"], "colours": looks["colours"]})]
        return []

    def _on_owned(self, sender: str, time_ns: int, object: str, token: int | None = None, was: str | None = None) -> list[Message]:
        track = self._claims.pop(token, None) if token is not None else self.tracks.of(was) if was is not None else None
        if was is not None:
            self._drop(was)
        if track is not None:
            track.object, track.told_ns = object, self._now_ns
        return []

    # What this camera knows

    def _is_news(self, track: Track) -> bool:
        if track.hits < CONFIRMED or track.sighting is None or track.object in self.owned:
            return False
        return track.object is None or self._now_ns - track.told_ns > RECHECK_S * 1e9

    def _match(self, time_ns: int, x: list[float], p: float, colours: str) -> Track | None:
        """The track of who is described, where they should be by now."""
        place = np.array(x[:2]) + np.array(x[2:]) * (self._now_ns - time_ns) / 1e9
        looks, best, nearest = unpack(colours), None, GATE
        for track in self.tracks.all:
            distance2 = track.kalman.distance2(place, np.eye(2) * p)
            if track.hits >= CONFIRMED and distance2 < nearest and np.linalg.norm(track.kalman.x[:2] - place) < NEAR_M and alike(track.colours, looks) > SAME_LOOKS:
                best, nearest = track, distance2
        return best

    def _remembered(self, time_ns: int, x: list[float], p: float, colours: str) -> str | None:
        """The name of somebody lost who looks like that and can have walked there."""
        best, most = None, KNOWN_LOOKS
        for name, track in self._lost.items():
            reach_m = 1.0 + WALK_M_S * (time_ns - track.seen_ns) / 1e9
            likeness = alike(track.colours, unpack(colours))
            if likeness > most and np.linalg.norm(track.sighting_place - np.array(x[:2])) < reach_m:
                best, most = name, likeness
        return best

    def _forget(self) -> None:
        for name in sorted(self.owned):
            track = self.tracks.of(name)
            if track is None or self._now_ns - track.seen_ns > PATIENCE_S * 1e9:
                self._drop(name)
                if track is not None:
                    self._lost[name] = track
        self._lost = {name: track for name, track in self._lost.items() if self._now_ns - track.seen_ns < REMEMBER_S * 1e9}

    def _own(self, track: Track, name: str) -> None:
        for other in self.tracks.all:  # a name is that of one track
            if other is not track and other.object == name:
                other.object = None
        track.object, track.told_ns = name, self._now_ns
        self.owned.add(name)
        self._lost.pop(name, None)

    def _drop(self, name: str) -> None:
        self.owned.discard(name)
        self._sold.pop(name, None)
        self.heads.pop(name, None)

    def _looks(self, track: Track) -> dict[str, object]:
        return {**track.speaks(), "colours": pack(track.colours)}

    def _say(self, to: str, kind: str, **body: object) -> Message:
        return Message(self.name, to, kind, self._now_ns, body)


def _kalman(x: list[float], p: float) -> Kalman:
    kalman = Kalman(np.array(x[:2]), np.eye(2) * p)
    kalman.x[2:] = x[2:]
    return kalman
