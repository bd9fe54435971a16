"""scenes/clock: a clock face whose hands a glTF node animation turns; black on white, readable by eye and by program.

Seen from the camera, at world time t the long hand points at 360 deg * t (one turn a second) and the short hand at 36
deg * t (one turn in ten seconds), both clockwise from the top. The hands' tips are at radius 0.9 and 0.55 m. A third
mark, a red disc at radius 0.72 m, goes with the long hand, so that colour alone finds the angle too.
"""

import math

import numpy as np

from . import shapes
from .glb import Glb
from .scene import Scene

LOOP_S = 10  # both hands are back where they began
KEYS_PER_TURN = 8  # 45 deg between keys: spherical interpolation between them is exactly uniform
CENTRE_Y = 1.5


def _facing(mesh):
    """Turns a mesh lying on the floor (facing +Y) upright, facing +Z."""
    return mesh.moved(matrix=[[1, 0, 0], [0, 0, -1], [0, 1, 0]])


def _bar(inner, outer, width, angle, depth):
    """A flat bar on the face from radius inner to outer, `angle` clockwise from the top."""
    mesh = shapes.quad(
        (-width / 2, inner, depth), (width / 2, inner, depth), (width / 2, outer, depth), (-width / 2, outer, depth)
    )
    c, s = math.cos(angle), math.sin(angle)
    return mesh.moved(matrix=[[c, s, 0], [-s, c, 0], [0, 0, 1]])


def _turns(seconds_per_turn):
    """Key times' rotations over the loop; neighbours are on the same half of the quaternion sphere."""
    steps = LOOP_S * KEYS_PER_TURN
    angles = -math.tau * np.arange(steps + 1) / KEYS_PER_TURN / seconds_per_turn
    return np.stack([0 * angles, 0 * angles, np.sin(angles / 2), np.cos(angles / 2)], axis=1)


def _glb():
    glb = Glb("clock")
    white = glb.material("face", base=(0.9, 0.9, 0.9), unlit=True)
    black = glb.material("ink", base=(0.005, 0.005, 0.005), unlit=True)
    red = glb.material("mark", base=(0.8, 0.01, 0.01), unlit=True)
    grey = glb.material("wall", base=(0.18, 0.19, 0.21), unlit=True)

    def part(name, mesh, material, parent=None, translation=None):
        return glb.node(
            name,
            parent,
            translation,
            mesh=glb.mesh(name, [glb.primitive(mesh.positions, mesh.normals, mesh.triangles, material)]),
        )

    part(
        "wall",
        shapes.quad((-3, -CENTRE_Y, -0.02), (3, -CENTRE_Y, -0.02), (3, 2, -0.02), (-3, 2, -0.02)),
        grey,
        translation=(0, CENTRE_Y, 0),
    )
    face = part("face", _facing(shapes.disc(1.1, 96)), white, translation=(0, CENTRE_Y, 0))
    rim = shapes.join(_facing(shapes.disc(1.16, 96, inner=1.1)))
    ticks = [_bar(0.97, 1.07, 0.035, i * math.tau / 12, 0.004) for i in range(12) if i % 3]
    ticks += [_bar(0.93, 1.07, 0.06, i * math.tau / 4, 0.004) for i in range(4)]
    ticks += [_bar(1.03, 1.07, 0.012, i * math.tau / 60, 0.004) for i in range(60) if i % 5]
    part("ticks", shapes.join(rim, *ticks), black, face)
    slow = part("hand_slow", _bar(-0.1, 0.55, 0.09, 0, 0), black, face, (0, 0, 0.02))
    fast = part("hand_fast", _bar(-0.18, 0.9, 0.05, 0, 0), black, face, (0, 0, 0.04))
    part("mark", _facing(shapes.disc(0.075, 24)), red, fast, (0, 0.72, 0.01))
    part("hub", _facing(shapes.disc(0.07, 24)), black, face, (0, 0, 0.06))
    times = np.arange(LOOP_S * KEYS_PER_TURN + 1) / KEYS_PER_TURN
    glb.animation(
        "run",
        times,
        [(fast, "rotation", _turns(1)), (slow, "rotation", _turns(10))],
        extras={"period_s": {"hand_fast": 1, "hand_slow": 10}},
    )
    return glb.bytes()


def files():
    scene = Scene(
        "clock",
        "A clock: the long hand turns once a second, the short hand once in ten seconds; unlit, so grey values "
        "are exact.",
        seed=1,
    )
    scene.environment(background=(0.02, 0.02, 0.02), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("clock", "clock/clock.glb")
    scene.object("clock", "clock", "clock", clip="run")
    scene.place("front", "straight in front, the face fills the height", (0, -3, CENTRE_Y), (0, 0, CENTRE_Y), 45)
    scene.place("left", "from the left and above", (-2, -2.4, 2.4), (0, 0, CENTRE_Y), 45)
    scene.place("right", "from the right and below", (2, -2.4, 0.8), (0, 0, CENTRE_Y), 45)
    scene.camera("front", "front", (640, 480), 25)
    scene.camera("left", "left", (640, 480), 10)
    scene.camera("right", "right", (640, 480), 5)
    return {"clock.json": scene.text(), "clock/clock.glb": _glb()}
