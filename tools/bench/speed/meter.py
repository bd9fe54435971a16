"""What a process uses, from /proc, and what a rig says of itself."""

from __future__ import annotations

import os
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import camrig


@dataclass
class Use:
    cpu_s: float
    rss_mib: float
    threads: int
    fds: int


def cpu_s_of(pid: int) -> float:
    """User and system time of all threads of a process, to the nanosecond: its clock by clock_getcpuclockid(3), whose number Linux makes like this."""
    return time.clock_gettime(~pid << 3 | 2)


def use_of(pid: int) -> Use:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    status = Path(f"/proc/{pid}/status").read_text()
    rss_kb = int(re.search(r"VmRSS:\s*(\d+)", status)[1])  # type: ignore[index]
    return Use(
        cpu_s=cpu_s_of(pid),
        rss_mib=rss_kb / 1024,
        threads=int(fields[17]),
        fds=len(os.listdir(f"/proc/{pid}/fd")),
    )


def _books(stats: dict[str, Any]) -> dict[str, int]:
    """Of all cameras: frames made, frames due that were not made, frames that readers were too slow for."""
    readers = [reader for camera in stats["cameras"] for output in camera["outputs"] for reader in output["readers"]]
    return {key: sum(camera[key] for camera in stats["cameras"]) for key in ("rendered", "dropped")} | {"dropped_by_readers": sum(reader["dropped"] for reader in readers)}


def _sequences(stats: dict[str, Any]) -> dict[str, int]:
    """The number of the last frame that was due, of each camera of the scene; of all its frames one is due or idle."""
    return {camera["name"]: camera["due"] + camera["idle"] - 1 for camera in stats["cameras"]}


class Meter:
    """Between two moments of a rig: CPU seconds, wall seconds, its books."""

    def __init__(self, rig: camrig.Rig) -> None:
        self._rig = rig
        self.pid = rig.call("server.info")["pid"]
        self.restart()

    def restart(self) -> None:
        self._wall = time.monotonic()
        self._use = use_of(self.pid)
        self._stats = self._rig.call("stats.get")
        self.sequences = _sequences(self._stats)

    def read(self) -> "Reading":
        stats = self._rig.call("stats.get")
        use = use_of(self.pid)
        wall = time.monotonic() - self._wall
        now, before = _books(stats), _books(self._stats)
        return Reading(
            wall_s=wall,
            cpu_s=use.cpu_s - self._use.cpu_s,
            use=use,
            instants=stats["instants"] - self._stats["instants"],
            stages={stage["name"]: stage for stage in stats["stages"]},
            renderer=stats["renderer"],
            sequences=_sequences(stats),
            **{key: now[key] - before[key] for key in now},
        )


@dataclass
class Reading:
    wall_s: float
    cpu_s: float
    use: Use
    rendered: int
    dropped: int
    dropped_by_readers: int
    instants: int
    # Since the rig began, not since restart():
    stages: dict[str, Any]
    renderer: dict[str, int]
    sequences: dict[str, int]  # of the last frames, by camera

    @property
    def cores(self) -> float:
        return self.cpu_s / self.wall_s


def processor_seconds() -> tuple[float, float]:
    """Of all processors since the start: all time that passed, and what the host gave to others while this machine wanted it (proc(5), steal)."""
    ticks = [int(word) for word in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:]]
    per_second = os.sysconf("SC_CLK_TCK")
    return sum(ticks[:8]) / per_second, ticks[7] / per_second


def percentile(values: list[float], share: float) -> float:
    """The nearest-rank percentile; nan of nothing."""
    if not values:
        return float("nan")
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, max(0, -(-int(share * 1000) * len(ordered) // 1000) - 1))]
