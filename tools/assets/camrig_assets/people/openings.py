"""What shows where a garment is open, and bands over it: strips that lie on the trunk."""

import numpy as np

from ..noise import smoothstep
from ..shapes import grid_normals
from .parts import Part
from .tops import opening_painter
from .trunk import TRUNK

POWER = 2.35  # of the trunk's rings, as Wardrobe.wear_top makes them
ON_TOP = 0.003

# Half width of the opening at a table height, from where it begins.
OPENINGS = {
    "jacket": (1.10, lambda y: (y - 1.10) * 0.24),
    "coat": (1.28, lambda y: (y - 1.28) * 0.30),
    "vneck": (1.34, lambda y: (y - 1.34) * 0.42),
    "blouse": (1.355, lambda y: (y - 1.355) * 0.42),
    "cardigan": (0.90, lambda y: 0.030 + np.maximum(y - 1.0, 0) * 0.075),
}
# The same for the skin in what is under it.
OPEN_COLLARS = {"coat": (1.405, lambda y: (y - 1.405) * 0.6), "cardigan": (1.435, lambda y: 0.030 + (y - 1.0) * 0.075)}


def rows_between(low, high=1.50):
    """Heights at which the trunk has its own rows, so that a strip lies on it between them too, and the ends."""
    return np.array([low, *(y for y in TRUNK if low + 0.01 < y < high - 0.005), high])


class Cover:
    """Places on the outside of a trunk garment."""

    def __init__(self, shaper, ease):
        self.shaper, self.ease = shaper, ease

    def at(self, x, y, front, off=ON_TOP):
        """The point at table height y, x to the left, on the front or the back."""
        half, ahead, behind, z0 = self.shaper.torso_at(max(y, 0.90))
        ease = self.ease(y)
        half, depth = half + ease, (ahead if front else behind) + ease
        x = np.clip(x, -0.985 * half, 0.985 * half)
        z = depth * (1 - np.abs(x / half) ** POWER) ** (1 / POWER)
        return np.array([x * (1 + off / half), self.shaper.lift(y), z0 + (z + off) * (1 if front else -1)])

    def strip(self, name, rows, painter, texels, piece, tags=None):
        """A part of rows of points, each from right to left as seen from outside."""
        grid = np.array(rows)
        heights = np.array([row[len(row) // 2][1] for row in rows])
        weights = self.shaper.torso_weights(heights, grid.shape[1] - 1, grid * self.shaper.s)
        return Part(
            name,
            grid * self.shaper.s,
            weights,
            texels,
            painter,
            normals=grid_normals(grid, False),
            piece=piece,
            tags=tags or {},
        )


def opening(shaper, fabrics, spec, seed, ease, hem):
    """The shirt, or the skin, that shows in front; nothing for what is closed."""
    if spec["style"] not in OPENINGS:
        return []
    cover = Cover(shaper, ease)
    begin, width = OPENINGS[spec["style"]]
    heights = rows_between(max(begin, hem) + 0.004)
    rows = []
    for y in heights:
        half = np.clip(width(y), 0.002, 0.085)
        rows.append([cover.at(x, y, True, ON_TOP + 0.004 * smoothstep(1.42, 1.48, y)) for x in np.linspace(-half, half, 5)])
    skin = spec["style"] in ("vneck", "blouse")
    part = cover.strip(
        "opening",
        rows,
        opening_painter(fabrics, spec, seed),
        (48, 96 if begin < 1.2 else 48),
        "skin" if skin else "plain",
        {"heights": heights},
    )
    made = [part]
    if spec["style"] in OPEN_COLLARS:
        begin, width = OPEN_COLLARS[spec["style"]]
        heights = rows_between(begin + 0.003)
        rows = [[cover.at(x, y, True, ON_TOP + 0.002 + 0.004 * smoothstep(1.42, 1.48, y)) for x in np.linspace(-1, 1, 5) * np.clip(width(y), 0.002, 0.085)] for y in heights]
        made.append(cover.strip("open_collar", rows, fabrics.skin, (32, 24), "skin", {"heights": heights}))
    return made


def neckline(shaper, fabrics, ease):
    """The skin above a round neckline."""
    heights = (1.458, 1.472, 1.486, 1.50)
    ring = shaper.torso("neckline", heights, lambda y: ease(y) + 0.005, columns=18, power=POWER, texels=(64, 16), paint=fabrics.skin)
    ring.piece = "skin"
    return [ring]


def backpack_straps(shaper, ease, painter, piece):
    """Two bands from the ribs over the shoulders to the top of the pack."""
    cover, made = Cover(shaper, ease), []
    for side, sign in (("left", 1), ("right", -1)):
        rows = []
        for y, front in [(y, True) for y in rows_between(1.13, 1.447)] + [(y, False) for y in rows_between(1.30, 1.447)[::-1]]:
            middle = sign * (0.100 - 0.03 * smoothstep(1.30, 1.46, y))
            edges = (middle - 0.022, middle + 0.022)
            rows.append([cover.at(x, y, front, 0.008 + 0.006 * smoothstep(1.37, 1.44, y)) for x in edges])
        top = len(rows_between(1.13, 1.447))
        rows.insert(top, [(a + b) / 2 + (0, 0.022, 0) for a, b in zip(rows[top - 1], rows[top])])
        made.append(cover.strip(f"{side}_strap", rows, painter, (8, 48), piece))
    return made


def cross_strap(shaper, ease, painter, side, piece):
    """From the bag at the hip of this side over the other shoulder, in front and behind."""
    sign = 1 if side == "left" else -1
    cover, made = Cover(shaper, ease), []
    for front in (True, False):
        rows = []
        for y in rows_between(0.96, 1.455):
            middle = sign * (1.22 - y) * 0.66
            edges = (middle - 0.019, middle + 0.019) if front else (middle + 0.019, middle - 0.019)
            rows.append([cover.at(x, y, front, 0.009 + 0.006 * smoothstep(1.37, 1.44, y)) for x in edges])
        made.append(cover.strip(f"strap_{'front' if front else 'back'}", rows, painter, (8, 48), piece))
    return made
