"""For comparison: one tracker that is told everything. Cameras send what they see, and it names people and says which camera has them."""

from __future__ import annotations

from typing import Any

import numpy as np

from .messages import Message
from .ownership import KNOWN_LOOKS, REMEMBER_S, WALK_M_S
from .sighting import Sighting, alike
from .tracks import CONFIRMED, Track, Tracks

CENTRE = "centre"


class Reporter:
    """A camera of a central network: sends what it sees."""

    def __init__(self, name: str) -> None:
        self.name = name

    def begin(self, now_ns: int, sightings: list[Sighting]) -> list[Message]:
        return [Message(self.name, CENTRE, "seen", now_ns, {"people": [one.to_json() for one in sightings]})] if sightings else []

    def receive(self, inbox: list[Message]) -> list[Message]:
        return []

    def settle(self) -> list[Message]:
        return []

    def share(self) -> list[Message]:
        return []

    def finish(self) -> dict[str, Any]:
        return {"owned": []}


class CentralNode:
    name = CENTRE

    def __init__(self) -> None:
        self._tracks = Tracks()
        self._now_ns, self._values = 0, {}
        self._owners: dict[int, str] = {}
        self._gone: dict[str, Track] = {}

    def begin(self, now_ns: int, sightings: list[Sighting]) -> list[Message]:
        self._now_ns, self._values = now_ns, {}
        self._tracks.advance(now_ns)
        return []

    def receive(self, inbox: list[Message]) -> list[Message]:
        """All cameras' sightings of a step, one camera after the other."""
        for message in inbox:
            if message.kind != "seen" or message.time_ns != self._now_ns:
                continue  # of a step that is over
            before = {track.number: track.sighting for track in self._tracks.all}
            self._tracks.see([Sighting.of(one) for one in message.body["people"]])
            for track in self._tracks.all:
                if track.sighting is not before.get(track.number):
                    self._values.setdefault(track.number, {})[message.sender] = track.sighting.value
        return []

    def settle(self) -> list[Message]:
        """An object belongs to the camera that sees it best; its cameras are told when that changes."""
        out = []
        known = {track.object: track for track in self._tracks.all if track.object}
        self._tracks.settle(set())
        kept = {track.object for track in self._tracks.all}
        self._gone.update({name: track for name, track in known.items() if name not in kept})
        self._gone = {name: track for name, track in self._gone.items() if self._now_ns - track.seen_ns < REMEMBER_S * 1e9}
        for track in self._tracks.all:
            if track.hits >= CONFIRMED and track.object is None:
                track.object = self._remembered(track) or f"{self._now_ns // 10**6:07d}-{CENTRE}-{track.number}"
                self._gone.pop(track.object, None)
            if track.object and (values := self._values.get(track.number)):
                best = max(values, key=lambda name: (values[name], name))
                if self._owners.get(track.number) != best:
                    out += [Message(CENTRE, camera, "assign", self._now_ns, {"object": track.object, "owner": best}) for camera in {best, self._owners.get(track.number, best)}]
                    self._owners[track.number] = best
        return sorted(out, key=lambda message: message.to)

    def share(self) -> list[Message]:
        return []

    def finish(self) -> dict[str, Any]:
        return {"owned": [{"object": track.object, "owner": self._owners[track.number], "floor": [round(float(v), 3) for v in track.kalman.x[:2]], "value": round(track.value, 3)}
                          for track in self._tracks.all if track.object and track.number in self._owners]}

    def _remembered(self, track: Track) -> str | None:
        best, most = None, KNOWN_LOOKS
        for name, old in self._gone.items():
            reach_m = 1.0 + WALK_M_S * (self._now_ns - old.seen_ns) / 1e9
            if (likeness := alike(old.colours, track.colours)) > most and np.linalg.norm(old.sighting_place - track.sighting_place) < reach_m:
                best, most = name, likeness
        return best
