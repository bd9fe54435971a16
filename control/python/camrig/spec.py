"""Camera options as Python likes them -> parameters of camera.create and camera.set."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, Iterable, Mapping, Sequence, Union

import numpy as np

from .errors import CamrigError

Rate = Union[int, float, str, Fraction]
Vector = Sequence[float]
Intrinsics = Union[Mapping[str, float], Sequence[Sequence[float]], np.ndarray]
Lens = Union[str, Mapping[str, Any], tuple[str, Sequence[float]]]
Output = Union[str, Mapping[str, Any]]


def camera_params(
    *,
    size: Sequence[int] | None = None,
    fps: Rate | None = None,
    vfov_deg: float | None = None,
    hfov_deg: float | None = None,
    intrinsics: Intrinsics | None = None,
    zoom: float | None = None,
    position: Vector | None = None,
    look_at: Vector | None = None,
    pan_deg: float | None = None,
    tilt_deg: float | None = None,
    roll_deg: float | None = None,
    orientation: Vector | None = None,
    mount: Mapping[str, str] | str | None = None,
    lens: Lens | None = None,
    antialias: str | None = None,
    near: float | None = None,
    far: float | None = None,
    quality: str | None = None,
    controls: Mapping[str, float | bool] | None = None,
    code_strip: bool | None = None,
    outputs: Iterable[Output] | None = None,
) -> dict[str, Any]:
    """Only what is given is in the result. Values are checked by the rig; here they are only brought into form."""
    params: dict[str, Any] = {}
    if size is not None:
        params["size"] = [int(v) for v in _vector("size", size, 2)]
    if fps is not None:
        params["fps"] = f"{fps.numerator}/{fps.denominator}" if isinstance(fps, Fraction) else _plain(fps)
    for name, value in (("vfov_deg", vfov_deg), ("hfov_deg", hfov_deg), ("zoom", zoom), ("near", near), ("far", far)):
        if value is not None:
            params[name] = float(value)
    if intrinsics is not None:
        params["intrinsics"] = _intrinsics(intrinsics)
    pose: dict[str, Any] = {}
    for name, vector, length in (("position", position, 3), ("look_at", look_at, 3), ("orientation", orientation, 4)):
        if vector is not None:
            pose[name] = _vector(name, vector, length)
    for name, angle in (("pan_deg", pan_deg), ("tilt_deg", tilt_deg), ("roll_deg", roll_deg)):
        if angle is not None:
            pose[name] = float(angle)
    if pose:
        params["pose"] = pose
    if mount is not None:
        params["mount"] = _mount(mount)
    if lens is not None:
        params["lens"] = _lens(lens)
    if antialias is not None:
        params["antialias"] = antialias
    if quality is not None:
        params["quality"] = quality
    if controls is not None:
        params["controls"] = {name: _plain(value) for name, value in controls.items()}
    if code_strip is not None:
        params["code_strip"] = bool(code_strip)
    if outputs is not None:
        params["outputs"] = [{"kind": output} if isinstance(output, str) else dict(output) for output in outputs]
    return params


def nanoseconds_of(seconds: float | None, nanoseconds: int | None) -> int:
    """Exactly one of the two, in ns. 0.2 s is 200000000 ns, whatever its binary digits say."""
    if (seconds is None) == (nanoseconds is None):
        raise CamrigError("invalid_argument", "step: give either seconds or nanoseconds")
    if nanoseconds is not None:
        return int(nanoseconds)
    return round(Fraction(repr(float(seconds))) * 10**9)  # type: ignore[arg-type]


def _plain(value: Any) -> Any:
    """numpy's scalars as Python's own."""
    return value.item() if isinstance(value, np.generic) else value


def _mount(value: Mapping[str, str] | str) -> dict[str, str] | None:
    """Also "actor" or "actor/node"; "" takes the camera off."""
    if not isinstance(value, str):
        return dict(value)
    actor, _, node = value.partition("/")
    return {"actor": actor, "node": node} if actor else None


def _vector(name: str, value: Sequence[float], length: int) -> list[float]:
    vector = [float(v) for v in value]
    if len(vector) != length:
        raise CamrigError("invalid_argument", f"{name}: has {len(vector)} numbers; it takes {length}")
    return vector


def _intrinsics(value: Intrinsics) -> dict[str, float]:
    if isinstance(value, Mapping):
        return {str(key): float(number) for key, number in value.items()}
    matrix = np.asarray(value, dtype=float)
    if matrix.shape != (3, 3) or matrix[0, 1] != 0 or matrix[1, 0] != 0 or not np.array_equal(matrix[2], [0, 0, 1]):
        raise CamrigError(
            "invalid_argument", "intrinsics: give {fx, fy, cx, cy} or a camera matrix [[fx,0,cx],[0,fy,cy],[0,0,1]] without skew"
        )
    return {
        "fx": float(matrix[0, 0]),
        "fy": float(matrix[1, 1]),
        "cx": float(matrix[0, 2]),
        "cy": float(matrix[1, 2]),
    }


def _lens(value: Lens) -> dict[str, Any]:
    if isinstance(value, str):
        return {"model": value, "coefficients": []}
    if isinstance(value, Mapping):
        model, coefficients = value.get("model"), value.get("coefficients", [])
        return {**value, "model": model, "coefficients": [float(c) for c in coefficients]}
    model, coefficients = value
    return {"model": model, "coefficients": [float(c) for c in np.ravel(coefficients)]}
