"""rosbag2 bags: a directory with MCAP files and metadata.yaml, readable at any time, also after a crash."""

from __future__ import annotations

import copy
import json
import os
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Iterable

from ..errors import CamrigError
from .messages import definition

try:
    from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
    from mcap.writer import CompressionType, IndexType, Writer
except ImportError as problem:
    raise CamrigError("unavailable", f"{problem}; this command needs: pip install 'camrig[ros2]'") from problem

_INFINITE = "sec: 9223372036\n    nsec: 854775807"
#: Of rosbag2 before Iron, which later ones read too: numbers of rmw, in YAML within YAML.
_QOS = (
    "- history: {history}\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    f"  deadline:\n    {_INFINITE}\n  lifespan:\n    {_INFINITE}\n"
    f"  liveliness: 1\n  liveliness_lease_duration:\n    {_INFINITE}\n"
    "  avoid_ros_namespace_conventions: false"
)
_RELIABLE_VOLATILE = _QOS.format(history=1, depth=10, durability=2)
_RELIABLE_LATCHED = _QOS.format(history=1, depth=1, durability=1)
_METADATA_VERSION = 5


@dataclass(frozen=True)
class Topic:
    name: str
    type: str
    latched: bool = False

    @property
    def qos(self) -> str:
        return _RELIABLE_LATCHED if self.latched else _RELIABLE_VOLATILE


@dataclass
class _Counts:
    messages: dict[str, int] = field(default_factory=dict)
    first_ns: int | None = None
    last_ns: int = 0

    def add(self, topic: str, log_ns: int) -> None:
        self.messages[topic] = self.messages.get(topic, 0) + 1
        self.first_ns = log_ns if self.first_ns is None else min(self.first_ns, log_ns)
        self.last_ns = max(self.last_ns, log_ns)

    @property
    def total(self) -> int:
        return sum(self.messages.values())

    @property
    def duration_ns(self) -> int:
        return self.last_ns - (self.first_ns or 0)


class _Staged:
    """What an MCAP writer writes, until commit() puts it into the file by one call."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor, self._start, self._bytes = descriptor, 0, bytearray()
        self._end = b""  # index and footer as they are in the file, from _start on

    def write(self, data: bytes) -> int:
        self._bytes += data
        return len(data)

    def tell(self) -> int:
        return self._start + len(self._bytes)

    def flush(self) -> None:
        pass

    def commit(self, next_start: int) -> int:
        """The next commit overwrites all from `next_start` on. Returns the length of the file. When it cannot be written the file is what it
        was after the last commit."""
        staged, self._bytes = bytes(self._bytes), bytearray()
        try:
            self._put(staged, self._start)
        except OSError:
            self._put(self._end, self._start)  # takes no room: it was there
            os.ftruncate(self._descriptor, self._start + len(self._end))
            raise
        length = self._start + len(staged)
        self._start, self._end = next_start, staged[next_start - self._start :]
        return length

    def _put(self, data: bytes, offset: int) -> None:
        while data:
            done = os.pwrite(self._descriptor, data, offset)
            data, offset = data[done:], offset + done


class BagFile:
    """One .mcap file. After every flush it is complete, index and all, so that every reader opens it whatever happens then.

    The writer's finish() only writes: index and footer go behind the data, and the next flush puts its data in their place.
    """

    def __init__(self, path: Path, topics: Iterable[Topic]) -> None:
        self.path = path
        self.counts = _Counts()
        self.size = 0
        self._flushed = _Counts()
        self._is_broken = False
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._staged = _Staged(self._descriptor)
        # Pictures are compressed already. One chunk a flush: what is not flushed is in memory anyway.
        self._writer = Writer(
            self._staged,  # type: ignore[arg-type]
            chunk_size=1 << 62,
            compression=CompressionType.NONE,
            index_types=IndexType.ALL,
            use_summary_offsets=False,
        )
        self._writer.start(profile=Profile.ROS2)
        schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        for topic in topics:
            if topic.type not in schemas:
                schemas[topic.type] = self._writer.register_schema(topic.type, SchemaEncoding.ROS2, definition(topic.type).encode())
            self._channels[topic.name] = self._writer.register_channel(
                topic.name, MessageEncoding.CDR, schemas[topic.type], {"offered_qos_profiles": topic.qos}
            )
        self.flush()

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        self._writer.add_message(self._channels[topic], log_ns, data, log_ns, self.counts.messages.get(topic, 0))
        self.counts.add(topic, log_ns)

    def flush(self) -> None:
        """Raises CamrigError when the file cannot be written, once: it then stays what it was after the last flush."""
        if self._is_broken:
            return
        self._writer.flush()
        end_of_data = self._staged.tell()
        self._writer.finish()
        try:
            self.size = self._staged.commit(end_of_data)
        except OSError as problem:
            self._is_broken, self.counts = True, self._flushed
            raise CamrigError("unavailable", f"{self.path}: cannot be written: {problem.strerror}; the bag holds what came before") from problem
        self._flushed = copy.deepcopy(self.counts)

    def close(self) -> None:
        try:
            self.flush()
        finally:
            os.close(self._descriptor)


@dataclass(frozen=True)
class BagOptions:
    split_bytes: int = 0  # 0: never
    split_ns: int = 0
    flush_s: float = 1.0
    #: Between two flushes at most this much is kept in memory.
    max_unflushed_bytes: int = 64 << 20


class Bag:
    """A bag that is being written. `opening` gives what every file begins with (for /tf_static): topic, bytes by log time."""

    def __init__(
        self, directory: Path, topics: list[Topic], options: BagOptions, opening: Callable[[int], list[tuple[str, bytes]]]
    ) -> None:
        self.directory, self._topics, self._options, self._opening = directory, topics, options, opening
        try:
            directory.mkdir(parents=True)
        except FileExistsError:
            raise CamrigError("already_exists", f"{directory} exists already; a bag needs a directory of its own") from None
        self._files: list[BagFile] = []
        self._unflushed = 0
        self._flushed_at = time.monotonic()
        self._open_file()

    @property
    def bytes(self) -> int:
        return sum(file.size for file in self._files) + self._unflushed

    @property
    def messages(self) -> int:
        return sum(file.counts.total for file in self._files)

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        file = self._files[-1]
        if file.counts.total == 0:
            for name, first in self._opening(log_ns):
                file.write(name, log_ns, first)
        file.write(topic, log_ns, data)
        self._unflushed += len(data)
        if self._unflushed >= self._options.max_unflushed_bytes:
            self.flush()

    def end_of_instant(self) -> None:
        """To be called where a file may end: all messages of an instant stay together."""
        if time.monotonic() - self._flushed_at >= self._options.flush_s:
            self.flush()
        counts, options = self._files[-1].counts, self._options
        too_long = options.split_ns and counts.first_ns is not None and counts.duration_ns >= options.split_ns
        if too_long or (options.split_bytes and self._files[-1].size + self._unflushed >= options.split_bytes):
            self._close_file()
            self._open_file()

    def flush(self) -> None:
        if self._unflushed:
            self._files[-1].flush()
            self._unflushed = 0
            self._write_metadata()
        self._flushed_at = time.monotonic()

    def close(self) -> None:
        try:
            self._close_file()
        finally:
            last = self._files[-1]
            if last.counts.total == 0 and len(self._files) > 1:  # split at the very end
                last.path.unlink()
                self._files.pop()
            self._write_metadata()

    def _open_file(self) -> None:
        name = f"{self.directory.name}_{len(self._files)}.mcap"
        self._files.append(BagFile(self.directory / name, self._topics))
        self._write_metadata()

    def _close_file(self) -> None:
        self._files[-1].close()
        self._unflushed = 0

    def _write_metadata(self) -> None:
        """A reader finds the old file or the new one, never half of one."""
        path = self.directory / "metadata.yaml"
        temporary = path.with_suffix(".yaml.new")
        try:
            temporary.write_text(metadata_yaml(self._topics, [(file.path.name, file.counts) for file in self._files]))
            os.replace(temporary, path)
        except OSError as problem:
            temporary.unlink(missing_ok=True)
            raise CamrigError("unavailable", f"{path}: cannot be written: {problem.strerror}; it describes an earlier state of the bag") from problem


def metadata_yaml(topics: list[Topic], files: list[tuple[str, _Counts]]) -> str:
    """rosbag2's description of a bag."""
    used = [counts for _, counts in files if counts.first_ns is not None]
    first_ns = min((counts.first_ns or 0 for counts in used), default=0)
    last_ns = max((counts.last_ns for counts in used), default=0)
    lines = [
        "rosbag2_bagfile_information:",
        f"  version: {_METADATA_VERSION}",
        "  storage_identifier: mcap",
        "  duration:",
        f"    nanoseconds: {last_ns - first_ns}",
        "  starting_time:",
        f"    nanoseconds_since_epoch: {first_ns}",
        f"  message_count: {sum(counts.total for _, counts in files)}",
        "  topics_with_message_count:",
    ]
    for topic in topics:
        lines += [
            "    - topic_metadata:",
            f"        name: {topic.name}",
            f"        type: {topic.type}",
            "        serialization_format: cdr",
            f"        offered_qos_profiles: {json.dumps(topic.qos)}",
            f"      message_count: {sum(counts.messages.get(topic.name, 0) for _, counts in files)}",
        ]
    lines += ['  compression_format: ""', '  compression_mode: ""', "  relative_file_paths:"]
    lines += [f"    - {json.dumps(name)}" for name, _ in files]
    lines.append("  files:")
    for name, counts in files:
        lines += [
            f"    - path: {json.dumps(name)}",
            "      starting_time:",
            f"        nanoseconds_since_epoch: {counts.first_ns or 0}",
            "      duration:",
            f"        nanoseconds: {counts.duration_ns}",
            f"      message_count: {counts.total}",
        ]
    return "\n".join(lines) + "\n"
