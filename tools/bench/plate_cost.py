"""python -m tools.bench.plate_cost [--report]

What a picture of a camera with a backdrop costs beside the same standing camera of the full scene: the shipped street as its place `corner` sees
it, 640x480. Each camera is alone in a rig in lockstep, whose world makes the same steps: drawing is the median of the stage `draw`
(stats.get); CPU is that of all threads of the rig a picture but for the thread that decodes a film ahead, which has a column of its own.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tools.bench import report

PAGE = report.REPOSITORY / "docs" / "backdrops.md"
PLACE = {"place": "corner", "size": (640, 480), "fps": 25}
QUALITIES = {"simple": {"quality": "simple"}, "beautiful, without antialiasing": {"quality": "beautiful", "antialias": "none"},
             "beautiful": {"quality": "beautiful", "antialias": "coverage"}}
#: The film's own thread (core/world/backdrop/film_player.cpp).
FILM_THREAD = "camrig-film"
WARM_UP = 10


def make_backdrops(folder: Path) -> dict[str, dict[str, Any]]:
    """The street without anybody as a photo, a film of it, what is all around, and what a projected photo needs."""
    with report.start("street", mode="lockstep", seed=11) as rig:
        for actor in rig.actors():
            rig.remove_actor(actor["name"])
        cam = rig.create_camera("empty", **PLACE, quality="beautiful")
        rig.step(seconds=0.04)
        photo = cam.frame().image
        told = cam.get()
    cv2.imwrite(str(folder / "photo.png"), photo)
    noisy = [np.clip(photo + np.random.default_rng(n).normal(0, 1.5, photo.shape), 0, 255).astype(np.uint8) for n in range(50)]
    subprocess.run(["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "bgr24", "-s", "640x480", "-r", "25", "-i", "-",
                    "-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", str(folder / "film.mp4")],
                   input=b"".join(frame.tobytes() for frame in noisy), check=True, timeout=300)
    cv2.imwrite(str(folder / "sphere.jpg"), cv2.resize(photo, (4096, 2048), interpolation=cv2.INTER_CUBIC))
    proxies = {"scene": "proxies"}
    taken = {"taken_from": {key: told["pose"][key] for key in ("position", "orientation")}, "intrinsics": told["intrinsics"]}
    return {"plate": {"file": str(folder / "photo.png"), "proxies": proxies},
            "film": {"kind": "film", "file": str(folder / "film.mp4"), "proxies": proxies},
            "panorama": {"kind": "panorama", "file": str(folder / "sphere.jpg"), "proxies": proxies},
            "projected": {"kind": "projected", "file": str(folder / "photo.png"), "proxies": proxies, **taken}}


def cpu_s(pid: int) -> tuple[float, float]:
    """Of the film's thread, and of all others."""
    film = rest = 0.0
    for task in Path(f"/proc/{pid}/task").iterdir():
        ns = int((task / "schedstat").read_text().split()[0])
        if (task / "comm").read_text().strip() == FILM_THREAD:
            film += ns / 1e9
        else:
            rest += ns / 1e9
    return film, rest


def measure(pictures: int, is_moving: bool = False, **camera: Any) -> tuple[float, float, float]:
    """Milliseconds a picture: drawing, CPU of the rig, CPU of the film's thread."""
    with report.start("street", mode="lockstep", seed=11) as rig:
        pid = rig.call("server.info")["pid"]
        cam = rig.create_camera("cam", **{**PLACE, **camera})
        pose = cam.get()["pose"]
        place = {key: pose[key] for key in ("position", "orientation")}
        draws = []
        for n in range(WARM_UP + pictures):
            if is_moving:
                x, y, z = place["position"]
                rig.call("camera.set", name="cam", pose={**place, "position": [x + 0.01 * (n % 2), y, z]})
            if n == WARM_UP:
                film, rest = cpu_s(pid)
            before = drawn(rig)
            rig.step(seconds=0.04)
            cam.frame()
            draws.append(drawn(rig) - before)
        film_after, rest_after = cpu_s(pid)
    return float(np.median(draws[WARM_UP:])), 1e3 * (rest_after - rest) / pictures, 1e3 * (film_after - film) / pictures


def drawn(rig: Any) -> float:
    """Milliseconds of drawing so far."""
    stage = next(stage for stage in rig.call("stats.get")["stages"] if stage["name"] == "draw")
    return float(stage["count"] * stage["mean_ms"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", type=int, default=60, help="of each camera (default 60)")
    parser.add_argument("--rounds", type=int, default=3, help="times that each is measured; the least counts (default 3)")
    parser.add_argument("--only", action="append", help="kinds of backdrops to measure, beside the scene (default all)")
    parser.add_argument("--quality", action="append", choices=list(QUALITIES), help="default all")
    parser.add_argument("--report", action="store_true", help="writes the table into docs/backdrops.md")
    options = parser.parse_args()
    qualities = options.quality or list(QUALITIES)
    best: dict[tuple[str, str], tuple[float, float, float]] = {}
    with tempfile.TemporaryDirectory() as name:
        kinds = {"the scene itself": None, **{kind: backdrop for kind, backdrop in make_backdrops(Path(name)).items() if not options.only or kind in options.only}}
        # Nothing is kept of what moves.
        kinds |= {f"{kind}, moving": kinds[kind] for kind in ("the scene itself", "projected") if "projected" in kinds}
        for _ in range(options.rounds):
            for quality in qualities:
                for kind, backdrop in kinds.items():
                    # A projected picture is drawn without antialiasing.
                    if kind.startswith("projected") and quality == "beautiful":
                        continue
                    more = {} if backdrop is None else {"backdrop": backdrop}
                    got = measure(options.pictures, kind.endswith("moving"), **QUALITIES[quality], **more)
                    best[kind, quality] = min(best.get((kind, quality), got), got)
                    print(f"{quality}, {kind}: draw {got[0]:.2f} ms, CPU {got[1]:.2f} ms, film {got[2]:.2f} ms", flush=True)
    rows = ["| camera | " + " | ".join(f"{quality}: drawing, CPU" for quality in qualities) + " | decoding ahead |", "|---" * (len(qualities) + 2) + "|"]
    for kind in kinds:
        cells = [f"{best[kind, quality][0]:.1f}, {best[kind, quality][1]:.1f}" if (kind, quality) in best else "" for quality in qualities]
        ahead = f"{best[kind, qualities[0]][2]:.1f}" if kind == "film" else ""
        rows.append(f"| {kind} | " + " | ".join(cells) + f" | {ahead} |")
    text = "\n".join(rows) + (f"\n\nMilliseconds a picture of 640x480: medians of {options.pictures} of the stage `draw`, and CPU of the whole rig; of {options.rounds} rounds the least.")
    print(text)
    if options.report:
        report.put(PAGE, "cost", text, "`python -m tools.bench.plate_cost --report`")


if __name__ == "__main__":
    main()
