"""HTTP: requests that are not what they seem, pages of other origins, slow and stuck connections."""

from __future__ import annotations

import json
import os
import selectors
import socket
import time

import camrig

from target import Target, request


def _raw(target: Target, text: str, timeout_s: float = 10.0) -> bytes:
    """What comes back until the rig closes or says nothing for a second."""
    with target.tcp(target.http, timeout_s) as raw:
        raw.sendall(text.encode("latin-1"))
        raw.settimeout(1.0)
        answer = b""
        try:
            while chunk := raw.recv(1 << 16):
                answer += chunk
        except TimeoutError:
            pass
        return answer


def requests_within_requests(target: Target) -> str:
    """Framing that two programs could read differently is refused, and never taken for two requests."""
    inner = "GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    post, get = "POST /rpc HTTP/1.1\r\nHost: 127.0.0.1\r\n", "GET /healthz HTTP/1.1\r\n"
    codings = ("xchunked", "chunked, gzip", "identity", "gzip, chunked", "chunked\r\nTransfer-Encoding: x")
    hosts = ("localhost\r\nHost: localhost", "[::1]evil.example", "[::1", "localhost:80:80", "a b", "", ":80", "localhost@evil.example")
    methods = ("GE", "ET", "get", "HEA", "OPTION", "T, H")
    cases = [
        *(f"{post}Transfer-Encoding: {coding}\r\n\r\n{inner}" for coding in codings),
        *(f"{get}Host: {host}\r\n\r\n{inner}" for host in hosts),
        *(f"{method} /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n" for method in methods),
        f"{post}Content-Length: 0\r\nContent-Length: {len(inner)}\r\n\r\n{inner}",
        f"{post}Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n{inner}",
        f"{post}Content-Length: -1\r\n\r\n{inner}",
        f"{get}Host : 127.0.0.1\r\n\r\n{inner}",
    ]
    for case in cases:
        answer = _raw(target, case)
        assert b"200 OK" not in answer, f"{case[:90]!r} gave {answer[:80]!r}"
    return f"{len(cases)} refused"


def paths_out_of_the_tree(target: Target) -> str:
    """Nothing outside what is served can be had by any spelling of a path."""
    ways = ["/../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/cameras/../../etc/passwd", "/cameras/../rpc", "/cameras/%2e%2e/rpc",
            "/cameras/%00/snapshot.jpg", "/cameras/lobby/..%5c..%5cetc/passwd", "/" + "a/" * 3000, "/./", "/cameras%2flobby/truth", "/a%00b", "/a%", "/a%4", "/a%zz",
            "/a%0d%0aX", "/caf%c3%a9", "/a\\..\\b", "/%5c", "/?a=%00", "/?a=1&a=2", "/?a%0a=1", "//evil/..", "/?\xff", "ftp://x/", "http:///x"]
    for way in ways:
        # As it stands: an HTTP library would set it right first.
        answer = _raw(target, f"GET {way} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
        status = answer[9:12]
        assert status in (b"400", b"404", b"414", b"431") and b"root:" not in answer, f"{way[:40]} gave {answer[:80]!r}"
    return f"{len(ways)} refused"


def pages_of_other_origins(target: Target) -> str:
    """A page of another origin can neither command nor have pictures drawn, and may not embed what is served."""
    headers = {"Origin": "http://evil.example", "Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"}
    status, _, _ = target.ask_http("POST", "/rpc", json.dumps(request("world.status")).encode(), {**headers, "Content-Type": "application/json"})
    assert status in (401, 403), f"POST /rpc gave {status}"
    paths = [f"/cameras/watched/{of}" for of in ("depth.png", "truth", "instance.png", "snapshot.jpg", "stream.mjpg")] + ["/live?cameras=watched", "/metrics"]
    pages = ({"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"}, {"Referer": "http://evil.example/"}, {"Origin": "null"})
    for path in paths:
        for page in pages:
            status, _, _ = target.ask_http("GET", path, headers=page)
            assert status == 403, f"{path} for a page with {page} gave {status}"
    status, answer, _ = target.ask_http("GET", "/healthz", headers={"Host": "evil.example"})
    assert status in (400, 403), f"another Host gave {status}"
    _, answer, _ = target.ask_http("GET", "/cameras")
    assert "same-origin" in answer.get("cross-origin-resource-policy", ""), answer
    return f"{len(paths) * len(pages) + 2} refused"


def slow_connections(target: Target) -> str:
    """600 connections that send their request a byte at a time: an ordinary request is answered meanwhile."""
    held: list[socket.socket] = []
    try:
        for number in range(600):
            try:
                raw = target.tcp(target.http, 2.0)
                raw.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127")
                held.append(raw)
            except OSError:
                pass
            if number % 100 == 99:
                begin = time.monotonic()
                status, _, _ = target.ask_http("GET", "/healthz")
                assert status == 200, f"with {len(held)} slow connections: {status}"
                assert time.monotonic() - begin < 2.0, "an ordinary request waited more than 2 s"
        assert len(held) > 500, f"only {len(held)} connections held"
    finally:
        for raw in held:
            raw.close()
    return f"{len(held)} were held"


def out_of_descriptors(target: Target) -> str:
    """A rig with few descriptors is filled with connections: it does not spin, and goes on when they are gone."""
    program = target.folder / "few-descriptors"
    program.write_text(f'#!/bin/bash\nulimit -Sn 300; ulimit -Hn 300; exec {camrig.launch.find_binary()} "$@"\n')
    program.chmod(0o755)
    with camrig.start("minimal", binary=program) as rig:
        other = Target(rig, target.folder)
        held: list[socket.socket] = []
        for port in (other.http, other.rtsp):
            for _ in range(250):
                raw = socket.socket()
                raw.setblocking(False)
                raw.connect_ex(("127.0.0.1", port))
                held.append(raw)
        time.sleep(1.0)
        taken = len(os.listdir(f"/proc/{other.pid}/fd"))
        assert taken > 200, f"filled with {taken} of 300"
        before, begin = other.cpu_s(), time.monotonic()
        time.sleep(3.0)
        share = (other.cpu_s() - before) / (time.monotonic() - begin)
        for raw in held:
            raw.close()
        other.owner_is_answered(5.0)
        assert share < 0.3, f"{share:.2f} cores without anything to do"
        status, _, _ = other.ask_http("GET", "/healthz")
        assert status == 200
    return f"{share:.2f} cores meanwhile"


def stuck_readers(target: Target) -> str:
    """200 readers of a stream, 50 of which take nothing: the others get their pictures."""
    mute, reading = [], []
    for number in range(200):
        raw = socket.socket()
        if number % 4 == 0:
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        raw.connect(("127.0.0.1", target.http))
        raw.sendall(b"GET /cameras/watched/stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        (mute if number % 4 == 0 else reading).append(raw)
    got = {raw: 0 for raw in reading}
    sequence = lambda: next(camera["sequence"] for camera in target.rig.call("camera.list")["cameras"] if camera["name"] == "watched")
    first, begin = sequence(), time.monotonic()
    with selectors.DefaultSelector() as ready:
        for raw in reading:
            ready.register(raw, selectors.EVENT_READ)
        while time.monotonic() - begin < 10.0:
            for key, _ in ready.select(0.5):
                data = key.fileobj.recv(1 << 18)
                assert data, "the stream of a reader that reads was closed"
                got[key.fileobj] += data.count(b"X-Sequence: ")
    made = sequence() - first
    for raw in (*mute, *reading):
        raw.close()
    assert made > 0 and min(got.values()) >= 0.9 * made - 2, f"of {made} pictures a reader got {min(got.values())}"
    return f"of {made} pictures the 150 that read got {min(got.values())} to {max(got.values())}"


ATTACKS = [requests_within_requests, paths_out_of_the_tree, pages_of_other_origins, slow_connections, out_of_descriptors, stuck_readers]
