"""The people's shapes: grids of rings lofted around the bones, each with its share of the texture and its joint weights.

Tables are in metres for a person of 1.75 m; everything is scaled by the build at the end. Where two parts meet (arm and torso,
leg and pelvis) `blend_joins` bends normals and surface so that the light passes over the join without an edge.
"""

from dataclasses import dataclass, field

import numpy as np

from .noise import smoothstep
from .shapes import grid_normals, grid_triangles


@dataclass
class Part:
    """A grid of vertices: rows run from its far end (bottom, fingertip) up, columns counter-clockwise from the back; column 0 is repeated."""
    name: str
    grid: np.ndarray                   # rows x columns+1 x 3
    weights: np.ndarray                # rows x columns+1 x joints
    texels: tuple = (64, 64)           # wanted width, height in the texture
    paint: object = None               # function(part, points, u, v) -> sRGB
    normals: np.ndarray = None
    keep: np.ndarray = None            # rows x columns+1, False: outside (triangles with no kept corner are dropped)
    rect: tuple = None                 # place in the atlas, set when packed
    uses: "Part" = None                # shares the texture of another part with the same grid topology
    tags: dict = field(default_factory=dict)

    def __post_init__(self):
        if self.normals is None:
            self.normals = grid_normals(self.grid, True)

    def triangles(self):
        triangles = grid_triangles(*self.grid.shape[:2])
        corners = self.grid.reshape(-1, 3)[triangles]
        sound = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 2e-9
        if self.keep is not None:
            sound &= self.keep.reshape(-1)[triangles].any(axis=1)
        return triangles[sound]


def unit_ring(columns, power=2.0, angles=None):
    """(x, z) of a superellipse of radius one, from the back (-z) over the right (-x) to the front; the first point is repeated."""
    turn = np.linspace(0, 2 * np.pi, columns + 1) if angles is None else np.radians(angles)
    x, z = -np.sin(turn), -np.cos(turn)
    length = (np.abs(x) ** power + np.abs(z) ** power) ** (1 / power)
    return np.stack([x / length, z / length], axis=1)


def ring_at(centre, up, half_width, front, back, columns, power=2.0, facing=(0, 0, 1)):
    """One ring across a bone: `up` points back along the bone, `facing` is where its front looks."""
    up = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    z = np.asarray(facing, dtype=np.float64)
    z = z - up * (z @ up)
    z /= np.linalg.norm(z)
    flat = unit_ring(columns, power)
    depth = np.where(flat[:, 1] > 0, front, back) * flat[:, 1]
    return np.asarray(centre) + flat[:, :1] * half_width * np.cross(up, z) + depth[:, None] * z


def table(rows, at):
    """Smooth interpolation in a table whose first column is the parameter."""
    rows = np.asarray(rows, dtype=np.float64)
    return np.stack([_monotone(rows[:, 0], rows[:, k], at) for k in range(1, rows.shape[1])], axis=-1)


def _monotone(x, y, at):
    """Monotone cubic interpolation (Fritsch-Carlson 1980): no overshoot between the given values."""
    x, y, at = np.asarray(x), np.asarray(y), np.clip(at, x[0], x[-1])
    h = np.diff(x)
    slope = np.diff(y) / h
    tangent = np.zeros_like(y)
    same = slope[:-1] * slope[1:] > 0
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent[1:-1] = np.where(same, (w1 + w2) / (w1 / slope[:-1] + w2 / slope[1:]), 0)
    tangent[0], tangent[-1] = slope[0], slope[-1]
    i = np.clip(np.searchsorted(x, at, "right") - 1, 0, len(h) - 1)
    t = (at - x[i]) / h[i]
    return ((2 * t ** 3 - 3 * t ** 2 + 1) * y[i] + (t ** 3 - 2 * t ** 2 + t) * h[i] * tangent[i]
            + (-2 * t ** 3 + 3 * t ** 2) * y[i + 1] + (t ** 3 - t ** 2) * h[i] * tangent[i + 1])


# height, half width, front, back, middle's z
TORSO_MAN = [(0.78, 0.100, 0.070, 0.080, 0.0), (0.86, 0.158, 0.096, 0.108, 0.0), (0.92, 0.170, 0.104, 0.126, 0.0), (0.98, 0.166, 0.106, 0.116, 0.0),
             (1.04, 0.155, 0.106, 0.096, 0.0), (1.10, 0.150, 0.108, 0.090, 0.0), (1.18, 0.158, 0.112, 0.100, 0.0), (1.26, 0.171, 0.118, 0.112, 0.0),
             (1.33, 0.182, 0.112, 0.116, 0.0), (1.38, 0.186, 0.098, 0.110, -0.004), (1.42, 0.172, 0.080, 0.098, -0.008), (1.45, 0.132, 0.066, 0.086, -0.012),
             (1.475, 0.088, 0.056, 0.072, -0.014), (1.50, 0.064, 0.050, 0.060, -0.014)]
TORSO_WOMAN = [(0.78, 0.105, 0.068, 0.085, 0.0), (0.86, 0.170, 0.094, 0.120, 0.0), (0.92, 0.180, 0.100, 0.132, 0.0), (0.98, 0.168, 0.100, 0.112, 0.0),
               (1.04, 0.142, 0.094, 0.086, 0.0), (1.10, 0.130, 0.090, 0.078, 0.0), (1.18, 0.138, 0.100, 0.086, 0.0), (1.26, 0.148, 0.128, 0.096, 0.0),
               (1.33, 0.154, 0.106, 0.100, 0.0), (1.38, 0.158, 0.086, 0.096, -0.004), (1.42, 0.148, 0.070, 0.088, -0.008), (1.45, 0.116, 0.058, 0.078, -0.012),
               (1.475, 0.080, 0.050, 0.066, -0.014), (1.50, 0.058, 0.044, 0.054, -0.014)]
# way along the arm (0 shoulder joint, 1 elbow, 2 wrist), radius across, front, back
ARM = [(-0.115, 0.004, 0.004, 0.004), (-0.095, 0.026, 0.030, 0.030), (-0.04, 0.044, 0.050, 0.052), (0.08, 0.054, 0.060, 0.061), (0.25, 0.052, 0.057, 0.057),
       (0.55, 0.046, 0.051, 0.050), (0.85, 0.041, 0.043, 0.043), (1.0, 0.041, 0.041, 0.044), (1.15, 0.043, 0.044, 0.043), (1.35, 0.041, 0.043, 0.040),
       (1.7, 0.031, 0.034, 0.031), (2.0, 0.023, 0.029, 0.028), (2.08, 0.022, 0.030, 0.029)]
# height, half width, front, back
LEG = [(0.05, 0.034, 0.036, 0.046), (0.10, 0.034, 0.036, 0.046), (0.18, 0.039, 0.041, 0.052), (0.28, 0.049, 0.046, 0.066), (0.37, 0.054, 0.050, 0.073), (0.45, 0.052, 0.054, 0.060),
       (0.50, 0.056, 0.062, 0.056), (0.56, 0.060, 0.066, 0.062), (0.65, 0.069, 0.076, 0.072), (0.75, 0.080, 0.086, 0.086), (0.83, 0.088, 0.092, 0.100),
       (0.90, 0.088, 0.092, 0.112), (0.96, 0.078, 0.085, 0.104)]


class Shaper:
    """Makes the parts of one person around a rig."""

    def __init__(self, rig):
        self.rig, self.build, self.s = rig, rig.build, rig.build.scale
        self.count = len(rig.names)
        self.rise = (self.build.legs - 1) * 0.915

    def blank(self, rows, columns):
        return np.zeros((rows, columns + 1, self.count))

    def j(self, name):
        return self.rig.index[name]

    def lift(self, y):
        """A table's height on this person before scaling: legs stretch below the hip, the trunk above is pushed and a little squeezed."""
        y = np.asarray(y, dtype=np.float64)
        return np.where(y < 0.915, y * self.build.legs, y + self.rise * np.clip((1.75 - y) / (1.75 - 0.915), 0, 1))

    def torso_at(self, y):
        """Half width, front, back and middle of the body at table height y."""
        b = self.build
        shape = table(TORSO_MAN, y) * (1 - b.female) + table(TORSO_WOMAN, y) * b.female
        heavy = b.weight * np.exp(-((np.asarray(y) - 1.06) / 0.15) ** 2)
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
            w[row, :, self.j("left_thigh")], w[row, :, self.j("right_thigh")] = 0.96 * down * left, 0.96 * down * (1 - left)
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
        """A garment (or skin) around the trunk at the table's `heights`, `ease` metres off the body (a number or a function of height).

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
            rows.append(ring_at((0, self.lift(y), -0.022 + 0.022 * (y - 1.43) / 0.17), (0, 1, -0.15), r, r * 0.95, r * 1.02, 12))
            up = smoothstep(1.53, 1.60, y)
            neck = smoothstep(1.44, 1.50, y) * (1 - up)
            w[row, :, self.j("head")], w[row, :, self.j("neck")] = up, neck
            w[row, :, self.j("chest")] = 1 - up - neck
        return Part("neck", np.array(rows) * self.s, w, (48, 24), paint)

    def arm_frame(self, side, t):
        """Place on the arm's axis at t (0 shoulder, 1 elbow, 2 wrist) and the direction back up the arm; not scaled."""
        places = [self.rig.at(f"{side}_{n}") / self.s for n in ("upper_arm", "forearm", "hand")]
        first, second = places[1] - places[0], places[2] - places[1]
        point = places[0] + first * min(t, 1) + second * max(t - 1, 0)
        bend = smoothstep(0.85, 1.15, t)
        up = -(first / np.linalg.norm(first) * (1 - bend) + second / np.linalg.norm(second) * bend)
        return point, up

    def arm(self, name, side, from_t, to_t, ease, columns=9, cuff=0.0, stations=None, **keywords):
        """A sleeve or bare arm between two stations, `ease` off the skin; `cuff` closes the lower end inwards."""
        ts = stations if stations is not None else [-0.115, -0.095, -0.04, 0.08, 0.28, 0.60, 0.86, 1.0, 1.14, 1.4, 1.7, 2.0]
        ts = np.array([t for t in ts if from_t <= t < to_t - 0.03] + [to_t])
        thick = 1 + 0.10 * self.build.weight - 0.14 * self.build.female
        rows, kept = [], []
        for t in ts[::-1]:
            point, up = self.arm_frame(side, t)
            half, front, back = table(ARM, t) * thick
            off = ease(t) if callable(ease) else ease
            off *= smoothstep(-0.125, -0.03, t)
            rows.append(ring_at(point, up, half + off, front + off, back + off, columns, 2.2))
            kept.append(t)
        if cuff:
            middle = rows[0][:-1].mean(axis=0)
            rows.insert(0, middle + (rows[0] - middle) * (1 - cuff) + 0.008 * self.arm_frame(side, to_t)[1])
            kept.insert(0, kept[0])
        w = self.blank(len(kept), columns)
        for row, t in enumerate(kept):
            fore, hand = smoothstep(0.84, 1.16, t), smoothstep(1.88, 2.04, t)
            top = 1 - smoothstep(-0.25, 0.22, t)
            w[row, :, self.j(f"{side}_hand")] = hand
            w[row, :, self.j(f"{side}_forearm")] = fore * (1 - hand)
            w[row, :, self.j(f"{side}_shoulder")] = 0.45 * top
            w[row, :, self.j("chest")] = 0.12 * top
            w[row, :, self.j(f"{side}_upper_arm")] = (1 - fore) * (1 - 0.57 * top)
        grid = np.array(rows) * self.s
        return Part(name, grid, w, tags={"stations": np.array(kept), "side": side}, **keywords)

    def leg(self, name, side, heights, ease, columns=12, power=2.1, cuff=0.0, **keywords):
        """A trouser leg or bare leg over the table's heights (rising)."""
        sign = 1 if side == "left" else -1
        hip, knee, foot = (self.rig.at(f"{side}_{n}") / self.s for n in ("thigh", "shin", "foot"))
        thick = 1 + 0.10 * self.build.weight
        rows, kept = [], list(heights)
        for y in heights:
            half, front, back = table(LEG, y) * thick
            off = np.asarray(ease(y) if callable(ease) else ease) * np.ones(3)   # across, front, back
            lifted = self.lift(y)
            axis = foot + (knee - foot) * min(lifted / knee[1], 1) if lifted < knee[1] else knee + (hip - knee) * (lifted - knee[1]) / (hip[1] - knee[1])
            axis = np.array([axis[0], lifted, axis[2]])
            rows.append(ring_at(axis, (0, 1, 0), half + off[0], front + off[1], back + off[2], columns, power))
        if cuff:
            middle = rows[0][:-1].mean(axis=0)
            rows.insert(0, middle + (rows[0] - middle) * (1 - cuff) + (0, 0.012, 0))
            kept.insert(0, kept[0])
        grid = np.array(rows) * self.s
        w = self.blank(len(kept), columns)
        for row, y in enumerate(kept):
            shin = 1 - smoothstep(0.43, 0.57, y)
            foot_part = (1 - smoothstep(0.05, 0.12, y)) * 0.85
            x = grid[row, :, 0] / self.s * sign
            hips = smoothstep(0.78, 0.97, y) * (0.75 + 0.25 * smoothstep(0.06, -0.01, x))
            w[row, :, self.j(f"{side}_foot")] = shin * foot_part
            w[row, :, self.j(f"{side}_shin")] = shin * (1 - foot_part)
            w[row, :, self.j("hips")] = (1 - shin) * hips
            w[row, :, self.j(f"{side}_thigh")] = (1 - shin) * (1 - hips)
        return Part(name, grid, w, tags={"heights": np.array(kept), "side": side}, **keywords)

    def hand(self, name, side, paint):
        """Palm and fingers as one closed shape, slightly curled, and a thumb; the palm looks at the thigh."""
        sign = 1 if side == "left" else -1
        wrist, up = self.arm_frame(side, 2.0)
        size = 0.94 if self.build.female else 1.0
        rows = [(0.182, 0.006, 0.010), (0.176, 0.011, 0.024), (0.150, 0.0125, 0.034), (0.115, 0.014, 0.039), (0.085, 0.0155, 0.042), (0.045, 0.018, 0.036), (0.012, 0.020, 0.028), (-0.012, 0.020, 0.027)]
        grid = []
        for way, thick, broad in rows:
            curl = 0.030 * (way / 0.18) ** 2 + 0.004
            centre = wrist - up * way * size + np.array([-sign * curl, 0, 0.004 + 0.02 * way])
            grid.append(ring_at(centre, up, thick * size, broad * size, broad * size * 0.95, 8, 2.6))
        palm = self._fixed(Part(name, np.array(grid) * self.s, self.blank(len(rows), 8), (40, 56), paint, tags={"side": side}), f"{side}_hand")
        start = wrist - up * 0.030 * size + np.array([-sign * 0.006, 0, 0.022])
        heading = -up * 0.80 + np.array([-sign * 0.28, 0, 0.55])
        heading /= np.linalg.norm(heading)
        thumb = [ring_at(start + heading * way * size, -heading, r * size, r * size, r * size, 5) for way, r in ((0.075, 0.003), (0.069, 0.008), (0.045, 0.0105), (0.0, 0.013))]
        return [palm, self._fixed(Part(name + "_thumb", np.array(thumb) * self.s, self.blank(4, 5), (16, 16), paint, tags={"side": side}), f"{side}_hand")]

    def _fixed(self, part, joint):
        part.weights[:] = 0
        part.weights[..., self.j(joint)] = 1
        return part

    def shoe(self, name, side, paint, top=0.085, sole=0.018, length=1.0, width=1.0, pointed=0.0):
        """A shoe from heel to toe: rings stand upright along the foot; the sole is flat on the ground."""
        sign = 1 if side == "left" else -1
        ankle = self.rig.at(f"{side}_foot") / self.s
        size = 1 - 0.06 * self.build.female
        # z from the ankle, half width at the ground, height, width of the top against the ground
        rows = [(-0.072, 0.0, 0.030, 0.8), (-0.067, 0.022, top * 0.85, 0.8), (-0.045, 0.033, top, 0.88), (0.015, 0.036, top * 0.98, 0.87), (0.065, 0.042, 0.068, 0.72),
                (0.110, 0.046, 0.052, 0.70), (0.150, 0.043 * (1 - 0.12 * pointed), 0.041, 0.72), (0.180, 0.031 * (1 - 0.38 * pointed), 0.031, 0.68), (0.195 + 0.01 * pointed, 0.014 * (1 - 0.4 * pointed), 0.022, 0.6), (0.199 + 0.012 * pointed, 0.0, 0.014, 0.5)]
        shape = np.array([(0.0, 0.0), (-0.98, 0.0), (-1.03, 0.20), (-0.95, 0.50), (-0.55, 0.92), (0.0, 1.0), (0.55, 0.92), (0.95, 0.50), (1.03, 0.20), (0.98, 0.0), (0.0, 0.0)])
        grid, w = [], self.blank(len(rows), len(shape) - 1)
        for row, (z, half, high, taper) in enumerate(rows):
            inward = -sign * 0.006 * smoothstep(0.02, 0.19, z)
            x = shape[:, 0] * half * width * size * (1 - (1 - taper) * shape[:, 1] ** 2)
            grid.append(np.stack([ankle[0] + inward + x, shape[:, 1] * high, np.full(len(shape), ankle[2] + z * length * size)], axis=1))
            toes = smoothstep(0.095, 0.150, z)
            w[row, :, self.j(f"{side}_toes")], w[row, :, self.j(f"{side}_foot")] = toes, 1 - toes
        grid = np.array(grid)[::-1] * self.s   # rows run from the toe back, so that the columns turn the right way round
        return Part(name, grid, w[::-1].copy(), (48, 64), paint, tags={"side": side, "sole": sole})

    def blob(self, name, joint, centre, radii, columns, rows, paint, texels=(32, 32), power=2.0, turn=None):
        """A closed rounded shape (superellipsoid) fixed to one joint: buns, bags, ears."""
        boxy = power >= 3.5
        ring = unit_ring(0, power, (0, 38, 52, 90, 128, 142, 180, 218, 232, 270, 308, 322, 360)) if boxy else unit_ring(columns, power)
        grid = []
        for lat in (-90, -54, -38, 0, 38, 54, 90) if boxy else np.linspace(-90, 90, rows):
            c, s = np.cos(np.radians(lat)), np.sin(np.radians(lat))
            length = (abs(c) ** power + abs(s) ** power) ** (1 / power)
            c, s = (0.0, np.sign(s)) if abs(lat) == 90 else (c / length, s / length)
            grid.append(np.stack([ring[:, 0] * c, np.full(len(ring), s), ring[:, 1] * c], axis=1))
        grid = np.array(grid) * radii
        if turn is not None:
            grid = grid @ np.asarray(turn).T
        return self._fixed(Part(name, (grid + centre) * self.s, self.blank(len(grid), len(ring) - 1), texels, paint), joint)


def blend_joins(parts, pairs, scale):
    """Rounds the joins: for each pair of names, normals lean and the surface swells where the other part is near."""
    by_name = {part.name: part for part in parts}
    for first, second, radius in pairs:
        if first not in by_name or second not in by_name:
            continue
        moves = []
        for part, other in ((by_name[first], by_name[second]), (by_name[second], by_name[first])):
            points, cloud, cloud_normals = part.grid.reshape(-1, 3), other.grid.reshape(-1, 3), other.normals.reshape(-1, 3)
            cloud, cloud_normals = _denser(other)
            nearest = np.concatenate([((block[:, None] - cloud[None]) ** 2).sum(-1).argmin(1) for block in np.array_split(points, 8)])
            away = ((points - cloud[nearest]) * cloud_normals[nearest]).sum(axis=1)  # > 0 outside the other part
            near = np.exp(-np.maximum(away, 0) / (radius * scale)) * (np.linalg.norm(points - cloud[nearest], axis=1) < 3.5 * radius * scale)
            moves.append((part, near[:, None], cloud_normals[nearest]))
        for part, near, other_normals in moves:
            normals = part.normals.reshape(-1, 3) + near * other_normals
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            normals = np.where(length > 0.3, normals / np.maximum(length, 1e-9), part.normals.reshape(-1, 3))
            part.grid = (part.grid.reshape(-1, 3) + normals * near * 0.16 * radius * scale).reshape(part.grid.shape)
            part.normals = normals.reshape(part.normals.shape)


def _denser(part):
    """Points and normals of a part's surface at twice its grid's density."""
    def refine(values):
        values = np.stack([values[:-1], (values[:-1] + values[1:]) / 2], 1).reshape(-1, *values.shape[1:])
        values = np.swapaxes(values, 0, 1)
        values = np.stack([values[:-1], (values[:-1] + values[1:]) / 2], 1).reshape(-1, *values.shape[1:])
        return values.reshape(-1, 3)
    normals = refine(part.normals)
    return refine(part.grid), normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
