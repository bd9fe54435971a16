"""Files and sockets that strangers put where the rig or its clients will look."""

from __future__ import annotations

import os
import random
import socket
import subprocess
import threading
from pathlib import Path

import camrig

from target import Target

STRANGER_UID = 65534


def a_link_in_the_place_of_a_device(target: Target) -> str:
    """The tree of devices of a rig without $XDG_RUNTIME_DIR was made before, with a link to a file of the owner's."""
    precious = target.folder / "precious"
    precious.write_text("not to be lost")
    control = target.folder / "linked.sock"
    tree = Path(f"{control}.devices.tree/dev")
    tree.mkdir(parents=True)
    (tree / "video10").symlink_to(precious)
    os.chown(tree.parent, STRANGER_UID, STRANGER_UID)
    binary = camrig.launch.find_binary()
    rig = subprocess.Popen([binary, "serve", "minimal", "--http", "0", "--rtsp", "0", "--control", str(control)], stderr=subprocess.DEVNULL,
                           stdout=subprocess.DEVNULL)
    try:
        for _ in range(200):
            if control.exists() or rig.poll() is not None:
                break
            threading.Event().wait(0.05)
        subprocess.run([binary, "--control", str(control), "camera", "create", "x", "--position", "1,1,1", "--device", "10"], capture_output=True, timeout=20)
    finally:
        rig.terminate()
        rig.wait(10)
    assert precious.read_text() == "not to be lost", "the owner's file was written to"
    return ""


def a_strangers_socket(target: Target) -> str:
    """Another user's program listens where the owner's rig would: the command line does not talk to it."""
    path = target.folder / "taken.sock"
    os.chmod(target.folder, 0o755)
    heard: list[bytes] = []
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        os.chmod(path, 0o777)
        pid = os.fork()
        if pid == 0:  # the stranger: SO_PEERCRED tells who called listen()
            os.setgroups([]), os.setgid(STRANGER_UID), os.setuid(STRANGER_UID)
            listener.listen(4)
            listener.settimeout(10)
            try:
                peer, _ = listener.accept()
                peer.settimeout(3)
                os._exit(1 if peer.recv(1000) else 0)
            except OSError:
                os._exit(0)
        threading.Event().wait(0.5)
        done = subprocess.run([camrig.launch.find_binary(), "--control", str(path), "camera", "list"], capture_output=True, text=True, timeout=30)
        _, status = os.waitpid(pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, "the stranger was sent a command"
    assert done.returncode == 1 and "internal" not in done.stderr, done.stderr
    return done.stderr.strip()[:120]


def scenes_that_lead_elsewhere(target: Target) -> str:
    """A scene that is a link to somebody's private file does not tell what is in it."""
    secret = target.folder / "secret"
    secret.write_text("#top secret")
    link = target.folder / "x.json"
    link.symlink_to(secret)
    try:
        target.rig.call("scene.check", scene=str(link))
        message = ""
    except camrig.CamrigError as error:
        message = str(error)
    assert "top secret" not in message and "'#'" not in message, message
    return message[:120]


def damaged_scenes(target: Target) -> str:
    """300 damaged models: a clear error or a scene, never more."""
    repository = Path(__file__).resolve().parents[2]
    original = next(iter(sorted((repository / "scenes" / "minimal").glob("*.glb")))).read_bytes()
    rng = random.Random(3)
    refused = 0
    with camrig.start("minimal", mode="lockstep") as rig:
        for number in range(300):
            data = bytearray(original)
            for _ in range(rng.choice([1, 10, 200])):
                data[rng.randrange(len(data))] = rng.randrange(256)
            path = target.folder / f"damaged{number % 4}.glb"
            path.write_bytes(data[: rng.randrange(len(data)) if number % 3 == 0 else len(data)])
            try:
                rig.load(str(path))
            except camrig.CamrigError as error:
                assert error.kind in ("invalid_argument", "unsupported", "resource_exhausted"), error
                refused += 1
    return f"{refused} of 300 refused"


def killed_device_readers(target: Target) -> str:
    """20 programs with a device open are killed in the middle of it."""
    cam = target.rig.create_camera("device", size=(160, 120), fps=25, place="lobby", outputs=[{"kind": "device", "number": 41}])
    binary = camrig.launch.find_binary()
    try:
        for _ in range(20):
            reader = subprocess.Popen([binary, "--control", target.control, "exec", "--", "v4l2-ctl", "-d", "/dev/video41", "--stream-mmap",
                                       "--stream-count=1000"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            reader.stdout.read(3)
            reader.kill()
            reader.wait()
    finally:
        cam.delete()
    return ""


ATTACKS = [a_link_in_the_place_of_a_device, a_strangers_socket, scenes_that_lead_elsewhere, damaged_scenes, killed_device_readers]
