"""`camrig farm check DIR`: reads a data set again and compares it with its manifest."""

from __future__ import annotations

import json
import sys
from typing import Sequence

from ...command_line import Parser
from .store import Store


def main(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm check", description="Reads all shards of a data set and compares them with its manifest. Exit code 1: some differ.")
    parser.add_argument("folder", metavar="DIR", help="of camrig farm record")
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    options = parser.parse_args(arguments)
    store, shards, problems = Store(options.folder), 0, []
    for told in store.manifest():
        shards += 1
        if problem := store.problem_of(told):
            problems.append(problem)
            print(f"camrig: {problem}", file=sys.stderr)
    text = f"{store.folder}: {shards} shards, {len(problems)} of them not as the manifest says"
    print(json.dumps({"folder": str(store.folder), "shards": shards, "problems": problems}) if options.json else text)
    return 1 if problems else 0
