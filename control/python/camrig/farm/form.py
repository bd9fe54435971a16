"""What a rig reads (core/base/json_reader.cpp) is less than what Python does. It refuses a line as a whole, and many clients' commands stand on one."""

from __future__ import annotations

import json
import math
from typing import Any

from ..errors import CamrigError
from ..json_checks import Wrong, check_object

#: Levels of a batch; what the log says comes to a rig in batches, however it came to us.
_MAX_DEPTH = 64


def raise_if_unreadable(value: Any, levels: int = _MAX_DEPTH) -> None:
    """invalid_argument: no rig reads this batch of requests."""
    if isinstance(value, str):
        try:
            value.encode()
        except UnicodeEncodeError:
            raise CamrigError("invalid_argument", "a text has half of a surrogate pair, which is no character") from None
    elif isinstance(value, (int, float)):
        try:
            is_finite = math.isfinite(value)
        except OverflowError:
            is_finite = False
        if not is_finite:
            raise CamrigError("invalid_argument", "a number is beyond 1.8e308, or is none")
    elif isinstance(value, (dict, list)):
        if levels == 0:
            raise CamrigError("invalid_argument", f"JSON nested deeper than {_MAX_DEPTH - 1} levels")
        for each in (*value, *value.values()) if isinstance(value, dict) else value:
            raise_if_unreadable(each, levels - 1)


def read_object(text: bytes) -> dict[str, Any]:
    """The JSON object that a rig would read in a text of somebody's; else Wrong."""
    try:
        value = json.loads(text.decode())
        raise_if_unreadable(value)
    except (ValueError, RecursionError) as problem:
        raise Wrong("", f"is not JSON: {problem}") from None
    except CamrigError as problem:
        raise Wrong("", problem.message) from None
    return dict(check_object(value, ""))
