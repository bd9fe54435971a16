"""Requests that are dear to answer: other readers must not pay for them."""

from __future__ import annotations

import concurrent.futures
import json
import time
from collections.abc import Callable

import camrig

from target import Target, read_line, request

#: Poses and lenses that make the outline of a box hard to follow (camera far outside, strong distortion).
#: Each a lens, how far away it is along y in m, and its optics.
HARD_TRUTH: list[tuple[dict, float, dict]] = [
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 50.0, {"hfov_deg": 60}),
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 1e3, {"hfov_deg": 60}),
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 1e4, {"hfov_deg": 60}),
    ({"model": "plumb_bob", "coefficients": [-0.3, 0.1, 0, 0, 0]}, 1e5, {"hfov_deg": 60}),
    ({"model": "rational_polynomial", "coefficients": [0.1, -0.2, 0, 0, 0.01, 0.3, -0.1, 0.02]}, 1e5, {"hfov_deg": 60}),
    ({"model": "equidistant", "coefficients": [0.02, -0.01, 0.003, -0.001]}, 1e5, {"hfov_deg": 60}),
    ({"model": "equidistant", "coefficients": [0.02, -0.01, 0.003, -0.001]}, 6.0, {"intrinsics": {"fx": 1e6, "fy": 50, "cx": 31.5, "cy": 23.5}}),
]
TRUTH_LIMIT_S = 10.0


def create_hard(rig: camrig.Rig, name: str, lens: dict, y: float, optics: dict) -> camrig.Camera:
    return rig.create_camera(name, size=(64, 48), lens=lens, position=(2, y, 2.8), orientation=(0, 0, 0, 1), **optics)


def truth_of_hard_cameras(target: Target) -> str:
    """Truth through strong lenses from far outside the hall answers, exactly or with an error, in bounded time."""
    took, refused = [], 0
    for number, hard in enumerate(HARD_TRUTH):
        cam = create_hard(target.rig, f"hard{number}", *hard)
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


#: What one connection may have waiting (server.info: queued_reply_bytes), and room for a picture that is being drawn.
MOST_BATCH_MIB = 400


def _large_batch(target: Target, send: Callable[[bytes], bytes]) -> str:
    """24 raw pictures of 4096x2900 in one batch."""
    cam = target.rig.create_camera("large", size=(4096, 2900), fps=1, place="lobby")
    cam.frame()
    batch = [request("frame.get", n, camera="large", format="raw") for n in range(24)]
    before = target.rss_kib()
    target.forget_peak()
    try:
        answers = json.loads(send(json.dumps(batch).encode()))
    finally:
        cam.delete()
    peak_mib = (target.peak_kib() - before) / 1024
    assert isinstance(answers, list) and len(answers) == 24, str(answers)[:300]
    refused = [answer["error"]["data"]["kind"] for answer in answers if "error" in answer]
    assert set(refused) <= {"resource_exhausted"}, refused
    assert peak_mib < MOST_BATCH_MIB, f"{peak_mib:.0f} MiB more at the peak"
    return f"{24 - len(refused)} answered, {len(refused)} refused, {peak_mib:+.0f} MiB at the peak"


def large_batches(target: Target) -> str:
    """A batch of large pictures: bounded memory, an answer to each, and the connection stays."""
    with target.unix(120) as raw:

        def send(batch: bytes) -> bytes:
            raw.sendall(batch + b"\n")
            return read_line(raw)

        said = _large_batch(target, send)
        raw.sendall(json.dumps(request("world.status")).encode() + b"\n")
        assert "result" in json.loads(read_line(raw)), "the connection does not go on"
    return said


def large_batches_over_http(target: Target) -> str:
    """The same by POST /rpc, with the rig's key; one of somebody without it is refused."""
    headers = {"Content-Type": "application/json"}

    def send(batch: bytes) -> bytes:
        status, _, body = target.ask_http("POST", "/rpc", batch, {**headers, **target.owner_headers}, timeout_s=120)
        assert status == 200, f"POST /rpc gave {status}: {body[:200]!r}"
        assert len(body) < 90 << 20, f"{len(body) >> 20} MiB in one answer"
        return body

    said = _large_batch(target, send)
    status, _, body = target.ask_http("POST", "/rpc", json.dumps([request("camera.delete", n, name="watched") for n in range(64)]).encode(), headers)
    assert status in (401, 403) or all(answer["error"]["data"]["kind"] == "unauthorized" for answer in json.loads(body)), body[:300]
    return said


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


ATTACKS = [truth_of_hard_cameras, many_snapshots_of_idle_cameras, large_batches, large_batches_over_http, loading_scenes_again_and_again]
