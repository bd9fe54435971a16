"""The trunk: its measures, garments over it, and shapes that hang on one joint.

Everything is made at the reference height and scaled by the build at the end.
"""

import numpy as np

from ..noise import smoothstep
from .parts import Part, ring_at, table, unit_ring

# height, half width, front, back, middle's z
TORSO_MAN = [
    (0.78, 0.100, 0.070, 0.080, 0.0),
    (0.86, 0.158, 0.096, 0.108, 0.0),
    (0.92, 0.170, 0.104, 0.126, 0.0),
    (0.98, 0.166, 0.106, 0.116, 0.0),
    (1.04, 0.155, 0.106, 0.096, 0.0),
    (1.10, 0.150, 0.108, 0.090, 0.0),
    (1.18, 0.158, 0.112, 0.100, 0.0),
    (1.26, 0.171, 0.118, 0.112, 0.0),
    (1.33, 0.182, 0.112, 0.116, 0.0),
    (1.38, 0.186, 0.098, 0.110, -0.004),
    (1.42, 0.172, 0.080, 0.098, -0.008),
    (1.45, 0.132, 0.066, 0.086, -0.012),
    (1.475, 0.088, 0.056, 0.072, -0.014),
    (1.50, 0.064, 0.050, 0.060, -0.014),
]
TORSO_WOMAN = [
    (0.78, 0.105, 0.068, 0.085, 0.0),
    (0.86, 0.170, 0.094, 0.120, 0.0),
    (0.92, 0.180, 0.100, 0.132, 0.0),
    (0.98, 0.168, 0.100, 0.112, 0.0),
    (1.04, 0.142, 0.094, 0.086, 0.0),
    (1.10, 0.130, 0.090, 0.078, 0.0),
    (1.18, 0.138, 0.100, 0.086, 0.0),
    (1.26, 0.148, 0.128, 0.096, 0.0),
    (1.33, 0.154, 0.106, 0.100, 0.0),
    (1.38, 0.158, 0.086, 0.096, -0.004),
    (1.42, 0.148, 0.070, 0.088, -0.008),
    (1.45, 0.116, 0.058, 0.078, -0.012),
    (1.475, 0.080, 0.050, 0.066, -0.014),
    (1.50, 0.058, 0.044, 0.054, -0.014),
]
# Table heights at which a garment has rows.
TRUNK = (0.93, 0.98, 1.04, 1.10, 1.18, 1.26, 1.32, 1.37, 1.405, 1.435, 1.46, 1.48, 1.50)


class Shaper:
    """Makes the parts of one person around a rig: here the trunk, `limbs` has arms and legs."""

    def __init__(self, rig):
        self.rig, self.build, self.s = rig, rig.build, rig.build.scale
        self.count = len(rig.names)
        self.rise = (self.build.legs - 1) * 0.915

    def blank(self, rows, columns):
        return np.zeros((rows, columns + 1, self.count))

    def j(self, name):
        return self.rig.index[name]

    def lift(self, y):
        """A table's height on this person before scaling: legs stretch below the hip, the trunk above is pushed and
        a little squeezed.
        """
        y = np.asarray(y, dtype=np.float64)
        return np.where(y < 0.915, y * self.build.legs, y + self.rise * np.clip((1.75 - y) / (1.75 - 0.915), 0, 1))

    def torso_at(self, y):
        """Half width, front, back and middle of the body at table height y."""
        b = self.build
        shape = table(TORSO_MAN, y) * (1 - b.female) + table(TORSO_WOMAN, y) * b.female
        heavy = b.weight * np.exp(-(((np.asarray(y) - 1.06) / 0.15) ** 2))
        shape[..., 0] *= 1 + 0.10 * b.weight + 0.06 * heavy
        shape[..., 0] *= 1 + (b.shoulders - 1) * smoothstep(1.2, 1.36, y)
        shape[..., 1] *= 1 + 0.10 * b.weight + (0.32 if b.weight > 0 else 0.08) * heavy
        shape[..., 2] *= 1 + 0.10 * b.weight
        return shape

    def torso_weights(self, heights, columns, grid):
        """Heights are the table's. Below the hips the cloth follows the thighs, split softly between left and right."""
        w = self.blank(len(heights), columns)
        for row, y in enumerate(heights):
            x = grid[row, :, 0] / self.s
            down = 1 - smoothstep(0.72, 0.96, y)
            left = smoothstep(-0.075, 0.075, x)
            w[row, :, self.j("left_thigh")], w[row, :, self.j("right_thigh")] = 0.96 * down * left, 0.96 * down * (
                1 - left
            )
            rest = 1 - 0.96 * down
            spine, chest = smoothstep(0.98, 1.12, y), smoothstep(1.13, 1.28, y)
            neck = 0.6 * smoothstep(1.47, 1.52, y)
            w[row, :, self.j("hips")] = rest * (1 - spine)
            w[row, :, self.j("spine")] = rest * spine * (1 - chest)
            for side, sign in (("left", 1), ("right", -1)):
                arm = 0.55 * smoothstep(0.125, 0.20, sign * x) * smoothstep(1.24, 1.38, y)
                collar = 0.5 * smoothstep(0.05, 0.13, sign * x) * smoothstep(1.30, 1.42, y) * (1 - arm)
                w[row, :, self.j(f"{side}_upper_arm")] += rest * chest * arm * (1 - neck)
                w[row, :, self.j(f"{side}_shoulder")] += rest * chest * collar * (1 - neck)
            w[row, :, self.j("neck")] = rest * chest * neck
            w[row, :, self.j("chest")] = np.maximum(0, 1 - w[row].sum(axis=1))
        return w

    def torso(self, name, heights, ease, columns=20, power=2.3, hem=None, **keywords):
        """A garment (or skin) around the trunk at the table's `heights`, `ease` metres off the body (a number or a
        function of height).

        Below 0.86 it hangs down instead of following the crotch. `hem` turns the lowest edge inwards by so many metres.
        """
        heights = np.asarray(heights, dtype=np.float64)
        rows = []
        for y in heights:
            off = ease(y) if callable(ease) else ease
            half, front, back, z = self.torso_at(max(y, 0.90))
            rows.append(ring_at((0, self.lift(y), z), (0, 1, 0), half + off, front + off, back + off, columns, power))
        if hem:
            inner = rows[0].copy()
            middle = inner[:-1].mean(axis=0)
            inner = middle + (inner - middle) * (1 - hem / 0.17) + (0, 0.012, 0)
            rows.insert(0, inner)
            heights = np.insert(heights, 0, heights[0])
        grid = np.array(rows) * self.s
        return Part(name, grid, self.torso_weights(heights, columns, grid), tags={"heights": heights}, **keywords)

    def neck(self, paint):
        heights = np.array([1.43, 1.475, 1.515, 1.555, 1.60])
        radius = 0.057 - 0.009 * self.build.female + 0.007 * max(self.build.weight, 0)
        rows, w = [], self.blank(len(heights), 12)
        for row, y in enumerate(heights):
            r = radius * (1.14 if row == 0 else 1.03 if row == 1 else 0.98)
            rows.append(
                ring_at((0, self.lift(y), -0.022 + 0.022 * (y - 1.43) / 0.17), (0, 1, -0.15), r, r * 0.95, r * 1.02, 12)
            )
            up = smoothstep(1.53, 1.60, y)
            neck = smoothstep(1.44, 1.50, y) * (1 - up)
            w[row, :, self.j("head")], w[row, :, self.j("neck")] = up, neck
            w[row, :, self.j("chest")] = 1 - up - neck
        return Part("neck", np.array(rows) * self.s, w, (48, 24), paint)

    def fixed(self, part, joint):
        part.weights[:] = 0
        part.weights[..., self.j(joint)] = 1
        return part

    def blob(self, name, joint, centre, radii, columns, rows, paint, texels=(32, 32), power=2.0, turn=None):
        """A closed rounded shape (superellipsoid) fixed to one joint: buns, bags, ears."""
        boxy = power >= 3.5
        ring = (
            unit_ring(0, power, (0, 38, 52, 90, 128, 142, 180, 218, 232, 270, 308, 322, 360))
            if boxy
            else unit_ring(columns, power)
        )
        grid = []
        for lat in (-90, -54, -38, 0, 38, 54, 90) if boxy else np.linspace(-90, 90, rows):
            c, s = np.cos(np.radians(lat)), np.sin(np.radians(lat))
            length = (abs(c) ** power + abs(s) ** power) ** (1 / power)
            c, s = (0.0, np.sign(s)) if abs(lat) == 90 else (c / length, s / length)
            grid.append(np.stack([ring[:, 0] * c, np.full(len(ring), s), ring[:, 1] * c], axis=1))
        grid = np.array(grid) * radii
        if turn is not None:
            grid = grid @ np.asarray(turn).T
        return self.fixed(
            Part(name, (grid + centre) * self.s, self.blank(len(grid), len(ring) - 1), texels, paint), joint
        )
