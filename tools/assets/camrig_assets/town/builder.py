"""Collects coloured meshes by material, bakes how open each vertex is, writes one GLB.

Everything is placed in world axes (z up, x along the street); the file gets glTF's (x, z, -y).
"""

import numpy as np

from .. import ao, shapes
from ..glb import LEAST_STEP, Glb
from ..noise import smoothstep

REACH_M = 2.5  # farther things darken nothing


def linear(colour):
    """Linear RGB of `#rrggbb`."""
    srgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def to_file(point):
    """A point or direction of the world in the file's axes."""
    x, y, z = point
    return (x, z, -y)


def block(low, high, sides=shapes.SIDES, cells=1):
    """The box between two corners. `sides` as in shapes.box: front is world -y, back +y, left +x, right -x."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    size = high - low
    return shapes.box((size[0], size[2], size[1]), to_file((low + high) / 2), sides, cells)


def slab(x0, x1, y0, y1, z, cell=1.0):
    """A level rectangle seen from above, in cells of about `cell` metres; u and v count metres."""
    cells = (max(1, round((x1 - x0) / cell)), max(1, round((y1 - y0) / cell)))
    mesh = shapes.quad(*(to_file(p) for p in ((x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z))), cells=cells)
    mesh.uv = np.stack([mesh.positions[:, 0], mesh.positions[:, 2]], axis=1)
    return mesh


def wall(start, end, z0, z1, cell=1.6):
    """An upright rectangle from `start` to `end` (world x, y), seen with `start` on its left; u and v count metres from the
    lower left."""
    (xa, ya), (xb, yb) = start, end
    length = float(np.hypot(xb - xa, yb - ya))
    cells = (max(1, round(length / cell)), max(1, round((z1 - z0) / cell)))
    mesh = shapes.quad(*(to_file(p) for p in ((xa, ya, z0), (xb, yb, z0), (xb, yb, z1), (xa, ya, z1))), cells=cells)
    mesh.uv = np.stack([mesh.uv[:, 0] * length, (1 - mesh.uv[:, 1]) * (z1 - z0)], axis=1)
    return mesh


def post(radius, height, at, top_radius=None, columns=10, rows=2):
    """A round upright bar on (x, y, z)."""
    return shapes.cylinder(radius, height, columns, rows=rows, top_radius=top_radius).moved(to_file(at))


def solid(mesh):
    """Its triangles that still have an area when the file's rounding is done."""
    corner = (np.round(mesh.positions / LEAST_STEP) * LEAST_STEP)[mesh.triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return mesh.triangles[area > 1e-8]


class Builder:
    """`materials`: name -> keys of Glb.material; a texture is given as a PNG or JPEG of (bytes, mime)."""

    def __init__(self, name, materials):
        self.name, self.materials = name, materials
        self._parts = []

    def add(self, mesh, material, colour=(1, 1, 1), shade=None):
        """`colour`: `#rrggbb`, linear RGB, or one linear RGB a vertex. `shade` in place of how open it is found: 1 = all."""
        colour = linear(colour) if isinstance(colour, str) else np.asarray(colour, dtype=float)
        colours = np.broadcast_to(colour, (len(mesh.positions), 3))
        self._parts.append((mesh, material, colours, shade))

    def bytes(self, least_light=0.25, count=96, floor=False):
        """The file. `floor`: an unseen floor at z = 0 darkens from below (for things that stand on another model's)."""
        soup = shapes.join(*(mesh for mesh, *_ in self._parts))
        positions, triangles = soup.positions, soup.triangles
        if floor:
            corners = np.array([[-30, 0, -30], [-30, 0, 30], [30, 0, 30], [30, 0, -30]], dtype=float)
            triangles = np.concatenate([triangles, np.array([[0, 1, 2], [0, 2, 3]]) + len(positions)])
            positions = np.concatenate([positions, corners])
        open_share, _ = ao.openness(
            ao.Rays(positions, triangles), soup.positions, soup.normals, REACH_M, count, lift=0.004
        )
        light = least_light + (1 - least_light) * smoothstep(-0.05, 0.95, open_share)
        glb = Glb(self.name)
        ramp = ao.ramp(glb)
        numbers = {}
        for name, keys in self.materials.items():
            if any(material == name for _, material, *_ in self._parts):
                keys = dict(keys)
                if "texture" in keys:
                    keys["texture"] = glb.texture(glb.image(*keys["texture"], name))
                numbers[name] = glb.material(name, occlusion_texture=ramp, occlusion_set=int("texture" in keys), **keys)
        primitives = [self._primitive(glb, name, number, light) for name, number in numbers.items()]
        glb.node(self.name, mesh=glb.mesh(self.name, primitives))
        return glb.bytes()

    def _primitive(self, glb, name, number, light):
        chosen, colours, openness, base = [], [], [], 0
        for mesh, material, colour, told in self._parts:
            count = len(mesh.positions)
            if material == name:
                chosen.append(mesh)
                colours.append(colour)
                openness.append(light[base : base + count] if told is None else np.full(count, told))
            base += count
        mesh, colours = shapes.join(*chosen), np.concatenate(colours)
        shade = ao.on_ramp(np.concatenate(openness))
        textured = "texture" in self.materials[name]
        return glb.primitive(
            mesh.positions,
            mesh.normals,
            solid(mesh),
            number,
            uv=mesh.uv if textured else shade,
            uv1=shade if textured else None,
            colors=None if np.all(colours == 1) else colours,
        )
