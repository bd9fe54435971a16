"""When the frames of a camera fall due: frame n at floor(n * den * 1e9 / num) ns of world time."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

_NS = 10**9


def rate_of(fps: Any) -> Fraction:
    """25, 29.97 or "30000/1001" as the rig gives it."""
    return Fraction(fps if isinstance(fps, (int, str)) else repr(fps))


def due_ns(rate: Fraction, n: int) -> int:
    """World time of frame n."""
    return n * rate.denominator * _NS // rate.numerator


def next_due_ns(rate: Fraction, after_ns: int) -> int:
    """World time of the first frame after that time."""
    return due_ns(rate, _first_after(rate, after_ns))


def due_count(rate: Fraction, after_ns: int, until_ns: int, phase_ns: int = 0) -> int:
    """Frames due after the one time, up to and with the other; the camera's clock has them later by its phase."""
    return max(0, _first_after(rate, until_ns - phase_ns) - _first_after(rate, after_ns - phase_ns))


def _first_after(rate: Fraction, world_ns: int) -> int:
    n = max(0, world_ns * rate.numerator // (rate.denominator * _NS))
    while due_ns(rate, n) <= world_ns:
        n += 1
    return n
