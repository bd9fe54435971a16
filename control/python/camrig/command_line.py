"""What every command of `camrig` that is written in Python shares: how it reaches the rig, and how it fails."""

from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Callable, NoReturn, Sequence

from .errors import CamrigError
from .rig import Rig, connect
from .token_file import read_token

_EXIT_FAILED, _EXIT_USAGE = 1, 2


class Parser(argparse.ArgumentParser):
    """Wrong usage is one line on stderr (JSON with --json) and exit code 2, as for the commands in C++."""

    def error(self, message: str) -> NoReturn:
        _tell("invalid_argument", f"{message} ({self.prog} --help)")
        sys.exit(_EXIT_USAGE)


def rig_options() -> argparse.ArgumentParser:
    """A parent parser with the options that all commands take, before or after their own."""
    parser = argparse.ArgumentParser(add_help=False)
    # SUPPRESS: a subparser's default must not undo what was given before the subcommand.
    parser.add_argument("--control", default=argparse.SUPPRESS, help="the rig's control socket: a path, HOST:PORT or http://HOST:PORT")
    parser.add_argument("--token-file", default=argparse.SUPPRESS, help="file with the token of the rig")
    parser.add_argument("--json", action="store_true", default=argparse.SUPPRESS, help="machine-readable output")
    return parser


def connect_as_told(options: argparse.Namespace) -> Rig:
    """The rig of --control, else of $CAMRIG_CONTROL, else the default one; with the token of --token-file or $CAMRIG_TOKEN_FILE."""
    token_file = getattr(options, "token_file", None) or os.environ.get("CAMRIG_TOKEN_FILE")
    token = read_token(token_file) if token_file else None
    return connect(getattr(options, "control", None), token=token)


def run(main: Callable[[Sequence[str]], int]) -> int:
    """Runs a command on sys.argv; what goes wrong is one line on stderr (JSON with --json) and exit code 1."""
    try:
        return main(sys.argv[1:])
    except CamrigError as problem:
        _tell(problem.kind, problem.message)
    except OSError as problem:
        _tell("not_found" if isinstance(problem, FileNotFoundError) else "unavailable", str(problem))
    except KeyboardInterrupt:
        return 130
    return _EXIT_FAILED


def _tell(kind: str, message: str) -> None:
    if "--json" in sys.argv[1:]:
        print(json.dumps({"error": {"kind": kind, "message": message}}), file=sys.stderr)
    else:
        print("camrig: " + " ".join(message.split()), file=sys.stderr)
