"""Starting a rig of one's own."""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
import tempfile
import time
import weakref
from pathlib import Path
from typing import Any, Mapping, Sequence

from .client import Client
from .errors import CamrigError, CamrigTimeout
from .places import find_binary, find_scene
from .rig import Rig
from .token_file import read_token
from .transport import MAX_WAIT_S, unix_connector


_MAX_LOG_CHARS = 8000
_READY_EXIT_TIMEOUT_S = 5.0


def _stop_timeout_s() -> float:
    """How long a rig may take to end; programs built with a sanitizer need longer."""
    return float(os.environ.get("CAMRIG_STOP_TIMEOUT_S", "5"))


def start(
    scene: str | os.PathLike[str],
    *,
    mode: str | None = None,
    device: int | str | None = None,
    seed: int | None = None,
    overload: str | None = None,
    quality: str | None = None,
    http: int = 0,
    rtsp: int = 0,
    tcp: int | None = None,
    token_file: str | os.PathLike[str] | None = None,
    binary: str | os.PathLike[str] | None = None,
    args: Sequence[str] = (),
    env: Mapping[str, str] | None = None,
    runner: Sequence[str] = (),
    timeout: float = 60.0,
) -> Rig:
    """Starts `camrig serve SCENE` with a private control socket and free ports, and waits until it is ready.

    mode (realtime, lockstep), device (EGL device number, "cpu", or "llvmpipe": Mesa's rasteriser), seed, overload (drop, slow), quality (fast, simple,
    beautiful), http, rtsp, tcp (ports; 0: any free one), token_file (a file with the token that clients show; the rig's URLs have it) are the options of
    that command; ``args`` are further ones. ``env`` adds to the environment; ``runner`` are words to put before the command, as of setpriv or taskset. The
    rig ends with close(), with the context manager, or with this Python program. close() raises CamrigError when the rig has not ended as it should: with
    exit code 0, within 5 s ($CAMRIG_STOP_TIMEOUT_S).
    """
    token = read_token(token_file) if token_file is not None else None
    program = os.fspath(binary) if binary is not None else find_binary()
    command = [program, "serve", find_scene(scene, program)]
    command += ["--http", str(http), "--rtsp", str(rtsp)]
    for option, value in (("mode", mode), ("device", device), ("seed", seed), ("overload", overload), ("quality", quality), ("tcp", tcp), ("token-file", token_file)):
        if value is not None:
            command += [f"--{option}", str(value)]
    process = _Process(command, list(args), env, runner)
    try:
        ready = process.wait_ready(timeout)
        ports = {service: int(ready[service]) for service in ("http", "rtsp") if ready.get(service)}
        host = ready.get("host", "127.0.0.1")
        return Rig(
            Client(unix_connector(process.control)),
            control=process.control,
            host="127.0.0.1" if host in ("0.0.0.0", "::") else host,
            token=token,
            ports=ports,
            owner=process,
            program=program,
        )
    except BaseException:
        process.discard()
        raise


class _Process:
    """The daemon as our child: with a directory for its socket and log, both gone when it is."""

    def __init__(self, command: list[str], args: list[str], env: Mapping[str, str] | None, runner: Sequence[str]) -> None:
        directory = tempfile.mkdtemp(prefix="camrig-")
        if len(directory) > 80:  # a Unix socket's path has at most 107 bytes
            os.rmdir(directory)
            directory = tempfile.mkdtemp(prefix="camrig-", dir="/tmp")
        self.control = os.path.join(directory, "control.sock")
        self._log_path = os.path.join(directory, "log")
        self._final_log: str | None = None
        self._ready_fd, child_fd = os.pipe()
        command = [*runner, *command, "--control", self.control, "--ready-fd", str(child_fd), *args]
        try:
            # A file, not a pipe: nobody has to read it for the daemon to go on.
            with open(self._log_path, "wb") as log:
                self._child = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    pass_fds=(child_fd,),
                    env={**os.environ, **(env or {})},
                )
        except OSError as problem:
            os.close(self._ready_fd)
            shutil.rmtree(directory, ignore_errors=True)
            raise CamrigError("unavailable", f"cannot run {command[0]}: {problem.strerror}") from problem
        finally:
            os.close(child_fd)
        # Runs once: at discard(), when nobody holds the rig any more, or at the end of the program; stop() takes its place.
        self._finalizer = weakref.finalize(self, _discard, self._child, directory, os.getpid())

    @property
    def log(self) -> str:
        if self._final_log is not None:
            return self._final_log
        try:
            text = Path(self._log_path).read_bytes()[-4 * _MAX_LOG_CHARS :].decode("utf-8", "replace")
        except OSError:
            return ""
        return text[-_MAX_LOG_CHARS:]

    def wait_ready(self, timeout_s: float) -> dict[str, Any]:
        """The line that the daemon writes when it serves."""
        deadline = time.monotonic() + timeout_s
        line = b""
        poller = select.poll()
        poller.register(self._ready_fd, select.POLLIN)
        try:
            while not line.endswith(b"\n"):
                left_ms = int(min(deadline - time.monotonic(), MAX_WAIT_S) * 1000)
                if left_ms <= 0 or not poller.poll(left_ms):
                    raise CamrigTimeout("unavailable", self._failure(f"was not ready within {timeout_s:g} s"))
                chunk = os.read(self._ready_fd, 4096)
                if not chunk:  # the daemon ended, or closed its end without a word
                    raise CamrigError("unavailable", self._failure(self._exit_text()))
                line += chunk
        finally:
            os.close(self._ready_fd)
        try:
            ready = json.loads(line)
        except ValueError:
            ready = None
        if not isinstance(ready, dict):
            raise CamrigError("internal", self._failure(f"said {line[:200]!r} instead of being ready"))
        return ready

    def stop(self) -> None:
        """Ends the daemon, once. Raises CamrigError when it did not end as it should, or had ended before in another way."""
        end = self._finalizer.detach()
        if end is None:
            return
        _, _, (child, directory, owner_pid), _ = end
        if os.getpid() != owner_pid:  # a forked copy of us: the rig is not its own
            return
        complaint = _end(child)
        self._final_log = self.log
        shutil.rmtree(directory, ignore_errors=True)
        if complaint:
            raise CamrigError("internal", self._failure(complaint))

    def discard(self) -> None:
        """Ends the daemon, however it takes that."""
        if self._finalizer.alive:
            self._final_log = self.log
            self._finalizer()

    def _exit_text(self) -> str:
        try:
            return f"ended with exit code {self._child.wait(_READY_EXIT_TIMEOUT_S)}"
        except subprocess.TimeoutExpired:
            return "closed --ready-fd without being ready"

    def _failure(self, what: str) -> str:
        log = self.log.strip()
        return f"camrig {what}: {' '.join(self._child.args)}" + (f"\n{log}" if log else "")  # type: ignore[arg-type]


def _end(child: subprocess.Popen[bytes]) -> str | None:
    """Asks the child to end and waits until it has. What was wrong with that; None when nothing was."""
    code = child.poll()
    when = "had ended before it was stopped"
    if code is None:
        when = "ended"
        child.terminate()
        try:
            code = child.wait(_stop_timeout_s())
        except subprocess.TimeoutExpired:
            return f"did not end within {_stop_timeout_s():g} s of SIGTERM and was killed"
        finally:
            if child.returncode is None:
                child.kill()
                child.wait()
    if code == 0:
        return None
    return f"{when}, by signal {-code}" if code < 0 else f"{when}, with exit code {code}"


def _discard(child: subprocess.Popen[bytes], directory: str, owner_pid: int) -> None:
    if os.getpid() != owner_pid:  # a forked copy of us: the rig is not its own
        return
    _end(child)
    shutil.rmtree(directory, ignore_errors=True)
