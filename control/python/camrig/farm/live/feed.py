"""Hands a rig what the log says, in the log's order, and never lets its world run past what is known to be complete."""

from __future__ import annotations

import asyncio
from typing import Any

from ...errors import CamrigError
from .clock import WallClock
from .log import CommandLog
from .wire import Wire

_CHUNK = 60  # entries of one line; the rig takes 64
DIGEST_EVERY_NS = 1_000_000_000
_MOST_UNANSWERED = 48  # lines
_FAR_NS = 30 * DIGEST_EVERY_NS


class Feed:
    """The log's entries up to ``applied``, on one rig. ``results`` has the answers of the newest, by number.

    ``fed``: the newest entry that the rig was told; ``world_ns``: its world's time, as it was last heard (realtime). ``moved``: the cameras
    that entry ``moved_by`` took from the nodes to which they belong by their names, and where they are.
    """

    def __init__(self, log: CommandLog, wire: Wire, identity: dict[str, Any], clock: WallClock = WallClock()) -> None:
        self._log, self._wire, self._identity, self._clock = log, wire, identity, clock
        self._is_lockstep = identity["mode"] == "lockstep"
        self.begin: dict[str, Any] | None = None
        self.applied = 0
        self.last_at_ns = self.world_ns = 0
        self.moved: dict[str, str] = {}
        self.moved_by = 0
        self.results: dict[int, asyncio.Future[Any]] = {}
        self.fed = 0
        self._digest_ns = 0
        self._limit_ns = 0
        self.digests: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def result(self, number: int) -> asyncio.Future[Any]:
        """The rig's answer to that entry, when it has been done."""
        if number not in self.results:
            self.results[number] = asyncio.get_running_loop().create_future()
            for old in sorted(self.results)[:-4096]:
                del self.results[old]
        return self.results[number]

    async def take(self, last: int, closed_ns: int) -> None:
        """Everything up to entry ``last`` is known, and no later one is of a time up to ``closed_ns``: the world may run so far."""
        while self.fed < last:
            entries = [(number, await self._log.read(number)) for number in range(self.fed + 1, min(last, self.fed + _CHUNK) + 1)]
            if entries[0][1]["kind"] == "begin":
                begin = entries.pop(0)[1]
                raise_if_different(begin, self._identity)
                self.begin = begin
            self.fed += len(entries) + (self.fed == 0)
            for number, entry in entries:
                if entry["kind"] == "owners":  # says nothing to a world
                    self.moved, self.moved_by = entry["moved"], number
            if self._is_lockstep:
                await self._step(entries)
            else:
                await self._send(entries)
        if not self._is_lockstep and self.begin:
            await self._run_to(closed_ns)

    async def _send(self, entries: list[tuple[int, dict[str, Any]]]) -> None:
        batch: list = []
        for number, entry in entries:
            if entry["at_ns"] > self._limit_ns + _FAR_NS:  # who joins late: the world comes after what it is told
                self._flush(batch)
                await self._run_to(entry["at_ns"] - 1)
            self._ask_digests(batch, entry["at_ns"])
            if entry["kind"] == "command":
                batch.append((number, self._wire.request(entry["method"], {**entry["params"], "at_ns": entry["at_ns"]})))
            else:  # answered when all before it are
                batch.append((number, self._wire.request("world.status", {})))
            self.last_at_ns = entry["at_ns"]
        self._flush(batch)
        if len(entries) == _CHUNK:  # more are to come, of this time too perhaps
            await self._run_to(self.last_at_ns - 1)
            while self._wire.unanswered >= _MOST_UNANSWERED:
                await asyncio.sleep(0.002)

    def _flush(self, batch: list) -> asyncio.Future[Any]:
        """Sends it and empties it; the future is done when the last of it is."""
        answer = asyncio.get_running_loop().create_future()
        answer.set_result(None)
        for begin in range(0, len(batch), _CHUNK):
            part = batch[begin : begin + _CHUNK]
            answer = self._wire.send([request for _, request in part])
            answer.add_done_callback(lambda done, part=part: self._note(part, done))
        batch.clear()
        return answer

    def _ask_digests(self, batch: list, until_ns: int) -> None:
        """Before anything of a later time: one a second of world time, at the same times on every node."""
        while (at_ns := self._digest_ns + DIGEST_EVERY_NS) <= until_ns:
            self._digest_ns = at_ns
            batch.append((0, self._wire.request("world.digest", {"at_ns": at_ns, "parts": True})))

    def _note(self, part: list, done: asyncio.Future[Any]) -> None:
        if done.cancelled() or done.exception():
            return
        replies = {reply["id"]: reply for reply in done.result()}
        for number, request in part:
            reply = replies[request["id"]]
            if number == 0:
                if "result" in reply:
                    self.digests.put_nowait(reply["result"])
                continue
            self.applied = max(self.applied, number)
            answer = self.result(number)
            if not answer.done():
                answer.set_result(reply)

    def _note_world(self, done: asyncio.Future[Any]) -> None:
        if not done.cancelled() and not done.exception() and "result" in done.result():
            self.world_ns = done.result()["result"]["world_ns"]

    async def _run_to(self, until_ns: int) -> None:
        """Raises the limit; by steps, each of which is waited for, where it is far. A rig that is slow is told later."""
        while until_ns > self._limit_ns and self._wire.unanswered < _MOST_UNANSWERED:
            is_far = until_ns > self._limit_ns + _FAR_NS
            self._limit_ns = min(until_ns, self._limit_ns + _FAR_NS)
            batch: list = []
            self._ask_digests(batch, self._limit_ns)
            there = self._flush(batch)
            assert self.begin
            clock_ns = max(0, self._clock.now_ns() - self.begin["epoch_utc_ns"])
            told = self._wire.send(self._wire.request("world.limit", {"until_ns": self._limit_ns, "clock_ns": clock_ns}))
            told.add_done_callback(self._note_world)
            if is_far:
                await there

    async def _step(self, entries: list[tuple[int, dict[str, Any]]]) -> None:
        for number, entry in entries:
            if entry["kind"] == "owners":
                self.applied = number
                continue
            if entry["kind"] == "step":
                request = self._wire.request("world.step", {"nanoseconds": entry["to_ns"] - entry["at_ns"], "timeout_s": entry["timeout_s"]})
            else:
                request = self._wire.request(entry["method"], {**entry["params"], "at_ns": entry["at_ns"]})
            reply = await self._wire.send(request)
            self.last_at_ns = entry.get("to_ns", entry["at_ns"])
            if entry["kind"] == "step":
                self.digests.put_nowait({**await self._wire.call("world.digest", parts=True), "step": number})
            self.applied = number
            answer = self.result(number)
            if not answer.done():
                answer.set_result(reply)


def raise_if_different(begin: dict[str, Any], identity: dict[str, Any]) -> None:
    """The gate: a node whose build, scene, seed or mathematics are others would go another way."""
    for member, of_farm in begin["identity"].items():
        if identity.get(member) != of_farm:
            raise CamrigError("unsupported", f"this node cannot join: {member} is {identity.get(member)!r}, the farm's is {of_farm!r}")
