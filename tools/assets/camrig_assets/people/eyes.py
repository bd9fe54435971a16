"""Eyeballs between their lids: small bulging patches on the face, with a picture of their own."""

import numpy as np

from ..noise import mix, smoothstep
from ..shapes import grid_normals
from .paint import rgb
from .parts import Part

CENTRE = (0.0310, 0.1125)
HALF = 0.0140


def lids(ex):
    """Upper and lower edge at this place across the eye."""
    bow = 1 - (ex / HALF) ** 2
    return 0.0072 * bow, -0.0052 * bow


def eyes(head):
    """A part for each eye."""
    colour, made = rgb(head.look.get("eyes", "#4a3728")), []
    for side, sign in (("left", 1), ("right", -1)):
        rows = []
        for t in np.linspace(0, 1, 4):
            row = []
            for s in np.linspace(-0.96, 0.96, 7):
                upper, lower = lids(s * HALF)
                x, y = sign * CENTRE[0] + s * HALF, CENTRE[1] + lower + (upper - lower) * t
                bulge = 0.0022 * (1 - s * s) * (0.4 + 2.4 * t * (1 - t))
                row.append((x, y, head.depth_at(x, y) + 0.0006 + bulge))
            rows.append(row)
        grid = np.array(rows)
        part = Part(
            f"{side}_eyeball",
            head.place(grid),
            head.shaper.blank(4, 6),
            (28, 16),
            _painter(head, colour),
            normals=grid_normals(grid, False),
            piece="plain",
        )
        made.append(head.shaper.fixed(part, "head"))
    return made


def _painter(head, colour):
    def paint(part, points, u, v):
        local = (points / head.shaper.s - head.chin) / head.size
        ex, ey = np.abs(local[..., 0]) - CENTRE[0], local[..., 1] - CENTRE[1]
        white = np.array([0.90, 0.88, 0.86]) * (0.72 + 0.28 * smoothstep(0.006, 0.0, ey))[..., None]
        iris = np.hypot(ex, ey - 0.0006)
        ball = mix(white, colour, smoothstep(0.0066, 0.0058, iris))
        ball = mix(ball, np.array([0.03, 0.02, 0.02]), smoothstep(0.0032, 0.0026, iris))
        # The light of a window in it.
        return mix(ball, np.array([0.95, 0.95, 0.95]), smoothstep(0.0017, 0.0009, np.hypot(ex + 0.0018, ey - 0.0028)))

    return paint
