"""Where rigs and clients of one user meet, and who is at the other end (as core/base/command_key.h has it)."""

from __future__ import annotations

import contextlib
import fcntl
import os
import socket
import stat
import struct
import tempfile
from collections.abc import Iterator

from .errors import CamrigError

_MAX_KEY_BYTES = 256


def runtime_folder() -> str:
    """$XDG_RUNTIME_DIR/camrig, else /tmp/camrig-UID."""
    if directory := os.environ.get("XDG_RUNTIME_DIR"):
        return os.path.join(directory, "camrig")
    return f"/tmp/camrig-{os.getuid()}"


def _is_private(path: str) -> bool:
    folder = os.lstat(path)
    return stat.S_ISDIR(folder.st_mode) and folder.st_uid == os.geteuid() and not folder.st_mode & 0o077


def _key_path(address: str, port: int) -> str:
    return os.path.join(runtime_folder(), f"[{address}]:{port}.key" if ":" in address else f"{address}:{port}.key")


class CommandKeyFile:
    """A key's file until close(); locked meanwhile, so that what a process that was killed left is not believed and goes.

    Raises CamrigError where it cannot be written.
    """

    def __init__(self, key: str, address: str, port: int) -> None:
        folder, self.path = runtime_folder(), _key_path(address, port)
        try:
            with contextlib.suppress(FileExistsError):
                os.mkdir(folder, 0o700)
            if not _is_private(folder):
                raise CamrigError("unavailable", f"{folder}: must be a folder of this user's alone, mode 0700 (chmod 700)")
            with _one_at_a_time(folder):
                _remove_left_keys(folder)
                # A new file takes the old one's place in one step: a client sees one key or the other, never half of one.
                file, temporary = tempfile.mkstemp(prefix=os.path.basename(self.path), dir=folder)  # mode 0600
                self._file = os.fdopen(file, "w")
                self._file.write(key + "\n")
                self._file.flush()
                _lock(file, fcntl.LOCK_EX)
                os.rename(temporary, self.path)
        except OSError as problem:
            raise CamrigError("unavailable", f"{self.path}: cannot be written: {problem.strerror}") from problem

    def close(self) -> None:
        with contextlib.suppress(OSError):
            os.unlink(self.path)
        self._file.close()


def command_key(sock: socket.socket) -> str | None:
    """The key for commands that a rig of this user wrote for the TCP address at the other end; None: there is none.

    The whole address names the file: another user may listen on the same port of another loopback address. Believed only where nobody
    else could have written it, and while the rig lives that did.
    """
    address, port = sock.getpeername()[:2]
    try:
        if not _is_private(runtime_folder()):
            return None
        file = _open_key(_key_path(address, port))
    except OSError:
        return None
    try:
        return os.read(file, _MAX_KEY_BYTES).decode("ascii", "replace").strip() or None if is_held(file) else None
    finally:
        os.close(file)


def _open_key(path: str) -> int:
    return os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)


def _lock(file: int, how: int) -> bool:
    """flock(2); False: another process has it, or the file system knows no locks."""
    try:
        fcntl.flock(file, how)
    except OSError:
        return False
    return True


def is_held(file: int) -> bool:
    """Whether the process lives that locked this open file for its life. Where the file system knows no locks it is believed to."""
    return not _lock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)


@contextlib.contextmanager
def _one_at_a_time(folder: str) -> Iterator[None]:
    """Else a key that is just written could be taken for one that was left."""
    file = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        _lock(file, fcntl.LOCK_EX)
        yield
    finally:
        os.close(file)


def _remove_left_keys(folder: str) -> None:
    for name in os.listdir(folder):
        if name.endswith(".key"):
            path = os.path.join(folder, name)
            with contextlib.suppress(OSError):
                file = _open_key(path)
                try:
                    if not is_held(file):
                        os.unlink(path)
                finally:
                    os.close(file)


def check_server(sock: socket.socket, path: str) -> None:
    """Raises CamrigError when the Unix socket is served by a stranger: below /tmp anybody may have made it first.

    Trusted are this user, root, and the owner of the socket's folder where nobody else can put anything into it.
    """
    _, user, _ = struct.unpack("3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i")))
    folder = os.stat(os.path.dirname(path) or ".")
    if user not in (os.geteuid(), 0) and (user != folder.st_uid or folder.st_mode & 0o022):
        raise CamrigError(
            "unauthorized",
            f"{path}: is served by user {user}, not by user {os.geteuid()}: nothing was sent; to command a rig of that user, be that user "
            "(or use its TCP port and token)",
        )
