"""`camrig ros2 files DIR` and `camrig ros2 record OUT`."""

from __future__ import annotations

import argparse
import json
import re
import signal
import sys
import time
from pathlib import Path
from typing import Any, Callable, Sequence

from ..command_line import Parser, connect_as_told, rig_options, run
from .camera_state import WORLD_FRAME


def main(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    return options.command(options)


def _parser() -> Parser:
    common = rig_options()
    parser = Parser(prog="camrig ros2", description="ROS 2 without a node; see docs/ros2.md", parents=[common])
    commands = parser.add_subparsers(required=True, metavar="files|record")

    files = commands.add_parser("files", parents=[common], help="calibrations, parameters and launch files for usb_cam, v4l2_camera and gscam2")
    files.add_argument("directory", metavar="DIR", type=Path)
    files.add_argument("--force", action="store_true", help="replace files that are there with other content")
    files.set_defaults(command=_files)

    record = commands.add_parser("record", parents=[common], help="writes a rosbag2 bag (MCAP)")
    record.add_argument("out", metavar="OUT", type=Path, help="the bag: a directory to be made")
    record.add_argument("--seconds", type=_positive(float), help="of world time; in lockstep the world is stepped by as much")
    record.add_argument("--follow", action="store_true", help="in lockstep: do not step, record while somebody else does")
    record.add_argument("--clock", choices=("world", "wall"), default="world", help="what stamps count: world time from 0 (default), or the time of day")
    record.add_argument("--raw", action="store_true", help="exact sensor_msgs/Image instead of JPEG (lockstep)")
    record.add_argument("--detections", action="store_true", help="vision_msgs/Detection2DArray from the ground truth (lockstep)")
    record.add_argument("--quality", type=_quality, default=90, help="of JPEG, 1 to 100 (default 90)")
    record.add_argument("--split-seconds", type=_positive(float), default=0.0, help="a new file after so much time")
    record.add_argument("--split-size", type=_size, default=0, help="a new file after so many bytes: 500M, 2G")
    record.set_defaults(command=_record)

    for command in (files, record):
        command.add_argument("--cameras", type=_names, default=(), metavar="A,B", help="these only")
        command.add_argument("--world-frame", default=WORLD_FRAME, type=_frame, help=f"name of the world's frame (default {WORLD_FRAME})")
    return parser


def _files(options: argparse.Namespace) -> int:
    from .files import make_files, write_files

    with connect_as_told(options) as rig:
        files = make_files(rig, options.cameras, options.world_frame)
    outcome = write_files(options.directory, files, options.force)
    if getattr(options, "json", False):
        print(json.dumps({"directory": str(options.directory), "files": outcome, "drivers": files.drivers, "notes": files.notes}))
        return 0
    for path, what in outcome.items():
        print(f"{what:9}  {options.directory / path}")
    for camera, drivers in files.drivers.items():
        print(f"camera {camera}: {', '.join(drivers)}")
    for note in files.notes:
        print(f"note: {note}")
    return 0


def _record(options: argparse.Namespace) -> int:
    from .record import BagOptions, RecordOptions, Recorder

    as_json = getattr(options, "json", False)
    bag = BagOptions(split_bytes=options.split_size, split_ns=round(options.split_seconds * 1e9))
    wanted = RecordOptions(
        out=options.out,
        cameras=options.cameras,
        seconds=options.seconds,
        follow=options.follow,
        clock=options.clock,
        raw=options.raw,
        detections=options.detections,
        quality=options.quality,
        world_frame=options.world_frame,
        bag=bag,
    )
    with connect_as_told(options) as rig:
        line = _ProgressLine(options.seconds, quiet=as_json)
        recorder = Recorder(rig, wanted, line.show)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: recorder.stop())
        try:
            progress = recorder.run()
        finally:
            line.end()
    summary = {
        "bag": str(options.out),
        "world_ns": progress.world_ns,
        "frames": dict(progress.frames),
        "missing": {camera: progress.missing[camera] for camera in progress.frames},
        "messages": recorder.messages,
        "bytes": progress.bytes,
    }
    print(json.dumps(summary) if as_json else _words(progress) + f": {options.out}")
    return 0


def _words(progress: Any) -> str:
    frames, missing = sum(progress.frames.values()), sum(progress.missing.values())
    return f"{frames} frames of {len(progress.frames)} cameras, {missing} missing, {progress.bytes / 1e6:.1f} MB"


class _ProgressLine:
    """One line that is written again: ten times a second on a terminal, else every ten seconds."""

    def __init__(self, seconds: float | None, quiet: bool) -> None:
        self._seconds, self._quiet, self._terminal = seconds, quiet, sys.stderr.isatty()
        self._start_ns: int | None = None
        self._shown_at = time.monotonic()
        self._open_line = False

    def show(self, progress: Any) -> None:
        if self._start_ns is None:
            self._start_ns = progress.world_ns
        now = time.monotonic()
        if self._quiet or now - self._shown_at < (0.1 if self._terminal else 10.0):
            return
        self._shown_at = now
        done = f"{(progress.world_ns - self._start_ns) / 1e9:.1f}" + (f" of {self._seconds:g} s" if self._seconds else " s")
        text = f"{done}, {_words(progress)}"
        print(f"\r{text}\x1b[K" if self._terminal else text, end="" if self._terminal else "\n", file=sys.stderr, flush=True)
        self._open_line = self._terminal

    def end(self) -> None:
        if self._open_line:
            print(file=sys.stderr)


def _names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise argparse.ArgumentTypeError("takes names with commas between: left,right")
    return names


def _frame(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_/]*", text):
        raise argparse.ArgumentTypeError("takes a frame name of tf2: letters, digits, _ and /, no leading /")
    return text


def _positive(kind: Callable[[str], float]) -> Callable[[str], float]:
    def parse(text: str) -> float:
        value = kind(text)
        if not 0 < value < 1e9:
            raise argparse.ArgumentTypeError(f"'{text}' is not a positive number")
        return value

    parse.__name__ = "number"
    return parse


def _quality(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= 100:
        raise argparse.ArgumentTypeError("takes 1 to 100")
    return int(text)


def _size(text: str) -> int:
    match = re.fullmatch(r"(\d+)([kMG]?)", text)
    if not match or int(match[1]) == 0:
        raise argparse.ArgumentTypeError("takes a number of bytes, or 500M, 2G")
    return int(match[1]) * {"": 1, "k": 10**3, "M": 10**6, "G": 10**9}[match[2]]


if __name__ == "__main__":
    sys.exit(run(main))
