"""The rows that the rig is meant to reach, each with the stage that holds it."""

from __future__ import annotations

from . import limits, programs, runs
from .figures import figure, stacked, tail
from .meter import Reading
from .others import best_peer, PEER_THREADS
from .plan import FULL_HD, VGA, Plan, table

# What was tried for rows that may be missed, with what it gave; said beside those that are.
TRIED = {
    "moving": "Two thirds of the time is shading: two textures a pixel, filtered linearly, light a pixel. Gathers for texels and for the vertices of several triangles at once "
    "took a third off (decision 0080). llvmpipe's figures are beside.",
    "lockstep": "The stages of one instant follow each other: one camera alone cannot fill two cores. Its rows are drawn by all threads, its triangles are set up by one. "
    "Bands of equal work instead of equal height, more bands than threads: nothing. JPEG on two threads: nothing where the cores are busy (decision 0070).",
    "jpeg": "The accurate DCT is as fast as the fast one. Encoders share the cores with the rasteriser.",
}


def holder(reading: Reading) -> str:
    """The dearest stage of a picture, in median milliseconds, of what all stages together take."""
    pictures = reading.stages.get("encode", {}).get("count", 0)
    if not pictures:
        return ""
    cost = {name: stage["p50_ms"] * stage["count"] / pictures for name, stage in reading.stages.items() if name not in ("wakeup", "truth") and stage["count"]}
    first = max(cost, key=cost.__getitem__)
    return f"{first}, {cost[first]:.1f} of {sum(cost.values()):.1f} ms a picture"


class Rows:
    def __init__(self) -> None:
        self.rows: list[list[object]] = []
        self.tried: list[str] = []

    def add(self, what: str, wanted: str, measured: str, reached: bool, held_by: str = "", tried: str = "") -> None:
        self.rows.append([what, wanted, measured, "yes" if reached else "**no**", held_by])
        if tried and not reached:
            self.tried.append(f"* {what}: {TRIED[tried]}")

    def text(self) -> str:
        notes = "\n\nNot reached, and tried:\n\n" + "\n".join(self.tried) if self.tried else ""
        return table(["what", "at least / at most", "measured", "reached", "dearest stage"], self.rows) + notes


def targets(plan: Plan) -> str:
    rows = Rows()
    twelve = runs.realtime(12, VGA, 25, plan.seconds)
    rows.add("12 cameras 640x480 at 25, one MJPEG reader each", "300 frames/s, at most 0.5 % dropped, all of them reported",
             f"{twelve.per_second:.0f} frames/s, {100 * twelve.dropped_share:.1f} % dropped, {twelve.unreported} unreported; "
             f"{twelve.reading.cores:.2f} cores, {twelve.cpu_ms:.1f} ms CPU each",
             twelve.per_second >= 299 and twelve.dropped_share <= 0.005 and twelve.unreported <= 0, holder(twelve.reading))
    rows.add("RSS of that rig", "400 MB", f"{twelve.reading.use.rss_mib:.0f} MiB", twelve.reading.use.rss_mib * 1.048576 <= 400)
    for size, wanted in ((VGA, 240), (FULL_HD, 75)):
        single = runs.lockstep(1, size, plan.steps)
        rows.add(f"one camera {size[0]}x{size[1]}, lockstep, JPEG made", f"{wanted} frames/s", f"{single.per_second:.0f} frames/s, {single.cpu_ms:.1f} ms CPU each",
                 single.per_second >= wanted, holder(single.reading), "lockstep")
    every = runs.all_kinds(plan.steps)
    rows.add("colour, depth, ids and truth of one camera 640x480 a step, taken by a Python program", "60 steps/s",
             f"{every.per_second:.0f} steps/s, {every.cpu_ms:.1f} ms CPU each", every.per_second >= 60)
    _layers(rows, plan)
    _moving(rows, plan)
    one = runs.realtime(1, VGA, 30, plan.seconds / 2)
    _jpeg(rows, one, runs.realtime(1, VGA, 30, plan.seconds / 4, args=("--static-layer-mb", "0")))
    rows.add("one camera 640x480 at 30 with a reader", "25 % of a core", f"{100 * one.reading.cores:.0f} %", one.reading.cores <= 0.25, holder(one.reading))
    idle = runs.realtime(12, VGA, 25, plan.seconds / 2, readers=False)
    rows.add("12 cameras, no readers", "2 % of a core", f"{100 * idle.reading.cores:.1f} %", idle.reading.cores <= 0.02)
    half = runs.realtime(6, VGA, 25, plan.seconds / 2)
    p50, p99 = half.latency_ms(0.5), half.latency_ms(0.99)
    rows.add("instant -> JPEG in the reader at half load (6 cameras), p50 / p99", "12 / 35 ms", f"{p50:.1f} / {p99:.1f} ms", p50 <= 12 and p99 <= 35, holder(half.reading))
    wakeup = half.wakeup
    late = {key: wakeup.get(f"{key}_ms", float("nan")) for key in ("p50", "p99", "p999", "max")}
    rows.add("lateness of wake-ups at half load, p99 / p99.9", "1 / 5 ms", f"{late['p99']:.2f} / {late['p999']:.2f} ms (p50 {late['p50']:.2f}, max {late['max']:.2f}, since the start)",
             late["p99"] <= 1 and late["p999"] <= 5)
    steps = max(3, plan.steps // 10)
    cost = {n: runs.lockstep(n, VGA, max(steps, steps * 8 // n)).cpu_ms for n in (1, 32)}
    rows.add("CPU a frame with 32 cameras against 1", "1.2 x", f"{cost[32]:.1f} / {cost[1]:.1f} ms = {cost[32] / cost[1]:.2f} x", cost[32] <= 1.2 * cost[1])
    return ("## What it is meant to reach\n\nThe hall with its people, quality `simple`, device `cpu`.\n\n" + rows.text()
            + _stages(twelve)
            + figure("latency", "Instant to JPEG in the reader: share of pictures that take longer",
                     tail({f"{n} cameras": [ms for s in run.streams for ms in s.latencies_ms] for n, run in ((6, half), (12, twelve))}, "ms")))


def _layers(rows: Rows, plan: Plan) -> None:
    """The renderer alone, on all eight places: kept pictures of what stands still against drawing everything."""
    frames = max(3, plan.steps // 10)
    kept, full = programs.to_memory(8, VGA, frames), programs.to_memory(8, VGA, frames, layers=False)
    before = programs.to_memory(8, VGA, frames, device="llvmpipe")
    if kept is None or full is None or before is None:
        return rows.add("static layer against full draw, 640x480, same bytes", "8 x", "not measured: render_scene is not built", False)
    rows.add("static layer against full draw, 640x480, same bytes (StaticLayer.*, test_speed_switches.py)", "8 x",
             f"{kept.per_second:.0f} / {full.per_second:.0f} frames/s to host memory = {kept.per_second / full.per_second:.1f} x; CPU {full.cpu_ms:.1f} / {kept.cpu_ms:.1f} ms = "
             f"{full.cpu_ms / kept.cpu_ms:.1f} x; kept by llvmpipe: {before.per_second:.0f} frames/s, {before.cpu_ms:.1f} ms", kept.per_second >= 8 * full.per_second, "people, drawn either way")


def _moving(rows: Rows, plan: Plan) -> None:
    for cameras in (4, 12):
        frames = max(3, plan.steps // (2 * cameras))
        got = {quality: programs.to_memory(cameras, VGA, frames, moving=True, quality=quality, threads=PEER_THREADS) for quality in ("simple", "fast")}
        simple, fast = got["simple"], got["fast"]
        before = programs.to_memory(cameras, VGA, frames, moving=True, device="llvmpipe", threads=PEER_THREADS)
        peer, wanted = best_peer(plan, cameras)
        what = f"{cameras} moving cameras 640x480, nothing kept, to host memory"
        if simple is None or fast is None or before is None:
            rows.add(what, f"{wanted:.0f} frames/s", "not measured: render_scene is not built", False)
            continue
        rows.add(what, f"{wanted:.0f} frames/s ({peer}), towards {1.5 * wanted:.0f}",
                 f"{simple.per_second:.0f} frames/s, {simple.cpu_ms:.1f} ms CPU each; quality `fast`, light per vertex as the peers: {fast.per_second:.0f}, {fast.cpu_ms:.1f} ms; "
                 f"device `llvmpipe`: {before.per_second:.0f}, {before.cpu_ms:.1f} ms",
                 simple.per_second >= wanted, "draw: shading pixels", "moving")


def _jpeg(rows: Rows, strips: runs.Realtime, plain: runs.Realtime) -> None:
    theirs = limits.tjbench_ms(pictures()[:1], 90)  # of the place that the one camera has
    ours, changed = plain.reading.stages["encode"]["p50_ms"], strips.reading.stages["encode"]["p50_ms"]
    if theirs is None:
        return rows.add("JPEG stage against tjbench", "1.15 x", "not measured: tjbench is not installed (libjpeg-turbo-progs)", False)
    rows.add("JPEG stage (one camera, median) against tjbench on a picture of that camera", "1.15 x", 
             f"{ours:.2f} / {theirs:.2f} ms = {ours / theirs:.2f} x with all rows compressed (`--static-layer-mb 0`); only those that changed: {changed:.2f} ms", ours <= 1.15 * theirs, "", "jpeg")


def pictures() -> list:
    with runs.rig_with(len(runs.PLACES), VGA, 25, mode="lockstep") as (rig, names):
        return [rig.camera(name).frame().image for name in names]


def _stages(run: runs.Realtime) -> str:
    stages = run.reading.stages
    rows = [[name, s["count"], *(f"{s[key]:.2f}" for key in ("mean_ms", "p50_ms", "p99_ms", "p999_ms", "max_ms"))] for name, s in stages.items() if s["count"]]
    kept = ", ".join(f"{name} {value}" for name, value in run.reading.renderer.items())
    return ("\n\nStages of the run with 12 cameras (ms; `wakeup` and `world` are per instant, `draw` and `publish` per turn, `convert` and `encode` per picture; since the rig's start, "
            "first pictures included):\n\n" + table(["stage", "count", "mean", "p50", "p99", "p99.9", "max"], rows) + f"\n\nWhat its renderer kept and saved: {kept}."
            + figure("stages", "Stages of 12 cameras, median, per instant",
                     stacked(["12 cameras"], {name: [s["p50_ms"] * s["count"] / max(1, stages["wakeup"]["count"])] for name, s in stages.items() if s["count"] and name != "wakeup"}, "ms")))
