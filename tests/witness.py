"""Tells how this machine kept programs from going on, so that a test does not take that for what it tests."""

from __future__ import annotations

import threading
import time


class Witness:
    """A thread that only sleeps, while the block runs: longest_s is how long this machine kept it from going on, at most, and total_s how long
    together, of what took a frame's time of 25 a second or more."""

    def __init__(self) -> None:
        self.longest_s = self.total_s = 0.0
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def _watch(self) -> None:
        before = time.monotonic()
        while not self._is_over.is_set():
            time.sleep(0.02)
            before, late_by_s = (now := time.monotonic()), now - before - 0.02
            self.longest_s = max(self.longest_s, late_by_s)
            self.total_s += late_by_s if late_by_s >= 0.04 else 0.0

    def __enter__(self) -> Witness:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join()
