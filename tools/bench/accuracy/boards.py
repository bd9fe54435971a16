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


@dataclass
class Seen:
    """A view and which corners of the board it shows (indices of OBJECT_POINTS); the board may go over the border."""

    view: View
    corners: np.ndarray
    pixels: np.ndarray


def views(camera, count=20, seed=5):
    """`count` views of the board, tilted up to 40 degrees and chosen so that together they fill the picture, as a
    person would wave a board: of many at random, each time the one that covers most of what is bare.
    """
    random = np.random.default_rng(seed)
    cells = (16, 12)
    found, covers = [], []
    for _ in range(20000):
        if len(found) == 8 * count:
            break
        seen = see(camera, _random_view(camera, random))
        if seen is None:
            continue
        column, row = (np.clip(seen.pixels[:, i] * cells[i] / camera.size[i], 0, cells[i] - 1).astype(int) for i in (0, 1))
        cover = np.zeros((cells[1], cells[0]))
        cover[row, column] = 1
        found.append(seen)
        covers.append(cover)
    if len(found) < count:
        raise ValueError(f"{camera.name}: only {len(found)} views show enough of the board")
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
    distance = random.uniform(0.3, 0.65) * camera.fx / 520
    position = middle - distance * np.array([np.cos(tilt) * np.cos(pan), np.cos(tilt) * np.sin(pan), np.sin(tilt)])
    aim = middle + random.uniform(-1, 1, 3) * distance * np.array([0, 1, 1]) * min(320 / camera.fx, 1.2)
    # Turned a little: an edge along the pixels would be as coarse as the samples.
    return looking(position, aim, roll=random.choice([-1, 1]) * random.uniform(0.2, 0.6))


def see(camera, view):
    """The corners in the picture, or None when there are too few, or squares too small."""
    directions = view.optical(world_points())
    angles = np.arctan2(np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2])
    inside = angles < min(0.95 * camera.fold_angle(), np.radians(80))
    pixels = np.full((len(directions), 2), -1e3)
    pixels[inside] = camera.project(directions[inside])
    inside &= ((pixels >= BORDER_PX) & (pixels <= np.array(camera.size) - 1 - BORDER_PX)).all(axis=1)
    grid = np.where(inside[:, None], pixels, np.nan).reshape(INNER[1], INNER[0], 2)
    spacing = np.concatenate([np.linalg.norm(np.diff(grid, axis=a), axis=2).ravel() for a in (0, 1)])
    if inside.sum() < LEAST_CORNERS or np.nanmin(spacing) < LEAST_SQUARE_PX:
        return None
    return Seen(view, np.nonzero(inside)[0], pixels[inside])


BORDER_PX = 7  # room for cornerSubPix's window
LEAST_CORNERS = 60
LEAST_SQUARE_PX = 18
# cornerSubPix's half window and the Gaussian under it. A lens bends edges, which a wide window takes for a shift.
WINDOW_PX, BLUR_PX = {"straight": 6, "bent": 4}, {"straight": 1.6, "bent": 1.0}


def find_corners(light, known, edges):
    """Pixels of corners that are about at `known`, refined by cv2.cornerSubPix from a start up to 1 px beside it.

    Which corner is which is given, as a ChArUco board gives it, so that boards may go over the border of the picture.
    cornerSubPix wants the picture a lens makes: linear light (the sRGB curve moves every edge towards black) and no
    steps (it is off by 0.1 px rms on edges one pixel wide), so it gets linear light under a Gaussian. `edges`: straight
    or bent.
    """
    light = cv2.GaussianBlur(light.astype(np.float32), (0, 0), BLUR_PX[edges])
    start = known + np.random.default_rng(1).uniform(-1, 1, known.shape)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-5)
    corners = start.astype(np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(light, corners, (WINDOW_PX[edges],) * 2, (-1, -1), criteria).reshape(-1, 2)
