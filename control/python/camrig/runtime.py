"""Where rigs and clients of one user meet, and who is at the other end (as core/base/command_key.h has it)."""

from __future__ import annotations

import contextlib
import os
import socket
import stat
import struct
import tempfile

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


def write_command_key(key: str, address: str, port: int) -> str:
    """Where command_key() finds it; the path. Who ends removes it."""
    folder, path = runtime_folder(), _key_path(address, port)
    try:
        with contextlib.suppress(FileExistsError):
            os.mkdir(folder, 0o700)
        if not _is_private(folder):
            raise CamrigError("unavailable", f"{folder}: must be a folder of this user's alone, mode 0700 (chmod 700)")
        # A new file takes the old one's place in one step: a client sees one key or the other, never half of one.
        file, temporary = tempfile.mkstemp(prefix=os.path.basename(path), dir=folder)  # mode 0600
        with os.fdopen(file, "w") as to:
            to.write(key + "\n")
        os.rename(temporary, path)
    except OSError as problem:
        raise CamrigError("unavailable", f"{path}: cannot be written: {problem.strerror}") from problem
    return path


def command_key(sock: socket.socket) -> str | None:
    """The key for commands that a rig of this user wrote for the TCP address at the other end; None: there is none.

    The whole address names the file: another user may listen on the same port of another loopback address.
    """
    address, port = sock.getpeername()[:2]
    try:
        # Believed only where nobody else could have written it.
        if not _is_private(runtime_folder()):
            return None
        file = os.open(_key_path(address, port), os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return None
    try:
        return os.read(file, _MAX_KEY_BYTES).decode("ascii", "replace").strip() or None
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
