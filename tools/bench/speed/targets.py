"""The rows that the rig is meant to reach, each with the stage that holds it."""

from __future__ import annotations

from . import limits, programs, runs
from .figures import figure, stacked, tail
from .meter import Reading
from .others import COUNTS, best_peer, side_by_side, tiny
from .plan import FULL_HD, VGA, Plan, table
from .programs import ToMemory

# What was tried for rows that may be missed, with what it gave; said beside those that are.
TRIED = {
    "moving": "Two thirds of the time is shading: two textures a pixel, filtered linearly, light a pixel. Gathers for texels and for the vertices of several triangles at once "
    "took a third off (decision 0080). llvmpipe's figures are beside.",
    "areas": "A moving picture of the hall has outlines in 45 thousand of its 307 thousand pixels and 165 thousand fragments in 32 thousand of these; a standing camera's are of people, whose "
    "outlines end in nearly every pixel. Time is spread over finding, resolving, sampling and shading them. Fewer samples a texture, masks asked last, one set-up a triangle, pixels that "
    "one edge goes right through: all in; bounds by depth, tables of masks, depth at each of the 64 places: nothing or wrong (decision 0105). Fewer than 64 places would be needed, or fewer triangles.",
    "tiny": "It takes the nearest texel and bends textures within triangles (see other renderers); camrig filters them, with perspective, and has its light at the pixel and linear.",
    "beautiful": "No part has what is missing: standing, materials are 20 %, fragments 11, sampling 10, shadows 9, resolving 7 (decisions 0105, 0118).",
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
        self.missed: dict[str, list[str]] = {}

    def add(self, what: str, wanted: str, measured: str, reached: bool, held_by: str = "", tried: str = "") -> None:
        self.rows.append([what, wanted, measured, "yes" if reached else "**no**", held_by])
        if tried and not reached:
            self.missed.setdefault(tried, []).append(what)

    def text(self) -> str:
        notes = "\n\nNot reached, and tried:\n\n" + "\n".join(f"* {'; '.join(what)}: {TRIED[tried]}" for tried, what in self.missed.items()) if self.missed else ""
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
    _by_areas(rows, plan)
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
    return ("## What it is meant to reach\n\nThe hall with its people, quality `simple`, device `cpu`. Figures to host memory are medians of "
            f"{programs.TURNS} turns of about {plan.turn_s:g} s each (lowest..highest), in which what is compared takes its turn one after the other.\n\n" + rows.text()
            + _stages(twelve)
            + figure("latency", "Instant to JPEG in the reader: share of pictures that take longer",
                     tail({f"{n} cameras": [ms for s in run.streams for ms in s.latencies_ms] for n, run in ((6, half), (12, twelve))}, "ms")))


def _layers(rows: Rows, plan: Plan) -> None:
    """The renderer alone, on all eight places: kept pictures of what stands still against drawing everything."""
    drawn = programs.in_turns({"kept": ToMemory(8), "full": ToMemory(8, layers=False), "llvmpipe": ToMemory(8, device="llvmpipe")}, plan.turn_s)
    if drawn is None:
        return rows.add("static layer against full draw, 640x480, same bytes", "8 x", "not measured: render_scene is not built", False)
    kept, full, before = drawn["kept"], drawn["full"], drawn["llvmpipe"]
    gain, gain_cpu = kept.per_second.median / full.per_second.median, full.cpu_ms.median / kept.cpu_ms.median
    rows.add("static layer against full draw, 640x480, same bytes (StaticLayer.*, test_speed_switches.py)", "8 x",
             f"{kept.per_second:.0f} / {full.per_second:.0f} frames/s to host memory = {gain:.1f} x; CPU {full.cpu_ms:.1f} / {kept.cpu_ms:.1f} ms = "
             f"{gain_cpu:.1f} x; kept by llvmpipe: {before.per_second:.0f} frames/s, {before.cpu_ms:.1f} ms", gain >= 8, "people, drawn either way")


def _moving(rows: Rows, plan: Plan) -> None:
    drawn = side_by_side(plan).ours
    for cameras in COUNTS:
        peer, wanted = best_peer(plan, cameras)
        what = f"{cameras} moving cameras 640x480, nothing kept, to host memory"
        if drawn is None:
            rows.add(what, f"{wanted:.0f} frames/s", "not measured: render_scene is not built", False)
            continue
        simple, fast, before = (drawn[name, cameras] for name in ("simple", "fast", "llvmpipe"))
        rows.add(what, f"{wanted:.0f} frames/s ({peer}), towards {1.5 * wanted:.0f}",
                 f"{simple.per_second:.0f} frames/s, {simple.cpu_ms:.1f} ms CPU each; quality `fast`, light per vertex as the peers: {fast.per_second:.0f}, {fast.cpu_ms:.1f} ms; "
                 f"device `llvmpipe`: {before.per_second:.0f}, {before.cpu_ms:.1f} ms",
                 simple.per_second.median >= wanted, "draw: shading pixels", "moving")


def _by_areas(rows: Rows, plan: Plan) -> None:
    """What exact edges cost, against pictures without them and against the others."""
    twelve = runs.realtime(12, VGA, 25, plan.seconds / 2, antialias="coverage")
    rows.add("12 standing cameras 640x480 at 25, `antialias: coverage`, one MJPEG reader each", "300 frames/s", f"{twelve.per_second:.0f} frames/s; {twelve.reading.cores:.2f} cores, {twelve.cpu_ms:.1f} ms CPU each",
             twelve.per_second >= 299, holder(twelve.reading), "areas")
    drawn = side_by_side(plan).ours
    beautiful = programs.in_turns({moving: ToMemory(1, moving=moving, quality="beautiful", antialias="coverage", view="lobby", threads=1) for moving in (False, True)}, plan.turn_s)
    if drawn is None or beautiful is None:
        return rows.add("pictures by areas to host memory", "1.35 x", "not measured: render_scene is not built", False)
    cameras = max(COUNTS)
    areas, plain = drawn["areas", cameras], drawn["simple", cameras]
    peer, theirs = best_peer(plan, cameras)
    rows.add(f"{cameras} moving cameras 640x480, nothing kept, `antialias: coverage`, to host memory", f"{1.2 * theirs:.0f} frames/s (1.2 x {peer})",
             f"{areas.per_second:.0f} frames/s = {areas.per_second.median / theirs:.2f} x, {areas.cpu_ms:.1f} ms CPU each", areas.per_second.median >= 1.2 * theirs, "", "areas")
    ratio = areas.cpu_ms.median / plain.cpu_ms.median
    rows.add("CPU of those against pictures without antialiasing", "1.35 x", f"{areas.cpu_ms:.1f} / {plain.cpu_ms:.1f} ms = {ratio:.2f} x", ratio <= 1.35, "", "areas")
    other = tiny(plan, cameras)
    if other is not None:
        ratio = plain.cpu_ms.median / other["cpu_ms"]
        rows.add(f"CPU of {cameras} moving cameras without antialiasing against panda3d-tiny", "below 1 x", f"{plain.cpu_ms:.1f} / {other['cpu_ms']:.1f} ms = {ratio:.2f} x", ratio < 1, "", "tiny")
    standing, moving = beautiful[False].cpu_ms, beautiful[True].cpu_ms
    rows.add("`beautiful` by areas, 640x480, one thread, standing / moving, CPU", "20 / 60 ms", f"{standing:.1f} / {moving:.1f} ms", standing.median <= 20 and moving.median <= 60, "", "beautiful")


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
