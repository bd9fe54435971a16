"""The ordered log of commands, in a stream of NATS JetStream, and the lease of who may write it.

An entry is one JSON object: ``{"kind": "begin" | "command" | "step" | "owners", "at_ns", "term", "id", "method", "params"}``. Its number in the
stream is its place in the order. Only who holds the lease writes, and only behind the entry that he knows as the last (Nats-Expected-Last-Sequence):
whoever was overtaken is refused by the stream itself.
"""

from __future__ import annotations

import asyncio
import collections
import contextlib
import json
import sys
import time
import urllib.parse
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, TypeVar

import nats
import nats.errors
import nats.js.errors
from nats.aio.client import Client as Bus
from nats.js.api import StorageType, StreamConfig

from ...errors import CamrigError

#: How long a lease is valid that is not renewed, and how often it is.
LEASE_S, RENEW_S = 2.0, 0.5
#: NATS takes no longer messages by itself.
MAX_ENTRY_BYTES = 1_000_000
_MAX_TOLD = 1024
#: So long nothing is said of a bus that is not there.
_PATIENCE_S = 5.0
#: What a cluster of NATS servers says that do not know each other yet.
_NO_PEERS = 10005
_T = TypeVar("_T")


class Overtaken(Exception):
    """Somebody else has written behind the entry that was known as the last."""


@dataclass(frozen=True)
class Subjects:
    """The names of a farm on the bus."""

    farm: str

    @property
    def stream(self) -> str:
        return f"camrig_{self.farm}"

    def __getattr__(self, name: str) -> str:
        if name in ("log", "mark", "report", "command", "stop", "clock"):
            return f"camrig.{self.farm}.{name}"
        raise AttributeError(name)


async def connect(urls: str) -> Bus:
    """Waits until one of the servers is there: URLs with commas between them."""

    async def quiet(_: Exception) -> None: ...

    servers = [url.strip() for url in urls.split(",")]
    for url in servers:
        parts = urllib.parse.urlsplit(url)
        try:
            is_good = parts.scheme in ("nats", "tls") and parts.hostname and (parts.port or 4222)
        except ValueError:
            is_good = False
        if not is_good:
            raise CamrigError("invalid_argument", f"--nats: '{url}' is not nats://HOST:PORT")
    joining = asyncio.ensure_future(nats.connect(servers, max_reconnect_attempts=-1, reconnect_time_wait=0.2, error_cb=quiet, allow_reconnect=True))
    if not (await asyncio.wait([joining], timeout=_PATIENCE_S))[0]:
        print(f"camrig farm: no NATS server answers yet at {urls}", file=sys.stderr, flush=True)
    return await joining


async def _patiently(ask: Callable[[], Awaitable[_T]]) -> _T:
    """Again, while JetStream has no leader: its servers have just started, or one has died."""
    while True:
        try:
            return await ask()
        except (asyncio.TimeoutError, nats.errors.NoRespondersError, nats.js.errors.NoStreamResponseError, nats.js.errors.ServiceUnavailableError):
            pass
        except nats.js.errors.BadRequestError as problem:
            if problem.err_code != _NO_PEERS:
                raise
        await asyncio.sleep(0.1)


class CommandLog:
    """Reads by number, writes behind the last."""

    def __init__(self, bus: Bus, subjects: Subjects, replicas: int = 1) -> None:
        self._bus, self._subjects, self._replicas = bus, subjects, replicas
        self._stream = bus.jetstream(timeout=2.0)
        self._told: collections.OrderedDict[int, dict[str, Any]] = collections.OrderedDict()

    async def open(self) -> None:
        config = StreamConfig(
            name=self._subjects.stream, subjects=[self._subjects.log], storage=StorageType.FILE, num_replicas=self._replicas, duplicate_window=120.0, deny_delete=True
        )
        with contextlib.suppress(nats.js.errors.BadRequestError):  # that it is there
            await _patiently(lambda: self._stream.add_stream(config))

    async def last(self) -> int:
        return (await self._stream.stream_info(self._subjects.stream)).state.last_seq

    async def read(self, number: int) -> dict[str, Any]:
        """By its number: an ordered consumer stands still for 20 s when the stream's leader dies."""
        if number in self._told:
            return self._told.pop(number)
        message = await _patiently(lambda: self._stream.get_msg(self._subjects.stream, number))
        return json.loads(message.data)

    def tell(self, number: int, entry: dict[str, Any]) -> None:
        """It is known to be there; read() need not ask for it."""
        self._told[number] = entry
        while len(self._told) > _MAX_TOLD:
            self._told.popitem(last=False)

    async def append(self, entry: dict[str, Any], behind: int) -> int:
        """Its number. Overtaken, or what nats raises: then nobody knows whether it is there; the same call again makes it sure."""
        text = json.dumps(entry, separators=(",", ":"), sort_keys=True, allow_nan=False).encode()
        headers = {"Nats-Msg-Id": entry["id"], "Nats-Expected-Last-Sequence": str(behind)}
        try:
            return (await self._stream.publish(self._subjects.log, text, headers=headers)).seq
        except nats.js.errors.APIError as problem:
            if "wrong last sequence" in str(problem.description):
                raise Overtaken from problem
            raise


class Lease:
    """Who may write, for a term. Time is counted on each machine alone: a lease that was not renewed for LEASE_S may be taken."""

    def __init__(self, bus: Bus, subjects: Subjects, owner: str, replicas: int = 1) -> None:
        self._bus, self._bucket, self.owner, self._replicas = bus, f"{subjects.stream}_lease", owner, replicas
        self.term = 0
        self._revision = 0
        self._renewed = -1e9
        self._seen: tuple[int, float] = (0, time.monotonic())

    async def open(self) -> None:
        stream = self._bus.jetstream(timeout=1.0)
        try:
            self._store = await _patiently(lambda: stream.create_key_value(bucket=self._bucket, history=1, replicas=self._replicas))
        except nats.js.errors.BadRequestError:
            self._store = await _patiently(lambda: stream.key_value(self._bucket))

    def is_held(self) -> bool:
        """With a margin: who was stopped in between must not think so."""
        return self.term > 0 and time.monotonic() - self._renewed < LEASE_S * 0.75

    async def keep(self) -> bool:
        """Renews it, or takes one that is over. To be called every RENEW_S."""
        now = time.monotonic()
        try:
            if self.is_held():
                self._revision = await self._store.update("sequencer", self._text(self.term, self.owner), last=self._revision)
            else:
                self.term = 0
                if not await self._take(now):
                    return False
            self._renewed = now
        except (nats.errors.Error, nats.js.errors.APIError, asyncio.TimeoutError):
            pass  # told by is_held()
        return self.is_held()

    async def _take(self, now: float) -> bool:
        try:
            entry = await self._store.get("sequencer")
        except nats.js.errors.KeyNotFoundError:
            self._revision = await self._store.create("sequencer", self._text(1, self.owner))
            self.term = 1
            return True
        held = json.loads(entry.value)
        if entry.revision != self._seen[0]:
            self._seen = (entry.revision, now)
        if held["owner"] is not None and now - self._seen[1] < LEASE_S:
            return False
        term = held["term"] + 1
        self._revision = await self._store.update("sequencer", self._text(term, self.owner), last=entry.revision)
        self.term = term
        return True

    async def give_back(self) -> None:
        """Another may take it at once."""
        if self.is_held():
            term, self.term = self.term, 0
            with contextlib.suppress(nats.errors.Error, nats.js.errors.APIError, asyncio.TimeoutError):
                await self._store.update("sequencer", self._text(term, None), last=self._revision)

    @staticmethod
    def _text(term: int, owner: str | None) -> bytes:
        return json.dumps({"owner": owner, "term": term, "at": time.time()}).encode()
