"""The rig that is attacked, and ways to reach it that no decent client would take."""

from __future__ import annotations

import http.client
import json
import os
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import camrig


class Target:
    def __init__(self, rig: camrig.Rig, folder: Path) -> None:
        self.rig = rig
        self.folder = folder  # for files of the attacks; gone afterwards
        info = rig.call("server.info")
        self.pid: int = info["pid"]
        self.control: str = info["control"]
        self.control_tcp: int | None = info.get("tcp")
        self.http: int = info["http"]
        self.rtsp: int = info["rtsp"]
        self.devices: str = info["devices"]
        #: What lets a client of the network command.
        self.owner_headers = {"Authorization": f"Bearer {Path(info['key_file']).read_text().strip()}"} if "key_file" in info else {}

    def is_alive(self) -> bool:
        return Path(f"/proc/{self.pid}/stat").exists() and Path(f"/proc/{self.pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"

    def rss_kib(self) -> int:
        """Resident memory of the daemon."""
        return self._memory_kib("VmRSS")

    def peak_kib(self) -> int:
        """The largest rss_kib() since forget_peak()."""
        return self._memory_kib("VmHWM")

    def forget_peak(self) -> None:
        Path(f"/proc/{self.pid}/clear_refs").write_text("5")

    def _memory_kib(self, field: str) -> int:
        status = Path(f"/proc/{self.pid}/status").read_text()
        return int(next(line.split()[1] for line in status.splitlines() if line.startswith(f"{field}:")))

    def cpu_s(self) -> float:
        fields = Path(f"/proc/{self.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def settle(self) -> None:
        """Every kind of picture and truth drawn once, so that what is made at first use is there."""
        name = self.rig.cameras()[0].name
        cam = self.rig.camera(name)
        cam.frame(), cam.depth(), cam.instances(), cam.truth()
        time.sleep(2.0)  # connections of what came before have their time to end

    def unix(self, timeout_s: float = 20.0) -> socket.socket:
        raw = socket.socket(socket.AF_UNIX)
        raw.settimeout(timeout_s)
        end = time.monotonic() + timeout_s
        while True:
            try:
                raw.connect(self.control)
                return raw
            except BlockingIOError:  # so many wait to be taken already; a socket with a time limit is told so at once
                if time.monotonic() > end:
                    raise
                time.sleep(0.01)

    def tcp(self, port: int, timeout_s: float = 20.0) -> socket.socket:
        return socket.create_connection(("127.0.0.1", port), timeout_s)

    def ask_http(self, method: str, path: str, body: bytes | None = None, headers: dict[str, str] | None = None,
                 timeout_s: float = 20.0) -> tuple[int, dict[str, str], bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self.http, timeout=timeout_s)
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return answer.status, {key.lower(): value for key, value in answer.getheaders()}, answer.read(400 << 20)
        finally:
            connection.close()

    def owner_is_answered(self, within_s: float = 2.0) -> float:
        """Seconds until the owner's own call is answered; fails when it takes longer."""
        begin = time.monotonic()
        with self.unix(within_s) as raw:
            raw.sendall(b'{"jsonrpc":"2.0","id":1,"method":"world.status"}\n')
            answer = json.loads(read_line(raw))
        took = time.monotonic() - begin
        assert "result" in answer, answer
        assert took <= within_s, f"the owner waited {took:.1f} s"
        return took


def read_line(raw: socket.socket, most: int = 400 << 20) -> bytes:
    """One line of an answer; a short one when the peer closes."""
    data = bytearray()
    while not data.endswith(b"\n") and len(data) < most:
        chunk = raw.recv(1 << 20)
        if not chunk:
            break
        data += chunk
    return bytes(data)


def request(method: str, number: int = 1, **params: Any) -> dict[str, Any]:
    return {"jsonrpc": "2.0", "id": number, "method": method, "params": params}


def send_until_closed(raw: socket.socket, chunk: bytes, most_bytes: int, timeout_s: float = 10.0) -> int:
    """Sends and sends; how many bytes were taken until the peer closed, stopped reading for timeout_s, or all was sent."""
    raw.settimeout(timeout_s)
    sent = 0
    try:
        while sent < most_bytes:
            sent += raw.send(chunk)
    except OSError:
        pass
    return sent


class Ended(NamedTuple):
    status: int  # negative: by this signal
    said: str
    peak_mib: float
    took_s: float


def run_measured(command: list[str], timeout_s: float = 60.0) -> Ended:
    """A program of the owner's, to its end."""
    begin = time.monotonic()
    with tempfile.TemporaryFile() as said:
        program = subprocess.Popen(["timeout", "-s", "KILL", str(timeout_s), *command], stdin=subprocess.DEVNULL, stdout=said, stderr=said)
        _, status, use = os.wait4(program.pid, 0)
        program.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read().decode(errors="replace")
    return Ended(program.returncode, text, use.ru_maxrss / 1024, time.monotonic() - begin)
