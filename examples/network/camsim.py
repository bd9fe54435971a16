"""CamSim's own kind of world: discs that roam a plane and cameras that are wedges in it, without pictures. The market is this example's own (auction.py, strategies.py,
vision_graph.py), so that its trade of utility against communication can be held against the one that is published, apart from what pictures do to it.

Geometry is ours (a grid of cameras whose headings are drawn), visibility and speeds are of CamSim's kind; random numbers are ours: compare shares and order, not numbers.
"""

from __future__ import annotations

import math

import numpy as np

from .auction import vickrey
from .chance import chance
from .strategies import STRATEGIES
from .vision_graph import VisionGraph

#: CamSim itself, 16 cameras and 4 objects, means of ten runs of 1000 steps: utility and searches as shares of ABC's.
MEASURED = {"ABC": (1.0, 1.0), "ASM": (0.968, 0.412), "AST": (0.863, 0.268), "PBC": (0.971, 0.799), "PSM": (0.941, 0.364), "PST": (0.872, 0.228)}

SIDE = 60.0  # of the square
CAMERAS, OBJECTS = 16, 4
ANGLE_DEG, RANGE = 100.0, 16.0
SPEED = 1.0  # a step


def visibilities(steps: int, seed: int) -> np.ndarray:
    """By step, camera and object: 0 outside of the wedge, else 1 / (d + (r - d) / r) times 1 on the axis to 0 at the edge."""
    rows = math.isqrt(CAMERAS)
    places = (np.stack(np.meshgrid(np.arange(rows), np.arange(rows)), -1).reshape(-1, 2) + 0.5) * SIDE / rows
    headings = np.array([2 * math.pi * chance(seed, "heading", i) for i in range(CAMERAS)])
    at = np.array([[SIDE * chance(seed, "place", i, axis) for axis in "xy"] for i in range(OBJECTS)])
    way = np.array([2 * math.pi * chance(seed, "way", i) for i in range(OBJECTS)])
    values = np.zeros((steps, CAMERAS, OBJECTS))
    for step in range(steps):
        at = at + SPEED * np.stack([np.cos(way), np.sin(way)], 1)
        for i in np.flatnonzero(((at < 0) | (at > SIDE)).any(1)):  # at the border: somewhere else
            at[i] = np.clip(at[i], 0, SIDE)
            way[i] = 2 * math.pi * chance(seed, "turn", step, i)
        off = at[None] - places[:, None]
        d = np.linalg.norm(off, axis=2)
        angle = np.abs((np.arctan2(off[..., 1], off[..., 0]) - headings[:, None] + math.pi) % (2 * math.pi) - math.pi)
        inside = (d < RANGE) & (angle < math.radians(ANGLE_DEG) / 2)
        values[step] = np.where(inside, (1 - angle / (math.radians(ANGLE_DEG) / 2)) / (d + (RANGE - d) / RANGE), 0.0)
    return values


def play(values: np.ndarray, strategy_name: str, seed: int) -> dict[str, float]:
    """Utility (sum of the owners' visibility), communication (searches, as CamSim counts) and hand-overs of one run."""
    strategy, names = STRATEGIES[strategy_name], [f"c{i:02}" for i in range(values.shape[1])]
    graphs = {name: VisionGraph() for name in names}
    owners = [names[int(np.argmax(values[0, :, o]))] for o in range(values.shape[2])]
    before = [0.0] * len(owners)
    utility = searches = handovers = 0.0
    for step, now in enumerate(values):
        for graph in graphs.values():
            graph.evaporate()
        for o, owner in enumerate(owners):
            value = float(now[names.index(owner), o])
            if strategy.offers(value, before[o]):
                peers = [name for name in names if name != owner]
                asked = strategy.asks(peers, graphs[owner], seed, owner, o, step)
                searches += len(asked)
                bids = {peer: float(now[names.index(peer), o]) for peer in asked if now[names.index(peer), o] > 0}
                if (winner := vickrey(owner, value, bids).winner) != owner:
                    graphs[owner].reinforce(winner)
                    owners[o], handovers, value = winner, handovers + 1, bids[winner]
            before[o] = value
            utility += value
    return {"utility": utility, "searches": searches, "handovers": handovers}


def table(steps: int = 1000, seeds: int = 10) -> dict[str, dict[str, float]]:
    """By strategy: means over seeds, and both shares of what ABC has, seed by seed."""
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in STRATEGIES}
    for seed in range(seeds):
        values = visibilities(steps, seed)
        for name in STRATEGIES:
            runs[name].append(play(values, name, seed))
    return {name: {key: float(np.mean([run[key] for run in of])) for key in of[0]}
            | {f"{key}_share": float(np.mean([run[key] / whole[key] for run, whole in zip(of, runs["ABC"])])) for key in ("utility", "searches")} for name, of in runs.items()}
