"""scenes/hall: puts the building, its furniture and the baked light into hall.glb."""

import numpy as np

from .. import images
from ..glb import CLAMP, Glb
from . import atlas, light, plan, routes, scene_file, structure, surfaces
from .bake import SELF_LIT, bake
from .structure import to_gltf

MAP_WIDTH = 1024
#: How many times brighter than white lamps shine, where light is baked.
LAMP_COLOUR = (1.0, 0.90, 0.76)
LAMPS = {"lamp_pendant": 4.0, "lamp_downlight": 20.0, "lamp_line": 4.0}


def files():
    routes.check()
    parts = structure.structure()
    pieces = {name: (make(), places) for name, (make, places) in plan.pieces().items()}
    used = light.pack([p.chart for p in parts], MAP_WIDTH)
    size = (MAP_WIDTH, 1 << (used - 1).bit_length())
    lightmap, prop_light = bake(parts, pieces, size)
    return {
        "hall.json": scene_file.scene(),
        "hall/hall.glb": _assemble(parts, pieces, size, lightmap, prop_light),
        "hall/plan.json": scene_file.footprints(),
    }


def _assemble(parts, pieces, size, lightmap, prop_light):
    glb = Glb("hall")

    def picture(name, image, quality=88, wrap=None):
        return glb.texture(
            glb.image(images.jpeg(image, quality), "image/jpeg", name), **({} if wrap is None else {"wrap": wrap})
        )

    baked = glb.texture(glb.image(images.png(lightmap), "image/png", "light"), CLAMP)
    furniture = picture("props", atlas.props(), 90, CLAMP)
    street = picture("outside", surfaces.outside(), 88, CLAMP)
    plaster = picture("plaster", surfaces.plaster())
    materials = {
        "floor": glb.material(
            "floor", texture=picture("floor", surfaces.floor(), 88), roughness=0.35, occlusion_texture=baked
        ),
        "plaster": glb.material("plaster", texture=plaster, roughness=0.9, occlusion_texture=baked),
        "ceiling": glb.material(
            "ceiling",
            texture=picture("ceiling", surfaces.ceiling()),
            roughness=0.9,
            occlusion_texture=baked,
            emissive=(SELF_LIT["ceiling"],) * 3,
        ),
        "concrete": glb.material(
            "concrete", texture=picture("concrete", surfaces.concrete()), roughness=0.8, occlusion_texture=baked
        ),
        "slats": glb.material(
            "slats", texture=picture("slats", surfaces.slats()), roughness=0.6, occlusion_texture=baked
        ),
        "trim": glb.material("trim", base=(0.07, 0.072, 0.078), roughness=0.5, occlusion_texture=baked),
        "accent": glb.material("accent", base=(0.05, 0.14, 0.20), roughness=0.8, occlusion_texture=baked),
        "carpet": glb.material(
            "carpet", texture=plaster, base=(0.19, 0.20, 0.215), roughness=1.0, occlusion_texture=baked
        ),
        "props": glb.material("props", texture=furniture, roughness=0.6),
        "leaf": glb.material("leaf", texture=furniture, roughness=0.7, double_sided=True),
        "glow": glb.material("glow", texture=furniture, unlit=True),
        **{
            name: glb.material(name, base=(0.8, 0.8, 0.8), emissive=LAMP_COLOUR, emissive_strength=strength)
            for name, strength in LAMPS.items()
        },
        "glass": glb.material("glass", base=(0.88, 0.94, 0.92, 1.0), roughness=0.02, transmission=0.97, double_sided=True),
        "outside": glb.material("outside", texture=street, unlit=True),
        "sky": glb.material("sky", base=(0.86, 0.92, 1.0), unlit=True),
    }
    root = glb.node("hall")
    _structure_nodes(glb, root, parts, size, materials)
    _outside_nodes(glb, root, materials)
    for name, (meshes, places) in pieces.items():
        primitives = [
            glb.primitive(
                mesh.positions,
                mesh.normals,
                mesh.triangles,
                materials[material],
                uv=None if material == "glass" or material in LAMPS else mesh.uv,
                colors=np.repeat(prop_light[name, k][:, None], 3, axis=1) if (name, k) in prop_light else None,
            )
            for k, (material, mesh) in enumerate(meshes)
        ]
        mesh_index = glb.mesh(name, primitives)
        for node, position, yaw in places:
            a = np.radians(yaw) / 2
            glb.node(
                node, root, to_gltf(np.array(position, dtype=float)), (0, np.sin(a), 0, np.cos(a)), mesh=mesh_index
            )
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
            primitives.append(
                glb.primitive(
                    to_gltf(np.concatenate([m[0] for m in meshes])),
                    to_gltf(np.concatenate([m[1] for m in meshes])),
                    np.concatenate([m[4] + b for m, b in zip(meshes, base)]),
                    materials[material],
                    uv=np.concatenate([m[2] for m in meshes]),
                    uv1=uv1,
                )
            )
        glb.node(node, root, mesh=glb.mesh(node, primitives))


def _outside_nodes(glb, root, materials):
    """Pictures of the street behind the windows and bright panes over the skylights."""

    def sheet(node, corner, u, v, material):
        corner, u, v = (np.array(a, dtype=float) for a in (corner, u, v))
        points = np.array([corner, corner + u, corner + u + v, corner + v])
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        glb.node(
            node,
            root,
            mesh=glb.mesh(
                node,
                [
                    glb.primitive(
                        to_gltf(points),
                        to_gltf(np.tile(normal, (4, 1))),
                        [(0, 1, 2), (0, 2, 3)],
                        materials[material],
                        uv=[(0, 1), (1, 1), (1, 0), (0, 0)],
                    )
                ],
            ),
        )

    sheet("outside_east", (39, 30, -1.9), (0, -44, 0), (0, 0, 14.0), "outside")
    sheet("outside_south", (42, -8, -2.4), (-54, 0, 0), (0, 0, 18.0), "outside")
    sheet("outside_north", (-6, 23, 2.0), (42, 0, 0), (0, 0, 6.0), "sky")
    x0, x1, y0, y1 = (f(s[k] for s in structure.SKYLIGHTS) for k, f in enumerate((min, max, min, max)))
    sheet(
        "skylight_panes", (x0, y1, 7.28), (x1 - x0, 0, 0), (0, y0 - y1, 0), "sky"
    )  # the ceiling hides what lies between the wells
