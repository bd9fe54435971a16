"""A town square with a hundred people in it: strolling, crossing it, talking in groups and sitting."""

import math

from .people.cast import CAST
from .scene import Scene
from .town import fittings, surfaces
from .town.builder import Builder, slab
from .town.buildings import Row
from .town.surfaces import PAVING_M, scaled

HALF = 21.0  # of the square, to the houses
WALK = 19.6  # of the area that people use
FOUNTAIN = (0.0, 0.0, 3.3)  # x, y, radius
TREES = [(sx * 12.0, sy * 12.0) for sx in (1, -1) for sy in (1, -1)]
LAMPS = [(sx * 16.5, sy * 5.5) for sx in (1, -1) for sy in (1, -1)]
PLANTERS = [(8.4, -0.6, 10.8, 0.6), (-10.8, -0.6, -8.4, 0.6)]
# x, y, seats along x; who sits looks away from the back
BENCHES = [(-2.6, 14.6, True), (2.6, 14.6, True), (14.6, 2.4, False)]
BINS = [(0.0, 14.8), (14.8, 4.4)]
GROUPS = [(-6.5, 6.8), (7.2, 7.4), (-7.6, -7.0), (6.4, -8.2), (-15.8, 0.4), (15.4, -9.4), (0.4, -15.2), (-9.8, 16.4)]
HOUSES = ((5, 4, "cream"), (4, 3, "brick"), (5, 4, "white"), (4, 3, "blue"), (5, 3, "ochre"), (4, 4, "office"))


def _obstacles():
    x, y, r = FOUNTAIN
    s = r * 0.5412  # a regular octagon's half side, as two rectangles
    boxes = [(x - r, y - s, x + r, y + s), (x - s, y - r, x + s, y + r)]
    boxes += [(x - 0.85, y - 0.85, x + 0.85, y + 0.85) for x, y in TREES]
    boxes += [(x - 0.15, y - 0.15, x + 0.15, y + 0.15) for x, y in LAMPS]
    boxes += PLANTERS
    for x, y, along_x in BENCHES:
        a, b = (1.0, 0.75) if along_x else (0.75, 1.0)
        boxes.append((x - a, y - b, x + a, y + b))
    boxes += [(x - 0.28, y - 0.28, x + 0.28, y + 0.28) for x, y in BINS]
    return boxes


def model():
    builder = Builder("square", surfaces.materials())
    builder.add(scaled(slab(-HALF - 14, HALF + 14, -HALF - 14, HALF + 14, -0.02, 3.0), 4.0), "asphalt", (0.6, 0.6, 0.6))
    builder.add(scaled(slab(-HALF, HALF, -HALF, HALF, 0.0, 0.7), 2.4), "setts", (0.95, 0.92, 0.88))
    for k in (-3, -2, -1, 0, 1, 2):  # bands of slabs across the setts
        at = 7.0 * k + 3.5
        builder.add(scaled(slab(-HALF, HALF, at - 0.35, at + 0.35, 0.003, 0.7), PAVING_M), "paving", (0.92, 0.90, 0.86))
        builder.add(scaled(slab(at - 0.35, at + 0.35, -HALF, HALF, 0.004, 0.7), PAVING_M), "paving", (0.92, 0.90, 0.86))
    rows = ((-HALF, HALF, 1, 0), (HALF, HALF, 0, -1), (HALF, -HALF, -1, 0), (-HALF, -HALF, 0, 1))
    for number, (x, y, dx, dy) in enumerate(rows):
        row = Row(builder, (x, y), (dx, dy))
        s = 0.0
        for k in range(3):
            bays, storeys, look = HOUSES[(number * 2 + k) % len(HOUSES)]
            s = row.house(s, 4 if k == 1 else 5, storeys, look, 10 * number + k + 3, shops=k != 1)
    fittings.fountain(builder, (FOUNTAIN[0], FOUNTAIN[1], 0))
    for k, (x, y) in enumerate(TREES):
        fittings.tree_grate(builder, (x, y, 0))
        fittings.tree(builder, (x, y, 0), 7.2 + 0.5 * k, 20 + k)
    for x, y in LAMPS:
        fittings.lamp(builder, (x, y, 0), (-1 if x > 0 else 1, 0))
    for k, (x0, y0, x1, y1) in enumerate(PLANTERS):
        fittings.planter(builder, (x0, y0, 0), (x1, y1, 0.45), 5 + k)
    for x, y, along_x in BENCHES:
        fittings.bench(builder, (x, y, 0), along_x)
    for x, y in BINS:
        fittings.bin_(builder, (x, y, 0))
    return builder.bytes()


def _free(x, y):
    return all(not (a - 0.6 < x < c + 0.6 and b - 0.6 < y < d + 0.6) for a, b, c, d in _obstacles()) and all(
        math.hypot(x - gx, y - gy) > 1.9 for gx, gy in GROUPS
    )


def _people(scene):
    cast = [name for name in CAST]
    walk = {"area": "square", "clip": "walk", "idle_clip": "idle"}
    grown = [name for name in cast if name != "person_8"]  # the boy's feet do not reach the ground
    seats = [(x, y, yaw) for x, y, yaw in ((-2.2, 14.6, -90), (3.0, 14.6, -90), (14.6, 2.0, 180))]
    for k, (x, y, yaw) in enumerate(seats):
        scene.person(f"sitter_{k + 1}", grown[3 * k], {"type": "stand", "clip": "sit"}, (x, y, 0), yaw, scale=1)
    for g, (x, y) in enumerate(GROUPS):
        for k in range(3):
            turn = 2 * math.pi * k / 3
            place = (x + 0.75 * math.cos(turn), y + 0.75 * math.sin(turn), 0)
            group = {"type": "group", "group": f"group_{g + 1}", "position": (x, y, 0), "radius_m": 0.75, **walk}
            name, yaw = cast[(4 * g + 3 * k + 1) % len(cast)], math.degrees(turn) + 180
            scene.person(f"talker_{3 * g + k + 1}", name, {**group, "idle_clip": "talk"}, place, yaw)
    corners = ((-18.5, -17), (18.5, 17), (-18.5, 17), (18.5, -17))
    for k in range(13):  # who cross the square, again and again
        a, b = corners[k % 4], corners[(k % 4) ^ 1]
        steps = []
        for (x, y), pause in ((b, 6), (a, 9)):
            shift = (k // 4) * 1.1 - 1.6
            steps.append({"type": "go_to", "position": (x, y + shift, 0), **walk, "speed": 1.35 + 0.03 * (k % 5)})
            steps.append({"type": "stand", "clip": "wait", "until": {"seconds": pause + k % 3}})
        start = (a[0] + (b[0] - a[0]) * 0.1 * (k // 4), a[1] + (k // 4) * 1.1 - 1.6, 0)
        scene.person(f"crosser_{k + 1}", cast[(5 * k + 2) % len(cast)], {"type": "sequence", "repeat": True, "steps": steps}, start, 0)
    count, number = 0, 0
    golden = 2.399963
    while count < 100 - 3 - 24 - 13:  # strollers, spread evenly
        number += 1
        r = 4.4 + 14.6 * math.sqrt(number / 96)
        x, y = r * math.cos(number * golden), r * math.sin(number * golden)
        if abs(x) > 18.6 or abs(y) > 18.6 or not _free(x, y):
            continue
        count += 1
        behaviour = {"type": "wander", "pause_s": 2 + count % 4, "speed": 1.0 + 0.08 * (count % 6), **walk}
        scene.person(f"stroller_{count}", cast[(7 * count) % len(cast)], behaviour, (x, y, 0), (number * 77) % 360)


def scene():
    scene = Scene("crowd", "A town square by day with a hundred people who stroll, cross it, talk and sit.", seed=1)
    scene.data["environment"] = {
        "lux": 100e3,
        "daylight": {"azimuth_deg": 230, "elevation_deg": 50, "turbidity": 4, "clouds": 0.3, "ground": (0.3, 0.28, 0.25)},
        "exposure": 2.2,
    }
    scene.model("square", "crowd/square.glb")
    scene.data["models"]["sky"] = {"shape": "sky"}
    for name in CAST:
        scene.model(name, f"hall/{name}.glb", front="+z")
    scene.object("square", "square", "building")
    scene.object("sky", "sky", "sky")
    scene.area("square", [(-WALK, -WALK), (WALK, -WALK), (WALK, WALK), (-WALK, WALK)], _obstacles())
    _people(scene)
    scene.place("west", "from above the western side over the whole square", (-19.8, -2.6, 5.6), (2, 1.0, 0.2), 62)
    scene.place("fountain", "beside the fountain, as a person with a camera sees it", (-7.5, -5.5, 2.2), (2.5, 4.5, 0.7), 55)
    scene.place("roof", "from a roof, steeply down", (0, -20.5, 17), (0, 1.5, 0), 56)
    scene.place("benches", "along the benches on the northern side", (-9, 11.6, 2.3), (3.5, 14.2, 0.8), 55)
    for name in ("west", "fountain", "roof"):
        scene.camera(name, name, (640, 480), 25)
    return scene.text()


def files():
    return {"crowd.json": scene(), "crowd/square.glb": model()}
