"""The face: skin, beard, mouth, eyes, brows and the ground of the hair, painted by place on the head; eyeballs are parts of their own (eyes.py)."""

import numpy as np

from .. import noise
from ..noise import mix, smoothstep
from .eyes import lids
from .paint import hair, line, rgb, skin


def face(head, tone, hair_colour, look):
    """Painter of the head: skin, eyes, brows, mouth, beard and the ground of the hair."""
    brow = rgb(look["brows"]) if "brows" in look else np.asarray(hair_colour) * 0.7
    tone = np.asarray(tone)

    def paint(part, points, u, v):
        local = (points / head.shaper.s - head.chin) / head.size
        x, y, z = np.abs(local[..., 0]), local[..., 1], local[..., 2]
        colour = skin(points, tone)
        front = smoothstep(0.015, 0.05, z)
        if "ear" in part.name:
            return (
                colour
                * np.array([0.97, 0.90, 0.89])
                * (0.88 + 0.12 * smoothstep(0.0, 0.5, np.abs(v - 0.5) * 2))[..., None]
            )

        def spot(px, py, wx, wy):
            return np.exp(-(((x - px) / wx) ** 2) - ((y - py) / wy) ** 2) * front

        flush = (
            0.55 * spot(0.046, 0.080, 0.020, 0.016)
            + 0.5 * spot(0, 0.076, 0.012, 0.010)
            + 0.2 * spot(0.03, 0.015, 0.03, 0.02)
        )
        colour = colour * (1 - flush[..., None] * np.array([0.02, 0.13, 0.12]) * (0.6 + look.get("flush", 0.5)))
        shade = (
            0.20 * spot(0.020, 0.114, 0.010, 0.010)
            + 0.10 * spot(0.032, 0.103, 0.016, 0.004)
            + 0.16 * spot(0, 0.063, 0.012, 0.004)
            + 0.10 * spot(0, 0.030, 0.016, 0.005)
        )
        shade = (
            shade
            + 0.14 * spot(0.0155, 0.076, 0.004, 0.008)
            + 0.12 * smoothstep(0.004, -0.012, y)
            + 0.12 * spot(0.034, 0.122, 0.018, 0.004)
        )
        light = (
            0.10 * spot(0, 0.092, 0.005, 0.016)
            + 0.06 * spot(0.030, 0.093, 0.016, 0.006)
            + 0.05 * spot(0, 0.155, 0.04, 0.016)
        )
        colour = colour * (1 - shade + light)[..., None]
        # beard before the mouth
        beard = look.get("beard", 0.0)
        if beard:
            edge = np.interp(x, [0, 0.020, 0.040, 0.058, 0.072], [0.030, 0.030, 0.045, 0.075, 0.100])
            cover = smoothstep(edge + 0.006, edge - 0.006, y) * smoothstep(-0.02, 0.015, z)
            lip_gap = 1 - np.clip(spot(0, 0.0455, 0.021, 0.0105) * 1.8, 0, 1)
            moustache = smoothstep(0.0095, 0.003, np.abs(y - (0.0585 - 0.18 * x))) * smoothstep(0.034, 0.026, x) * front
            cover = np.maximum(cover * lip_gap, moustache)
            colour = mix(colour, hair(points, np.asarray(hair_colour) * 0.85, 31, 0), np.clip(cover * beard, 0, 1))
        # mouth
        lips = (
            np.clip(
                1.4
                - ((x / 0.0245) ** 2 + (np.where(y > 0.0455, (y - 0.0455) / 0.0070, (y - 0.0455) / 0.0085)) ** 2) * 1.4,
                0,
                1,
            )
            * front
        )
        lip_tone = tone * np.array([0.86, 0.60, 0.60]) if "lips" not in look else rgb(look["lips"])
        colour = mix(colour, lip_tone, lips * look.get("lip_strength", 0.75))
        colour = mix(
            colour,
            tone * np.array([0.40, 0.24, 0.22]),
            line(y - 0.0458 - 1.2 * x**2, 0.0022) * smoothstep(0.026, 0.021, x) * front * 0.85,
        )
        colour = mix(
            colour, tone * np.array([0.42, 0.28, 0.26]), np.clip(spot(0.0078, 0.0675, 0.0036, 0.0026) * 1.3, 0, 1) * 0.8
        )
        # eyes
        ex, ey = x - 0.0310, y - 0.1125
        upper, lower = lids(ex)
        inside = smoothstep(-0.0006, 0.0008, np.minimum(upper - ey, ey - lower)) * (np.abs(ex) < 0.0140) * front
        # What is seen beside the eyeball's rim.
        colour = mix(colour, tone * np.array([0.72, 0.52, 0.48]), inside)
        lash = line(ey - upper - 0.0006, look.get("lashes", 0.0020)) * (np.abs(ex) < 0.0150) * front
        colour = mix(colour, np.array([0.10, 0.07, 0.06]), lash * 0.9)
        colour = mix(colour, tone * 0.55, line(ey - lower + 0.0004, 0.0012) * (np.abs(ex) < 0.0135) * front * 0.5)
        colour = mix(colour, tone * 0.62, line(ey - upper - 0.0048, 0.0016) * (np.abs(ex) < 0.0130) * front * 0.5)
        # brows: rise outwards, then fall
        bx = (x - 0.012) / 0.038
        middle = 0.1290 + 0.006 * np.sin(np.clip(bx, 0, 1) * 2.5) - 0.002
        thick = look.get("brow_width", 0.0042) * (1 - 0.55 * np.clip(bx, 0, 1))
        hairs = 0.75 + 0.5 * (noise.value(points * (500, 300, 300), 77) - 0.5)
        colour = mix(
            colour,
            brow,
            np.clip(
                line(y - middle, thick * 1.5)
                * smoothstep(-0.04, 0.06, bx)
                * smoothstep(1.04, 0.92, bx)
                * front
                * hairs,
                0,
                1,
            ),
        )
        if look.get("glasses"):
            rim = line(np.hypot(ex * 0.95, (ey + 0.002) * 1.15) - 0.0195, 0.0022) * front
            bridge = line(y - 0.1150, 0.0022) * (x < 0.0125) * front
            temple = line(y - 0.1150, 0.0024) * smoothstep(0.049, 0.052, x) * (z > -0.01)
            colour = mix(
                colour, np.array([0.08, 0.07, 0.07]), np.clip(np.maximum(np.maximum(rim, bridge), temple), 0, 1)
            )
        # hair
        cover = head.hair_cover(local)
        ragged = cover + 0.006 * (noise.value(points * 90, 12) - 0.5)
        grown = smoothstep(-0.004, 0.006, ragged)
        return mix(colour, strands(head, hair_colour, look, points, local), grown)

    return paint


def strands(head, hair_colour, look, points, local):
    """Hair on the skull: darker at its line, with a light band above the brow."""
    y, cover = local[..., 1], head.hair_cover(local)
    made = hair(points, hair_colour, 7, look.get("strands", 1))
    return (
        made
        * (0.72 + 0.28 * smoothstep(0.02, 0.10, cover))[..., None]
        * (1 + 0.16 * np.exp(-(((y - 0.185) / 0.016) ** 2)))[..., None]
    )


def shell(head, hair_colour, look):
    """Painter of the hair that lies on the skull."""
    return lambda part, points, u, v: strands(
        head, hair_colour, look, points, (points / head.shaper.s - head.chin) / head.size
    )
