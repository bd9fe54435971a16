"""Encodes pictures for embedding in GLB files."""

import io

import numpy as np
from PIL import Image


def jpeg(image, quality=88):
    out = io.BytesIO()
    image.save(out, "JPEG", quality=quality, subsampling=0)
    return out.getvalue()


def png(values):
    """Grey values 0..1 as an 8-bit PNG."""
    out = io.BytesIO()
    Image.fromarray((np.clip(values, 0, 1) * 255 + 0.5).astype(np.uint8), "L").save(out, "PNG", optimize=True)
    return out.getvalue()
