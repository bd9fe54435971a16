"""What makes a rig fast must not be seen: each switch on and off, on the hall."""

import urllib.request

import numpy as np
import pytest

import camrig

PLACES = ("lobby", "gallery", "entrance")
STEPS = 4


def pictures(*args, quality="simple", antialias="none"):
    """Colour, depth and ids of three standing cameras at four moments."""
    seen = []
    with camrig.start("scenes/hall.json", mode="lockstep", device="cpu", quality=quality, args=args) as rig:
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


@pytest.mark.parametrize("args", [(), ("--plain-jpeg",)])
def test_a_stream_has_the_bytes_of_snapshots(args):
    """A stream compresses what changed since its last picture, a snapshot everything. Seen from above and once a second, people leave
    the rows where they were, so that a row too few shows."""
    with camrig.start("scenes/hall.json", mode="lockstep", device="cpu", args=args) as rig:
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
                assert (b"\xff\xd0" in snapshot) == (not args), "a restart marker"
