"""Bodies of /live of several nodes as one."""

from __future__ import annotations

import asyncio
import re
from typing import AsyncIterator, Awaitable, Callable, Protocol, Sequence

_LENGTH = re.compile(rb"\r\nContent-Length: (\d{1,8})\r\n", re.IGNORECASE)
_MAX_PART = 64 << 20


class Readable(Protocol):
    async def readuntil(self, separator: bytes = ...) -> bytes: ...
    async def readexactly(self, n: int) -> bytes: ...


async def parts_of(body: Readable) -> AsyncIterator[bytes]:
    """Each with its boundary before it, whole; ends with the body, also where that is cut off."""
    try:
        while True:
            head = (await body.readuntil(b"\r\n\r\n")).lstrip(b"\r\n")
            length = _LENGTH.search(head)
            if not length or int(length[1]) > _MAX_PART:  # the closing boundary
                return
            yield head + await body.readexactly(int(length[1])) + b"\r\n"
    except asyncio.IncompleteReadError:
        return


async def join(bodies: Sequence[AsyncIterator[bytes]], write: Callable[[bytes], Awaitable[None]]) -> None:
    """Part by part as they come, until one body ends. Nobody reads ahead: who waits to write holds one part."""
    turn = asyncio.Lock()
    is_over = False

    async def take(body: AsyncIterator[bytes]) -> None:
        async for part in body:
            async with turn:
                await write(part)
            if is_over:  # wait_for() before Python 3.12 loses a cancellation that comes when what it waits for has just been done
                return

    taking = [asyncio.ensure_future(take(body)) for body in bodies]
    try:
        done, _ = await asyncio.wait(taking, return_when=asyncio.FIRST_COMPLETED)
        for one in done:
            one.result()
    finally:
        is_over = True
        for one in taking:
            one.cancel()
        await asyncio.gather(*taking, return_exceptions=True)
