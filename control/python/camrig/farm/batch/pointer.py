"""Changes of a JSON document at a place: JSON Pointer (RFC 6901), with elements of lists by their "name" too."""

from __future__ import annotations

from typing import Any


class PointerError(Exception):
    """What is wrong with a pointer, in one line."""


def assign(document: Any, pointer: str, value: Any) -> None:
    """Puts the value at that place: "/lights/0/intensity", or "/lights/daylight/intensity" for the light of that name.

    The last word may be a new key of an object, or "-" for a new element at a list's end; all before must be there.
    """
    words = [word.replace("~1", "/").replace("~0", "~") for word in pointer.split("/")[1:]]
    if not words:
        raise PointerError("must begin with /")
    place = document
    for depth, word in enumerate(words[:-1]):
        place = _enter(place, word, "/" + "/".join(words[: depth + 1]))
    last = words[-1]
    if isinstance(place, list):
        if last == "-":
            place.append(value)
        else:
            place[_index(place, last, pointer)] = value
    elif isinstance(place, dict):
        place[last] = value
    else:
        raise PointerError(f"the scene has a {_kind(place)} at {pointer.rpartition('/')[0]}, which nothing can be put into")


def _enter(place: Any, word: str, so_far: str) -> Any:
    if isinstance(place, list):
        return place[_index(place, word, so_far)]
    if isinstance(place, dict) and word in place:
        return place[word]
    known = f"; there are {', '.join(sorted(place)[:20])}" if isinstance(place, dict) else ""
    raise PointerError(f"the scene has no {so_far}{known}")


def _index(place: list[Any], word: str, so_far: str) -> int:
    names = [one.get("name") if isinstance(one, dict) else None for one in place]
    if word in names:
        return names.index(word)
    if word.isdecimal() and int(word) < len(place):
        return int(word)
    told = ", ".join(str(name) for name in names[:20] if name) or f"0 to {len(place) - 1}" if place else "none"
    raise PointerError(f"the scene has no {so_far}; there are {told}")


def _kind(value: Any) -> str:
    return {str: "text", bool: "truth value", type(None): "null"}.get(type(value), "number")
