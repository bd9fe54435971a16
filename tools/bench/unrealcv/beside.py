"""Where tools/setup put UnrealCV's client."""

import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def places() -> list[str]:
    """Folders for the path of Python: the client, and docker, which it imports."""
    found = [place for package in ("unrealcv", "docker") for place in (REPOSITORY / ".venv/beside" / package).glob("lib/python*/site-packages")]
    if len(found) != 2:
        sys.exit("UnrealCV's client is not installed; run tools/setup")
    return [str(place) for place in found]
