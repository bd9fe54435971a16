"""Other renderers on the same machine, through tools/bench/peers (in an environment of its own; left out where it is not)."""

from __future__ import annotations

import json
import subprocess

from . import REPOSITORY
from .plan import Plan

PEERS = REPOSITORY / "tools" / "bench" / "peers"
PYTHON = REPOSITORY / "build" / "peers" / "bin" / "python"
NAMES = ("panda3d", "panda3d-tiny", "mujoco", "pyrender", "vtk")


def other_renderers(plan: Plan) -> list[dict] | None:
    """[{name, cameras, per_second, cpu_ms}]; None: not installed. One that fails is left out, its last line on stderr."""
    if not PYTHON.exists():
        return None
    results = []
    for name in NAMES:
        for cameras in (4, 12):
            seconds = max(1.0, plan.seconds / 15)
            done = subprocess.run([PYTHON, PEERS / "draw.py", name, "--cameras", str(cameras), "--seconds", str(seconds)], capture_output=True, text=True, cwd=REPOSITORY)
            if done.returncode != 0:
                print(f"{name}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}", flush=True)
                break
            results.append(json.loads(done.stdout.strip().splitlines()[-1]))
    return results
