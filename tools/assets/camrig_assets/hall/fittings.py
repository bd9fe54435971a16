"""What is fixed to the hall's walls, ceiling and openings, as meshes over the prop atlas (glTF frame: +Y up, front +Z).

A piece is a list of (material, shapes.Mesh): `props` is lit, `glow` shines by itself, `leaf` is seen from both sides,
`glass` is see-through.
"""

import numpy as np

from ..shapes import box, cylinder, disc, join, quad, tube
from .atlas import cell
from .furniture import pictured, plain


def poster(i):
    return [
        (
            "props",
            join(
                plain(box((1.06, 1.46, 0.04), (0, 0, 0.02), ("left", "right", "top", "bottom")), "dark"),
                pictured(
                    quad((-0.53, -0.73, 0.04), (0.53, -0.73, 0.04), (0.53, 0.73, 0.04), (-0.53, 0.73, 0.04), (2, 2)),
                    f"poster_{i}",
                ),
            ),
        )
    ]


def banner(which):
    one = quad((-0.6, -3.0, 0.01), (0.6, -3.0, 0.01), (0.6, 0, 0.01), (-0.6, 0, 0.01), (1, 5))
    other = quad((0.6, -3.0, -0.01), (-0.6, -3.0, -0.01), (-0.6, 0, -0.01), (0.6, 0, -0.01), (1, 5))
    bars = [plain(box((1.26, 0.04, 0.04), (0, y, 0)), "steel") for y in (0.0, -3.0)]
    return [("props", join(pictured(join(one, other), which), *bars))]


def door(kind, double=False):
    w = 1.8 if double else 1.0
    parts = []
    for side in ((-1, 1) if double else (0,)):
        leaf = quad((-0.45, 0, 0.03), (0.45, 0, 0.03), (0.45, 2.1, 0.03), (-0.45, 2.1, 0.03), (2, 4)).moved(
            (side * 0.45, 0, 0)
        )
        u0, v0, u1, v1 = cell(kind)
        parts.append(leaf.with_uv((u1, v0, u0, v1) if side > 0 else (u0, v0, u1, v1)))
    frame = [
        plain(box((0.08, 2.18, 0.10), (x, 1.09, 0.03), ("front", "left", "right"), {"front": (1, 3)}), "charcoal")
        for x in (-w / 2 + 0.01, w / 2 - 0.01)
    ]
    frame.append(plain(box((w + 0.06, 0.08, 0.10), (0, 2.14, 0.03), ("front", "bottom", "top")), "charcoal"))
    return [("props", join(*parts, *frame))]


def small_sign(name, size=(0.9, 0.225)):
    w, h = size
    return [
        (
            "glow",
            pictured(
                quad((-w / 2, -h / 2, 0.03), (w / 2, -h / 2, 0.03), (w / 2, h / 2, 0.03), (-w / 2, h / 2, 0.03)), name
            ),
        ),
        ("props", plain(box((w, h, 0.03), (0, 0, 0.014), ("left", "right", "top", "bottom")), "dark")),
    ]


def hanging_sign(front, back, drop, size=(2.6, 0.65)):
    w, h = size
    faces = [
        pictured(
            quad((-w / 2, -h / 2, 0.06), (w / 2, -h / 2, 0.06), (w / 2, h / 2, 0.06), (-w / 2, h / 2, 0.06)), front
        ),
        pictured(
            quad((w / 2, -h / 2, -0.06), (-w / 2, -h / 2, -0.06), (-w / 2, h / 2, -0.06), (w / 2, h / 2, -0.06)), back
        ),
    ]
    case = [plain(box((w + 0.06, h + 0.06, 0.115)), "dark")] + [
        plain(box((0.025, drop, 0.025), (x, h / 2 + drop / 2, 0), ("front", "back", "left", "right")), "steel")
        for x in (-w * 0.4, w * 0.4)
    ]
    return [("glow", join(*faces)), ("props", join(*case))]


def pendant():
    """A drum lamp on a cable; its lower face shines."""
    drum = [
        plain(cylinder(0.34, 0.16, 16, top=True, rows=1), "charcoal"),
        plain(tube([(0, 0.16, 0), (0, 1.45, 0)], 0.012, 4), "dark"),
    ]
    lamp = disc(0.325, 16).moved(matrix=[[1, 0, 0], [0, -1, 0], [0, 0, -1]]).moved((0, 0.012, 0))
    return [("props", join(*drum)), ("lamp_pendant", lamp)]


def downlight():
    return [
        ("lamp_downlight", disc(0.10, 12).moved(matrix=[[1, 0, 0], [0, -1, 0], [0, 0, -1]]).moved((0, -0.012, 0)))
    ]


def light_line(length=3.6):
    """A line of light under the ceiling."""
    body = box((length, 0.07, 0.12), (0, 0.0, 0), ("front", "back", "left", "right"))
    return [
        ("props", plain(body, "white")),
        ("lamp_line", box((length - 0.02, 0.07, 0.11), (0, -0.002, 0), ("bottom",))),
    ]


def railing(length):
    """Glass between steel posts, a round handrail on top; stands on y = 0, 1.05 m high."""
    count = max(2, int(round(length / 1.25)) + 1)
    posts = [
        plain(box((0.04, 1.0, 0.02), (x, 0.5, 0), ("front", "back", "left", "right")), "steel")
        for x in np.linspace(-length / 2 + 0.03, length / 2 - 0.03, count)
    ]
    rail = plain(tube([(-length / 2, 1.03, 0), (length / 2, 1.03, 0)], 0.025, 8), "steel")
    glass = quad((-length / 2, 0.08, 0), (length / 2, 0.08, 0), (length / 2, 0.95, 0), (-length / 2, 0.95, 0))
    return [("props", join(*posts, rail)), ("glass", plain(glass, "white"))]


def stair_rail(run, rise, sign):
    """Sloping glass and handrail beside the stairs; starts at the origin, goes +Z... along -Z in the world's north."""
    posts, n = [], 6
    for t in np.linspace(0.03, 0.97, n):
        posts.append(
            plain(box((0.03, 0.95, 0.03), (0, t * rise + 0.48, -t * run), ("front", "back", "left", "right")), "steel")
        )
    rail = plain(
        tube([(0, 0.95, 0.25), (0, 0.97, 0), (0, rise + 0.97, -run), (0, rise + 1.0, -run - 0.25)], 0.025, 8), "steel"
    )
    glass = quad((0, 0.12, 0), (0, rise + 0.12, -run), (0, rise + 0.88, -run), (0, 0.88, 0))
    return [("props", join(*posts, rail)), ("glass", plain(glass, "white"))]


def facade(width, height):
    """Curtain wall: mullions and transoms, glass; centre bottom at the origin, seen from +Z. Two sliding doors in
    the middle.
    """
    bars, panes = [], []
    stops = np.linspace(-width / 2, width / 2, 9)
    for x in stops:
        bars.append(
            plain(
                box(
                    (0.07, height, 0.14),
                    (x, height / 2, 0),
                    ("front", "left", "right"),
                    {"front": (1, 4), "left": (1, 4), "right": (1, 4)},
                ),
                "charcoal",
            )
        )
    for y in (0.04, 2.55, 4.15, height - 0.04):
        bars.append(
            plain(box((width, 0.08, 0.12), (0, y, 0), ("front", "top", "bottom"), {"front": (8, 1)}), "charcoal")
        )
    doors = []
    for x in (-1.07, -0.36, 0.36, 1.07):
        for edge in (-0.33, 0.33):
            doors.append(plain(box((0.05, 2.4, 0.06), (x + edge, 1.25, 0.10), ("front", "left", "right")), "steel"))
        doors.append(plain(box((0.70, 0.10, 0.06), (x, 0.07, 0.10), ("front", "top")), "steel"))
        doors.append(
            plain(
                box(
                    (0.03, 0.5, 0.05),
                    (x + (0.25 if x < 0 and x > -0.6 else -0.25 if 0 < x < 0.6 else 0.0), 1.1, 0.14),
                    ("front", "left", "right"),
                ),
                "dark",
            )
        )
    doors.append(plain(box((3.0, 0.22, 0.26), (0, 2.58, 0.10), ("front", "top", "bottom")), "charcoal"))
    panes.append(
        quad((-width / 2, 0, -0.03), (width / 2, 0, -0.03), (width / 2, height, -0.03), (-width / 2, height, -0.03))
    )
    return [("props", join(*bars, *doors)), ("glass", plain(join(*panes), "white"))]


def window(width, height):
    """A frame with a cross for the south windows; centre bottom at the origin, seen from +Z."""
    bars = [
        plain(box((0.07, height, 0.10), (x, height / 2, 0), ("front", "left", "right"), {"front": (1, 2)}), "charcoal")
        for x in (-width / 2 + 0.035, -width / 6, width / 6, width / 2 - 0.035)
    ]
    bars += [
        plain(box((width, 0.07, 0.10), (0, y, 0), ("front", "top", "bottom"), {"front": (3, 1)}), "charcoal")
        for y in (0.035, height * 0.38, height - 0.035)
    ]
    return [("props", join(*bars))]


def skylight(width, depth):
    """Mullions below the panes."""
    bars = [
        plain(box((0.06, 0.10, depth), (x, 0, 0), ("left", "right", "bottom")), "white")
        for x in (-width / 6, width / 6)
    ]
    bars += [
        plain(box((width, 0.10, 0.06), (0, 0, z), ("front", "back", "bottom")), "white")
        for z in (-depth / 4, 0, depth / 4)
    ]
    return [("props", join(*bars))]


def clock():
    return [
        (
            "props",
            join(
                pictured(disc(0.55, 32).moved(matrix=[[1, 0, 0], [0, 0, -1], [0, 1, 0]]).moved((0, 0, 0.06)), "clock"),
                plain(cylinder(0.57, 0.06, 32, top=False).moved(matrix=[[1, 0, 0], [0, 0, -1], [0, 1, 0]]), "charcoal"),
            ),
        )
    ]


def wall_map():
    return [
        (
            "props",
            join(
                pictured(
                    quad((-1.1, -0.75, 0.04), (1.1, -0.75, 0.04), (1.1, 0.75, 0.04), (-1.1, 0.75, 0.04), (2, 2)), "map"
                ),
                plain(box((2.24, 1.54, 0.035), (0, 0, 0.017), ("left", "right", "top", "bottom")), "dark"),
            ),
        )
    ]
