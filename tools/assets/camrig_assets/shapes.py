"""Plain meshes: boxes, cylinders, discs, quads and lofts, with normals and texture coordinates (+Y up, metres)."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Mesh:
    """Triangles with per-vertex attributes. `uv` is in [0,1]; what it means is the material's business."""

    positions: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    normals: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))

    def moved(self, offset=(0, 0, 0), yaw=0.0, scale=(1, 1, 1), matrix=None):
        """A copy scaled, turned by `yaw` (radians about +Y) or by the 3x3 `matrix`, then shifted."""
        turn = (
            np.asarray(matrix)
            if matrix is not None
            else np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
        )
        normals = (self.normals / np.asarray(scale)) @ turn.T
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return Mesh(
            (self.positions * np.asarray(scale)) @ turn.T + np.asarray(offset),
            normals,
            self.uv.copy(),
            self.triangles.copy(),
        )

    def with_uv(self, rect):
        """A copy whose [0,1] texture coordinates fill `rect` = (u0, v0, u1, v1) of an atlas."""
        low, high = np.array(rect[:2]), np.array(rect[2:])
        return Mesh(self.positions, self.normals, low + self.uv * (high - low), self.triangles)


def join(*meshes):
    parts, base = [list(m) for m in ([], [], [], [])], 0
    for mesh in meshes:
        for part, values in zip(parts, (mesh.positions, mesh.normals, mesh.uv, mesh.triangles + base)):
            part.append(values)
        base += len(mesh.positions)
    return Mesh(*(np.concatenate(part) for part in parts))


def quad(a, b, c, d, cells=(1, 1)):
    """A flat patch with corners a b c d (counter-clockwise from the front), cut into cells along ab and ad."""
    a, b, c, d = (np.asarray(p, dtype=np.float64) for p in (a, b, c, d))
    across, up = cells
    s, t = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, up + 1))
    s, t = s.reshape(-1, 1), t.reshape(-1, 1)
    positions = a * (1 - s) * (1 - t) + b * s * (1 - t) + c * s * t + d * (1 - s) * t
    normal = np.cross(b - a, d - a)
    normals = np.tile(normal / np.linalg.norm(normal), (len(positions), 1))
    return Mesh(positions, normals, np.hstack([s, 1 - t]), grid_triangles(up + 1, across + 1))


def grid_triangles(rows, columns):
    """Triangles of a rows x columns vertex grid, counter-clockwise when columns run right and rows run up."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None, :]).reshape(-1)
    a, b, c, d = corner, corner + 1, corner + columns + 1, corner + columns
    return np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], 1).reshape(-1, 3)


SIDES = ("front", "back", "left", "right", "top", "bottom")  # +Z -Z +X -X +Y -Y


def box(size, centre=(0, 0, 0), sides=SIDES, cells=1):
    """A box; `sides` says which faces exist (hidden ones cost vertices); `cells` cuts each face in cells x cells."""
    x, y, z = np.asarray(size, dtype=np.float64) / 2
    corners = {
        "front": ((-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)),
        "back": ((x, -y, -z), (-x, -y, -z), (-x, y, -z), (x, y, -z)),
        "left": ((x, -y, z), (x, -y, -z), (x, y, -z), (x, y, z)),
        "right": ((-x, -y, -z), (-x, -y, z), (-x, y, z), (-x, y, -z)),
        "top": ((-x, y, z), (x, y, z), (x, y, -z), (-x, y, -z)),
        "bottom": ((-x, -y, -z), (x, -y, -z), (x, -y, z), (-x, -y, z)),
    }
    count = cells if isinstance(cells, dict) else {side: (cells, cells) for side in sides}
    return join(*(quad(*corners[side], cells=count.get(side, (1, 1))) for side in sides)).moved(centre)


def loft(rings, closed=True):
    """A surface through `rings` (rows x columns x 3), columns counter-clockwise seen from above when rows go up.

    A closed ring repeats its first column for the texture seam; normals there agree. u runs along columns, v down
    from the last row.
    """
    rings = np.asarray(rings, dtype=np.float64)
    if closed:
        rings = np.concatenate([rings, rings[:, :1]], axis=1)
    rows, columns = rings.shape[:2]
    normals = grid_normals(rings, closed)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(1, 0, rows))
    flat, triangles = rings.reshape(-1, 3), grid_triangles(rows, columns)
    area = np.linalg.norm(
        np.cross(flat[triangles[:, 1]] - flat[triangles[:, 0]], flat[triangles[:, 2]] - flat[triangles[:, 0]]), axis=1
    )
    return Mesh(flat, normals.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2), triangles[area > 1e-10])


def grid_normals(grid, closed):
    """Smooth normals of a vertex grid, area weighted; the columns' seam is joined when closed."""
    flat, triangles = grid.reshape(-1, 3), grid_triangles(*grid.shape[:2])
    face = np.cross(flat[triangles[:, 1]] - flat[triangles[:, 0]], flat[triangles[:, 2]] - flat[triangles[:, 0]])
    normals = np.zeros_like(flat)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], face)
    normals = normals.reshape(grid.shape)
    if closed:
        normals[:, 0] += normals[:, -1]
        normals[:, -1] = normals[:, 0]
    for row in (0, -1):  # a ring shrunk to a point is a pole: one normal for all
        if np.ptp(grid[row], axis=0).max() < 1e-6:
            normals[row] = normals[row].sum(axis=0)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    return np.where(length > 1e-12, normals / np.maximum(length, 1e-12), (0, 1, 0))


def ring(radius_x, radius_z, centre, columns, power=2.0):
    """One horizontal ring (superellipse), counter-clockwise from above starting at the back (-Z), so that the seam
    is behind.
    """
    angle = -np.pi / 2 - np.linspace(0, 2 * np.pi, columns, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    x = np.sign(c) * np.abs(c) ** (2 / power) * radius_x
    z = np.sign(s) * np.abs(s) ** (2 / power) * radius_z
    return np.stack([x + centre[0], np.full(columns, centre[1], dtype=np.float64), z + centre[2]], axis=1)


def cylinder(radius, height, columns=16, top=True, bottom=False, rows=1, top_radius=None):
    """A round post standing on the origin; rows cut it along its height."""
    top_radius = radius if top_radius is None else top_radius
    heights = np.linspace(0, height, rows + 1)
    radii = radius + (top_radius - radius) * heights / height
    parts = [loft([ring(r, r, (0, y, 0), columns) for r, y in zip(radii, heights)])]
    if top:
        parts.append(disc(top_radius, columns).moved((0, height, 0)))
    if bottom:
        parts.append(disc(radius, columns).moved(matrix=[[1, 0, 0], [0, -1, 0], [0, 0, -1]]))
    return join(*parts)


def disc(radius, columns=16, inner=0.0):
    """A flat disc or washer facing +Y."""
    outer, hole = ring(radius, radius, (0, 0, 0), columns), ring(inner, inner, (0, 0, 0), columns)
    mesh = loft([outer, hole])
    mesh.normals[:] = (0, 1, 0)
    mesh.uv = mesh.positions[:, [0, 2]] / (2 * radius) + 0.5
    return mesh


def tube(points, radius, columns=8):
    """A round bar along a polyline, open at its ends."""
    points = np.asarray(points, dtype=np.float64)
    rings = []
    for i, point in enumerate(points):
        forward = points[min(i + 1, len(points) - 1)] - points[max(i - 1, 0)]
        forward /= np.linalg.norm(forward)
        helper = np.array([0.0, 0, 1]) if abs(forward[2]) < 0.9 else np.array([1.0, 0, 0])
        side = np.cross(helper, forward)
        side /= np.linalg.norm(side)
        other = np.cross(forward, side)
        angle = np.linspace(0, 2 * np.pi, columns, endpoint=False)
        rings.append(point + radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other))
    return loft(rings)
