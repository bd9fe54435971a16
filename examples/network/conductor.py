"""Runs a network of programs on a rig: starts them, beats time in lockstep, writes down the truth, and waits for nobody who has died."""

from __future__ import annotations

import asyncio
import contextlib
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable

import camrig

from .bus import BEAT_S, Bus, Server, environment
from .node import phases
from .nodes import Plan
from . import stage

FIRST_FRAME = 4  # OpenCV throws a device's first picture away; from this one on all cameras have theirs
READY_S = 60.0


class Programs:
    """The processes of a network, by name."""

    def __init__(self, rig: camrig.Rig, plan: Plan, url: str, folder: Path, is_device: bool, is_lockstep: bool) -> None:
        (folder / "plan.json").write_text(json.dumps(plan.to_json(), indent=1) + "\n")
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        self.ends: dict[str, int] = {}
        try:
            for name in plan.names():
                has_camera = name in plan.cameras or name in plan.heads
                command = [rig.program, "--control", rig.control, "exec", "--"] if has_camera and is_device else []
                command += [sys.executable, "-m", "examples.network.program", str(folder / "plan.json"), name, "--bus", url, "--out", str(folder)]
                command += ["--source", stage.source(rig, name, is_device)] if has_camera else []
                command += ["--beat"] if is_lockstep else []
                with (folder / f"{name}.err").open("wb") as errors:
                    self.running[name] = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=errors, stderr=errors, env=environment())
        except BaseException:
            self.stop()
            raise

    def alive(self) -> list[str]:
        """Those that run; who has ended is told apart."""
        for name, child in list(self.running.items()):
            if (code := child.poll()) is not None:
                self.ends[name] = code
                del self.running[name]
        return sorted(self.running)

    def stop(self) -> None:
        for child in self.running.values():
            child.terminate()
        for child in self.running.values():
            try:
                child.wait(5)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


class Conductor:
    """`on_step(number, of)` is called after each step: for a progress line, and for tests that break things meanwhile."""

    def __init__(self, rig: camrig.Rig, plan: Plan, folder: Path, is_device: bool, on_step: Callable[[int, int, Programs], None]) -> None:
        self._rig, self._plan, self._folder, self._is_device, self._on_step = rig, plan, folder, is_device, on_step
        self._watched = [*sorted(plan.cameras), *sorted(plan.heads)]
        self._truth = (folder / "truth.jsonl").open("w")

    def run(self, steps: int) -> dict[str, int]:
        """The ends of programs that ended early: {name: exit code}."""
        with contextlib.ExitStack() as stack:
            stack.enter_context(self._truth)
            server = Server(self._folder)
            stack.callback(server.stop)
            is_lockstep = self._rig.status()["mode"] == "lockstep"
            if not is_lockstep:
                self._rig.resume()
            programs = Programs(self._rig, self._plan, server.url, self._folder, self._is_device, is_lockstep)
            stack.callback(programs.stop)
            asyncio.run(self._run(server.url, programs, steps, is_lockstep))
        return programs.ends

    async def _run(self, url: str, programs: Programs, steps: int, is_lockstep: bool) -> None:
        bus = await Bus.connect(url, "conductor", ("beat.ready", "beat.done"))
        waiting = set(programs.alive())
        deadline = time.monotonic() + READY_S
        while waiting and time.monotonic() < deadline:
            waiting &= set(programs.alive())
            word = await self._word(bus, 0.5)
            waiting.discard(word.get("name"))
        if programs.ends or waiting:
            raise SystemExit("; ".join(f"{name}: {(self._folder / f'{name}.err').read_text().strip()[-500:] or 'is not ready'}" for name in sorted({*programs.ends, *waiting})))
        await (self._lockstep if is_lockstep else self._real_time)(bus, programs, steps)
        await bus.close()

    @staticmethod
    async def _word(bus: Bus, timeout_s: float) -> dict[str, Any]:
        try:
            return await bus.beat(timeout_s)
        except TimeoutError:
            return {}

    async def _lockstep(self, bus: Bus, programs: Programs, steps: int) -> None:
        for step in range(steps):
            now_ns = self._plan.frame_ns(FIRST_FRAME + step)
            expect: dict[str, int] = {}
            for phase in phases(self._plan.rounds):
                await bus.tell("beat.go", phase=phase, t=now_ns, expect=expect)
                if phase == "begin":
                    await asyncio.to_thread(self._advance, programs, now_ns, step == 0)
                    self._write(await asyncio.to_thread(stage.truth_line, self._rig, self._watched))
                expect = await self._all_done(bus, programs, phase, now_ns)
            self._on_step(step + 1, steps, programs)
        await bus.tell("beat.go", phase="end")

    def _advance(self, programs: Programs, now_ns: int, is_first: bool) -> None:
        if is_first:
            self._wait_for_readers(programs)
        self._rig.step(nanoseconds=now_ns - self._rig.status()["world_ns"])

    def _wait_for_readers(self, programs: Programs) -> None:
        """Until every program's stream runs: in lockstep readers get what falls due from then on."""
        deadline = time.monotonic() + READY_S
        while time.monotonic() < deadline:
            reading = {camera["name"] for camera in self._rig.stats()["cameras"] if any(output["readers"] for output in camera["outputs"])}
            if set(programs.alive()) & {*self._plan.cameras, *self._plan.heads} <= reading:
                return
            time.sleep(0.02)
        raise SystemExit(f"not every program has opened its camera within {READY_S:g} s")

    async def _all_done(self, bus: Bus, programs: Programs, phase: str, now_ns: int) -> dict[str, int]:
        """How many messages are on their way to each node. Who has died is not waited for."""
        missing, expect = set(programs.alive()), {}
        deadline = time.monotonic() + BEAT_S
        while missing and time.monotonic() < deadline:
            word = await self._word(bus, 0.2)
            if (word.get("phase"), word.get("t")) == (phase, now_ns):
                missing.discard(word["name"])
                for to, count in word["sent"].items():
                    expect[to] = expect.get(to, 0) + count
            if not word:
                missing &= set(programs.alive())
        if missing:
            raise SystemExit(f"{', '.join(sorted(missing))} did not answer within {BEAT_S:g} s; see {self._folder}")
        return expect

    async def _real_time(self, bus: Bus, programs: Programs, steps: int) -> None:
        """The world runs, and stands for a moment once a period while its truth is written down, as `camrig record` does."""
        period_ns = round(self._plan.period_s * 1e9)
        end_ns = next_ns = self._rig.status()["world_ns"]
        end_ns += steps * period_ns
        written_ns = -1
        while next_ns < end_ns:
            now_ns = self._rig.status()["world_ns"]
            if now_ns < next_ns:
                await asyncio.sleep((next_ns - now_ns) / 1e9)
                continue
            next_ns += max(1, (now_ns - next_ns) // period_ns + 1) * period_ns
            line = await asyncio.to_thread(self._standing_truth)
            # Cameras that draw later than the world runs may show no newer instant yet.
            if line["t"] > written_ns:
                self._write(line)
                written_ns = line["t"]
            programs.alive()
            self._on_step(steps - max(0, (end_ns - next_ns) // period_ns), steps, programs)

    def _standing_truth(self) -> dict[str, Any]:
        self._rig.pause()
        try:
            return stage.truth_line(self._rig, self._watched)
        finally:
            self._rig.resume()

    def _write(self, line: dict[str, Any]) -> None:
        self._truth.write(json.dumps(line, separators=(",", ":")) + "\n")
