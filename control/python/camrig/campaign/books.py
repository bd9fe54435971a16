"""What became of the camera's frames while the program ran."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from ..errors import CamrigError

if TYPE_CHECKING:
    from ..rig import Rig

_EVERY_S = 0.25
_OUTPUT_KEYS = ("due", "fault", "not_drawn", "received", "encoded", "dropped", "failed", "kept_back")


class Books:
    """Adds up stats.get from entering on. An output's own numbers begin anew when its last reader goes, so they are looked at four times
    a second: of an output that goes, what was since the last look is missing."""

    def __init__(self, rig: Rig, camera: str) -> None:
        self._rig, self._camera = rig, camera
        self._first: dict[str, Any] | None = None
        self._latest: dict[str, Any] = {}
        self._outputs: dict[str, dict[str, int]] = {}
        self._seen: dict[str, dict[str, int]] = {}
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Books:
        self._look()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def told(self) -> dict[str, Any]:
        """`camera`: due = rendered + by_fault + by_overload, exactly. `outputs`, by format: due = delivered + by_fault + by_overload, but for
        a frame that is on its way; by_fault is what the camera's driver dropped and what a fault of the way to readers kept back."""
        self._look()
        with self._lock:
            assert self._first is not None
            first, latest = self._first, self._latest
            since = {key: latest[key] - first[key] for key in ("due", "rendered", "dropped")}
            by_fault = latest["dropped_for"]["fault"] - first["dropped_for"]["fault"]
            camera = {"due": since["due"], "rendered": since["rendered"], "by_fault": by_fault, "by_overload": since["dropped"] - by_fault}
            outputs = [
                {"format": name, "due": sums["due"], "delivered": sums["encoded"], "by_fault": sums["fault"] + sums["kept_back"],
                 "by_overload": sums["not_drawn"] + sums["dropped"] + sums["failed"]}
                for name, sums in sorted(self._outputs.items())
            ]
        return {"camera": camera, "outputs": outputs}

    def _run(self) -> None:
        while not self._stop.wait(_EVERY_S):
            try:
                self._look()
            except CamrigError:
                return

    def _look(self) -> None:
        with self._lock:
            state = next(one for one in self._rig.stats()["cameras"] if one["name"] == self._camera)
            is_first = self._first is None
            self._first = self._first or state
            self._latest = state
            seen = {one["format"]: {key: one[key] for key in _OUTPUT_KEYS} for one in state["outputs"]}
            if not is_first:
                for name, now in seen.items():
                    before = self._seen.get(name, {})
                    is_new = not before or now["due"] < before["due"]
                    sums = self._outputs.setdefault(name, dict.fromkeys(_OUTPUT_KEYS, 0))
                    for key in _OUTPUT_KEYS:
                        sums[key] += now[key] - (0 if is_new else before[key])
            self._seen = seen
