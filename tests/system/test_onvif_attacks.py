"""What strangers send to an ONVIF port: everything is refused, costs little, and nothing of it stays."""

import re
import socket
import time

import pytest

import camrig
from conftest import Process, wait_until
from onvif_messages import SERVICES, SOAP, TOKEN, listens, post, security
from ports import free_port

MOVE = '<tptz:AbsoluteMove><tptz:ProfileToken>dome</tptz:ProfileToken><tptz:Position><tt:PanTilt x="1" y="0"/></tptz:Position></tptz:AbsoluteMove>'
ENTITIES = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 10))
BOMBS = {
    "entities that grow": f'<!DOCTYPE x [<!ENTITY e0 "camrig">{ENTITIES}]>',
    "one large entity": f'<!DOCTYPE x [<!ENTITY e9 "{"a" * 100_000}">]>',
    "a file": '<!DOCTYPE x [<!ENTITY e9 SYSTEM "file:///etc/passwd">]>',
    "another machine's": '<!DOCTYPE x [<!ENTITY % far SYSTEM "http://127.0.0.1:9/x.dtd"> %far;]>',
}


@pytest.fixture
def dome(tmp_path):
    (token_file := tmp_path / "token").write_text(TOKEN + "\n")
    port = free_port()
    with camrig.start("minimal", mode="lockstep", args=["--token-file", str(token_file)]) as rig:
        rig.create_camera("dome", size=(320, 240), ptz={"preset": "ideal", "pan_limits_deg": [-90, 90]}, outputs=[{"kind": "onvif", "port": port}])
        wait_until(lambda: listens(port), what="the camera's port")
        yield rig, port


def send(port, message, fields="", timeout_s=30):
    """The status and all of the answer to what is sent as it stands."""
    with socket.create_connection(("127.0.0.1", port), timeout_s) as raw:
        try:
            raw.sendall(f"POST /onvif/device_service HTTP/1.1\r\nHost: 127.0.0.1\r\n{fields}Content-Length: {len(message)}\r\n\r\n".encode() + message)
        except (BrokenPipeError, ConnectionResetError):
            pass  # it has heard enough
        answer = b""
        try:
            while chunk := raw.recv(65536):
                answer += chunk
                if b"</s:Envelope>" in answer or (b" 413 " in answer and answer.endswith(b"}\n")):
                    break
        except ConnectionResetError:
            pass
    return int(answer.split()[1]), answer.decode()


def test_no_attack_is_answered_by_anything_but_a_fault_and_nothing_of_them_stays(dome):
    rig, port = dome
    process = Process(rig.call("server.info")["pid"])

    def attack(times):
        for name, document_type in BOMBS.items():
            text = f'<?xml version="1.0"?>{document_type}<e:Envelope xmlns:e="{SOAP}"><e:Body><GetHostname xmlns="{SERVICES["tds"][0]}">&e9;</GetHostname></e:Body></e:Envelope>'
            for _ in range(times):
                status, answer = send(port, text.encode())
                assert status == 400 and "ter:WellFormed" in answer and "root:" not in answer and "camrigcamrig" not in answer, name
        for _ in range(times):
            assert send(port, b" " * 10_000_000)[0] == 413
            assert send(port, b"<a>" * 80_000)[0] == 400
            assert send(port, b"<a " + b"".join(b'b%d="" ' % n for n in range(20_000)) + b"/>")[0] == 400
        # Wrong passwords, signatures of another time, and ones that were seen.
        right = security(TOKEN, nonce=bytes([times]) * 16)
        assert post(port, MOVE, right)[0] == 200
        for _ in range(times):
            for header in (right, security("wrong"), security(TOKEN, age_s=900), security(TOKEN, age_s=-900), security(TOKEN, nonce=b"n" * 257)):
                status, text, _ = post(port, MOVE, header)
                assert status == 400 and "ter:NotAuthorized" in text
        assert post(port, "<tptz:Stop><tptz:ProfileToken>dome</tptz:ProfileToken></tptz:Stop>", security(TOKEN, nonce=bytes([times, 1]) * 8))[0] == 200

    attack(2)  # what is made at first use is there
    before, files = process.rss_kib(), process.fds()
    begin = time.monotonic()
    attack(8)
    assert time.monotonic() - begin < 60, "an attack costs the rig its time"
    wait_until(lambda: process.fds() <= files, what="the end of their connections")
    assert process.rss_kib() - before < 16 * 1024
    # Who asks as it should is answered as before.
    assert re.search("<tt:Hour>", post(port, "<tds:GetSystemDateAndTime/>")[1])


def test_slow_senders_are_closed_and_hold_up_nobody(dome):
    rig, port = dome
    slow = []
    for _ in range(100):
        raw = socket.create_connection(("127.0.0.1", port), 30)
        raw.sendall(b"POST /onvif/device_service HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 200\r\n\r\n<e:Env")
        slow.append(raw)
    begin = time.monotonic()
    closed = [False] * len(slow)
    while not all(closed):
        assert time.monotonic() - begin < 30, f"{closed.count(False)} of {len(slow)} are still there"
        assert post(port, "<tds:GetSystemDateAndTime/>")[0] == 200
        for number, raw in enumerate(slow):
            if closed[number]:
                continue
            try:
                raw.setblocking(False)
                raw.send(b"e")  # a byte now and then
                assert not raw.recv(4096).startswith(b"HTTP/1.1 2")
                closed[number] = True
            except BlockingIOError:
                pass
            except (BrokenPipeError, ConnectionResetError):
                closed[number] = True
        time.sleep(0.25)
    for raw in slow:
        raw.close()
