"""The control socket, over Unix, TCP and HTTP: who may command, and what cannot be held or broken."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys

import camrig

from described import Calls
from target import Target, read_line, request, send_until_closed

#: A user who is not the rig's.
STRANGER_UID = 65534
#: How a call that was stopped at the names of its parameters is answered.
OF_NAMES = ("unknown key", "is missing")


def a_stranger_commands_over_http(target: Target) -> str:
    """Another user of this machine may look, and may not command."""
    program = ("import http.client, json, os, sys; os.setgroups([]); os.setgid(65534); os.setuid(65534)\n"
               "for method, params in (('server.shutdown', {}), ('world.load', {'scene': 'street'}), ('camera.delete', {'name': 'watched'})):\n"
               "    c = http.client.HTTPConnection('127.0.0.1', int(sys.argv[1]), timeout=20)\n"
               "    c.request('POST', '/rpc', json.dumps({'jsonrpc': '2.0', 'id': 1, 'method': method, 'params': params}), {'Content-Type': 'application/json'})\n"
               "    a = c.getresponse(); print(a.status, a.read(500))\n")
    assert os.getuid() == 0, "needs root, to become another user"
    done = subprocess.run([sys.executable, "-c", program, str(target.http)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 3 and all(line.startswith("401") or "unauthorized" in line for line in lines), lines
    target.owner_is_answered()
    return "3 of 3 refused"


def silent_connections_hold_no_place(target: Target) -> str:
    """200 connections to the Unix socket, control over TCP, HTTP and RTSP that say nothing: the owner is still answered."""
    held: list[socket.socket] = []
    try:
        for _ in range(200):
            for connect in (target.unix, *(lambda port=port: target.tcp(port) for port in (target.control_tcp, target.http, target.rtsp))):
                try:
                    held.append(connect())
                except OSError:
                    pass
        took = target.owner_is_answered(5.0)
        status, _, _ = target.ask_http("GET", "/healthz")
        assert status == 200, status
        assert len(held) > 600, f"only {len(held)} connections held"
    finally:
        for raw in held:
            raw.close()
    return f"{len(held)} connections held, the owner waited {took * 1000:.0f} ms"


def _answers(other: Target, calls: list[tuple[str, dict]]) -> tuple[int, int, set[str]]:
    """How many of these calls got past the check of their parameters' names, how many were carried out, and the methods called."""
    past_names, carried_out = 0, 0
    with other.unix(60) as raw:
        for number, (method, params) in enumerate(calls):
            raw.sendall(json.dumps(request(method, number, **params)).encode() + b"\n")
            try:
                line = read_line(raw)
            except TimeoutError:
                line = b""
            assert line, f"no answer to {method} {json.dumps(params)[:300]}"
            answer = json.loads(line)
            assert answer["id"] == number, answer
            if "result" in answer:
                carried_out += 1
                past_names += 1
                if method == "camera.create":  # they are bounded in number
                    other.rig.camera(answer["result"]["name"]).delete()
                if method == "camera.delete":
                    _make_victim(other.rig)
                continue
            assert answer["error"]["data"]["kind"] != "internal", (method, json.dumps(params)[:300], answer)
            past_names += not any(text in answer["error"]["message"] for text in OF_NAMES)
    return past_names, carried_out, {method for method, _ in calls}


def _make_victim(rig: camrig.Rig) -> None:
    rig.create_camera("victim", size=(64, 48), position=(0, 0, 1), ptz={"preset": "cheap"})


def _with_a_victim(rig: camrig.Rig, target: Target) -> Target:
    """A rig of their own for calls that change everything there is."""
    _make_victim(rig)
    return Target(rig, target.folder)


def values_of_every_type(target: Target) -> str:
    """23 000 calls of all methods with values of every type under right names: an answer to each, none of them an internal error."""
    with camrig.start("minimal", mode="lockstep") as rig:
        other = _with_a_victim(rig, target)
        calls = [some.one() for some in (Calls(rig, 1, 0.7), Calls(rig, 2, 0.95)) for _ in range(11_500)]
        past_names, carried_out, methods = _answers(other, calls)
        other.owner_is_answered()
    assert past_names > len(calls) / 2, f"only {past_names} of {len(calls)} calls had right names"
    assert len(methods) > 15 and carried_out > 0, (methods, carried_out)
    return f"{len(calls)} calls of {len(methods)} methods, {past_names} with right names, {carried_out} carried out"


def numbers_at_their_bounds(target: Target) -> str:
    """4000 calls with numbers at and beyond the bounds of their parameters and of their types."""
    with camrig.start("minimal", mode="lockstep") as rig:
        other = _with_a_victim(rig, target)
        some = Calls(rig, 3, 1.0)
        calls: list[tuple[str, dict]] = []
        while len(calls) < 4000:
            calls += some.numbers()
        past_names, carried_out, _ = _answers(other, calls)
        other.owner_is_answered()
    assert past_names > len(calls) / 2, f"only {past_names} of {len(calls)} calls had right names"
    assert carried_out > 0, "no call was carried out"
    return f"{len(calls)} calls, {past_names} with right names, {carried_out} carried out"


def endless_lines_and_deep_nesting(target: Target) -> str:
    """A line of 200 MB and 500 000 brackets: refused, and nothing kept."""
    before = target.rss_kib()
    with target.unix() as raw:
        taken = send_until_closed(raw, b"x" * (1 << 20), 200 << 20)
    grown = target.rss_kib() - before
    with target.unix() as raw:
        raw.sendall(b"[" * 500_000 + b"]" * 500_000 + b"\n")
        answer = json.loads(read_line(raw))
        assert "error" in answer, answer
    assert grown < 40 * 1024, f"{grown // 1024} MiB grown"
    return f"{taken >> 20} MiB taken before the connection was closed"


def names_with_control_characters(target: Target) -> str:
    """What a client asks for comes back in messages without escape sequences or line breaks."""
    with target.unix() as raw:
        raw.sendall(json.dumps(request("camera.get", name="\x1b[31mred\nline")).encode() + b"\n")
        answer = json.loads(read_line(raw))
    message = answer["error"]["message"]
    assert not any(ord(character) < 32 for character in message), message.encode()
    return ""


def cameras_come_and_go(target: Target) -> str:
    """2000 cameras are made and deleted: memory, descriptors and threads stay."""
    count = lambda what: len(os.listdir(f"/proc/{target.pid}/{what}"))

    def live(first: int, last: int) -> None:
        for number in range(first, last):
            target.rig.create_camera(f"c{number}", size=(64, 48), place="lobby").delete()

    before = count("fd"), count("task")
    live(0, 1200)
    full_kib = target.rss_kib()  # what an allocator keeps for the next one is there
    live(1200, 2000)
    after = count("fd"), count("task")
    grown_mib = (target.rss_kib() - full_kib) / 1024
    assert after[0] <= before[0] + 4 and after[1] <= before[1] + 2, (before, after)
    assert grown_mib < 16, f"the last 800 left {grown_mib:.0f} MiB"
    return f"descriptors and threads {before} before, {after} after, {grown_mib:+.1f} MiB by the last 800"


def start_with_little_memory(target: Target) -> str:
    """A rig that may have 120 MB of address space says what is wrong and ends."""
    command = f"ulimit -v 120000; exec {camrig.launch.find_binary()} serve minimal --http 0 --rtsp 0 --control {target.folder}/small.sock"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, (done.returncode, done.stderr[-500:])
    assert "terminate called" not in done.stderr and done.stderr.startswith("camrig: "), done.stderr[-500:]
    return done.stderr.strip().splitlines()[-1][:150]


ATTACKS = [a_stranger_commands_over_http, silent_connections_hold_no_place, values_of_every_type, numbers_at_their_bounds,
           endless_lines_and_deep_nesting, names_with_control_characters, cameras_come_and_go, start_with_little_memory]
