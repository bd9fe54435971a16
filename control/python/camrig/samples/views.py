"""How a picture is shown to a detector that knows only people who stand upright.

A view makes the picture that is searched, and takes windows of it back to the camera's picture. Around it lie MARGIN px that repeat its
edge, so that people at the edge can be found: OpenCV's own padding mirrors the picture there, which gives people four legs.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import cv2
import numpy as np

import camrig
from camrig.projection import OPTICAL_FROM_BODY, rotation

Box = tuple[float, float, float, float]  # x, y, width, height; OpenCV's coordinates

ASPECT = 0.41  # width by height of a pedestrian's box
WINDOW_MARGIN = 16 / 128  # of the detector's window, above and below the person it was trained on
MARGIN = 32
STEEPEST = math.radians(70)  # what is straight below has no place in an upright view


def upright(box: Box) -> Box:
    """A box of the same middle and height, ASPECT times as wide as high."""
    x, y, width, height = box
    return (x + (width - ASPECT * height) / 2, y, ASPECT * height, height)


class View(Protocol):
    def picture(self, image: np.ndarray) -> np.ndarray: ...

    def box(self, window: Box) -> Box | None:
        """Of the person whom the detector's window shows, in the camera's picture; None for what cannot be a person."""


class AsSeen:
    """The camera's picture, enlarged; needs to know nothing of the camera."""

    def __init__(self, enlarge: float) -> None:
        self._enlarge = enlarge

    def picture(self, image: np.ndarray) -> np.ndarray:
        large = cv2.resize(image, None, fx=self._enlarge, fy=self._enlarge, interpolation=cv2.INTER_LINEAR)
        return cv2.copyMakeBorder(large, MARGIN, MARGIN, MARGIN, MARGIN, cv2.BORDER_REPLICATE)

    def box(self, window: Box) -> Box | None:
        x, y, width, height = ((window[0] - MARGIN), (window[1] - MARGIN), window[2], window[3])
        margin = WINDOW_MARGIN * height
        large = upright((x, y + margin, width, height - 2 * margin))
        return tuple(value / self._enlarge for value in large)  # type: ignore[return-value]


class Upright:
    """What a calibrated camera makes possible: everybody upright, and no people who float or are 4 m tall.

    The picture is redrawn with the azimuth to the right and, downwards, asinh(tan(depression)): Mercator's projection about the
    vertical through the camera. It is conformal, so that people keep their shape as seen from there, and every vertical line of
    the world is one of the picture. A box must reach from the floor, at height 0, to 1.2 to 2.3 m above it.
    """

    TALL_M = (1.2, 2.3)

    def __init__(self, truth: dict[str, Any], enlarge: float) -> None:
        if truth["lens"]["model"] != "pinhole":
            raise camrig.CamrigError("unsupported", f"{truth['camera']}: its lens is {truth['lens']['model']}; --view upright takes pinhole, --view as-seen any")
        k, (width, height) = truth["intrinsics"], truth["size"]
        self._size = (width, height)
        self._intrinsics = np.array([[k["fx"], 0, k["cx"]], [0, k["fy"], k["cy"]], [0, 0, 1]])
        self._eye = np.array(truth["pose"]["position"])
        self._scale = enlarge * k["fy"]
        world_from_body = rotation(truth["pose"]["orientation"])
        yaw = math.atan2(world_from_body[1, 0], world_from_body[0, 0])
        level = np.array([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])  # world from level body
        self._optical_from_level = OPTICAL_FROM_BODY @ world_from_body.T @ level @ OPTICAL_FROM_BODY.T

        edge = np.array([(x, y, 1) for x in np.linspace(0, width - 1, 65) for y in np.linspace(0, height - 1, 65)])
        rays = edge @ np.linalg.inv(self._intrinsics).T @ self._optical_from_level
        azimuth = np.arctan2(rays[:, 0], rays[:, 2])
        down = np.arcsinh(np.tan(np.clip(np.arctan2(rays[:, 1], np.hypot(rays[:, 0], rays[:, 2])), -STEEPEST, STEEPEST)))
        self._left, right = azimuth.min() * self._scale - MARGIN, azimuth.max() * self._scale + MARGIN
        self._top, bottom = down.min() * self._scale - MARGIN, down.max() * self._scale + MARGIN
        columns, rows = np.meshgrid(np.arange(int(right - self._left)), np.arange(int(bottom - self._top)))
        places = self._places(columns, rows)
        self._map = [np.clip(places[..., i], 0, self._size[i] - 1).astype(np.float32) for i in (0, 1)]

    def _rays(self, x: Any, y: Any) -> np.ndarray:
        """Directions in the level camera's optical frame of places in the upright picture."""
        azimuth = (np.asarray(x, float) + self._left) / self._scale
        down = np.sinh((np.asarray(y, float) + self._top) / self._scale)  # tangent of the depression
        return np.stack([np.sin(azimuth), down, np.cos(azimuth)], axis=-1)

    def _places(self, x: Any, y: Any) -> np.ndarray:
        rays = self._rays(x, y) @ self._optical_from_level.T
        rays[..., 2] = np.maximum(rays[..., 2], 1e-3)  # behind the camera: far outside of the picture
        points = rays @ self._intrinsics.T
        return points[..., :2] / points[..., 2:]

    def picture(self, image: np.ndarray) -> np.ndarray:
        return cv2.remap(image, *self._map, cv2.INTER_LINEAR)

    def box(self, window: Box) -> Box | None:
        x, y, width, height = window
        ends = (y + WINDOW_MARGIN * height, y + (1 - WINDOW_MARGIN) * height)
        head, foot = self._rays([x + width / 2] * 2, ends)[:, 1]
        if foot <= 0 or not self.TALL_M[0] < self._eye[2] * (1 - head / foot) < self.TALL_M[1]:
            return None
        top, bottom = self._places([x + width / 2] * 2, ends)
        tall = bottom[1] - top[1]
        return upright((float(top[0] + bottom[0]) / 2, float(top[1]), 0.0, float(tall))) if tall > 0 else None
