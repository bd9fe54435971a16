import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parents[2] / "control" / "python"))

import camrig  # noqa: E402
import fake_rig  # noqa: E402

pytest_plugins = ["pytester"]


@pytest.fixture
def fake(tmp_path):
    """A stand-in for the daemon at tmp_path/control.sock."""
    rig = fake_rig.FakeRig()
    server = fake_rig.serve_unix(rig, str(tmp_path / "control.sock"))
    yield rig
    server.shutdown()
    server.server_close()


@pytest.fixture
def client_rig(fake, tmp_path):
    with camrig.connect(tmp_path / "control.sock") as rig:
        fake.requests.clear()
        yield rig


@pytest.fixture
def fake_binary(tmp_path):
    """A program that takes the command line of `camrig serve`."""
    path = tmp_path / "camrig"
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{HERE / "fake_rig.py"}" "$@"\n')
    path.chmod(0o755)
    return path
