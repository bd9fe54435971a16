"""What stands on the hall's floor, as meshes over the prop atlas (glTF frame: +Y up, front +Z).

A piece is a list of (material, shapes.Mesh): `props` is lit, `glow` shines by itself, `leaf` is seen from both sides,
`glass` is see-through.
"""

import numpy as np

from .. import noise, shapes
from ..shapes import box, cylinder, disc, join, quad, tube
from .atlas import cell


def pictured(mesh, name):
    return mesh.with_uv(cell(name))


def plain(mesh, name):
    """The cell's middle on all of the mesh (for colours without a pattern, where no seam must show)."""
    u0, v0, u1, v1 = cell(name)
    return shapes.Mesh(
        mesh.positions,
        mesh.normals,
        0.3 * (mesh.uv - 0.5) * (u1 - u0, v1 - v0) + ((u0 + u1) / 2, (v0 + v1) / 2),
        mesh.triangles,
    )


def bench():
    """Wooden slats on a steel frame, 2 m long, seat 0.45 m high."""
    parts = [
        pictured(
            box((2.0, 0.035, 0.085), (0, 0.435, z), ("front", "back", "left", "right", "top"), {"top": (3, 1)}), "wood"
        )
        for z in (-0.19, -0.095, 0.0, 0.095, 0.19)
    ]
    for x in (-0.75, 0.75):
        parts += [
            plain(box((0.06, 0.02, 0.46), (x, 0.405, 0), ("front", "back", "left", "right")), "dark"),
            plain(box((0.06, 0.39, 0.05), (x, 0.20, 0.17), ("front", "back", "left", "right")), "dark"),
            plain(box((0.06, 0.39, 0.05), (x, 0.20, -0.17), ("front", "back", "left", "right")), "dark"),
            plain(box((0.06, 0.015, 0.46), (x, 0.0075, 0), ("front", "back", "left", "right", "top")), "dark"),
        ]
    return [("props", join(*parts))]


def backed_bench():
    """The bench with a back rest."""
    parts = [bench()[0][1]]
    lean = 0.18
    for y in (0.62, 0.72, 0.82):
        parts.append(
            pictured(
                box(
                    (2.0, 0.075, 0.03),
                    (0, y, -0.24 - lean * (y - 0.45)),
                    ("front", "back", "left", "right", "top"),
                    {s: (3, 1) for s in ("front", "back")},
                ),
                "wood",
            )
        )
    for x in (-0.75, 0.75):
        parts.append(
            plain(box((0.05, 0.46, 0.03), (x, 0.64, -0.275), ("front", "back", "left", "right", "top")), "dark")
        )
    return [("props", join(*parts))]


def planter(tall, seed):
    """A stone pot with a plant: blades that arch outwards, or a small tree with leaves."""
    pot = [
        pictured(
            shapes.loft(
                [
                    shapes.ring(r, r, (0, y, 0), 16, 5.0)
                    for y, r in ((0, 0.26), (0.05, 0.27), (0.35, 0.29), (0.55, 0.31), (0.55, 0.275), (0.50, 0.27))
                ]
            ),
            "pot",
        ),
        plain(disc(0.27, 12).moved((0, 0.50, 0)), "soil"),
    ]
    leaves = []
    if tall:
        pot.append(
            plain(tube([(0, 0.5, 0), (0.02, 0.9, 0.01), (-0.01, 1.3, 0.0), (0.02, 1.7, 0.02)], 0.022, 6), "soil")
        )
    count = 40 if tall else 30
    for i in range(count):
        a, b, c = (float(noise._lattice(np.array(i), np.array(k), np.array(0), seed)) for k in range(3))
        heading = 2 * np.pi * (i * 0.618 + 0.1 * a)
        start = 0.95 + 0.8 * b if tall else 0.5
        length, width = (0.42 + 0.22 * c, 0.075) if tall else (0.65 + 0.55 * c, 0.055)
        lean = (0.25 + 0.65 * a) if tall else (0.12 + 0.75 * b)
        points, across = [], np.array([-np.sin(heading), 0, np.cos(heading)])
        out = np.array([np.cos(heading), 0, np.sin(heading)])
        for t in (0, 0.35, 0.7, 1.0):
            bend = lean + (0.9 if tall else 0.75) * t * t
            centre = (
                np.array([0.0, start, 0.0])
                + out * (length * t * np.sin(bend) + 0.02)
                + np.array([0, length * t * np.cos(bend), 0])
            )
            points.append((centre, width * (0.35, 1.0, 0.8, 0.05)[(0, 0.35, 0.7, 1.0).index(t)]))
        left, right = np.array([p - across * w / 2 for p, w in points]), np.array(
            [p + across * w / 2 for p, w in points]
        )
        grid = np.stack([left, right], axis=1)
        normals = shapes.grid_normals(grid, False)
        normals = np.where(normals[..., 1:2] < 0, -normals, normals)
        uv = np.array([[(0, 1 - t), (1, 1 - t)] for t in (0, 0.35, 0.7, 1.0)]).reshape(-1, 2)
        leaves.append(shapes.Mesh(grid.reshape(-1, 3), normals.reshape(-1, 3), uv, shapes.grid_triangles(4, 2)))
    return [("props", join(*pot)), ("leaf", pictured(join(*leaves), "leaf"))]


def bin_():
    return [
        (
            "props",
            join(
                plain(cylinder(0.20, 0.72, 16, rows=3), "steel"),
                plain(cylinder(0.205, 0.10, 16, top=False).moved((0, 0.62, 0)), "dark"),
                plain(disc(0.12, 12).moved((0, 0.723, 0)), "dark"),
            ),
        )
    ]


def desk():
    """Reception: slatted front, white top, a lower part, two screens, a lit strip."""
    front = pictured(box((3.6, 1.02, 0.08), (0, 0.55, 0.46), ("front", "left", "right"), {"front": (10, 4)}), "slats")
    top = plain(
        box(
            (3.8, 0.05, 0.42),
            (0, 1.085, 0.36),
            cells={"top": (10, 2), "front": (10, 1), "bottom": (6, 1), "back": (6, 1)},
        ),
        "white",
    )
    work = plain(box((3.6, 0.04, 0.60), (0, 0.74, -0.05), cells={"top": (8, 2)}), "white")
    ends = [
        plain(box((0.06, 1.06, 0.95), (x, 0.53, 0.02), ("left", "right", "front", "back", "top"), 2), "white")
        for x in (-1.83, 1.83)
    ]
    plinth = plain(box((3.6, 0.06, 0.06), (0, 0.03, 0.45), ("front",), {"front": (10, 1)}), "dark")
    screens = []
    for x in (-0.9, 0.8):
        screens += [
            plain(box((0.52, 0.32, 0.03), (x, 1.05, 0.02)), "dark"),
            plain(box((0.05, 0.14, 0.05), (x, 0.83, 0.0)), "dark"),
        ]
    inner = plain(box((3.6, 1.0, 0.02), (0, 0.55, 0.41), ("back",), {"back": (8, 2)}), "white")
    return [
        ("props", join(front, top, work, plinth, inner, *ends, *screens)),
        (
            "glow",
            plain(
                quad((-1.78, 1.045, 0.505), (1.78, 1.045, 0.505), (1.78, 1.06, 0.505), (-1.78, 1.06, 0.505)),
                "glow_white",
            ),
        ),
    ]


def machine(kind, size=(0.8, 1.85, 0.6)):
    w, h, d = size
    body = plain(
        box(size, (0, h / 2, 0), ("back", "left", "right", "top"), 2),
        {"vending": "red", "ticket": "white", "lift": "steel"}[kind],
    )
    return [("props", join(body, pictured(box(size, (0, h / 2, 0), ("front",), {"front": (2, 4)}), kind)))]


def totem():
    return [
        ("props", plain(box((0.66, 2.05, 0.14), (0, 1.025, 0), ("left", "right", "top", "back", "front"), 2), "dark")),
        (
            "glow",
            pictured(
                join(
                    quad((-0.30, 0.75, 0.073), (0.30, 0.75, 0.073), (0.30, 2.0, 0.073), (-0.30, 2.0, 0.073)),
                    quad((0.30, 0.75, -0.073), (-0.30, 0.75, -0.073), (-0.30, 2.0, -0.073), (0.30, 2.0, -0.073)),
                ),
                "totem",
            ),
        ),
    ]


def table():
    return [
        (
            "props",
            join(
                plain(cylinder(0.36, 0.03, 20, bottom=True).moved((0, 0.71, 0)), "white"),
                plain(cylinder(0.03, 0.70, 8, top=False), "dark"),
                plain(cylinder(0.22, 0.02, 16), "dark"),
            ),
        )
    ]


def chair():
    seat = [
        pictured(box((0.42, 0.03, 0.42), (0, 0.45, 0), cells={"top": (2, 2)}), "wood"),
        pictured(box((0.40, 0.22, 0.025), (0, 0.74, -0.20), cells={"front": (2, 2), "back": (2, 2)}), "wood"),
    ]
    legs = [
        plain(box((0.03, 0.44, 0.03), (x, 0.22, z), ("front", "back", "left", "right")), "dark")
        for x in (-0.18, 0.18)
        for z in (-0.18, 0.18)
    ]
    legs += [
        plain(box((0.03, 0.42, 0.025), (x, 0.65, -0.195), ("front", "back", "left", "right")), "dark")
        for x in (-0.17, 0.17)
    ]
    return [("props", join(*seat, *legs))]


def chairs():
    """Three chairs around a table that stands at the origin."""
    return [("props", join(*(chair()[0][1].moved((0, 0, -0.64)).moved(yaw=a) for a in np.radians((0, 120, 240)))))]


def suitcase(colour):
    body = pictured(box((0.40, 0.58, 0.24), (0, 0.34, 0), ("front", "back", "left", "right", "top"), 2), colour)
    extras = [plain(box((0.05, 0.05, 0.05), (x, 0.025, z)), "dark") for x in (-0.15, 0.15) for z in (-0.08, 0.08)]
    extras += [
        plain(box((0.015, 0.40, 0.015), (x, 0.83, -0.08), ("front", "back", "left", "right")), "steel")
        for x in (-0.10, 0.10)
    ] + [plain(box((0.23, 0.025, 0.03), (0, 1.03, -0.08)), "dark")]
    return [("props", join(body, *extras))]


def kiosk():
    """The cafe's counter: slatted front, a menu above, shelves behind."""
    base = join(
        pictured(box((3.0, 1.0, 0.6), (0, 0.5, 0), ("front",), {"front": (8, 3)}), "slats"),
        plain(box((3.0, 1.0, 0.6), (0, 0.5, 0), ("left", "right", "back"), 2), "charcoal"),
        plain(box((3.1, 0.05, 0.72), (0, 1.02, 0), cells={"top": (8, 2), "front": (8, 1)}), "stone"),
    )
    machine_ = join(
        plain(box((0.6, 0.42, 0.4), (-0.9, 1.26, -0.05), cells=2), "steel"),
        plain(box((0.5, 0.05, 0.3), (-0.9, 1.50, -0.05)), "dark"),
    )
    cake = [plain(box((0.9, 0.32, 0.4), (0.7, 1.21, 0.0), ("back", "left", "right")), "steel")]
    shelf = join(
        pictured(box((3.0, 1.3, 0.04), (0, 1.65, -1.15), ("front",), {"front": (6, 3)}), "shelf"),
        plain(box((3.0, 0.9, 0.4), (0, 0.45, -0.98), ("front", "top", "left", "right"), 2), "charcoal"),
    )
    return [
        ("props", join(base, machine_, shelf, *cake)),
        ("glow", pictured(quad((-0.9, 2.38, -1.1), (0.9, 2.38, -1.1), (0.9, 2.95, -1.1), (-0.9, 2.95, -1.1)), "menu")),
    ]


def mat(width, depth):
    """The entrance mat."""
    return [
        (
            "props",
            plain(
                quad(
                    (-width / 2, 0.008, depth / 2),
                    (width / 2, 0.008, depth / 2),
                    (width / 2, 0.008, -depth / 2),
                    (-width / 2, 0.008, -depth / 2),
                    (6, 4),
                ),
                "charcoal",
            ),
        )
    ]


def stanchion():
    return [
        (
            "props",
            join(
                plain(cylinder(0.16, 0.02, 14), "steel"),
                plain(cylinder(0.025, 0.93, 8, top=False), "steel"),
                plain(cylinder(0.045, 0.06, 8).moved((0, 0.93, 0)), "dark"),
            ),
        )
    ]


def belt(length):
    return [
        (
            "props",
            plain(
                join(
                    quad(
                        (-length / 2, 0.90, 0.0),
                        (length / 2, 0.90, 0.0),
                        (length / 2, 0.95, 0.0),
                        (-length / 2, 0.95, 0.0),
                    ),
                    quad(
                        (length / 2, 0.90, -0.004),
                        (-length / 2, 0.90, -0.004),
                        (-length / 2, 0.95, -0.004),
                        (length / 2, 0.95, -0.004),
                    ),
                ),
                "blue",
            ),
        )
    ]
