"""A node of a farm: a rig that does what the log says, and perhaps the sequencer of all.

    camrig farm node --name A --nats nats://HOST:4222 --farm lobby --scene hall

The rig is ours: it is killed when this process ends, whatever ends it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
import time
import uuid
from typing import Any

import nats.errors

from ...errors import CamrigError
from .clock import Comparison, Offset
from .costs import COST_S, Costs
from .daemon import Daemon, NodeOptions
from .feed import Feed, Moment, moment_of
from .log import LEASE_S, RENEW_S, CommandLog, Lease, Subjects, connect
from .roster import REPORT_S
from .sequencer import MARK_S, Sequencer
from .wire import Wire

CLOCK_S = 1.0
#: Marks come so often while somebody has the lease and the bus is there.
_QUIET_S = 4 * MARK_S
#: So many questions to the bus, one after the other, that find no answer: then this node's cameras are others'.
_MOST_UNANSWERED, _ANSWER_S = 3, LEASE_S / 4
#: Who leaves goes on so long, for those who read from it to be told of another.
_FAREWELL_S = 1.0
#: A node that joins can have cameras when it has come so near, and then until it is so far behind.
_CAUGHT_UP_NS, _FAR_BEHIND_NS = 500_000_000, int(LEASE_S * 1e9)
_ENDED, _CUT_OFF = 3, 4


class Node:
    def __init__(self, options: NodeOptions) -> None:
        self.options = options
        self.subjects = Subjects(options.farm)
        self._mark: dict[str, Any] = {"term": 0, "last": 0, "closed_ns": -1}
        self._life = uuid.uuid4().hex
        self._heard = float("-inf")
        self._marked = asyncio.Event()
        self._parts: dict[Moment, dict[str, str]] = {}
        self._newest: dict[str, Any] = {}
        self._stop: asyncio.Future[tuple[int, str]] = asyncio.get_running_loop().create_future()
        self._comparison = Comparison()
        self._clock_is_off = False
        self._unanswered = 0
        self._costs: dict[str, float] = {}
        self.leaves = self._was_there = False
        self.daemon: Daemon | None = None
        self._tasks: list[asyncio.Task[None]] = []

    async def run(self) -> int:
        """Until it is told to stop: _ENDED, also when that was for being different. _CUT_OFF: another may take its place at once."""
        working = asyncio.ensure_future(self._work())
        try:
            await asyncio.wait([working, self._stop], return_when=asyncio.FIRST_COMPLETED)
            if working.done():
                working.result()
            code, why = self._stop.result() if self._stop.done() else (_ENDED, "its rig has ended")
            print(f"camrig farm: node {self.options.name} stops: {why}", file=sys.stderr, flush=True)
            return code
        finally:
            working.cancel()  # it may wait for a bus that never comes
            if self.daemon:
                await self.daemon.kill()
            for task in self._tasks + (self.sequencer.tasks if hasattr(self, "sequencer") else []):
                task.cancel()
            if hasattr(self, "bus"):
                # Not wait_for(): what nats-py does in close() while it makes a connection anew does not end when it is cancelled.
                await asyncio.wait([asyncio.ensure_future(self.bus.close())], timeout=_ANSWER_S)

    async def _work(self) -> None:
        """Until one part of it ends, or fails."""
        self.bus = await connect(self.options.nats)  # a rig without a log would show the world's beginning
        self.daemon = Daemon(self.options)
        await self.daemon.start()
        self.wire = await Wire.open({"control": self.daemon.control})
        self.identity = await self.wire.call("rig.identity")
        self._rtsp_scheme = (await self.wire.call("server.info")).get("rtsp_scheme", "rtsp")
        self.log = CommandLog(self.bus, self.subjects, self.options.replicas)
        await self.log.open()
        self.feed = Feed(self.log, self.wire, self.identity, self.options.clock)
        self.lease = Lease(self.bus, self.subjects, self.options.name, self.options.replicas)
        await self.lease.open()
        self.sequencer = Sequencer(self.bus, self.subjects, self.log, self.lease, self.feed, self.identity, self.options.lead_ms, self.options.clock)
        await self.bus.subscribe(self.subjects.mark, cb=self._on_mark)
        await self.bus.subscribe(self.subjects.stop, cb=self._on_stop)
        parts = (self._follow(), self._report(), self._digests(), self._keep(), self._watch(), self._watch_wire(), self._watch_bus(), self._compare_clock(), self._tell_costs())
        self._tasks = [asyncio.create_task(each) for each in parts]
        for ended in (await asyncio.wait(self._tasks, return_when=asyncio.FIRST_COMPLETED))[0]:
            ended.result()

    def leave(self) -> None:
        """Its cameras are told to be others' before they end here."""
        if not self.leaves:
            self.leaves = True
            self._farewell = asyncio.get_running_loop().create_task(self._say_farewell())

    async def _say_farewell(self) -> None:
        try:
            if hasattr(self, "sequencer") and self._unanswered == 0:
                await self._say({})
                await self.lease.give_back()
                await asyncio.sleep(_FAREWELL_S)
        finally:
            self._end(_ENDED, "it was told to")

    def _end(self, code: int, why: str) -> None:
        if not self._stop.done():
            self._stop.set_result((code, why))

    async def _on_mark(self, message: Any) -> None:
        mark = json.loads(message.data)
        if mark["term"] < self._mark["term"]:
            return  # of a sequencer that was overtaken
        for number, entry in mark.pop("entries"):
            self.log.tell(number, entry)
        self._mark, self._heard = mark, time.monotonic()
        self._marked.set()

    async def _on_stop(self, message: Any) -> None:
        told = json.loads(message.data)
        if told["life"] != self._life:
            return
        own = self._parts.get(tuple(told["moment"]), {})
        differs = sorted(name for name in own.keys() | told["parts"].keys() if own.get(name) != told["parts"].get(name))
        self._end(_ENDED, f"{told['why']}; what differs: {', '.join(differs[:20]) or 'unknown'}")

    async def _follow(self) -> None:
        while True:
            await self._marked.wait()
            self._marked.clear()
            mark = self._mark
            await self.feed.take(mark["last"], mark["closed_ns"])

    async def _digests(self) -> None:
        while True:
            digest = await self.feed.digests.get()
            self._parts[moment_of(digest)] = digest["parts"]
            for old in list(self._parts)[:-20]:
                del self._parts[old]
            self._newest = {key: digest.get(key) for key in ("world_ns", "hash", "step")}
            await self._say({"digest": self._newest, "parts": digest["parts"]})

    async def _report(self) -> None:
        while True:
            await self._say({})
            await asyncio.sleep(REPORT_S)

    async def _say(self, more: dict[str, Any]) -> None:
        if self.feed.begin is None or self._unanswered > 0:
            return  # nobody counts on a node that has not passed the gate; what is said into a dead link comes when it is no longer true
        ready = self.daemon.ready
        report = {"node": self.options.name, "life": self._life, "at": time.monotonic(), "pid": os.getpid(), "rig_pid": self.daemon.process.pid,
                  **{key: ready.get(key) for key in ("control", "http", "rtsp", "tcp", "host")}, "rtsp_scheme": self._rtsp_scheme, "applied": self.feed.applied,
                  "is_sequencer": self.sequencer.is_active, "term": self.lease.term, "leaves": self.leaves, "is_behind": self._is_behind(), **more}
        if offset := self._offset():
            report |= {"clock_ahead_ms": round(offset.ahead_s * 1e3, 3), "clock_bound_ms": round(offset.bound_s * 1e3, 3), "clock_is_off": self._clock_is_off}
        report |= {"cores": self.options.cores, "costs": self._costs, "moved_by": self.feed.moved_by}
        if self.sequencer.is_active:
            report |= {"moved": self.feed.moved, "full": sorted(self.sequencer.full)}
        await self.bus.publish(self.subjects.report, json.dumps(report).encode())

    def _is_behind(self) -> bool:
        """Who joins shows what is past until it has caught up, and so does who is too slow."""
        behind_ns = self._mark["closed_ns"] - self.feed.world_ns
        if self._was_there:
            return self.identity["mode"] == "realtime" and behind_ns > _FAR_BEHIND_NS
        self._was_there = 0 < self._mark["last"] <= self.feed.fed and (self.identity["mode"] == "lockstep" or behind_ns < _CAUGHT_UP_NS + int(self.options.lead_ms * 1e6))
        return not self._was_there

    def _offset(self) -> Offset | None:
        return Offset(0.0, 0.0) if self.sequencer.is_active else self._comparison.best()

    async def _keep(self) -> None:
        while not self.leaves:
            if self.lease.is_held() or self._is_quiet() and self._may_lead():
                await self.lease.keep()
            await asyncio.sleep(RENEW_S if self.lease.is_held() else RENEW_S / 2)
        await asyncio.Event().wait()

    def _is_quiet(self) -> bool:
        """Whoever marks has the lease, so there is no need to ask for it."""
        return time.monotonic() - self._heard > _QUIET_S

    def _may_lead(self) -> bool:
        """Not with a clock that is not the others', and who has not caught up only if nobody else does."""
        return not self._clock_is_off and (not self._is_behind() or time.monotonic() - self._heard > 3 * LEASE_S)

    async def _watch(self) -> None:
        await self.daemon.process.wait()

    async def _watch_wire(self) -> None:
        """A rig that is told nothing stands, and its node would keep what it has: cameras, and the lease."""
        self._end(_ENDED, (await self.feed.until_cut_off()).message)

    async def _watch_bus(self) -> None:
        """Who hears nothing from the bus is not heard either: its cameras are others' from then on, and nobody may go on reading its
        standing pictures. A dead sequencer alone is no reason: then all worlds stand."""
        heard, own = asyncio.Event(), self.bus.new_inbox()

        async def hear(_: Any) -> None:
            heard.set()

        await self.bus.subscribe(own, cb=hear)
        while True:
            heard.clear()
            if is_quiet := self._is_quiet():
                # Not Client.flush() with a timeout: a late PONG for one that has timed out ends nats-py's reading (2.16, InvalidStateError).
                await self.bus.publish(own, b"")
            await asyncio.sleep(_ANSWER_S)
            self._unanswered = 0 if heard.is_set() or not is_quiet else self._unanswered + 1
            if self._unanswered == _MOST_UNANSWERED:
                self._end(_CUT_OFF, "it is cut off from the farm's bus; its rig ends, and it comes back when the bus does")

    async def _compare_clock(self) -> None:
        """With the sequencer's. Who is far off gets no camera: its pictures would come early or late."""
        while True:
            if not self.sequencer.is_active:
                sent_ns = self.options.clock.now_ns()
                with contextlib.suppress(nats.errors.Error, asyncio.TimeoutError):
                    message = await self.bus.request(self.subjects.clock, b"", timeout=CLOCK_S)
                    told = json.loads(message.data)
                    self._comparison.add(told["of"], sent_ns, told["now_ns"], self.options.clock.now_ns())
            offset = self._offset()
            is_off = offset is not None and self.identity["mode"] == "realtime" and offset.is_beyond(self.options.max_skew_ms / 1e3)
            if is_off and not self._clock_is_off:
                why = f"its clock is {offset}; --max-skew-ms is {self.options.max_skew_ms:g}"
                print(f"camrig farm: node {self.options.name} has no cameras: {why}", file=sys.stderr, flush=True)
            self._clock_is_off = is_off
            await asyncio.sleep(CLOCK_S)

    async def _tell_costs(self) -> None:
        costs = Costs(self.daemon.process.pid)
        while True:
            if not self._is_behind():  # what it takes to come to the world's time is no camera's
                with contextlib.suppress(CamrigError):  # a rig that has many clients may take no more, or close this wire for another
                    wire = await Wire.open({"control": self.daemon.control})  # one on which nothing waits for a world time
                    try:
                        self._costs = costs.of((await wire.call("stats.get"))["cameras"], (await wire.call("camera.list"))["cameras"])
                    finally:
                        wire.close()
            await asyncio.sleep(COST_S)


async def run_node(options: NodeOptions) -> int:
    loop = asyncio.get_running_loop()
    while True:
        node = Node(options)
        for end in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(end, node.leave)
        code = await node.run()
        if node.leaves:  # perhaps while it was cut off
            return _ENDED
        if code != _CUT_OFF:
            return code
