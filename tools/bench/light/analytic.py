"""build/light/bin/python -m tools.bench.light.analytic: the reference on cases with known answers; exit 1 where one is missed.

With Lambert surfaces units, camera and lights must give the known answers. Beside it is what the material of the bench, glTF's, makes of the
same: its surface mirrors some of the light and loses some between its microfacets.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from .export import Exported, Eye, Light
from .gltf import Material, Primitive
from .reference import Reference

BOUND = 0.01
GREY = Material("grey", base_color=(0.5, 0.5, 0.5, 1.0), roughness=1.0, metallic=0.0)
PANE = Material("pane", base_color=(1.0, 1.0, 1.0, 1.0), roughness=0.0, metallic=0.0, transmission=0.9)
#: From 2 m above, straight down: x right, y of the picture to -y, z down.
DOWN = Eye((33, 33), 20.0, np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 2.0], [0, 0, 0, 1]]))


def floor(tilt_deg: float = 0.0, material: Material = GREY) -> Primitive:
    """A square of 20 m about the origin, its normal tilted from up towards +x."""
    c, s = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    corners = np.array([[-10, -10, 0], [10, -10, 0], [10, 10, 0], [-10, 10, 0.0]])
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return Primitive(corners @ turn.T, np.tile(turn @ [0, 0, 1.0], (4, 1)), np.ones((4, 4)), None, np.array([[0, 1, 2], [0, 2, 3]]), material)


def seen(surface: Primitive, lights: list[Light], sky: float, ground: float) -> tuple[float, float]:
    """Light of the picture's middle: of a Lambert surface, and of glTF's."""
    exported = Exported([surface], lights, np.full(3, sky), np.full(3, ground), np.zeros(3), exposure=1.0, glow=1.0)
    pictures = [Reference(exported, DOWN, is_lambert=is_lambert).light(256, 1) for is_lambert in (True, False)]
    return float(pictures[0][14:19, 14:19].mean()), float(pictures[1][14:19, 14:19].mean())


def main() -> int:
    sun = Light("directional", math.pi * np.full(3, 0.8), direction=np.array([0, 0, -1.0]))
    lamp = Light("point", math.pi * np.full(3, 2.0), position=np.array([3.0, 0, 4.0]))
    cases = {
        "white furnace: grey in a world of 1": (seen(floor(), [], 1.0, 1.0), 0.5),
        # What comes straight through is the background, which is black here.
        "a pane in a world of 1: what it mirrors, 2 F / (1 + F), and scatters": (seen(floor(material=PANE), [], 1.0, 1.0), 1 - 0.9 * (1 - 0.08 / 1.04)),
        "a ball's place at 60 degrees under sun": (seen(floor(60), [sun], 0.0, 0.0), 0.5 * 0.8 * 0.5),
        "a ball's place at 60 degrees, half sky 0.9, ground 0.3": (seen(floor(60), [], 0.9, 0.3), 0.5 * (0.9 * 0.75 + 0.3 * 0.25)),
        "one lamp over a floor, aslant": (seen(floor(), [lamp], 0.0, 0.0), 0.5 * 2.0 * 4.0 / 5.0**3),
    }
    missed = 0
    for name, ((found, material), expected) in cases.items():
        is_met = abs(found / expected - 1) <= BOUND
        missed += not is_met
        print(f"{'met' if is_met else 'MISSED'}: {name}: {found:.4f}, expected {expected:.4f} ({100 * (found / expected - 1):+.2f} %); glTF {100 * (material / expected - 1):+.1f} %")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
