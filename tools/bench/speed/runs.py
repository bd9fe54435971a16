"""The runs: each starts a rig of its own on the hall, does one thing, and gives one row of numbers."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import camrig

from .meter import Meter, Reading, percentile
from .readers import MjpegReaders, Stream

HALL = "scenes/hall.json"
PLACES = ("lobby", "entrance", "benches", "desk", "stairs", "gallery", "cafe", "overhead")
WARM_UP_S = 3.0


@contextlib.contextmanager
def rig_with(cameras: int, size: tuple[int, int], fps: float, *, mode: str = "realtime", quality: str = "simple",
             overload: str = "drop", args: tuple[str, ...] = ()) -> Iterator[tuple[camrig.Rig, list[str]]]:
    """The hall with exactly these cameras, one after the other at its eight places."""
    with camrig.start(HALL, mode=mode, device="cpu", quality=quality, overload=overload, args=args) as rig:
        for camera in rig.call("camera.list")["cameras"]:
            rig.call("camera.delete", name=camera["name"])
        names = [f"c{i}" for i in range(cameras)]
        for i, name in enumerate(names):
            rig.create_camera(name, place=PLACES[i % len(PLACES)], size=size, fps=fps)
        yield rig, names


@dataclass
class Realtime:
    """A rig in real time with one MJPEG reader per camera."""

    reading: Reading
    streams: list[Stream]
    wakeup: dict = field(default_factory=dict)

    @property
    def per_second(self) -> float:
        return sum(s.pictures for s in self.streams) / self.reading.wall_s

    @property
    def dropped_share(self) -> float:
        return self.reading.dropped / self.reading.due if self.reading.due else float("nan")

    @property
    def unreported(self) -> int:
        """Frames that a reader never got and nobody counted as dropped; the books say 0, up to those on their way."""
        return self.reading.due - self.reading.rendered - self.reading.dropped

    def latency_ms(self, share: float) -> float:
        return percentile([ms for s in self.streams for ms in s.latencies_ms], share)


def realtime(cameras: int, size: tuple[int, int], fps: float, seconds: float, *, readers: bool = True, quality: str = "simple",
             overload: str = "drop", args: tuple[str, ...] = ()) -> Realtime:
    with rig_with(cameras, size, fps, quality=quality, overload=overload, args=args) as (rig, names):
        with MjpegReaders(rig.call("server.info")["http"], names if readers else []) as streams:
            time.sleep(WARM_UP_S)
            meter = Meter(rig)
            streams.reset()
            time.sleep(seconds)
            reading = meter.read()
            return Realtime(reading, streams.close(), reading.stages.get("wakeup", {}))


@dataclass
class Lockstep:
    """A rig stepped as fast as it goes, pictures delivered to one MJPEG reader per camera."""

    reading: Reading
    pictures: int

    @property
    def per_second(self) -> float:
        return self.pictures / self.reading.wall_s

    @property
    def cpu_ms(self) -> float:
        return 1000 * self.reading.cpu_s / self.pictures if self.pictures else float("nan")


def lockstep(cameras: int, size: tuple[int, int], steps: int, *, moving: bool = False, quality: str = "simple",
             args: tuple[str, ...] = ()) -> Lockstep:
    """`steps` instants of 1/25 s; `moving`: every camera is turned a little before each, so that nothing can be kept."""
    with rig_with(cameras, size, 25, mode="lockstep", quality=quality, args=args) as (rig, names):
        poses = {name: rig.call("camera.get", name=name)["pose"] for name in names}
        with MjpegReaders(rig.call("server.info")["http"], names) as streams:
            _wait_for_readers(rig, cameras)
            rig.step(seconds=0.4)
            meter = Meter(rig)
            if not moving:
                rig.call("world.step", seconds=steps / 25)
            for n in range(steps if moving else 0):
                for name in names:
                    pose = poses[name]
                    rig.call("camera.set", name=name, pose={"position": pose["position"], "pan_deg": pose["pan_deg"] + 0.05 * (n % 40),
                                                            "tilt_deg": pose["tilt_deg"], "roll_deg": pose["roll_deg"]})
                rig.call("world.step", seconds=1 / 25)
            reading = meter.read()
            streams.close()
            return Lockstep(reading, reading.rendered)


def _wait_for_readers(rig: camrig.Rig, count: int) -> None:
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        if sum(camera["readers"] for camera in rig.call("camera.list")["cameras"]) >= count:
            return
        time.sleep(0.05)
    raise RuntimeError(f"{count} readers did not come")
