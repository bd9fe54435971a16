"""Data sets, by the program itself."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from typing import Any, Sequence

from .errors import CamrigError, CamrigTimeout, error_of_command

#: A recording that is asked to end completes its labels first.
_FINISH_TIMEOUT_S = 60.0


def record(program: str, control: str, token: str | None, options: Sequence[str], timeout: float | None) -> dict[str, Any]:
    """Runs `camrig record`, of that program, at the rig with that control socket (a path, or HOST:PORT); gives what it prints. One that takes longer than
    `timeout` seconds, or is interrupted, is asked to end: what is there then is a data set, and the world goes on."""
    with tempfile.NamedTemporaryFile("w", prefix="camrig-token-") as token_file:  # readable by its owner only
        command = [program, "record", "--control", control, "--json", *options]
        if token:
            token_file.write(token)
            token_file.flush()
            command += ["--token-file", token_file.name]
        try:
            child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        except OSError as problem:
            raise CamrigError("unavailable", f"cannot run {command[0]}: {problem.strerror}") from problem
        with child:
            try:
                out, err = child.communicate(timeout=timeout)
            except subprocess.TimeoutExpired:
                _finish(child)
                raise CamrigTimeout("unavailable", f"record: not done within {timeout} s; what is there is a data set") from None
            except BaseException:
                _finish(child)
                raise
    if child.returncode != 0:
        kind = "invalid_argument" if child.returncode == 2 else "unavailable"
        raise error_of_command(err, CamrigError(kind, f"record: exit code {child.returncode}"))
    return json.loads(out)


def record_options(
    folder: str | os.PathLike[str],
    cameras: Sequence[str],
    *,
    seconds: float | None,
    frames: int | None,
    format: str,
    depth: str | None,
    flow: bool,
    masks: bool,
    soiling: bool,
    yolo: bool,
) -> list[str]:
    """The command line of it."""
    options = [os.fspath(folder), "--format", format]
    if cameras:
        options += ["--cameras", ",".join(cameras)]
    for option, value in (("--seconds", seconds), ("--frames", frames), ("--depth", depth)):
        if value is not None:
            options += [option, str(value)]
    return options + [option for option, is_wanted in (("--flow", flow), ("--masks", masks), ("--soiling", soiling), ("--yolo", yolo)) if is_wanted]


def _finish(child: subprocess.Popen[str]) -> None:
    child.terminate()
    try:
        child.communicate(timeout=_FINISH_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        child.kill()
