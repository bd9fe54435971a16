"""Hashes by which shards are named, and numbers that depend on names alone."""

from __future__ import annotations

import functools
import hashlib
import json
import os
from pathlib import Path
from typing import Any

_CHUNK_BYTES = 1 << 20
#: JSON has no whole numbers beyond it that every reader keeps.
_SEED_BITS = 53


def canonical(value: Any) -> str:
    """One text for one value: keys sorted, no spaces."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def text_hash(value: Any) -> str:
    """SHA-256 of the canonical text, in hex."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def seed_of(*names: Any) -> int:
    """A counter-based seed, 0 to 2^53 - 1: the same names give the same seed, in any order of asking and on any machine."""
    return int(text_hash(list(names)), 16) >> (256 - _SEED_BITS)


def file_hash(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a file's bytes, in hex; computed once while the file stays as it is."""
    real = Path(path).resolve()
    facts = real.stat()
    return _file_hash(str(real), facts.st_size, facts.st_mtime_ns)


@functools.lru_cache(maxsize=4096)
def _file_hash(path: str, size: int, mtime_ns: int) -> str:
    made = hashlib.sha256()
    with open(path, "rb") as file:
        while chunk := file.read(_CHUNK_BYTES):
            made.update(chunk)
    return made.hexdigest()
