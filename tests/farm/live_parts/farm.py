"""A farm as it stands on several machines: a NATS server, nodes and a door, each a process of its own that can be killed, stopped or cut off."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Sequence

import camrig
from camrig.farm.live.up import find_nats_server

START_S = 120.0
_ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[3] / "control" / "python")}


def wait_until(condition: Callable[[], Any], what: str, timeout_s: float = START_S) -> Any:
    deadline = time.monotonic() + timeout_s
    while not (value := condition()):
        if time.monotonic() > deadline:
            raise TimeoutError(f"after {timeout_s:.0f} s: {what}")
        time.sleep(0.02)
    return value


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


class Link:
    """A way of TCP connections to a port, which can be down as a pulled cable is: what is sent stays where it is, nothing is closed."""

    def __init__(self, to: int) -> None:
        self._to = to
        self.port = free_port()
        self._loop = asyncio.new_event_loop()
        self._up = asyncio.Event()
        self._up.set()
        self._loop.run_until_complete(asyncio.start_server(self._join, "127.0.0.1", self.port))
        threading.Thread(target=self._loop.run_forever, daemon=True).start()

    def set_up(self, is_up: bool) -> None:
        self._loop.call_soon_threadsafe(self._up.set if is_up else self._up.clear)

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await self._up.wait()
        try:
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._to)
        except OSError:
            writer.close()
            return
        await asyncio.gather(self._pump(reader, far_writer), self._pump(far_reader, writer))

    async def _pump(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while data := await reader.read(65536):
                await self._up.wait()
                writer.write(data)
                await writer.drain()
        except OSError:
            pass
        await self._up.wait()
        writer.close()


class Node:
    """One `camrig farm node`, behind a link of its own."""

    def __init__(self, farm: Farm, name: str, *options: str) -> None:
        self.name, self._farm, self._options = name, farm, options
        self.link = Link(farm.nats_port)
        self.log = farm.folder / f"{name}.log"
        self.start()

    def start(self) -> None:
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", self.name, "--nats", f"nats://127.0.0.1:{self.link.port}", "--scene", self._farm.scene,
                   "--mode", self._farm.mode, "--arg=--device=cpu", "--arg=--quality=fast", *self._options]
        with open(self.log, "ab") as to:
            self.process = subprocess.Popen(command, stdout=to, stderr=to, env=_ENVIRONMENT)

    def signal(self, what: signal.Signals, *, node: bool = True) -> None:
        """To the node and its rig, as if their machine did it; or to its rig alone."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for pid in [*([self.process.pid] if node else []), *map(int, children)]:
            os.kill(pid, what)

    def kill(self) -> None:
        """Its rig must not outlive it."""
        self.process.kill()
        self.process.wait()


class Farm:
    def __init__(self, folder: Path, scene: str, mode: str = "realtime", nodes: int = 4, node_options: Sequence[str] = (), door_options: Sequence[str] = ()) -> None:
        self.folder, self.scene, self.mode = folder, scene, mode
        folder.mkdir(parents=True, exist_ok=True)
        self.nats_port = free_port()
        self.nats = f"nats://127.0.0.1:{self.nats_port}"
        self._processes: list[subprocess.Popen[Any]] = []
        self._run([find_nats_server(), "-js", "-sd", str(folder / "jetstream"), "-a", "127.0.0.1", "-p", str(self.nats_port)], "nats")
        wait_until(self._nats_answers, "NATS")
        self.control = str(folder / "farm.sock")
        self.door = self._open_door(door_options)
        self.nodes = {f"node{number + 1}": Node(self, f"node{number + 1}", *node_options) for number in range(nodes)}
        self.rig = self._connect()
        self.wait_for_nodes()

    def _run(self, command: list[str], name: str, **more: Any) -> None:
        with open(self.folder / f"{name}.log", "ab") as to:
            self._processes.append(subprocess.Popen(command, stdout=to, stderr=to, env=_ENVIRONMENT, **more))

    def _open_door(self, options: Sequence[str]) -> dict[str, Any]:
        """What it says when it is there."""
        read_end, write_end = os.pipe()
        self._run([sys.executable, "-m", "camrig.farm", "door", "--nats", self.nats, "--control", self.control, "--ready-fd", str(write_end), *options], "door", pass_fds=(write_end,))
        os.close(write_end)
        with os.fdopen(read_end) as ready:
            return json.loads(ready.readline())

    def _nats_answers(self) -> bool:
        try:
            socket.create_connection(("127.0.0.1", self.nats_port), 1).close()
            return True
        except OSError:
            return False

    def _connect(self) -> camrig.Rig:
        def attempt() -> camrig.Rig | None:
            try:
                return camrig.connect(self.control)
            except camrig.CamrigError:
                return None

        return wait_until(attempt, "a node that answers")

    def __enter__(self) -> Farm:
        return self

    def __exit__(self, *_: Any) -> None:
        for node in self.nodes.values():
            if node.process.poll() is None:
                node.process.send_signal(signal.SIGCONT)
                node.process.kill()
                node.process.wait()
        for process in self._processes:
            process.kill()
            process.wait()

    def status(self) -> dict[str, Any]:
        return self.rig.call("farm.status")

    def facts_of(self, name: str) -> dict[str, Any]:
        return next(node for node in self.status()["nodes"] if node["node"] == name)

    def sequencer(self) -> str:
        return wait_until(lambda: next((node["node"] for node in self.status()["nodes"] if node["is_sequencer"]), None), "a sequencer")

    def owners(self) -> dict[str, str]:
        return {camera["camera"]: camera["node"] for camera in self.status()["cameras"]}

    def wait_for_nodes(self) -> None:
        """All are there, and can have cameras."""
        names = set(self.nodes)

        def are_there() -> bool:
            try:
                nodes = self.status()["nodes"]
            except camrig.CamrigError:
                return False
            running = {node["node"] for node in nodes if not node["is_behind"] and node["pid"] == self.nodes[node["node"]].process.pid}
            return running >= names and any(node["is_sequencer"] for node in nodes)

        wait_until(are_there, f"nodes {', '.join(sorted(names))}; see {self.folder}/*.log")

    def rigs(self) -> dict[str, camrig.Rig]:
        return {node["node"]: camrig.connect(node["control"]) for node in self.status()["nodes"]}


def digests_at_one_time(farm: Farm) -> dict[str, str]:
    """Of every node, at the same world time."""
    rigs = farm.rigs()
    if farm.mode == "lockstep":
        return {name: rig.call("world.digest")["hash"] for name, rig in rigs.items()}
    at_ns = max(rig.status()["world_ns"] for rig in rigs.values()) + 1_500_000_000
    told: dict[str, str] = {}
    asking = [threading.Thread(target=lambda name=name, rig=rig: told.update({name: rig.call("world.digest", at_ns=at_ns)["hash"]})) for name, rig in rigs.items()]
    for each in asking:
        each.start()
    for each in asking:
        each.join(30)
    return told


async def _last_of_log(nats: str) -> int:
    from camrig.farm.live.log import CommandLog, Subjects, connect

    bus = await connect(nats)
    last = await CommandLog(bus, Subjects("farm")).last()
    await bus.close()
    return last


def wait_for_all(farm: Farm) -> int:
    """Until every node says that it has done all of the log; how many entries that are."""
    last = asyncio.run(_last_of_log(farm.nats))
    wait_until(lambda: {node["applied"] for node in farm.status()["nodes"]} == {last}, f"all nodes to have done entry {last}")
    return last


async def _read_log(nats: str) -> list[dict[str, Any]]:
    from camrig.farm.live.log import CommandLog, Subjects, connect

    bus = await connect(nats)
    log = CommandLog(bus, Subjects("farm"))
    entries = [await log.read(number) for number in range(1, await log.last() + 1)]
    await bus.close()
    return entries


def log_of(farm: Farm) -> list[dict[str, Any]]:
    return asyncio.run(_read_log(farm.nats))


Books = dict[str, dict[str, int]]  # by node and its process: what was dropped, by reason


def books(farm: Farm) -> tuple[bool, Books]:
    """Whether every node's balance; and what they say."""
    is_balanced, said = True, Books()
    for name, rig in farm.rigs().items():
        dropped = said.setdefault(f"{name} {rig.call('server.info')['pid']}", {})
        for camera in rig.call("stats.get")["cameras"]:
            is_balanced &= camera["due"] == camera["rendered"] + camera["dropped"] and camera["dropped"] == sum(camera["dropped_for"].values())
            for reason, count in camera["dropped_for"].items():
                dropped[reason] = dropped.get(reason, 0) + count
    return is_balanced, said


def dropped_between(before: Books, after: Books) -> dict[str, int]:
    """Of the rigs that are in both."""
    found: dict[str, int] = {}
    for name in before.keys() & after.keys():
        for reason, count in after[name].items():
            if more := count - before[name].get(reason, 0):
                found[reason] = found.get(reason, 0) + more
    return found


def write_json(path: Path, value: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value, indent=1) + "\n")
