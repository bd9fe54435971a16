"""A walker on the floor: constant velocity, driven by white acceleration (Bar-Shalom, Li, Kirubarajan 2001, section 6.2). Metres and seconds."""

from __future__ import annotations

import numpy as np

ACCELERATION = 1.5  # m/s2, standard deviation: people turn and stop
SPEED = 1.2  # m/s, standard deviation of a velocity nobody has measured
H = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0]])  # x, y of (x, y, vx, vy)


def motion(dt_s: float) -> tuple[np.ndarray, np.ndarray]:
    """F and Q over `dt_s`."""
    f = np.eye(4)
    f[0, 2] = f[1, 3] = dt_s
    g = np.array([[dt_s**2 / 2, 0], [0, dt_s**2 / 2], [dt_s, 0], [0, dt_s]])
    return f, g @ g.T * ACCELERATION**2


class Kalman:
    """State x (4) and covariance P (4 x 4)."""

    def __init__(self, position: np.ndarray, covariance: np.ndarray) -> None:
        self.x = np.array([*position, 0.0, 0.0])
        self.P = np.diag([0.0, 0.0, SPEED**2, SPEED**2])
        self.P[:2, :2] = covariance

    def predict(self, dt_s: float) -> None:
        f, q = motion(dt_s)
        self.x, self.P = f @ self.x, f @ self.P @ f.T + q

    def distance2(self, position: np.ndarray, covariance: np.ndarray) -> float:
        """Squared Mahalanobis distance of a measurement."""
        off = position - self.x[:2]
        return float(off @ np.linalg.solve(self.P[:2, :2] + covariance, off))

    def update(self, position: np.ndarray, covariance: np.ndarray) -> None:
        gain = self.P[:, :2] @ np.linalg.inv(self.P[:2, :2] + covariance)
        self.x = self.x + gain @ (position - self.x[:2])
        rest = np.eye(4) - gain @ H
        self.P = rest @ self.P @ rest.T + gain @ covariance @ gain.T  # Joseph's form stays symmetric
