"""10 000 frames over a Ray cluster of 4 nodes of this machine, with 20 kills at random: the set must be that of one undisturbed run, byte for byte.

    PYTHONPATH=control/python build/farm/bin/python tests/farm/run.py [--shards 100] [--kills 20] [--seed 1] [--keep DIR] [--write]

Killed with SIGKILL are drawers, the camrig of a drawer, Ray's workers, whole nodes (a new one joins) and who hands out (`camrig farm record`, started
again). Prints what was killed and how long both runs took, and with --write puts it into docs/farm-record.md; exit code 1 if the sets differ.
tools/test --long makes the environment and runs it.
"""

from __future__ import annotations

import argparse
import collections
import filecmp
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import ray
from ray.cluster_utils import Cluster

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from camrig.farm.batch.shard_file import samples  # noqa: E402
from camrig.farm.batch.store import Store  # noqa: E402
from tools.bench import report  # noqa: E402

_NODES = 4
_POLL_S = 0.05
_STARTS = 100
_NODE_STARTS = 5
_VICTIMS = ("drawer", "camrig", "worker", "node", "record")


def plan_of(shards: int) -> dict:
    """Shards of 100 frames, four of five of the minimal scene and one of the hall."""
    seconds = 2.0
    small = {"size": [160, 120], "fps": 50}
    return {
        "camrig_plan": 1, "master_seed": 7, "quality": "fast", "shard_seconds": seconds,
        "pictures": {"masks": True, "yolo": True},
        "vary": [{"rows": [
            {"scene": "minimal", "cameras": [{"name": "eye", "place": "above", **small}], "seconds": seconds * (shards - shards // 5)},
            {"scene": "hall", "cameras": [{"name": "eye", "place": "lobby", **small}], "seconds": seconds * (shards // 5)},
        ]}],
    }


def record(plan: Path, out: Path, *options: str, log: Path) -> subprocess.Popen:
    with open(log, "ab") as to:
        return subprocess.Popen([sys.executable, "-m", "camrig.farm", "record", str(plan), "--out", str(out), "--verify", "0", *options], stdout=to, stderr=to)


def descendants(root: int) -> dict[int, str]:
    """The processes below one, and their command lines."""
    children = collections.defaultdict(list)
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            children[int((folder / "stat").read_text().rpartition(")")[2].split()[1])].append(int(folder.name))
        except OSError:
            continue
    found, waiting = {}, [root]
    while waiting:
        for pid in children[waiting.pop()]:
            waiting.append(pid)
            try:
                found[pid] = Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode("utf-8", "replace")
            except OSError:
                continue
    return found


def is_of(kind: str, command: str) -> bool:
    words = command.split()
    if kind == "drawer":
        return "camrig.farm.batch.draw" in words
    if kind == "camrig":
        return len(words) > 1 and words[0].endswith("/camrig") and words[1] == "serve"
    return kind == "worker" and command.startswith("ray::") and "run_drawer" in command


class Chaos:
    def __init__(self, cluster: Cluster, seed: int) -> None:
        self._cluster, self._random = cluster, random.Random(seed)
        self._nodes = [self._add() for _ in range(_NODES - 1)]
        self.kills: collections.Counter[str] = collections.Counter()

    def _add(self):
        for _ in range(_NODE_STARTS):
            try:
                return self._cluster.add_node(num_cpus=1, object_store_memory=80 << 20)
            except Exception as problem:  # Ray has no other; it waits 30 s for a node, which a busy machine may not need less than
                failed = problem
        raise failed

    def kill_one(self, recorder: subprocess.Popen) -> bool:
        """One at random; False when there was none of the kind right now."""
        kind = self._random.choice(_VICTIMS)
        if kind == "record":
            recorder.kill()
            recorder.wait()
        elif kind == "node":
            node = self._nodes.pop(self._random.randrange(len(self._nodes)))
            self._cluster.remove_node(node, allow_graceful=False)
            self._nodes.append(self._add())
        else:
            pids = [pid for pid, command in descendants(os.getpid()).items() if is_of(kind, command)]
            if not pids:
                return False
            try:
                os.kill(self._random.choice(pids), signal.SIGKILL)
            except ProcessLookupError:
                return False
        self.kills[kind] += 1
        return True


def disturbed(plan: Path, out: Path, log: Path, shards: int, kills: int, seed: int) -> tuple[float, collections.Counter, int]:
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 80 << 20, "include_dashboard": False})
    try:
        chaos = Chaos(cluster, seed)
        due = sorted(random.Random(seed).sample(range(1, shards - 1), kills))
        begin_s, starts = time.monotonic(), 0
        while starts < _STARTS:
            recorder = record(plan, out, "--ray", cluster.address, "--cpus", "1", log=log)
            starts += 1
            while recorder.poll() is None:
                done = len(list((out / "shards").glob("*.tar")))
                if due and done >= due[0] and chaos.kill_one(recorder):
                    due.pop(0)
                time.sleep(_POLL_S)
            if recorder.returncode == 0:
                break
        assert recorder.returncode == 0 and not due, f"exit code {recorder.returncode}, {len(due)} kills not done; see {log}"
        return time.monotonic() - begin_s, chaos.kills, starts
    finally:
        cluster.shutdown()


def differences(one: Path, other: Path) -> list[str]:
    names = {str(path.relative_to(root)) for root in (one, other) for path in root.rglob("*") if path.is_file()}
    return sorted(name for name in names if not ((one / name).is_file() and (other / name).is_file() and filecmp.cmp(one / name, other / name, shallow=False)))


def check_parquet(store: Path, to: Path, frames: int) -> None:
    """The set as Parquet, read by ray.data; and its shards as WebDataset, read by it too."""
    assert subprocess.run([sys.executable, "-m", "camrig.farm", "export", str(store), "--out", str(to), "--format", "parquet"], stdout=subprocess.DEVNULL, check=False).returncode == 0
    import ray.data

    ray.init(num_cpus=1, include_dashboard=False, object_store_memory=200 << 20, log_to_driver=False, logging_level="error")
    try:
        rows = ray.data.read_parquet(str(to))
        assert rows.count() == frames and {"key", "image", "truth"} <= set(rows.schema().names)
        row = rows.take(1)[0]
        (told,) = [one for one in Store(store).manifest() if one["shard"] == row["shard"]]
        (sample,) = [one.parts for one in samples(Store(store).shard_path(row["shard"]), told) if one.key == row["key"]]
        assert row["image"] == sample["jpg"] and row["truth"] == sample["json"].decode() and row["instance_png"] == sample["instance.png"]
        assert ray.data.read_webdataset(str(store / "shards" / f"{row['shard']}.tar")).count() == 100
    finally:
        ray.shutdown()


def shard_cost_s(scene: str, place: str, folder: Path) -> float:
    """Seconds that a shard takes beside its frames: by sets of 4 and of 12 shards of one frame, one at a time."""
    times = []
    for count in (4, 12):
        plan = folder / f"{scene}-{count}.json"
        plan.write_text(json.dumps({"camrig_plan": 1, "scene": scene, "quality": "fast", "seconds": 0.02, "vary": [{"repeat": count}],
                                    "cameras": [{"name": "eye", "place": place, "size": [160, 120], "fps": 50}]}))
        begin_s = time.monotonic()
        assert record(plan, folder / f"{scene}-{count}", "--workers", "1", log=folder / "cost.log").wait() == 0
        times.append(time.monotonic() - begin_s)
    return (times[1] - times[0]) / 8


def page_part(found: dict) -> str:
    names = {"drawer": "drawers", "camrig": "camrigs", "worker": "Ray workers", "node": "nodes", "record": "times `camrig farm record`"}
    killed = ", ".join(f"{found['kills'].get(kind, 0)} {name}" for kind, name in names.items())
    costs = " and ".join(f"{seconds:.1f} s of {scene}" for scene, seconds in found["shard_cost_s"].items())
    return f"""{found['frames']} frames of 160x120 (`fast`, JPEG, masks, YOLO; four fifths of `minimal`, one of `hall`) in {found['shards']} shards; Ray {ray.__version__} on Python {sys.version.split()[0]}:

| | seconds | frames/s |
|---|---|---|
| one machine, a worker a core, undisturbed | {found['quiet_s']:.0f} | {found['frames'] / found['quiet_s']:.0f} |
| {_NODES} Ray nodes on the same cores; killed were {killed} | {found['disturbed_s']:.0f} | {found['frames'] / found['disturbed_s']:.0f} |

Files that differ: {len(found['different_files'])}. A shard costs {costs} beside its frames."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, value in (("shards", 100), ("kills", 20), ("seed", 1)):
        parser.add_argument(f"--{name}", type=int, default=value)
    parser.add_argument("--keep", help="folder for both sets")
    parser.add_argument("--write", action="store_true", help="into docs/farm-record.md")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="camrig-farm-test-", ignore_cleanup_errors=True) as temporary:
        folder = Path(options.keep or temporary)
        folder.mkdir(exist_ok=True)
        plan = folder / "plan.json"
        plan.write_text(json.dumps(plan_of(options.shards)))
        begin_s = time.monotonic()
        quiet = record(plan, folder / "quiet", "--workers", str(os.cpu_count()), log=folder / "quiet.log")
        assert quiet.wait() == 0, (folder / "quiet.log").read_text()
        quiet_s = time.monotonic() - begin_s
        seconds, kills, starts = disturbed(plan, folder / "disturbed", folder / "disturbed.log", options.shards, options.kills, options.seed)
        frames = sum(json.loads(line)["frames"] for line in open(folder / "quiet" / "manifest.jsonl"))
        wrong = differences(folder / "quiet", folder / "disturbed")
        found = {"frames": frames, "shards": options.shards, "quiet_s": round(quiet_s, 1), "disturbed_s": round(seconds, 1), "starts": starts, "kills": dict(kills),
                 "different_files": wrong, "shard_cost_s": {scene: round(shard_cost_s(scene, place, folder), 2) for scene, place in (("minimal", "main"), ("hall", "lobby"))}}
        print(json.dumps(found), flush=True)
        check_parquet(folder / "disturbed", folder / "parquet", frames)
        if options.write:
            report.put(report.REPOSITORY / "docs" / "farm-record.md", "kills", page_part(found), "`tests/farm/run.py --write`")
        return 1 if wrong or frames != 100 * options.shards else 0


if __name__ == "__main__":
    sys.exit(main())
