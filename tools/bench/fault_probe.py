"""What `camrig probe` says of cameras that fail, and the table of docs/faults.md made of it.

    python -m tools.bench.fault_probe --write

Without --write it prints the table. Each fault of tools.bench.fault_readers acts for the second third of a probe's time, on a camera with a code strip.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import camrig
from camrig.places import find_binary
from camrig.rig import Rig

from .fault_readers import FAULTS, ONLY, PAGE, put, title_of

BEGIN, END = "<!-- probe, made by: python -m tools.bench.fault_probe --write -->", "<!-- probe ends here -->"
SOURCES = {"HTTP": "mjpeg", "RTSP": "rtsp", "device": "device"}
RATE, HOLD_S = 15, 3.0
#: What it counts of a source, beside the pictures.
COUNTS = ("drops", "repeats", "out_of_order", "torn")


def probed(rig: Rig, fault: dict[str, Any], number: int, source: str) -> str:
    """A cell: how many pictures it had of how many, and what it counted; or the error that it ended with."""
    camera = rig.create_camera(f"probe{number}", size=(320, 240), fps=RATE, code_strip=True,
                               outputs=[{"kind": "mjpeg"}, {"kind": "rtsp"}, {"kind": "device", "number": 210 + number}])
    place = f"/dev/video{210 + number}" if source == "device" else camera.url(SOURCES[source])
    words = [find_binary(), "--control", rig.control or ""]
    words += ["exec", "--", find_binary()] if source == "device" else []
    try:
        with subprocess.Popen([*words, "probe", place, "--seconds", str(3 * HOLD_S), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as probe:
            while probe.poll() is None and not any(one["delivered"] > 1 for output in books_of(rig, camera.name) for one in output["readers"]):
                time.sleep(0.05)
            time.sleep(HOLD_S)
            rig.fault.set(camera.name, fault["kind"], severity=fault.get("severity", 1.0), **fault.get("params", {}))
            time.sleep(HOLD_S)
            rig.fault.clear(camera.name)
            told, problem = probe.communicate(timeout=60)
    finally:
        camera.delete()
    if probe.returncode != 0:
        return "ends: " + problem.strip().splitlines()[-1].split(f"{place}: ")[-1].replace("|", "/")
    report = json.loads(told)["sources"][0]
    due = round(3 * HOLD_S * RATE)
    counts = ", ".join(f"{report[name]} {name.replace('_', ' ')}" for name in COUNTS if report[name])
    return f"{report['pictures']} of {due}" + (f": {counts}" if counts else "")


def books_of(rig: Rig, name: str) -> list[dict[str, Any]]:
    outputs: list[dict[str, Any]] = next(one["outputs"] for one in rig.stats()["cameras"] if one["name"] == name)
    return outputs


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.fault_probe", description="what camrig probe says of cameras that fail")
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name}")
    options = parser.parse_args()
    cells = [(fault, source) for fault in [{"kind": "", "name": "without"}, *FAULTS] for source in SOURCES if source in ONLY.get(fault["kind"], source)]
    with camrig.start("scenes/minimal.json", mode="realtime") as rig, ThreadPoolExecutor(3) as pool:

        def measured(job: tuple[int, tuple[dict[str, Any], str]]) -> str:
            number, (fault, source) = job
            told = probed(rig, fault if fault["kind"] else {"kind": "black", "severity": 0.0}, number % 40, source)
            print(f"{title_of(fault)} {source}: {told}", file=sys.stderr, flush=True)
            return told

        said = dict(zip([(title_of(fault), source) for fault, source in cells], pool.map(measured, enumerate(cells))))
    lines = ["| fault | " + " | ".join(SOURCES) + " |", "|---" * (len(SOURCES) + 1) + "|"]
    for title in dict.fromkeys(title for title, _ in said):
        lines.append(f"| {title} | " + " | ".join(said.get((title, source), "") for source in SOURCES) + " |")
    put("\n".join(lines), BEGIN, END, options.write)
    return 0


if __name__ == "__main__":
    sys.exit(main())
