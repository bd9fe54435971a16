"""The parts of docs/speed.md: each measures and gives its Markdown."""

from __future__ import annotations

import time
from collections.abc import Callable

from . import limits, programs, runs
from .figures import figure, lines
from .meter import percentile
from .others import PEER_THREADS, difference_of_tiny, other_renderers
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
                     f"{stage['convert']['p50_ms']:.2f}", f"{stage['encode']['p50_ms']:.2f}"])
    return ("## Outputs\n\nFour cameras 640x480 at 25 in real time, each read by one client. H.264 is x264's `ultrafast`, inside the daemon.\n\n"
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
    copy = limits.memcpy_gb_s(rounds=4 if plan is QUICK else 20)
    with runs.mesh_scene(2) as sheet:
        views = {"clear": "0,-24,0,0,-48,0", "fill": "0,-24,0,0,0,0"}
        empty, full = (programs.to_memory(1, FULL_HD, plan.steps, moving=True, scene=sheet, view=view, device="llvmpipe") for view in views.values())
    frame_mb = VGA[0] * VGA[1] * 4 / 1e6
    rows = [["memcpy, one core", f"{copy:.1f} GB/s", f"an RGBA picture of 640x480 in {frame_mb / copy:.2f} ms"]]
    share = VGA[0] * VGA[1] / (FULL_HD[0] * FULL_HD[1])
    for what, seen_at in (("an empty picture, cleared and read back, llvmpipe", empty), ("two triangles of one colour over everything, read back", full)):
        if seen_at is not None:
            rows.append([what, f"{seen_at.per_second * FULL_HD[0] * FULL_HD[1] / 1e6:.0f} Mpixel/s", f"a picture of 640x480 in {1e3 * share / seen_at.per_second:.2f} ms"])
    if jpeg is not None:
        rows.append(["tjbench, RGBX to 4:2:0, quality 90, one core", f"{jpeg:.2f} ms a picture of 640x480", f"{2e3 / jpeg:.0f} pictures/s if two cores did nothing else"])
    frames = max(3, plan.steps // 5)
    ours = programs.to_memory(8, VGA, frames)
    text = "## What the machine gives\n\n" + table(["limit", "measured", "that is"], rows)
    if ours is not None and jpeg is not None:
        floor = 2 * frame_mb / copy + jpeg
        text += (f"\n\nA standing camera's picture takes {ours.cpu_ms:.1f} ms of CPU to host memory and {jpeg:.2f} ms to become a JPEG; copying it twice and encoding it, which nothing can do "
                 f"without, takes {floor:.2f} ms: camrig is at {100 * floor / (ours.cpu_ms + jpeg):.0f} % of what the machine gives.")
    return text


def kernels(plan: Plan) -> str:
    rows = programs.kernels(0.05 if plan is QUICK else 0.5)
    if rows is None:
        return "## Kernels\n\nNot measured: `camrig_kernels` is not built (`cmake --preset dev -DCAMRIG_BENCHMARKS=ON`)."
    return "## Kernels\n\nOne thread, Google Benchmark.\n\n" + table(
        ["kernel", "CPU time", "a second"], [[f"`{row['name']}`", f"{row['cpu_time']:.3g} {row['time_unit']}", f"{row.get('items_per_second', 0):.3g}"] for row in rows])


def peers(plan: Plan) -> str:
    title = "## Other renderers\n\n"
    results = other_renderers(plan)
    if results is None:
        return title + "Not measured: tools/bench/peers/setup was not run."
    rows, to_tiny = [], []
    for cameras in (4, 12):
        frames = max(3, plan.steps // (2 * cameras))
        for quality in ("fast", "simple"):
            ours = programs.to_memory(cameras, VGA, frames, moving=True, quality=quality, threads=PEER_THREADS)
            if ours is not None:
                rows.append([f"camrig, quality `{quality}`", cameras, f"{ours.per_second:.0f}", f"{ours.cpu_ms:.1f}"])
        rows += [[peer["name"], cameras, f"{peer['per_second']:.0f}", f"{peer['cpu_ms']:.1f}"] for peer in results if peer["cameras"] == cameras]
        tiny = [peer["per_second"] for peer in results if (peer["name"], peer["cameras"]) == ("panda3d-tiny", cameras)]
        if ours is not None and tiny:
            to_tiny.append(f"{ours.per_second / tiny[0]:.2f} x with {cameras} cameras")
    return (title + "The hall and eight people as they stand (camrig: all eleven of it, who walk), the same poses of cameras, each turned before each picture, 640x480 to arrays in host memory, "
            f"camrig and llvmpipe with {PEER_THREADS} threads. Versions are "
            "those that tools/bench/peers/setup installs; what each does not draw is said in tools/bench/peers/README.md.\n\n" + table(["renderer", "cameras", "frames/s", "CPU ms a frame"], rows)
            + ("\n\n" + difference_of_tiny() + " camrig's `simple` draws of its frames a second: " + ", ".join(to_tiny) + "." if to_tiny else ""))


ALL: dict[str, Callable[[Plan], str]] = {
    "targets": targets, "cameras": cameras, "sizes": sizes, "outputs": outputs, "load": load, "overload": overload, "sharing": sharing, "sensors": sensors, "limits": machine_limits,
    "kernels": kernels, "peers": peers, "soak": soak,
}
