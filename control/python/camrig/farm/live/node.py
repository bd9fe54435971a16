"""A node of a farm: a rig that does what the log says, and perhaps the sequencer of all.

    camrig farm node --name A --nats nats://HOST:4222 --farm lobby --scene hall

The rig is ours: it is killed when this process ends, whatever ends it.
"""

from __future__ import annotations

import asyncio
import ctypes
import json
import os
import signal
import sys
import tempfile
import time
from dataclasses import dataclass
from typing import Any

from ...errors import CamrigError
from ...places import find_binary, find_scene
from .feed import Feed
from .log import RENEW_S, CommandLog, Lease, Subjects, connect
from .sequencer import Sequencer
from .wire import Wire

REPORT_S = 0.5


@dataclass(frozen=True)
class NodeOptions:
    name: str
    farm: str
    nats: str
    scene: str
    mode: str = "realtime"
    seed: int | None = None
    lead_ms: float = 100.0
    args: tuple[str, ...] = ()


def _die_with_parent() -> None:
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Daemon:
    """`camrig serve --held`, as our child."""

    def __init__(self, options: NodeOptions) -> None:
        self._options = options
        self.folder = tempfile.TemporaryDirectory(prefix="camrig-node-")
        self.control = os.path.join(self.folder.name, "rig.sock")
        self.ready: dict[str, Any] = {}

    async def start(self) -> None:
        program = find_binary()
        read_end, write_end = os.pipe()
        command = [program, "serve", find_scene(self._options.scene, program), "--held", "--mode", self._options.mode, "--control", self.control]
        command += ["--http", "0", "--rtsp", "0", "--ready-fd", str(write_end), *self._options.args]
        if self._options.seed is not None:
            command += ["--seed", str(self._options.seed)]
        self.process = await asyncio.create_subprocess_exec(*command, pass_fds=(write_end,), stdout=sys.stderr.fileno(), preexec_fn=_die_with_parent)
        os.close(write_end)
        line = await asyncio.get_running_loop().run_in_executor(None, lambda: os.read(read_end, 65536))
        os.close(read_end)
        if not line:
            raise CamrigError("unavailable", f"the node's rig ended with exit code {await self.process.wait()}")
        self.ready = json.loads(line)

    def kill(self) -> None:
        if self.process.returncode is None:
            self.process.kill()


class Node:
    def __init__(self, options: NodeOptions) -> None:
        self.options = options
        self.subjects = Subjects(options.farm)
        self._mark: dict[str, Any] = {"term": 0, "last": 0, "closed_ns": -1}
        self._marked = asyncio.Event()
        self._parts: dict[int, dict[str, str]] = {}
        self._newest: dict[str, Any] = {}
        self._stop: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    async def run(self) -> int:
        """Until it is told to stop; 3 when that was for being different."""
        self.daemon = Daemon(self.options)
        await self.daemon.start()
        try:
            self.wire = await Wire.open(self.daemon.control)
            self.identity = await self.wire.call("rig.identity")
            self.bus = await connect(self.options.nats)
            self.log = CommandLog(self.bus, self.subjects)
            await self.log.open()
            self.feed = Feed(self.log, self.wire, self.identity)
            lease = Lease(self.bus, self.subjects, self.options.name)
            await lease.open()
            self.sequencer = Sequencer(self.bus, self.subjects, self.log, lease, self.feed, self.identity, self.options.lead_ms)
            await self.bus.subscribe(self.subjects.mark, cb=self._on_mark)
            await self.bus.subscribe(self.subjects.stop, cb=self._on_stop)
            tasks = [asyncio.create_task(each) for each in (self._follow(), self._report(), self._digests(), self._keep(lease), self._watch())]
            await asyncio.wait([*tasks, self._stop], return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                if task.done() and task.exception():
                    raise task.exception()  # type: ignore[misc]
            print(f"camrig farm: node {self.options.name} stops: {self._stop.result() if self._stop.done() else 'its rig has ended'}", file=sys.stderr, flush=True)
            return 3
        finally:
            self.daemon.kill()

    async def _on_mark(self, message: Any) -> None:
        mark = json.loads(message.data)
        if mark["term"] < self._mark["term"]:
            return  # of a sequencer that was overtaken
        self._mark = mark
        self._marked.set()

    async def _on_stop(self, message: Any) -> None:
        told = json.loads(message.data)
        if told["node"] != self.options.name or self._stop.done():
            return
        own = self._parts.get(told["at_ns"], {})
        differs = sorted(name for name in own.keys() | told["parts"].keys() if own.get(name) != told["parts"].get(name))
        self._stop.set_result(f"{told['why']}; what differs: {', '.join(differs[:20]) or 'unknown'}")

    async def _follow(self) -> None:
        while True:
            await self._marked.wait()
            self._marked.clear()
            mark = self._mark
            await self.feed.take(mark["last"], mark["closed_ns"])

    async def _digests(self) -> None:
        while True:
            digest = await self.feed.digests.get()
            self._parts[digest["world_ns"]] = digest["parts"]
            for old in sorted(self._parts)[:-20]:
                del self._parts[old]
            self._newest = {key: digest.get(key) for key in ("world_ns", "hash", "step")}
            await self._say({"digest": self._newest, "parts": digest["parts"]})

    async def _report(self) -> None:
        while True:
            await self._say({})
            await asyncio.sleep(REPORT_S)

    async def _say(self, more: dict[str, Any]) -> None:
        if self.feed.begin is None:
            return  # nobody counts on a node that has not passed the gate
        report = {"node": self.options.name, "applied": self.feed.applied, "at": time.time(), "is_sequencer": self.sequencer.is_active, "pid": os.getpid(),
                  "rig_pid": self.daemon.process.pid, **{key: self.daemon.ready.get(key) for key in ("control", "http", "rtsp", "host")}, **more}
        await self.bus.publish(self.subjects.report, json.dumps(report).encode())

    async def _keep(self, lease: Lease) -> None:
        while True:
            await lease.keep()
            await asyncio.sleep(RENEW_S)

    async def _watch(self) -> None:
        await self.daemon.process.wait()


async def run_node(options: NodeOptions) -> int:
    node = Node(options)
    loop = asyncio.get_running_loop()
    for end in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(end, lambda: node._stop.done() or node._stop.set_result("it was told to"))
    return await node.run()
