"""The control protocol by asyncio: one connection to a rig, on which many requests may be under way."""

from __future__ import annotations

import asyncio
import collections
import itertools
import json
from typing import Any, Mapping

from ...errors import CamrigError, error_of_reply

_MAX_LINE = 96 << 20
_encoded = json.JSONEncoder(separators=(",", ":")).encode
CONNECT_S = 2.0


def line_of(message: Any) -> bytes:
    """As one line of the control protocol."""
    return _encoded(message).encode() + b"\n"


def url_of(report: Mapping[str, Any], target: str, scheme: str = "http") -> str:
    """Of a node's own port; RTSP as its rig has it, with a certificate or without."""
    host = f"[{report['host']}]" if ":" in report["host"] else report["host"]
    return f"{report['rtsp_scheme'] if scheme == 'rtsp' else scheme}://{host}:{report[scheme]}{target}"


async def connect_to(report: Mapping[str, Any], token: str | None, limit: int = _MAX_LINE) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """To the rig of a node, by what it reports: over TCP where it has a port and we the token, else by its socket on this machine.
    CamrigError of kind unauthorized: it lives, and the token is wrong, or is missing for a rig that has no socket here."""
    if not report.get("tcp") or not token:
        try:
            return await asyncio.open_unix_connection(report["control"], limit=limit)
        except OSError:
            if not report.get("tcp"):
                raise
    reader, writer = await asyncio.wait_for(asyncio.open_connection(report["host"], report["tcp"], limit=limit), CONNECT_S)
    if not token:
        writer.close()
        raise CamrigError("unauthorized", f"node {report['node']}: its rig on {report['host']} asks for the farm's token; give --token-file")
    writer.write(json.dumps({"jsonrpc": "2.0", "id": 0, "method": "auth", "params": {"token": token}}).encode() + b"\n")
    reply = json.loads(await asyncio.wait_for(reader.readline(), CONNECT_S))
    if "error" in reply:
        writer.close()
        raise error_of_reply("auth", reply["error"])
    return reader, writer


class Wire:
    """Requests go out at once, in this order; answers come in the same. The rig takes up to 64 lines unanswered."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer
        self._ids = itertools.count(1)
        self._waiting: collections.deque[asyncio.Future[bytes]] = collections.deque()
        self._task = asyncio.create_task(self._read())

    @classmethod
    async def open(cls, report: Mapping[str, Any], token: str | None = None) -> Wire:
        try:
            return cls(*await connect_to(report, token))
        except (OSError, ValueError, asyncio.TimeoutError) as problem:
            raise CamrigError("unavailable", f"no rig at {report['control']} ({problem})") from problem

    def send(self, message: Any) -> asyncio.Future[bytes]:
        """The answer to a request or a batch, as the line that it is."""
        answer: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        if self._task.done():
            answer.set_exception(CamrigError("unavailable", "the rig closed the connection"))
            return answer
        self._waiting.append(answer)
        self._write(message)
        return answer

    def tell(self, notification: dict[str, Any]) -> None:
        """Nothing answers it."""
        if not self._task.done():
            self._write(notification)

    def _write(self, message: Any) -> None:
        self._writer.write(line_of(message))

    @property
    def unanswered(self) -> int:
        return len(self._waiting)

    def request(self, method: str, params: dict[str, Any]) -> dict[str, Any]:
        return {"jsonrpc": "2.0", "id": next(self._ids), "method": method, "params": params}

    async def call(self, method: str, **params: Any) -> Any:
        reply = json.loads(await self.send(self.request(method, params)))
        if "error" in reply:
            raise error_of_reply(method, reply["error"])
        return reply["result"]

    async def _read(self) -> None:
        try:
            while line := await self._reader.readline():
                answer = self._waiting.popleft()
                if not answer.done():
                    answer.set_result(line)
        except (OSError, ValueError, IndexError):  # the last: it says why it closes, and was asked nothing
            pass
        for answer in self._waiting:
            if not answer.done():
                answer.set_exception(CamrigError("unavailable", "the rig closed the connection"))

    async def ended(self) -> None:
        """Returns when no answer comes any more."""
        await asyncio.wait([self._task])

    def close(self) -> None:
        self._writer.close()
        self._task.cancel()
