"""Ends of a rig: killed, told to end under load or in the middle of what is dear, and started again at once."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import camrig

from attacks_work import HARD_TRUTH, create_hard
from bystanders import rtsp_times
from target import Target, request

#: The review saw 0.2 to 4.5 s under load.
MOST_END_S = 5.0


def _serve(scene: str, control: Path, *arguments: str) -> subprocess.Popen:
    """A rig that is ready, as a person would have started it."""
    ready, told = os.pipe()
    rig = subprocess.Popen([camrig.launch.find_binary(), "serve", scene, "--http", "0", "--rtsp", "0", "--control", str(control), "--ready-fd", str(told), *arguments],
                           pass_fds=(told,), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    os.close(told)
    with os.fdopen(ready) as pipe:
        assert pipe.readline(), f"it does not start: {rig.stderr.read()[-500:]}"
    return rig


@contextlib.contextmanager
def _busy_rig(folder: Path, name: str) -> Iterator[tuple[subprocess.Popen, camrig.Rig]]:
    control = folder / f"{name}.sock"
    process = _serve("hall", control)
    try:
        with camrig.connect(control) as rig:
            yield process, rig
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


def _seconds_until_the_end(process: subprocess.Popen) -> float:
    begin = time.monotonic()
    process.send_signal(signal.SIGTERM)
    process.wait(60)
    took = time.monotonic() - begin
    assert process.returncode == 0, f"it ended with {process.returncode}: {process.stderr.read()[-500:]}"
    assert took < MOST_END_S, f"it took {took:.1f} s to end"
    return took


def told_to_end_in_hard_truth(target: Target) -> str:
    """SIGTERM while truth of hard cameras is asked for on four connections: the rig ends in time."""
    with _busy_rig(target.folder, "truth") as (process, rig):
        other = Target(rig, target.folder)
        for number, hard in enumerate(HARD_TRUTH):
            create_hard(rig, f"hard{number}", *hard)
        asking = [other.unix() for _ in range(4)]
        for raw in asking:
            raw.sendall(b"".join(_line(request("truth.get", n, camera=f"hard{n % len(HARD_TRUTH)}")) for n in range(20)))
        asking[0].recv(1)  # the first is made; the others are under way
        took = _seconds_until_the_end(process)
        for raw in asking:
            raw.close()
    return f"ended in {took:.2f} s"


def told_to_end_under_load(target: Target) -> str:
    """SIGTERM with 12 cameras of 1280x720 read over HTTP and RTSP, mute readers, and snapshots asked for: the rig ends in time."""
    with _busy_rig(target.folder, "load") as (process, rig):
        other = Target(rig, target.folder)
        held = []
        for number in range(12):
            rig.create_camera(f"c{number}", size=(1280, 720), fps=25, place="lobby")
            for _ in range(4):
                raw = other.tcp(other.http)
                raw.sendall(f"GET /cameras/c{number}/stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
                held.append(raw)
            raw = other.unix()
            raw.sendall(b"".join(_line(request("frame.get", n, camera=f"c{number}", format="png")) for n in range(20)))
            held.append(raw)
        readers = [_mute_rtsp_reader(rig, f"c{number}") for number in range(4)]
        for raw in held:
            raw.recv(1)
        took = _seconds_until_the_end(process)
        for raw in (*held, *readers):
            raw.close()
    return f"ended in {took:.2f} s"


def _mute_rtsp_reader(rig: camrig.Rig, name: str) -> socket.socket:
    """It plays and takes nothing."""
    return rtsp_times.RtspReader(rig.camera(name).url("rtsp")).socket


def killed_and_started_again(target: Target) -> str:
    """20 rigs are killed (SIGKILL) in turn while they are read; the next one at the same socket serves, devices too."""
    control, took = target.folder / "again.sock", []
    for number in range(20):
        begin = time.monotonic()
        process = _serve("minimal", control)
        took.append(time.monotonic() - begin)
        try:
            with camrig.connect(control) as rig:
                cam = rig.create_camera("c", size=(160, 120), position=(0, 0, 1), outputs=[{"kind": "device", "number": 42}])
                assert cam.frame().image.shape == (120, 160, 3)
                stream = socket.create_connection(("127.0.0.1", rig.info()["http"]), 10)
                stream.sendall(b"GET /cameras/c/stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                assert stream.recv(15) == b"HTTP/1.1 200 OK"
                process.kill()
                stream.close()
        finally:
            process.kill()
            process.wait()
            process.stderr.close()
    return f"20 starts, at most {max(took):.2f} s"


def started_and_ended(target: Target) -> str:
    """20 rigs are started at one socket and told to end at once: status 0, and nothing is left behind."""
    control = target.folder / "short.sock"
    for _ in range(20):
        process = _serve("minimal", control)
        _seconds_until_the_end(process)
        process.stderr.close()
    left = [path.name for path in target.folder.glob("short.sock*")]
    assert not left, left
    return "20 ended"


def _line(message: dict) -> bytes:
    return json.dumps(message).encode() + b"\n"


ATTACKS = [told_to_end_in_hard_truth, told_to_end_under_load, killed_and_started_again, started_and_ended]
