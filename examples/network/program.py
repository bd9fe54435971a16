"""One node as an ordinary program: opens its own video source, hears its own subject, and knows nothing else of rig or world.

    python -m examples.network.program PLAN.json NAME --source /dev/video20|rtsp://... --bus nats://127.0.0.1:4222 --out FOLDER [--beat]

A camera writes what it sees to FOLDER/NAME.seen.jsonl and what it owns to FOLDER/NAME.log.jsonl. With --beat the conductor says when which phase of a step begins; without, a
step begins with each picture that is there, answers go out when messages come, and an auction ends with the next picture.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import threading
from pathlib import Path
from typing import Any, NamedTuple, TextIO

os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", "rtsp_transport;tcp|fflags;nobuffer|flags;low_delay|threads;1")  # no picture waits
import cv2  # noqa: E402  (reads the line above when it is loaded)
import numpy as np  # noqa: E402

from camrig.code_strip import read_code  # noqa: E402

from .bus import Bus  # noqa: E402
from .messages import Link  # noqa: E402
from .node import run_phase  # noqa: E402
from .nodes import Plan, make_node  # noqa: E402
from .perception import Eye  # noqa: E402
from .replay import log_line  # noqa: E402
from .sighting import Sighting, line, read_line  # noqa: E402


UNREADABLE = 100  # pictures without a time, one after the other: this is no camera with a code strip


Angles = tuple[float, float, float]  # pan to the left and tilt up in degrees from rest, zoom


class Picture(NamedTuple):
    time_ns: int
    image: np.ndarray
    angles: Angles | None  # of a head: where it believed to look when the picture came


class Source:
    """A camera's pictures. What time they show stands in them, as on any recorder's: the code strip."""

    def __init__(self, source: str, size: list[int], is_head: bool) -> None:
        self._is_head = is_head
        self._is_device = source.startswith("/dev/")
        self._capture = cv2.VideoCapture(source, cv2.CAP_V4L2 if self._is_device else cv2.CAP_FFMPEG)
        if self._is_device:
            self._capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*"BGR3"))
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
        if not self._capture.isOpened():
            raise SystemExit(f"{source}: OpenCV cannot open it" + ("; /dev/videoN of a rig is there below `camrig exec --`" if self._is_device else ""))

    def read(self) -> Picture | None:
        """The next that tells its time (damaged ones may not); None at the end."""
        for _ in range(UNREADABLE):
            good, image = self._capture.read()
            if not good:
                break
            if (code := read_code(image)) is not None:
                return Picture(code.time_ns, image, self._angles() if self._is_head else None)
        return None

    def until(self, time_ns: int) -> Picture:
        """The picture of that time: those before it are passed over."""
        while (read := self.read()) is not None:
            if read.time_ns == time_ns:
                return read
            if read.time_ns > time_ns:
                break
        raise SystemExit(f"no picture of {time_ns} ns came")

    def _angles(self) -> Angles:
        return -self._capture.get(cv2.CAP_PROP_PAN) / 3600, self._capture.get(cv2.CAP_PROP_TILT) / 3600, self._capture.get(cv2.CAP_PROP_ZOOM) / 100

    def turn(self, pan_deg: float, tilt_deg: float, zoom: float) -> None:
        """By the device's own V4L2 controls, in arc seconds, right and up."""
        self._capture.set(cv2.CAP_PROP_PAN, -round(pan_deg * 3600))
        self._capture.set(cv2.CAP_PROP_TILT, round(tilt_deg * 3600))
        self._capture.set(cv2.CAP_PROP_ZOOM, round(min(max(zoom, 1.0), 10.0) * 100))


class Newest(threading.Thread):
    """Reads all pictures and keeps the newest, so that none is old when there is time for it."""

    def __init__(self, source: Source) -> None:
        super().__init__(daemon=True)
        self._source, self._newest, self._new, self.done = source, None, threading.Condition(), False
        self.start()

    def run(self) -> None:
        while (read := self._source.read()) is not None:
            with self._new:
                self._newest = read
                self._new.notify()
        with self._new:
            self.done = True
            self._new.notify()

    def take(self, timeout_s: float) -> Picture | None:
        with self._new:
            self._new.wait_for(lambda: self._newest is not None or self.done, timeout_s)
            newest, self._newest = self._newest, None
            return newest


class Program:
    def __init__(self, plan: Plan, name: str, source: Source | None, folder: Path) -> None:
        self._plan, self.name = plan, name
        self.node, self.link = make_node(plan, name), Link(plan.loss, plan.seed)
        self.source = source
        self._calibration: dict[str, Any] = plan.heads.get(name) or plan.cameras.get(name) or {}
        self._is_head = name in plan.heads
        self._eye = Eye(self._calibration, self._is_head) if self._calibration else None
        self._aim: Any = None
        self._seen, self._log = (folder / f"{name}.seen.jsonl").open("w"), (folder / f"{name}.log.jsonl").open("w")

    def look(self, picture: Picture) -> list[Sighting]:
        """What is kept is what is used: rounded, so that a replay sees the same."""
        if picture.angles is not None:
            self._eye.turn(_turned(self._calibration, *picture.angles))
        text = line(picture.time_ns, self._eye(picture.image))
        _write(self._seen, text)
        return read_line(text)[1]

    def log(self, now_ns: int, told: dict[str, Any]) -> None:
        _write(self._log, json.dumps(log_line(now_ns, told, self.link), separators=(",", ":")))
        if self._is_head and (aim := getattr(self.node, "aim", None)) != self._aim:
            self._aim = aim
            self.source.turn(*(aim or (0.0, 0.0, 1.0)))


def _turned(calibration: dict[str, Any], pan_deg: float, tilt_deg: float, zoom: float) -> dict[str, Any]:
    """Calibration of a camera whose level head has turned."""
    pose, k = calibration["pose"], calibration["intrinsics"]
    half_pan, half_tilt = np.radians(pose["pan_deg"] + pan_deg) / 2, -np.radians(pose["tilt_deg"] + tilt_deg) / 2
    (sz, cz), (sy, cy) = ((np.sin(a), np.cos(a)) for a in (half_pan, half_tilt))
    return {**calibration, "shown_intrinsics": {**k, "fx": k["fx"] * zoom, "fy": k["fy"] * zoom},
            "world_pose": {"position": pose["position"], "orientation": [-sz * sy, cz * sy, sz * cy, cz * cy]}}


def _write(file: TextIO, text: str) -> None:
    file.write(text + "\n")
    file.flush()


async def in_lockstep(program: Program, bus: Bus) -> None:
    """The conductor says which phase begins, and how many messages of the one before are on their way to this node."""
    await bus.tell("beat.ready", name=program.name)
    sightings: list[Sighting] = []
    while (beat := await bus.beat())["phase"] != "end":
        if beat["phase"] == "begin":
            sightings = program.look(program.source.until(beat["t"])) if program.source else []
        out, told = run_phase(program.node, beat["phase"], await bus.take(beat["expect"].get(program.name, 0)), beat["t"], sightings)
        out = program.link.passes(out)
        await bus.send(out)
        if told is not None:
            program.log(beat["t"], told)
        counts: dict[str, int] = {}
        for message in out:
            counts[message.to] = counts.get(message.to, 0) + 1
        await bus.tell("beat.done", name=program.name, phase=beat["phase"], t=beat["t"], sent=counts)


async def in_real_time(program: Program, bus: Bus) -> None:
    """Whatever comes is answered at once; what has not come when the next picture is looked at is late."""
    newest = Newest(program.source) if program.source else None
    now_ns, period_s = 0, program._plan.period_s
    ticks = asyncio.get_running_loop().time()
    await bus.tell("beat.ready", name=program.name)
    while not (newest and newest.done):
        picture = None
        if newest is not None:
            picture = await asyncio.to_thread(newest.take, 0.02)
            begins = picture is not None and picture.time_ns > now_ns  # a stream may repeat a picture
        else:  # the centre has no camera: it settles once a period
            await asyncio.sleep(0.01)
            if begins := asyncio.get_running_loop().time() >= ticks + period_s:
                ticks += period_s
        inbox = await bus.take()
        now_ns = max([now_ns, *(message.time_ns for message in inbox)]) if newest is None else now_ns
        out = program.node.receive(inbox)
        if begins:
            out += program.node.settle()
            if now_ns:
                program.log(now_ns, program.node.finish())
            now_ns = picture.time_ns if picture else now_ns
            out += program.node.begin(now_ns, await asyncio.to_thread(program.look, picture) if picture else [])
        await bus.send(program.link.passes(out))


async def main(options: argparse.Namespace) -> None:
    plan = Plan(**json.loads(options.plan.read_text()))
    camera = plan.heads.get(options.name) or plan.cameras.get(options.name)
    program = Program(plan, options.name, Source(options.source, camera["size"], options.name in plan.heads) if camera else None, options.out)
    bus = await Bus.connect(options.bus, options.name, ("beat.go",) if options.beat else ())
    try:
        await (in_lockstep if options.beat else in_real_time)(program, bus)
    except TimeoutError:
        raise SystemExit("the conductor is silent") from None
    finally:
        await bus.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m examples.network.program", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", type=Path)
    parser.add_argument("name", help="of this node in the plan")
    parser.add_argument("--source", help="its camera: /dev/videoN or rtsp://...")
    parser.add_argument("--bus", required=True, help="nats://HOST:PORT")
    parser.add_argument("--out", type=Path, required=True, help="folder for what it sees and owns")
    parser.add_argument("--beat", action="store_true", help="lockstep")
    asyncio.run(main(parser.parse_args()))
