"""People detection with OpenCV's stock HOG detector on live cameras, scored against the truth.

    python -m camrig.samples.people                               # starts scenes/hall.json and looks at its cameras
    python -m camrig.samples.people --control /tmp/camrig.sock --cameras lobby,gallery

The detector is OpenCV's, with its default people model (OpenCV 4: pip install 'camrig[samples]'; of 5 opencv-contrib-python-headless); hog.py runs it, views.py shows it the pictures, scoring.py says what counts.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, Sequence

import cv2
import numpy as np

import camrig

from ..command_line import run
from .hog import Detector
from .scoring import Tally, counts, table, together
from .views import AsSeen, Box, Upright, View

#: So far ahead a frame is asked for: the rig waits 10 s for one.
_WAIT_NS = 5_000_000_000
COLORS = {"right": (0, 200, 0), "wrong": (0, 0, 255), "ignored": (200, 200, 0)}


def observe(camera: camrig.Camera) -> tuple[camrig.Frame, dict[str, Any]]:
    """A picture and its truth, of a world that stands still."""
    truth, frame = camera.truth(), camera.frame()
    if frame.sequence != truth["sequence"]:
        raise camrig.CamrigError("unavailable", f"{camera.name}: somebody else moves the world or the camera meanwhile")
    return frame, truth


def wait_for(rig: camrig.Rig, camera: str, world_ns: int) -> None:
    """Until the camera of a running world shows that time."""
    for at_ns in (*range(rig.status()["world_ns"] + _WAIT_NS, world_ns, _WAIT_NS), world_ns):
        rig.camera(camera).frame(min_ns=at_ns)


class Views:
    """A view for each camera, made anew when the camera has changed."""

    def __init__(self, kind: str, enlarge: float) -> None:
        self._kind, self._enlarge = kind, enlarge
        self._made: dict[str, tuple[Any, View]] = {}

    def of(self, truth: dict[str, Any]) -> View:
        state = [truth[key] for key in ("size", "intrinsics", "lens", "pose")]
        if truth["camera"] not in self._made or self._made[truth["camera"]][0] != state:
            view = Upright(truth, self._enlarge) if self._kind == "upright" else AsSeen(self._enlarge)
            self._made[truth["camera"]] = (state, view)
        return self._made[truth["camera"]][1]


def drawn(image: np.ndarray, marks: list[tuple[Box, str]], truth: dict[str, Any]) -> np.ndarray:
    picture = image.copy()
    boxes = [(person["box_full"], (255, 255, 255), 1) for person in truth["objects"] if person["class"] == "person" and counts(person)]
    for (x, y, w, h), color, thickness in boxes + [(box, COLORS[mark], 2) for box, mark in marks]:
        cv2.rectangle(picture, (round(x), round(y)), (round(x + w), round(y + h)), color, thickness)
    return picture


def score(rig: camrig.Rig, names: list[str], frames: int, every_s: float, detector: Detector, views: Views, pictures: str | None = None) -> dict[str, Tally]:
    """A tally for each camera, and one of "all". A world in real time stands while its cameras are read. pictures: a folder,
    which is made if it is not there."""
    if pictures:
        Path(pictures).mkdir(parents=True, exist_ok=True)
    tallies: dict[str, Tally] = {name: Tally() for name in names}
    status = rig.status()
    is_lockstep, due_ns = status["mode"] == "lockstep", status["world_ns"]
    for index in range(frames):
        due_ns += round(every_s * 1e9)
        if is_lockstep:
            rig.step(seconds=every_s)
        else:
            wait_for(rig, names[0], due_ns)
            rig.pause()
        try:
            seen = {name: observe(rig.camera(name)) for name in names}
        finally:
            if not is_lockstep:
                rig.resume()
        for name, (frame, truth) in seen.items():
            marks = tallies[name].add(detector(frame.image, views.of(truth)), truth)
            if pictures:
                cv2.imwrite(f"{pictures}/{name}-{index:03}.png", drawn(frame.image, marks, truth))
    return {**tallies, "all": together(tallies.values())}


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m camrig.samples.people", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="scenes/hall.json", help="started in lockstep, if no --control is given")
    parser.add_argument("--control", help="control socket of a running rig")
    parser.add_argument("--cameras", help="NAME,NAME,...; default: all")
    parser.add_argument("--frames", type=int, default=20, help="pictures of each camera (default 20)")
    parser.add_argument("--every", type=float, default=1.0, help="seconds of world time between two pictures (default 1)")
    parser.add_argument("--view", choices=("upright", "as-seen"), default="upright",
                        help="upright (default): uses the camera's pose and lens to turn everybody upright and to drop what stands on no floor; as-seen: the picture alone")
    parser.add_argument("--enlarge", type=float, default=1.5, help="of pictures before the search (default 1.5: people from 64 px)")
    parser.add_argument("--threshold", type=float, default=0.3, help="of the detector's score (default 0.3)")
    parser.add_argument("--pictures", help="folder for pictures with the boxes drawn: white truth, green right, red wrong, cyan ignored")
    parser.add_argument("--json", action="store_true", help="numbers instead of a table")
    options = parser.parse_args(arguments)

    detector = Detector(options.threshold)
    with camrig.connect(options.control) if options.control else camrig.start(options.scene, mode="lockstep") as rig:
        names = options.cameras.split(",") if options.cameras else [camera.name for camera in rig.cameras()]
        tallies = score(rig, names, options.frames, options.every, detector, Views(options.view, options.enlarge), options.pictures)
    if options.json:
        json.dump({name: {"precision": t.precision(), "recall": t.recall("all"), "recall_clear": t.recall("clear"), "people": t.there[("all",)]}
                   for name, t in tallies.items()}, sys.stdout, indent=1)
        print()
    else:
        print(table(tallies))
    return 0


if __name__ == "__main__":
    sys.exit(run(main))
