"""The texture that all furniture shares, and where in it each picture lies."""

import numpy as np
from PIL import Image

from .. import noise
from ..noise import mix, smoothstep
from .prints import board, device, font, panel, poster, sign
from .surfaces import image_of, wood

ATLAS = 1024
# name: x, y, width, height in the prop atlas
CELLS = {
    "wood": (0, 0, 256, 128),
    "steel": (256, 0, 64, 64),
    "dark": (320, 0, 64, 64),
    "white": (384, 0, 64, 64),
    "fabric": (448, 0, 64, 64),
    "soil": (256, 64, 64, 64),
    "pot": (320, 64, 64, 64),
    "leaf": (384, 64, 64, 64),
    "red": (448, 64, 64, 64),
    "stone": (512, 0, 128, 128),
    "blue": (640, 0, 64, 64),
    "yellow": (704, 0, 64, 64),
    "lamp": (640, 64, 64, 64),
    "tan": (704, 64, 64, 64),
    "charcoal": (768, 0, 128, 64),
    "glow_white": (768, 64, 128, 64),
    "clock": (896, 0, 128, 128),
    "board": (0, 128, 512, 160),
    "sign_a": (512, 128, 256, 64),
    "sign_b": (768, 128, 256, 64),
    "sign_c": (512, 192, 256, 64),
    "sign_d": (768, 192, 256, 64),
    "info": (0, 288, 256, 64),
    "door_a": (256, 288, 128, 256),
    "door_b": (384, 288, 128, 256),
    "vending": (512, 256, 128, 256),
    "ticket": (640, 256, 128, 256),
    "totem": (768, 256, 128, 256),
    "lift": (896, 256, 128, 256),
    "banner_a": (0, 352, 96, 224),
    "banner_b": (128, 352, 96, 224),
    "map": (0, 592, 256, 176),
    "slats": (256, 560, 256, 208),
    **{f"poster_{i}": (i * 128, 784, 120, 168) for i in range(8)},
    "menu": (512, 528, 192, 96),
    "shelf": (512, 640, 256, 128),
    "exit": (704, 528, 128, 48),
    "case_a": (832, 528, 64, 64),
    "case_b": (896, 528, 64, 64),
}


def cell(name):
    """(u0, v0, u1, v1) of a cell, a texel inside its rim."""
    x, y, w, h = CELLS[name]
    return ((x + 1) / ATLAS, (y + 1) / ATLAS, (x + w - 1) / ATLAS, (y + h - 1) / ATLAS)


def props():
    """The prop atlas."""
    atlas = Image.new("RGB", (ATLAS, ATLAS), "#808080")

    def put(name, image):
        x, y, w, h = CELLS[name]
        atlas.paste(image.resize((w, h), Image.LANCZOS), (x, y))

    y, x = np.meshgrid(np.linspace(0, 1, 128), np.linspace(0, 2, 256), indexing="ij")
    put("wood", image_of(wood(x, y, 2, (0.66, 0.47, 0.30))))
    yy, xx = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 64), indexing="ij")
    spot = np.stack([xx * 30, yy * 30, xx * 0], -1)
    for name, colour, rough in (
        ("dark", (0.17, 0.175, 0.185), 0.05),
        ("white", (0.90, 0.90, 0.885), 0.015),
        ("fabric", (0.23, 0.32, 0.40), 0.30),
        ("soil", (0.20, 0.14, 0.10), 0.7),
        ("pot", (0.86, 0.85, 0.82), 0.03),
        ("red", (0.66, 0.16, 0.13), 0.04),
        ("blue", (0.10, 0.26, 0.46), 0.04),
        ("yellow", (0.93, 0.72, 0.18), 0.04),
        ("lamp", (0.93, 0.93, 0.92), 0.0),
        ("tan", (0.70, 0.56, 0.40), 0.08),
        ("charcoal", (0.26, 0.265, 0.28), 0.08),
        ("glow_white", (1.0, 0.97, 0.91), 0.0),
    ):
        put(name, image_of(np.array(colour) * (1 + rough * 2 * (noise.fractal(spot, 2, len(name)) - 0.5))[..., None]))
    put(
        "steel",
        image_of(
            np.array([0.70, 0.71, 0.72])
            * (1 + 0.10 * (noise.value(np.stack([xx * 2, yy * 60, xx * 0], -1), 3) - 0.5))[..., None]
        ),
    )
    vein = np.abs(xx - 0.5)
    put(
        "leaf",
        image_of(
            np.array([0.22, 0.42, 0.16])
            * (0.75 + 0.5 * noise.fractal(spot * 0.3, 2, 4) + 0.35 * smoothstep(0.05, 0.0, vein) - 0.25 * vein)[
                ..., None
            ]
        ),
    )
    y, x = np.meshgrid(np.linspace(0, 1, 128), np.linspace(0, 1, 128), indexing="ij")
    put(
        "stone",
        image_of(
            np.array([0.78, 0.77, 0.75])
            * (1 + 0.12 * (noise.fractal(np.stack([x * 7, y * 7, x * 0], -1), 4, 8) - 0.5))[..., None]
        ),
    )
    clock, draw = panel((512, 512), "#e8e8e6")
    draw.ellipse((6, 6, 506, 506), fill="#fbfbf8", outline="#24272b", width=22)
    for k in range(12):
        a = np.radians(k * 30)
        draw.line(
            [(256 + r * np.sin(a), 256 - r * np.cos(a)) for r in ((180, 226) if k % 3 else (164, 226))],
            fill="#1b1e22",
            width=12 if k % 3 else 20,
        )
    for angle, length, width in ((312, 130, 22), (144, 200, 14)):
        a = np.radians(angle)
        draw.line(
            (256 - 30 * np.sin(a), 256 + 30 * np.cos(a), 256 + length * np.sin(a), 256 - length * np.cos(a)),
            fill="#1b1e22",
            width=width,
        )
    put("clock", clock)
    put("board", board())
    put("sign_a", sign("Platforms 1-5", "up"))
    put("sign_b", sign("Exit  City", "right"))
    put("sign_c", sign("Lounge  Cafe", "left"))
    put("sign_d", sign("Toilets", "right", "#2a2d31"))
    put("info", sign("Information", None, "#f4f2ec", "#1b3b5f"))
    put("exit", sign("EXIT", "right", "#0d7a3e"))
    for kind in ("door_a", "door_b", "vending", "ticket", "totem", "lift"):
        put(kind, device(kind))
    for name, fill, ink, text in (
        ("banner_a", "#1f5f74", "#f3e9d2", "Open\nHouse"),
        ("banner_b", "#c8502e", "#fff4e2", "Summer\nSeason"),
    ):
        image, draw = panel((384, 896), fill)
        draw.ellipse((62, 470, 322, 730), fill=ink)
        draw.ellipse((122, 530, 262, 670), fill=fill)
        draw.multiline_text((192, 200), text, font=font(96), fill=ink, anchor="mm", align="center", spacing=20)
        put(name, image)
    plan, draw = panel((1024, 704), "#f3f1ea")
    for k, (colour, points) in enumerate(
        (
            ("#d1495b", [(60, 600), (300, 420), (520, 420), (760, 160), (980, 160)]),
            ("#2e6f95", [(60, 140), (360, 140), (520, 420), (520, 640)]),
            ("#e0a030", [(100, 380), (420, 300), (700, 520), (960, 560)]),
            ("#3f8f5f", [(200, 660), (640, 300), (640, 60)]),
        )
    ):
        draw.line(points, fill=colour, width=22, joint="curve")
        for p in points:
            draw.ellipse((p[0] - 20, p[1] - 20, p[0] + 20, p[1] + 20), fill="#fff", outline="#222", width=7)
    draw.rectangle((0, 0, 1023, 703), outline="#30343a", width=18)
    put("map", plan)
    y, x = np.meshgrid(np.linspace(0, 1.3, 208), np.linspace(0, 1.6, 256), indexing="ij")
    number = np.floor(x / 0.10).astype(int)
    put(
        "slats",
        image_of(
            mix(
                wood(y, x + number * 1.7, 4) * (0.85 + 0.15 * np.sin((x % 0.1) / 0.073 * np.pi))[..., None],
                np.array([0.07, 0.05, 0.035]),
                smoothstep(0.07, 0.076, x % 0.10),
            )
        ),
    )
    for i in range(8):
        put(f"poster_{i}", poster(i))
    menu, draw = panel((768, 384), "#1c1d1f")
    draw.text((384, 50), "CAFE", font=font(64), fill="#f2e3c6", anchor="mm")
    for k in range(5):
        draw.rectangle((60, 110 + k * 52, 300 - k * 17 % 60, 126 + k * 52), fill="#d8cdb8")
        draw.rectangle((420, 110 + k * 52, 690 - k * 29 % 80, 126 + k * 52), fill="#d8cdb8")
    put("menu", menu)
    shelf, draw = panel((512, 256), "#40362e")
    colours = ["#b5402f", "#e0a93b", "#3e7d5a", "#30608c", "#d8d2c6", "#7d3c5c", "#c77b3a"]
    for r in range(3):
        draw.rectangle((6, 10 + r * 84, 506, 84 + r * 84), fill="#221d19")
        for c in range(26):
            high = 34 + (c * 31 + r * 17) % 34
            draw.rectangle(
                (12 + c * 19, 82 + r * 84 - high, 27 + c * 19, 82 + r * 84), fill=colours[(c * 5 + r * 3) % 7]
            )
    put("shelf", shelf)
    for name, colour in (("case_a", "#28507a"), ("case_b", "#8c2f39")):
        image, draw = panel((128, 128), colour)
        for k in range(6):
            draw.rectangle((8 + k * 20, 6, 14 + k * 20, 122), fill=tuple(int(v * 0.8) for v in image.getpixel((1, 1))))
        put(name, image)
    return atlas
