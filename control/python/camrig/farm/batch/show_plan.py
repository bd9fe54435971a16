"""`camrig farm plan PLAN`: the shards of a plan, one JSON object a line."""

from __future__ import annotations

import json
from typing import Sequence

from ...command_line import Parser
from . import plan as plans


def main(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm plan", description="Tells the shards of a plan, one JSON object a line, and draws nothing.")
    parser.add_argument("plan", metavar="PLAN", help="JSON file")
    parser.add_argument("--json", action="store_true", help="they always are")
    for shard in plans.load(parser.parse_args(arguments).plan).shards:
        print(json.dumps({"shard": shard.id, **shard.to_json()}))
    return 0
