"""What makes a rig fast must not be seen: each switch on and off, on the hall."""

import io
import os
import subprocess
import urllib.request

import numpy as np
import pytest
from PIL import Image

import camrig

PLACES = ("lobby", "gallery", "entrance")
STEPS = 4


def pictures(*args, quality="simple", antialias="none", device="cpu"):
    """Colour, depth and ids of three standing cameras at four moments."""
    seen = []
    with camrig.start("scenes/hall.json", mode="lockstep", device=device, quality=quality, args=args) as rig:
        cameras = [rig.create_camera(f"at_{place}", place=place, size=(320, 240), fps=10, antialias=antialias) for place in PLACES]
        for _ in range(STEPS):
            rig.step(seconds=0.1)
            seen += [(camera.frame().image, camera.depth(), camera.instances()) for camera in cameras]
    return seen


@pytest.mark.parametrize("quality, antialias", [("fast", "none"), ("simple", "none"), ("beautiful", "none"), ("beautiful", "auto"), ("simple", "msaa4")])
def test_static_layers_change_no_byte(quality, antialias):
    for kept, full in zip(pictures(quality=quality, antialias=antialias), pictures("--static-layer-mb", "0", quality=quality, antialias=antialias)):
        for a, b in zip(kept, full):
            assert np.array_equal(a, b)


def test_calls_of_opengl_are_counted():
    with camrig.start("scenes/hall.json", mode="lockstep", device="llvmpipe") as rig:
        rig.create_camera("at_lobby", place="lobby", size=(64, 48)).frame()
        counted = rig.stats()["renderer"]
    assert counted["draws"] > 100
    assert counted["draw_calls"] < counted["draws"] / 2, "surfaces that differ only in mesh and place are one call"


def test_coarser_people_stay_within_a_quarter_of_a_pixel():
    """A border that moves by a quarter of a pixel changes at most a quarter of the pixels along it, on either side."""
    coarse, full = pictures(), pictures("--detail-error-px", "0")
    changed = border = 0
    for (_, _, a), (_, _, b) in zip(coarse, full):
        changed += np.count_nonzero(a != b)
        border += np.count_nonzero(b[:, 1:] != b[:, :-1]) + np.count_nonzero(b[1:] != b[:-1])
    assert 0 < changed < 0.25 * border, f"{changed} of {border} border pixels"
    differences = [np.abs(a.astype(int) - b.astype(int)) for (a, _, _), (b, _, _) in zip(coarse, full)]
    assert np.mean(differences) < 0.2, "sRGB codes, mean over the pictures"


def next_part(stream):
    """Sequence and JPEG of the next part of an MJPEG stream."""
    fields = {}
    for line in iter(stream.readline, b""):
        name, _, value = line.decode().strip().partition(": ")
        if value:
            fields[name] = value
        elif fields:
            break
    return int(fields["X-Sequence"]), stream.read(int(fields["Content-Length"]))


@pytest.mark.parametrize("device, args", [("cpu", ()), ("llvmpipe", ("--convert-on", "device"))])
def test_a_stream_has_the_bytes_of_snapshots(device, args):
    """A stream compresses what changed since its last picture, a snapshot everything. Seen from above and once a second, people leave
    the rows where they were, so that a row too few shows."""
    with camrig.start("scenes/hall.json", mode="lockstep", device=device, args=args) as rig:
        cam = rig.create_camera("above", place="overhead", size=(640, 360), fps=1)
        with urllib.request.urlopen(cam.url(), timeout=60) as stream:
            last, _ = next_part(stream)
            for step in range(10):
                if step == 4:
                    cam.set(controls={"brightness": 0.2})
                if step == 7:
                    cam.set(vfov_deg=50)
                rig.step(seconds=1)
                with urllib.request.urlopen(cam.url("jpg"), timeout=60) as answer:
                    shown, snapshot = int(answer.headers["X-Sequence"]), answer.read()
                while last < shown:
                    last, streamed = next_part(stream)
                assert last == shown and streamed == snapshot, f"step {step}"


FOURCCS = ("YUYV", "YU12", "NV12", "BGR3")


def device_pictures(folder, convert_on):
    """A chart that stands still: read from a device in every layout beside an MJPEG reader, and as JPEG and PNG; with what was counted."""
    with camrig.start("scenes/calibration.json", mode="realtime", device="llvmpipe", args=("--convert-on", convert_on)) as rig:
        cam = rig.create_camera("chart", size=(322, 242), fps=30, position=(0, 0, 1.5), outputs=[{"kind": "device", "number": 9}])
        raw = {}
        with urllib.request.urlopen(cam.url(), timeout=60) as stream:
            next_part(stream)
            for fourcc in FOURCCS:
                file = folder / f"{convert_on}-{fourcc}"
                done = subprocess.run([os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--",
                                       "v4l2-ctl", "-d", "/dev/video9", f"--set-fmt-video=pixelformat={fourcc}", "--stream-mmap",
                                       "--stream-count=1", f"--stream-to={file}"], capture_output=True, text=True, timeout=60, check=False)
                assert done.returncode == 0, done.stderr
                raw[fourcc] = file.read_bytes()
            jpeg = next_part(stream)[1]
        with urllib.request.urlopen(cam.url("png"), timeout=60) as answer:
            png = answer.read()
        stats = rig.stats()
        counted = {stage["name"]: stage["count"] for stage in stats["stages"]}
        counted.update(stats["renderer"])
    return raw, jpeg, png, counted


def test_readers_get_the_same_picture_wherever_colours_are_converted(tmp_path):
    host, host_jpeg, host_png, host_counted = device_pictures(tmp_path, "host")
    device, device_jpeg, device_png, device_counted = device_pictures(tmp_path, "device")
    assert host == device and len(set(host.values())) == len(FOURCCS)
    assert host_png == device_png
    assert host_counted["convert"] >= len(FOURCCS) and host_counted["conversions"] == 0
    assert device_counted["convert"] == 0 and device_counted["conversions"] >= len(FOURCCS)
    # A JPEG is made of planes there and of RGB here: as near to the picture, not the same bytes.
    drawn = decoded(host_png)
    errors = [np.mean((decoded(jpeg) - drawn) ** 2) for jpeg in (host_jpeg, device_jpeg)]
    assert errors[0] > 0 and abs(10 * np.log10(errors[1] / errors[0])) < 0.1, "dB"


def decoded(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(float)
