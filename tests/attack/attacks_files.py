"""Files and sockets that strangers put where the rig or its clients will look."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from pathlib import Path

import camrig

from target import Target

STRANGER_UID = 65534


def a_link_in_the_place_of_a_device(target: Target) -> str:
    """The folder of a rig's devices was made before by somebody else, with a link to a file of the owner's in the place of a device."""
    precious = target.folder / "precious"
    precious.write_text("not to be lost")
    control = target.folder / "linked.sock"
    told = []
    for prepared in (Path(f"{control}.d/devices.tree/dev"), Path(f"{control}.devices.tree/dev")):
        prepared.mkdir(parents=True)
        (prepared / "video10").symlink_to(precious)
        for folder in (prepared, *prepared.parents):
            if folder == target.folder:
                break
            os.chown(folder, STRANGER_UID, STRANGER_UID)
        binary = camrig.launch.find_binary()
        ready, said = os.pipe()
        rig = subprocess.Popen([binary, "serve", "minimal", "--http", "0", "--rtsp", "0", "--control", str(control), "--ready-fd", str(said)],
                               pass_fds=(said,), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        os.close(said)
        try:
            with os.fdopen(ready) as pipe:
                serves = bool(pipe.readline())
            if serves:
                created = subprocess.run([binary, "--control", str(control), "camera", "create", "x", "--position", "1,1,1", "--device", "10"],
                                         capture_output=True, text=True, timeout=20)
                assert created.returncode == 0, created.stderr  # that was not in its way
                told.append("served")
            else:
                rig.wait(20)
        finally:
            rig.terminate()
            told += rig.communicate(timeout=20)[1].splitlines()[:1] if rig.poll() is not None else []
            rig.wait(20)
        assert precious.read_text() == "not to be lost", f"the owner's file was written to through {prepared}"
        shutil.rmtree(f"{control}.d", ignore_errors=True)
    assert told and f"{control}.d: belongs to user {STRANGER_UID}" in told[0], told
    return told[0][:150]


def a_strangers_socket(target: Target) -> str:
    """Another user's program listens where the owner's rig would: the command line does not talk to it."""
    path = target.folder / "taken.sock"
    os.chmod(target.folder, 0o755)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        os.chmod(path, 0o777)
        listens, says = os.pipe()
        pid = os.fork()
        if pid == 0:  # the stranger: SO_PEERCRED tells who called listen()
            status = 2
            try:
                os.setgroups([]), os.setgid(STRANGER_UID), os.setuid(STRANGER_UID)
                listener.listen(4)
                os.write(says, b".")
                listener.settimeout(10)
                peer, _ = listener.accept()
                peer.settimeout(3)
                status = 1 if peer.recv(1000) else 0
            finally:
                os._exit(status)
        os.close(says)
        with os.fdopen(listens, "rb") as pipe:
            assert pipe.read(1) == b".", "the stranger does not listen"
        done = subprocess.run([camrig.launch.find_binary(), "--control", str(path), "camera", "list"], capture_output=True, text=True, timeout=30)
        _, status = os.waitpid(pid, 0)
    assert (status := os.waitstatus_to_exitcode(status)) == 0, "the stranger was sent a command" if status == 1 else "nobody came to the stranger"
    assert done.returncode == 1 and f"served by user {STRANGER_UID}" in done.stderr, done.stderr
    return done.stderr.strip()[:120]


def scenes_that_lead_elsewhere(target: Target) -> str:
    """A scene that is a link to somebody's private file does not tell what is in it."""
    secret = target.folder / "secret"
    secret.write_text("#top secret")
    link = target.folder / "x.json"
    link.symlink_to(secret)
    errors = target.rig.call("scene.check", scene=str(link))["errors"]
    assert errors and all(error["file"] == str(link) for error in errors), errors
    assert not any("top" in error["message"] or "secret" in error["message"] for error in errors), errors
    return errors[0]["message"][:120]


ATTACKS = [a_link_in_the_place_of_a_device, a_strangers_socket, scenes_that_lead_elsewhere]
