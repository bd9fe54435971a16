"""The cameras that are measured: intrinsics and lenses from mild to extreme, and where OpenCV says they see a point."""

import functools
from dataclasses import dataclass

import cv2
import numpy as np

SIZE = (640, 480)


@dataclass(frozen=True)
class Camera:
    """One parameter set. Pixel centres at integers; coefficients in the order of ROS and OpenCV."""

    name: str
    model: str = "pinhole"
    coefficients: tuple = ()
    fx: float = 520.0
    fy: float = 520.0
    cx: float = 319.5
    cy: float = 239.5
    size: tuple = SIZE

    @property
    def matrix(self):
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    def options(self, shift=(0.0, 0.0)):
        """Arguments of Rig.create_camera and Camera.set; `shift` moves the picture by that many pixels."""
        return {
            "size": self.size,
            "intrinsics": {"fx": self.fx, "fy": self.fy, "cx": self.cx + shift[0], "cy": self.cy + shift[1]},
            "lens": (self.model, list(self.coefficients)),
        }

    def project(self, points):
        """Pixels of points of the optical frame (N, 3), by OpenCV in double.

        cv2.fisheye.projectPoints divides by z, so it knows no direction beyond 90 degrees: there its formula is
        evaluated here, with theta by atan2 (tests/unit/camera holds both against each other below 90 degrees).
        """
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        zero = np.zeros(3)
        if self.model != "equidistant":
            distortion = np.array(self.coefficients or (0, 0, 0, 0, 0), dtype=np.float64)
            return cv2.projectPoints(points, zero, zero, self.matrix, distortion)[0].reshape(-1, 2)
        front = points[:, 2] > 1e-3 * np.linalg.norm(points, axis=1)
        pixels = np.empty((len(points), 2))
        k = np.array(self.coefficients, dtype=np.float64)
        if front.any():
            chosen = points[front].reshape(-1, 1, 3)
            pixels[front] = cv2.fisheye.projectPoints(chosen, zero, zero, self.matrix, k)[0].reshape(-1, 2)
        if not front.all():
            x, y, z = points[~front].T
            r = np.hypot(x, y)
            theta = np.arctan2(r, z)
            distorted = theta * (1 + theta**2 * (k[0] + theta**2 * (k[1] + theta**2 * (k[2] + theta**2 * k[3]))))
            scale = np.where(r > 0, distorted / np.maximum(r, 1e-300), 1.0)
            pixels[~front] = np.stack([self.fx * x * scale + self.cx, self.fy * y * scale + self.cy], axis=1)
        return pixels

    @functools.lru_cache(maxsize=64)
    def fold_angle(self):
        """Angle to the axis at which the radial profile stops rising (sampled: only to keep markers well inside)."""
        theta = np.linspace(1e-4, np.radians(179 if self.model == "equidistant" else 89), 20000)
        rising = np.diff(self._radius(theta)) > 0
        return float(theta[-1] if rising.all() else theta[np.argmin(rising)])

    def unproject(self, pixels, limit):
        """Unit directions of pixels, NaN beyond `limit` (an angle before the fold): bisection on the radial profile, the
        tangential part by fixed-point steps."""
        pixels = np.asarray(pixels, dtype=np.float64)
        target = (pixels - [self.cx, self.cy]) / [self.fx, self.fy]
        wanted = target.copy()
        directions = np.full((len(pixels), 3), np.nan)
        for _ in range(60):
            radius = np.linalg.norm(wanted, axis=1)
            low, high = np.zeros(len(pixels)), np.full(len(pixels), limit)
            for _ in range(60):
                middle = (low + high) / 2
                below = self._radius(middle) < radius
                low, high = np.where(below, middle, low), np.where(below, high, middle)
            theta = (low + high) / 2
            unit = wanted / np.maximum(radius, 1e-300)[:, None]
            directions = np.concatenate([np.sin(theta)[:, None] * unit, np.cos(theta)[:, None]], axis=1)
            got = (self.project(directions) - [self.cx, self.cy]) / [self.fx, self.fy]
            inside = theta < limit * 0.999
            if np.abs(got - target)[inside].max(initial=0) < 1e-11:
                break
            wanted[inside] += (target - got)[inside]
        directions[theta > limit * 0.999] = np.nan
        return directions

    def _radius(self, theta):
        k = list(self.coefficients) + [0.0] * 8
        if self.model == "equidistant":
            return theta * (1 + k[0] * theta**2 + k[1] * theta**4 + k[2] * theta**6 + k[3] * theta**8)
        r = np.tan(theta)
        if self.model == "pinhole":
            return r
        top = 1 + k[0] * r**2 + k[1] * r**4 + k[4] * r**6
        return r * top / (1 + k[5] * r**2 + k[6] * r**4 + k[7] * r**6)


PINHOLES = (
    Camera("pinhole 63 deg"),
    Camera("pinhole, fx != fy, off-centre", fx=611.3, fy=547.9, cx=301.7, cy=255.2),
    Camera("pinhole 110 deg", fx=224.0, fy=224.0),
    Camera("pinhole 10 deg", fx=3650.0, fy=3650.0),
    Camera("pinhole 160 deg", fx=56.4, fy=56.4),
)

LENSES = (
    Camera("webcam", "plumb_bob", (-0.10, 0.02, 0.0, 0.0, 0.0)),
    Camera("EuRoC cam0", "plumb_bob", (-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0), 458.654, 457.296, 367.215, 248.375, (752, 480)),
    Camera("barrel, k3", "plumb_bob", (-0.28, 0.08, 8e-4, -5e-4, -0.005), 350, 350),
    Camera("strong barrel", "plumb_bob", (-0.36, 0.15, 0.0, 0.0, -0.028), 300, 300),
    Camera("pincushion", "plumb_bob", (0.12, 0.05, 0.0, 0.0, 0.0), 520, 520),
    Camera("strong pincushion", "plumb_bob", (0.35, 0.20, 0.0, 0.0, 0.05), 480, 480),
    Camera("moustache", "plumb_bob", (-0.22, 0.28, 0.0, 0.0, -0.06), 420, 420),
    Camera("tangential", "plumb_bob", (0.0, 0.0, 6e-3, -9e-3, 0.0), 420, 420),
    Camera("barrel and tangential", "plumb_bob", (-0.25, 0.06, 4e-3, 3e-3, 0.0), 380, 410, 305.2, 251.8),
    Camera("off-centre barrel", "plumb_bob", (-0.2, 0.04, 0.0, 0.0, 0.0), 400, 400, 250.0, 300.0),
    Camera("fold just inside the corner", "plumb_bob", (-0.32, 0.13, 0.0, 0.0, -0.025), 379.0, 379.0),
    Camera("fold well inside", "plumb_bob", (-0.30, 0.0, 0.0, 0.0, 0.0), 450, 450),
    Camera("rational, wide", "rational_polynomial", (0.9, 0.12, 3e-4, -2e-4, 0.004, 1.25, 0.35, 0.03), 420, 420),
    Camera("rational, mild", "rational_polynomial", (-0.05, 0.02, 1e-4, 2e-4, 0.0, 0.03, 0.01, 0.0), 500, 498),
    Camera("rational, big pairs", "rational_polynomial", (8.1, 3.0, -1e-4, 2e-4, 0.15, 8.4, 5.2, 0.8), 480, 482, 322.1, 236.9),
    Camera("rational 120 deg", "rational_polynomial", (1.4, 0.18, 0.0, 0.0, 0.003, 1.75, 0.50, 0.045), 240, 240),
    Camera("fisheye 120 deg", "equidistant", (-0.012, 0.006, -0.008, 0.002), 300, 300),
    Camera("fisheye 160 deg", "equidistant", (0.02, -0.01, 0.003, -0.0005), 225, 227, 316.0, 243.0),
    Camera("fisheye 180 deg", "equidistant", (0.0, 0.0, 0.0, 0.0), 200, 200),
    Camera("fisheye 200 deg, circular", "equidistant", (0.01, -0.004, 0.0, 0.0), 132, 132),
    Camera("fisheye 220 deg, circular", "equidistant", (0.0, 0.0, 0.0, 0.0), 122, 122),
    Camera("fisheye that folds at 81 deg", "equidistant", (-0.10, -0.02, 0.0, 0.0), 210, 210),
    Camera("fisheye, off-centre", "equidistant", (0.03, -0.012, 0.002, 0.0), 180, 186, 280.5, 265.5),
)
