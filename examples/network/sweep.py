"""What is compared on one recording: strategies, numbers of cameras, links that lose messages, rounds of consensus. Nothing is drawn or looked at again."""

from __future__ import annotations

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Callable, Iterator

import numpy as np

from .nodes import Plan, make_node
from .replay import read_sightings, replay
from .score import read_truth, score
from .strategies import STRATEGIES

ALL = [*STRATEGIES, "central"]
LOSSES = (0.0, 0.05, 0.1, 0.2, 0.4)
ROUNDS = (0, 1, 2, 5, 10)
SWEPT = ("ABC", "AST", "PBC", "PST", "central")  # of the plots against cameras and losses


class Recording:
    """What a run left in its folder."""

    def __init__(self, folder: Path) -> None:
        try:
            self.plan = Plan(**json.loads((folder / "plan.json").read_text()))
            self.truth = read_truth(folder)
            self.sightings = read_sightings(folder, [*self.plan.cameras, *self.plan.heads])
        except (OSError, ValueError, TypeError) as problem:
            raise SystemExit(f"{folder}: no recording of a run: {problem}") from None
        self.times = [line["t"] for line in self.truth]

    def play(self, plan: Plan) -> dict[str, list[dict[str, Any]]]:
        return replay([make_node(plan, name) for name in plan.names()], self.times, self.sightings, plan.rounds, plan.loss, plan.seed)

    def score(self, plan: Plan) -> dict[str, Any]:
        return score(self.truth, self.play(plan), plan.cameras, plan.heads)


def plans(base: Plan, seeds: int) -> Iterator[tuple[str, Any, Plan]]:
    """(which sweep, the value that it varies, plan). Heads look where one run sent them, so they take no part."""
    base = replace(base, heads={}, rounds=0, loss=0.0)
    for seed in range(1, seeds + 1):
        for name in ALL:
            yield "strategy", name, replace(base, strategy=name, seed=seed)
        for name in SWEPT:
            for loss in LOSSES:
                yield f"loss {name}", loss, replace(base, strategy=name, loss=loss, seed=seed)
            for number in sorted({*range(2, len(base.cameras), 2), len(base.cameras)}):
                few = {camera: base.cameras[camera] for camera in list(base.cameras)[:number]}
                yield f"cameras {name}", number, replace(base, strategy=name, cameras=few, seed=seed)
    for rounds in ROUNDS:
        yield "rounds", rounds, replace(base, strategy="ABC", rounds=rounds)


def sweep(folder: Path, seeds: int, on_run: Callable[[int, int], None]) -> dict[str, dict[Any, dict[str, float]]]:
    """Of the recording in `folder`: by sweep and value, means over seeds of every number that a score has. On all cores."""
    jobs = [(which, value, plan, _key(plan)) for which, value, plan in plans(Recording(folder).plan, seeds)]
    unique = {key: plan for _, _, plan, key in jobs}
    scores: dict[str, dict[str, Any]] = {}
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn"), initializer=_open, initargs=(folder,)) as pool:
        for number, (key, got) in enumerate(zip(unique, pool.map(_score, unique.values()))):
            scores[key] = got
            on_run(number + 1, len(unique))
    found: dict[str, dict[Any, list[dict[str, Any]]]] = {}
    for which, value, _, key in jobs:
        found.setdefault(which, {}).setdefault(value, []).append(scores[key])
    return {which: {value: _mean(of) for value, of in by.items()} for which, by in found.items()}


def _key(plan: Plan) -> str:
    """Plans of one key have one result: without losses and drawn audiences nothing depends on the seed."""
    draws = plan.loss or STRATEGIES.get(plan.strategy, STRATEGIES["none"]).audience in ("smooth", "step")
    return f"{plan.strategy} {len(plan.cameras)} {plan.rounds} {plan.loss} {plan.seed if draws else 0}"


_recording: Recording | None = None  # of a worker process


def _open(folder: Path) -> None:
    global _recording
    _recording = Recording(folder)


def _score(plan: Plan) -> dict[str, Any]:
    assert _recording is not None
    return _recording.score(plan)


def _mean(scores: list[dict[str, Any]]) -> dict[str, float]:
    keys = [key for key, value in scores[0].items() if isinstance(value, (int, float))]
    return {key: round(float(np.mean([score[key] for score in scores if score[key] is not None])), 4) for key in keys}
