"""Arms, legs, hands and shoes of one person, each with sleeves or trousers of its own width."""

import numpy as np

from ..noise import smoothstep
from .parts import Part, ring_at, table

# way along the arm (0 shoulder joint, 1 elbow, 2 wrist), radius across, front, back
ARM = [
    (-0.115, 0.004, 0.004, 0.004),
    (-0.095, 0.026, 0.030, 0.030),
    (-0.04, 0.044, 0.050, 0.052),
    (0.08, 0.054, 0.060, 0.061),
    (0.25, 0.052, 0.057, 0.057),
    (0.55, 0.046, 0.051, 0.050),
    (0.85, 0.041, 0.043, 0.043),
    (1.0, 0.041, 0.041, 0.044),
    (1.15, 0.043, 0.044, 0.043),
    (1.35, 0.041, 0.043, 0.040),
    (1.7, 0.031, 0.034, 0.031),
    (2.0, 0.023, 0.029, 0.028),
    (2.08, 0.022, 0.030, 0.029),
]
# height, half width, front, back
LEG = [
    (0.05, 0.034, 0.036, 0.046),
    (0.10, 0.034, 0.036, 0.046),
    (0.18, 0.039, 0.041, 0.052),
    (0.28, 0.049, 0.046, 0.066),
    (0.37, 0.054, 0.050, 0.073),
    (0.45, 0.052, 0.054, 0.060),
    (0.50, 0.056, 0.062, 0.056),
    (0.56, 0.060, 0.066, 0.062),
    (0.65, 0.069, 0.076, 0.072),
    (0.75, 0.080, 0.086, 0.086),
    (0.83, 0.088, 0.092, 0.100),
    (0.90, 0.088, 0.092, 0.112),
    (0.96, 0.078, 0.085, 0.104),
]


def arm_frame(shaper, side, t):
    """Place on the arm's axis at t (0 shoulder, 1 elbow, 2 wrist) and the direction back up the arm; not scaled."""
    places = [shaper.rig.at(f"{side}_{n}") / shaper.s for n in ("upper_arm", "forearm", "hand")]
    first, second = places[1] - places[0], places[2] - places[1]
    point = places[0] + first * min(t, 1) + second * max(t - 1, 0)
    bend = smoothstep(0.85, 1.15, t)
    up = -(first / np.linalg.norm(first) * (1 - bend) + second / np.linalg.norm(second) * bend)
    return point, up


def arm(shaper, name, side, from_t, to_t, ease, columns=9, cuff=0.0, stations=None, **keywords):
    """A sleeve or bare arm between two stations, `ease` off the skin; `cuff` closes the lower end inwards."""
    ts = stations if stations is not None else [-0.115, -0.095, -0.04, 0.08, 0.28, 0.60, 0.86, 1.0, 1.14, 1.4, 1.7, 2.0]
    ts = np.array([t for t in ts if from_t <= t < to_t - 0.03] + [to_t])
    thick = 1 + 0.10 * shaper.build.weight - 0.14 * shaper.build.female
    rows, kept = [], []
    for t in ts[::-1]:
        point, up = arm_frame(shaper, side, t)
        half, front, back = table(ARM, t) * thick
        off = ease(t) if callable(ease) else ease
        off *= smoothstep(-0.125, -0.03, t)
        rows.append(ring_at(point, up, half + off, front + off, back + off, columns, 2.2))
        kept.append(t)
    if cuff:
        middle = rows[0][:-1].mean(axis=0)
        rows.insert(0, middle + (rows[0] - middle) * (1 - cuff) + 0.008 * arm_frame(shaper, side, to_t)[1])
        kept.insert(0, kept[0])
    w = shaper.blank(len(kept), columns)
    for row, t in enumerate(kept):
        fore, hand = smoothstep(0.84, 1.16, t), smoothstep(1.88, 2.04, t)
        top = 1 - smoothstep(-0.25, 0.22, t)
        w[row, :, shaper.j(f"{side}_hand")] = hand
        w[row, :, shaper.j(f"{side}_forearm")] = fore * (1 - hand)
        w[row, :, shaper.j(f"{side}_shoulder")] = 0.45 * top
        w[row, :, shaper.j("chest")] = 0.12 * top
        w[row, :, shaper.j(f"{side}_upper_arm")] = (1 - fore) * (1 - 0.57 * top)
    grid = np.array(rows) * shaper.s
    return Part(name, grid, w, tags={"stations": np.array(kept), "side": side}, **keywords)


def leg(shaper, name, side, heights, ease, columns=12, power=2.1, cuff=0.0, **keywords):
    """A trouser leg or bare leg over the table's heights (rising)."""
    sign = 1 if side == "left" else -1
    hip, knee, foot = (shaper.rig.at(f"{side}_{n}") / shaper.s for n in ("thigh", "shin", "foot"))
    thick = 1 + 0.10 * shaper.build.weight
    rows, kept = [], list(heights)
    for y in heights:
        half, front, back = table(LEG, y) * thick
        off = np.asarray(ease(y) if callable(ease) else ease) * np.ones(3)  # across, front, back
        lifted = shaper.lift(y)
        axis = (
            foot + (knee - foot) * min(lifted / knee[1], 1)
            if lifted < knee[1]
            else knee + (hip - knee) * (lifted - knee[1]) / (hip[1] - knee[1])
        )
        axis = np.array([axis[0], lifted, axis[2]])
        rows.append(ring_at(axis, (0, 1, 0), half + off[0], front + off[1], back + off[2], columns, power))
    if cuff:
        middle = rows[0][:-1].mean(axis=0)
        rows.insert(0, middle + (rows[0] - middle) * (1 - cuff) + (0, 0.012, 0))
        kept.insert(0, kept[0])
    grid = np.array(rows) * shaper.s
    w = shaper.blank(len(kept), columns)
    for row, y in enumerate(kept):
        shin = 1 - smoothstep(0.43, 0.57, y)
        foot_part = (1 - smoothstep(0.05, 0.12, y)) * 0.85
        x = grid[row, :, 0] / shaper.s * sign
        hips = smoothstep(0.78, 0.97, y) * (0.75 + 0.25 * smoothstep(0.06, -0.01, x))
        w[row, :, shaper.j(f"{side}_foot")] = shin * foot_part
        w[row, :, shaper.j(f"{side}_shin")] = shin * (1 - foot_part)
        w[row, :, shaper.j("hips")] = (1 - shin) * hips
        w[row, :, shaper.j(f"{side}_thigh")] = (1 - shin) * (1 - hips)
    return Part(name, grid, w, tags={"heights": np.array(kept), "side": side}, **keywords)


# where along the palm's breadth (forward), length from the wrist, radius at the knuckle
FINGERS = ((0.0285, 0.172, 0.0088), (0.0100, 0.182, 0.0092), (-0.0085, 0.174, 0.0088), (-0.0260, 0.152, 0.0078))


def hand(shaper, name, side, paint):
    """A palm, four fingers and a thumb, slightly curled; the palm looks at the thigh."""
    sign = 1 if side == "left" else -1
    wrist, up = arm_frame(shaper, side, 2.0)
    size = 0.94 if shaper.build.female else 1.0

    def axis(way, bend=1.0):
        curl = 0.030 * (way / 0.18) ** 2 * bend + 0.004
        return wrist - up * way * size + np.array([-sign * curl, 0, 0.004 + 0.02 * way])

    def made(part, count, columns, texels):
        return shaper.fixed(
            Part(name + part, count * shaper.s, shaper.blank(len(count), columns), texels, paint, tags={"side": side}),
            f"{side}_hand",
        )

    rows = [
        (0.108, 0.006, 0.030),
        (0.103, 0.0125, 0.038),
        (0.085, 0.0150, 0.041),
        (0.045, 0.018, 0.036),
        (0.012, 0.020, 0.028),
        (-0.012, 0.020, 0.027),
    ]
    palm = [ring_at(axis(way), up, thick * size, broad * size, broad * size * 0.95, 8, 2.6) for way, thick, broad in rows]
    parts = [made("", np.array(palm), 8, (40, 32))]
    for number, (aside, length, radius) in enumerate(FINGERS):
        bend = 1.0 + 0.25 * number
        rings = []
        for share, thick in ((1.0, 0.25), (0.93, 0.72), (0.55, 0.95), (0.0, 1.0)):
            way = 0.092 + (length - 0.092) * share
            centre = axis(way, bend) + np.array([0, 0, aside * (1 + 0.12 * share)]) * size
            rings.append(ring_at(centre, up, radius * thick * size, radius * thick * size, radius * thick * size, 5))
        parts.append(made(f"_finger_{number}", np.array(rings), 5, (12, 20)))
        if number:
            parts[-1].uses = parts[1]
    start = wrist - up * 0.030 * size + np.array([-sign * 0.006, 0, 0.022])
    heading = -up * 0.80 + np.array([-sign * 0.28, 0, 0.55])
    heading /= np.linalg.norm(heading)
    thumb = [
        ring_at(start + heading * way * size, -heading, r * size, r * size, r * size, 5)
        for way, r in ((0.075, 0.003), (0.069, 0.008), (0.045, 0.0105), (0.0, 0.013))
    ]
    return parts + [made("_thumb", np.array(thumb), 5, (16, 16))]


def shoe(shaper, name, side, paint, top=0.085, sole=0.018, length=1.0, width=1.0, pointed=0.0):
    """A shoe from heel to toe: rings stand upright along the foot; the sole is flat on the ground."""
    sign = 1 if side == "left" else -1
    ankle = shaper.rig.at(f"{side}_foot") / shaper.s
    size = 1 - 0.06 * shaper.build.female
    # z from the ankle, half width at the ground, height, width of the top against the ground
    rows = [
        (-0.072, 0.0, 0.030, 0.8),
        (-0.067, 0.022, top * 0.85, 0.8),
        (-0.045, 0.033, top, 0.88),
        (0.015, 0.036, top * 0.98, 0.87),
        (0.065, 0.042, 0.068, 0.72),
        (0.110, 0.046, 0.052, 0.70),
        (0.150, 0.043 * (1 - 0.12 * pointed), 0.041, 0.72),
        (0.180, 0.031 * (1 - 0.38 * pointed), 0.031, 0.68),
        (0.195 + 0.01 * pointed, 0.014 * (1 - 0.4 * pointed), 0.022, 0.6),
        (0.199 + 0.012 * pointed, 0.0, 0.014, 0.5),
    ]
    shape = np.array(
        [
            (0.0, 0.0),
            (-0.98, 0.0),
            (-1.03, 0.20),
            (-0.95, 0.50),
            (-0.55, 0.92),
            (0.0, 1.0),
            (0.55, 0.92),
            (0.95, 0.50),
            (1.03, 0.20),
            (0.98, 0.0),
            (0.0, 0.0),
        ]
    )
    grid, w = [], shaper.blank(len(rows), len(shape) - 1)
    for row, (z, half, high, taper) in enumerate(rows):
        inward = -sign * 0.006 * smoothstep(0.02, 0.19, z)
        x = shape[:, 0] * half * width * size * (1 - (1 - taper) * shape[:, 1] ** 2)
        grid.append(
            np.stack(
                [ankle[0] + inward + x, shape[:, 1] * high, np.full(len(shape), ankle[2] + z * length * size)], axis=1
            )
        )
        toes = smoothstep(0.095, 0.150, z)
        w[row, :, shaper.j(f"{side}_toes")], w[row, :, shaper.j(f"{side}_foot")] = toes, 1 - toes
    grid = np.array(grid)[::-1] * shaper.s  # rows run from the toe back, so that the columns turn the right way round
    return Part(name, grid, w[::-1].copy(), (48, 64), paint, tags={"side": side, "sole": sole})
