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
from .rig import Rig
from .transport import unix_connector


def _find_checkout() -> Path | None:
    """The source checkout, when the package is used from one (control/python/camrig/launch.py)."""
    root = Path(__file__).resolve().parents[3]
    return root if (root / "control" / "python" / "pyproject.toml").is_file() else None


_CHECKOUT = _find_checkout()
_MAX_LOG_CHARS = 8000
_STOP_TIMEOUT_S = 5.0


def find_binary() -> str:
    """The camrig program: $CAMRIG_BIN, else one in $PATH, else the one built in this source checkout."""
    if path := os.environ.get("CAMRIG_BIN"):
        return path
    if path := shutil.which("camrig"):
        return path
    places = "neither in $CAMRIG_BIN nor in $PATH"
    if _CHECKOUT is not None:
        for preset in ("dev", "run", "ci"):
            candidate = _CHECKOUT / "build" / preset / "tools" / "camrig" / "camrig"
            if candidate.is_file():
                return str(candidate)
        places += f" nor built in {_CHECKOUT}"
    raise CamrigError("unavailable", f"no camrig program: {places}; build it with tools/run and set CAMRIG_BIN")


def find_scene(scene: str | os.PathLike[str]) -> str:
    """The file as given, else the one of that name in the source checkout ("scenes/minimal.json" works from anywhere).

    The name of a shipped scene ("hall") stays as it is: the program knows them, installed and in a checkout.
    """
    path = Path(scene)
    if not path.exists() and not path.is_absolute() and _CHECKOUT is not None and (_CHECKOUT / path).exists():
        return str(_CHECKOUT / path)
    return str(path)


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
    binary: str | os.PathLike[str] | None = None,
    args: Sequence[str] = (),
    env: Mapping[str, str] | None = None,
    timeout: float = 60.0,
) -> Rig:
    """Starts `camrig serve SCENE` with a private control socket and free ports, and waits until it is ready.

    mode (realtime, lockstep), device (EGL device number, "cpu", or "llvmpipe": all by Mesa's rasteriser), seed, overload (drop, slow), quality (fast, simple,
    beautiful), http, rtsp, tcp (ports; 0: any free one) are the options of that command; ``args`` are further ones. ``env`` adds
    to the environment. The rig ends with close(), with the context manager, or with this Python program.
    """
    command = [os.fspath(binary) if binary is not None else find_binary(), "serve", find_scene(scene)]
    command += ["--http", str(http), "--rtsp", str(rtsp)]
    for option, value in (("mode", mode), ("device", device), ("seed", seed), ("overload", overload), ("quality", quality), ("tcp", tcp)):
        if value is not None:
            command += [f"--{option}", str(value)]
    process = _Process(command, list(args), env)
    try:
        ready = process.wait_ready(timeout)
        ports = {service: int(ready[service]) for service in ("http", "rtsp") if ready.get(service)}
        host = ready.get("host", "127.0.0.1")
        return Rig(
            Client(unix_connector(process.control)),
            host="127.0.0.1" if host in ("0.0.0.0", "::") else host,
            ports=ports,
            owner=process,
        )
    except BaseException:
        process.stop()
        raise


class _Process:
    """The daemon as our child: with a directory for its socket and log, both gone when it is."""

    def __init__(self, command: list[str], args: list[str], env: Mapping[str, str] | None) -> None:
        directory = tempfile.mkdtemp(prefix="camrig-")
        if len(directory) > 80:  # a Unix socket's path has at most 107 bytes
            os.rmdir(directory)
            directory = tempfile.mkdtemp(prefix="camrig-", dir="/tmp")
        self.control = os.path.join(directory, "control.sock")
        self._log_path = os.path.join(directory, "log")
        self._final_log: str | None = None
        self._ready_fd, child_fd = os.pipe()
        command = [*command, "--control", self.control, "--ready-fd", str(child_fd), *args]
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
        # Runs once: at stop(), when nobody holds the rig any more, or at the end of the program.
        self._finalizer = weakref.finalize(self, _end, self._child, directory, os.getpid())

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
                left_ms = int((deadline - time.monotonic()) * 1000)
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
        if self._finalizer.alive:
            self._final_log = self.log
            self._finalizer()

    def _exit_text(self) -> str:
        try:
            return f"ended with exit code {self._child.wait(_STOP_TIMEOUT_S)}"
        except subprocess.TimeoutExpired:
            return "closed --ready-fd without being ready"

    def _failure(self, what: str) -> str:
        log = self.log.strip()
        return f"camrig {what}: {' '.join(self._child.args)}" + (f"\n{log}" if log else "")  # type: ignore[arg-type]


def _end(child: subprocess.Popen[bytes], directory: str, pid: int) -> None:
    if os.getpid() != pid:  # a forked copy of us: the rig is not its own
        return
    if child.poll() is None:
        child.terminate()
        try:
            child.wait(_STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
    shutil.rmtree(directory, ignore_errors=True)
