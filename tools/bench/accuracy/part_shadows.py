"""What shadows cost and how far their edges are off: of all kinds of light, by how much one map covers."""

import numpy as np

from . import measure, part_cost, shadow_scene, shadows
from .lenses import LENSES, PINHOLES

#: Light, and metres of ground that one map of it covers; the sun's covers no more than 200 m.
CASES = ((shadow_scene.SUN, 10.0), (shadow_scene.SUN, 30.0), (shadow_scene.SUN, 100.0), (shadow_scene.SUN, 400.0), (shadow_scene.HIGH_SUN, 30.0), (shadow_scene.LOW_SUN, 30.0), (shadow_scene.SPOT, 30.0), (shadow_scene.POINT, 30.0))
THROUGH = ("barrel and tangential", "rational, wide", "fisheye 180 deg")
#: An ordinary camera, 10 m away from the edge.
PX_PER_M = 520 / 10
LIMIT_TEXELS = 0.65
LIT_BY = (("sun", (shadow_scene.SUN,)), ("spot", (shadow_scene.SPOT,)), ("point", (shadow_scene.POINT,)), ("sun, spot and point", (shadow_scene.SUN, shadow_scene.SPOT, shadow_scene.POINT)))


def edges_of(rig, camera, light, extent_m, quick):
    """Boxes, spaces and the camera's height grow with the ground beyond 30 m, so that edges stay as many texels apart."""
    scale = max(1.0, min(extent_m, shadow_scene.MOST_EXTENT_M) / 30.0)
    ground = shadow_scene.Ground(extent_m, 0.6 * scale, 1.4 * scale, 2.4 * scale, count=5 if extent_m >= 30 else 3)
    view = shadows.over_ground(camera, scale)
    return shadows.measured(rig, camera, view, ground, light, fine=2 if quick else 4)


def rms(values):
    return float(np.sqrt((np.asarray(values) ** 2).mean()))


def edges_and_cost(section, quick):
    """Edges of all kinds of light, through lenses too, and what pictures cost with and without shadows."""
    rows, worst, missing = [], 0.0, 0
    with measure.rig_of() as rig:
        cases = [(PINHOLES[0], *case) for case in CASES[: 3 if quick else None]]
        cases += [(camera, shadow_scene.SUN, 30.0) for camera in LENSES if camera.name in THROUGH]
        for camera, light, extent_m in cases:
            found = edges_of(rig, camera, light, extent_m, quick)
            worst = max(worst, float(abs(found.error_texels).max()))
            missing += found.missing
            most = abs(found.error_m).max()
            rows.append(
                (camera.name, light.name, f"{extent_m:.0f}", 1e3 * found.texel_m.mean(), 1e3 * rms(found.error_m), 1e3 * most, PX_PER_M * most,
                 rms(found.error_texels), float(abs(found.error_texels).max()), float(np.median(found.width_m / (found.texel_m * found.stretch))), len(found.error_m), found.missing)
            )
        costs = [(name, level, *(cpu_ms(rig, lights, level, moves, 9 if quick else 31) for moves in (False, True))) for name, lights in LIT_BY for level in ("simple", "beautiful")]
    section.say(
        "Boxes over level ground, `beautiful`: edges of their shadows against the hull of the box's corners followed along the light, across the edge on the ground. Where the light in the picture is half of that without boxes is the edge. "
        "A map has 2048 x 2048 texels, or 4096 x 4096 where the sun's would be larger than 3 cm and there are two maps at most. The sun's covers the ground, up to 200 m of it; a lamp's covers its cone, or a side of a cube (here 10 to 12 m away). A surface looks its light up where it is, so edges are "
        "where the map has them: within half a texel, where an outline lies along texels, more where light grazes. px: the largest error 10 m from a camera of 520 px. "
        "Width: from a tenth to nine tenths of the light. The sun is a point here, its own half-shadow (9 mm for each metre to what throws it) is not drawn."
    )
    section.table(("camera", "light", "ground, m", "texel, mm", "error rms, mm", "max, mm", "max, px", "rms, texels", "max, texels", "width, texels", "edges", "not found"), rows)
    section.gate("shadow edge, max", worst, LIMIT_TEXELS, "texels")
    section.gate("shadow edges not found", missing, 0.5)
    section.say("CPU ms of an instant and its picture, raw, 640x480, 25 boxes going round; `simple` (default) throws no shadows, `beautiful` does, and has its materials too. Maps have 2048 x 2048 texels, as the ground is 30 m wide; the sun and a spot have one, a point light those of six that see something:")
    section.table(("lights", "quality", "standing", "moving"), [(name, f"`{level}`" + (" (default)" if level == "simple" else ""), *cost) for name, level, *cost in costs])

    def draw(_, axes):
        for name, level, standing, moving in costs:
            color = {"simple": "tab:blue", "beautiful": "tab:red"}[level]
            axes.plot([standing, moving], [name, name], "-", color=color, alpha=0.4)
            axes.plot(standing, name, "o", color=color, fillstyle="none")
            axes.plot(moving, name, "o", color=color)
        for level, color in (("simple", "tab:blue"), ("beautiful", "tab:red")):
            axes.plot([], [], "o", color=color, label=level)
        axes.set(xlabel="CPU of a picture, 640x480, ms (hollow: standing, filled: moving)")
        axes.legend(fontsize=8)

    section.plot("shadows", draw, "What shadows cost, by lights")


def cpu_ms(rig, lights, level, moving, frames):
    rig.load(shadow_scene.Ground(30.0).write(rig.folder, lights, boxes="walking"))
    camera = PINHOLES[0]
    cam = measure.new_camera(rig, **camera.options(), **shadows.over_ground(camera).options(), quality=level, antialias="none")
    return part_cost.cpu_ms(rig, cam, moving, frames)
