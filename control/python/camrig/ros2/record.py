"""Records cameras of a rig into a rosbag2 bag, without ROS."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Mapping

import numpy as np

from ..camera import Camera
from ..errors import CamrigError, CamrigTimeout
from ..rig import Rig
from . import messages
from .bag import Bag, BagOptions, Topic
from .camera_state import CameraState, StateHistory
from .inbox import Inbox
from .mjpeg import Frame, StreamReader

_FRAME_TIMEOUT_S = 30.0
_POLL_S = 0.1
#: Frames are taken and cameras asked for at most so often.
_BATCH_S = 0.02
#: World time after the end at which frames that are still missing are taken for dropped.
_GRACE_NS = 2 * 10**9


@dataclass(frozen=True)
class RecordOptions:
    out: Path
    cameras: tuple[str, ...] = ()  # none: all
    seconds: float | None = None  # of world time; None: until stopped
    follow: bool = False  # in lockstep: somebody else steps the world
    clock: str = "world"  # or "wall": of header.stamp and log time
    raw: bool = False
    detections: bool = False
    quality: int = 90
    world_frame: str = messages.WORLD_FRAME
    bag: BagOptions = field(default_factory=BagOptions)


@dataclass
class Progress:
    """What there is to say of a recording, while it runs and in the end."""

    world_ns: int
    frames: Counter[str] = field(default_factory=Counter)
    missing: Counter[str] = field(default_factory=Counter)
    bytes: int = 0


class Recorder:
    """One recording. Not for several threads, but stop() may come from any, and from signal handlers."""

    def __init__(self, rig: Rig, options: RecordOptions, report: Callable[[Progress], None] = lambda progress: None) -> None:
        self._rig, self._options, self._report = rig, options, report
        self._stopping = False
        status = rig.status()
        self._lockstep = status["mode"] == "lockstep"
        self._drives = self._lockstep and not options.follow
        self._check_options()
        self._choose()
        self._inbox = Inbox()
        self._readers: dict[str, StreamReader] = {}
        self._ended: set[str] = set()
        self._last: dict[str, tuple[int, int]] = {}  # sequence and world time of the last frame
        self._wall_offset_ns = _wall_offset_ns()
        self.progress = Progress(world_ns=status["world_ns"], frames=Counter(dict.fromkeys(self._cameras, 0)))
        self._start_ns = status["world_ns"]
        self._end_ns = None if options.seconds is None else self._start_ns + round(options.seconds * 1e9)
        self._bag = Bag(options.out, self._topics(), options.bag, self._opening)

    def stop(self) -> None:
        """Ends the recording after the instant in work."""
        self._stopping = True

    @property
    def messages(self) -> int:
        return self._bag.messages

    def run(self) -> Progress:
        try:
            self._open_readers()
            if self._drives:
                self._drive()
            else:
                self._follow()
        except CamrigError:
            with contextlib.suppress(CamrigError):  # a picture that cannot be had may be one of a world that is gone
                self._poll()
            self._check_world()
            raise
        finally:
            for reader in self._readers.values():
                reader.close()
            self._bag.close()
            self.progress.bytes = self._bag.bytes
        return self.progress

    # What to record

    def _check_options(self) -> None:
        options = self._options
        if self._drives and options.seconds is None:
            raise CamrigError(
                "invalid_argument", "the rig is in lockstep: give --seconds to step it, or --follow to record while somebody else does"
            )
        for given, what in ((options.raw, "--raw"), (options.detections, "--detections")):
            if given and not self._drives:
                raise CamrigError("unsupported", f"{what} needs a rig in lockstep that the recorder steps (serve --mode lockstep, --seconds)")
        if options.detections and "truth.get" not in self._rig.info().get("methods", ["truth.get"]):
            raise CamrigError("unsupported", "--detections: this rig gives no ground truth (truth.get)")

    def _choose(self) -> None:
        replies = self._rig.call("camera.list")["cameras"]
        names = [reply["name"] for reply in replies]
        for name in self._options.cameras:
            if name not in names:
                raise CamrigError("not_found", f"no camera '{name}'; the rig has: {', '.join(sorted(names)) or 'none'}")
        if not names:
            raise CamrigError("not_found", "the rig has no camera; make one with: camrig camera create NAME")
        self._cameras = {name: StateHistory() for name in self._options.cameras or names}
        self._latest: dict[str, tuple[int, int]] = {}  # sequence and world time of what each shows
        self._world_is_gone = False
        self._poll(replies)

    def _poll(self, replies: list[dict[str, Any]] | None = None) -> None:
        """The cameras as they are now; one that is gone may come again."""
        replies = self._rig.call("camera.list")["cameras"] if replies is None else replies
        there = {reply["name"]: reply for reply in replies}
        self._active = [name for name in self._cameras if name in there]
        latest = {name: (there[name]["sequence"], there[name]["applied_ns"]) for name in self._active}
        if any(sequence > self._latest[name][0] and ns < self._latest[name][1] for name, (sequence, ns) in latest.items() if name in self._latest):
            self._world_is_gone = True
        if self._world_is_gone:  # frames that still come are of the cameras as they were
            return
        self._latest.update(latest)
        for name in self._active:
            self._cameras[name].add(latest[name][1], CameraState.of(there[name]))

    def _check_world(self) -> None:
        """In another world, time begins at 0; the sequence numbers of its cameras go on."""
        if self._world_is_gone:
            raise CamrigError("unavailable", "another world was loaded into the rig (world.load), and its time began at 0: the bag holds what came before") from None

    def _topics(self) -> list[Topic]:
        topics = [Topic("/tf_static", messages.TF, latched=True), Topic("/tf", messages.TF)]
        for name in self._cameras:
            topics.append(Topic(f"/{name}/camera_info", messages.CAMERA_INFO))
            topics.append(Topic(*self._image_topic(name)))
            if self._options.detections:
                topics.append(Topic(f"/{name}/detections", messages.DETECTIONS))
        return topics

    def _image_topic(self, camera: str) -> tuple[str, str]:
        if self._options.raw:
            return f"/{camera}/image_raw", messages.IMAGE
        return f"/{camera}/image_raw/compressed", messages.COMPRESSED_IMAGE

    def _opening(self, log_ns: int) -> list[tuple[str, bytes]]:
        return [("/tf_static", messages.optical_frames([history.now for history in self._cameras.values()], log_ns))]

    # Where frames come from

    def _open_readers(self) -> None:
        for name in self._without_reader():
            self._open_reader(name, self._start_ns)

    def _without_reader(self) -> list[str]:
        return [] if self._options.raw else [name for name in self._active if name not in self._readers]

    def _open_reader(self, name: str, after_ns: int) -> None:
        """Of what is shown later than that: a stream begins with the picture that is there."""
        url = Camera(self._rig, name).url("mjpeg", quality=self._options.quality)
        self._readers[name] = StreamReader(name, url, after_ns, self._inbox.put, self._inbox.stream_ended)

    def _renew_readers(self, after_ns: int) -> None:
        """A stream ends when its camera changes its size, is deleted, or the rig is gone."""
        ended, self._ended = self._ended | self._inbox.take_ended(), set()
        for name in ended:
            if reader := self._readers.pop(name, None):
                reader.close()
        if not self._without_reader():
            return
        self._poll()  # one that was deleted is not to be asked
        for name in self._without_reader():
            try:
                self._open_reader(name, after_ns)
            except CamrigError as problem:  # it went meanwhile, or a fault refuses readers: its frames are missing
                if problem.kind not in ("not_found", "unavailable"):
                    raise

    def _drive(self) -> None:
        """Steps the world from instant to instant: nothing is lost, and every pose is that of its instant."""
        assert self._end_ns is not None
        now_ns = self._start_ns
        while not self._stopping and now_ns < self._end_ns:
            self._renew_readers(now_ns)
            due_ns = min([self._end_ns, *(self._cameras[name].now.next_due_ns(now_ns) for name in self._active)])
            self._step(now_ns, due_ns)
            self._poll()
            self._check_world()
            # Who was refused until now may read from this instant on.
            self._renew_readers(now_ns)
            # A camera whose clock runs its own way shows nothing new in most steps; one that exposes for long leaves some out.
            read = self._active if self._options.raw else [name for name in self._active if name in self._readers]
            shown = {name: ns for name in read if (ns := self._cameras[name].latest_ns) > now_ns}
            for name in self._kept_back(shown):
                del shown[name]
            if self._options.raw:
                self._write_raw(shown)
            else:
                self._write(self._collect(shown))
            now_ns = due_ns
            self._tell(now_ns)
        self._write(self._inbox.take(0))
        self._count_the_rest()
        self._count_unseen(now_ns)

    def _kept_back(self, shown: Mapping[str, int]) -> list[str]:
        """Cameras whose picture of this instant a fault keeps from us; it is counted as missing when the next one comes."""
        kept = []
        for name in {fault["camera"] for fault in self._rig.call("fault.list")["faults"]} & shown.keys():
            truth = self._rig.call("truth.get", camera=name, min_ns=shown[name])
            way = truth["outputs"]["mjpeg"]
            is_lost = any(harm["mode"] == "lost" for harm in way["damaged"])
            if not truth["delivered"] or (not self._options.raw and (way["fate"] != "sent" or way["late_frames"] or is_lost)):
                kept.append(name)
        return kept

    def _count_the_rest(self) -> None:
        """Frames that were kept back until the end."""
        for reply in self._rig.call("camera.list")["cameras"]:
            if (name := reply["name"]) in self._last:
                self.progress.missing[name] += max(0, reply["sequence"] - self._last[name][0])

    def _count_unseen(self, until_ns: int) -> None:
        """All frames of the cameras from which none came."""
        for name in self._active:
            if name not in self._last:
                self.progress.missing[name] = self._cameras[name].now.due_count(self._start_ns, until_ns)

    def _step(self, now_ns: int, due_ns: int) -> None:
        if due_ns > now_ns and self._rig.step(nanoseconds=due_ns - now_ns)["world_ns"] < due_ns:
            self._world_is_gone = True

    def _collect(self, shown: Mapping[str, int]) -> list[Frame]:
        """What came, with these cameras' frames of these world times."""
        frames = self._inbox.take(0)  # late ones, too
        deadline = time.monotonic() + _FRAME_TIMEOUT_S
        while waiting := {one for one in shown.items() - {(frame.camera, frame.world_ns) for frame in frames} if one[0] not in self._ended}:
            left_s = deadline - time.monotonic()
            if left_s <= 0:
                raise CamrigTimeout("unavailable", "no frame " + ", ".join(f"of world time {ns} ns from {name}" for name, ns in sorted(waiting)))
            if not (came := self._inbox.take(min(left_s, _POLL_S))):
                self._poll()
                self._check_world()
            frames += came
            self._ended |= self._inbox.take_ended()
        return frames

    def _write_raw(self, shown: Mapping[str, int]) -> None:
        for name, world_ns in sorted(shown.items(), key=lambda one: (one[1], one[0])):
            got = Camera(self._rig, name).frame(min_ns=world_ns, format="raw")
            if got.time_ns != world_ns:
                raise CamrigError("internal", f"camera {name}: asked for world time {world_ns} ns, got {got.time_ns}")
            frame = Frame(name, got.sequence, got.time_ns, got.monotonic_ns, b"")
            if self._is_next(frame):
                self._write_frame(frame, got.image[:, :, ::-1])
        self._bag.end_of_instant()

    def _follow(self) -> None:
        """Takes what the streams bring; a frame that was dropped is missing in its sequence numbers."""
        end_ns = self._end_ns
        while not self._stopping:
            time.sleep(_BATCH_S)
            frames = self._inbox.take(_POLL_S)
            self._poll()
            self._renew_readers(self._start_ns)
            self._write(frames)
            self._check_world()
            world_ns = max((world_ns for _, world_ns in self._last.values()), default=self._start_ns)
            self._tell(world_ns if end_ns is None else min(world_ns, end_ns))
            if not self._active or (end_ns is not None and self._is_over(end_ns)):
                return
        world_ns = self._rig.status()["world_ns"]
        self._count_unseen(world_ns if end_ns is None else min(world_ns, end_ns))

    def _is_over(self, end_ns: int) -> bool:
        late = {name: self._cameras[name].now.due_count(self._seen_ns(name), end_ns) for name in self._active}
        if any(late.values()) and self._rig.status()["world_ns"] <= end_ns + _GRACE_NS:
            return False
        self.progress.missing.update(late)
        return True

    # What becomes of them

    def _write(self, frames: list[Frame]) -> None:
        instant: int | None = None
        for frame in sorted(frames, key=lambda frame: (frame.world_ns, frame.camera)):
            if not self._is_next(frame):
                continue
            if instant is not None and frame.world_ns != instant:
                self._bag.end_of_instant()
            instant = frame.world_ns
            self._write_frame(frame)
        self._bag.end_of_instant()

    def _is_next(self, frame: Frame) -> bool:
        """Counts what is missing before it. A camera that is changed while the world stands still shows one instant again."""
        if self._end_ns is not None and frame.world_ns > self._end_ns:
            return False
        history = self._cameras[frame.camera]
        if frame.camera in self._last:
            sequence, world_ns = self._last[frame.camera]
            missing = frame.sequence - sequence - 1
            is_late = frame.world_ns <= world_ns and frame.sequence < sequence
        else:
            world_ns = self._start_ns
            missing = history.at(frame.world_ns).due_count(world_ns, frame.world_ns) - 1
            is_late = False
        if is_late:  # counted as missing when a later one came
            return False
        self._last[frame.camera] = (frame.sequence, max(frame.world_ns, world_ns))
        # A camera that was deleted and made again counts from the start.
        self.progress.missing[frame.camera] += max(0, missing)
        return frame.world_ns > world_ns

    def _seen_ns(self, camera: str) -> int:
        return self._last[camera][1] if camera in self._last else self._start_ns

    def _write_frame(self, frame: Frame, rgb: np.ndarray | None = None) -> None:
        """The picture is the frame's JPEG, else `rgb`."""
        state, stamp_ns = self._cameras[frame.camera].at(frame.world_ns), self._stamp_ns(frame)
        picture = messages.compressed_image(state, stamp_ns, frame.jpeg) if rgb is None else messages.image(state, stamp_ns, rgb)
        write = self._bag.write
        write("/tf", stamp_ns, messages.camera_pose(state, stamp_ns, self._options.world_frame))
        write(f"/{state.name}/camera_info", stamp_ns, messages.camera_info(state, stamp_ns))
        write(self._image_topic(state.name)[0], stamp_ns, picture)
        if self._options.detections:
            write(f"/{state.name}/detections", stamp_ns, messages.detections(state, stamp_ns, self._truth(frame)))
        self.progress.frames[state.name] += 1

    def _truth(self, frame: Frame) -> list[dict[str, Any]]:
        truth = self._rig.call("truth.get", camera=frame.camera, min_ns=frame.world_ns)
        if truth["time_ns"] != frame.world_ns:
            raise CamrigError("internal", f"camera {frame.camera}: truth of {truth['time_ns']} ns for a frame of {frame.world_ns} ns")
        return truth["objects"]

    def _stamp_ns(self, frame: Frame) -> int:
        return frame.world_ns if self._options.clock == "world" else frame.monotonic_ns + self._wall_offset_ns

    def _tell(self, world_ns: int) -> None:
        self.progress.world_ns = world_ns
        self.progress.bytes = self._bag.bytes
        self._report(self.progress)


def _wall_offset_ns() -> int:
    """CLOCK_REALTIME - CLOCK_MONOTONIC, from the closest of several pairs of readings; what V4L2 drivers do once at the start."""
    pairs = []
    for _ in range(9):
        before, wall, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        pairs.append((after - before, wall - (before + after) // 2))
    return min(pairs)[1]
