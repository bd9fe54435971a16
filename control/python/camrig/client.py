"""JSON-RPC 2.0 calls from any thread."""

from __future__ import annotations

import itertools
import json
import os
import threading
import time
import weakref
from typing import Any, Mapping

from .errors import CamrigError, CamrigTimeout, error_of_reply
from .transport import Connection, Connector

DEFAULT_TIMEOUT_S = 30.0
_MAX_IDLE_CONNECTIONS = 4

#: All of this process; a forked one leaves their connections to its parent.
_clients: weakref.WeakSet[Client] = weakref.WeakSet()


class Client:
    """Sends requests and waits for their answers.

    Any thread may call; calls of different threads travel on connections of their own and do not wait for each other. A
    request is never sent twice: when the connection breaks in the middle, the caller learns it and decides. A forked process may
    call too, over connections of its own.
    """

    def __init__(self, connector: Connector, token: str | None = None, timeout_s: float = DEFAULT_TIMEOUT_S) -> None:
        self._connector = connector
        self._token = token
        self.timeout_s = timeout_s
        self._ids = itertools.count(1)
        self._lock = threading.Lock()
        self._idle: list[Connection] = []
        self._closed = False
        _clients.add(self)

    def call(self, method: str, params: Mapping[str, Any] | None = None, timeout_s: float | None = None, wants_bytes: bool = False) -> Any:
        """The ``result`` of the method; raises CamrigError.

        ``wants_bytes``: asks for ``data`` as bytes behind the answer where the connection has that (a bytearray); else it is base64.
        """
        timeout_s = self.timeout_s if timeout_s is None else timeout_s
        deadline = time.monotonic() + timeout_s
        connection = self._take(deadline, timeout_s)
        try:
            if wants_bytes and connection.gives_bytes:
                params = {**(params or {}), "encoding": "bytes"}
            result = self._exchange(connection, method, params, deadline)
        except CamrigError as problem:
            # The rig's own errors leave the connection in order; anything else does not.
            if getattr(problem, "is_reply", False):
                self._give_back(connection)
            else:
                connection.close()
            raise
        except OSError as problem:
            connection.close()
            raise _lost(method, problem, timeout_s) from problem
        except BaseException:
            connection.close()
            raise
        self._give_back(connection)
        return result

    def close(self) -> None:
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()

    def _leave_to_parent(self) -> None:
        """In a forked process: the idle connections are the parent's, and a thread of the parent's may hold the lock for ever."""
        self._lock = threading.Lock()
        idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()

    def _exchange(self, connection: Connection, method: str, params: Mapping[str, Any] | None, deadline: float) -> Any:
        request_id = next(self._ids)
        request = {"jsonrpc": "2.0", "id": request_id, "method": method, "params": dict(params or {})}
        try:
            text = json.dumps(request, allow_nan=False, separators=(",", ":"))
        except (TypeError, ValueError) as problem:
            raise _as_reply(CamrigError("invalid_argument", f"{method}: {problem}")) from None
        line = connection.roundtrip(text.encode(), deadline)
        result = _result(method, request_id, line)
        if isinstance(result, dict) and result.get("encoding") == "bytes":
            result["data"] = connection.read_bytes(int(result["bytes"]), deadline)
        return result

    def _take(self, deadline: float, timeout_s: float) -> Connection:
        while True:
            with self._lock:
                if self._closed:
                    raise CamrigError("unavailable", "this rig is closed")
                connection = self._idle.pop() if self._idle else None
            if connection is None:
                break
            if connection.is_idle():
                return connection
            connection.close()
        connection = self._connector(deadline)
        if token := self._token or connection.key:
            try:
                self._exchange(connection, "auth", {"token": token}, deadline)
            except (OSError, CamrigError) as problem:
                connection.close()
                if isinstance(problem, CamrigError):
                    raise
                raise _lost("auth", problem, timeout_s) from problem
        return connection

    def _give_back(self, connection: Connection) -> None:
        with self._lock:
            if not self._closed and len(self._idle) < _MAX_IDLE_CONNECTIONS:
                self._idle.append(connection)
                return
        connection.close()


def _leave_all_to_parent() -> None:
    for client in _clients:
        client._leave_to_parent()


os.register_at_fork(after_in_child=_leave_all_to_parent)


def _result(method: str, request_id: int, line: bytes) -> Any:
    """What the rig answered to this request; raises CamrigError."""
    try:
        reply = json.loads(line)
    except ValueError as problem:
        raise CamrigError("internal", f"{method}: the rig's answer is not JSON: {problem}") from None
    if not isinstance(reply, dict) or ("result" not in reply) == ("error" not in reply):
        raise CamrigError("internal", f"{method}: the rig's answer is not JSON-RPC 2.0: {str(reply)[:200]}")
    answered = reply.get("id")
    if "error" in reply and answered is None:
        # Refused before it was read as a request: often the rig's last words on this connection.
        raise error_of_reply(method, reply["error"])
    if answered != request_id:
        raise CamrigError("internal", f"{method}: the rig answered request {answered!r} instead of {request_id}")
    if "error" in reply:
        raise _as_reply(error_of_reply(method, reply["error"]))
    return reply["result"]


def _lost(method: str, problem: OSError, timeout_s: float) -> CamrigError:
    """What a call raises that got no answer."""
    if isinstance(problem, TimeoutError):
        return CamrigTimeout("unavailable", f"{method}: no answer within {timeout_s:g} s")
    return CamrigError("unavailable", f"{method}: {problem}")


def _as_reply(error: CamrigError) -> CamrigError:
    error.is_reply = True  # type: ignore[attr-defined]
    return error
