"""The log, the lease and the owners of a farm, against a NATS server."""

import asyncio
import contextlib
import json
import socket
import subprocess
import tempfile

import pytest

from camrig.errors import CamrigError
from camrig.farm.live import log as log_module
from camrig.farm.live.door import owner_of
from camrig.farm.live.feed import Feed, raise_if_different
from camrig.farm.live.log import CommandLog, Lease, Overtaken, Subjects, connect
from camrig.farm.live.up import find_nats_server


@contextlib.asynccontextmanager
async def bus():
    with socket.create_server(("127.0.0.1", 0)) as free, tempfile.TemporaryDirectory() as store:
        port = free.getsockname()[1]
        free.close()
        server = subprocess.Popen([find_nats_server(), "-js", "-sd", store, "-a", "127.0.0.1", "-p", str(port)], stderr=subprocess.DEVNULL)
        try:
            for _ in range(100):
                with contextlib.suppress(OSError):
                    client = await connect(f"nats://127.0.0.1:{port}")
                    break
                await asyncio.sleep(0.05)
            yield client
            await client.close()
        finally:
            server.kill()
            server.wait()


def entry(name, at_ns=0):
    return {"kind": "command", "id": name, "at_ns": at_ns, "term": 1, "method": "camera.set", "params": {"name": name}}


def test_who_was_overtaken_cannot_write_and_what_is_sent_twice_comes_once():
    async def run():
        async with bus() as client:
            one, two = (CommandLog(client, Subjects("t")) for _ in range(2))
            await one.open()
            await two.open()
            assert await one.append(entry("a"), 0) == 1
            with pytest.raises(Overtaken):
                await two.append(entry("b"), 0)
            assert await two.append(entry("b"), 1) == 2
            # Not knowing whether it came, its writer sends it again.
            assert await one.append(entry("a"), 0) == 1
            assert await one.append(entry("a"), 2) == 1
            assert await one.last() == 2 and [(await two.read(number))["id"] for number in (1, 2)] == ["a", "b"]

    asyncio.run(run())


def test_a_lease_is_taken_only_when_it_was_not_renewed(monkeypatch):
    monkeypatch.setattr(log_module, "LEASE_S", 0.4)

    async def run():
        async with bus() as client:
            one, two = (Lease(client, Subjects("t"), name) for name in ("one", "two"))
            await one.open()
            await two.open()
            assert await one.keep() and one.term == 1
            for _ in range(4):
                assert not await two.keep()
                await asyncio.sleep(0.15)
                assert await one.keep()
            await two.keep()
            await asyncio.sleep(0.45)  # one was stopped
            assert not one.is_held()
            assert await two.keep() and two.term == 2
            assert not await one.keep()

    asyncio.run(run())


def test_only_the_cameras_of_a_node_that_goes_move():
    cameras, nodes = [f"cam{number}" for number in range(200)], ["a", "b", "c", "d"]
    before = {camera: owner_of(camera, nodes) for camera in cameras}
    after = {camera: owner_of(camera, ["a", "b", "d"]) for camera in cameras}
    assert all(before[camera] == after[camera] for camera in cameras if before[camera] != "c")
    counts = [list(before.values()).count(node) for node in nodes]
    assert min(counts) > 25


def test_the_gate_names_what_differs():
    identity = {"build": "1", "seed": 1, "mathematics": "aa"}
    raise_if_different({"identity": identity}, dict(identity))
    with pytest.raises(CamrigError, match="mathematics is 'bb', the farm's is 'aa'"):
        raise_if_different({"identity": identity}, {**identity, "mathematics": "bb"})


class FakeLog:
    def __init__(self, entries):
        self.entries = entries

    async def read(self, number):
        return self.entries[number - 1]


class FakeRig:
    """Takes lines as a rig does, and answers a command when its world may have come to it."""

    def __init__(self):
        self.lines, self.limit = [], 0
        self._waiting = []

    @property
    def unanswered(self):
        return len(self._waiting)

    def request(self, method, params):
        return {"id": object(), "method": method, "params": params}

    def send(self, message):
        answer = asyncio.get_running_loop().create_future()
        requests = message if isinstance(message, list) else [message]
        for one in requests:
            if one["method"] == "world.limit":
                self.limit = one["params"]["until_ns"]
            else:
                assert one["params"]["at_ns"] > self.limit or one["params"]["at_ns"] == 0, "the world may be past it"
        self.lines += requests
        assert len(self._waiting) < 64, "the rig reads no more"
        self._waiting.append((answer, requests))
        while self._waiting and all(one["params"].get("at_ns", 0) <= self.limit for one in self._waiting[0][1]):
            answered, of = self._waiting.pop(0)
            answered.set_result([{"id": one["id"], "result": {"world_ns": one["params"].get("at_ns")}} for one in of])
        return answer


def test_a_rig_is_told_every_command_before_its_world_may_come_to_its_time():
    """Also who joins an hour late, to thousands of commands."""

    async def run():
        times = sorted([10**9 * second + 7 for second in range(0, 4000, 3)] + [3_000_000_000] * 150)
        begin = {"kind": "begin", "epoch_utc_ns": 0, "identity": {"mode": "realtime"}, "at_ns": 0}
        rig = FakeRig()
        feed = Feed(FakeLog([begin] + [entry(f"c{number}", at_ns) for number, at_ns in enumerate(times)]), rig, {"mode": "realtime"})
        await feed.take(len(times) + 1, 4_100_000_000_000)
        await asyncio.sleep(0)
        told = [one["params"] for one in rig.lines if one["method"] == "camera.set"]
        assert [one["name"] for one in told] == [f"c{number}" for number in range(len(times))]
        assert rig.limit == 4_100_000_000_000 and feed.applied == len(times) + 1
        digests = [one["params"]["at_ns"] for one in rig.lines if one["method"] == "world.digest"]
        assert digests == [10**9 * second for second in range(1, 4101)]

    asyncio.run(run())
