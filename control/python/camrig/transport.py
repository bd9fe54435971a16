"""Ways to send one JSON object to the rig and get one back, each with a deadline.

A connection serves one request at a time; the client keeps several. After any error it is closed, because what would
come next on it could be the answer to an earlier request.
"""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import select
import socket
import time
from abc import ABC, abstractmethod
from typing import Any, Callable

from .errors import CamrigError, CamrigTimeout
from .runtime import check_server, command_key

#: Longest answer: a raw 8192x8192 frame of 4 bytes a pixel in base64, and some.
MAX_ANSWER_BYTES = 400 << 20

#: Longest wait in seconds (23 days): sockets and polls count milliseconds in 31 bits, and know no infinity.
MAX_WAIT_S = 2e6

#: Answers with one monotonic clock time; a request must be done before it.
Deadline = float


def _left(deadline: Deadline) -> float:
    left = deadline - time.monotonic()
    if not left > 0:
        raise TimeoutError
    return min(left, MAX_WAIT_S)


class Connection(ABC):
    #: What this connection has to begin with, when the client was given no token.
    key: str | None = None

    @abstractmethod
    def roundtrip(self, request: bytes, deadline: Deadline) -> bytes:
        """Sends one line and returns the answer's. Raises TimeoutError, OSError or CamrigError; then it is of no more use."""

    #: Whether pictures may come as bytes behind the line of an answer: read_bytes() takes them.
    gives_bytes = False

    def read_bytes(self, count: int, deadline: Deadline) -> bytearray:
        """The bytes that follow the answer of the last roundtrip(), all of them, before anything else is sent."""
        raise NotImplementedError

    @abstractmethod
    def is_idle(self) -> bool:
        """False when the rig has closed it (or talks out of turn): do not use it again."""

    @abstractmethod
    def close(self) -> None: ...


class LineConnection(Connection):
    """One object a line, over the Unix socket or TCP."""

    gives_bytes = True

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._rest = b""  # what came behind the line of the last answer

    def roundtrip(self, request: bytes, deadline: Deadline) -> bytes:
        if self._rest:
            raise CamrigError("internal", "the rig sent more than one line as an answer")
        self._socket.settimeout(_left(deadline))
        try:
            self._socket.sendall(request + b"\n")
        except ConnectionError as problem:
            return self._last_line(problem, deadline)
        return self._read_line(deadline)

    def _last_line(self, problem: ConnectionError, deadline: Deadline) -> bytes:
        """What the rig has said before it closed; what went wrong at sending, where it has said nothing."""
        try:
            return self._read_line(deadline)
        except OSError:
            raise problem from None

    def _read_line(self, deadline: Deadline) -> bytes:
        chunks: list[bytes] = []
        received = 0
        while True:
            self._socket.settimeout(_left(deadline))
            chunk = self._socket.recv(1 << 20)
            if not chunk:
                raise ConnectionError("the rig closed the connection")
            end = chunk.find(b"\n")
            if end >= 0:
                self._rest = chunk[end + 1 :]
                chunks.append(chunk[:end])
                return b"".join(chunks)
            chunks.append(chunk)
            received += len(chunk)
            if received > MAX_ANSWER_BYTES:
                raise CamrigError("resource_exhausted", f"the rig's answer is longer than {MAX_ANSWER_BYTES} bytes")

    def read_bytes(self, count: int, deadline: Deadline) -> bytearray:
        if not len(self._rest) <= count <= MAX_ANSWER_BYTES:
            raise CamrigError("internal", f"the rig sent {len(self._rest)} bytes or more as {count}")
        made = bytearray(count)
        made[: len(self._rest)] = self._rest
        received, self._rest = len(self._rest), b""
        with memoryview(made) as view:
            while received < count:
                self._socket.settimeout(_left(deadline))
                size = self._socket.recv_into(view[received:])
                if size == 0:
                    raise ConnectionError("the rig closed the connection")
                received += size
        return made

    def is_idle(self) -> bool:
        if self._rest:
            return False
        try:
            poller = select.poll()
            poller.register(self._socket, select.POLLIN)
            return not poller.poll(0)
        except (OSError, ValueError):
            return False

    def close(self) -> None:
        self._socket.close()


def _reason(body: bytes) -> str:
    """What a refusal says of itself, or nothing."""
    try:
        return str(json.loads(body)["error"]["message"])
    except (ValueError, TypeError, KeyError, RecursionError):
        return ""


class _PunctualSocket(socket.socket):
    """Waits until its deadline and no longer, in however many pieces http.client sends and reads."""

    deadline: Deadline

    def recv_into(self, buffer: Any, nbytes: int = 0, flags: int = 0) -> int:
        self.settimeout(_left(self.deadline))
        return super().recv_into(buffer, nbytes, flags)

    def sendall(self, data: Any, flags: int = 0) -> None:
        self.settimeout(_left(self.deadline))
        super().sendall(data, flags)


def _connect(host: str, port: int, deadline: Deadline) -> socket.socket:
    """To the first of the host's addresses that answers; those left to try share the time left."""
    addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    last = OSError(f"{host} has no address")
    for number, (family, kind, protocol, _, address) in enumerate(addresses):
        try:
            with contextlib.ExitStack() as closing:
                sock = closing.enter_context(socket.socket(family, kind, protocol))
                sock.settimeout(_left(deadline) / (len(addresses) - number))
                sock.connect(address)
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                closing.pop_all()
                return sock
        except OSError as problem:
            last = problem
    raise last


class HttpConnection(Connection):
    """One object in the body of ``POST /rpc``."""

    def __init__(self, host: str, port: int, token: str | None, deadline: Deadline) -> None:
        self._connection = http.client.HTTPConnection(host, port)
        self._socket = self._connection.sock = _PunctualSocket(fileno=_connect(host, port, deadline).detach())
        self._headers = {"Content-Type": "application/json"}
        if token := token or command_key(self._socket):
            self._headers["Authorization"] = f"Bearer {token}"

    def roundtrip(self, request: bytes, deadline: Deadline) -> bytes:
        if self._connection.sock is None:
            raise ConnectionError("the rig closed the connection")
        self._socket.deadline = deadline
        try:
            self._connection.request("POST", "/rpc", body=request, headers=self._headers)
            response = self._connection.getresponse()
            body = response.read(MAX_ANSWER_BYTES + 1)
        except http.client.HTTPException as problem:
            raise ConnectionError(f"not HTTP as expected: {problem!r}") from problem
        if len(body) > MAX_ANSWER_BYTES:
            raise CamrigError("resource_exhausted", f"the rig's answer is longer than {MAX_ANSWER_BYTES} bytes")
        if response.status in (401, 403):
            raise CamrigError("unauthorized", _reason(body) or f"the rig refused the token (HTTP {response.status})")
        if not response.headers.get("Content-Type", "").startswith("application/json"):
            text = body[:200].decode("utf-8", "replace").strip()
            raise CamrigError("unavailable", f"POST /rpc answered HTTP {response.status}: {text}")
        return body

    def is_idle(self) -> bool:
        sock = self._connection.sock
        return sock is not None and LineConnection(sock).is_idle()

    def close(self) -> None:
        self._connection.close()


#: Opens a fresh connection before the deadline.
Connector = Callable[[Deadline], Connection]


def unix_connector(path: str | os.PathLike[str]) -> Connector:
    path = os.fspath(path)

    def connect(deadline: Deadline) -> Connection:
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            sock.settimeout(_left(deadline))
            sock.connect(path)
        except TimeoutError:
            sock.close()
            raise CamrigTimeout("unavailable", f"no answer at {path}") from None
        except OSError as problem:
            sock.close()
            raise CamrigError(
                "unavailable", f"no rig at {path} ({problem.strerror or problem}); start one with: camrig serve SCENE --control {path}"
            ) from problem
        try:
            check_server(sock, path)
        except CamrigError:
            sock.close()
            raise
        return LineConnection(sock)

    return connect


def tcp_connector(host: str, port: int) -> Connector:
    def connect(deadline: Deadline) -> Connection:
        try:
            sock = _connect(host, port, deadline)
        except TimeoutError:
            raise CamrigTimeout("unavailable", f"{host}:{port} does not answer") from None
        except OSError as problem:
            raise CamrigError(
                "unavailable", f"no rig at {host}:{port} ({problem}); start one with: camrig serve SCENE --host {host} --tcp {port}"
            ) from problem
        connection = LineConnection(sock)
        connection.key = command_key(sock)
        return connection

    return connect


def http_connector(host: str, port: int, token: str | None) -> Connector:
    def connect(deadline: Deadline) -> Connection:
        try:
            return HttpConnection(host, port, token, deadline)
        except TimeoutError:
            raise CamrigTimeout("unavailable", f"http://{host}:{port} does not answer") from None
        except OSError as problem:
            raise CamrigError("unavailable", f"no rig at http://{host}:{port} ({problem})") from problem

    return connect
