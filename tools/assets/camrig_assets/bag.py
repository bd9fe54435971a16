"""A travel bag to be carried and left behind; it stands on its origin, its grip is GRIP above it."""

import numpy as np

from . import shapes
from .glb import Glb

GRIP = 0.46


def _handle(z):
    angles = np.linspace(0, np.pi, 9)
    return shapes.tube([(0.12 * np.cos(a), 0.29 + (GRIP - 0.29) * np.sin(a), z) for a in angles], 0.012, 6)


def files():
    glb = Glb("bag")
    rings = [
        shapes.ring(rx, rz, (0, y, 0), 24, 5.0)
        for y, rx, rz in ((0, 0.2, 0.1), (0.01, 0.23, 0.12), (0.2, 0.24, 0.125), (0.28, 0.23, 0.09), (0.31, 0.21, 0.02))
    ]
    body = shapes.join(shapes.loft(rings), shapes.box((0.4, 0.012, 0.03), (0, 0.31, 0)))
    cloth = glb.material("cloth", base=(0.42, 0.05, 0.04), roughness=0.85)
    leather = glb.material("leather", base=(0.03, 0.025, 0.02), roughness=0.6)
    handles = shapes.join(_handle(0.05), _handle(-0.05), shapes.box((0.5, 0.03, 0.252), (0, 0.12, 0)))
    parts = [
        glb.primitive(mesh.positions, mesh.normals, mesh.triangles, material)
        for mesh, material in ((body, cloth), (handles, leather))
    ]
    glb.node("bag", mesh=glb.mesh("bag", parts))
    return {"hall/bag.glb": glb.bytes()}
