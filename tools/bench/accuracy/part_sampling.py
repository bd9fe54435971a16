"""What sampling costs and buys: lens method, anti-aliasing, texture filtering; speed against error in one run each."""

import camrig
import numpy as np
from camrig_assets.glb import Glb
from camrig_assets.scene import Scene

from tools.bench.speed.meter import cpu_s_of

from . import REPOSITORY, estimator, marks, measure, quality
from .lenses import LENSES, Camera

HALL = REPOSITORY / "scenes" / "hall.json"
ANTIALIAS = ("none", "coverage", "msaa4", "ssaa2", "ssaa3", "ssaa4")
# What the samples of each mode allow at random edges, against exact area: one, a rotated four, then regular grids.
EXPECTED_COVERAGE_RMS = {"none": 0.248, "coverage": 0.015, "msaa4": 0.094, "ssaa2": 0.09, "ssaa3": 0.05, "ssaa4": 0.031}


def picture_ms(rig, cam, pose, frames=15):
    """CPU of the rig for one picture of a camera that moves, asked for and sent raw: the median, which holds still on a busy machine; the camera stands back as it was."""
    pid = rig.call("server.info")["pid"]
    cam.frame()
    times = []
    for i in range(frames):
        cam.set(**moved(pose, i + 1))
        start = cpu_s_of(pid)
        cam.frame()
        times.append((cpu_s_of(pid) - start) * 1e3)
    cam.set(**pose)
    return float(np.median(times))


def moved(pose, i):
    """The pose a micrometre up every other time: nothing to see, but a new picture to the rig."""
    x, y, z = pose["position"]
    return dict(pose, position=(x, y, z + (i % 2) * 2.0**-20))


LOBBY = {"position": (2, 3, 2.8), "look_at": (12, 9, 1)}


def edge_corners():
    """(108, 3, 2): the corners of triangles at every angle, in a plane 2 m in front of the camera, m right and up."""
    random = np.random.default_rng(8)
    grid = [((column - 5.5) * 0.2, (row - 4) * 0.2) for row in range(9) for column in range(12)]
    angles = [random.uniform(0, 2 * np.pi) + np.array([0, 2.1, 4.2]) for _ in grid]
    return np.array([np.array(centre) + 0.085 * np.stack([np.cos(a), np.sin(a)], 1) for centre, a in zip(grid, angles)])


def edges_scene(folder):
    """The triangles, white on black."""
    glb = Glb("edges")
    white = glb.material("white", base=(1, 1, 1), unlit=True, double_sided=True)
    corners = np.pad(edge_corners().reshape(-1, 2), ((0, 0), (0, 1)))
    triangles = np.arange(len(corners)).reshape(-1, 3)
    glb.node("edges", mesh=glb.mesh("edges", [glb.primitive(corners, np.tile([0.0, 0, 1], (len(corners), 1)), triangles, white)]))
    (folder / "edges.glb").write_bytes(glb.bytes())
    scene = Scene("edges", "Edges for measuring coverage.", seed=1)
    scene.environment(background=(0, 0, 0), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("edges", "edges.glb")
    scene.object("edges", "edges", "edges", (2, 0, 0), -90)
    path = folder / "edges.json"
    path.write_bytes(scene.text())
    return path


def half_plane_area(distance, a, b):
    """The part of a unit square on the inner side of a line: `distance` from the middle (inside: positive), |normal| = (a, b)."""
    a, b = np.maximum(a, 1e-6), np.maximum(b, 1e-6)
    t = distance + (a + b) / 2
    squares = [np.maximum(x, 0) ** 2 for x in (t, t - a, t - b, t - a - b)]
    return (squares[0] - squares[1] - squares[2] + squares[3]) / (2 * a * b)


def exact_coverage(camera):
    """(coverage, which): exact areas in the pixels that one edge crosses, away from corners; others are not in `which`."""
    rows, columns = np.mgrid[: camera.size[1], : camera.size[0]].astype(float)
    coverage, crossings = np.zeros(rows.shape), np.zeros(rows.shape, int)
    near_corner = np.zeros(rows.shape, bool)
    cx, cy = (camera.size[0] - 1) / 2, (camera.size[1] - 1) / 2
    for triangle in edge_corners():
        corners = np.stack([cx + camera.fx * triangle[:, 0] / 2, cy - camera.fy * triangle[:, 1] / 2], 1)
        middle = corners.mean(axis=0)
        for start, end in zip(corners, np.roll(corners, -1, axis=0)):
            near_corner |= (abs(columns - start[0]) < 2) & (abs(rows - start[1]) < 2)
            along = (end - start) / np.linalg.norm(end - start)
            inward = np.array([-along[1], along[0]])
            inward *= np.sign(inward @ (middle - start))
            distance = (columns - start[0]) * inward[0] + (rows - start[1]) * inward[1]
            place = (columns - start[0]) * along[0] + (rows - start[1]) * along[1]
            a, b = abs(inward)
            crossed = (abs(distance) < (a + b) / 2) & (place > 0) & (place < np.linalg.norm(end - start))
            coverage[crossed] = half_plane_area(distance[crossed], a, b)
            crossings += crossed
    return coverage, (crossings == 1) & ~near_corner


def coverage(rig, modes=ANTIALIAS, timed=True):
    """{mode: (rms coverage error over edge pixels, largest, ms)} against exact areas."""
    rig.load(edges_scene(rig.folder))
    camera = Camera("edges", fx=520, fy=520)
    exact, edge = exact_coverage(camera)
    cam = measure.new_camera(rig, **camera.options(), position=(0, 0, 0))
    results = {}
    for mode in modes:
        cam.set(antialias=mode)
        error = (estimator.LINEAR[cam.frame().image[:, :, 1]] - exact)[edge]
        cost = picture_ms(rig, cam, {"position": (0, 0, 0)}) if timed else float("nan")
        results[mode] = (float(np.sqrt((error**2).mean())), float(np.abs(error).max()), cost)
    return results


#: Stops by which pictures are darker that show how bright it is over white: up to 16 times white.
OVER_WHITE_EV = -4


def finer(cam, camera, n):
    """Mean linear light of n x n ssaa4 pictures moved by fractions of their samples: 4n x 4n samples a pixel, mixed before what is over white is cut, as areas and sensors mix it.

    Mesa cuts each sample at white. Where the same pictures, but exposed OVER_WHITE_EV, say that this took something away, it is theirs that count: of so few bits that they would be worse elsewhere."""
    light = _mean_light(cam, camera, n)
    cam.set(exposure_ev=OVER_WHITE_EV)
    uncut = _mean_light(cam, camera, n) / 2.0**OVER_WHITE_EV
    cam.set(exposure_ev=0)
    return np.minimum(np.where(uncut > 1.05 * light + 0.02, uncut, light), 1.0)


def _mean_light(cam, camera, n):
    """Of n x n pictures as the camera is set, moved by fractions of their samples; HxWx3, linear, 0 to 1."""
    steps = (np.arange(n) + 0.5) / (4 * n) - 0.125
    total = 0.0
    for shift in [(x, y) for y in steps for x in steps]:
        cam.set(**camera.options(shift))
        total = total + estimator.LINEAR[cam.frame().image] / n**2
    cam.set(**camera.options())
    return total


def antialias(section, quick):
    with measure.rig_of() as rig:
        edges = coverage(rig)
        hall = {}
        rig.load(HALL)
        camera = Camera("hall", fx=480, fy=480)
        cam = measure.new_camera(rig, **camera.options(), **LOBBY)
        cam.set(antialias="ssaa4")
        light = finer(cam, camera, 2 if quick else 4)
        reference = np.round(255 * estimator.encode(light)).astype(np.uint8)
        for mode in ANTIALIAS:
            cam.set(antialias=mode)
            picture = cam.frame().image
            hall[mode] = (quality.psnr(picture, reference), quality.ssim(picture, reference), picture_ms(rig, cam, LOBBY))
    base = hall["none"][2]
    section.say(
        f"Coverage: the error of linear light in the pixels that one edge of triangles at random angles crosses (white on black), against the exact area. Hall: PSNR and SSIM of `scenes/hall.json` against the mean of {4 if quick else 16} ssaa4 pictures, {64 if quick else 256} samples a pixel, which sample textures as finely as ssaa4 does. Time: CPU "
        f"of a picture asked for by `frame.get`, raw, 640x480, of the hall by a camera that moves: the median; the last column is relative to `none` in the same run."
    )
    section.table(
        ("antialias", "coverage error rms", "max", "hall PSNR, dB", "SSIM", "CPU ms", "CPU / none"),
        [(m, edges[m][0], edges[m][1], hall[m][0], f"{hall[m][1]:.4f}", hall[m][2], hall[m][2] / base) for m in ANTIALIAS],
    )
    for mode in ANTIALIAS:
        section.gate(f"coverage error rms, {mode}", edges[mode][0], EXPECTED_COVERAGE_RMS[mode])

    def draw(_, axes):
        for mode in ANTIALIAS:
            axes.semilogy(hall[mode][2], edges[mode][0], "o", label=mode)
        axes.set(xlabel="CPU of one 640x480 picture of the hall, ms", ylabel="coverage error, rms")
        axes.legend(fontsize=8)

    section.plot("antialias", draw, "Speed against coverage error of the anti-aliasing modes")


def lens_methods(section, quick):
    """Method and filter of one barrel and one fisheye: geometry, likeness and time."""
    cases = [next(c for c in LENSES if c.name == n) for n in ("EuRoC cam0", "fisheye 160 deg")]
    choices = [("auto", "auto"), ("warp", "bilinear"), ("warp", "bicubic"), ("cube", "bilinear"), ("cube", "bicubic")]
    points = []
    rows = []
    with measure.rig_of() as rig:
        for camera in cases:
            field = marks.place_discs(camera)
            rig.load(marks.write_scene(rig.folder, field))
            cam = measure.new_camera(rig, **camera.options(), **field.pose())
            errors = {}
            for choice in choices:
                options = dict(camera.options(), lens=lens_of(camera, *choice))
                try:
                    errors[choice] = dithered_with(cam, camera, field, 2, options)
                except camrig.CamrigError as refused:  # a warp cannot hold a fisheye: the rig says so
                    errors[choice] = str(refused)
            rig.load(HALL)
            cam = measure.new_camera(rig, **camera.options(), **LOBBY)
            cam.set(antialias="ssaa3", lens=lens_of(camera, "auto", "bicubic"))
            reference = cam.frame().image
            cam.set(antialias="none")
            for choice in choices:
                if isinstance(errors[choice], str):
                    rows.append((camera.name, *choice, "refused", "", "", ""))
                    continue
                cam.set(lens=lens_of(camera, *choice))
                picture = cam.frame().image
                cost = picture_ms(rig, cam, LOBBY)
                most, rms, _ = estimator.summary(errors[choice])
                rows.append((camera.name, *choice, most, rms, quality.psnr(picture, reference), cost))
                points.append((camera.name, choice, cost, rms))
    section.say(
        "Reprojection error of discs in the mean of four pictures without anti-aliasing (so mostly what samples of the source cost), likeness to the same picture drawn with "
        "ssaa3 (hall), and CPU of a picture through `frame.get`, the camera moving. The first row is what a camera does unless told otherwise: camrig's own rasteriser draws "
        "through the lens itself, the others resample a picture of Mesa's."
    )
    section.table(("lens", "method", "filter", "max px", "rms px", "hall PSNR, dB", "CPU ms"), rows)

    def draw(_, axes):
        for (name, marker) in zip([c.name for c in cases], "os"):
            for _, choice, cost, rms in [p for p in points if p[0] == name]:
                color = {"auto": "tab:blue", "warp": "tab:orange", "cube": "tab:green"}[choice[0]]
                axes.plot(cost, rms, marker, color=color, fillstyle="full" if choice[1] == "bicubic" else "none", markersize=7)
            axes.plot([], [], marker, color="gray", label=name)
        for method, color in (("auto", "tab:blue"), ("warp", "tab:orange"), ("cube", "tab:green")):
            axes.plot([], [], ".", color=color, label=method)
        axes.set(xlabel="CPU of one 640x480 or 752x480 picture, ms", ylabel="reprojection error, rms px")
        axes.legend(fontsize=8)

    section.plot("lens-methods", draw, "Speed against reprojection error of lens methods; filled: bicubic")


def lens_of(camera, method, filter_):
    return {"model": camera.model, "coefficients": list(camera.coefficients), "method": method, "filter": filter_}


def dithered_with(cam, camera, field, n, options):
    outlines, truth = field.outlines(camera), field.truth(camera)
    total = np.zeros_like(truth)
    for shift in estimator.shifts(n):
        cam.set(**dict(options, intrinsics=camera.options(shift)["intrinsics"]))
        total += estimator.centroids(estimator.linear_light(cam.frame().image), outlines + np.array(shift)) - shift
    return total / n**2 - truth


def inside_of_surfaces(cam, tolerance=0.01):
    """(H, W): pixels around which 3 x 3 show one flat piece of one object, so that edges count for nothing."""
    instance, depth, normal = cam.instances(), cam.depth(), cam.frame(kind="normal").image
    bent = np.zeros(depth.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        inverse = 1 / depth  # of a plane it is linear in the picture
        for axis in (0, 1):
            bent = np.maximum(bent, abs(np.roll(inverse, 1, axis) + np.roll(inverse, -1, axis) - 2 * inverse) / inverse)
    flat = np.isfinite(depth) & ~(bent > tolerance)
    for shift in [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]:
        flat &= (instance == np.roll(instance, shift, (0, 1))) & (abs(normal - np.roll(normal, shift, (0, 1))).max(axis=2) < tolerance)
    flat[[0, -1], :] = flat[:, [0, -1]] = False
    return flat


# Quality, antialias, device, and how these filter textures.
TEXTURES = (
    ("fast", "none", "cpu", "nearest level, one sample"),
    ("simple", "none", "cpu", "nearest level, one sample"),
    ("simple", "coverage", "cpu", "up to four samples along the footprint"),
    ("beautiful", "none", "cpu", "between levels, one sample"),
    ("beautiful", "coverage", "cpu", "up to four samples along the footprint"),
    ("simple", "none", "llvmpipe", "nearest level, one sample"),
)


def textures(section, quick):
    """What each way to filter textures costs and how near it comes to many samples, where no edge is."""
    camera = Camera("hall", fx=480, fy=480)
    rows = []
    for level, antialias, device, how in TEXTURES:
        with measure.rig_of(HALL, device=device) as rig:
            cam = measure.new_camera(rig, **camera.options(), **LOBBY)
            cam.set(quality=level, antialias="ssaa4")
            light = finer(cam, camera, 2 if quick else 4)
            inside = inside_of_surfaces(cam)
            cam.set(antialias=antialias)
            error = (255 * estimator.encode(light) - cam.frame().image)[inside]
            rms = float(np.sqrt((error**2).mean()))
            rows.append((level, antialias, device, how, rms, float(np.percentile(abs(error), 99)), float(100 * inside.mean()), picture_ms(rig, cam, LOBBY, 9 if quick else 31)))
    section.say(
        f"The pixels of the hall inside of flat surfaces, where no edge is near, against the mean of {4 if quick else 16} ssaa4 pictures of the same quality and device "
        f"({64 if quick else 256} samples a pixel). The error is of codes (0 to 255); 640x480, a camera that moves, through `frame.get`."
    )
    section.table(("quality", "antialias", "device", "filter", "error rms", "99 % below", "pixels, %", "CPU ms"), rows)

    def draw(_, axes):
        for level, antialias, device, _, rms, _, _, cost in rows:
            axes.plot(cost, rms, "o", label=f"{level}, {antialias}, {device}")
        axes.set(xlabel="CPU of one 640x480 picture of the hall, ms", ylabel="error inside of surfaces, rms codes")
        axes.legend(fontsize=8)

    section.plot("textures", draw, "Speed against error of texture filtering")
