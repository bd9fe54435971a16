"""Wrong tokens, as a rig has them: answered late, counted, and told once a second at most."""

from __future__ import annotations

import asyncio
import sys
import time

WAIT_S = 0.25
_TELL_S = 1.0


class WrongTokens:
    def __init__(self) -> None:
        self.count = 0
        self._told = float("-inf")

    async def take(self, peer: object) -> None:
        """Before it is answered."""
        self.count += 1
        if (now := time.monotonic()) - self._told >= _TELL_S:
            self._told = now
            print(f"camrig farm: {peer} has sent a wrong token; {self.count} since the start", file=sys.stderr, flush=True)
        await asyncio.sleep(WAIT_S)
