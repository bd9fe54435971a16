"""Where the hall's furniture stands, how people walk through it, and from where cameras look. World frame, metres,
degrees.

A piece's front looks to the south (-y) at yaw 0, east at 90, north at 180, west at -90.
"""

import math

from . import fittings, furniture, structure

S, E, N, W = 0, 90, 180, -90
TOP = structure.GALLERY_Z


def pieces():
    """{mesh name: (function making it, [(node name, position, yaw)])}."""
    plan = {}

    def put(mesh, make, places):
        number = len(places) > 1
        plan[mesh] = (
            make,
            [(f"{mesh}_{i + 1}" if number else mesh, position, yaw) for i, (position, yaw) in enumerate(places)],
        )

    put(
        "bench",
        furniture.backed_bench,
        [
            ((8.2, 10.03, 0), S),
            ((8.2, 10.67, 0), N),
            ((10.4, 10.03, 0), S),
            ((10.4, 10.67, 0), N),
            ((14.5, 5.93, 0), S),
            ((14.5, 6.57, 0), N),
            ((16.7, 5.93, 0), S),
            ((16.7, 6.57, 0), N),
            ((7.9, 5.28, 0), S),
            ((7.9, 5.92, 0), N),
        ],
    )
    put(
        "stool_bench",
        furniture.bench,
        [
            ((3.8, 0.50, 0), N),
            ((8.2, 0.50, 0), N),
            ((12.6, 0.50, 0), N),
            ((6.0, 19.4, TOP), S),
            ((12.0, 19.4, TOP), S),
            ((26.0, 19.4, TOP), S),
        ],
    )
    put(
        "tree",
        lambda: furniture.planter(True, 3),
        [
            ((12.15, 10.35, 0), 20),
            ((29.1, 1.75, 0), 80),
            ((29.2, 14.8, 0), 200),
            ((0.75, 18.9, 0), 140),
            ((0.75, 0.75, 0), 300),
            ((19.3, 19.0, TOP), 10),
        ],
    )
    put(
        "plant",
        lambda: furniture.planter(False, 9),
        [
            ((6.45, 10.35, 0), 0),
            ((12.95, 6.25, 0), 60),
            ((18.25, 6.25, 0), 190),
            ((9.45, 5.6, 0), 30),
            ((19.95, 8.9, 0), 120),
            ((13.9, 17.4, 0), 45),
            ((7.7, 17.4, 0), 260),
            ((1.0, 19.3, TOP), 90),
            ((24.7, 14.1, 0), 150),
        ],
    )
    put(
        "bin",
        furniture.bin_,
        [((7.0, 9.2, 0), 0), ((18.95, 5.1, 0), 0), ((24.15, 15.3, 0), 0), ((29.3, 11.6, 0), 0), ((5.4, 0.45, 0), 0)],
    )
    put("reception_desk", furniture.desk, [((10.8, 17.2, 0), S)])
    put(
        "ticket_machine",
        lambda: furniture.machine("ticket"),
        [((15.2, 19.65, 0), S), ((16.3, 19.65, 0), S), ((17.4, 19.65, 0), S)],
    )
    put(
        "vending_machine",
        lambda: furniture.machine("vending", (1.0, 1.95, 0.7)),
        [((20.3, 0.38, 0), N), ((21.45, 0.38, 0), N)],
    )
    put("lift", lambda: furniture.machine("lift", (1.5, 2.25, 0.08)), [((26.6, 19.95, 0), S), ((26.6, 19.95, TOP), S)])
    put("info_totem", furniture.totem, [((24.8, 10.9, 0), W), ((5.0, 13.2, 0), S)])
    walls = [
        ((0.0, 3.3, 1.65), E),
        ((0.0, 6.6, 1.65), E),
        ((0.0, 13.4, 1.65), E),
        ((3.9, 20.0, 1.55), S),
        ((22.2, 20.0, 1.55), S),
        ((30.0, 1.2, 1.7), W),
        ((30.0, 16.2, 1.6), W),
        ((30.0, 17.9, 1.6), W),
    ]
    for i, place in enumerate(walls):
        put(f"poster_{'abcdefgh'[i]}", lambda i=i: fittings.poster(i), [place])
    put("banner_left", lambda: fittings.banner("banner_a"), [((6.9, 13.9, 6.3), -20)])
    put("banner_right", lambda: fittings.banner("banner_b"), [((16.5, 13.9, 6.3), -20)])
    put("double_door", lambda: fittings.door("door_a", True), [((2.0, 20.0, 0), S), ((0.0, 10.0, 0), E)])
    put(
        "door",
        lambda: fittings.door("door_a"),
        [
            ((5.8, 20.0, 0), S),
            ((5.1, 20.0, TOP), S),
            ((9.7, 20.0, TOP), S),
            ((16.6, 20.0, TOP), S),
            ((0.0, 17.0, 0), E),
        ],
    )
    put(
        "service_door",
        lambda: fittings.door("door_b"),
        [((19.2, 20.0, 0), S), ((24.4, 20.0, 0), S), ((23.5, 20.0, TOP), S), ((28.7, 20.0, TOP), S)],
    )
    put("sign_toilets", lambda: fittings.small_sign("sign_d"), [((24.4, 19.97, 2.5), S)])
    put("sign_exit", lambda: fittings.small_sign("exit", (0.6, 0.225)), [((0.0, 10.0, 2.5), E), ((2.0, 19.97, 2.5), S)])
    put("sign_information", lambda: fittings.small_sign("info", (2.4, 0.6)), [((11.4, 19.97, 2.25), S)])
    put("hanging_sign_exit", lambda: fittings.hanging_sign("sign_b", "sign_c", 2.0), [((13.2, 11.9, 4.25), W)])
    put("hanging_sign_platforms", lambda: fittings.hanging_sign("sign_a", "sign_b", 2.0), [((21.0, 6.0, 4.25), W)])
    put("departure_board", lambda: fittings.hanging_sign("board", "board", 1.4, (4.0, 1.25)), [((17.8, 9.6, 4.55), W)])
    put("clock", fittings.clock, [((14.3, 20.0, 5.5), S)])
    put("map", fittings.wall_map, [((0.0, 15.0, 1.6), E), ((21.0, 20.0, 5.2), S)])
    put(
        "pendant_pair",
        lambda: _row(fittings.pendant(), 1.8),
        [((5.0 * i + 2.5, y, 5.1), S) for y in (3.0, 12.7) for i in range(6)],
    )
    put(
        "downlights",
        lambda: _row(fittings.downlight(), 2.5, 6),
        [((7.5 + 15.0 * i, y, TOP - structure.SLAB), S) for y in (16.5, 18.5) for i in range(2)],
    )
    put("light_line", fittings.light_line, [((5.0 * i + 2.5, 17.4, 6.55), S) for i in range(6)])
    put("cafe_counter", furniture.kiosk, [((27.0, 1.55, 0), N)])
    tables = [(22.9, 4.9), (24.6, 3.2), (22.7, 2.3)]
    put("table", furniture.table, [((x, y, 0), S) for x, y in tables])
    put("chairs", furniture.chairs, [((x, y, 0), turn) for (x, y), turn in zip(tables, (20, 75, -30))])
    put("suitcase_blue", lambda: furniture.suitcase("case_a"), [((9.35, 9.45, 0), 30), ((13.95, 1.0, 0), 170)])
    put("suitcase_red", lambda: furniture.suitcase("case_b"), [((15.6, 5.35, 0), -20), ((6.55, 5.75, 0), 60)])
    put("stanchion", furniture.stanchion, [((x, 14.2, 0), 0) for x in (9.0, 10.5, 12.0)])
    put("belts", lambda: _row(furniture.belt(1.42), 1.5), [((10.5, 14.2, 0), 0)])
    put("entrance_mat", lambda: furniture.mat(3.4, 2.2), [((28.75, 8.25, 0), W)])
    put("facade", lambda: fittings.facade(11.5, 5.7), [((30.18, 8.25, 0), W)])
    put(
        "window",
        lambda: fittings.window(3.6, 3.4),
        [((a + 1.8, -0.22, 2.3), N) for a, _, _, _ in structure.SOUTH_WINDOWS],
    )
    put(
        "gallery_window",
        lambda: fittings.window(2.8, 1.2),
        [((a + 1.4, 20.18, 4.9), S) for a, _, _, _ in structure.NORTH_WINDOWS],
    )
    put(
        "skylight",
        lambda: fittings.skylight(3.2, 4.8),
        [(((a + b) / 2, 8.0, 7.18), S) for a, b, _, _ in structure.SKYLIGHTS],
    )
    put("railing", lambda: fittings.railing(5.125), [((2.5625 + 5.125 * i, 15.03, TOP + 0.08), S) for i in range(4)])
    put("railing_east", lambda: fittings.railing(7.0), [((26.5, 15.03, TOP + 0.08), S)])
    run, rise = structure.STAIR_Y[1] - structure.STAIR_Y[0], TOP
    put(
        "stair_rail",
        lambda: fittings.stair_rail(run, rise, 1),
        [
            ((structure.STAIR_X[0] + 0.05, structure.STAIR_Y[0], 0), S),
            ((structure.STAIR_X[1] - 0.05, structure.STAIR_Y[0], 0), S),
        ],
    )
    return plan


def _row(parts, step, count=2):
    """`count` copies side by side as one piece."""
    from ..shapes import join

    return [
        (material, join(*(mesh.moved(((i - (count - 1) / 2) * step, 0, 0)) for i in range(count))))
        for material, mesh in parts
    ]


def _loop(x0, y0, x1, y1, radius=0.8, z=None, clockwise=False):
    """A rectangle with round corners, counter-clockwise from its south-west."""
    points = []
    for cx, cy, start in (
        (x1 - radius, y0 + radius, -90),
        (x1 - radius, y1 - radius, 0),
        (x0 + radius, y1 - radius, 90),
        (x0 + radius, y0 + radius, 180),
    ):
        points += [
            (cx + radius * math.cos(math.radians(start + a)), cy + radius * math.sin(math.radians(start + a)))
            for a in (0, 22.5, 45, 67.5, 90)
        ]
    points = points[::-1] if clockwise else points
    return [(*p, z) for p in points] if z is not None else points


ROUTES = {
    "west_benches": _loop(5.0, 8.2, 13.3, 11.9, 1.1),
    "east_benches": _loop(11.4, 4.3, 19.6, 7.6, 0.9, clockwise=True),
    "south_side": _loop(2.4, 1.7, 21.2, 3.5, 0.85),
    "middle": _loop(14.2, 8.6, 19.4, 13.1, 1.0, clockwise=True),
    "entrance": _loop(20.4, 6.5, 28.9, 8.0, 0.72),
    "west_side": _loop(1.2, 4.6, 4.1, 12.2, 1.0, clockwise=True),
}
# name, model, route, way from the route's start as a share of its length, speed in metres a second
WALKERS = [
    ("anna", "person_1", "west_benches", 0.02, 1.25),
    ("tom", "person_2", "south_side", 0.12, 1.40),
    ("mei", "person_3", "east_benches", 0.52, 1.22),
    ("omar", "person_4", "west_benches", 0.52, 1.25),
    ("lena", "person_5", "west_side", 0.30, 1.20),
    ("samuel", "person_6", "middle", 0.30, 1.12),
    ("ben", "person_8", "south_side", 0.62, 1.40),
    ("ines", "person_10", "east_benches", 0.02, 1.22),
]
# name, model, position, yaw, clip
STANDERS = [
    ("ruth", "person_7", (11.0, 13.15, 0), -28, "talk"),
    ("raj", "person_9", (11.8, 12.73, 0), 152, "wait"),
    ("noah", "person_11", (8.35, 4.92, 0), -90, "sit"),
]

# rectangles nobody may enter (x0, y0, x1, y1): furniture, columns, stairs; on the ground floor
OBSTACLES = {
    "benches_west": (6.1, 9.7, 12.5, 11.0),
    "benches_near": (6.3, 5.0, 9.8, 6.2),
    "benches_east": (12.6, 5.6, 18.6, 6.9),
    "stairs": (20.4, 8.7, 23.1, 15.0),
    "plant_stairs": (19.65, 8.6, 20.25, 9.2),
    "desk": (8.9, 16.7, 12.7, 17.8),
    "queue": (8.8, 14.0, 12.2, 14.4),
    "cafe": (21.9, 1.3, 25.4, 5.8),
    "totem_east": (24.7, 10.5, 24.9, 11.3),
    "totem_west": (4.6, 13.1, 5.4, 13.3),
    "south_benches": (2.7, 0.0, 13.7, 0.9),
    "machines": (19.7, 0.0, 22.0, 0.8),
    "bin_1": (6.8, 9.0, 7.2, 9.4),
    "bin_2": (18.75, 4.9, 19.15, 5.3),
    "bin_3": (29.0, 11.3, 29.6, 11.9),
    "suitcase_1": (9.1, 9.3, 9.6, 9.7),
    "suitcase_2": (15.3, 5.1, 15.9, 5.6),
    "suitcase_3": (13.7, 0.7, 14.2, 1.2),
    **{f"column_{i + 1}": (x - 0.3, y - 0.3, x + 0.3, y + 0.3) for i, (x, y) in enumerate(structure.COLUMNS)},
}

# Where people find their way themselves: from the doors to the stairs and the cafe, off all routes.
AREAS = {
    "entrance_hall": (
        [(20.1, 6.1), (25.7, 6.1), (25.7, 3.0), (29.4, 3.0), (29.4, 7.6), (30.0, 7.6)]
        + [(30.0, 8.9), (29.4, 8.9), (29.4, 13.6), (23.4, 13.6), (23.4, 8.5), (20.1, 8.5)],
        ["column_7", "column_8", "totem_east", "bin_3"],
    ),
    "door": ([(28.9, 7.6), (30.0, 7.6), (30.0, 8.9), (28.9, 8.9)], []),
}
DOOR = (29.6, 8.25, 0)

# name: (what it shows, position, look at, vertical field of view)
PLACES = {
    "lobby": ("from the south-west corner over the whole hall to the entrance", (2, 3, 2.8), (12, 9, 1), 60),
    "entrance": ("above the doors, along the hall to the west", (29.2, 8.2, 3.6), (16, 8.4, 1.0), 62),
    "benches": ("close to the western benches", (5.2, 6.2, 2.0), (10.4, 10.6, 0.9), 55),
    "desk": ("the reception desk from across the aisle", (8.4, 12.2, 2.6), (10.9, 17.4, 1.0), 62),
    "stairs": ("foot of the stairs and the gallery above", (16.2, 4.4, 2.4), (22.2, 13.2, 1.9), 60),
    "gallery": ("from the gallery down into the hall", (8.9, 15.0, 5.3), (12.2, 6.2, 0.3), 62),
    "cafe": ("the cafe corner from the middle of the hall", (18.9, 8.1, 2.3), (26.2, 2.4, 1.0), 55),
    "overhead": ("a ceiling camera straight above the middle", (12.4, 8.0, 6.4), (12.9, 8.1, 0), 80),
}
CAMERAS = [("lobby", (640, 480), 25), ("entrance", (640, 480), 25), ("gallery", (640, 480), 25)]
