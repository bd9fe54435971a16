"""How far a run is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import collections
import sys
import time
from typing import TextIO

_WIDTH = 30
_LINE_EVERY_S = 30.0
#: The rate is that of so much of the past.
_WINDOW_S = 120.0


class Progress:
    def __init__(self, shards: int, done: int, out: TextIO = sys.stderr) -> None:
        self._shards, self._out = shards, out
        self._is_bar = out.isatty()
        self._begin_s = self._last_s = time.monotonic()
        self._past: collections.deque[tuple[float, int, int]] = collections.deque([(self._begin_s, done, 0)])

    def show(self, done: int, frames: int, failed: int, is_last: bool = False) -> None:
        """done: shards that are there; frames: drawn in this run."""
        now_s = time.monotonic()
        self._past.append((now_s, done, frames))
        while len(self._past) > 2 and self._past[0][0] < now_s - _WINDOW_S:
            self._past.popleft()
        if not is_last and now_s - self._last_s < (0.2 if self._is_bar else _LINE_EVERY_S):
            return
        self._last_s = now_s
        text = line(self._shards, done, frames, failed, self._past)
        full = _WIDTH * done // max(1, self._shards)
        if self._is_bar:
            self._out.write(f"\r[{'#' * full}{'.' * (_WIDTH - full)}] {text}\x1b[K" + ("\n" if is_last else ""))
        else:
            self._out.write(text + "\n")
        self._out.flush()


def line(shards: int, done: int, frames: int, failed: int, past: collections.deque[tuple[float, int, int]]) -> str:
    first_s, first_done, first_frames = past[0]
    seconds = max(1e-6, past[-1][0] - first_s)
    text = f"{100 * done // max(1, shards):3} %  {done}/{shards} shards  {frames} frames, {(frames - first_frames) / seconds:.1f}/s"
    if failed:
        text += f"  {failed} failed"
    if (shards_a_second := (done - first_done) / seconds) > 0 and done < shards:
        text += f"  {duration((shards - done - failed) / shards_a_second)} left"
    return text


def duration(seconds: float) -> str:
    minutes, second = divmod(max(0, round(seconds)), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours} h {minute:02} min" if hours else f"{minute} min {second:02} s" if minute else f"{second} s"
