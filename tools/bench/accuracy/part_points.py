"""Where the cameras see a point: by lens, by place in the picture, far from the origin, and depth."""


import numpy as np
from camrig_assets.glb import Glb
from camrig_assets.scene import Scene

from . import estimator, marks, measure
from .lenses import LENSES, PINHOLES, Camera


def reprojection(section, quick):
    cameras = PINHOLES + LENSES
    if quick:
        cameras = cameras[::6]
    rulers = [estimator.bias(samples=8, shifts_n=n, trials=300) for n in (1, 2)]
    section.say(
        "Discs of 9 px radius all over the picture, measured minus `cv2.projectPoints` / `cv2.fisheye.projectPoints` in double (beyond 90 degrees, where OpenCV has no "
        f"answer, its formula with theta by atan2). One ordinary picture with `antialias: coverage` is what a program gets; of four, whose principal points are moved by fractions of a pixel, less of "
        "the error is of sampling, and more of it of the camera. The last column is one picture with one sample a pixel. On discs of 64 samples a pixel by formula the estimator itself is off by "
        + " (one picture) and ".join(f"at most {np.hypot(*b.T).max():.4f} px, {np.sqrt((b**2).sum(axis=1).mean()):.4f} px rms" for b in rulers)
        + " (four): what is of this size below is the ruler, not the camera."
    )
    rows, by_place, worst = [], [], {"pinhole": [0.0, 0.0], "lens": [0.0, 0.0]}
    with measure.rig_of() as rig:
        for camera in cameras:
            kind = "pinhole" if camera.model == "pinhole" else "lens"
            one, places = measure.reprojection(rig, camera, dither=1, antialias="coverage")
            four, _ = measure.reprojection(rig, camera, dither=2, antialias="coverage")
            plain, _ = measure.reprojection(rig, camera, dither=1, antialias="none")
            (most, rms, mean), (most_of_four, rms_of_four, _) = estimator.summary(one), estimator.summary(four)
            rows.append((camera.name, camera.model, len(places), most, rms, float(np.hypot(*mean)), most_of_four, rms_of_four, estimator.summary(plain)[1]))
            worst[kind] = [max(pair) for pair in zip(worst[kind], (most, most_of_four))]
            half = np.hypot(*camera.size) / 2
            by_place.append((camera, np.linalg.norm(places - (np.array(camera.size) - 1) / 2, axis=1) / half, np.hypot(*four.T)))
    section.table(("camera", "lens model", "discs", "one picture, max px", "rms px", "mean px", "four pictures, max px", "rms px", "one sample, rms px"), rows)
    section.say("The worst marks are those of the strong barrel nearest to its fold: within a pixel a ray is taken to change evenly, and there it does not.")
    for kind, name, limits in (("pinhole", "pinhole", (0.02, 0.015)), ("lens", "every lens model", (0.04, 0.035))):
        section.gate(f"{name}, one picture, max", worst[kind][0], limits[0], "px")
        section.gate(f"{name}, four pictures, max", worst[kind][1], limits[1], "px")

    def draw(_, axes):
        for camera, radius, error in by_place:
            axes.scatter(radius, error, s=5, alpha=0.5, color={"pinhole": "tab:blue", "plumb_bob": "tab:orange", "rational_polynomial": "tab:green", "equidistant": "tab:red"}[camera.model], linewidths=0)
        for model, color in (("pinhole", "tab:blue"), ("plumb_bob", "tab:orange"), ("rational_polynomial", "tab:green"), ("equidistant", "tab:red")):
            axes.scatter([], [], s=12, color=color, label=model)
        axes.set(xlabel="distance from the middle of the picture (1: corner)", ylabel="reprojection error, px", yscale="log", ylim=(1e-5, 0.1))
        axes.legend(loc="lower left", fontsize=8, ncols=2)

    section.plot("reprojection", draw, "Reprojection error of every disc by its place in the picture, all cameras of the table")


def offset(section, quick):
    camera = PINHOLES[1]
    field = marks.place_discs(camera)
    rows = []
    reference = None
    distances = [0.0] + [10.0**k for k in ((3, 6, 9) if quick else range(3, 10))]
    with measure.rig_of() as rig:
        for distance in distances:
            moved = np.array([distance, -distance, distance])
            rig.load(marks.write_scene(rig.folder, field, offset=moved))
            # The place of the camera as a double at that distance; the truth keeps the place that was meant.
            pose = {"position": list(field.position + moved), "orientation": list(field.orientation)}
            cam = measure.new_camera(rig, **camera.options(), **pose)
            picture = cam.frame().image
            reference = picture if reference is None else reference
            residuals = estimator.dithered(cam, camera, field, 4)
            if distance == 0.0:
                origin = residuals
            differing = np.abs(picture.astype(int) - reference)
            most = float(np.abs(residuals - origin).max())
            rows.append((f"{distance:.0e}" if distance else "0", int((differing.max(axis=2) > 1).sum()), float(np.hypot(*(residuals - origin).mean(axis=0))), most, estimator.summary(residuals)[0]))
    section.say(
        "The same discs and camera, moved by (d, -d, d). The camera's place is given as it is at the origin plus d, so a double rounds it "
        "(by 6e-8 m at 1e9 m); discs and camera are 4 m apart. Pose error: the mean shift of all discs against d = 0."
    )
    section.table(("d, m", "pixels off by over 1 code", "pose error, px", "largest change of a disc, px", "max reprojection error, px"), rows)
    section.gate("pose error up to 1e9 m from the origin", max(r[2] for r in rows), 0.002, "px")

    def draw(_, axes):
        x = [max(d, 1.0) for d in distances]
        axes.loglog(x, [max(r[2], 1e-7) for r in rows], "o-", label="camrig, measured")
        naive = [1000 / 7.5 * np.spacing(np.float32(d)) / 2 if d else 1e-7 for d in distances]
        axes.loglog(x, np.maximum(naive, 1e-7), "--", color="gray", label="float32 world, half an ulp")
        axes.axhline(0.002, color="tab:red", linewidth=1, label="gate")
        axes.set(xlabel="distance of the world's objects from the origin, m", ylabel="pose error, px")
        axes.legend(fontsize=8)

    section.plot("offset", draw, "Pose error against the distance of camera and objects from the world's origin (0 is drawn at 1e-7)")


def depth(section, quick):
    distances = [0.1, 1.0, 100.0, 1e4, 1e6] if quick else [0.1, 0.3, 1, 3, 10, 30, 100, 300, 1e3, 3e3, 1e4, 1e5, 1e6]
    rows, middle, whole = [], [], []
    camera = Camera("depth", fx=520, fy=520, cx=320.0, cy=240.0)
    with measure.rig_of() as rig:
        rig.load(walls(rig.folder, distances))
        cam = measure.new_camera(rig, **camera.options(), position=(0, 0, 0), near=0.001)
        for i, distance in enumerate(distances):
            cam.set(position=(0, 0, 0), pan_deg=step_deg(distances) * i)
            metres = cam.depth()
            ids = cam.instances()
            lit = ids == ids[240, 320]  # a neighbour may be in the picture too
            error = np.abs(metres[lit].astype(np.float64) / distance - 1)
            middle.append(abs(float(metres[240, 320]) / distance - 1))
            whole.append(float(error.max()))
            rows.append((f"{distance:g}", middle[-1], whole[-1], int(lit.sum())))
    section.say(
        "Walls across the optical axis at stated distances, one world, near plane at 1 mm, no far plane. Depth is along the axis, so "
        "the whole wall has one. A float32 itself is within 6e-8 (relative)."
    )
    section.table(("distance, m", "relative error in the middle", "largest on the wall", "pixels"), rows)
    section.gate("depth, relative, middle of the picture", max(middle), 1e-6)

    def draw(_, axes):
        floor = 1e-9
        axes.loglog(distances, np.maximum(middle, floor), "o-", label="middle of the picture")
        axes.loglog(distances, np.maximum(whole, floor), "s-", label="largest of all pixels")
        axes.loglog(distances, [d / 0.001 * 2**-25 for d in distances], "--", color="gray", label="24-bit depth, near plane 1 mm")
        axes.axhline(1e-6, color="tab:red", linewidth=1, label="gate (middle)")
        axes.set(xlabel="distance, m", ylabel="relative error of depth", ylim=(floor / 2, 10))
        axes.legend(fontsize=8)

    section.plot("depth", draw, "Relative error of the depth picture against distance (0 is drawn at 1e-9)")


def step_deg(distances):
    return round(360 / (len(distances) + 1))


def walls(folder, distances):
    """One unit wall, placed at each distance in a direction of its own, +-7 degrees wide."""
    glb = Glb("wall")
    white = glb.material("white", base=(1, 1, 1), unlit=True, double_sided=True)
    half = 0.125
    corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
    glb.node("wall", mesh=glb.mesh("wall", [glb.primitive(corners, [(0, 0, 1)] * 4, [(0, 1, 2), (0, 2, 3)], white)]))
    (folder / "wall.glb").write_bytes(glb.bytes())
    scene = Scene("walls", "Walls for measuring depth.", seed=1)
    scene.environment(background=(0, 0, 0), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("wall", "wall.glb")
    path = folder / "walls.json"
    import json

    data = json.loads(scene.text())
    data["objects"] = []
    for i, distance in enumerate(distances):
        angle = np.radians(step_deg(distances) * i)
        data["objects"].append(
            {"name": f"wall {i}", "model": "wall", "position": [distance * np.cos(angle), distance * np.sin(angle), 0.0], "yaw_deg": float(step_deg(distances) * i - 90), "scale": float(distance)}
        )
    path.write_text(json.dumps(data))
    return path
