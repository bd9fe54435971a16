"""In real time: how long cameras are away when something dies, who notices, and what the books say."""

from __future__ import annotations

import math
import random
import signal
import statistics
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable

from .farm import Farm, Node, books, digests_at_one_time, dropped_between, wait_until
from .readers import Reader, Seen, Supervisor, longest_gap, missing
from .verdicts import Verdicts

_CAMERAS, _FPS = 12, 5
_BACK_S = 4.0  # what is promised, at the 99th percentile
_AWAY_S = 5.0
_SKEW_MS = 300.0
_SLOW_S = 10.0
_NEVER_S = 30.0


@dataclass
class Case:
    """What one kind of disturbance did, over its repetitions."""

    back_s: list[float] = field(default_factory=list)  #: of each camera of the victim: until the next picture that came after it
    back_each_s: list[float] = field(default_factory=list)  #: the last camera of each repetition
    healthy_lost: int = 0  #: pictures that readers of other nodes missed, beyond what those nodes' books say was dropped for overload
    healthy_reconnects: int = 0
    healthy_gap_s: float = 0.0
    lost: int = 0  #: pictures that readers of the victim missed
    dropped: dict[str, int] = field(default_factory=dict)

    def numbers(self) -> dict[str, Any]:
        return {"times": len(self.back_each_s), "cameras": len(self.back_s), "median_s": round(statistics.median(self.back_s), 2) if self.back_s else None,
                "p99_s": round(percentile(self.back_s, 0.99), 2) if self.back_s else None, "lost": self.lost, "healthy_lost": self.healthy_lost,
                "healthy_reconnects": self.healthy_reconnects, "healthy_gap_s": round(self.healthy_gap_s, 2), "dropped": self.dropped}


def percentile(values: list[float], part: float) -> float:
    """The smallest value that so large a part of them does not exceed."""
    return sorted(values)[max(0, math.ceil(part * len(values)) - 1)]


class Stage:
    """A farm with a reader on each camera, each on the node that owns it."""

    def __init__(self, farm: Farm) -> None:
        self.farm = farm
        for number in range(_CAMERAS):
            farm.rig.call("camera.create", name=f"cam{number}", size=[160, 120], fps=_FPS, vfov_deg=60, pose={"position": [2 + number, 3, 2.8], "look_at": [12, 8, 1]})
        self.readers = [Reader(farm.control, f"cam{number}") for number in range(_CAMERAS)]
        self._supervisor = Supervisor(farm.control, self.readers)
        self.settle()

    def settle(self) -> None:
        """Everybody is there and reads where he should."""
        self.farm.wait_for_nodes()
        moment = time.monotonic()

        def all_read() -> bool:
            owners = self.farm.owners()  # they may change once more
            astray = [reader for reader in self.readers if reader.node != owners[reader.camera]]
            for reader in astray:
                reader.reconnect()
            if astray:
                time.sleep(0.5)
            return not astray and all(any(one.node == owners[reader.camera] for one in reader.since(moment)) for reader in self.readers)

        wait_until(all_read, "all readers to read")

    def disturb(self, case: Case, victim: str, do: Callable[[], None], *, is_held: bool = False) -> None:
        """``is_held``: all worlds stand meanwhile, so pictures of others count only from behind that."""
        mine = [reader for reader in self.readers if self.farm.owners()[reader.camera] == victim]
        others = [reader for reader in self.readers if reader not in mine]
        connections = {reader.camera: reader.connections for reader in self.readers}
        _, before = books(self.farm)
        world_ns = max(reader.newest().world_ns for reader in self.readers)
        moment = time.monotonic()
        do()
        wait_until(lambda: all(first_after(reader, moment, victim, world_ns) for reader in mine), f"the cameras of {victim} to be back", _NEVER_S)
        if is_held:
            wait_until(lambda: all(any(one.world_ns > world_ns + 10**9 for one in reader.since(moment)) for reader in others), "the other cameras to go on", _NEVER_S)
        back_s = [first_after(reader, moment, victim, world_ns).came - moment for reader in mine]
        case.back_s += back_s
        case.back_each_s.append(max(back_s, default=0.0))
        time.sleep(1.0)
        case.lost += sum(missing(_around(reader, moment)) for reader in mine)
        case.healthy_gap_s = max([case.healthy_gap_s, *(longest_gap(_around(reader, moment)) for reader in others)])
        case.healthy_reconnects += sum(reader.connections - connections[reader.camera] for reader in others)
        _, after = books(self.farm)
        drops = dropped_between(before, after)
        for reason, count in drops.items():
            case.dropped[reason] = case.dropped.get(reason, 0) + count
        told = sum(count for reason, count in drops.items() if reason in ("overload", "own_cost") or (is_held and reason == "held"))
        case.healthy_lost += max(0, sum(missing(_around(reader, moment)) for reader in others) - told)

    def end(self) -> None:
        self._supervisor.end()
        for reader in self.readers:
            reader.end()


def first_after(reader: Reader, moment: float, victim: str, world_ns: int) -> Seen | None:
    """The first picture of the camera that shows a time after the event: by another node, or by this one when it goes on."""
    return next((one for one in reader.since(moment) if one.world_ns > world_ns + 300_000_000 and (one.node != victim or one.world_ns > world_ns + int(_AWAY_S * 1e9))), None)


def _around(reader: Reader, moment: float) -> list[Seen]:
    return reader.since(moment - 2.0)


def run(folder: Path, verdicts: Verdicts, *, kills: int, seed: int) -> dict[str, Any]:
    chance = random.Random(seed)
    cases: dict[str, Case] = {}
    with Farm(folder, "hall") as farm:
        stage = Stage(farm)
        cases["a node killed"] = _repeat(stage, kills, lambda: _not_sequencer(farm, chance), _kill)
        cases["the sequencer's node killed"] = _repeat(stage, kills, farm.sequencer, _kill, is_held=True)
        cases["a node stopped for 5 s"] = _repeat(stage, max(1, kills // 7), lambda: _not_sequencer(farm, chance), _stop)
        cases["a node's link down for 5 s"] = _repeat(stage, max(1, kills // 7), lambda: _not_sequencer(farm, chance), _cut)
        cases["the sequencer's link down for 5 s"] = _repeat(stage, max(1, kills // 7), farm.sequencer, _cut, is_held=True)
        slow = _slow(stage, _not_sequencer(farm, chance))
        skew = _skewed(stage, verdicts)
        hashes = digests_at_one_time(farm)
        is_balanced, _ = books(farm)
        stage.end()
    verdicts.check("real time: all nodes are equal at the end", len(hashes) == 4 and len(set(hashes.values())) == 1, hashes)
    verdicts.check("real time: the books balance on every node", is_balanced)
    for name, case in cases.items():
        p99_s = percentile(case.back_s, 0.99) if case.back_s else 0.0
        verdicts.check(f"real time: {name}: its cameras are back within {_BACK_S:.0f} s at the 99th percentile", bool(case.back_s) and p99_s <= _BACK_S, f"{p99_s:.2f} s of {len(case.back_s)}")
        verdicts.check(f"real time: {name}: no reader of another node lost a picture or its connection", case.healthy_lost == 0 and case.healthy_reconnects == 0,
                       f"{case.healthy_lost} pictures, {case.healthy_reconnects} connections")
    verdicts.check("real time: a slow node: no reader of another node lost a picture or its connection",
                   slow["healthy_lost"] == 0 and slow["healthy_reconnects"] == 0, slow)
    return {"fps": _FPS, "cameras": _CAMERAS, "cases": {name: case.numbers() for name, case in cases.items()}, "slow": slow, **skew}


def _not_sequencer(farm: Farm, chance: random.Random) -> str:
    """One that has cameras."""
    sequencer, owners = farm.sequencer(), farm.owners()
    return chance.choice([name for name in farm.nodes if name != sequencer and any(owners[f"cam{number}"] == name for number in range(_CAMERAS))])


def _repeat(stage: Stage, times: int, choose: Callable[[], str], do: Callable[[Node], Callable[[], None]], *, is_held: bool = False) -> Case:
    case = Case()
    for _ in range(times):
        victim = choose()
        undo: list[Callable[[], None]] = []
        stage.disturb(case, victim, lambda: undo.append(do(stage.farm.nodes[victim])), is_held=is_held)
        undo[0]()
        stage.settle()
    return case


def _kill(node: Node) -> Callable[[], None]:
    node.kill()
    return node.start


def _stop(node: Node) -> Callable[[], None]:
    node.signal(signal.SIGSTOP)
    timer = threading.Timer(_AWAY_S, node.signal, [signal.SIGCONT])
    timer.start()
    return timer.join


def _cut(node: Node) -> Callable[[], None]:
    node.set_link(False)
    timer = threading.Timer(_AWAY_S, node.set_link, [True])
    timer.start()
    return timer.join


def _slow(stage: Stage, victim: str) -> dict[str, Any]:
    """Its rig runs for a fiftieth of the time."""
    ends = threading.Event()
    node = stage.farm.nodes[victim]

    def hold() -> None:
        while not ends.is_set():
            node.signal(signal.SIGSTOP, node=False)
            time.sleep(0.49)
            node.signal(signal.SIGCONT, node=False)
            time.sleep(0.01)

    owners = stage.farm.owners()
    mine = [reader for reader in stage.readers if owners[reader.camera] == victim]
    others = [reader for reader in stage.readers if reader not in mine]
    connections = {reader.camera: reader.connections for reader in stage.readers}
    _, before = books(stage.farm)
    moment = time.monotonic()
    holding = threading.Thread(target=hold)
    holding.start()
    time.sleep(_SLOW_S)
    ends.set()
    holding.join()
    time.sleep(1.0)
    _, after = books(stage.farm)
    found = {"seconds": _SLOW_S, "of_node": sum(len(reader.since(moment)) for reader in mine), "due": len(mine) * int(_FPS * (_SLOW_S + 1)), "lost": sum(missing(_around(reader, moment)) for reader in mine),
             "healthy_lost": sum(missing(_around(reader, moment)) for reader in others), "healthy_reconnects": sum(reader.connections - connections[reader.camera] for reader in others),
             "dropped": dropped_between(before, after)}
    stage.settle()
    return found


def _skewed(stage: Stage, verdicts: Verdicts) -> dict[str, Any]:
    """Two more nodes, whose clocks are 300 ms ahead and behind (--clock-ahead-ms: Linux has no namespace for the wall clock)."""
    farm = stage.farm
    told = {}
    for name, ahead_ms in (("early", _SKEW_MS), ("late", -_SKEW_MS)):
        node = Node(farm, name, "--clock-ahead-ms", str(ahead_ms))
        facts = wait_until(lambda name=name: next((one for one in farm.status()["nodes"] if one["node"] == name and one.get("clock_is_off")), None), f"node {name} to be named")
        told[name] = {"told_ms": facts["clock_ahead_ms"], "bound_ms": facts["clock_bound_ms"]}
        verdicts.check(f"real time: a clock {ahead_ms:+.0f} ms off is told within its bound", abs(facts["clock_ahead_ms"] - ahead_ms) <= facts["clock_bound_ms"] + 0.1, told[name])
        verdicts.check(f"real time: node {name} has no cameras, and says why", name not in farm.owners().values() and "its clock is" in node.log.read_text())
        wait_until(lambda name=name: len(set(digests_at_one_time(farm).values())) == 1, f"node {name} to be equal to the others", 20)
        node.kill()
        wait_until(lambda name=name: name not in [one["node"] for one in farm.status()["nodes"]], f"node {name} to be forgotten")
    return {"clocks": told}
