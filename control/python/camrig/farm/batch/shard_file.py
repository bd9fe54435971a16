"""A shard as a tar file in the way of WebDataset: the files of a sample have one key and stand together.

    KEY.jpg | KEY.png        the picture
    KEY.json                 its truth, as truth.get gives it, without the machine's own clock (`monotonic_ns`)
    KEY.depth.npy | .png, KEY.flow.npy, KEY.instance.png, KEY.soiling.png    what the plan asks for
    KEY.kitti.txt, KEY.calib.txt, KEY.yolo.txt                               labels of the frame

KEY is SHARD_CAMERA_FRAME and there once in all shards. The bytes follow from the frames alone: no times, no owners, one order.
"""

from __future__ import annotations

import hashlib
import io
import itertools
import json
import os
import tarfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Collection, Iterable, Iterator, Mapping, Sequence

from ...errors import CamrigError
from ...json_checks import Wrong, check_integer
from ..form import read_object

#: Extension of a key's file -> folder of a camera where `camrig record` has it, in the order in which they stand. The picture's is first.
PARTS = {"kitti.txt": "label_2", "calib.txt": "calib", "yolo.txt": "labels", "depth.npy": "depth", "depth.png": "depth", "flow.npy": "flow",
         "instance.png": "instance", "soiling.png": "soiling"}
#: What a camera has once.
CAMERA_FILES = ("camera_info.yaml", "opencv.yml", "seqinfo.ini")
_MAX_MEMBER_BYTES, _MAX_TRUTH_BYTES = 1 << 30, 64 << 20


class _Hashing:
    """A file that knows the hash and length of what was written."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.sha256 = hashlib.sha256()
        self.size = 0

    def write(self, data: bytes) -> int:
        self.sha256.update(data)
        self.size += len(data)
        return self._file.write(data)


def pack(shard_id: str, dataset: Path, cameras: Sequence[str], suffix: str, to: BinaryIO) -> dict[str, Any]:
    """Writes what `camrig record` has recorded as one shard. Gives what the manifest says of it: bytes, sha256, frames, cameras."""
    out = _Hashing(to)
    told = []
    with tarfile.open(fileobj=out, mode="w|", format=tarfile.USTAR_FORMAT) as tar:  # type: ignore[call-overload]
        for camera in cameras:
            frames = 0
            for frames, truth in enumerate(_truths(dataset / camera / "truth.jsonl"), 1):
                key = f"{shard_id}_{camera}_{frames:06}"
                _add(tar, f"{key}{suffix}", (dataset / camera / "image_2" / f"{frames:06}{suffix}").read_bytes())
                _add(tar, f"{key}.json", truth)
                for extension, part in PARTS.items():
                    file = dataset / camera / part / f"{frames:06}.{extension.rpartition('.')[2]}"
                    if file.is_file():
                        _add(tar, f"{key}.{extension}", file.read_bytes())
            files = {name: (dataset / camera / name).read_text() for name in CAMERA_FILES} if frames else {}
            told.append({"name": camera, "frames": frames, "files": files})
    return {"bytes": out.size, "sha256": out.sha256.hexdigest(), "frames": sum(one["frames"] for one in told), "picture_suffix": suffix, "cameras": told}


def _truths(journal: Path) -> Iterator[bytes]:
    if not journal.exists():  # no frame of this camera was due
        return
    with open(journal, encoding="utf-8") as lines:
        for line in lines:
            truth = json.loads(line)
            del truth["monotonic_ns"]
            yield json.dumps(truth, separators=(",", ":"), ensure_ascii=False).encode()


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    entry = tarfile.TarInfo(name)
    entry.size, entry.mode = len(data), 0o644
    tar.addfile(entry, io.BytesIO(data))


@dataclass(frozen=True)
class Sample:
    key: str
    camera: str
    frame: str  #: as its files are named
    parts: dict[str, bytes]  #: by extension; the picture and "json" are there


def samples(path: str | os.PathLike[str], told: Mapping[str, Any]) -> Iterator[Sample]:
    """The samples of a shard, which are those that its (sound) row of the manifest tells, in that order. CamrigError names the member of what is not so."""
    suffix = told["picture_suffix"].removeprefix(".")
    try:
        with open(path, "rb") as file:
            found = itertools.groupby(_members(file, {suffix, "json", *PARTS}), lambda member: member[0])
            for camera in told["cameras"]:
                for frame in (f"{number:06}" for number in range(1, camera["frames"] + 1)):
                    key = f"{told['shard']}_{camera['name']}_{frame}"
                    name, members = next(found, ("its end", iter(())))
                    if name != key:
                        raise Wrong(_printable(name), f"stands where the manifest has {key}")
                    yield Sample(key, camera["name"], frame, _parts(key, members, suffix))
            for name, _ in found:
                raise Wrong(_printable(name), "is of no frame that the manifest has")
    except Wrong as problem:
        raise CamrigError("invalid_argument", f"{path}: {problem}; camrig farm record draws a shard anew whose file is removed") from None


def _members(file: BinaryIO, extensions: Collection[str]) -> Iterator[tuple[str, str, bytes]]:
    """Key, extension and bytes of the members as pack() writes them: plain files with headers of one block. Not by TarFile, which reads all further headers
    that tar knows into memory, as long as they say that they are."""
    while (head := file.read(tarfile.BLOCKSIZE)) and head != bytes(tarfile.BLOCKSIZE):
        try:
            entry = tarfile.TarInfo.frombuf(head, "utf-8", "surrogateescape")
        except tarfile.HeaderError as problem:
            raise Wrong(f"byte {file.tell() - len(head)}", f"must be a tar file's header: {problem}") from None
        key, _, extension = entry.name.partition(".")
        name = _printable(entry.name)
        if entry.type != tarfile.REGTYPE or extension not in extensions:
            raise Wrong(name, f"is no file of a frame, KEY with one of {', '.join(f'.{one}' for one in sorted(extensions))}")
        if not 0 <= entry.size <= (most := _MAX_TRUTH_BYTES if extension == "json" else _MAX_MEMBER_BYTES):
            raise Wrong(name, f"says that it has {entry.size} bytes; at most {most}")
        data, fill = file.read(entry.size), -entry.size % tarfile.BLOCKSIZE
        if len(data) < entry.size or len(file.read(fill)) < fill:
            raise Wrong(name, f"is cut off: the file ends within its {entry.size} bytes")
        yield key, extension, data


def _parts(key: str, members: Iterable[tuple[str, str, bytes]], suffix: str) -> dict[str, bytes]:
    parts: dict[str, bytes] = {}
    for _, extension, data in members:
        if extension in parts:
            raise Wrong(f"{key}.{extension}", "is there twice")
        parts[extension] = data
    for extension in (suffix, "json"):
        if extension not in parts:
            raise Wrong(f"{key}.{extension}", "is missing")
    try:
        check_integer(read_object(parts["json"]).get("time_ns"), "time_ns", 0, 2**63 - 1)
        if b"\n" in parts["json"]:
            raise Wrong("", "must be one line")
    except Wrong as problem:
        raise Wrong(f"{key}.json", str(problem)) from None
    return parts


def _printable(name: str) -> str:
    """A name of somebody's, which tar keeps to 256 bytes, in a message of one line."""
    return "".join(letter if letter.isprintable() else "?" for letter in name)
