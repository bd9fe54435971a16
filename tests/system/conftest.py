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

from camrig import launch  # noqa: E402
from witness import Witness  # noqa: E402


@pytest.fixture(scope="session")
def scenes() -> pathlib.Path:
    return REPOSITORY / "scenes"


def wait_until(condition, timeout_s=20.0, what="condition"):
    """Waits until condition() is true; fails with `what` after timeout_s."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, f"timed out after {timeout_s} s waiting for {what}"
        time.sleep(0.01)


def what_threads_do(pid):
    """Of each thread of a process: name, state, where in the kernel it waits, seconds on a processor and of waiting for one."""
    told = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
        with contextlib.suppress(OSError):
            ran, waited = ((task / "schedstat").read_text().split() + ["0", "0"])[:2]
            name, state = (task / "comm").read_text().strip(), (task / "stat").read_text().rpartition(")")[2].split()[0]
            told.append((name, state, (task / "wchan").read_text(), round(int(ran) / 1e9, 2), round(int(waited) / 1e9, 2)))
    return told


@pytest.fixture(scope="session", autouse=True)
def rigs_end_in_time():
    """A rig has 5 s for its end ($CAMRIG_STOP_TIMEOUT_S for slower builds), beside the time in which this machine let nobody go on."""
    end, in_time_s = launch._end, launch._stop_timeout_s()

    def end_in_time(child):
        begin, waits = time.monotonic(), []
        late = threading.Timer(in_time_s, lambda: waits.extend(what_threads_do(child.pid)))
        late.daemon = True
        late.start()
        with Witness() as witness:
            wrong = end(child)
        late.cancel()
        took_s = time.monotonic() - begin
        if wrong is None and took_s > in_time_s + witness.total_s:
            return f"took {took_s:.1f} s to end after SIGTERM, of which this machine was held up for {witness.total_s:.1f} s; after {in_time_s} s: {waits}"
        return wrong

    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(launch, "_end", end_in_time)
        changed.setattr(launch, "_stop_timeout_s", lambda: in_time_s + 15)
        yield


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
