"""Painters of skin, sleeves, trousers, tights and shoes."""

import numpy as np

from .. import noise
from ..noise import mix, smoothstep
from . import paint
from .paint import along, cloth, folds, line, rgb


class Fabrics:
    """Painters of one person's skin and clothes; `tone` is the skin's sRGB colour."""

    def __init__(self, shaper, tone):
        self.shaper, self.s, self.tone = shaper, shaper.s, np.asarray(tone)

    def skin(self, part, points, u, v):
        colour = paint.skin(points, self.tone)
        if "hand" in part.name:
            colour = colour * np.array([1.0, 0.95, 0.94])
        if "finger" in part.name:  # lines at the joints and a nail at the tip, outside
            bent = line(v - 0.42, 0.05) + line(v - 0.16, 0.05)
            colour = colour * (1 - 0.12 * np.clip(bent, 0, 1))[..., None]
        if "leg" in part.name:
            knee = np.exp(-(((along(part, v, "heights") - 0.50) / 0.035) ** 2))
            colour = colour * (1 - 0.08 * knee)[..., None]
        if part.name == "neck":
            colour = colour * (0.90 - 0.10 * smoothstep(0.5, 0.0, v))[..., None]
        return colour

    def tights(self, colour):
        def painter(part, points, u, v):
            edge = np.abs(np.sin(np.pi * (u * 2 - 0.5)))
            return mix(cloth(points, rgb(colour), np.zeros(u.shape), 5), self.tone * 0.8, 0.18 * edge)

        return painter

    def sleeve(self, base, seed, strength=1.0, trim=None, weave=0.035):
        def painter(part, points, u, v):
            t = along(part, v, "stations")
            amount = strength * (
                0.35
                + 0.9 * np.exp(-(((t - 1.0) / 0.22) ** 2))
                + 0.6 * np.exp(-(((t - 0.1) / 0.2) ** 2))
                + 0.5 * np.exp(-(((t - 1.85) / 0.12) ** 2))
            )
            colour = cloth(points, rgb(base), folds(points, amount, seed, (10, 34, 10)), seed, weave)
            last = part.tags["stations"].max()
            colour = colour * (1 - 0.25 * line(t - last + 0.07, 0.015))[..., None]
            if trim:
                colour = mix(colour, rgb(trim), smoothstep(last - 0.05, last - 0.04, t))
            return colour

        return painter

    def trousers(self, base, seed, jeans=False, strength=1.0):
        base = rgb(base)

        def painter(part, points, u, v):
            if "heights" not in part.tags:
                return cloth(points, base, np.zeros(u.shape), seed)
            y = along(part, v, "heights")
            leg = part.name.startswith(("left", "right"))
            amount = strength * (
                0.30
                + (0.9 * np.exp(-(((y - 0.50) / 0.07) ** 2)) + 1.0 * np.exp(-(((y - 0.10) / 0.07) ** 2)) if leg else 0)
                + 0.9 * np.exp(-(((y - 0.84) / 0.06) ** 2))
            )
            colour = base
            if jeans:  # worn thighs, yellow seams
                worn = smoothstep(0.30, 0.0, np.abs(u - 0.5)) * (np.exp(-(((y - 0.66) / 0.13) ** 2)) * 0.8 + 0.25)
                colour = mix(
                    np.broadcast_to(base, points.shape),
                    np.minimum(base * 1.9 + 0.10, 1),
                    0.38 * worn * (0.7 + 0.6 * noise.fractal(points * 40, 2, seed)),
                )
            out = cloth(points, colour, folds(points, amount, seed, (8, 26, 8)), seed, 0.06 if jeans else 0.03)
            if leg:
                out = out * (1 - 0.20 * (line(np.abs(u - 0.5) - 0.25, 0.012)))[..., None]
                if not jeans:  # a pressed crease in front
                    out = out * (1 + 0.10 * line(u - 0.5, 0.02))[..., None]
                out = out * (1 - 0.25 * smoothstep(0.075, 0.06, y))[..., None]
            else:
                x = points[..., 0] / self.s
                out = out * (1 - 0.3 * line(x, 0.004) * (points[..., 2] > 0))[..., None]
                belt = smoothstep(0.975, 0.98, y)
                out = mix(out, np.array([0.12, 0.09, 0.07]), belt)
                buckle = belt * (np.abs(x) < 0.02) * (points[..., 2] > 0)
                out = mix(out, np.array([0.70, 0.68, 0.62]), buckle)
            return out

        return painter

    def shoe(self, upper, sole="#222222", toe=None):
        def painter(part, points, u, v):
            y = points[..., 1] / self.s
            z = (points[..., 2] - self.shaper.rig.at(f"{part.tags['side']}_foot")[2]) / self.s
            out = cloth(
                points, rgb(upper), folds(points, 0.5 * np.exp(-(((z - 0.10) / 0.03) ** 2)), 3, (12, 12, 40)), 9, 0.02
            )
            lace = (np.abs((z * 70) % 1 - 0.5) < 0.18) * (z > 0.03) * (z < 0.095) * (np.abs(u - 0.5) < 0.11)
            out = mix(out, np.clip(rgb(upper) * 0.55 + 0.25 * (rgb(upper).mean() < 0.4), 0, 1), 0.8 * lace)
            if toe:
                out = mix(out, rgb(toe), smoothstep(0.145, 0.15, z))
            return mix(out, rgb(sole), smoothstep(part.tags["sole"] + 0.003, part.tags["sole"], y))

        return painter

    def plain(self, colour, seed, grain=0.035):
        def painter(part, points, u, v):
            return cloth(points, rgb(colour), folds(points, 0.4, seed), seed, grain)

        return painter
