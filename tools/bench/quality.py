"""python -m tools.bench.quality: what the quality levels look like and cost; writes docs/quality.md and its pictures.

Pictures through frame.get of a rig in lockstep. CPU time is that of the whole program, the JPEG and the request
included (1 to 2 ms at 640x480), so that what else the machine does falls out as far as it can.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tools.bench import report
from tools.bench.speed.meter import Meter

ROOT = report.REPOSITORY
PAGE = ROOT / "docs" / "quality.md"
PICTURES = ROOT / "docs" / "pictures" / "quality"
LEVELS = ("fast", "simple", "beautiful")
#: Scene, place, and the second that is shown.
VIEWS = (("hall", "lobby", 4.0), ("street", "corner", 6.0), ("crowd", "west", 6.0))
SIZES = ((640, 480), (1920, 1080))


def views():
    """Those whose scene is there and has the place."""
    for scene, place, seconds in VIEWS:
        path = ROOT / "scenes" / f"{scene}.json"
        if path.exists() and f'"{place}"' in path.read_text():
            yield scene, path, place, seconds


def take_pictures() -> str:
    PICTURES.mkdir(parents=True, exist_ok=True)
    rows = ["| `fast` | `simple` | `beautiful` |", "|---|---|---|"]
    for scene, path, place, seconds in views():
        cells = []
        with report.start(path, mode="lockstep", device="cpu") as rig:
            cameras = [rig.create_camera(level, place=place, size=(800, 600), fps=5, quality=level) for level in LEVELS]
            rig.step(seconds=seconds)
            for level, camera in zip(LEVELS, cameras):
                name = f"{scene}-{place}-{level}.jpg"
                camera.snapshot(PICTURES / name)
                cells.append(f"![{scene}, {place}, {level}](pictures/quality/{name})")
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def cpu_ms(path: Path, place: str, level: str, size: tuple[int, int], keeps_layers: bool, antialias: str, frames: int) -> float:
    """Of one picture; the first ones, in which layers and tables are made, not counted."""
    options = [] if keeps_layers else ["--static-layer-mb", "0"]
    with report.start(path, mode="lockstep", device="cpu", args=options) as rig:
        camera = rig.create_camera("one", place=place, size=size, fps=25, quality=level, antialias=antialias)
        for _ in range(5):
            rig.step(nanoseconds=40_000_000)
            camera.frame(format="jpeg")
        meter = Meter(rig)
        for _ in range(frames):
            rig.step(nanoseconds=40_000_000)
            camera.frame(format="jpeg")
        return 1e3 * meter.read().cpu_s / frames


def measure(frames: int) -> str:
    rows = [
        "| scene, place | level | " + " | ".join(f"{w}x{h}, standing | {w}x{h}, in full" for w, h in SIZES) + " |",
        "|---|---|" + "---|---|" * len(SIZES),
    ]
    seen = set()
    for scene, path, place, _ in views():
        if scene in seen:
            continue
        seen.add(scene)
        for level, antialias in (*((level, "auto") for level in LEVELS), ("beautiful", "none")):
            cells = []
            for size in SIZES:
                for keeps_layers in (True, False):
                    cells.append(f"{cpu_ms(path, place, level, size, keeps_layers, antialias, frames):.1f}")
            note = ", one sample a pixel" if antialias == "none" else ""
            rows.append(f"| {scene}, {place} | `{level}`{note} | " + " | ".join(cells) + " |")
            print(rows[-1], file=sys.stderr, flush=True)
    return "CPU ms a picture, JPEG and request included.\n\n" + "\n".join(rows)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.quality", description="draws and measures the quality levels, writes docs/quality.md")
    parser.add_argument("--frames", type=int, default=40, help="counted for each number (default 40)")
    parser.add_argument("--only", choices=("pictures", "cost"), help="only this part")
    arguments = parser.parse_args()
    for name, make in (("pictures", take_pictures), ("cost", lambda: measure(arguments.frames))):
        if arguments.only in (None, name):
            report.put(PAGE, name, make(), f"`python -m tools.bench.quality --only {name}`")
    return 0


if __name__ == "__main__":
    sys.exit(main())
