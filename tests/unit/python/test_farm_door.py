"""The control sockets of a farm's door, before a door that answers what the tests want: what strangers and clients may make it hold."""

import asyncio
import contextlib
import json
import socket
import time

import pytest

from camrig.errors import CamrigError
from camrig.farm.live import budget as budget_module
from camrig.farm.live import socket_door, wires, wrong_tokens
from camrig.farm.live.budget import PIECE_BYTES, Budget, Claim, read_exactly, read_line
from camrig.farm.live.door import Client, Door
from camrig.farm.live.log import Subjects
from camrig.farm.live.wire import line_of
from camrig.farm.live.wrong_tokens import WrongTokens

MIB = 1 << 20


def reader_of(*pieces):
    reader = asyncio.StreamReader(limit=PIECE_BYTES)
    for piece in pieces:
        reader.feed_data(piece)
    reader.feed_eof()
    return reader


@pytest.mark.parametrize("line", [b"\n", b"x" * 100 + b"\n", b"x" * (PIECE_BYTES - 1) + b"\n", b"x" * PIECE_BYTES + b"\n", b"x" * (5 * PIECE_BYTES + 3) + b"\n"])
def test_a_line_is_read_whole_and_counted(line):
    async def run():
        all_of = Budget()
        claim = Claim(all_of)
        reader = reader_of(line, b"next\nlast")
        assert await read_line(reader, claim) == line and all_of.used == len(line)
        assert await read_line(reader, claim) == b"next\n" and await read_line(reader, claim) == b"last" and await read_line(reader, claim) == b""
        claim.release()
        assert all_of.used == 0

    asyncio.run(run())


def test_no_line_no_client_and_not_all_together_hold_more_than_is_allowed(monkeypatch):
    monkeypatch.setattr(budget_module, "MOST_BYTES", 6 * PIECE_BYTES)

    async def run():
        all_of = Budget(8 * PIECE_BYTES)
        one, two = Claim(all_of), Claim(all_of)
        with pytest.raises(CamrigError, match="a line has at most 4096 bytes"):
            await read_line(reader_of(b"x" * 5000 + b"\n"), one, 4096)
        await read_line(reader_of(b"x" * (4 * PIECE_BYTES) + b"\n"), one)
        with pytest.raises(CamrigError, match="a request with its answer"):
            await read_exactly(reader_of(b"x" * 3 * PIECE_BYTES), 3 * PIECE_BYTES, one)
        with pytest.raises(CamrigError, match="for all clients and they are in use") as full:
            await read_line(reader_of(b"x" * (5 * PIECE_BYTES) + b"\n"), two)
        assert full.value.kind == "resource_exhausted"
        two.release()
        one.release()
        assert all_of.used == 0
        await read_line(reader_of(b"x" * (5 * PIECE_BYTES) + b"\n"), two)

    asyncio.run(run())


class FakeDoor:
    """Its answer is as long as it was asked for."""

    token = "0123456789abcdef"

    def __init__(self):
        self.budget, self.wrong_tokens = Budget(), WrongTokens()

    async def answer(self, line, client):
        try:
            size = json.loads(line)["params"]["size"]
            client.claim.grow(size)
        except CamrigError as problem:
            return line_of({"error": problem.kind})
        return b"x" * (size - 1) + b"\n"


@contextlib.asynccontextmanager
async def sockets(tmp_path):
    door = FakeDoor()
    opened = socket_door.SocketDoor(door)
    await opened.open(str(tmp_path / "door.sock"))
    yield door, str(tmp_path / "door.sock"), await opened.listen("127.0.0.1", 0)


def asking(size):
    return line_of({"method": "x", "params": {"size": size}})


async def wait_until(condition):
    for _ in range(3000):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise TimeoutError


def test_clients_that_do_not_read_are_closed_and_what_they_held_is_free_again(tmp_path, monkeypatch):
    monkeypatch.setattr(socket_door, "_STALLED_S", 5.0)  # in which all four must have been answered

    async def run():
        async with sockets(tmp_path) as (door, path, _):
            idle = []
            for number in range(4):
                reader, writer = await asyncio.open_unix_connection(path, limit=1024)
                writer.write(asking(60 * MIB))
                idle.append((reader, writer))
            await wait_until(lambda: door.budget.used > 239 * MIB)
            reader, writer = await asyncio.open_unix_connection(path, limit=100 * MIB)
            writer.write(asking(60 * MIB))
            assert json.loads(await reader.readline()) == {"error": "resource_exhausted"}
            await wait_until(lambda: door.budget.used == 0)
            writer.write(asking(60 * MIB))
            assert len(await reader.readline()) == 60 * MIB
            # One that is slow, but reads, gets all of it.
            slow, writer = await asyncio.open_unix_connection(path, limit=PIECE_BYTES)
            writer.write(asking(4 * MIB))
            got = 0
            while got < 4 * MIB:
                some = await slow.read(MIB // 4)
                assert some, "it was closed"
                got += len(some)
                await asyncio.sleep(0.1)
            await wait_until(lambda: door.budget.used == 0)

    asyncio.run(run())


def test_lines_and_clients_are_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(socket_door, "_MAX_CLIENTS", 3)

    async def run():
        async with sockets(tmp_path) as (door, path, _):
            clients = [await asyncio.open_unix_connection(path) for _ in range(3)]
            for reader, writer in clients:
                writer.write(asking(10))
                assert await reader.readline() == b"x" * 9 + b"\n"
            reader, _ = await asyncio.open_unix_connection(path)
            assert json.loads(await reader.readline())["error"]["message"].startswith("there are 3 connections")
            reader, writer = clients[0]
            writer.write(b"x" * (5 * MIB))
            assert "a line has at most" in json.loads(await reader.readline())["error"]["message"] and await reader.read() == b""
            await wait_until(lambda: door.budget.used == 0)
            reader, writer = await asyncio.open_unix_connection(path)
            writer.write(asking(10))
            assert await reader.readline() == b"x" * 9 + b"\n"

    asyncio.run(run())


def test_a_wrong_token_is_answered_late_counted_and_told(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(wrong_tokens, "WAIT_S", 1.0)

    async def show(port, first):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        began = asyncio.get_running_loop().time()
        writer.write(first)
        line = await reader.readline()
        return json.loads(line) if line else None, asyncio.get_running_loop().time() - began, reader, writer

    def auth(token):
        return line_of({"jsonrpc": "2.0", "id": 7, "method": "auth", "params": {"token": token}})

    async def run():
        async with sockets(tmp_path) as (door, _, port):
            for _ in range(3):
                reply, took_s, reader, _ = await show(port, auth("fedcba9876543210"))
                assert reply["error"]["data"]["kind"] == "unauthorized" and reply["id"] == 7 and took_s > 0.9 and await reader.read() == b""
            assert door.wrong_tokens.count == 3
            for other in (b'{"method":"world.status"}\n', b"x\n", b"[]\n", b"x" * 10_000):
                await show(port, other)
            assert door.wrong_tokens.count == 3
            reply, took_s, reader, writer = await show(port, auth(door.token))
            assert reply == {"jsonrpc": "2.0", "id": 7, "result": {"authorized": True}} and took_s < 0.9
            writer.write(asking(10))
            assert await reader.readline() == b"x" * 9 + b"\n"

    asyncio.run(run())
    assert capsys.readouterr().err.count("127.0.0.1 has sent a wrong token; 1 since the start") == 1


@pytest.mark.parametrize("token, said", [("fedcba9876543210", "this is not the token"), (None, "node far: its rig on 127.0.0.1 asks for the farm's token; give --token-file")])
def test_a_nodes_rig_that_refuses_the_doors_token_is_no_dead_node(tmp_path, token, said):
    refusal = line_of({"jsonrpc": "2.0", "id": 0, "error": {"code": -32000, "message": "this is not the token", "data": {"kind": "unauthorized"}}})

    async def refuse(reader, writer):
        await reader.readline()
        writer.write(refusal)
        writer.close()

    async def run():
        server = await asyncio.start_server(refuse, "127.0.0.1", 0)
        door = Door(None, Subjects("t"), token)
        report = {"node": "far", "life": "1", "at": time.monotonic(), "leaves": False, "is_behind": False, "control": str(tmp_path / "of_another_machine.sock"),
                  "host": "127.0.0.1", "tcp": server.sockets[0].getsockname()[1]}
        door._nodes.hear(report)
        client = Client(Claim(door.budget))

        async def asked(method):
            return json.loads(await door.answer(line_of({"jsonrpc": "2.0", "id": 1, "method": method, "params": {}}), client))["error"]

        for _ in range(2):
            wrong = await asked("camera.list")
            assert wrong["data"]["kind"] == "unauthorized" and said in wrong["message"]
            door._writes = {"camera.create"}  # then it is the question itself that the node is asked
        door._nodes.hear({**report, "tcp": None})
        gone = await asked("camera.list")
        assert gone["data"]["kind"] == "unavailable" and "no node of this farm is there" in gone["message"]
        server.close()

    asyncio.run(run())


def nested(levels):
    return "[" * levels + "]" * levels


@pytest.mark.parametrize("value, is_taken", [
    ('"\\ud83d\\ude00 \\u0000"', True), ('"\\ud800"', False), ('{"\\udfff": 1}', False), ('[["a", "\\ude00\\ud83d"]]', False),
    ("1" + 308 * "0", True), ("-1" + 309 * "0", False), ("1e308", True), ("1e309", False), ("-1e309", False), ("[NaN]", False), ("Infinity", False),
    (nested(61), True), (nested(62), False), (nested(100_000), False),
])
@pytest.mark.parametrize("method", ["camera.set", "camera.get"])
def test_what_no_rig_reads_is_refused_before_it_stands_beside_others_commands(value, is_taken, method):
    """A rig refuses a line as a whole, and with it all others' commands on it."""
    async def run():
        door, came = Door(None, Subjects("t")), []
        door._writes = {"camera.set"}

        async def take(*_):
            came.append(True)
            return {"result": {}}

        door._command = door._look = take
        line = b'{"jsonrpc":"2.0","id":7,"method":"%s","params":{"name":%s}}\n' % (method.encode(), value.encode())
        for text in (line, b"[" + line + b"]"):
            came.clear()
            reply = json.loads(await door.answer(text, Client(Claim(door.budget))))
            reply = reply[0] if isinstance(reply, list) else reply
            assert came == [True] * is_taken
            assert is_taken or reply["error"]["data"]["kind"] == "invalid_argument" and reply["id"] is None

    asyncio.run(run())


@contextlib.asynccontextmanager
async def node_of(tmp_path, rig):
    """A door to one node, and what asks it as a client. ``rig`` serves one connection."""
    tasks = set()

    async def serve(reader, writer):
        tasks.add(asyncio.current_task())
        await rig(reader, writer)
        writer.close()

    server = await asyncio.start_unix_server(serve, str(tmp_path / "rig.sock"))
    door = Door(None, Subjects("t"))
    door._writes = {"camera.create"}
    door._nodes.hear({"node": "a", "life": "1", "at": time.monotonic(), "control": str(tmp_path / "rig.sock")})
    door.forget = lambda node: pytest.fail("the node lives")

    async def look(client=None):
        return json.loads(await door.answer(b'{"jsonrpc":"2.0","id":7,"method":"camera.list","params":{}}', client or Client(Claim(door.budget))))

    yield look
    server.close()
    for task in tasks:
        task.cancel()


def test_a_rig_has_few_connections_however_many_clients_a_door_has(tmp_path):
    """It takes 64, and would close one of its own node's for the next."""
    opened = [0, 0]

    async def rig(reader, writer):
        opened[0] += 1
        opened[1] += 1
        while line := await reader.readline():
            await asyncio.sleep(0.05)
            writer.write(line_of({"jsonrpc": "2.0", "id": json.loads(line)["id"], "result": {"cameras": []}}))
        opened[0] -= 1

    async def run():
        async with node_of(tmp_path, rig) as look:
            answers = await asyncio.gather(*(look() for _ in range(150)))
            assert answers == [{"jsonrpc": "2.0", "id": 7, "result": {"cameras": []}}] * 150
            assert 10 < opened[0] == opened[1] <= 50

    asyncio.run(run())


def test_a_rig_that_has_closed_an_idle_connection_is_asked_on_another(tmp_path):
    async def rig(reader, writer):
        line = await reader.readline()
        writer.write(line_of({"jsonrpc": "2.0", "id": json.loads(line)["id"], "result": {}}))

    async def run():
        async with node_of(tmp_path, rig) as look:
            client = Client(Claim(Budget()))
            for _ in range(3):
                assert (await look(client))["result"] == {}

    asyncio.run(run())


def test_a_rig_that_takes_no_more_connections_is_not_dead(tmp_path):
    async def rig(reader, writer):
        writer.write(b'{"error":{"code":-32000,"data":{"kind":"resource_exhausted"},"message":"close one"},"id":null,"jsonrpc":"2.0"}\n')

    async def run():
        async with node_of(tmp_path, rig) as look:
            reply = await look()
            assert reply["id"] == 7 and reply["error"]["data"]["kind"] == "resource_exhausted"

    asyncio.run(run())


def test_who_waits_too_long_for_others_answers_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(wires, "_MOST", 1)
    monkeypatch.setattr(wires, "_WAIT_S", 0.05)
    answered = asyncio.Event()

    async def rig(reader, writer):
        while line := await reader.readline():
            await answered.wait()
            writer.write(line_of({"jsonrpc": "2.0", "id": json.loads(line)["id"], "result": {}}))

    async def run():
        async with node_of(tmp_path, rig) as look:
            first = asyncio.ensure_future(look())
            await asyncio.sleep(0)
            assert (await look())["error"]["data"]["kind"] == "resource_exhausted"
            gone = asyncio.ensure_future(look())
            await asyncio.sleep(0)
            gone.cancel()
            answered.set()
            assert (await first)["result"] == {} and (await look())["result"] == {}

    asyncio.run(run())


def test_a_status_for_which_the_last_node_dies_is_unavailable():
    async def run():
        door = Door(None, Subjects("t"))
        door._nodes.hear({"node": "a", "life": "1", "at": time.monotonic()})

        async def last_answer(method):
            door.forget("a")
            return {"cameras": [{"name": "gate"}]}

        door._once = last_answer
        with pytest.raises(CamrigError) as gone:
            await door.call("farm.status")
        assert gone.value.kind == "unavailable"

    asyncio.run(run())


def test_a_door_takes_nobodys_place(tmp_path):
    async def run():
        async with sockets(tmp_path) as (_, path, _):
            with pytest.raises(CamrigError, match="another rig lives there") as refused:
                await socket_door.SocketDoor(FakeDoor()).open(path)
            assert refused.value.kind == "already_exists"
            reader, writer = await asyncio.open_unix_connection(path)
            writer.write(asking(5))
            assert await reader.readline() == b"xxxx\n", "who was there is there"
            writer.close()

    asyncio.run(run())
    # One that nobody listens at is left of who was killed.
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(tmp_path / "left.sock"))
    asyncio.run(socket_door.SocketDoor(FakeDoor()).open(str(tmp_path / "left.sock")))
