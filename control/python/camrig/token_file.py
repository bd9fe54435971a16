"""The file with a rig's token, as ``--token-file`` takes it."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import CamrigError


def read_token(path: str | os.PathLike[str]) -> str:
    """CamrigError of kind invalid_argument names the file."""
    try:
        return Path(path).read_text().strip()
    except OSError as problem:
        raise CamrigError("invalid_argument", f"--token-file {os.fspath(path)}: {problem.strerror}") from problem
