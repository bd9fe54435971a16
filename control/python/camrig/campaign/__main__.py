"""`camrig fault run CAMPAIGN -- PROGRAM ARGS..`"""

from __future__ import annotations

import argparse
import json
import signal
import sys
from typing import Any, Sequence

from .. import launch
from ..command_line import Parser, connect_as_told, rig_options, run as run_command
from . import load, run, shipped_names, write
from .runner import Result

_EXIT_NOT_WELL = 3


def main(arguments: Sequence[str]) -> int:
    words = list(arguments)
    program: list[str] = []
    if "--" in words:
        program = words[words.index("--") + 1 :]
        words = words[: words.index("--")]
    options = _parser().parse_args(words)
    campaign = load(options.campaign, _changes(options, program))
    # So that the camera, its fault and the program go, whoever ends us; a shell's background starts us with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    is_json = getattr(options, "json", False)
    with launch.start(campaign.scene, mode="realtime") if campaign.scene else connect_as_told(options) as rig:
        report = run(rig, campaign, lambda result: print(_line(result), file=sys.stderr, flush=True))
    page = write(report, options.out or f"campaign-{campaign.name}")
    print(json.dumps(report.to_json()) if is_json else page)
    return 0 if report.is_good else _EXIT_NOT_WELL


def _parser() -> Parser:
    parser = Parser(prog="camrig fault run", usage="%(prog)s CAMPAIGN [OPTIONS] [-- PROGRAM ARGS..]", parents=[rig_options()],
                    description="Lets the camera of a program fail, and says when the program noticed and when it was well again. "
                    "In PROGRAM {rtsp}, {http} and {device} stand for what it is to read. "
                    f"Exit code {_EXIT_NOT_WELL}: it was not well after some fault. docs/faults.md")
    parser.add_argument("campaign", metavar="CAMPAIGN", help=f"a file, or one of {', '.join(shipped_names())}")
    parser.add_argument("--out", metavar="DIR", help="for report.html and report.json (default: campaign-NAME)")
    parser.add_argument("--scene", help="in a rig of its own; without: in the one that runs")
    parser.add_argument("--camera", help="a camera that is there; without: one for the campaign, that looks where the first one does")
    parser.add_argument("--well", metavar="REGEX", help="lines of the program that say it is well (default: all)")
    parser.add_argument("--troubled", metavar="REGEX", help="lines that say it is not")
    parser.add_argument("--every-s", type=float, metavar="S", help="without such a line for so long it is not well (default 2)")
    parser.add_argument("--check", metavar="COMMAND", help="instead of lines: a command whose exit code 0 says that it is well")
    for name, text in (("warm-up-s", "the most it may take to be well at first"), ("hold-s", "how long each fault lasts"),
                       ("recover-s", "the most it may take to be well again"), ("stays-s", "for how long it must be well to be so")):
        parser.add_argument(f"--{name}", type=float, metavar="S", help=text)
    parser.add_argument("--repeats", type=int, help="of each cell")
    parser.add_argument("--seed", type=int, help="of all that is random")
    return parser


def _changes(options: argparse.Namespace, program: list[str]) -> dict[str, Any]:
    names = ("scene", "camera", "warm_up_s", "hold_s", "recover_s", "stays_s", "repeats", "seed")
    changes = {name: value for name in names if (value := getattr(options, name)) is not None}
    if program:
        changes["program"] = program
    check = {key: value for key, value in (("well", options.well), ("troubled", options.troubled), ("every_s", options.every_s),
                                           ("command", options.check)) if value is not None}
    if check:
        if ("well" in check or "troubled" in check) and "every_s" not in check:
            check["every_s"] = 2.0
        changes["check"] = check
    return changes


def _line(result: Result) -> str:
    parts = [f"{result.row} {result.severity:g}: {result.outcome.replace('_', ' ')}"]
    for text, value in (("noticed after", result.noticed_s), ("well again after", result.recovered_s), ("ended after", result.ended_s)):
        if value is not None and not (text.startswith("well") and result.outcome == "unnoticed"):
            parts.append(f"{text} {value:.2f} s")
    return ", ".join(parts + ([result.reason] if result.reason else []))


if __name__ == "__main__":
    sys.exit(run_command(main))
