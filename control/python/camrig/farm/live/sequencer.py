"""Puts the commands of all clients into one order and says from when they hold, while it has the lease.

A command is applied at ``now + lead``, so that it is everywhere in time. A mark every 20 ms says up to which world time no more commands
will come; nodes run so far and no further. Lost marks, slow nodes and a dead sequencer can only hold a world, never fork it.
"""

from __future__ import annotations

import asyncio
import collections
import contextlib
import json
import math
import sys
import time
import uuid
from typing import Any, NamedTuple

import nats.errors
import nats.js.errors

from ...errors import CamrigError
from .clock import WallClock
from .feed import Feed, Moment, moment_of
from .log import MAX_ENTRY_BYTES, RENEW_S, CommandLog, Lease, Overtaken, Subjects
from .placement import full_of, is_placeable, moves
from .roster import REPORT_S, Roster

#: Marks come so often, or three in a lead that is shorter: the longer between them the less they cost, and the less time is left for one to be late.
MARK_S, _LEAST_MARK_S = 1 / 30, 0.005
_SHORT_LEAD_NS = 50_000_000
#: Marks carry entries that are no longer, so that nodes need not ask the log for them; and so many.
_TOLD_BYTES, _MAX_UNTOLD = 4096, 64
#: So often it is looked whether a node is full.
PLACE_S = 5.0
#: Steps wait so long for all nodes.
STEP_TIMEOUT_S = 60.0


class State(NamedTuple):
    """Of a node at one moment, told by its run of this name: who was stopped may come back."""

    life: str
    hash: str
    parts: dict[str, str]


class NotNow(Exception):
    """The command may be in the log or not. Asked again, with its id, it is in it once."""


class Sequencer:
    def __init__(self, bus: Any, subjects: Subjects, log: CommandLog, lease: Lease, feed: Feed, identity: dict[str, Any], lead_ms: float, clock: WallClock) -> None:
        self._bus, self._subjects, self._log, self._lease, self._feed = bus, subjects, log, lease, feed
        self._identity, self._lead_ns, self._clock = identity, int(lead_ms * 1e6), clock
        self._mark_s = min(MARK_S, max(_LEAST_MARK_S, lead_ms / 3e3))
        self._is_lockstep = identity["mode"] == "lockstep"
        self._order = asyncio.Lock()
        self._last = 0  # entry
        self._last_at_ns = 0
        self._untold: list[tuple[int, dict[str, Any]]] = []  # of this sequencer's, for the next mark
        self._closed_ns = -1
        self._epoch_utc_ns = 0
        self._nodes = Roster()
        self._hearing: list[Any] = []  # while it is active: others need not be told what they do not use
        self._hears_since = 0.0
        self._states: dict[Moment, dict[str, State]] = collections.OrderedDict()
        self._different: set[str] = set()  # by their lives
        self.is_active = False
        self.full: set[str] = set()  #: nodes that can give no camera away and should
        self.tasks = [asyncio.create_task(self._run()), asyncio.create_task(self._place())]

    async def _run(self) -> None:
        while True:
            now_ns = self._clock.now_ns() - self._epoch_utc_ns  # before the lease is looked at: who was stopped in between marks what is past
            if not self._lease.is_held():
                self.is_active = False
                await self._deafen()
            elif not self.is_active:
                try:
                    await self._take_over()
                except (nats.errors.Error, nats.js.errors.Error, asyncio.TimeoutError, Overtaken):
                    pass  # tried again while the lease is held
            else:
                await self._mark(now_ns)
            await asyncio.sleep(self._mark_s if self._lease.is_held() else RENEW_S / 5)

    async def _hear(self) -> None:
        if not self._hearing:
            self._hears_since = time.monotonic()
            for subject, do in ((self._subjects.report, self._on_report), (self._subjects.command, self._spawn), (self._subjects.clock, self._tell_time)):
                self._hearing.append(await self._bus.subscribe(subject, cb=do))

    async def _deafen(self) -> None:
        while self._hearing:
            with contextlib.suppress(nats.errors.Error):
                await self._hearing.pop().unsubscribe()

    def _knows_all(self) -> float:
        """From when on every node that lives has been heard."""
        return self._hears_since + 2 * REPORT_S

    async def _tell_time(self, message: Any) -> None:
        if self.is_active:
            await message.respond(json.dumps({"of": self._lease.owner, "now_ns": self._clock.now_ns()}).encode())

    async def _spawn(self, message: Any) -> None:
        task = asyncio.create_task(self._on_command(message))
        self.tasks.append(task)
        task.add_done_callback(self.tasks.remove)

    async def _take_over(self) -> None:
        """Reads the log to its end: what comes now comes behind it, and after every time that the one before can have closed."""
        await self._hear()
        self._last = await self._log.last()
        if self._last == 0:
            entry = {"kind": "begin", "id": uuid.uuid4().hex, "term": self._lease.term, "at_ns": 0, "epoch_utc_ns": self._clock.now_ns() + 200_000_000,
                     "identity": {key: self._identity[key] for key in ("build", "mathematics", "scene_hash", "seed", "step_ns", "mode", "quality")}}
            self._last = await self._log.append(entry, 0)
        self._epoch_utc_ns = (await self._log.read(1))["epoch_utc_ns"]
        newest = await self._log.read(self._last)
        self._last_at_ns = newest.get("to_ns", newest["at_ns"])
        self._closed_ns = self._last_at_ns - 1
        self.is_active = True

    def _time_for_command(self) -> int:
        if self._is_lockstep:
            return self._last_at_ns
        return max(self._last_at_ns, self._closed_ns + 1, self._clock.now_ns() - self._epoch_utc_ns + self._lead_ns)

    async def _mark(self, now_ns: int) -> None:
        # What is on its way into the log may have the time that is closed next.
        if not self._order.locked():
            self._closed_ns = max(self._closed_ns, now_ns + self._lead_ns - 1)
        mark = {"term": self._lease.term, "last": self._last, "closed_ns": self._closed_ns, "entries": self._untold}
        self._untold = []
        if self._lease.is_held():
            await self._bus.publish(self._subjects.mark, json.dumps(mark).encode())

    async def _on_command(self, message: Any) -> None:
        if not self.is_active or not self._lease.is_held():
            return  # somebody else answers, or nobody
        asked = json.loads(message.data)
        try:
            reply = await self._do(asked)
        except CamrigError as problem:
            reply = {"error": {"code": -32000, "message": problem.message, "data": {"kind": problem.kind}}}
        except NotNow:
            reply = {}
        await message.respond(json.dumps(reply).encode())

    async def _do(self, asked: dict[str, Any]) -> dict[str, Any]:
        async with self._order:
            entry = {"kind": "command", "id": asked["id"], "term": self._lease.term, "at_ns": self._time_for_command(), "method": asked["method"],
                     "params": asked["params"]}
            if asked["method"] == "world.step":
                entry = self._step(entry)
            length = len(json.dumps(entry))
            if length > MAX_ENTRY_BYTES:
                raise CamrigError("invalid_argument", f"{asked['method']}: a command of a farm has at most {MAX_ENTRY_BYTES} bytes")
            number = await self._append(entry)
            if number > self._last:  # else it was asked again, and is there already
                self._last = number
                self._last_at_ns = entry.get("to_ns", entry["at_ns"])
                if length < _TOLD_BYTES and len(self._untold) < _MAX_UNTOLD:
                    self._untold.append((number, entry))
            if self._is_lockstep or self._lead_ns < _SHORT_LEAD_NS:  # else the next mark is early enough
                await self._mark(self._clock.now_ns() - self._epoch_utc_ns)
            if entry["kind"] == "step":
                await self._wait_for_nodes(number)
        try:
            reply = await asyncio.wait_for(self._feed.answers.of(number), STEP_TIMEOUT_S)
        except asyncio.TimeoutError:
            raise CamrigError("unavailable", f"{asked['method']}: is number {number} of the log, and the world has not come to it") from None
        return {"at_ns": entry["at_ns"], **{key: reply[key] for key in ("result", "error") if key in reply}}

    def _step(self, entry: dict[str, Any]) -> dict[str, Any]:
        if not self._is_lockstep:
            raise CamrigError("unavailable", "the world runs in real time; start the farm with --mode lockstep")
        params = entry.pop("params")
        if ("seconds" in params) == ("nanoseconds" in params):
            raise CamrigError("invalid_argument", "world.step: give either seconds or nanoseconds")
        timeout_s = params.get("timeout_s", 10)
        for name, value in (("seconds", params.get("seconds", 0)), ("nanoseconds", params.get("nanoseconds", 0)), ("timeout_s", timeout_s)):
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
                raise CamrigError("invalid_argument", f"world.step: {name} is a number")
        if not 0 < timeout_s <= 3600:
            raise CamrigError("invalid_argument", "world.step: timeout_s is over 0 s and at most an hour")
        length_ns = params["nanoseconds"] if "nanoseconds" in params else round(params["seconds"] * 1e9)
        if not isinstance(length_ns, int) or not 0 <= length_ns <= 24 * 3600 * 10**9:
            raise CamrigError("invalid_argument", "world.step: from 0 s to a day")
        return {**entry, "kind": "step", "to_ns": entry["at_ns"] + length_ns, "timeout_s": timeout_s}

    async def _append(self, entry: dict[str, Any]) -> int:
        """Until it is known whether it is there: the worlds wait so long, for they must not run past its time."""
        while self._lease.is_held():
            try:
                return await self._log.append(entry, self._last)
            except Overtaken:
                self.is_active = False  # read the log again
                raise NotNow from None
            except (nats.errors.Error, nats.js.errors.Error, asyncio.TimeoutError):
                await asyncio.sleep(0.1)
        self.is_active = False
        raise NotNow

    def _live(self) -> list[str]:
        return [name for name in self._nodes.live() if self._nodes[name]["life"] not in self._different]

    async def _wait_for_nodes(self, number: int) -> None:
        """A step is done when it is done on every node that lives."""
        deadline = time.monotonic() + STEP_TIMEOUT_S
        await asyncio.sleep(max(0.0, self._knows_all() - time.monotonic()))
        while late := [name for name in self._live() if self._nodes[name]["applied"] < number]:
            if time.monotonic() > deadline:
                raise CamrigError("unavailable", f"the step waits for node {', '.join(late)}")
            await asyncio.sleep(0.002)

    async def _place(self) -> None:
        """Takes cameras from a node that is full. What everybody sees of it is an entry of the log."""
        while True:
            await asyncio.sleep(PLACE_S)
            if not self.is_active or self._feed.applied < self._last or time.monotonic() < self._knows_all():
                continue
            there = {name: self._nodes[name] for name in self._live() if is_placeable(self._nodes[name])}
            costs: dict[str, float] = {}
            for report in there.values():
                for camera, cost in report.get("costs", {}).items():
                    costs[camera] = costs.get(camera, 0.0) + cost
            cores = {name: report["cores"] for name, report in there.items()}
            moved = moves(costs, cores, self._feed.moved)
            self._tell_full(full_of(costs, cores, moved), cores)
            if moved == self._feed.moved:
                continue
            with contextlib.suppress(NotNow):
                async with self._order:
                    entry = {"kind": "owners", "id": uuid.uuid4().hex, "term": self._lease.term, "at_ns": self._time_for_command(), "moved": moved}
                    self._last = await self._append(entry)
                    self._last_at_ns = entry["at_ns"]

    def _tell_full(self, full: dict[str, float], cores: dict[str, float]) -> None:
        for name in full.keys() - self.full:
            print(f"camrig farm: node {name} is full: its cameras that are watched take {full[name]:.2f} of {cores[name]:g} cores, and no other node has room for one; "
                  "pictures will be left out (overload) until there are more nodes", file=sys.stderr, flush=True)
        self.full = set(full)

    async def _on_report(self, message: Any) -> None:
        report = json.loads(message.data)
        if not self._nodes.hear({key: value for key, value in report.items() if key != "parts"}):
            return
        if digest := report.get("digest"):
            moment = moment_of(digest)
            states = self._states.setdefault(moment, {})
            states[report["node"]] = State(report["life"], digest["hash"], report["parts"])
            while len(self._states) > 30:
                self._states.pop(next(iter(self._states)))
            if self.is_active and all(self._has_told(states, self._nodes[name]) for name in self._live()):
                await self._compare(moment, states)

    @staticmethod
    def _has_told(states: dict[str, State], node: dict[str, Any]) -> bool:
        """Or need not: who is behind is compared when he comes there."""
        return node["is_behind"] or node["node"] in states and states[node["node"]].life == node["life"]

    async def _compare(self, moment: Moment, states: dict[str, State]) -> None:
        """Who is not as most are is stopped; of two that are unlike, both are named, and the one that is not the sequencer's goes."""
        votes = collections.Counter(state.hash for state in states.values())
        if len(votes) < 2:
            return
        most = votes.most_common()
        good = most[0][0]
        if most[0][1] == most[1][1]:
            if self._lease.owner not in states:
                return
            good = states[self._lease.owner].hash
        parts = next(state.parts for state in states.values() if state.hash == good)
        for name, state in states.items():
            if state.hash == good or state.life in self._different:
                continue
            self._different.add(state.life)
            why = f"at world time {moment[0]} ns its state has hash {state.hash}, that of the others is {good}"
            print(f"camrig farm: node {name} is stopped: {why}", file=sys.stderr, flush=True)
            stop = {"node": name, "life": state.life, "moment": moment, "why": why, "parts": parts}
            await self._bus.publish(self._subjects.stop, json.dumps(stop).encode())
