"""Where hair grows, and hair that hangs or stands off the head: closed shapes behind and above it."""

import numpy as np

from ..noise import smoothstep
from .parts import Part, unit_ring

# hairline: degrees from the front, height it reaches down to
HAIRLINE = {
    "short": [
        (0, 0.180),
        (25, 0.180),
        (42, 0.170),
        (56, 0.150),
        (66, 0.112),
        (76, 0.088),
        (86, 0.100),
        (98, 0.094),
        (120, 0.050),
        (180, 0.030),
    ],
    "high": [
        (0, 0.196),
        (25, 0.198),
        (42, 0.192),
        (56, 0.158),
        (66, 0.112),
        (76, 0.088),
        (86, 0.100),
        (98, 0.094),
        (120, 0.050),
        (180, 0.030),
    ],
    "long": [
        (0, 0.182),
        (20, 0.180),
        (38, 0.164),
        (52, 0.130),
        (64, 0.085),
        (76, 0.050),
        (90, 0.030),
        (120, 0.010),
        (180, -0.010),
    ],
}


def long_hair(head, paint_hair, style):
    """Long hair, bun, ponytail, curls: closed shapes behind and beside the neck."""
    made, shaper = [], head.shaper
    if style in ("long", "bob", "medium"):
        bottom = {"long": -0.19, "medium": -0.10, "bob": -0.005}[style]
        heights = np.linspace(bottom, 0.17, 9 if style == "long" else 7)
        rows, w = [], shaper.blank(len(heights), 14)
        for i, y in enumerate(heights):
            half = np.interp(y, [-0.19, -0.08, 0.0, 0.06, 0.13, 0.17], [0.085, 0.088, 0.084, 0.088, 0.088, 0.074]) * (
                0.88 if y == bottom else 1
            )
            back = np.interp(y, [-0.19, -0.08, 0.0, 0.06, 0.13, 0.17], [0.066, 0.062, 0.075, 0.092, 0.107, 0.102])
            front = np.interp(y, [-0.19, -0.06, 0.0, 0.06, 0.13, 0.17], [-0.02, 0.02, 0.042, 0.046, 0.036, 0.02])
            z0 = np.interp(y, [-0.19, -0.08, 0.0, 0.06], [-0.052, -0.032, -0.012, 0.0])
            flat = unit_ring(14, 2.6)
            z = np.where(flat[:, 1] > 0, front, back) * flat[:, 1] + z0
            rows.append(np.stack([flat[:, 0] * half, np.full(15, y), z], axis=1))
            low = 1 - smoothstep(-0.10, 0.03, y)
            w[i, :, shaper.j("head")], w[i, :, shaper.j("neck")] = 1 - low, low * 0.5
            w[i, :, shaper.j("chest")] = low * 0.5
        rows.insert(0, rows[0] * (0.6, 1, 0.6) + np.array([0, 0.012, -0.02]))
        w = np.concatenate([w[:1], w])
        made.append(Part("hair_mass", head.place(np.array(rows)), w, (96, 64), paint_hair))
    if style == "bun":
        made.append(
            shaper.blob(
                "bun",
                "head",
                head.chin + np.array([0, 0.165, -0.115]) * head.size,
                np.array([0.040, 0.040, 0.036]) * head.size,
                8,
                6,
                paint_hair,
            )
        )
    if style == "ponytail":
        path = [
            (0, 0.150, -0.098, 0.020),
            (0, 0.146, -0.130, 0.026),
            (0, 0.110, -0.150, 0.029),
            (0, 0.050, -0.148, 0.027),
            (0, -0.010, -0.132, 0.020),
            (0, -0.050, -0.122, 0.004),
        ]
        rows, w = [], shaper.blank(len(path), 8)
        for i, (x, y, z, r) in enumerate(path[::-1]):
            flat = unit_ring(8)
            tilt = np.interp(y, [-0.05, 0.10, 0.150], [0, 0.2, 1.2])
            rows.append(
                np.stack(
                    [x + flat[:, 0] * r, y + flat[:, 1] * r * np.sin(tilt), z + flat[:, 1] * r * np.cos(tilt)], axis=1
                )
            )
            low = 0.4 * (1 - smoothstep(-0.03, 0.08, y))
            w[i, :, shaper.j("head")], w[i, :, shaper.j("neck")] = 1 - low, low
        made.append(Part("ponytail", head.place(np.array(rows)), w, (40, 48), paint_hair))
    if style == "afro":
        made.append(
            shaper.blob(
                "afro",
                "head",
                head.chin + np.array([0, 0.152, -0.022]) * head.size,
                np.array([0.112, 0.098, 0.112]) * head.size,
                14,
                9,
                paint_hair,
                (96, 64),
                2.1,
            )
        )
    if style == "curly":
        made.append(
            shaper.blob(
                "curly",
                "head",
                head.chin + np.array([0, 0.145, -0.030]) * head.size,
                np.array([0.098, 0.095, 0.096]) * head.size,
                12,
                8,
                paint_hair,
                (96, 64),
                2.2,
            )
        )
    return made
