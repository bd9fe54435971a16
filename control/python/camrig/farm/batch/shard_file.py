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
import json
import os
import tarfile
from pathlib import Path
from typing import Any, BinaryIO, Iterator, Sequence

from ...errors import CamrigError

#: Extension of a key's file -> folder of a camera where `camrig record` has it, in the order in which they stand. The picture's is first.
PARTS = {"kitti.txt": "label_2", "calib.txt": "calib", "yolo.txt": "labels", "depth.npy": "depth", "depth.png": "depth", "flow.npy": "flow",
         "instance.png": "instance", "soiling.png": "soiling"}
#: What a camera has once.
CAMERA_FILES = ("camera_info.yaml", "opencv.yml", "seqinfo.ini")
_MAX_MEMBER_BYTES = 1 << 30


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


def samples(path: str | os.PathLike[str]) -> Iterator[tuple[str, dict[str, bytes]]]:
    """The samples of a shard in order: key, and the bytes by extension."""
    key, parts = "", dict[str, bytes]()
    try:
        with tarfile.open(path, mode="r|") as tar:
            for entry in tar:
                name, _, extension = entry.name.partition(".")
                if not entry.isreg() or entry.size > _MAX_MEMBER_BYTES or "/" in name:
                    raise CamrigError("invalid_argument", f"{path}: {entry.name}: is not of a shard")
                if name != key and parts:
                    yield key, parts
                    parts = {}
                key, parts[extension] = name, tar.extractfile(entry).read()  # type: ignore[union-attr]
    except tarfile.TarError as problem:
        raise CamrigError("invalid_argument", f"{path}: {problem}") from None
    if parts:
        yield key, parts
