"""A street with lanes, a raised crossing with lights, parked and driving cars, people and a drone, by day."""

import math

from . import shapes
from .glb import Glb
from .people.cast import CAST
from .scene import NULL, Scene
from .town import fittings, surfaces, vehicles
from .town.buildings import Row
from .town.builder import Builder, block, post, slab, to_file
from .town.surfaces import ASPHALT_M, PAVING_M, scaled

LANE_Y = 1.65
KERB_Y, PARK_Y, FRONT_Y = 3.3, 5.4, 9.6  # edge of the lanes, of the parking bays, the houses
ROAD_Z = -0.10
END_X = 63.0  # where the houses end
FAR_KERB_X, FAR_FRONT_X = 74.6, 78.0  # across the ends: edge of the road, the houses
BULGE_X = 7.0  # the pavement reaches the lanes beside the crossing
ZEBRA_X, RAMP_X = 2.0, 4.4
WHITE, KERB, PAVING = (0.80, 0.80, 0.78), (0.30, 0.295, 0.285), (0.80, 0.80, 0.80)

TREES = [(x, side * 6.2) for side in (1, -1) for x in (-40.5, -28, -15.5, 15.5, 28, 40.5)]
LAMPS = [(x, side * 5.75) for side in (1, -1) for x in (-34, -9.5, 9.5, 34)]
BENCHES = [(-21.5, 6.4), (21.5, 6.4), (-33.5, -6.4 - 0.2), (12.0, -6.4 - 0.2)]
BINS = [(-19.8, 6.1), (19.8, 6.1), (-12.0, -6.1)]
BOLLARDS = [(side * x, s * 3.75) for side in (1, -1) for s in (1, -1) for x in (3.0, 4.4, 5.8)]
PARKED = [
    ("car_3", -44.5, 1), ("car_1", -38.9, 1), ("van", -25.0, 1), ("car_2", -13.2, 1), ("car_5", 12.6, 1), ("car_4", 24.0, 1),
    ("car_2", 37.6, 1), ("car_2", -36.4, -1), ("car_4", -24.9, -1), ("car_1", -18.6, -1), ("car_3", 13.0, -1), ("car_5", 31.2, -1),
    ("car_1", 43.7, -1),
]  # fmt: skip
HOUSES = [(4, 3, "brick"), (5, 4, "cream"), (3, 4, "blue"), (4, 3, "ochre"), (6, 4, "office"), (4, 4, "white"), (5, 3, "brick"), (4, 4, "blue"), (7, 3, "cream")]

# Both lanes are part of a way round the block behind the houses, so that cars come back.
LANE = [(-58, -LANE_Y), (58, -LANE_Y), (66.5, -5), (70, -13), (70, -36), (61, -45), (-61, -45), (-70, -36), (-70, -13), (-66.5, -5)]
DRIVERS = [
    ("car_1", 0, 8.5), ("car_4", 17, 8.0), ("van", 48, 7.5), ("car_2", 105, 8.8), ("car_3", 190, 8.4), ("car_5", 260, 8.0)
]  # fmt: skip

WALKWAY = [
    (-46, -9.1), (46, -9.1), (46, -5.6), (6.6, -5.6), (6.6, -3.9), (1.8, -3.9), (1.8, 3.9), (6.6, 3.9), (6.6, 5.6), (46, 5.6),
    (46, 9.1), (-46, 9.1), (-46, 5.6), (-6.6, 5.6), (-6.6, 3.9), (-1.8, 3.9), (-1.8, -3.9), (-6.6, -3.9), (-6.6, -5.6), (-46, -5.6),
]  # fmt: skip
LAMP_COLOUR = (1.0, 0.82, 0.58)
PERIOD_S, FIRST_RED_S, WALK_AFTER_S, GREEN_AFTER_S = 40, 4, 4, 21


def _obstacles(side):
    """Rectangles that nobody on this side's pavement (1 north, -1 south) walks through."""
    boxes = [(x - 0.75, y - 0.75, x + 0.75, y + 0.75) for x, y in TREES]
    boxes += [(x - 0.15, y - 0.15, x + 0.15, y + 0.15) for x, y in LAMPS]
    boxes += [(x - 0.95, y - 0.35, x + 0.95, y + 0.35) for x, y in BENCHES]
    boxes += [(x - 0.28, y - 0.28, x + 0.28, y + 0.28) for x, y in BINS]
    boxes += [(x - 0.1, y - 0.1, x + 0.1, y + 0.1) for x, y in BOLLARDS]
    boxes += [(x - 0.15, y - 0.15, x + 0.15, y + 0.15) for x, y in SIGNALS]
    return [b for b in boxes if b[1] * side > 0]


SIGNALS = [(-3.0, -4.9), (3.0, 4.9)]  # the poles of the lights, at the right of each lane


def _ground(builder):
    def road(x0, x1, y0, y1, z=ROAD_Z, cell=1.2):
        builder.add(scaled(slab(x0, x1, y0, y1, z, cell), ASPHALT_M), "asphalt", (0.62, 0.62, 0.62))

    # Under all of it: where a surface meets one that is cut otherwise, a gap of rounding lets a pixel through now and then.
    builder.add(slab(-FAR_FRONT_X, FAR_FRONT_X, -FRONT_Y - 0.3, FRONT_Y + 0.3, ROAD_Z - 0.05, 4), "plain", KERB)
    road(-END_X, -RAMP_X, -KERB_Y, KERB_Y)
    road(RAMP_X, END_X, -KERB_Y, KERB_Y)
    for side in (1, -1):
        # Across its ends a road, and before the houses there a pavement that goes on a little under them.
        a, b = sorted((side * 53, side * (FAR_KERB_X + 0.15)))
        road(a, b, -50, 50, ROAD_Z - 0.001, 4)
        a, b = sorted((side * FAR_KERB_X, side * (FAR_KERB_X + 0.15)))
        builder.add(block((a, -50, ROAD_Z - 0.05), (b, 50, 0.004), cells=1), "plain", KERB)
        a, b = sorted((side * (FAR_KERB_X + 0.15), side * (FAR_FRONT_X + 0.5)))
        builder.add(scaled(slab(a, b, -50, 50, 0.0, 4), PAVING_M), "paving", PAVING)
        # Crossing on a table with ramps.
        ramp = slab(side * ZEBRA_X, side * RAMP_X, -KERB_Y, KERB_Y, 0.0, 0.6)
        if side < 0:
            ramp = slab(-RAMP_X, -ZEBRA_X, -KERB_Y, KERB_Y, 0.0, 0.6)
        ramp.positions[:, 1] = ROAD_Z * (abs(ramp.positions[:, 0]) - ZEBRA_X) / (RAMP_X - ZEBRA_X)
        builder.add(scaled(ramp, 2.4), "setts", (0.70, 0.70, 0.70))
    builder.add(scaled(slab(-ZEBRA_X, ZEBRA_X, -KERB_Y, KERB_Y, 0.0, 0.6), ASPHALT_M), "asphalt", (0.55, 0.55, 0.55))
    for k in range(7):
        y = -KERB_Y + 0.35 + k * 0.95
        builder.add(slab(-ZEBRA_X + 0.1, ZEBRA_X - 0.1, y, y + 0.5, 0.004, 1.0), "paint", WHITE)
    for k in range(24):  # the line between the lanes, and stop lines
        x = 8 + k * 4.6 / 2
        for sign in (1, -1):
            if k % 2 == 0:
                a, b = sorted((sign * x, sign * (x + 1.8)))
                builder.add(slab(a, b, -0.06, 0.06, ROAD_Z + 0.004, 1.0), "paint", WHITE)
    builder.add(slab(-6.0, -5.6, -KERB_Y + 0.1, -0.1, ROAD_Z + 0.004), "paint", WHITE)
    builder.add(slab(5.6, 6.0, 0.1, KERB_Y - 0.1, ROAD_Z + 0.004), "paint", WHITE)

    for side in (1, -1):

        def strip(x0, x1, y0, y1, side=side, cell=0.8):
            a, b = sorted((side * y0, side * y1))
            builder.add(scaled(slab(x0, x1, a, b, 0.0, cell), PAVING_M), "paving", PAVING)

        strip(-END_X, END_X, PARK_Y + 0.2, FRONT_Y)
        pieces = [(-END_X, -48), (-BULGE_X, BULGE_X), (48, END_X)]
        for x0, x1 in pieces:
            strip(x0, x1, KERB_Y + 0.15, PARK_Y + 0.2)
            a, b = sorted((side * KERB_Y, side * (KERB_Y + 0.15)))
            builder.add(block((x0, a, ROAD_Z - 0.05), (x1, b, 0.004), cells=(1)), "plain", KERB)
            for x in (x0, x1):
                a, b = sorted((side * KERB_Y, side * (PARK_Y + 0.2)))
                builder.add(block((x - 0.075, a, ROAD_Z - 0.05), (x + 0.075, b, 0.004)), "plain", KERB)
        for x0, x1 in ((-48, -BULGE_X), (BULGE_X, 48)):
            a, b = sorted((side * KERB_Y, side * PARK_Y))
            builder.add(scaled(slab(x0, x1, a, b, ROAD_Z, 0.8), 2.4), "setts", (0.52, 0.52, 0.53))
            a, b = sorted((side * PARK_Y, side * (PARK_Y + 0.2)))
            for k in range(40):
                builder.add(
                    block((x0 + (x1 - x0) * k / 40, a, ROAD_Z - 0.05), (x0 + (x1 - x0) * (k + 1) / 40, b, 0.004), ("front", "back", "top")),
                    "plain",
                    KERB,
                )


def _houses(builder):
    for number, row in enumerate((Row(builder, (-END_X, FRONT_Y), (1, 0)), Row(builder, (END_X, -FRONT_Y), (-1, 0)))):
        s = 0.0
        order = HOUSES if number == 0 else HOUSES[4:] + HOUSES[:4]
        for k, (bays, storeys, look) in enumerate(order):
            s = row.house(s, bays, storeys, look, 100 * number + k + 1, shops=k % 3 != 2)
    for row, number in ((Row(builder, (FAR_FRONT_X, 33), (0, -1)), 3), (Row(builder, (-FAR_FRONT_X, -33), (0, 1)), 4)):
        s = 0.0
        for k, (bays, storeys, look) in enumerate(HOUSES[number : number + 5]):
            s = row.house(s, bays, storeys, look, 100 * number + k, shops=False)


def _fittings(builder):
    for k, (x, y) in enumerate(TREES):
        fittings.tree_grate(builder, (x, y, 0))
        fittings.tree(builder, (x, y, 0), 6.6 + 0.9 * ((k * 7) % 5) / 4, 60 + k)
    for x, y in LAMPS:
        fittings.lamp(builder, (x, y, 0), (0, -1 if y > 0 else 1))
    for x, y in BENCHES:
        fittings.bench(builder, (x, y, 0))
    for x, y in BINS:
        fittings.bin_(builder, (x, y, 0))
    for x, y in BOLLARDS:
        fittings.bollard(builder, (x, y, 0))
    for x, y in SIGNALS:
        look = -1 if x < 0 else 1
        builder.add(post(0.06, 3.3, (x, y, 0)), "metal", (0.06, 0.065, 0.07))
        builder.add(block((x - 0.13, y - 0.15, 2.35), (x + 0.13, y + 0.15, 3.35)), "metal", (0.02, 0.022, 0.022))
        for z, tone in ((3.15, (0.10, 0.008, 0.006)), (2.85, (0.09, 0.055, 0.005)), (2.55, (0.006, 0.06, 0.03))):
            builder.add(_lamp_disc(look, (x + look * 0.135, y, z)), "plain", tone, shade=1.0)
            builder.add(block((x + min(0, look * 0.26), y - 0.13, z + 0.115), (x + max(0, look * 0.26), y + 0.13, z + 0.135)), "metal", (0.02, 0.022, 0.022))
    for x, facing in ((-46.5, (-1, 0)), (46.5, (1, 0))):
        fittings.sign(builder, (x, -5.7 if x < 0 else 5.7, 0), facing, (0.62, 0.02, 0.02))


def _lamp_disc(look, at, radius=0.10):
    """A lens that looks along world x."""
    turn = [[0, look, 0], [1, 0, 0], [0, 0, -look]]
    return shapes.disc(radius, 20).moved(matrix=turn).moved(to_file(at))


def _light(name, colour, height):
    """A lit lamp whose origin is where cars stop for it: 3.6 m before the pole's crossing, in the lane's middle."""
    glb = Glb(name)
    material = glb.material(name, base=colour, unlit=True)
    # The file's +z is along the lane and +x to its left; the lamp looks back at the drivers.
    ahead, left, _ = STOP_TO_SIGNAL
    lens = shapes.disc(0.10, 20).moved(matrix=[[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    mesh = lens.moved((left, height, ahead - 0.142))
    glb.node(name, mesh=glb.mesh(name, [glb.primitive(mesh.positions, mesh.normals, mesh.triangles, material)]))
    return glb.bytes()


def _lamp_glow():
    """What shines below the head of a lit street lamp (fittings.lamp); origin at the middle of its head."""
    glb = Glb("lamp_glow")
    material = glb.material("lamp_glow", base=LAMP_COLOUR, unlit=True)
    mesh = block((-0.2, -0.2, -0.085), (0.2, 0.2, -0.065))
    glb.node("lamp_glow", mesh=glb.mesh("lamp_glow", [glb.primitive(mesh.positions, mesh.normals, mesh.triangles, material)]))
    return glb.bytes()


STOP_AT = (-3.9, -LANE_Y)  # of the eastern lane; the western one's is opposite
STOP_TO_SIGNAL = (SIGNALS[0][0] - STOP_AT[0], SIGNALS[0][1] - STOP_AT[1], 0)


def model():
    builder = Builder("street", surfaces.materials())
    _ground(builder)
    _houses(builder)
    _fittings(builder)
    return builder.bytes()


def _signal(scene):
    """Lights by events: a red lamp is an actor whose body stands on the lane, so that cars stop for it."""
    lanes = {"east": (*STOP_AT, ROAD_Z + 0.1), "west": (-STOP_AT[0], -STOP_AT[1], ROAD_Z + 0.1)}
    yaw = {"east": 0, "west": 180}

    def lamp(lane, colour):
        radius = {"radius_m": 0.5} if colour == "red" else {}
        return {
            "name": f"{colour}_{lane}", "model": f"{colour}_light", "class": "traffic_light", "position": lanes[lane],
            "yaw_deg": yaw[lane], **radius, "behaviour": {"type": "stand"},
        }  # fmt: skip

    for lane in lanes:
        scene.data.setdefault("actors", []).append(lamp(lane, "green"))
    scene.event("red", {"every_s": PERIOD_S, "from_s": FIRST_RED_S}, [
        action for lane in lanes
        for action in ({"action": "remove", "actor": f"green_{lane}"}, {"action": "spawn", "actor": lamp(lane, "red")})
    ])  # fmt: skip
    scene.event("walk", {"event": "red", "after_s": WALK_AFTER_S}, [])
    scene.event("green", {"event": "red", "after_s": GREEN_AFTER_S}, [
        action for lane in lanes
        for action in ({"action": "remove", "actor": f"red_{lane}"}, {"action": "spawn", "actor": lamp(lane, "green")})
    ])  # fmt: skip


def _people(scene):
    def walk(area, **keys):
        return {"area": area, "clip": "walk", "idle_clip": "idle", **keys}

    names = iter([f"person_{i}" for i in (5, 3, 1, 4, 7, 9, 2, 10, 11, 6, 8, 1, 5, 3, 9, 10, 2, 4, 6, 7)])
    # Who cross: to the kerb, wait for the light, over, about on the other side, and back.
    for k in range(8):
        side = 1 if k % 2 == 0 else -1
        x = (-1.35, -0.45, 0.45, 1.35)[k // 2]
        steps = []
        for here in (side, -side):
            own, other = ("north", "south") if here > 0 else ("south", "north")
            steps.append({"type": "go_to", "position": (x, here * 4.35, 0), "yaw_deg": -90 * here, **walk("walkway")})
            steps.append({"type": "stand", "clip": "wait", "until": {"event": "walk"}})
            steps.append({"type": "go_to", "position": (x * 2.4, -here * 7.2, 0), **walk("walkway")})
            steps.append({"type": "wander", **walk(other), "pause_s": 3, "until": {"seconds": 14 + 3 * k}})
        position = (x * 3.2, side * (6.4 + 0.5 * (k % 3)), 0)
        scene.person(f"crosser_{k + 1}", next(names), {"type": "sequence", "repeat": True, "steps": steps}, position, -90 * side)
    places = [(-30, 1), (-12.5, 1), (8.5, 1), (27, 1), (38, 1), (-38, -1), (-22, -1), (9.0, -1), (18, -1), (33, -1)]
    for k, (x, side) in enumerate(places):
        area = "north" if side > 0 else "south"
        scene.person(
            f"stroller_{k + 1}", next(names),
            {"type": "wander", "pause_s": 4, "speed": 1.1 + 0.05 * (k % 5), **walk(area)}, (x, side * 7.7, 0), 180 * (k % 2),
        )  # fmt: skip


def _lamp_heads():
    return [(x, y - math.copysign(1.2, y), 5.74) for x, y in LAMPS]


def _lamp_lights(scene, intensity):
    """The lamps' light; off by day. They shine from below the head of fittings.lamp."""
    for k, (x, y, z) in enumerate(_lamp_heads()):
        scene.light(f"lamp_{k + 1}", "spot", group="lamps", color=LAMP_COLOUR, intensity=intensity, position=(x, y, z - 0.14), direction=(0, 0, -1), inner_cone_deg=35, outer_cone_deg=72)


def _variant(name, description, lux, daylight, exposure, lamp_cd):
    """The street at another time: what differs from `street`. `lux`: illuminance that is drawn as white at exposure 1."""
    scene = Scene(name, description, seed=1)
    scene.data["base"] = "street.json"
    scene.data["environment"] = {"ambient": NULL, "background": NULL, "lux": lux, "daylight": daylight, "exposure": exposure}
    scene.data["models"] = {"sky": {"shape": "sky"}}
    scene.object("sky", "sky", "sky")
    if lamp_cd > 0:
        scene.model("lamp_glow", "street/lamp_glow.glb")
        scene.data["lights"] = [{"name": f"lamp_{k + 1}", "intensity": lamp_cd / lux} for k in range(len(LAMPS))]
        # Actors, which are in nobody's way: baked light is of the objects, and is that of the street.
        for k, head in enumerate(_lamp_heads()):
            scene.actor(f"lamp_glow_{k + 1}", "lamp_glow", "light", {"type": "stand"}, head)
    return scene.text()


def scene():
    scene = Scene("street", "A street by day: cars in two lanes, a crossing with lights, people, and a drone above.", seed=1)
    scene.environment(background=(0.50, 0.68, 0.93), sky=(0.74, 0.80, 0.90), ground=(0.40, 0.37, 0.33), exposure=1.0)
    scene.model("street", "street/street.glb")
    for name in (*vehicles.CARS, "drone", "red_light", "green_light"):
        scene.model(name, f"street/{name}.glb", front="+z")
    for name in CAST:
        scene.model(name, f"hall/{name}.glb", front="+z")
    scene.object("street", "street", "building")
    for k, (name, x, side) in enumerate(PARKED):
        # An object stands as its file has it: ahead is world -y.
        scene.object(f"parked_{k + 1}", name, "car", (x, side * 4.35, ROAD_Z), yaw_deg=90 * -side)
    scene.light("sun", "directional", color=(1, 0.95, 0.86), intensity=0.95, direction=(0.45, 0.50, -0.85))
    _lamp_lights(scene, 0.0)
    scene.route("lane_east", [(x, y, ROAD_Z) for x, y in LANE], closed=True)
    scene.route("lane_west", [(-x, -y, ROAD_Z) for x, y in LANE], closed=True)
    scene.route(
        "drone_path",
        [(-34, 1, 10), (-12, 3.5, 7.5), (4, 3, 6.2), (26, 1.5, 8.5), (36, -1.5, 11), (16, -3.5, 12.5), (-18, -3, 12)],
        closed=True,
    )
    for lane in ("east", "west"):
        for k, (model_name, start, speed) in enumerate(DRIVERS):
            name = model_name if lane == "east" else DRIVERS[(k + 2) % len(DRIVERS)][0]
            scene.actor(
                f"{lane}_{k + 1}", name, "car",
                {"type": "vehicle", "route": f"lane_{lane}", "speed": speed, "start_m": start + (9 if lane == "west" else 0),
                 "length_m": vehicles.LENGTHS_M[name], "width_m": 1.8, "clip": "drive"},
                variant=2 * k + (lane == "west") + 1,
            )  # fmt: skip
    scene.actor("drone", "drone", "drone", {"type": "route", "route": "drone_path", "speed": 3.0, "mode": "loop", "clip": "fly"})
    scene.area("walkway", WALKWAY, _obstacles(1) + _obstacles(-1))
    scene.area("north", [(-46, 5.6), (46, 5.6), (46, 9.1), (-46, 9.1)], [b for b in _obstacles(1) if b[1] > 5.6 or b[3] > 5.6])
    scene.area("south", [(-46, -9.1), (46, -9.1), (46, -5.6), (-46, -5.6)], [b for b in _obstacles(-1) if b[1] < -5.6])
    _signal(scene)
    _people(scene)
    scene.place("corner", "from a corner of the houses over the crossing and both lanes", (-8.4, -8.9, 4.0), (3.5, 2.2, 0.2), 62)
    scene.place("crossing", "beside the crossing, near enough to know people", (-8.6, 6.0, 2.3), (1.6, 0.2, 0.9), 55)
    scene.place("lane", "from above the western end along both lanes", (-47.5, 0.0, 5.6), (0, 0.0, 0.4), 42)
    scene.place("window", "from a window on the third floor down to the crossing", (13.5, 9.4, 9.6), (0.5, -1.0, 0), 52)
    scene.place("pavement", "along the northern pavement", (-30, 8.6, 2.4), (-14, 6.6, 1.0), 55)
    for name in ("corner", "crossing", "lane"):
        scene.camera(name, name, (640, 480), 25)
    return scene.text()


def variants():
    return {
        "street-noon.json": _variant("street noon", "The street in the sun of noon.", 100e3, {"azimuth_deg": 150, "elevation_deg": 52, "turbidity": 4.5, "clouds": 0.35}, 2.2, 0),
        "street-evening.json": _variant(
            "street evening", "The street in the last sun, its lamps just lit.", 10e3, {"azimuth_deg": 258, "elevation_deg": 8, "turbidity": 4, "clouds": 0.3}, 1.8, 3000
        ),
        "street-night.json": _variant("street night", "The street by its lamps.", 100, {"azimuth_deg": 300, "elevation_deg": -9}, 2.5, 3000),
    }


def files():
    return {
        "street.json": scene(),
        **variants(),
        "street/street.glb": model(),
        "street/red_light.glb": _light("red_light", (1.0, 0.05, 0.03), 3.15),
        "street/green_light.glb": _light("green_light", (0.05, 0.95, 0.35), 2.55),
        "street/lamp_glow.glb": _lamp_glow(),
        **vehicles.files(),
    }
