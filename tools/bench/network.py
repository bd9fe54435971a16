"""Writes what a run of examples/network found into docs/network.md, and its figure of utility against communication.

    python -m examples.network --rounds 5
    python -m tools.bench.network network-run
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from examples.network.camsim import MEASURED
from examples.network.report import trade

from . import report

ROWS = ("relative_utility", "coverage", "handovers", "returned", "idf1", "switches", "error_m", "searches", "messages", "bytes")
TITLES = ("utility of the best possible", "coverage", "hand-overs", "back in 1 s", "IDF1", "switches", "error, m", "searches", "messages", "kB")


def _row(name: str, cells: list[str]) -> str:
    return f"| {name} | {' | '.join(cells)} |"


def strategies(results: dict[str, Any]) -> str:
    def cell(key: str, value: float) -> str:
        return f"{value / 1000:.0f}" if key == "bytes" else f"{value:.2f}" if key in ("relative_utility", "coverage", "idf1", "error_m") else f"{value:.0f}"

    of = results["sweeps"]["strategy"]
    lines = [_row("", list(TITLES)), _row("---", ["---"] * len(TITLES)), *(_row(name, [cell(key, one[key]) for key in ROWS]) for name, one in of.items())]
    rounds = results["sweeps"]["rounds"]
    lines += ["", _row("rounds of consensus (ABC)", list(rounds)), _row("---", ["---"] * len(rounds)),
              _row("error on the floor, m", [f"{one['error_m']:.3f}" for one in rounds.values()]), _row("MB", [f"{one['bytes'] / 1e6:.1f}" for one in rounds.values()])]
    return "\n".join([*lines, "", f"The run: {results['about']}."])


def camsim(results: dict[str, Any]) -> str:
    of, whole, ours = results["sweeps"]["strategy"], results["sweeps"]["strategy"]["ABC"], results["camsim"]
    lines = [_row("share of ABC's", ["utility: CamSim", "ours, no pictures", "ours, on pictures", "searches: CamSim", "ours, no pictures", "ours, on pictures"]), _row("---", ["---"] * 6)]
    for name, (utility, searches) in MEASURED.items():
        pairs = ((utility, ours[name]["utility_share"], of[name]["utility"] / whole["utility"]), (searches, ours[name]["searches_share"], of[name]["searches"] / whole["searches"]))
        lines.append(_row(name, [f"{value:.2f}" for three in pairs for value in three]))
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tools.bench.network", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of a run with its comparisons")
    found = json.loads((parser.parse_args().folder / "results.json").read_text())
    page = report.REPOSITORY / "docs" / "network.md"
    figure = report.REPOSITORY / "docs" / "pictures" / "network" / "trade.svg"
    figure.parent.mkdir(exist_ok=True)
    figure.write_text(trade(found) + "\n")
    by = "`python -m examples.network --rounds 5` and `python -m tools.bench.network network-run`"
    report.put(page, "strategies", strategies(found), by)
    report.put(page, "camsim", camsim(found), by)
