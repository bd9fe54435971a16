"""Clothes, shoes and bags: which parts a garment has and how its cloth is painted."""

import numpy as np

from . import noise, paint
from .noise import mix, smoothstep
from .paint import along, cloth, folds, line, rgb

TRUNK = (0.93, 0.98, 1.04, 1.10, 1.18, 1.26, 1.32, 1.37, 1.405, 1.435, 1.46, 1.48, 1.50)
LEG_ROWS = (0.055, 0.10, 0.20, 0.32, 0.42, 0.48, 0.53, 0.60, 0.70, 0.80, 0.88, 0.955)


class Wardrobe:
    """Dresses one person; `tone` is the skin's sRGB colour."""

    def __init__(self, shaper, tone):
        self.shaper, self.s, self.tone = shaper, shaper.s, np.asarray(tone)

    # ---- painters -------------------------------------------------------------------------------------------------

    def skin(self, part, points, u, v):
        colour = paint.skin(points, self.tone)
        if "hand" in part.name and "thumb" not in part.name:   # fingers: dark lines between them, nails left out
            fingers = 0.5 + 0.5 * np.cos(2 * np.pi * u * 8)
            colour = colour * (1 - 0.30 * (fingers ** 4) * smoothstep(0.42, 0.60, 1 - np.abs(v - 0.0)) * (v > 0.45))[..., None]
            colour = colour * np.array([1.0, 0.95, 0.94])
        if "leg" in part.name:
            knee = np.exp(-((along(part, v, "heights") - 0.50) / 0.035) ** 2)
            colour = colour * (1 - 0.08 * knee)[..., None]
        if part.name == "neck":
            colour = colour * (0.90 - 0.10 * smoothstep(0.5, 0.0, v))[..., None]
        return colour

    def tights(self, colour):
        def painter(part, points, u, v):
            edge = np.abs(np.sin(np.pi * (u * 2 - 0.5)))
            return mix(cloth(points, rgb(colour), np.zeros(u.shape), 5), self.tone * 0.8, 0.18 * edge)
        return painter

    def sleeve(self, base, seed, strength=1.0, trim=None, weave=0.035):
        def painter(part, points, u, v):
            t = along(part, v, "stations")
            amount = strength * (0.35 + 0.9 * np.exp(-((t - 1.0) / 0.22) ** 2) + 0.6 * np.exp(-((t - 0.1) / 0.2) ** 2) + 0.5 * np.exp(-((t - 1.85) / 0.12) ** 2))
            colour = cloth(points, rgb(base), folds(points, amount, seed, (10, 34, 10)), seed, weave)
            last = part.tags["stations"].max()
            colour = colour * (1 - 0.25 * line(t - last + 0.07, 0.015))[..., None]
            if trim:
                colour = mix(colour, rgb(trim), smoothstep(last - 0.05, last - 0.04, t))
            return colour
        return painter

    def trousers(self, base, seed, jeans=False, strength=1.0):
        base = rgb(base)

        def painter(part, points, u, v):
            if "heights" not in part.tags:
                return cloth(points, base, np.zeros(u.shape), seed)
            y = along(part, v, "heights")
            leg = part.name.startswith(("left", "right"))
            amount = strength * (0.30 + (0.9 * np.exp(-((y - 0.50) / 0.07) ** 2) + 1.0 * np.exp(-((y - 0.10) / 0.07) ** 2) if leg else 0) + 0.9 * np.exp(-((y - 0.84) / 0.06) ** 2))
            colour = base
            if jeans:   # worn thighs, yellow seams
                worn = smoothstep(0.30, 0.0, np.abs(u - 0.5)) * (np.exp(-((y - 0.66) / 0.13) ** 2) * 0.8 + 0.25)
                colour = mix(np.broadcast_to(base, points.shape), np.minimum(base * 1.9 + 0.10, 1), 0.38 * worn * (0.7 + 0.6 * noise.fractal(points * 40, 2, seed)))
            out = cloth(points, colour, folds(points, amount, seed, (8, 26, 8)), seed, 0.06 if jeans else 0.03)
            if leg:
                out = out * (1 - 0.20 * (line(np.abs(u - 0.5) - 0.25, 0.012)))[..., None]
                if not jeans:   # a pressed crease in front
                    out = out * (1 + 0.10 * line(u - 0.5, 0.02))[..., None]
                out = out * (1 - 0.25 * smoothstep(0.075, 0.06, y))[..., None]
            else:
                x = points[..., 0] / self.s
                out = out * (1 - 0.3 * line(x, 0.004) * (points[..., 2] > 0))[..., None]
                belt = smoothstep(0.975, 0.98, y)
                out = mix(out, np.array([0.12, 0.09, 0.07]), belt)
                buckle = belt * (np.abs(x) < 0.02) * (points[..., 2] > 0)
                out = mix(out, np.array([0.70, 0.68, 0.62]), buckle)
            return out
        return painter

    def shoe(self, upper, sole="#222222", toe=None):
        def painter(part, points, u, v):
            y = points[..., 1] / self.s
            z = (points[..., 2] - self.shaper.rig.at(f"{part.tags['side']}_foot")[2]) / self.s
            out = cloth(points, rgb(upper), folds(points, 0.5 * np.exp(-((z - 0.10) / 0.03) ** 2), 3, (12, 12, 40)), 9, 0.02)
            lace = (np.abs((z * 70) % 1 - 0.5) < 0.18) * (z > 0.03) * (z < 0.095) * (np.abs(u - 0.5) < 0.11)
            out = mix(out, np.clip(rgb(upper) * 0.55 + 0.25 * (rgb(upper).mean() < 0.4), 0, 1), 0.8 * lace)
            if toe:
                out = mix(out, rgb(toe), smoothstep(0.145, 0.15, z))
            return mix(out, rgb(sole), smoothstep(part.tags["sole"] + 0.003, part.tags["sole"], y))
        return painter

    def top(self, spec, seed):
        """Painter of a trunk garment: the cloth, then what its style adds."""
        base = rgb(spec["colour"])
        style = spec["style"]

        def painter(part, points, u, v):
            y = along(part, v, "heights")
            x, z = points[..., 0] / self.s, points[..., 2] / self.s
            front, ax = z > 0.0, np.abs(x)
            strength = spec.get("folds", 1.0)
            amount = strength * (0.35 + 0.6 * np.exp(-((y - 1.06) / 0.07) ** 2) + 0.7 * np.exp(-((ax - 0.15) / 0.05) ** 2) * np.exp(-((y - 1.26) / 0.10) ** 2) + 0.5 * smoothstep(1.0, 0.8, y))
            ground = base
            if "stripes" in spec:
                ground = mix(np.broadcast_to(base, points.shape), rgb(spec["stripes"]), ((y * 28) % 1 < 0.42).astype(float))
            if "dots" in spec:
                cell = np.hypot(((u * 44) % 1 - 0.5), ((y * 36 + 0.5 * (np.floor(u * 44) % 2)) % 1 - 0.5))
                ground = mix(np.broadcast_to(base, points.shape), rgb(spec["dots"]), smoothstep(0.26, 0.20, cell))
            if "check" in spec:
                a, b = ((u * 22) % 1 < 0.4).astype(float), ((y * 24) % 1 < 0.4).astype(float)
                ground = mix(np.broadcast_to(base, points.shape), rgb(spec["check"]), 0.35 * a + 0.35 * b)
            out = cloth(points, ground, folds(points, amount, seed), seed, spec.get("weave", 0.035))
            hem = part.tags["heights"].min()
            out = out * (1 - 0.22 * line(y - hem - 0.025, 0.006))[..., None]
            if style in ("shirt", "blouse"):
                out = out * (1 - 0.16 * line(ax - 0.016, 0.004) * front)[..., None]
                button = smoothstep(0.0065, 0.0045, np.hypot(x, (y % 0.085) - 0.04)) * front
                out = mix(out, np.array([0.86, 0.84, 0.80]) * (0.5 if base.mean() > 0.7 else 1), button * 0.9)
            if style == "blouse" or style == "vneck":
                depth = 1.355 if style == "blouse" else 1.34
                opening = smoothstep(0.004, -0.004, ax - (y - depth) * 0.42) * front
                out = mix(out * (1 - 0.3 * line(ax - (y - depth) * 0.42 - 0.006, 0.008) * front)[..., None], paint.skin(points, self.tone) * 0.96, opening)
            if style == "tee":
                neck = smoothstep(1.462, 1.468, y - 0.030 * smoothstep(0.10, 0.0, ax) * 0 + np.where(front, 0.022, 0.0) * smoothstep(0.09, 0.03, ax))
                out = mix(out * (1 - 0.2 * line(y - 1.45 + np.where(front, 0.022, 0.0) * smoothstep(0.09, 0.03, ax), 0.006))[..., None], paint.skin(points, self.tone), neck)
                if "print" in spec:
                    badge = smoothstep(0.075, 0.071, np.hypot(x, (y - 1.27) * 1.1)) * front
                    inner = smoothstep(0.05, 0.047, np.hypot(x - 0.012, (y - 1.28) * 1.1)) * front
                    out = mix(mix(out, rgb(spec["print"]), badge), base, inner)
            if style in ("jacket", "coat"):
                bottom = 1.10 if style == "jacket" else 1.28
                shirt = rgb(spec.get("shirt", "#e8ecf2"))
                width = np.clip((y - bottom) * (0.24 if style == "jacket" else 0.30), 0, 0.085)
                inside = smoothstep(0.005, -0.005, ax - width) * front * (y > bottom)
                under = cloth(points, shirt, folds(points, 0.4, seed + 1), seed + 1)
                if spec.get("tie"):
                    knot = np.interp(y, [1.12, 1.40, 1.43, 1.47], [0.034, 0.022, 0.016, 0.020])
                    under = mix(under, cloth(points, rgb(spec["tie"]) * (1 - 0.3 * ((x + y * 1.0) * 50 % 1 < 0.3))[..., None], np.zeros(u.shape), 3), smoothstep(0.002, -0.002, ax - knot))
                    under = under * (1 - 0.2 * line(ax - 0.045 - (1.48 - y) * 0.25, 0.006) * (y > 1.42))[..., None]
                else:
                    skin_v = smoothstep(0.005, -0.005, ax - (y - 1.405) * 0.6)
                    under = mix(under, paint.skin(points, self.tone), skin_v)
                out = mix(out, under, inside)
                lapel = smoothstep(0.002, -0.002, ax - width - np.interp(y, [bottom, 1.30, 1.385, 1.39, 1.47], [0.004, 0.060, 0.075, 0.052, 0.040])) * front * (1 - inside) * (y > bottom)
                out = out * (1 + 0.10 * lapel)[..., None]
                out = out * (1 - 0.40 * line(ax - width - np.interp(y, [bottom, 1.30, 1.385, 1.39, 1.47], [0.004, 0.060, 0.075, 0.052, 0.040]), 0.005) * front * (y > bottom) * (1 - inside))[..., None]
                out = out * (1 - 0.35 * line(x - 0.008, 0.005) * front * (y < bottom))[..., None]
                if style == "jacket":
                    button = smoothstep(0.010, 0.008, np.hypot(x - 0.012, (y - 1.07))) + smoothstep(0.010, 0.008, np.hypot(x - 0.012, (y - 0.97)))
                    pocket = line(y - 0.985, 0.007) * (np.abs(ax - 0.11) < 0.05) * front + line(y - 1.31, 0.006) * (np.abs(x - 0.095) < 0.035) * front
                    out = out * (1 - 0.35 * np.clip(pocket, 0, 1))[..., None]
                else:
                    button = sum(smoothstep(0.013, 0.011, np.hypot(ax - 0.05, y - level)) for level in (1.20, 1.10, 0.97)) * 1.0
                    belt = smoothstep(0.022, 0.020, np.abs(y - 1.045))
                    out = out * (1 - 0.22 * belt - 0.25 * line(np.abs(y - 1.045) - 0.022, 0.006))[..., None]
                out = mix(out, base * 0.35, np.clip(button, 0, 1) * front)
            if style == "hoodie":
                pocket = line(ax - (0.115 - 0.35 * np.clip(y - 0.98, 0, 0.13)), 0.006) * (y > 0.955) * (y < 1.11) + line(y - 1.11, 0.006) * (ax < 0.072)
                strings = line(ax - 0.035 - 0.1 * (1.45 - y), 0.006) * (y > 1.30) * (y < 1.46)
                out = out * (1 - 0.30 * np.clip(pocket, 0, 1) * front)[..., None]
                out = mix(out, np.array([0.92, 0.90, 0.85]), strings * front * 0.9)
            if style in ("hoodie", "sweater"):
                rib = smoothstep(hem + 0.06, hem + 0.055, y) + smoothstep(1.462, 1.468, y)
                out = out * (1 - 0.14 * np.clip(rib, 0, 1) * (0.5 + 0.5 * np.sign(np.sin(u * 2 * np.pi * 60))))[..., None]
            if style == "cardigan":
                width = 0.030 + np.clip(y - 1.0, 0, 1) * 0.075
                under = cloth(points, rgb(spec["shirt"]), folds(points, 0.5, seed + 1), seed + 1)
                under = mix(under, paint.skin(points, self.tone), smoothstep(1.425, 1.432, y - 0.3 * ax))
                out = out * (1 - 0.25 * line(ax - width - 0.018, 0.004) * front)[..., None]
                out = mix(out, under, smoothstep(0.005, -0.005, ax - width) * front)
            for strap in spec.get("straps", ()):
                colour = rgb(strap[1])
                if strap[0] == "backpack":
                    path = ax - 0.100 + 0.03 * smoothstep(1.30, 1.46, y)
                    band = smoothstep(0.026, 0.023, np.abs(path)) * (y > 1.12) * (front | (y > 1.40))
                else:   # across the chest, from the person's left hip over the right shoulder, or the other way round
                    sign = 1 if strap[0] == "left" else -1
                    band = smoothstep(0.022, 0.019, np.abs(sign * x * 0.80 - np.where(front, 1, 1) * (1.22 - y) * 0.55 + 0.0)) * (y < 1.47) * (y > 0.95)
                edge = 1 - 0.35 * smoothstep(0.3, 0.9, 1 - band) * (band > 0)
                out = mix(out * edge[..., None], cloth(points, colour, np.zeros(u.shape), 4), band)
            return out
        return painter

    # ---- parts ----------------------------------------------------------------------------------------------------

    def wear_top(self, spec, seed):
        """Trunk, sleeves and collar of a top; bare arms below short sleeves; hands."""
        shaper, parts = self.shaper, []
        style = spec["style"]
        loose = {"tee": 0.010, "shirt": 0.012, "blouse": 0.012, "vneck": 0.008, "jacket": 0.024, "coat": 0.030, "hoodie": 0.024, "sweater": 0.016, "cardigan": 0.017}[style] * spec.get("loose", 1.0)
        hem = spec.get("hem", 0.88)
        flare = spec.get("flare", 0.012)
        heights = [y for y in (0.40, 0.50, 0.60, 0.70, 0.78, 0.85, 0.90) if hem + 0.04 < y] if hem < 0.86 else []
        heights = [hem] + heights + [y for y in TRUNK if y > hem + 0.03]
        waisted = spec.get("waisted", 0.5)

        def ease(y):
            hang = flare * smoothstep(1.0, max(0.55, hem), y) * (1 + 2.5 * smoothstep(0.9, 0.5, y))
            straight = (1 - waisted) * 0.020 * np.exp(-((y - 1.08) / 0.07) ** 2)
            return loose * (1 - 0.55 * smoothstep(1.40, 1.49, y)) + hang + straight

        trunk = shaper.torso("trunk", heights, ease, columns=18, power=2.35, hem=0.025, texels=(240, 208 if hem > 0.7 else 264), paint=self.top(spec, seed))
        parts.append(trunk)
        parts.append(shaper.neck(self.skin))
        long_sleeves = spec.get("sleeves", "long") == "long"
        for side in ("left", "right"):
            sleeve_paint = self.sleeve(spec.get("sleeve_colour", spec["colour"]), seed + 2, spec.get("folds", 1.0), spec.get("cuffs"), spec.get("weave", 0.035))
            width = loose * 0.50 + 0.006
            if long_sleeves:
                parts.append(shaper.arm(f"{side}_sleeve", side, -0.115, 1.97, lambda t, w=width: w * (0.8 + 0.25 * np.exp(-((t - 0.9) / 0.3) ** 2)) + 0.004 * smoothstep(1.6, 1.95, t), cuff=0.4, texels=(72, 144), paint=sleeve_paint))
            else:
                end = {"short": 0.62, "none": 0.05, "elbow": 0.98}[spec["sleeves"]]
                if end > 0.1:
                    parts.append(shaper.arm(f"{side}_sleeve", side, -0.115, end, lambda t, w=width: w + 0.010 * smoothstep(0.0, 0.6, t), cuff=0.2, texels=(72, 64), paint=sleeve_paint))
                bare = self.skin
                parts.append(shaper.arm(f"{side}_arm", side, -0.115 if end < 0.1 else end - 0.25, 2.06, 0.0, texels=(48, 80), paint=bare))
            parts += shaper.hand(f"{side}_hand", side, self.skin)
        if style in ("shirt", "jacket", "coat"):
            parts.append(self.collar(spec))
        if style == "hoodie":
            hood = shaper.blob("hood", "chest", (0, shaper.lift(1.475), -0.075), np.array([0.115, 0.050, 0.070]), 12, 6, self.plain(spec["colour"], seed + 5), (64, 32), 2.2)
            parts.append(hood)
        return parts

    def collar(self, spec):
        shaper = self.shaper
        colour = spec.get("shirt") if spec["style"] == "jacket" else spec["colour"]
        ys = np.array([1.462, 1.484, 1.504, 1.510, 1.500])   # outside up, over the fold, a little down inside
        out = np.array([0.088, 0.077, 0.068, 0.064, 0.060]) - 0.006 * shaper.build.female
        rows, w = [], shaper.blank(len(ys), 14)
        from .body import ring_at, Part
        for y, r in zip(ys, out):
            ring = ring_at((0, shaper.lift(y), -0.014), (0, 1, 0.40), r, r * 0.94, r * 1.02, 14)
            rows.append(ring)
        w[..., shaper.j("neck")], w[..., shaper.j("chest")] = 0.45, 0.55
        return Part("collar", np.array(rows)[:, ::1] * self.s, w, (64, 20), self.plain(colour, 71))

    def plain(self, colour, seed, grain=0.035):
        def painter(part, points, u, v):
            return cloth(points, rgb(colour), folds(points, 0.4, seed), seed, grain)
        return painter

    def wear_bottom(self, spec, seed):
        shaper, parts = self.shaper, []
        style = spec["style"]
        if style in ("trousers", "jeans", "chinos", "leggings", "shorts"):
            fit = spec.get("fit", 0.5)   # 0 slim .. 1 wide
            painter = self.trousers(spec["colour"], seed, style == "jeans", spec.get("folds", 1.0) * (0.45 if style == "leggings" else 1.0))

            def ease(y):
                low = smoothstep(0.55, 0.12, y)
                wide = (0.002 if style == "leggings" else 0.008 + 0.010 * fit) + low * fit * 0.016
                wide -= 0.020 * smoothstep(0.78, 0.90, y)
                return np.array([wide, wide + low * fit * 0.006, wide - 0.006 * smoothstep(0.3, 0.38, y) * smoothstep(0.46, 0.38, y)])

            for side in ("left", "right"):
                if style == "shorts":
                    parts.append(shaper.leg(f"{side}_trouser", side, (0.46, 0.53, 0.60, 0.70, 0.80, 0.88, 0.955), lambda y: 0.012 + 0.02 * smoothstep(0.8, 0.46, y) - 0.024 * smoothstep(0.76, 0.90, y), cuff=0.15, texels=(88, 80), paint=painter))
                    parts.append(shaper.leg(f"{side}_leg", side, (0.05, 0.10, 0.18, 0.28, 0.37, 0.45, 0.50, 0.56), 0.0, columns=10, texels=(48, 80), paint=self.skin))
                else:
                    parts.append(shaper.leg(f"{side}_trouser", side, LEG_ROWS, ease, cuff=0.12, texels=(88, 176), paint=painter))
            parts.append(shaper.torso("pelvis", (0.80, 0.83, 0.88, 0.93, 0.97, 1.01), lambda y: 0.008 if y > 0.87 else 0.008 - 0.045 * (0.88 - y) / 0.08, columns=16, power=2.3, texels=(120, 48), paint=painter))
        else:
            legs = self.tights(spec["tights"]) if "tights" in spec else self.skin
            for side in ("left", "right"):
                parts.append(shaper.leg(f"{side}_leg", side, (0.05, 0.10, 0.18, 0.28, 0.37, 0.45, 0.50, 0.56, 0.66, 0.80), lambda y: -0.016 * smoothstep(0.58, 0.75, y), columns=10, texels=(56, 128), paint=legs))
            if style == "skirt":
                hem = spec.get("hem", 0.50)
                heights = [y for y in np.linspace(hem, 0.90, 6)] + [0.95, 1.0, 1.04]
                flare = spec.get("flare", 0.04)
                parts.append(shaper.torso("skirt", heights, lambda y: 0.010 + flare * smoothstep(0.92, hem, y), columns=18, power=2.2, hem=0.03, texels=(160, 112), paint=self.top({"colour": spec["colour"], "style": "skirt", "folds": 1.2, **{k: spec[k] for k in ("dots", "check", "stripes") if k in spec}}, seed)))
        return parts

    def wear_shoes(self, spec):
        painter = self.shoe(spec["colour"], spec.get("sole", "#1c1c1c"), spec.get("toe"))
        keys = {k: spec[k] for k in ("top", "sole_height", "pointed", "width") if k in spec}
        if "sole_height" in keys:
            keys["sole"] = keys.pop("sole_height")
        return [self.shaper.shoe(f"{side}_shoe", side, painter, **keys) for side in ("left", "right")]

    def carry(self, spec):
        """A bag: backpack, shoulder bag at the hip, or a handbag/briefcase in the left or right hand."""
        shaper, kind = self.shaper, spec["kind"]

        def painter(part, points, u, v):
            out = cloth(points, rgb(spec["colour"]), folds(points, 0.35, 41, (14, 14, 14)), 41, 0.05)
            if kind == "backpack":
                pocket = line(v - 0.58, 0.015) + line(v - 0.30, 0.012)
                return out * (1 - 0.4 * np.clip(pocket, 0, 1))[..., None]
            flap = line(v - 0.45, 0.02)
            clasp = smoothstep(0.03, 0.02, np.hypot(((u + 0.25) % 0.5) - 0.25, v - 0.45))
            return mix(out * (1 - 0.4 * flap)[..., None], np.array([0.75, 0.68, 0.45]), clasp * 0.8)

        if kind == "backpack":
            return [shaper.blob("bag", "chest", (0, shaper.lift(1.235), -0.185), np.array([0.138, 0.205, 0.080]) * spec.get("size", 1.0), 12, 8, painter, (96, 64), 3.5)]
        if kind in ("left", "right"):   # at the hip, hanging from the opposite shoulder
            sign = 1 if kind == "left" else -1
            return [shaper.blob("bag", "hips", (sign * 0.235, shaper.lift(0.93), -0.02), np.array([0.045, 0.105, 0.14]), 12, 7, painter, (96, 48), 4.0)]
        side = kind.split("_")[0]   # left_hand, right_hand
        wrist, up = shaper.arm_frame(side, 2.0)
        centre = wrist - up * 0.10 + np.array([0, -0.175, 0.015])
        parts = [shaper.blob("bag", f"{side}_hand", centre, np.array(spec.get("radii", (0.045, 0.13, 0.18))), 12, 7, painter, (96, 56), 4.5)]
        from .body import Part, ring_at
        top = centre[1] + spec.get("radii", (0.045, 0.13, 0.18))[1]
        path = [(-0.075, -0.01), (-0.06, 0.045), (0.0, 0.062), (0.06, 0.045), (0.075, -0.01)]
        rows = [ring_at((centre[0], top + y, centre[2] + z), d, 0.008, 0.008, 0.008, 5, facing=(1, 0, 0)) for (z, y), d in zip(path, ((0, 1, 0.3), (0, 0.5, 0.8), (0, 0, 1), (0, -0.5, 0.8), (0, -1, 0.3)))]
        handle = Part("handle", np.array(rows) * self.s, shaper.blank(5, 5), (16, 16), self.plain(spec["colour"], 43))
        return parts + [shaper._fixed(handle, f"{side}_hand")]
