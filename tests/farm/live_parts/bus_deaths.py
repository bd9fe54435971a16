"""What a farm loses when NATS servers are killed: one of three that keep the log together, or the only one, which then is started again."""

from __future__ import annotations

import statistics
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

import camrig

from .bus import wait_until
from .farm import Farm, books, digests_at_one_time, dropped_between
from .readers import Reader, Supervisor, longest_gap, missing
from .verdicts import Verdicts

_CAMERAS, _FPS, _EACH_S, _DOWN_S = 6, 5, 0.1, 3.0
_AFTER_S, _NEVER_S = 3.0, 60.0


class Commander:
    """One client, which sends a command when the last is answered; each says something else, so that each can be found in the log."""

    def __init__(self, control: str) -> None:
        self.answered: list[tuple[float, float]] = []  # what it set, when the answer came
        self.failed: list[str] = []
        self._control, self._ends = control, threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        rig, sent = camrig.connect(self._control), 0
        while not self._ends.wait(_EACH_S):
            value = round(40 + (sent := sent + 1) * 1e-3, 3)
            try:
                rig.call("camera.set", name="cam0", vfov_deg=value)
            except camrig.CamrigError as problem:
                self.failed.append(str(problem))
            else:
                self.answered.append((value, time.monotonic()))

    def longest_wait_s(self, since: float) -> float:
        came = [at for _, at in list(self.answered) if at > since]
        return max(after - before for before, after in zip([since, *came], came))

    def end(self) -> None:
        self._ends.set()
        self._thread.join(_NEVER_S)


@dataclass
class Deaths:
    """Of one kind of server."""

    command_s: list[float] = field(default_factory=list)  #: the longest wait for a command's answer, of each death
    picture_s: list[float] = field(default_factory=list)  #: and for a picture, of the reader that waited longest
    missed: int = 0  #: pictures, of all readers
    connections: int = 0  #: of readers, that ended
    dropped: dict[str, int] = field(default_factory=dict)

    def numbers(self) -> dict[str, Any]:
        return {"times": len(self.command_s), "command_median_s": round(statistics.median(self.command_s), 2), "command_most_s": round(max(self.command_s), 2),
                "picture_median_s": round(statistics.median(self.picture_s), 2), "picture_most_s": round(max(self.picture_s), 2), "missed": self.missed,
                "connections": self.connections, "dropped": self.dropped}


def run(folder: Path, verdicts: Verdicts, *, kills: int) -> dict[str, Any]:
    found: dict[str, Any] = {"fps": _FPS, "cameras": _CAMERAS, "down_s": _DOWN_S}
    with Farm(folder / "three", "minimal", nodes=3, servers=3) as farm:
        choices: dict[str, Callable[[], int]] = {
            "the one of three that leads the log": farm.bus.leader,
            "another of three": lambda: (farm.bus.leader() + 1) % 3,
        }
        found["cases"] = _kill_in(farm, choices, kills, verdicts)
    with Farm(folder / "one", "minimal", nodes=3) as farm:
        found["cases"] |= _kill_in(farm, {"the only one": lambda: 0}, kills, verdicts)
    return found


def _kill_in(farm: Farm, choices: dict[str, Callable[[], int]], kills: int, verdicts: Verdicts) -> dict[str, Any]:
    for number in range(_CAMERAS):
        farm.rig.call("camera.create", name=f"cam{number}", size=[160, 120], fps=_FPS, vfov_deg=60)
    readers = [Reader(farm.control, f"cam{number}") for number in range(_CAMERAS)]
    supervisor = Supervisor(farm.control, readers)
    commander = Commander(farm.control)
    cases: dict[str, Any] = {}
    for name, choose in choices.items():
        deaths = Deaths()
        for _ in range(kills):
            _one_death(farm, choose(), readers, commander, deaths)
        cases[name] = deaths.numbers()
    commander.end()
    supervisor.end()
    for reader in readers:
        reader.end()
    where = ", ".join(cases)
    in_log = [entry["params"].get("vfov_deg") for entry in farm.bus.entries() if entry["kind"] == "command"]
    astray = [value for value, _ in commander.answered if in_log.count(value) != 1]
    verdicts.check(f"NATS ({where}): {len(commander.answered)} answered commands are in the log, once", not astray, astray[:3] or "")
    verdicts.check(f"NATS ({where}): no command failed", not commander.failed, commander.failed[:2] or "")
    hashes = digests_at_one_time(farm)
    verdicts.check(f"NATS ({where}): all nodes are equal at the end", len(hashes) == len(farm.nodes) and len(set(hashes.values())) == 1, hashes)
    verdicts.check(f"NATS ({where}): the books balance on every node", books(farm)[0])
    return cases


def _one_death(farm: Farm, victim: int, readers: list[Reader], commander: Commander, deaths: Deaths) -> None:
    wait_until(lambda: commander.answered and all(reader.since(time.monotonic() - 1.0) for reader in readers), "all readers to read and commands to be answered", _NEVER_S)
    _, before = books(farm)
    connections = sum(reader.connections for reader in readers)
    moment = time.monotonic()
    farm.bus.kill(victim)
    time.sleep(_DOWN_S)
    if len(farm.bus.ports) == 1:
        farm.bus.start(victim)
    else:  # the two that are left go on by themselves
        wait_until(lambda: commander.answered[-1][1] > moment + _DOWN_S, "a command to be answered", _NEVER_S)
        farm.bus.start(victim)
    wait_until(lambda: commander.answered[-1][1] > moment + _DOWN_S + _AFTER_S, "commands to be answered again", _NEVER_S)
    farm.wait_for_nodes()
    wait_until(lambda: all(reader.newest_at > moment + _DOWN_S + _AFTER_S for reader in readers), "all readers to read again", _NEVER_S)
    time.sleep(_AFTER_S)
    _, after = books(farm)
    deaths.command_s.append(commander.longest_wait_s(moment))
    seen = [reader.since(moment - 1.0) for reader in readers]
    deaths.picture_s.append(max(map(longest_gap, seen)))
    deaths.missed += sum(map(missing, seen))
    deaths.connections += sum(reader.connections for reader in readers) - connections
    for reason, count in dropped_between(before, after).items():
        deaths.dropped[reason] = deaths.dropped.get(reason, 0) + count
