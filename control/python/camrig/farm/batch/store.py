"""The folder of a data set.

    set.json             which build of camrig draws it
    plan.json            the plan as it was read last
    planned.json         how many shards that plan has
    shards/ID.tar        a shard that is whole; while it is written, ID.tar.NUMBER.part
    shards/ID.json       what the manifest says of it: written before the shard gets its name
    manifest.jsonl       of all shards, in the plan's order; made of those when a run ends
    failed.json          shards that could not be drawn, and why; there only if there are such

A shard is there when it has its name. It gets it by rename, when its bytes are on the disk.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import secrets
from pathlib import Path
from typing import Any, BinaryIO, Callable, Iterable, Iterator, NoReturn

from ...errors import CamrigError
from .manifest import rows
from .shard_file import samples

_CHUNK_BYTES = 1 << 20
_FORMAT = 1


class Differs(CamrigError):
    """A shard that was drawn twice came out as two."""


def _raise(problem: CamrigError) -> NoReturn:
    raise problem


class Store:
    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder).absolute()
        self.shards = self.folder / "shards"

    def shard_path(self, shard_id: str) -> Path:
        return self.shards / f"{shard_id}.tar"

    def told(self, shard_id: str) -> dict[str, Any] | None:
        """What the manifest says of a shard, if it is there and as long as it says."""
        try:
            told = json.loads((self.shards / f"{shard_id}.json").read_bytes())
            return told if self.shard_path(shard_id).stat().st_size == told["bytes"] else None
        except (FileNotFoundError, ValueError, KeyError, TypeError):  # a disk that lost it
            return None

    def publish(self, shard_id: str, write: Callable[[BinaryIO], dict[str, Any]]) -> dict[str, Any]:
        """Lets `write` write the shard and gives it its name; `write` returns what the manifest is to say. Of a shard that has its name already, as
        one does whose worker was thought dead, it is seen that the bytes are the same: else Differs."""
        part = self.shards / f"{shard_id}.tar.{secrets.token_hex(4)}.part"
        try:
            told = _write_through(part, write)
            if (there := self.told(shard_id)) is not None:
                _check_same(shard_id, told["sha256"], there["sha256"])
                return there
            write_json(self.shards / f"{shard_id}.json", told)
            os.rename(part, self.shard_path(shard_id))
        finally:
            part.unlink(missing_ok=True)
        _sync_folder(self.shards)
        return told

    def compare(self, shard_id: str, write: Callable[[BinaryIO], dict[str, Any]]) -> dict[str, Any]:
        """Lets `write` write a shard that is there once more, into nothing; Differs if it is not the same."""
        with open(os.devnull, "wb") as nothing:
            told = write(nothing)
        _check_same(shard_id, told["sha256"], (self.told(shard_id) or {}).get("sha256", "nothing"))
        return told

    @contextlib.contextmanager
    def held(self, program: dict[str, str], plan: dict[str, Any], shard_ids: Iterable[str]) -> Iterator[None]:
        """Makes the folder, or goes on with it; nobody else may meanwhile. `program`: version and hash of the camrig that draws."""
        self.folder.mkdir(parents=True, exist_ok=True)
        set_file = self.folder / "set.json"
        known = (".lock", "shards", "plan.json")
        if not set_file.exists() and (strangers := [one.name for one in self.folder.iterdir() if one.name not in known and one.suffix != ".part"]):
            raise CamrigError("already_exists", f"{self.folder}: is no data set of camrig farm and holds {sorted(strangers)[0]}; give another folder")
        with open(self.folder / ".lock", "ab") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise CamrigError("unavailable", f"{self.folder}: another camrig farm record draws into it; wait for it or end it") from None
            self.shards.mkdir(exist_ok=True)
            self._check_program(set_file, program)
            wanted = set(shard_ids)
            self._check_names(wanted)
            self._remove_parts()
            write_json(self.folder / "plan.json", plan, indent=1)
            write_json(self.folder / "planned.json", {"shards": len(wanted)})
            try:
                yield
            finally:
                self._remove_parts()

    def _remove_parts(self) -> None:
        """Of who was killed. One that goes on all the same, out of reach, finds that its file is gone and gives up."""
        for part in [*self.shards.glob("*.part"), *self.folder.glob("*.part")]:
            part.unlink(missing_ok=True)

    def _check_program(self, set_file: Path, program: dict[str, str]) -> None:
        mine = {"camrig_farm_set": _FORMAT, **program}
        if not set_file.exists():
            return write_json(set_file, mine, indent=1)
        its = json.loads(set_file.read_bytes())
        if its != mine:
            raise CamrigError("invalid_argument", f"{self.folder}: is drawn by another build of camrig ({its.get('version')}, program {str(its.get('program'))[:12]}; this is "
                              f"{mine['version']}, {mine['program'][:12]}); go on with that one, or give another folder")

    def _check_names(self, wanted: set[str]) -> None:
        strangers = [path.name for path in self.shards.glob("*.tar") if path.stem not in wanted]
        if strangers:
            raise CamrigError("invalid_argument", f"{self.folder}: holds {len(strangers)} shards that this plan has not, as {min(strangers)}; "
                              "a plan may grow, but what was drawn stays in it (or a scene's file has changed): give another folder, or remove them")

    def write_manifest(self, shard_ids: Iterable[str]) -> int:
        """Of the shards that are there, in that order; returns how many."""
        count = 0
        temporary = self.folder / "manifest.jsonl.part"
        with open(temporary, "w", encoding="utf-8") as out:
            for shard_id in shard_ids:
                if (told := self.told(shard_id)) is not None:
                    out.write(json.dumps(told, sort_keys=True) + "\n")
                    count += 1
            _sync(out)
        os.rename(temporary, self.folder / "manifest.jsonl")
        return count

    def write_failed(self, failed: list[dict[str, Any]]) -> None:
        if failed:
            write_json(self.folder / "failed.json", failed, indent=1)
        else:
            (self.folder / "failed.json").unlink(missing_ok=True)

    def manifest(self, on_wrong: Callable[[CamrigError], object] = _raise) -> Iterator[dict[str, Any]]:
        """What it says of each shard; `on_wrong` is told of each line that is of none."""
        try:
            yield from rows(self.folder / "manifest.jsonl", on_wrong)
        except FileNotFoundError:
            raise CamrigError("not_found", f"{self.folder}: no manifest.jsonl; it is there when a run of camrig farm record has ended") from None

    def lacks(self, listed: set[str]) -> str | None:
        """What the manifest, which lists those shards, has not of all that the folder knows of, as after a run that was broken off; None: it has everything."""
        found = []
        if len(listed) < (planned := self._planned()):
            found.append(f"the manifest has {len(listed)} of {planned} planned shards")
        if others := {path.stem for path in self.shards.glob("*.tar")} - listed:
            found.append(f"shards/ has {len(others)} that {'it' if found else 'the manifest'} has not")
        return ", and ".join(found) or None

    def _planned(self) -> int:
        try:
            with open(self.folder / "planned.json", "rb") as file:
                return int(json.loads(file.read(_CHUNK_BYTES))["shards"])
        except (FileNotFoundError, ValueError, KeyError, TypeError, OverflowError, RecursionError):  # an older camrig wrote none
            return 0

    def problem_of(self, told: dict[str, Any]) -> str | None:
        """Reads a shard of the manifest; what is wrong with it."""
        path = self.shard_path(told["shard"])
        made, size = hashlib.sha256(), 0
        try:
            with open(path, "rb") as file:
                while chunk := file.read(_CHUNK_BYTES):
                    made.update(chunk)
                    size += len(chunk)
        except OSError as problem:
            return f"{path.name}: {problem.strerror}"
        if size != told["bytes"]:
            return f"{path.name}: {size} bytes, the manifest says {told['bytes']}"
        if made.hexdigest() != told["sha256"]:
            return f"{path.name}: other bytes than the manifest says"
        try:
            for _ in samples(path, told):
                pass
        except CamrigError as problem:  # a manifest of somebody's is true of anything
            return problem.message
        return None


def _check_same(shard_id: str, mine: str, its: str) -> None:
    if mine != its:
        raise Differs("internal", f"shard {shard_id}: drawn twice, it came out as {its[:12]} and as {mine[:12]}: machines that draw differently, or an error in camrig")


def _write_through(path: Path, write: Callable[[BinaryIO], dict[str, Any]]) -> dict[str, Any]:
    with open(path, "wb") as file:
        told = write(file)
        _sync(file)
    return told


def write_json(path: Path, value: Any, indent: int | None = None) -> None:
    """All of it or nothing."""
    temporary = path.with_name(f"{path.name}.{secrets.token_hex(4)}.part")
    try:
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(json.dumps(value, indent=indent, sort_keys=True) + "\n")
            _sync(file)
        os.rename(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _sync(file: Any) -> None:
    file.flush()
    os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)
