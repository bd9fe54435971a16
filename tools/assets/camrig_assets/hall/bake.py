"""Computes the hall's light and turns it into what the renderer multiplies its ambient light with.

The picture the renderer makes is albedo * (ambient(normal) * baked + directional light); the bake stores what the
directional light lacks to the computed light: baked = (light - directional) / ambient. Where the hall shades itself from the
directional light, only the levels without shadows draw it; SHADED of the computed light is baked there in any case, or those places
were black with shadows.
"""

import numpy as np

from . import light
from .structure import ALBEDO

SKY_LIGHT, GROUND_LIGHT = 4.6, 1.3  # radiance seen through windows, up and down
GLOW = {"departure_board": 0.4, "reception_desk": 2.0}
# lamp: places along it, height, radius of the sampled disc, area, radiance
LAMPS = {
    "pendant_pair": ((-0.9, 0.9), 0.0, 0.30, 0.332, 5.5),
    "downlights": ((-6.25, -3.75, -1.25, 1.25, 3.75, 6.25), -0.02, 0.09, 0.0314, 90.0),
    "light_line": ((-1.2, 0, 1.2), -0.04, 0.25, 0.13, 12.0),
}
PROP_ALBEDO = 0.40
BOUNCES = (48, 48, 400)


AMBIENT_SKY, AMBIENT_GROUND = (1.08, 1.05, 1.01), (0.66, 0.62, 0.575)
KEY = {
    "color": (1.0, 0.97, 0.92),
    "intensity": 0.34,
    "direction": (-0.35, 0.62, -0.70),
}  # soft light from the southern windows and the entrance
SELF_LIT = {"ceiling": 0.22}  # emissive share, because the ambient light from below is weak
SHADED = 0.5
FLOOR_LEVEL = 0.84  # the floor's median light in the picture


def ambient(normals):
    sky, ground = np.mean(AMBIENT_SKY), np.mean(AMBIENT_GROUND)
    return ground + (sky - ground) * (0.5 + 0.5 * normals[:, 2])


def key_light(normals):
    direction = np.array(KEY["direction"]) / np.linalg.norm(KEY["direction"])
    return np.maximum(0, -(normals @ direction)) * KEY["intensity"] * np.mean(KEY["color"])


def shoulder(values):
    """Film-like top end: nothing below 0.85 changes, brighter approaches 1.35."""
    return np.where(values < 0.85, values, 0.85 + 0.5 * (1 - np.exp(-(np.maximum(values, 0.85) - 0.85) / 0.5)))


def _turn(yaw):
    a = np.radians(yaw)
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def _world(mesh, position, yaw):
    """Positions and normals of a prop's mesh (glTF frame) at its place in the world."""
    place = lambda v: np.stack([v[:, 0], -v[:, 2], v[:, 1]], axis=1)  # noqa: E731
    return place(mesh.positions @ _turn(yaw).T) + position, place(mesh.normals @ _turn(yaw).T)


def bake(parts, plan, size):
    room = light.Room(size, SKY_LIGHT, GROUND_LIGHT)
    for part in parts:
        points, _, _, st, triangles = part.mesh()
        room.add(points, triangles, part.chart.albedo, uv1=light.chart_uv(part.chart, st, size))
    sets, index, owner = [], {}, 0
    for name, (meshes, places) in plan.items():
        sample = set(np.linspace(0, len(places) - 1, min(4, len(places))).astype(int))
        for i, (_, position, yaw) in enumerate(places):
            for k, (material, mesh) in enumerate(meshes):
                points, normals = _world(mesh, position, yaw)
                if material != "glass":
                    room.add(
                        points,
                        mesh.triangles,
                        PROP_ALBEDO if material != "leaf" else 0.15,
                        GLOW.get(name, 0.6) if material == "glow" and name not in LAMPS else 0.0,
                        owner=owner,
                    )
                if i in sample and material in ("props", "leaf"):
                    index.setdefault((name, k), []).append((len(sets), normals))
                    sets.append((points, normals, owner))
            if name in LAMPS:
                offsets, height, radius, area, radiance = LAMPS[name]
                for offset in offsets:
                    room.add_lamp(
                        np.array(position)
                        + (offset * np.cos(np.radians(yaw)), offset * np.sin(np.radians(yaw)), height),
                        radius,
                        area,
                        radiance,
                    )
            owner += 1
    room.close(owner)
    vertex_light = room.bake([p.chart for p in parts], sets, BOUNCES)

    floor = np.concatenate(
        [
            room.map[
                p.chart.rect[1] : p.chart.rect[1] + p.chart.rect[3], p.chart.rect[0] : p.chart.rect[0] + p.chart.rect[2]
            ].reshape(-1)
            for p in parts
            if p.node.startswith("floor")
        ]
    )
    exposure = FLOOR_LEVEL / np.median(floor)
    print("floor light, percentiles:", np.round(np.percentile(floor * exposure, (1, 10, 50, 90, 99)), 2))
    out = np.full((size[1], size[0]), 0.5)
    for part in parts:
        x, y, w, h = part.chart.rect
        place, normals = light._texels(part.chart)
        level = (
            shoulder(room.map[y : y + h, x : x + w].reshape(-1) * exposure)
            - SELF_LIT.get(part.material, 0) / ALBEDO[part.material]
        )
        share = np.maximum(level - key_light(normals), SHADED * level) / ambient(normals)
        block = np.clip(share, 0.02, 1).reshape(h, w)
        out[y - 1 : y + h + 1, x - 1 : x + w + 1] = np.pad(block, 1, mode="edge")
    props = {}
    for key, samples in index.items():
        levels = [
            shoulder(vertex_light[i] * exposure) / (ambient(normals) + key_light(normals)) for i, normals in samples
        ]
        props[key] = np.clip(np.mean(levels, axis=0), 0.03, 1)
    return out, props
