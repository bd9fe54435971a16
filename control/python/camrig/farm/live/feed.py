"""Hands a rig what the log says, in the log's order, and never lets its world run past what is known to be complete."""

from __future__ import annotations

import asyncio
import json
import time
from typing import Any

from ...errors import CamrigError, error_of_reply
from .answers import Answers, replies_in
from .clock import WallClock
from .log import CommandLog
from .wire import Wire, line_of

#: Entries of one line, and bytes where they are more than one; the rig takes 64, and 1 MiB.
_CHUNK, _LINE_BYTES = 60, 900_000
DIGEST_EVERY_NS = 1_000_000_000
_MOST_UNANSWERED = 48  # lines
_FAR_NS = 30 * DIGEST_EVERY_NS
_DIGEST = 0  # no entry has this number
#: So often a rig is asked how far its world is; else it is only told how far it may run.
_ASK_S = 0.25
#: Of a digest: the world's time, and in lockstep the entry whose step ended there: commands may stand between two of one time.
Moment = tuple[int, int | None]


class Feed:
    """The log's entries up to ``applied``, on one rig. ``answers`` has the rig's, by number.

    ``fed``: the newest entry that the rig was told; ``world_ns``: its world's time, as it was last heard. ``moved``: the cameras
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
        self.answers = Answers()
        self.fed = 0
        self._numbers: list[int] = []  # of the line that goes out next
        self._requests: list[dict[str, Any]] = []
        self._bytes = 0
        self._refusal: CamrigError | None = None
        self._digest_ns = 0
        self._limit_ns = 0
        self._asked = float("-inf")
        self.digests: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

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
        for number, entry in entries:
            at_ns = entry["at_ns"]
            if at_ns > self._limit_ns + _FAR_NS:  # who joins late: the world comes after what it is told
                await self._run_to(at_ns - 1)
            self._ask_digests(at_ns)
            if entry["kind"] == "command":
                self._ask(number, entry["method"], {**entry["params"], "at_ns": at_ns})
            else:  # answered when all before it are
                self._ask(number, "world.status", {})
            self.last_at_ns = at_ns
        if len(entries) == _CHUNK:  # more are to come, of this time too perhaps
            await self._run_to(self.last_at_ns - 1)
            while self._wire.unanswered >= _MOST_UNANSWERED:
                await asyncio.sleep(0.002)

    def _ask(self, number: int, method: str, params: dict[str, Any]) -> None:
        """With the next line."""
        request = self._wire.request(method, params)
        size = len(line_of(request))
        if len(self._requests) == _CHUNK or self._bytes + size > _LINE_BYTES:
            self._flush()
        self._numbers.append(number)
        self._requests.append(request)
        self._bytes += size

    def _flush(self, *last: dict[str, Any]) -> asyncio.Future[bytes] | None:
        """One line with all that waits, and these notifications; its answer comes when all of it is done."""
        if not self._numbers:
            for notification in last:
                self._wire.tell(notification)
            return None
        numbers, requests = self._numbers, self._requests
        self._numbers, self._requests, self._bytes = [], [], 0
        answer = self._wire.send([*requests, *last])
        answer.add_done_callback(lambda done: self._note(numbers, done))
        return answer

    def _ask_digests(self, until_ns: int) -> None:
        """Before anything of a later time: one a second of world time, at the same times on every node."""
        while (at_ns := self._digest_ns + DIGEST_EVERY_NS) <= until_ns:
            self._digest_ns = at_ns
            self._ask(_DIGEST, "world.digest", {"at_ns": at_ns, "parts": True})

    def _note(self, numbers: list[int], done: asyncio.Future[bytes]) -> None:
        if done.cancelled() or done.exception():
            return
        line = done.result()
        if not line.startswith(b"["):  # one error for all of it
            self._refusal = error_of_reply("the log's commands", json.loads(line).get("error"))
            return self._wire.close()
        self.applied = max(self.applied, *numbers)
        self.answers.add(numbers, line)
        if _DIGEST in numbers:
            for number, reply in zip(numbers, replies_in(line)):
                if number == _DIGEST and "result" in reply:
                    self.digests.put_nowait(reply["result"])

    async def until_cut_off(self) -> CamrigError:
        """Why the rig is told no more. What it has not done since, the other nodes' rigs may have."""
        await self._wire.ended()
        return self._refusal or CamrigError("unavailable", "the rig closed the connection")

    def _note_world(self, done: asyncio.Future[bytes]) -> None:
        if not done.cancelled() and not done.exception() and "result" in (reply := json.loads(done.result())):
            self.world_ns = reply["result"]["world_ns"]

    async def _run_to(self, until_ns: int) -> None:
        """Raises the limit; by steps, each of which is waited for, where it is far. A rig that is slow is told later."""
        while until_ns > self._limit_ns and self._wire.unanswered < _MOST_UNANSWERED:
            is_far = until_ns > self._limit_ns + _FAR_NS
            self._limit_ns = min(until_ns, self._limit_ns + _FAR_NS)
            self._ask_digests(self._limit_ns)
            assert self.begin
            params = {"until_ns": self._limit_ns, "clock_ns": max(0, self._clock.now_ns() - self.begin["epoch_utc_ns"])}
            if (now := time.monotonic()) - self._asked >= _ASK_S:
                self._asked = now
                there = self._flush()
                self._wire.send(self._wire.request("world.limit", params)).add_done_callback(self._note_world)
            else:
                there = self._flush({"jsonrpc": "2.0", "method": "world.limit", "params": params})
            if is_far and there:
                await there
        self._flush()

    async def _step(self, entries: list[tuple[int, dict[str, Any]]]) -> None:
        for number, entry in entries:
            if entry["kind"] == "owners":
                self.applied = number
                continue
            if entry["kind"] == "step":
                answer, digest = await self._step_to(entry["to_ns"], timeout_s=entry["timeout_s"])
                self.digests.put_nowait({**digest, "step": number})
            else:
                while (before_ns := self.world_ns) < entry["at_ns"]:  # a reader held a step up for too long
                    await self._step_to(entry["at_ns"])
                    if self.world_ns == before_ns:
                        await asyncio.sleep(_ASK_S)
                answer = await self._wire.send(self._wire.request(entry["method"], {**entry["params"], "at_ns": entry["at_ns"]}))
            self.last_at_ns = entry.get("to_ns", entry["at_ns"])
            self.applied = number
            self.answers.add([number], answer)

    async def _step_to(self, to_ns: int, **timeout: float) -> tuple[bytes, dict[str, Any]]:
        """One attempt, from wherever the last one ended; the rig's answer, and its state."""
        answer = await self._wire.send(self._wire.request("world.step", {"nanoseconds": to_ns - self.world_ns, **timeout}))
        digest = await self._wire.call("world.digest", parts=True)
        self.world_ns = digest["world_ns"]
        return answer, digest


def moment_of(digest: dict[str, Any]) -> Moment:
    return digest["world_ns"], digest.get("step")


def raise_if_different(begin: dict[str, Any], identity: dict[str, Any]) -> None:
    """The gate: a node whose build, scene, seed or mathematics are others would go another way."""
    for member, of_farm in begin["identity"].items():
        if identity.get(member) != of_farm:
            raise CamrigError("unsupported", f"this node cannot join: {member} is {identity.get(member)!r}, the farm's is {of_farm!r}")
