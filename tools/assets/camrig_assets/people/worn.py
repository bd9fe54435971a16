"""What a person may have on besides: bags and hats, each a piece of its own that is there in some variants."""

import numpy as np

from ..noise import smoothstep
from . import dyes, openings
from .hair import long_hair
from .parts import Part

# Share of the variants that have each kind of bag; the rest carries none.
BAGS = {"backpack": (0.0, 0.2), "hip": (0.2, 0.36), "hand": (0.36, 0.6)}
HATS = {"cap": (0.0, 0.1), "beanie": (0.1, 0.18)}
HAIR = {"long": (0.0, 0.35), "bob": (0.35, 0.6), "bun": (0.6, 0.8), "ponytail": (0.8, 1.0)}


def bags(wardrobe, spec):
    """The person's own bag, and those that it has in variants."""
    own, ease = spec.get("bag"), wardrobe.ease
    kinds = {"backpack": {"kind": "backpack"}, "hip": {"kind": "left"}}
    if own:
        kinds["hip" if own["kind"] in ("left", "right") else own["kind"].removeprefix("left_").removeprefix("right_")] = own
    if spec["build"]["height"] < 1.5:  # a child has no bag at the hip
        kinds.pop("hip")
    made = []
    for kind, bag in kinds.items():
        is_own, colour = bag is own, bag.get("colour", "#35463f")
        bag = {"colour": colour, **bag}
        piece = dyes.cloth(f"bag_{kind}", colour, dyes.BAGS, dye="bag", choice="bag", share=BAGS[kind], shown=is_own)
        piece.parts = wardrobe.carry(bag)
        strap = wardrobe.fabrics.plain(bag.get("strap", colour), 4)
        if kind == "backpack":
            piece.parts += openings.backpack_straps(wardrobe.shaper, ease, strap, piece.name)
        if kind == "hip":
            piece.parts += openings.cross_strap(wardrobe.shaper, ease, strap, bag["kind"], piece.name)
        made.append(piece)
    return made


def hats(head, fabrics):
    """A cap and a woollen hat, over hair that is short enough."""
    if head.look.get("style") in ("curly", "afro"):
        return []
    made = []
    for kind, share in HATS.items():
        piece = dyes.cloth(kind, "#8c8884", dyes.HATS, dye="hat", choice="hat", share=share, shown=False)
        piece.parts = [_dome(head, fabrics, kind)] + ([_brim(head, fabrics)] if kind == "cap" else [])
        made.append(piece)
    return made


def _dome(head, fabrics, kind):
    """The head's grid above the brow, pushed out over the hair."""
    thick = head.look["thickness"] * (1.35 + head.look.get("quiff", 0) * 0.5) + (0.008 if kind == "cap" else 0.011)
    low = 0.150 if kind == "cap" else 0.138
    y = head.local[..., 1]
    begin = int(np.searchsorted(y[:, 0], low)) - 1
    local = head.local[begin:].copy()
    middle = np.array([0, 0, -0.006])
    for row in range(len(local)):
        flat = local[row] - middle
        length = np.maximum(np.hypot(flat[:, 0], flat[:, 2]), 1e-6)
        out = thick * smoothstep(0.225, 0.205, y[begin + row, 0])
        local[row, :, 0] += flat[:, 0] / length * out
        local[row, :, 2] += flat[:, 2] / length * out
        local[row, :, 1] += thick * smoothstep(0.15, 0.215, y[begin + row, 0]) + (0.012 * smoothstep(0.19, 0.225, y[begin + row, 0]) if kind == "beanie" else 0)
    local[0, :, 1] = low - (0.03 if kind == "beanie" else 0.012) * smoothstep(0.03, -0.06, local[0, :, 2])
    rows, columns = local.shape[:2]
    part = Part(kind, head.place(local), head.shaper.blank(rows, columns - 1), (64, 32), fabrics.plain("#8c8884", 61, 0.08 if kind == "beanie" else 0.03))
    return head.shaper.fixed(part, "head")


def _brim(head, fabrics):
    """A closed shape in front of the brow."""
    thick = head.look["thickness"] * 1.3 + 0.008
    return head.shaper.blob(
        "brim",
        "head",
        head.chin + np.array([0, 0.152, 0.085 + thick]) * head.size,
        np.array([0.070, 0.006, 0.062]) * head.size,
        10,
        5,
        fabrics.plain("#8c8884", 62),
        (24, 16),
        2.4,
    )


def hair(head, own, paint_hair):
    """Long hair in other cuts; [] where there is none to cut. The cut as written is shown where nothing is asked for."""
    style = head.look.get("style", "")
    if style not in HAIR:
        return []
    made = []
    for cut, share in HAIR.items():
        piece = dyes.Piece(f"hair_{cut}", own.own, own.ground, own.colours, dye="hair", choice="hair", share=share, shown=cut == style)
        piece.parts = long_hair(head, paint_hair, cut)
        made.append(piece)
    return made
