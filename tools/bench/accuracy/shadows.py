"""Shadows of boxes on level ground, whose outlines are known: what light cannot reach is the convex hull of a box's corners, each followed along the light to the ground.

How far the shadow in a picture is from that: along lines across the outline, the light in the picture relative to the same picture without boxes, and where it is half of it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from . import boards, estimator, measure

#: Along a line across the outline: so many places on each side, and so far, in texels.
PLACES, REACH_TEXELS = 40, 5.0


@dataclass
class Outlines:
    """Of all shadows, at places on their edges: the place (N, 3), which way is out of the shadow, of which shadow (`owner`) and which of its edges it is, and how much farther apart
    things are on the ground than in the light's map (`stretch`), across this edge.
    """

    places: np.ndarray
    outwards: np.ndarray
    owners: np.ndarray
    edges: np.ndarray
    stretch: np.ndarray
    hulls: list

    @staticmethod
    def of(ground, light, along=9):
        places, outwards, owners, edges, hulls = [], [], [], [], []
        for i, corners in enumerate(ground.corners()):
            hull = _hull(light.on_ground(corners)[:, :2])
            hulls.append(hull)
            normals = _normals(hull)
            for k, (start, end) in enumerate(zip(hull, np.roll(hull, -1, axis=0))):
                for t in np.linspace(0.2, 0.8, along):
                    places.append((*(start + t * (end - start)), 0.0))
                    outwards.append((*normals[k], 0.0))
                    owners.append(i)
                    edges.append(k)
        places, outwards = np.array(places), np.array(outwards)
        return Outlines(places, outwards, np.array(owners), np.array(edges), _stretch(light.way_to(places), outwards), hulls)


def _stretch(way, normals):
    along = np.stack([-normals[..., 1], normals[..., 0], np.zeros(normals.shape[:-1])], axis=-1)
    return np.sqrt(1 - (along * way).sum(axis=-1) ** 2) / np.abs(way[..., 2])


def _hull(points):
    """Convex hull in double, to the left (Andrew's monotone chain)."""
    points = points[np.lexsort((points[:, 1], points[:, 0]))]

    def half(ordered):
        kept = []
        for p in ordered:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-1] - kept[-2], p - kept[-2]
                if ax * by - ay * bx > 1e-9:
                    break
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(half(points) + half(points[::-1]))


def _normals(hull):
    """Outwards of each edge."""
    edge = np.roll(hull, -1, axis=0) - hull
    return np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1, keepdims=True)


@dataclass
class Edges:
    """What was measured at places on outlines, all (N,) and over 0 where the shadow is too large."""

    error_m: np.ndarray
    error_px: np.ndarray  # in the picture, at that place
    texel_m: np.ndarray
    width_m: np.ndarray  # from a tenth to nine tenths of the light, across the edge on the ground
    stretch: np.ndarray  # as in Outlines
    missing: int  # lines on which no edge was found, though all of them is seen

    @property
    def error_texels(self):
        """In texels of the map."""
        return self.error_m / (self.texel_m * self.stretch)


def measured(rig, camera, view, ground, light, fine, boxes="things"):
    """Edges in pictures of `camera` at `view` (boards.View), `fine` x `fine` samples a pixel: as many pictures, moved by parts of a pixel."""
    pictures = []
    for shown in (boxes, "none"):
        rig.load(ground.write(rig.folder, (light,), shown))
        cam = measure.new_camera(rig, **camera.options(), **view.options(), quality="beautiful", antialias="none")
        pictures.append(_finely(cam, camera, fine))
    return edges(*pictures, fine, camera, view, ground, light)


def _finely(cam, camera, fine):
    """Linear light, `fine` times as many rows and columns: that of pixel (x, y) at (fine x, fine y)."""
    picture = np.empty((camera.size[1] * fine, camera.size[0] * fine), np.float32)
    for row in range(fine):
        for column in range(fine):
            cam.set(**camera.options((-column / fine, -row / fine)))
            picture[row::fine, column::fine] = estimator.linear_light(cam.frame().image)
    return picture


def edges(shadowed, clear, fine, camera, view, ground, light):
    """Edges in linear light with and without boxes."""
    outlines = Outlines.of(ground, light)
    texel_m = light.texel_m(outlines.places, ground)
    across = np.linspace(-REACH_TEXELS, REACH_TEXELS, 2 * PLACES + 1)
    out_m = (texel_m * outlines.stretch)[:, None] * across
    lines = outlines.places[:, None] + out_m[:, :, None] * outlines.outwards[:, None]
    pixels, used = _seen(lines, camera, view, ground)
    used &= np.linalg.norm(pixels[:, -1] - pixels[:, 0], axis=1) * fine > 2 * REACH_TEXELS  # a texel is a sample at least
    used &= _apart(lines, outlines, light, ground)
    if not used.any():
        raise ValueError(f"{camera.name}, {light.name}: no edge can be measured")
    at = (fine * pixels[used]).astype(np.float32)
    taken, open_light = (cv2.remap(picture, at[..., 0], at[..., 1], cv2.INTER_LINEAR) for picture in (shadowed, clear))
    lit = open_light.min(axis=1) > 0.05
    used[used] = lit
    share = taken[lit] / open_light[lit]
    found = np.array([[_crossing(line, place, level) for level in (0.1, 0.5, 0.9)] for line, place in zip(share, out_m[used])]).reshape(-1, 3)
    good = np.isfinite(found).all(axis=1) & (share[:, 0] < 0.05) & (share[:, -1] > 0.95)
    which = np.nonzero(used)[0][good]
    error, places = found[good, 1], outlines.places[which]
    moved = places + error[:, None] * outlines.outwards[which]
    error_px = np.linalg.norm(camera.project(view.optical(moved)) - camera.project(view.optical(places)), axis=1)
    return Edges(error, np.copysign(error_px, error), texel_m[which], found[good, 2] - found[good, 0], outlines.stretch[which], int((~good).sum()))


def _crossing(values, at, level):
    """Where values rise over a level, the first time."""
    over = np.nonzero((values[:-1] < level) & (values[1:] >= level))[0]
    if not len(over):
        return np.nan
    i = over[0]
    return at[i] + (at[i + 1] - at[i]) * (level - values[i]) / (values[i + 1] - values[i])


def _seen(lines, camera, view, ground):
    """(pixels, whether all of a line is in the picture, on the ground, and before the boxes)."""
    optical = view.optical(lines.reshape(-1, 3)).reshape(lines.shape)
    angle = np.arctan2(np.hypot(optical[..., 0], optical[..., 1]), optical[..., 2])
    seen = (angle < 0.97 * min(camera.fold_angle(), np.radians(85))).all(axis=1)
    seen &= (np.abs(lines[..., :2]) < ground.extent_m / 2).all(axis=(1, 2))
    pixels = np.zeros((*lines.shape[:2], 2))
    if seen.any():
        pixels[seen] = camera.project(optical[seen].reshape(-1, 3)).reshape(-1, lines.shape[1], 2)
    seen &= ((pixels > 2) & (pixels < np.array(camera.size) - 3)).all(axis=(1, 2))
    way = lines - view.position
    with np.errstate(divide="ignore", invalid="ignore"):
        for corners in ground.corners():
            to_low, to_high = ((corner + slack - view.position) / way for corner, slack in ((corners.min(axis=0), -0.02), (corners.max(axis=0), 0.02)))
            hidden = np.minimum(to_low, to_high).max(axis=-1) < np.maximum(to_low, to_high).min(axis=-1)
            seen &= ~hidden.any(axis=1)
    return pixels, seen


def _apart(lines, outlines, light, ground):
    """Whether no other edge is within a line's reach: of the same shadow seen from its inner end, of others from all of it."""
    apart = np.ones(len(lines), bool)
    for i, hull in enumerate(outlines.hulls):
        normals = np.pad(_normals(hull), ((0, 0), (0, 1)))
        distance = ((np.pad(hull, ((0, 0), (0, 1))) - lines[:, :, None]) * normals).sum(axis=3)  # inside: all over 0
        middle = np.pad(hull.mean(axis=0), (0, 1))[None]
        scale = light.texel_m(middle, ground) * _stretch(light.way_to(middle), normals)
        texels = distance / scale
        own = outlines.owners == i
        inner = texels[:, 0].copy()
        inner[own, outlines.edges[own]] = np.inf
        apart &= np.where(own, inner.min(axis=1) > REACH_TEXELS, texels.min(axis=2).max(axis=1) < -REACH_TEXELS)
    return apart


def over_ground(camera, scale=1.0):
    """A view straight down, but for a few degrees, from where many boxes are in the picture and a texel is not much less than a pixel."""
    return boards.looking(scale * np.array((0.5, -0.4, 6.0 if camera.fx > 300 else 4.5)), scale * np.array((0.2, 0.1, 0.0)), roll=0.35)
