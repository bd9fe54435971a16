"""The log, the lease and the clocks of a farm, against a NATS server; owners of cameras; the page of metrics."""

import asyncio
import contextlib
import json
import pathlib
import subprocess
import tempfile
import time
from types import SimpleNamespace

import pytest

from camrig.errors import CamrigError
from camrig.farm.live import log as log_module
from camrig.farm.live.answers import Answers
from camrig.farm.live.clock import Comparison, Offset, WallClock
from camrig.farm.live.costs import Costs
from camrig.farm.live.feed import Feed, raise_if_different
from camrig.farm.live.log import MAX_ENTRY_BYTES, CommandLog, Lease, Overtaken, Subjects, connect
from camrig.farm.live.metrics import merged
from camrig.farm.live.http_access import check, is_loopback, token_of
from camrig.farm.live import node as node_module
from camrig.farm.live.node import Node
from camrig.farm.live.multipart import join, parts_of
from camrig.farm.live.placement import FULL, ROOM, moves, order_of, owner_of
from camrig.farm.live.roster import Roster
from camrig.farm.live.sequencer import Sequencer
from camrig.farm.live import up
from camrig.farm.live.up import Farm, find_nats_server
from camrig.farm.live.wire import Wire


@contextlib.asynccontextmanager
async def bus():
    with tempfile.TemporaryDirectory() as folder:
        # The server takes a free port, and tells it in a file.
        server = subprocess.Popen([find_nats_server(), "-js", "-sd", f"{folder}/store", "-a", "127.0.0.1", "-p", "-1", "--ports_file_dir", folder, "-l", f"{folder}/log"])
        try:
            client = await connect(await url_of(server, pathlib.Path(folder)))
            yield client
            await client.close()
        finally:
            server.kill()
            server.wait()


async def url_of(server, folder):
    deadline = time.monotonic() + 30
    while True:
        with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):  # not there yet, or half written
            return json.loads((folder / f"nats-server_{server.pid}.ports").read_text())["nats"][0]
        if server.poll() is not None or time.monotonic() > deadline:
            said = folder / "log"
            pytest.fail(f"no NATS server; it said: {said.read_text() if said.exists() else 'nothing'}")
        await asyncio.sleep(0.05)


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
    now = [100.0]
    monkeypatch.setattr(log_module, "time", SimpleNamespace(monotonic=lambda: now[0], time=time.time))

    async def run():
        async with bus() as client:
            one, two = (Lease(client, Subjects("t"), name) for name in ("one", "two"))
            await one.open()
            await two.open()
            assert await one.keep() and one.term == 1
            for _ in range(4):
                assert not await two.keep()
                now[0] += 0.75
                assert await one.keep()
            await two.keep()
            now[0] += 2.25  # one was stopped
            assert not one.is_held()
            assert await two.keep() and two.term == 2
            assert not await one.keep()
            await two.give_back()
            assert not two.is_held() and await one.keep() and one.term == 3

    asyncio.run(run())


def test_only_the_cameras_of_a_node_that_goes_move():
    cameras, nodes = [f"cam{number}" for number in range(200)], ["a", "b", "c", "d"]
    before = {camera: owner_of(camera, nodes) for camera in cameras}
    after = {camera: owner_of(camera, ["a", "b", "d"]) for camera in cameras}
    assert all(before[camera] == after[camera] for camera in cameras if before[camera] != "c")
    counts = [list(before.values()).count(node) for node in nodes]
    assert min(counts) > 25


def loads_of(costs, nodes, moved):
    return {node: sum(cost for camera, cost in costs.items() if owner_of(camera, nodes, moved) == node) for node in nodes}


def test_a_full_node_gives_cameras_to_nodes_with_room_and_they_stay_there():
    nodes = ["a", "b", "c"]
    cameras = [f"cam{number}" for number in range(30)]
    of_a = [camera for camera in cameras if owner_of(camera, nodes) == "a"]
    costs = {camera: 0.3 if camera in of_a else 0.05 for camera in cameras}
    cores = dict.fromkeys(nodes, 2.0)
    assert loads_of(costs, nodes, {})["a"] > FULL * 2
    moved = moves(costs, cores, {})
    assert moved and set(moved) <= set(of_a) and max(loads_of(costs, nodes, moved).values()) <= ROOM * 2
    # Nothing moves back, and nothing on, while nobody is full.
    assert moves({camera: cost / 3 for camera, cost in costs.items()}, cores, moved) == moved
    assert moves({camera: cost * FULL / ROOM * 0.95 for camera, cost in costs.items()}, cores, moved) == moved
    # Of a node that goes, all move; nobody else.
    gone = moved[next(iter(moved))]
    left = [node for node in nodes if node != gone]
    after = moves(dict.fromkeys(cameras, 0.0), {node: 2.0 for node in left}, moved)
    assert after == {camera: node for camera, node in moved.items() if node != gone and order_of(camera, left)[0] != node}


def test_where_all_nodes_are_full_nothing_moves():
    costs = {f"cam{number}": 1.0 for number in range(12)}
    assert moves(costs, {"a": 2.0, "b": 2.0}, {}) == {} and moves(costs, {}, {"cam1": "a"}) == {}


def test_a_clock_is_compared_by_the_quickest_round_trip(monkeypatch):
    one = Comparison()
    assert one.best() is None
    one.add("a", 1_000_000_000, 1_010_000_000, 1_100_000_000)  # asked for 100 ms
    one.add("a", 2_000_000_000, 2_000_500_000, 2_001_000_000)
    best = one.best()
    assert best.ahead_s == pytest.approx(0) and 0.0005 <= best.bound_s < 0.0006
    one.add("b", 2_300_000_000, 2_002_000_000, 2_304_000_000)  # another sequencer
    assert one.best().ahead_s == pytest.approx(0.3) and one.best().bound_s >= 0.002
    assert one.best().is_beyond(0.005) and not Offset(0.006, 0.002).is_beyond(0.005) and Offset(-0.3, 0.002).is_beyond(0.005)


def test_a_rigs_time_is_shared_out_by_pixels(monkeypatch):
    times = iter([(10.0, 1.0), (20.0, 9.0), (30.0, 12.0), (40.0, 60.0)])  # dear at first, as a rig that starts is, and later once more
    now = [0.0, 0.0]
    monkeypatch.setattr("camrig.farm.live.costs.cpu_s", lambda pid: now[1])
    monkeypatch.setattr("camrig.farm.live.costs.time.monotonic", lambda: now[0])
    cameras = [{"name": "big", "size": [200, 100]}, {"name": "small", "size": [100, 100]}, {"name": "idle", "size": [900, 900]}]
    costs = Costs(1)
    told = []
    for rendered, (now[0], now[1]) in zip((5, 15, 25, 35), times):
        told.append(costs.of([{"name": camera["name"], "rendered": 0 if camera["name"] == "idle" else rendered} for camera in cameras], cameras))
    assert told == [{}, {}, *[{"big": 0.2, "small": 0.1}] * 2]


def test_a_report_that_waited_in_a_dead_link_brings_nobody_back(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("camrig.farm.live.roster.time.monotonic", lambda: now[0])
    nodes = Roster()
    report = {"node": "a", "life": "1", "applied": 1, "http": 1}
    assert nodes.hear({**report, "at": 5000.0}) and nodes.live() == ["a"]  # its clock is its own
    now[0] += 5
    assert nodes.live() == []
    assert not nodes.hear({**report, "at": 5000.5}) and nodes.live() == []
    assert nodes.hear({**report, "life": "2", "http": 2, "at": 7.0}) and nodes["a"]["http"] == 2
    assert not nodes.hear({**report, "at": 5001.0}) and nodes["a"]["http"] == 2
    assert nodes.hear({**report, "life": "2", "http": 3, "at": 7.3}) and nodes["a"]["http"] == 3


def test_a_node_whose_clock_is_slower_or_stood_still_is_heard_again(monkeypatch):
    now, own = [100.0], [5000.0]
    monkeypatch.setattr("camrig.farm.live.roster.time.monotonic", lambda: now[0])
    nodes = Roster()

    def later(seconds, its_seconds):
        now[0] += seconds
        own[0] += its_seconds
        return nodes.hear({"node": "a", "life": "1", "at": own[0]})

    assert all(later(0.5, 0.4999) for _ in range(20_000)), "after 10000 s it is 2 s behind"
    assert not later(30, 0.5), "its machine stood still, or a link did"
    heard = [later(0.5, 0.5) for _ in range(10)]
    assert not any(heard[:6]) and all(heard[8:])
    # What comes out of a link that was down: late by less and less.
    now[0] += 30
    assert not any(later(0.002, 0.5) for _ in range(58)) and later(0.002, 1.0)


def test_metrics_of_all_nodes_are_one_page():
    page = "# HELP a_total Of a.\n# TYPE a_total counter\na_total 1\n# HELP b Of b.\n# TYPE b summary\nb{camera=\"x } y\",q=\"0.5\"} 2e-3\nb_sum 4\n"
    assert merged({"n1": page, "n2": page.replace(" 1\n", " 7\n")}) == (
        '# HELP a_total Of a.\n# TYPE a_total counter\na_total{node="n1"} 1\na_total{node="n2"} 7\n'
        '# HELP b Of b.\n# TYPE b summary\nb{node="n1",camera="x } y",q="0.5"} 2e-3\nb_sum{node="n1"} 4\nb{node="n2",camera="x } y",q="0.5"} 2e-3\nb_sum{node="n2"} 4\n')


def test_the_gate_names_what_differs():
    identity = {"build": "1", "seed": 1, "mathematics": "aa"}
    raise_if_different({"identity": identity}, dict(identity))
    with pytest.raises(CamrigError, match="mathematics is 'bb', the farm's is 'aa'"):
        raise_if_different({"identity": identity}, {**identity, "mathematics": "bb"})


class FakeBus:
    def __init__(self):
        self.said = []

    async def publish(self, subject, data):
        self.said.append((subject, json.loads(data)))

    async def subscribe(self, subject, cb):
        raise AssertionError("it is active already")


@contextlib.asynccontextmanager
async def watching(mode):
    """The bus of node a's sequencer, and what gives it a report."""
    bus = FakeBus()
    lease = SimpleNamespace(owner="a", term=1, is_held=lambda: True)
    sequencer = Sequencer(bus, Subjects("t"), None, lease, None, {"mode": mode}, 100.0, WallClock())
    sequencer.is_active = True

    async def report(name, **more):
        say = {"node": name, "life": name, "at": time.monotonic(), "is_behind": False, **more}
        await sequencer._on_report(SimpleNamespace(data=json.dumps(say).encode()))

    yield bus, report
    for task in sequencer.tasks:
        task.cancel()


def stops(bus):
    return [say for subject, say in bus.said if subject.endswith("stop")]


@pytest.mark.parametrize("hashes, stopped", [
    ({"a": "w", "b": "r", "c": "r"}, ["a"]),  # a is the sequencer's
    ({"b": "w", "a": "r", "c": "r"}, ["b"]),
    ({"b": "w", "a": "r"}, ["b"]),  # which is right nobody can know
    ({"a": "r", "b": "r", "c": "r"}, []),
])
def test_of_nodes_that_differ_the_fewer_are_stopped_when_all_have_told(hashes, stopped):
    async def run():
        async with watching("realtime") as (bus, report):
            for name in hashes:
                await report(name)
            for name, value in hashes.items():
                assert not stops(bus)
                await report(name, digest={"world_ns": 10**9, "hash": value}, parts={})
            assert [say["node"] for say in stops(bus)] == stopped

    asyncio.run(run())


def test_a_step_of_no_length_is_compared_with_itself_alone():
    """World time is the same before and after what was commanded between them, and the state is not."""
    async def run():
        async with watching("lockstep") as (bus, report):
            for name in ("a", "b"):
                await report(name)
            for name, step, value in (("a", 2, "before"), ("b", 2, "before"), ("a", 4, "after"), ("b", 4, "after")):
                await report(name, digest={"world_ns": 10**9, "hash": value, "step": step}, parts={})
            assert stops(bus) == []
            await report("a", digest={"world_ns": 10**9, "hash": "right", "step": 5}, parts={})
            await report("b", digest={"world_ns": 10**9, "hash": "wrong", "step": 5}, parts={})
            assert [(say["node"], say["moment"]) for say in stops(bus)] == [("b", [10**9, 5])]

    asyncio.run(run())


def test_a_node_that_was_stopped_and_comes_back_is_one_of_all_again():
    """It is waited for, compared, and answers for what it has done in this life alone."""
    async def run():
        async with watching("lockstep") as (bus, report):
            moments = [{"world_ns": 10**9 * step, "step": step} for step in range(4)]
            for name in ("a", "b", "c"):
                await report(name)
            await report("b", digest={**moments[0], "hash": "wrong"}, parts={})
            for name in ("a", "c"):
                await report(name, digest={**moments[0], "hash": "right"}, parts={})
            assert [(say["node"], say["life"]) for say in stops(bus)] == [("b", "b")]
            await report("b", life="b2")
            for name in ("a", "c"):
                await report(name, digest={**moments[0], "hash": "right"}, parts={})
                await report(name, digest={**moments[1], "hash": "right"}, parts={})
            await report("b", life="b2", digest={**moments[0], "hash": "right"}, parts={})
            assert len(stops(bus)) == 1
            await report("b", life="b2", digest={**moments[1], "hash": "wrong"}, parts={})
            assert [(say["node"], say["life"]) for say in stops(bus)[1:]] == [("b", "b2")], "a node has one vote, however often it came back"

    asyncio.run(run())


def test_a_node_is_stopped_for_what_it_did_in_this_life_alone():
    async def run():
        node = Node(SimpleNamespace(farm="t", name="a"))
        for life in ("of another run", node._life):
            assert not node._stop.done()
            await node._on_stop(SimpleNamespace(data=json.dumps({"node": "a", "life": life, "moment": [5, None], "why": "it differs", "parts": {"x": "1"}}).encode()))
        assert node._stop.result()[1] == "it differs; what differs: x"

    asyncio.run(run())


class FakeLog:
    def __init__(self, entries):
        self.entries = entries

    async def read(self, number):
        return self.entries[number - 1]


def test_answers_are_kept_as_lines_and_given_to_who_asks_before_or_after():
    async def run():
        answers = Answers()
        early = asyncio.ensure_future(answers.of(3))
        await asyncio.sleep(0)
        answers.add([2, 3], json.dumps([{"result": "two"}, {"result": "three"}]).encode())
        answers.add([4], json.dumps({"result": "four"}).encode())
        assert await early == {"result": "three"} and await answers.of(3) == {"result": "three"} and await answers.of(4) == {"result": "four"}
        for number in range(5, 5000):
            answers.add([number], b'{"result":0}')
        with pytest.raises(asyncio.TimeoutError):  # it has been forgotten
            await asyncio.wait_for(answers.of(2), 0.05)
        assert await answers.of(4999) == {"result": 0}

    asyncio.run(run())


class FakeRig:
    """Takes lines as a rig does, and answers a command when its world may have come to it."""

    def __init__(self):
        self.lines, self.limit = [], 0
        self._waiting = []

    @property
    def unanswered(self):
        return len(self._waiting)

    def request(self, method, params):
        return {"id": 0, "method": method, "params": params}

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
        self._waiting.append((answer, message))
        self._answer()
        return answer

    def _answer(self):
        while self._waiting:
            answer, message = self._waiting[0]
            requests = message if isinstance(message, list) else [message]
            if any(one["params"].get("at_ns", 0) > self.limit for one in requests):
                return
            self._waiting.pop(0)
            replies = [{"id": one["id"], "result": {"world_ns": one["params"].get("at_ns")}} for one in requests if "id" in one]
            answer.set_result(json.dumps(replies if isinstance(message, list) else replies[0]).encode())

    def tell(self, notification):
        assert notification["method"] == "world.limit"
        self.limit = notification["params"]["until_ns"]
        self._answer()


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


def test_no_line_is_longer_than_a_rig_takes():
    """60 commands are more than 1 MiB, and two of the longest already."""
    async def run():
        begin = {"kind": "begin", "epoch_utc_ns": 0, "identity": {"mode": "realtime"}, "at_ns": 0}
        lengths = [40_000] * 100 + [MAX_ENTRY_BYTES - 300] * 3 + [10, 900_000, 10, 60_000]
        entries = [{**entry("c", 5), "params": {"name": "x" * length}} for length in lengths]
        assert all(len(json.dumps(each)) <= MAX_ENTRY_BYTES for each in entries)

        async def rig(reader, writer):
            while line := await reader.readline():
                assert len(line) <= 1 << 20
                message = json.loads(line)
                is_batch = isinstance(message, list)
                requests = [one for one in (message if is_batch else [message]) if "id" in one]
                lines.append([one for one in requests if one["method"] == "camera.set"])
                replies = [{"id": one["id"], "result": {"world_ns": 0}} for one in requests]
                if replies:
                    writer.write(json.dumps(replies if is_batch else replies[0]).encode() + b"\n")

        lines = []
        async with served(rig) as wire:
            feed = Feed(FakeLog([begin] + entries), wire, {"mode": "realtime"})
            await feed.take(len(entries) + 1, 10)
            await asyncio.wait_for(feed.answers.of(len(entries) + 1), 20)
            assert [len(one["params"]["name"]) for line in lines for one in line] == lengths
            assert feed.applied == len(entries) + 1 and len([line for line in lines if line]) < 15

    asyncio.run(run())


@contextlib.asynccontextmanager
async def served(rig):
    with tempfile.TemporaryDirectory() as folder:
        server = await asyncio.start_unix_server(rig, f"{folder}/rig.sock", limit=2 << 20)
        wire = await Wire.open({"control": f"{folder}/rig.sock"})
        yield wire
        wire.close()
        server.close()


def test_a_node_ends_when_its_rig_closes_the_wire_on_which_it_is_told_what_to_do():
    async def run():
        async def rig(reader, writer):
            await reader.readline()
            writer.close()

        async with served(rig) as wire:
            feed = Feed(FakeLog([]), wire, {"mode": "lockstep"})
            cut_off = asyncio.ensure_future(feed.until_cut_off())
            assert not (await asyncio.wait([cut_off], timeout=0.05))[0]
            wire.tell({"method": "world.limit"})
            assert "the rig closed the connection" in (await asyncio.wait_for(cut_off, 5)).message

    asyncio.run(run())


def test_a_node_ends_when_its_rig_refuses_a_line_of_commands():
    """It has done none of them, and the other nodes' rigs may have."""
    async def run():
        async def rig(reader, writer):
            await reader.readline()
            writer.write(b'{"error":{"code":-32700,"message":"not JSON"},"id":null,"jsonrpc":"2.0"}\n')

        begin = {"kind": "begin", "epoch_utc_ns": 0, "identity": {"mode": "realtime"}, "at_ns": 0}
        async with served(rig) as wire:
            feed = Feed(FakeLog([begin, entry("a", 5), entry("b", 5)]), wire, {"mode": "realtime"})
            cut_off = asyncio.ensure_future(feed.until_cut_off())
            await feed.take(3, 10)
            assert "not JSON" in (await asyncio.wait_for(cut_off, 5)).message
            assert feed.applied == 0

    asyncio.run(run())


def test_a_node_tells_what_its_cameras_cost_again_after_its_rig_closed_that_wire(monkeypatch):
    """A rig of many clients closes what is idle, and the node would have ended."""
    async def run():
        async def rig(reader, writer):
            served.append(True)
            for _ in range(2 if len(served) != 3 else 0):  # or it takes no more now
                request = json.loads(await reader.readline())
                writer.write(json.dumps({"id": request["id"], "result": {"cameras": len(served)}}).encode() + b"\n")
            writer.close()

        served, told = [], []
        monkeypatch.setattr(node_module, "COST_S", 0.01)
        monkeypatch.setattr(node_module, "Costs", lambda pid: SimpleNamespace(of=lambda *lists: told.append(lists)))
        with tempfile.TemporaryDirectory() as folder:
            server = await asyncio.start_unix_server(rig, f"{folder}/rig.sock")
            node = Node(SimpleNamespace(farm="t", name="a"))
            node.daemon = SimpleNamespace(control=f"{folder}/rig.sock", process=SimpleNamespace(pid=1))
            node._is_behind = lambda: False
            telling = asyncio.ensure_future(node._tell_costs())
            for _ in range(500):
                if len(told) >= 4 or telling.done():
                    break
                await asyncio.sleep(0.01)
            assert not telling.done() and [lists[0] for lists in told[:4]] == [1, 2, 4, 5]
            telling.cancel()
            server.close()

    asyncio.run(run())


class HeldRig:
    """Of a lockstep world, of whose steps the first few end half way: a reader stands still."""

    def __init__(self, given_up):
        self.world_ns, self.given_up, self.done, self.attempts = 0, given_up, [], 0

    def request(self, method, params):
        return {"id": 0, "method": method, "params": params}

    def send(self, message):
        params, answer = message["params"], asyncio.get_running_loop().create_future()
        if message["method"] == "world.step":
            self.attempts += 1
            is_given_up = self.attempts <= self.given_up
            self.world_ns += params["nanoseconds"] // 2 if is_given_up else params["nanoseconds"]
            reply = {"error": {"code": -32000, "message": "the step waits for a reader"}} if is_given_up else {"result": {"world_ns": self.world_ns}}
        else:
            assert self.world_ns == params["at_ns"], "a command of another time"
            self.done.append((params["name"], self.world_ns))
            reply = {"result": {}}
        answer.set_result(json.dumps({"id": 0, **reply}).encode())
        return answer

    async def call(self, method, **_):
        assert method == "world.digest"
        return {"world_ns": self.world_ns, "hash": "", "parts": {}}


@pytest.mark.parametrize("then", ["command", "step"])
def test_a_rig_whose_step_was_held_up_comes_to_where_the_others_are(then):
    async def run():
        step = lambda at_ns: {"kind": "step", "at_ns": at_ns, "to_ns": at_ns + 100, "timeout_s": 10}
        entries = [{"kind": "begin", "epoch_utc_ns": 0, "identity": {"mode": "lockstep"}, "at_ns": 0}, step(0)]
        entries += [entry("late", 100)] if then == "command" else [step(100), entry("late", 200)]
        rig = HeldRig(given_up=3 if then == "command" else 1)
        feed = Feed(FakeLog(entries), rig, {"mode": "lockstep"})
        await feed.take(len(entries), 0)
        assert rig.done == [("late", entries[-1]["at_ns"])] and feed.world_ns == rig.world_ns == entries[-1]["at_ns"]

    asyncio.run(run())


@pytest.mark.parametrize("method, headers, is_guarded, refused", [
    ("POST", {}, False, ""),
    ("POST", {"Origin": "http://127.0.0.1:80", "Sec-Fetch-Site": "same-origin"}, False, ""),
    ("POST", {"Origin": "http://127.0.0.1:81"}, False, "Origin"),
    ("POST", {"Origin": "null"}, False, "Origin"),
    ("POST", {"Origin": "http://[x"}, False, "Origin"),
    ("POST", {"Sec-Fetch-Site": "same-site"}, False, "Sec-Fetch-Site"),
    ("GET", {"Referer": "http://evil.example/127.0.0.1:80", "Sec-Fetch-Site": "cross-site"}, False, ""),
    ("GET", {"Referer": "http://127.0.0.1:80/x"}, True, ""),
    ("GET", {"Referer": "http://evil.example/127.0.0.1:80"}, True, "Referer"),
    ("GET", {"Origin": "http://evil.example", "Referer": "http://127.0.0.1:80/"}, True, "Origin"),
    ("GET", {"Host": "evil.example"}, False, "Host"),
    ("GET", {"Host": "127.evil.example"}, False, "Host"),
    ("GET", {"Host": "Localhost:80"}, False, ""),
    ("GET", {"Host": "[::1]:80"}, False, ""),
    ("GET", {"Host": ""}, False, "Host"),
    ("GET", {"Host": None}, True, ""),
    ("POST", {"Host": None, "Origin": "http://127.0.0.1:80"}, False, "Origin"),
])
def test_pages_of_other_origins_are_kept_out(method, headers, is_guarded, refused):
    asked = {name: value for name, value in {"Host": "127.0.0.1:80", **headers}.items() if value is not None}
    if refused:
        with pytest.raises(CamrigError, match=refused):
            check(method, asked, "127.0.0.1", False, is_guarded)
    else:
        check(method, asked, "127.0.0.1", False, is_guarded)


def test_a_token_comes_in_a_header_field_the_url_or_a_cookie():
    assert token_of({"Authorization": "bearer  a"}, {"token": "b"}, {"camrig_token": "c"}) == "a"
    assert token_of({"Authorization": "Digest a"}, {"token": "b"}, {"camrig_token": "c"}) == "b"
    assert token_of({}, {}, {"camrig_token": "c"}) == "c" and token_of({}, {}, {}) == ""
    assert is_loopback("127.3.4.5") and is_loopback("::1") and not is_loopback("0.0.0.0") and not is_loopback("localhost.example")


def test_parts_of_several_bodies_come_whole_and_end_with_the_first_that_ends():
    def part(name, data):
        return f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\nX-Camera: {name}\r\n\r\n".encode() + data + b"\r\n"

    async def run():
        one, other = asyncio.StreamReader(), asyncio.StreamReader()
        got, held = [], asyncio.Event()

        async def write(some):
            got.append(some)
            await held.wait()

        joining = asyncio.ensure_future(join([parts_of(one), parts_of(other)], write))
        for byte in part("a", b"\r\n\r\n--frame"):  # a picture may hold what looks like a head
            one.feed_data(bytes([byte]))
        other.feed_data(part("b", b"") + part("b", b"xyz") + b"--frame\r\nContent-Length: 9\r\n\r\ncut")
        await asyncio.sleep(0.05)
        assert len(got) == 1  # nobody reads ahead of who takes
        held.set()
        await asyncio.sleep(0.05)
        assert sorted(got) == sorted([part("a", b"\r\n\r\n--frame"), part("b", b""), part("b", b"xyz")]) and not joining.done()
        other.feed_eof()
        await asyncio.wait_for(joining, 5)
        assert len(got) == 3
        for rest in (b"--frame--\r\n\r\n", b"--frame\r\nContent-Length: 99999999\r\n\r\n"):
            ended = asyncio.StreamReader()
            ended.feed_data(part("a", b"1") + rest)
            assert [each async for each in parts_of(ended)] == [part("a", b"1")]

    asyncio.run(run())


@pytest.mark.parametrize("turns", range(9))
def test_all_bodies_end_with_one_also_when_a_part_of_another_has_just_been_written(turns):
    """``turns`` of the loop until one ends: whatever the other one's writer has come to by then."""
    written = []

    async def ends():
        for _ in range(turns):
            await asyncio.sleep(0)
        for part in ():
            yield part

    async def goes_on():
        for _ in range(1000):
            await asyncio.sleep(0)
            yield b"part"

    async def put(part):
        written.append(part)

    async def write(part):
        await asyncio.wait_for(put(part), 10)

    asyncio.run(join([ends(), goes_on()], write))
    assert len(written) < 10


@pytest.mark.parametrize("params", [{"seconds": "1"}, {"seconds": None}, {"seconds": float("nan")}, {"seconds": float("inf")}, {"nanoseconds": True},
                                    {"seconds": 0.1, "timeout_s": 5000}, {"seconds": 0.1, "timeout_s": 0}, {"seconds": 0.1, "timeout_s": "x"}])
def test_a_step_that_no_rig_takes_is_refused_at_once(params):
    sequencer = Sequencer.__new__(Sequencer)
    sequencer._is_lockstep = True
    with pytest.raises(CamrigError) as refused:
        sequencer._step({"at_ns": 0, "params": params})
    assert refused.value.kind == "invalid_argument"
    assert sequencer._step({"at_ns": 5, "params": {"seconds": 0.5}}) == {"at_ns": 5, "kind": "step", "to_ns": 500_000_005, "timeout_s": 10}


def test_a_nats_server_that_dies_at_once_is_started_again_ever_more_seldom(monkeypatch, capsys):
    pauses_s, farm = [], Farm(SimpleNamespace())

    async def dead():
        return 1

    async def start(port):
        assert port == 4222
        return SimpleNamespace(wait=dead)

    async def pause(seconds):
        pauses_s.append(seconds)
        farm._is_ending = len(pauses_s) == 9

    monkeypatch.setattr(farm, "_start_nats", start)
    monkeypatch.setattr(up.asyncio, "sleep", pause)
    asyncio.run(farm._keep_bus(SimpleNamespace(wait=dead), 4222))
    assert pauses_s == [0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 10.0, 10.0, 10.0]
    assert capsys.readouterr().err.count("is started again: it says nothing") == 8
