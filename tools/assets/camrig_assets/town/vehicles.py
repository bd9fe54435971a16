"""Cars, a van and a drone, each a GLB of its own that looks along +z; wheels and rotors turn by the clips `drive` and `fly`.

Built with x ahead, y to the left and z up, and turned when it is written.
"""

from dataclasses import dataclass, field

import numpy as np

from .. import ao, shapes
from ..glb import Glb
from ..noise import smoothstep
from .builder import linear, solid

MATERIALS = {
    "paint": {"roughness": 0.35},
    "glass": {"roughness": 0.06},
    "trim": {"roughness": 0.8},
    "lamp": {"roughness": 0.3},
}

WHEEL_WIDTH = 0.20


@dataclass
class Shape:
    """Side and plan of a car, metres; stations are (x, bottom, top, half width) from the tail to the nose."""

    stations: tuple
    cabin: tuple  # (z, x of the rear, x of the front, half width) from the belt up
    wheels: tuple  # x of the axles
    wheel_radius: float = 0.315
    pillars: tuple = field(default=(0.42,))  # further pillars, as shares of the cabin's length from its rear


CAR = Shape(
    stations=(
        (-2.06, 0.48, 0.62, 0.60),
        (-2.04, 0.36, 0.80, 0.74),
        (-1.93, 0.26, 0.93, 0.82),
        (-1.55, 0.21, 0.965, 0.86),
        (-0.80, 0.19, 0.955, 0.88),
        (0.00, 0.19, 0.935, 0.885),
        (0.70, 0.19, 0.915, 0.88),
        (1.20, 0.20, 0.84, 0.865),
        (1.65, 0.22, 0.76, 0.84),
        (1.95, 0.26, 0.67, 0.77),
        (2.07, 0.32, 0.58, 0.66),
        (2.10, 0.42, 0.50, 0.56),
    ),
    cabin=((0.90, -1.90, 1.12, 0.80), (1.12, -1.74, 0.72, 0.755), (1.34, -1.52, 0.32, 0.665), (1.42, -1.36, 0.14, 0.60)),
    wheels=(-1.27, 1.29),
)
SALOON = Shape(
    stations=(
        (-2.30, 0.50, 0.64, 0.62),
        (-2.28, 0.38, 0.86, 0.74),
        (-2.16, 0.28, 0.98, 0.82),
        (-1.60, 0.22, 1.00, 0.88),
        (-0.80, 0.19, 0.975, 0.905),
        (0.00, 0.19, 0.955, 0.91),
        (0.80, 0.19, 0.93, 0.905),
        (1.30, 0.20, 0.86, 0.89),
        (1.80, 0.22, 0.79, 0.86),
        (2.14, 0.26, 0.70, 0.79),
        (2.28, 0.32, 0.60, 0.68),
        (2.31, 0.42, 0.52, 0.58),
    ),
    cabin=((0.93, -1.72, 1.22, 0.82), (1.14, -1.42, 0.82, 0.77), (1.35, -1.06, 0.42, 0.68), (1.43, -0.86, 0.22, 0.61)),
    wheels=(-1.38, 1.40),
    wheel_radius=0.325,
    pillars=(0.46,),
)
VAN = Shape(
    stations=(
        (-2.45, 0.50, 1.02, 0.86),
        (-2.43, 0.34, 1.06, 0.92),
        (-2.30, 0.26, 1.08, 0.955),
        (-1.50, 0.22, 1.08, 0.965),
        (0.00, 0.21, 1.08, 0.965),
        (1.30, 0.21, 1.08, 0.96),
        (1.75, 0.23, 1.04, 0.93),
        (2.20, 0.26, 0.92, 0.86),
        (2.40, 0.32, 0.74, 0.76),
        (2.44, 0.44, 0.60, 0.64),
    ),
    cabin=((1.02, -2.44, 1.98, 0.93), (1.40, -2.43, 1.52, 0.91), (1.80, -2.41, 1.12, 0.87), (1.95, -2.32, 0.92, 0.80)),
    wheels=(-1.55, 1.60),
    wheel_radius=0.335,
    pillars=(),
)
CARS = {
    "car_1": (CAR, "#9c1f1f"),
    "car_2": (CAR, "#c9ccd0"),
    "car_3": (SALOON, "#1f3f6e"),
    "car_4": (SALOON, "#2a2c2f"),
    "car_5": (CAR, "#d9a321"),
    "van": (VAN, "#e4e4df"),
}
# In which other paint a car comes.
PAINTS = "#9c1f1f #c9ccd0 #1f3f6e #2a2c2f #d9a321 #e4e4df #6d7276 #14161a #3c5a46 #7c2f1c #4a6a8c #8a8478 #b5562a #5a2a3c".split()
LENGTHS_M = {"car_1": 4.2, "car_2": 4.2, "car_3": 4.62, "car_4": 4.62, "car_5": 4.2, "van": 4.9}


def turned(mesh):
    """From x ahead, y left, z up to the file's z ahead, x left, y up."""
    return shapes.Mesh(mesh.positions[:, [1, 2, 0]], mesh.normals[:, [1, 2, 0]], mesh.uv, mesh.triangles)


def _rings(rings):
    """A closed surface through rings of points about the x axis; turned outwards."""
    mesh = shapes.loft(rings)
    middle = mesh.positions.mean(axis=0)
    if ((mesh.positions - middle) * mesh.normals).sum() < 0:
        mesh = shapes.Mesh(mesh.positions, -mesh.normals, mesh.uv, mesh.triangles[:, ::-1])
    return mesh


def _section(x, bottom, top, half, columns=28):
    angle = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    y = np.sign(c) * np.abs(c) ** (2 / 4.5) * half
    z = np.sign(s) * np.abs(s) ** (2 / 4.0) * (top - bottom) / 2 + (top + bottom) / 2
    # Sides lean in a little above the waist, as doors do.
    y = y * (1 - 0.06 * smoothstep(0.55, 1.0, z))
    return np.stack([np.full(columns, x), y, z], axis=1)


def _plan(z, rear, front, half, columns=32):
    angle = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    x = np.sign(c) * np.abs(c) ** (2 / 7.0) * (front - rear) / 2 + (front + rear) / 2
    y = np.sign(s) * np.abs(s) ** (2 / 7.0) * half
    return np.stack([x, y, np.full(columns, z)], axis=1)


def _box(low, high):
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    mesh = shapes.box(high - low)
    mesh.positions = mesh.positions + (low + high) / 2
    return mesh


def _disc(radius, at, side, columns=24):
    """A disc that faces `side` (+1 left, -1 right)."""
    mesh = shapes.disc(radius, columns)
    place, normal = mesh.positions[:, [0, 1, 2]].copy(), np.zeros_like(mesh.normals)
    place = np.stack([mesh.positions[:, 0], np.zeros(len(place)), -side * mesh.positions[:, 2]], axis=1) + at
    normal[:, 1] = side
    return _facing(shapes.Mesh(place, normal, mesh.uv, mesh.triangles))


def _facing(mesh):
    """Triangles wound as their normals say."""
    a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
    wrong = (np.cross(b - a, c - a) * mesh.normals[mesh.triangles[:, 0]]).sum(axis=1) < 0
    triangles = mesh.triangles.copy()
    triangles[wrong] = triangles[wrong][:, ::-1]
    return shapes.Mesh(mesh.positions, mesh.normals, mesh.uv, triangles)


def _body(shape, colour):
    """(mesh, material, colour) of what does not turn."""
    paint = (1, 1, 1)  # the material has it
    parts = []
    sections = [_section(*station) for station in shape.stations]
    caps = [np.repeat(s.mean(axis=0)[None], len(s), axis=0) for s in (sections[0], sections[-1])]
    parts.append((_rings([caps[0], *sections, caps[1]]), "paint", paint))
    cabin = [_plan(*level) for level in shape.cabin]
    parts.append((_rings(cabin[:-1]), "glass", (0.018, 0.022, 0.026)))
    z, rear, front, half = shape.cabin[-1]
    roof = [_plan(shape.cabin[-2][0] - 0.03, *shape.cabin[-2][1:]) * (1, 1.004, 1), cabin[-1]]
    roof += [_plan(z + 0.035, rear + 0.12, front - 0.12, half - 0.12), _plan(z + 0.05, rear + 0.5, front - 0.5, 0.1)]
    roof.append(np.repeat(roof[-1].mean(axis=0)[None], len(roof[-1]), axis=0))
    parts.append((_rings(roof), "paint", paint))
    for side in (1, -1):
        for share in (0.0, *shape.pillars, 1.0):
            points = []
            for z, rear, front, half in shape.cabin[:-1]:
                if share in (0.0, 1.0):  # at the glass's rounded corner, half sunk in it
                    x, y = (front + rear) / 2 + (share - 0.5) * 0.925 * (front - rear), 0.905 * half
                else:
                    x, y = rear + 0.05 + share * (front - rear - 0.10), half + 0.006
                points.append((x, side * y, z))
            parts.append((shapes.tube(points, 0.045 if share in (0.0, 1.0) else 0.035, 6), "paint", paint))
        if not shape.pillars:  # a van: closed sides behind the driver
            (z0, r0, f0, h0), (z1, r1, _, h1) = shape.cabin[0], shape.cabin[-2]
            ends = f0 - 1.55
            corners = ((r0 + 0.06, h0 + 0.012, z0), (ends, h0 + 0.012, z0), (ends, h1 + 0.012, z1), (r1 + 0.06, h1 + 0.012, z1))
            points = [np.array((x, side * y, z)) for x, y, z in corners]
            sheet = shapes.quad(*(points if side < 0 else points[::-1]), cells=(4, 2))
            parts.append((sheet, "paint", paint))
    _details(shape, parts)
    return parts


def _side(shape, x):
    """Half the width of the body at x."""
    return float(np.interp(x, [s[0] for s in shape.stations], [s[3] for s in shape.stations]))


def _details(shape, parts):
    tail, nose = shape.stations[0], shape.stations[-1]
    front, rear = shape.stations[-3], shape.stations[2]
    dark = (0.012, 0.012, 0.013)
    for side in (1, -1):
        for x in shape.wheels:
            arch = (x, side * (_side(shape, x) + 0.004), shape.wheel_radius)
            parts.append((_disc(shape.wheel_radius + 0.055, arch, side), "trim", dark))
        y = side * front[3] * 0.64
        parts.append((_box((front[0] - 0.02, y - 0.14, front[2] - 0.18), (nose[0] - 0.03, y + 0.14, front[2] - 0.06)), "lamp", (0.82, 0.84, 0.86)))
        parts.append((_box((front[0], y - 0.11, front[2] - 0.165), (nose[0] - 0.022, y + 0.04, front[2] - 0.075)), "glass", (0.30, 0.32, 0.34)))
        y = side * rear[3] * 0.76
        parts.append((_box((tail[0] - 0.015, y - 0.12, rear[2] - 0.24), (rear[0] + 0.05, y + 0.12, rear[2] - 0.10)), "lamp", (0.42, 0.02, 0.02)))
        z, _, cabin_front, half = shape.cabin[0]
        parts.append((_box((cabin_front - 0.72, side * (half + 0.10) - 0.10, z + 0.03), (cabin_front - 0.60, side * (half + 0.10) + 0.10, z + 0.16)), "trim", dark))
        low = shape.stations[len(shape.stations) // 2]
        parts.append((_box((shape.wheels[0] + 0.42, side * (low[3] - 0.03) - 0.035, low[1] - 0.02), (shape.wheels[1] - 0.42, side * (low[3] - 0.03) + 0.035, low[1] + 0.10)), "trim", dark))
        for x in (0.12, -0.75):
            parts.append((_box((x, side * (low[3] - 0.035) - 0.012, 0.74), (x + 0.16, side * (low[3] - 0.035) + 0.045, 0.77)), "trim", (0.25, 0.25, 0.26)))
    parts.append((_box((nose[0] - 0.05, -0.42, 0.30), (nose[0] + 0.005, 0.42, 0.43)), "trim", dark))
    plate = (0.80, 0.80, 0.76)
    parts.append((_box((nose[0], -0.26, 0.43), (nose[0] + 0.02, 0.26, 0.54)), "lamp", plate))
    parts.append((_box((tail[0] - 0.02, -0.26, 0.52), (tail[0], 0.26, 0.63)), "lamp", plate))
    parts.append((_box((-abs(tail[0]) + 0.02, -0.70, 0.28), (-abs(tail[0]) + 0.12, 0.70, 0.40)), "trim", dark))


def _wheel(radius, side):
    """A wheel about its own middle; `side` is where its outside is."""
    parts = []
    width, columns = WHEEL_WIDTH, 26
    angle = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    ring = lambda r, y: np.stack([r * np.cos(angle), np.full(columns, y), r * np.sin(angle)], axis=1)  # noqa: E731
    outer = side * width / 2
    tyre = [ring(radius * 0.62, -outer), ring(radius * 0.93, -outer), ring(radius, -outer * 0.8), ring(radius, outer * 0.8)]
    tyre += [ring(radius * 0.93, outer), ring(radius * 0.64, outer * 0.97)]
    parts.append((_rings(tyre), "trim", (0.014, 0.014, 0.015)))
    parts.append((_disc(radius * 0.66, (0, outer * 0.80, 0), side), "trim", (0.03, 0.03, 0.032)))
    for k in range(5):
        turn = k * 2 * np.pi / 5
        spoke = _box((-0.035, -0.012, 0.02), (0.035, 0.012, radius * 0.62))
        c, s = np.cos(turn), np.sin(turn)
        spoke = spoke.moved(matrix=[[c, 0, s], [0, 1, 0], [-s, 0, c]])
        spoke.positions = spoke.positions + (0, outer * 0.90, 0)
        parts.append((spoke, "lamp", (0.42, 0.43, 0.45)))
    rim = [ring(radius * 0.66, outer * 0.86), ring(radius * 0.66, outer * 1.0), ring(radius * 0.60, outer * 1.0), ring(radius * 0.60, outer * 0.86)]
    parts.append((_rings(rim), "lamp", (0.42, 0.43, 0.45)))
    parts.append((_disc(radius * 0.17, (0, outer * 1.0, 0), side, 12), "lamp", (0.42, 0.43, 0.45)))
    return parts


def _primitives(glb, numbers, parts, light=None):
    """`light`: how open each vertex is, for materials with the occlusion ramp."""
    made, base = [], 0
    chosen = {}
    for mesh, material, colour in parts:
        count = len(mesh.positions)
        colours = np.broadcast_to(np.asarray(colour, dtype=float), (count, 3))
        chosen.setdefault(material, []).append((turned(mesh), colours, [] if light is None else light[base : base + count]))
        base += count
    for material, items in chosen.items():
        mesh = shapes.join(*(item for item, *_ in items))
        made.append(
            glb.primitive(
                mesh.positions,
                mesh.normals,
                solid(mesh),
                numbers[material],
                uv=None if light is None else ao.on_ramp(np.concatenate([shade for *_, shade in items])),
                colors=np.concatenate([colours for _, colours, _ in items]),
            )
        )
    return made


def _light(parts):
    """How open each vertex is, above a floor."""
    soup = shapes.join(*(mesh for mesh, *_ in parts))
    floor = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], dtype=float)
    triangles = np.concatenate([soup.triangles, np.array([[0, 1, 2], [0, 2, 3]]) + len(soup.positions)])
    rays = ao.Rays(np.concatenate([soup.positions, floor]), triangles)
    open_share, _ = ao.openness(rays, soup.positions, soup.normals, reach=1.0, count=96, lift=0.01)
    return 0.35 + 0.65 * smoothstep(-0.05, 0.95, open_share)


def _shadow(glb, material, length, width):
    """A soft dark patch below, transparent at its rim."""
    columns = 28
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    c, s = np.cos(turn), np.sin(turn)
    x, z = np.sign(c) * np.abs(c) ** 0.4, np.sign(s) * np.abs(s) ** 0.4
    positions, alphas, triangles = [(0, 0.012, 0)], [0.72], []
    for grow, alpha in ((0.82, 0.66), (1.16, 0.0)):
        positions += [(width / 2 * grow * a, 0.012, length / 2 * (1 + (grow - 1) * 0.5) * b) for a, b in zip(x, z)]
        alphas += [alpha] * columns
    for i in range(columns):
        j = (i + 1) % columns
        a, b = 1 + i, 1 + j
        triangles += [(0, b, a), (a, b, b + columns), (a, b + columns, a + columns)]
    colours = np.ones((len(positions), 4))
    colours[:, 3] = alphas
    return glb.primitive(
        np.array(positions), np.tile((0.0, 1, 0), (len(positions), 1)), np.array(triangles), material, colors=colours
    )


def _turn(axis, steps=4):
    """One turn about an axis of the file, as key quaternions."""
    half = np.linspace(0, np.pi, steps + 1)
    return np.concatenate([np.sin(half)[:, None] * np.asarray(axis, dtype=float), np.cos(half)[:, None]], axis=1)


def car(name):
    """One car's GLB; its clip `drive` turns the wheels once in the time it takes at 10 m/s."""
    shape, colour = CARS[name]
    glb = Glb(name)
    own = {"base": tuple(linear(colour)), "extras": {"camrig_variants": {"colors": [[round(float(v), 4) for v in linear(c)] for c in PAINTS]}}}
    shade = {"occlusion_texture": ao.ramp(glb), "occlusion_set": 0}
    numbers = {key: glb.material(key, **keys, **shade, **(own if key == "paint" else {})) for key, keys in MATERIALS.items()}
    shadow = glb.material("contact_shadow", base=(0, 0, 0, 1), alpha="BLEND", roughness=1.0, unlit=True)
    body = _body(shape, colour)
    root = glb.node(name)
    parts = _primitives(glb, numbers, body, _light(body))
    parts.append(_shadow(glb, shadow, LENGTHS_M[name], 2 * max(s[3] for s in shape.stations)))
    glb.node("body", root, mesh=glb.mesh("body", parts))
    glb.node("dashboard", root, translation=(0.0, shape.cabin[1][0] + 0.05, shape.cabin[0][2] - 0.25))
    meshes = {}
    for side in (1, -1):
        wheel = _wheel(shape.wheel_radius, side)
        meshes[side] = glb.mesh(f"wheel_{side}", _primitives(glb, numbers, wheel, np.ones(sum(len(m.positions) for m, *_ in wheel))))
    nodes = []
    for axle, x in zip(("rear", "front"), shape.wheels):
        for side, hand in ((1, "left"), (-1, "right")):
            # Its outside stands a little proud of the body's.
            place = (side * (_side(shape, x) - WHEEL_WIDTH / 2 + 0.025), shape.wheel_radius, x)
            nodes.append(glb.node(f"{axle}_{hand}_wheel", root, place, mesh=meshes[side]))
    seconds = 2 * np.pi * shape.wheel_radius / 10.0
    times = np.linspace(0, seconds, 9)
    turn = _turn((1, 0, 0), 8)
    glb.animation("drive", times, [(node, "rotation", turn) for node in nodes], {"ground_speed_m_s": 10.0})
    return glb.bytes()


def drone():
    """A quadcopter of 0.9 m with a camera below (`gimbal`)."""
    glb = Glb("drone")
    numbers = {key: glb.material(key, **keys) for key, keys in MATERIALS.items()}
    grey, dark = (0.62, 0.63, 0.65), (0.02, 0.02, 0.022)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 9)
    hull = _rings([_section(0.22 * np.sin(a), -0.055 * np.cos(a) - 1e-4, 0.06 * np.cos(a) + 1e-4, 0.10 * np.cos(a) + 1e-4) for a in angle])
    parts = [(hull, "paint", grey), (_box((0.13, -0.04, -0.10), (0.21, 0.04, -0.045)), "glass", dark)]
    places = [(sx * 0.28, sy * 0.28) for sx in (1, -1) for sy in (1, -1)]
    for x, y in places:
        parts.append((shapes.tube([(0.05 * np.sign(x), 0.05 * np.sign(y), 0.01), (x, y, 0.03)], 0.018, 8), "trim", dark))
        motor = _rings([np.stack([x + r * np.cos(t), y + r * np.sin(t), np.full(12, z)], axis=1) for r, z in ((0.001, 0.0), (0.03, 0.0), (0.03, 0.07), (0.001, 0.075)) for t in [np.linspace(0, 2 * np.pi, 12, endpoint=False)]])
        parts.append((motor, "trim", (0.10, 0.10, 0.11)))
        parts.append((_box((x - 0.012, y - 0.012, -0.13), (x + 0.012, y + 0.012, 0.02)), "trim", dark))
        parts.append((_box((x - 0.02, y - 0.02, -0.02), (x + 0.02, y + 0.02, 0.0)), "lamp", (0.7, 0.03, 0.03) if x < 0 else (0.05, 0.6, 0.1)))
    root = glb.node("drone")
    glb.node("body", root, mesh=glb.mesh("body", _primitives(glb, numbers, parts)))
    glb.node("gimbal", root, translation=(0.0, -0.11, 0.17))
    blade = [(_box((-0.20, -0.018, 0.078), (0.20, 0.018, 0.084)), "trim", (0.05, 0.05, 0.055))]
    mesh = glb.mesh("rotor", _primitives(glb, numbers, blade))
    nodes = [glb.node(f"rotor_{i}", root, (y, 0.0, x), mesh=mesh) for i, (x, y) in enumerate(places)]
    times = np.linspace(0, 0.11, 9)
    tracks = [(node, "rotation", _turn((0, 1 if i in (0, 3) else -1, 0), 8)) for i, node in enumerate(nodes)]
    glb.animation("fly", times, tracks)
    return glb.bytes()


def files():
    """All of them, by file name."""
    return {**{f"street/{name}.glb": car(name) for name in CARS}, "street/drone.glb": drone()}
