"""What the machine itself gives, in the same run: the floors under our numbers."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np


def memcpy_gb_s(picture_bytes: int, pictures: int, seconds: float) -> float:
    """Copying so many pictures in rotation, as a renderer's are, on one core; bytes copied, not bytes moved."""
    source = np.ones((pictures, picture_bytes), np.uint8)
    target = np.empty_like(source)
    np.copyto(target, source)
    rounds, begin = 0, time.perf_counter()
    while (elapsed := time.perf_counter() - begin) < seconds:
        for n in range(pictures):
            np.copyto(target[n], source[n])
        rounds += 1
    return rounds * source.nbytes / elapsed / 1e9


def tjbench_ms(pictures: list[np.ndarray], quality: int) -> float | None:
    """Milliseconds a picture for libjpeg-turbo's own benchmark, RGBX to 4:2:0 JPEG on one core; None where it is not installed."""
    program = shutil.which("tjbench")
    if program is None:
        return None
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for i, picture in enumerate(pictures):
            file = Path(folder) / f"{i}.ppm"
            cv2.imwrite(str(file), picture)
            text = subprocess.run(
                [program, str(file), str(quality), "-rgbx", "-subsamp", "420", "-nowrite", "-benchtime", "1", "-warmup", "0.3", "-quiet"],
                capture_output=True, text=True, check=True,
            ).stdout
            # A quiet row: format, bit order, subsampling, quality, width, height, megapixels/s of compression, ...
            row = next(line for line in text.splitlines() if line.startswith("RGBX"))
            mpixels = float(row.split()[6])
            times.append(picture.shape[0] * picture.shape[1] / mpixels / 1e3)
    return sum(times) / len(times)
