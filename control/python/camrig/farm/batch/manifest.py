"""The manifest of a data set, which may be anybody's: a line a shard, each checked before it is used."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, BinaryIO, Callable, Iterator, Mapping, Sequence

from ...errors import CamrigError
from ...json_checks import Wrong, check_choice, check_integer, check_list, check_object, inside
from ..form import read_object
from .shard import MAX_CAMERAS, MAX_SHARDS
from .shard_file import CAMERA_FILES

#: A shard's changes go into a scene's file, which may have no more.
MAX_LINE_BYTES = 64 << 20
_CHUNK_BYTES = 1 << 20
_MAX_TOLD = 300


def rows(path: Path, on_wrong: Callable[[CamrigError], object]) -> Iterator[dict[str, Any]]:
    """What the manifest says of each shard, once. `on_wrong` is told which line says nothing of a shard, and why; unless it raises, that line is passed over."""
    seen: set[str] = set()
    with open(path, "rb") as file:
        for number, line in enumerate(iter(lambda: _line(file), b""), 1):
            if number > MAX_SHARDS:
                raise CamrigError("invalid_argument", f"{path}: has more than {MAX_SHARDS} lines, which no plan makes")
            try:
                row = _row(line)
                if row["shard"] in seen:
                    raise Wrong("shard", "is that of an earlier line, too")
            except Wrong as problem:
                # It may quote the line: one line for it, of letters alone.
                text = "".join(letter if letter.isprintable() else "?" for letter in str(problem)[:_MAX_TOLD])
                on_wrong(CamrigError("invalid_argument", f"{path}: line {number}: {text}"))
                continue
            seen.add(row["shard"])
            yield row


def _line(file: BinaryIO) -> bytes:
    """The next line, b"" at the end; of one that is too long its beginning."""
    line = rest = file.readline(MAX_LINE_BYTES + 1)
    while len(line) > MAX_LINE_BYTES and rest and not rest.endswith(b"\n"):
        rest = file.readline(_CHUNK_BYTES)
    return line


def _row(line: bytes) -> dict[str, Any]:
    if len(line) > MAX_LINE_BYTES:
        raise Wrong("", f"is longer than {MAX_LINE_BYTES} bytes")
    row = read_object(line)
    _check_has(row, "", ("shard", "bytes", "sha256", "seed", "picture_suffix", "pictures", "cameras"))
    _check_match(row["shard"], "shard", "[0-9a-f]{16}", "16 hex digits")
    _check_match(row["sha256"], "sha256", "[0-9a-f]{64}", "64 hex digits")
    for key in ("bytes", "seed"):
        check_integer(row[key], key, 0, 2**53)
    check_choice(row["picture_suffix"], "picture_suffix", (".png", ".jpg"))
    _check_has(row["pictures"], "pictures", ("yolo",))
    check_choice(row["pictures"]["yolo"], "pictures.yolo", (True, False))
    names: set[str] = set()
    for number, camera in enumerate(check_list(row["cameras"], "cameras", MAX_CAMERAS)):
        _check_camera(camera, f"cameras[{number}]")
        if camera["name"] in names:
            raise Wrong(f"cameras[{number}].name", "is that of an earlier camera, too")
        names.add(camera["name"])
    return row


def _check_camera(camera: Any, place: str) -> None:
    _check_has(camera, place, ("name", "frames", "files"))
    _check_match(camera["name"], inside(place, "name"), "[a-z0-9_]{1,24}", "1 to 24 of a-z, 0-9 and _")
    check_integer(camera["frames"], inside(place, "frames"), 0, 2**53)
    files = inside(place, "files")
    check_object(camera["files"], files, CAMERA_FILES)
    if camera["frames"]:
        _check_has(camera["files"], files, CAMERA_FILES)
    for name, text in camera["files"].items():
        if not isinstance(text, str):
            raise Wrong(inside(files, name), "must be a string, the file's text")


def _check_has(value: Any, place: str, keys: Sequence[str]) -> None:
    told: Mapping[str, Any] = check_object(value, place)
    for key in keys:
        if key not in told:
            raise Wrong(inside(place, key), "is missing")


def _check_match(value: Any, place: str, pattern: str, what: str) -> None:
    if not isinstance(value, str) or re.fullmatch(pattern, value) is None:
        raise Wrong(place, f"must be {what}")
