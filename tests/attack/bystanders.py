"""Ordinary readers of one camera, which must not notice the attacks."""

from __future__ import annotations

import importlib.util
import re
import sys
import threading
import time
import urllib.request
from pathlib import Path

import camrig

_REPOSITORY = Path(__file__).resolve().parents[2]
_spec = importlib.util.spec_from_file_location("rtsp_times", _REPOSITORY / "docs" / "examples" / "rtsp_times.py")
rtsp_times = importlib.util.module_from_spec(_spec)
sys.modules["rtsp_times"] = rtsp_times
_spec.loader.exec_module(rtsp_times)


class Bystanders:
    """Two threads that read; both take the camera's sequence numbers from what they are sent."""

    def __init__(self, cam: camrig.Camera, fps: float) -> None:
        self._http = urllib.request.urlopen(cam.url("mjpeg"), timeout=60)
        self._rtsp = rtsp_times.RtspReader(cam.url("rtsp"), timeout_s=60)
        self._sequences: dict[str, list[int]] = {"MJPEG": [], "RTSP": []}
        self._fps = fps
        self._begin = self._end = 0.0
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=read, daemon=True) for read in (self._read_mjpeg, self._read_rtsp)]

    def __enter__(self) -> Bystanders:
        for thread in self._threads:
            thread.start()
        self._begin = time.monotonic()
        return self

    def __exit__(self, *_: object) -> None:
        # A single attack may be over in no time: long enough to tell a loss.
        time.sleep(max(0.0, 5.0 - (time.monotonic() - self._begin)))
        self._end = time.monotonic()
        self._ended.set()
        for thread in self._threads:
            thread.join(30)

    def losses(self) -> list[tuple[str, int, int]]:
        """(reader, frames that were due by the clock while it read, frames it did not get)."""
        expected = int((self._end - self._begin) * self._fps) - 1  # the last one may still be on its way
        return [(name, expected, max(0, expected - len(set(seen)))) for name, seen in self._sequences.items()]

    def _read_mjpeg(self) -> None:
        buffered = b""
        while not self._ended.is_set():
            chunk = self._http.read1(1 << 16)
            if not chunk:
                return
            buffered += chunk
            found = list(re.finditer(rb"X-Sequence: (\d+)\r\n", buffered))
            if found:
                self._sequences["MJPEG"] += [int(one.group(1)) for one in found]
                buffered = buffered[found[-1].end():]
            buffered = buffered[-(1 << 20):]

    def _read_rtsp(self) -> None:
        for picture in self._rtsp.pictures():
            if picture.times:
                self._sequences["RTSP"].append(picture.times.sequence)
            if self._ended.is_set():
                return
