"""`camrig farm record PLAN --out DIR`: hands the shards of a plan out until all are there."""

from __future__ import annotations

import argparse
import collections
import json
import os
import signal
import subprocess
import sys
from typing import Any, Sequence

from ...command_line import Parser
from ...errors import CamrigError
from ...places import find_binary
from . import plan as plans
from .draw import Job
from .hashing import file_hash, text_hash
from .pools import Answer, LocalPool, Pool
from .progress import Progress
from .shard import Shard
from .store import Store

#: A shard whose worker is killed so often is taken for the cause.
MAX_LOST = 20
_EXIT_FAILED_SHARDS = 3
_WAIT_S = 1.0
_AGAIN = "#again"


class Run:
    """Hands out what is not there. Who hands out may be killed at any time: all that is known is what is in the folder."""

    def __init__(self, store: Store, shards: Sequence[Shard], options: argparse.Namespace) -> None:
        self._store, self._options = store, options
        self._shards = {shard.id: shard for shard in shards}
        self._waiting = collections.deque(shard.id for shard in shards if store.told(shard.id) is None)
        self._there_before = len(shards) - len(self._waiting)
        self._again = chosen_again(list(self._waiting), options.verify)
        self._tries: collections.Counter[tuple[str, str]] = collections.Counter()
        self._failed: dict[str, dict[str, Any]] = {}
        self._progress = Progress(len(shards), self._there_before)
        self.drawn = self.frames = self.compared = 0

    @property
    def failed(self) -> list[dict[str, Any]]:
        """In the plan's order."""
        return [self._failed[shard_id] for shard_id in self._shards if shard_id in self._failed]

    def run(self, pool: Pool) -> None:
        in_hand = 0
        while self._waiting or in_hand:
            while self._waiting and in_hand < pool.slots:
                name = self._waiting.popleft()
                pool.submit(name, self._job(name))
                in_hand += 1
            for name, answer in pool.finished(_WAIT_S):
                in_hand -= 1
                self._take(name, answer)
            self._show()
        self._show(is_last=True)

    def _job(self, name: str) -> dict[str, Any]:
        shard_id, _, again = name.partition("#")
        return Job(self._shards[shard_id], str(self._store.folder), bool(again), self._options.timeout_s).to_json()

    def _take(self, name: str, answer: Answer) -> None:
        shard_id, _, again = name.partition("#")
        if "error" in answer:
            return self._take_error(name, answer["error"])
        if again:
            self.compared += 1
            return
        self.drawn += 1
        self.frames += answer["told"]["frames"]
        self._failed.pop(shard_id, None)
        if shard_id in self._again:
            self._waiting.append(shard_id + _AGAIN)

    def _take_error(self, name: str, error: dict[str, str]) -> None:
        kind, text = error["kind"], error["text"]
        if kind == "disk":
            raise CamrigError("resource_exhausted", f"{text}; {self._there_before + self.drawn} of {len(self._shards)} shards are there, whole: make room and run this again")
        if kind in ("machine", "differs"):
            raise CamrigError("unavailable", text)
        self._tries[name, kind] += 1
        if self._tries[name, kind] <= (MAX_LOST if kind == "lost" else self._options.max_retries):
            self._waiting.append(name)
            return
        shard_id = name.partition("#")[0]
        shard = self._shards[shard_id]
        self._failed[shard_id] = {"shard": shard_id, "error": text, "tries": self._tries[name, kind], "scene": shard.scene, "changes": dict(shard.changes),
                                  "seed": shard.seed, "start_ns": shard.start_ns, "end_ns": shard.end_ns}
        if len(self._failed) > self._options.max_failed:
            raise CamrigError("unavailable", f"more than {self._options.max_failed} shards failed (--max-failed), the last with: {text}")

    def _show(self, is_last: bool = False) -> None:
        self._progress.show(self._there_before + self.drawn, self.frames, len(self._failed), is_last)


def chosen_again(shard_ids: Sequence[str], share: float) -> set[str]:
    """The shards that are drawn twice and compared: that share, one at least, and the same ones always."""
    count = min(len(shard_ids), max(1, round(share * len(shard_ids)))) if share > 0 else 0
    return set(sorted(shard_ids, key=lambda shard_id: text_hash(["again", shard_id]))[:count])


def record(plan: plans.Plan, options: argparse.Namespace) -> dict[str, Any]:
    program = {"version": _version(), "program": file_hash(find_binary())}
    store, ids = Store(options.out), [shard.id for shard in plan.shards]
    with store.held(program, plan.text, ids):
        run = Run(store, plan.shards, options)
        pool = _pool(options)
        try:
            run.run(pool)
        finally:
            pool.close()
            there = store.write_manifest(ids)
            store.write_failed(run.failed)
    return {"folder": str(store.folder), "shards": len(ids), "there": there, "drawn": run.drawn, "frames": run.frames, "compared": run.compared,
            "failed": [one["shard"] for one in run.failed]}


def _pool(options: argparse.Namespace) -> Pool:
    if options.ray:
        from .ray_pool import RayPool

        return RayPool(options.ray, options.cpus)
    return LocalPool(options.workers or max(1, int((os.cpu_count() or 1) // options.cpus)))


def _version() -> str:
    try:
        done = subprocess.run([find_binary(), "version"], capture_output=True, text=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError) as problem:
        raise CamrigError("unavailable", f"{find_binary()} version: {problem}") from None
    return done.stdout.strip().removeprefix("camrig ")


def _parser() -> Parser:
    parser = Parser(prog="camrig farm record", description="Draws the data set of a plan, and goes on with one that was broken off. docs/farm-record.md "
                    f"Exit code {_EXIT_FAILED_SHARDS}: some shards could not be drawn; DIR/failed.json says why.")
    parser.add_argument("plan", metavar="PLAN", help="JSON file")
    parser.add_argument("--out", metavar="DIR", required=True, help="folder of the set; with Ray one that all machines see")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=_integer(1, 1024), metavar="N", help="shards at a time on this machine (default: by its cores and --cpus)")
    where.add_argument("--ray", metavar="ADDRESS", help="on a Ray cluster: auto, or HOST:PORT")
    parser.add_argument("--cpus", type=_share(0.01, 1024), default=2.0, metavar="N", help="cores that a shard takes (default 2)")
    parser.add_argument("--verify", type=_share(0, 1), default=0.001, metavar="SHARE", help="of the shards that are drawn twice and compared, one at least (default 0.001); 0: none")
    parser.add_argument("--max-retries", type=_integer(0, 1000), default=3, metavar="N", help="of a shard that fails (default 3); then it is in failed.json")
    parser.add_argument("--max-failed", type=_integer(0, 10**9), default=20, metavar="N", help="ends the run when more shards than that have failed (default 20)")
    parser.add_argument("--timeout-s", type=_share(1, 1e6), default=3600.0, metavar="S", help="the most that a shard may take (default 3600)")
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    return parser


def _integer(low: int, high: int) -> Any:
    def read(text: str) -> int:
        if not text.lstrip("-").isdigit() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"must be a whole number, {low} to {high}")
        return int(text)

    return read


def _share(low: float, high: float) -> Any:
    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be a number, {low:g} to {high:g}")
        return value

    return read


def main(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    # So that workers end and the manifest is written, whoever ends us; a shell's background starts us with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    done = record(plans.load(options.plan), options)
    failed = f", {len(done['failed'])} failed (failed.json)" if done["failed"] else ""
    text = f"{done['folder']}: {done['there']} of {done['shards']} shards, {done['drawn']} drawn now with {done['frames']} frames, {done['compared']} drawn twice and the same{failed}"
    print(json.dumps(done) if options.json else text)
    return _EXIT_FAILED_SHARDS if done["failed"] else 0
