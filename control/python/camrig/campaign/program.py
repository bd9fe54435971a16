"""The program under test: what it prints, with times, and its end; and the watch that says since when it is well."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import threading
import time
from typing import Callable, Sequence

from ..errors import CamrigError
from .spec import Check

_MAX_LINE_BYTES = 4096
_MAX_OUTPUT_BYTES = 65536
_MAX_CHANGES = 1000
_STOP_TIMEOUT_S = 3.0


class Watch:
    """Whether the program is well, and when that changed. Times are of time.monotonic()."""

    def __init__(self, check: Check) -> None:
        self._well = re.compile(check.well) if check.well else None
        self._troubled = re.compile(check.troubled) if check.troubled else None
        self._every_s = check.every_s if check.command is None else None
        self._lock = threading.Lock()
        self._fresh_at: float | None = None
        #: (time, is well), the last of which holds. A program that flutters faster than anybody asks is cut short.
        self._changes: list[tuple[float, bool]] = []

    def line(self, text: str, now: float) -> None:
        if self._troubled and self._troubled.search(text):
            self.told(False, now)
        elif (self._well.search(text) if self._well else True):
            self.told(True, now)

    def told(self, is_well: bool, now: float) -> None:
        with self._lock:
            self._grow_stale(now)
            self._fresh_at = now if is_well else None
            self._set(is_well, now)

    def changes(self, now: float) -> list[tuple[float, bool]]:
        with self._lock:
            self._grow_stale(now)
            return list(self._changes)

    def _grow_stale(self, now: float) -> None:
        if self._every_s is not None and self._fresh_at is not None and now - self._fresh_at > self._every_s:
            self._set(False, self._fresh_at + self._every_s)
            self._fresh_at = None

    def _set(self, is_well: bool, now: float) -> None:
        if (not self._changes and is_well) or (self._changes and self._changes[-1][1] != is_well):
            if len(self._changes) < _MAX_CHANGES:
                self._changes.append((now, is_well))


class Program:
    """A process group of its own; as a context manager it is ended with all its children that stayed in the group."""

    def __init__(self, words: Sequence[str], watch: Watch, env: dict[str, str]) -> None:
        self._watch = watch
        self._tail = bytearray()
        try:
            self._child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=env,
                                           start_new_session=True)
        except OSError as problem:
            raise CamrigError("unavailable", f"program: cannot run {words[0]}: {problem.strerror}") from problem
        self.ended_at: float | None = None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._waiter = threading.Thread(target=self._wait, daemon=True)
        self._reader.start()
        self._waiter.start()

    def is_over(self) -> bool:
        return self.ended_at is not None

    @property
    def exit_code(self) -> int | None:
        """As subprocess has it; None while it runs."""
        return self._child.returncode if self.ended_at is not None else None

    @property
    def output(self) -> str:
        """The end of what it printed."""
        return bytes(self._tail).decode("utf-8", "replace")

    def _read(self) -> None:
        assert self._child.stdout is not None
        descriptor, line = self._child.stdout.fileno(), b""
        while chunk := os.read(descriptor, 65536):
            now = time.monotonic()
            self._tail = (self._tail + chunk)[-_MAX_OUTPUT_BYTES:]
            # Progress lines of ffmpeg and curl end with CR.
            *whole, line = (line + chunk).replace(b"\r", b"\n").split(b"\n")
            line = line[-_MAX_LINE_BYTES:]
            for one in whole:
                if one.strip():
                    self._watch.line(one[:_MAX_LINE_BYTES].decode("utf-8", "replace"), now)

    def _wait(self) -> None:
        self._child.wait()
        self.ended_at = time.monotonic()
        self._watch.told(False, self.ended_at)

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        for number in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(self._child.pid, number)
            except ProcessLookupError:
                break
            self._waiter.join(_STOP_TIMEOUT_S)
        self._waiter.join()
        self._reader.join(_STOP_TIMEOUT_S)
        assert self._child.stdout is not None
        if not self._reader.is_alive():
            self._child.stdout.close()


class Poller:
    """Runs the check's command again and again beside the program; its exit code 0 means well."""

    def __init__(self, words: Sequence[str], every_s: float, watch: Watch, env: dict[str, str]) -> None:
        self._words, self._every_s, self._watch, self._env = words, every_s, watch, env
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Poller:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        limit_s = max(self._every_s, 5.0)
        while not self._stop.is_set():
            try:
                code = subprocess.run(self._words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=self._env,
                                      timeout=limit_s).returncode
            except (OSError, subprocess.TimeoutExpired):
                code = -1
            self._watch.told(code == 0, time.monotonic())
            self._stop.wait(self._every_s)


def wait_well(watch: Watch, since: float, stays_s: float, until: float, is_over: Callable[[], bool]) -> float | None:
    """Waits until the program was well for `stays_s` without a break, not counted before `since`; gives when that began. None when it is
    over, or the time is."""
    while True:
        now = time.monotonic()
        changes = watch.changes(now)
        if changes and changes[-1][1] and now - max(changes[-1][0], since) >= stays_s:
            return max(changes[-1][0], since)
        if is_over() or now >= until:
            return None
        time.sleep(0.01)
