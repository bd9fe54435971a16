"""python -m tools.bench.faults: what faults look like; writes the pictures of docs/faults.md.

A fault of the picture is a picture. One of delivery or of the way to readers is a strip: what a reader's window shows with each of six frames that
fall due, grey where it shows nothing.

    python -m tools.bench.faults [KIND..]     those alone
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
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
#: The same, seen by a program that uses OpenCV and opens anew what gives no picture: the way it reads, kind, severity, parameters.
PROGRAM_STRIPS = (
    ("mjpeg", "refuse", 1.0, {}),
    ("mjpeg", "restart", 0.5, {"period_s": 1.2}),
    ("mjpeg", "bad_part", 1.0, {"probability": 0.5}),
    ("rtsp", "packet_loss", 1.0, {"probability": 0.2}),
    ("rtsp", "packet_reorder", 1.0, {"probability": 0.3}),
    ("rtsp", "packet_delay", 1.0, {"probability": 0.3, "delay_s": 0.4}),
    ("rtsp", "new_ssrc", 1.0, {"period_s": 0.6}),
    ("rtsp", "corrupt_video", 1.0, {"amount": 100, "probability": 1.0}),
    ("device", "buffer_error", 1.0, {"probability": 0.5}),
    ("device", "wrong_size", 1.0, {}),
    ("device", "device_error", 0.5, {"at": "streaming", "period_s": 1.2}),
    ("device", "unplug", 0.5, {"period_s": 1.2}),
)
STRIP_FRAMES, STRIP_SIZE = 6, (160, 120)
DEVICE = 199
#: Writes each picture, and a grey one where there is none; `anew`: another connection for each.
PROGRAM = """
import sys, time, cv2, numpy as np
source, anew, (width, height) = sys.argv[1], sys.argv[2] == "anew", map(int, sys.argv[3:5])
show = lambda picture: (sys.stdout.buffer.write(cv2.resize(picture, (width, height)).tobytes()), sys.stdout.flush())
while True:
    capture = cv2.VideoCapture(source)
    is_there = True
    while is_there:
        is_there, picture = capture.read()
        if is_there: show(picture)
        if anew: break
    if not is_there: show(np.full((height, width, 3), 128, np.uint8))
    capture.release()
    time.sleep(0.02)
"""


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


class ProgramWindow:
    """What an OpenCV program shows."""

    def __init__(self, rig: Any, camera: Any, way: str, anew: bool) -> None:
        self.picture: np.ndarray | None = None
        source = f"/dev/video{DEVICE}" if way == "device" else camera.url(way)
        words = [sys.executable, "-c", PROGRAM, source, "anew" if anew else "stays", *map(str, SIZE)]
        if way == "device":
            words = [os.environ["CAMRIG_BIN"], "--control", rig.control, "exec", "--", *words]
        quiet = {**os.environ, "OPENCV_FFMPEG_CAPTURE_OPTIONS": "rtsp_transport;tcp|fflags;nobuffer|flags;low_delay", "OPENCV_LOG_LEVEL": "OFF"}
        self._program = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=quiet)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._program.stdout is not None
        while len(piece := self._program.stdout.read(3 * SIZE[0] * SIZE[1])) == 3 * SIZE[0] * SIZE[1]:
            self.picture = np.frombuffer(piece, np.uint8).reshape(SIZE[1], SIZE[0], 3)

    def wait(self, rig: Any) -> None:
        """Until it shows the camera. The world goes on: programs look at a stream before they show it."""
        deadline = time.monotonic() + 30
        while self.picture is None or self.picture.std() < 5:
            assert time.monotonic() < deadline, "the program shows nothing"
            rig.step(seconds=0.2)
            time.sleep(0.1)

    def close(self) -> None:
        self._program.kill()
        self._program.wait()


def program_strip(rig: Any, camera: Any, way: str, kind: str, severity: float, params: dict[str, Any]) -> np.ndarray:
    """The same as strip(), by a program."""
    window = ProgramWindow(rig, camera, way, anew=kind == "refuse")
    window.wait(rig)
    rig.fault.set("desk", kind, severity=severity, **params)
    shown = []
    for _ in range(STRIP_FRAMES):
        rig.step(seconds=0.2)
        time.sleep(0.6)
        assert window.picture is not None
        shown.append(cv2.resize(window.picture, STRIP_SIZE, interpolation=cv2.INTER_AREA))
    rig.fault.clear("desk")
    window.close()
    rig.step(seconds=0.2)
    return side_by_side(shown)


def side_by_side(shown: list[np.ndarray]) -> np.ndarray:
    return np.hstack([np.pad(one, ((0, 0), (0, 4), (0, 0)), constant_values=255) for one in shown])[:, :-4]


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
    return side_by_side(shown)


def keep(kind: str, picture: np.ndarray) -> None:
    cv2.imwrite(str(PICTURES / f"{kind}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 85])


def main() -> int:
    PICTURES.mkdir(parents=True, exist_ok=True)
    wanted = sys.argv[1:] or [kind for *_, kind, _, _ in (*SHOWN, *STRIPS, *PROGRAM_STRIPS)]
    with report.start(ROOT / "scenes" / "hall.json", mode="lockstep", device="cpu", seed=1) as rig:
        camera = rig.create_camera("desk", place="lobby", size=SIZE, fps=Fraction(5), outputs=[{"kind": "mjpeg"}, {"kind": "rtsp", "key_interval_s": 10}, {"kind": "device", "number": DEVICE}])
        rig.step(seconds=4)
        for kind, severity, params in SHOWN:
            if kind not in wanted:
                continue
            if kind != "none":
                rig.fault.set("desk", kind, severity=severity, **params)
            rig.step(seconds=0.2)
            camera.snapshot(PICTURES / f"{kind}.jpg")
            rig.fault.clear("desk")
        for kind, severity, params in STRIPS:
            if kind in wanted:
                keep(kind, strip(rig, camera, kind, severity, params))
        for way, kind, severity, params in PROGRAM_STRIPS:
            if kind in wanted:
                keep(kind, program_strip(rig, camera, way, kind, severity, params))
    return 0


if __name__ == "__main__":
    sys.exit(main())
