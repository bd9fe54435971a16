"""In which colours the pieces of a person come, and what of them is worn when: the materials of a model.

Each piece (skin, hair, top, ...) is painted in its own colours, and then its picture is divided by one colour, the
material's: so another colour of the material gives the same cloth in another dye, with its folds and seams
(docs/decisions/0175-people-that-differ.md). What has no dye (eyes, shirts below a jacket) keeps its colours.
"""

from dataclasses import dataclass, field

import numpy as np

from .paint import rgb

SKINS = "#f0c8ae #e9c2a4 #e6bd9c #dfae90 #d8a382 #d09a76 #c9946c #b98058 #a06a46 #8d5a3b #7a4a30 #5e3a24".split()
HAIRS = "#17120f #14100e #241a14 #2e2117 #2a1a12 #3b2417 #4a2f1c #5a3a22 #6b4526 #8a5a30 #b48a4c #7a3318".split()
PATTERNS = ("dots", "print")
GREYS = "#8c8884 #b4b0aa #6a6662".split()
TOPS = (
    "#e6e4de #d4d0c6 #9a9c9e #5c6066 #34373c #1e1f23 #27324d #3a5a8c #7fa0c4 #2c6a6e #2f6650 #6d7a4a "
    "#545a36 #c98e22 #d8b45a #b99464 #7a5a3c #a8432c #b02a2c #7c1f2b #c67a86 #8a5a86 #5c2c52 #d9a184"
).split()
BOTTOMS = "#1e1f23 #2a2c31 #3c3f45 #5c5f63 #262f47 #34507a #4a6484 #23303c #4a4034 #5d5a4c #8a7a5c #b9a57f #3e2c24".split()
SHOES = "#1d1512 #2a1b14 #4a2f1d #6b4a30 #16161a #3c3f45 #cfcac0 #8a2c24 #2c3c5c #b0a48c".split()
BAGS = "#202228 #35463f #6e2a22 #4a2f1d #27324d #8a7a5c #b06a2c #5c5f63 #a8432c".split()
HATS = "#1e1f23 #27324d #7c1f2b #545a36 #8c8884 #d4d0c6 #b99464 #34507a #c98e22".split()


def linear(colour):
    colour = np.asarray(colour, dtype=np.float64)
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def srgb(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


@dataclass
class Piece:
    """A material: `own` is its colour on the person as written, `ground` what is left in the picture of that."""

    name: str
    own: object = None  # sRGB; None: it has no dye
    ground: object = None
    colours: tuple = ()
    dye: str = None
    choice: str = None  # it is there where the number drawn for this is in `share`
    share: tuple = (0.0, 1.0)
    shown: bool = True
    parts: list = field(default_factory=list)

    @property
    def factor(self):
        """Of the material, linear."""
        return np.ones(3) if self.own is None else self._factor(self.own)

    def _factor(self, colour):
        return np.clip(linear(colour) / linear(self.ground), 1e-3, 1)

    def painted(self, pixels):
        """A picture in its own colours as the material wants it."""
        return srgb(linear(pixels) / self.factor)

    def extras(self):
        made = {}
        if self.colours:
            made["colors"] = [[round(float(v), 4) for v in self._factor(rgb(c))] for c in self.colours]
        if self.dye:
            made["dye"] = self.dye
        if self.choice:
            made.update(choice=self.choice, **{"from": self.share[0], "to": self.share[1]})
        if not self.shown:
            made["shown"] = False
        return {"camrig_variants": made} if made else None


def grey(least, colour=(0, 0, 0)):
    """The ground of a cloth: grey, and not darker than the cloth itself."""
    return np.full(3, max(least, float(np.max(colour))))


def cloth(name, own, colours, **keywords):
    own = rgb(own)
    return Piece(name, own, grey(0.80, own), tuple(colours), **keywords)


def _patterned(name, own, colours, has_pattern):
    """Cloth; where it has a pattern the ground leaves room for what is brighter, and the dyes are not bright."""
    if not has_pattern:
        return Piece(name, own, grey(0.80, own), tuple(colours))
    return Piece(name, own, np.full(3, 0.55), tuple(c for c in colours if max(rgb(c)) < 0.6))


def pieces_of(spec):
    """The materials of a person but for what may be worn: {name: Piece}."""
    skin, hair = rgb(spec["skin"]), rgb(spec["hair"]["colour"])
    bottom = rgb(spec["bottom"].get("colour", spec["top"]["colour"]))
    made = [
        Piece("skin", skin, np.maximum(rgb("#f2cdb4"), skin), tuple(SKINS)),
        Piece("hair", hair, grey(0.72, hair), tuple(HAIRS if spec["build"]["height"] < 1.5 else HAIRS + GREYS)),
        _patterned("top", rgb(spec["top"]["colour"]), TOPS, any(key in spec["top"] for key in PATTERNS)),
        _patterned("bottom", bottom, BOTTOMS, spec["bottom"]["style"] == "jeans" or "dots" in spec["bottom"]),
        cloth("shoes", spec["shoes"]["colour"], SHOES),
        Piece("plain"),
    ]
    return {piece.name: piece for piece in made}


def piece_of(part, spec):
    """The piece that a part of the body or of clothes is of."""
    if part.piece:
        return part.piece
    name = part.name.removeprefix("left_").removeprefix("right_")
    if name in ("trunk", "sleeve", "hood", "collar"):
        return "plain" if name == "collar" and spec["top"]["style"] == "jacket" else "top"
    if name in ("trouser", "pelvis", "skirt"):
        return "bottom"
    if name == "leg" and "tights" in spec["bottom"]:
        return "plain"
    return {"shoe": "shoes"}.get(name, "skin")
