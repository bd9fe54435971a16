"""The farm's bus as it stands on several machines: one NATS server, or three that keep the log together; each can be killed and started again."""

from __future__ import annotations

import asyncio
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable, Sequence

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from ports import free_port  # noqa: E402

from camrig.farm.live.log import CommandLog, Subjects, connect
from camrig.farm.live.up import find_nats_server


def wait_until(condition: Callable[[], Any], what: str, timeout_s: float = 120.0) -> Any:
    deadline = time.monotonic() + timeout_s
    while not (value := condition()):
        if time.monotonic() > deadline:
            raise TimeoutError(f"after {timeout_s:.0f} s: {what}")
        time.sleep(0.02)
    return value


def run(command: Sequence[str], log: Path, **more: Any) -> subprocess.Popen[bytes]:
    """Whatever ends us ends it, also before it has begun: nobody must be left waiting for a farm that is no more. (By setpriv(1), and not by a
    function that is called after the fork: an interrupt that comes in Python's own work there is lost.)"""
    if_we_live = ["setpriv", "--pdeathsig", "KILL", "sh", "-c", '[ "$PPID" = "$0" ] && exec "$@"', str(os.getpid())]
    with open(log, "ab") as to:
        return subprocess.Popen([*if_we_live, *command], stdout=to, stderr=to, **more)


class Bus:
    def __init__(self, folder: Path, count: int) -> None:
        self._folder = folder
        self.ports = [free_port() for _ in range(count)]
        self._routes = [free_port() for _ in range(count)]
        self._servers: list[subprocess.Popen[bytes] | None] = [None] * count
        for number in range(count):
            self.start(number)

    @property
    def urls(self) -> str:
        return ",".join(f"nats://127.0.0.1:{port}" for port in self.ports)

    def start(self, number: int) -> None:
        command = [find_nats_server(), "-js", "-sd", str(self._folder / f"jetstream{number}"), "-a", "127.0.0.1", "-p", str(self.ports[number])]
        if len(self.ports) > 1:
            routes = ",".join(f"nats://127.0.0.1:{port}" for port in self._routes)
            command += ["--server_name", str(number), "--cluster_name", "farm", "--cluster", f"nats://127.0.0.1:{self._routes[number]}", "--routes", routes]
        self._servers[number] = run(command, self._folder / f"nats{number}.log")
        wait_until(lambda: self._answers(number), f"NATS server {number}")

    def kill(self, number: int) -> None:
        if server := self._servers[number]:
            server.kill()
            server.wait()

    def end(self) -> None:
        for number in range(len(self._servers)):
            self.kill(number)

    def _answers(self, number: int) -> bool:
        try:
            socket.create_connection(("127.0.0.1", self.ports[number]), 1).close()
            return True
        except OSError:
            return False

    def leader(self) -> int:
        """Of the servers that keep the log."""
        return asyncio.run(self._leader())

    async def _leader(self) -> int:
        client = await connect(self.urls)
        try:
            return int((await client.jetstream().stream_info(Subjects("farm").stream)).cluster.leader)
        finally:
            await client.close()

    def last(self) -> int:
        """Number of the log's last entry."""
        return asyncio.run(self._read(lambda log: log.last()))

    def entries(self) -> list[dict[str, Any]]:
        async def all_of(log: CommandLog) -> list[dict[str, Any]]:
            return [await log.read(number) for number in range(1, await log.last() + 1)]

        return asyncio.run(self._read(all_of))

    async def _read(self, what: Callable[[CommandLog], Any]) -> Any:
        client = await connect(self.urls)
        try:
            return await what(CommandLog(client, Subjects("farm")))
        finally:
            await client.close()
