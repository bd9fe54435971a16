"""Data sets, by the program itself."""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any, Sequence

from .errors import CamrigError, CamrigTimeout
from .places import find_binary


def record(
    control: str,
    folder: str | os.PathLike[str],
    cameras: Sequence[str],
    seconds: float | None,
    frames: int | None,
    format: str,
    timeout: float | None,
) -> dict[str, Any]:
    """Runs `camrig record` at a rig on this machine; gives what it prints."""
    command = [find_binary(), "record", os.fspath(folder), "--control", control, "--format", format, "--json"]
    if cameras:
        command += ["--cameras", ",".join(cameras)]
    for option, value in (("--seconds", seconds), ("--frames", frames)):
        if value is not None:
            command += [option, str(value)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        raise CamrigTimeout("unavailable", f"record: not done within {timeout} s; what is there is a data set") from None
    except OSError as problem:
        raise CamrigError("unavailable", f"cannot run {command[0]}: {problem.strerror}") from problem
    if done.returncode != 0:
        kind = "invalid_argument" if done.returncode == 2 else "unavailable"
        raise CamrigError(kind, done.stderr.strip().removeprefix("camrig: ") or f"record: exit code {done.returncode}")
    return json.loads(done.stdout)
