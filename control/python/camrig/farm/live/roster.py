"""The nodes of a farm, by what they report of themselves."""

from __future__ import annotations

import time
from typing import Any, Mapping

from .log import LEASE_S

#: So often a node reports.
REPORT_S = 0.5
#: A report that was so much longer on its way than the quickest waited in a link that was down, and says nothing of now.
_LATE_S = LEASE_S / 4
_MAX_LIVES = 4096


class Roster:
    def __init__(self) -> None:
        self._nodes: dict[str, dict[str, Any]] = {}
        self._least: dict[tuple[str, str], float] = {}

    def hear(self, report: Mapping[str, Any]) -> bool:
        """False: it is too old. ``at`` is of the node's own monotonic clock, ``life`` names the run of its that has this clock."""
        now = time.monotonic()
        name, life = report["node"], report["life"]
        on_its_way = now - report["at"]
        least = self._least.setdefault((name, life), on_its_way)
        if on_its_way > least + _LATE_S:
            return False
        self._least[(name, life)] = min(least, on_its_way)
        while len(self._least) > _MAX_LIVES:
            self._least.pop(next(iter(self._least)))
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
