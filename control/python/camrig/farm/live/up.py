"""A farm on this machine: a bus, nodes, and the door. On several machines whatever starts programs there starts the same parts, each by
its own command."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any, AsyncIterator, Coroutine, Sequence

from ...command_line import Parser
from ...errors import CamrigError
from ...token_file import read_token
from .clock import WallClock
from .daemon import NodeOptions, die_with_parent
from .door import Door
from .http_access import is_loopback
from .http_door import HttpDoor, serve_metrics, session_of
from .log import Subjects, connect
from .node import run_node
from .socket_door import SocketDoor


#: For nodes to start and come to where the world is; for a NATS server.
_START_S, _BUS_START_S = 90.0, 30.0
#: Before a NATS server that has ended is started again: at first; at most, where each lives no longer than that.
_BUS_PAUSE_S, _BUS_LONGEST_PAUSE_S = 0.2, 10.0


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
        self._leaving: set[str] = set()
        self._scaling = asyncio.Lock()
        self._bus_server: asyncio.subprocess.Process | None = None
        self._is_ending = False
        #: The loop alone may forget a task.
        self._watching: set[asyncio.Task[None]] = set()

    async def run(self) -> int:
        try:
            url = self._options.nats or await self._start_bus()
            bus = await connect(url)
            self._url = url
            self.door = Door(bus, Subjects(self._options.farm))
            await self.door.open()
            control = self._options.control or os.path.join(self._folder.name, "farm.sock")
            await SocketDoor(self.door).open(control)
            for _ in range(self._options.nodes):
                await self._start_node()
            await self._wait_for(self._options.nodes)
            self.door.scale = self._scale
            for camera in json.loads(Path(self._options.cameras).read_text()) if self._options.cameras else []:
                await self.door.call("camera.create", **camera)
            async with _http_of(self.door, self._options) as http:
                _tell_ready({"control": control, "nats": url, "nodes": sorted(self._children)}, http, self._options)
                await self.door.ended.wait()
            return 0
        finally:
            self._is_ending = True
            for children in (list(self._children.values()), [self._bus_server] if self._bus_server else []):  # nodes leave by the bus
                for child in children:
                    with contextlib.suppress(ProcessLookupError):
                        child.terminate()
                await asyncio.gather(*(child.wait() for child in children))
            self._folder.cleanup()

    async def _all_there(self, count: int) -> None:
        while len(self.door.owners()) < count or not any(one["is_sequencer"] for one in self.door.nodes().values()):
            await asyncio.sleep(0.02)

    async def _wait_for(self, count: int) -> None:
        try:
            await asyncio.wait_for(self._all_there(count), _START_S)
        except asyncio.TimeoutError:
            raise CamrigError("unavailable", f"{len(self.door.owners())} of {count} nodes are there after {_START_S:.0f} s") from None

    async def _scale(self, count: int) -> dict[str, Any]:
        """More nodes, or fewer: the youngest go, and tell it before they do."""
        async with self._scaling:
            staying = [name for name in self._children if name not in self._leaving]
            for _ in range(len(staying), count):
                await self._start_node()
            going = staying[count:]
            self._leaving |= set(going)
            for name in going:
                self._children[name].terminate()
            await asyncio.gather(*(self._children[name].wait() for name in going))
            for name in going:
                del self._children[name]
            self._leaving -= set(going)
            await self._wait_for(count)
            return {"nodes": sorted(self._children)}

    async def _start_bus(self) -> str:
        """At any free port, which it writes into a file of its folder: a port that we found free could be another farm's by then."""
        server = await self._start_nats(-1)
        ports = Path(self._folder.name, f"nats-server_{server.pid}.ports")
        for _ in range(round(_BUS_START_S / 0.02)):
            with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):  # half written
                url = str(json.loads(ports.read_text())["nats"][0])
                self._watch(self._keep_bus(server, int(url.rpartition(":")[2])))
                return url
            if server.returncode is not None:
                break
            await asyncio.sleep(0.02)
        raise CamrigError("unavailable", f"the NATS server does not start: {self._last_of_nats()}")

    async def _start_nats(self, port: int) -> asyncio.subprocess.Process:
        folder = self._folder.name
        store = self._options.store or os.path.join(folder, "jetstream")
        command = [find_nats_server(), "-js", "-sd", store, "-a", "127.0.0.1", "-p", str(port), "--ports_file_dir", folder, "-l", os.path.join(folder, "nats.log")]
        self._bus_server = await asyncio.create_subprocess_exec(*command, "--log_size_limit", "1000000", preexec_fn=die_with_parent)
        return self._bus_server

    def _last_of_nats(self) -> str:
        log = Path(self._folder.name, "nats.log")
        return (log.read_text(errors="replace").splitlines() if log.exists() else [""])[-1] or "it says nothing"

    async def _keep_bus(self, server: asyncio.subprocess.Process, port: int) -> None:
        """One that dies is started again where it was, with its log: nobody else would. After a pause that is longer each time, if they
        die at once."""
        loop, pause_s = asyncio.get_running_loop(), _BUS_PAUSE_S
        while True:
            begun_s = loop.time()
            code = await server.wait()
            if loop.time() - begun_s > _BUS_LONGEST_PAUSE_S:
                pause_s = _BUS_PAUSE_S
            await asyncio.sleep(pause_s)
            pause_s = min(2 * pause_s, _BUS_LONGEST_PAUSE_S)
            if self._is_ending:
                return
            print(f"camrig farm: the NATS server has ended ({code}) and is started again: {self._last_of_nats()}", file=sys.stderr, flush=True)
            server = await self._start_nats(port)

    def _watch(self, child: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(child)
        self._watching.add(task)
        task.add_done_callback(self._watching.discard)

    async def _start_node(self) -> None:
        self._count += 1
        name = f"node{self._count}"
        options = self._options
        command = [sys.executable, "-m", "camrig.farm", "node", "--name", name, "--nats", self._url, "--farm", options.farm, "--scene", options.scene,
                   "--mode", options.mode, "--lead-ms", str(options.lead_ms), "--max-skew-ms", str(options.max_skew_ms)]
        command += ["--seed", str(options.seed)] if options.seed is not None else []
        command += [f"--arg={each}" for each in options.arg]
        self._children[name] = child = await asyncio.create_subprocess_exec(*command, preexec_fn=die_with_parent)
        self._watch(self._replace(name, child))

    async def _replace(self, name: str, child: asyncio.subprocess.Process) -> None:
        """Who has gone is forgotten at once, and another takes its place."""
        code = await child.wait()
        self.door.forget(name)
        if self._is_ending or name in self._leaving:
            return
        del self._children[name]
        print(f"camrig farm: node {name} has ended ({code})", file=sys.stderr, flush=True)
        if self._options.replace:
            await self._start_node()


@contextlib.asynccontextmanager
async def _http_of(door: Door, options: argparse.Namespace) -> AsyncIterator[HttpDoor | None]:
    async with session_of(door) as session:
        if options.metrics:
            options.metrics_url = await serve_metrics(door, session, *options.metrics)
        if not options.http:
            yield None
            return
        http = HttpDoor(door, session)
        await http.open(*options.http)
        try:
            yield http
        finally:
            http.close()


def _tell_ready(facts: dict[str, Any], http: HttpDoor | None, options: argparse.Namespace) -> None:
    """On stdout, and on --ready-fd as JSON. The printed link brings the key to the page."""
    if http:
        facts |= {"http": http.url, **({"key_file": http.key_file} if http.key_file else {})}
    if options.metrics:
        facts["metrics"] = options.metrics_url
    if options.ready_fd is not None:
        with os.fdopen(options.ready_fd, "w") as ready:
            ready.write(json.dumps(facts) + "\n")
    shown = facts | ({"http": http.link} if http else {})
    print("camrig farm\n" + "\n".join(f"  {name:8} {' '.join(value) if isinstance(value, list) else value}" for name, value in shown.items()), flush=True)


def _farm_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--farm", default="farm", help="name of the farm on the bus")


def _door_options(parser: argparse.ArgumentParser, http: tuple[str, int] | None = None) -> None:
    parser.add_argument("--control", help="path of the farm's control socket")
    parser.add_argument("--http", metavar="HOST:PORT", type=_address, default=http, help="web page, /rpc, pictures and /metrics of the farm at one address; port 0: any free one")
    parser.add_argument("--metrics", metavar="HOST:PORT", type=_address, help="where /metrics of all nodes is one page; port 0: any free one")
    parser.add_argument("--ready-fd", type=int, help="writes one JSON line here when ready")


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit() or int(port) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not HOST:PORT")
    return host.strip("[]"), int(port)


def _cores(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0 < (cores := float(text)) < 1e4:
            return cores
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of cores")


def _scene_options(parser: argparse.ArgumentParser) -> None:
    _farm_option(parser)
    parser.add_argument("--scene", required=True, help="as camrig serve takes it; the same files on every node")
    parser.add_argument("--mode", choices=["realtime", "lockstep"], default="realtime")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--lead-ms", type=float, default=100.0, help="so long after it was sent a command is applied (realtime)")
    parser.add_argument("--max-skew-ms", type=float, default=5.0, help="a node whose clock is further from the sequencer's has no cameras (realtime)")
    parser.add_argument("--arg", action="append", default=[], help="a further option of camrig serve, as --arg=--device=cpu")


async def _up(options: argparse.Namespace) -> int:
    farm = Farm(options)
    loop = asyncio.get_running_loop()
    task = asyncio.ensure_future(farm.run())

    def end() -> None:
        for number in (signal.SIGTERM, signal.SIGINT):  # another one ends it at once
            loop.remove_signal_handler(number)
        task.cancel()

    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, end)
    with contextlib.suppress(asyncio.CancelledError):
        return await task
    return 0


async def _door(options: argparse.Namespace) -> int:
    token = read_token(options.token_file) if options.token_file else None
    door = Door(await connect(options.nats), Subjects(options.farm), token)
    for end in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(end, door.ended.set)
    await door.open()
    sockets = SocketDoor(door)
    await sockets.open(options.control)
    facts = {"control": options.control, "nats": options.nats}
    if options.tcp:
        facts["tcp"] = f"{options.tcp[0]}:{await sockets.listen(*options.tcp)}"
    async with _http_of(door, options) as http:
        _tell_ready(facts, http, options)
        await door.ended.wait()
    return 0


def up(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm up", description="one world on many nodes, on this machine")
    _scene_options(parser)
    _door_options(parser, http=("127.0.0.1", 0))
    parser.add_argument("--nodes", type=int, default=2)
    parser.add_argument("--cameras", help="file with a list of cameras, as camera.create takes them")
    parser.add_argument("--nats", help="URL of a NATS server with JetStream; default: one is started")
    parser.add_argument("--store", help="folder of the log, of a NATS server that is started; default: gone at the end")
    parser.add_argument("--no-replace", dest="replace", action="store_false", help="no new node in the place of one that has ended")
    options = parser.parse_args(arguments)
    if not is_loopback(options.http[0]):
        parser.error("--http: of loopback only; beyond it camrig farm door --http serves, with --token-file")
    return _run(_up(options))


def door(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm door", description="one control address of a farm")
    _farm_option(parser)
    _door_options(parser)
    parser.add_argument("--nats", required=True, help="URLs of the farm's NATS servers, with commas between them")
    parser.add_argument("--token-file", help="the nodes' token, for those on other machines")
    parser.add_argument("--tcp", metavar="HOST:PORT", type=_address, help="control by TCP too, for clients that have the token; port 0: any free one")
    options = parser.parse_args(arguments)
    if not options.control:
        parser.error("--control: give the path of the socket")
    if options.tcp and not options.token_file:
        parser.error("--tcp: give --token-file too")
    if options.http and not options.token_file and not is_loopback(options.http[0]):
        parser.error("--http: beyond loopback give --token-file too")
    return _run(_door(options))


def node(arguments: Sequence[str]) -> int:
    parser = Parser(prog="camrig farm node", description="one node of a farm")
    _scene_options(parser)
    parser.add_argument("--name", required=True, help="of its own in the farm")
    parser.add_argument("--nats", required=True, help="URLs of NATS servers with JetStream, with commas between them")
    parser.add_argument("--replicas", type=int, default=1, choices=(1, 3, 5), help="NATS servers that keep the log; the same on all nodes")
    parser.add_argument("--host", help="address of this machine at which other machines reach this node; default: this machine alone does")
    parser.add_argument("--token-file", help="as of camrig serve, the same token on all nodes; with --host")
    parser.add_argument("--http", type=int, default=0, help="port; 0: any free one")
    parser.add_argument("--rtsp", type=int, default=0)
    parser.add_argument("--cores", type=_cores, help="of this machine that its cameras may take; default: all that it may use")
    parser.add_argument("--clock-ahead-ms", type=float, default=0.0, help="for tests: what this node takes for its wall clock is so far ahead")
    given = parser.parse_args(arguments)
    if given.host and not given.token_file:
        parser.error("--host: give --token-file too")
    cores = {} if given.cores is None else {"cores": given.cores}
    options = NodeOptions(given.name, given.farm, given.nats, given.scene, given.mode, given.seed, given.lead_ms, given.max_skew_ms,
                          WallClock(round(given.clock_ahead_ms * 1e6)), given.host, given.token_file, given.http, given.rtsp, given.replicas,
                          args=tuple(given.arg), **cores)
    return _run(run_node(options))


def _run(main: Coroutine[Any, Any, int]) -> int:
    """Ends the program: asyncio.run() would wait for the tasks of a connection to a bus that has gone."""
    code = asyncio.new_event_loop().run_until_complete(main)
    sys.stdout.flush()
    os._exit(code)
