"""python -m tools.bench.speed: see the package's docstring."""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import replace

from tools.bench import report

from . import REPOSITORY
from .meter import processor_seconds
from .parts import ALL, QUICK, Plan

PAGE = REPOSITORY / "docs" / "speed.md"


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.speed", description="measures whole rigs and writes docs/speed.md; exit 1 if something that must hold was missed, 3 if nothing was but "
                                     "it takes longer to tell whether something holds")
    parser.add_argument("--only", choices=list(ALL), action="append", help="only this part; may come more than once")
    parser.add_argument("--quick", action="store_true", help="short runs, printed and not written")
    parser.add_argument("--soak-minutes", type=float, help="how long part soak lasts (5)")
    parser.add_argument("--print-only", action="store_true", help="prints the parts and writes nothing")
    arguments = parser.parse_args()
    plan = QUICK if arguments.quick else Plan()
    if arguments.soak_minutes is not None:
        plan = replace(plan, soak_s=60 * arguments.soak_minutes)
    is_missed = is_undecided = False
    for name in arguments.only or ALL:
        load, begin, (all_before, stolen_before) = os.getloadavg()[0], time.monotonic(), processor_seconds()
        print(f"{name} ...", file=sys.stderr, flush=True)
        with report.start("scenes/minimal.json", mode="lockstep", device="cpu"):
            pass  # what draws by default; rows of other devices say so
        text = ALL[name](plan)
        is_missed |= "**missed**" in text
        is_undecided |= "**undecided**" in text
        all_after, stolen_after = processor_seconds()
        stolen = (stolen_after - stolen_before) / (all_after - all_before)
        print(text + "\n", flush=True)
        if not arguments.quick and not arguments.print_only:
            # Every part says where it was measured: parts may be renewed on different days and machines.
            report.put(PAGE, name, text, f"load average before: {load:.1f}; other guests of the host took {100 * stolen:.1f} % of the processors' time; "
                       f"took {time.monotonic() - begin:.0f} s; `python -m tools.bench.speed --only {name}`")
    return 1 if is_missed else 3 if is_undecided else 0


if __name__ == "__main__":
    sys.exit(main())
