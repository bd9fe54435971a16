"""Few file descriptors: whom the rig serves last, and how many it allows itself."""

import contextlib
import json
import pathlib
import resource
import socket

import pytest

import camrig
from conftest import Process
from rtsp_client import RtspReader, take


def limited(tmp_path, option, limit):
    """The rig's program where a shell has set this limit."""
    program = tmp_path / "camrig-few"
    program.write_text(f'#!/bin/sh\nulimit {option} {limit}\nexec {camrig.launch.find_binary()} "$@"\n')
    program.chmod(0o755)
    return program


def test_streams_leave_descriptors_for_the_owner(scenes, tmp_path):
    """Readers filled the table until the owner's own socket could not be accepted."""
    limit = 200
    with camrig.start(str(scenes / "minimal.json"), binary=limited(tmp_path, "-n", limit), tcp=0) as rig, contextlib.ExitStack() as held:
        info = rig.call("server.info")
        process = Process(info["pid"])
        rtsp = RtspReader(rig.rtsp_url + "/main")

        def connected(service):
            return held.enter_context(socket.create_connection(("127.0.0.1", info[service]), 20))

        for _ in range(limit):
            raw = connected("http")
            raw.sendall(b"GET /cameras/main/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n")
            if raw.recv(64).startswith(b"HTTP/1.1 503"):
                break
        else:
            pytest.fail("nobody was refused")
        assert limit - 60 < process.fds() < limit - 40
        refused = json.loads(connected("tcp").makefile().readline())
        assert "too many open files" in refused["error"]["message"]
        owners = [camrig.connect(info["control"]) for _ in range(20)]
        assert all(owner.call("world.status") for owner in owners)
        assert len(take(rtsp, 3)) == 3
        counts = rig.call("server.info")["connections"]
        assert counts["http"]["refused"] == 1 and counts["control"]["refused"] == 1 and counts["rtsp"]["open"] == 1, counts
        assert "http: connections are refused" in rig.log and "control: connections are refused" in rig.log


def test_the_soft_limit_of_a_shell_is_raised(scenes, tmp_path):
    hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    with camrig.start(str(scenes / "minimal.json"), binary=limited(tmp_path, "-Sn", 256)) as rig:
        limits = pathlib.Path(f"/proc/{rig.call('server.info')['pid']}/limits").read_text()
        soft = next(line for line in limits.splitlines() if line.startswith("Max open files")).split()[3]
        assert int(soft) == min(8192, hard)
