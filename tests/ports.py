"""Ports for servers that must be told one."""

import contextlib
import itertools
import os
import socket

#: Below those that the kernel gives to whoever asks for any (net.ipv4.ip_local_port_range), of which another program may get one at any time;
#: each process of a test run that has several takes its own.
_FIRST, _OF_EACH = 20_000, 1_000
_places = itertools.cycle(range(_OF_EACH))


def free_port() -> int:
    """One that nobody listens at and that no other process of this test run is told."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw11").removeprefix("gw")) % 12
    for place in itertools.islice(_places, _OF_EACH):
        with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", _FIRST + worker * _OF_EACH + place)) as server:
            return server.getsockname()[1]
    raise OSError("no port is free")
