"""One HTTP address for a farm: POST /rpc by the door; the page and all pictures from nodes that live.

Programs that read a stream are sent to the camera's owner (307), so that no stream of theirs goes through here. All else passes through: the web page
needs everything of its own origin, and a client that shows its token in a header field would not show it to another address.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import secrets
import socket
import sys
from typing import Any, Awaitable, Callable, Sequence

import aiohttp
from aiohttp import web
from aiohttp.http import HttpProcessingError
from yarl import URL

from ...errors import CamrigError
from ...runtime import CommandKeyFile
from .budget import PIECE_BYTES, Claim
from .door import Client, Door
from .http_access import COOKIE, check, equal_tokens, is_loopback, token_of
from .metrics import page as metrics_page
from .multipart import join, parts_of
from .wire import CONNECT_S, url_of

#: What strangers send that is no HTTP is answered (400), and not worth a trace each.
_log = logging.getLogger(__name__)
_log.addFilter(lambda record: not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError)))

#: Bounds: open connections; a body (aiohttp's own); then the times to send a request, to take some bytes, to wait for a node's answer and for one of /rpc.
_MAX_CONNECTIONS, _MAX_BODY = 512, 1 << 20
_MAX_LIVE = 64  # cameras, as the rig has it
_REQUEST_S, _STALLED_S, _REPLY_S, _RPC_S = 10.0, 10.0, 30.0, 600.0
_STATUS = {"invalid_argument": 400, "not_found": 404, "already_exists": 409, "unavailable": 503, "unsupported": 501, "resource_exhausted": 503, "unauthorized": 401}
#: Nodes that one request is put to, one after the other, and what it looks like when one has gone.
_MOST_TRIES = 8
_GONE = (aiohttp.ClientConnectionError, asyncio.TimeoutError, CamrigError)
#: Of a node's answer: what belongs to its connection with us.
_NOT_PASSED = {"connection", "keep-alive", "transfer-encoding", "date", "set-cookie"}
#: Of answers of our own; a node's bring theirs.
_OWN = {"Server": "camrig", "Cross-Origin-Resource-Policy": "same-origin", "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store"}
#: All but the page's own files, which may be linked to from anywhere.
_GUARDED = ("/cameras", "/live", "/healthz", "/metrics")


def _error(kind: str, message: str, status: int | None = None) -> web.Response:
    return web.json_response({"error": {"kind": kind, "message": message}}, status=status or _STATUS.get(kind, 500), headers=_OWN)


def _rpc_error(kind: str, message: str) -> dict[str, Any]:
    return {"error": {"code": -32000, "message": message, "data": {"kind": kind}}}


def _cut_off(request: web.BaseRequest, answer: web.StreamResponse) -> None:
    """It must not look whole."""
    answer.force_close()
    if request.transport:
        request.transport.abort()


class _Refused(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        transport.close()


async def _listen(handler: Callable[[web.BaseRequest], Awaitable[web.StreamResponse]], host: str, port: int) -> tuple[str, int]:
    """Where it listens."""
    try:
        family, *_, at = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listening = socket.create_server(at[:2], family=family)
        # Whoever takes nothing is closed, whatever waits for it; accepted connections inherit this (tcp(7)).
        listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, int(_STALLED_S * 1000))
    except OSError as problem:
        raise CamrigError("unavailable", f"cannot listen at {host}:{port}: {problem.strerror}") from None
    # keepalive_timeout: for a request to come, the first one too. The bound of a body is aiohttp's own.
    server = web.Server(handler, access_log=None, logger=_log, keepalive_timeout=_REQUEST_S, handler_cancellation=True)
    await asyncio.get_running_loop().create_server(lambda: server() if len(server.connections) < _MAX_CONNECTIONS else _Refused(), sock=listening)
    return listening.getsockname()[:2]


def session_of(door: Door) -> aiohttp.ClientSession:
    """To nodes. A connection serves one request: one that a node just closed would look as if the node had gone."""
    headers = {"Authorization": f"Bearer {door.token}"} if door.token else {}
    return aiohttp.ClientSession(connector=aiohttp.TCPConnector(limit=0, force_close=True), headers=headers, auto_decompress=False,
                                 skip_auto_headers=["Accept-Encoding"], timeout=aiohttp.ClientTimeout(total=None, sock_connect=CONNECT_S))


async def serve_metrics(door: Door, session: aiohttp.ClientSession, host: str, port: int) -> str:
    """/metrics alone, open to whoever reaches the address; its URL."""
    async def answer(request: web.BaseRequest) -> web.StreamResponse:
        return await _metrics(door, session) if request.path == "/metrics" else _error("not_found", "there is /metrics")

    name, bound = await _listen(answer, host, port)
    return url_of({"host": name, "http": bound}, "/metrics")


async def _metrics(door: Door, session: aiohttp.ClientSession) -> web.Response:
    return web.Response(body=(await metrics_page(door, session)).encode(), headers={"Content-Type": "text/plain; version=0.0.4; charset=utf-8", **_OWN})


class _WhileThere:
    """The body of a node's answer. A node that hangs closes nothing."""

    def __init__(self, door: Door, node: str, body: aiohttp.StreamReader) -> None:
        self._door, self._node, self._body = door, node, body

    async def readuntil(self, separator: bytes = b"\n") -> bytes:
        return await self._door.while_there(self._node, self._body.readuntil(separator))

    async def readexactly(self, n: int) -> bytes:
        return await self._door.while_there(self._node, self._body.readexactly(n))

    async def readany(self) -> bytes:
        return await self._door.while_there(self._node, self._body.readany())


class HttpDoor:
    def __init__(self, door: Door, session: aiohttp.ClientSession) -> None:
        self._door, self._session, self._key = door, session, ""
        self._key_file: CommandKeyFile | None = None
        door.look_openly = self._look_openly

    async def open(self, host: str, port: int) -> None:
        self._name = host
        assert self._door.token or is_loopback(host)
        at, bound = await _listen(self._answer, host, port)
        self.url = url_of({"host": at, "http": bound}, "/")
        if not self._door.token:
            self._key = secrets.token_hex(24)
            self._door.how_to_command = ("commands need this farm's key: open the page by the link that camrig farm printed (it ends in #key=...), or send "
                                         "'Authorization: Bearer KEY' with the line in its key file, which camrig call server.info names")
            try:
                self._key_file = CommandKeyFile(self._key, at, bound)
            except CamrigError as problem:  # the printed link has it
                print(f"camrig farm: {problem.message}; until then no client finds the key for commands by itself", file=sys.stderr, flush=True)
        self._door.http = {"host": at, "http": bound, **({"key_file": self.key_file} if self.key_file else {})}

    @property
    def key_file(self) -> str | None:
        return self._key_file.path if self._key_file else None

    @property
    def link(self) -> str:
        """That opens the page with the right to command."""
        return self.url + (f"#key={self._key}" if self._key else "")

    def close(self) -> None:
        if self._key_file:
            self._key_file.close()

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        token = self._door.token
        if not request.rel_url.raw_path.startswith("/"):  # behind a node's address it would be another address
            return _error("invalid_argument", "the target of a request is a path")
        try:
            shown = token_of(request.headers, request.query, request.cookies)
            check(request.method, request.headers, self._name, bool(token), request.path.startswith(_GUARDED))
        except CamrigError as problem:
            return _error(problem.kind, problem.message, 403 if problem.kind == "unauthorized" else None)
        if token and not equal_tokens(shown, token):
            if shown:
                await self._door.wrong_tokens.take(request.remote)
            return _error("unauthorized", "send 'Authorization: Bearer TOKEN' with the farm's token, or add ?token=TOKEN to the URL")
        try:
            if request.path == "/rpc":
                return await self._rpc(request, may_command=bool(token) or equal_tokens(shown, self._key))
            if request.method not in ("GET", "HEAD", "OPTIONS"):
                return _error("unsupported", f"{request.path[:80]} takes GET, HEAD and OPTIONS", 405)
            if request.path == "/metrics":
                return await _metrics(self._door, self._session)
            if request.path == "/live":
                return await self._live(request)
            return await self._from_node(request, self._camera_of(request.path))
        except CamrigError as problem:
            return _error(problem.kind, problem.message)
        except (aiohttp.ClientError, ValueError) as problem:  # InvalidURL is both
            return _error("invalid_argument", f"this cannot be asked of a node: {str(problem)[:200]}")

    async def _rpc(self, request: web.BaseRequest, may_command: bool) -> web.StreamResponse:
        if request.method != "POST":
            return _error("unsupported", "/rpc takes POST", 405)
        if request.content_type != "application/json":
            return _error("invalid_argument", "POST /rpc needs 'Content-Type: application/json'", 415)
        client = Client(Claim(self._door.budget), may_command=may_command, takes_bytes=False)
        try:
            body = await asyncio.wait_for(request.read(), _REQUEST_S)
            client.claim.grow(len(body))
            text = await asyncio.wait_for(self._door.answer(body, client), _RPC_S)
            return await self._write(request, text) if text else web.Response(status=204)
        except web.HTTPRequestEntityTooLarge:
            return _error("resource_exhausted", f"the body is larger than {_MAX_BODY >> 10} KiB", 413)
        except asyncio.TimeoutError:
            return _error("unavailable", "the request did not come, or its answer did not, in time")
        finally:
            client.close()

    @staticmethod
    async def _write(request: web.BaseRequest, text: bytes) -> web.StreamResponse:
        """To the end, so that it can be let go of."""
        answer = web.StreamResponse(headers={"Content-Type": "application/json; charset=utf-8", **_OWN})
        answer.content_length = len(text)
        await answer.prepare(request)
        try:
            for begin in range(0, len(text), PIECE_BYTES):
                await asyncio.wait_for(answer.write(text[begin : begin + PIECE_BYTES]), _STALLED_S)
            await answer.write_eof()
        except asyncio.TimeoutError:
            _cut_off(request, answer)
        return answer

    async def _look_openly(self, node: dict[str, Any], request: dict[str, Any], claim: Claim) -> dict[str, Any]:
        asked = json.dumps({"jsonrpc": "2.0", **request, "id": 0}, ensure_ascii=False, separators=(",", ":")).encode()
        if len(asked) > _MAX_BODY:
            return _rpc_error("invalid_argument", "the request is too long")
        try:
            async with self._session.post(url_of(node, "/rpc"), data=asked, headers={"Content-Type": "application/json"}) as reply:
                text = bytearray()
                async for some in reply.content.iter_any():
                    claim.grow(len(some))
                    text += some
        except (aiohttp.ClientError, asyncio.TimeoutError) as problem:
            raise CamrigError("unavailable", f"{request['method']}: the node has gone ({problem}); ask again") from None
        answer = json.loads(text)
        return answer if reply.status == 200 else _rpc_error(answer["error"]["kind"], answer["error"]["message"])

    @staticmethod
    def _camera_of(path: str) -> str | None:
        """Whose owner is to answer."""
        parts = path.split("/")
        return parts[2] if len(parts) == 4 and parts[1] == "cameras" else None

    async def _live(self, request: web.BaseRequest) -> web.StreamResponse:
        """Each camera from its owner, all on one connection. Ends when one of them ends; who reads asks again."""
        names = request.query.get("cameras", "").split(",")
        if len({self._door.node_for({"camera": name})["node"] for name in names}) < 2 or len(names) > _MAX_LIVE or request.method != "GET":
            return await self._from_node(request, names[0])
        for _ in range(_MOST_TRIES):
            if (replies := await self._open_each(request, names)) is not None:
                break
        else:
            raise CamrigError("unavailable", "no node answers now; ask again")
        try:
            for node, reply in replies.items():
                if reply.status != 200:
                    return await self._pass(request, reply, node)
            made = self._begin(next(iter(replies.values())))
            await made.prepare(request)

            async def write(part: bytes) -> None:
                await asyncio.wait_for(made.write(part), _STALLED_S)

            with contextlib.suppress(aiohttp.ClientError, asyncio.TimeoutError, CamrigError, ConnectionError, ValueError):
                await join([parts_of(_WhileThere(self._door, node, reply.content)) for node, reply in replies.items()], write)
            made.force_close()
            return made
        finally:
            for reply in replies.values():
                reply.close()

    async def _open_each(self, request: web.BaseRequest, names: Sequence[str]) -> dict[str, aiohttp.ClientResponse] | None:
        """/live of each owner, for its own cameras; None: one has gone, and others own its cameras now."""
        by_node: dict[str, list[str]] = {}
        for name in names:
            by_node.setdefault(self._door.node_for({"camera": name})["node"], []).append(name)
        replies: dict[str, aiohttp.ClientResponse] = {}
        try:
            for node, own in by_node.items():
                target = f"/live?{request.rel_url.update_query(cameras=','.join(own)).raw_query_string}"
                replies[node] = await self._door.while_there(node, self._ask(self._door.nodes()[node], request, target))
        except (*_GONE, KeyError) as problem:
            self._door.pass_by(node, problem)
        finally:
            if len(replies) < len(by_node):  # also when who asked has gone meanwhile
                for reply in replies.values():
                    reply.close()
        return replies if len(replies) == len(by_node) else None

    async def _from_node(self, request: web.BaseRequest, camera: str | None) -> web.StreamResponse:
        query = request.rel_url.raw_query_string
        target = request.rel_url.raw_path + (f"?{query}" if query else "")
        is_stream = request.path.endswith("/stream.mjpg")
        by_query = not self._door.token or "token" in request.query
        for _ in range(_MOST_TRIES):
            node = self._door.node_for({"camera": camera} if camera is not None else {})
            if is_stream and by_query and request.headers.get("Sec-Fetch-Site", "none") == "none":
                return web.Response(status=307, headers={"Location": url_of(node, target), **_OWN})
            try:
                reply = await self._door.while_there(node["node"], self._ask(node, request, target))
            except _GONE as problem:
                self._door.pass_by(node["node"], problem)
                continue
            try:
                return await self._pass(request, reply, node["node"])
            finally:
                reply.close()
        raise CamrigError("unavailable", "no node answers now; ask again")

    async def _ask(self, node: dict[str, Any], request: web.BaseRequest, target: str) -> aiohttp.ClientResponse:
        await self._door.reach(node)
        passed = {name: request.headers[name] for name in ("If-None-Match",) if name in request.headers}
        asking = self._session.request(request.method, URL(url_of(node, target), encoded=True), headers=passed, allow_redirects=False)
        return await asyncio.wait_for(asking, _REPLY_S)

    @staticmethod
    def _begin(reply: aiohttp.ClientResponse) -> web.StreamResponse:
        made = web.StreamResponse(status=reply.status, reason=reply.reason)
        for name, value in reply.headers.items():
            if name.lower() not in _NOT_PASSED:
                made.headers.add(name, value)
        return made

    async def _pass(self, request: web.BaseRequest, reply: aiohttp.ClientResponse, node: str) -> web.StreamResponse:
        """Byte by byte; ends with the node."""
        made = self._begin(reply)
        if self._door.token and "token" in request.query and reply.status == 200 and not request.path.startswith(_GUARDED):
            made.set_cookie(COOKIE, self._door.token, path="/", httponly=True, samesite="Strict")
        await made.prepare(request)
        body = _WhileThere(self._door, node, reply.content)
        try:
            while some := await body.readany():
                await asyncio.wait_for(made.write(some), _STALLED_S)
            await made.write_eof()
        except (aiohttp.ClientError, asyncio.TimeoutError, CamrigError, ConnectionError):
            _cut_off(request, made)
        return made
