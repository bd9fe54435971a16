"""What is printed or shown in the hall: posters, signs, boards, and the fronts of doors and machines."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .surfaces import image_of, wood


def font(size):
    return ImageFont.load_default(size)


def panel(size, fill):
    image = Image.new("RGB", size, fill)
    return image, ImageDraw.Draw(image)


def poster(i):
    """Eight prints with few, clear shapes."""
    w, h = 120, 168
    grounds = ["#e8dfcf", "#16324f", "#d9482b", "#f1c232", "#20504f", "#efe9e1", "#2b2b31", "#c7d9e6"]
    image, draw = panel((w * 4, h * 4), grounds[i])
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
    draw.text((W / 2, 540), text, font=font(74), fill="#222" if light else "#fff", anchor="mm")
    draw.text((W / 2, 610), "until 30 September", font=font(34), fill="#333" if light else "#eee", anchor="mm")
    draw.rectangle((0, 0, W - 1, H - 1), outline="#111", width=10)
    return image.resize((w, h), Image.LANCZOS)


def sign(text, arrow, fill="#14365c", ink="#ffffff"):
    image, draw = panel((1024, 256), fill)
    x = 60
    if arrow:
        shaft = {
            "left": [(50, 128), (130, 50), (130, 100), (220, 100), (220, 156), (130, 156), (130, 206)],
            "right": [(220, 128), (140, 50), (140, 100), (50, 100), (50, 156), (140, 156), (140, 206)],
            "up": [(135, 40), (215, 125), (163, 125), (163, 216), (107, 216), (107, 125), (55, 125)],
        }[arrow]
        draw.polygon(shaft, fill="#f7c948")
        x = 270
    draw.text((x, 128), text, font=font(120), fill=ink, anchor="lm")
    return image


def board():
    """A departure board: amber rows on black."""
    image, draw = panel((1024, 320), "#0b0d10")
    draw.rectangle((0, 0, 1024, 46), fill="#17324f")
    draw.text((20, 23), "Departures", font=font(34), fill="#ffffff", anchor="lm")
    draw.text((1000, 23), "10:24", font=font(34), fill="#ffffff", anchor="rm")
    rows = [
        ("10:27", "IC 204", "Harbour City", "4"),
        ("10:31", "RE 18", "Northgate", "2"),
        ("10:36", "S 3", "Airport", "1"),
        ("10:42", "IC 77", "Lakeside", "5"),
        ("10:45", "RE 6", "Old Mill", "3"),
        ("10:52", "S 1", "University", "1"),
    ]
    for i, row in enumerate(rows):
        y = 72 + i * 43
        for x, text in zip((20, 170, 350, 960), row):
            draw.text((x, y), text, font=font(32), fill="#ffc247" if i != 2 else "#ffffff", anchor="lm")
    return image


def device(kind):
    """Fronts of machines and doors."""
    if kind == "ticket":
        image, draw = panel((256, 512), "#c8cdd2")
        draw.rectangle((0, 0, 256, 70), fill="#12497a")
        draw.text((128, 36), "Tickets", font=font(46), fill="#fff", anchor="mm")
        draw.rectangle((36, 100, 220, 260), fill="#0e1a26")
        draw.rectangle((46, 110, 210, 150), fill="#2f80c2")
        for k in range(4):
            draw.rectangle(
                (46 + (k % 2) * 84, 160 + (k // 2) * 46, 122 + (k % 2) * 84, 198 + (k // 2) * 46), fill="#e9f1f7"
            )
        draw.rectangle((50, 300, 130, 340), fill="#30353a")
        draw.rectangle((160, 290, 206, 350), fill="#f2b632")
        draw.rectangle((60, 400, 196, 450), fill="#22262a")
    elif kind == "vending":
        image, draw = panel((256, 512), "#8d1f23")
        draw.rectangle((14, 40, 190, 440), fill="#20262b")
        colours = ["#e2572b", "#f3c13a", "#3f8f4f", "#3273b8", "#e9e4da", "#b22f6a"]
        for r in range(6):
            draw.rectangle((20, 50 + r * 64, 184, 108 + r * 64), fill="#d8dee2")
            for c in range(5):
                draw.rectangle(
                    (26 + c * 32, 62 + r * 64, 50 + c * 32, 104 + r * 64), fill=colours[(r * 5 + c * 3 + r) % 6]
                )
        draw.rectangle((204, 120, 244, 200), fill="#11161a")
        draw.rectangle((204, 220, 244, 250), fill="#c8c8c8")
        draw.text((128, 22), "Drinks & Snacks", font=font(26), fill="#fff", anchor="mm")
        draw.rectangle((30, 456, 180, 496), fill="#101214")
    elif kind == "totem":
        image, draw = panel((256, 512), "#0d2233")
        draw.rectangle((0, 0, 256, 120), fill="#1f6f8b")
        draw.text((128, 60), "i", font=font(110), fill="#fff", anchor="mm")
        for k in range(6):
            draw.rectangle((30, 150 + k * 54, 226 - (k * 37) % 80, 172 + k * 54), fill="#8fb9cf")
            draw.rectangle((30, 180 + k * 54, 180 - (k * 23) % 60, 188 + k * 54), fill="#47697d")
    elif kind == "lift":
        image, draw = panel((256, 512), "#b9bdc0")
        for k in range(256):
            draw.line(
                (k, 0, k, 512), fill=tuple(int(176 + 14 * np.sin(k * 0.9) + 6 * np.sin(k * 3.1)) for _ in range(3))
            )
        draw.rectangle((124, 0, 131, 512), fill="#3a3d40")
        draw.rectangle((0, 0, 255, 511), outline="#55595c", width=8)
    else:
        light = kind == "door_a"
        image, draw = panel((256, 512), "#8a6443" if light else "#5b6670")
        grain = np.asarray(
            image_of(wood(*np.meshgrid(np.linspace(0, 2, 512), np.linspace(0, 1, 256)), 6, (0.60, 0.43, 0.28))).rotate(
                90, expand=True
            )
        )
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
