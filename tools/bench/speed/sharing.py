"""What one camera or client costs the others: dear cameras and requests beside running cameras."""

from __future__ import annotations

import contextlib
import itertools
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import camrig

from .meter import percentile
from .plan import HD, VGA, Plan, table
from .readers import MjpegReaders, Stream

WARM_UP_S = 3.0


def sharing(plan: Plan) -> str:
    rows = [_corner(plan, beside=False), _corner(plan, beside=True), *_twelve(plan), _newcomers(plan), _requests(plan)]
    return ("## What one camera or client costs the others\n\nEach with one MJPEG reader a camera, in real time. Frames lost are those that the camera's rate gives in that time and its reader "
            "never got. Latency is from the instant to the reader.\n\n" + table(["what", "wanted", "frames/s", "lost", "latency p50 / p99 ms", "reached"], rows))


@contextlib.contextmanager
def _rig(scene: str) -> Iterator[camrig.Rig]:
    with camrig.start(scene, device="cpu") as rig:
        for name in [camera["name"] for camera in rig.call("camera.list")["cameras"]]:
            rig.camera(name).delete()
        yield rig


def watch(rig: camrig.Rig, names: list[str], seconds: float, meanwhile: Callable[[float], None] = time.sleep) -> tuple[dict[str, Stream], float]:
    """What readers of these cameras see while something else goes on for about so long, and for how long it did."""
    with MjpegReaders(rig.call("server.info")["http"], names) as readers:
        time.sleep(WARM_UP_S)
        readers.reset()
        begin = time.monotonic()
        meanwhile(seconds)
        lasted_s = time.monotonic() - begin
        return {stream.camera: stream for stream in readers.close()}, lasted_s


def row(what: str, wanted: str, streams: list[Stream], due: float, seconds: float, reached: Callable[[float, float], bool]) -> list[object]:
    pictures = sum(stream.pictures for stream in streams)
    latencies = [ms for stream in streams for ms in stream.latencies_ms]
    lost, p99 = max(0.0, 1 - pictures / due), percentile(latencies, 0.99)
    return [what, wanted, f"{pictures / seconds:.1f} of {due / seconds:.1f}", f"{100 * lost:.1f} %", f"{percentile(latencies, 0.5):.1f} / {p99:.1f}", "yes" if reached(lost, p99) else "**no**"]


def _corner(plan: Plan, *, beside: bool) -> list[object]:
    seconds = plan.seconds / 2
    with _rig("street") as rig:
        rig.create_camera("corner_watched", place="corner", size=VGA, fps=25)
        names = ["corner_watched"]
        if beside:
            rig.create_camera("dear", place="corner", size=HD, fps=1, quality="beautiful")
            names.append("dear")
        streams, seconds = watch(rig, names, seconds)
    what = "street `corner` 640x480 at 25/s" + (", 1280x720 `beautiful` at 1/s beside it" if beside else " alone")
    wanted = "24.5/s, p99 below 80 ms" if beside else ""
    return row(what, wanted, [streams["corner_watched"]], 25 * seconds, seconds, lambda lost, p99: not beside or (lost <= 0.02 and p99 < 80))


def _twelve(plan: Plan) -> list[list[object]]:
    seconds = plan.seconds / 2
    with _rig("hall") as rig:
        places = sorted(rig.call("world.status")["places"])
        plain, dear = [f"plain{i}" for i in range(9)], [f"dear{i}" for i in range(3)]
        for i, name in enumerate(plain + dear):
            rig.create_camera(name, place=places[i % len(places)], size=VGA, fps=25, quality="beautiful" if name in dear else "simple")
        streams, seconds = watch(rig, plain + dear, seconds)
    return [row(f"hall, 12 cameras 640x480 at 25/s, three of them `beautiful`: the {len(group)} {kind}", wanted, [streams[name] for name in group], 25 * len(group) * seconds, seconds, reached)
            for kind, group, wanted, reached in (("others", plain, "at most 2 % lost", lambda lost, _: lost <= 0.02), ("dear ones", dear, "", lambda *_: True))]


def _newcomers(plan: Plan) -> list[object]:
    """Every two seconds a dear camera comes, is read for as long, and goes: each time its first pictures, shadow maps and lenses are made."""
    seconds = plan.seconds / 2
    kinds: list[dict[str, Any]] = [{"size": (1920, 1080)}, {"size": HD, "lens": {"model": "plumb_bob", "coefficients": [-0.25, 0.05, 0.001, -0.001, 0.0]}}, {"size": VGA, "quality": "beautiful"}]
    with _rig("hall") as rig:
        place = sorted(rig.call("world.status")["places"])[0]
        rig.create_camera("running", place=place, size=VGA, fps=25)

        def meanwhile(duration: float) -> None:
            end = time.monotonic() + duration
            for n in itertools.count():
                newcomer = rig.create_camera(f"newcomer{n}", place=place, fps=25, **kinds[n % len(kinds)])
                with MjpegReaders(rig.call("server.info")["http"], [newcomer.name]):
                    time.sleep(2.0)
                newcomer.delete()
                if time.monotonic() >= end:
                    break

        streams, seconds = watch(rig, ["running"], seconds, meanwhile)
    what = "hall, one camera 640x480 at 25/s while others come and go, each for 2 s: 1920x1080, 1280x720 through a lens, 640x480 `beautiful`"
    return row(what, "at most 2 % lost, p99 below 80 ms", [streams["running"]], 25 * seconds, seconds, lambda lost, p99: lost <= 0.02 and p99 < 80)


def _requests(plan: Plan) -> list[object]:
    seconds = plan.seconds / 2
    with _rig("hall") as rig:
        places = sorted(rig.call("world.status")["places"])
        running, asked = [f"running{i}" for i in range(4)], [f"asked{i}" for i in range(4)]
        for i, name in enumerate(running + asked):
            rig.create_camera(name, place=places[i % len(places)], size=VGA, fps=25)
        answered = {"snapshots": 0, "truths": 0, "refused": 0}
        lock = threading.Lock()

        def ask(kind: str, cam: camrig.Camera) -> None:
            try:
                if kind == "snapshots":
                    with urllib.request.urlopen(cam.url("jpg"), timeout=30) as reply:
                        reply.read()
                else:
                    cam.truth()
            except (OSError, camrig.CamrigError):
                kind = "refused"
            with lock:
                answered[kind] += 1

        def meanwhile(duration: float) -> None:
            with ThreadPoolExecutor(32) as pool:
                begin = time.monotonic()
                for n in range(int(250 * duration)):
                    time.sleep(max(0.0, begin + n / 250 - time.monotonic()))
                    pool.submit(ask, "truths" if n % 5 == 0 else "snapshots", rig.camera(asked[n % len(asked)]))
                    if time.monotonic() >= begin + duration:
                        break
                pool.shutdown(cancel_futures=True)  # what was asked is waited for

        streams, seconds = watch(rig, running, seconds, meanwhile)
    what = (f"hall, 4 cameras 640x480 at 25/s while 200 snapshots and 50 truths a second are asked of 4 others ({answered['snapshots'] / seconds:.0f} and {answered['truths'] / seconds:.0f}/s "
            f"answered, {answered['refused'] / seconds:.0f}/s refused)")
    return row(what, "at most 2 % lost", [streams[name] for name in running], 100 * seconds, seconds, lambda lost, _: lost <= 0.02)
