"""Sun and sky of `environment.daylight` for the path tracer: core/daylight/sky.h in numpy, checked against camrig's own pictures in each run (__main__.py).

Lux over the scene's `lux` is what camrig draws: 1 is white.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

#: Where white is white in a scene with daylight that says nothing of it.
DAYLIGHT_LUX = 100e3
_SOLAR_LUX, _NIGHT_LUX, _LEAST_SKY, _SUN_RADIUS_DEG = 133.8e3, 2e-3, 0.05, 0.267
_ROWS, _COLUMNS = 24, 48
_CLEAR = (
    (20.0, (3.74, 3.97, -4.07, 1.47)), (5.0, (3.05, 13.28, -45.98, 64.33)), (-0.8, (2.88, 22.26, -207.64, 1034.30)),
    (-5.0, (2.88, 21.81, -258.11, -858.36)), (-12.0, (2.70, 12.17, -431.69, -1899.83)), (-18.0, (13.84, 262.72, 1447.42, 2797.93)),
)
_X_ZENITH = ((0.00166, -0.00375, 0.00209, 0.0), (-0.02903, 0.06377, -0.03202, 0.00394), (0.11693, -0.21196, 0.06052, 0.25886))
_Y_ZENITH = ((0.00275, -0.00610, 0.00317, 0.0), (-0.04214, 0.08970, -0.04153, 0.00516), (0.15346, -0.26756, 0.06670, 0.26688))
_RGB_OF_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Daylight:
    """`to_sun`: unit, z up. Light in multiples of the scene's white: `sun` on a surface that faces it, `sky` on level ground, `ground` what that sends up."""

    to_sun: np.ndarray
    sun: np.ndarray
    sky: np.ndarray
    ground: np.ndarray
    _sky: _Sky
    _lux: float

    def radiance(self, towards: np.ndarray) -> np.ndarray:
        """Of the sky in these directions (...x3, not below the horizon), as an environment that would give level ground so much."""
        return self._sky.towards(towards) / self._lux

    def background(self) -> np.ndarray:
        """What cameras see where nothing is: the mean of the sky near the horizon."""
        i = np.arange(48)
        pan, up = 2 * math.pi * i / 48, 0.25 * (i % 4 + 0.5) / 4
        return self.radiance(np.stack([np.cos(up) * np.cos(pan), np.cos(up) * np.sin(pan), np.sin(up)], axis=-1)).mean(axis=0)


def read(environment: dict[str, Any]) -> Daylight:
    """Of a scene's `environment`; ValueError for a `time`, which only camrig reads."""
    told = environment["daylight"]
    if "time" in told:
        raise ValueError("environment.daylight: the export takes azimuth_deg and elevation_deg, no time")
    angle = math.radians(told.get("north_deg", 90.0) - told["azimuth_deg"])
    up = math.radians(told["elevation_deg"])
    to_sun = np.array([math.cos(up) * math.cos(angle), math.cos(up) * math.sin(angle), math.sin(up)])
    lux = environment.get("lux") or DAYLIGHT_LUX
    sky = _Sky(to_sun, told.get("turbidity", 3.0), told.get("overcast", 0.0))
    ground = np.asarray(told.get("ground", (0.25, 0.25, 0.25))) * (sky.level + sky.sun * max(to_sun[2], 0.0))
    return Daylight(to_sun, sky.sun / lux, sky.level / lux, ground / lux, sky, lux)


class _Sky:
    """`sun`, `level`: lux of the sun on what faces it, and of the sky on level ground."""

    def __init__(self, to_sun: np.ndarray, turbidity: float, overcast: float) -> None:
        t = turbidity
        self.to_sun = to_sun
        self._perez = np.array([
            (0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703),
            (-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452),
            (-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529),
        ])
        elevation = math.degrees(math.asin(to_sun[2]))
        zenith = min(math.radians(90 - elevation), math.radians(89))
        self._zenith = np.array([1.0, _chromaticity(_X_ZENITH, t, zenith), _chromaticity(_Y_ZENITH, t, zenith)])
        self._zenith /= [self._distribution(i, 1.0, math.cos(zenith), zenith) for i in range(3)]
        every, m, height = _clear_lux(elevation), _air_mass(max(elevation, 0.0)), max(to_sun[2], 0.0)
        risen = min(max(0.5 + 0.5 * elevation / _SUN_RADIUS_DEG, 0.0), 1.0)
        sun = risen * _SOLAR_LUX * math.exp(-0.8662 * t * m * _rayleigh_depth(m))
        if sun * height > (1 - _LEAST_SKY) * every:
            sun = (1 - _LEAST_SKY) * every / height
        self.sun = (1 - overcast) * sun * _sun_color(m, t)
        up = np.sqrt((np.arange(_ROWS) + 0.5) / _ROWS)[:, None]
        pan = 2 * math.pi * (np.arange(_COLUMNS) + 0.5) / _COLUMNS
        level = np.sqrt(1 - up * up)
        towards = np.stack([level * np.cos(pan), level * np.sin(pan), np.broadcast_to(up, (_ROWS, _COLUMNS))], axis=-1)
        mean = np.maximum(_RGB_OF_XYZ @ self._clear_xyz(towards).mean(axis=(0, 1)), 0)
        self._clear = (1 - overcast) * (every - sun * height) / float(_LUMINANCE @ mean)
        share = (300.0 + 21000.0 * height) / (every if elevation > 0 else _clear_lux(0.0))
        self._overcast = overcast * every * min(share, 1.0)
        self.level = self._clear * mean + self._overcast

    def towards(self, towards: np.ndarray) -> np.ndarray:
        clear = np.maximum(self._clear_xyz(towards) @ _RGB_OF_XYZ.T, 0)
        return self._clear * clear + (self._overcast * (9 / 7) * (1 + 2 * np.maximum(towards[..., 2], 0)) / 3)[..., None]

    def _distribution(self, i: int, cos_zenith: Any, cos_sun: Any, angle: Any) -> Any:
        c = self._perez[i]
        return (1 + c[0] * np.exp(c[1] / np.maximum(cos_zenith, 0.01))) * (1 + c[2] * np.exp(c[3] * angle) + c[4] * cos_sun * cos_sun)

    def _clear_xyz(self, towards: np.ndarray) -> np.ndarray:
        cos_sun = np.clip(towards @ self.to_sun, -1, 1)
        luminance, x, y = (self._zenith[i] * self._distribution(i, np.maximum(towards[..., 2], 0), cos_sun, np.arccos(cos_sun)) for i in range(3))
        luminance = np.maximum(luminance, 0)
        return np.stack([luminance * x / y, luminance, luminance * (1 - x - y) / y], axis=-1)


def _clear_lux(elevation_deg: float) -> float:
    for low, c in _CLEAR:
        if elevation_deg >= low:
            x = elevation_deg / 90
            return _NIGHT_LUX + 10 ** (c[0] + x * (c[1] + x * (c[2] + x * c[3])))
    return _NIGHT_LUX


def _air_mass(elevation_deg: float) -> float:
    return 1 / (math.sin(math.radians(elevation_deg)) + 0.50572 * (elevation_deg + 6.07995) ** -1.6364)


def _rayleigh_depth(m: float) -> float:
    if m > 20:
        return 1 / (10.4 + 0.718 * m)
    return 1 / (6.6296 + m * (1.7513 + m * (-0.1202 + m * (0.0065 - 0.00013 * m))))


def _sun_color(m: float, turbidity: float) -> np.ndarray:
    wave_um, haze = np.array([0.610, 0.550, 0.465]), max(0.0, turbidity - 2.3) / 16.4
    color = np.exp(-m * (0.008735 * wave_um**-4.08 + haze * wave_um**-1.3)) / (_black_body(6500.0) / _black_body(5800.0))
    return color / float(_LUMINANCE @ color)


def _black_body(kelvin: float) -> np.ndarray:
    """Linear sRGB over its green; above 4000 K."""
    t = 1000 / kelvin
    x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    rgb = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]) @ [x / y, 1, (1 - x - y) / y]
    return rgb / rgb[1]


def _chromaticity(m: Any, turbidity: float, zenith: float) -> float:
    total = 0.0
    for a, b, c, d in m:
        total = total * turbidity + ((a * zenith + b) * zenith + c) * zenith + d
    return total
