"""scenes/minimal: ground, one box, one small box that goes round it. The least a test can film."""

import math

from . import shapes
from .glb import Glb
from .scene import Scene


def _model(name, mesh, color):
    glb = Glb(name)
    material = glb.material(name, base=color, roughness=0.9)
    glb.node(name, mesh=glb.mesh(name, [glb.primitive(mesh.positions, mesh.normals, mesh.triangles, material)]))
    return glb.bytes()


def files():
    scene = Scene("minimal", "A lit box on the ground and a smaller one that circles it.", seed=1)
    scene.environment(background=(0.30, 0.45, 0.65), sky=(0.45, 0.47, 0.5), ground=(0.2, 0.19, 0.18))
    scene.model("ground", "minimal/ground.glb")
    scene.model("box", "minimal/box.glb")
    scene.model("mover", "minimal/mover.glb", front="+z")
    scene.object("ground", "ground", "ground")
    scene.object("box", "box", "box", yaw_deg=30)
    scene.light("sun", "directional", color=(1, 0.96, 0.9), intensity=0.8, direction=(0.4, 0.6, -1))
    scene.route(
        "circle",
        [(2.5 * math.cos(a), 2.5 * math.sin(a), 0) for a in (i * math.tau / 24 for i in range(24))],
        closed=True,
    )
    scene.actor(
        "mover",
        "mover",
        "box",
        behaviour={"type": "route", "route": "circle", "speed": 1.0, "start_m": 0, "mode": "loop"},
    )
    scene.place("main", "the box from the front, the whole circle in view", (-6, 0, 2.5), (0, 0, 0.4), 50)
    scene.place("above", "straight above, a little tilted", (-0.5, 0, 9), (0, 0, 0), 50)
    scene.camera("main", "main", (640, 480), 25)
    ground = shapes.quad((-5, 0, 5), (5, 0, 5), (5, 0, -5), (-5, 0, -5))
    return {
        "minimal.json": scene.text(),
        "minimal/ground.glb": _model("ground", ground, (0.32, 0.34, 0.30)),
        "minimal/box.glb": _model("box", shapes.box((1, 1, 1), (0, 0.5, 0)), (0.70, 0.12, 0.08)),
        "minimal/mover.glb": _model("mover", shapes.box((0.4, 0.4, 0.6), (0, 0.2, 0)), (0.08, 0.25, 0.70)),
    }
