"""MJPEG readers that cost little: many streams on one thread, pictures counted and stamped but not decoded."""

from __future__ import annotations

import selectors
import socket
import threading
import time
from dataclasses import dataclass, field

_MAX_HEADER_BYTES = 16384
#: Longer than a picture takes to a reader, also where few are made.
ON_ITS_WAY_S = 5.0


@dataclass
class Stream:
    """What one reader saw."""

    camera: str
    pictures: int = 0
    bytes: int = 0
    gaps: int = 0  # frames of close_books() that never came
    latencies_ms: list[float] = field(default_factory=list)
    sequences: list[int] = field(default_factory=list)
    last_sequence: int | None = None
    until: int | None = None  # later frames are not counted any more

    def close_books(self, after: int, until: int) -> None:
        """Of the frames with these numbers, the first excluded and the last included: what came of them, and what did not."""
        self.until = until
        without_latency = len(self.sequences) - len(self.latencies_ms)
        self.latencies_ms = [ms for sequence, ms in zip(self.sequences[without_latency:], self.latencies_ms) if after < sequence <= until]
        self.pictures = sum(after < sequence <= until for sequence in self.sequences)
        self.gaps = until - after - self.pictures


class _Reader:
    """Takes a multipart stream apart as the bytes come: header, then so many bytes of body, then the next header."""

    def __init__(self, stream: Stream, address: tuple[str, int]) -> None:
        self.stream = stream
        self.socket = socket.create_connection(address, timeout=10)
        self.socket.sendall(f"GET /cameras/{stream.camera}/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        self.socket.setblocking(False)
        self._header = bytearray()
        self._body_left = 0
        self._stamps: tuple[int, int] | None = None

    def take(self, data: memoryview) -> None:
        at = 0
        while at < len(data):
            if self._body_left:
                used = min(self._body_left, len(data) - at)
                self._body_left -= used
                at += used
                if not self._body_left:
                    self._finish_picture()
                continue
            # Headers are short; searching them byte by byte would cost more than the copy.
            old = len(self._header)
            self._header += data[at : at + _MAX_HEADER_BYTES]
            end = self._header.find(b"\r\n\r\n", max(0, old - 3))
            if end < 0:
                if len(self._header) > _MAX_HEADER_BYTES:
                    raise RuntimeError(f"{self.stream.camera}: no end of the header")
                at += len(self._header) - old
                continue
            at += end + 4 - old
            self._read_header(bytes(self._header[:end]).decode("latin-1"))
            self._header.clear()

    def _read_header(self, text: str) -> None:
        fields = dict(line.lower().split(": ", 1) for line in text.split("\r\n") if ": " in line)
        if "x-sequence" in fields:
            self._body_left = int(fields["content-length"])
            self.stream.bytes += self._body_left
            self._stamps = (int(fields["x-sequence"]), int(fields["x-monotonic-ns"]))
        elif " 200 " not in text.split("\r\n", 1)[0] and text.startswith("HTTP/"):
            raise RuntimeError(f"{self.stream.camera}: {text.splitlines()[0]}")

    def _finish_picture(self) -> None:
        sequence, monotonic_ns = self._stamps or (0, 0)
        stream = self.stream
        if stream.last_sequence is not None and sequence <= stream.last_sequence:
            return  # a repeat: keeps clients alive while nothing new comes
        if stream.until is not None and sequence > stream.until:
            stream.last_sequence = sequence
            return
        if stream.last_sequence is not None:
            # The first picture is as old as it is; those after it are on time or late.
            stream.latencies_ms.append((time.monotonic_ns() - monotonic_ns) / 1e6)
        stream.last_sequence = sequence
        stream.sequences.append(sequence)
        stream.pictures += 1


class MjpegReaders:
    """One reader per name in `cameras` (a name may come more than once), on a thread of their own until close()."""

    def __init__(self, port: int, cameras: list[str]) -> None:
        self.streams = [Stream(camera) for camera in cameras]
        self._selector = selectors.DefaultSelector()
        self._readers = [_Reader(stream, ("127.0.0.1", port)) for stream in self.streams]
        for reader in self._readers:
            self._selector.register(reader.socket, selectors.EVENT_READ, reader)
        self._stop = False
        self.failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="readers")
        self._thread.start()

    def _run(self) -> None:
        buffer = memoryview(bytearray(1 << 18))
        try:
            while not self._stop:
                for key, _ in self._selector.select(timeout=0.1):
                    count = key.data.socket.recv_into(buffer)
                    if count == 0:
                        raise RuntimeError(f"{key.data.stream.camera}: the stream ended")
                    key.data.take(buffer[:count])
        except Exception as problem:  # told to whoever closes
            self.failure = problem

    def reset(self) -> None:
        """Forgets what was seen so far: the start of a measurement."""
        for stream in self.streams:
            stream.pictures = stream.bytes = stream.gaps = 0
            stream.latencies_ms = []
            stream.sequences = []
            stream.until = None

    def close_books(self, after: dict[str, int], until: dict[str, int]) -> None:
        """Between two moments of the rig's books, by the numbers of the last frames then; waits for what is on its way."""
        deadline = time.monotonic() + ON_ITS_WAY_S
        while any((s.last_sequence or 0) < until[s.camera] for s in self.streams) and time.monotonic() < deadline:
            time.sleep(0.01)
        for stream in self.streams:
            stream.close_books(after[stream.camera], until[stream.camera])

    def close(self) -> list[Stream]:
        self._stop = True
        self._thread.join()
        for reader in self._readers:
            reader.socket.close()
        if self.failure:
            raise self.failure
        return self.streams

    def __enter__(self) -> "MjpegReaders":
        return self

    def __exit__(self, *_: object) -> None:
        if not self._stop:
            self._stop = True
            self._thread.join()
