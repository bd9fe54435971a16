"""Calls as the rig itself describes them: right names, and values of right and of wrong types in their places."""

from __future__ import annotations

import random
from typing import Any

import camrig

#: What would end the rig, stop it for long, or is attacked by itself.
LEFT_OUT = {"server.shutdown", "world.load", "world.pause", "auth"}
#: Of any type, to be put in any place.
WRONG = [None, True, -1, 0, 2**63, 2**64, -(2**63), 1e308, -1e308, 5e-324, "", "x" * 5000, "\u202e", "\x00", [], [[]], [None] * 300, {}, {"a": 1}, {"": {"": {}}}]
#: How far the world moves, and how long a call waits (also for a world time, in a world that stands), is the attack's own time;
#: who has pictures drawn pays for them; bytes would follow a line.
SHORT = {"seconds": [0, 0.04, -1, 1e308], "nanoseconds": [0, 40_000_000, -1, 2**63], "timeout_s": [0.01, -1, 1e308], "min_ns": [0, -1, 2**63], "at_ns": [0, -1, 2**62, 2**63],
         "size": [[64, 48], [17, 33], [15, 16], [0, 0], [1e9, 1e9], [64], "64x48"], "encoding": ["base64", "base65", 1]}
NAMES = [*["victim"] * 6, *["guest"] * 3, "nobody", "UPPER", "x" * 25, "", "a b"]
TEXTS = {"name": NAMES, "camera": NAMES, "actor": NAMES, "scene": ["minimal", "clock", "none", "/dev/null", "/"], "model": ["mover", "person_1", "none"]}


class Calls:
    """Random calls of all methods but those that are left out."""

    def __init__(self, rig: camrig.Rig, seed: int, right_share: float) -> None:
        described = rig.call("server.describe")
        self.methods: list[dict[str, Any]] = [method for method in described["methods"] if method["name"] not in LEFT_OUT]
        self._kinds: dict[str, list[dict[str, Any]]] = described["kinds"]
        self._kind_of_field = {"outputs": "output", "behaviour": "behaviour", "do": "action", "when": "trigger"}
        self._random = random.Random(seed)
        self._right_share = right_share

    def one(self) -> tuple[str, dict[str, Any]]:
        """A method and its parameters: what it needs, and some of what it takes."""
        method, = self._random.choices(self.methods, [1 + 10 * bool(one["params"]) for one in self.methods])
        return method["name"], self._object(method["params"])

    def numbers(self) -> list[tuple[str, dict[str, Any]]]:
        """Of each number of each method: the bounds, just beyond them, and the extremes of its type; alone beside what the method needs."""
        calls = []
        for method in self.methods:
            for field in method["params"]:
                if field["name"] in SHORT or field["type"] not in ("number", "integer", "[x, y, z]", "[x, y, z, w]"):
                    continue
                for value in self._extremes(field):
                    params = {one["name"]: TEXTS.get(one["name"], [None])[0] or self._right(one) for one in method["params"] if one.get("required")}
                    if method["name"].endswith((".create", ".spawn")):
                        params["name"] = "guest"
                    params[field["name"]] = [value] * (field["type"].count(",") + 1) if field["type"].startswith("[") else value
                    calls.append((method["name"], params | self._waits(method["params"])))
        return calls

    def _object(self, fields: list[dict[str, Any]]) -> dict[str, Any]:
        chosen = {}
        optional = [field for field in fields if not field.get("required")]
        for field in [*(one for one in fields if one.get("required")), *self._random.sample(optional, min(len(optional), self._random.randrange(4)))]:
            is_right = self._random.random() < self._right_share
            chosen[field["name"]] = self._right(field) if is_right or field["name"] in SHORT else self._random.choice(WRONG)
        return chosen | self._waits(fields)

    def _waits(self, fields: list[dict[str, Any]]) -> dict[str, Any]:
        return {"timeout_s": 0.01} if any(field["name"] == "timeout_s" for field in fields) else {}

    def _extremes(self, field: dict[str, Any]) -> list[Any]:
        least, most = (field.get(key, field.get(f"exclusive_{key}")) for key in ("minimum", "maximum"))
        bounds = [value for bound in (least, most) if bound is not None for value in (bound, bound - 1, bound + 1, bound * (1 + 2**-52), bound * (1 - 2**-53))]
        return [*bounds, 0, -0.0, 5e-324, -5e-324, 1e-38, 1e38, 1e308, -1e308, 2**31, -(2**31) - 1, 2**53 + 1, 2**63 - 1, 2**63, -(2**63), 2**64]

    def _right(self, field: dict[str, Any]) -> Any:
        rng, name, kind = self._random, field["name"], field["type"]
        if name in SHORT:
            return rng.choice(SHORT[name])
        if name in self._kind_of_field:
            described = rng.choice(self._kinds[self._kind_of_field[name]])
            one = {"type" if name == "behaviour" else "kind" if name == "outputs" else "action": described["name"]} if name != "when" else {}
            one |= self._object(described["fields"])
            return [one] if kind.startswith("array") else one
        if "choices" in field:
            return rng.choice(field["choices"])
        if name in TEXTS and kind == "string":
            return rng.choice(TEXTS[name])
        if "fields" in field:
            return [self._object(field["fields"])] if kind.startswith("array") else self._object(field["fields"])
        if kind.startswith("[") and kind != "[string, string]":
            return [rng.choice([0, 1, -1.5, 0.25, rng.uniform(-20, 20)]) for _ in range(kind.count(",") + 1)]
        if kind in ("number", "integer"):
            least, most = field.get("minimum", field.get("exclusive_minimum", -1e3)), field.get("maximum", field.get("exclusive_maximum", 1e3))
            value = rng.choice([least, most, rng.uniform(least, min(most, 1e3))])
            return int(value) if kind == "integer" else value
        return {"boolean": rng.random() < 0.5, "string": rng.choice([*NAMES, "25/2", "hall", "person_1", "jpeg"]), "[string, string]": ["a", "b"]}.get(
            kind, rng.choice([25, "25/2", [], {}, [0.1, -0.2], "none"]))
