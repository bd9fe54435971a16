#!/usr/bin/env python3
"""Writes opencv_reference.txt: pixels that OpenCV's own projectPoints gives for lenses of every model.

Run from anywhere with the project's Python environment: tests/unit/camera/make_opencv_reference.py
The table is committed, so that the C++ test needs no OpenCV. Seeded: a second run writes the same file (up to the
last digit, if OpenCV's arithmetic changes).

Lines:  lens MODEL FX FY CX CY K...     then, for that lens,   point X Y Z U V
"""
from pathlib import Path

import cv2
import numpy as np

POINTS_PER_LENS = 16

# (model, coefficients, largest angle to the axis in degrees that is on the rising branch)
LENSES = [
    ("plumb_bob", [0, 0, 0, 0, 0], 80),
    ("plumb_bob", [-0.28, 0.08, 8e-4, -5e-4, -0.005], 45),            # the mild lens of the accuracy report
    ("plumb_bob", [-0.32, 0.13, 0, 0, -0.025], 57),                   # folds just inside the corner
    ("plumb_bob", [-0.45, 0.25, 1e-3, 2e-3, -0.08], 36),              # strong barrel
    ("plumb_bob", [0.5, 0, 0, 0, 0], 70),                             # pincushion
    ("plumb_bob", [0.25, -0.03, -2e-3, 1e-3, 0.01], 60),
    ("plumb_bob", [-0.1, 0.05, 0.02, -0.015, 0], 50),                 # strong tangential
    ("plumb_bob", [0.01, -0.02, -1e-4, 5e-5, 0.003], 40),
    ("rational_polynomial", [0.1, -0.05, 1e-4, -2e-4, 0.01, 0.3, 0.02, 0.001], 60),
    ("rational_polynomial", [12.5, 6.1, 2e-4, -1e-4, 0.4, 12.9, 9.8, 1.7], 65),   # as OpenCV calibrates wide lenses
    ("rational_polynomial", [-0.4, 0.1, -1e-3, 5e-4, 0.02, -0.1, 0.05, 0.01], 50),
    ("rational_polynomial", [0.6, 0.1, 0, 0, 0.002, 0.9, 0.3, 0.02], 75),
    ("equidistant", [0, 0, 0, 0], 89),
    ("equidistant", [0.05, -0.01, 0.003, -0.0006], 89),
    ("equidistant", [-0.02, 0.004, -0.003, 0.0005], 89),
    ("equidistant", [-0.1, 0.02, -0.004, 0.0003], 85),
    ("equidistant", [0.3, 0.1, -0.02, 0.004], 80),
]


def project(model, camera_matrix, k, points):
    zero = np.zeros(3)
    if model == "equidistant":
        pixels, _ = cv2.fisheye.projectPoints(points.reshape(-1, 1, 3), zero, zero, camera_matrix, np.array(k, float))
    else:
        pixels, _ = cv2.projectPoints(points, zero, zero, camera_matrix, np.array(k, float))
    return pixels.reshape(-1, 2)


def main():
    random = np.random.default_rng(20)
    lines = [f"# made by make_opencv_reference.py with OpenCV {cv2.__version__}"]
    for model, k, max_deg in LENSES:
        fx, fy = random.uniform(300, 1200), random.uniform(300, 1200)
        cx, cy = random.uniform(200, 1400), random.uniform(200, 900)
        angle = np.radians(max_deg) * np.sqrt(random.uniform(0, 1, POINTS_PER_LENS))
        angle[0], angle[1], angle[2] = np.radians(max_deg), 1e-6, 1e-3
        turn = random.uniform(-np.pi, np.pi, POINTS_PER_LENS)
        range_m = 10.0 ** random.uniform(-2, 3, POINTS_PER_LENS)
        points = range_m[:, None] * np.stack(
            [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], axis=1)
        camera_matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
        lines.append("lens " + " ".join([model] + [repr(float(v)) for v in [fx, fy, cx, cy, *k]]))
        for point, pixel in zip(points, project(model, camera_matrix, k, points)):
            lines.append("point " + " ".join(repr(float(v)) for v in [*point, *pixel]))
    Path(__file__).with_name("opencv_reference.txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
