"""`camrig farm export DIR --out FOLDER`: what other programs read, made of the shards; the same bytes whenever it is made."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Sequence

from ...command_line import Parser
from ...errors import CamrigError, error_of_command
from ...places import find_binary
from .check import warn_of_lacks
from .shard_file import PARTS, samples
from .store import Store

#: What a data set of `camrig record` holds, all of it together.
_RECORD_FORMATS = ("coco", "mot", "kitti", "yolo")


def main(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm export", description="Makes of the shards a folder as camrig record writes it, with labels for COCO, MOTChallenge, KITTI and, "
                    "where the plan asked for them, YOLO; or a Parquet file of each shard. docs/farm-record.md")
    parser.add_argument("folder", metavar="DIR", help="of camrig farm record")
    parser.add_argument("--out", metavar="FOLDER", required=True, help="a new one")
    parser.add_argument("--format", choices=(*_RECORD_FORMATS, "parquet"), default="coco", help="coco (default), mot, kitti, yolo: one folder has them all; parquet")
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    options = parser.parse_args(arguments)
    store, to = Store(options.folder), Path(options.out)
    warn_of_lacks(store, {told["shard"] for told in store.manifest()})
    if options.format == "parquet":
        from .parquet import write_parquet

        frames = write_parquet(store, to)
    else:
        frames = write_recording(store, to, options.format)
    print(json.dumps({"folder": str(to), "frames": frames}) if options.json else f"{to}: {frames} frames")
    return 0


def make_new(folder: Path) -> None:
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        raise CamrigError("already_exists", f"{folder}: is there; give a new folder") from None


def write_recording(store: Store, to: Path, wanted: str = "coco") -> int:
    """A data set as `camrig record` writes it. Each camera of each shard is a sequence of its own, SHARD_CAMERA: persons have their numbers within one
    world only. Returns how many frames it has."""
    manifest = list(store.manifest())
    if wanted == "yolo" and not all(told["pictures"]["yolo"] for told in manifest):
        raise CamrigError("invalid_argument", f"{store.folder}: has no YOLO labels; its plan must have \"pictures\": {{\"yolo\": true}}")
    if len(suffixes := {told["picture_suffix"] for told in manifest}) != 1:
        raise CamrigError("invalid_argument", f"{store.folder}: has {'pictures of two kinds' if suffixes else 'no shards'}")
    make_new(to)
    suffix = suffixes.pop()
    names = [f"{told['shard']}_{camera['name']}" for told in manifest for camera in told["cameras"] if camera["frames"]]
    for told in manifest:
        _unpack(store, told, suffix, to)
    description = {"camrig_dataset": 1, "cameras": names, "picture_suffix": suffix, "yolo": all(told["pictures"]["yolo"] for told in manifest)}
    (to / "dataset.json").write_text(json.dumps(description, indent=2) + "\n")
    # Labels over all frames are made by the program that makes them of a recording that was killed.
    done = subprocess.run([find_binary(), "record", os.fspath(to), "--repair", "--json"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise error_of_command(done.stderr, CamrigError("internal", f"record --repair: exit code {done.returncode}"))
    return json.loads(done.stdout)["frames"]


def _unpack(store: Store, told: dict[str, Any], suffix: str, to: Path) -> None:
    folders = {camera["name"]: to / f"{told['shard']}_{camera['name']}" for camera in told["cameras"] if camera["frames"]}
    for camera in told["cameras"]:
        if camera["name"] not in folders:
            continue
        folder = folders[camera["name"]]
        (folder / "gt").mkdir(parents=True)
        if told["pictures"]["yolo"]:  # its trainer follows links, and looks beside `images` for `labels`
            (folder / "images").mkdir()
            (folder / "image_2").symlink_to("images")
        else:
            (folder / "image_2").mkdir()
        for name, text in camera["files"].items():
            (folder / name).write_text(text.replace(f"name={camera['name']}\n", f"name={folder.name}\n") if name == "seqinfo.ini" else text)
    journals = {name: open(folder / "truth.jsonl", "wb") for name, folder in folders.items()}
    try:
        for sample in samples(store.shard_path(told["shard"]), told):
            _put_sample(folders[sample.camera], sample.frame, suffix, sample.parts)
            journals[sample.camera].write(sample.parts["json"] + b"\n")
    finally:
        for journal in journals.values():
            journal.close()


def _put_sample(folder: Path, frame: str, suffix: str, parts: dict[str, bytes]) -> None:
    for extension, data in parts.items():
        if extension == "json":
            continue
        part = "image_2" if f".{extension}" == suffix else PARTS[extension]
        (folder / part).mkdir(exist_ok=True)
        (folder / part / f"{frame}.{extension.rpartition('.')[2]}").write_bytes(data)
