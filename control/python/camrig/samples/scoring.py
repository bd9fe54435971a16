"""Detections against the truth, as the Caltech pedestrian benchmark scores them.

Dollar, Wojek, Schiele, Perona: Pedestrian Detection: An Evaluation of the State of the Art, PAMI 34, 2012, section 3. A detection is right
when it overlaps the full box of a person by half (intersection over union) whom no surer detection has taken; both boxes are first given
the same aspect, 0.41, about their middles. People who are hard to see neither count as missed nor make a detection wrong that lies
on them by more than half of its area; so it is with detections beyond the range of heights, widened by 1.25. As in that benchmark, people whom
the edge of the picture cuts off are told apart.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Iterable

import numpy as np

from .hog import intersection, overlap
from .views import Box, upright

HEIGHTS_PX = (80, 300)
WIDENED = 1.25
DISTANCES_M = (6, 9, 12, math.inf)
STEEPNESS_DEG = (12, 20, 30, 40, math.inf)
VISIBLE = ((0.9, "at least 90 %"), (0.5, "50 to 90 %"), (0.0, "below 50 %"))
CLEAR = 0.9  # visible fraction of people who are unoccluded
OVERLAP = 0.5


def is_seated(person: dict[str, Any]) -> bool:
    """Both thighs nearer to level than to upright; as in CityPersons, who sits is no pedestrian (Zhang, Benenson, Schiele, CVPR 2017)."""
    points = person["keypoints_world"]
    thighs = [(points[hip], points[knee]) for hip, knee in ((11, 13), (12, 14))]  # COCO's numbers
    return all(a is not None and b is not None and abs(a[2] - b[2]) < math.dist(a[:2], b[:2]) for a, b in thighs)


def steepness_deg(person: dict[str, Any], eye: np.ndarray) -> float:
    """How far below the horizon of the camera's place the person's middle is."""
    to = np.array(person["center"]) - eye
    return math.degrees(math.atan2(-to[2], float(np.hypot(to[0], to[1]))))


def is_in_range(person: dict[str, Any]) -> bool:
    return person["truncated"] <= 0.2 and HEIGHTS_PX[0] <= person["box_full"][3] <= HEIGHTS_PX[1] and person["pixels"] > 0 and not is_seated(person)


def counts(person: dict[str, Any]) -> bool:
    """Whether the detector is expected to find this person."""
    return is_in_range(person) and person["visible_fraction"] >= 0.5


@dataclass
class Tally:
    right: int = 0
    wrong: int = 0
    found: dict[Any, int] = field(default_factory=lambda: defaultdict(int))
    there: dict[Any, int] = field(default_factory=lambda: defaultdict(int))

    def add(self, detections: Iterable[tuple[float, Box]], truth: dict[str, Any]) -> list[tuple[Box, str]]:
        """Scores one picture; gives each detection with "right", "wrong" or "ignored"."""
        people = [item for item in truth["objects"] if item["class"] == "person" and item["pixels"] > 0]
        marks, taken = self._match([box for _, box in sorted(detections, reverse=True)], people)
        for mark in marks:
            self.right += mark[1] == "right"
            self.wrong += mark[1] == "wrong"
        eye = np.array(truth["pose"]["position"])
        for person in filter(is_in_range, people):
            for key in _kinds(person, eye):
                self.there[key] += 1
                self.found[key] += person["id"] in taken
        return marks

    @staticmethod
    def _match(boxes: list[Box], people: list[dict[str, Any]]) -> tuple[list[tuple[Box, str]], set[int]]:
        free = [person for person in people if counts(person)]
        hard = [person for person in people if not counts(person)]
        marks, taken = [], set()
        for box in boxes:
            if not HEIGHTS_PX[0] / WIDENED <= box[3] <= HEIGHTS_PX[1] * WIDENED:
                continue
            best = max(free, key=lambda person: overlap(box, upright(person["box_full"])), default=None)
            if best is not None and overlap(box, upright(best["box_full"])) >= OVERLAP:
                free.remove(best)
                taken.add(best["id"])
                marks.append((box, "right"))
                continue
            on_hard = next((person for person in hard if intersection(box, tuple(person["box_full"])) > OVERLAP * box[2] * box[3]), None)
            if on_hard is not None:
                taken.add(on_hard["id"])
            marks.append((box, "ignored" if on_hard is not None else "wrong"))
        return marks, taken

    def precision(self) -> float:
        return self.right / (self.right + self.wrong) if self.right + self.wrong else math.nan

    def recall(self, *key: Any) -> float:
        return self.found[key] / self.there[key] if self.there[key] else math.nan


def _kinds(person: dict[str, Any], eye: np.ndarray) -> list[tuple[Any, ...]]:
    """The rows of the table in which a person counts."""
    keys: list[tuple[Any, ...]] = [("visible", next(name for limit, name in VISIBLE if person["visible_fraction"] >= limit))]
    if counts(person):
        keys.append(("all",))
    if person["visible_fraction"] >= CLEAR and person["truncated"] > 0:
        keys.append(("cut",))
    elif person["visible_fraction"] >= CLEAR:
        distance = float(np.linalg.norm(np.array(person["center"]) - eye))
        keys.append(("distance", next(limit for limit in DISTANCES_M if distance < limit)))
        keys.append(("steepness", next(limit for limit in STEEPNESS_DEG if steepness_deg(person, eye) < limit)))
        keys.append(("clear",))
    return keys


def together(tallies: Iterable[Tally]) -> Tally:
    total = Tally()
    for tally in tallies:
        total.right += tally.right
        total.wrong += tally.wrong
        for key, number in tally.there.items():
            total.there[key] += number
            total.found[key] += tally.found[key]
    return total


def table(tallies: dict[str, Tally]) -> str:
    """Markdown."""
    def share(value: float, of: int) -> str:
        return f"{value:.2f} ({of})" if of else "-"

    def row(title: str, *key: Any) -> list[str]:
        return [title, *(share(tally.recall(*key), tally.there[key]) for tally in tallies.values())]

    rows = [["", *tallies], ["---"] * (len(tallies) + 1)]
    rows.append(["precision", *(share(t.precision(), t.right + t.wrong) for t in tallies.values())])
    rows += [row("recall", "all"), *(row(f"recall, {name} visible", "visible", name) for _, name in VISIBLE)]
    rows += [row("recall, at least 90 % visible, cut off by the edge", "cut"), row("**unoccluded**: at least 90 % visible, not cut off", "clear")]
    for kind, limits, unit in (("distance", DISTANCES_M, "m"), ("steepness", STEEPNESS_DEG, "deg above")):
        low = 0.0
        for limit in limits:
            span = f"from {low:g}" if limit == math.inf else f"{low:g} to {limit:g}"
            rows.append(row(f"unoccluded, {span} {unit}", kind, limit))
            low = limit
    return "\n".join("| " + " | ".join(cells) + " |" for cells in rows)
