"""Paints textures in which every texel knows its place on the body, so that colours are functions of place.

Colours are sRGB 0..1. A painter takes (part, points, u, v) - the texels' places in metres and their way around (0 and 1
at the back) and down the part - and returns colours of the same shape.
"""

import numpy as np
from PIL import Image

from .. import noise
from ..noise import smoothstep

GUTTER = 2


def pack(parts, width):
    """Gives every part a rectangle of whole texels in an atlas of this width (tallest first, in shelves); returns
    the height used.
    """
    x = y = shelf = 0
    for part in sorted((p for p in parts if p.uses is None), key=lambda p: (-p.texels[1], -p.texels[0], p.name)):
        w, h = part.texels[0] + 2 * GUTTER, part.texels[1] + 2 * GUTTER
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        part.rect = (x + GUTTER, y + GUTTER, part.texels[0], part.texels[1])
        x, shelf = x + w, max(shelf, h)
    return y + shelf


def texture_coordinates(part, size):
    """TEXCOORD_0 of a part's vertices: texel centres of the rectangle's rim are the rim of the grid."""
    x, y, w, h = (part.uses or part).rect
    rows, columns = part.grid.shape[:2]
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(1, 0, rows))
    return np.stack([(x + 0.5 + u * (w - 1)) / size[0], (y + 0.5 + v * (h - 1)) / size[1]], axis=-1).reshape(-1, 2)


def sampled(grid, u, v):
    """Values of a vertex grid at (u, v), bilinear."""
    rows, columns = grid.shape[:2]
    c, r = np.clip(u, 0, 1) * (columns - 1), (1 - np.clip(v, 0, 1)) * (rows - 1)
    c0, r0 = np.minimum(c.astype(int), columns - 2), np.minimum(r.astype(int), rows - 2)
    fc, fr = (c - c0)[..., None], (r - r0)[..., None]
    return (grid[r0, c0] * (1 - fc) + grid[r0, c0 + 1] * fc) * (1 - fr) + (
        grid[r0 + 1, c0] * (1 - fc) + grid[r0 + 1, c0 + 1] * fc
    ) * fr


def along(part, v, key):
    """The part's own measure (table height, station) at v."""
    values = part.tags[key]
    return np.interp((1 - np.clip(v, 0, 1)) * (len(values) - 1), np.arange(len(values)), values)


def atlas(pieces, size):
    """The painted texture of all pieces' parts as a PIL image, each as its material wants it."""
    pixels = np.full((size[1], size[0], 3), 0.5)
    for piece, part in ((piece, part) for piece in pieces for part in piece.parts if part.uses is None):
        x, y, w, h = part.rect
        columns, rows = np.arange(-GUTTER, w + GUTTER), np.arange(-GUTTER, h + GUTTER)
        u, v = np.meshgrid(np.clip(columns / (w - 1), 0, 1), np.clip(rows / (h - 1), 0, 1))
        pixels[y - GUTTER : y + h + GUTTER, x - GUTTER : x + w + GUTTER] = piece.painted(
            np.clip(part.paint(part, sampled(part.grid, u, v), u, v), 0, 1)
        )
    return Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8), "RGB")


def rgb(text):
    """'#rrggbb' as sRGB numbers."""
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def folds(points, strength, seed, stretch=(9, 22, 9)):
    """Light and dark streaks of cloth, about -1..1 times `strength` (a number or one for every texel)."""
    warp = noise.fractal(points * 7, 2, seed + 50)[..., None] - 0.5
    field = noise.value(points * stretch + warp * (2.5, 5, 2.5), seed)
    fine = noise.value(points * np.array(stretch) * 2.1 + warp * 3, seed + 9)
    crease = 1 - np.abs(2 * field - 1) * 1.6 + 0.5 * (1 - np.abs(2 * fine - 1) * 1.6)
    return np.clip(crease, -1, 1) * strength


def cloth(points, colour, fold, seed, weave=0.035, spots=0.05):
    """A plain fabric: folds, slow unevenness and thread noise over one colour."""
    grain = noise.value(points * 420, seed + 3) - 0.5
    slow = noise.fractal(points * 6, 2, seed + 4) - 0.5
    light = 1 + 0.17 * fold + spots * 2 * slow + weave * 2 * grain
    lifted = np.asarray(colour) * light[..., None]
    return np.clip(lifted + 0.012 * (light[..., None] - 1), 0, 1)


def skin(points, tone, seed=1):
    blotch = noise.fractal(points * 30, 2, seed) - 0.5
    fine = noise.value(points * 300, seed + 2) - 0.5
    return (
        np.asarray(tone)
        * (1 + 0.06 * blotch + 0.03 * fine)[..., None]
        * (1 + np.array([0.015, -0.01, -0.01]) * blotch[..., None])
    )


def line(distance, width):
    """1 on a line, 0 from `width` away."""
    return 1 - smoothstep(0.4 * width, width, np.abs(distance))


def hair(points, colour, seed=7, direction=1):
    """Strands that run down (direction 1) or anyhow (0)."""
    stretch = (110, 9, 110) if direction else (60, 60, 60)
    strands = (
        noise.value(points * stretch, seed)
        - 0.5
        + 0.6 * (noise.value(points * np.array(stretch) * 2.3, seed + 1) - 0.5)
    )
    slow = noise.fractal(points * 14, 2, seed + 5) - 0.5
    return np.clip(np.asarray(colour) * (1 + 0.55 * strands + 0.35 * slow)[..., None] + 0.02 * strands[..., None], 0, 1)
