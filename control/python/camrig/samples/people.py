"""People detection with OpenCV's stock HOG detector on live cameras, scored against the truth.

    python -m camrig.samples.people                               # starts scenes/hall.json and looks at its cameras
    python -m camrig.samples.people --control /tmp/camrig.sock --cameras lobby,gallery

A detection is right when it overlaps the full box of a person by half (intersection over union) that no better detection
has taken; both boxes are first given the same aspect, 0.41, about their middles, so that a stretched arm or leg decides nothing
(Dollar, Wojek, Schiele, Perona: Pedestrian Detection: An Evaluation of the State of the Art, PAMI 34, 2012, section 3). People who are hard to see (hidden by more than half, over a fifth outside of the picture, or outside of the height
range) and people who sit neither count as missed nor make a detection of them wrong, as in the usual pedestrian benchmarks.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Iterable

import cv2
import numpy as np

import camrig

Box = tuple[float, float, float, float]  # x, y, width, height; OpenCV's coordinates

HEIGHTS_PX = (80, 300)
DISTANCES_M = (6, 9, 12, 16, math.inf)
STEEPNESS_DEG = (12, 20, 30, math.inf)
VISIBLE = ((0.9, "at least 90 %"), (0.5, "50 to 90 %"), (0.0, "below 50 %"))
OVERLAP = 0.5
ASPECT = 0.41  # width by height of a pedestrian's box
WINDOW_MARGIN = 16 / 128  # of the detector's window, above and below the person it was trained on


def upright(box: Box) -> Box:
    """A box of the same middle and height, ASPECT times as wide as high."""
    x, y, width, height = box
    return (x + (width - ASPECT * height) / 2, y, ASPECT * height, height)


class Detector:
    """OpenCV's HOG detector with its default people model (64 x 128 windows, people of about 100 px)."""

    def __init__(self, enlarge: float, threshold: float) -> None:
        self._hog = cv2.HOGDescriptor()
        self._hog.setSVMDetector(cv2.HOGDescriptor.getDefaultPeopleDetector())
        self._enlarge = enlarge
        self._threshold = threshold

    def __call__(self, image: np.ndarray) -> list[tuple[float, Box]]:
        """(score, box) of everybody it sees, the surest first."""
        large = cv2.resize(image, None, fx=self._enlarge, fy=self._enlarge, interpolation=cv2.INTER_LINEAR)
        boxes, scores = self._hog.detectMultiScale(large, hitThreshold=self._threshold, winStride=(8, 8), padding=(16, 16), scale=1.05)
        found = []
        for (x, y, w, h), score in zip(boxes, np.ravel(scores)):
            box = (x, y + WINDOW_MARGIN * h, w, (1 - 2 * WINDOW_MARGIN) * h)
            found.append((float(score), tuple(float(v) / self._enlarge for v in upright(box))))
        return sorted(found, reverse=True)  # type: ignore[arg-type]


def overlap(a: Box, b: Box) -> float:
    """Intersection over union."""
    width = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    height = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    return width * height / (a[2] * a[3] + b[2] * b[3] - width * height)


def is_seated(person: dict[str, Any]) -> bool:
    """Both thighs nearer to level than to upright; as in CityPersons, who sits is no pedestrian (Zhang, Benenson, Schiele, CVPR 2017)."""
    points = person["keypoints_world"]
    thighs = [(points[hip], points[knee]) for hip, knee in ((11, 13), (12, 14))]  # COCO's numbers
    return all(a is not None and b is not None and abs(a[2] - b[2]) < math.dist(a[:2], b[:2]) for a, b in thighs)


def steepness_deg(person: dict[str, Any], eye: np.ndarray) -> float:
    """How far below the horizon of the camera's place the person's middle is."""
    to = np.array(person["center"]) - eye
    return math.degrees(math.atan2(-to[2], float(np.hypot(to[0], to[1]))))


def counts(person: dict[str, Any]) -> bool:
    """Whether the detector is expected to find this person."""
    return (
        person["visible_fraction"] >= 0.5
        and person["truncated"] <= 0.2
        and HEIGHTS_PX[0] <= person["box_full"][3] <= HEIGHTS_PX[1]
        and not is_seated(person)
    )


@dataclass
class Tally:
    right: int = 0
    wrong: int = 0
    found: dict[Any, int] = field(default_factory=lambda: defaultdict(int))
    there: dict[Any, int] = field(default_factory=lambda: defaultdict(int))

    def add(self, detections: Iterable[tuple[float, Box]], truth: dict[str, Any]) -> list[tuple[Box, str]]:
        """Scores one picture; gives each detection with "right", "wrong" or "ignored"."""
        people = [item for item in truth["objects"] if item["class"] == "person"]
        free = list(people)
        marks = []
        taken = []
        for _, box in detections:
            def fit(person: dict[str, Any], box: Box = box) -> float:
                return overlap(box, upright(person["box_full"]))

            best = max(free, key=lambda person: (counts(person), fit(person)) if fit(person) >= OVERLAP else (False, -1.0), default=None)
            if best is None or fit(best) < OVERLAP:
                self.wrong += 1
                marks.append((box, "wrong"))
                continue
            free.remove(best)
            taken.append(best)
            expected = counts(best)
            self.right += expected
            marks.append((box, "right" if expected else "ignored"))
        eye = np.array(truth["pose"]["position"])
        for person in people:
            height = person["box_full"][3]
            if person["truncated"] > 0.2 or not HEIGHTS_PX[0] <= height <= HEIGHTS_PX[1] or person["pixels"] == 0 or is_seated(person):
                continue
            distance = float(np.linalg.norm(np.array(person["center"]) - eye))
            visible = next(name for limit, name in VISIBLE if person["visible_fraction"] >= limit)
            reach = next(limit for limit in DISTANCES_M if distance < limit)
            keys = [("visible", visible)]
            if counts(person):
                steep = next(limit for limit in STEEPNESS_DEG if steepness_deg(person, eye) < limit)
                keys += [("all",), ("distance", reach), ("steepness", steep)]
                if person["visible_fraction"] >= 0.9:
                    keys.append(("clear",))
            for key in keys:
                self.there[key] += 1
                self.found[key] += any(person is other for other in taken)
        return marks

    def precision(self) -> float:
        return self.right / max(1, self.right + self.wrong)

    def recall(self, *key: Any) -> float:
        return self.found[key] / self.there[key] if self.there[key] else math.nan


def observe(camera: camrig.Camera, min_ns: int = 0) -> tuple[camrig.Frame, dict[str, Any]]:
    """A picture and its truth; in real time the next frame may come between the two."""
    for _ in range(50):
        truth = camera.truth(min_ns)
        frame = camera.frame(min_ns)
        if frame.sequence == truth["sequence"]:
            return frame, truth
        min_ns = frame.time_ns + 1
    raise camrig.CamrigError("unavailable", f"{camera.name}: frames come faster than their truth; use lockstep")


def drawn(image: np.ndarray, marks: list[tuple[Box, str]], truth: dict[str, Any]) -> np.ndarray:
    colors = {"right": (0, 200, 0), "wrong": (0, 0, 255), "ignored": (200, 200, 0)}
    picture = image.copy()
    for person in truth["objects"]:
        if person["class"] == "person" and counts(person):
            x, y, w, h = (round(v) for v in person["box_full"])
            cv2.rectangle(picture, (x, y), (x + w, y + h), (255, 255, 255), 1)
    for (x, y, w, h), mark in marks:
        cv2.rectangle(picture, (round(x), round(y)), (round(x + w), round(y + h)), colors[mark], 2)
    return picture


def table(tallies: dict[str, Tally]) -> str:
    """Markdown."""
    def share(tally: Tally, *key: Any) -> str:
        return f"{tally.recall(*key):.2f} ({tally.there[key]})" if tally.there[key] else "-"

    rows = [["", *tallies], ["---"] * (len(tallies) + 1)]
    rows.append(["precision", *(f"{t.precision():.2f} ({t.right + t.wrong})" for t in tallies.values())])
    rows.append(["recall", *(share(t, "all") for t in tallies.values())])
    rows.append(["recall, at least 90 % visible", *(share(t, "clear") for t in tallies.values())])
    nearest = 0.0
    for limit in DISTANCES_M:
        name = f"from {nearest:g} m" if limit == math.inf else f"{nearest:g} to {limit:g} m"
        rows.append([f"recall, {name}", *(share(t, "distance", limit) for t in tallies.values())])
        nearest = limit
    gentlest = "0"
    for limit in STEEPNESS_DEG:
        name = f"from {gentlest} deg above" if limit == math.inf else f"{gentlest} to {limit} deg above"
        rows.append([f"recall, seen {name}", *(share(t, "steepness", limit) for t in tallies.values())])
        gentlest = str(limit)
    for _, name in VISIBLE:
        rows.append([f"recall, visible {name}", *(share(t, "visible", name) for t in tallies.values())])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def together(tallies: Iterable[Tally]) -> Tally:
    total = Tally()
    for tally in tallies:
        total.right += tally.right
        total.wrong += tally.wrong
        for key, number in tally.there.items():
            total.there[key] += number
            total.found[key] += tally.found[key]
    return total


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m camrig.samples.people", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="scenes/hall.json", help="started in lockstep, if no --control is given")
    parser.add_argument("--control", help="control socket of a running rig")
    parser.add_argument("--cameras", help="NAME,NAME,...; default: all")
    parser.add_argument("--frames", type=int, default=20, help="pictures of each camera (default 20)")
    parser.add_argument("--every", type=float, default=1.0, help="seconds of world time between two pictures (default 1)")
    parser.add_argument("--enlarge", type=float, default=1.6, help="of pictures before the search (default 1.6): the model's people are 100 px tall")
    parser.add_argument("--threshold", type=float, default=0.3, help="of the detector's score (default 0.3)")
    parser.add_argument("--pictures", help="folder for pictures with the boxes drawn: white truth, green right, red wrong, cyan ignored")
    parser.add_argument("--json", action="store_true", help="numbers instead of a table")
    options = parser.parse_args(arguments)

    detector = Detector(options.enlarge, options.threshold)
    tallies: dict[str, Tally] = {}
    with camrig.connect(options.control) if options.control else camrig.start(options.scene, mode="lockstep") as rig:
        names = options.cameras.split(",") if options.cameras else [camera.name for camera in rig.cameras()]
        cameras = [rig.camera(name) for name in names]
        is_lockstep = rig.status()["mode"] == "lockstep"
        due_ns = rig.status()["world_ns"]
        for index in range(options.frames):
            due_ns += round(options.every * 1e9)
            if is_lockstep:
                rig.step(seconds=options.every)
            for camera in cameras:
                frame, truth = observe(camera, 0 if is_lockstep else due_ns)
                marks = tallies.setdefault(camera.name, Tally()).add(detector(frame.image), truth)
                if options.pictures:
                    cv2.imwrite(f"{options.pictures}/{camera.name}-{index:03}.png", drawn(frame.image, marks, truth))
    tallies["all"] = together(list(tallies.values()))
    if options.json:
        json.dump({name: {"precision": t.precision(), "recall": t.recall("all"), "recall_clear": t.recall("clear"), "people": t.there[("all",)]}
                   for name, t in tallies.items()}, sys.stdout, indent=1)
        print()
    else:
        print(table(tallies))
    return 0


if __name__ == "__main__":
    sys.exit(main())
