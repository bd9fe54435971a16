"""Clothes, shoes and bags: which parts a garment has, how loose they are and how far they reach."""

import numpy as np

from ..noise import mix, smoothstep
from . import limbs, openings
from .fabrics import Fabrics
from .paint import cloth, folds, line, rgb
from .parts import Part, ring_at
from .tops import top_painter
from .trunk import TRUNK

LEG_ROWS = (0.055, 0.10, 0.20, 0.32, 0.42, 0.48, 0.53, 0.60, 0.70, 0.80, 0.88, 0.955)


class Wardrobe:
    """Dresses one person; `tone` is the skin's sRGB colour."""

    def __init__(self, shaper, tone):
        self.shaper, self.s, self.fabrics = shaper, shaper.s, Fabrics(shaper, tone)

    def wear_top(self, spec, seed):
        """Trunk, sleeves and collar of a top; bare arms below short sleeves; hands."""
        shaper, parts = self.shaper, []
        style = spec["style"]
        loose = {
            "tee": 0.010,
            "shirt": 0.012,
            "blouse": 0.012,
            "vneck": 0.008,
            "jacket": 0.024,
            "coat": 0.030,
            "hoodie": 0.024,
            "sweater": 0.016,
            "cardigan": 0.017,
        }[style] * spec.get("loose", 1.0)
        hem = spec.get("hem", 0.88)
        flare = spec.get("flare", 0.012)
        heights = [y for y in (0.40, 0.50, 0.60, 0.70, 0.78, 0.85, 0.90) if hem + 0.04 < y] if hem < 0.86 else []
        heights = [hem] + heights + [y for y in TRUNK if y > hem + 0.03]
        waisted = spec.get("waisted", 0.5)

        def ease(y):
            hang = flare * smoothstep(1.0, max(0.55, hem), y) * (1 + 2.5 * smoothstep(0.9, 0.5, y))
            straight = (1 - waisted) * 0.020 * np.exp(-(((y - 1.08) / 0.07) ** 2))
            return loose * (1 - 0.55 * smoothstep(1.40, 1.49, y)) + hang + straight

        trunk = shaper.torso(
            "trunk",
            heights,
            ease,
            columns=18,
            power=2.35,
            hem=0.025,
            texels=(240, 208 if hem > 0.7 else 264),
            paint=top_painter(self.fabrics, spec, seed),
        )
        parts.append(trunk)
        parts += openings.opening(shaper, self.fabrics, spec, seed, ease, hem)
        if style == "tee":
            parts += openings.neckline(shaper, self.fabrics, ease)
        self.ease = ease
        parts.append(shaper.neck(self.fabrics.skin))
        long_sleeves = spec.get("sleeves", "long") == "long"
        for side in ("left", "right"):
            sleeve_paint = self.fabrics.sleeve(
                spec.get("sleeve_colour", spec["colour"]),
                seed + 2,
                spec.get("folds", 1.0),
                spec.get("cuffs"),
                spec.get("weave", 0.035),
            )
            width = loose * 0.50 + 0.006
            if long_sleeves:
                parts.append(
                    limbs.arm(
                        shaper,
                        f"{side}_sleeve",
                        side,
                        -0.115,
                        1.97,
                        lambda t, w=width: w * (0.8 + 0.25 * np.exp(-(((t - 0.9) / 0.3) ** 2)))
                        + 0.004 * smoothstep(1.6, 1.95, t),
                        cuff=0.4,
                        texels=(72, 144),
                        paint=sleeve_paint,
                    )
                )
            else:
                end = {"short": 0.62, "none": 0.05, "elbow": 0.98}[spec["sleeves"]]
                if end > 0.1:
                    parts.append(
                        limbs.arm(
                            shaper,
                            f"{side}_sleeve",
                            side,
                            -0.115,
                            end,
                            lambda t, w=width: w + 0.010 * smoothstep(0.0, 0.6, t),
                            cuff=0.2,
                            texels=(72, 64),
                            paint=sleeve_paint,
                        )
                    )
                bare = self.fabrics.skin
                parts.append(
                    limbs.arm(
                        shaper,
                        f"{side}_arm",
                        side,
                        -0.115 if end < 0.1 else end - 0.25,
                        2.06,
                        0.0,
                        texels=(48, 80),
                        paint=bare,
                    )
                )
            parts += limbs.hand(shaper, f"{side}_hand", side, self.fabrics.skin)
        if style in ("shirt", "jacket", "coat"):
            parts.append(self.collar(spec))
        if style == "hoodie":
            hood = shaper.blob(
                "hood",
                "chest",
                (0, shaper.lift(1.475), -0.075),
                np.array([0.115, 0.050, 0.070]),
                12,
                6,
                self.fabrics.plain(spec["colour"], seed + 5),
                (64, 32),
                2.2,
            )
            parts.append(hood)
        return parts

    def collar(self, spec):
        shaper = self.shaper
        colour = spec.get("shirt") if spec["style"] == "jacket" else spec["colour"]
        ys = np.array([1.462, 1.484, 1.504, 1.510, 1.500])  # outside up, over the fold, a little down inside
        out = np.array([0.088, 0.077, 0.068, 0.064, 0.060]) - 0.006 * shaper.build.female
        rows, w = [], shaper.blank(len(ys), 14)
        for y, r in zip(ys, out):
            ring = ring_at((0, shaper.lift(y), -0.014), (0, 1, 0.40), r, r * 0.94, r * 1.02, 14)
            rows.append(ring)
        w[..., shaper.j("neck")], w[..., shaper.j("chest")] = 0.45, 0.55
        return Part("collar", np.array(rows)[:, ::1] * self.s, w, (64, 20), self.fabrics.plain(colour, 71))

    def wear_bottom(self, spec, seed):
        shaper, parts = self.shaper, []
        style = spec["style"]
        if style in ("trousers", "jeans", "chinos", "leggings", "shorts"):
            fit = spec.get("fit", 0.5)  # 0 slim .. 1 wide
            painter = self.fabrics.trousers(
                spec["colour"], seed, style == "jeans", spec.get("folds", 1.0) * (0.45 if style == "leggings" else 1.0)
            )

            def ease(y):
                low = smoothstep(0.55, 0.12, y)
                wide = (0.002 if style == "leggings" else 0.008 + 0.010 * fit) + low * fit * 0.016
                wide -= 0.020 * smoothstep(0.78, 0.90, y)
                return np.array(
                    [
                        wide,
                        wide + low * fit * 0.006,
                        wide - 0.006 * smoothstep(0.3, 0.38, y) * smoothstep(0.46, 0.38, y),
                    ]
                )

            for side in ("left", "right"):
                if style == "shorts":
                    parts.append(
                        limbs.leg(
                            shaper,
                            f"{side}_trouser",
                            side,
                            (0.46, 0.53, 0.60, 0.70, 0.80, 0.88, 0.955),
                            lambda y: 0.012 + 0.02 * smoothstep(0.8, 0.46, y) - 0.024 * smoothstep(0.76, 0.90, y),
                            cuff=0.15,
                            texels=(88, 80),
                            paint=painter,
                        )
                    )
                    parts.append(
                        limbs.leg(
                            shaper,
                            f"{side}_leg",
                            side,
                            (0.05, 0.10, 0.18, 0.28, 0.37, 0.45, 0.50, 0.56),
                            0.0,
                            columns=10,
                            texels=(48, 80),
                            paint=self.fabrics.skin,
                        )
                    )
                else:
                    parts.append(
                        limbs.leg(
                            shaper, f"{side}_trouser", side, LEG_ROWS, ease, cuff=0.12, texels=(88, 176), paint=painter
                        )
                    )
            parts.append(
                shaper.torso(
                    "pelvis",
                    (0.80, 0.83, 0.88, 0.93, 0.97, 1.01),
                    lambda y: 0.008 if y > 0.87 else 0.008 - 0.045 * (0.88 - y) / 0.08,
                    columns=16,
                    power=2.3,
                    texels=(120, 48),
                    paint=painter,
                )
            )
        else:
            legs = self.fabrics.tights(spec["tights"]) if "tights" in spec else self.fabrics.skin
            for side in ("left", "right"):
                parts.append(
                    limbs.leg(
                        shaper,
                        f"{side}_leg",
                        side,
                        (0.05, 0.10, 0.18, 0.28, 0.37, 0.45, 0.50, 0.56, 0.66, 0.80),
                        lambda y: -0.016 * smoothstep(0.58, 0.75, y),
                        columns=10,
                        texels=(56, 128),
                        paint=legs,
                    )
                )
            if style == "skirt":
                hem = spec.get("hem", 0.50)
                heights = [y for y in np.linspace(hem, 0.90, 6)] + [0.95, 1.0, 1.04]
                flare = spec.get("flare", 0.04)
                parts.append(
                    shaper.torso(
                        "skirt",
                        heights,
                        lambda y: 0.010 + flare * smoothstep(0.92, hem, y),
                        columns=18,
                        power=2.2,
                        hem=0.03,
                        texels=(160, 112),
                        paint=top_painter(
                            self.fabrics,
                            {
                                "colour": spec["colour"],
                                "style": "skirt",
                                "folds": 1.2,
                                **{k: spec[k] for k in ("dots", "check", "stripes") if k in spec},
                            },
                            seed,
                        ),
                    )
                )
        return parts

    def wear_shoes(self, spec):
        painter = self.fabrics.shoe(spec["colour"], spec.get("sole", "#1c1c1c"), spec.get("toe"))
        keys = {k: spec[k] for k in ("top", "sole_height", "pointed", "width") if k in spec}
        if "sole_height" in keys:
            keys["sole"] = keys.pop("sole_height")
        return [limbs.shoe(self.shaper, f"{side}_shoe", side, painter, **keys) for side in ("left", "right")]

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
            return [
                shaper.blob(
                    "bag",
                    "chest",
                    (0, shaper.lift(1.235), -0.185),
                    np.array([0.138, 0.205, 0.080]) * spec.get("size", 1.0),
                    12,
                    8,
                    painter,
                    (96, 64),
                    3.5,
                )
            ]
        if kind in ("left", "right"):  # at the hip, hanging from the opposite shoulder
            sign = 1 if kind == "left" else -1
            return [
                shaper.blob(
                    "bag",
                    "hips",
                    (sign * 0.235, shaper.lift(0.93), -0.02),
                    np.array([0.045, 0.105, 0.14]),
                    12,
                    7,
                    painter,
                    (96, 48),
                    4.0,
                )
            ]
        side = kind.split("_")[0]  # left_hand, right_hand
        wrist, up = limbs.arm_frame(shaper, side, 2.0)
        centre = wrist - up * 0.10 + np.array([0, -0.175, 0.015])
        parts = [
            shaper.blob(
                "bag",
                f"{side}_hand",
                centre,
                np.array(spec.get("radii", (0.045, 0.13, 0.18))),
                12,
                7,
                painter,
                (96, 56),
                4.5,
            )
        ]
        top = centre[1] + spec.get("radii", (0.045, 0.13, 0.18))[1]
        path = [(-0.075, -0.01), (-0.06, 0.045), (0.0, 0.062), (0.06, 0.045), (0.075, -0.01)]
        rows = [
            ring_at((centre[0], top + y, centre[2] + z), d, 0.008, 0.008, 0.008, 5, facing=(1, 0, 0))
            for (z, y), d in zip(path, ((0, 1, 0.3), (0, 0.5, 0.8), (0, 0, 1), (0, -0.5, 0.8), (0, -1, 0.3)))
        ]
        handle = Part(
            "handle", np.array(rows) * self.s, shaper.blank(5, 5), (16, 16), self.fabrics.plain(spec["colour"], 43)
        )
        return parts + [shaper.fixed(handle, f"{side}_hand")]
