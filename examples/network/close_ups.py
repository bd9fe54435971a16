"""Active cameras: who of the heads looks at whom, by contract nets between owners of objects (managers) and heads (contractors).

Smith: The contract net protocol, IEEE Trans. Computers 29(12), 1980; for cameras on heads: Starzyk, Qureshi: Software laboratory for camera networks research, IEEE JETCAS 3(2), 2013.
Announcement, bid, award; then the owner reports where its object is, which is all that a head knows of people it does not see yet.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .messages import Message
from .ownership import Ownership
from .sighting import Sighting

DWELL_S = 6.0  # a head looks at one person for so long, then at another
SILENCE_S = 1.5  # without a report it is free again
REACH_M = 20.0  # what is farther away it does not bid for
AGAIN = 0.1  # what a second close-up within AGAIN_S is worth
AGAIN_S = 20.0
HEIGHT_M, SHARE = 1.75, 0.6  # of a person, and of the picture's height that they are to fill


class Desk:
    """An owner's side."""

    def __init__(self, market: Ownership, heads: list[str]) -> None:
        self._market, self._heads = market, heads
        self._offers: dict[str, dict[str, float]] = {}

    def begin(self, now_ns: int) -> list[Message]:
        out, self._offers = [], {}
        for name in sorted(self._market.owned):
            track = self._market.tracks.of(name)
            if track is None or track.sighting is None:
                continue
            if name in self._market.heads:
                out.append(self._say(self._market.heads[name], "report", now_ns, object=name, **track.speaks()))
            elif self._heads:
                self._offers[name] = {}
                out += [self._say(head, "announce", now_ns, object=name, **track.speaks()) for head in self._heads]
        return out

    def receive(self, message: Message) -> None:
        name = message.body["object"]
        if message.kind == "offer" and name in self._offers:
            self._offers[name][message.sender] = message.body["value"]
        elif message.kind == "released" and self._market.heads.get(name) == message.sender:
            del self._market.heads[name]

    def settle(self, now_ns: int) -> list[Message]:
        """A head gets one award: that of the object it offered most for."""
        offers = sorted(((-value, name, head) for name, of in self._offers.items() for head, value in of.items()))
        out, given = [], set()
        for _, name, head in offers:
            if head not in given and name in self._market.owned and name not in self._market.heads:
                given.add(head)
                self._market.heads[name] = head
                out.append(self._say(head, "award", now_ns, object=name, **self._market.tracks.of(name).speaks()))
        return out

    def _say(self, to: str, kind: str, now_ns: int, **body: Any) -> Message:
        return Message(self._market.name, to, kind, now_ns, body)


class HeadNode:
    """A camera on a head. Follows one person at a time."""

    def __init__(self, name: str, position: list[float], pan_deg: float, tilt_deg: float, focal_heights: float, ahead_s: float) -> None:
        """Where it stands and looks at rest, as its calibration says; its focal length in heights of the picture; how far ahead of a report it aims."""
        self.name, self._eye = name, np.array(position)
        self._pan_deg, self._tilt_deg, self._focal, self._ahead_s = pan_deg, tilt_deg, focal_heights, ahead_s
        self._target: str | None = None
        self._owner, self._since_ns, self._told_ns, self._x = "", 0, 0, np.zeros(4)
        self._looked: dict[str, int] = {}
        self._now_ns = 0
        self.aim: tuple[float, float, float] | None = None  #: pan, tilt (deg, left and up, from rest) and zoom; None: back to rest

    def begin(self, now_ns: int, sightings: list[Sighting]) -> list[Message]:
        self._now_ns = now_ns
        self._looked = {name: at for name, at in self._looked.items() if now_ns - at < AGAIN_S * 1e9}
        if self._target is None:
            return []
        silent = now_ns - self._told_ns > SILENCE_S * 1e9
        if not silent and now_ns - self._since_ns < DWELL_S * 1e9:
            return []
        released, self._looked[self._target], self._target, self.aim = self._target, now_ns, None, None
        return [Message(self.name, self._owner, "released", now_ns, {"object": released})]

    def receive(self, inbox: list[Message]) -> list[Message]:
        out = []
        for message in inbox:
            name, x = message.body["object"], message.body["x"]
            if message.kind == "announce" and self._target is None and (value := self._value(name, x)) > 0:
                out.append(Message(self.name, message.sender, "offer", self._now_ns, {"object": name, "value": round(value, 3)}))
            elif message.kind == "award" and self._target is None:
                self._target, self._since_ns = name, self._now_ns
                self._hear(message.sender, message.time_ns, x)
            elif message.kind == "report" and self._target == name:
                self._hear(message.sender, message.time_ns, x)
            elif message.kind in ("award", "report"):  # it looks at somebody else
                out.append(Message(self.name, message.sender, "released", self._now_ns, {"object": name}))
        return out

    def settle(self) -> list[Message]:
        return []

    def share(self) -> list[Message]:
        return []

    def finish(self) -> dict[str, Any]:
        return {"target": self._target, "aim": None if self.aim is None else [round(v, 2) for v in self.aim]}

    def _hear(self, owner: str, time_ns: int, x: list[float]) -> None:
        self._owner, self._told_ns, self._x = owner, time_ns, np.array(x)
        ahead_s = (self._now_ns - time_ns) / 1e9 + self._ahead_s
        dx, dy = self._x[:2] + self._x[2:] * ahead_s - self._eye[:2]
        away = math.hypot(dx, dy)
        pan = (math.degrees(math.atan2(dy, dx)) - self._pan_deg + 180) % 360 - 180
        tilt = math.degrees(math.atan2(HEIGHT_M / 2 - self._eye[2], away)) - self._tilt_deg
        self.aim = (pan, tilt, max(1.0, SHARE * math.hypot(away, self._eye[2]) / HEIGHT_M / self._focal))

    def _value(self, name: str, x: list[float]) -> float:
        away = float(np.linalg.norm(np.array(x[:2]) - self._eye[:2]))
        return max(0.0, 1 - away / REACH_M) * (AGAIN if name in self._looked else 1.0)
