"""scenes/hall: assembles the building, its furniture and baked light into hall.glb, and writes hall.json.

The picture the renderer makes is albedo * (ambient(normal) * baked + directional light); the bake stores what is missing to the
light that was computed: baked = (light - directional) / ambient, so the sum is the computed light.
"""

import json

import numpy as np
from PIL import Image

from . import hall_build, hall_plan, hall_routes, hall_textures, light, paint
from .glb import CLAMP, Glb
from .hall_build import ALBEDO, to_gltf
from .scene import Scene

MAP_WIDTH = 1024
SKY_LIGHT, GROUND_LIGHT = 4.6, 1.3           # radiance seen through windows, up and down
GLOW = {"departure_board": 0.4, "reception_desk": 2.0}
# lamp: places along it, height, radius of the sampled disc, area, radiance
LAMPS = {"pendant_pair": ((-0.9, 0.9), 0.0, 0.30, 0.332, 5.5), "downlights": ((-6.25, -3.75, -1.25, 1.25, 3.75, 6.25), -0.02, 0.09, 0.0314, 90.0), "light_line": ((-1.2, 0, 1.2), -0.04, 0.25, 0.13, 12.0)}
PROP_ALBEDO = 0.40
BOUNCES = (48, 48, 400)
AMBIENT_SKY, AMBIENT_GROUND = (1.08, 1.05, 1.01), (0.66, 0.62, 0.575)
KEY = {"color": (1.0, 0.97, 0.92), "intensity": 0.34, "direction": (-0.35, 0.62, -0.70)}   # soft light from the southern windows and the entrance
SELF_LIT = {"ceiling": 0.22}                 # emissive share, because the ambient light from below is weak
FLOOR_LEVEL = 0.84                           # the floor's median light in the picture


def ambient(normals):
    sky, ground = np.mean(AMBIENT_SKY), np.mean(AMBIENT_GROUND)
    return ground + (sky - ground) * (0.5 + 0.5 * normals[:, 2])


def key_light(normals):
    direction = np.array(KEY["direction"]) / np.linalg.norm(KEY["direction"])
    return np.maximum(0, -(normals @ direction)) * KEY["intensity"] * np.mean(KEY["color"])


def shoulder(values):
    """Film-like top end: nothing below 0.85 changes, brighter approaches 1.35."""
    return np.where(values < 0.85, values, 0.85 + 0.5 * (1 - np.exp(-(np.maximum(values, 0.85) - 0.85) / 0.5)))


def files():
    hall_routes.check()
    parts = hall_build.structure()
    plan = {name: (make(), places) for name, (make, places) in hall_plan.furniture().items()}
    used = light.pack([p.chart for p in parts], MAP_WIDTH)
    size = (MAP_WIDTH, 1 << (used - 1).bit_length())
    lightmap, prop_light = _bake(parts, plan, size)
    return {"hall.json": _scene(), "hall/hall.glb": _assemble(parts, plan, size, lightmap, prop_light), "hall/plan.json": _plan_file()}


def _turn(yaw):
    a = np.radians(yaw)
    return np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])


def _world(mesh, position, yaw):
    """Positions and normals of a prop's mesh (glTF frame) at its place in the world."""
    place = lambda v: np.stack([v[:, 0], -v[:, 2], v[:, 1]], axis=1)  # noqa: E731
    return place(mesh.positions @ _turn(yaw).T) + position, place(mesh.normals @ _turn(yaw).T)


def _bake(parts, plan, size):
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
                    room.add(points, mesh.triangles, PROP_ALBEDO if material != "leaf" else 0.15, GLOW.get(name, 0.6) if material == "glow" and name not in LAMPS else 0.0, owner=owner)
                if i in sample and material in ("props", "leaf"):
                    index.setdefault((name, k), []).append((len(sets), normals))
                    sets.append((points, normals, owner))
            if name in LAMPS:
                offsets, height, radius, area, radiance = LAMPS[name]
                for offset in offsets:
                    room.add_lamp(np.array(position) + (offset * np.cos(np.radians(yaw)), offset * np.sin(np.radians(yaw)), height), radius, area, radiance)
            owner += 1
    room.close(owner)
    vertex_light = room.bake([p.chart for p in parts], sets, BOUNCES)

    floor = np.concatenate([room.map[p.chart.rect[1]:p.chart.rect[1] + p.chart.rect[3], p.chart.rect[0]:p.chart.rect[0] + p.chart.rect[2]].reshape(-1) for p in parts if p.node.startswith("floor")])
    exposure = FLOOR_LEVEL / np.median(floor)
    print("floor light, percentiles:", np.round(np.percentile(floor * exposure, (1, 10, 50, 90, 99)), 2))
    out = np.full((size[1], size[0]), 0.5)
    for part in parts:
        x, y, w, h = part.chart.rect
        place, normals = light._texels(part.chart)
        level = shoulder(room.map[y:y + h, x:x + w].reshape(-1) * exposure) - SELF_LIT.get(part.material, 0) / ALBEDO[part.material]
        share = (level - key_light(normals)) / ambient(normals)
        block = np.clip(share, 0.02, 1).reshape(h, w)
        out[y - 1:y + h + 1, x - 1:x + w + 1] = np.pad(block, 1, mode="edge")
    props = {}
    for key, samples in index.items():
        levels = [shoulder(vertex_light[i] * exposure) / (ambient(normals) + key_light(normals)) for i, normals in samples]
        props[key] = np.clip(np.mean(levels, axis=0), 0.03, 1)
    return out, props


def _png(values):
    import io
    out = io.BytesIO()
    Image.fromarray((np.clip(values, 0, 1) * 255 + 0.5).astype(np.uint8), "L").save(out, "PNG", optimize=True)
    return out.getvalue()


def _assemble(parts, plan, size, lightmap, prop_light):
    glb = Glb("hall")

    def picture(name, image, quality=88, wrap=None):
        return glb.texture(glb.image(paint.jpeg(image, quality), "image/jpeg", name), **({} if wrap is None else {"wrap": wrap}))

    baked = glb.texture(glb.image(_png(lightmap), "image/png", "light"), CLAMP)
    atlas = picture("props", hall_textures.props(), 90, CLAMP)
    street = picture("outside", hall_textures.outside(), 88, CLAMP)
    plaster = picture("plaster", hall_textures.plaster())
    materials = {"floor": glb.material("floor", texture=picture("floor", hall_textures.floor(), 88), roughness=0.35, occlusion_texture=baked),
                 "plaster": glb.material("plaster", texture=plaster, roughness=0.9, occlusion_texture=baked),
                 "ceiling": glb.material("ceiling", texture=picture("ceiling", hall_textures.ceiling()), roughness=0.9, occlusion_texture=baked, emissive=(SELF_LIT["ceiling"],) * 3),
                 "concrete": glb.material("concrete", texture=picture("concrete", hall_textures.concrete()), roughness=0.8, occlusion_texture=baked),
                 "slats": glb.material("slats", texture=picture("slats", hall_textures.slats()), roughness=0.6, occlusion_texture=baked),
                 "trim": glb.material("trim", base=(0.07, 0.072, 0.078), roughness=0.5, occlusion_texture=baked),
                 "accent": glb.material("accent", base=(0.05, 0.14, 0.20), roughness=0.8, occlusion_texture=baked),
                 "carpet": glb.material("carpet", texture=plaster, base=(0.19, 0.20, 0.215), roughness=1.0, occlusion_texture=baked),
                 "props": glb.material("props", texture=atlas, roughness=0.6), "leaf": glb.material("leaf", texture=atlas, roughness=0.7, double_sided=True),
                 "glow": glb.material("glow", texture=atlas, unlit=True), "glass": glb.material("glass", base=(0.62, 0.72, 0.72, 0.13), roughness=0.1, alpha="BLEND", double_sided=True),
                 "outside": glb.material("outside", texture=street, unlit=True), "sky": glb.material("sky", base=(0.86, 0.92, 1.0), unlit=True)}
    root = glb.node("hall")
    _structure_nodes(glb, root, parts, size, materials)
    _outside_nodes(glb, root, materials)
    for name, (meshes, places) in plan.items():
        primitives = [glb.primitive(mesh.positions, mesh.normals, mesh.triangles, materials[material], uv=None if material == "glass" else mesh.uv,
                                    colors=np.repeat(prop_light[name, k][:, None], 3, axis=1) if (name, k) in prop_light else None) for k, (material, mesh) in enumerate(meshes)]
        mesh_index = glb.mesh(name, primitives)
        for node, position, yaw in places:
            a = np.radians(yaw) / 2
            glb.node(node, root, to_gltf(np.array(position, dtype=float)), (0, np.sin(a), 0, np.cos(a)), mesh=mesh_index)
    return glb.bytes()


def _structure_nodes(glb, root, parts, size, materials):
    groups = {}
    for part in parts:
        groups.setdefault(part.node, {}).setdefault(part.material, []).append(part)
    for node, by_material in groups.items():
        primitives = []
        for material, members in by_material.items():
            meshes = [part.mesh() for part in members]
            base = np.cumsum([0] + [len(m[0]) for m in meshes[:-1]])
            uv1 = np.concatenate([light.chart_uv(part.chart, m[3], size) for part, m in zip(members, meshes)])
            primitives.append(glb.primitive(to_gltf(np.concatenate([m[0] for m in meshes])), to_gltf(np.concatenate([m[1] for m in meshes])), np.concatenate([m[4] + b for m, b in zip(meshes, base)]),
                                            materials[material], uv=np.concatenate([m[2] for m in meshes]), uv1=uv1))
        glb.node(node, root, mesh=glb.mesh(node, primitives))


def _outside_nodes(glb, root, materials):
    """Pictures of the street behind the windows and bright panes over the skylights."""
    def sheet(node, corner, u, v, material):
        corner, u, v = (np.array(a, dtype=float) for a in (corner, u, v))
        points = np.array([corner, corner + u, corner + u + v, corner + v])
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        glb.node(node, root, mesh=glb.mesh(node, [glb.primitive(to_gltf(points), to_gltf(np.tile(normal, (4, 1))), [(0, 1, 2), (0, 2, 3)], materials[material], uv=[(0, 1), (1, 1), (1, 0), (0, 0)])]))

    sheet("outside_east", (39, 30, -1.9), (0, -44, 0), (0, 0, 14.0), "outside")
    sheet("outside_south", (42, -8, -2.4), (-54, 0, 0), (0, 0, 18.0), "outside")
    sheet("outside_north", (-6, 23, 2.0), (42, 0, 0), (0, 0, 6.0), "sky")
    x0, x1, y0, y1 = (f(s[k] for s in hall_build.SKYLIGHTS) for k, f in enumerate((min, max, min, max)))
    sheet("skylight_panes", (x0, y1, 7.28), (x1 - x0, 0, 0), (0, y0 - y1, 0), "sky")   # the ceiling hides what lies between the wells


def _scene():
    scene = Scene("hall", "A public hall of 30 m x 20 m with a gallery, its furniture, and people who walk, stand and talk.", seed=1)
    scene.environment(background=(0.75, 0.83, 0.92), sky=AMBIENT_SKY, ground=AMBIENT_GROUND)
    scene.model("hall", "hall/hall.glb")
    people = sorted({model for _, model, *_ in hall_plan.WALKERS + hall_plan.STANDERS}, key=lambda name: int(name.split("_")[1]))
    for model in people:
        scene.model(model, f"hall/{model}.glb", front="+z")
    scene.object("hall", "hall", "building")
    scene.light("daylight", "directional", **KEY)
    for name, points in hall_plan.ROUTES.items():
        scene.route(name, points, closed=True)
    for name, model, route, share, speed in hall_plan.WALKERS:
        start = round(share * hall_routes.length(hall_plan.ROUTES[route]), 2)
        scene.actor(name, model, "person", {"type": "route", "route": route, "speed": speed, "start_m": start, "mode": "loop", "clip": "walk"})
    for name, model, position, yaw, clip in hall_plan.STANDERS:
        scene.actor(name, model, "person", {"type": "stand", "clip": clip}, position=position, yaw_deg=yaw)
    for name, (description, position, look_at, vfov) in hall_plan.PLACES.items():
        scene.place(name, description, position, look_at, vfov)
    for name, size, fps in hall_plan.CAMERAS:
        scene.camera(name, name, size, fps)
    return scene.text()


def _plan_file():
    """Footprints for whoever plans ways through the hall: where the floor is and what stands on it."""
    plan = {"floor": [0.3, 0.3, hall_build.LENGTH - 0.3, hall_build.WIDTH - 0.3], "gallery": [0.3, 15.3, hall_build.LENGTH - 0.3, hall_build.WIDTH - 0.3, hall_build.GALLERY_Z],
            "obstacles": {name: list(rect) for name, rect in hall_plan.OBSTACLES.items()}}
    return (json.dumps(plan, indent=1) + "\n").encode()
