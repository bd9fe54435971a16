"""What the RTSP tests share: the documented example client, and ways to run stock programs."""

import importlib.util
import itertools
import subprocess
import sys
import threading

from conftest import REPOSITORY

_spec = importlib.util.spec_from_file_location("rtsp_times", REPOSITORY / "docs/examples/rtsp_times.py")
rtsp_times = importlib.util.module_from_spec(_spec)
sys.modules["rtsp_times"] = rtsp_times
_spec.loader.exec_module(rtsp_times)
RtspReader = rtsp_times.RtspReader


def run(*command, timeout=90, **options):
    return subprocess.run(command, capture_output=True, timeout=timeout, check=False, **options)


def take(reader: "RtspReader", count: int) -> list:
    """The next pictures of a reader; fewer if the stream ends."""
    return list(itertools.islice(reader.pictures(), count))


def read_aside(url: str, count: int = 10**9) -> tuple:
    """A thread that takes pictures, the list it fills, and its reader."""
    reader, pictures = RtspReader(url), []

    def read():
        for picture in itertools.islice(reader.pictures(), count):
            pictures.append(picture)

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread, pictures, reader


def strictly_rising(values) -> bool:
    return all(a < b for a, b in zip(values, values[1:]))


def unwrapped(stamps: list[int]) -> list[int]:
    """RTP stamps without the wrap at 2^32."""
    out = stamps[:1]
    for stamp in stamps[1:]:
        out.append(out[-1] + ((stamp - out[-1] + (1 << 31)) % (1 << 32)) - (1 << 31))
    return out
