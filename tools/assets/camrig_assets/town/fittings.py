"""What stands on pavements: trees, lamps, benches, bins, bollards, planters, signs, a fountain."""

import numpy as np

from .. import noise, shapes
from .builder import block, post, to_file


def _ball(columns=11, rows=7):
    rings = [
        shapes.ring(max(np.cos(a), 1e-5), max(np.cos(a), 1e-5), (0, np.sin(a), 0), columns)
        for a in np.linspace(-np.pi / 2, np.pi / 2, rows)
    ]
    return shapes.loft(rings)


def tree(builder, at, height, seed):
    """A trunk with a crown of many small uneven clumps."""
    random = np.random.default_rng(seed)
    x, y, z = at
    trunk = height * 0.42
    builder.add(post(0.15, trunk, at, 0.09, 9, 4), "plain", (0.115, 0.085, 0.062))
    for turn in np.linspace(0, 2 * np.pi, 5)[:-1] + random.uniform(0, 1):
        bend = [(x, y, z + trunk * 0.85), (x + 0.5 * np.cos(turn), y + 0.5 * np.sin(turn), z + trunk * 1.15)]
        bend.append((x + 1.0 * np.cos(turn), y + 1.0 * np.sin(turn), z + trunk * 1.5))
        builder.add(shapes.tube([to_file(p) for p in bend], 0.05, 6), "plain", (0.10, 0.075, 0.055))
    middle, reach = np.array([x, y, z + height * 0.70]), np.array([height * 0.29, height * 0.29, height * 0.29])
    ball = _ball()
    for k in range(34):
        # Clumps sit on the crown's hull, evenly by the golden angle.
        up = 1 - 2 * (k + 0.5) / 34
        turn = k * 2.39996
        out = np.array([np.sqrt(1 - up * up) * np.cos(turn), np.sqrt(1 - up * up) * np.sin(turn), up])
        place = middle + out * reach * random.uniform(0.55, 0.80)
        size = height * random.uniform(0.085, 0.135)
        clump = ball.moved(scale=(size, size * 0.85, size), yaw=random.uniform(0, 6))
        bumps = noise.fractal(clump.positions / (height * 0.05) + random.uniform(0, 50), 2, seed + k)
        clump.positions = clump.positions * (0.72 + 0.62 * bumps)[:, None]
        clump.normals = shapes.grid_normals(clump.positions.reshape(7, 12, 3), True).reshape(-1, 3)
        # Rounded towards the crown's outside, so that light falls on the tree and not on each clump alone.
        clump.normals = clump.normals * 0.6 + np.array(to_file(out)) * 0.6
        clump.normals /= np.maximum(np.linalg.norm(clump.normals, axis=1, keepdims=True), 1e-9)
        clump = clump.moved(to_file(place))
        inner = np.linalg.norm((clump.positions - to_file(middle)) / (height * 0.30), axis=1)
        leaf = np.array([0.095, 0.165, 0.042]) * random.uniform(0.85, 1.2)
        fleck = noise.fractal(clump.positions * 9, 2, seed)
        tone = leaf * (0.45 + 0.75 * noise.smoothstep(0.45, 1.1, inner) * (0.55 + 0.9 * fleck))[:, None]
        clump.uv = clump.uv * (3, 2)
        builder.add(clump, "leaves", tone * 1.45, shade=1.0)


def tree_grate(builder, at):
    x, y, z = at
    builder.add(block((x - 0.7, y - 0.7, z), (x + 0.7, y + 0.7, z + 0.012)), "plain", (0.05, 0.04, 0.032))
    for s in (-0.72, 0.66):
        builder.add(block((x - 0.72, y + s, z), (x + 0.72, y + s + 0.06, z + 0.03)), "metal", (0.09, 0.09, 0.09))
        builder.add(block((x + s, y - 0.72, z), (x + s + 0.06, y + 0.72, z + 0.03)), "metal", (0.09, 0.09, 0.09))


def lamp(builder, at, towards=(0, 1), height=5.6):
    """A street lamp; its arm reaches `towards` (unit, in the plane)."""
    x, y, z = at
    dark = (0.06, 0.065, 0.07)
    builder.add(post(0.11, 0.5, at, 0.09), "metal", dark)
    builder.add(post(0.065, height, at, 0.045, rows=3), "metal", dark)
    arm = [(x, y, z + height - 0.05), (x + 0.5 * towards[0], y + 0.5 * towards[1], z + height + 0.12)]
    arm.append((x + 1.2 * towards[0], y + 1.2 * towards[1], z + height + 0.14))
    builder.add(shapes.tube([to_file(p) for p in arm], 0.032), "metal", dark)
    head = np.array(arm[-1])
    builder.add(block(head - (0.28, 0.28, 0.05), head + (0.28, 0.28, 0.05)), "metal", (0.10, 0.105, 0.11))
    builder.add(block(head - (0.2, 0.2, 0.07), head + (0.2, 0.2, -0.045)), "plain", (0.85, 0.84, 0.78))


def bench(builder, at, along_x=True):
    x, y, z = at

    def piece(low, high, material, colour):
        if not along_x:
            low, high = (-high[1], low[0], low[2]), (-low[1], high[0], high[2])
        builder.add(block(np.add(low, at), np.add(high, at), cells=2), material, colour)

    wood = (0.26, 0.145, 0.07)
    for k in range(3):
        piece((-0.9, -0.24 + 0.165 * k, 0.42), (0.9, -0.10 + 0.165 * k, 0.46), "plain", wood)
    for k in range(2):
        piece((-0.9, 0.26, 0.55 + 0.15 * k), (0.9, 0.30, 0.67 + 0.15 * k), "plain", wood)
    for s in (-0.7, 0.62):
        piece((s, -0.22, 0), (s + 0.08, 0.28, 0.42), "metal", (0.07, 0.07, 0.075))
        piece((s, 0.27, 0.42), (s + 0.08, 0.33, 0.84), "metal", (0.07, 0.07, 0.075))


def bin_(builder, at):
    builder.add(post(0.21, 0.85, at, 0.23, 14), "metal", (0.045, 0.085, 0.07))
    x, y, z = at
    builder.add(post(0.24, 0.06, (x, y, z + 0.85), columns=14), "metal", (0.09, 0.09, 0.09))


def bollard(builder, at):
    x, y, z = at
    builder.add(post(0.065, 0.85, at, columns=10), "metal", (0.055, 0.057, 0.06))
    builder.add(post(0.068, 0.06, (x, y, z + 0.68), columns=10), "plain", (0.75, 0.75, 0.72))


def planter(builder, low, high, seed):
    """A stone trough with low plants."""
    random = np.random.default_rng(seed)
    (x0, y0, z0), (x1, y1, z1) = low, high
    builder.add(block(low, high, cells=2), "plain", (0.47, 0.45, 0.42))
    ball = _ball(10, 7)
    count = max(3, round((x1 - x0) * (y1 - y0) / 0.16))
    for k in range(count):
        size = random.uniform(0.16, 0.30)
        place = (random.uniform(x0 + 0.12, x1 - 0.12), random.uniform(y0 + 0.12, y1 - 0.12), z1 + size * 0.25)
        clump = ball.moved(scale=(size, size * 0.9, size), yaw=random.uniform(0, 6))
        clump.positions = clump.positions * (0.75 + 0.5 * noise.fractal(clump.positions * 9 + 7 * k, 2, seed))[:, None]
        clump = clump.moved(to_file(place))
        clump.uv = clump.uv * (2, 1)
        leaf = np.array([0.07, 0.15, 0.04]) if k % 4 else np.array([0.36, 0.09, 0.11])
        builder.add(clump, "leaves", leaf * random.uniform(0.8, 1.3))


def sign(builder, at, facing, colour, size=0.3):
    """A round traffic sign on a post; `facing` is the unit way it looks, in the plane."""
    x, y, z = at
    builder.add(post(0.03, 2.6, at), "metal", (0.35, 0.36, 0.36))
    turn = np.arctan2(facing[0], -facing[1])  # of the file's +z (world -y) towards `facing`
    face = shapes.disc(size, 24).moved(matrix=[[1, 0, 0], [0, 0, -1], [0, 1, 0]]).moved(yaw=turn)
    for grow, tone, out in ((1.0, colour, 0.04), (0.72, (0.85, 0.85, 0.83), 0.046)):
        plate = face.moved(scale=(grow,) * 3).moved(to_file((x + facing[0] * out, y + facing[1] * out, z + 2.3)))
        builder.add(plate, "paint", tone, shade=1.0)
    back = shapes.disc(size, 24).moved(matrix=[[1, 0, 0], [0, 0, 1], [0, -1, 0]]).moved(yaw=turn)
    builder.add(back.moved(to_file((x + facing[0] * 0.034, y + facing[1] * 0.034, z + 2.3))), "metal", (0.35, 0.36, 0.36))


def fountain(builder, at, radius=3.2):
    """A round basin with water, a bowl on a column."""
    x, y, z = at
    stone = (0.46, 0.44, 0.40)
    ring = lambda r, h: shapes.ring(r, r, (0, h, 0), 40)  # noqa: E731
    basin = [ring(radius, 0), ring(radius, 0.42), ring(radius + 0.06, 0.45), ring(radius + 0.06, 0.55), ring(radius - 0.32, 0.55)]
    basin += [ring(radius - 0.34, 0.30)]
    wet = (0.22, 0.21, 0.19)  # stone that water runs over is darker, and shines
    builder.add(shapes.loft(basin[:4]).moved(to_file(at)), "plain", stone)
    builder.add(shapes.loft(basin[3:]).moved(to_file(at)), "wet", wet)
    builder.add(shapes.disc(radius - 0.33, 40).moved(to_file((x, y, z + 0.38))), "glass", (0.10, 0.20, 0.23))
    profile = ((0.55, 0.3), (0.5, 0.5), (0.3, 0.7), (0.24, 1.3), (0.36, 1.5), (1.15, 1.72), (1.2, 1.82), (1.05, 1.80), (0.2, 1.66))
    profile += ((0.16, 2.25), (0.5, 2.4), (0.52, 2.46), (0.1, 2.42), (0.09, 2.75), (0.0001, 2.82))
    builder.add(shapes.loft([shapes.ring(r, r, (0, h, 0), 28) for r, h in profile]).moved(to_file(at)), "wet", wet)
