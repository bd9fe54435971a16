"""What a node is told, and its rig: `camrig serve --held`, which is killed when the node ends, whatever ends it."""

from __future__ import annotations

import asyncio
import ctypes
import json
import os
import signal
import sys
from dataclasses import dataclass, field
from typing import Any

from ...errors import CamrigError
from ...places import find_binary, find_scene
from ..own_folder import OwnFolder
from .clock import WallClock
from .costs import usable_cores


@dataclass(frozen=True)
class NodeOptions:
    name: str
    farm: str
    nats: str
    scene: str
    mode: str = "realtime"
    seed: int | None = None
    lead_ms: float = 100.0
    max_skew_ms: float = 5.0
    clock: WallClock = WallClock()
    host: str | None = None  #: address of this machine at which others reach the node; with token_file
    token_file: str | None = None
    http: int = 0
    rtsp: int = 0
    replicas: int = 1
    cores: float = field(default_factory=usable_cores)
    args: tuple[str, ...] = ()


_prctl = ctypes.CDLL(None).prctl  # found before a fork: other threads may hold the loader's lock then


def die_with_parent() -> None:
    """For a child to call before it becomes another program: whatever ends us ends it."""
    _prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Daemon:
    """`camrig serve --held`, as our child."""

    def __init__(self, options: NodeOptions) -> None:
        self._options = options
        self._folder = OwnFolder("camrig-node-")
        self.control = str(self._folder.path / "rig.sock")
        self.process: asyncio.subprocess.Process | None = None
        self.ready: dict[str, Any] = {}

    async def start(self) -> None:
        program = find_binary()
        read_end, write_end = os.pipe()
        command = [program, "serve", find_scene(self._options.scene, program), "--held", "--mode", self._options.mode, "--control", self.control]
        command += ["--http", str(self._options.http), "--rtsp", str(self._options.rtsp), "--ready-fd", str(write_end), *self._options.args]
        if self._options.host:
            command += ["--host", self._options.host, "--tcp", "0"]
        if self._options.token_file:
            command += ["--token-file", self._options.token_file]
        if self._options.seed is not None:
            command += ["--seed", str(self._options.seed)]
        self.process = await asyncio.create_subprocess_exec(*command, pass_fds=(write_end,), stdout=sys.stderr.fileno(), preexec_fn=die_with_parent)
        os.close(write_end)
        line = await asyncio.get_running_loop().run_in_executor(None, lambda: os.read(read_end, 65536))
        os.close(read_end)
        if not line:
            raise CamrigError("unavailable", f"the node's rig ended with exit code {await self.process.wait()}")
        self.ready = json.loads(line)

    async def kill(self) -> None:
        if self.process and self.process.returncode is None:
            self.process.kill()
            await self.process.wait()
