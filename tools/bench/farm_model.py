"""A model of farms of up to 1000 nodes, by discrete events (simpy), with what was measured on few nodes as its numbers. Writes docs/farm-model.md.

    python -m tools.bench.farm_model            prints the tables
    python -m tools.bench.farm_model --write    and puts them into the page

Three parts that have nothing to do with each other: the command log of one world on many nodes, cameras that move when nodes die, and data sets.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import shutil
import socket
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from typing import Iterator

import numpy as np
import simpy

from . import report

HOUR_S, DAY_S = 3600.0, 86400.0
#: z of the 99th percentile.
_P99 = 2.326


#: Of the sequencer, or three in a lead that is shorter than 100 ms.
MARKS_PER_S = 30


@dataclass(frozen=True)
class Measured:
    """Seconds, but for what says otherwise. Where from: docs/farm-model.md."""

    ack_p50: float = 1.2e-3  #: JetStream, three replicas: of a write until it is acknowledged
    ack_p99: float = 4.5e-3
    fan_out: float = 1.0e-6  #: NATS: of the server, a message to one more subscriber
    lease: float = 2.0
    renewal: float = 0.5
    first_frame: float = 0.1
    ray_notices_dead: float = 16.1
    ray_notices_hung: float = 63.8
    shard_cost: float = 0.9  #: of a shard beside its frames
    hand_out: float = 1e-3  #: of who hands out shards, for each


@dataclass(frozen=True)
class Network:
    """One way: at least `delay`, with a lognormal part of that median, and a resent segment (200 ms, Linux's least) once in 1/`loss`."""

    name: str
    delay: float
    jitter: float
    loss: float = 1e-5

    def delays(self, random: np.random.Generator, count: int) -> np.ndarray:
        return self.delay + self.jitter * random.lognormal(0, 1, count) + np.where(random.random(count) < self.loss, 0.2 + 2 * self.delay, 0)


NETWORKS = (Network("one rack", 50e-6, 50e-6), Network("campus", 1e-3, 0.3e-3), Network("country", 15e-3, 2e-3))


@dataclass
class Held:
    """How long nodes waited for the log."""

    node_seconds: float = 0.0
    held_seconds: float = 0.0
    holds: int = 0

    @property
    def share(self) -> float:
        return self.held_seconds / self.node_seconds


def log(nodes: int, network: Network, lead: float, seconds: float, measured: Measured = Measured(), commands_per_s: float = 100, watermark: float = 1 / MARKS_PER_S,
        step: float = 0.01, seed: int = 1) -> Held:
    """One sequencer stamps commands `lead` ahead and writes them; a watermark every `watermark` closes steps as far as nothing unacknowledged can apply in them.
    A node runs a step when it knows it closed: later than its time, it was held."""
    random, env, held = np.random.default_rng(seed), simpy.Environment(), Held(node_seconds=nodes * seconds)
    unacknowledged: dict[int, int] = {}
    sigma = math.log(measured.ack_p99 / measured.ack_p50) / _P99

    def command(number: int, apply_step: int) -> Iterator[simpy.Event]:
        unacknowledged[number] = apply_step
        yield env.timeout(measured.ack_p50 * random.lognormal(0, sigma))
        del unacknowledged[number]

    def clients() -> Iterator[simpy.Event]:
        number = 0
        while True:
            yield env.timeout(random.exponential(1 / commands_per_s))
            number += 1
            env.process(command(number, math.ceil((env.now + lead) / step)))

    def sequencer() -> Iterator[simpy.Event]:
        closed = int(lead / step) - 1
        while True:
            yield env.timeout(min(watermark, lead / 3))
            now_closed = min([int((env.now + lead) / step) - 1, *(apply_step - 1 for apply_step in unacknowledged.values())])
            if now_closed <= closed:
                continue
            # Entries went the same way before it, so who has the watermark has them, or waits for the same resent segment.
            arrival = env.now + np.arange(nodes) * measured.fan_out + network.delays(random, nodes)
            late = np.maximum(0, arrival - (closed + 1) * step)
            held.held_seconds += float(late.sum())
            held.holds += int((late > 0).sum())
            closed = now_closed

    env.process(clients())
    env.process(sequencer())
    env.run(seconds)
    return held


def moves(nodes: int, cameras: int, notices: float, lead: float, days: float, measured: Measured = Measured(), mtbf_h: float = 1000, repair: float = 300,
          seed: int = 1) -> tuple[list[float], float]:
    """Nodes die; their cameras are back when that was noticed, told and a first frame was drawn. `notices` 0: by our lease. Gives the times of the moves and
    the share of camera time that is lost."""
    random, env, times = np.random.default_rng(seed), simpy.Environment(), list[float]()

    def node() -> Iterator[simpy.Event]:
        while True:
            yield env.timeout(random.exponential(mtbf_h * HOUR_S))
            # Renewed last some time ago, which the lease has run since.
            seen_s = measured.lease - random.uniform(0, measured.renewal) if notices == 0 else notices
            times.append(seen_s + lead + random.uniform(0, measured.first_frame))
            yield env.timeout(repair)

    for _ in range(nodes):
        env.process(node())
    env.run(days * DAY_S)
    return times, cameras * sum(times) / (nodes * cameras * days * DAY_S)


@dataclass
class Batch:
    seconds: float
    useful: float  #: node seconds of frames that count
    lost_shards: int
    nodes: int

    @property
    def efficiency(self) -> float:
        return self.useful / (self.nodes * self.seconds)


def batch(nodes: int, shards: int, shard_s: float, measured: Measured = Measured(), mtbf_h: float = 1000, repair: float = 300, seed: int = 1) -> Batch:
    """Shards of `shard_s` of drawing (lognormal, 20 %), handed out one after the other by one program; a shard of a node that dies is begun anew when Ray has
    noticed. One node takes one shard at a time."""
    random, env = np.random.default_rng(seed), simpy.Environment()
    waiting, desk, done = simpy.Store(env), simpy.Resource(env), env.event()
    result, left = Batch(0, 0, 0, nodes), shards
    for number in range(shards):
        waiting.put(shard_s * random.lognormal(0, 0.2))

    def back(length: float) -> Iterator[simpy.Event]:
        yield env.timeout(measured.ray_notices_dead)
        waiting.put(length)

    def node() -> Iterator[simpy.Event]:
        nonlocal left
        dies_at = env.now + random.exponential(mtbf_h * HOUR_S)
        while True:
            length = yield waiting.get()
            with desk.request() as turn:
                yield turn
                yield env.timeout(measured.hand_out)
            takes = length + measured.shard_cost
            if env.now + takes >= dies_at:
                yield env.timeout(max(0, dies_at - env.now))
                result.lost_shards += 1
                env.process(back(length))
                yield env.timeout(repair)
                dies_at = env.now + random.exponential(mtbf_h * HOUR_S)
                continue
            yield env.timeout(takes)
            result.useful += length
            left -= 1
            if left == 0:
                done.succeed()

    for _ in range(nodes):
        env.process(node())
    env.run(done)
    result.seconds = env.now
    return result


def measure_fan_out(subscribers: int = 64, messages: int = 20_000, size: int = 60) -> float:
    """Seconds that nats-server takes to send a message of that size to one more subscriber, on this machine."""
    program = shutil.which("nats-server")
    assert program, "nats-server is not installed (tools/setup)"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        server = subprocess.Popen([program, "-a", "127.0.0.1", "-p", str(port)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            readers = [_connect(port) for _ in range(subscribers)]
            for reader in readers:
                _say(reader, b"SUB w 1\r\n")
            writer = _connect(port)
            expected = messages * len(b"MSG w 1 %d\r\n\r\n" % size) + messages * size

            def read(reader: socket.socket) -> None:
                got, buffer = 0, bytearray(1 << 18)
                while got < expected and (count := reader.recv_into(buffer)):
                    got += count

            threads = [threading.Thread(target=read, args=(reader,)) for reader in readers]
            for thread in threads:
                thread.start()
            begin = time.monotonic()
            writer.sendall((b"PUB w %d\r\n" % size + b"x" * size + b"\r\n") * messages)
            for thread in threads:
                thread.join(60)
            assert not any(thread.is_alive() for thread in threads), "nats-server did not deliver everything"
            return (time.monotonic() - begin) / (subscribers * messages)
        finally:
            server.kill()
            server.wait()


def _connect(port: int) -> socket.socket:
    for _ in range(200):
        try:
            made = socket.create_connection(("127.0.0.1", port), timeout=30)
            made.recv(4096)  # INFO
            _say(made, b'CONNECT {"verbose":false}\r\n')
            return made
        except ConnectionRefusedError:
            time.sleep(0.02)
    raise AssertionError("nats-server does not listen")


def _say(to: socket.socket, text: bytes) -> None:
    """And waits until the server has heard it."""
    to.sendall(text + b"PING\r\n")
    answer = b""
    while not answer.endswith(b"PONG\r\n"):
        answer += to.recv(4096)


def measure_hand_out(shards: int = 2000) -> float:
    """Seconds that `camrig farm record` takes for each shard beside the drawing: what it does for one that a worker has drawn."""
    import sys

    from camrig.farm.batch import pools, record
    from camrig.farm.batch.shard import Pictures, Shard
    from camrig.farm.batch.store import Store

    class Nothing:
        slots = 1000

        def __init__(self) -> None:
            self._names: list[str] = []

        def submit(self, name: str, job: dict) -> None:
            self._names.append(name)

        def finished(self, timeout_s: float) -> list[tuple[str, pools.Answer]]:
            names, self._names = self._names, []
            return [(name, {"told": {"frames": 1}}) for name in names]

    made = [Shard("hall", "", "", seed, 0, 1, None, {}, [], "fast", "cpu", Pictures()) for seed in range(shards)]
    options = argparse.Namespace(verify=0.001, max_retries=3, max_failed=20, timeout_s=1.0)
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as quiet:
        before, sys.stderr = sys.stderr, quiet
        try:
            store = Store(folder)
            store.shards.mkdir()
            begin = time.monotonic()
            record.Run(store, made, options).run(Nothing())
            return (time.monotonic() - begin) / shards
        finally:
            sys.stderr = before


# The tables

LEADS = (0.03, 0.05, 0.075, 0.1, 0.15, 0.25, 0.4)
_ENOUGH = 1e-4


def log_table(measured: Measured, seconds: float = 120) -> str:
    lines = ["| network, nodes | least lead for under 0.01 % held | held at 100 ms | holds a node an hour at 100 ms | watermarks, MB/s out of the server | entries, MB/s |", "|---|---|---|---|---|---|"]
    for network in NETWORKS:
        for nodes in (10, 100, 1000):
            of = {lead: log(nodes, network, lead, seconds, measured) for lead in LEADS}
            least = next((f"{lead * 1e3:.0f} ms" for lead in LEADS if of[lead].share < _ENOUGH), f"over {LEADS[-1] * 1e3:.0f} ms")
            usual = of[0.1]
            lines.append(f"| {network.name}, {nodes} | {least} | {100 * usual.share:.4f} % | {usual.holds / usual.node_seconds * HOUR_S:.1f} | {MARKS_PER_S * nodes * 60 / 1e6:.2f} | {100 * nodes * 300 / 1e6:.1f} |")
    size_gb = 100 * 300 * DAY_S / 1e9
    return "\n".join(lines) + f"\n\nThe log grows by {size_gb:.1f} GB a day at 100 commands a second of 300 bytes; a server of one core sends {1 / measured.fan_out / 1e6:.1f} million messages a second, the watermarks of 1000 nodes are {MARKS_PER_S / 1e3:.2f}."


def moves_table(measured: Measured, days: float = 200) -> str:
    lines = ["| noticed by | cameras back after, median | 99th percentile | camera seconds lost a day, of 1000 nodes with 8 cameras each | share |", "|---|---|---|---|---|"]
    for name, notices in (("our lease (2 s)", 0.0), ("Ray, process dead", measured.ray_notices_dead), ("Ray, machine hangs", measured.ray_notices_hung), ("Kubernetes (40 s, tolerated for 300 s)", 340.0)):
        times, share = moves(1000, 8, notices, 0.1, days, measured)
        lines.append(f"| {name} | {np.median(times):.1f} s | {np.percentile(times, 99):.1f} s | {share * 8000 * DAY_S:.0f} | {share:.1e} |")
    return "\n".join(lines)


def batch_table(measured: Measured) -> str:
    lines = ["| drawing of a shard | 10 nodes | 100 nodes | 1000 nodes | shards begun anew, 1000 nodes | 100 shards a node, 1000 nodes |", "|---|---|---|---|---|---|"]
    for shard_s in (5, 30, 120, 600, 3600):
        of = {nodes: batch(nodes, 20 * nodes, shard_s, measured) for nodes in (10, 100, 1000)}
        endless = batch(1000, 100_000, shard_s, measured).efficiency
        lines.append(f"| {shard_s} s | " + " | ".join(f"{100 * one.efficiency:.1f} %" for one in of.values()) + f" | {of[1000].lost_shards} of 20000 | {100 * endless:.1f} % |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.bench.farm_model", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="into docs/farm-model.md")
    options = parser.parse_args()
    measured = dataclasses.replace(Measured(), fan_out=measure_fan_out(), hand_out=measure_hand_out())
    here = f"Measured now: {measured.fan_out * 1e6:.2f} us a message and subscriber, {measured.hand_out * 1e3:.2f} ms a shard that is handed out."
    for name, text in (("measured", here), ("log", log_table(measured)), ("moves", moves_table(measured)), ("batch", batch_table(measured))):
        print(f"{name}\n{text}\n", flush=True)
        if options.write:
            report.put(report.REPOSITORY / "docs" / "farm-model.md", name, text, "`python -m tools.bench.farm_model --write`")


if __name__ == "__main__":
    main()
