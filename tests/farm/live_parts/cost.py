"""What the log costs: CPU time of nodes at 100 commands a second and at none, and of one rig alone."""

from __future__ import annotations

import statistics
import threading
import time
from pathlib import Path
from typing import Any

import camrig

from .farm import Farm
from .verdicts import Verdicts

_SECONDS, _RATE, _CLIENTS, _TURNS = 10.0, 100, 20, 4
_BOUND_MS = 1.0
_SEQUENCER_BOUND_MS = 50.0  # of its own: it takes each command, writes it into the log and answers it


def cpu_s(pid: int) -> float:
    """Of all threads that a process has now; finer than the kernel's ticks."""
    return sum(int(path.read_text().split()[0]) for path in Path(f"/proc/{pid}/task").glob("*/schedstat")) / 1e9


def _children_of(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def _command(control: str, rate: float) -> int:
    """So many commands a second, by clients that wait for each answer; how many came."""
    done = [0] * _CLIENTS
    ends = time.monotonic() + _SECONDS

    def client(number: int) -> None:
        rig = camrig.connect(control)
        due = time.monotonic()
        while (due := due + _CLIENTS / rate) < ends:
            time.sleep(max(0.0, due - time.monotonic()))
            rig.call("camera.set", name=f"cam{number}", vfov_deg=40 + done[number] % 10)
            done[number] += 1

    threads = [threading.Thread(target=client, args=(number,)) for number in range(_CLIENTS)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    return sum(done)


def _spent(pids: dict[str, int], control: str, rate: float) -> tuple[dict[str, float], float]:
    """Milliseconds of CPU a second of each process, and the rate that came about."""
    before, began = {name: cpu_s(pid) for name, pid in pids.items()}, time.monotonic()
    done = 0
    if rate:
        done = _command(control, rate)
    else:
        time.sleep(_SECONDS)
    took_s = time.monotonic() - began
    return {name: round((cpu_s(pid) - before[name]) / took_s * 1e3, 2) for name, pid in pids.items()}, round(done / took_s, 1)


def _by_turns(pids: dict[str, int], control: str) -> dict[str, Any]:
    """At no commands and at 100 a second, in turn: the machine is others' too."""
    told: dict[str, list[tuple[dict[str, float], float]]] = {"0": [], str(_RATE): []}
    for _ in range(_TURNS):
        for rate in told:
            told[rate].append(_spent(pids, control, int(rate)))
    found: dict[str, Any] = {rate: {name: round(statistics.median(spent[name] for spent, _ in turns), 2) for name in pids} for rate, turns in told.items()}
    found["spread"] = {name: round(max(spent[name] for spent, _ in told["0"]) - min(spent[name] for spent, _ in told["0"]), 2) for name in pids}
    found["rate"] = min(rate for _, rate in told[str(_RATE)])
    return found


def run(folder: Path, verdicts: Verdicts) -> dict[str, Any]:
    found: dict[str, Any] = {}
    with camrig.start("minimal", device="cpu", quality="fast") as alone:
        _make_cameras(alone)
        info = alone.call("server.info")
        found["alone"] = _by_turns({"rig": info["pid"]}, info["control"])
    with Farm(folder, "minimal", nodes=3) as farm:
        _make_cameras(farm.rig)
        sequencer = farm.sequencer()
        pids = {}
        for name, node in farm.nodes.items():
            role = "sequencer" if name == sequencer else "follower"
            pids[f"{role}: node"], pids[f"{role}: rig"] = node.process.pid, _children_of(node.process.pid)[0]
        found["farm"] = told = _by_turns(pids, farm.control)
    own = found["alone"][str(_RATE)]["rig"] - found["alone"]["0"]["rig"]
    found["log_ms"] = {name: round(told[str(_RATE)][name] - told["0"][name] - (own if name.endswith("rig") else 0.0), 2) for name in pids}
    verdicts.check(f"cost: {_RATE} commands a second are taken", told["rate"] > 0.95 * _RATE, told["rate"])
    for role, bound_ms in (("follower", _BOUND_MS), ("sequencer", _SEQUENCER_BOUND_MS)):
        total = found["log_ms"][f"{role}: node"] + found["log_ms"][f"{role}: rig"]
        spread = told["spread"][f"{role}: node"] + told["spread"][f"{role}: rig"]
        verdicts.check(f"cost: the log takes a {role} at most {bound_ms:g} ms of CPU a second at {_RATE} commands a second, as far as it can be told", total <= bound_ms + spread,
                       f"{total:.1f} ms; the idle ones vary by {spread:.1f} ms")
    return found


def _make_cameras(rig: camrig.Rig) -> None:
    for number in range(_CLIENTS):
        rig.call("camera.create", name=f"cam{number}", size=[160, 120], fps=5, vfov_deg=60)
