"""`camrig farm check DIR`: reads a data set again and compares it with its manifest."""

from __future__ import annotations

import json
import sys
from typing import Sequence

from ...command_line import Parser
from .store import Store


def main(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm check", description="Reads all shards of a data set and compares them with its manifest. "
                    "Exit code 1: some differ, or the manifest has not all of them, or lines that are of none.")
    parser.add_argument("folder", metavar="DIR", help="of camrig farm record")
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    options = parser.parse_args(arguments)
    store = Store(options.folder)
    problems: list[str] = []
    listed: set[str] = set()

    def tell(problem: str) -> None:
        problems.append(problem)
        print(f"camrig: {problem}", file=sys.stderr)

    for told in store.manifest(lambda wrong: tell(wrong.message)):
        listed.add(told["shard"])
        if problem := store.problem_of(told):
            tell(problem)
    lacks = warn_of_lacks(store, listed)
    text = f"{store.folder}: {len(listed)} shards in the manifest, {len(problems)} problems"
    print(json.dumps({"folder": str(store.folder), "shards": len(listed), "problems": problems, "lacks": lacks}) if options.json else text)
    return 1 if problems or lacks else 0


def warn_of_lacks(store: Store, listed: set[str]) -> str | None:
    if lacks := store.lacks(listed):
        print(f"camrig: {store.folder}: {lacks}: run camrig farm record again", file=sys.stderr)
    return lacks
