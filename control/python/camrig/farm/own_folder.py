"""Temporary folders of a process. One whose process was killed is removed by the next that makes one of its kind."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
import weakref
from pathlib import Path
from typing import IO

from ..runtime import is_held


class OwnFolder:
    """A new folder below $TMPDIR until close(), or until this object or the process ends."""

    def __init__(self, prefix: str) -> None:
        parent = Path(tempfile.gettempdir())
        # Only folders with this file are ever removed: it is made here alone, first of all, and locked while its process lives.
        lock = f".{prefix.rstrip('-')}.lock"
        _sweep(parent, prefix, lock)
        self.path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
        held = open(self.path / f"{lock}.new", "wb")
        fcntl.flock(held, fcntl.LOCK_EX)
        os.rename(self.path / f"{lock}.new", self.path / lock)  # it has its name when it is locked: nobody sees it free before
        self.close = weakref.finalize(self, _remove, self.path, held)


def _remove(folder: Path, held: IO[bytes]) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    held.close()


def _sweep(parent: Path, prefix: str, lock: str) -> None:
    for folder in parent.glob(f"{prefix}*"):
        with contextlib.suppress(OSError):
            if folder.lstat().st_uid == os.geteuid() and not folder.is_symlink():
                with open(folder / lock, "rb") as file:
                    if not is_held(file.fileno()):
                        shutil.rmtree(folder, ignore_errors=True)
