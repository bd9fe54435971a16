"""`python -m camrig.farm.live up|node ...`"""

from __future__ import annotations

import sys
from typing import Sequence

from ...command_line import run
from .up import node, up


def main(arguments: Sequence[str]) -> int:
    commands = {"up": up, "node": node}
    if not arguments or arguments[0] not in commands:
        print("usage: python -m camrig.farm.live up|node ... (--help tells their options)", file=sys.stderr)
        return 2
    return commands[arguments[0]](arguments[1:])


if __name__ == "__main__":
    sys.exit(run(main))
