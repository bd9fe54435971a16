"""What a camera's perception tells its node of one person in one picture, and how it is kept in a file."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from typing import Any, Iterable

import numpy as np


@dataclass(frozen=True)
class Sighting:
    position: np.ndarray  #: where the person stands on the floor, m
    covariance: np.ndarray  #: of it, m2 (2 x 2)
    value: float  #: how well the camera sees them, 0 to 1: what it bids
    colours: np.ndarray  #: histogram of the torso, 48 bins, uint8
    box: tuple[float, ...]  #: in the picture, px: x, y, width, height

    def to_json(self) -> dict[str, Any]:
        return {"floor": [round(float(v), 3) for v in self.position], "cov": [round(float(v), 4) for v in self.covariance[np.triu_indices(2)]],
                "value": round(self.value, 3), "colours": pack(self.colours), "box": [round(float(v), 1) for v in self.box]}

    @classmethod
    def of(cls, told: dict[str, Any]) -> Sighting:
        a, b, c = told["cov"]
        return cls(np.array(told["floor"]), np.array([[a, b], [b, c]]), told["value"], unpack(told["colours"]), tuple(told["box"]))


def pack(colours: np.ndarray) -> str:
    return base64.b64encode(colours.astype(np.uint8).tobytes()).decode()


def unpack(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), np.uint8)


def alike(a: np.ndarray, b: np.ndarray) -> float:
    """Bhattacharyya coefficient of two histograms of three channels, 0 to 1."""
    p, q = (one.reshape(3, -1).astype(float) for one in (a, b))
    p, q = (one / np.maximum(one.sum(axis=1, keepdims=True), 1) for one in (p, q))
    return float(np.sqrt(p * q).sum() / 3)


def line(time_ns: int, sightings: Iterable[Sighting], **more: Any) -> str:
    """One line of a recording: all that a camera saw in one picture."""
    return json.dumps({"t": time_ns, "people": [one.to_json() for one in sightings], **more}, separators=(",", ":"))


def read_line(text: str) -> tuple[int, list[Sighting]]:
    told = json.loads(text)
    return told["t"], [Sighting.of(one) for one in told["people"]]
