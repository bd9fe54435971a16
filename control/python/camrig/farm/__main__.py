"""`camrig farm COMMAND ...`"""

from __future__ import annotations

import argparse
import importlib
import sys
from typing import Sequence

from ..command_line import Parser, run

#: The function of each command, which takes the words behind its name, and what it does.
COMMANDS = {
    "up": ("camrig.farm.live.up:up", "runs one world on several nodes of this machine, with one control address"),
    "node": ("camrig.farm.live.up:node", "is one node of such a world, on any machine"),
    "door": ("camrig.farm.live.up:door", "is one control address of such a world"),
    "record": ("camrig.farm.batch.record:main", "draws a data set by a plan of shards, on this machine or by Ray"),
    "plan": ("camrig.farm.batch.show_plan:main", "tells the shards of a plan, one a line, and draws nothing"),
    "check": ("camrig.farm.batch.check:main", "reads a data set again and compares it with its manifest"),
    "export": ("camrig.farm.batch.export:main", "makes COCO, MOTChallenge, KITTI, YOLO or Parquet of a data set"),
}


def main(arguments: Sequence[str]) -> int:
    told = "\n".join(f"  {name:10}{text}" for name, (_, text) in COMMANDS.items())
    parser = Parser(prog="camrig farm", usage="%(prog)s COMMAND ...", description="camrig on many machines",
                    epilog=f"commands:\n{told}\n\ncamrig farm COMMAND --help tells their options", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    parser.add_argument("command", choices=COMMANDS, metavar="COMMAND")
    words = list(arguments)
    at = next((number for number, word in enumerate(words) if not word.startswith("-")), len(words))
    options = parser.parse_args(words[: at + 1])
    rest = words[at + 1 :] + (["--json"] if options.json else [])
    module, _, function = COMMANDS[options.command][0].partition(":")
    return getattr(importlib.import_module(module), function)(rest)


if __name__ == "__main__":
    sys.exit(run(main))
