"""Smooth value noise in three dimensions; the same everywhere for the same seed."""

import numpy as np


def _lattice(ix, iy, iz, seed):
    """A fixed pseudo-random number in [0,1) for every lattice point (integer hash, 32-bit wrap-around)."""
    with np.errstate(over="ignore"):  # wrapping around is what the hash wants
        return _hash(ix, iy, iz, seed)


def _hash(ix, iy, iz, seed):
    h = (
        ix.astype(np.uint32) * np.uint32(374761393)
        + iy.astype(np.uint32) * np.uint32(668265263)
        + iz.astype(np.uint32) * np.uint32(2147483647)
        + np.uint32(seed) * np.uint32(974634151)
    )
    h = (h ^ (h >> np.uint32(13))) * np.uint32(1274126177)
    h = (h ^ (h >> np.uint32(16))) * np.uint32(2246822519)
    return ((h ^ (h >> np.uint32(15))) >> np.uint32(8)).astype(np.float64) / 2**24


def value(points, seed=0):
    """Noise in [0,1] with features of size one at points of shape (..., 3)."""
    points = np.asarray(points, dtype=np.float64)
    cell = np.floor(points).astype(np.int64)
    f = points - cell
    f = f * f * (3 - 2 * f)
    total = 0.0
    for dx in (0, 1):
        for dy in (0, 1):
            for dz in (0, 1):
                weight = (
                    (f[..., 0] if dx else 1 - f[..., 0])
                    * (f[..., 1] if dy else 1 - f[..., 1])
                    * (f[..., 2] if dz else 1 - f[..., 2])
                )
                total = total + weight * _lattice(cell[..., 0] + dx, cell[..., 1] + dy, cell[..., 2] + dz, seed)
    return total


def fractal(points, octaves=3, seed=0):
    """Sum of octaves, mean about 0.5."""
    total, weight = 0.0, 0.0
    for octave in range(octaves):
        total = total + value(np.asarray(points) * 2**octave, seed + octave) / 2**octave
        weight += 1 / 2**octave
    return total / weight


def smoothstep(low, high, x):
    t = np.clip((np.asarray(x, dtype=np.float64) - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    """Linear blend of colours a and b (..., 3) by t (...)."""
    return np.asarray(a) * (1 - np.asarray(t)[..., None]) + np.asarray(b) * np.asarray(t)[..., None]
