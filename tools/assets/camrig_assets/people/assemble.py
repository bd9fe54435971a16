"""scenes/hall/person_*.glb: the people. Each is one skinned mesh with one texture
and a material for each piece that comes in several colours or is not always worn, plus a soft shadow on the floor."""

import numpy as np

from .. import ao, images
from ..glb import CLAMP, Glb
from . import clips, dyes, face, paint, skeleton, worn
from .cast import CAST
from .hair import long_hair
from .head import Head
from .joins import blend_joins
from .trunk import Shaper
from .wardrobe import Wardrobe

ATLAS_WIDTH = 512
#: Of skin and clothes, in the mean: what they hide from a place they light a little.
REFLECTANCE = 0.25
#: Of all light, for what sees next to nothing: the bind pose hides more of the inside of clothes than people who move.
LEAST_LIGHT = 0.15
JOINS = [("trunk", f"{side}_{part}", 0.030) for side in ("left", "right") for part in ("sleeve", "arm")]
JOINS += [("pelvis", f"{side}_trouser", 0.022) for side in ("left", "right")] + [("neck", "head", 0.02)]


def files():
    return {f"hall/{name}.glb": person(name, spec) for name, spec in CAST.items()}


def person(name, spec):
    rig = skeleton.Rig(skeleton.Build(**spec["build"]))
    shaper = Shaper(rig)
    pieces = _dress(shaper, spec)
    parts = [part for piece in pieces for part in piece.parts]
    blend_joins([part for piece in pieces if piece.shown for part in piece.parts], JOINS, shaper.s)
    used = paint.pack(parts, ATLAS_WIDTH)
    size = (ATLAS_WIDTH, 512 if used <= 512 else 1024)
    if used > size[1]:
        raise ValueError(f"{name}: the texture atlas is {used} rows high")
    texture = images.jpeg(paint.atlas(pieces, size))

    glb = Glb(name, extras={"keypoints": skeleton.KEYPOINTS})
    image = glb.texture(glb.image(texture, "image/jpeg", name), CLAMP)
    openness, ramp = _openness(pieces), ao.ramp(glb)
    primitives = []
    for piece in pieces:
        material = glb.material(piece.name, tuple(piece.factor), texture=image, occlusion_texture=ramp, roughness=0.85, extras=piece.extras())
        primitives.append(_skinned(glb, piece.parts, openness, size, material))
    shadow = glb.material("contact_shadow", base=(0, 0, 0, 1), alpha="BLEND", roughness=1.0, unlit=True)
    mesh = glb.mesh(name, [*primitives, _shadow(glb, rig, shadow)])
    nodes = _nodes(glb, rig)
    inverse = np.tile(np.eye(4), (len(rig.names), 1, 1))
    inverse[:, :3, 3] = -rig.places
    glb.node("body", mesh=mesh, skin=glb.skin(name, nodes, inverse, nodes[0]))
    for clip, (times, turns, hips, extras) in clips.all_clips(rig, spec.get("gait", {})).items():
        moving = [
            i
            for i in range(len(nodes))
            if np.ptp(turns[:, i], axis=0).max() > 1e-5 or np.abs(turns[0, i, :3]).max() > 1e-5
        ]
        tracks = [(nodes[rig.index["hips"]], "translation", hips)] + [
            (nodes[i], "rotation", turns[:, i]) for i in moving
        ]
        glb.animation(clip, times, tracks, extras)
    return glb.bytes()


def _dress(shaper, spec):
    """The pieces of a person, each with its parts."""
    tone, hair_colour, look = paint.rgb(spec["skin"]), paint.rgb(spec["hair"]["colour"]), spec["hair"]
    head, wardrobe = Head(shaper, look), Wardrobe(shaper, tone)
    strands = look.get("strands", 1)

    def paint_hair(part, points, u, v):
        return paint.hair(points, hair_colour, 7, strands)

    body = (
        head.parts(face.face(head, tone, hair_colour, look), face.shell(head, hair_colour, look))
        + wardrobe.wear_top(spec["top"], spec["seed"])
        + wardrobe.wear_bottom(spec["bottom"], spec["seed"] + 10)
        + wardrobe.wear_shoes(spec["shoes"])
    )
    pieces = dyes.pieces_of(spec)
    for part in body:
        pieces[dyes.piece_of(part, spec)].parts.append(part)
    cuts = worn.hair(head, pieces["hair"], paint_hair)
    if not cuts:
        pieces["hair"].parts += long_hair(head, paint_hair, look.get("style", ""))
    every = [*pieces.values(), *cuts, *worn.bags(wardrobe, spec), *worn.hats(head, wardrobe.fabrics)]
    return [piece for piece in every if piece.parts]


def _nodes(glb, rig):
    """The skeleton as nodes; the face's keypoints are leaves below the head."""
    coco = {node: name for name, node in skeleton.KEYPOINTS.items()}
    nodes = []
    for i, name in enumerate(rig.names):
        parent = nodes[rig.parents[i]] if rig.parents[i] >= 0 else None
        nodes.append(glb.node(name, parent, rig.offset(i), extras={"keypoint": coco[name]} if name in coco else None))
    for name, place in skeleton.face_nodes(rig.build):
        glb.node(name, nodes[rig.index["head"]], place - rig.at("head"), extras={"keypoint": name})
    return nodes


def _flat(parts):
    """Positions, normals and triangles of parts, and where each part's grid lies among them."""
    triangles, rows, base = [], [], 0
    for part in parts:
        triangles.append(part.triangles() + base)
        rows.append((base, part.grid.shape[:2]))
        base += part.grid.shape[0] * part.grid.shape[1]
    positions = np.concatenate([part.grid.reshape(-1, 3) for part in parts])
    normals = np.concatenate([part.normals.reshape(-1, 3) for part in parts])
    return positions, normals, np.concatenate(triangles), rows


def _skinned(glb, parts, openness, size, material):
    positions, normals, triangles, _ = _flat(parts)
    weights = np.concatenate([part.weights.reshape(-1, part.weights.shape[2]) for part in parts])
    weights = np.clip(weights, 0, None)
    joints = np.argsort(-weights, axis=1, kind="stable")[:, :4]
    shares = np.take_along_axis(weights, joints, axis=1)
    joints[shares <= 0] = 0
    shade = ao.on_ramp(np.concatenate([openness[id(part)] for part in parts]))
    uv = np.concatenate([paint.texture_coordinates(part, size) for part in parts])
    return glb.primitive(positions, normals, triangles, material, uv=uv, uv1=shade, joints=joints, weights=shares)


def _openness(pieces):
    """How much of the light from all around reaches each vertex, in the bind pose on a floor, by part; what lies inside another part
    takes its neighbours' share. What is not in every variant darkens nothing but itself.
    """
    floor = np.array([[-3, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]], dtype=np.float64)
    light = {}

    def cast(others, parts):
        positions, _, triangles, _ = _flat(others)
        soup = ao.Rays(
            np.concatenate([positions, floor]),
            np.concatenate([triangles, np.array([[0, 1, 2], [0, 2, 3]]) + len(positions)]),
        )
        positions, normals, _, rows = _flat(parts)
        open_share, backs = ao.openness(soup, positions, normals, reach=0.45, count=96, lift=0.003, solid=len(triangles))
        # What is hidden is hidden by clothes and skin, which send some of their light on.
        light_there = open_share / (1 - REFLECTANCE * (1 - open_share))
        found = _without_hidden(light_there, backs > 0.25, rows)
        for part, (base, (height, width)) in zip(parts, rows):
            light[id(part)] = found[base : base + height * width]

    always = [part for piece in pieces if not piece.choice for part in piece.parts]
    cast(always, always)
    for piece in pieces:
        if piece.choice:
            cast(always + piece.parts, piece.parts)
    return light


def _without_hidden(light, hidden, rows):
    for base, (height, width) in rows:
        block = slice(base, base + height * width)
        grid, unknown = light[block].reshape(height, width).copy(), hidden[block].reshape(height, width).copy()
        for _ in range(24):
            if not unknown.any() or unknown.all():
                break
            total, count = np.zeros_like(grid), np.zeros_like(grid)
            for dr, dc in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                other, known = np.roll(grid, (dr, dc), (0, 1)), ~np.roll(unknown, (dr, dc), (0, 1))
                if dr:
                    known[0 if dr > 0 else -1] = False
                total += np.where(known, other, 0)
                count += known
            fill = unknown & (count > 0)
            grid[fill] = total[fill] / count[fill]
            unknown &= ~fill
        grid[:, -1] = grid[:, 0] = (grid[:, 0] + grid[:, -1]) / 2
        light[block] = np.maximum(grid, LEAST_LIGHT).reshape(-1)
    return light


def _shadow(glb, rig, material):
    """A soft dark spot below the feet: transparent at its rim, fixed to the root."""
    s = rig.build.scale
    rings, columns = ((0.0, 0.66), (0.45, 0.44), (1.0, 0.0)), 12
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    positions, alphas, triangles = [(0, 0, 0)], [rings[0][1]], []
    for radius, alpha in rings[1:]:
        positions += [(0.27 * s * radius * np.sin(a), 0, 0.02 + 0.40 * s * radius * np.cos(a)) for a in turn]
        alphas += [alpha] * columns
    for i in range(columns):
        j = (i + 1) % columns
        triangles.append((0, 1 + i, 1 + j))
        for ring in range(len(rings) - 2):
            a, b = 1 + ring * columns, 1 + (ring + 1) * columns
            triangles += [(a + i, b + i, b + j), (a + i, b + j, a + j)]
    positions = np.array(positions) + (0, 0.006, 0)
    colours = np.ones((len(positions), 4))
    colours[:, 3] = alphas
    weights = np.zeros((len(positions), 4))
    weights[:, 0] = 1
    return glb.primitive(
        positions,
        np.tile((0.0, 1, 0), (len(positions), 1)),
        triangles,
        material,
        colors=colours,
        joints=np.zeros((len(positions), 4), dtype=int),
        weights=weights,
    )
