"""The programs beside the daemon: the renderer alone, to host memory, and the kernels. Left out where they are not built."""

from __future__ import annotations

import json
import os
import re
import statistics
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from . import REPOSITORY
from .plan import VGA
from .runs import HALL, PLACES

TURNS = 3
Case = TypeVar("Case")


def built(name: str) -> Path | None:
    """The newest build of a program that is not installed, or None."""
    found = [path for path in (REPOSITORY / "build").glob(f"*/**/{name}") if path.is_file() and os.access(path, os.X_OK)]
    return max(found, key=lambda path: path.stat().st_mtime, default=None)


@dataclass(frozen=True)
class ToMemory:
    """Pictures drawn and read into host memory by the renderer alone: no JPEG, no network, no clock."""

    cameras: int
    size: tuple[int, int] = VGA
    moving: bool = False
    quality: str = "simple"
    antialias: str = "none"
    layers: bool = True
    device: str = "cpu"
    scene: str = HALL
    view: str = "+".join(PLACES)
    threads: int | None = None


class Values:
    """Of one thing, a value for each time that it was measured; printed as the median with (lowest..highest)."""

    def __init__(self, values: list[float]) -> None:
        self.values = values

    @property
    def median(self) -> float:
        return statistics.median(self.values)

    def __format__(self, spec: str) -> str:
        return f"{self.median:{spec}} ({min(self.values):{spec}}..{max(self.values):{spec}})"


@dataclass
class Drawn:
    per_second: Values
    cpu_ms: Values


def in_turns(cases: dict[Case, ToMemory], seconds: float, beside: Callable[[int], None] = lambda turn: None) -> dict[Case, Drawn] | None:
    """Each case for about so long in each turn, one case after the other. `beside`: what they are compared with; it is called before each turn, with its number."""
    program = built("render_scene")
    frames = {case: max(3, round(seconds * _draw(program, what, 8)[0] / what.cameras)) for case, what in cases.items()} if program else {}
    got: dict[Case, list[tuple[float, float]]] = {case: [] for case in cases}
    for turn in range(TURNS):
        beside(turn)
        for case in frames:
            got[case].append(_draw(program, cases[case], frames[case]))
    if program is None:
        return None
    return {case: Drawn(Values([per_second for per_second, _ in values]), Values([cpu_ms for _, cpu_ms in values])) for case, values in got.items()}


def _draw(program: Path, what: ToMemory, frames: int) -> tuple[float, float]:
    """Pictures a second, and CPU milliseconds a picture."""
    text = subprocess.run(
        [program, what.scene, what.view, os.devnull, "--size", f"{what.size[0]}x{what.size[1]}", "--bench", str(frames), "--cameras", str(what.cameras),
         "--device", what.device, "--moving", "on" if what.moving else "off", "--quality", what.quality, "--antialias", what.antialias, "--static-layer", "on" if what.layers else "off",
         *(["--threads", str(what.threads)] if what.threads else [])],
        capture_output=True, text=True, check=True, cwd=REPOSITORY,
    ).stdout
    numbers = re.search(r"\(([\d.]+)/s\), CPU ([\d.]+) ms", text)
    return float(numbers[1]), float(numbers[2])  # type: ignore[index]


def kernels(seconds: float) -> list[dict] | None:
    """Rows of Google Benchmark: name, real_time, cpu_time, time_unit, items_per_second, ..."""
    program = built("camrig_kernels")
    if program is None:
        return None
    text = subprocess.run([program, "--benchmark_format=json", f"--benchmark_min_time={seconds}"], capture_output=True, text=True, check=True, cwd=REPOSITORY).stdout
    return json.loads(text)["benchmarks"]
