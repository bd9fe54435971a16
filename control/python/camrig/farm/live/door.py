"""One control address for a farm: answers the whole control protocol, whatever way a request came (socket_door.py, http_door.py).

What changes the world goes into the log, through the sequencer; what only looks goes to a node: about a camera, to the one that owns it.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
import uuid
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, Coroutine

import nats.errors

from ...errors import CamrigError, error_of_reply
from ..form import raise_if_unreadable
from .budget import Budget, Claim, read_exactly, read_line
from .log import LEASE_S, MAX_ENTRY_BYTES, Subjects
from .placement import is_placeable, owner_of
from .roster import Roster
from .wire import line_of, url_of
from .wires import Wires
from .wrong_tokens import WrongTokens

#: So long a command is tried again, when the sequencer has died; and a step, which waits for readers.
COMMAND_TIMEOUT_S, STEP_TIMEOUT_S = 15.0, 120.0
#: So long one try waits. The command has an id: however often it is sent, it comes once.
_TRY_S, _LOOK_S = 2.0, 0.1
_MAX_BATCH = 64
#: That one machine starts.
_MAX_NODES = 64


def _count_of(params: dict[str, Any]) -> int:
    count = params.get("nodes")
    if set(params) != {"nodes"} or not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= _MAX_NODES:
        raise CamrigError("invalid_argument", f"farm.scale: nodes: a number from 1 to {_MAX_NODES}")
    return count


async def _whole_line(reader: asyncio.StreamReader, claim: Claim) -> bytes:
    line = await read_line(reader, claim)
    if not line.endswith(b"\n"):
        raise EOFError("closed")
    return line


@dataclass
class Client:
    """Who asks."""

    claim: Claim  #: for its request and the answer
    may_command: bool = True
    takes_bytes: bool = True  #: behind the line of an answer

    def close(self) -> None:
        self.claim.release()


class Door:
    def __init__(self, bus: Any, subjects: Subjects, token: str | None = None) -> None:
        """``token``: of nodes on other machines, all of which have the same."""
        self._bus, self._subjects, self.token = bus, subjects, token
        self.budget, self.wrong_tokens = Budget(), WrongTokens()
        self._nodes, self._wires = Roster(), Wires(token)
        self._moved: dict[str, str] = {}
        self._full: list[str] = []
        self._moved_by = self._done_ns = 0
        self._commanded = float("-inf")
        self._is_lockstep = False
        self._writes: set[str] = set()
        self.scale: Callable[[int], Awaitable[Any]] | None = None  #: farm.scale, where nodes can be started
        #: Puts a request to a node as one who may only look does: the node's rig knows which methods that may.
        self.look_openly: Callable[[dict[str, Any], dict[str, Any], Claim], Awaitable[dict[str, Any]]] | None = None
        self.http: dict[str, Any] = {}  #: members of server.info: where the farm's own HTTP is
        self.how_to_command = ""
        self.scraping = asyncio.Lock()
        self.ended = asyncio.Event()  # by server.shutdown

    async def open(self) -> None:
        """Hears of nodes from then on."""
        await self._bus.subscribe(self._subjects.report, cb=self._on_report)

    async def _on_report(self, message: Any) -> None:
        report = json.loads(message.data)
        report.pop("parts", None)
        moved, full = report.pop("moved", None), report.pop("full", [])  # from the sequencer alone
        if moved is not None and report["moved_by"] >= self._moved_by:
            self._moved, self._moved_by, self._full = moved, report["moved_by"], full
        self._nodes.hear(report)

    def nodes(self) -> dict[str, dict[str, Any]]:
        return {name: self._nodes[name] for name in self._nodes.live()}

    def owners(self) -> list[str]:
        """Who can have cameras; if nobody can, who is there."""
        live = self._nodes.live()
        return [name for name in live if is_placeable(self._nodes[name])] or live

    def forget(self, node: str) -> None:
        """Known to be dead: its cameras move at once."""
        self._nodes.forget(node)

    def pass_by(self, node: str, problem: Exception) -> None:
        """Looking changes nothing: another node can answer. ``problem`` is raised where it says that this one lives."""
        if isinstance(problem, CamrigError) and problem.kind in ("resource_exhausted", "unauthorized"):
            raise problem
        self.forget(node)  # it comes back by its next report if it has not died

    async def call(self, method: str, **params: Any) -> Any:
        client = Client(Claim(self.budget))
        try:
            reply = await self._answer({"method": method, "params": params}, client)
        finally:
            client.close()
        if "error" in reply:
            raise error_of_reply(method, reply["error"])
        return reply["result"]

    async def answer(self, line: bytes, client: Client) -> bytes:
        """To a request or a batch; empty: nobody waits for one. It is in the client's claim."""
        try:
            message = json.loads(line)
        except (ValueError, RecursionError) as problem:
            return self._no_request(f"not JSON: {problem}", -32700)
        requests = message if isinstance(message, list) else [message]
        if not requests or len(requests) > _MAX_BATCH or not all(isinstance(each, dict) and isinstance(each.get("method"), str) for each in requests):
            return self._no_request(f"a request has jsonrpc, id, method and params; a batch at most {_MAX_BATCH}")
        try:
            raise_if_unreadable(requests)
        except CamrigError as problem:
            return self._no_request(problem.message, -32700)
        replies = []
        for request in requests:
            reply = await self._answer(request, client, is_alone=not isinstance(message, list))
            if isinstance(reply, bytes):
                return reply
            if "id" in request:
                replies.append({"jsonrpc": "2.0", "id": request["id"], **reply})
        if not replies:
            return b""
        text = line_of(replies if isinstance(message, list) else replies[0])
        try:
            client.claim.grow(len(text))
        except CamrigError as problem:
            return line_of({"jsonrpc": "2.0", "id": replies[0]["id"], **self._error(problem)})
        return text

    @staticmethod
    def _no_request(message: str, code: int = -32600) -> bytes:
        return line_of({"jsonrpc": "2.0", "id": None, "error": {"code": code, "message": message, "data": {"kind": "invalid_argument"}}})

    async def _answer(self, request: dict[str, Any], client: Client, is_alone: bool = False) -> Any:
        """``is_alone``: the answer may be a rig's own, as bytes."""
        method, params = request["method"], request.get("params") or {}
        try:
            if not isinstance(params, dict):
                raise CamrigError("invalid_argument", f"{method}: params: must be an object")
            if method == "farm.status":
                return {"result": await self._status()}
            if not client.may_command and method in ("farm.scale", "server.shutdown"):
                raise self._refused(method)
            if method == "farm.scale" and self.scale:
                return {"result": await self.scale(_count_of(params))}
            if method == "server.shutdown":
                self.ended.set()
                return {"result": {"stopping": True}}
            if not self._writes:
                await self._learn()
            if method in self._writes and not client.may_command:
                raise self._refused(method)
            if method in self._writes:
                return await self._command(method, params)
            return await self._look(request, params, client, is_alone and "id" in request and method != "server.info")
        except CamrigError as problem:
            return self._error(problem)

    @staticmethod
    def _error(problem: CamrigError) -> dict[str, Any]:
        return {"error": {"code": -32000, "message": problem.message, "data": {"kind": problem.kind}}}

    def _refused(self, method: str) -> CamrigError:
        return CamrigError("unauthorized", f"{method}: {self.how_to_command}")

    async def _learn(self) -> None:
        """What changes the world takes a time: so the rig's own description says."""
        self._is_lockstep = (await self._once("world.status"))["mode"] == "lockstep"
        described = await self._once("server.describe")
        self._writes = {each["name"] for each in described["methods"] if any(field["name"] == "at_ns" for field in each["params"])} - {"world.digest"} | {"world.step"}

    async def _once(self, method: str) -> Any:
        while True:
            node = self.node_for({})
            try:
                return await self.while_there(node["node"], self._ask_after_commands(node, method))
            except CamrigError as problem:
                self.pass_by(node["node"], problem)

    async def _ask(self, node: dict[str, Any], method: str, **params: Any) -> Any:
        request = {"jsonrpc": "2.0", "id": 0, "method": method, "params": params}
        reply = json.loads(await self._wires.ask(node, request, lambda reader: _whole_line(reader, Claim(Budget()))))
        if "error" in reply:
            raise error_of_reply(method, reply["error"])
        return reply["result"]

    async def _ask_after_commands(self, node: dict[str, Any], method: str) -> Any:
        await self.reach(node)
        return await self._ask(node, method)

    async def reach(self, node: dict[str, Any]) -> None:
        """Who looks after a command sees what it did, whichever node he is shown: it is done there at the same world time, which may be
        some milliseconds away. (In lockstep all nodes are together after each step.)"""
        if not self._is_lockstep and time.monotonic() - self._commanded < LEASE_S:
            try:
                await self._ask(node, "world.digest", at_ns=self._done_ns + 1)
            except CamrigError as problem:  # most often that it is past
                if problem.kind == "resource_exhausted":
                    raise

    async def _command(self, method: str, params: dict[str, Any]) -> dict[str, Any]:
        if "at_ns" in params:
            raise CamrigError("invalid_argument", "at_ns: a farm says itself when a command is done")
        asked = json.dumps({"id": uuid.uuid4().hex, "method": method, "params": params}).encode()
        if len(asked) > MAX_ENTRY_BYTES:
            raise CamrigError("invalid_argument", f"{method}: a command of a farm has at most {MAX_ENTRY_BYTES} bytes")
        timeout_s = STEP_TIMEOUT_S if method == "world.step" else COMMAND_TIMEOUT_S
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            told, sequencer = asyncio.ensure_future(self._bus.request(self._subjects.command, asked, timeout=_TRY_S)), self._sequencer()
            while not (await asyncio.wait([told], timeout=_LOOK_S))[0] and self._sequencer() == sequencer:
                pass
            told.cancel()  # if there is another sequencer now, it did not hear us
            with contextlib.suppress(nats.errors.Error, asyncio.TimeoutError, asyncio.CancelledError):
                if reply := json.loads((await told).data):
                    self._commanded, self._done_ns = time.monotonic(), max(self._done_ns, reply.pop("at_ns", 0))
                    return reply
            await asyncio.sleep(_LOOK_S)
        raise CamrigError("unavailable", f"{method}: no sequencer or no log answers for {timeout_s:.0f} s; it is not known whether this command comes")

    def _sequencer(self) -> tuple[int, str] | None:
        return max(((report["term"], name) for name, report in self.nodes().items() if report["is_sequencer"]), default=None)

    def node_for(self, params: dict[str, Any]) -> dict[str, Any]:
        owners = self.owners()
        if not owners:
            raise CamrigError("unavailable", "no node of this farm is there now")
        camera = params.get("camera", params.get("name"))
        return self._nodes[owner_of(camera, owners, self._moved) if isinstance(camera, str) else owners[0]]

    async def _look(self, request: dict[str, Any], params: dict[str, Any], client: Client, is_own: bool) -> Any:
        while True:
            node = self.node_for(params)
            try:
                reply = await self.while_there(node["node"], self._look_at(node, request, client, is_own))
                if request["method"] == "server.info" and self.http and isinstance(reply, dict) and "result" in reply:
                    reply["result"] = self._info(reply["result"])
                return reply
            except CamrigError as problem:
                self.pass_by(node["node"], problem)

    def _info(self, of_node: dict[str, Any]) -> dict[str, Any]:
        """Where HTTP is: here. RTSP is the nodes' own, so it is told where their address is the same."""
        own = {key: value for key, value in of_node.items() if key != "key_file"} | self.http
        return own if of_node.get("host") == self.http["host"] else own | {"rtsp": 0}

    async def while_there(self, node: str, answer: Coroutine[Any, Any, Any]) -> Any:
        """A node that hangs closes nothing."""
        asking = asyncio.ensure_future(answer)
        try:
            while not (await asyncio.wait([asking], timeout=LEASE_S / 4))[0]:
                if node not in self._nodes.live():
                    raise CamrigError("unavailable", f"node {node} does not answer")
            return asking.result()
        finally:
            asking.cancel()  # also when who asked has gone

    async def _look_at(self, node: dict[str, Any], request: dict[str, Any], client: Client, is_own: bool) -> Any:
        if not client.may_command:
            assert self.look_openly
            await self.reach(node)
            reply = await self.look_openly(node, request, client.claim)
            if reply.get("error", {}).get("data", {}).get("kind") == "unauthorized":
                return self._error(self._refused(request["method"]))
            return {key: reply[key] for key in ("result", "error") if key in reply}
        asked = request.get("params")
        wants_bytes = isinstance(asked, dict) and asked.get("encoding") == "bytes"

        async def read(reader: asyncio.StreamReader) -> Any:
            line = await _whole_line(reader, client.claim)
            # Errors are read: that of a rig with too many connections has nobody's id.
            if is_own and not wants_bytes and not line.startswith(b'{"error"'):
                return line
            reply = json.loads(line)
            result = reply.get("result")
            if isinstance(result, dict) and result.get("encoding") == "bytes":
                rest = await read_exactly(reader, int(result["bytes"]), client.claim)
                if not client.takes_bytes:
                    return self._error(CamrigError("invalid_argument", "encoding: bytes come on the control socket and TCP; not by HTTP"))
                return line + rest
            return {key: reply[key] for key in ("result", "error") if key in reply}

        await self.reach(node)
        return await self._wires.ask(node, {"jsonrpc": "2.0", "id": 0, **request}, read)

    async def _status(self) -> dict[str, Any]:
        nodes = self.nodes()
        listed = (await self._once("camera.list"))["cameras"] if nodes else []
        cameras = []
        for camera in listed:
            at = self.node_for({"camera": camera["name"]})
            http, rtsp = url_of(at, f"/cameras/{camera['name']}/stream.mjpg"), url_of(at, f"/{camera['name']}", "rtsp")
            cameras.append({"camera": camera["name"], "node": at["node"], "http": http, "rtsp": rtsp})
        return {"nodes": [{**node, "is_full": name in self._full} for name, node in nodes.items()], "cameras": cameras}
