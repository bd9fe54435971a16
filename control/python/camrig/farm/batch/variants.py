"""The table of variants: what a plan's `vary` says, row by row.

Each block gives a list of rows; the table is the product of the blocks. A row says which keys have which values: `scene`, `seed`, `quality`, `device`,
`start_s`, `seconds`, `cameras`, `faults`, or a place in the scene that begins with / (pointer.py).
"""

from __future__ import annotations

import itertools
import math
from typing import Any, Mapping

from ...errors import CamrigError
from ...json_checks import Wrong, check_integer, check_list, check_number, check_object, inside
from .hashing import seed_of

Row = dict[str, Any]

MAX_ROWS = 200_000
_MAX_VALUES = 10_000
_MAX_DIMENSIONS = 1000
#: How a block is made; each block is of one of them.
_WAYS = ("rows", "product", "sobol", "latin_hypercube", "repeat")


def rows_of(blocks: Any, master_seed: int) -> list[Row]:
    """The table, in an order that follows from the blocks alone."""
    if blocks == []:
        return [{}]
    parts = [_block(block, f"vary[{number}]", seed_of(master_seed, "vary", number)) for number, block in enumerate(check_list(blocks, "vary", 100))]
    if (count := math.prod(len(part) for part in parts)) > MAX_ROWS:
        raise Wrong("vary", f"makes {count} variants; at most {MAX_ROWS}")
    seen: set[str] = set()
    for number, part in enumerate(parts):
        keys = set().union(*part)
        if twice := sorted(seen & keys):
            raise Wrong(f"vary[{number}]", f"'{twice[0]}' is varied by an earlier block already")
        seen |= keys
    return [{key: value for row in rows for key, value in row.items()} for rows in itertools.product(*parts)]


def _block(block: Any, place: str, seed: int) -> list[Row]:
    check_object(block, place, {*_WAYS, "count"})
    ways = [way for way in _WAYS if way in block]
    if len(ways) != 1:
        raise Wrong(place, f"must have one of {', '.join(_WAYS)}")
    way = ways[0]
    what, where = block[way], inside(place, way)
    if ("count" in block) != (way in ("sobol", "latin_hypercube")):
        raise Wrong(inside(place, "count"), "goes with sobol and latin_hypercube, which need it: how many variants")
    if way == "repeat":
        # A number that no camera sees: it makes another seed.
        return [{"repeat": number} for number in range(check_integer(what, where, 1, MAX_ROWS))]
    if way == "rows":
        return [dict(check_object(row, f"{where}[{number}]")) for number, row in enumerate(check_list(what, where, MAX_ROWS))]
    if way == "product":
        return _product(check_object(what, where), where)
    return _sample(way, check_object(what, where), where, check_integer(block["count"], inside(place, "count"), 1, MAX_ROWS), seed)


def _product(axes: Mapping[str, Any], place: str) -> list[Row]:
    values = [check_list(list_, inside(place, key), _MAX_VALUES) for key, list_ in axes.items()]
    if (count := math.prod(map(len, values))) > MAX_ROWS:
        raise Wrong(place, f"makes {count} variants; at most {MAX_ROWS}")
    return [dict(zip(axes, row)) for row in itertools.product(*values)]


def _sample(way: str, axes: Mapping[str, Any], place: str, count: int, seed: int) -> list[Row]:
    """Points that fill the space evenly (scipy.stats.qmc), scrambled by the seed."""
    if not 1 <= len(axes) <= _MAX_DIMENSIONS:
        raise Wrong(place, f"must have 1 to {_MAX_DIMENSIONS} axes")
    checked = {key: _axis(axis, inside(place, key)) for key, axis in axes.items()}
    try:
        import numpy as np
        from scipy.stats import qmc
    except ImportError:
        raise CamrigError("unavailable", f"{way} needs scipy: pip install 'camrig[farm]'") from None
    random = np.random.Generator(np.random.Philox(seed))
    if way == "sobol":
        # Whole powers of two are what the sequence is balanced for; the first of them are taken.
        points = qmc.Sobol(len(checked), rng=random).random_base2(max(0, math.ceil(math.log2(count))))[:count]
    else:
        points = qmc.LatinHypercube(len(checked), rng=random).random(count)
    return [{key: _on_axis(axis, float(x)) for (key, axis), x in zip(checked.items(), point)} for point in points]


def _axis(axis: Any, place: str) -> Mapping[str, Any]:
    check_object(axis, place, {"min", "max", "scale", "choices"})
    if "choices" in axis:
        check_list(axis["choices"], inside(place, "choices"), _MAX_VALUES)
        if len(axis) > 1:
            raise Wrong(place, "give choices, or min and max")
        return axis
    for key in ("min", "max"):
        if key not in axis:
            raise Wrong(inside(place, key), "is missing; give min and max, or choices")
        check_number(axis[key], inside(place, key), -1e12, 1e12)
    scale = axis.get("scale", "linear")
    if scale not in ("linear", "log", "integer"):
        raise Wrong(inside(place, "scale"), "must be linear, log or integer")
    if not axis["min"] < axis["max"]:
        raise Wrong(inside(place, "max"), "must be over min")
    if scale == "log" and axis["min"] <= 0:
        raise Wrong(inside(place, "min"), "must be over 0 where scale is log")
    if scale == "integer":
        check_integer(axis["min"], inside(place, "min"), -(2**53), 2**53)
        check_integer(axis["max"], inside(place, "max"), -(2**53), 2**53)
    return axis


def _on_axis(axis: Mapping[str, Any], x: float) -> Any:
    """The value at x of [0, 1)."""
    if "choices" in axis:
        return axis["choices"][min(int(x * len(axis["choices"])), len(axis["choices"]) - 1)]
    low, high, scale = axis["min"], axis["max"], axis.get("scale", "linear")
    if scale == "integer":
        return min(low + int(x * (high - low + 1)), high)
    # Twelve digits: what a mathematical library rounds otherwise in the last one makes no other shard.
    value = low * (high / low) ** x if scale == "log" else low + x * (high - low)
    return min(max(float(f"{value:.12g}"), low), high)
