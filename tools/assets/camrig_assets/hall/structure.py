"""The hall's fixed parts: floor, walls with their openings, ceiling, gallery, stairs, columns. World frame, metres.

Every flat part is a `Panel` with a chart in the lightmap; columns are `Tube`s. The plan: entrance facade in the east (x
= 30), windows in the south (y = 0), gallery along the north (y 15..20) at 3.3 m, stairs to it at x 20.5..23, skylights
above the middle.
"""

from dataclasses import dataclass

import numpy as np

from .. import shapes
from .light import Chart

LENGTH, WIDTH, HEIGHT = 30.0, 20.0, 6.6
GALLERY_Y, GALLERY_Z, SLAB = 15.0, 3.3, 0.35
STAIR_X, STAIR_Y, STEPS = (20.5, 23.0), (8.76, 15.0), 20
ALBEDO = {
    "floor": 0.47,
    "plaster": 0.76,
    "ceiling": 0.78,
    "concrete": 0.44,
    "slats": 0.14,
    "trim": 0.07,
    "accent": 0.12,
    "carpet": 0.16,
}
TILE = {
    "floor": 4.8,
    "plaster": 3.0,
    "ceiling": 2.4,
    "concrete": 2.4,
    "slats": 1.6,
    "trim": 1.0,
    "accent": 1.0,
    "carpet": 2.4,
}
SOUTH_WINDOWS = [(2.0 + 4.4 * i, 5.6 + 4.4 * i, 2.3, 5.7) for i in range(6)]
SKYLIGHTS = [(5.0 * i + 0.9, 5.0 * i + 4.1, 5.6, 10.4) for i in range(1, 5)]
NORTH_WINDOWS = [(1.4 + 4.6 * i, 4.2 + 4.6 * i, 4.9, 6.1) for i in range(6) if i != 3]
COLUMNS = [*((1.8 + 5.4 * i, 14.75) for i in range(6)), (26.6, 4.6), (26.6, 12.2)]
FACADE = (2.5, 14.0, 0.0, 5.7)


def to_gltf(points):
    """World (z up) to glTF (y up)."""
    points = np.asarray(points, dtype=np.float64)
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


@dataclass
class Panel:
    """A rectangle: corner and two edges; it faces u x v."""

    node: str
    material: str
    corner: tuple
    u: tuple
    v: tuple
    density: float = 8.0  # lightmap texels a metre

    def __post_init__(self):
        self.corner, self.u, self.v = (np.asarray(a, dtype=np.float64) for a in (self.corner, self.u, self.v))
        lengths = np.linalg.norm(self.u), np.linalg.norm(self.v)
        self.normal = np.cross(self.u, self.v) / (lengths[0] * lengths[1])
        self.chart = Chart(
            tuple(max(2, int(round(n * self.density)) + 1) for n in lengths), self._place, ALBEDO[self.material]
        )

    def _place(self, s, t):
        points = self.corner + s[:, None] * self.u + t[:, None] * self.v
        return points, np.tile(self.normal, (len(points), 1))

    def mesh(self):
        """(positions, normals, uv, st, triangles), world frame."""
        st = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=np.float64)
        points, normals = self._place(st[:, 0], st[:, 1])
        tile = TILE[self.material]
        along, up = self.u / np.linalg.norm(self.u), self.v / np.linalg.norm(self.v)
        uv = np.stack([points @ along, -(points @ up)], axis=1) / tile
        return points, normals, uv - np.floor(uv.min(axis=0)), st, np.array([(0, 1, 2), (0, 2, 3)])


@dataclass
class Tube:
    """A round column."""

    node: str
    material: str
    centre: tuple
    radius: float
    bottom: float
    top: float
    density: float = 8.0
    columns: int = 20

    def __post_init__(self):
        size = (
            max(8, int(2 * np.pi * self.radius * self.density) + 1),
            int((self.top - self.bottom) * self.density) + 1,
        )
        self.chart = Chart(size, self._place, ALBEDO[self.material])

    def _place(self, s, t):
        normals = np.stack([np.cos(2 * np.pi * s), np.sin(2 * np.pi * s), 0 * s], axis=1)
        return (
            normals * self.radius
            + np.stack(
                [0 * s + self.centre[0], 0 * s + self.centre[1], self.bottom + t * (self.top - self.bottom)], axis=1
            ),
            normals,
        )

    def mesh(self):
        s, t = np.meshgrid(np.linspace(0, 1, self.columns + 1), [0.0, 1.0])
        s, t = s.reshape(-1), t.reshape(-1)
        points, normals = self._place(s, t)
        uv = np.stack([s * 2 * np.pi * self.radius, (1 - t) * (self.top - self.bottom)], axis=1) / TILE[self.material]
        return points, normals, uv, np.stack([s, t], axis=1), shapes.grid_triangles(2, self.columns + 1)


def wall(
    node, material, corner, along, length, bottom, top, openings=(), density=8.0, reveal=0.0, reveal_material="plaster"
):
    """A vertical wall; it faces along x up. `openings` are (from, to, low, high); `reveal` is the depth of their
    sides.
    """
    corner, along = np.asarray(corner, dtype=np.float64), np.asarray(along, dtype=np.float64)
    up = np.array([0, 0, 1.0])
    panels = []
    stops = sorted({0.0, length, *(v for o in openings for v in o[:2])})
    for a, b in zip(stops[:-1], stops[1:]):
        inside = sorted((o[2], o[3]) for o in openings if o[0] <= a and o[1] >= b)
        z = bottom
        for low, high in [*inside, (top, top)]:
            if low - z > 1e-6:
                panels.append(
                    Panel(
                        node,
                        material,
                        corner + along * a + up * (z - corner[2]),
                        along * (b - a),
                        up * (low - z),
                        density,
                    )
                )
            z = high
    if reveal:
        out = -np.cross(along, up) * reveal
        for a, b, low, high in openings:
            at = corner + up * -corner[2]
            panels += [
                Panel(node, reveal_material, at + along * a + up * low, out, up * (high - low), 5),
                Panel(node, reveal_material, at + along * b + up * low + out, -out, up * (high - low), 5),
                Panel(node, reveal_material, at + along * a + up * high, out, along * (b - a), 5),
            ]
            if low > 0.01:
                panels.append(Panel(node, reveal_material, at + along * a + up * low, along * (b - a), out, 5))
    return panels


def block(node, material, low, high, sides="nsewtb", density=6.0):
    """The sides of an upright box: n(orth, +y), s(outh), e(ast, +x), w(est), t(op), b(ottom)."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    dx, dy, dz = (x1 - x0, 0, 0), (0, y1 - y0, 0), (0, 0, z1 - z0)
    neg = lambda v: tuple(-c for c in v)  # noqa: E731
    made = {
        "s": ((x0, y0, z0), dx, dz),
        "n": ((x1, y1, z0), neg(dx), dz),
        "e": ((x1, y0, z0), dy, dz),
        "w": ((x0, y1, z0), neg(dy), dz),
        "t": ((x0, y0, z1), dx, dy),
        "b": ((x0, y1, z0), dx, neg(dy)),
    }
    return [Panel(node, material, *made[s], density) for s in sides]


def structure():
    """All panels and tubes."""
    parts = []
    for i in range(3):  # the floor in three nodes, for culling
        parts.append(Panel(f"floor_{i + 1}", "floor", (10.0 * i, 0, 0), (10, 0, 0), (0, WIDTH, 0), 14))
    parts += wall(
        "wall_south",
        "plaster",
        (LENGTH, 0, 0),
        (-1, 0, 0),
        LENGTH,
        0.0,
        HEIGHT,
        [(LENGTH - b, LENGTH - a, lo, hi) for a, b, lo, hi in SOUTH_WINDOWS],
        7,
        reveal=0.35,
    )
    parts += wall(
        "wall_north",
        "plaster",
        (0, WIDTH, GALLERY_Z),
        (1, 0, 0),
        LENGTH,
        GALLERY_Z,
        HEIGHT,
        NORTH_WINDOWS,
        7,
        reveal=0.3,
    )
    parts += wall("wall_north_low", "plaster", (0, WIDTH, 0), (1, 0, 0), 7.6, 0.0, GALLERY_Z - SLAB, density=8)
    parts += wall("wall_desk", "slats", (7.6, WIDTH, 0), (1, 0, 0), 6.4, 0.0, GALLERY_Z - SLAB, density=8)
    parts += wall("wall_north_east", "plaster", (14.0, WIDTH, 0), (1, 0, 0), 16.0, 0.0, GALLERY_Z - SLAB, density=8)
    parts += wall("wall_west", "plaster", (0, 0, 0), (0, 1, 0), WIDTH, 0.0, HEIGHT, density=7)
    parts += wall(
        "wall_east",
        "concrete",
        (LENGTH, WIDTH, 0),
        (0, -1, 0),
        WIDTH,
        0.0,
        HEIGHT,
        [(WIDTH - FACADE[1], WIDTH - FACADE[0], FACADE[2], FACADE[3])],
        8,
        reveal=0.4,
        reveal_material="concrete",
    )
    for node, corner, u in (
        ("wall_south", (LENGTH, 0.015, 0), (-LENGTH, 0, 0)),
        ("wall_west", (0.015, 0, 0), (0, WIDTH, 0)),
        ("wall_north_low", (0, WIDTH - 0.015, 0), (7.6, 0, 0)),
        ("wall_north_east", (14.0, WIDTH - 0.015, 0), (16.0, 0, 0)),
        ("wall_east", (LENGTH - 0.015, WIDTH, 0), (0, FACADE[1] - WIDTH, 0)),
        ("wall_east", (LENGTH - 0.015, FACADE[0], 0), (0, -FACADE[0], 0)),
    ):
        parts.append(Panel(node, "trim", corner, u, (0, 0, 0.09), 10))
    parts += ceiling()
    parts += gallery() + stairs()
    for i, (x, y) in enumerate(COLUMNS):
        parts += column(f"column_{i + 1}", x, y)
    for i, (x0, x1, _, _) in enumerate(SOUTH_WINDOWS[:-1]):  # piers between the windows
        parts += block(f"pier_{i + 1}", "concrete", (x1 + 0.15, 0, 0), (x1 + 0.65, 0.22, HEIGHT), "new", 5)
    return parts


def column(node, x, y):
    return [
        Tube(node, "concrete", (x, y), 0.26, 0.0, HEIGHT, 8),
        *block(node, "trim", (x - 0.30, y - 0.30, 0.0), (x + 0.30, y + 0.30, 0.10), "nsewt", 10),
    ]


def ceiling():
    """White panels with skylight openings, crossed by beams."""
    parts = []
    cuts = sorted({0.0, LENGTH, *(v for s in SKYLIGHTS for v in s[:2])})
    for a, b in zip(cuts[:-1], cuts[1:]):
        hole = next((s for s in SKYLIGHTS if s[0] <= a and s[1] >= b), None)
        for low, high in ([(0, hole[2]), (hole[3], WIDTH)] if hole else [(0, WIDTH)]):
            parts.append(
                Panel(
                    "ceiling_west" if b <= 15 else "ceiling_east",
                    "ceiling",
                    (a, high, HEIGHT),
                    (b - a, 0, 0),
                    (0, low - high, 0),
                    5,
                )
            )
    for i, (x0, x1, y0, y1) in enumerate(SKYLIGHTS):  # the wells
        up, node = (0, 0, 0.7), f"skylight_well_{i + 1}"
        parts += [
            Panel(node, "plaster", (x1, y0, HEIGHT), (x0 - x1, 0, 0), up, 5),
            Panel(node, "plaster", (x0, y1, HEIGHT), (x1 - x0, 0, 0), up, 5),
            Panel(node, "plaster", (x1, y1, HEIGHT), (0, y0 - y1, 0), up, 5),
            Panel(node, "plaster", (x0, y0, HEIGHT), (0, y1 - y0, 0), up, 5),
        ]
    for i in range(1, 6):
        parts += block(
            f"beam_{i}", "concrete", (5.0 * i - 0.18, 0, HEIGHT - 0.55), (5.0 * i + 0.18, WIDTH, HEIGHT), "ewb", 5
        )
    return parts


def gallery():
    """The slab in two halves: carpet on top, white below, a fascia in front with the gap for the stairs' head."""
    parts = [Panel("gallery_floor", "carpet", (0, GALLERY_Y, GALLERY_Z), (LENGTH, 0, 0), (0, WIDTH - GALLERY_Y, 0), 7)]
    parts.append(
        Panel("gallery_soffit", "ceiling", (0, WIDTH, GALLERY_Z - SLAB), (LENGTH, 0, 0), (0, GALLERY_Y - WIDTH, 0), 8)
    )
    parts.append(
        Panel("gallery_fascia", "plaster", (0, GALLERY_Y, GALLERY_Z - SLAB), (LENGTH, 0, 0), (0, 0, SLAB + 0.08), 8)
    )
    parts.append(Panel("gallery_fascia", "plaster", (0, GALLERY_Y, GALLERY_Z + 0.08), (LENGTH, 0, 0), (0, 0.06, 0), 3))
    return parts


def stairs():
    """Straight flight from the hall up to the gallery; the sides are closed walls."""
    parts = []
    rise, going = GALLERY_Z / STEPS, (STAIR_Y[1] - STAIR_Y[0]) / STEPS
    x0, x1 = STAIR_X
    for i in range(STEPS):
        y, z = STAIR_Y[0] + going * i, rise * i
        parts.append(Panel("stairs", "concrete", (x0, y, z), (x1 - x0, 0, 0), (0, 0, rise), 7))
        parts.append(Panel("stairs", "floor", (x0, y, z + rise), (x1 - x0, 0, 0), (0, going, 0), 7))
    parts.append(Panel("stairs", "plaster", (x1, STAIR_Y[1], 0), (x0 - x1, 0, 0), (0, 0, GALLERY_Z - SLAB), 7))
    for i in range(STEPS):  # side walls as upright strips, one lightmap strip each
        y, z = STAIR_Y[0] + going * i, rise * (i + 1)
        parts.append(Panel("stair_side_west", "plaster", (x0, y + going, 0), (0, -going, 0), (0, 0, z), 7))
        parts.append(Panel("stair_side_east", "plaster", (x1, y, 0), (0, going, 0), (0, 0, z), 7))
    return parts
