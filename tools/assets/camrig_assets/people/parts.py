"""Building blocks of a body: a `Part` is a grid of vertices with joint weights and its share of the texture.

Tables of measures are in metres for a person of 1.75 m.
"""

from dataclasses import dataclass, field

import numpy as np

from ..shapes import grid_normals, grid_triangles


@dataclass
class Part:
    """A grid of vertices: rows run from its far end (bottom, fingertip) up, columns counter-clockwise from the back;
    column 0 is repeated.
    """

    name: str
    grid: np.ndarray  # rows x columns+1 x 3
    weights: np.ndarray  # rows x columns+1 x joints
    texels: tuple = (64, 64)  # wanted width, height in the texture
    paint: object = None  # function(part, points, u, v) -> sRGB
    normals: np.ndarray = None
    keep: np.ndarray = None  # rows x columns+1, False: outside (triangles with no kept corner are dropped)
    rect: tuple = None  # place in the atlas, set when packed
    piece: str = None  # name of its material; None: by its name (dyes.piece_of)
    uses: "Part" = None  # shares the texture of another part with the same grid topology
    tags: dict = field(default_factory=dict)

    def __post_init__(self):
        if self.normals is None:
            self.normals = grid_normals(self.grid, True)

    def triangles(self):
        triangles = grid_triangles(*self.grid.shape[:2])
        corners = self.grid.reshape(-1, 3)[triangles]
        sound = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 2e-9
        if self.keep is not None:
            sound &= self.keep.reshape(-1)[triangles].any(axis=1)
        return triangles[sound]


def unit_ring(columns, power=2.0, angles=None):
    """(x, z) of a superellipse of radius one, from the back (-z) over the right (-x) to the front; the first point
    is repeated.
    """
    turn = np.linspace(0, 2 * np.pi, columns + 1) if angles is None else np.radians(angles)
    x, z = -np.sin(turn), -np.cos(turn)
    length = (np.abs(x) ** power + np.abs(z) ** power) ** (1 / power)
    return np.stack([x / length, z / length], axis=1)


def ring_at(centre, up, half_width, front, back, columns, power=2.0, facing=(0, 0, 1)):
    """One ring across a bone: `up` points back along the bone, `facing` is where its front looks."""
    up = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    z = np.asarray(facing, dtype=np.float64)
    z = z - up * (z @ up)
    z /= np.linalg.norm(z)
    flat = unit_ring(columns, power)
    depth = np.where(flat[:, 1] > 0, front, back) * flat[:, 1]
    return np.asarray(centre) + flat[:, :1] * half_width * np.cross(up, z) + depth[:, None] * z


def table(rows, at):
    """Smooth interpolation in a table whose first column is the parameter."""
    rows = np.asarray(rows, dtype=np.float64)
    return np.stack([_monotone(rows[:, 0], rows[:, k], at) for k in range(1, rows.shape[1])], axis=-1)


def _monotone(x, y, at):
    """Monotone cubic interpolation (Fritsch-Carlson 1980): no overshoot between the given values."""
    x, y, at = np.asarray(x), np.asarray(y), np.clip(at, x[0], x[-1])
    h = np.diff(x)
    slope = np.diff(y) / h
    tangent = np.zeros_like(y)
    same = slope[:-1] * slope[1:] > 0
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent[1:-1] = np.where(same, (w1 + w2) / (w1 / slope[:-1] + w2 / slope[1:]), 0)
    tangent[0], tangent[-1] = slope[0], slope[-1]
    i = np.clip(np.searchsorted(x, at, "right") - 1, 0, len(h) - 1)
    t = (at - x[i]) / h[i]
    return (
        (2 * t**3 - 3 * t**2 + 1) * y[i]
        + (t**3 - 2 * t**2 + t) * h[i] * tangent[i]
        + (-2 * t**3 + 3 * t**2) * y[i + 1]
        + (t**3 - t**2) * h[i] * tangent[i + 1]
    )
