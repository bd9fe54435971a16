"""How far a picture is from the reference: PSNR, SSIM, FLIP."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import export


@dataclass(frozen=True)
class Score:
    psnr_db: float
    ssim: float
    flip: float
    #: Without what shines brighter than white and the pixels beside it: the reference mixes its light in a pixel before it is cut, we after.
    psnr_without_lamps_db: float


def beside_lamps(light: np.ndarray) -> np.ndarray:
    """HxW: the pixels, and those beside them, where the reference's exposed light is over white."""
    is_over = np.pad(light.max(axis=2) > 1.0, 1)
    height, width = light.shape[:2]
    return np.any([is_over[dy:dy + height, dx:dx + width] for dy in range(3) for dx in range(3)], axis=0)


def mean_square(picture: np.ndarray, halves: tuple[np.ndarray, np.ndarray]) -> float:
    """Of the error in codes, without the reference's noise: the halves' noise is independent, so it is zero in the mean of the product."""
    return float(np.mean((picture - halves[0]) * (picture - halves[1])))


def decibels(square: float) -> float:
    """PSNR of a mean square error in codes of 255."""
    return float(10 * np.log10(255**2 / max(square, 1e-9)))


def noise(halves: tuple[np.ndarray, np.ndarray]) -> float:
    """Standard deviation of the halves' mean, in codes."""
    return float(np.sqrt(np.mean((halves[0] - halves[1]) ** 2)) / 2)


def score(picture: np.ndarray, halves: tuple[np.ndarray, np.ndarray], clean: tuple[np.ndarray, np.ndarray], is_lamp: np.ndarray) -> Score:
    """`picture`, halves of the reference, and `clean`, the same denoised, whose mean SSIM and FLIP are against: HxWx3 codes 0 to 255;
    is_lamp: beside_lamps()."""
    import flip_evaluator
    from skimage.metrics import structural_similarity

    mean = (clean[0] + clean[1]) / 2
    flip = flip_evaluator.evaluate((mean / 255).astype(np.float32), (picture / 255).astype(np.float32), "LDR")[1]
    ssim = structural_similarity(mean, picture, channel_axis=2, data_range=255, gaussian_weights=True, sigma=1.5, use_sample_covariance=False)
    others = decibels(mean_square(picture[~is_lamp], (halves[0][~is_lamp], halves[1][~is_lamp])))
    return Score(decibels(mean_square(picture, halves)), float(ssim), float(flip), others)


def best_factor(picture: np.ndarray, reference: np.ndarray, *, is_toned: bool = False) -> float:
    """By which the reference's light is brought to the picture's level: the median of the ratios of what neither clips."""
    ours, light = export.light_of(picture, is_toned=is_toned).mean(axis=2), reference.mean(axis=2)
    is_told = (picture.max(axis=2) < 250) & (light > 0.01)
    return float(np.median(ours[is_told] / light[is_told]))
