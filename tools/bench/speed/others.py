"""Other renderers on the same machine, through tools/bench/peers (in an environment of its own; left out where it is not)."""

from __future__ import annotations

import functools
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import cv2
import numpy as np

from . import REPOSITORY, programs
from .plan import Plan

PEERS = REPOSITORY / "tools" / "bench" / "peers"
PYTHON = REPOSITORY / "build" / "peers" / "bin" / "python"
PEER_THREADS = 2  # of llvmpipe, by tools/bench/peers/draw.py, and of camrig beside them
NAMES = ("panda3d", "panda3d-tiny", "mujoco", "pyrender", "vtk")
COUNTS = (4, 12)
#: Of camrig beside them, cameras that move: its qualities, and what llvmpipe makes of the first.
OURS = {"simple": {}, "fast": {"quality": "fast"}, "areas": {"antialias": "coverage"}, "llvmpipe": {"device": "llvmpipe"}}


@dataclass
class SideBySide:
    ours: dict[tuple[str, int], programs.Drawn] | None  # by name in OURS and cameras; None: render_scene is not built
    others: list[dict]  # {name, cameras, per_second, cpu_ms}


@functools.cache
def side_by_side(plan: Plan) -> SideBySide:
    """camrig's turns lie before, between and after the others' runs, which are one each."""
    cases = {(name, cameras): programs.ToMemory(cameras, moving=True, threads=PEER_THREADS, **options) for cameras in COUNTS for name, options in OURS.items()}
    others: list[dict] = []
    groups = [NAMES[i :: programs.TURNS - 1] for i in range(programs.TURNS - 1)]

    def beside(turn: int) -> None:
        if turn > 0 and PYTHON.exists():
            others.extend(_others(plan, groups[turn - 1]))

    ours = programs.in_turns(cases, plan.turn_s, beside)
    return SideBySide(ours, others)


def _others(plan: Plan, names: tuple[str, ...]) -> list[dict]:
    """One that fails is left out, its last line on stderr."""
    results = []
    for name in names:
        for cameras in COUNTS:
            seconds = max(1.0, plan.seconds / 15)
            command = ["timeout", "150", PYTHON, PEERS / "draw.py", name, "--cameras", str(cameras), "--seconds", str(seconds)]
            done = subprocess.run(command, capture_output=True, text=True, cwd=REPOSITORY)
            if done.returncode != 0:
                print(f"{name}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}", file=sys.stderr, flush=True)
                break
            results.append(json.loads(done.stdout.strip().splitlines()[-1]))
    return results


def difference_of_tiny() -> str:
    """How far the picture of Panda3D's own CPU rasteriser is from the one that Panda3D draws with llvmpipe: same scene, light and textures."""
    with tempfile.TemporaryDirectory() as folder:
        pictures = []
        for name in ("panda3d", "panda3d-tiny"):
            file = f"{folder}/{name}.png"
            subprocess.run(["timeout", "150", PYTHON, PEERS / "draw.py", name, "--seconds", "0.1", "--picture", file], capture_output=True, check=True, cwd=REPOSITORY)
            pictures.append(cv2.imread(file).astype(float))
    off = np.abs(pictures[0] - pictures[1])
    return (f"`panda3d-tiny` pays for its frames with the picture: from `panda3d`'s it is off by {off.mean():.1f} codes of 255 in the mean, by more than 10 in {100 * (off.max(axis=2) > 10).mean():.0f} % of the "
            f"pixels (PSNR {10 * np.log10(255**2 / (off**2).mean()):.1f} dB). Textures are not filtered between mip levels and bend within triangles: lines on the floor are crooked, letters unreadable.")


def tiny(plan: Plan, cameras: int) -> dict | None:
    """Panda3D's own CPU rasteriser, which filters no texture; None where the peers are not installed."""
    return next((peer for peer in side_by_side(plan).others if peer["cameras"] == cameras and peer["name"] == "panda3d-tiny"), None)


def best_peer(plan: Plan, cameras: int) -> tuple[str, float]:
    """Who, of those that filter their textures, draws most frames a second, and how many."""
    results = [peer for peer in side_by_side(plan).others if peer["cameras"] == cameras and peer["name"] != "panda3d-tiny"]
    if not results:
        return "best peer with filtered textures on an earlier machine", {4: 59.0, 12: 79.0}[cameras]
    best = max(results, key=lambda peer: peer["per_second"])
    return f"{best['name']} in this run, the best peer with filtered textures", best["per_second"]
