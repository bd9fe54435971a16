"""What each camera of a rig costs, in cores: the rig's own CPU time, shared out by the pixels that it has drawn."""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import Any, Sequence

#: So long the rig is looked at, twice for a cost.
COST_S = 5.0


def cpu_s(pid: int) -> float:
    """Of a process since its start; proc(5)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def usable_cores() -> float:
    """That this process may use: by its affinity, and by the quota of its control group (cgroup v2), which a container's CPU limit is."""
    cores = float(len(os.sched_getaffinity(0)))
    with contextlib.suppress(OSError, ValueError):  # no such file or group, or "max"
        own = Path("/proc/self/cgroup").read_text().rpartition("0::")[2].strip()
        for group in (Path("/sys/fs/cgroup") / own.lstrip("/"), Path("/sys/fs/cgroup")):
            if (limit := group / "cpu.max").exists():
                quota, period = limit.read_text().split()
                return min(cores, int(quota) / int(period))
    return cores


class Costs:
    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._before: tuple[float, float, dict[str, int]] | None = None
        self._seen: dict[str, float] = {}

    def of(self, statistics: Sequence[dict[str, Any]], cameras: Sequence[dict[str, Any]]) -> dict[str, float]:
        """Of cameras that were drawn since the call before the last and since the last (stats.get's and camera.list's): the lesser of the two, for a
        first picture, or whatever else is done once, must not move a camera."""
        now = (time.monotonic(), cpu_s(self._pid), {camera["name"]: camera["rendered"] for camera in statistics})
        before, self._before = self._before, now
        if before is None:
            return {}
        pixels = {camera["name"]: camera["size"][0] * camera["size"][1] for camera in cameras}
        drawn = {name: (count - before[2].get(name, 0)) * pixels.get(name, 0) for name, count in now[2].items()}
        drawn = {name: part for name, part in drawn.items() if part > 0}
        cores = (now[1] - before[1]) / (now[0] - before[0])
        seen, self._seen = self._seen, {name: round(cores * part / sum(drawn.values()), 4) for name, part in drawn.items()}
        return {name: min(cost, seen[name]) for name, cost in self._seen.items() if name in seen}
