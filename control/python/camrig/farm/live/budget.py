"""What clients of a door make it hold at one time, all together: requests and answers that are on their way. Bounded before it is taken."""

from __future__ import annotations

import asyncio

from ...errors import CamrigError

#: Of all clients, and of one request with its answer; a rig answers with at most 80 MiB (control/rpc/limits.h).
TOTAL_BYTES, MOST_BYTES = 256 << 20, 96 << 20
#: Of a StreamReader: it holds twice as much before it stops reading.
PIECE_BYTES = 64 << 10


class Budget:
    def __init__(self, total: int = TOTAL_BYTES) -> None:
        self.total, self.used = total, 0


class Claim:
    """Of one client, until its answer has gone out."""

    def __init__(self, budget: Budget) -> None:
        self._budget, self._bytes = budget, 0

    def grow(self, size: int) -> None:
        if self._bytes + size > MOST_BYTES:
            raise CamrigError("resource_exhausted", f"a request with its answer has at most {MOST_BYTES >> 20} MiB")
        if self._budget.used + size > self._budget.total:
            raise CamrigError("resource_exhausted", f"this door has {self._budget.total >> 20} MiB for all clients and they are in use; read the answers that are due, then ask again")
        self._bytes += size
        self._budget.used += size

    def release(self) -> None:
        self._budget.used -= self._bytes
        self._bytes = 0


async def read_line(reader: asyncio.StreamReader, claim: Claim, most: int = MOST_BYTES) -> bytes:
    """With its end; without one, or empty, where the other side has closed. ``reader``: with a limit of PIECE_BYTES."""
    pieces: list[bytes] = []
    size = 0
    while True:
        try:
            piece = await reader.readuntil(b"\n")
        except asyncio.LimitOverrunError as more:
            piece = await reader.readexactly(more.consumed)
        except asyncio.IncompleteReadError as end:
            return b"".join([*pieces, end.partial])
        if (size := size + len(piece)) > most:
            raise CamrigError("resource_exhausted", f"a line has at most {most} bytes here")
        claim.grow(len(piece))
        pieces.append(piece)
        if piece.endswith(b"\n"):
            return b"".join(pieces)


async def read_exactly(reader: asyncio.StreamReader, size: int, claim: Claim) -> bytes:
    claim.grow(size)
    return await reader.readexactly(size)
