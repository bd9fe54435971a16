"""Where a mark is in a picture, and how wrong that estimate is by itself.

A disc is found by the centroid of its linear light. For exact area coverage that is the truth; with one sample a pixel it
has the noise of a Gauss circle problem. `dithered` therefore draws the same camera several times with its principal point
moved by fractions of a pixel, and takes the mean: what is left is the camera's own error, and n x n shifts measure like
n x n supersampling. `bias` measures the estimator on pictures made by a formula.
"""

import numpy as np

MARGIN_PX = 4


def _to_linear():
    code = np.arange(256) / 255.0
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


LINEAR = _to_linear()


def linear_light(image):
    """HxW linear light of an 8-bit picture (its green: the marks are grey)."""
    return LINEAR[image[:, :, 1]]


def centroids(light, outlines):
    """The centroid of the light around each outline, (N, 2). Nothing else may be lit there."""
    height, width = light.shape
    found = np.empty((len(outlines), 2))
    for i, outline in enumerate(outlines):
        low = np.maximum(np.floor(outline.min(axis=0)).astype(int) - MARGIN_PX, 0)
        high = np.minimum(np.ceil(outline.max(axis=0)).astype(int) + MARGIN_PX + 1, (width, height))
        window = light[low[1] : high[1], low[0] : high[0]]
        total = window.sum()
        if total <= 0:
            found[i] = np.nan
            continue
        found[i] = (
            low[0] + (window.sum(axis=0) * np.arange(window.shape[1])).sum() / total,
            low[1] + (window.sum(axis=1) * np.arange(window.shape[0])).sum() / total,
        )
    return found


def shifts(n):
    """n x n shifts of the picture in pixels, centred on 0."""
    steps = (np.arange(n) + 0.5) / n - 0.5
    return [(x, y) for y in steps for x in steps]


def dithered(cam, camera, marks, n):
    """Residuals (N, 2) in px, measured minus truth, of a live camera over n x n shifts."""
    outlines = marks.outlines(camera)
    truth = marks.truth(camera)
    total = np.zeros_like(truth)
    for shift in shifts(n):
        cam.set(**camera.options(shift))
        light = linear_light(cam.frame().image)
        total += centroids(light, outlines + np.array(shift)) - shift
    return total / n**2 - truth


def bias(radius_px=9.0, samples=1, shifts_n=1, trials=200, eight_bit=True, seed=3):
    """Errors (trials, 2) of the estimator on discs sampled exactly: samples x samples points a pixel."""
    random = np.random.default_rng(seed)
    size = int(2 * radius_px + 2 * MARGIN_PX + 6)
    sub = (np.arange(size * samples) + 0.5) / samples - 0.5
    errors = np.empty((trials, 2))
    for t in range(trials):
        centre = size / 2 + random.uniform(-0.5, 0.5, 2)
        total = np.zeros(2)
        for shift in shifts(shifts_n):
            c = centre + shift
            inside = ((sub[None, :] - c[0]) ** 2 + (sub[:, None] - c[1]) ** 2) < radius_px**2
            light = inside.reshape(size, samples, size, samples).mean(axis=(1, 3))
            if eight_bit:
                light = LINEAR[np.round(255 * encode(light)).astype(np.uint8)]
            box = np.array([[c[0] - radius_px, c[1] - radius_px], [c[0] + radius_px, c[1] + radius_px]])
            total += centroids(light, box[None])[0] - shift
        errors[t] = total / shifts_n**2 - centre
    return errors


def encode(linear):
    """The sRGB curve, 0..1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(np.maximum(linear, 0), 1 / 2.4) - 0.055)


def summary(residuals):
    """(max, rms, mean vector) of the residuals' lengths in px."""
    length = np.hypot(*residuals.T)
    return float(length.max()), float(np.sqrt((length**2).mean())), residuals.mean(axis=0)
