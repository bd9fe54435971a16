"""The parts of docs/speed.md: each measures and gives its Markdown."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass


from . import limits, runs
from .meter import percentile, use_of

VGA, HD, FULL_HD = (640, 480), (1280, 720), (1920, 1080)


@dataclass
class Plan:
    """How long to look."""

    seconds: float = 60
    steps: int = 250
    counts: tuple[int, ...] = (1, 2, 4, 8, 12, 16, 32)
    soak_s: float = 1800


QUICK = Plan(seconds=4, steps=10, counts=(1, 4), soak_s=20)


def table(head: list[str], rows: list[list[object]]) -> str:
    def line(cells: list[object]) -> str:
        return "| " + " | ".join(str(cell) for cell in cells) + " |"

    return "\n".join([line(list(head)), "|" + "---|" * len(head), *(line(row) for row in rows)])


def targets(plan: Plan) -> str:
    """The rows that the rig is meant to reach."""
    rows: list[list[object]] = []

    def row(what: str, wanted: str, measured: str, reached: bool) -> None:
        rows.append([what, wanted, measured, "yes" if reached else "**no**"])

    twelve = runs.realtime(12, VGA, 25, plan.seconds)
    row("12 cameras 640x480 at 25, one MJPEG reader each", "300 frames/s, at most 0.5 % dropped",
        f"{twelve.per_second:.0f} frames/s, {100 * twelve.dropped_share:.1f} % dropped, {max(0, twelve.unreported)} unreported, {twelve.reading.cores:.2f} cores",
        twelve.per_second >= 299 and twelve.dropped_share <= 0.005)
    row("RSS of that rig", "400 MB", f"{twelve.reading.use.rss_mb:.0f} MB", twelve.reading.use.rss_mb <= 400)
    for size, wanted in ((VGA, 240), (FULL_HD, 75)):
        single = runs.lockstep(1, size, plan.steps)
        row(f"one camera {size[0]}x{size[1]}, lockstep, JPEG made", f"{wanted} frames/s", f"{single.per_second:.0f} frames/s, {single.cpu_ms:.1f} ms CPU each",
            single.per_second >= wanted)
    for cameras in (4, 12):
        moving = runs.lockstep(cameras, VGA, max(3, plan.steps // (2 * cameras)), moving=True)
        row(f"{cameras} moving cameras 640x480, lockstep, JPEG made", "78 frames/s (best peer with filtered textures)", f"{moving.per_second:.0f} frames/s", moving.per_second >= 78)
    one = runs.realtime(1, VGA, 30, plan.seconds / 2)
    row("one camera 640x480 at 30 with a reader", "25 % of a core", f"{100 * one.reading.cores:.0f} %", one.reading.cores <= 0.25)
    idle = runs.realtime(12, VGA, 25, plan.seconds / 2, readers=False)
    row("12 cameras, no readers", "2 % of a core", f"{100 * idle.reading.cores:.1f} %", idle.reading.cores <= 0.02)
    half = runs.realtime(6, VGA, 25, plan.seconds / 2)
    p50, p99 = half.latency_ms(0.5), half.latency_ms(0.99)
    row("instant -> JPEG in the reader at half load (6 cameras), p50 / p99", "12 / 35 ms", f"{p50:.1f} / {p99:.1f} ms", p50 <= 12 and p99 <= 35)
    wakeup = half.wakeup
    row("lateness of wake-ups at half load, p99 / max", "1 / 5 ms (p99.9)", f"{wakeup.get('p99_ms', float('nan')):.2f} / {wakeup.get('max_ms', float('nan')):.2f} ms",
        wakeup.get("p99_ms", 1e9) <= 1 and wakeup.get("max_ms", 1e9) <= 5)
    steps = max(3, plan.steps // 10)
    cost = {n: runs.lockstep(n, VGA, steps).cpu_ms for n in (1, 32)}
    row("CPU a frame with 32 cameras against 1", "1.2 x", f"{cost[32]:.1f} / {cost[1]:.1f} ms = {cost[32] / cost[1]:.2f} x", cost[32] <= 1.2 * cost[1])
    pictures = _pictures()
    ours, theirs = twelve.reading.stages.get("encode", {}).get("p50_ms", float("nan")), limits.tjbench_ms(pictures, 90)
    if theirs is not None:
        alone = one.reading.stages["encode"]["p50_ms"]
        row("JPEG stage (one camera, median) against tjbench on pictures of the same cameras", "1.15 x", f"{alone:.2f} / {theirs:.2f} ms = {alone / theirs:.2f} x", alone <= 1.15 * theirs)
    return ("## What it is meant to reach\n\nThe hall with its people, quality `simple`, llvmpipe.\n\n"
            + table(["what", "at least / at most", "measured", "reached"], rows)
            + f"\n\nWith 12 cameras the JPEG stage took {ours:.2f} ms (median, two rasteriser threads beside it).\n\n" + _stages(twelve))


def _pictures() -> list:
    with runs.rig_with(len(runs.PLACES), VGA, 25, mode="lockstep") as (rig, names):
        return [rig.camera(name).frame().image for name in names]


def _stages(run: runs.Realtime) -> str:
    rows = [[name, s["count"], f"{s['mean_ms']:.2f}", f"{s['p50_ms']:.2f}", f"{s['p99_ms']:.2f}", f"{s['max_ms']:.1f}"] for name, s in run.reading.stages.items()]
    return "Stages of the run with 12 cameras (ms; `submit` and `collect` are per instant, `convert` and `encode` per picture):\n\n" + table(["stage", "count", "mean", "p50", "p99", "max"], rows)


def cameras(plan: Plan) -> str:
    rows = []
    for n in plan.counts:
        steps = max(3, plan.steps // n)
        still, moving = runs.lockstep(n, VGA, steps), runs.lockstep(n, VGA, max(3, steps // 2), moving=True)
        rows.append([n, f"{still.per_second:.0f}", f"{still.cpu_ms:.1f}", f"{moving.per_second:.0f}", f"{moving.cpu_ms:.1f}", f"{still.reading.use.rss_mb:.0f}"])
    return ("## Cost a frame against the number of cameras\n\n640x480, lockstep, every picture made into a JPEG and read. Flat columns of CPU are the goal.\n\n"
            + table(["cameras", "standing: frames/s", "CPU ms a frame", "moving: frames/s", "CPU ms a frame", "RSS MB"], rows))


def sizes(plan: Plan) -> str:
    rows = []
    for size in ((320, 240), VGA, HD, FULL_HD):
        for quality in ("fast", "simple", "beautiful"):
            steps = max(3, plan.steps * VGA[0] * VGA[1] // (3 * max(size[0] * size[1], VGA[0] * VGA[1])))
            still = runs.lockstep(1, size, steps, quality=quality)
            moving = runs.lockstep(1, size, steps, quality=quality, moving=True)
            rows.append([f"{size[0]}x{size[1]}", quality, f"{still.per_second:.0f}", f"{still.cpu_ms:.1f}", f"{moving.per_second:.0f}", f"{moving.cpu_ms:.1f}"])
    return ("## Size and quality\n\nOne camera, lockstep, JPEG made and read.\n\n"
            + table(["size", "quality", "standing: frames/s", "CPU ms", "moving: frames/s", "CPU ms"], rows))


def overload(plan: Plan) -> str:
    rows = []
    for policy in ("drop", "slow"):
        with runs.rig_with(40, VGA, 25, overload=policy) as (rig, names):
            with runs.MjpegReaders(rig.call("server.info")["http"], names) as readers:
                time.sleep(runs.WARM_UP_S)
                meter = runs.Meter(rig)
                readers.reset()
                answers, begin_ns, begin = [], rig.call("world.status")["world_ns"], time.monotonic()
                while time.monotonic() < begin + plan.seconds / 2:
                    asked = time.perf_counter()
                    rig.call("camera.get", name=names[0])
                    answers.append(1e3 * (time.perf_counter() - asked))
                    time.sleep(0.05)
                reading, world_s = meter.read(), (rig.call("world.status")["world_ns"] - begin_ns) / 1e9
                streams = readers.close()
        counts = [s.pictures for s in streams]
        latencies = [ms for s in streams for ms in s.latencies_ms]
        rows.append([policy, f"{sum(counts) / reading.wall_s:.0f}", f"{min(counts)} .. {max(counts)}", f"{100 * reading.dropped / max(1, reading.due):.0f} %",
                     reading.due - reading.rendered - reading.dropped, f"{world_s / reading.wall_s:.2f}", f"{percentile(latencies, 0.99):.0f} ms",
                     f"{percentile(answers, 0.99):.0f} / {max(answers):.0f} ms"])
    return ("## Overload: 40 cameras 640x480 at 25\n\n"
            + table(["policy", "frames/s", "frames per camera, min .. max", "dropped", "unreported", "world seconds a second", "latency p99", "control answers p99 / max"], rows))


def soak(plan: Plan) -> str:
    samples = []
    with runs.rig_with(12, VGA, 25) as (rig, names):
        pid = rig.call("server.info")["pid"]
        with runs.MjpegReaders(rig.call("server.info")["http"], names) as readers:
            time.sleep(runs.WARM_UP_S)
            begin = time.monotonic()
            while (elapsed := time.monotonic() - begin) < plan.soak_s:
                samples.append((elapsed, use_of(pid)))
                for stream in readers.streams:
                    stream.latencies_ms.clear()
                time.sleep(plan.soak_s / 60)
            readers.close()
    # The first tenth fills pools and caches.
    kept = samples[len(samples) // 10 :]
    mean_t = sum(t for t, _ in kept) / len(kept)
    spread = sum((t - mean_t) ** 2 for t, _ in kept)

    def slope_per_hour(value: Callable[[object], float]) -> float:
        return 3600 * sum((t - mean_t) * value(use) for t, use in kept) / spread

    rows = [[name, f"{value(kept[0][1]):.1f}", f"{value(kept[-1][1]):.1f}", f"{slope_per_hour(value):+.2f}"]
            for name, value in (("RSS, MB", lambda u: u.rss_mb), ("threads", lambda u: u.threads), ("descriptors", lambda u: u.fds))]
    return (f"## {plan.soak_s / 60:.0f} minutes with 12 cameras and readers\n\n" + table(["", "first", "last", "slope per hour"], rows))


def machine_limits(plan: Plan) -> str:
    pictures = _pictures()
    jpeg = limits.tjbench_ms(pictures, 90)
    copy = limits.memcpy_gb_s(rounds=4 if plan is QUICK else 20)
    frame_mb = VGA[0] * VGA[1] * 4 / 1e6
    rows = [["memcpy, one core", f"{copy:.1f} GB/s", f"an RGBA picture of 640x480 in {frame_mb / copy:.2f} ms"]]
    if jpeg is not None:
        rows.append(["tjbench, RGBX to 4:2:0, quality 90, one core", f"{jpeg:.2f} ms a picture of 640x480", f"{2e3 / jpeg:.0f} pictures/s if two cores did nothing else"])
    return "## What the machine gives\n\n" + table(["limit", "measured", "that is"], rows)


ALL: dict[str, Callable[[Plan], str]] = {
    "targets": targets, "cameras": cameras, "sizes": sizes, "overload": overload, "limits": machine_limits, "soak": soak,
}
