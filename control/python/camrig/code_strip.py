"""Reads the code strip: which camera, which frame, which instant a picture shows.

Layout and method are those of docs/decisions/0010-code-strip.md and core/frame/code_strip.cpp.
"""

from __future__ import annotations

import binascii
from dataclasses import dataclass

import numpy as np

_COLUMNS, _ROWS = 32, 4
_SYNC = np.array([[1, 0, 1, 1, 0, 0, 1, 0]], dtype=bool)
_MIN_CONTRAST = 32.0
_STEP = 1 + 1 / 160


@dataclass(frozen=True)
class Code:
    """camera: low 8 bits of the camera's number; sequence: low 32 bits of the frame's; time_ns: world time it shows."""

    camera: int
    sequence: int
    time_ns: int


def read_code(image: np.ndarray) -> Code | None:
    """The code of a picture (HxW, HxWx3 or HxWx4, uint8), also after JPEG, video coding and scaling.

    None when there is none or it cannot be read with certainty (its checksum is wrong); a wrong code is not returned.
    """
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.ndim not in (2, 3):
        raise TypeError(f"read_code: takes a uint8 array HxW or HxWxC, not {image.dtype} {image.shape}")
    luma = image if image.ndim == 2 else image[:, :, min(1, image.shape[2] - 1)]  # green stands for luma
    height, width = luma.shape
    if width < 64 or height < 8:
        return None
    own_cell = min(max(4, width // 80), height // _ROWS)
    largest = min(width / _COLUMNS, height / _ROWS) * _STEP
    reader = _Reader(luma, largest)
    if width >= 128 and height >= 32:
        code = reader.read(own_cell)
        if code is not None:
            return code
    # A scaled picture: every cell side it could have, from the nominal one outwards.
    nominal, smallest = width / 80, max(1.5, width / 400)
    cell = nominal
    while cell >= smallest:
        if (code := reader.read(cell)) is not None:
            return code
        cell /= _STEP
    cell = nominal * _STEP
    while cell <= largest:
        if (code := reader.read(cell)) is not None:
            return code
        cell *= _STEP
    return None


class _Reader:
    def __init__(self, luma: np.ndarray, largest_cell: float) -> None:
        self._height, self._width = luma.shape
        part = luma[: min(self._height, int(_ROWS * largest_cell) + 2)]
        # sums[y, x]: of all pixels above and left, so that the mean of any box takes four look-ups.
        self._sums = np.zeros((part.shape[0] + 1, part.shape[1] + 1), dtype=np.int64)
        np.cumsum(np.cumsum(part, axis=0, dtype=np.int64), axis=1, out=self._sums[1:, 1:])

    def _means(self, cell: float, rows: int, columns: int) -> np.ndarray:
        """Means of the inner half of each cell."""

        def edges(count: int, limit: int) -> tuple[np.ndarray, np.ndarray]:
            start = np.arange(count) * cell
            first = np.clip(np.floor(start + cell / 4 + 0.5).astype(int), 0, limit - 1)
            end = np.clip(np.floor(start + cell * 3 / 4 + 0.5).astype(int), first + 1, limit)
            return first, end

        left, right = edges(columns, self._width)
        top, bottom = edges(rows, self._sums.shape[0] - 1)
        sums = (
            self._sums[np.ix_(bottom, right)]
            - self._sums[np.ix_(top, right)]
            - self._sums[np.ix_(bottom, left)]
            + self._sums[np.ix_(top, left)]
        )
        return sums / np.outer(bottom - top, right - left)

    def read(self, cell: float) -> Code | None:
        sync = self._means(cell, 1, 8)
        ones, zeros = sync[_SYNC], sync[~_SYNC]
        threshold = (ones.mean() + zeros.mean()) / 2
        if ones.mean() - zeros.mean() < _MIN_CONTRAST or ones.min() <= threshold or zeros.max() >= threshold:
            return None
        bits = self._means(cell, _ROWS, _COLUMNS) > threshold
        data = np.packbits(bits.ravel()).tobytes()
        # crc_hqx is CRC-CCITT with polynomial 0x1021; from 0xffff on it is CRC-16/CCITT-FALSE.
        if binascii.crc_hqx(data[:14], 0xFFFF) != int.from_bytes(data[14:], "big"):
            return None
        return Code(
            camera=data[1],
            sequence=int.from_bytes(data[2:6], "big"),
            time_ns=int.from_bytes(data[6:14], "big", signed=True),
        )
