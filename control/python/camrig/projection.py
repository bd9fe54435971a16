"""Where a camera sees a point of the world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np

#: Body frame (x forward, y left, z up) -> optical frame (z forward, x right, y down).
OPTICAL_FROM_BODY = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
#: As the rig has them (core/camera/lens_map.h): of the plane of (x / z, y / z), and how near a pole the picture may come.
_MAX_PLANE_RADIUS = 1e6
_POLE_MARGIN = 1e-4


def rotation(quaternion: Sequence[float]) -> np.ndarray:
    """The matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


@dataclass(frozen=True)
class Projection:
    """A camera's calibration and place at one moment, in OpenCV's terms.

    ``K`` is the 3x3 camera matrix in pixels, pixel centres at integers; ``distortion`` holds the coefficients of ``model``
    in the order of OpenCV and ROS (five zeros for a pinhole); ``world_from_camera`` is 4x4, metres, from the *optical* frame (z forward,
    x right, y down), so that ``np.linalg.inv`` of it gives what cv2.projectPoints calls rvec and tvec.
    """

    model: str
    K: np.ndarray
    distortion: np.ndarray
    world_from_camera: np.ndarray

    @classmethod
    def of(cls, reply: Mapping[str, Any]) -> Projection:
        """Of what camera.get or truth.get answers."""
        k, lens, pose = reply.get("shown_intrinsics", reply["intrinsics"]), reply["lens"], reply.get("world_pose", reply["pose"])
        world_from_camera = np.eye(4)
        world_from_camera[:3, :3] = rotation(pose["orientation"]) @ OPTICAL_FROM_BODY.T
        world_from_camera[:3, 3] = pose["position"]
        return cls(
            model=lens["model"],
            K=np.array([[k["fx"], 0.0, k["cx"]], [0.0, k["fy"], k["cy"]], [0.0, 0.0, 1.0]]),
            distortion=np.array(lens.get("coefficients") or [0.0] * 5, dtype=np.float64),
            world_from_camera=world_from_camera,
        )

    def project(self, points: Any) -> np.ndarray:
        """Pixels (N x 2, also outside of the picture) of points of the world (N x 3, metres).

        NaN where the camera has no pixel for a point: behind it, beyond the angle at which its lens folds, or at its own place.
        """
        world = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        seen = (world - self.world_from_camera[:3, 3]) @ self.world_from_camera[:3, :3]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ideal = self._ideal(seen)
            ideal[~(np.hypot(ideal[:, 0], ideal[:, 1]) < self._valid_radius())] = np.nan
            distorted = self._distorted(ideal)
        return distorted @ self.K[:2, :2].T + self.K[:2, 2]

    def _ideal(self, seen: np.ndarray) -> np.ndarray:
        """Points of the optical frame in the lens's undistorted plane; NaN for those it does not know."""
        x, y, z = seen.T
        if self.model == "equidistant":
            r = np.hypot(x, y)
            ideal = seen[:, :2] * np.where(r > 0, np.arctan2(r, z) / np.where(r > 0, r, 1.0), 0.0)[:, None]
            ideal[(r == 0) & ~(z > 0)] = np.nan
            return ideal
        return np.where(z > 0, seen[:, :2].T / z, np.nan).T

    def _distorted(self, ideal: np.ndarray) -> np.ndarray:
        numerator, denominator, p1, p2 = self._terms()
        x, y = ideal.T
        s = x * x + y * y
        scale = np.polynomial.polynomial.polyval(s, numerator) / np.polynomial.polynomial.polyval(s, denominator)
        return np.stack([x * scale + 2 * p1 * x * y + p2 * (s + 2 * x * x), y * scale + p1 * (s + 2 * y * y) + 2 * p2 * x * y], axis=1)

    def _terms(self) -> tuple[list[float], list[float], float, float]:
        """Radial numerator and denominator as polynomials of the squared radius, and the two tangential coefficients."""
        k = [*self.distortion, *[0.0] * 8][:8]
        if self.model == "equidistant":
            return [1.0, *k[:4]], [1.0], 0.0, 0.0
        return [1.0, k[0], k[1], k[4]], [1.0, k[5], k[6], k[7]], k[2], k[3]

    def _valid_radius(self) -> float:
        """Up to where the lens is one-to-one, in its undistorted plane: where the radial part stops rising or has a pole; with tangential
        terms where their largest share, 6 p r, outweighs it (see core/camera/lens_map.h)."""
        if self.model == "pinhole":
            return math.inf
        numerator, denominator, p1, p2 = self._terms()
        polynomial = np.polynomial.Polynomial
        square = polynomial([0.0, 0.0, 1.0])
        radius = polynomial([0.0, 1.0])
        n, d = polynomial(numerator)(square), polynomial(denominator)(square)
        loss = 6 * math.hypot(p1, p2) * radius
        # In r: d(r n / d) / dr = slope / d^2 along the radius, n / d across it.
        slope = n * d + radius * (n.deriv() * d - n * d.deriv())
        limit = math.pi if self.model == "equidistant" else _MAX_PLANE_RADIUS
        ends = [limit, _first_root(slope - loss * d * d), _first_root(n - loss * d), _first_root(d) * (1 - _POLE_MARGIN)]
        return min(ends)


def _first_root(polynomial: np.polynomial.Polynomial) -> float:
    """The smallest positive root at which the sign changes; infinity when there is none."""
    roots = polynomial.trim().roots()
    real = np.sort(roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0)])
    for root in real:
        if polynomial(root * (1 - 1e-6)) * polynomial(root * (1 + 1e-6)) < 0:
            return float(root)
    return math.inf
