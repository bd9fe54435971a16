"""A farm as it stands on several machines: NATS servers, nodes and a door, each a process of its own that can be killed, stopped or cut off."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Sequence

import camrig

from .bus import Bus, run, wait_until

_ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[3] / "control" / "python")}


class Link:
    """A way of TCP connections to a port, which can be down as a pulled cable is: what is sent stays where it is, nothing is closed."""

    def __init__(self, to: int) -> None:
        self._to = to
        listening = socket.create_server(("127.0.0.1", 0))
        self.port = listening.getsockname()[1]
        self._loop = asyncio.new_event_loop()
        self._up = asyncio.Event()
        self._up.set()
        self._ended = asyncio.Event()
        # In its thread alone: an interrupt comes in the main thread, and must not find coroutines there that nobody awaits yet.
        self._thread = threading.Thread(target=self._run, args=(listening,), daemon=True)
        self._thread.start()

    def set_up(self, is_up: bool) -> None:
        self._loop.call_soon_threadsafe(self._up.set if is_up else self._up.clear)

    def close(self) -> None:
        """Its connections too. Once, when nobody needs it any more."""
        self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join(10)

    def _run(self, listening: socket.socket) -> None:
        try:
            self._loop.run_until_complete(self._serve(listening))
        finally:
            self._loop.close()

    async def _serve(self, listening: socket.socket) -> None:
        server = await asyncio.start_server(self._join, sock=listening)
        await self._ended.wait()
        server.close()
        joined = asyncio.all_tasks() - {asyncio.current_task()}
        for task in joined:
            task.cancel()
        await asyncio.gather(*joined, return_exceptions=True)
        await asyncio.sleep(0)  # transports close when the loop comes to it

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await self._up.wait()
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._to)
            await asyncio.gather(self._pump(reader, far_writer), self._pump(far_reader, writer))
        except OSError:
            pass
        finally:
            writer.close()

    async def _pump(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            with contextlib.suppress(OSError):
                while data := await reader.read(65536):
                    await self._up.wait()
                    writer.write(data)
                    await writer.drain()
            await self._up.wait()
        finally:
            writer.close()


class Node:
    """One `camrig farm node`, behind links of its own."""

    def __init__(self, farm: Farm, name: str, *options: str) -> None:
        self.name, self._farm, self._options = name, farm, options
        self._links = [Link(port) for port in farm.bus.ports]
        self.log = farm.folder / f"{name}.log"
        self.start()

    def start(self, *options: str) -> None:
        bus = ",".join(f"nats://127.0.0.1:{link.port}" for link in self._links)
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", self.name, "--nats", bus, "--replicas", str(len(self._links)), "--scene", self._farm.scene,
                   "--mode", self._farm.mode, "--arg=--device=cpu", "--arg=--quality=fast", *self._options, *options]
        self.process = run(command, self.log, env=_ENVIRONMENT)

    def set_link(self, is_up: bool) -> None:
        for link in self._links:
            link.set_up(is_up)

    def signal(self, what: signal.Signals, *, node: bool = True) -> None:
        """To the node and its rig, as if their machine did it; or to its rig alone."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for pid in [*([self.process.pid] if node else []), *map(int, children)]:
            os.kill(pid, what)

    def close_links(self) -> None:
        for link in self._links:
            link.close()

    def kill(self) -> None:
        """Its rig must not outlive it."""
        self.process.kill()
        self.process.wait()


class Farm:
    def __init__(self, folder: Path, scene: str, mode: str = "realtime", nodes: int = 4, node_options: Sequence[str] = (), door_options: Sequence[str] = (), servers: int = 1) -> None:
        """``servers``: of NATS, that keep the log together: 1 or 3."""
        self.folder, self.scene, self.mode = folder, scene, mode
        folder.mkdir(parents=True, exist_ok=True)
        self.control = str(folder / "farm.sock")
        self.nodes: dict[str, Node] = {}
        self.door_process: subprocess.Popen[Any] | None = None
        self.bus = Bus(folder, servers)
        try:
            self.door = self._open_door(door_options)
            for number in range(nodes):
                self.nodes[f"node{number + 1}"] = Node(self, f"node{number + 1}", *node_options)
            self.rig = self._connect()
            self.wait_for_nodes()
        except BaseException:
            self.__exit__()
            raise

    def _open_door(self, options: Sequence[str]) -> dict[str, Any]:
        """What it says when it is there."""
        read_end, write_end = os.pipe()
        command = [sys.executable, "-m", "camrig.farm", "door", "--nats", self.bus.urls, "--control", self.control, "--ready-fd", str(write_end), *options]
        self.door_process = run(command, self.folder / "door.log", env=_ENVIRONMENT, pass_fds=(write_end,))
        os.close(write_end)
        with os.fdopen(read_end) as ready:
            return json.loads(ready.readline())

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
        signal.setitimer(signal.ITIMER_REAL, 0.0)  # whoever interrupted has been heard
        for node in self.nodes.values():
            if node.process.poll() is None:
                node.process.send_signal(signal.SIGCONT)
                node.process.kill()
                node.process.wait()
            node.close_links()
        if self.door_process:
            self.door_process.kill()
            self.door_process.wait()
        self.bus.end()

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


@contextlib.contextmanager
def asked_in_time():
    """Of a time that has passed meanwhile, on a machine that is busy, nothing is told; another refusal is an error."""
    try:
        yield
    except camrig.CamrigError as refused:
        if "is past" not in str(refused):
            raise


def digests_at_one_time(farm: Farm) -> dict[str, str]:
    """Of every node, at the same world time."""
    rigs = farm.rigs()
    if farm.mode == "lockstep":
        return {name: rig.call("world.digest")["hash"] for name, rig in rigs.items()}
    told: dict[str, str] = {}

    def ask(name: str, at_ns: int) -> None:
        with asked_in_time():
            told[name] = rigs[name].call("world.digest", at_ns=at_ns)["hash"]

    for ahead_ns in (1_500_000_000, 5_000_000_000, 8_000_000_000):
        told.clear()
        at_ns = max(rig.status()["world_ns"] for rig in rigs.values()) + ahead_ns
        asking = [threading.Thread(target=ask, args=(name, at_ns)) for name in rigs]
        for each in asking:
            each.start()
        for each in asking:
            each.join(30)
        if len(told) == len(rigs):
            break
    return told


def wait_for_all(farm: Farm) -> int:
    """Until every node says that it has done all of the log; how many entries that are."""
    last = farm.bus.last()
    wait_until(lambda: {node["applied"] for node in farm.status()["nodes"]} == {last}, f"all nodes to have done entry {last}")
    return last


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
