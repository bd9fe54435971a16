"""The programs beside the daemon: the renderer alone, to host memory, and the kernels. Left out where they are not built."""

from __future__ import annotations

import json
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from . import REPOSITORY
from .runs import HALL, PLACES


def built(name: str) -> Path | None:
    """The newest build of a program that is not installed, or None."""
    found = [path for path in (REPOSITORY / "build").glob(f"*/**/{name}") if path.is_file() and os.access(path, os.X_OK)]
    return max(found, key=lambda path: path.stat().st_mtime, default=None)


@dataclass
class ToMemory:
    """Pictures drawn and read into host memory by the renderer alone: no JPEG, no network, no clock."""

    per_second: float
    cpu_ms: float


def to_memory(cameras: int, size: tuple[int, int], frames: int, *, moving: bool = False, quality: str = "simple", layers: bool = True,
              device: str = "cpu", scene: str = HALL, view: str = "+".join(PLACES), threads: int | None = None) -> ToMemory | None:
    program = built("render_scene")
    if program is None:
        return None
    text = subprocess.run(
        [program, scene, view, os.devnull, "--size", f"{size[0]}x{size[1]}", "--bench", str(frames), "--cameras", str(cameras),
         "--device", device, "--moving", "on" if moving else "off", "--quality", quality, "--static-layer", "on" if layers else "off",
         *(["--threads", str(threads)] if threads else [])],
        capture_output=True, text=True, check=True, cwd=REPOSITORY,
    ).stdout
    numbers = re.search(r"\(([\d.]+)/s\), CPU ([\d.]+) ms", text)
    return ToMemory(float(numbers[1]), float(numbers[2]))  # type: ignore[index]


def kernels(seconds: float) -> list[dict] | None:
    """Rows of Google Benchmark: name, real_time, cpu_time, time_unit, items_per_second, ..."""
    program = built("camrig_kernels")
    if program is None:
        return None
    text = subprocess.run([program, "--benchmark_format=json", f"--benchmark_min_time={seconds}"], capture_output=True, text=True, check=True, cwd=REPOSITORY).stdout
    return json.loads(text)["benchmarks"]
