"""The control sockets of a farm's door, before a door that answers what the tests want: what strangers and clients may make it hold."""

import asyncio
import contextlib
import json
import socket
import time

import pytest

from camrig.errors import CamrigError
from camrig.farm.live import budget as budget_module
from camrig.farm.live import socket_door, wrong_tokens
from camrig.farm.live.budget import PIECE_BYTES, Budget, Claim, read_exactly, read_line
from camrig.farm.live.door import Client, Door, text_of
from camrig.farm.live.log import Subjects
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
            return text_of({"error": problem.kind})
        return b"x" * (size - 1) + b"\n"


@contextlib.asynccontextmanager
async def sockets(tmp_path):
    door = FakeDoor()
    opened = socket_door.SocketDoor(door)
    await opened.open(str(tmp_path / "door.sock"))
    yield door, str(tmp_path / "door.sock"), await opened.listen("127.0.0.1", 0)


def asking(size):
    return text_of({"method": "x", "params": {"size": size}})


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
        return text_of({"jsonrpc": "2.0", "id": 7, "method": "auth", "params": {"token": token}})

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
    refusal = text_of({"jsonrpc": "2.0", "id": 0, "error": {"code": -32000, "message": "this is not the token", "data": {"kind": "unauthorized"}}})

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
            return json.loads(await door.answer(text_of({"jsonrpc": "2.0", "id": 1, "method": method, "params": {}}), client))["error"]

        for _ in range(2):
            wrong = await asked("camera.list")
            assert wrong["data"]["kind"] == "unauthorized" and said in wrong["message"]
            door._writes = {"camera.create"}  # then it is the question itself that the node is asked
        door._nodes.hear({**report, "tcp": None})
        gone = await asked("camera.list")
        assert gone["data"]["kind"] == "unavailable" and "no node of this farm is there" in gone["message"]
        server.close()

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
