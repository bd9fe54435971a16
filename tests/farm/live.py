"""Farms on this machine, each node a process behind a link of its own, over NATS on loopback: what holds, and what it costs when something dies.

    PYTHONPATH=control/python .venv/bin/python tests/farm/live.py [--seconds 600] [--commands 1000] [--kills 20] [--seed 1] [--only PART ...] [--write]

Parts: lockstep (what four nodes show is what one machine shows), disturbed (so it is when nodes are killed, stopped and cut off), realtime (how long
cameras are away), bus (so when NATS servers are killed), cost (of the log). A verdict a line, numbers in build/farm/live.json, with --write in
docs/farm.md; exit code 1 if one fails.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any, Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from live_parts import bus_deaths, cost, lockstep, realtime  # noqa: E402
from live_parts.farm import write_json  # noqa: E402
from live_parts.page import page_part  # noqa: E402
from live_parts.verdicts import Verdicts  # noqa: E402
from tools.bench import report  # noqa: E402

_NUMBERS = report.REPOSITORY / "build" / "farm" / "live.json"
_PARTS = ("lockstep", "disturbed", "realtime", "bus", "cost")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=600.0, help="of lockstep, and a tenth of it disturbed")
    for name, value, text in (("commands", 1000, "in lockstep"), ("kills", 20, "of each kind, in real time"), ("seed", 1, "of all that is random")):
        parser.add_argument(f"--{name}", type=int, default=value, help=text)
    parser.add_argument("--only", nargs="*", choices=_PARTS, default=_PARTS, help="the other parts keep the numbers that they had; nothing: only --write")
    parser.add_argument("--keep", help="folder for logs of nodes")
    parser.add_argument("--write", action="store_true", help="into docs/farm.md")
    options = parser.parse_args()
    verdicts = Verdicts()
    found: dict[str, Any] = json.loads(_NUMBERS.read_text()) if _NUMBERS.exists() else {}
    with tempfile.TemporaryDirectory(prefix="camrig-farm-live-", ignore_cleanup_errors=True) as temporary:
        folder = Path(options.keep or temporary)
        parts: dict[str, Callable[[Path], dict[str, Any]]] = {
            "lockstep": lambda to: lockstep.run(to, verdicts, seconds=options.seconds, count=options.commands, seed=options.seed),
            "disturbed": lambda to: lockstep.run(to, verdicts, seconds=options.seconds / 10, count=options.commands // 10, seed=options.seed + 100, disturb=True),
            "realtime": lambda to: realtime.run(to, verdicts, kills=options.kills, seed=options.seed),
            "bus": lambda to: bus_deaths.run(to, verdicts, kills=max(2, options.kills // 4)),
            "cost": lambda to: cost.run(to, verdicts),
        }
        for name in options.only:
            commit = report.commit()  # before: a run is long
            found[name] = {**parts[name](folder / name), "commit": commit}
            write_json(_NUMBERS, found)
    if options.write:
        report.put(report.REPOSITORY / "docs" / "farm.md", "live", page_part(found), "`tests/farm/live.py --write`")
    return 1 if verdicts.failed else 0


def interrupt(*_: Any) -> None:
    """Each second again until somebody hears it (Farm.__exit__): one that comes in a callback of Python's own work is lost."""
    signal.setitimer(signal.ITIMER_REAL, 1.0)
    raise KeyboardInterrupt


if __name__ == "__main__":
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):
        signal.signal(each, interrupt)
    try:
        sys.exit(main())
    except KeyboardInterrupt:  # the farm has been ended on the way here
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sys.exit("interrupted; the numbers of parts that were done are kept")
