"""What a picture costs and how far it is from an exactly sampled one: all that may be chosen, in one run, with what a camera does by itself marked."""

import statistics

import numpy as np

from tools.bench.speed.meter import cpu_s_of

from . import REPOSITORY, estimator, measure, part_sampling, quality
from .lenses import Camera

#: Scene, a place of it, and the second that is shown.
VIEWS = (("hall", "lobby", 4.0), ("street", "corner", 6.0))
LEVELS = ("fast", "simple", "beautiful")
STEP_NS = 40_000_000
#: Quality, antialias.
CHOICES = tuple((level, antialias) for level in LEVELS for antialias in ("none", "coverage")) + tuple(("simple", antialias) for antialias in ("msaa4", "ssaa2", "ssaa3", "ssaa4"))
DEFAULT = ("simple", "none")
#: Pixels that fewer triangles may be off by: `serve --detail-error-px`.
DETAIL_ERRORS_PX = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0)
DEFAULT_DETAIL_PX = 0.25


def scene_of(name):
    return REPOSITORY / "scenes" / f"{name}.json"


def cpu_ms(rig, cam, moving, frames):
    """Median CPU of an instant of the world and one raw picture of it, by a camera that stands or moves."""
    pid = rig.call("server.info")["pid"]
    pose = {key: cam.get()["pose"][key] for key in ("position", "orientation")}
    costs = []
    for i in range(frames + 3):
        if moving:
            cam.set(**part_sampling.moved(pose, i + 1))
        start = cpu_s_of(pid)
        rig.step(nanoseconds=STEP_NS)
        cam.frame()
        costs.append(1e3 * (cpu_s_of(pid) - start))
    return statistics.median(costs[3:])


def curve(section, quick):
    """Quality and antialias: error of one ordinary picture against 256 samples a pixel of the same quality, and CPU."""
    camera = Camera("view", fx=480, fy=480)
    points, rows = [], []
    for scene, place, seconds in VIEWS[: 1 if quick else None]:
        with measure.rig_of(scene_of(scene)) as rig:
            rig.step(seconds=seconds)
            cam = measure.new_camera(rig, place=place, **camera.options())
            light = {}
            for level in LEVELS:
                cam.set(quality=level, antialias="ssaa4")
                light[level] = part_sampling.finer(cam, camera, 2 if quick else 4)
            shown = {}
            for choice in CHOICES:
                cam.set(quality=choice[0], antialias=choice[1])
                shown[choice] = cam.frame().image
            for level, antialias in CHOICES:
                cam.set(quality=level, antialias=antialias)
                exact = 255 * estimator.encode(light[level])
                error = exact - shown[level, antialias]
                rms = float(np.sqrt((error**2).mean()))
                psnr = quality.psnr(np.round(exact).astype(np.uint8), shown[level, antialias])
                standing, moving = (cpu_ms(rig, cam, moves, 9 if quick else 31) for moves in (False, True))
                rows.append((f"{scene}, {place}", f"`{level}`", f"`{antialias}`" + (" (default)" if (level, antialias) == DEFAULT else ""), rms, psnr, standing, moving))
                points.append((scene, level, antialias, rms, standing, moving))
    section.say(
        f"One ordinary picture, 640x480, against the mean of {4 if quick else 16} ssaa4 pictures of the same quality ({64 if quick else 256} samples a pixel): what sampling alone is wrong by, in codes of 0 to 255 "
        "over the whole picture. How far the light itself is from a path tracer's: [quality](quality.md#against-a-path-tracer). "
        "CPU ms of one instant of the world and its picture, raw, while people walk; `msaa4` and `ssaa` are drawn by Mesa."
    )
    section.table(("scene, place", "quality", "antialias", "error rms", "PSNR, dB", "standing", "moving"), rows)

    def draw(_, axes):
        colours = {"fast": "tab:gray", "simple": "tab:blue", "beautiful": "tab:red"}
        for scene, level, antialias, rms, standing, moving in points:
            if scene != VIEWS[0][0]:
                continue
            axes.loglog([standing, moving], [rms, rms], "-", color=colours[level], alpha=0.3)
            axes.loglog(standing, rms, "o", color=colours[level], fillstyle="none")
            axes.loglog(moving, rms, "o", color=colours[level])
            axes.annotate(antialias, (moving, rms), textcoords="offset points", xytext=(6, -3), fontsize=7)
            if (level, antialias) == DEFAULT:
                axes.loglog([standing, moving], [rms, rms], "o", color="black", fillstyle="none", markersize=13)
        for level, colour in colours.items():
            axes.plot([], [], "o", color=colour, label=level)
        axes.plot([], [], "o", color="black", fillstyle="none", markersize=13, label="default")
        axes.set(xlabel="CPU of a picture of the hall, 640x480, ms (hollow: standing, filled: moving)", ylabel="error, rms codes")
        axes.legend(fontsize=8)

    section.plot("curve", draw, "Cost against error of quality and antialias in the hall")


def detail(section, quick):
    """Fewer triangles of people far away: what they change and save in the crowd."""
    camera = Camera("view", fx=480, fy=480)
    rows, exact = [], None
    for error_px in DETAIL_ERRORS_PX:
        with measure.rig_of(scene_of("crowd"), args=["--detail-error-px", str(error_px)]) as rig:
            rig.step(seconds=6.0)
            cam = measure.new_camera(rig, place="west", antialias="coverage", **camera.options())
            shown = cam.frame().image.astype(float)
            exact = shown if exact is None else exact
            error = abs(shown - exact)
            cam.set(antialias="none")
            standing, moving = (cpu_ms(rig, cam, moves, 9 if quick else 31) for moves in (False, True))
            mark = " (default)" if error_px == DEFAULT_DETAIL_PX else " (all triangles)" if not error_px else ""
            rows.append((f"{error_px:g}{mark}", float(np.sqrt((error**2).mean())), float(error.max()), float(100 * (error.max(axis=2) > 3).mean()), standing, moving))
    section.say(
        "`serve --detail-error-px`, the square with its hundred people, `simple`, 640x480: codes by which a picture by coverage differs from that of all triangles, and CPU ms of an instant and its picture with one sample a pixel."
    )
    section.table(("at most, px", "error rms", "max", "over 3 codes, %", "standing", "moving"), rows)
