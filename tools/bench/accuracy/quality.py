"""How alike two pictures are: PSNR and SSIM on 8-bit pictures."""

import cv2
import numpy as np


def psnr(a, b):
    """dB over all three channels."""
    error = np.mean((a.astype(np.float64) - b) ** 2)
    return float("inf") if error == 0 else float(10 * np.log10(255**2 / error))


def ssim(a, b):
    """Mean SSIM of luma with the 11 x 11 Gaussian window (sigma 1.5) of Wang et al. 2004."""
    x, y = (cv2.cvtColor(i, cv2.COLOR_BGR2GRAY).astype(np.float64) for i in (a, b))

    def blur(i):
        return cv2.GaussianBlur(i, (11, 11), 1.5)

    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    mx, my = blur(x), blur(y)
    vx, vy, vxy = blur(x * x) - mx * mx, blur(y * y) - my * my, blur(x * y) - mx * my
    return float((((2 * mx * my + c1) * (2 * vxy + c2)) / ((mx**2 + my**2 + c1) * (vx + vy + c2))).mean())
