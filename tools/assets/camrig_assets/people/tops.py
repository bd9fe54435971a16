"""Painters of trunk garments: the cloth, then what each style adds (buttons, lapels, pockets, openings, straps)."""

from dataclasses import dataclass

import numpy as np

from ..noise import mix, smoothstep
from . import paint
from .paint import along, cloth, folds, line, rgb


@dataclass
class Canvas:
    """The texels of one garment: where they are (table height y; x to the person's left) and what they show so far."""

    points: np.ndarray
    u: np.ndarray
    x: np.ndarray
    y: np.ndarray
    front: np.ndarray
    base: np.ndarray  # the cloth's plain colour
    tone: np.ndarray  # the wearer's skin
    hem: float
    seed: int
    colours: np.ndarray = None
    opening: np.ndarray = None

    @property
    def aside(self):
        """Distance from the middle."""
        return np.abs(self.x)

    def put(self, colours, cover):
        self.colours = mix(self.colours, colours, cover)

    def open(self, colours, cover):
        """Not cloth of this garment: a part of its own shows it (openings.py)."""
        self.opening = mix(self.opening, colours, cover)

    def darken(self, amount):
        self.colours = self.colours * (1 - amount)[..., None]

    def skin(self):
        return paint.skin(self.points, self.tone)


def top_painter(fabrics, spec, seed):
    """The painter of the garment that `spec` describes, for `fabrics`' wearer."""
    return lambda part, points, u, v: _painted(fabrics, spec, seed, part, points, u, v).colours


def opening_painter(fabrics, spec, seed):
    """The painter of what shows where that garment is open."""
    return lambda part, points, u, v: _painted(fabrics, spec, seed, part, points, u, v).opening


def _painted(fabrics, spec, seed, part, points, u, v):
    x, z = points[..., 0] / fabrics.s, points[..., 2] / fabrics.s
    canvas = Canvas(
        points,
        u,
        x,
        along(part, v, "heights"),
        z > 0.0,
        rgb(spec["colour"]),
        fabrics.tone,
        part.tags["heights"].min(),
        seed,
    )
    canvas.opening = canvas.skin() * 0.96
    _cloth(canvas, spec)
    for add in STYLES.get(spec["style"], ()):
        add(canvas, spec)
    return canvas


def _cloth(c, spec):
    """The fabric with its pattern, folds at waist, armpits and hem, and the hem's seam."""
    amount = spec.get("folds", 1.0) * (
        0.35
        + 0.6 * np.exp(-(((c.y - 1.06) / 0.07) ** 2))
        + 0.5 * smoothstep(1.0, 0.8, c.y)
        + 0.7 * np.exp(-(((c.aside - 0.15) / 0.05) ** 2)) * np.exp(-(((c.y - 1.26) / 0.10) ** 2))
    )
    ground = c.base
    if "dots" in spec:
        across, up = (c.u * 44) % 1 - 0.5, (c.y * 36 + 0.5 * (np.floor(c.u * 44) % 2)) % 1 - 0.5
        ground = mix(
            np.broadcast_to(c.base, c.points.shape), rgb(spec["dots"]), smoothstep(0.26, 0.20, np.hypot(across, up))
        )
    c.colours = cloth(c.points, ground, folds(c.points, amount, c.seed), c.seed, spec.get("weave", 0.035))
    c.darken(0.22 * line(c.y - c.hem - 0.025, 0.006))


def _buttons(c, spec):
    """A placket down the front with small buttons."""
    c.darken(0.16 * line(c.aside - 0.016, 0.004) * c.front)
    button = smoothstep(0.0065, 0.0045, np.hypot(c.x, (c.y % 0.085) - 0.04)) * c.front
    c.put(np.array([0.86, 0.84, 0.80]) * (0.5 if c.base.mean() > 0.7 else 1), button * 0.9)


def _v_neck(c, spec):
    edge = c.aside - (c.y - (1.355 if spec["style"] == "blouse" else 1.34)) * 0.42
    c.darken(0.3 * line(edge - 0.006, 0.008) * c.front)


def _crew_neck(c, spec):
    """A round neckline, and a print on the chest."""
    c.darken(0.2 * line(c.y - 1.45, 0.006))
    if "print" in spec:
        c.put(rgb(spec["print"]), smoothstep(0.075, 0.071, np.hypot(c.x, (c.y - 1.27) * 1.1)) * c.front)
        c.put(c.base, smoothstep(0.05, 0.047, np.hypot(c.x - 0.012, (c.y - 1.28) * 1.1)) * c.front)


def _shirt_and_tie(c, spec, open_to):
    """What shows between the lapels: a shirt, with a tie or an open collar. Returns the opening's half width and
    cover.
    """
    width = np.clip((c.y - open_to) * (0.24 if spec["style"] == "jacket" else 0.30), 0, 0.085)
    inside = smoothstep(0.005, -0.005, c.aside - width) * c.front * (c.y > open_to)
    under = cloth(c.points, rgb(spec.get("shirt", "#e8ecf2")), folds(c.points, 0.4, c.seed + 1), c.seed + 1)
    if spec.get("tie"):
        half = np.interp(c.y, [1.12, 1.40, 1.43, 1.47], [0.034, 0.022, 0.016, 0.020])
        stripes = rgb(spec["tie"]) * (1 - 0.3 * ((c.x + c.y) * 50 % 1 < 0.3))[..., None]
        under = mix(under, cloth(c.points, stripes, np.zeros(c.u.shape), 3), smoothstep(0.002, -0.002, c.aside - half))
        collar = line(c.aside - 0.045 - (1.48 - c.y) * 0.25, 0.006) * (c.y > 1.42)
        under = under * (1 - 0.2 * collar)[..., None]
    c.open(under, np.ones(c.u.shape))
    return width, inside


def _lapels(c, spec, width, inside, open_to):
    reach = np.interp(c.y, [open_to, 1.30, 1.385, 1.39, 1.47], [0.004, 0.060, 0.075, 0.052, 0.040])
    edge, shown = c.aside - width - reach, c.front * (c.y > open_to) * (1 - inside)
    c.darken(-0.10 * smoothstep(0.002, -0.002, edge) * shown)
    c.darken(0.40 * line(edge, 0.005) * shown)
    c.darken(0.35 * line(c.x - 0.008, 0.005) * c.front * (c.y < open_to))


def _jacket(c, spec):
    open_to = 1.10
    _lapels(c, spec, *_shirt_and_tie(c, spec, open_to), open_to)
    pockets = line(c.y - 0.985, 0.007) * (np.abs(c.aside - 0.11) < 0.05)
    pockets = pockets + line(c.y - 1.31, 0.006) * (np.abs(c.x - 0.095) < 0.035)
    c.darken(0.35 * np.clip(pockets * c.front, 0, 1))
    buttons = sum(smoothstep(0.010, 0.008, np.hypot(c.x - 0.012, c.y - level)) for level in (1.07, 0.97))
    c.put(c.base * 0.35, np.clip(buttons, 0, 1) * c.front)


def _coat(c, spec):
    """Double-breasted, with a belt."""
    open_to = 1.28
    _lapels(c, spec, *_shirt_and_tie(c, spec, open_to), open_to)
    belt = smoothstep(0.022, 0.020, np.abs(c.y - 1.045))
    c.darken(0.22 * belt + 0.25 * line(np.abs(c.y - 1.045) - 0.022, 0.006))
    buttons = sum(smoothstep(0.013, 0.011, np.hypot(c.aside - 0.05, c.y - level)) for level in (1.20, 1.10, 0.97))
    c.put(c.base * 0.35, np.clip(buttons, 0, 1) * c.front)


def _hoodie(c, spec):
    """A pocket in front and the hood's strings."""
    pocket = line(c.aside - (0.115 - 0.35 * np.clip(c.y - 0.98, 0, 0.13)), 0.006) * (c.y > 0.955) * (c.y < 1.11)
    pocket = pocket + line(c.y - 1.11, 0.006) * (c.aside < 0.072)
    c.darken(0.30 * np.clip(pocket, 0, 1) * c.front)
    strings = line(c.aside - 0.035 - 0.1 * (1.45 - c.y), 0.006) * (c.y > 1.30) * (c.y < 1.46)
    c.put(np.array([0.92, 0.90, 0.85]), strings * c.front * 0.9)


def _ribs(c, spec):
    """Knitted hem and neck."""
    rib = np.clip(smoothstep(c.hem + 0.06, c.hem + 0.055, c.y) + smoothstep(1.462, 1.468, c.y), 0, 1)
    c.darken(0.14 * rib * (0.5 + 0.5 * np.sign(np.sin(c.u * 2 * np.pi * 60))))


def _cardigan(c, spec):
    """Open in front over another top."""
    width = 0.030 + np.clip(c.y - 1.0, 0, 1) * 0.075
    under = cloth(c.points, rgb(spec["shirt"]), folds(c.points, 0.5, c.seed + 1), c.seed + 1)
    c.darken(0.25 * line(c.aside - width - 0.018, 0.004) * c.front)
    c.open(under, np.ones(c.u.shape))


STYLES = {
    "shirt": (_buttons,),
    "blouse": (_buttons, _v_neck),
    "vneck": (_v_neck,),
    "tee": (_crew_neck,),
    "jacket": (_jacket,),
    "coat": (_coat,),
    "hoodie": (_hoodie, _ribs),
    "sweater": (_ribs,),
    "cardigan": (_cardigan,),
}
