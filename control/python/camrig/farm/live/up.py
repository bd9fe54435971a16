"""A farm on this machine: a bus, nodes, and the door. On several machines the same parts are started by whatever starts things there."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import shutil
import signal
import socket
import sys
import tempfile
from pathlib import Path
from typing import Any, Sequence

from ...errors import CamrigError
from .door import Door
from .log import Subjects, connect
from .node import NodeOptions, run_node


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def find_nats_server() -> str:
    for program in (os.environ.get("CAMRIG_NATS_SERVER"), shutil.which("nats-server"), str(Path(sys.executable).parent / "nats-server")):
        if program and os.access(program, os.X_OK):
            return program
    raise CamrigError("unavailable", "no nats-server: install Debian's package nats-server, or give --nats URL of one with JetStream")


class Farm:
    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._folder = tempfile.TemporaryDirectory(prefix="camrig-farm-")
        self._count = 0
        self._children: dict[str, asyncio.subprocess.Process] = {}
        self._bus_server: asyncio.subprocess.Process | None = None

    async def run(self) -> int:
        try:
            url = self._options.nats or await self._start_bus()
            bus = await self._connect(url)
            self._url = url
            self.door = Door(bus, Subjects(self._options.farm), self._options.control or os.path.join(self._folder.name, "farm.sock"))
            await self.door.open()
            for _ in range(self._options.nodes):
                await self._start_node()
            await asyncio.wait_for(self._all_there(), 90)
            for camera in json.loads(Path(self._options.cameras).read_text()) if self._options.cameras else []:
                await self.door.call("camera.create", **camera)
            self._tell_ready()
            await self.door.ended.wait()
            return 0
        finally:
            for child in [*self._children.values(), *([self._bus_server] if self._bus_server else [])]:
                with contextlib.suppress(ProcessLookupError):
                    child.terminate()
            await asyncio.gather(*(child.wait() for child in [*self._children.values(), *([self._bus_server] if self._bus_server else [])]))

    async def _all_there(self) -> None:
        while len(self.door.live()) < self._options.nodes or not any(one["is_sequencer"] for one in self.door.nodes().values()):
            await asyncio.sleep(0.02)

    async def _connect(self, url: str) -> Any:
        for _ in range(100):
            try:
                return await connect(url)
            except OSError:
                await asyncio.sleep(0.05)
        raise CamrigError("unavailable", f"no NATS server at {url}")

    async def _start_bus(self) -> str:
        port = _free_port()
        store = self._options.store or os.path.join(self._folder.name, "jetstream")
        self._bus_server = await asyncio.create_subprocess_exec(find_nats_server(), "-js", "-sd", store, "-a", "127.0.0.1", "-p", str(port), stderr=asyncio.subprocess.DEVNULL)
        return f"nats://127.0.0.1:{port}"

    async def _start_node(self) -> None:
        self._count += 1
        name = f"node{self._count}"
        options = self._options
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", name, "--nats", self._url, "--farm", options.farm, "--scene", options.scene,
                   "--mode", options.mode, "--lead-ms", str(options.lead_ms)]
        command += ["--seed", str(options.seed)] if options.seed is not None else []
        command += [f"--arg={each}" for each in options.arg]
        self._children[name] = child = await asyncio.create_subprocess_exec(*command)
        asyncio.create_task(self._replace(name, child))

    async def _replace(self, name: str, child: asyncio.subprocess.Process) -> None:
        """Who has gone is forgotten at once, and another takes its place."""
        code = await child.wait()
        if self.door.ended.is_set():
            return
        self.door.forget(name)
        print(f"camrig farm: node {name} has ended ({code})", file=sys.stderr, flush=True)
        if self._options.replace:
            await self._start_node()

    def _tell_ready(self) -> None:
        facts = {"control": self.door.path, "nats": self._url, "nodes": sorted(self._children)}
        if self._options.ready_fd is not None:
            with os.fdopen(self._options.ready_fd, "w") as ready:
                ready.write(json.dumps(facts) + "\n")
        print(f"camrig farm  {len(self._children)} nodes\n  control  {self.door.path}\n  nats     {self._url}", flush=True)


def _scene_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", required=True, help="as camrig serve takes it; the same files on every node")
    parser.add_argument("--farm", default="farm", help="name of the farm on the bus")
    parser.add_argument("--mode", choices=["realtime", "lockstep"], default="realtime")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--lead-ms", type=float, default=100.0, help="so long after it was sent a command is applied (realtime)")
    parser.add_argument("--arg", action="append", default=[], help="a further option of camrig serve, as --arg=--device=cpu")


async def _up(options: argparse.Namespace) -> int:
    farm = Farm(options)
    loop = asyncio.get_running_loop()
    task = asyncio.ensure_future(farm.run())
    for end in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(end, lambda: farm.door.ended.set() if hasattr(farm, "door") else task.cancel())
    return await task


def up(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="camrig farm up", description="one world on many nodes, on this machine")
    _scene_options(parser)
    parser.add_argument("--nodes", type=int, default=2)
    parser.add_argument("--cameras", help="file with a list of cameras, as camera.create takes them")
    parser.add_argument("--control", help="path of the farm's control socket")
    parser.add_argument("--nats", help="URL of a NATS server with JetStream; default: one is started")
    parser.add_argument("--store", help="folder of the log, of a NATS server that is started; default: gone at the end")
    parser.add_argument("--no-replace", dest="replace", action="store_false", help="no new node in the place of one that has ended")
    parser.add_argument("--ready-fd", type=int, help="writes one JSON line here when ready")
    return asyncio.run(_up(parser.parse_args(arguments)))


def node(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="camrig farm node", description="one node of a farm")
    _scene_options(parser)
    parser.add_argument("--name", required=True, help="of its own in the farm")
    parser.add_argument("--nats", required=True, help="URL of a NATS server with JetStream")
    given = parser.parse_args(arguments)
    options = NodeOptions(given.name, given.farm, given.nats, given.scene, given.mode, given.seed, given.lead_ms, tuple(given.arg))
    return asyncio.run(run_node(options))
