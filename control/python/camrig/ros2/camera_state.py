"""A camera as ROS sees it: calibration (sensor_msgs/CameraInfo), frames (REP 103, REP 105) and rate."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Mapping

from ..errors import CamrigError
from ..frame_times import due_count, due_ns, next_due_ns, rate_of

WORLD_FRAME = "map"

#: <cam>_link (x forward, y left, z up) -> <cam>_optical_frame (z forward, x right, y down), x y z w.
OPTICAL_FROM_LINK = (-0.5, 0.5, -0.5, 0.5)

#: Coefficients of the models that sensor_msgs/distortion_models.hpp names.
_COEFFICIENTS = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}


@dataclass(frozen=True)
class CameraState:
    """What camera.get says of one camera; equal states give equal messages."""

    name: str
    size: tuple[int, int]
    rate: Fraction
    phase_ns: int
    leaves_grid: bool  # its clock has it expose beside the grid of its rate
    intrinsics: tuple[float, float, float, float]  # fx, fy, cx, cy
    distortion_model: str
    distortion: tuple[float, ...]
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]  # x, y, z, w of the body frame in the world

    @classmethod
    def of(cls, reply: Mapping[str, Any]) -> CameraState:
        clock = reply.get("clock") or {}
        intrinsics, lens, pose = reply.get("shown_intrinsics", reply["intrinsics"]), reply.get("lens") or {}, reply.get("world_pose", reply["pose"])
        model = lens.get("model", "pinhole")
        coefficients = tuple(float(c) for c in lens.get("coefficients", ()))
        if model == "pinhole":  # ROS has no name for it: plumb_bob of zeros
            model, coefficients = "plumb_bob", (0.0,) * 5
        if model not in _COEFFICIENTS:
            raise CamrigError("unsupported", f"camera {reply['name']}: ROS has no distortion model '{model}'")
        coefficients += (0.0,) * (_COEFFICIENTS[model] - len(coefficients))
        width, height = reply["size"]
        return cls(
            name=reply["name"],
            size=(int(width), int(height)),
            rate=rate_of(reply["fps"]),
            phase_ns=clock.get("phase_ns", 0),
            leaves_grid=any(clock.get(key) for key in ("phase_ns", "rate_ppb", "trigger_jitter_ns")),
            intrinsics=tuple(float(intrinsics[key]) for key in ("fx", "fy", "cx", "cy")),  # type: ignore[arg-type]
            distortion_model=model,
            distortion=coefficients,
            position=tuple(float(v) for v in pose["position"]),  # type: ignore[arg-type]
            orientation=tuple(float(v) for v in pose["orientation"]),  # type: ignore[arg-type]
        )

    @property
    def link_frame(self) -> str:
        return f"{self.name}_link"

    @property
    def optical_frame(self) -> str:
        return f"{self.name}_optical_frame"

    @property
    def k(self) -> tuple[float, ...]:
        fx, fy, cx, cy = self.intrinsics
        return (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0)

    @property
    def r(self) -> tuple[float, ...]:
        return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)

    @property
    def p(self) -> tuple[float, ...]:
        """Of the rectified picture that keeps the camera matrix, without a stereo baseline."""
        fx, fy, cx, cy = self.intrinsics
        return (fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0)

    def next_due_ns(self, after_ns: int) -> int:
        """The next exposure; beside the grid, where they may come after little less than half a period, a time until which there is one at most."""
        return after_ns + due_ns(self.rate, 1) // 3 if self.leaves_grid else next_due_ns(self.rate, after_ns)

    def due_count(self, after_ns: int, until_ns: int) -> int:
        return due_count(self.rate, after_ns, until_ns, self.phase_ns)


class StateHistory:
    """One camera's states, each with the world time of the latest frame when it was last seen."""

    def __init__(self) -> None:
        self._states: deque[tuple[int, CameraState]] = deque(maxlen=64)

    def add(self, latest_ns: int, state: CameraState) -> None:
        if self._states and self._states[-1][1] == state:
            self._states.pop()
        self._states.append((latest_ns, state))

    @property
    def now(self) -> CameraState:
        return self._states[-1][1]

    @property
    def latest_ns(self) -> int:
        return self._states[-1][0]

    def at(self, world_ns: int) -> CameraState:
        """A frame was made in the state of the first poll that knew it."""
        return next((state for latest_ns, state in self._states if latest_ns >= world_ns), self.now)


def camera_info_yaml(state: CameraState) -> str:
    """The file that camera_info_manager reads (camera_calibration_parsers, YAML)."""
    return "".join(
        [
            f"image_width: {state.size[0]}\n",
            f"image_height: {state.size[1]}\n",
            f"camera_name: {state.name}\n",
            _matrix("camera_matrix", 3, 3, state.k),
            f"distortion_model: {state.distortion_model}\n",
            _matrix("distortion_coefficients", 1, len(state.distortion), state.distortion),
            _matrix("rectification_matrix", 3, 3, state.r),
            _matrix("projection_matrix", 3, 4, state.p),
        ]
    )


def yaml_number(value: float) -> str:
    """The shortest decimal that reads back as the same double, and that YAML 1.1 takes for a number (1.0e-05, not 1e-05)."""
    text = repr(float(value))
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _matrix(key: str, rows: int, cols: int, data: tuple[float, ...]) -> str:
    return f"{key}:\n  rows: {rows}\n  cols: {cols}\n  data: [{', '.join(map(yaml_number, data))}]\n"
