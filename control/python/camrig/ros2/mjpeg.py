"""The pictures of one camera as the rig's MJPEG stream sends them, byte for byte."""

from __future__ import annotations

import http.client
import json
import socket
import threading
from dataclasses import dataclass
from typing import Callable
from urllib.parse import urljoin, urlsplit

from ..errors import CamrigError

#: A stream repeats its last picture every 2 s; silence for longer means that the rig is gone.
_TIMEOUT_S = 20.0
_MAX_LINE = 4096
_MAX_PICTURE = 256 << 20


@dataclass(frozen=True)
class Frame:
    camera: str
    sequence: int
    world_ns: int
    monotonic_ns: int
    jpeg: bytes


class MjpegStream:
    """One open stream. One thread reads; any may close it."""

    def __init__(self, camera: str, url: str) -> None:
        self._camera = camera
        self._ask(url)
        if self._response.status == 307:  # a farm's door names the camera's node; its token, where it has one, is in that URL already
            self._connection.close()
            self._ask(urljoin(url, self._response.headers.get("Location", "")))
        if self._response.status != 200:
            body = self._response.read(_MAX_LINE)
            self._connection.close()
            raise _refusal(camera, self._response.status, body)
        self._socket = self._connection.sock or self._response.fp.raw._sock  # type: ignore[union-attr]

    def _ask(self, url: str) -> None:
        try:
            parts = urlsplit(url)
            if parts.scheme != "http":
                raise ValueError(f"it is sent to a URL of {parts.scheme}")
            self._connection = http.client.HTTPConnection(parts.hostname or "", parts.port, timeout=_TIMEOUT_S)
        except (ValueError, http.client.HTTPException) as problem:
            raise CamrigError("unavailable", f"camera {self._camera}: no stream: {problem}") from problem
        try:
            self._connection.request("GET", f"{parts.path}?{parts.query}" if parts.query else parts.path)
            self._response = self._connection.getresponse()
        except (OSError, ValueError, http.client.HTTPException) as problem:
            self._connection.close()
            raise CamrigError("unavailable", f"camera {self._camera}: no stream: {problem}") from problem

    def next(self) -> Frame | None:
        """The next part, or None when the stream has ended (camera deleted or of a new size, rig gone, closed)."""
        try:
            return self._next()
        except (OSError, ValueError, http.client.HTTPException):
            return None

    def close(self) -> None:
        """Wakes up a reader too."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._connection.close()

    def _next(self) -> Frame | None:
        fields: dict[str, str] = {}
        line = self._line()
        while line == b"":  # between parts
            line = self._line()
        if line is None or not line.startswith(b"--") or line.endswith(b"--"):
            return None
        while line := self._line():
            name, _, value = line.decode("latin-1").partition(":")
            fields[name.lower()] = value.strip()
        if not fields:  # an empty part comes before the closing boundary
            return None
        length = int(fields["content-length"])
        if not 0 < length <= _MAX_PICTURE:
            raise ValueError("Content-Length")
        jpeg = self._response.read(length)
        if len(jpeg) != length:
            return None
        stamps = (int(fields[name]) for name in ("x-sequence", "x-world-time-ns", "x-monotonic-ns"))
        return Frame(self._camera, *stamps, jpeg)

    def _line(self) -> bytes | None:
        line = self._response.readline(_MAX_LINE)
        return line.rstrip(b"\r\n") if line.endswith(b"\n") else None


def _refusal(camera: str, status: int, body: bytes) -> CamrigError:
    try:
        error = json.loads(body)["error"]
        return CamrigError(error["kind"], f"camera {camera}: {error['message']}")
    except (ValueError, KeyError, TypeError):
        return CamrigError("unavailable", f"camera {camera}: the rig answered HTTP {status} to a request for its stream")


class StreamReader:
    """Reads a stream in a thread of its own and hands each new frame to `sink`; pictures sent again are left out."""

    def __init__(self, camera: str, url: str, after_ns: int, sink: Callable[[Frame], None], ended: Callable[[str], None]) -> None:
        """Frames that show `after_ns` or earlier are left out. `ended` is called once, from the thread, with the camera's name."""
        self._stream = MjpegStream(camera, url)
        self._after_ns, self._sink, self._ended = after_ns, sink, ended
        self._thread = threading.Thread(target=self._run, args=(camera,), name=f"mjpeg {camera}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stream.close()
        self._thread.join()

    def _run(self, camera: str) -> None:
        last = -1
        while (frame := self._stream.next()) is not None:
            if frame.sequence > last and frame.world_ns > self._after_ns:
                self._sink(frame)
            last = max(last, frame.sequence)
        self._ended(camera)
