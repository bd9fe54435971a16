"""rig.record: which program it runs, and what it says of one that fails."""

import json
import sys

import pytest

import camrig
from camrig.farm.batch import export


@pytest.fixture
def program(fake_binary, tmp_path):
    """A camrig that serves, and whose `record` runs what is told."""
    path = tmp_path / "recorder"

    def program_(script):
        (tmp_path / "record.py").write_text("import sys\n" + script)
        path.write_text(f'#!/bin/sh\n[ "$1" = record ] && exec "{sys.executable}" "{tmp_path / "record.py"}" "$@"\nexec "{fake_binary}" "$@"\n')
        path.chmod(0o755)
        return path

    return program_


def failing(text, code=1):
    return f"sys.stderr.write({text!r}); sys.exit({code})"


def test_the_program_that_runs_the_rig_records(program, tmp_path, monkeypatch):
    monkeypatch.setenv("CAMRIG_BIN", "/nowhere/camrig")
    with camrig.start("scene.json", binary=program("import json; print(json.dumps({'words': sys.argv[1:]}))")) as rig:
        assert rig.program == str(tmp_path / "recorder")
        assert rig.record("set", ["lobby"], frames=2)["words"] == ["record", "--control", rig.control, "--json", "set", "--format", "png", "--cameras", "lobby", "--frames", "2"]
        # What others have started is recorded by the program that is found.
        with camrig.connect(rig.control) as other, pytest.raises(camrig.CamrigError, match="cannot run /nowhere/camrig"):
            other.record("set")


@pytest.mark.parametrize(
    "text, code, kind, message",
    [
        ('camrig: no camera x\n{"error": {"kind": "not_found", "message": "no camera x"}}\n', 1, "not_found", "no camera x"),
        ('{"error": {"kind": "already_exists", "message": "set: is there"}}\n', 1, "already_exists", "set: is there"),
        ("camrig: no rig at x\n", 1, "unavailable", "no rig at x"),
        ("camrig: --frames: must be a number\n", 2, "invalid_argument", "--frames: must be a number"),
        ("", 3, "unavailable", "record: exit code 3"),
        ('{"error": "of another form"}\n', 1, "unavailable", '{"error": "of another form"}'),
        ('{"error": {"kind": 1, "message": "x"}}', 1, "unavailable", '{"error": {"kind": 1, "message": "x"}}'),
        pytest.param("[" * 10_000, 1, "unavailable", "[" * 10_000, id="deep"),
    ],
)
def test_an_error_of_the_program_is_of_its_kind(program, text, code, kind, message):
    with camrig.start("scene.json", binary=program(failing(text, code))) as rig, pytest.raises(camrig.CamrigError) as caught:
        rig.record("set")
    assert (caught.value.kind, caught.value.message) == (kind, message)


def test_so_is_one_of_an_export(program, tmp_path, monkeypatch):
    monkeypatch.setenv("CAMRIG_BIN", str(program(failing(json.dumps({"error": {"kind": "resource_exhausted", "message": "the disk is full"}})))))
    monkeypatch.setattr(export, "_unpack", lambda *_: None)
    shard = {"shard": "0", "cameras": [], "picture_suffix": ".png", "pictures": {"yolo": False}}
    store = type("Set", (), {"folder": tmp_path, "manifest": lambda self: [shard]})()
    with pytest.raises(camrig.CamrigError, match="resource_exhausted: the disk is full"):
        export.write_recording(store, tmp_path / "out")
