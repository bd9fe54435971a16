"""Head, face and hair: one grid sculpted from a table and a few bumps; hair is a second shell over the same grid.

Heights are measured from the chin, z from the head's middle axis, metres at the reference height.
"""

import numpy as np

from ..noise import smoothstep
from .eyes import eyes
from .hair import HAIRLINE
from .parts import Part, table, unit_ring

# height, half width, front, back
SKULL = [
    (-0.030, 0.034, 0.048, 0.034),
    (-0.012, 0.044, 0.066, 0.044),
    (0.000, 0.044, 0.080, 0.050),
    (0.010, 0.049, 0.089, 0.054),
    (0.026, 0.057, 0.090, 0.062),
    (0.046, 0.064, 0.090, 0.070),
    (0.066, 0.0685, 0.090, 0.080),
    (0.085, 0.0715, 0.090, 0.088),
    (0.105, 0.0740, 0.090, 0.094),
    (0.120, 0.0755, 0.091, 0.097),
    (0.140, 0.0770, 0.093, 0.100),
    (0.160, 0.0765, 0.088, 0.100),
    (0.180, 0.0715, 0.076, 0.094),
    (0.200, 0.0600, 0.056, 0.078),
    (0.214, 0.0410, 0.034, 0.054),
    (0.2215, 0.0220, 0.016, 0.030),
    (0.225, 0.0, 0.0, 0.0),
]
ROWS = np.array(
    [
        -0.030,
        -0.008,
        0.004,
        0.026,
        0.044,
        0.056,
        0.068,
        0.077,
        0.090,
        0.104,
        0.114,
        0.128,
        0.150,
        0.172,
        0.192,
        0.208,
        0.219,
        0.225,
    ]
)
COLUMNS = np.array([0, 36, 66, 90, 110, 126, 140, 152, 162, 171.5, 180])
ANGLES = np.concatenate([COLUMNS, 360 - COLUMNS[-2::-1]])


def from_front(grid_x, grid_z):
    return np.degrees(np.abs(np.arctan2(grid_x, grid_z)))


class Head:
    """Places the parts of a head on a rig."""

    def __init__(self, shaper, look):
        self.shaper, self.look = shaper, look
        build = shaper.build
        self.size = build.head
        self.chin = np.array([0, 1.75 - 0.225 * build.head, 0.012])
        self.local = self._skull()

    def place(self, local):
        return (local * self.size + self.chin) * self.shaper.s

    def _skull(self):
        female = self.shaper.build.female
        flat, grid = unit_ring(0, 2.25, ANGLES), []
        for y in ROWS:
            half, front, back = table(SKULL, y)
            jaw = 1 - (0.07 * female + 0.02) * smoothstep(0.07, 0.01, y)
            heavy = 1 + 0.07 * max(self.shaper.build.weight, 0) * smoothstep(0.10, 0.03, y)
            x = flat[:, 0] * half * jaw * heavy
            z = np.where(flat[:, 1] > 0, front, back) * flat[:, 1] - 0.006 * smoothstep(0.2, 0.225, y)
            grid.append(np.stack([x, np.full(len(x), y), z], axis=1))
        grid = np.array(grid)
        x, y, z = grid[..., 0], grid[..., 1], grid[..., 2]
        front = smoothstep(0.02, 0.06, z)

        def bump(px, py, wx, wy):
            return np.exp(-(((np.abs(x) - px) / wx) ** 2) - ((y - py) / wy) ** 2) * front

        nose = np.interp(
            y, [0.062, 0.070, 0.077, 0.088, 0.102, 0.113, 0.126], [0.0, 0.013, 0.024, 0.017, 0.010, 0.004, 0.0]
        ) * (1 - 0.12 * female)
        out = nose * np.exp(-((x / np.interp(y, [0.06, 0.08, 0.11], [0.0135, 0.012, 0.008])) ** 2)) * front
        out += -0.0095 * bump(0.030, 0.112, 0.015, 0.010) + 0.004 * (1 - 0.6 * female) * bump(
            0.026, 0.130, 0.022, 0.007
        )
        out += (
            0.005 * bump(0, 0.044, 0.020, 0.009)
            - 0.003 * bump(0, 0.056, 0.012, 0.005)
            + 0.004 * bump(0, 0.010, 0.016, 0.009)
            - 0.002 * bump(0, 0.028, 0.018, 0.006)
        )
        side = 0.004 * np.exp(-(((np.abs(x) - 0.052) / 0.016) ** 2) - ((y - 0.088) / 0.016) ** 2) * front
        grid[..., 2] += out + side
        grid[..., 0] += np.sign(x) * side
        return grid

    def hair_cover(self, local):
        """> 0 where hair grows (metres above the hairline)."""
        line = self.look["hairline"]
        if line is None:
            return np.full(local.shape[:-1], -1.0)
        degrees, heights = np.array(HAIRLINE[line]).T
        angle = from_front(local[..., 0], local[..., 2])
        angle = np.where(local[..., 1] > 0.2, np.minimum(angle, 180), angle)
        return local[..., 1] - np.interp(angle, degrees, heights)

    def parts(self, paint, paint_hair):
        shaper, made = self.shaper, []
        rows, columns = self.local.shape[:2]
        head = Part(
            "head",
            self.place(self.local),
            np.zeros((rows, columns, shaper.count)),
            (192, 176),
            paint,
            tags={"local": self.local},
        )
        shaper.fixed(head, "head")
        w_neck = 0.55 * (1 - smoothstep(-0.03, 0.02, self.local[..., 1]))
        head.weights[..., shaper.j("neck")], head.weights[..., shaper.j("head")] = w_neck, 1 - w_neck
        made.append(head)
        if self.look.get("ears", True):
            for side, sign in (("left", 1), ("right", -1)):
                tilt = np.array(
                    [
                        [np.cos(sign * 0.35), 0, np.sin(sign * 0.35)],
                        [0, 1, 0],
                        [-np.sin(sign * 0.35), 0, np.cos(sign * 0.35)],
                    ]
                )
                centre = self.chin + np.array([sign * 0.0775, 0.100, -0.006]) * self.size
                made.append(
                    shaper.blob(
                        f"{side}_ear_shape",
                        "head",
                        centre,
                        np.array([0.008, 0.031, 0.019]) * self.size,
                        6,
                        5,
                        paint,
                        (12, 12),
                        2.2,
                        tilt,
                    )
                )
        if self.look["hairline"]:
            made.append(self._shell(head, paint_hair))
        return made + eyes(self)

    def depth_at(self, x, y):
        """z of the face at (x, y): between the grid's rows, which are level."""
        row = int(np.clip(np.searchsorted(ROWS, y, "right") - 1, 0, len(ROWS) - 2))
        share = (y - ROWS[row]) / (ROWS[row + 1] - ROWS[row])
        found = []
        for points in self.local[row : row + 2]:
            front = points[points[:, 2] > 0]
            front = front[np.argsort(front[:, 0])]
            found.append(np.interp(x, front[:, 0], front[:, 2]))
        return found[0] * (1 - share) + found[1] * share

    def _shell(self, head, paint_hair):
        """Hair lying on the skull: the head's grid pushed out by the hair's thickness, cut at the hairline."""
        cover = self.hair_cover(self.local)
        thick = self.look["thickness"]
        y, z = self.local[..., 1], self.local[..., 2]
        crown = thick * (
            1
            + self.look.get("crown", 0.3) * smoothstep(0.15, 0.21, y)
            + self.look.get("quiff", 0.0) * smoothstep(0.15, 0.19, y) * smoothstep(0.02, 0.07, z)
        )
        rise = np.where(cover > 0, smoothstep(0, 0.022, cover) * crown + 0.002, -0.004)
        shell = self.local + head.normals * rise[..., None]
        return Part(
            "hair", self.place(shell), head.weights.copy(), (128, 112), paint_hair, keep=cover > 0, piece="hair"
        )
