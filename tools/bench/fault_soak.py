"""Random campaigns, many at once, on one rig: what is left of them afterwards.

    python -m tools.bench.fault_soak --campaigns 1000 --at-once 8

Each has a camera of its own, a stock reader (curl, ffmpeg by RTSP, or v4l2-ctl on a user-space device), a fault of a random kind and
severity, and about two seconds. After a first part, which fills caches, and at the end the rig's descriptors, threads, memory, cameras, faults and
device nodes are counted. Exit code 1 when something was left.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import random
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Mapping, Sequence

import camrig
import camrig.campaign
from camrig.rig import Rig

READERS = {
    "http": ["curl", "-sN", "-o", "/dev/null", "--no-progress-meter", "-w", "%{size_download}\n", "{http}"],
    "rtsp": ["ffmpeg", "-v", "error", "-nostdin", "-rtsp_transport", "tcp", "-i", "{rtsp}", "-c", "copy", "-progress", "-", "-stats_period", "0.1", "-f", "null", "-"],
    "device": ["v4l2-ctl", "-d", "{device}", "--stream-mmap", "--stream-to", "/dev/null", "--verbose"],
}
_FIRST_DEVICE = 200
_HOLD_S, _RECOVER_S = 1.2, 0.6
_MAX_RSS_GROWTH_KB = 40_000


def kinds_of(rig: Rig) -> list[str]:
    """All kinds of faults that this rig knows."""
    return [kind["name"] for kind in rig.call("server.describe")["kinds"]["fault"]]


def random_campaign(seed: int, number: int, kinds: Sequence[str]) -> dict[str, Any]:
    """The same for the same numbers."""
    dice = random.Random(f"{seed}/{number}")
    faults = [{"kind": dice.choice(kinds), "severity": round(dice.uniform(0.05, 1.0), 3)}]
    # In turn, so that few campaigns have them all.
    reader = list(READERS)[number % len(READERS)]
    device = {"kind": "device", "number": _FIRST_DEVICE + number % 50}
    return {
        "name": f"soak{number}",
        "faults": faults,
        "seed": number,
        "program": READERS[reader],
        # Of a reader that is killed in the end and says nothing before: that it runs.
        "check": {"command": ["true"], "every_s": 0.2} if reader == "http" else {"every_s": 0.5},
        "camera": {"name": f"soak{number}", "size": [160, 120], "fps": 20, "outputs": [{"kind": "mjpeg"}, {"kind": "rtsp"}, device]},
        "warm_up_s": 20, "hold_s": _HOLD_S, "recover_s": _RECOVER_S, "stays_s": 0.1,
    }


def left_over(rig: Rig) -> dict[str, Any]:
    info = rig.info()
    process = Path(f"/proc/{info['pid']}")
    status = dict(line.split(":", 1) for line in (process / "status").read_text().splitlines() if ":" in line)
    return {
        "cameras": sorted(camera.name for camera in rig.cameras()),
        "faults": len(rig.fault.list()),
        "devices": len(list(Path(info["devices"]).glob("*"))) if Path(info["devices"]).is_dir() else 0,
        "descriptors": len(os.listdir(process / "fd")),
        "threads": int(status["Threads"]),
        "rss_kb": int(status["VmRSS"].split()[0]),
        "our_descriptors": len(os.listdir("/proc/self/fd")),
        "our_threads": threading.active_count(),
    }


def run_some(rig: Rig, numbers: Sequence[int], seed: int, at_once: int) -> Mapping[str, int]:
    """How they ended."""
    kinds, counts = kinds_of(rig), collections.Counter[str]()

    def one(number: int) -> str:
        campaign = camrig.campaign.load(random_campaign(seed, number, kinds))
        try:
            return camrig.campaign.run(rig, campaign).results[0].outcome
        except camrig.CamrigError as problem:
            return f"{problem.kind}: {problem.message[:160]}"

    with ThreadPoolExecutor(at_once) as pool:
        counts.update(pool.map(one, numbers))
    return dict(counts)


def settled(rig: Rig, wanted: Mapping[str, Any] | None) -> dict[str, Any]:
    """What is left when readers that were just ended are gone."""
    for _ in range(40):
        time.sleep(0.5)
        left = left_over(rig)
        if wanted is not None and not problems(wanted, left):
            break
    return left


def problems(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """What has grown that should not."""
    found = [f"{key}: {before[key]}, then {after[key]}" for key in ("cameras", "faults", "devices") if after[key] != before[key]]
    found += [f"{key}: {before[key]}, then {after[key]}" for key in ("descriptors", "threads", "our_descriptors", "our_threads") if after[key] > before[key]]
    if after["rss_kb"] > before["rss_kb"] + _MAX_RSS_GROWTH_KB:
        found.append(f"rss_kb: {before['rss_kb']}, then {after['rss_kb']}")
    return found


def soak(rig: Rig, campaigns: int, at_once: int, seed: int) -> dict[str, Any]:
    """A first part, of a tenth or two rounds, then the rest in parts of so many; what was there before, after the first and afterwards."""
    first = min(campaigns, max(2 * at_once, campaigns // 10))
    begun = time.monotonic()
    start = left_over(rig)
    outcomes = collections.Counter(run_some(rig, range(first), seed, at_once))
    warm = settled(rig, None)
    memory = [warm["rss_kb"]]
    for part in range(first, campaigns, first):
        outcomes.update(run_some(rig, range(part, min(part + first, campaigns)), seed, at_once))
        memory.append(left_over(rig)["rss_kb"])
    end = settled(rig, warm)
    gone = {**warm, **{key: start[key] for key in ("cameras", "faults", "devices")}}
    return {"campaigns": campaigns, "seconds": round(time.monotonic() - begun, 1), "outcomes": dict(outcomes), "rss_kb": memory, "start": start,
            "warm": warm, "end": end, "problems": problems(gone, end)}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.fault_soak", description="random campaigns: nothing is left of them")
    parser.add_argument("--campaigns", type=int, default=1000)
    parser.add_argument("--at-once", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with camrig.start("scenes/minimal.json", mode="realtime") as rig:
        report = soak(rig, options.campaigns, options.at_once, options.seed)
    print(json.dumps(report, indent=1))
    return 1 if report["problems"] else 0


if __name__ == "__main__":
    sys.exit(main())
