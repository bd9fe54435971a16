"""Textures of the hall's surfaces, painted: floor, plaster, concrete, ceiling, wood, and the street outside."""

import numpy as np
from PIL import Image, ImageFilter

from .. import noise
from ..noise import mix, smoothstep


def image_of(pixels):
    return Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8), "RGB")


def _grid(size, metres):
    """Texel places in metres, and the same on a torus so that the noise repeats with the texture: (x, y, function
    seamless).
    """
    y, x = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")

    def seamless(cells, seed, octaves=2):
        total, weight = 0.0, 0.0
        for octave in range(octaves):
            n = cells * 2**octave
            fx, fy = x * n, y * n
            value = 0.0
            ix, iy = np.floor(fx).astype(int), np.floor(fy).astype(int)
            tx, ty = fx - ix, fy - iy
            tx, ty = tx * tx * (3 - 2 * tx), ty * ty * (3 - 2 * ty)
            for dx in (0, 1):
                for dy in (0, 1):
                    w = (tx if dx else 1 - tx) * (ty if dy else 1 - ty)
                    value = value + w * noise._lattice((ix + dx) % n, (iy + dy) % n, np.zeros_like(ix), seed + octave)
            total, weight = total + value / 2**octave, weight + 1 / 2**octave
        return total / weight

    return x * metres, y * metres, seamless


def floor(size=1024, metres=4.8, tile=0.8):
    """Large stone slabs: every slab a little different, fine speckles, narrow grey joints."""
    x, y, seamless = _grid(size, metres)
    ix, iy = (x / tile).astype(int), (y / tile).astype(int)
    shade = noise._lattice(ix, iy, np.zeros_like(ix), 5) - 0.5
    warm = noise._lattice(ix, iy, np.ones_like(ix), 6) - 0.5
    cloud, speck = seamless(12, 11, 4) - 0.5, seamless(256, 17, 1) - 0.5
    flake = smoothstep(0.80, 0.90, seamless(200, 23, 1)) - smoothstep(0.82, 0.92, seamless(190, 29, 1))
    colour = np.array([0.745, 0.718, 0.675]) * (1 + 0.075 * shade + 0.085 * cloud + 0.07 * speck + 0.07 * flake)[
        ..., None
    ] + warm[..., None] * np.array([0.012, 0.002, -0.012])
    edge = np.minimum.reduce([x % tile, y % tile, tile - x % tile, tile - y % tile])
    joint = smoothstep(0.0060, 0.0030, edge)
    colour = mix(colour, np.array([0.50, 0.485, 0.465]), joint * 0.85)
    colour = colour * (1 - 0.03 * smoothstep(0.02, 0.005, edge))[..., None]
    strip = smoothstep(
        0.078, 0.072, np.minimum.reduce([x, y, metres - x, metres - y])
    )  # dark granite along the 4.8 m grid
    dark = np.array([0.40, 0.39, 0.385]) * (1 + 0.10 * cloud + 0.25 * speck)[..., None]
    return image_of(mix(colour, dark, strip * 0.9))


def plaster(size=256, metres=3.0):
    _, _, seamless = _grid(size, metres)
    return image_of(
        np.array([0.905, 0.893, 0.868])
        * (1 + 0.020 * (seamless(5, 3, 3) - 0.5) + 0.035 * (seamless(110, 9, 1) - 0.5))[..., None]
    )


def concrete(size=512, metres=2.4):
    """Fair-faced concrete: cloudy, pin holes, panel joints with tie holes."""
    x, y, seamless = _grid(size, metres)
    colour = (
        np.array([0.705, 0.695, 0.675])
        * (
            1
            + 0.16 * (seamless(4, 31, 4) - 0.5)
            + 0.05 * (seamless(128, 37, 1) - 0.5)
            - 0.10 * smoothstep(0.90, 0.95, seamless(90, 41, 1))
        )[..., None]
    )
    edge = np.minimum(x % 2.4, y % 1.2)
    colour = colour * (1 - 0.22 * smoothstep(0.012, 0.006, edge))[..., None]
    hole = np.hypot((x % 1.2) - 0.6, (y % 1.2) - 0.3)
    return image_of(colour * (1 - 0.45 * smoothstep(0.022, 0.016, hole))[..., None])


def ceiling(size=256, metres=2.4):
    """Perforated white panels of 1.2 m x 0.6 m."""
    x, y, seamless = _grid(size, metres)
    edge = np.minimum.reduce([x % 1.2, y % 0.6])
    return image_of(
        np.array([0.90, 0.90, 0.89])
        * (1 + 0.02 * (seamless(60, 5, 1) - 0.5) - 0.20 * smoothstep(0.020, 0.010, edge))[..., None]
    )


def wood(x, y, seed, base=(0.63, 0.44, 0.27)):
    grain = noise.fractal(
        np.stack([x * 3 + 0.4 * noise.value(np.stack([x * 2, y * 6, x * 0], -1), seed), y * 42, x * 0 + seed], -1),
        3,
        seed,
    )
    fine = noise.value(np.stack([x * 22, y * 380, x * 0], -1), seed + 3)
    return np.array(base) * (1 + 0.45 * (grain - 0.5) + 0.15 * (fine - 0.5))[..., None]


def slats(size=512, metres=1.6):
    """Vertical wooden slats with dark gaps."""
    x, y, _ = _grid(size, metres)
    number = np.floor(x / 0.10).astype(int)
    tone = noise._lattice(number % 16, number * 0, number * 0, 3) - 0.5
    colour = wood(y, x + number * 1.7, 4) * (1 + 0.22 * tone)[..., None]
    place = x % 0.10
    gap = smoothstep(0.070, 0.076, place)
    round_ = 0.80 + 0.20 * np.sin(np.clip(place / 0.073, 0, 1) * np.pi)
    return image_of(mix(colour * round_[..., None], np.array([0.07, 0.05, 0.035]), gap))


def outside(width=1024, height=384):
    """What the windows show: hazy sky, a row of facades and trees, pavement; far enough to be soft."""
    y, x = np.meshgrid(np.linspace(0, 1, height), np.linspace(0, 1, width), indexing="ij")
    sky = mix(
        np.broadcast_to(np.array([0.66, 0.79, 0.93]), (height, width, 3)),
        np.array([0.93, 0.95, 0.96]),
        smoothstep(0.0, 0.60, y),
    )
    cloud = smoothstep(0.48, 0.75, noise.fractal(np.stack([x * 9, y * 12, x * 0], -1), 4, 71))
    out = mix(sky, np.array([0.98, 0.98, 0.98]), 0.75 * cloud * smoothstep(0.62, 0.2, y))
    house = np.floor(x * 9 + 0.15 * np.sin(x * 23)).astype(int)
    roof = 0.40 + 0.10 * noise._lattice(house, house * 0, house * 0, 8)
    tint = noise._lattice(house, house * 0, house * 0, 9)[..., None]
    wall = mix(np.broadcast_to(np.array([0.80, 0.73, 0.64]), out.shape), np.array([0.66, 0.66, 0.68]), tint[..., 0])
    wx, wy = (x * 72) % 1, (y * 26) % 1
    pane = (np.abs(wx - 0.5) < 0.24) & (np.abs(wy - 0.5) < 0.28)
    wall = np.where(
        pane[..., None],
        np.array([0.42, 0.49, 0.56])
        + 0.12 * (noise._lattice((x * 72).astype(int), (y * 26).astype(int), house, 4)[..., None] - 0.5),
        wall,
    )
    out = mix(
        out,
        mix(wall, np.array([0.88, 0.91, 0.94]), np.full((height, width), 0.25)),
        smoothstep(-0.002, 0.004, y - roof) * smoothstep(0.735, 0.73, y),
    )
    crown = noise.fractal(np.stack([x * 26, y * 10, x * 0], -1), 4, 12)
    trees = smoothstep(0.02, 0.10, crown - 0.44 - 1.7 * np.abs(y - 0.60) ** 1.2) * (
        noise.value(np.stack([x * 7, y * 0, y * 0], -1), 44) > 0.42
    )
    leaf = (
        np.array([0.40, 0.52, 0.27])
        * (0.65 + 0.7 * noise.fractal(np.stack([x * 160, y * 60, x * 0], -1), 2, 55))[..., None]
    )
    out = mix(out, leaf, trees * 0.92)
    out = mix(out, np.array([0.64, 0.63, 0.61]) * (0.90 + 0.2 * y)[..., None], smoothstep(0.725, 0.735, y))
    out = mix(out, np.array([0.50, 0.50, 0.51]), smoothstep(0.80, 0.81, y) * smoothstep(0.90, 0.89, y))
    car = (
        (y > 0.765)
        & (y < 0.845)
        & (np.abs((x * 5.3) % 1 - 0.5) < 0.15)
        & (noise._lattice((x * 5.3).astype(int), house * 0, house * 0, 77) > 0.35)
    )
    body = mix(
        np.broadcast_to(np.array([0.72, 0.73, 0.75]), out.shape),
        np.array([0.46, 0.14, 0.13]),
        noise._lattice((x * 5.3).astype(int), house * 0, house * 0, 78),
    )
    out = np.where(car[..., None], np.where((y < 0.80)[..., None], np.array([0.25, 0.29, 0.33]), body), out)
    out = 1 - (1 - out) * 0.82  # overexposed, as a street is from indoors
    return image_of(out).filter(ImageFilter.GaussianBlur(1.6))
