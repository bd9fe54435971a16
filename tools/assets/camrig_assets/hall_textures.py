"""Textures of the hall, painted by program: floor, plaster, ceiling, wood, the outside, and one atlas for all props."""

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from . import noise
from .noise import mix, smoothstep

ATLAS = 1024
# name: x, y, width, height in the prop atlas
CELLS = {"wood": (0, 0, 256, 128), "steel": (256, 0, 64, 64), "dark": (320, 0, 64, 64), "white": (384, 0, 64, 64), "fabric": (448, 0, 64, 64), "soil": (256, 64, 64, 64),
         "pot": (320, 64, 64, 64), "leaf": (384, 64, 64, 64), "red": (448, 64, 64, 64), "stone": (512, 0, 128, 128), "blue": (640, 0, 64, 64), "yellow": (704, 0, 64, 64), "lamp": (640, 64, 64, 64),
         "tan": (704, 64, 64, 64), "charcoal": (768, 0, 128, 64), "glow_white": (768, 64, 128, 64), "clock": (896, 0, 128, 128),
         "board": (0, 128, 512, 160), "sign_a": (512, 128, 256, 64), "sign_b": (768, 128, 256, 64), "sign_c": (512, 192, 256, 64), "sign_d": (768, 192, 256, 64),
         "info": (0, 288, 256, 64), "door_a": (256, 288, 128, 256), "door_b": (384, 288, 128, 256), "vending": (512, 256, 128, 256), "ticket": (640, 256, 128, 256), "totem": (768, 256, 128, 256),
         "lift": (896, 256, 128, 256), "banner_a": (0, 352, 96, 224), "banner_b": (128, 352, 96, 224), "map": (0, 592, 256, 176), "slats": (256, 560, 256, 208),
         **{f"poster_{i}": (i * 128, 784, 120, 168) for i in range(8)}, "menu": (512, 528, 192, 96), "shelf": (512, 640, 256, 128), "exit": (704, 528, 128, 48), "case_a": (832, 528, 64, 64), "case_b": (896, 528, 64, 64)}


def cell(name):
    """(u0, v0, u1, v1) of a cell, a texel inside its rim."""
    x, y, w, h = CELLS[name]
    return ((x + 1) / ATLAS, (y + 1) / ATLAS, (x + w - 1) / ATLAS, (y + h - 1) / ATLAS)


def _image(pixels):
    return Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8), "RGB")


def _grid(size, metres):
    """Texel places in metres, and the same on a torus so that the noise repeats with the texture: (x, y, function seamless)."""
    y, x = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")

    def seamless(cells, seed, octaves=2):
        total, weight = 0.0, 0.0
        for octave in range(octaves):
            n = cells * 2 ** octave
            fx, fy = x * n, y * n
            value = 0.0
            ix, iy = np.floor(fx).astype(int), np.floor(fy).astype(int)
            tx, ty = fx - ix, fy - iy
            tx, ty = tx * tx * (3 - 2 * tx), ty * ty * (3 - 2 * ty)
            for dx in (0, 1):
                for dy in (0, 1):
                    w = (tx if dx else 1 - tx) * (ty if dy else 1 - ty)
                    value = value + w * noise._lattice((ix + dx) % n, (iy + dy) % n, np.zeros_like(ix), seed + octave)
            total, weight = total + value / 2 ** octave, weight + 1 / 2 ** octave
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
    colour = np.array([0.745, 0.718, 0.675]) * (1 + 0.075 * shade + 0.085 * cloud + 0.07 * speck + 0.07 * flake)[..., None] + warm[..., None] * np.array([0.012, 0.002, -0.012])
    edge = np.minimum.reduce([x % tile, y % tile, tile - x % tile, tile - y % tile])
    joint = smoothstep(0.0060, 0.0030, edge)
    colour = mix(colour, np.array([0.50, 0.485, 0.465]), joint * 0.85)
    colour = colour * (1 - 0.03 * smoothstep(0.02, 0.005, edge))[..., None]
    strip = smoothstep(0.078, 0.072, np.minimum.reduce([x, y, metres - x, metres - y]))   # dark granite along the 4.8 m grid
    dark = np.array([0.40, 0.39, 0.385]) * (1 + 0.10 * cloud + 0.25 * speck)[..., None]
    return _image(mix(colour, dark, strip * 0.9))


def plaster(size=256, metres=3.0):
    _, _, seamless = _grid(size, metres)
    return _image(np.array([0.905, 0.893, 0.868]) * (1 + 0.020 * (seamless(5, 3, 3) - 0.5) + 0.035 * (seamless(110, 9, 1) - 0.5))[..., None])


def concrete(size=512, metres=2.4):
    """Fair-faced concrete: cloudy, pin holes, panel joints with tie holes."""
    x, y, seamless = _grid(size, metres)
    colour = np.array([0.705, 0.695, 0.675]) * (1 + 0.16 * (seamless(4, 31, 4) - 0.5) + 0.05 * (seamless(128, 37, 1) - 0.5) - 0.10 * smoothstep(0.90, 0.95, seamless(90, 41, 1)))[..., None]
    edge = np.minimum(x % 2.4, y % 1.2)
    colour = colour * (1 - 0.22 * smoothstep(0.012, 0.006, edge))[..., None]
    hole = np.hypot((x % 1.2) - 0.6, (y % 1.2) - 0.3)
    return _image(colour * (1 - 0.45 * smoothstep(0.022, 0.016, hole))[..., None])


def ceiling(size=256, metres=2.4):
    """Perforated white panels of 1.2 m x 0.6 m."""
    x, y, seamless = _grid(size, metres)
    edge = np.minimum.reduce([x % 1.2, y % 0.6])
    return _image(np.array([0.90, 0.90, 0.89]) * (1 + 0.02 * (seamless(60, 5, 1) - 0.5) - 0.20 * smoothstep(0.020, 0.010, edge))[..., None])


def _wood(x, y, seed, base=(0.63, 0.44, 0.27)):
    grain = noise.fractal(np.stack([x * 3 + 0.4 * noise.value(np.stack([x * 2, y * 6, x * 0], -1), seed), y * 42, x * 0 + seed], -1), 3, seed)
    fine = noise.value(np.stack([x * 22, y * 380, x * 0], -1), seed + 3)
    return np.array(base) * (1 + 0.45 * (grain - 0.5) + 0.15 * (fine - 0.5))[..., None]


def slats(size=512, metres=1.6):
    """Vertical wooden slats with dark gaps."""
    x, y, _ = _grid(size, metres)
    number = np.floor(x / 0.10).astype(int)
    tone = noise._lattice(number % 16, number * 0, number * 0, 3) - 0.5
    colour = _wood(y, x + number * 1.7, 4) * (1 + 0.22 * tone)[..., None]
    place = x % 0.10
    gap = smoothstep(0.070, 0.076, place)
    round_ = 0.80 + 0.20 * np.sin(np.clip(place / 0.073, 0, 1) * np.pi)
    return _image(mix(colour * round_[..., None], np.array([0.07, 0.05, 0.035]), gap))


def outside(width=1024, height=384):
    """What the windows show: hazy sky, a row of facades and trees, pavement; far enough to be soft."""
    y, x = np.meshgrid(np.linspace(0, 1, height), np.linspace(0, 1, width), indexing="ij")
    sky = mix(np.broadcast_to(np.array([0.66, 0.79, 0.93]), (height, width, 3)), np.array([0.93, 0.95, 0.96]), smoothstep(0.0, 0.60, y))
    cloud = smoothstep(0.48, 0.75, noise.fractal(np.stack([x * 9, y * 12, x * 0], -1), 4, 71))
    out = mix(sky, np.array([0.98, 0.98, 0.98]), 0.75 * cloud * smoothstep(0.62, 0.2, y))
    house = np.floor(x * 9 + 0.15 * np.sin(x * 23)).astype(int)
    roof = 0.40 + 0.10 * noise._lattice(house, house * 0, house * 0, 8)
    tint = noise._lattice(house, house * 0, house * 0, 9)[..., None]
    wall = mix(np.broadcast_to(np.array([0.80, 0.73, 0.64]), out.shape), np.array([0.66, 0.66, 0.68]), tint[..., 0])
    wx, wy = (x * 72) % 1, (y * 26) % 1
    pane = (np.abs(wx - 0.5) < 0.24) & (np.abs(wy - 0.5) < 0.28)
    wall = np.where(pane[..., None], np.array([0.42, 0.49, 0.56]) + 0.12 * (noise._lattice((x * 72).astype(int), (y * 26).astype(int), house, 4)[..., None] - 0.5), wall)
    out = mix(out, mix(wall, np.array([0.88, 0.91, 0.94]), np.full((height, width), 0.25)), smoothstep(-0.002, 0.004, y - roof) * smoothstep(0.735, 0.73, y))
    crown = noise.fractal(np.stack([x * 26, y * 10, x * 0], -1), 4, 12)
    trees = smoothstep(0.02, 0.10, crown - 0.44 - 1.7 * np.abs(y - 0.60) ** 1.2) * (noise.value(np.stack([x * 7, y * 0, y * 0], -1), 44) > 0.42)
    leaf = np.array([0.40, 0.52, 0.27]) * (0.65 + 0.7 * noise.fractal(np.stack([x * 160, y * 60, x * 0], -1), 2, 55))[..., None]
    out = mix(out, leaf, trees * 0.92)
    out = mix(out, np.array([0.64, 0.63, 0.61]) * (0.90 + 0.2 * y)[..., None], smoothstep(0.725, 0.735, y))
    out = mix(out, np.array([0.50, 0.50, 0.51]), smoothstep(0.80, 0.81, y) * smoothstep(0.90, 0.89, y))
    car = (y > 0.765) & (y < 0.845) & (np.abs((x * 5.3) % 1 - 0.5) < 0.15) & (noise._lattice((x * 5.3).astype(int), house * 0, house * 0, 77) > 0.35)
    body = mix(np.broadcast_to(np.array([0.72, 0.73, 0.75]), out.shape), np.array([0.46, 0.14, 0.13]), noise._lattice((x * 5.3).astype(int), house * 0, house * 0, 78))
    out = np.where(car[..., None], np.where((y < 0.80)[..., None], np.array([0.25, 0.29, 0.33]), body), out)
    out = 1 - (1 - out) * 0.82   # overexposed, as a street is from indoors
    return _image(out).filter(ImageFilter.GaussianBlur(1.6))


def _font(size):
    return ImageFont.load_default(size)


def _panel(size, fill):
    image = Image.new("RGB", size, fill)
    return image, ImageDraw.Draw(image)


def _poster(i):
    """Eight prints with few, clear shapes."""
    w, h = 120, 168
    grounds = ["#e8dfcf", "#16324f", "#d9482b", "#f1c232", "#20504f", "#efe9e1", "#2b2b31", "#c7d9e6"]
    image, draw = _panel((w * 4, h * 4), grounds[i])
    W, H = w * 4, h * 4
    ink = ["#b33a2c", "#e9c46a", "#fff3e0", "#1d3557", "#f4a261", "#274c77", "#e76f51", "#7a2e3a"][i]
    if i == 0:
        draw.ellipse((90, 120, 390, 420), fill=ink)
        draw.rectangle((0, 420, W, 440), fill="#31302e")
    elif i == 1:
        for k in range(7):
            draw.arc((60 - k * 20, 180 - k * 20, 420 + k * 20, 540 + k * 20), 180, 360, fill=ink, width=12)
    elif i == 2:
        for k in range(5):
            draw.polygon([(40 + k * 85, 470), (90 + k * 85, 150 + 40 * (k % 2)), (140 + k * 85, 470)], fill=ink)
    elif i == 3:
        draw.rectangle((60, 110, 250, 330), fill=ink)
        draw.ellipse((200, 240, 420, 460), fill="#d1495b")
    elif i == 4:
        for k in range(9):
            draw.rectangle((50 + k * 44, 470 - (k * 37 % 190) - 90, 80 + k * 44, 470), fill=ink)
    elif i == 5:
        draw.polygon([(240, 90), (430, 470), (50, 470)], fill=ink)
        draw.ellipse((300, 90, 380, 170), fill="#f2a33a")
    elif i == 6:
        for k in range(6):
            draw.line((40, 140 + k * 60, 440, 100 + k * 66), fill=ink, width=14 - k)
        draw.ellipse((170, 200, 310, 340), outline="#f4f1de", width=14)
    else:
        draw.rectangle((60, 240, 420, 470), fill="#5d8aa8")
        draw.polygon([(60, 240), (240, 110), (420, 240)], fill=ink)
        draw.rectangle((200, 340, 280, 470), fill="#f1faee")
    text = ["ORBITS", "ECHO", "PEAKS", "FORMS", "RHYTHM", "SUMMIT", "SIGNAL", "HOME"][i]
    light = sum(image.getpixel((4, H - 30))) > 380
    draw.text((W / 2, 540), text, font=_font(74), fill="#222" if light else "#fff", anchor="mm")
    draw.text((W / 2, 610), "until 30 September", font=_font(34), fill="#333" if light else "#eee", anchor="mm")
    draw.rectangle((0, 0, W - 1, H - 1), outline="#111", width=10)
    return image.resize((w, h), Image.LANCZOS)


def _sign(text, arrow, fill="#14365c", ink="#ffffff"):
    image, draw = _panel((1024, 256), fill)
    x = 60
    if arrow:
        shaft = {"left": [(50, 128), (130, 50), (130, 100), (220, 100), (220, 156), (130, 156), (130, 206)], "right": [(220, 128), (140, 50), (140, 100), (50, 100), (50, 156), (140, 156), (140, 206)],
                 "up": [(135, 40), (215, 125), (163, 125), (163, 216), (107, 216), (107, 125), (55, 125)]}[arrow]
        draw.polygon(shaft, fill="#f7c948")
        x = 270
    draw.text((x, 128), text, font=_font(120), fill=ink, anchor="lm")
    return image


def _board():
    """A departure board: amber rows on black."""
    image, draw = _panel((1024, 320), "#0b0d10")
    draw.rectangle((0, 0, 1024, 46), fill="#17324f")
    draw.text((20, 23), "Departures", font=_font(34), fill="#ffffff", anchor="lm")
    draw.text((1000, 23), "10:24", font=_font(34), fill="#ffffff", anchor="rm")
    rows = [("10:27", "IC 204", "Harbour City", "4"), ("10:31", "RE 18", "Northgate", "2"), ("10:36", "S 3", "Airport", "1"), ("10:42", "IC 77", "Lakeside", "5"), ("10:45", "RE 6", "Old Mill", "3"), ("10:52", "S 1", "University", "1")]
    for i, row in enumerate(rows):
        y = 72 + i * 43
        for x, text in zip((20, 170, 350, 960), row):
            draw.text((x, y), text, font=_font(32), fill="#ffc247" if i != 2 else "#ffffff", anchor="lm")
    return image


def _device(kind):
    """Fronts of machines and doors."""
    if kind == "ticket":
        image, draw = _panel((256, 512), "#c8cdd2")
        draw.rectangle((0, 0, 256, 70), fill="#12497a")
        draw.text((128, 36), "Tickets", font=_font(46), fill="#fff", anchor="mm")
        draw.rectangle((36, 100, 220, 260), fill="#0e1a26")
        draw.rectangle((46, 110, 210, 150), fill="#2f80c2")
        for k in range(4):
            draw.rectangle((46 + (k % 2) * 84, 160 + (k // 2) * 46, 122 + (k % 2) * 84, 198 + (k // 2) * 46), fill="#e9f1f7")
        draw.rectangle((50, 300, 130, 340), fill="#30353a")
        draw.rectangle((160, 290, 206, 350), fill="#f2b632")
        draw.rectangle((60, 400, 196, 450), fill="#22262a")
    elif kind == "vending":
        image, draw = _panel((256, 512), "#8d1f23")
        draw.rectangle((14, 40, 190, 440), fill="#20262b")
        colours = ["#e2572b", "#f3c13a", "#3f8f4f", "#3273b8", "#e9e4da", "#b22f6a"]
        for r in range(6):
            draw.rectangle((20, 50 + r * 64, 184, 108 + r * 64), fill="#d8dee2")
            for c in range(5):
                draw.rectangle((26 + c * 32, 62 + r * 64, 50 + c * 32, 104 + r * 64), fill=colours[(r * 5 + c * 3 + r) % 6])
        draw.rectangle((204, 120, 244, 200), fill="#11161a")
        draw.rectangle((204, 220, 244, 250), fill="#c8c8c8")
        draw.text((128, 22), "Drinks & Snacks", font=_font(26), fill="#fff", anchor="mm")
        draw.rectangle((30, 456, 180, 496), fill="#101214")
    elif kind == "totem":
        image, draw = _panel((256, 512), "#0d2233")
        draw.rectangle((0, 0, 256, 120), fill="#1f6f8b")
        draw.text((128, 60), "i", font=_font(110), fill="#fff", anchor="mm")
        for k in range(6):
            draw.rectangle((30, 150 + k * 54, 226 - (k * 37) % 80, 172 + k * 54), fill="#8fb9cf")
            draw.rectangle((30, 180 + k * 54, 180 - (k * 23) % 60, 188 + k * 54), fill="#47697d")
    elif kind == "lift":
        image, draw = _panel((256, 512), "#b9bdc0")
        for k in range(256):
            draw.line((k, 0, k, 512), fill=tuple(int(176 + 14 * np.sin(k * 0.9) + 6 * np.sin(k * 3.1)) for _ in range(3)))
        draw.rectangle((124, 0, 131, 512), fill="#3a3d40")
        draw.rectangle((0, 0, 255, 511), outline="#55595c", width=8)
    else:
        light = kind == "door_a"
        image, draw = _panel((256, 512), "#8a6443" if light else "#5b6670")
        grain = np.asarray(_image(_wood(*np.meshgrid(np.linspace(0, 2, 512), np.linspace(0, 1, 256)), 6, (0.60, 0.43, 0.28))).rotate(90, expand=True))
        if light:
            image.paste(Image.fromarray(grain).resize((256, 512)))
            draw = ImageDraw.Draw(image)
        draw.rectangle((0, 0, 255, 511), outline="#3c3f42", width=14)
        if not light:
            draw.rectangle((150, 60, 205, 300), fill="#a9c0c9", outline="#2e3338", width=6)
        draw.rectangle((24, 262, 40, 330), fill="#d0d3d5")
        draw.rectangle((24, 284, 74, 296), fill="#e4e6e8")
        draw.rectangle((14, 470, 242, 500), fill="#9aa0a4")
    return image


def props():
    """The prop atlas."""
    atlas = Image.new("RGB", (ATLAS, ATLAS), "#808080")

    def put(name, image):
        x, y, w, h = CELLS[name]
        atlas.paste(image.resize((w, h), Image.LANCZOS), (x, y))

    y, x = np.meshgrid(np.linspace(0, 1, 128), np.linspace(0, 2, 256), indexing="ij")
    put("wood", _image(_wood(x, y, 2, (0.66, 0.47, 0.30))))
    yy, xx = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 64), indexing="ij")
    spot = np.stack([xx * 30, yy * 30, xx * 0], -1)
    for name, colour, rough in (("dark", (0.17, 0.175, 0.185), 0.05), ("white", (0.90, 0.90, 0.885), 0.015), ("fabric", (0.23, 0.32, 0.40), 0.30), ("soil", (0.20, 0.14, 0.10), 0.7), ("pot", (0.86, 0.85, 0.82), 0.03),
                                ("red", (0.66, 0.16, 0.13), 0.04), ("blue", (0.10, 0.26, 0.46), 0.04), ("yellow", (0.93, 0.72, 0.18), 0.04), ("lamp", (0.93, 0.93, 0.92), 0.0), ("tan", (0.70, 0.56, 0.40), 0.08),
                                ("charcoal", (0.26, 0.265, 0.28), 0.08), ("glow_white", (1.0, 0.97, 0.91), 0.0)):
        put(name, _image(np.array(colour) * (1 + rough * 2 * (noise.fractal(spot, 2, len(name)) - 0.5))[..., None]))
    put("steel", _image(np.array([0.70, 0.71, 0.72]) * (1 + 0.10 * (noise.value(np.stack([xx * 2, yy * 60, xx * 0], -1), 3) - 0.5))[..., None]))
    vein = np.abs(xx - 0.5)
    put("leaf", _image(np.array([0.22, 0.42, 0.16]) * (0.75 + 0.5 * noise.fractal(spot * 0.3, 2, 4) + 0.35 * smoothstep(0.05, 0.0, vein) - 0.25 * vein)[..., None]))
    y, x = np.meshgrid(np.linspace(0, 1, 128), np.linspace(0, 1, 128), indexing="ij")
    put("stone", _image(np.array([0.78, 0.77, 0.75]) * (1 + 0.12 * (noise.fractal(np.stack([x * 7, y * 7, x * 0], -1), 4, 8) - 0.5))[..., None]))
    clock, draw = _panel((512, 512), "#e8e8e6")
    draw.ellipse((6, 6, 506, 506), fill="#fbfbf8", outline="#24272b", width=22)
    for k in range(12):
        a = np.radians(k * 30)
        draw.line([(256 + r * np.sin(a), 256 - r * np.cos(a)) for r in ((180, 226) if k % 3 else (164, 226))], fill="#1b1e22", width=12 if k % 3 else 20)
    for angle, length, width in ((312, 130, 22), (144, 200, 14)):
        a = np.radians(angle)
        draw.line((256 - 30 * np.sin(a), 256 + 30 * np.cos(a), 256 + length * np.sin(a), 256 - length * np.cos(a)), fill="#1b1e22", width=width)
    put("clock", clock)
    put("board", _board())
    put("sign_a", _sign("Platforms 1-5", "up"))
    put("sign_b", _sign("Exit  City", "right"))
    put("sign_c", _sign("Lounge  Cafe", "left"))
    put("sign_d", _sign("Toilets", "right", "#2a2d31"))
    put("info", _sign("Information", None, "#f4f2ec", "#1b3b5f"))
    put("exit", _sign("EXIT", "right", "#0d7a3e"))
    for kind in ("door_a", "door_b", "vending", "ticket", "totem", "lift"):
        put(kind, _device(kind))
    for name, fill, ink, text in (("banner_a", "#1f5f74", "#f3e9d2", "Open\nHouse"), ("banner_b", "#c8502e", "#fff4e2", "Summer\nSeason")):
        image, draw = _panel((384, 896), fill)
        draw.ellipse((62, 470, 322, 730), fill=ink)
        draw.ellipse((122, 530, 262, 670), fill=fill)
        draw.multiline_text((192, 200), text, font=_font(96), fill=ink, anchor="mm", align="center", spacing=20)
        put(name, image)
    plan, draw = _panel((1024, 704), "#f3f1ea")
    for k, (colour, points) in enumerate((("#d1495b", [(60, 600), (300, 420), (520, 420), (760, 160), (980, 160)]), ("#2e6f95", [(60, 140), (360, 140), (520, 420), (520, 640)]), ("#e0a030", [(100, 380), (420, 300), (700, 520), (960, 560)]), ("#3f8f5f", [(200, 660), (640, 300), (640, 60)]))):
        draw.line(points, fill=colour, width=22, joint="curve")
        for p in points:
            draw.ellipse((p[0] - 20, p[1] - 20, p[0] + 20, p[1] + 20), fill="#fff", outline="#222", width=7)
    draw.rectangle((0, 0, 1023, 703), outline="#30343a", width=18)
    put("map", plan)
    y, x = np.meshgrid(np.linspace(0, 1.3, 208), np.linspace(0, 1.6, 256), indexing="ij")
    number = np.floor(x / 0.10).astype(int)
    put("slats", _image(mix(_wood(y, x + number * 1.7, 4) * (0.85 + 0.15 * np.sin((x % 0.1) / 0.073 * np.pi))[..., None], np.array([0.07, 0.05, 0.035]), smoothstep(0.07, 0.076, x % 0.10))))
    for i in range(8):
        put(f"poster_{i}", _poster(i))
    menu, draw = _panel((768, 384), "#1c1d1f")
    draw.text((384, 50), "CAFE", font=_font(64), fill="#f2e3c6", anchor="mm")
    for k in range(5):
        draw.rectangle((60, 110 + k * 52, 300 - k * 17 % 60, 126 + k * 52), fill="#d8cdb8")
        draw.rectangle((420, 110 + k * 52, 690 - k * 29 % 80, 126 + k * 52), fill="#d8cdb8")
    put("menu", menu)
    shelf, draw = _panel((512, 256), "#40362e")
    colours = ["#b5402f", "#e0a93b", "#3e7d5a", "#30608c", "#d8d2c6", "#7d3c5c", "#c77b3a"]
    for r in range(3):
        draw.rectangle((6, 10 + r * 84, 506, 84 + r * 84), fill="#221d19")
        for c in range(26):
            high = 34 + (c * 31 + r * 17) % 34
            draw.rectangle((12 + c * 19, 82 + r * 84 - high, 27 + c * 19, 82 + r * 84), fill=colours[(c * 5 + r * 3) % 7])
    put("shelf", shelf)
    for name, colour in (("case_a", "#28507a"), ("case_b", "#8c2f39")):
        image, draw = _panel((128, 128), colour)
        for k in range(6):
            draw.rectangle((8 + k * 20, 6, 14 + k * 20, 122), fill=tuple(int(v * 0.8) for v in image.getpixel((1, 1))))
        put(name, image)
    return atlas
