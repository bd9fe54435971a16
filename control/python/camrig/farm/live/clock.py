"""A node's wall clock, and how far it is from the sequencer's: as in NTP (RFC 5905, section 8) the offset is that of the middle of a
round trip, and half the round trip bounds its error, however unlike the two ways are."""

from __future__ import annotations

import collections
import time
from dataclasses import dataclass

_SAMPLES = 16
#: What two clocks may run apart within the samples.
_DRIFT = 100e-6


@dataclass(frozen=True)
class WallClock:
    """``ahead_ns`` is for tests: no program can have a wall clock of its own under Linux."""

    ahead_ns: int = 0

    def now_ns(self) -> int:
        return time.time_ns() + self.ahead_ns


@dataclass(frozen=True)
class Offset:
    """How far a clock is ahead, and by how much that may be wrong."""

    ahead_s: float
    bound_s: float

    def is_beyond(self, most_s: float) -> bool:
        """For certain."""
        return abs(self.ahead_s) - self.bound_s > most_s

    def __str__(self) -> str:
        return f"{abs(self.ahead_s) * 1e3:.1f} ms {'ahead of' if self.ahead_s >= 0 else 'behind'} the sequencer's (within {self.bound_s * 1e3:.1f} ms)"


class Comparison:
    """The best of the newest round trips to one other clock."""

    def __init__(self) -> None:
        self._samples: collections.deque[tuple[float, float, float]] = collections.deque(maxlen=_SAMPLES)
        self._with: object = None

    def add(self, other: object, sent_ns: int, theirs_ns: int, came_ns: int) -> None:
        """``other``: whose clock it is; what was known of another's is forgotten."""
        if other != self._with:
            self._with = other
            self._samples.clear()
        self._samples.append((time.monotonic(), ((sent_ns + came_ns) / 2 - theirs_ns) / 1e9, (came_ns - sent_ns) / 2e9))

    def best(self) -> Offset | None:
        """None: nothing is known."""
        now = time.monotonic()
        grown = [Offset(ahead, bound + _DRIFT * (now - at)) for at, ahead, bound in self._samples]
        return min(grown, key=lambda one: one.bound_s, default=None)
