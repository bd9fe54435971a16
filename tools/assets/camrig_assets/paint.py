"""Paints the people's textures: every texel knows its place on the body, so that colours are functions of place.

Colours are sRGB 0..1. A painter takes (part, points, u, v) - the texels' places in metres and their way around (0 and 1 at the
back) and down the part - and returns colours of the same shape.
"""

import io

import numpy as np
from PIL import Image

from . import noise
from .noise import mix, smoothstep

GUTTER = 2


def pack(parts, width):
    """Gives every part a rectangle of whole texels in an atlas of this width (tallest first, in shelves); returns the height used."""
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
    return (grid[r0, c0] * (1 - fc) + grid[r0, c0 + 1] * fc) * (1 - fr) + (grid[r0 + 1, c0] * (1 - fc) + grid[r0 + 1, c0 + 1] * fc) * fr


def along(part, v, key):
    """The part's own measure (table height, station) at v."""
    values = part.tags[key]
    return np.interp((1 - np.clip(v, 0, 1)) * (len(values) - 1), np.arange(len(values)), values)


def atlas(parts, size):
    """The painted texture as a PIL image."""
    pixels = np.full((size[1], size[0], 3), 0.5)
    for part in parts:
        if part.uses is not None:
            continue
        x, y, w, h = part.rect
        columns, rows = np.arange(-GUTTER, w + GUTTER), np.arange(-GUTTER, h + GUTTER)
        u, v = np.meshgrid(np.clip(columns / (w - 1), 0, 1), np.clip(rows / (h - 1), 0, 1))
        pixels[y - GUTTER:y + h + GUTTER, x - GUTTER:x + w + GUTTER] = part.paint(part, sampled(part.grid, u, v), u, v)
    return Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8), "RGB")


def jpeg(image, quality=88):
    out = io.BytesIO()
    image.save(out, "JPEG", quality=quality, subsampling=0)
    return out.getvalue()


def rgb(text):
    """'#rrggbb' as sRGB numbers."""
    return np.array([int(text[i:i + 2], 16) for i in (1, 3, 5)]) / 255


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
    return np.asarray(tone) * (1 + 0.06 * blotch + 0.03 * fine)[..., None] * (1 + np.array([0.015, -0.01, -0.01]) * blotch[..., None])


def line(distance, width):
    """1 on a line, 0 from `width` away."""
    return 1 - smoothstep(0.4 * width, width, np.abs(distance))


def hair(points, colour, seed=7, direction=1):
    """Strands that run down (direction 1) or anyhow (0)."""
    stretch = (110, 9, 110) if direction else (60, 60, 60)
    strands = noise.value(points * stretch, seed) - 0.5 + 0.6 * (noise.value(points * np.array(stretch) * 2.3, seed + 1) - 0.5)
    slow = noise.fractal(points * 14, 2, seed + 5) - 0.5
    return np.clip(np.asarray(colour) * (1 + 0.55 * strands + 0.35 * slow)[..., None] + 0.02 * strands[..., None], 0, 1)


def face(head, tone, hair_colour, look):
    """Painter of the head: skin, eyes, brows, mouth, beard and the ground of the hair."""
    eye_colour = rgb(look.get("eyes", "#4a3728"))
    brow = rgb(look["brows"]) if "brows" in look else np.asarray(hair_colour) * 0.7
    tone = np.asarray(tone)

    def paint(part, points, u, v):
        local = (points / head.shaper.s - head.chin) / head.size
        x, y, z = np.abs(local[..., 0]), local[..., 1], local[..., 2]
        colour = skin(points, tone)
        front = smoothstep(0.015, 0.05, z)
        if "ear" in part.name:
            return colour * np.array([0.97, 0.90, 0.89]) * (0.88 + 0.12 * smoothstep(0.0, 0.5, np.abs(v - 0.5) * 2))[..., None]

        def spot(px, py, wx, wy):
            return np.exp(-((x - px) / wx) ** 2 - ((y - py) / wy) ** 2) * front

        flush = 0.55 * spot(0.046, 0.080, 0.020, 0.016) + 0.5 * spot(0, 0.076, 0.012, 0.010) + 0.2 * spot(0.03, 0.015, 0.03, 0.02)
        colour = colour * (1 - flush[..., None] * np.array([0.02, 0.13, 0.12]) * (0.6 + look.get("flush", 0.5)))
        shade = 0.20 * spot(0.020, 0.114, 0.010, 0.010) + 0.10 * spot(0.032, 0.103, 0.016, 0.004) + 0.16 * spot(0, 0.063, 0.012, 0.004) + 0.10 * spot(0, 0.030, 0.016, 0.005)
        shade = shade + 0.14 * spot(0.0155, 0.076, 0.004, 0.008) + 0.12 * smoothstep(0.004, -0.012, y) + 0.12 * spot(0.034, 0.122, 0.018, 0.004)
        light = 0.10 * spot(0, 0.092, 0.005, 0.016) + 0.06 * spot(0.030, 0.093, 0.016, 0.006) + 0.05 * spot(0, 0.155, 0.04, 0.016)
        colour = colour * (1 - shade + light)[..., None]
        # beard before the mouth
        beard = look.get("beard", 0.0)
        if beard:
            edge = np.interp(x, [0, 0.020, 0.040, 0.058, 0.072], [0.030, 0.030, 0.045, 0.075, 0.100])
            cover = smoothstep(edge + 0.006, edge - 0.006, y) * smoothstep(-0.02, 0.015, z)
            lip_gap = 1 - np.clip(spot(0, 0.0455, 0.021, 0.0105) * 1.8, 0, 1)
            moustache = smoothstep(0.0095, 0.003, np.abs(y - (0.0585 - 0.18 * x))) * smoothstep(0.034, 0.026, x) * front
            cover = np.maximum(cover * lip_gap, moustache)
            colour = mix(colour, hair(points, np.asarray(hair_colour) * 0.85, 31, 0), np.clip(cover * beard, 0, 1))
        # mouth
        lips = np.clip(1.4 - ((x / 0.0245) ** 2 + (np.where(y > 0.0455, (y - 0.0455) / 0.0070, (y - 0.0455) / 0.0085)) ** 2) * 1.4, 0, 1) * front
        lip_tone = tone * np.array([0.86, 0.60, 0.60]) if "lips" not in look else rgb(look["lips"])
        colour = mix(colour, lip_tone, lips * look.get("lip_strength", 0.75))
        colour = mix(colour, tone * np.array([0.40, 0.24, 0.22]), line(y - 0.0458 - 1.2 * x ** 2, 0.0022) * smoothstep(0.026, 0.021, x) * front * 0.85)
        colour = mix(colour, tone * np.array([0.42, 0.28, 0.26]), np.clip(spot(0.0078, 0.0675, 0.0036, 0.0026) * 1.3, 0, 1) * 0.8)
        # eyes
        ex, ey = x - 0.0310, y - 0.1125
        upper, lower = 0.0072 * (1 - (ex / 0.0140) ** 2), -0.0052 * (1 - (ex / 0.0140) ** 2)
        inside = smoothstep(-0.0006, 0.0008, np.minimum(upper - ey, ey - lower)) * (np.abs(ex) < 0.0140) * front
        white = np.array([0.90, 0.88, 0.86]) * (0.80 + 0.20 * smoothstep(0.006, -0.001, ey))[..., None]
        iris = np.hypot(ex, ey - 0.0006)
        ball = mix(white, eye_colour, smoothstep(0.0066, 0.0058, iris))
        ball = mix(ball, np.array([0.03, 0.02, 0.02]), smoothstep(0.0032, 0.0026, iris))
        ball = mix(ball, np.array([0.95, 0.95, 0.95]), smoothstep(0.0015, 0.0008, np.hypot(ex + 0.0018, ey - 0.0028)))
        colour = mix(colour, ball, inside)
        lash = line(ey - upper - 0.0006, look.get("lashes", 0.0020)) * (np.abs(ex) < 0.0150) * front
        colour = mix(colour, np.array([0.10, 0.07, 0.06]), lash * 0.9)
        colour = mix(colour, tone * 0.55, line(ey - lower + 0.0004, 0.0012) * (np.abs(ex) < 0.0135) * front * 0.5)
        colour = mix(colour, tone * 0.62, line(ey - upper - 0.0048, 0.0016) * (np.abs(ex) < 0.0130) * front * 0.5)
        # brows: rise outwards, then fall
        bx = (x - 0.012) / 0.038
        middle = 0.1290 + 0.006 * np.sin(np.clip(bx, 0, 1) * 2.5) - 0.002
        thick = look.get("brow_width", 0.0042) * (1 - 0.55 * np.clip(bx, 0, 1))
        hairs = 0.75 + 0.5 * (noise.value(points * (500, 300, 300), 77) - 0.5)
        colour = mix(colour, brow, np.clip(line(y - middle, thick * 1.5) * smoothstep(-0.04, 0.06, bx) * smoothstep(1.04, 0.92, bx) * front * hairs, 0, 1))
        if look.get("glasses"):
            rim = line(np.hypot(ex * 0.95, (ey + 0.002) * 1.15) - 0.0195, 0.0022) * front
            bridge = line(y - 0.1150, 0.0022) * (x < 0.0125) * front
            temple = line(y - 0.1150, 0.0024) * smoothstep(0.049, 0.052, x) * (z > -0.01)
            colour = mix(colour, np.array([0.08, 0.07, 0.07]), np.clip(np.maximum(np.maximum(rim, bridge), temple), 0, 1))
        # hair
        cover = head.hair_cover(local)
        ragged = cover + 0.006 * (noise.value(points * 90, 12) - 0.5)
        grown = smoothstep(-0.004, 0.006, ragged)
        strands = hair(points, hair_colour, 7, look.get("strands", 1))
        strands = strands * (0.72 + 0.28 * smoothstep(0.02, 0.10, cover))[..., None] * (1 + 0.16 * np.exp(-((y - 0.185) / 0.016) ** 2))[..., None]
        return mix(colour, strands, grown)

    return paint
