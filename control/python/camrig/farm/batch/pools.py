"""Who draws shards: processes of this machine. (By Ray: ray_pool.py.)"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, Protocol

#: A shard's answer, or {"error": {"kind": "lost", ..}} when the worker was killed.
Answer = dict[str, Any]
_PACKAGE = str(Path(__file__).resolve().parents[3])


class Pool(Protocol):
    """Draws the jobs that it is given; all calls come from one thread."""

    @property
    def slots(self) -> int:
        """How many jobs it can have in hand; it may grow."""

    def submit(self, name: str, job: dict[str, Any]) -> None: ...

    def finished(self, timeout_s: float) -> list[tuple[str, Answer]]:
        """Those that have come to an end, after waiting that long at most for the first."""

    def close(self) -> None:
        """Ends what is in work."""


def run_drawer(job: dict[str, Any], running: set[subprocess.Popen[bytes]] | None = None) -> Answer:
    """Draws a shard in a process of its own and waits for it; in `running` while it goes."""
    path = os.pathsep.join([_PACKAGE, *filter(None, [os.environ.get("PYTHONPATH")])])
    with tempfile.TemporaryFile() as said:
        child = subprocess.Popen([sys.executable, "-m", "camrig.farm.batch.draw"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said,
                                 start_new_session=True,  # Ctrl-C is for who hands out
                                 env={**os.environ, "PYTHONPATH": path})
        if running is not None:
            running.add(child)
        text = b""
        # One that was killed takes nothing: writing to it fails, and so does closing a pipe with what it did not take.
        with contextlib.suppress(BrokenPipeError), child:
            try:
                # stdin stays open: its end is the drawer's.
                child.stdin.write(json.dumps(job).encode() + b"\n")  # type: ignore[union-attr]
                child.stdin.flush()  # type: ignore[union-attr]
                text = child.stdout.read()  # type: ignore[union-attr]
            finally:
                if running is not None:
                    running.discard(child)
        try:
            return json.loads(text)
        except ValueError:
            said.seek(0, os.SEEK_END)
            said.seek(max(0, said.tell() - 2000))
            last = said.read().decode("utf-8", "replace").strip().splitlines()[-1:]
            code = child.returncode
            how = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
            return {"error": {"kind": "lost" if code < 0 else "shard", "text": f"its process {how}" + "".join(f": {line}" for line in last)}}


class LocalPool:
    """As many drawers at a time as there are workers."""

    def __init__(self, workers: int) -> None:
        self.slots = workers
        self._threads = ThreadPoolExecutor(workers)
        self._jobs: dict[Future[Answer], str] = {}
        self._running: set[subprocess.Popen[bytes]] = set()
        self._is_closed = threading.Event()

    def submit(self, name: str, job: dict[str, Any]) -> None:
        self._jobs[self._threads.submit(self._run, job)] = name

    def finished(self, timeout_s: float) -> list[tuple[str, Answer]]:
        done = wait(self._jobs, timeout_s, FIRST_COMPLETED).done
        return [(self._jobs.pop(one), one.result()) for one in done]

    def close(self) -> None:
        self._is_closed.set()
        for child in list(self._running):
            child.kill()
        self._threads.shutdown(cancel_futures=True)

    def _run(self, job: dict[str, Any]) -> Answer:
        if self._is_closed.is_set():
            return {"error": {"kind": "lost", "text": "the run has ended"}}
        return run_drawer(job, self._running)
