"""Houses in closed rows and free-standing: facades of textured storeys above a ground floor with shops and doors."""

import numpy as np

from .builder import block, wall
from .surfaces import BAY_M, BAYS, STOREY_M, STOREYS, scaled

SHOP_M = 3.9  # height of a ground floor
FACADE_M = (BAYS * BAY_M, STOREYS * STOREY_M)
AWNINGS = ("#7a2e2a", "#2f5d50", "#33507a", "#8a6a2f", "#5b3a66")
FASCIAS = ("#2a2f33", "#5a2a25", "#24483e", "#d8cfb9", "#2b3f5c")


class Row:
    """Facades along a straight line; the street is to the right of who walks from `start` along `direction`."""

    def __init__(self, builder, start, direction):
        self.builder, self.start = builder, np.asarray(start, dtype=float)
        self.along = np.asarray(direction, dtype=float)
        self.out = np.array([self.along[1], -self.along[0]])  # to the street

    def at(self, s, out=0.0):
        return self.start + self.along * s + self.out * out

    def box(self, s0, s1, out0, out1, z0, z1, material, colour, cells=1):
        a, b = self.at(s0, out0), self.at(s1, out1)
        low, high = np.minimum(a, b), np.maximum(a, b)
        self.builder.add(block((*low, z0), (*high, z1), cells=cells), material, colour)

    def face(self, s0, s1, z0, z1, material, colour=(1, 1, 1), out=0.0, texture=False, cell=1.6):
        mesh = wall(self.at(s0, out), self.at(s1, out), z0, z1, cell)
        self.builder.add(scaled(mesh, FACADE_M) if texture else mesh, material, colour)

    def house(self, s0, bays, storeys, look, seed, depth=10.0, shops=True):
        """One house from s0 on; returns where it ends."""
        random = np.random.default_rng(seed)
        s1, top = s0 + bays * BAY_M, SHOP_M + storeys * STOREY_M
        self.face(s0, s1, SHOP_M, top, look, texture=True)
        self._ground_floor(s0, bays, random, shops)
        stone = (0.60, 0.57, 0.52)
        self.box(s0, s1, 0, 0.14, SHOP_M - 0.05, SHOP_M + 0.16, "plain", stone, {"front": (bays * 2, 1), "back": (bays * 2, 1)})
        self.box(s0 - 0.02, s1 + 0.02, -0.3, 0.38, top, top + 0.35, "plain", stone)
        # Sides and roof, as far as they show between houses of different heights.
        for end, other in ((self.at(s0), self.at(s0, -depth)), (self.at(s1, -depth), self.at(s1))):
            self.builder.add(wall(other, end, 0, top + 0.3, 2.5), "plain", (0.42, 0.39, 0.36))
        self.box(s0, s1, -depth, -0.3, top, top + 0.3, "plain", (0.20, 0.19, 0.19))
        for k in range(int(random.integers(1, 3))):
            s = s0 + (s1 - s0) * (0.25 + 0.5 * k) + random.uniform(-0.5, 0.5)
            self.box(s, s + 0.9, -4.2, -3.4, top + 0.3, top + 1.6, "plain", (0.30, 0.16, 0.12))
        return s1

    def _ground_floor(self, s0, bays, random, shops):
        """Bays of shop windows with a door in one of them; piers between; a fascia with an awning above."""
        width = bays * BAY_M
        colour = np.array([0.50, 0.46, 0.40]) * random.uniform(0.7, 1.15)
        self.face(s0, s0 + width, 0, SHOP_M, "plain", colour * 0.8, out=-0.25)
        for k in range(bays + 1):
            self.box(s0 + k * BAY_M - 0.22, s0 + k * BAY_M + 0.22, -0.25, 0.06, 0, SHOP_M, "plain", colour, 2)
        door = int(random.integers(0, bays))
        accent = FASCIAS[int(random.integers(0, len(FASCIAS)))]
        for k in range(bays):
            a, b = s0 + k * BAY_M + 0.22, s0 + (k + 1) * BAY_M - 0.22
            if k == door:
                self.box(a, b, -0.25, -0.02, 2.55, SHOP_M, "plain", colour)
                # The pavement ends at the front; a sill closes the way down between it and the door.
                self.box(a, b, -0.25, 0.01, -0.05, 0.03, "plain", colour)
                self.face(a, b, 0.0, 2.55, "glass", (0.045, 0.055, 0.06), out=-0.2, cell=0.8)
                for s in (a, (a + b) / 2 - 0.05, b - 0.10):
                    self.box(s, s + 0.10, -0.21, -0.10, 0, 2.55, "plain", accent)
                continue
            self.box(a, b, -0.25, 0.0, 0, 0.55, "plain", accent, 2)
            self.box(a, b, -0.25, 0.02, 3.05, 3.75, "plain", accent, 2)
            self.face(a, b, 0.55, 3.05, "glass", (0.07, 0.085, 0.095), out=-0.16, cell=0.7)
            for s in (a, (a + b) / 2 - 0.03, b - 0.06):
                self.box(s, s + 0.06, -0.17, -0.08, 0.55, 3.05, "plain", accent)
            if shops:
                self._display(a, b, random)
        if shops and random.uniform() < 0.75:
            self._awning(s0 + 0.3, s0 + width - 0.3, AWNINGS[int(random.integers(0, len(AWNINGS)))])

    def _display(self, a, b, random):
        """Coloured things behind the window, drawn on its pane."""
        s = a + 0.2
        while s < b - 0.35:
            w, h = random.uniform(0.2, 0.5), random.uniform(0.3, 1.1)
            tone = random.uniform(0.06, 0.42) * np.array([random.uniform(0.6, 1), random.uniform(0.5, 1), random.uniform(0.4, 1)])
            self.face(s, min(s + w, b - 0.15), 0.62, 0.62 + h, "plain", tone, out=-0.155, cell=2)
            s += w + random.uniform(0.05, 0.35)

    def _awning(self, s0, s1, colour):
        from .builder import linear, to_file
        from ..shapes import quad

        base = linear(colour)
        count = max(2, round((s1 - s0) / 0.5))
        for k in range(count):
            a, b = s0 + (s1 - s0) * k / count, s0 + (s1 - s0) * (k + 1) / count
            tone = base if k % 2 else np.array([0.72, 0.69, 0.62])
            upper = [(*self.at(s, 0.03), 3.2) for s in (a, b)]
            lower = [(*self.at(s, 1.25), 2.72) for s in (a, b)]
            hem = [(*self.at(s, 1.25), 2.5) for s in (a, b)]
            for low, high in ((lower, upper), (hem, lower)):
                top = quad(*(to_file(p) for p in (low[0], low[1], high[1], high[0])), cells=(1, 2))
                under = quad(*(to_file(p) for p in (low[1], low[0], high[0], high[1])))
                self.builder.add(top, "plain", tone)
                self.builder.add(under, "plain", tone * 0.6)
