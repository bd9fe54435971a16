"""Frames on their way from the threads that read streams to the one that writes the bag."""

from __future__ import annotations

import threading
from collections import deque

from .mjpeg import Frame

#: Beyond it the newest are left out; their sequence numbers will be missing.
_MAX_WAITING_BYTES = 256 << 20


class Inbox:
    """A bounded queue of frames, and the names of the cameras whose streams have ended. Any thread."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._frames: deque[Frame] = deque()
        self._bytes = 0
        self._ended: set[str] = set()

    def put(self, frame: Frame) -> None:
        with self._changed:
            if self._bytes + len(frame.jpeg) > _MAX_WAITING_BYTES:
                return
            self._frames.append(frame)
            self._bytes += len(frame.jpeg)
            self._changed.notify()

    def stream_ended(self, camera: str) -> None:
        with self._changed:
            self._ended.add(camera)
            self._changed.notify()

    def take(self, timeout_s: float) -> list[Frame]:
        """All that wait, at least one frame or one stream's end, unless time runs out."""
        with self._changed:
            self._changed.wait_for(lambda: self._frames or self._ended, timeout_s)
            frames = list(self._frames)
            self._frames.clear()
            self._bytes = 0
            return frames

    def take_ended(self) -> set[str]:
        with self._changed:
            ended, self._ended = self._ended, set()
            return ended
