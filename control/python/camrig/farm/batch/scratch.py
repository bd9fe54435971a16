"""A folder for what is on its way into a shard."""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import Iterator

from ..own_folder import OwnFolder


@contextlib.contextmanager
def scratch() -> Iterator[Path]:
    """A folder of its own, gone at the end; temporary files of this process go into it meanwhile."""
    folder = OwnFolder("camrig-drawer-")
    before, tempfile.tempdir = tempfile.tempdir, str(folder.path)
    try:
        yield folder.path
    finally:
        tempfile.tempdir = before
        folder.close()
