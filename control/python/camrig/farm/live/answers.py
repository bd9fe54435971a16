"""A rig's answers to entries of the log. Few are ever asked for, by the sequencer's clients, so they are kept as the lines that came."""

from __future__ import annotations

import asyncio
import collections
import json
from typing import Any

#: Entries whose answers are kept: a client whose sequencer died asks the next one again.
_MOST = 4096


class Answers:
    def __init__(self) -> None:
        self._lines: collections.deque[tuple[list[int], bytes]] = collections.deque()
        self._count = self._newest = 0
        self._awaited: dict[int, asyncio.Future[dict[str, Any]]] = {}

    def add(self, numbers: list[int], line: bytes) -> None:
        """Of these entries, in this order."""
        self._lines.append((numbers, line))
        self._count += len(numbers)
        self._newest = max(self._newest, *numbers)
        while self._count > _MOST:
            self._count -= len(self._lines.popleft()[0])
        if self._awaited.keys().isdisjoint(numbers):
            return
        for number, reply in zip(numbers, replies_in(line)):
            if answer := self._awaited.pop(number, None):
                answer.set_result(reply)

    async def of(self, number: int) -> dict[str, Any]:
        """When the rig has done that entry."""
        for numbers, line in reversed(self._lines) if number <= self._newest else ():
            if number in numbers:
                return replies_in(line)[numbers.index(number)]
        answer = self._awaited.setdefault(number, asyncio.get_running_loop().create_future())
        return await asyncio.shield(answer)


def replies_in(line: bytes) -> list[dict[str, Any]]:
    value = json.loads(line)
    return value if isinstance(value, list) else [value]
