"""What faults cost a camera that has none: CPU time of the rig per picture, by turns within one run.

    python -m tools.bench.fault_cost

A camera that never had a fault, one whose fault is still to come, one whose fault was cleared, and for comparison one with a fault, each alone in a lockstep world and read by HTTP: the
same scene, the same number of pictures, in turns, so that what else the machine does is in all of them. Prints the CPU milliseconds per picture of each (median of the turns) and their ratio to the first; and whether the
bytes of their pictures are the same.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import time

import camrig
from camrig.rig import Rig

#: By name, what is done to the camera before it is measured.
CASES = ("never had one", "one to come", "one that was cleared", "noise, which it has")
_SETTLE_STEPS = 5


def cpu_s(pid: int) -> float:
    """User and system time of the process so far."""
    fields = open(f"/proc/{pid}/stat", encoding="ascii").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def prepare(rig: Rig, camera: str, case: str) -> None:
    if case == CASES[1]:
        rig.fault.set(camera, "noise", start_s=1e6)
    if case in CASES[2:]:
        rig.fault.set(camera, "noise")
    if case == CASES[2]:
        rig.step(seconds=0.04 * _SETTLE_STEPS)
        rig.fault.clear(camera)
    rig.step(seconds=0.04 * _SETTLE_STEPS)


def turn(rig: Rig, case: str, pictures: int) -> tuple[float, str]:
    """CPU milliseconds per picture, and a digest of the camera's last."""
    rig.load("hall")
    for camera in rig.cameras():
        camera.delete()
    cam = rig.create_camera("desk", size=(640, 480), fps=25, place="lobby")
    reader = subprocess.Popen(["curl", "-sN", "-o", "/dev/null", cam.url()])
    while not any(output["readers"] for one in rig.stats()["cameras"] for output in one["outputs"]):
        time.sleep(0.02)
    if case != CASES[2]:
        rig.step(seconds=0.04 * _SETTLE_STEPS)  # so that all are measured at the same times of the world
    prepare(rig, "desk", case)
    pid = rig.info()["pid"]
    begin = cpu_s(pid)
    rig.step(seconds=0.04 * pictures)
    spent = cpu_s(pid) - begin
    digest = hashlib.md5(cam.frame().image.tobytes()).hexdigest()
    cam.delete()
    reader.wait(30)
    return 1e3 * spent / pictures, digest


def measure(turns: int, pictures: int) -> dict[str, object]:
    spent: dict[str, list[float]] = {case: [] for case in CASES}
    digests = set()
    with camrig.start("hall", mode="lockstep", seed=7) as rig:
        for _ in range(turns):
            for case in CASES:
                ms, digest = turn(rig, case, pictures)
                spent[case].append(ms)
                if case != CASES[3]:
                    digests.add(digest)
    medians = {case: statistics.median(values) for case, values in spent.items()}
    return {"cpu_ms_per_picture": {case: round(ms, 3) for case, ms in medians.items()},
            "ratio": {case: round(ms / medians[CASES[0]], 3) for case, ms in medians.items()},
            "same_bytes": len(digests) == 1}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.fault_cost", description="what faults cost a camera that has none")
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--pictures", type=int, default=800)
    options = parser.parse_args()
    report = measure(options.turns, options.pictures)
    print(json.dumps(report, indent=1))
    return 0 if report["same_bytes"] else 1


if __name__ == "__main__":
    raise SystemExit(main())
