"""A door's connections to the rigs of nodes: few, however many clients it has.

A rig that has as many connections as it takes closes the one that has been idle longest when another comes. That may be one of its own node's, or one
that is kept here: then nothing is said of the node.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Any, Awaitable, Callable, TypeVar

from ...errors import CamrigError
from .budget import PIECE_BYTES
from .wire import connect_to, line_of

#: To one node; its rig takes 64 (control/rpc/limits.h), with the node's own. A request waits so long for one of them.
_MOST, _WAIT_S = 48, 10.0
_T = TypeVar("_T")


@dataclass
class _ToNode:
    life: str
    places: asyncio.Semaphore
    idle: list[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = field(default_factory=list)


class Wires:
    def __init__(self, token: str | None) -> None:
        self._token = token
        self._nodes: dict[str, _ToNode] = {}

    async def ask(self, node: dict[str, Any], request: dict[str, Any], read: Callable[[asyncio.StreamReader], Awaitable[_T]]) -> _T:
        """What ``read`` takes of the connection is the answer, and all of it. Errors: unavailable, the node has gone; resource_exhausted."""
        to_node = self._to(node)
        try:
            await asyncio.wait_for(to_node.places.acquire(), _WAIT_S)
        except asyncio.TimeoutError:
            raise CamrigError("resource_exhausted", f"this door waits for {_MOST} answers of node {node['node']} already; ask again later") from None
        try:
            text = line_of(request)
            while to_node.idle:
                try:
                    return await self._answer(to_node, *to_node.idle.pop(), text, read)
                except (OSError, ValueError, EOFError):
                    pass  # the rig closed it while nobody needed it
            return await self._answer(to_node, *await connect_to(node, self._token, PIECE_BYTES), text, read)
        except (OSError, ValueError, EOFError, asyncio.TimeoutError) as problem:
            raise CamrigError("unavailable", f"{request['method']}: the node has gone ({problem or 'closed'}); ask again") from None
        finally:
            to_node.places.release()

    def _to(self, node: dict[str, Any]) -> _ToNode:
        known = self._nodes.get(node["node"])
        if not known or known.life != node["life"]:
            for _, writer in known.idle if known else ():
                writer.close()
            known = self._nodes[node["node"]] = _ToNode(node["life"], asyncio.Semaphore(_MOST))
        return known

    @staticmethod
    async def _answer(to_node: _ToNode, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, text: bytes,
                      read: Callable[[asyncio.StreamReader], Awaitable[_T]]) -> _T:
        try:
            writer.write(text)
            answer = await read(reader)
        except BaseException:  # also when who asked has gone: the rest of the answer is still to come
            writer.close()
            raise
        to_node.idle.append((reader, writer))
        return answer
