"""One camera of a rig."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode

import numpy as np

from .errors import CamrigError
from .frame import Frame, data_of, frame_of, frame_params
from .projection import Projection
from .ptz import Ptz
from .spec import camera_params, takes_camera_options

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .parameters import CameraOptions, CameraState
    from .rig import Rig

_SNAPSHOT_FORMATS = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png"}


class Camera:
    """A camera by its name. Holds no state: what it is now, ``get()`` asks the rig."""

    def __init__(self, rig: Rig, name: str) -> None:
        self._rig = rig
        self.name = name

    def __repr__(self) -> str:
        return f"Camera({self.name!r})"

    def get(self) -> CameraState:
        """All its settings, as camera.get gives them."""
        return self._rig.call("camera.get", name=self.name)

    @takes_camera_options
    def set(self, *, seconds: float | None = None, **options: Unpack[CameraOptions]) -> CameraState:
        """Changes any option of Rig.create_camera but name and place. The reply's ``applied_ns`` is the world time from
        which it shows. With ``seconds``, pose and field of view get there in so long a world time, at ``arrives_ns``."""
        return self._rig.call("camera.set", name=self.name, **_optional(seconds=seconds), **camera_params(**options))

    def delete(self) -> dict[str, Any]:
        return self._rig.call("camera.delete", name=self.name)

    def frame(self, min_ns: int | None = None, kind: str = "color", format: str = "raw", timeout: float | None = None) -> Frame:
        """The latest due frame; with ``min_ns``, the first that shows that world time or a later one (waits for it).

        ``format`` is how it travels: raw (exact), png (exact; depth in whole millimetres, to 65.535 m) or jpeg (smaller; color only).
        """
        return frame_of(self._frame_get(min_ns, kind, format, timeout), self.name, kind)

    def depth(self, min_ns: int | None = None) -> np.ndarray:
        """HxW float32: metres along the optical axis, inf where nothing is."""
        return self.frame(min_ns, kind="depth").image

    def flow(self, min_ns: int | None = None) -> np.ndarray:
        """HxWx2 float32, optical flow: how many pixels to the right and down what a pixel shows will have moved in the camera's next frame.

        NaN where nothing is, and of what the lens does not show then. It is that of a world to which nobody says anything until then.
        """
        return self.frame(min_ns, kind="flow").image

    def soiling(self, min_ns: int | None = None) -> np.ndarray:
        """HxW uint8: how much of a pixel's light dirt, drops, condensation and covers on the lens take; 0: none, 255: all."""
        return self.frame(min_ns, kind="soiling").image

    def instances(self, min_ns: int | None = None) -> np.ndarray:
        """HxW uint32: ids of objects, the same in all cameras and in truth(); 0 where nothing is."""
        return self.frame(min_ns, kind="instance").image

    def truth(self, min_ns: int | None = None) -> dict[str, Any]:
        """The truth of the latest due frame: camera, pose and every object in view."""
        return self._rig.call("truth.get", camera=self.name, **_optional(min_ns=min_ns))

    @property
    def ptz(self) -> Ptz:
        """Its pan/tilt/zoom head, if it has one."""
        return Ptz(self._rig, self.name)

    def projection(self) -> Projection:
        """Calibration and place of this moment together; of an instant, ``camrig.Projection.of(truth)``."""
        return Projection.of(self.get())

    @property
    def K(self) -> np.ndarray:
        """3x3 float64 camera matrix, pixels, pixel centres at integers; asks the rig, like all below."""
        return self.projection().K

    @property
    def distortion(self) -> np.ndarray:
        """Coefficients of its lens model in the order of OpenCV and ROS; five zeros for a pinhole."""
        return self.projection().distortion

    @property
    def world_from_camera(self) -> np.ndarray:
        """4x4 float64: from its optical frame (z forward, x right, y down) to the world, metres; of a camera that is mounted, at its latest
        due frame."""
        return self.projection().world_from_camera

    def project(self, points: Any) -> np.ndarray:
        """Pixels (N x 2) of points of the world (N x 3, metres) through its lens, also outside of the picture; NaN for those behind it or
        beyond the angle at which its lens folds."""
        return self.projection().project(points)

    def snapshot(self, path: str | os.PathLike[str]) -> Path:
        """Writes the latest due frame to a .jpg or .png file, as encoded by the rig; returns the path."""
        path = Path(path)
        encoding = _SNAPSHOT_FORMATS.get(path.suffix.lower())
        if encoding is None:
            raise CamrigError("invalid_argument", f"snapshot: '{path.name}' ends in neither .jpg nor .png")
        path.write_bytes(data_of(self._frame_get(None, "color", encoding, None)))
        return path

    def url(self, kind: str = "mjpeg", fps: float | None = None, quality: int | None = None) -> str:
        """Where a program finds this camera: kind is mjpeg, jpg, png, rtsp (the main stream), rtsp-sub or rtsp-mjpeg."""
        query: dict[str, Any] = _optional(fps=fps, quality=quality)
        if kind in ("rtsp", "rtsp-sub", "rtsp-mjpeg"):
            if query:
                raise CamrigError("invalid_argument", f"url: fps and quality are for HTTP, not for {kind}")
            return f"{self._rig.rtsp_url}/{self.name}" + {"rtsp": "", "rtsp-sub": "/sub", "rtsp-mjpeg": "/mjpeg"}[kind]
        files = {"mjpeg": "stream.mjpg", "jpg": "snapshot.jpg", "png": "snapshot.png"}
        if kind not in files:
            raise CamrigError("invalid_argument", f"url: kind is '{kind}'; it is mjpeg, jpg, png, rtsp, rtsp-sub or rtsp-mjpeg")
        if self._rig.token:
            query["token"] = self._rig.token
        url = f"{self._rig.http_url}/cameras/{self.name}/{files[kind]}"
        return f"{url}?{urlencode(query)}" if query else url

    def _frame_get(self, min_ns: int | None, kind: str, encoding: str, timeout: float | None) -> dict[str, Any]:
        params = {**frame_params(self.name, kind, encoding), **_optional(min_ns=min_ns)}
        return self._rig.client.call("frame.get", params, timeout_s=timeout, wants_bytes=True)


def _optional(**params: Any) -> dict[str, Any]:
    return {name: value for name, value in params.items() if value is not None}
