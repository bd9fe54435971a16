"""Pictures and truth of several cameras, all of one instant."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Sequence

from .errors import CamrigError
from .frame import frame_of, frame_params
from .frame_times import next_due_ns, rate_of

if TYPE_CHECKING:
    from .rig import Rig

KINDS = ("color", "depth", "instance", "semantic", "normal", "sensor", "flow", "soiling", "truth")
#: Each picture that is asked for waits for the instant on a connection of its own.
_MAX_REQUESTS = 32
#: In real time the first instant that is tried lies so far ahead, the next ones up to the most.
_FIRST_LEAD_NS, _MOST_LEAD_NS = 50_000_000, 1_000_000_000
#: Cameras whose frames do not fall together within so much world time have no instant in common.
_LONGEST_SEARCH_NS = 10 * 10**9


class Instant(dict[str, dict[str, Any]]):
    """What Rig.grab returns: {camera: {kind: array}}, and the world time that all of it shows."""

    def __init__(self, time_ns: int, pictures: dict[str, dict[str, Any]]) -> None:
        super().__init__(pictures)
        self.time_ns = time_ns


def grab(rig: Rig, names: Sequence[str], kinds: Sequence[str], timeout_s: float) -> Instant:
    for kind in kinds:
        if kind not in KINDS:
            raise CamrigError("invalid_argument", f"grab: kind '{kind}' is none of {', '.join(KINDS)}")
    if not names or not kinds:
        raise CamrigError("invalid_argument", "grab: give at least one camera and one kind")
    wanted = [(name, kind) for name in dict.fromkeys(names) for kind in dict.fromkeys(kinds)]
    if len(wanted) > _MAX_REQUESTS:
        raise CamrigError("invalid_argument", f"grab: {len(wanted)} pictures; at most {_MAX_REQUESTS} of one instant are taken at once")
    status = rig.status()
    with ThreadPoolExecutor(len(wanted)) as pool:

        def take(min_ns: int | None) -> dict[tuple[str, str], tuple[int, int, Any]]:
            waiting = {what: pool.submit(_take, rig, *what, min_ns, timeout_s) for what in wanted}
            return {what: answer.result() for what, answer in waiting.items()}

        if status["mode"] == "lockstep" or status["paused"]:
            return _of_one_instant(take(None), "the world stands where these cameras show different instants; step it to one at which all are due")
        return _ahead(rig, list(dict.fromkeys(names)), take, timeout_s)


def _ahead(rig: Rig, names: list[str], take: Any, timeout_s: float) -> Instant:
    """Real time: asks for an instant that is still to come, before it comes, and for a later one when not all cameras gave the same."""
    deadline, lead_ns = time.monotonic() + timeout_s, _FIRST_LEAD_NS
    while True:
        rates = [rate_of(rig.call("camera.get", name=name)["fps"]) for name in names]
        instant_ns = _common_instant(names, rates, rig.status()["world_ns"] + lead_ns)
        got = take(instant_ns)
        # Clocks of their own may have them due later than their rates say, and who was late got later ones: together is what counts.
        if len({time_ns for time_ns, _, _ in got.values()}) == 1:
            return _of_one_instant(got, "somebody changes these cameras")
        if time.monotonic() > deadline:
            raise CamrigError("unavailable", f"grab: no instant within {timeout_s:g} s was drawn for all of {', '.join(names)}; camrig stats tells what is dropped")
        lead_ns = min(2 * lead_ns, _MOST_LEAD_NS)


def _common_instant(names: Sequence[str], rates: Sequence[Any], from_ns: int) -> int:
    """The first world time from there on at which a frame of each camera is due."""
    at_ns = from_ns
    while at_ns <= from_ns + _LONGEST_SEARCH_NS:
        latest_ns = max(next_due_ns(rate, at_ns - 1) for rate in rates)
        if latest_ns == at_ns:
            return at_ns
        at_ns = latest_ns
    raise CamrigError(
        "unavailable", f"grab: the frames of {', '.join(names)} do not fall together within {_LONGEST_SEARCH_NS / 1e9:g} s; give the cameras rates that do"
    )


def _take(rig: Rig, name: str, kind: str, min_ns: int | None, timeout_s: float) -> tuple[int, int, Any]:
    """World time, sequence number, and the array or the truth."""
    params: dict[str, Any] = {"camera": name} if min_ns is None else {"camera": name, "min_ns": min_ns}
    if kind == "truth":
        truth = rig.client.call("truth.get", params, timeout_s=timeout_s)
        return truth["time_ns"], truth["sequence"], truth
    params = {**params, **frame_params(name, kind, "raw")}
    frame = frame_of(rig.client.call("frame.get", params, timeout_s=timeout_s, wants_bytes=True), name, kind)
    return frame.time_ns, frame.sequence, frame.image


def _of_one_instant(got: dict[tuple[str, str], tuple[int, int, Any]], why_not: str) -> Instant:
    instants = {time_ns for time_ns, _, _ in got.values()}
    frames = {(name, sequence) for (name, _), (_, sequence, _) in got.items()}
    if len(instants) != 1 or len(frames) != len({name for name, _ in got}):
        shown = ", ".join(sorted({f"{name} at {time_ns} ns" for (name, _), (time_ns, _, _) in got.items()}))
        raise CamrigError("unavailable", f"grab: {why_not} ({shown})")
    pictures: dict[str, dict[str, Any]] = {}
    for (name, kind), (_, _, picture) in got.items():
        pictures.setdefault(name, {})[kind] = picture
    return Instant(instants.pop(), pictures)
