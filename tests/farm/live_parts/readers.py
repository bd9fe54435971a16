"""Readers of a farm's cameras, as its users have them: MJPEG over HTTP, and the farm is asked for the address again when that ends. Who sees
nothing new for a second is taken elsewhere if the farm says that the camera is elsewhere; a standing world alone ends no connection."""

from __future__ import annotations

import contextlib
import http.client
import socket
import threading
import time
from dataclasses import dataclass
from urllib.parse import urlsplit

import camrig

PATIENCE_S = 1.0
_RETRY_S, _LOOK_S, _CONNECT_S = 0.05, 0.2, 1.0


@dataclass(frozen=True)
class Seen:
    came: float  #: time.monotonic()
    sequence: int
    world_ns: int
    node: str
    connection: int  #: the how manieth of this reader


class Reader:
    def __init__(self, control: str, camera: str) -> None:
        self.camera = camera
        self.seen: list[Seen] = []
        self.connections = 0
        self.node = ""
        self.newest_at = 0.0
        self._control = control
        self._ends = threading.Event()
        self._socket: socket.socket | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def reconnect(self) -> None:
        """To where the camera is now."""
        if taken := self._socket:
            with contextlib.suppress(OSError):
                taken.shutdown(socket.SHUT_RDWR)

    def end(self) -> None:
        self._ends.set()
        self.reconnect()
        self._thread.join(10)

    def since(self, moment: float) -> list[Seen]:
        return [one for one in list(self.seen) if one.came >= moment]

    def newest(self) -> Seen | None:
        return self.seen[-1] if self.seen else None

    def _run(self) -> None:
        rig: camrig.Rig | None = None
        while not self._ends.is_set():
            with contextlib.suppress(camrig.CamrigError, OSError, ValueError, http.client.HTTPException, StopIteration):
                rig = rig or camrig.connect(self._control)
                at = next(one for one in rig.call("farm.status")["cameras"] if one["camera"] == self.camera)
                self._read(at["node"], at["http"])
            time.sleep(_RETRY_S)

    def _read(self, node: str, url: str) -> None:
        parts = urlsplit(url)
        connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=_CONNECT_S)
        try:
            connection.request("GET", parts.path)
            self._socket = connection.sock  # the reply takes it over
            reply = connection.getresponse()
            if reply.status != 200:
                return
            self.connections += 1
            self.node, self.newest_at = node, time.monotonic()
            self._socket.settimeout(None)
            while not self._ends.is_set():
                fields: dict[str, str] = {}
                while (line := reply.readline()) not in (b"\r\n", b"\n"):
                    if not line:
                        return
                    name, _, value = line.decode().partition(":")
                    fields[name.lower()] = value.strip()
                if "content-length" not in fields:
                    continue
                reply.read(int(fields["content-length"]))
                sequence = int(fields.get("x-sequence", -1))
                if not self.seen or sequence > self.seen[-1].sequence:
                    self.newest_at = time.monotonic()
                    self.seen.append(Seen(self.newest_at, sequence, int(fields["x-world-time-ns"]), node, self.connections))
        finally:
            self._socket = None
            connection.close()


class Supervisor:
    """Asks the farm for those who see nothing new."""

    def __init__(self, control: str, readers: list[Reader]) -> None:
        self._control, self._readers = control, readers
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        rig = camrig.connect(self._control)
        while not self._ends.wait(_LOOK_S):
            stale = [reader for reader in self._readers if time.monotonic() - reader.newest_at > PATIENCE_S]
            if not stale:
                continue
            with contextlib.suppress(camrig.CamrigError):
                owners = {one["camera"]: one["node"] for one in rig.call("farm.status")["cameras"]}
                for reader in stale:
                    if reader.node != owners.get(reader.camera):
                        reader.reconnect()

    def end(self) -> None:
        self._ends.set()
        self._thread.join(10)


def longest_gap(seen: list[Seen]) -> float:
    return max((after.came - before.came for before, after in zip(seen, seen[1:])), default=0.0)


def missing(seen: list[Seen]) -> int:
    """Frames between the first and the last that did not come, by their numbers."""
    return seen[-1].sequence - seen[0].sequence + 1 - len(seen) if seen else 0
