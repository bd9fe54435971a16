"""Measurements on a running rig. Each returns plain numbers; gates are the tests' affair, tables the report's."""

import contextlib
import pathlib
import tempfile

import cv2
import numpy as np

from tools.bench import report

from . import boards, estimator, marks

NAME = "meter"


@contextlib.contextmanager
def rig_of(scene=None, device="cpu", **options):
    """A rig whose world stands still, and a folder for scenes."""
    with tempfile.TemporaryDirectory(prefix="camrig-accuracy-") as folder:
        folder = pathlib.Path(folder)
        if scene is None:
            scene = marks.write_scene(folder, marks.place_discs(_any_camera()))
        with report.start(scene, mode="lockstep", device=device, **options) as rig:
            rig.folder = folder
            yield rig


def new_camera(rig, **options):
    """The one camera that measures, made anew: `load` keeps those there are."""
    if NAME in [camera.name for camera in rig.cameras()]:
        rig.camera(NAME).delete()
    return rig.create_camera(NAME, **options)


def _any_camera():
    from .lenses import PINHOLES

    return PINHOLES[0]


def reprojection(rig, camera, dither=4, radius_px=9.0, spacing_px=42.0, **options):
    """Residuals (N, 2) and places (N, 2) in px of discs all over one camera's picture, measured minus OpenCV."""
    field = marks.place_discs(camera, radius_px, spacing_px)
    rig.load(marks.write_scene(rig.folder, field))
    cam = new_camera(rig, **camera.options(), **field.pose(), **options)
    residuals = estimator.dithered(cam, camera, field, dither)
    return residuals, field.truth(camera)


# Pictures moved by these, in px: one ordinary one, or four, whose mean has 256 places a pixel by areas.
ONE, FOUR = [(0.0, 0.0)], [(x / 16, y / 16) for y in (-1, 1) for x in (-1, 1)]


def corners_of_board(cam, camera, chosen, shifts=FOUR):
    """Pixels of the corners that each view shows, as cornerSubPix finds them in the mean of the pictures."""
    light = [0.0] * len(chosen)
    for shift in shifts:
        cam.set(**camera.options(shift))
        for i, seen in enumerate(chosen):
            cam.set(**seen.view.options())
            light[i] = light[i] + estimator.linear_light(cam.frame().image) / len(shifts)
    edges = "straight" if camera.model == "pinhole" else "bent"
    return [boards.find_corners(picture, seen.pixels, edges) for picture, seen in zip(light, chosen)]


def calibrate(rig, camera, count=20, seed=5, shifts=FOUR, **options):
    """(rms, matrix, distortion) of OpenCV's calibration of `count` rendered views, and the corners' errors (N, 2), px."""
    chosen = boards.views(camera, count, seed)
    cam = new_camera(rig, **camera.options(), **options)
    pictures = corners_of_board(cam, camera, chosen, shifts)
    errors = np.concatenate([found - seen.pixels for found, seen in zip(pictures, chosen)])
    return solve(camera, pictures, [seen.corners for seen in chosen]), errors


def solve(camera, pictures, corners):
    """(rms, matrix, distortion) by OpenCV from pixels of several pictures and the corners' indices."""
    points = [boards.OBJECT_POINTS[c] for c in corners]
    if camera.model == "equidistant":
        # OpenCV 5 has the flags of its fisheye module among all others, with other values.
        of = cv2.fisheye if hasattr(cv2.fisheye, "CALIB_FIX_SKEW") else cv2
        flags = of.CALIB_RECOMPUTE_EXTRINSIC + of.CALIB_FIX_SKEW + of.CALIB_USE_INTRINSIC_GUESS
        criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 200, 1e-10)
        # A start as a person would type it: its own guess is too poor for boards that go over the border.
        start = np.diag([round(camera.fx, -1) + 10.0, round(camera.fx, -1) + 10.0, 1.0])
        start[:2, 2] = (np.array(camera.size) - 1) / 2
        rms, matrix, k, _, _ = cv2.fisheye.calibrate(
            [p.reshape(1, -1, 3) for p in points], [c.reshape(1, -1, 2).astype(np.float64) for c in pictures],
            camera.size, start, np.zeros(4), flags=flags, criteria=criteria,
        )
        return rms, matrix, k.ravel()
    flags = {"rational_polynomial": cv2.CALIB_RATIONAL_MODEL, "pinhole": cv2.CALIB_FIX_K3}.get(camera.model, 0)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-12)
    points, pictures = [p.astype(np.float32) for p in points], [p.astype(np.float32) for p in pictures]
    rms, matrix, k, _, _ = cv2.calibrateCamera(points, pictures, camera.size, None, None, flags=flags, criteria=criteria)
    return rms, matrix, k.ravel()


def curve_error(camera, matrix, k):
    """Largest distance in px, over the picture, between where the camera and its calibration see a direction.

    Up to 90 % of the fold, and for fisheyes to 80 degrees: OpenCV's own projection ends at 90.
    """
    width, height = camera.size
    x, y = np.meshgrid(np.linspace(0, width - 1, 33), np.linspace(0, height - 1, 25))
    limit = min(0.9 * camera.fold_angle(), np.radians(80))
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    directions = camera.unproject(pixels, limit)
    good = np.isfinite(directions).all(axis=1)
    directions = directions[good]
    if camera.model == "equidistant":
        estimate = cv2.fisheye.projectPoints(directions.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, k)[0]
    else:
        estimate = cv2.projectPoints(directions, np.zeros(3), np.zeros(3), matrix, k)[0]
    return float(np.linalg.norm(estimate.reshape(-1, 2) - camera.project(directions), axis=1).max())


def stereo(rig, camera, baseline_m=0.12, count=32, **options):
    """Baseline (m) and rotation (deg) between two rendered cameras by cv2.stereoCalibrate, and what they should be."""
    right_of_left = np.array([baseline_m, 0.0, 0.0])  # the right camera's place in the left optical frame
    turn = cv2.Rodrigues(np.radians([0.3, -1.2, 0.5]))[0]  # right_from_left, optical frames
    pairs = []
    for left in boards.views(camera, 3 * count, seed=9):
        world_from_left = marks.rotation_of(left.view.orientation) @ marks.LINK_FROM_OPTICAL
        body = world_from_left @ turn.T @ marks.LINK_FROM_OPTICAL.T
        right = boards.see(camera, boards.View(left.view.position + world_from_left @ right_of_left, boards.quaternion_of(body)))
        both = np.intersect1d(left.corners, right.corners) if right else []
        if len(both) >= 40:
            pairs.append([boards.Seen(s.view, both, s.pixels[np.isin(s.corners, both)]) for s in (left, right)])
    pairs = pairs[:count]
    cam = new_camera(rig, **camera.options(), **options)
    lefts, rights = (corners_of_board(cam, camera, [pair[i] for pair in pairs]) for i in (0, 1))
    corners = [pair[0].corners for pair in pairs]
    _, matrix_l, k_l = solve(camera, lefts, corners)
    _, matrix_r, k_r = solve(camera, rights, corners)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-12)
    rms, *_, rotation, translation, _, _ = cv2.stereoCalibrate(
        [boards.OBJECT_POINTS[c].astype(np.float32) for c in corners], [p.astype(np.float32) for p in lefts], [p.astype(np.float32) for p in rights],
        matrix_l, k_l, matrix_r, k_r, camera.size,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS | (cv2.CALIB_FIX_K3 if camera.model == "pinhole" else 0), criteria=criteria,
    )
    off = np.degrees(np.linalg.norm(cv2.Rodrigues(rotation @ turn.T)[0]))
    return {"matrix": matrix_l, "rms": rms, "baseline": float(np.linalg.norm(translation)), "true_baseline": baseline_m, "rotation_off_deg": float(off), "pairs": len(pairs)}
