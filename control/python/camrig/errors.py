"""What can go wrong, by the kinds of the control protocol."""

from __future__ import annotations

import json
from typing import Any

# A server that does not know a method is older than the client, or was built without the part.
_KIND_OF_CODE = {-32601: "unsupported", -32602: "invalid_argument", -32600: "invalid_argument", -32700: "invalid_argument"}


class CamrigError(Exception):
    """An error of the rig, or on the way to it.

    ``kind`` is one of invalid_argument, not_found, already_exists, unavailable, unsupported, resource_exhausted,
    unauthorized, internal; ``message`` says what was wrong and what to do.
    """

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(f"{kind}: {message}")
        self.kind = kind
        self.message = message

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.kind, self.message)


class CamrigTimeout(CamrigError, TimeoutError):
    """The rig did not answer in time (kind ``unavailable``)."""

    def __init__(self, kind: str, message: str) -> None:
        CamrigError.__init__(self, kind, message)


def error_of_reply(method: str, error: Any) -> CamrigError:
    """The exception for the ``error`` member of a JSON-RPC reply."""
    if not isinstance(error, dict):
        return CamrigError("internal", f"{method}: the rig answered with a malformed error: {error!r}")
    data = error.get("data")
    kind = data.get("kind") if isinstance(data, dict) else None
    if not isinstance(kind, str):
        kind = error.get("kind")  # what is refused before it is a request
    if not isinstance(kind, str):
        kind = _KIND_OF_CODE.get(error.get("code", 0), "internal")
    return CamrigError(kind, str(error.get("message", "no message")))


def error_of_command(printed: str, otherwise: CamrigError) -> CamrigError:
    """The exception for what a ``camrig`` command with ``--json`` printed on stderr when it failed: what the last line says,
    ``{"error": {"kind": "...", "message": "..."}}``. Without such a line it is of the kind of ``otherwise``, with all that was printed, if anything was."""
    text = printed.strip()
    try:
        error = json.loads(text.rpartition("\n")[2])["error"]
        kind, message = error["kind"], error["message"]
        if isinstance(kind, str) and isinstance(message, str):
            return CamrigError(kind, message)
    except (ValueError, TypeError, KeyError, RecursionError):
        pass
    return CamrigError(otherwise.kind, text.removeprefix("camrig: ") or otherwise.message)
