"""The door's control sockets: a Unix socket, and TCP for who shows the farm's token. One line is a request or a batch, and so is its answer."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import os
import socket
from typing import Any

from ...errors import CamrigError
from .budget import PIECE_BYTES, Budget, Claim, read_line
from .door import Client, Door
from .wire import CONNECT_S, line_of
from .wrong_tokens import WrongTokens

#: Connections: on the Unix socket, and as many over TCP; of these, that have shown no token yet.
_MAX_CLIENTS, _MAX_STRANGERS = 256, 8
_MAX_LINE, _MAX_FIRST_LINE = 4 << 20, 4096
#: A client that takes no byte of an answer for so long is closed.
_STALLED_S = 10.0
#: So long the rest of a line that is too long is read.
_LINGER_S = 1.0


def _error(kind: str, message: str, request_id: Any = None) -> bytes:
    return line_of({"jsonrpc": "2.0", "id": request_id, "error": {"code": -32000, "message": message, "data": {"kind": kind}}})


def _refuse_if_taken(path: str) -> None:
    """asyncio takes the place of any socket: one that is listened to is somebody's."""
    with socket.socket(socket.AF_UNIX) as probe:
        probe.settimeout(CONNECT_S)
        try:
            probe.connect(path)
        except (BlockingIOError, TimeoutError):
            pass  # it has more clients than it takes
        except OSError:
            return
    raise CamrigError("already_exists", f"{path}: another rig lives there; end it, or choose another place with --control")


class SocketDoor:
    def __init__(self, door: Door) -> None:
        self._door = door
        self._clients = {"unix": 0, "tcp": 0}
        self._strangers = 0

    async def open(self, path: str) -> None:
        """The socket is there afterwards, of mode 0600. already_exists: somebody listens there."""
        _refuse_if_taken(path)
        before = os.umask(0o177)
        try:
            self._server = await asyncio.start_unix_server(lambda *ends: self._serve("unix", *ends), path, limit=PIECE_BYTES)
        finally:
            os.umask(before)

    async def listen(self, host: str, port: int) -> int:
        """Control over TCP too, for who shows the token; the port."""
        assert self._door.token
        server = await asyncio.start_server(self._serve_known, host, port, limit=PIECE_BYTES)
        return server.sockets[0].getsockname()[1]

    async def _serve_known(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._strangers += 1
        try:
            is_known = self._strangers <= _MAX_STRANGERS and await self._shows_token(reader, writer)
        except (OSError, ValueError, KeyError, TypeError, AttributeError, CamrigError, asyncio.TimeoutError):
            is_known = False
        finally:
            self._strangers -= 1
        if is_known:
            await self._serve("tcp", reader, writer)
        writer.close()

    async def _shows_token(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bool:
        asked = json.loads(await asyncio.wait_for(read_line(reader, Claim(Budget()), _MAX_FIRST_LINE), CONNECT_S))
        shown = asked["params"]["token"] if asked["method"] == "auth" else None
        is_known = isinstance(shown, str) and hmac.compare_digest(shown.encode(), (self._door.token or "").encode())
        if is_known:
            answer = line_of({"jsonrpc": "2.0", "id": asked.get("id"), "result": {"authorized": True}})
        else:
            if shown is not None:
                await self._door.wrong_tokens.take(writer.get_extra_info("peername")[0])
            answer = _error("unauthorized", "a client shows the farm's token first (auth)", asked.get("id"))
        writer.write(answer)
        await _drain(writer)
        return is_known

    async def _serve(self, kind: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._clients[kind] += 1
        client = Client(Claim(self._door.budget))
        try:
            if self._clients[kind] > _MAX_CLIENTS:
                writer.write(_error("resource_exhausted", f"there are {_MAX_CLIENTS} connections in use already; close one"))
                await _drain(writer)
                return
            while line := await self._next_line(reader, writer, client):
                if line.strip():
                    writer.write(await self._door.answer(line, client))
                    del line  # it may be long, and the answer to it take its time
                    await _drain(writer)
                client.claim.release()
        except (OSError, ValueError, asyncio.TimeoutError):
            pass
        finally:
            client.close()
            writer.close()
            self._clients[kind] -= 1

    async def _next_line(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, client: Client) -> bytes:
        try:
            return await read_line(reader, client.claim, _MAX_LINE)
        except CamrigError as problem:  # the rest of the line is not read
            writer.write(_error(problem.kind, f"{problem.message}; this connection ends"))
            await _drain(writer)
            await _read_off(reader)
            return b""


async def _drain(writer: asyncio.StreamWriter) -> None:
    draining = asyncio.ensure_future(writer.drain())
    try:
        left = writer.transport.get_write_buffer_size()
        while not (await asyncio.wait([draining], timeout=_STALLED_S))[0]:
            if (now_left := writer.transport.get_write_buffer_size()) >= left:
                writer.transport.abort()
                raise asyncio.TimeoutError
            left = now_left
        draining.result()
    finally:
        draining.cancel()


async def _read_off(reader: asyncio.StreamReader) -> None:
    """What is left of a line: a connection that is closed before loses the answer."""
    async def read() -> None:
        left = _MAX_LINE
        while left > 0 and (some := await reader.read(PIECE_BYTES)):
            left -= len(some)

    with contextlib.suppress(asyncio.TimeoutError):
        await asyncio.wait_for(read(), _LINGER_S)
