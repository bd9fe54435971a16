"""Random numbers that depend on what they are for and on nothing else: the same in whatever order and by whichever process they are asked for."""

from __future__ import annotations

import hashlib


def chance(*what: object) -> float:
    """Uniform in [0, 1), a function of `what` (seed, names, times): a counter-based generator, so that no process keeps a state of it."""
    digest = hashlib.blake2b("|".join(map(str, what)).encode(), digest_size=8).digest()
    return (int.from_bytes(digest, "big") >> 11) / (1 << 53)
