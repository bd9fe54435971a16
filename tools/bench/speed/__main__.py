"""python -m tools.bench.speed: see the package's docstring."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from dataclasses import replace

import camrig

from . import REPOSITORY
from .meter import machine, processor_seconds
from .parts import ALL, QUICK, Plan

PAGE = REPOSITORY / "docs" / "speed.md"
HEAD = """# Speed

How fast camrig is, where the time goes, and how far that is from what the machine gives. Every section is written by one part of
`python -m tools.bench.speed` and says where and when it was measured: whole rigs, started as a user would and read by clients over HTTP.
CPU milliseconds are of the daemon alone, user and system; they hold still when the machine is busy with other things, frames a second do not.

The renderer works the same on a GPU: a shader converts colours to what readers take (`--convert-on`), and pixels come to host memory through a ring of mapped buffers behind
fences (`ReadbackMode::buffered`). `tests/render/gpu_test.cpp` holds both to the same bytes on the CPU, and a hardware EGL device to what the CPU draws and converts (skipped by name
where there is none, as here): all numbers below are of the device `cpu`: colour of qualities `fast` and `simple` by the own rasteriser, all else by llvmpipe.
"""


def section(name: str, text: str) -> str:
    return f"<!-- part {name} -->\n{text.strip()}\n<!-- end of {name} -->"


def put(page: str, name: str, text: str) -> str:
    """The page with one part renewed, the others as they are, all in the order of ALL."""
    found = dict(re.findall(r"<!-- part (\w+) -->\n(.*?)\n<!-- end of \1 -->", page, re.DOTALL))
    found[name] = text.strip()
    return HEAD + "\n" + "\n\n".join(section(part, found[part]) for part in ALL if part in found) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.speed", description="measures whole rigs and writes docs/speed.md")
    parser.add_argument("--only", choices=list(ALL), action="append", help="only this part; may come more than once")
    parser.add_argument("--quick", action="store_true", help="short runs, printed and not written")
    parser.add_argument("--soak-minutes", type=float, help="how long part soak lasts (5)")
    parser.add_argument("--print-only", action="store_true", help="prints the parts and writes nothing")
    arguments = parser.parse_args()
    plan = QUICK if arguments.quick else Plan()
    if arguments.soak_minutes is not None:
        plan = replace(plan, soak_s=60 * arguments.soak_minutes)
    with camrig.start("scenes/minimal.json", mode="lockstep", device="cpu") as rig:
        renderer = rig.call("server.info")["renderer"]
    for name in arguments.only or ALL:
        load, begin, (all_before, stolen_before) = os.getloadavg()[0], time.monotonic(), processor_seconds()
        print(f"{name} ...", file=sys.stderr, flush=True)
        title, _, rest = ALL[name](plan).partition("\n\n")
        all_after, stolen_after = processor_seconds()
        stolen = (stolen_after - stolen_before) / (all_after - all_before)
        # Every part says where it was measured: parts may be renewed on different days and machines.
        how = (f"Measured on {machine()}, {renderer}; load average before: {load:.1f}; other guests of the host took {100 * stolen:.1f} % of the processors' time; "
               f"took {time.monotonic() - begin:.0f} s; `python -m tools.bench.speed --only {name}`.")
        text = f"{title}\n\n{how}\n\n{rest}"
        print(text + "\n", flush=True)
        if not arguments.quick and not arguments.print_only:
            PAGE.write_text(put(PAGE.read_text() if PAGE.exists() else "", name, text))
    return 0


if __name__ == "__main__":
    sys.exit(main())
