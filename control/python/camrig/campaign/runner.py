"""Runs a campaign: cell by cell, the program anew for each."""

from __future__ import annotations

import contextlib
import hashlib
import os
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping

from ..errors import CamrigError
from .books import Books
from .program import Poller, Program, Watch, wait_well
from .spec import PLACEHOLDERS, Campaign, Cell

if TYPE_CHECKING:
    from ..rig import Rig

_CAMERA = "campaign"
_OUTPUT_CHARS = 2000
#: User-space devices that a campaign's own camera takes the first free of.
_DEVICE_NUMBERS = range(180, 256)
#: What a cell may end as. After the first two the program is well.
OUTCOMES = {
    "unnoticed": "well all the time",
    "recovered": "in trouble, and well again by itself",
    "lost": "not well again in time",
    "ended": "the program ended",
    "never_well": "not well before the fault",
    "refused": "the camera cannot have this fault",
}


@dataclass
class Result:
    """A cell's. Seconds of the wall clock: `noticed_s` from the fault's begin, `recovered_s` from its end (0: before it, or not noticed),
    `ended_s` from its begin. `world_ns` is when it acted, in world time."""

    row: str
    kind: str
    severity: float
    repeat: int
    params: Mapping[str, Any]
    outcome: str = "never_well"
    warm_up_s: float | None = None
    noticed_s: float | None = None
    recovered_s: float | None = None
    ended_s: float | None = None
    exit_code: int | None = None
    reason: str | None = None
    fault_id: int | None = None
    world_ns: tuple[int, int] | None = None
    held_s: float | None = None
    #: (seconds from the fault's begin, is well), the last change before it and all after.
    changes: list[tuple[float, bool]] = field(default_factory=list)
    books: Mapping[str, Any] | None = None
    output: str = ""

    @property
    def is_good(self) -> bool:
        return self.outcome in ("unnoticed", "recovered")


@dataclass
class Report:
    campaign: Campaign
    rig: Mapping[str, Any]
    results: list[Result]

    @property
    def is_good(self) -> bool:
        """Whether the program is well after all faults that its camera can have."""
        return all(result.is_good or result.outcome == "refused" for result in self.results)

    def to_json(self) -> dict[str, Any]:
        outcomes = {name: sum(result.outcome == name for result in self.results) for name in OUTCOMES}
        return {"campaign": self.campaign.to_json(), "rig": dict(self.rig), "outcomes": outcomes,
                "cells": [asdict(result) for result in self.results]}


def run(rig: Rig, campaign: Campaign, tell: Callable[[Result], None] = lambda _: None) -> Report:
    """Runs all cells, in the table's order. A camera that it made for itself is gone afterwards, one that was there is as it was before;
    so they are when this raises: CamrigError, of kind invalid_argument when the program is not well in the first cell."""
    _check_words(campaign)
    status = rig.status()
    if status.get("mode") != "realtime":
        raise CamrigError("invalid_argument", f"campaign: the world's mode is {status.get('mode')}; programs that are tested live need realtime")
    info = rig.info()
    report = Report(campaign, {key: info.get(key) for key in ("version", "renderer")}, [])
    with _camera(rig, campaign) as (name, device):
        _check_rows(rig, campaign, name)
        places = _places(rig, campaign, name, device)
        for cell in campaign.cells():
            result = _run_cell(rig, campaign, cell, name, places)
            report.results.append(result)
            tell(result)
            if result.outcome == "never_well" and len(report.results) == 1:
                raise CamrigError("invalid_argument",
                                  f"program: was not well within {campaign.warm_up_s:g} s, before any fault; it printed: {result.output[-500:]!r}")
    return report


def seed_of(campaign: Campaign, cell: Cell) -> int:
    """Of the fault, from the campaign's seed and the cell alone: a cell is the same whatever others there are."""
    return int.from_bytes(hashlib.sha256(f"{campaign.seed}/{cell.key}".encode()).digest()[:6], "big")


def _run_cell(rig: Rig, campaign: Campaign, cell: Cell, camera: str, places: Mapping[str, str]) -> Result:
    result = Result(cell.row.name, cell.row.kind, cell.severity, cell.repeat, cell.row.params)
    rig.camera(camera).frame(min_ns=int(rig.status()["world_ns"]))  # then the last cell's fault is over for who comes
    check, watch = campaign.check, Watch(campaign.check)
    stays_s = max(campaign.stays_s, check.every_s or 0.0)
    env = {**os.environ, "CAMRIG_CONTROL": places["control"]}
    with contextlib.ExitStack() as stack:
        program = stack.enter_context(Program(_program_words(rig, campaign, places), watch, env))
        if check.command is not None:
            stack.enter_context(Poller(_filled(check.command, places), check.every_s or 0.5, watch, env))
        books = stack.enter_context(Books(rig, camera))
        begun = time.monotonic()
        well_at = wait_well(watch, begun, campaign.stays_s, begun + campaign.warm_up_s, program.is_over)
        result.output = program.output[-_OUTPUT_CHARS:]
        if well_at is None:
            result.exit_code = program.exit_code
            return result
        result.warm_up_s = well_at - begun
        with contextlib.ExitStack() as fault:
            set_at = time.monotonic()
            try:
                start_ns, result.fault_id = _set(rig, campaign, cell, camera, fault)
            except CamrigError as problem:
                if problem.kind != "unsupported":
                    raise
                result.outcome, result.reason = "refused", problem.message
                return result
            _sleep_until(set_at + campaign.hold_s)
        cleared_at, end_ns = time.monotonic(), int(rig.status()["world_ns"])
        result.world_ns, result.held_s = (start_ns, end_ns), cleared_at - set_at
        again_at = wait_well(watch, cleared_at, stays_s, cleared_at + campaign.recover_s + stays_s, program.is_over)
        changes = watch.changes(time.monotonic())
        result.books = books.told()
        result.exit_code = program.exit_code
        result.output = program.output[-_OUTPUT_CHARS:]
    before = [one for one in changes if one[0] < set_at][-1:]
    after = [one for one in changes if one[0] >= set_at]
    result.changes = [(at - set_at, is_well) for at, is_well in before + after]
    result.noticed_s = next((at - set_at for at, is_well in after if not is_well), None)
    if result.exit_code is not None and program.ended_at is not None:
        result.outcome, result.ended_s = "ended", program.ended_at - set_at
    elif again_at is None:
        result.outcome = "lost"
    else:
        result.outcome, result.recovered_s = "unnoticed" if result.noticed_s is None else "recovered", again_at - cleared_at
    return result


def _set(rig: Rig, campaign: Campaign, cell: Cell, camera: str, stack: contextlib.ExitStack) -> tuple[int, int | None]:
    """Sets the cell's fault, and has `stack` undo it; (its begin in world ns, the fault's number)."""
    if cell.row.kind == "settings":
        state = rig.camera(camera).get()
        before = {key: state[key] for key in cell.row.params if key in state}
        stack.callback(lambda: rig.call("camera.set", name=camera, **before))
        done = rig.call("camera.set", name=camera, **cell.row.params)
        return int(done["applied_ns"]), None
    fault = rig.fault.set(camera, cell.row.kind, severity=cell.severity, seed=seed_of(campaign, cell), **cell.row.params)
    stack.callback(lambda: rig.fault.clear(id=fault["id"]))
    return int(fault["start_ns"]), int(fault["id"])


@contextlib.contextmanager
def _camera(rig: Rig, campaign: Campaign) -> Iterator[tuple[str, int | None]]:
    """The campaign's camera, and the number of its user-space device."""
    told = campaign.camera
    if isinstance(told, str) and told:
        if faults := rig.fault.list(told):
            raise CamrigError("invalid_argument", f"campaign: camera {told} has a fault already ({faults[0]['kind']}); camrig fault clear {told}")
        yield told, _device_of(rig.camera(told).get())
        return
    params = dict(told) if isinstance(told, Mapping) else _as_the_first(rig)
    name = params.pop("name", _CAMERA)
    if "outputs" not in params:
        params["outputs"] = [{"kind": "mjpeg"}, {"kind": "rtsp"}] + ([{"kind": "device", "number": _free_number(rig)}] if _uses(campaign, "device") else [])
    rig.call("camera.create", name=name, **params)
    camera = rig.camera(name)
    try:
        yield name, _device_of(camera.get())
    finally:
        camera.delete()


def _as_the_first(rig: Rig) -> dict[str, Any]:
    """A camera that looks where the rig's first one does."""
    params: dict[str, Any] = {"name": _CAMERA, "size": [640, 480], "fps": 25}
    if cameras := rig.cameras():
        state = cameras[0].get()
        params["pose"] = {key: state["world_pose"][key] for key in ("position", "orientation")}
        params["vfov_deg"] = min(state["vfov_deg"] or 60.0, 100.0)
    return params


def _free_number(rig: Rig) -> int:
    taken = {_device_of(camera.get()) for camera in rig.cameras()}
    return next(number for number in _DEVICE_NUMBERS if number not in taken and not Path(f"/dev/video{number}").exists())


def _device_of(state: Mapping[str, Any]) -> int | None:
    return next((int(output["number"]) for output in state["outputs"] if output["kind"] == "device"), None)


def _places(rig: Rig, campaign: Campaign, camera: str, device: int | None) -> dict[str, str]:
    places = {"camera": camera, "http": rig.camera(camera).url("mjpeg"), "control": rig.control or ""}
    if _uses(campaign, "rtsp"):
        places["rtsp"] = rig.camera(camera).url("rtsp")
    if _uses(campaign, "device"):
        if device is None:
            raise CamrigError("invalid_argument", f"{{device}}: camera {camera} has no output of kind device (docs/devices.md)")
        if rig.control is None:
            raise CamrigError("unsupported", "{device}: programs see devices of a rig that is reached by its Unix socket")
        places["device"] = f"/dev/video{device}"
    return places


def _uses(campaign: Campaign, place: str) -> bool:
    return any(f"{{{place}}}" in word for word in (*campaign.program, *(campaign.check.command or ())))


def _check_words(campaign: Campaign) -> None:
    if not campaign.program:
        raise CamrigError("invalid_argument", "program: is missing; camrig fault run CAMPAIGN -- PROGRAM ARGS.., with {rtsp}, {http} or {device} "
                          "where it is told what to read")
    if not any(_uses(campaign, place) for place in PLACEHOLDERS):
        raise CamrigError("invalid_argument", f"program: has none of {', '.join(f'{{{place}}}' for place in PLACEHOLDERS)}: so it would read "
                          "something else than this campaign's camera")


def _check_rows(rig: Rig, campaign: Campaign, camera: str) -> None:
    """That the rig knows all faults and their parameters, before the first cell has taken its time."""
    far_s = rig.status()["world_ns"] * 1e-9 + 3600
    for number, row in enumerate(campaign.rows):
        try:
            if row.kind == "settings":
                with contextlib.ExitStack() as stack:
                    _set(rig, campaign, Cell(row, 1.0, 0), camera, stack)
            else:
                rig.fault.clear(id=rig.fault.set(camera, row.kind, start_s=far_s, **row.params)["id"])
        except CamrigError as problem:
            if problem.kind != "unsupported":
                raise CamrigError(problem.kind, f"faults[{number}]: {problem.message}") from None


def _filled(words: tuple[str, ...], places: Mapping[str, str]) -> list[str]:
    filled = list(words)
    for name, value in places.items():
        filled = [word.replace(f"{{{name}}}", value) for word in filled]
    return filled


def _program_words(rig: Rig, campaign: Campaign, places: Mapping[str, str]) -> list[str]:
    words = _filled(campaign.program, places)
    # User-space devices are seen by programs that camrig exec runs.
    return [rig.program, "--control", places["control"], "exec", "--", *words] if "device" in places else words


def _sleep_until(until: float) -> None:
    while (left := until - time.monotonic()) > 0:
        time.sleep(left)
