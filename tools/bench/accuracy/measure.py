"""Measurements on a running rig. Each returns plain numbers; gates are the tests' affair, tables the report's."""

import contextlib
import pathlib
import tempfile

import camrig
import cv2
import numpy as np

from . import boards, estimator, marks

NAME = "meter"


@contextlib.contextmanager
def rig_of(scene=None, **options):
    """A rig on the CPU device whose world stands still, and a folder for scenes."""
    with tempfile.TemporaryDirectory(prefix="camrig-accuracy-") as folder:
        folder = pathlib.Path(folder)
        if scene is None:
            scene = marks.write_scene(folder, marks.place_discs(_any_camera()))
        with camrig.start(scene, mode="lockstep", device="cpu", **options) as rig:
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


def corners_of_board(camera, view, cam):
    """Corners of the calibration board as cornerSubPix finds them in one picture, in board order."""
    cam.set(**view.options())
    grey = cv2.cvtColor(cam.frame().image, cv2.COLOR_BGR2GRAY)
    return boards.find_corners(grey, camera.project(view.optical(boards.world_points())))


def calibrate(rig, camera, count=20, seed=5, **options):
    """What OpenCV's calibration makes of `count` rendered views of the board; see Calibrated."""
    views = boards.views(camera, count, seed)
    cam = new_camera(rig, **camera.options(), **options)
    pictures, errors = [], []
    for view in views:
        found = corners_of_board(camera, view, cam)
        pictures.append(found.astype(np.float32))
        errors.append(found - camera.project(view.optical(boards.world_points())))
    cam.delete()
    return solve(camera, pictures), np.concatenate(errors), views, pictures


def solve(camera, pictures):
    """Intrinsics, distortion and rms (px) by OpenCV from corners of several pictures."""
    points = [boards.OBJECT_POINTS.astype(np.float32)] * len(pictures)
    if camera.model == "equidistant":
        flags = cv2.fisheye.CALIB_RECOMPUTE_EXTRINSIC + cv2.fisheye.CALIB_FIX_SKEW
        criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 200, 1e-10)
        rms, matrix, k, _, _ = cv2.fisheye.calibrate(
            [p.reshape(1, -1, 3).astype(np.float64) for p in points],
            [c.reshape(1, -1, 2).astype(np.float64) for c in pictures],
            camera.size, camera.matrix * 1.0, np.zeros(4), flags=flags, criteria=criteria,
        )
        return rms, matrix, k.ravel()
    flags = 0
    if camera.model == "rational_polynomial":
        flags |= cv2.CALIB_RATIONAL_MODEL
    if camera.model == "pinhole":
        flags |= cv2.CALIB_FIX_K3
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-12)
    rms, matrix, k, _, _ = cv2.calibrateCamera(points, pictures, camera.size, None, None, flags=flags, criteria=criteria)
    return rms, matrix, k.ravel()


def curve_error(camera, matrix, k, reach=1.0):
    """Largest distance in px, over the picture, between where the camera and its calibration see a direction.

    The calibration may have turned the axis a little; what a user sees is the picture, so the best common turn and
    shift of both (a homography of the ideal plane would hide more than that) is not taken out: only principal point
    and focal lengths as calibrated count.
    """
    width, height = camera.size
    x, y = np.meshgrid(np.linspace(0, width - 1, 33), np.linspace(0, height - 1, 25))
    limit = 0.9 * camera.fold_angle() * reach
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    directions = camera.unproject(pixels, limit)
    good = np.isfinite(directions).all(axis=1)
    directions = directions[good]
    if camera.model == "equidistant":
        estimate = cv2.fisheye.projectPoints(directions.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, k)[0]
    else:
        estimate = cv2.projectPoints(directions, np.zeros(3), np.zeros(3), matrix, k)[0]
    return float(np.linalg.norm(estimate.reshape(-1, 2) - camera.project(directions), axis=1).max())


def stereo(rig, camera, baseline_m=0.12, count=20, **options):
    """Baseline (m) and rotation (deg) between two rendered cameras by cv2.stereoCalibrate, and what they should be."""
    right_of_left = np.array([baseline_m, 0.0, 0.0])  # the right camera's place in the left optical frame
    turn = cv2.Rodrigues(np.radians([0.3, -1.2, 0.5]))[0]  # right_from_left, optical frames
    lefts, rights = [], []
    cam = new_camera(rig, **camera.options(), **options)
    for seed in range(5, 400):
        if len(lefts) == count:
            break
        for left in boards.views(camera, 4, seed):
            world_from_left = marks.rotation_of(left.orientation) @ marks.LINK_FROM_OPTICAL
            place = left.position + world_from_left @ right_of_left
            body = world_from_left @ turn.T @ marks.LINK_FROM_OPTICAL.T
            right = boards.View(place, boards.quaternion_of(body))
            seen = camera.project(right.optical(boards._outline()))
            if ((seen < 6) | (seen > np.array(camera.size) - 7)).any() or len(lefts) == count:
                continue
            lefts.append(corners_of_board(camera, left, cam).astype(np.float32))
            rights.append(corners_of_board(camera, right, cam).astype(np.float32))
    cam.delete()
    points = [boards.OBJECT_POINTS.astype(np.float32)] * len(lefts)
    _, matrix_l, k_l = solve(camera, lefts)
    _, matrix_r, k_r = solve(camera, rights)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-12)
    rms, *_, rotation, translation, _, _ = cv2.stereoCalibrate(
        points, lefts, rights, matrix_l, k_l, matrix_r, k_r, camera.size,
        flags=cv2.CALIB_USE_INTRINSIC_GUESS | (cv2.CALIB_FIX_K3 if camera.model == "pinhole" else 0), criteria=criteria,
    )
    off = np.degrees(np.linalg.norm(cv2.Rodrigues(rotation @ turn.T)[0]))
    return {"rms": rms, "baseline": float(np.linalg.norm(translation)), "true_baseline": baseline_m, "rotation_off_deg": float(off), "pairs": len(lefts)}


def light_of(cam, camera, n):
    """The mean linear light (H, W, 3) over n x n shifts: the picture of n x n samples a pixel, box filter."""
    total = 0.0
    for shift in estimator.shifts(n):
        cam.set(**camera.options(tuple(-s for s in shift)))
        total = total + estimator.LINEAR[cam.frame().image]
    cam.set(**camera.options())
    return total / n**2
