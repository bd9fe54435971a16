"""From pictures of quality `beautiful` back to light: in scenes with daylight lit surfaces are shown there by a tone curve (docs/quality.md).

    light = camrig.tone.light_of(cam.frame().image)      # HxWx3, linear, as the surfaces sent it times the exposure
"""

from __future__ import annotations

from typing import Any

import numpy as np

_MIRRORED = 0.04
_START = 0.8 - _MIRRORED
_REST = 1.0 - _START
_FADING = 0.15


def pbr_neutral(light: Any) -> np.ndarray:
    """Linear light (..., 3), from 0 up, to what a picture shows of it, linear from 0 to 1: PBR Neutral, Khronos Group, 2024."""
    light = np.asarray(light, float)
    least = light.min(axis=-1, keepdims=True)
    color = light - np.where(least < 2 * _MIRRORED, least - least * least / (4 * _MIRRORED), _MIRRORED)
    peak = color.max(axis=-1, keepdims=True)
    over = np.maximum(peak, _START)
    compressed = 1 - _REST**2 / (over + _REST - _START)
    share = 1 / (_FADING * (peak - compressed) + 1)
    return np.where(peak < _START, color, compressed + (color * (compressed / over) - compressed) * share)


def inverse_pbr_neutral(shown: Any) -> np.ndarray:
    """The inverse: what is shown as 1 may have been anything brighter, and is given as the light of 0.998 (`shown` is clipped there)."""
    shown = np.clip(np.asarray(shown, float), 0.0, 0.998)
    peak = shown.max(axis=-1, keepdims=True)
    top = np.maximum(peak, _START)
    light_peak = _REST**2 / (1 - top) - _REST + _START
    share = 1 / (_FADING * (light_peak - top) + 1)
    color = np.where(peak < _START, shown, (top + (shown - top) / share) * (light_peak / top))
    least = color.min(axis=-1, keepdims=True)
    taken = np.where(least < _MIRRORED, np.sqrt(np.maximum(least, 0.0) * 4 * _MIRRORED) - least, _MIRRORED)
    return color + taken


def light_of(codes: Any) -> np.ndarray:
    """Of a picture's codes (..., 3), 0 to 255: the sRGB curve and the tone curve taken back."""
    value = np.asarray(codes, float) / 255
    return inverse_pbr_neutral(np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4))
