"""Camera options as Python likes them -> parameters of camera.create and camera.set."""

from __future__ import annotations

import inspect
from fractions import Fraction
from typing import Any, Callable, Iterable, Mapping, Sequence, TypeVar

import numpy as np

from . import parameters
from .errors import CamrigError
from .parameters import CAMERA_OPTIONS

Function = TypeVar("Function", bound=Callable[..., Any])


def camera_params(**options: Any) -> dict[str, Any]:
    """Only what is given is in the result: None is not given, but for options that may be null. Values are checked by the rig; here they are
    only brought into form."""
    params: dict[str, Any] = {}
    for name, value in options.items():
        if name not in CAMERA_OPTIONS:
            raise TypeError(f"'{name}' is no option of a camera; there are {', '.join(CAMERA_OPTIONS)}")
        json_type, within = CAMERA_OPTIONS[name]
        if value is None and not json_type.endswith(" or null"):
            continue
        place = params.setdefault(within, {}) if within else params
        place[name] = None if value is None else _formed(name, json_type, value)
    return params


def takes_camera_options(function: Function) -> Function:
    """Shows each camera option as a keyword of the function, to help() and to shells that complete; editors read Unpack[CameraOptions]."""
    signature = inspect.signature(function)
    own = [one for one in signature.parameters.values() if one.kind is not inspect.Parameter.VAR_KEYWORD]
    hints = parameters.CameraOptions.__annotations__
    options = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_words(hints[name])) for name in CAMERA_OPTIONS]
    function.__signature__ = signature.replace(parameters=own + options)  # type: ignore[attr-defined]
    return function


def step_params(seconds: float | None, nanoseconds: int | None) -> dict[str, Any]:
    """Exactly one of the two, as it was given: the rig takes 0.2 s for 200000000 ns and says what is wrong in the same unit."""
    if (seconds is None) == (nanoseconds is None):
        raise CamrigError("invalid_argument", "step: give either seconds or nanoseconds")
    return {"seconds": float(seconds)} if seconds is not None else {"nanoseconds": int(nanoseconds)}  # type: ignore[arg-type]


def _words(hint: Any) -> str:
    """Of an annotation that was not evaluated."""
    return getattr(hint, "__forward_arg__", str(hint))


def _formed(name: str, json_type: str, value: Any) -> Any:
    if name in _BY_NAME:
        return _BY_NAME[name](value)
    if name == "size":
        return [int(v) for v in _vector(name, value, 2)]
    if json_type.startswith("["):
        return _vector(name, value, json_type.count(",") + 1)
    if isinstance(value, Fraction):
        return f"{value.numerator}/{value.denominator}"
    if json_type == "number":
        return float(value)
    if json_type == "boolean":
        return bool(value)
    if isinstance(value, Mapping):
        return {key: _plain(one) for key, one in value.items()}
    return _plain(value)


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


def _intrinsics(value: Any) -> dict[str, float]:
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


def _lens(value: Any) -> dict[str, Any]:
    if isinstance(value, str):
        return {"model": value, "coefficients": []}
    if isinstance(value, Mapping):
        model, coefficients = value.get("model"), value.get("coefficients", [])
        return {**value, "model": model, "coefficients": [float(c) for c in coefficients]}
    model, coefficients = value
    return {"model": model, "coefficients": [float(c) for c in np.ravel(coefficients)]}


def _outputs(value: Iterable[Any]) -> list[dict[str, Any]]:
    return [{"kind": output} if isinstance(output, str) else dict(output) for output in value]


# Those with shorter ways to say them.
_BY_NAME: dict[str, Callable[[Any], Any]] = {"intrinsics": _intrinsics, "mount": _mount, "lens": _lens, "outputs": _outputs}
