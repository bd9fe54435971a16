"""From a picture to people on the floor: OpenCV's stock people detector, colours of the torso, and what the camera knows of itself."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from camrig.projection import Projection
from camrig.samples.hog import Detector
from camrig.samples.views import AsSeen, Box, Upright, View

from .sighting import Sighting

THRESHOLD, ENLARGE = 0.3, 1.5  # as camrig.samples.people has them
PIXELS = 0.06  # standard deviation of a foot point, in heights of its box
LEAST_M = 0.15  # and at least, on the floor: calibration, the gait
SURE = 1.2  # the detector's score from which it counts as sure
TALL_PX = 120.0  # and who is that high in the picture is seen as well as can be
BINS = 16


class Eye:
    """Of a camera whose calibration is known: size, intrinsics, lens and pose, as camera.get answers them."""

    def __init__(self, calibration: dict[str, Any], is_turning: bool = False) -> None:
        """is_turning: a camera on a head, whose pictures are searched as they are."""
        cv2.setNumThreads(1)  # there are as many processes as cameras
        self._detector = Detector(THRESHOLD)
        self._view: View = AsSeen(ENLARGE) if is_turning else Upright({**calibration, "camera": calibration["name"]}, ENLARGE)
        self._projection = Projection.of(calibration)
        self._size = calibration["size"]

    def turn(self, calibration: dict[str, Any]) -> None:
        """The head looks elsewhere now."""
        self._projection = Projection.of(calibration)

    def __call__(self, image: np.ndarray) -> list[Sighting]:
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        seen = []
        for score, box in self._detector(image, self._view):
            if (floor := self._floor(box)) is not None:
                seen.append(Sighting(*floor, self._value(score, box), _colours(hsv, box), box))
        return seen

    def _floor(self, box: Box) -> tuple[np.ndarray, np.ndarray] | None:
        """Where the foot of the box stands, and how uncertain that is: the pixels' uncertainty taken through the camera to the floor."""
        x, y, width, height = box
        foot = np.array([x + width / 2, y + height])
        places = [self._on_floor(foot + off) for off in ([0, 0], [1, 0], [0, 1])]
        if any(place is None for place in places):
            return None
        jacobian = np.stack([places[1] - places[0], places[2] - places[0]], axis=1) * PIXELS * height
        return places[0], jacobian @ jacobian.T + np.eye(2) * LEAST_M**2

    def _on_floor(self, pixel: np.ndarray) -> np.ndarray | None:
        ray = self._projection.world_from_camera[:3, :3] @ np.linalg.inv(self._projection.K) @ [*pixel, 1.0]
        eye = self._projection.world_from_camera[:3, 3]
        return None if ray[2] >= -1e-3 * np.linalg.norm(ray) else (eye - ray * eye[2] / ray[2])[:2]

    def _value(self, score: float, box: Box) -> float:
        """How well the person is seen, as far as a picture can tell: surely, large, and not about to leave it."""
        x, y, width, height = box
        from_edge = min(x, self._size[0] - x - width) / (self._size[0] / 4)
        return min(score / SURE, 1.0) * min(height / TALL_PX, 1.0) * min(max(from_edge, 0.1), 1.0)


def _colours(hsv: np.ndarray, box: Box) -> np.ndarray:
    """Histograms of hue (weighted by saturation), saturation and value of the torso, each with its largest bin at 255."""
    x, y, width, height = box
    rows = slice(max(0, round(y + 0.18 * height)), max(1, round(y + 0.52 * height)))
    columns = slice(max(0, round(x + 0.28 * width)), max(1, round(x + 0.72 * width)))
    torso = hsv[rows, columns].reshape(-1, 3)
    if not len(torso):
        return np.zeros(3 * BINS, np.uint8)
    weights = (torso[:, 1].astype(float) + 1, None, None)
    bins = [np.histogram(torso[:, i], BINS, (0, 180 if i == 0 else 256), weights=weights[i])[0] for i in range(3)]
    return np.concatenate([np.round(255 * one / one.max()) for one in bins]).astype(np.uint8)
