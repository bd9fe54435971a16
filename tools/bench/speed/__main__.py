"""python -m tools.bench.speed: see the package's docstring."""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path

import camrig

from .meter import machine
from .parts import ALL, QUICK, Plan

PAGE = Path(__file__).resolve().parents[3] / "docs" / "speed.md"


def section(name: str, text: str) -> str:
    return f"<!-- part {name} -->\n{text.strip()}\n<!-- end of {name} -->"


def put(page: str, name: str, text: str) -> str:
    """The page with one part renewed, the others as they are."""
    pattern = re.compile(rf"<!-- part {name} -->.*?<!-- end of {name} -->", re.DOTALL)
    if pattern.search(page):
        return pattern.sub(lambda _: section(name, text), page)
    return page.rstrip() + "\n\n" + section(name, text) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.speed", description="measures whole rigs and writes docs/speed.md")
    parser.add_argument("--only", choices=list(ALL), action="append", help="only this part; may come more than once")
    parser.add_argument("--quick", action="store_true", help="short runs, printed and not written")
    arguments = parser.parse_args()
    plan = QUICK if arguments.quick else Plan()
    with camrig.start("scenes/minimal.json", mode="lockstep", device="cpu") as rig:
        renderer = rig.call("server.info")["renderer"]
    head = f"Measured on {machine()}, {renderer}; load average before: {os.getloadavg()[0]:.1f}."
    for name in arguments.only or ALL:
        print(f"{name} ...", file=sys.stderr, flush=True)
        text = ALL[name](plan)
        # Every part says where it was measured: parts may be renewed on different days and machines.
        title, _, rest = text.partition("\n\n")
        text = f"{title}\n\n{head}\n\n{rest}"
        print(text + "\n", flush=True)
        if not arguments.quick:
            PAGE.write_text(put(PAGE.read_text() if PAGE.exists() else "# Speed\n", name, text))
    return 0


if __name__ == "__main__":
    sys.exit(main())
