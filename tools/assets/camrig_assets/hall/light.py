"""Bakes the light of a room: diffuse light from the sky, lamps and all surfaces onto lightmap texels and vertices.

Monte Carlo gathering with fixed directions, turned by a fixed angle at each receiver; a few bounces, each reading the
one before. Everything in the world frame (z up); light is grey (one number), as the occlusion texture that carries it.
"""

from dataclasses import dataclass

import numpy as np

from .. import ao, noise

LIFT = 0.006


@dataclass
class Chart:
    """A rectangle of the lightmap and the surface it covers."""

    size: tuple  # texels
    place: object  # function(s, t) in 0..1 -> (points, normals)
    albedo: float
    rect: tuple = None


def pack(charts, width):
    """Shelf packing with one texel between charts; returns the height used."""
    x = y = shelf = 0
    for chart in sorted(charts, key=lambda c: (-c.size[1], -c.size[0])):
        w, h = chart.size[0] + 2, chart.size[1] + 2
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        chart.rect = (x + 1, y + 1, chart.size[0], chart.size[1])
        x, shelf = x + w, max(shelf, h)
    return y + shelf


def chart_uv(chart, st, size):
    """Lightmap coordinates of chart coordinates st (0..1)."""
    x, y, w, h = chart.rect
    return np.stack([(x + 0.5 + st[:, 0] * (w - 1)) / size[0], (y + 0.5 + st[:, 1] * (h - 1)) / size[1]], axis=1)


class Room:
    """Triangles with what they send back: through a lightmap (charts), or one value each (everything else)."""

    def __init__(self, size, sky, ground):
        self.size, self.sky, self.ground = size, sky, ground
        self.positions, self.triangles, self.uv = [], [], []
        self.albedo, self.glow, self.mapped, self.owner = [], [], [], []
        self.lamps = []
        self._count = 0

    def add(self, positions, triangles, albedo, glow=0.0, uv1=None, owner=-1):
        """`owner` groups triangles whose mean light is kept in one place (a prop instance)."""
        self.positions.append(np.asarray(positions))
        self.triangles.append(np.asarray(triangles) + self._count)
        self.uv.append(np.zeros((len(positions), 2)) if uv1 is None else uv1)
        n = len(triangles)
        self.albedo.append(np.full(n, albedo))
        self.glow.append(np.full(n, glow, dtype=np.float64) if np.isscalar(glow) else glow)
        self.mapped.append(np.full(n, uv1 is not None))
        self.owner.append(np.full(n, owner))
        self._count += len(positions)

    def add_lamp(self, centre, radius, area, radiance):
        """A disc that shines downwards; its triangles, if any, must not glow themselves."""
        self.lamps.append((np.asarray(centre, dtype=np.float64), radius, area * radiance))

    def close(self, owners):
        join = np.concatenate
        self.positions, self.triangles, self.uv = join(self.positions), join(self.triangles), join(self.uv)
        self.albedo, self.glow, self.mapped, self.owner = (
            join(self.albedo),
            join(self.glow),
            join(self.mapped),
            join(self.owner),
        )
        self.rays = ao.Rays(self.positions, self.triangles)
        self.corner_uv = self.uv[self.triangles]
        self.map = np.zeros((self.size[1], self.size[0]))
        self.owner_light = np.zeros(owners)

    def gather(self, points, normals, count):
        """(light, share of rays that met a near back face) at each receiver."""
        points = points + normals * LIFT
        tangent, bitangent = ao.frames(normals)
        cell = np.floor(points * 977).astype(np.int64)
        turn = noise._lattice(cell[:, 0], cell[:, 1], cell[:, 2], 3) * 2 * np.pi
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        tangent, bitangent = tangent * c + bitangent * s, bitangent * c - tangent * s
        points, tangent, bitangent, upright = (a.astype(np.float32) for a in (points, tangent, bitangent, normals))
        light, backs = np.zeros(len(points)), np.zeros(len(points))
        for x, y, z in ao.hemisphere(count).astype(np.float32):
            directions = tangent * x + bitangent * y + upright * z
            seen, back = self._radiance(points, directions)
            light += seen
            backs += back
        return light / count, backs / count

    def lamp_light(self, points, normals):
        """Light straight from the lamps: one shadow ray to a point of each, another point for each receiver."""
        points = points + normals * LIFT
        cell = np.floor(points * 977).astype(np.int64)
        total = np.zeros(len(points))
        for i, (centre, radius, power) in enumerate(self.lamps):
            turn = noise._lattice(cell[:, 0], cell[:, 1], cell[:, 2], 40 + 2 * i) * 2 * np.pi
            way = radius * np.sqrt(noise._lattice(cell[:, 0], cell[:, 1], cell[:, 2], 41 + 2 * i))
            to = centre + np.stack([way * np.cos(turn), way * np.sin(turn), np.full(len(turn), -0.03)], axis=1) - points
            distance = np.linalg.norm(to, axis=1)
            to /= distance[:, None]
            share = power * np.maximum(0, (normals * to).sum(axis=1)) * np.maximum(0, to[:, 2]) / (np.pi * distance**2)
            lit = np.flatnonzero(share > 0.002)
            if len(lit):
                free = (
                    self.rays.scene.run(points[lit].astype(np.float32), to[lit].astype(np.float32), output=1)["tfar"]
                    > distance[lit] - 0.02
                )
                total[lit] += np.minimum(share[lit], 3.0) * free
        return total

    def _radiance(self, points, directions):
        out = self.rays.scene.run(points, directions, output=1)
        hit = out["primID"]
        missed = hit < 0
        hit = np.where(missed, 0, hit)
        back = ((out["Ng"] * directions).sum(axis=1) > 0) & ~missed
        corner = self.corner_uv[hit]
        u, v = out["u"][:, None], out["v"][:, None]
        uv = corner[:, 0] * (1 - u - v) + corner[:, 1] * u + corner[:, 2] * v
        px = np.clip((uv[:, 0] * self.size[0]).astype(np.int64), 0, self.size[0] - 1)
        py = np.clip((uv[:, 1] * self.size[1]).astype(np.int64), 0, self.size[1] - 1)
        stored = np.where(self.mapped[hit], self.map[py, px], self.owner_light[self.owner[hit]])
        radiance = self.glow[hit] + self.albedo[hit] * stored
        sky = np.where(directions[:, 2] > 0.02, self.sky, self.ground)
        return np.where(missed, sky, np.where(back, 0.0, radiance)), back & (out["tfar"] < 0.6)

    def bake(self, charts, vertex_sets, counts):
        """Fills every chart's texels and returns the light of the vertex sets [(points, normals, owner)]; one bounce
        for each of `counts`.
        """
        texels = [_texels(chart) for chart in charts]
        points = np.concatenate([t[0] for t in texels] + [v[0] for v in vertex_sets])
        normals = np.concatenate([t[1] for t in texels] + [v[1] for v in vertex_sets])
        direct = self.lamp_light(points, normals)
        for count in counts:
            light, backs = self.gather(points, normals, count)
            light += direct
            at = 0
            for chart, (place, _) in zip(charts, texels):
                x, y, w, h = chart.rect
                block = slice(at, at + len(place))
                self.map[y : y + h, x : x + w] = _cleaned(
                    light[block].reshape(h, w), backs[block].reshape(h, w) > 0.30, w, h
                )
                at += len(place)
            vertex_light = []
            for place, _, owner in vertex_sets:
                block = slice(at, at + len(place))
                values, hidden = light[block].copy(), backs[block] > 0.30
                if hidden.any() and not hidden.all():
                    values[hidden] = np.quantile(values[~hidden], 0.2)
                self.owner_light[owner] = values.mean()
                vertex_light.append(values)
                at += len(place)
        return vertex_light


def _texels(chart):
    w, h = chart.size
    s, t = np.meshgrid(
        np.clip(np.linspace(0, 1, w), 0.15 / w, 1 - 0.15 / w), np.clip(np.linspace(0, 1, h), 0.15 / h, 1 - 0.15 / h)
    )
    return chart.place(s.reshape(-1), t.reshape(-1))


def _cleaned(light, hidden, w, h):
    """Takes hidden texels (below furniture that stands on the floor) from their neighbours, darker, and smooths the
    noise.
    """
    light, hidden = light.copy(), hidden.copy()
    for _ in range(6):
        if not hidden.any() or hidden.all():
            break
        total, count = np.zeros_like(light), np.zeros_like(light)
        for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            value, known = _shift(light, dy, dx), ~_shift(hidden, dy, dx)
            total += np.where(known, value, 0)
            count += known
        fill = hidden & (count > 0)
        light[fill] = 0.85 * total[fill] / count[fill]
        hidden &= ~fill
    if min(w, h) < 4:
        return light
    weights = ((0, 0, 4), (0, 1, 2), (0, -1, 2), (1, 0, 2), (-1, 0, 2), (1, 1, 1), (1, -1, 1), (-1, 1, 1), (-1, -1, 1))
    for _ in range(2 if min(w, h) > 24 else 1):
        total = norm = 0.0
        for dy, dx, weight in weights:  # bilateral: an edge of a contact shadow stays
            value = _shift(light, dy, dx)
            k = weight * np.exp(-(((value - light) / (0.22 * light.mean() + 1e-6)) ** 2))
            total, norm = total + k * value, norm + k
        light = total / norm
    return light


def _shift(values, dy, dx):
    """The neighbour's value, the rim repeated."""
    h, w = values.shape
    return values[np.clip(np.arange(h) + dy, 0, h - 1)][:, np.clip(np.arange(w) + dx, 0, w - 1)]
