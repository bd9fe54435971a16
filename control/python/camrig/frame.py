"""Pictures as arrays."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from .errors import CamrigError


@dataclass(frozen=True)
class Frame:
    """One picture and the instant it shows.

    ``image`` is HxWx3 uint8 BGR for color, HxW float32 metres for depth (inf where nothing is), HxW uint32 for instance
    and semantic (0 where nothing is), HxWx3 float32 for normal, HxWx2 float32 for flow (as Camera.flow), HxW uint8 for soiling (as Camera.soiling), HxW uint16 (of filter rgb HxWx3, BGR) for sensor. Cameras due at one instant have the same ``time_ns``.
    ``stamp_ns`` and ``steady_ns`` are that instant as the camera's own clock says it, beside ``time_ns`` and
    ``monotonic_ns``: the same unless it has a ``clock``.
    """

    image: np.ndarray
    time_ns: int
    monotonic_ns: int
    sequence: int
    camera: str
    kind: str = "color"
    stamp_ns: int = 0
    steady_ns: int = 0
    #: Of a camera with a sensor: how it took the picture, ``exposure_s``, ``gain_db``, ``black_level`` and so on.
    sensor: dict[str, Any] | None = None


#: dtype and numbers per pixel of the raw pixel formats.
_LAYOUTS: dict[str, tuple[np.dtype[Any], int]] = {
    "rgba8": (np.dtype("u1"), 4),
    "rgb24": (np.dtype("u1"), 3),
    "bgr24": (np.dtype("u1"), 3),
    "gray8": (np.dtype("u1"), 1),
    "depth32f": (np.dtype("<f4"), 1),
    "id32": (np.dtype("<u4"), 1),
    "normal32f": (np.dtype("<f4"), 3),
    "flow32f": (np.dtype("<f4"), 2),
    "gray16": (np.dtype("<u2"), 1),
    "bayer_rggb16": (np.dtype("<u2"), 1),
    "bayer_grbg16": (np.dtype("<u2"), 1),
    "bayer_gbrg16": (np.dtype("<u2"), 1),
    "bayer_bggr16": (np.dtype("<u2"), 1),
    "rgb16_planes": (np.dtype("<u2"), 3),
}
_FORMAT_OF_KIND = {"color": "rgba8", "depth": "depth32f", "instance": "id32", "semantic": "id32", "normal": "normal32f", "flow": "flow32f", "soiling": "gray8"}


def data_of(reply: Mapping[str, Any]) -> bytes | bytearray:
    """The bytes in the ``data`` of a frame.get reply."""
    try:
        data = reply["data"]
        return data if isinstance(data, bytearray) else base64.b64decode(data, validate=True)
    except (KeyError, TypeError, binascii.Error) as problem:
        raise CamrigError("internal", f"frame.get: the answer has no sound base64 data: {problem!r}") from None


def _decoded(data: bytes | bytearray, kind: str) -> np.ndarray:
    """A picture from a file, in the units of Frame: a PNG has depth in whole millimetres, to 65.535 m, and 0 for what is farther."""
    image = decode_image(data)
    if kind == "depth":
        return np.where(image == 0, np.inf, image / 1000).astype(np.float32)
    return image.astype(np.uint32) if kind in ("instance", "semantic") else image


def frame_of(reply: Mapping[str, Any], camera: str, kind: str) -> Frame:
    """The frame of a frame.get reply of any format."""
    data = data_of(reply)
    try:
        encoding = str(reply.get("format", "raw"))
        if encoding == "raw":
            width, height = (int(v) for v in reply["size"])
            image = _raw(data, str(reply.get("pixels") or _FORMAT_OF_KIND[kind]), width, height)
        else:
            image = _decoded(data, kind)
        time_ns, monotonic_ns = int(reply["time_ns"]), int(reply["monotonic_ns"])
        return Frame(
            image=image,
            time_ns=time_ns,
            monotonic_ns=monotonic_ns,
            sequence=int(reply["sequence"]),
            camera=str(reply.get("camera", camera)),
            kind=kind,
            stamp_ns=int(reply.get("stamp_ns", time_ns)),
            steady_ns=int(reply.get("steady_ns", monotonic_ns)),
            sensor=reply.get("sensor"),
        )
    except (KeyError, TypeError, ValueError) as problem:
        raise CamrigError("internal", f"frame.get: the answer is not as expected: {problem!r}") from None


def frame_params(camera: str, kind: str, encoding: str) -> dict[str, Any]:
    """Those of frame.get for a picture that frame_of() takes."""
    params = {"camera": camera, "kind": kind, "format": encoding}
    return {**params, "pixels": "bgr24"} if kind == "color" and encoding == "raw" else params


def _raw(data: bytes | bytearray, pixel_format: str, width: int, height: int) -> np.ndarray:
    dtype, channels = _LAYOUTS[pixel_format]
    pixels = np.frombuffer(data, dtype=dtype)
    if pixels.size != width * height * channels:
        raise ValueError(f"{len(data)} bytes are no {pixel_format} picture of {width}x{height}")
    if pixel_format == "rgb16_planes":
        return np.ascontiguousarray(pixels.reshape(channels, height, width).transpose(1, 2, 0)[:, :, ::-1])
    pixels = pixels.reshape((height, width) if channels == 1 else (height, width, channels))
    if pixel_format in ("rgba8", "rgb24"):
        return np.ascontiguousarray(pixels[:, :, 2::-1])
    return pixels if pixels.flags.writeable else pixels.copy()


def decode_image(data: bytes | bytearray) -> np.ndarray:
    """A JPEG or PNG as an array: HxWx3 BGR, or HxW. Needs OpenCV or Pillow."""
    try:
        import cv2
    except ImportError:
        pass
    else:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise CamrigError("internal", f"{len(data)} bytes are no picture that OpenCV can decode")
        return image
    try:
        import io

        from PIL import Image
    except ImportError:
        raise CamrigError("unsupported", "decoding JPEG or PNG needs opencv-python or pillow; raw frames need neither") from None
    with Image.open(io.BytesIO(data)) as picture:
        pixels = np.asarray(picture)
    return np.ascontiguousarray(pixels[:, :, 2::-1]) if pixels.ndim == 3 else pixels.copy()
