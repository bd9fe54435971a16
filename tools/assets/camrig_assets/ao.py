"""Ambient occlusion of vertices by ray casting (embree).

How open a vertex is lies beside its colour, as a place on the ramp of an occlusion texture: it darkens light from all around only, and
where a map of baked light knows what is hidden it is left out.
"""

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from .glb import CLAMP, LINEAR
from .images import png


def hemisphere(count):
    """`count` cosine-distributed directions about +z: Hammersley points on the disc, lifted."""
    i = np.arange(count)
    radical = np.zeros(count)
    bits, half = i.copy(), 0.5
    while bits.any():
        radical += half * (bits & 1)
        bits >>= 1
        half /= 2
    r, turn = np.sqrt((i + 0.5) / count), 2 * np.pi * radical
    return np.stack([r * np.cos(turn), r * np.sin(turn), np.sqrt(1 - r * r)], axis=1)


def frames(normals):
    """Two tangents for each normal (Duff et al. 2017, Building an orthonormal basis, revisited)."""
    x, y, z = normals.T
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1 / (sign + z)
    b = x * y * a
    return np.stack([1 + sign * x * x * a, sign * b, -sign * x], 1), np.stack([b, sign + y * y * a, -y], 1)


class Rays:
    """A triangle soup that rays can be shot at."""

    def __init__(self, positions, triangles):
        self.positions = np.ascontiguousarray(positions, dtype=np.float32)
        self.triangles = np.ascontiguousarray(triangles, dtype=np.int32)
        self.scene = rtcore_scene.EmbreeScene()
        TriangleMesh(self.scene, self.positions, self.triangles)

    def hit(self, origins, directions):
        """(triangle or -1, distance, cosine of the hit surface's normal to the ray; > 0 means its back)."""
        out = self.scene.run(
            np.ascontiguousarray(origins, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            output=1,
        )
        normal = out["Ng"]
        length = np.maximum(np.linalg.norm(normal, axis=1), 1e-20)
        return out["primID"], out["tfar"], (normal * directions).sum(axis=1) / length


def openness(rays, points, normals, reach, count=128, lift=0.004, solid=0):
    """(share of the hemisphere that is open, share of rays that saw a back face) for every point.

    A hit counts the more the nearer it is; beyond `reach` metres it counts nothing. The first `solid` triangles count
    whole, however far they are.
    """
    tangent, bitangent = frames(normals)
    local = hemisphere(count)
    seen, backs = np.zeros(len(points)), np.zeros(len(points))
    for direction in local:
        rays_to = direction[0] * tangent + direction[1] * bitangent + direction[2] * normals
        triangle, distance, cosine = rays.hit(points + normals * lift, rays_to)
        struck = (triangle >= 0) & (distance < reach)
        is_solid = (triangle >= 0) & (triangle < solid)
        seen += np.where(is_solid, 1, np.where(struck, 1 - np.clip(distance / reach, 0, 1), 0))
        backs += struck & (cosine > 0) & (distance < 0.25)
    return 1 - seen / count, backs / count


def ramp(glb):
    """The texture of Glb.material's `occlusion_texture` for coordinates of on_ramp()."""
    return glb.texture(glb.image(png([[0, 1]]), "image/png", "occlusion"), CLAMP, minify=LINEAR)


def on_ramp(openness):
    """Where on the ramp each vertex has its share of light, 0 to 1: from the middle of the first texel to that of the second."""
    openness = np.asarray(openness, dtype=float)
    return np.stack([0.25 + 0.5 * openness, np.full(len(openness), 0.5)], axis=1)
