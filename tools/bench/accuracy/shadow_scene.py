"""Boxes over level ground in the light of the sun, a spot or a point light, and the texels of their shadow maps."""

import pathlib
from dataclasses import dataclass

import numpy as np
from camrig_assets.glb import Glb
from camrig_assets.scene import Scene

#: Texels along a side of a shadow map, and how much larger it is than what it shows: core/render/shadow_plan.{h,cpp}.
MAP_SIDE, MAP_MARGIN, MOST_EXTENT_M = 2048, 1.02, 200.0
#: Where a texel of the sun's map would be larger than this and there are two maps at most, they have so many along a side.
COARSE_TEXEL_M, FINE_MAP_SIDE = 0.03, 4096
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


@dataclass(frozen=True)
class Light:
    """One of each kind that casts shadows. `towards`: of the sun and of spots; `place`: of lamps."""

    name: str
    kind: str
    towards: tuple = ()
    place: tuple = ()
    cone_deg: float = 0.0

    def fields(self):
        found = {"intensity": 0.9 if self.kind == "directional" else 120.0}
        if self.towards:
            found["direction"] = list(self.towards)
        if self.place:
            found["position"] = list(self.place)
        if self.cone_deg:
            found |= {"outer_cone_deg": self.cone_deg, "inner_cone_deg": self.cone_deg - 2}
        return found

    def on_ground(self, points):
        """Where light that touches the points (N, 3) meets z = 0."""
        way = np.array(self.towards, dtype=float) if self.kind == "directional" else points - np.array(self.place)
        return points - way * (points[:, 2] / way[..., 2])[:, None]

    def way_to(self, points):
        """Unit directions in which light arrives at points."""
        way = np.broadcast_to(self.towards, points.shape) if self.kind == "directional" else points - np.array(self.place)
        return way / np.linalg.norm(way, axis=1, keepdims=True)

    def texel_m(self, points, ground):
        """The longer side of a texel where the points are, if there is no other light."""
        if self.kind == "directional":
            z = np.array(self.towards, dtype=float) / np.linalg.norm(self.towards)
            aside = (0.0, 0.0, 1.0) if abs(z[2]) < 0.9 else (1.0, 0.0, 0.0)
            x = np.cross(aside, z)
            x /= np.linalg.norm(x)
            corners = ground.bounds()
            sides = [np.ptp(corners @ axis) for axis in (x, np.cross(z, x))]
            side_m = MAP_MARGIN * min(max(sides), MOST_EXTENT_M)
            return np.full(len(points), side_m / (FINE_MAP_SIDE if side_m / MAP_SIDE > COARSE_TEXEL_M else MAP_SIDE))
        away = points - np.array(self.place)
        if self.kind == "spot" and self.cone_deg < np.degrees(1.3):
            axis = np.array(self.towards, dtype=float) / np.linalg.norm(self.towards)
            return 2 * MAP_MARGIN * np.tan(np.radians(self.cone_deg)) / MAP_SIDE * (away @ axis)
        return 2 * MAP_MARGIN / MAP_SIDE * np.abs(away).max(axis=1)  # sides of a cube: a point light's lie along the world's axes


SUN = Light("sun, 45 deg high", "directional", towards=(0.6, 0.8, -1.0))
HIGH_SUN = Light("sun, 75 deg high", "directional", towards=(0.6, 0.8, -3.732))
LOW_SUN = Light("sun, 15 deg high", "directional", towards=(0.6, 0.8, -0.268))
SPOT = Light("spot", "spot", towards=(0.1, 0.05, -1.0), place=(-0.4, 0.3, 12.0), cone_deg=40.0)
POINT = Light("point", "point", place=(0.3, -0.2, 10.0))
LIGHTS = (SUN, LOW_SUN, SPOT, POINT)


@dataclass(frozen=True)
class Ground:
    """Boxes with sides of `side_m` over a square of ground of `extent_m`, `spacing_m` apart."""

    extent_m: float
    side_m: float = 0.6
    height_m: float = 1.4  # of their middles
    spacing_m: float = 2.4
    count: int = 5  # along a side of the grid

    def middles(self):
        at = (np.arange(self.count) - (self.count - 1) / 2) * self.spacing_m
        return np.array([(x + 0.13 * y, y - 0.07 * x, self.height_m) for x in at for y in at])

    def corners(self):
        """(boxes, 8, 3), as the file holds the places."""
        return np.round(self.middles(), 4)[:, None] + CORNERS * self.side_m / 2

    def bounds(self):
        """Corners of the box around all that light may fall on."""
        half, top = self.extent_m / 2, self.height_m + self.side_m / 2
        return np.array([(x * half, y * half, z) for x in (-1, 1) for y in (-1, 1) for z in (0.0, top)])

    def write(self, folder, lights, boxes):
        """A scene file: no light but these, on matt white ground. boxes: none, things, standing (actors, who could move) or walking."""
        folder = pathlib.Path(folder)
        glb = Glb("ground")
        white = glb.material("white", base=(1, 1, 1), roughness=1.0, metallic=0.0)
        half = self.extent_m / 2
        flat = [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]
        glb.node("ground", mesh=glb.mesh("ground", [glb.primitive(flat, [(0, 1, 0)] * 4, [(0, 1, 2), (0, 2, 3)], white)]))
        (folder / "ground.glb").write_bytes(glb.bytes())
        scene = Scene("shadows", "Boxes over level ground.", seed=1)
        scene.environment(background=(0, 0, 0), sky=(0, 0, 0), ground=(0, 0, 0))
        scene.model("ground", "ground.glb")
        scene.object("ground", "ground", "ground")
        if boxes != "none":
            (folder / "box.glb").write_bytes(box(self.side_m))
            scene.model("box", "box.glb")
            for i, middle in enumerate(self.middles()):
                at = [float(v) for v in middle]
                if boxes == "things":
                    scene.object(f"box{i}", "box", "box", position=at)
                elif boxes == "standing":
                    scene.actor(f"box{i}", "box", "box", {"type": "stand"}, position=at)
                else:
                    scene.route(f"round{i}", [(at[0] + x * self.side_m, at[1] + y * self.side_m, at[2]) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], closed=True)
                    scene.actor(f"box{i}", "box", "box", {"type": "route", "route": f"round{i}"})
        for light in lights:
            scene.light(light.kind, light.kind, **light.fields())
        path = folder / f"{boxes}.json"
        path.write_bytes(scene.text())
        return path


def box(side_m):
    """A file with a cube around the origin."""
    glb = Glb("box")
    grey = glb.material("grey", base=(0.5, 0.5, 0.5), roughness=1.0, metallic=0.0)
    points, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            across = np.roll(np.eye(3), -axis, axis=0)  # the axis, and two beside it
            first = len(points)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                points.append((sign * across[0] + sign * a * across[1] + b * across[2]) * side_m / 2)
                normals.append(sign * across[0])
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    glb.node("box", mesh=glb.mesh("box", [glb.primitive(points, normals, triangles, grey)]))
    return glb.bytes()
