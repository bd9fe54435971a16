"""How well a network did, by the rig's truth: identities and places by motmetrics (Bernardin, Stiefelhagen 2008; Ristani et al. 2016), the rest by what CamSim publishes."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any, Iterable

import motmetrics
import numpy as np

GATE_M = 1.5  # between where the network says somebody is and where they are
SEEN, TALL_PX = 0.5, 45.0  # people count who show this much, this high, in a camera at least
RANGE_M = 20.0  # of CamSim's visibility
BACK_S = 1.0  # an object that comes back so soon was played to and fro
CLOSE_PX = 120.0  # height in a head's picture (of 360) that makes a close-up
SEARCHES = ("search",)  # CamSim's measure of communication


def visibility(seen: dict[str, float]) -> float:
    """CamSim's, of the true distance and angle off the axis (0 to 1 at the edge of the view), times the share of the person that shows."""
    d = seen["distance_m"]
    if d >= RANGE_M or seen["off_axis"] >= 1:
        return 0.0
    return seen["visible"] * (1 - seen["off_axis"]) / (d + (RANGE_M - d) / RANGE_M)


def read_logs(folder: Path, names: Iterable[str]) -> dict[str, list[dict[str, Any]]]:
    return {name: [json.loads(line) for line in (folder / f"{name}.log.jsonl").read_text().splitlines()] for name in names}


def read_truth(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "truth.jsonl").read_text().splitlines()]


def score(truth: list[dict[str, Any]], logs: dict[str, list[dict[str, Any]]], cameras: Iterable[str], heads: Iterable[str] = ()) -> dict[str, Any]:
    """truth: a line a step (stage.py). logs: of each node; what it said last, at most a second ago, counts (in lockstep: what it said of that very step)."""
    cameras, steps = set(cameras), _steps(truth, logs)
    accumulator = motmetrics.MOTAccumulator()
    numbers: dict[str, int] = {}  # motmetrics wants numbers
    matched: list[dict[str, tuple[str, int]]] = []  # per step: object -> (owner, person)
    utility = best_utility = 0.0
    errors: list[float] = []
    orphans = people_steps = 0
    for index, (line, told) in enumerate(zip(truth, steps)):
        people = {one["id"]: one for one in line["people"] if any(_counts(seen) for camera, seen in one["seen"].items() if camera in cameras)}
        others = np.array([one["floor"] for one in line["people"] if one["id"] not in people]).reshape(-1, 2)
        places = np.array([one["floor"] for one in people.values()]).reshape(-1, 2)
        owned = _owned(told)
        said = np.array([one["floor"] for one in owned]).reshape(-1, 2)
        distances = motmetrics.distances.norm2squared_matrix(places, said, max_d2=GATE_M**2) if len(places) and len(said) else np.full((len(places), len(said)), np.nan)
        # Who is near somebody that does not count is neither right nor wrong.
        ignored = [j for j in range(len(owned)) if not np.isfinite(distances[:, j]).any() and len(others) and np.min(np.linalg.norm(others - said[j], axis=1)) < GATE_M]
        kept = [j for j in range(len(owned)) if j not in ignored]
        ids = [numbers.setdefault(owned[j]["object"], len(numbers) + 1) for j in kept]
        accumulator.update(list(people), ids, distances[:, kept], frameid=index)
        pairs = _pairs(accumulator, index)
        of_number = {number: owned[j] for number, j in zip(ids, kept)}
        matched.append({of_number[hypothesis]["object"]: (of_number[hypothesis]["owner"], person) for person, hypothesis in pairs})
        for person, hypothesis in pairs:
            utility += visibility(people[person]["seen"].get(of_number[hypothesis]["owner"], _NOT))
            errors.append(float(np.linalg.norm(np.array(people[person]["floor"]) - of_number[hypothesis]["floor"])))
        best_utility += sum(max(visibility(seen) for camera, seen in one["seen"].items() if camera in cameras) for one in people.values())
        people_steps += len(people)
        orphans += len(people) - len(pairs)
    identity = motmetrics.metrics.create().compute(accumulator, metrics=["idf1", "mota", "num_switches", "num_misses", "num_false_positives"], name="n").to_dict("records")[0]
    sent, size, lost = Counter(), Counter(), 0
    for lines in logs.values():
        if lines:
            sent.update(lines[-1]["sent"])
            size.update(lines[-1]["bytes"])
            lost += lines[-1]["lost"]
    return {
        "steps": len(truth), "people_steps": people_steps, "utility": round(utility, 3), "relative_utility": round(utility / best_utility, 4) if best_utility else 0.0,
        "coverage": round(1 - orphans / people_steps, 4) if people_steps else 0.0, **_handovers(truth, steps, matched),
        "idf1": round(float(identity["idf1"]), 4), "mota": round(float(identity["mota"]), 4), "switches": int(identity["num_switches"]),
        "misses": int(identity["num_misses"]), "false_positives": int(identity["num_false_positives"]),
        "error_m": round(float(np.mean(errors)), 3) if errors else None, "error_p95_m": round(float(np.quantile(errors, 0.95)), 3) if errors else None,
        "searches": sum(sent[kind] for kind in SEARCHES), "messages": sum(sent.values()), "bytes": sum(size.values()), "lost": lost,
        "messages_by_kind": dict(sorted(sent.items())), "bytes_by_kind": dict(sorted(size.items())), "heads": _heads(truth, steps, matched, sorted(heads)),
        "graph": {name: lines[-1]["graph"] for name, lines in logs.items() if lines and lines[-1].get("graph")}, "overlap": _overlap(truth, sorted(cameras)),
    }


_NOT = {"distance_m": RANGE_M, "off_axis": 1.0, "visible": 0.0}


def _counts(seen: dict[str, float]) -> bool:
    return seen["visible"] >= SEEN and seen["height_px"] >= TALL_PX


def _steps(truth: list[dict[str, Any]], logs: dict[str, list[dict[str, Any]]]) -> list[dict[str, dict[str, Any]]]:
    """What each node had said last at each line of the truth."""
    at = dict.fromkeys(logs, 0)
    steps = []
    for line in truth:
        told = {}
        for name, lines in logs.items():
            while at[name] < len(lines) and lines[at[name]]["t"] <= line["t"]:
                at[name] += 1
            if at[name] and line["t"] - lines[at[name] - 1]["t"] < 10**9:
                told[name] = lines[at[name] - 1]
        steps.append(told)
    return steps


def _owned(told: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """Each object once: where two nodes say that they own it, what was said last, or else by who sees it better."""
    said = sorted(((node["t"], one["value"], one["owner"], one) for node in told.values() for one in node.get("owned", [])), key=lambda entry: entry[:3])
    return list({one["object"]: one for _, _, _, one in said}.values())


def _pairs(accumulator: motmetrics.MOTAccumulator, frame: int) -> list[tuple[int, int]]:
    """(person, hypothesis) that motmetrics has matched in its last frame."""
    events = accumulator.mot_events.xs(frame, level="FrameId")
    events = events[events.Type.isin(["MATCH", "SWITCH", "TRANSFER", "ASCEND", "MIGRATE"])]
    return sorted({(int(person), int(hypothesis)) for person, hypothesis in zip(events.OId, events.HId)})


def _handovers(truth: list[dict[str, Any]], steps: list[dict[str, dict[str, Any]]], matched: list[dict[str, tuple[str, int]]]) -> dict[str, int]:
    """Changes of an object's owner; right: the new owner has the same person as the old; returned: back within BACK_S."""
    owner: dict[str, str] = {}
    person: dict[str, int] = {}
    moved: dict[str, tuple[str, int]] = {}  # object -> (the owner before, when)
    count = right = judged = returned = 0
    for line, told, pairs in zip(truth, steps, matched):
        owners: dict[str, list[str]] = {}
        for one in (one for node in told.values() for one in node.get("owned", [])):
            owners.setdefault(one["object"], []).append(one["owner"])
        for name, all_now in owners.items():
            now = owner[name] if owner.get(name) in all_now else all_now[0]  # of two, the new one has it when the old one has not
            if name in owner and owner[name] != now:
                count += 1
                if name in moved and moved[name][0] == now and line["t"] - moved[name][1] <= BACK_S * 1e9:
                    returned += 1
                if name in person and name in pairs:
                    judged += 1
                    right += person[name] == pairs[name][1]
                moved[name] = (owner[name], line["t"])
            owner[name] = now
        person.update({name: who for name, (_, who) in pairs.items()})
    return {"handovers": count, "handovers_judged": judged, "handovers_right": right, "returned": returned}


def _overlap(truth: list[dict[str, Any]], cameras: list[str]) -> dict[str, dict[str, float]]:
    """Of the people and steps that a camera sees, the share that another sees too: what a learnt vision graph is held against."""
    both, alone = Counter(), Counter()
    for line in truth:
        for one in line["people"]:
            seeing = [camera for camera in cameras if camera in one["seen"] and _counts(one["seen"][camera])]
            alone.update(seeing)
            both.update((a, b) for a in seeing for b in seeing if a != b)
    return {a: {b: round(both[a, b] / alone[a], 3) for b in cameras if both[a, b]} for a in cameras if alone[a]}


def _heads(truth: list[dict[str, Any]], steps: list[dict[str, dict[str, Any]]], matched: list[dict[str, tuple[str, int]]], heads: list[str]) -> dict[str, Any]:
    """Of each head: share of the steps with a target, of those in which it shows it, and large; how many people had a close-up."""
    out, close_people = {}, set()
    for head in heads:
        targets = shown = close = 0
        for line, told, pairs in zip(truth, steps, matched):
            target = told.get(head, {}).get("target")
            if target is None or target not in pairs:
                continue
            targets += 1
            seen = next((one["seen"].get(head) for one in line["people"] if one["id"] == pairs[target][1]), None)
            shown += bool(seen and seen["visible"] >= SEEN)
            if seen and seen["visible"] >= SEEN and seen["height_px"] >= CLOSE_PX:
                close += 1
                close_people.add(pairs[target][1])
        out[head] = {"busy": round(targets / max(len(truth), 1), 3), "shown": round(shown / max(targets, 1), 3), "close_up": round(close / max(targets, 1), 3)}
    return {"each": out, "people": len(close_people)} if heads else {}
