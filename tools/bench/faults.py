"""python -m tools.bench.faults: what faults look like; writes the pictures of docs/faults.md.

A fault of the picture is a picture. One of delivery or of the way to readers is a strip: what a reader's window shows with each of six frames that
fall due, grey where it shows nothing.
"""

from __future__ import annotations

import sys
import threading
import urllib.request
from fractions import Fraction
from typing import Any

import cv2
import numpy as np

from tools.bench import report

ROOT = report.REPOSITORY
PICTURES = ROOT / "docs" / "pictures" / "faults"
SIZE = (320, 240)
#: Kind, severity, parameters.
SHOWN = (
    ("none", 0.0, {}),
    ("knock", 1.0, {}),
    ("defocus", 1.0, {}),
    ("dirt", 0.8, {}),
    ("drops", 1.0, {}),
    ("condensation", 1.0, {}),
    ("covered", 0.5, {}),
    ("exposure", 1.0, {}),
    ("white_balance", 1.0, {}),
    ("chroma_lost", 1.0, {}),
    ("noise", 0.8, {}),
    ("banding", 1.0, {}),
    ("dead_pixels", 1.0, {}),
    ("dead_rows", 1.0, {}),
    ("mirrored", 1.0, {}),
    ("upside_down", 1.0, {}),
    ("black", 0.7, {}),
)
#: The same, seen over time through an HTTP stream; what moves the camera, tears or keeps frames back.
STRIPS = (
    ("sag", 1.0, {"tilt_deg_per_h": -20_000.0}),
    ("vibration", 1.0, {"amplitude_deg": 3.0, "frequency_hz": 1.1}),
    ("tearing", 1.0, {}),
    ("freeze", 1.0, {}),
    ("duplicate", 1.0, {}),
    ("reduced_rate", 1.0, {"share": 0.5}),
    ("drop", 1.0, {}),
    ("late", 1.0, {"frames": 2}),
    ("corrupt_jpeg", 1.0, {"amount": 30}),
    ("other_size", 1.0, {}),
    ("stall", 1.0, {}),
    ("disconnect", 1.0, {}),
    ("bandwidth", 1.0, {"kbit_per_s": 120.0}),
    ("cut_part", 1.0, {"probability": 0.5}),
)
STRIP_FRAMES, STRIP_SIZE = 6, (160, 120)


class Window:
    """What a reader of the camera's HTTP stream shows: its newest picture that can be decoded, and since when."""

    def __init__(self, url: str) -> None:
        self.picture: np.ndarray | None = None
        self.bytes = 0
        self._stream = urllib.request.urlopen(url, timeout=10)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        kept = b""
        try:
            while piece := self._stream.read1(1 << 16):
                kept += piece
                self.bytes += len(piece)
                while (end := kept.find(b"\r\n--frame", kept.find(b"\xff\xd8") + 1)) > 0 and b"\xff\xd8" in kept:
                    jpeg = kept[kept.find(b"\xff\xd8"):end]
                    kept = kept[end + 2:]
                    picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
                    self.picture = picture if picture is not None else self.picture
        except (OSError, ValueError, AttributeError):
            pass
        self.picture = None

    def close(self) -> None:
        self._stream.close()


def strip(rig: Any, camera: Any, kind: str, severity: float, params: dict[str, Any]) -> np.ndarray:
    """Six pictures side by side."""
    window = Window(camera.url())
    rig.step(seconds=0.4)
    rig.fault.set("desk", kind, severity=severity, **params)
    shown = []
    for _ in range(STRIP_FRAMES):
        rig.step(seconds=0.2)
        threading.Event().wait(0.3)  # a reader without a step to wait for it
        grey = np.full((STRIP_SIZE[1], STRIP_SIZE[0], 3), 128, np.uint8)
        picture = window.picture
        if picture is not None and picture.shape[1] == SIZE[0]:
            grey = cv2.resize(picture, STRIP_SIZE, interpolation=cv2.INTER_AREA)
        elif picture is not None:
            grey[:picture.shape[0] // 2, :picture.shape[1] // 2] = cv2.resize(picture, (picture.shape[1] // 2, picture.shape[0] // 2))
        shown.append(grey)
    rig.fault.clear("desk")
    window.close()
    return np.hstack([np.pad(one, ((0, 0), (0, 4), (0, 0)), constant_values=255) for one in shown])[:, :-4]


def main() -> int:
    PICTURES.mkdir(parents=True, exist_ok=True)
    with report.start(ROOT / "scenes" / "hall.json", mode="lockstep", device="cpu", seed=1) as rig:
        camera = rig.create_camera("desk", place="lobby", size=SIZE, fps=Fraction(5))
        rig.step(seconds=4)
        for kind, severity, params in SHOWN:
            if kind != "none":
                rig.fault.set("desk", kind, severity=severity, **params)
            rig.step(seconds=0.2)
            camera.snapshot(PICTURES / f"{kind}.jpg")
            rig.fault.clear("desk")
        for kind, severity, params in STRIPS:
            cv2.imwrite(str(PICTURES / f"{kind}.jpg"), strip(rig, camera, kind, severity, params), [cv2.IMWRITE_JPEG_QUALITY, 85])
    return 0


if __name__ == "__main__":
    sys.exit(main())
