"""What a detector finds by how sure it is, over many pictures."""

from __future__ import annotations

from typing import Any, Callable

import numpy as np

from camrig.samples.scoring import Tally, counts

#: Detections of one picture as (score, right), and how many people were to be found in it.
Picture = tuple[list[tuple[float, bool]], int]


class Curve:
    def __init__(self, pictures: list[Picture] | None = None) -> None:
        self.pictures = pictures or []

    def add(self, found: list[tuple[float, Any]], truth: dict[str, Any]) -> None:
        """One picture: detections as (score, box), and its truth."""
        scores = {box: score for score, box in found}
        marks = [(scores[box], mark == "right") for box, mark in Tally().add(found, truth) if mark != "ignored"]
        self.pictures.append((marks, sum(one["class"] == "person" and counts(one) for one in truth["objects"])))

    @property
    def people(self) -> int:
        return sum(people for _, people in self.pictures)

    def recall_at(self, false_per_picture: float) -> float:
        """How many people are found where so many detections a picture are wrong."""
        right = wrong = best = 0
        for is_right in self._surest_first():
            right, wrong = right + is_right, wrong + (not is_right)
            if wrong <= false_per_picture * len(self.pictures):
                best = right
        return best / max(1, self.people)

    def average_precision(self) -> float:
        """Area under precision by recall, each precision the best at that recall or more (PASCAL VOC 2010)."""
        marks = np.array(self._surest_first(), float)
        if not len(marks):
            return 0.0
        precision = np.cumsum(marks) / np.arange(1, len(marks) + 1)
        return float((np.maximum.accumulate(precision[::-1])[::-1] * marks).sum() / max(1, self.people))

    def standard_error(self, of: Callable[[Curve], float], samples: int = 200) -> float:
        """By the bootstrap over pictures (Efron 1979); those of one camera are taken seconds apart and resemble each other, so it is more."""
        rng = np.random.default_rng(1)
        return float(np.std([of(Curve([self.pictures[n] for n in rng.integers(0, len(self.pictures), len(self.pictures))])) for _ in range(samples)]))

    def _surest_first(self) -> list[bool]:
        return [is_right for _, is_right in sorted((mark for marks, _ in self.pictures for mark in marks), reverse=True)]
