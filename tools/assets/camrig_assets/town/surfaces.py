"""Textures of ground and facades. One repeat covers the metres named beside each; colours are sRGB."""

import io

import numpy as np
from PIL import Image

from .. import images, noise

ASPHALT_M, PAVING_M = 4.0, 2.4
BAY_M, STOREY_M = 3.0, 3.2  # of a facade: one window
BAYS, STOREYS = 4, 4  # in one picture


def _grid(size):
    v, u = np.meshgrid(np.arange(size) / size, np.arange(size) / size, indexing="ij")
    return u, v


def _tiling(u, v, frequency, octaves, seed):
    """Noise that repeats with the picture: on a torus in four dimensions, folded into two looks in three."""
    a, b = u * 2 * np.pi, v * 2 * np.pi
    r = frequency / (2 * np.pi)
    first = noise.fractal(np.stack([r * np.cos(a) + 9, r * np.sin(a) + 9, r * np.cos(b) + 9], -1), octaves, seed)
    second = noise.fractal(np.stack([r * np.cos(b) + 5, r * np.sin(b) + 5, r * np.sin(a) + 5], -1), octaves, seed + 7)
    return (first + second) / 2


def _picture(rgb):
    return Image.fromarray((np.clip(rgb, 0, 1) * 255 + 0.5).astype(np.uint8), "RGB")


def asphalt():
    u, v = _grid(512)
    grain = np.random.default_rng(1).normal(0, 1, u.shape)
    tone = 0.36 + 0.16 * (_tiling(u, v, 5, 3, 1) - 0.5) + 0.022 * grain
    crack = np.abs(_tiling(u, v, 7, 3, 11) - 0.5)
    tone = tone * (1 - 0.12 * noise.smoothstep(0.006, 0.0, crack))
    return images.jpeg(_picture(tone[..., None] * np.array([0.99, 1.0, 1.02])), 85), "image/jpeg"


def paving():
    """Slabs of 0.6 m x 0.4 m in running bond."""
    u, v = _grid(512)
    row = np.floor(v * PAVING_M / 0.4)
    along = u * PAVING_M / 0.6 + 0.5 * (row % 2)
    column = np.floor(along) % 4
    edge_u = np.minimum(along % 1, 1 - along % 1) * 0.6
    edge_v = np.minimum(v * PAVING_M / 0.4 % 1, 1 - v * PAVING_M / 0.4 % 1) * 0.4
    joint = noise.smoothstep(0.012, 0.005, np.minimum(edge_u, edge_v))
    slab = np.random.default_rng(2).uniform(-1, 1, (6, 4))[row.astype(int) % 6, column.astype(int)]
    tone = 0.66 + 0.05 * slab + 0.10 * (_tiling(u, v, 6, 3, 3) - 0.5)
    tone = tone + 0.015 * np.random.default_rng(3).normal(0, 1, u.shape)
    tone = tone * (1 - 0.35 * joint)
    return images.jpeg(_picture(tone[..., None] * np.array([1.0, 0.97, 0.92])), 85), "image/jpeg"


def setts():
    """Small granite stones, 0.2 m."""
    u, v = _grid(512)
    row = np.floor(v * 12)
    along = u * 12 + 0.5 * (row % 2)
    wobble = 0.25 * (_tiling(u, v, 14, 2, 21) - 0.5)
    edge = np.minimum(
        np.minimum((along + wobble) % 1, 1 - (along + wobble) % 1),
        np.minimum((v * 12 + wobble) % 1, 1 - (v * 12 + wobble) % 1),
    )
    stone = np.random.default_rng(4).uniform(-1, 1, (12, 12))
    tone = 0.55 + 0.07 * stone[row.astype(int) % 12, np.floor(along).astype(int) % 12]
    tone = tone + 0.08 * (_tiling(u, v, 20, 2, 5) - 0.5)
    tone = tone * (1 - 0.42 * noise.smoothstep(0.16, 0.05, edge))
    return images.jpeg(_picture(tone[..., None] * np.array([1.0, 0.98, 0.95])), 85), "image/jpeg"


def grass():
    u, v = _grid(256)
    blades = np.random.default_rng(5).normal(0, 1, u.shape)
    tone = 1 + 0.5 * (_tiling(u, v, 6, 3, 6) - 0.5) + 0.10 * blades
    return images.jpeg(_picture(tone[..., None] * np.array([0.33, 0.44, 0.20])), 85), "image/jpeg"


def leaves():
    """Overlapping leaves with gaps between them, grey: the vertices colour them."""
    size = 256
    y, x = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    tone, alpha = np.full((size, size), 0.35), np.zeros((size, size))
    random = np.random.default_rng(8)
    for _ in range(520):
        cx, cy, turn = random.uniform(0, size), random.uniform(0, size), random.uniform(0, np.pi)
        dx, dy = ((v - c + size / 2) % size - size / 2 for v, c in ((x, cx), (y, cy)))
        along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
        inside = (along / 11) ** 2 + (across / (5.2 * (1.05 - along / 22))) ** 2 < 1
        shade = random.uniform(0.55, 1.0) * (1 - 0.25 * (np.abs(across) < 0.8))
        tone = np.where(inside, shade, tone)
        alpha = np.maximum(alpha, inside)
    rgba = np.dstack([tone, tone, tone, alpha])
    out = io.BytesIO()
    Image.fromarray((rgba * 255 + 0.5).astype(np.uint8), "RGBA").save(out, "PNG", optimize=True)
    return out.getvalue(), "image/png"


def facade(seed, wall, kind="plaster", frame="#e8e4da", trim=None):
    """BAYS x STOREYS windows in a wall. `kind`: plaster, brick or panels."""
    per_bay = 128
    width, height = per_bay * BAYS, per_bay * STOREYS
    x, y = np.meshgrid((np.arange(width) + 0.5) / per_bay, (np.arange(height) + 0.5) / per_bay)
    random = np.random.default_rng(seed)
    base = np.array([int(wall[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    edge = np.array([int(frame[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    u, v = x / BAYS, y / STOREYS
    dirt = 1 + 0.16 * (_tiling(u, v, 8, 3, seed) - 0.5)
    rgb = dirt[..., None] * base
    if kind == "brick":
        row = np.floor(y * 40)
        along = x * 13 + 0.5 * (row % 2)
        brick = random.uniform(-1, 1, (160, 52))[row.astype(int) % 160, np.floor(along).astype(int) % 52]
        rgb = rgb * (1 + 0.13 * brick)[..., None]
        joint = (np.minimum(along % 1, 1 - along % 1) < 0.05) | ((y * 40) % 1 < 0.16)
        rgb = np.where(joint[..., None], rgb * 0.6 + 0.25 * np.array([0.8, 0.78, 0.74]), rgb)
    if kind == "panels":
        seam = (np.minimum(x % 1, 1 - x % 1) < 0.012) | (np.minimum(y % 1, 1 - y % 1) < 0.012)
        rgb = np.where(seam[..., None], rgb * 0.6, rgb)
    half = {"plaster": 0.20, "brick": 0.21, "panels": 0.34}[kind]  # of a window, in bays
    top, bottom = (0.20, 0.80) if kind != "panels" else (0.16, 0.84)
    fx, fy = x % 1, y % 1
    inside = lambda grow: (np.abs(fx - 0.5) < half + grow) & (fy > top - grow) & (fy < bottom + grow)  # noqa: E731
    surround = np.clip(base * 1.16 + 0.05, 0, 1) if trim is None else np.array(
        [int(trim[i : i + 2], 16) for i in (1, 3, 5)]
    ) / 255
    rgb = np.where(inside(0.055)[..., None], surround * dirt[..., None], rgb)
    rgb = np.where(inside(0.022)[..., None], edge, rgb)
    # Glass: the sky above, the other side of the street below; some have curtains or blinds.
    sky = noise.smoothstep(bottom, top, fy)
    glass = noise.mix(np.array([0.10, 0.12, 0.14]), np.array([0.42, 0.52, 0.62]), 0.15 + 0.75 * sky)
    glass = glass * (1 + 0.5 * (_tiling(u, v, 10, 2, seed + 3) - 0.5))[..., None]
    state = random.uniform(0, 1, (STOREYS, BAYS))[np.floor(y).astype(int) % STOREYS, np.floor(x).astype(int) % BAYS]
    curtain = (state > 0.55) & (np.abs(fx - 0.5) > half * 0.45)
    glass = np.where(curtain[..., None], glass * 0.3 + 0.50 * np.array([0.93, 0.91, 0.85]), glass)
    blind = (state < 0.22) & (fy < top + (bottom - top) * (0.3 + 2.2 * state))
    glass = np.where(blind[..., None], 0.62 * np.array([0.94, 0.92, 0.86]), glass)
    recess = noise.smoothstep(0.0, 0.035, fy - top) * noise.smoothstep(0.0, 0.03, fx - 0.5 + half)
    glass = glass * (0.45 + 0.55 * recess)[..., None]
    bars = (np.abs(fx - 0.5) < 0.014) | ((kind != "panels") & (np.abs(fy - (top + 0.3 * (bottom - top))) < 0.012))
    glass = np.where(bars[..., None], edge, glass)
    rgb = np.where(inside(0)[..., None], glass, rgb)
    sill = (np.abs(fx - 0.5) < half + 0.08) & (fy > bottom + 0.02) & (fy < bottom + 0.06)
    rgb = np.where(sill[..., None], surround * 0.95, rgb)
    stain = (np.abs(fx - 0.5) < half + 0.06) & (fy >= bottom + 0.06)
    fade = 1 - 0.18 * stain * noise.smoothstep(bottom + 0.2, bottom + 0.06, fy)
    return images.jpeg(_picture(rgb * fade[..., None]), 85), "image/jpeg"


def materials():
    """All of them, for Builder."""
    walls = {
        "brick": facade(31, "#9c5a45", "brick", trim="#d6cbb8"),
        "cream": facade(32, "#d9c9a4", "plaster", "#f2efe8"),
        "blue": facade(33, "#9fb0bd", "plaster", "#f0f0ee", trim="#e6e2d8"),
        "ochre": facade(34, "#c99a5b", "plaster", "#5b4632", trim="#e3d2b4"),
        "office": facade(35, "#b8bab8", "panels", "#3b4046"),
        "white": facade(36, "#dcdad2", "plaster", "#44494c", trim="#c8c4ba"),
    }
    ground = {"asphalt": asphalt(), "paving": paving(), "setts": setts(), "grass": grass()}
    textured = {name: {"texture": texture, "roughness": 0.9} for name, texture in {**walls, **ground}.items()}
    plain = {
        "plain": {"roughness": 0.85},
        "metal": {"roughness": 0.45, "metallic": 0.0},
        "leaves": {"roughness": 0.95, "texture": leaves(), "alpha": "MASK", "cutoff": 0.5, "double_sided": True},
        "glass": {"roughness": 0.08, "base": (0.9, 0.95, 1.0)},
        "wet": {"roughness": 0.18},
        "paint": {"roughness": 0.7},
    }
    return {**textured, **plain}


def scaled(mesh, metres):
    """The mesh with texture coordinates in repeats in place of metres; v down, as pictures are."""
    u, v = metres if isinstance(metres, tuple) else (metres, metres)
    mesh.uv = mesh.uv / np.array([u, v]) * (1, -1)
    return mesh
