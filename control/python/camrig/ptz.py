"""The pan/tilt/zoom head of a camera."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .rig import Rig


class Ptz:
    """Moves the head of a camera that has one (``ptz={"preset": "dome"}``) and tells where it is.

    All calls answer at once with the status: ``pan_deg``, ``tilt_deg`` and ``zoom`` as the head believes, ``true`` as it is,
    ``turning``, ``zooming``, ``arrives_ns``, ``presets``, ``tours`` and the ``tour`` that it is on. Pan is positive to the left, tilt upwards.
    """

    def __init__(self, rig: Rig, camera: str) -> None:
        self._rig = rig
        self._camera = camera

    def status(self) -> dict[str, Any]:
        return self._call("ptz.status")

    def move(
        self,
        *,
        pan_deg: float | None = None,
        tilt_deg: float | None = None,
        x: float | None = None,
        y: float | None = None,
        zoom: float | None = None,
        mode: str = "absolute",
        speed: float | None = None,
        timeout_s: float | None = None,
    ) -> dict[str, Any]:
        """``absolute``: to these angles and this zoom; ``relative``: by them; ``continuous``: degrees a second, and a share
        of the zoom's speed, until another command, a limit or ``timeout_s``; ``fov``: what the picture shows at x to the right
        and y up (halves of the picture from its middle) comes to its middle. ``speed``: share of the head's."""
        return self._call("ptz.move", pan_deg=pan_deg, tilt_deg=tilt_deg, x=x, y=y, zoom=zoom, mode=mode, speed=speed, timeout_s=timeout_s)

    def stop(self, pan_tilt: bool = True, zoom: bool = True) -> dict[str, Any]:
        return self._call("ptz.stop", pan_tilt=pan_tilt, zoom=zoom)

    def preset_set(self, preset: str) -> dict[str, Any]:
        return self._call("ptz.preset_set", preset=preset)

    def preset_goto(self, preset: str) -> dict[str, Any]:
        return self._call("ptz.preset_goto", preset=preset)

    def preset_remove(self, preset: str) -> dict[str, Any]:
        return self._call("ptz.preset_remove", preset=preset)

    def tour_set(self, tour: str, stops: Iterable[str | Mapping[str, Any]]) -> dict[str, Any]:
        """Makes a guard tour: names of presets, or each ``{"preset": .., "dwell_s": .., "speed": ..}``."""
        listed = [{"preset": stop} if isinstance(stop, str) else dict(stop) for stop in stops]
        return self._call("ptz.tour_set", tour=tour, stops=listed)

    def tour_start(self, tour: str) -> dict[str, Any]:
        """From stop to stop, over and over, until any other command moves the head or stops it."""
        return self._call("ptz.tour_start", tour=tour)

    def tour_remove(self, tour: str) -> dict[str, Any]:
        return self._call("ptz.tour_remove", tour=tour)

    def home_set(self) -> dict[str, Any]:
        return self._call("ptz.home_set")

    def home_goto(self) -> dict[str, Any]:
        return self._call("ptz.home_goto")

    def _call(self, method: str, **params: Any) -> dict[str, Any]:
        given = {key: value for key, value in params.items() if value is not None}
        return self._rig.call(method, camera=self._camera, **given)
