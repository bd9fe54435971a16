"""Requests that are dear to answer: other readers must not pay for them."""

from __future__ import annotations

import concurrent.futures
import json
import time

import camrig

from target import Target, read_line, request

#: Poses and lenses that make the outline of a box hard to follow (camera far outside, strong distortion).
HARD_TRUTH = [
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 50.0),
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 1e4),
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 1e5),
    ({"model": "rational_polynomial", "coefficients": [0.1, -0.2, 0, 0, 0.01, 0.3, -0.1, 0.02]}, 1e5),
    ({"model": "equidistant", "coefficients": [0.02, -0.01, 0.003, -0.001]}, 1e5),
]
TRUTH_LIMIT_S = 10.0


def truth_of_hard_cameras(target: Target) -> str:
    """Truth through strong lenses from far outside the hall answers, exactly or with an error, in bounded time."""
    took, refused = [], 0
    for number, (lens, y) in enumerate(HARD_TRUTH):
        name = f"hard{number}"
        cam = target.rig.create_camera(name, size=(64, 48), hfov_deg=60, lens=lens, position=(2, y, 2.8), orientation=(0, 0, 0, 1))
        begin = time.monotonic()
        try:
            cam.truth()
        except camrig.CamrigError as error:
            assert error.kind in ("unsupported", "resource_exhausted", "invalid_argument"), error
            refused += 1
        took.append(time.monotonic() - begin)
        cam.delete()
    assert max(took) < TRUTH_LIMIT_S, f"up to {max(took):.1f} s"
    return f"{len(took)} cameras, at most {max(took):.2f} s, {refused} refused"


def many_snapshots_of_idle_cameras(target: Target) -> str:
    """200 snapshots of cameras that nobody watches, on 20 connections at once."""
    names = [f"idle{n}" for n in range(4)]
    for name in names:
        target.rig.create_camera(name, size=(320, 240), place="lobby")

    def ask_ten(number: int) -> list[dict]:
        with target.unix(60) as raw:
            answers = []
            for n in range(10):
                raw.sendall(json.dumps(request("frame.get", n, camera=names[(number + n) % 4], format="jpeg")).encode() + b"\n")
                answers.append(json.loads(read_line(raw)))
            return answers

    with concurrent.futures.ThreadPoolExecutor(20) as pool:
        answers = [answer for ten in pool.map(ask_ten, range(20)) for answer in ten]
    for name in names:
        target.rig.camera(name).delete()
    refused = [answer["error"]["data"]["kind"] for answer in answers if "error" in answer]
    assert len(answers) == 200 and set(refused) <= {"resource_exhausted"}, refused[:3]
    return f"{200 - len(refused)} of 200 answered, the others told to come back"


def large_batches(target: Target) -> str:
    """A batch of raw pictures of 4096x2900: bounded memory, an answer to each, and the connection stays."""
    cam = target.rig.create_camera("large", size=(4096, 2900), fps=1, place="lobby")
    batch = [request("frame.get", n, camera="large", format="raw") for n in range(24)]
    before = target.rss_kib()
    most = before
    try:
        with target.unix(120) as raw:
            raw.sendall(json.dumps(batch).encode() + b"\n")
            answers = json.loads(read_line(raw))
            most = max(most, target.rss_kib())
            raw.sendall(json.dumps(request("world.status")).encode() + b"\n")
            assert "result" in json.loads(read_line(raw)), "the connection does not go on"
    finally:
        cam.delete()
    assert len(answers) == 24
    refused = [answer["error"]["data"]["kind"] for answer in answers if "error" in answer]
    assert set(refused) <= {"resource_exhausted"}, refused
    return f"{24 - len(refused)} answered, {len(refused)} refused, {(most - before) / 1024:+.0f} MiB afterwards"


def loading_scenes_again_and_again(target: Target) -> str:
    """Scenes are loaded 24 times, truth and depth of each asked for; once heaps are filled (12 loads), memory stands."""
    seen = []
    with camrig.start("minimal", mode="lockstep") as rig:
        other = Target(rig, target.folder)
        for round_number in range(24):
            rig.load("hall" if round_number % 2 else "street")
            cam = rig.create_camera("c", size=(160, 120), position=(2, 3, 2), look_at=(8, 6, 1))
            cam.truth(), cam.depth()
            cam.delete()
            seen.append(other.rss_kib() // 1024)
    # A load leaves the heap 20 MiB more or less than the one before; means of six tell what is kept.
    assert (sum(seen[18:]) - sum(seen[12:18])) / 6 < 20, f"MiB after each load: {seen}"
    return f"MiB after each load: {seen}"


ATTACKS = [truth_of_hard_cameras, many_snapshots_of_idle_cameras, large_batches, loading_scenes_again_and_again]
