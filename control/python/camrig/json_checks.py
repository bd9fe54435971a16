"""Reading of JSON files, and checks of their values that say where what is wrong."""

from __future__ import annotations

import json
import os
from typing import Any, Collection, Mapping

from .errors import CamrigError


class Wrong(Exception):
    """What is wrong at a place of a file: `vary[1].count: must be ..`."""

    def __init__(self, place: str, what: str) -> None:
        super().__init__(f"{place}: {what}" if place else what)


def read_json(path: str | os.PathLike[str], most_bytes: int, hint: str = "") -> Any:
    """The value in the file, of at most so many bytes. CamrigError names the file; `hint` is added where there is none."""
    where = os.fspath(path)
    try:
        with open(where, "rb") as file:
            text = file.read(most_bytes + 1)
    except OSError as problem:
        raise CamrigError("not_found", f"{where}: {problem.strerror}{hint}") from None
    if len(text) > most_bytes:
        raise CamrigError("invalid_argument", f"{where}: more than {most_bytes} bytes")
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as problem:
        raise CamrigError("invalid_argument", f"{where}: is not JSON: {problem}") from None


def inside(place: str, key: str) -> str:
    return f"{place}.{key}" if place else key


def check_object(value: Any, place: str, known: Collection[str] | None = None) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise Wrong(place, "must be an object")
    for key in value:
        if known is not None and key not in known:
            raise Wrong(inside(place, key), f"is unknown; known: {', '.join(sorted(known))}")
    return value


def check_list(value: Any, place: str, most: int) -> list[Any]:
    if not isinstance(value, list) or not 1 <= len(value) <= most:
        raise Wrong(place, f"must be a list of 1 to {most}")
    return value


def check_text(value: Any, place: str) -> str:
    if not isinstance(value, str) or not 1 <= len(value) <= 1000:
        raise Wrong(place, "must be a string of 1 to 1000 characters")
    return value


def check_choice(value: Any, place: str, choices: Collection[Any]) -> Any:
    if not isinstance(value, (str, bool, type(None))) or value not in choices:
        raise Wrong(place, f"must be one of {', '.join(str(choice) for choice in choices)}")
    return value


def check_number(value: Any, place: str, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise Wrong(place, f"must be {low:g} to {high:g}")
    return float(value)


def check_integer(value: Any, place: str, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise Wrong(place, f"must be a whole number, {low} to {high}")
    return value
