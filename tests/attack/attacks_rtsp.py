"""RTSP: what is sent before anybody has shown who they are."""

from __future__ import annotations

import random
import socket
import time
from pathlib import Path

import camrig

from target import Target, send_until_closed


def _options_is_answered(target: Target, within_s: float = 2.0) -> float:
    begin = time.monotonic()
    with target.tcp(target.rtsp, within_s) as raw:
        raw.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
        answer = raw.recv(4096)
    assert answer.startswith(b"RTSP/1.0 "), answer
    return time.monotonic() - begin


def endless_bodies(target: Target) -> str:
    """Bodies of 2 GB are announced and begun on 16 connections: not taken, and not kept."""
    before, taken, most = target.rss_kib(), 0, 0
    held = []
    for _ in range(16):
        raw = target.tcp(target.rtsp, 3.0)
        raw.sendall(b"SET_PARAMETER rtsp://127.0.0.1/watched RTSP/1.0\r\nCSeq: 1\r\nContent-Length: 2147483647\r\n\r\n")
        taken += send_until_closed(raw, b"x" * (1 << 18), 8 << 20, 1.0)
        held.append(raw)
    most = target.rss_kib() - before
    waited = _options_is_answered(target)
    for raw in held:
        raw.close()
    assert most < 32 * 1024, f"{most // 1024} MiB more for {taken >> 20} MiB sent"
    return f"{taken >> 10} KiB taken of 128 MiB offered, {most / 1024:+.1f} MiB, OPTIONS of others answered in {waited * 1000:.0f} ms"


def endless_headers(target: Target) -> str:
    """Header lines without end: closed, and no time of others."""
    raw = target.tcp(target.rtsp, 5.0)
    raw.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n")
    taken = send_until_closed(raw, b"X-Header: " + b"y" * 1000 + b"\r\n", 32 << 20, 2.0)
    waited = _options_is_answered(target)
    raw.close()
    assert taken < 4 << 20, f"{taken >> 20} MiB of headers were taken"
    return f"{taken >> 10} KiB taken, OPTIONS of others answered in {waited * 1000:.0f} ms"


def requests_at_random(target: Target) -> str:
    """600 mangled requests."""
    rng = random.Random(2)
    good = b"DESCRIBE rtsp://127.0.0.1/watched RTSP/1.0\r\nCSeq: 2\r\nAccept: application/sdp\r\nContent-Length: 0\r\n\r\n"
    for _ in range(600):
        data = bytearray(good)
        for _ in range(rng.choice([1, 3, 20])):
            data[rng.randrange(len(data))] = rng.randrange(256)
        try:
            with target.tcp(target.rtsp, 0.2) as raw:
                raw.sendall(data[: rng.randrange(1, len(data) + 1)])
                if rng.random() < 0.1:
                    raw.recv(100)
        except OSError:
            pass
    return f"OPTIONS answered in {_options_is_answered(target) * 1000:.0f} ms"


def sessions_without_end(target: Target) -> str:
    """500 SETUPs on one connection."""
    with target.tcp(target.rtsp, 10.0) as raw:
        try:
            for number in range(500):
                raw.sendall(f"SETUP rtsp://127.0.0.1:{target.rtsp}/watched/stream=0 RTSP/1.0\r\nCSeq: {number}\r\n"
                            "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\n\r\n".encode())
                raw.recv(1 << 14)
        except OSError:
            pass
    return f"OPTIONS answered in {_options_is_answered(target) * 1000:.0f} ms"


def sockets_beyond_the_host(target: Target) -> str:
    """UDP of a rig on the loopback address is bound to that address."""
    host, port = "127.0.0.1", target.rtsp
    with socket.create_connection((host, port), 10) as raw, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ours:
        ours.bind((host, 0))
        client = ours.getsockname()[1]
        raw.sendall(f"SETUP rtsp://{host}:{port}/watched/stream=0 RTSP/1.0\r\nCSeq: 1\r\nTransport: RTP/AVP;unicast;client_port={client}-{client + 1}\r\n\r\n".encode())
        answer = raw.recv(1 << 14).decode()
        assert " 200 " in answer.splitlines()[0], answer
        inodes = {link.readlink().name for link in Path(f"/proc/{target.pid}/fd").iterdir() if str(link.readlink()).startswith("socket:")}
        inodes = {name.strip("socket:[]") for name in inodes}
        wide = []
        for table, everywhere in (("udp", "00000000"), ("udp6", "0" * 32), ("tcp", "00000000"), ("tcp6", "0" * 32)):
            for line in Path(f"/proc/{target.pid}/net/{table}").read_text().splitlines()[1:]:
                fields = line.split()
                if fields[9] in inodes and fields[1].split(":")[0] == everywhere:
                    wide.append(f"{table} port {int(fields[1].split(':')[1], 16)}")
    assert not wide, f"bound to all addresses: {wide}"
    return ""


def wrong_passwords(target: Target) -> str:
    """Wrong passwords are few, however fast they are tried."""
    token = target.folder / "token"
    token.write_text("a-token-that-nobody-guesses\n")
    with camrig.start("minimal", args=["--host", "127.0.0.2", "--token-file", str(token)]) as rig:
        port = rig.call("server.info")["rtsp"]
        tried, begin = 0, time.monotonic()
        while time.monotonic() - begin < 3.0:
            try:
                with socket.create_connection(("127.0.0.2", port), 3.0) as raw:
                    for _ in range(200):
                        raw.sendall(b"DESCRIBE rtsp://127.0.0.2/c RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Digest username=\"camrig\", realm=\"camrig\", "
                                    b"nonce=\"0\", uri=\"/\", response=\"00000000000000000000000000000000\"\r\n\r\n")
                        if not raw.recv(4096):
                            break
                        tried += 1
            except OSError:
                pass
    rate = tried / 3.0
    assert rate < 500, f"{rate:.0f} tries a second"
    return f"{rate:.0f} tries a second"


ATTACKS = [endless_bodies, endless_headers, requests_at_random, sessions_without_end, sockets_beyond_the_host, wrong_passwords]
