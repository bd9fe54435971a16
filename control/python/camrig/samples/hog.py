"""OpenCV's HOG detector with its default people model (Dalal and Triggs, CVPR 2005): 64 x 128 windows, people of 96 px."""

from __future__ import annotations

import cv2
import numpy as np

from ..errors import CamrigError
from .views import Box, View

WINDOWS = 3  # that must agree on a person, as OpenCV's own grouping asks for
SAME = 0.35  # intersection over union from which two windows show one person


def overlap(a: Box, b: Box) -> float:
    """Intersection over union."""
    shared = intersection(a, b)
    return shared / (a[2] * a[3] + b[2] * b[3] - shared) if shared else 0.0


def intersection(a: Box, b: Box) -> float:
    width = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    height = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    return max(width, 0.0) * max(height, 0.0)


def strongest(found: list[tuple[float, Box]]) -> list[tuple[float, Box]]:
    """Of windows that show one person the one with the best score, and only where WINDOWS agree; OpenCV's grouping would take their
    average, which lies beside the person where some of them are far off."""
    kept: list[tuple[float, Box, int]] = []
    for score, box in sorted(found, reverse=True):
        same = next((i for i, other in enumerate(kept) if overlap(box, other[1]) >= SAME), None)
        if same is None:
            kept.append((score, box, 1))
        else:
            kept[same] = (*kept[same][:2], kept[same][2] + 1)
    return [(score, box) for score, box, windows in kept if windows >= WINDOWS]


class Detector:
    """Needs OpenCV 4, or 5 with its contrib modules, where that has the detector and its model."""

    def __init__(self, threshold: float, model: np.ndarray | None = None) -> None:
        """model: weights and offset of a linear SVM of one's own, for the same windows; None: the stock one."""
        if not hasattr(cv2, "HOGDescriptor"):
            raise CamrigError("unsupported", f"this OpenCV {cv2.__version__} has no HOG people detector; pip install 'camrig[samples]', or opencv-contrib-python-headless in its place")
        self._hog = cv2.HOGDescriptor()
        self._hog.setSVMDetector(cv2.HOGDescriptor.getDefaultPeopleDetector() if model is None else model)
        self._threshold = threshold

    def __call__(self, image: np.ndarray, view: View) -> list[tuple[float, Box]]:
        """(score, box in the image) of everybody it sees, the surest first."""
        windows, scores = self._hog.detectMultiScale(view.picture(image), hitThreshold=self._threshold, winStride=(8, 8), padding=(0, 0), scale=1.05, groupThreshold=0)
        boxes = ((float(score), view.box(tuple(map(float, window)))) for window, score in zip(windows, np.ravel(scores)))  # type: ignore[arg-type]
        return strongest([(score, box) for score, box in boxes if box is not None])
