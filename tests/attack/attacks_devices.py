"""The socket of user-space devices: peers that are no library of camrig's, and programs that are killed."""

from __future__ import annotations

import array
import contextlib
import os
import random
import signal
import socket
import struct
import subprocess
import time
from collections.abc import Iterator

import camrig

from target import Target

#: v4l2_sink/preload/protocol.h: struct camrig_request, and where the present format lies in the reply to a hello.
PROTOCOL, REQUEST_BYTES, FORMAT_AT, FORMAT_BYTES = 5, 204, 16 + 380, 20
HELLO, GET_FORMAT, ACQUIRE, STREAM_ON = 1, 2, 4, 6
NUMBER = 41


@contextlib.contextmanager
def _device(rig: camrig.Rig) -> Iterator[camrig.Camera]:
    cam = rig.create_camera("device", size=(160, 120), fps=25, position=(0, 0, 1), outputs=[{"kind": "device", "number": NUMBER}])
    try:
        yield cam
    finally:
        cam.delete()


def _connect(target: Target) -> socket.socket:
    raw = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    # The kernel's own time limit: with Python's, connect() fails at once where the backlog is full.
    for option in (socket.SO_SNDTIMEO, socket.SO_RCVTIMEO):
        raw.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", 10, 0))
    raw.connect(target.devices)
    return raw


def _request(kind: int, body: bytes = b"") -> bytes:
    return struct.pack("=II", kind, 1) + body.ljust(REQUEST_BYTES - 8, b"\0")


def _hello(program: bytes, mark: int = 1) -> bytes:
    return _request(HELLO, struct.pack("=II32sII", PROTOCOL, NUMBER, program, mark, 0))


def _is_served(target: Target) -> None:
    """A program that behaves is answered; that it is shows that the messages here are those of the protocol."""
    with _connect(target) as raw:
        raw.sendall(_hello(b"honest"))
        _, _, status = struct.unpack_from("=IIi", raw.recv(8192))
        assert status == 0, os.strerror(status)


def _descriptors(target: Target) -> int:
    return len(os.listdir(f"/proc/{target.pid}/fd"))


def _wait_for_descriptors(target: Target, most: int) -> None:
    deadline = time.monotonic() + 20.0
    while (now := _descriptors(target)) > most:
        assert time.monotonic() < deadline, f"{now} descriptors are open, {most} were before"
        time.sleep(0.05)


def garbage_for_devices(target: Target) -> str:
    """2000 connections that send anything: others are served, and nothing stays open."""
    rng = random.Random(4)
    with _device(target.rig):
        _is_served(target)
        before = _descriptors(target)
        for number in range(2000):
            with _connect(target) as raw:
                messages = [_hello(b"x", number)] * rng.randrange(2)
                messages += [rng.choice([_request(rng.randrange(16), rng.randbytes(REQUEST_BYTES - 8)), rng.randbytes(rng.randrange(1, 5000)), b"\0"])
                             for _ in range(rng.randrange(1, 6))]
                with contextlib.suppress(ConnectionError):  # it hangs up on them
                    for message in messages:
                        raw.sendall(message)
        _is_served(target)
        _wait_for_descriptors(target, before + 2)
    return "2000 connections"


def descriptors_for_devices(target: Target) -> str:
    """3000 times 100 descriptors in a message, some before a greeting and some after it: the rig keeps none."""
    with _device(target.rig), open("/dev/null") as nothing:
        _is_served(target)
        before, most = _descriptors(target), 0
        passed = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [nothing.fileno()] * 100).tobytes())]
        for number in range(3000):
            with _connect(target) as raw, contextlib.suppress(ConnectionError):
                if number % 2:
                    raw.sendall(_hello(b"x", number))
                    raw.recv(8192)
                raw.sendmsg([_request(GET_FORMAT if number % 2 else HELLO)], passed)
                raw.recv(8192)
                if number % 100 < 2:
                    most = max(most, _descriptors(target))
        _is_served(target)
        _wait_for_descriptors(target, before + 2)
    assert most < before + 50, f"{most} descriptors were open, {before} before"
    return f"3000 messages of 100 descriptors, at most {most - before} more open"


def programs_with_control_characters(target: Target) -> str:
    """What a program calls itself comes back in the rig's books and in the error of a step without escape sequences or line breaks."""
    with camrig.start("minimal", mode="lockstep") as rig, _device(rig):
        other = Target(rig, target.folder)
        with _connect(other) as raw:
            raw.sendall(_hello(b"\x1b[31mred\nline"))
            reply = raw.recv(8192)
            raw.sendall(_request(ACQUIRE))
            raw.recv(8192)
            raw.sendall(_request(STREAM_ON, reply[FORMAT_AT:FORMAT_AT + FORMAT_BYTES]))
            _, _, status = struct.unpack_from("=IIi", raw.recv(8192))
            assert status == 0, os.strerror(status)
            try:  # it queues no buffer and takes no picture
                rig.call("world.step", seconds=1, timeout_s=1)
                message = ""
            except camrig.CamrigError as error:
                message = str(error)
            books = repr(rig.stats())
    assert "?[31mred?line" in message, f"the step does not name its reader: {message!r}"
    assert "?[31mred?line" in books and "\\x1b" not in books and not any(ord(character) < 32 for character in message), (message, books)
    return message[:150]


def killed_device_programs(target: Target) -> str:
    """60 programs with a device open are killed in the middle of it."""
    with _device(target.rig):
        _is_served(target)
        before = _descriptors(target)
        for _ in range(60):
            reader = subprocess.Popen([camrig.launch.find_binary(), "--control", target.control, "exec", "--", "v4l2-ctl", "-d", f"/dev/video{NUMBER}",
                                       "--stream-mmap", "--stream-count=1000"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            said = reader.stdout.read(3)
            assert said.startswith(b"<"), f"it was not streaming: {said + reader.stdout.read1(500)}"
            reader.send_signal(signal.SIGKILL)
            reader.wait()
            reader.stdout.close()
        _is_served(target)
        _wait_for_descriptors(target, before + 2)
    return "60 killed"


ATTACKS = [garbage_for_devices, descriptors_for_devices, programs_with_control_characters, killed_device_programs]
