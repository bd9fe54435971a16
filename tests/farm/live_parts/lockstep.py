"""In lockstep a farm shows what one machine shows: the log of the farm is done again on a single rig, and each picture compared."""

from __future__ import annotations

import hashlib
import itertools
import random
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Iterator

import camrig

from .farm import Farm, digests_at_one_time, wait_for_all
from .verdicts import Verdicts

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "system"))
from test_command_log import commands, people_of  # noqa: E402

_CAMERAS, _CLIENTS = 24, 3
_STEP_S = 0.2
_STEPS_OF_A_CHECK = 10

Picture = tuple[int, int, str]  # time, number, hash


def pictures(rig: camrig.Rig, verdicts: list[str]) -> dict[str, Picture]:
    """Of every camera; in ``verdicts`` those whose code strip says something else than their header."""
    frames = {camera.name: camera.frame() for camera in rig.cameras()}
    newest_ns = max(frame.time_ns for frame in frames.values())
    for name, frame in frames.items():
        code = camrig.read_code(frame.image) if name.startswith("cam") else None
        # Noise may garble a strip so that its checksum holds all the same: what says a time that has not come is nobody's stamp.
        if code is not None and code.time_ns <= newest_ns and (code.time_ns, code.sequence) != (frame.time_ns, frame.sequence):
            verdicts.append(f"{name}: {code} in frame {frame.sequence} of {frame.time_ns} ns")
    return {name: (frame.time_ns, frame.sequence, hashlib.sha256(frame.image.tobytes()).hexdigest()) for name, frame in frames.items()}


class Clients:
    """They command when they like, but for the moments in which pictures are compared."""

    def __init__(self, control: str, people: list[str], count: int, seconds: float, seed: int) -> None:
        self._turns = threading.Semaphore(_CLIENTS)
        self.sent, self.failed = 0, list[str]()
        self._lock = threading.Lock()
        each = [count // _CLIENTS + (number < count % _CLIENTS) for number in range(_CLIENTS)]
        work = [(control, itertools.islice(commands(seed + number, people, _CAMERAS), _CAMERAS, _CAMERAS + each[number]), seconds / max(1, each[number]), seed + number) for number in range(_CLIENTS)]
        self._threads = [threading.Thread(target=self._run, args=one, daemon=True) for one in work]
        for thread in self._threads:
            thread.start()

    def _run(self, control: str, line: Iterator[tuple[str, dict[str, Any]]], mean_s: float, seed: int) -> None:
        rig, chance = camrig.connect(control), random.Random(seed)
        for method, params in line:
            time.sleep(chance.uniform(0, 2 * mean_s))
            with self._turns:
                try:
                    rig.call(method, **params)
                except camrig.CamrigError as problem:
                    if problem.kind != "already_exists":  # the same on all nodes: a guest of this name
                        self.failed.append(f"{method}: {problem}")
            with self._lock:
                self.sent += 1

    def are_done(self) -> bool:
        return not any(thread.is_alive() for thread in self._threads)

    def __enter__(self) -> None:
        for _ in range(_CLIENTS):
            self._turns.acquire()

    def __exit__(self, *_: Any) -> None:
        self._turns.release(_CLIENTS)


def run(folder: Path, verdicts: Verdicts, *, seconds: float, count: int, seed: int, disturb: bool = False) -> dict[str, Any]:
    name = "lockstep, with what goes wrong" if disturb else "lockstep"
    wrong_stamps: list[str] = []
    checks: list[tuple[int, dict[str, Picture]]] = []  # entry of the log behind which, pictures
    unequal: list[str] = []
    disturbances = list(_DISTURBANCES) if disturb else []
    slowest_s: dict[str, float] = {}  # step, by what was done last
    happened = "nothing"
    with Farm(folder, "hall", "lockstep", servers=3 if disturb else 1) as farm:
        people = people_of(farm.rig)
        for method, params in itertools.islice(commands(seed, people, _CAMERAS), _CAMERAS):
            farm.rig.call(method, **params)
        owners = farm.owners()
        began = time.monotonic()
        clients = Clients(farm.control, people, count, seconds, seed)
        due_s = seconds / (len(_DISTURBANCES) + 1)
        undo: Callable[[], None] | None = None
        for step in itertools.count(1):
            took = time.monotonic()
            farm.rig.step(seconds=_STEP_S, timeout=60)
            slowest_s[happened] = round(max(slowest_s.get(happened, 0.0), time.monotonic() - took), 2)
            if step % _STEPS_OF_A_CHECK == 0:
                with clients:
                    numbers = wait_for_all(farm)
                    hashes = digests_at_one_time(farm)
                    if len(set(hashes.values())) != 1:
                        unequal.append(f"entry {numbers}: {hashes}")
                    checks.append((numbers, pictures(farm.rig, wrong_stamps)))
                if clients.are_done() and not undo and not disturbances:
                    break
                if undo:
                    undo()
                    undo = None
                    farm.wait_for_nodes()
                elif disturbances and time.monotonic() - began > due_s:
                    due_s += seconds / (len(_DISTURBANCES) + 1)
                    happened, do = disturbances.pop(0)
                    undo = do(farm)
            time.sleep(max(0.0, began + step * _STEP_S - time.monotonic()))
        took_s = time.monotonic() - began
        entries = farm.bus.entries()
        nodes = len(set(owners.values()))
    found = {"seconds": round(took_s, 1), "commands": clients.sent, "entries": len(entries), "steps": step, "checks": len(checks), "cameras": len(owners), "nodes": nodes,
             "pictures": sum(len(shown) for _, shown in checks), "slowest_step_s": slowest_s,
             "unequal_checks": len(unequal), "wrong_stamps": len(wrong_stamps)}
    verdicts.check(f"{name}: all commands were taken", not clients.failed and clients.sent == count, clients.failed[:3] or clients.sent)
    verdicts.check(f"{name}: the state of all nodes was equal at {len(checks)} checks", not unequal, unequal[:2] or "")
    verdicts.check(f"{name}: no frame with another's stamp", not wrong_stamps, wrong_stamps[:3] or "")
    different = _differences(entries, checks)
    found["different_pictures"] = len(different)
    verdicts.check(f"{name}: {found['pictures']} pictures of {len(owners)} cameras on {nodes} nodes are those of one machine, to the byte", not different, different[:3] or "")
    return found


def _differences(entries: list[dict[str, Any]], checks: list[tuple[int, dict[str, Picture]]]) -> list[str]:
    """One machine does the log again; what its pictures are not."""
    different: list[str] = []
    waiting = list(checks)
    with camrig.start("hall", mode="lockstep", device="cpu", quality="fast") as alone:
        for number, entry in enumerate(entries, 1):
            if entry["kind"] == "step":
                alone.step(nanoseconds=entry["to_ns"] - entry["at_ns"])
            elif entry["kind"] == "command":
                try:
                    alone.call(entry["method"], **entry["params"])
                except camrig.CamrigError as problem:
                    if problem.kind != "already_exists":
                        different.append(f"entry {number}: {problem}")
            while waiting and waiting[0][0] == number:
                _, shown = waiting.pop(0)
                own = pictures(alone, [])
                different += [f"entry {number}: {camera}: {shown.get(camera)} and not {picture}" for camera, picture in own.items() if shown.get(camera) != picture]
    return different + [f"entry {number} is not in the log" for number, _ in waiting]


def _kill_node(farm: Farm) -> Callable[[], None]:
    victim = farm.nodes[next(name for name in farm.nodes if name != farm.sequencer())]
    victim.kill()
    return victim.start


def _kill_sequencer(farm: Farm) -> Callable[[], None]:
    victim = farm.nodes[farm.sequencer()]
    victim.kill()
    return victim.start


def _stop_node(farm: Farm) -> Callable[[], None]:
    victim = farm.nodes[next(name for name in farm.nodes if name != farm.sequencer())]
    victim.signal(signal.SIGSTOP)
    timer = threading.Timer(5.0, victim.signal, [signal.SIGCONT])
    timer.start()
    return timer.join


def _cut_link(farm: Farm) -> Callable[[], None]:
    victim = farm.nodes[next(name for name in farm.nodes if name != farm.sequencer())]
    victim.set_link(False)
    timer = threading.Timer(5.0, victim.set_link, [True])
    timer.start()
    return timer.join


def _kill_bus(farm: Farm) -> Callable[[], None]:
    victim = farm.bus.leader()
    farm.bus.kill(victim)
    return lambda: farm.bus.start(victim)


_DISTURBANCES = (("a node killed", _kill_node), ("the sequencer's node killed", _kill_sequencer), ("a node stopped for 5 s", _stop_node),
                 ("a node's link down for 5 s", _cut_link), ("the NATS server killed that leads the log, of three", _kill_bus))
