"""The control socket, over Unix, TCP and HTTP: who may command, and what cannot be held or broken."""

from __future__ import annotations

import json
import os
import random
import socket
import subprocess
import sys

import camrig

from target import Target, read_line, request, send_until_closed

#: A user who is not the rig's.
STRANGER_UID = 65534
LISTED_TYPES = [None, True, -1, 0, 2**63, 1e308, "", "x" * 5000, "\u202e", [], [[]], {}, {"a": 1}]


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
    """200 connections to the Unix socket, HTTP and RTSP that say nothing: the owner is still answered."""
    held: list[socket.socket] = []
    try:
        for _ in range(200):
            for connect in (target.unix, lambda: target.tcp(target.http), lambda: target.tcp(target.rtsp)):
                try:
                    held.append(connect())
                except OSError:
                    pass
        took = target.owner_is_answered(5.0)
        status, _, _ = target.ask_http("GET", "/healthz")
        assert status == 200, status
    finally:
        for raw in held:
            raw.close()
    return f"{len(held)} connections held, the owner waited {took * 1000:.0f} ms"


def values_of_every_type(target: Target) -> str:
    """Thousands of calls with values of every type in every place: an answer to each, none of them an internal error."""
    methods = [one["name"] if isinstance(one, dict) else one for one in target.rig.call("server.info").get("methods", [])] or [
        "camera.create", "camera.set", "camera.get", "camera.delete", "world.step", "world.status", "frame.get", "truth.get", "actor.spawn",
        "actor.set", "actor.remove", "event.add", "event.remove", "world.load", "stats.get"]
    methods = [name for name in methods if name not in ("server.shutdown", "world.load", "world.pause")]
    names = ["name", "camera", "size", "fps", "pose", "lens", "vfov_deg", "seconds", "nanoseconds", "min_ns", "kind", "format", "outputs", "when", "do", "near"]
    rng = random.Random(1)
    count = 4000
    with target.unix(60) as raw:
        for number in range(count):
            params = {rng.choice(names): rng.choice(LISTED_TYPES) for _ in range(rng.randrange(4))}
            if params.get("name") == "watched" or params.get("camera") == "watched":
                continue
            raw.sendall(json.dumps(request(rng.choice(methods), number, **params)).encode() + b"\n")
            answer = json.loads(read_line(raw))
            assert answer.get("error", {}).get("data", {}).get("kind") != "internal", answer
    return f"{count} calls"


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
    """What a client calls itself comes back in messages without escape sequences or line breaks."""
    with target.unix() as raw:
        raw.sendall(json.dumps(request("camera.get", name="\x1b[31mred\nline")).encode() + b"\n")
        answer = json.loads(read_line(raw))
    message = answer["error"]["message"]
    assert not any(ord(character) < 32 for character in message), message.encode()
    return ""


def cameras_come_and_go(target: Target) -> str:
    """500 cameras are made and deleted: descriptors and threads stay."""
    count = lambda what: len(os.listdir(f"/proc/{target.pid}/{what}"))
    before = count("fd"), count("task")
    for number in range(500):
        target.rig.create_camera(f"c{number}", size=(64, 48), place="lobby").delete()
    after = count("fd"), count("task")
    assert after[0] <= before[0] + 4 and after[1] <= before[1] + 2, (before, after)
    return f"descriptors and threads {before} before, {after} after"


def start_with_little_memory(target: Target) -> str:
    """A rig that may have 120 MB of address space says what is wrong and ends."""
    command = f"ulimit -v 120000; exec {camrig.launch.find_binary()} serve minimal --http 0 --rtsp 0 --control {target.folder}/small.sock"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, (done.returncode, done.stderr[-500:])
    assert "terminate called" not in done.stderr and done.stderr.startswith("camrig: "), done.stderr[-500:]
    return done.stderr.strip().splitlines()[-1][:150]


ATTACKS = [a_stranger_commands_over_http, silent_connections_hold_no_place, values_of_every_type, endless_lines_and_deep_nesting,
           names_with_control_characters, cameras_come_and_go, start_with_little_memory]
