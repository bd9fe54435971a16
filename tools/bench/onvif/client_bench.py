"""What the benches of clients share: a rig with a camera on a head as a device of its own, and a line for each thing that a client was seen to do."""

from __future__ import annotations

import contextlib
import pathlib
import socket
import tempfile

import camrig

TOKEN = "client-bench"  # the device's password
_verdicts: list[bool] = []


@contextlib.contextmanager
def dome(size):
    """The rig, camera `dome` that sees a box move, and the port of its device, whose password is TOKEN. Pan is within 90 degrees, tilt from -60 to 30."""
    with tempfile.TemporaryDirectory() as folder:
        (token := pathlib.Path(folder) / "token").write_text(TOKEN + "\n")
        with camrig.start("minimal", args=["--token-file", str(token)]) as rig:
            port = free_port()
            head = {"preset": "dome", "pan_limits_deg": [-90, 90], "tilt_limits_deg": [-60, 30]}
            yield rig, rig.create_camera("dome", place="main", size=size, fps=25, ptz=head, outputs=[{"kind": "onvif", "port": port}]), port


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def verdict(what: str, holds: bool, said: object = "") -> None:
    """One line: `ok` or `WRONG`, what was looked at, what was seen."""
    _verdicts.append(bool(holds))
    print(f"{'ok' if holds else 'WRONG':6}{what}{f': {said}' if said != '' else ''}", flush=True)


def end() -> None:
    """Counts the lines; ends the program, with 1 where one of them does not hold."""
    print(f"{sum(_verdicts)} of {len(_verdicts)} hold")
    raise SystemExit(0 if all(_verdicts) else 1)
