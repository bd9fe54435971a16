"""The parts of docs/speed.md: each measures and gives its Markdown."""

from __future__ import annotations

import time
from collections.abc import Callable

from . import limits, programs, runs
from .figures import figure, lines
from .meter import percentile
from .others import COUNTS, PEER_THREADS, PYTHON, difference_of_tiny, side_by_side
from .plan import FULL_HD, HD, QUICK, VGA, Plan, table
from .sensors import sensors
from .sharing import sharing
from .soak import soak
from .targets import pictures, targets

__all__ = ["ALL", "QUICK", "Plan"]

def cameras(plan: Plan) -> str:
    rows, curves = [], {"standing": [], "moving": []}
    for n in plan.counts:
        steps = max(3, plan.steps // n)
        still, moving = runs.lockstep(n, VGA, steps), runs.lockstep(n, VGA, max(3, steps // 2), moving=True)
        rows.append([n, f"{still.per_second:.0f}", f"{still.cpu_ms:.1f}", f"{moving.per_second:.0f}", f"{moving.cpu_ms:.1f}", f"{still.reading.use.rss_mib:.0f}"])
        curves["standing"].append(still.cpu_ms)
        curves["moving"].append(moving.cpu_ms)
    return ("## Cost a frame against the number of cameras\n\n640x480, lockstep, every picture made into a JPEG and read. Flat columns of CPU are the goal. A moving camera is turned "
            "before every picture, so that nothing can be kept.\n\n"
            + table(["cameras", "standing: frames/s", "CPU ms a frame", "moving: frames/s", "CPU ms a frame", "RSS MiB"], rows)
            + figure("cameras", "CPU milliseconds a frame against cameras, 640x480", lines(list(plan.counts), curves, "cameras", "CPU ms a frame", log_x=True)))


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


def outputs(plan: Plan) -> str:
    """What an output costs beside the drawing: the same four cameras, read in different ways."""
    rows = []
    for what, reader in (("nobody but the clock (nothing drawn)", None), *runs.READERS.items()):
        with runs.rig_with(4, VGA, 25, devices=True) as (rig, names):
            with runs.read_by(reader, rig, names):
                time.sleep(runs.WARM_UP_S)
                meter = runs.Meter(rig)
                time.sleep(plan.seconds / 6)
                reading = meter.read()
        stage = reading.stages
        rows.append([what, f"{reading.rendered / reading.wall_s:.0f}", f"{100 * reading.cores:.0f} %", f"{1000 * reading.cpu_s / reading.rendered:.1f}" if reading.rendered else "",
                     *(f"{stage[name]['p50_ms']:.2f}" if stage[name]["count"] else "" for name in ("convert", "encode"))])
    return ("## Outputs\n\nFour cameras 640x480 at 25 in real time, each read by one client. H.264 is x264's `ultrafast`, inside the daemon; it is in the CPU time, but in no stage.\n\n"
            + table(["read as", "frames/s", "of a core", "CPU ms a frame", "convert p50 ms", "encode p50 ms"], rows))


def load(plan: Plan) -> str:
    """What a frame costs against people and against triangles; the camera moves, so nothing is kept."""
    people, triangles = [], []
    steps = max(3, plan.steps // 6)
    for count in (0, 8, 16, 32, 64):
        still, moving = (runs.lockstep(1, VGA, steps, moving=moves, prepare=runs.crowd(count)) for moves in (False, True))
        people.append((count, still.cpu_ms, moving.cpu_ms))
    for count in (1_000, 10_000, 100_000, 400_000):
        with runs.mesh_scene(count) as scene:
            moving = runs.lockstep(1, VGA, max(3, steps // 4), moving=True, scene=scene)
        triangles.append((count, moving.cpu_ms))
    text = "## People and triangles\n\nOne camera 640x480, lockstep, JPEG made and read. People are added to those of the hall, in front of the camera `lobby`.\n\n"
    text += table(["people more", "standing: CPU ms a frame", "moving: CPU ms a frame"], [[n, f"{a:.1f}", f"{b:.1f}"] for n, a, b in people])
    text += "\n\nA wavy sheet of so many triangles that fills the picture, unlit, and a moving camera:\n\n" + table(["triangles", "CPU ms a frame"], [[f"{n:,}", f"{ms:.1f}"] for n, ms in triangles])
    return text + figure("people", "CPU milliseconds a frame against people", lines([n for n, _, _ in people], {"standing": [a for _, a, _ in people], "moving": [b for _, _, b in people]}, "people more", "CPU ms a frame"))


def overload(plan: Plan) -> str:
    rows = []
    for policy in ("drop", "slow"):
        with runs.rig_with(40, VGA, 25, overload=policy) as (rig, names):
            with runs.MjpegReaders(rig.call("server.info")["http"], names) as readers:
                time.sleep(runs.WARM_UP_S)
                readers.reset()
                meter = runs.Meter(rig)
                answers, begin_ns, begin = [], rig.call("world.status")["world_ns"], time.monotonic()
                while time.monotonic() < begin + plan.seconds / 2:
                    asked = time.perf_counter()
                    rig.call("camera.get", name=names[0])
                    answers.append(1e3 * (time.perf_counter() - asked))
                    time.sleep(0.05)
                reading, world_s = meter.read(), (rig.call("world.status")["world_ns"] - begin_ns) / 1e9
                readers.close_books(meter.sequences, reading.sequences)
                streams = readers.close()
        counts = [s.pictures for s in streams]
        latencies = [ms for s in streams for ms in s.latencies_ms]
        rows.append([policy, f"{sum(counts) / reading.wall_s:.0f}", f"{min(counts)} .. {max(counts)}", f"{100 * reading.dropped / max(1.0, len(names) * 25 * world_s):.0f} %",
                     runs.unreported(streams, reading), f"{world_s / reading.wall_s:.2f}", f"{percentile(latencies, 0.99):.0f} ms",
                     f"{percentile(answers, 0.99):.0f} / {max(answers):.0f} ms"])
    return ("## Overload: 40 cameras 640x480 at 25\n\n"
            + table(["policy", "frames/s", "frames per camera, min .. max", "dropped", "unreported", "world seconds a second", "latency p99", "control answers p99 / max"], rows)
            + "\n\nUnreported: frames that a reader never got and nobody counted as dropped; less than 0: counted as dropped, though it got them.")


def machine_limits(plan: Plan) -> str:
    seen = pictures()
    jpeg = limits.tjbench_ms(seen, 90)
    frame_bytes = VGA[0] * VGA[1] * 4
    copy = limits.memcpy_gb_s(frame_bytes, len(seen), plan.turn_s)
    with runs.mesh_scene(2) as sheet:
        # The sheet is 40 m wide; at 18 m a picture shows 37 m of it.
        views = {"an empty picture, cleared and read back, llvmpipe": "0,-18,0,0,-36,0", "two triangles of one colour over everything, read back": "0,-18,0,0,0,0"}
        drawn = programs.in_turns({what: programs.ToMemory(1, FULL_HD, moving=True, scene=sheet, view=view, device="llvmpipe") for what, view in views.items()}, plan.turn_s)
    rows = [[f"memcpy of {len(seen)} RGBA pictures of 640x480 in rotation, one core", f"{copy:.1f} GB/s", f"a picture in {frame_bytes / copy / 1e6:.2f} ms"]]
    share = VGA[0] * VGA[1] / (FULL_HD[0] * FULL_HD[1])
    for what, seen_at in (drawn or {}).items():
        mpixels = programs.Values([per_second * FULL_HD[0] * FULL_HD[1] / 1e6 for per_second in seen_at.per_second.values])
        rows.append([what, f"{mpixels:.0f} Mpixel/s", f"a picture of 640x480 in {1e3 * share / seen_at.per_second.median:.2f} ms"])
    if jpeg is not None:
        rows.append(["tjbench, RGBX to 4:2:0, quality 90, one core", f"{jpeg:.2f} ms a picture of 640x480", f"{2e3 / jpeg:.0f} pictures/s if two cores did nothing else"])
    return "## What the machine gives\n\nWhat is drawn: medians of turns (lowest..highest).\n\n" + table(["limit", "measured", "that is"], rows)


def kernels(plan: Plan) -> str:
    rows = programs.kernels(0.05 if plan is QUICK else 0.5)
    if rows is None:
        return "## Kernels\n\nNot measured: `camrig_kernels` is not built (`cmake --preset dev -DCAMRIG_BENCHMARKS=ON`)."
    return ("## Kernels\n\nGoogle Benchmark. CPU time is of one thread, and of all threads where the name has `process_time`. Things a second (pixels, unless the kernel has others) are by CPU time, "
            "and by the clock where the name has `real_time`.\n\n"
            + table(["kernel", "CPU time", "a second"], [[f"`{row['name']}`", f"{row['cpu_time']:.3g} {row['time_unit']}", f"{row.get('items_per_second', 0):.3g}"] for row in rows]))


def peers(plan: Plan) -> str:
    title = "## Other renderers\n\n"
    if not PYTHON.exists():
        return title + "Not measured: tools/bench/peers/setup was not run."
    measured, rows, to_tiny = side_by_side(plan), [], []
    for cameras in COUNTS:
        if measured.ours is not None:
            for name, called in (("fast", "quality `fast`"), ("simple", "quality `simple`"), ("areas", "quality `simple`, by areas"), ("llvmpipe", "quality `simple`, device `llvmpipe`")):
                ours = measured.ours[name, cameras]
                rows.append([f"camrig, {called}", cameras, f"{ours.per_second:.0f}", f"{ours.cpu_ms:.1f}"])
        peers_here = [peer for peer in measured.others if peer["cameras"] == cameras]
        rows += [[peer["name"], cameras, f"{peer['per_second']:.0f}", f"{peer['cpu_ms']:.1f}"] for peer in peers_here]
        tiny = [peer["per_second"] for peer in peers_here if peer["name"] == "panda3d-tiny"]
        if measured.ours is not None and tiny:
            to_tiny.append(f"{measured.ours['simple', cameras].per_second.median / tiny[0]:.2f} x with {cameras} cameras")
    return (title + "The hall and eight people as they stand (camrig: all eleven of it, who walk), the same poses of cameras, each turned before each picture, 640x480 to arrays in host memory, "
            f"camrig and llvmpipe with {PEER_THREADS} threads. camrig's figures are medians of {programs.TURNS} turns of about {plan.turn_s:g} s each (lowest..highest), before, between and after the "
            f"others, which have one run of {max(1.0, plan.seconds / 15):g} s each. Versions are "
            "those that tools/bench/peers/setup installs; what each does not draw is said in tools/bench/peers/README.md.\n\n" + table(["renderer", "cameras", "frames/s", "CPU ms a frame"], rows)
            + ("\n\n" + difference_of_tiny() + " camrig's `simple` draws of its frames a second: " + ", ".join(to_tiny) + "." if to_tiny else ""))


ALL: dict[str, Callable[[Plan], str]] = {
    "targets": targets, "cameras": cameras, "sizes": sizes, "outputs": outputs, "load": load, "overload": overload, "sharing": sharing, "sensors": sensors, "limits": machine_limits,
    "kernels": kernels, "peers": peers, "soak": soak,
}
