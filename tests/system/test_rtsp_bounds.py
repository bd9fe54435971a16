"""What strangers can cost an RTSP server: bounded bytes, bounded time, bounded places, and nobody else's stream."""

import contextlib
import os
import pathlib
import re
import socket
import ssl
import subprocess
import threading
import time

import pytest

import camrig
from conftest import Process, wait_until
from rtsp_client import RtspReader, run, take

TOKEN = "a-token-for-tests"


@pytest.fixture
def guarded(scenes, tmp_path):
    """A rig that asks for a token, and its port."""
    token_file = tmp_path / "token"
    token_file.write_text(TOKEN + "\n")
    with camrig.start(str(scenes / "minimal.json"), args=["--token-file", str(token_file)]) as rig:
        yield rig, rig.call("server.info")["rtsp"]


def connect(port):
    return socket.create_connection(("127.0.0.1", port), 20)


def is_closed(raw, timeout_s=20.0):
    """Whether the other end closes within this time."""
    raw.settimeout(timeout_s)
    try:
        while raw.recv(1 << 16):
            pass
    except TimeoutError:
        return False
    except OSError:
        pass
    return True


def answer_of(raw):
    answer = b""
    while not answer.endswith(b"\r\n\r\n"):
        more = raw.recv(4096)
        if not more:
            break
        answer += more
    return answer.decode()


def options(raw, number=1, head=""):
    raw.sendall(f"OPTIONS * RTSP/1.0\r\nCSeq: {number}\r\n{head}\r\n".encode())
    return answer_of(raw)


REFUSED = {
    "a body of 2 GB": b"SET_PARAMETER * RTSP/1.0\r\nCSeq: 1\r\nContent-Length: 2147483647\r\n\r\n",
    "a body just too large": b"SET_PARAMETER * RTSP/1.0\r\nCSeq: 1\r\nContent-Length: 16385\r\n\r\n",
    "two lengths": b"SET_PARAMETER * RTSP/1.0\r\nCSeq: 1\r\nContent-Length: 1\r\nContent-Length: 9\r\n\r\n",
    "a line without end": b"OPTIONS " + b"a" * 3000,
    "too many header lines": b"OPTIONS * RTSP/1.0\r\n" + b"a: b\r\n" * 100,
    "too large a head": b"OPTIONS * RTSP/1.0\r\n" + (b"a: " + b"b" * 1000 + b"\r\n") * 10,
    "empty lines for ever": b"\r\n" * 10000,
    "packets without a stream": b"$\0\xff\xff" + b"x" * 70000,
    "an HTTP tunnel": b"GET /main HTTP/1.0\r\nX-Sessioncookie: 1\r\nAccept: application/x-rtsp-tunnelled\r\n\r\n",
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_breaks_a_bound_ends_the_connection_before_it_is_whole(guarded, what):
    _, port = guarded
    with connect(port) as raw:
        raw.sendall(REFUSED[what])
        assert is_closed(raw, 5)


def test_bodies_before_authentication_cost_no_memory(guarded):
    """It was as much as was sent: 512 connections of up to 2 GB."""
    rig, port = guarded
    process = Process(rig.call("server.info")["pid"])
    before = process.rss_kib()
    with contextlib.ExitStack() as stack:
        for _ in range(4):
            raw = stack.enter_context(connect(port))
            with contextlib.suppress(OSError):
                raw.sendall(b"SET_PARAMETER * RTSP/1.0\r\nCSeq: 1\r\nContent-Length: 100000000\r\n\r\n")
                for _ in range(16):
                    raw.sendall(b"x" * (1 << 20))
        assert options(stack.enter_context(connect(port))).startswith("RTSP/1.0 401")
        assert process.rss_kib() - before < 16 * 1024


def test_header_lines_without_end_do_not_keep_others_waiting(guarded):
    """One connection kept everybody's requests waiting for as long as it sent."""
    _, port = guarded
    with connect(port) as raw:
        def send():
            with contextlib.suppress(OSError):
                raw.sendall(b"OPTIONS * RTSP/1.0\r\n")
                while not stop.is_set():
                    raw.sendall(b"X-Field: value\r\n" * 4096)
        stop = threading.Event()
        sender = threading.Thread(target=send, daemon=True)
        sender.start()
        try:
            sender.join(10)
            assert not sender.is_alive(), "it is still taken"
        finally:
            stop.set()
            raw.shutdown(socket.SHUT_RDWR) if sender.is_alive() else None
            sender.join()
    with connect(port) as other:
        assert options(other).startswith("RTSP/1.0 401")


def test_over_tls_the_same_bounds_hold(scenes, tmp_path):
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    made = run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", str(key), "-out", str(cert))
    assert made.returncode == 0
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    with camrig.start(str(scenes / "minimal.json"), args=["--rtsp-cert", str(cert), "--rtsp-key", str(key)]) as rig:
        port = rig.call("server.info")["rtsp"]
        with context.wrap_socket(connect(port)) as raw:
            assert options(raw).startswith("RTSP/1.0 200")
            raw.sendall(REFUSED["too many header lines"])
            assert is_closed(raw, 5)


def test_a_wrong_token_closes_the_connection_after_three_and_then_waits(guarded):
    """Guessing was neither slowed nor told: 5000 tries a second."""
    rig, port = guarded
    wrong = 'Authorization: Digest username="camrig", realm="GStreamer RTSP Server", nonce="0", uri="*", response="0"\r\n'
    began = time.monotonic()
    for _ in range(2):
        with connect(port) as raw:
            for number in range(3):
                assert options(raw, number + 1, wrong).startswith("RTSP/1.0 401")
            assert is_closed(raw, 5)
    assert "127.0.0.1: wrong user or token" in rig.log
    assert rig.log.count("wrong user or token") <= 1 + time.monotonic() - began  # a line a second
    assert rig.call("server.info")["connections"]["rtsp"]["wrong_tokens"] == 6
    asked = time.monotonic()
    with connect(port) as raw:  # from an address that guessed too often
        raw.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
        raw.settimeout(20)
        assert answer_of(raw).startswith("RTSP/1.0 401") and time.monotonic() - asked > 0.5  # late, but answered


def test_silent_strangers_make_room_and_a_reader_stays(guarded):
    """300 connections that say nothing, from the reader's own address."""
    rig, port = guarded
    url = f"rtsp://camrig:{TOKEN}@127.0.0.1:{port}/main"
    reader = RtspReader(url)
    crowd = []
    try:
        for _ in range(300):
            crowd.append(connect(port))
        assert is_closed(crowd[0], 5)  # the first has made room
        assert len(take(reader, 5)) == 5
        assert len(take(RtspReader(url), 3)) == 3
        assert Process(rig.call("server.info")["pid"]).fds() < 250
    finally:
        for raw in crowd:
            raw.close()


def thread_cpu_s(pid, name):
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            fields = (task / "stat").read_text().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    raise AssertionError(f"no thread {name}")


def test_without_descriptors_it_waits_instead_of_spinning(scenes, tmp_path):
    program = tmp_path / "camrig-few"
    program.write_text(f'#!/bin/sh\nulimit -n 128\nexec {camrig.launch.find_binary()} "$@"\n')
    program.chmod(0o755)
    with camrig.start(str(scenes / "minimal.json"), binary=program) as rig:
        info = rig.call("server.info")
        crowd = [socket.socket() for _ in range(200)]
        try:
            for raw in crowd:
                raw.setblocking(False)
                raw.connect_ex(("127.0.0.1", info["rtsp"]))
            wait_until(lambda: "new connections wait" in rig.log, what="the log to tell")
            before, begun = thread_cpu_s(info["pid"], "camrig-rtsp"), time.monotonic()
            wait_until(lambda: time.monotonic() - begun > 1)
            assert thread_cpu_s(info["pid"], "camrig-rtsp") - before < 0.4 * (time.monotonic() - begun)
        finally:
            for raw in crowd:
                raw.close()
        assert len(take(RtspReader(rig.rtsp_url + "/main"), 3)) == 3


def udp_ports_of(pid):
    """Local addresses of a process's UDP sockets."""
    inodes = set()
    for entry in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            if match := re.match(r"socket:\[(\d+)\]", os.readlink(entry)):
                inodes.add(match[1])
    found = []
    for table in ("udp", "udp6"):
        for line in pathlib.Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in inodes:
                found.append(fields[1].split(":")[0])
    return found


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_udp_ports_are_open_on_the_rigs_host_only(rig, process):
    reader = subprocess.Popen(["ffmpeg", "-v", "error", "-rtsp_transport", "udp", "-i", rig.rtsp_url + "/main", "-f", "null", "-"])
    try:
        wait_until(lambda: rig.log.count("plays /main"), what="a reader")
        ports = udp_ports_of(process.pid)
        assert len(ports) >= 2 and set(ports) == {"0100007F"}, ports  # 127.0.0.1 as the kernel prints it
    finally:
        reader.kill()
        reader.wait()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_connection_has_few_sessions_and_plays_on(rig):
    """Each SETUP without one made a session that lived for a minute."""
    port = rig.call("server.info")["rtsp"]
    with connect(port) as raw:
        def ask(method, number, head):
            raw.sendall(f"{method} rtsp://127.0.0.1:{port}/main/stream=0 RTSP/1.0\r\nCSeq: {number}\r\n{head}\r\n".encode())
            return answer_of(raw)

        answers = [ask("SETUP", n, f"Transport: RTP/AVP/TCP;unicast;interleaved={2 * n}-{2 * n + 1}\r\n") for n in range(1, 51)]
        assert [int(answer.split()[1]) for answer in answers] == 8 * [200] + 42 * [503]
        assert "has 8 sessions" in answers[-1]
        session = re.search(r"Session: *([^;\r]+)", answers[0])[1]
        raw.sendall(f"PLAY rtsp://127.0.0.1:{port}/main RTSP/1.0\r\nCSeq: 51\r\nSession: {session}\r\n\r\n".encode())
        raw.settimeout(20)
        assert raw.recv(12) == b"RTSP/1.0 200"
        packets = iter(lambda: raw.recv(1 << 16), b"")
        assert any(re.search(rb"\$\x02..[\x80-\xbf]", some, re.DOTALL) for some in packets), "no picture on its channel"
    assert len(take(RtspReader(rig.rtsp_url + "/main"), 3)) == 3


@pytest.mark.slow
def test_who_says_nothing_or_never_ends_a_request_is_closed_and_a_reader_is_not(guarded):
    """After ten seconds. Who waits has shown no token; the reader has, and reads on."""
    _, port = guarded
    with connect(port) as silent, connect(port) as slow:
        reader = RtspReader(f"rtsp://camrig:{TOKEN}@127.0.0.1:{port}/main")
        slow.sendall(b"OPTIONS * RTSP/1.0\r\nCSeq:")
        assert is_closed(silent) and is_closed(slow)
        assert len(take(reader, 5)) == 5
