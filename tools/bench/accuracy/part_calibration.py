"""OpenCV's calibration of rendered boards, and lens inverses against cv2.undistortPoints."""

import subprocess

import cv2
import numpy as np

from . import REPOSITORY, measure
from .lenses import LENSES, PINHOLES, Camera

SCENE = REPOSITORY / "scenes" / "calibration.json"
CALIBRATED = (
    PINHOLES[1],
    next(c for c in LENSES if c.name == "EuRoC cam0"),
    next(c for c in LENSES if c.name == "barrel, k3"),
    next(c for c in LENSES if c.name == "fisheye 120 deg"),
    next(c for c in LENSES if c.name == "fisheye 160 deg"),
)


def calibration(section, quick):
    rows = []
    worst = {"focal": 0.0, "principal": 0.0, "rms": 0.0, "curve": 0.0}
    with measure.rig_of(SCENE) as rig:
        for camera in CALIBRATED[:: 3 if quick else 1]:
            for shifts in (measure.ONE, measure.FOUR):
                (rms, matrix, k), errors = measure.calibrate(rig, camera, shifts=shifts, antialias="coverage")
                focal = max(abs(matrix[0, 0] / camera.fx - 1), abs(matrix[1, 1] / camera.fy - 1)) * 100
                principal = max(abs(matrix[0, 2] - camera.cx), abs(matrix[1, 2] - camera.cy))
                curve = measure.curve_error(camera, matrix, k)
                rows.append((camera.name, len(shifts), focal, principal, rms, curve, float(np.sqrt((errors**2).sum(axis=1).mean()))))
            for key, value in zip(worst, (focal, principal, rms, curve)):
                worst[key] = max(worst[key], value)
    section.say(
        "Twenty views of the chequerboard of `scenes/calibration.json` (11 x 8 inner corners; the board may go over the border), by `antialias: coverage`, each one ordinary picture or the mean of four an eighth of a pixel apart (of which the bounds are), corners by `cv2.cornerSubPix` on linear light under a "
        "Gaussian of 1.6 (pinholes) or 1 px, then `cv2.calibrateCamera` without a guess, or `cv2.fisheye.calibrate` from a focal length off by several per cent. Curve: the largest distance, all over the picture (to 90 % of the fold and 80 degrees), between where the camera and its calibration see one direction."
    )
    section.table(("camera", "pictures", "fx, fy off, %", "cx, cy off, px", "rms, px", "curve, px", "corners off, px rms"), rows)
    section.gate("fx, fy recovered", worst["focal"], 0.05, "%")
    section.gate("cx, cy recovered", worst["principal"], 0.1, "px")
    section.gate("calibration's rms", worst["rms"], 0.05, "px")
    section.gate("distortion curve recovered", worst["curve"], 0.05, "px")


def stereo(section, quick):
    with measure.rig_of(SCENE) as rig:
        pair = measure.stereo(rig, PINHOLES[0], antialias="coverage")
    off = abs(pair["baseline"] / pair["true_baseline"] - 1) * 100
    section.say(
        f"Stereo, {pair['pairs']} pairs by `antialias: coverage`, baseline {pair['true_baseline']} m, turned by 1.3 deg: `cv2.stereoCalibrate` is off by {off:.4f} % of the baseline and "
        f"{pair['rotation_off_deg']:.5f} deg, rms {pair['rms']:.4f} px."
    )
    section.gate("stereo baseline", off, 0.05, "%")
    section.gate("stereo rotation", pair["rotation_off_deg"], 0.002, "deg")


def random_lens(random, n):
    """Plausible lenses: mild to strong, with and without tangential terms; the recipe of tests/unit/camera."""
    strength = 10.0 ** random.uniform(-2, 0)
    tangential = 0.0 if n % 5 == 0 else 10.0 ** random.uniform(-5, -1.7)
    u = lambda size: strength * random.uniform(-size, size)  # noqa: E731
    p = lambda: tangential * random.uniform(-1, 1)  # noqa: E731
    if n % 3 == 0:
        return "plumb_bob", [u(0.6), u(0.4), p(), p(), u(0.2)]
    if n % 3 == 1:
        big = 1.0 if n % 2 else 10.0
        k4, k5, k6 = u(big), u(big), u(0.3 * big)
        return "rational_polynomial", [k4 + u(0.5), k5 + u(0.5), p(), p(), k6 + u(0.2), k4, k5, k6]
    return "equidistant", [u(0.15), u(0.1), u(0.05), u(0.02)]


def probe():
    """The built lens_probe program."""
    for preset in ("ci", "dev"):
        path = REPOSITORY / "build" / preset / "tests" / "unit" / "camera" / "lens_probe"
        if path.exists():
            return path
    raise RuntimeError("lens_probe is not built: cmake --build build/dev --target lens_probe")


def one_to_one_angle(camera):
    """Angle up to which the lens is one-to-one in every direction: tangential terms take 6 |p| r off the radial slope
    in the worst of them (core/camera/lens_map.h)."""
    limit = camera.fold_angle()
    if camera.model == "equidistant":
        return limit
    r = np.linspace(0, np.tan(limit), 20001)
    slope = np.gradient(camera._radius(np.arctan(r)), r)
    falling = slope - 6 * np.hypot(*camera.coefficients[2:4]) * r <= 0
    return float(np.arctan(r[np.argmax(falling)])) if falling.any() else limit


def inverse(section, quick):
    lenses, points = (200, 50) if quick else (3000, 100)
    random = np.random.default_rng(12)
    cases = []
    for n in range(lenses):
        model, k = random_lens(random, n)
        camera = Camera("random", model, tuple(k), 1.0, 1.0, 0.0, 0.0)
        limit = one_to_one_angle(camera)
        theta = limit * 0.98 * np.sqrt(random.uniform(0, 1, points))
        theta = np.minimum(theta, np.radians(75 if model != "equidistant" else 85))
        phi = random.uniform(-np.pi, np.pi, points)
        directions = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
        cases.append((model, k, camera, camera.project(directions)))
    lines = "".join(f"{m} {' '.join(map(repr, map(float, k)))} {x!r} {y!r}\n" for m, k, _, d in cases for x, y in d.tolist())
    answers = subprocess.run([probe()], input=lines, capture_output=True, text=True, check=True).stdout.splitlines()
    table = {}

    def note(method, model, residuals, missing):
        entry = table.setdefault((method, model), [[], 0])
        entry[0].append(residuals)
        entry[1] += missing

    for i, (model, k, camera, distorted) in enumerate(cases):
        mine = answers[i * points : (i + 1) * points]
        known = np.array([not a.startswith(("none", "refused")) for a in mine])
        if mine[0] == "refused":
            continue
        ideal = np.array([[float(v) for v in a.split()] if ok else (np.nan, np.nan) for a, ok in zip(mine, known)])
        note("camrig", model, residual(camera, ideal, distorted), int((~known).sum()))
        matrix = np.eye(3)
        for iterations in (None, 100):
            criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, iterations or 10, 1e-14)
            name = f"OpenCV, {iterations} iterations" if iterations else "OpenCV, default"
            flat = distorted.reshape(-1, 1, 2)
            if model == "equidistant":
                found = cv2.fisheye.undistortPoints(flat, matrix, np.array(k), criteria=criteria) if iterations else cv2.fisheye.undistortPoints(flat, matrix, np.array(k))
                found = found.reshape(-1, 2)
                lost = ~np.isfinite(found).all(axis=1) | (np.abs(found) > 1e5).any(axis=1)
                r = np.linalg.norm(found, axis=1)
                found = np.where(r[:, None] > 0, found / np.maximum(r, 1e-300)[:, None] * np.arctan(r)[:, None], found)
            else:
                found = cv2.undistortPoints(flat, matrix, np.array(k)) if iterations is None else undistorted(flat, matrix, np.array(k), criteria)
                found = found.reshape(-1, 2)
                lost = ~np.isfinite(found).all(axis=1)
            found = np.where(lost[:, None], np.nan, found)
            note(name, model, residual(camera, found, distorted), int(lost.sum()))
    rows = []
    for (method, model), (residuals, missing) in sorted(table.items(), key=lambda item: (item[0][1], item[0][0])):
        r = np.concatenate(residuals)
        finite = r[np.isfinite(r)]
        rows.append((model, method, len(r), float(np.median(finite)), float(finite.max()), f"{100 * ((finite > 1e-3).sum() + missing) / len(r):.2f} %", missing))
        if method == "camrig":
            section.gate(f"inverse of {model}, residual", finite.max(), 1e-9)
            section.gate(f"inverse of {model}, points not found", missing, 0.5)
    section.say(
        f"{lenses} random lenses, {points} points each, all of them where the lens is one-to-one (within 98 % of the fold, tangential terms counted, and 75, fisheye 85 degrees), distorted by OpenCV's "
        "formula and undistorted again. The residual is the distance, in focal lengths, between the point and what the answer distorts to; 1e-3 is a pixel at f = 1000."
    )
    section.table(("model", "method", "points", "median residual", "largest", "off by over 1e-3, or none", "no answer"), rows)
    section.say(
        "The larger run, 10^4 lenses and 10^6 points and both ways, is the unit test `InverseMap.TenThousandLensesAndAMillionPointsHaveNoResidualAndNeverLeaveTheValidDisc`; it also "
        "holds that no answer lies beyond the fold."
    )


def undistorted(points, matrix, k, criteria):
    """OpenCV 5 takes the criteria in undistortPoints itself."""
    if hasattr(cv2, "undistortPointsIter"):
        return cv2.undistortPointsIter(points, matrix, k, None, None, criteria)
    return cv2.undistortPoints(points, matrix, k, criteria=criteria)


def residual(camera, ideal, distorted):
    """Relative residual of answers in the ideal plane (angles for equidistant)."""
    if camera.model == "equidistant":
        theta = np.linalg.norm(ideal, axis=1)
        unit = ideal / np.maximum(theta, 1e-300)[:, None]
        directions = np.concatenate([np.sin(theta)[:, None] * unit, np.cos(theta)[:, None]], axis=1)
    else:
        directions = np.concatenate([ideal, np.ones((len(ideal), 1))], axis=1)
    bad = ~np.isfinite(directions).all(axis=1)
    directions[bad] = (0, 0, 1)
    with np.errstate(all="ignore"):
        out = np.linalg.norm(camera.project(directions) - distorted, axis=1) / np.maximum(1, np.linalg.norm(distorted, axis=1))
    out[bad] = np.nan
    return out
