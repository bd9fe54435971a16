"""Scenes of discs whose place in the picture is known to a nanopixel, made at run time in a folder of the caller.

Each disc is a fan of triangles facing the camera. Its vertices are rounded to multiples of 2^-16 m as the file keeps
them, and the truth is the area centroid of exactly that polygon, each vertex projected by OpenCV in double: perspective
and lens bend the disc's image, and the truth bends with it.
"""

import pathlib
from dataclasses import dataclass

import numpy as np
from camrig_assets.glb import LEAST_STEP, Glb
from camrig_assets.scene import Scene

CORNERS = 48
DISTANCE_M = 4.0
# Body of a camera (x forward, y left, z up) from its optical frame (z forward, x right, y down).
LINK_FROM_OPTICAL = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])


@dataclass
class Marks:
    """Discs of one camera. The camera's pose goes with them."""

    polygons: np.ndarray  # (N, CORNERS, 3), world, metres, as the file holds them
    position: np.ndarray
    orientation: np.ndarray  # x, y, z, w of the body

    def pose(self):
        return {"position": list(self.position), "orientation": list(self.orientation)}

    def optical(self, points):
        """World points in the camera's optical frame."""
        turn = rotation_of(self.orientation) @ LINK_FROM_OPTICAL
        return (np.asarray(points) - self.position) @ turn

    def truth(self, camera):
        """Pixel of each disc's area centroid, (N, 2)."""
        flat = self.optical(self.polygons.reshape(-1, 3))
        return np.array([centroid(p) for p in camera.project(flat).reshape(len(self.polygons), -1, 2)])

    def outlines(self, camera):
        return camera.project(self.optical(self.polygons.reshape(-1, 3))).reshape(len(self.polygons), -1, 2)


def rotation_of(q):
    x, y, z, w = np.asarray(q, dtype=np.float64) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def centroid(polygon):
    """Area centroid of a simple polygon; relative to its first corner, so that nothing cancels."""
    origin = polygon[0]
    x, y = (polygon - origin).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    total = cross.sum()
    return origin + np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()]) / (3 * total)


def place_discs(camera, radius_px=9.0, spacing_px=42.0, position=(0.3, -0.2, 1.1), orientation=(0.1, -0.05, 0.2, 0.97)):
    """Discs all over the camera's valid picture: about `spacing_px` apart, none over the border or the fold."""
    width, height = camera.size
    limit = 0.97 * camera.fold_angle()
    if camera.model == "equidistant":
        limit = min(limit, np.radians(112))
    reach = radius_px * 1.6 + 2
    pixels = _places(camera, limit, reach, spacing_px)
    directions = camera.unproject(pixels, limit)
    directions = directions[np.isfinite(directions).all(axis=1)]
    polygons = []
    turn = rotation_of(orientation) @ LINK_FROM_OPTICAL
    for direction in directions:
        polygon = _disc(camera, direction, radius_px)
        world = polygon @ turn.T + np.asarray(position)
        # As the file will hold them: the model's frame is y up.
        polygons.append(np.round(world / LEAST_STEP) * LEAST_STEP)
    marks = Marks(np.array(polygons), np.array(position, dtype=np.float64), np.array(orientation) / np.linalg.norm(orientation))
    outlines = marks.outlines(camera)
    whole = ((outlines > 1) & (outlines < np.array([width, height]) - 2)).all(axis=(1, 2))
    size = np.linalg.norm(outlines - outlines.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    whole &= size < 2.0 * radius_px  # next to a fold a disc is drawn out
    x, y, z = np.moveaxis(marks.optical(marks.polygons.reshape(-1, 3)).reshape(*marks.polygons.shape), 2, 0)
    whole &= (np.arctan2(np.hypot(x, y), z) < 0.998 * camera.fold_angle()).all(axis=1)
    marks.polygons = marks.polygons[whole]
    return marks


def _places(camera, limit, reach, spacing_px):
    """Pixels for discs: a ring along the fold (or the edge of the field), then a grid up to the borders."""
    width, height = camera.size
    azimuth = np.arange(48) * 2 * np.pi / 48
    theta = 0.985 * limit
    ring = camera.project(np.stack([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.full(48, np.cos(theta))], axis=1))
    columns, rows = (max(2, round((side - 1 - 2 * reach) / spacing_px) + 1) for side in (width, height))
    x, y = np.meshgrid(np.linspace(reach, width - 1 - reach, columns), np.linspace(reach, height - 1 - reach, rows))
    kept = []
    for pixel in np.concatenate([ring, np.stack([x.ravel(), y.ravel()], axis=1)]):
        inside = (pixel >= reach).all() and pixel[0] <= width - 1 - reach and pixel[1] <= height - 1 - reach
        if inside and all(np.hypot(*(pixel - other)) >= 0.8 * spacing_px for other in kept):
            kept.append(pixel)
    return np.array(kept)


def _disc(camera, direction, radius_px):
    """A disc across the line of sight whose image has about that radius (its mean, where the lens stretches it)."""
    helper = np.array([0.0, 1, 0]) if abs(direction[1]) < 0.9 else np.array([1.0, 0, 0])
    u = np.cross(helper, direction)
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    h = 1e-4
    du = (camera.project(direction + h * u) - camera.project(direction - h * u))[0] / (2 * h)
    dv = (camera.project(direction + h * v) - camera.project(direction - h * v))[0] / (2 * h)
    scale = np.sqrt(abs(du[0] * dv[1] - du[1] * dv[0]))
    radius = radius_px / max(scale, 1e-6)
    angle = np.arange(CORNERS) * 2 * np.pi / CORNERS
    return DISTANCE_M * (direction + radius * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v))


def write_scene(folder, marks, offset=(0.0, 0.0, 0.0)):
    """Scene file and model of the marks: white discs, unlit, on black. `offset` moves all of the world."""
    folder = pathlib.Path(folder)
    glb = Glb("marks")
    white = glb.material("white", base=(1, 1, 1), unlit=True, double_sided=True)
    # World (z up) to the file (y up): the loader's turn backwards.
    corners = np.concatenate([marks.polygons.mean(axis=1, keepdims=True), marks.polygons], axis=1)
    flat = corners.reshape(-1, 3)
    flat = np.stack([flat[:, 0], flat[:, 2], -flat[:, 1]], axis=1)
    ring = np.arange(CORNERS)
    fan = np.stack([np.zeros(CORNERS, int), 1 + ring, 1 + (ring + 1) % CORNERS], axis=1)
    triangles = (np.arange(len(corners))[:, None, None] * (CORNERS + 1) + fan).reshape(-1, 3)
    normals = np.tile([0.0, 1, 0], (len(flat), 1))
    glb.node("marks", mesh=glb.mesh("marks", [glb.primitive(flat, normals, triangles, white)]))
    (folder / "marks.glb").write_bytes(glb.bytes())
    scene = Scene("marks", "Discs for measuring.", seed=1)
    scene.environment(background=(0, 0, 0), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("marks", "marks.glb")
    scene.object("marks", "marks", "mark", position=[float(v) for v in offset])
    path = folder / "marks.json"
    path.write_bytes(scene.text())
    return path
