"""The runs: each starts a rig of its own on the hall, does one thing, and gives one row of numbers."""

from __future__ import annotations

import contextlib
import json
import math
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import camrig

from .meter import Meter, Reading, percentile
from .readers import MjpegReaders, Stream

HALL = "scenes/hall.json"
PLACES = ("lobby", "entrance", "benches", "desk", "stairs", "gallery", "cafe", "overhead")
WARM_UP_S = 3.0


@contextlib.contextmanager
def rig_with(cameras: int, size: tuple[int, int], fps: float, *, mode: str = "realtime", quality: str = "simple", antialias: str = "auto",
             overload: str = "drop", scene: str = HALL, devices: bool = False, args: tuple[str, ...] = ()) -> Iterator[tuple[camrig.Rig, list[str]]]:
    """The hall with exactly these cameras, one after the other at its eight places (or a scene that has places of these names);
    `devices`: each is the user-space device of its number too, from 0."""
    names = [f"c{i}" for i in range(cameras)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "these_cameras.json"
        text = json.loads(Path(scene).read_text())
        # A scene's files lie below its own folder.
        for entry in Path(scene).resolve().parent.iterdir():
            (Path(folder) / entry.name).symlink_to(entry)
        # Cameras of the scene are drawn once before the clock runs: what is measured is not the making of shaders.
        text["cameras"] = []
        for i, name in enumerate(names):
            outputs = [{"kind": "device", "number": i}] if devices else []
            text["cameras"].append({"name": name, "place": PLACES[i % len(PLACES)], "size": list(size), "fps": fps, "antialias": antialias, "outputs": outputs})
        file.write_text(json.dumps(text))
        with camrig.start(file, mode=mode, device="cpu", quality=quality, overload=overload, args=args) as rig:
            yield rig, names


def unreported(streams: list[Stream], reading: Reading) -> int:
    """Frames that a reader never got and nobody counted as dropped; less than 0: counted as dropped, though it got them."""
    return sum(stream.gaps for stream in streams) - reading.dropped - reading.dropped_by_readers


@dataclass
class Realtime:
    """A rig in real time with one MJPEG reader per camera."""

    reading: Reading
    streams: list[Stream]
    fps: float
    wakeup: dict = field(default_factory=dict)

    @property
    def per_second(self) -> float:
        return sum(s.pictures for s in self.streams) / self.reading.wall_s

    @property
    def cpu_ms(self) -> float:
        return 1000 * self.reading.cpu_s / self.reading.rendered if self.reading.rendered else float("nan")

    @property
    def dropped_share(self) -> float:
        """Of the frames that were due by the clock."""
        due = len(self.streams) * self.fps * self.reading.wall_s
        return self.reading.dropped / due if due else float("nan")

    @property
    def unreported(self) -> int:
        return unreported(self.streams, self.reading)

    def latency_ms(self, share: float) -> float:
        return percentile([ms for s in self.streams for ms in s.latencies_ms], share)


def realtime(cameras: int, size: tuple[int, int], fps: float, seconds: float, *, readers: bool = True, quality: str = "simple",
             antialias: str = "auto", overload: str = "drop", args: tuple[str, ...] = ()) -> Realtime:
    with rig_with(cameras, size, fps, quality=quality, antialias=antialias, overload=overload, args=args) as (rig, names):
        with MjpegReaders(rig.call("server.info")["http"], names if readers else []) as streams:
            time.sleep(WARM_UP_S)
            streams.reset()
            meter = Meter(rig)
            time.sleep(seconds)
            reading = meter.read()
            if readers:
                streams.close_books(meter.sequences, reading.sequences)
            return Realtime(reading, streams.close(), fps, reading.stages.get("wakeup", {}))


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
             scene: str = HALL, prepare: Callable[[camrig.Rig], None] | None = None, args: tuple[str, ...] = ()) -> Lockstep:
    """`steps` instants of 1/25 s; `moving`: every camera is turned a little before each, so that nothing can be kept."""
    with rig_with(cameras, size, 25, mode="lockstep", quality=quality, scene=scene, args=args) as (rig, names):
        if prepare is not None:
            prepare(rig)
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


def all_kinds(steps: int) -> Lockstep:
    """Colour, depth, ids and truth of one camera in each of `steps` instants, as a Python program takes them; a picture is all four."""
    with rig_with(1, (640, 480), 25, mode="lockstep") as (rig, names):
        cam = rig.camera(names[0])

        def take(count: int) -> None:
            for _ in range(count):
                rig.step(seconds=1 / 25)
                cam.frame(), cam.depth(), cam.instances(), cam.truth()

        take(10)
        meter = Meter(rig)
        take(steps)
        return Lockstep(meter.read(), steps)


def _wait_for_readers(rig: camrig.Rig, count: int) -> None:
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        if sum(camera["readers"] for camera in rig.call("camera.list")["cameras"]) >= count:
            return
        time.sleep(0.05)
    raise RuntimeError(f"{count} readers did not come")


def crowd(count: int) -> Callable[[camrig.Rig], None]:
    """So many people more, standing in rows where the camera `lobby` looks."""

    def prepare(rig: camrig.Rig) -> None:
        for i in range(count):
            rig.spawn_actor(f"more{i}", f"person_{1 + i % 11}", object_class="person", position=[10 + 1.2 * (i % 8), 5 + 1.2 * (i // 8), 0])

    return prepare


@contextlib.contextmanager
def mesh_scene(triangles: int) -> Iterator[str]:
    """A scene of one wavy sheet of about so many triangles, 40 m wide, in front of its one place."""
    side = max(1, round(math.sqrt(triangles / 2)))
    positions = b"".join(struct.pack("<3f", 40 * x / side - 20, 40 * y / side - 20, 0.5 * math.sin(x) * math.sin(y)) for y in range(side + 1) for x in range(side + 1))
    indices = bytearray()
    for y in range(side):
        for x in range(side):
            a, b = y * (side + 1) + x, (y + 1) * (side + 1) + x
            indices += struct.pack("<6I", a, a + 1, b, a + 1, b + 1, b)
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "extensionsUsed": ["KHR_materials_unlit"],
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0.3, 0.5, 0.7, 1]}, "extensions": {"KHR_materials_unlit": {}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": (side + 1) ** 2, "type": "VEC3", "min": [-20, -20, -0.5], "max": [20, 20, 0.5]},
                      {"bufferView": 1, "componentType": 5125, "count": 6 * side * side, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
    }
    with tempfile.TemporaryDirectory() as folder:
        text, data = json.dumps(gltf).encode(), positions + bytes(indices)
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
        (Path(folder) / "sheet.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        # glTF is y up: its sheet stands upright here, across the view of the place.
        scene = {"camrig_scene": 1, "name": "sheet", "models": {"sheet": {"file": "sheet.glb"}}, "objects": [{"name": "sheet", "model": "sheet", "class": "sheet"}],
                 "places": {PLACES[0]: {"vfov_deg": 60, "pose": {"position": [0, -24, 0], "look_at": [0, 0, 0]}}}}
        file = Path(folder) / "sheet.json"
        file.write_text(json.dumps(scene))
        yield str(file)


# How an output is read, by its name in the page: commands for one camera, {i} its number, {port} of RTSP; None: MJPEG over HTTP.
READERS: dict[str, list[str] | str] = {
    "MJPEG over HTTP": "mjpeg",
    "H.264 over RTSP": ["ffmpeg", "-v", "error", "-rtsp_transport", "tcp", "-i", "rtsp://127.0.0.1:{port}/c{i}", "-c", "copy", "-f", "null", "-"],
    "YUYV, user-space device": ["{camrig}", "--control", "{control}", "exec", "--", "v4l2-ctl", "-d", "/dev/video{i}", "--set-fmt-video=pixelformat=YUYV", "--stream-mmap", "--stream-count=0"],
    "I420, user-space device": ["{camrig}", "--control", "{control}", "exec", "--", "v4l2-ctl", "-d", "/dev/video{i}", "--set-fmt-video=pixelformat=YU12", "--stream-mmap", "--stream-count=0"],
    "BGR, user-space device": ["{camrig}", "--control", "{control}", "exec", "--", "v4l2-ctl", "-d", "/dev/video{i}", "--set-fmt-video=pixelformat=BGR3", "--stream-mmap", "--stream-count=0"],
}


@contextlib.contextmanager
def read_by(reader: list[str] | str | None, rig: camrig.Rig, names: list[str]) -> Iterator[None]:
    """One client per camera, until the end."""
    info = rig.call("server.info")
    if reader is None:
        yield
    elif isinstance(reader, str):
        with MjpegReaders(info["http"], names):
            yield
    else:
        values = {"port": info["rtsp"], "control": info["control"], "camrig": camrig.find_binary()}
        clients = [subprocess.Popen([part.format(i=i, **values) for part in reader], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for i in range(len(names))]
        try:
            yield
            if any(client.poll() is not None for client in clients):
                raise RuntimeError(f"a reader ended early: {' '.join(reader)}")
        finally:
            for client in clients:
                client.kill()
                client.wait()
