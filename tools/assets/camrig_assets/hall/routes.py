"""Checks that nobody walks through furniture or through somebody else."""

import numpy as np

CLEARANCE = 0.30  # a person's half width
APART = 0.55  # least distance between the middles of two people
SECONDS = 1800


def _line(points):
    points = np.array([p[:3] if len(p) > 2 else (*p, 0.0) for p in points], dtype=float)
    points = np.vstack([points, points[:1]])
    return points, np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def length(points):
    return float(_line(points)[1][-1])


def at(points, metres):
    """Places along a closed route."""
    line, way = _line(points)
    metres = np.mod(metres, way[-1])
    return np.stack([np.interp(metres, way, line[:, k]) for k in range(3)], axis=-1)


def check():
    """Raises ValueError when a route touches an obstacle or two people meet within half an hour."""
    from .plan import OBSTACLES, ROUTES, STANDERS, WALKERS

    for name, points in ROUTES.items():
        places = at(points, np.arange(0, length(points), 0.05))
        if places[:, 2].max() > 1:
            continue
        for obstacle, (x0, y0, x1, y1) in OBSTACLES.items():
            away = np.hypot(
                np.maximum(0, np.maximum(x0 - places[:, 0], places[:, 0] - x1)),
                np.maximum(0, np.maximum(y0 - places[:, 1], places[:, 1] - y1)),
            )
            if away.min() < CLEARANCE:
                raise ValueError(f"route {name} passes {obstacle} at {away.min():.2f} m")
    times = np.arange(0, SECONDS, 0.1)
    tracks = {
        name: at(ROUTES[route], share * length(ROUTES[route]) + speed * times)
        for name, _, route, share, speed in WALKERS
    }
    tracks |= {name: np.tile(np.array(position, dtype=float), (len(times), 1)) for name, _, position, _, _ in STANDERS}
    names = sorted(tracks)
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            gap = np.linalg.norm(tracks[first] - tracks[second], axis=1).min()
            if gap < APART:
                raise ValueError(f"{first} and {second} come as near as {gap:.2f} m")
