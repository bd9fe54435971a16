"""A long run of a rig with 12 cameras in full use: what grows?

Two readers stay; others come and go over HTTP, RTSP and devices, cameras are changed, made and deleted, scenes are loaded, pictures of all
kinds and truth are asked for. All of it once in every round; memory, threads and descriptors are read at the end of a round, when only those that stay are left.
"""

from __future__ import annotations

import random
import time
from contextlib import ExitStack

import camrig

from . import runs
from .figures import figure
from .meter import Use, use_of
from .plan import VGA, Plan, table

ROUND_S = 20.0
#: What a rig may grow by in the second half, by the straight line through it.
MOST_MIB_PER_HOUR = 1.0
STAY = ("c0", "c1")
COME_AND_GO = ("MJPEG over HTTP", "H.264 over RTSP", "YUYV, user-space device")
KINDS = ("color", "depth", "instance", "normal")


def one_round(rig: camrig.Rig, names: list[str], scene: str, number: int) -> None:
    rng = random.Random(number)
    with ExitStack() as readers:
        for how in COME_AND_GO:
            readers.enter_context(runs.read_by(runs.READERS[how], rig, names[:4]))
        time.sleep(3)
    for name in names[2:]:
        pose = rig.call("camera.get", name=name)["pose"]
        rig.call("camera.set", name=name, vfov_deg=rng.uniform(30, 80), fps=rng.choice((10, 20, 25)), size=list(rng.choice((VGA, (320, 240)))),
                 pose={"position": pose["position"], "pan_deg": rng.uniform(-180, 180), "tilt_deg": rng.uniform(-30, 10), "roll_deg": 0})
    for i in range(3):
        rig.create_camera(f"passing{i}", size=(320, 240), fps=10, position=(2, 3, 2.5), look_at=(12, 9, 1), quality=("fast", "simple", "beautiful")[i])
    for name in (*names[::3], "passing0", "passing1", "passing2"):
        camera = rig.camera(name)
        for kind in KINDS:
            camera.frame(kind=kind)
        camera.truth()
    for passing in (("street", "crowd")[number % 2], scene):
        rig.call("world.load", scene=passing)
        for name in names[::4]:
            rig.camera(name).frame()
    for camera in rig.cameras():
        if camera.name not in names:
            camera.delete()


def line(part: list[tuple[float, float]]) -> tuple[float, float]:
    """Least squares of (seconds, value): slope and its standard error, per hour. Fewer than three points say nothing."""
    if len(part) < 3:
        return 0.0, float("inf")
    n, mean_t, mean = len(part), sum(t for t, _ in part) / len(part), sum(v for _, v in part) / len(part)
    spread = sum((t - mean_t) ** 2 for t, _ in part)
    slope = sum((t - mean_t) * v for t, v in part) / spread
    left = sum((v - mean - slope * (t - mean_t)) ** 2 for t, v in part)
    return 3600 * slope, 3600 * (left / (n - 2) / spread) ** 0.5


def verdict(slope: float, error: float, most: float) -> str:
    """Whether a slope is at most so much, as far as two standard errors can tell."""
    most += 0.001
    if slope + 2 * error <= most:
        return "yes"
    return "**missed**" if slope - 2 * error > most else "**undecided**: run longer"


def soak(plan: Plan) -> str:
    samples: list[tuple[float, Use]] = []
    with runs.rig_with(12, VGA, 25, devices=True) as (rig, names):
        info = rig.call("server.info")
        scene = rig.call("world.status")["scene_file"]
        with runs.MjpegReaders(info["http"], list(STAY)) as readers:
            begin, number = time.monotonic(), 0
            while (elapsed := time.monotonic() - begin) < plan.soak_s:
                number += 1
                one_round(rig, names, scene, number)
                time.sleep(max(2.0, begin + elapsed + ROUND_S - time.monotonic()))
                readers.reset()
                samples.append((time.monotonic() - begin, use_of(info["pid"])))
            readers.close()
    kept = samples[len(samples) // 10 :]
    second = samples[len(samples) // 2 :]
    rows = []
    for name, value, most in (("RSS, MiB", lambda use: use.rss_mib, MOST_MIB_PER_HOUR), ("threads", lambda use: use.threads, 0.0), ("descriptors", lambda use: use.fds, 0.0)):
        slope, error = line([(t, value(use)) for t, use in second])
        rows.append([name, *(f"{value(part[end][1]):.1f}" for part, end in ((kept, 0), (second, 0), (second, -1))), f"{slope:+.2f} +- {error:.2f}", f"{most:g}", verdict(slope, error, most)])
    first = kept[0][1]
    grown = {"RSS, MiB": [use.rss_mib - first.rss_mib for _, use in kept], "threads": [use.threads - first.threads for _, use in kept], "descriptors": [use.fds - first.fds for _, use in kept]}

    def draw(axes) -> None:
        for label, values in grown.items():
            axes.plot([t / 60 for t, _ in kept], values, label=label)
        axes.set_xlabel("minutes")
        axes.set_ylabel("more than at first")
        axes.legend()

    return (f"## {plan.soak_s / 60:.0f} minutes with 12 cameras in full use\n\n{number} rounds: four cameras get a reader each over HTTP, RTSP and as a device for 3 s while two others are watched throughout; "
            "ten cameras change pose, field of view, size and rate, three come and go, seven give pictures of all kinds and truth, and another scene is loaded and then the first again. Read at the end of each "
            "round. The first tenth, which fills pools and caches, is left out.\n\n"
            + table(["", "after a tenth", "in the middle", "at the end", "slope of the second half, per hour, and its standard error", "at most, give or take two errors", "met"], rows)
            + figure("soak", "A long run: what grows", draw))
