"""RTSP: what is sent before anybody has shown who they are."""

from __future__ import annotations

import contextlib
import random
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import camrig

from bystanders import rtsp_times
from target import Target, send_until_closed

TOKEN = "a-token-that-nobody-guesses"


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
    """3000 mangled requests."""
    rng = random.Random(2)
    good = b"DESCRIBE rtsp://127.0.0.1/watched RTSP/1.0\r\nCSeq: 2\r\nAccept: application/sdp\r\nContent-Length: 0\r\n\r\n"
    for _ in range(3000):
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
    """3000 SETUPs, on each connection as many as the rig answers; it makes at most 8 sessions of them."""
    sent = connections = 0
    while sent < 3000:
        connections += 1
        answered_before, sessions = sent, 0
        with target.tcp(target.rtsp, 10.0) as raw, contextlib.suppress(OSError):
            while sent < 3000:
                raw.sendall(f"SETUP rtsp://127.0.0.1:{target.rtsp}/watched/stream=0 RTSP/1.0\r\nCSeq: {sent}\r\n"
                            "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\n\r\n".encode())
                answer = raw.recv(1 << 14)
                if not answer.startswith(b"RTSP/1.0 "):
                    break
                sent += 1
                sessions += answer.startswith(b"RTSP/1.0 200")
        assert 1 <= sessions <= 8, f"connection {connections} has {sessions} sessions"
        assert sent > answered_before, f"connection {connections} was not answered at all"
    return f"{sent} answered on {connections} connections; OPTIONS answered in {_options_is_answered(target) * 1000:.0f} ms"


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


@contextlib.contextmanager
def _guarded(target: Target, host: str) -> Iterator[int]:
    """The RTSP port of a rig that asks for a password."""
    token = target.folder / "token"
    token.write_text(f"{TOKEN}\n")
    with camrig.start("minimal", args=["--host", host, "--token-file", str(token)]) as rig:
        yield rig.call("server.info")["rtsp"]


def wrong_passwords(target: Target) -> str:
    """Wrong passwords are few, however fast they are tried: after three a connection is closed, and an address waits."""
    with _guarded(target, "127.0.0.2") as port:
        tried, begin = 0, time.monotonic()
        while time.monotonic() - begin < 3.0:
            try:
                with socket.create_connection(("127.0.0.2", port), 3.0) as raw:
                    for _ in range(200):
                        raw.sendall(b"DESCRIBE rtsp://127.0.0.2/c RTSP/1.0\r\nCSeq: 1\r\nAuthorization: Digest username=\"camrig\", realm=\"camrig\", "
                                    b"nonce=\"0\", uri=\"/\", response=\"00000000000000000000000000000000\"\r\n\r\n")
                        answer = raw.recv(4096)
                        if not answer:
                            break
                        assert answer.startswith(b"RTSP/1.0 401 "), answer
                        tried += 1
            except OSError:
                pass
    rate = tried / 3.0
    assert tried > 0, "nobody answered"
    assert rate < 20, f"{rate:.0f} tries a second"
    return f"{tried} tried, {rate:.0f} a second"


def digests_again(target: Target) -> str:
    """What a reader proved its password with, heard on the way and sent again: of no use on another connection, for another method or path."""
    with _guarded(target, "127.0.0.3") as port:
        reader = rtsp_times.RtspReader(f"rtsp://camrig:{TOKEN}@127.0.0.3:{port}/main")
        heard = reader.digest("DESCRIBE", reader.url)
        cases = [("DESCRIBE", "main"), ("SETUP", "main/stream=0"), ("PLAY", "main"), ("TEARDOWN", "main"), ("OPTIONS", "main")]
        for method, path in cases:
            with socket.create_connection(("127.0.0.3", port), 20.0) as raw:
                raw.sendall(f"{method} rtsp://127.0.0.3:{port}/{path} RTSP/1.0\r\nCSeq: 1\r\nTransport: RTP/AVP/TCP;interleaved=0-1\r\n"
                            f"Session: {reader.session}\r\nAuthorization: {heard}\r\n\r\n".encode())
                answer = raw.recv(4096)
            assert answer.startswith(b"RTSP/1.0 401 "), f"{method} {path}: {answer[:200]!r}"
        reader.close()
    return f"{len(cases)} refused"


def packets_for_others(target: Target) -> str:
    """`destination=` and `source=` in a SETUP send nobody's packets to where they were not asked from."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as victim:
        victim.bind(("127.0.0.9", 0))
        victim.setblocking(False)
        port = victim.getsockname()[1]
        for more in ("destination=127.0.0.9", "destination=127.0.0.9;source=127.0.0.9", "destination=\"127.0.0.9\"", "destination=127.0.0.9;destination=127.0.0.1"):
            with target.tcp(target.rtsp) as raw:
                url, answers = f"rtsp://127.0.0.1:{target.rtsp}/watched", b""
                raw.sendall(f"SETUP {url}/stream=0 RTSP/1.0\r\nCSeq: 1\r\nTransport: RTP/AVP;unicast;{more};client_port={port}-{port + 1}\r\n\r\n".encode())
                answer = raw.recv(1 << 14).decode()
                assert "127.0.0.9" not in answer, answer
                session = [line[9:].split(";")[0] for line in answer.splitlines() if line.startswith("Session: ")]
                if session:
                    raw.sendall(f"PLAY {url} RTSP/1.0\r\nCSeq: 2\r\nSession: {session[0]}\r\n\r\n".encode())
                    answers = raw.recv(1 << 14)
                    assert answers.startswith(b"RTSP/1.0 "), answers
                time.sleep(0.5)  # five pictures of the stream
            try:
                raise AssertionError(f"{len(victim.recv(1 << 16))} bytes were sent to somebody who did not ask: {more}")
            except BlockingIOError:
                pass
    return "4 ways, nothing was sent"


ATTACKS = [endless_bodies, endless_headers, requests_at_random, sessions_without_end, sockets_beyond_the_host, wrong_passwords, digests_again, packets_for_others]
