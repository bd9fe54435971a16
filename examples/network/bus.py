"""The bus: NATS. Subjects `net.TO.KIND` are the network's own; `beat.*` is the lockstep between its nodes and the conductor, which a real network does not have and no count includes."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import nats

from .messages import Message

START_S = 10.0
BEAT_S = 60.0  # so long a phase may take; a node that says nothing for so long is left behind


def server_program() -> str:
    """nats-server, from the PATH or where Debian has it. Raises SystemExit that says what to install."""
    found = shutil.which("nats-server") or shutil.which("nats-server", path="/usr/sbin:/usr/local/sbin")
    if found is None:
        raise SystemExit("nats-server is not there: apt install nats-server (tools/setup does), or put it on the PATH")
    return found


class Server:
    """nats-server on a free port of the loopback address."""

    def __init__(self, folder: Path) -> None:
        # NATS takes a free port for -1, and tells it in a file.
        self._child = subprocess.Popen([server_program(), "-a", "127.0.0.1", "-p", "-1", "--ports_file_dir", str(folder), "-l", str(folder / "nats.log")], stdin=subprocess.DEVNULL)
        deadline = time.monotonic() + START_S
        file = folder / f"nats-server_{self._child.pid}.ports"
        while not file.exists() or not file.read_text():
            if self._child.poll() is not None or time.monotonic() > deadline:
                self.stop()
                raise SystemExit(f"nats-server did not start; {folder}/nats.log may say why")
            time.sleep(0.02)
        self.url = json.loads(file.read_text())["nats"][0]

    def stop(self) -> None:
        if self._child.poll() is None:
            self._child.send_signal(signal.SIGTERM)
            self._child.wait(START_S)


class Bus:
    """One node's connection. Messages that arrive wait here until they are taken."""

    LIMIT = 10_000  # waiting messages; more are dropped, the oldest first, as a node that hangs must not grow

    def __init__(self, connection: Any) -> None:
        self._connection = connection
        self._waiting: list[tuple[str, bytes]] = []
        self._came = asyncio.Event()
        self._beats: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    @classmethod
    async def connect(cls, url: str, name: str, hears: tuple[str, ...]) -> Bus:
        bus = cls(await nats.connect(url, name=name, allow_reconnect=False, connect_timeout=START_S))
        await bus._connection.subscribe(f"net.{name}.*", cb=bus._on_message)
        for subject in hears:
            await bus._connection.subscribe(subject, cb=bus._on_beat)
        await bus._connection.flush()  # answered: what is sent from now on arrives
        return bus

    async def _on_message(self, message: Any) -> None:
        self._waiting.append((message.subject, message.data))
        del self._waiting[: -self.LIMIT]
        self._came.set()

    async def _on_beat(self, message: Any) -> None:
        self._beats.put_nowait(json.loads(message.data))

    async def send(self, messages: list[Message]) -> None:
        for message in messages:
            await self._connection.publish(message.subject(), message.encode())
        await self._connection.flush()

    async def tell(self, subject: str, **what: Any) -> None:
        await self._connection.publish(subject, json.dumps(what).encode())
        await self._connection.flush()

    async def beat(self, timeout_s: float = BEAT_S) -> dict[str, Any]:
        """The next word of the lockstep. Raises TimeoutError."""
        return await asyncio.wait_for(self._beats.get(), timeout_s)

    async def take(self, count: int | None = None) -> list[Message]:
        """What has arrived, by sender and in the order in which each sent. count: exactly so many, the first ones (waits for them, at most BEAT_S): what others send in a
        phase that they have begun already stays for the next."""
        deadline = time.monotonic() + BEAT_S
        while len(self._waiting) < (count or 0) and time.monotonic() < deadline:
            self._came.clear()
            try:
                await asyncio.wait_for(self._came.wait(), 1.0)
            except TimeoutError:
                pass
        taken, self._waiting = self._waiting[:count], self._waiting[len(self._waiting) if count is None else count:]
        of: dict[str, list[Message]] = defaultdict(list)
        for subject, data in taken:
            message = Message.decode(subject, data)
            of[message.sender].append(message)
        return [message for sender in sorted(of) for message in of[sender]]

    async def close(self) -> None:
        await self._connection.close()


def environment() -> dict[str, str]:
    """Of the network's programs: this checkout's examples can be imported."""
    root = str(Path(__file__).resolve().parents[2])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))}
