"""Cameras that fail."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .rig import Rig


class Faults:
    """Lets cameras fail, as docs/faults.md says: ``rig.fault.set("lobby", "freeze", end_s=12)``."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig

    def set(
        self,
        camera: str,
        kind: str,
        *,
        severity: float | None = None,
        start_s: float | None = None,
        end_s: float | None = None,
        seed: int | None = None,
        **params: Any,
    ) -> dict[str, Any]:
        """Times are world seconds; other keywords are the kind's own. Answers what was set, with its ``id``."""
        given = {"severity": severity, "start_s": start_s, "end_s": end_s, "seed": seed, "params": params or None}
        return self._rig.call("fault.set", camera=camera, kind=kind, **_given(given))

    def clear(self, camera: str | None = None, *, id: int | None = None, kind: str | None = None) -> int:
        """Ends one fault, or those of a camera, of all kinds or one. How many."""
        return self._rig.call("fault.clear", **_given({"camera": camera, "id": id, "kind": kind}))["cleared"]

    def wipe(self, camera: str) -> int:
        """Wipes the glass before its lens: ends dirt, drops and condensation. How many."""
        return self._rig.call("fault.wipe", camera=camera)["cleared"]

    def list(self, camera: str | None = None) -> list[dict[str, Any]]:
        """Those that are not over."""
        return self._rig.call("fault.list", **_given({"camera": camera}))["faults"]

    def log(self, camera: str | None = None, *, since: int = 0) -> dict[str, Any]:
        """What faults let readers meet after event number ``since``: ``events`` with ``kind`` (closed, open, refused, thrown_out, good), camera, output,
        peer and times; ``last`` and ``missed``. A reader's time to come back: its first ``good`` event since the fault was cleared."""
        return self._rig.call("fault.log", since=since, **_given({"camera": camera}))


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}
