"""A chequered calibration board in front of the cameras, and what OpenCV's calibration makes of its pictures.

The board of scenes/calibration.json (made by tools/assets/camrig_assets/calibration.py): its squares are geometry, not a
texture, so their corners are exact.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from camrig_assets import calibration as board_asset

from .marks import LINK_FROM_OPTICAL, rotation_of

COLUMNS, ROWS, SQUARE_M = board_asset.COLUMNS, board_asset.ROWS, board_asset.SQUARE_M
INNER = (COLUMNS - 1, ROWS - 1)
# The board stands upright in the world at x = 0, facing -x; its origin is the first inner corner, x right, y down as
# seen from the front, z away from the viewer: OpenCV's own object frame.
OBJECT_POINTS = np.array([[x * SQUARE_M, y * SQUARE_M, 0] for y in range(INNER[1]) for x in range(INNER[0])])


def world_points():
    """The inner corners in the world."""
    first = np.array(board_asset.FIRST_CORNER)
    return first + OBJECT_POINTS @ np.array([[0, -1.0, 0], [0, 0, -1.0], [1.0, 0, 0]])


@dataclass
class View:
    """Where a camera stands and how it looks at the board."""

    position: np.ndarray
    orientation: np.ndarray

    def options(self):
        return {"position": list(self.position), "orientation": list(self.orientation)}

    def optical(self, points):
        return (np.asarray(points) - self.position) @ (rotation_of(self.orientation) @ LINK_FROM_OPTICAL)


def quaternion_of(rotation):
    """x, y, z, w of a rotation matrix."""
    m = rotation
    w = np.sqrt(max(0, 1 + m[0, 0] + m[1, 1] + m[2, 2])) / 2
    x = np.sqrt(max(0, 1 + m[0, 0] - m[1, 1] - m[2, 2])) / 2
    y = np.sqrt(max(0, 1 - m[0, 0] + m[1, 1] - m[2, 2])) / 2
    z = np.sqrt(max(0, 1 - m[0, 0] - m[1, 1] + m[2, 2])) / 2
    q = np.array([np.copysign(x, m[2, 1] - m[1, 2]), np.copysign(y, m[0, 2] - m[2, 0]), np.copysign(z, m[1, 0] - m[0, 1]), w])
    return q / np.linalg.norm(q)


def looking(position, target, roll=0.0):
    """A view from a place at a target, rolled about the line of sight."""
    forward = np.asarray(target, dtype=np.float64) - position
    forward /= np.linalg.norm(forward)
    left = np.cross([0.0, 0, 1], forward)
    left /= np.linalg.norm(left)
    up = np.cross(forward, left)
    c, s = np.cos(roll), np.sin(roll)
    # Positive roll is clockwise seen from behind: up turns to the right.
    rolled_left, rolled_up = c * left + s * up, c * up - s * left
    return View(np.asarray(position, dtype=np.float64), quaternion_of(np.stack([forward, rolled_left, rolled_up], axis=1)))


def views(camera, count=20, seed=5):
    """`count` views that show the whole board, tilted up to 40 degrees and chosen so that together they fill the
    picture, as a person would wave a board: of many at random, each time the one that covers most of what is bare.
    """
    random = np.random.default_rng(seed)
    cells = (16, 12)
    found, covers = [], []
    for _ in range(20000):
        if len(found) == 6 * count:
            break
        view = _random_view(camera, random)
        inner = _inner_corners(camera, view)
        if inner is None:
            continue
        column, row = (np.clip(inner[:, i] * cells[i] / camera.size[i], 0, cells[i] - 1).astype(int) for i in (0, 1))
        cover = np.zeros((cells[1], cells[0]))
        cover[row, column] = 1
        found.append(view)
        covers.append(cover)
    if len(found) < count:
        raise ValueError(f"{camera.name}: only {len(found)} views show the whole board")
    covers, times = np.array(covers), np.zeros((cells[1], cells[0]))
    chosen = []
    for _ in range(count):
        worth = (covers / (1 + times) ** 2).sum(axis=(1, 2))
        worth[chosen] = -1
        chosen.append(int(worth.argmax()))
        times += covers[chosen[-1]]
    return [found[i] for i in chosen]


def _random_view(camera, random):
    middle = np.array([0.0, 0.0, board_asset.CENTRE_HEIGHT_M])
    pan, tilt = np.radians(random.uniform(-40, 40, 2))
    distance = random.uniform(0.3, 0.8) * camera.fx / 520
    position = middle - distance * np.array([np.cos(tilt) * np.cos(pan), np.cos(tilt) * np.sin(pan), np.sin(tilt)])
    aim = middle + random.uniform(-1, 1, 3) * distance * np.array([0, 1, 1]) * min(320 / camera.fx, 1.2)
    return looking(position, aim, roll=random.uniform(-0.4, 0.4))


def _inner_corners(camera, view):
    """The corners' pixels, or None when the board is not all in the picture or too small."""
    directions = view.optical(_outline())
    angles = np.arctan2(np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2])
    if angles.max() > min(0.93 * camera.fold_angle(), np.radians(85)):
        return None
    seen = camera.project(directions)
    if ((seen < 4) | (seen > np.array(camera.size) - 5)).any():
        return None
    # Squares of at least 14 px, so that corners have a neighbourhood of their own.
    inner = camera.project(view.optical(world_points()))
    grid = inner.reshape(INNER[1], INNER[0], 2)
    least = min(np.linalg.norm(np.diff(grid, axis=a), axis=2).min() for a in (0, 1))
    return inner if least >= 14 else None


def _outline():
    edge = []
    for t in np.linspace(-1, 1, 21):
        for a, b in ((t, -1), (t, 1), (-1, t), (1, t)):
            edge.append((0.0, a * (COLUMNS / 2 + 0.6) * SQUARE_M, board_asset.CENTRE_HEIGHT_M + b * (ROWS / 2 + 0.6) * SQUARE_M))
    return np.array(edge)


def find_corners(grey, known):
    """Inner corners in the order of OBJECT_POINTS, refined by cornerSubPix.

    `known` is about where they are: the scene holds more boards, OpenCV may find another or start at the other end.
    """
    found, corners = cv2.findChessboardCorners(grey, INNER, None, cv2.CALIB_CB_ADAPTIVE_THRESH)
    corners = corners.reshape(-1, 2) if found else known
    if np.abs(corners - known).max() > np.abs(corners[::-1] - known).max():
        corners = corners[::-1]
    if np.abs(corners - known).max() > 3:
        corners = known
    grid = known.reshape(INNER[1], INNER[0], 2)
    spacing = min(np.linalg.norm(np.diff(grid, axis=a), axis=2).min() for a in (0, 1))
    half = int(np.clip(spacing / 2 - 1, 3, 8))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    start = np.ascontiguousarray(corners, dtype=np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria).reshape(-1, 2)
