"""The nodes of a farm, by what they report of themselves."""

from __future__ import annotations

import time
from typing import Any, Mapping

from .log import LEASE_S

#: So often a node reports.
REPORT_S = 0.5
#: A report that was so much longer on its way than the quickest waited in a link that was down, and says nothing of now.
_LATE_S = LEASE_S / 4
#: One that stays late for so long does not come out of such a link: its clock has stood still meanwhile.
_STEADY_S = 2 * LEASE_S
#: Two clocks go apart by at most so much.
_DRIFT = 1e-3
_MAX_LIVES = 4096


class _Way:
    """How long the reports of one clock are on their way, plus what this clock is behind ours."""

    def __init__(self, first: float, now: float) -> None:
        self._least, self._heard = first, now
        self._late_since, self._least_late = now, first

    def is_late(self, on_its_way: float, now: float) -> bool:
        self._least = min(on_its_way, self._least + _DRIFT * (now - self._heard))
        self._heard = now
        if on_its_way <= self._least + _LATE_S:
            self._late_since, self._least_late = now, float("inf")
            return False
        if on_its_way < self._least_late - _LATE_S:  # the link empties
            self._late_since, self._least_late = now, on_its_way
        if now - self._late_since < _STEADY_S:
            return True
        self._least = on_its_way
        return False


class Roster:
    def __init__(self) -> None:
        self._nodes: dict[str, dict[str, Any]] = {}
        self._ways: dict[tuple[str, str], _Way] = {}

    def hear(self, report: Mapping[str, Any]) -> bool:
        """False: it is too old. ``at`` is of the node's own monotonic clock, ``life`` names the run of its that has this clock."""
        now = time.monotonic()
        name, life = report["node"], report["life"]
        on_its_way = now - report["at"]
        if self._ways.setdefault((name, life), _Way(on_its_way, now)).is_late(on_its_way, now):
            return False
        while len(self._ways) > _MAX_LIVES:
            self._ways.pop(next(iter(self._ways)))
        known = self._nodes.get(name, {})
        if known.get("life") != life:
            known = {}
        self._nodes[name] = {**known, **report, "heard": now}
        return True

    def live(self) -> list[str]:
        return sorted(name for name, report in self._nodes.items() if time.monotonic() - report["heard"] < LEASE_S)

    def forget(self, name: str) -> None:
        """Known to be dead."""
        self._nodes.pop(name, None)

    def __getitem__(self, name: str) -> dict[str, Any]:
        return self._nodes[name]
