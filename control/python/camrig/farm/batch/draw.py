"""Draws one shard: `python -m camrig.farm.batch.draw`, with a Job as a line on stdin and what came of it as a line on stdout.

In a process of its own, with a camrig of its own: what leaks or falls takes one shard with it. It ends when its stdin does, and camrig with it, so that
nobody goes on who is not waited for, however the one that waits has ended.
"""

from __future__ import annotations

import errno
import json
import math
import os
import sys
import threading
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

from ... import launch
from ...errors import CamrigError
from ...places import find_binary
from ...rig import Rig
from .hashing import file_hash
from .pointer import PointerError
from .scene_file import read_scene, scene_hash, varied, write_varied
from .scratch import scratch
from .shard import Shard
from .shard_file import pack
from .store import Differs, Store

_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_START_TIMEOUT_S = 300.0
#: The most that one world.step takes.
_MAX_STEP_NS = 86_400_000_000_000
#: Killed with the process that starts it: the kernel's word for that is lost if the parent was gone before, so that is looked at afterwards.
_ENDS_WITH_PARENT = ("setpriv", "--pdeathsig", "KILL", "sh", "-c", '[ "$PPID" = "$0" ] && exec "$@"')


@dataclass(frozen=True)
class Job:
    """`compares`: the shard is there; it is drawn again to see that it comes out the same."""

    shard: Shard
    folder: str
    compares: bool
    timeout_s: float

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def from_json(told: dict[str, Any]) -> Job:
        return Job(**{**told, "shard": Shard.from_json(told["shard"])})


def draw(job: Job) -> dict[str, Any]:
    """Draws the shard and puts it into the set; gives what the manifest says of it."""
    shard, store = job.shard, Store(job.folder)
    if not job.compares and (there := store.told(shard.id)) is not None:
        return there
    made = varied(read_scene(shard.scene), shard.cameras, shard.changes)
    _check_here(shard, made)
    with scratch() as folder:
        scene = write_varied(shard.scene, made, folder / "scene")
        about = _record(shard, scene, folder / "set", job.timeout_s)
        names = [camera["name"] for camera in made["cameras"]]

        def write(file: BinaryIO) -> dict[str, Any]:
            return {**about, **pack(shard.id, folder / "set", names, ".png" if shard.pictures.format == "png" else ".jpg", file)}

        return store.compare(shard.id, write) if job.compares else store.publish(shard.id, write)


def _check_here(shard: Shard, made: dict[str, Any]) -> None:
    """That this machine would draw what the plan was made for."""
    if (program := file_hash(find_binary())) != shard.program_hash:
        raise _Other(f"{os.uname().nodename}: {find_binary()} is another build of camrig ({program[:12]}) than that of the plan ({shard.program_hash[:12]})")
    if scene_hash(shard.scene, made) != shard.scene_hash:
        raise _Other(f"{os.uname().nodename}: scene {shard.scene} or a file of it differs from that of the plan")


class _Other(Exception):
    """This machine, and not the shard, is wrong."""


def _record(shard: Shard, scene: Path, to: Path, timeout_s: float) -> dict[str, Any]:
    with launch.start(scene, mode="lockstep", seed=shard.seed, quality=shard.quality, device=shard.device, timeout=_START_TIMEOUT_S,
                      runner=(*_ENDS_WITH_PARENT, str(os.getpid()))) as rig:
        for fault in shard.faults:
            rig.call("fault.set", **fault)
        _go_to(rig, shard.start_ns, timeout_s)
        before = rig.status()["state_hash"]
        pictures = shard.pictures
        rig.record(to, seconds=_seconds(shard.end_ns - shard.start_ns), format=pictures.format, depth=pictures.depth, flow=pictures.flow, masks=pictures.masks,
                   soiling=pictures.soiling, yolo=pictures.yolo, timeout=timeout_s)
        # The world's state at a shard's end is the one that the next shard of the same world begins with.
        _go_to(rig, shard.end_ns, timeout_s)
        told = shard.to_json()
        return {"shard": shard.id, "state_hash": [before, rig.status()["state_hash"]],
                **{key: told[key] for key in ("scene_hash", "program_hash", "seed", "start_ns", "end_ns", "changes", "faults", "quality", "device", "pictures")}}


def _go_to(rig: Rig, world_ns: int, timeout_s: float) -> None:
    """Moves the world to that time, if it is not there already; each step may take `timeout_s`."""
    now_ns = rig.status()["world_ns"]
    while now_ns < world_ns:
        step_ns = min(world_ns - now_ns, _MAX_STEP_NS)
        rig.step(nanoseconds=step_ns, timeout=timeout_s)
        now_ns += step_ns


def _seconds(nanoseconds: int) -> float:
    """The number that `camrig record --seconds` takes for exactly these: it multiplies by 1e9 and cuts off."""
    seconds = nanoseconds / 1e9
    while int(seconds * 1e9) < nanoseconds:
        seconds = math.nextafter(seconds, math.inf)
    return seconds


def answer(line: str) -> dict[str, Any]:
    """What came of a job: `told`, or `error` with its kind: disk (full), machine (is another), differs, shard."""
    try:
        return {"told": draw(Job.from_json(json.loads(line)))}
    except Differs as problem:
        kind, text = "differs", problem.message
    except _Other as problem:
        kind, text = "machine", str(problem)
    except OSError as problem:
        kind, text = "disk" if problem.errno in _DISK else "shard", str(problem)
    except (CamrigError, PointerError) as problem:
        text = str(problem)
        kind = "disk" if any(os.strerror(number) in text for number in _DISK) else "shard"
    return {"error": {"kind": kind, "text": " ".join(text.split())[-2000:]}}


def _end_with_stdin() -> None:
    while os.read(0, 4096):
        pass
    os._exit(1)


def main() -> int:
    line = b""
    while not line.endswith(b"\n"):
        if not (chunk := os.read(0, 1 << 16)):
            return 1
        line += chunk
    threading.Thread(target=_end_with_stdin, daemon=True).start()
    # What anything prints goes to stderr: stdout has the answer alone.
    out = os.dup(1)
    os.dup2(2, 1)
    with open(out, "w", encoding="utf-8") as answered:
        answered.write(json.dumps(answer(line.decode())) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
