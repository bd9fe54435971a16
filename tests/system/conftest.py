"""Shared by the system tests: every test talks to a real rig through its public doors only."""

import contextlib
import os
import pathlib
import socket
import subprocess
import sys
import threading
import time
import urllib.parse

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))


@pytest.fixture(scope="session")
def scenes() -> pathlib.Path:
    return REPOSITORY / "scenes"


def wait_until(condition, timeout_s=20.0, what="condition"):
    """Waits until condition() is true; fails with `what` after timeout_s."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"timed out after {timeout_s} s waiting for {what}"
        time.sleep(0.01)


class Witness:
    """A thread that only sleeps, while the block runs: longest_s is how long this machine kept it from going on, at most."""

    def __init__(self):
        self.longest_s = 0.0
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def _watch(self):
        before = time.monotonic()
        while not self._is_over.is_set():
            time.sleep(0.02)
            before, late_by_s = (now := time.monotonic()), now - before - 0.02
            self.longest_s = max(self.longest_s, late_by_s)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._is_over.set()
        self._thread.join()


@pytest.fixture
def programs():
    """Starts programs as subprocess.Popen does. Those that still run when the test has ended, well or not, are killed and waited for."""
    started = []

    def start(*command, **options):
        started.append(subprocess.Popen(*command, **options))
        return started[-1]

    yield start
    for program in started:
        program.kill()
    for program in started:
        program.wait(20)
        for pipe in filter(None, (program.stdin, program.stdout, program.stderr)):
            with contextlib.suppress(BrokenPipeError):  # of what was never sent
                pipe.close()


class Process:
    """What the kernel says of a process: memory, descriptors, threads."""

    def __init__(self, pid: int):
        self.pid = pid

    def rss_kib(self) -> int:
        for line in pathlib.Path(f"/proc/{self.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1])
        raise AssertionError("no VmRSS")

    def peak_kib(self) -> int:
        """The largest rss_kib() since forget_peak()."""
        for line in pathlib.Path(f"/proc/{self.pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1])
        raise AssertionError("no VmHWM")

    def forget_peak(self) -> None:
        pathlib.Path(f"/proc/{self.pid}/clear_refs").write_text("5")

    def fds(self) -> int:
        return len(os.listdir(f"/proc/{self.pid}/fd"))

    def threads(self) -> int:
        return len(os.listdir(f"/proc/{self.pid}/task"))


@pytest.fixture
def process(rig) -> Process:
    return Process(rig.call("server.info")["pid"])


def control_socket(rig) -> socket.socket:
    """A raw connection to the control socket, for messages no decent client would send."""
    raw = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    raw.settimeout(30)
    raw.connect(rig.call("server.info")["control"])
    return raw


def stuck_mjpeg_reader(cam) -> socket.socket:
    """A client that opens the camera's stream and then takes nothing; its receive buffer is as small as they come."""
    url = urllib.parse.urlparse(cam.url())
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.connect((url.hostname, url.port))
    raw.sendall(f"GET {url.path} HTTP/1.1\r\nHost: {url.netloc}\r\n\r\n".encode())
    raw.recv(100)
    return raw
