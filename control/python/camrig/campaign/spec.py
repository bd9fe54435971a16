"""What a campaign is: a table of faults and severities, a program, and how one sees that it is well."""

from __future__ import annotations

import json
import os
import re
import shlex
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Mapping

from ..errors import CamrigError
from ..json_checks import Wrong, check_integer, check_number, check_object, read_json

MAX_FILE_BYTES = 1 << 20
MAX_CELLS = 1000
MAX_SECONDS = 3600.0
#: Parameters of fault.set that are no kind's own: who gives them.
_OF_THE_ROW = {
    "kind": "the fault's kind stands beside params",
    "severity": "severity, or a list of severities, stands beside params",
    "camera": "camera is the campaign's",
    "seed": "each cell's follows from the campaign's seed",
    "start_s": "each cell begins when the program is well",
    "end_s": "hold_s of the campaign says how long a fault lasts",
}
SHIPPED = Path(__file__).with_name("shipped")
#: What stands for an address in the program's words and in a command that checks it.
PLACEHOLDERS = ("rtsp", "http", "device", "camera", "control")


@dataclass(frozen=True)
class Check:
    """A program is well while lines that match `well` come (each within `every_s`, if given) and none matches `troubled`; without
    `well`, any other line will do. Or: while `command` ends with 0, asked each `every_s`."""

    well: str | None = None
    troubled: str | None = None
    every_s: float | None = 2.0
    command: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Row:
    """One fault with its severities; `params` are the kind's own. Or `settings`: `params` are fields of camera.set, put back afterwards."""

    name: str
    kind: str
    severities: tuple[float, ...] = (1.0,)
    params: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Cell:
    """A row at one severity, once."""

    row: Row
    severity: float
    repeat: int

    @property
    def key(self) -> str:
        return f"{self.row.name}/{self.severity:g}/{self.repeat}"


@dataclass(frozen=True)
class Campaign:
    """Times in seconds of the wall clock, for what is measured is the program: `warm_up_s`, the most it may take to be well at first;
    `hold_s`, how long the fault lasts; `recover_s`, the most it may take to be well again; `stays_s`, for how long it must then be."""

    name: str
    rows: tuple[Row, ...]
    program: tuple[str, ...] = ()
    check: Check = field(default_factory=Check)
    camera: str | Mapping[str, Any] = ""
    scene: str | None = None
    repeats: int = 1
    warm_up_s: float = 20.0
    hold_s: float = 5.0
    recover_s: float = 20.0
    stays_s: float = 1.0
    seed: int = 0
    #: What a benchmark has and this campaign has not: why, by name.
    unmapped: Mapping[str, str] = field(default_factory=dict)

    def cells(self) -> list[Cell]:
        return [Cell(row, severity, repeat) for row in self.rows for severity in row.severities for repeat in range(self.repeats)]

    def to_json(self) -> dict[str, Any]:
        return json.loads(json.dumps(asdict(self)))


def shipped_names() -> list[str]:
    return sorted(path.stem for path in SHIPPED.glob("*.json"))


def load(campaign: str | os.PathLike[str] | Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Campaign:
    """A file, the name of a shipped campaign, or what such a file says; `changes` take the place of its keys.

    CamrigError names the place of what is wrong, as in ``usb.json: faults[2].severities[0]: must be 0 to 1``."""
    if isinstance(campaign, Mapping):
        where, value = "campaign", dict(campaign)
    else:
        where, value = _read(campaign)
    if changes and isinstance(value, dict):
        value = {**value, **changes}
    try:
        return _campaign(value)
    except Wrong as wrong:
        raise CamrigError("invalid_argument", f"{where}: {wrong}") from None


def _read(path: str | os.PathLike[str]) -> tuple[str, Any]:
    name = os.fspath(path)
    shipped = SHIPPED / f"{name}.json"
    file = shipped if name in shipped_names() and not os.path.exists(name) else Path(name)
    return name, read_json(file, MAX_FILE_BYTES, f"; shipped campaigns: {', '.join(shipped_names())}")


def _campaign(value: Any) -> Campaign:
    known = {"faults", *(one.name for one in fields(Campaign) if one.name != "rows")}
    check_object(value, "", known)
    faults = value.get("faults")
    if not isinstance(faults, list) or not faults:
        raise Wrong("faults", "must be a list of at least one fault")
    rows = tuple(_row(one, f"faults[{number}]") for number, one in enumerate(faults))
    names = [row.name for row in rows]
    for number, name in enumerate(names):
        if name in names[:number]:
            raise Wrong(f"faults[{number}].name", f"'{name}' is there twice; give one of them another name")
    campaign = Campaign(
        name=_text(value.get("name", "campaign"), "name"),
        rows=rows,
        program=_words(value.get("program", []), "program"),
        check=_check(value.get("check", {})),
        camera=_camera(value.get("camera", "")),
        scene=None if value.get("scene") is None else _text(value["scene"], "scene"),
        repeats=check_integer(value.get("repeats", 1), "repeats", 1, MAX_CELLS),
        seed=check_integer(value.get("seed", 0), "seed", 0, 2**53),
        unmapped=_unmapped(value.get("unmapped", {})),
        **{key: check_number(value[key], key, 0, MAX_SECONDS) for key in ("warm_up_s", "hold_s", "recover_s", "stays_s") if key in value},
    )
    if (count := campaign.repeats * sum(len(row.severities) for row in rows)) > MAX_CELLS:
        raise Wrong("faults", f"{count} cells; at most {MAX_CELLS}")
    return campaign


def _row(value: Any, place: str) -> Row:
    check_object(value, place, {"name", "kind", "severity", "severities", "params"})
    if "kind" not in value:
        raise Wrong(f"{place}.kind", "is missing; one of camrig fault kinds, or settings")
    kind = _text(value["kind"], f"{place}.kind")
    severities = value.get("severities", [value.get("severity", 1)])
    if "severities" in value and "severity" in value or not isinstance(severities, list) or not severities:
        raise Wrong(f"{place}.severities", "give severity, or a list of severities")
    numbers = tuple(check_number(one, f"{place}.severities[{number}]", 0, 1) for number, one in enumerate(severities))
    if len(set(numbers)) != len(numbers):
        raise Wrong(f"{place}.severities", "one of them is there twice")
    params = value.get("params", {})
    check_object(params, f"{place}.params", None)
    if kind != "settings" and (own := next((key for key in _OF_THE_ROW if key in params), None)):
        raise Wrong(f"{place}.params.{own}", f"is none of the kind's own parameters: {_OF_THE_ROW[own]}")
    if kind == "settings" and (numbers != (1.0,) or not params):
        raise Wrong(place, "settings have params (fields of camera.set) and no severities")
    if kind == "settings" and (clash := sorted({"name", "seconds", "outputs"} & set(params))):
        raise Wrong(f"{place}.params.{clash[0]}", "cannot be put back; it is not for a campaign")
    return Row(_text(value.get("name", kind), f"{place}.name"), kind, numbers, params)


def _unmapped(value: Any) -> Mapping[str, str]:
    check_object(value, "unmapped", None)
    return {name: _text(reason, f"unmapped.{name}") for name, reason in value.items()}


def _check(value: Any) -> Check:
    if value == {}:
        return Check()
    check_object(value, "check", {"well", "troubled", "every_s", "command"})
    for key in ("well", "troubled"):
        if key in value:
            try:
                re.compile(_text(value[key], f"check.{key}"))
            except re.error as problem:
                raise Wrong(f"check.{key}", f"is no regular expression: {problem}") from None
    every_s = None if value.get("every_s") is None else check_number(value["every_s"], "check.every_s", 0.05, MAX_SECONDS)
    if "command" in value:
        if "well" in value or "troubled" in value:
            raise Wrong("check.command", "goes alone: without well and troubled")
        command = _words(value["command"], "check.command")
        if not command:
            raise Wrong("check.command", "must be a list of words")
        return Check(every_s=every_s or 0.5, command=command)
    if value and every_s is None and not ("well" in value and "troubled" in value):
        raise Wrong("check.every_s", "is missing: seconds within which a line must come (or give well and troubled, both)")
    return Check(value.get("well"), value.get("troubled"), every_s)


def _camera(value: Any) -> str | Mapping[str, Any]:
    if isinstance(value, str):
        return _text(value, "camera", is_empty_good=True)
    check_object(value, "camera", None)
    if not isinstance(value.get("name"), str):
        raise Wrong("camera.name", "is missing")
    return value


def _text(value: Any, place: str, is_empty_good: bool = False) -> str:
    if not isinstance(value, str) or not (value or is_empty_good) or len(value) > 1000:
        raise Wrong(place, "must be a string of 1 to 1000 characters")
    return value


def _words(value: Any, place: str) -> tuple[str, ...]:
    if isinstance(value, str):
        try:
            value = shlex.split(value)
        except ValueError as problem:
            raise Wrong(place, str(problem)) from None
    if not isinstance(value, (list, tuple)) or len(value) > 1000 or not all(isinstance(word, str) for word in value):
        raise Wrong(place, "must be a command line, or a list of its words")
    return tuple(value)
