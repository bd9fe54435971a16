"""python -m tools.bench.truth [--scene scenes/hall.json] [--frames 200] [--write]

Two rigs in lockstep at the same world times, the first camera of each. CPU time (user and system) of a rig's whole process per picture.
One rig is never asked for truth. The other is asked with every picture of one block of --block pictures, and not in the next, and so
on; the rigs take each block one after the other. Who asks no more pays as much as who never asked, but for noise, because nothing is
drawn, kept or computed for truth unless it is asked for. --write puts the table into docs/truth.md.
"""

import argparse
import statistics

from tools.bench import report
from tools.bench.speed.meter import cpu_s_of


def measure(rig, camera, frames, with_truth):
    pid = rig.call("server.info")["pid"]
    before = cpu_s_of(pid)
    for _ in range(frames):
        rig.step(seconds=0.04)
        camera.frame(kind="color")
        if with_truth:
            camera.truth()
    return 1000 * (cpu_s_of(pid) - before) / frames


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="scenes/hall.json")
    parser.add_argument("--frames", type=int, default=200, help="of each kind (default 200)")
    parser.add_argument("--block", type=int, default=25)
    parser.add_argument("--write", action="store_true", help="puts the table into docs/truth.md")
    options = parser.parse_args()
    asked, beside_asked, after, beside_after = [], [], [], []
    with report.start(options.scene, mode="lockstep") as rig, report.start(options.scene, mode="lockstep") as never:
        camera, never_camera = rig.cameras()[0], never.cameras()[0]
        for with_truth in (False, True):  # shaders, static layers, and what truth makes once
            measure(never, never_camera, options.block, False)
            measure(rig, camera, options.block, with_truth)
        for _ in range(max(1, options.frames // options.block)):
            beside_after.append(measure(never, never_camera, options.block, False))
            after.append(measure(rig, camera, options.block, False))
            beside_asked.append(measure(never, never_camera, options.block, False))
            asked.append(measure(rig, camera, options.block, True))
    lines = ["| CPU ms per picture | median | lowest | highest |", "|---|---|---|---|"]
    for name, values in (("truth of every picture", asked), ("at the same times, a rig that was never asked", beside_asked),
                         ("nobody asks any more", after), ("at the same times, a rig that was never asked", beside_after)):
        lines.append(f"| {name} | {statistics.median(values):.2f} | {min(values):.2f} | {max(values):.2f} |")
    lines += ["", f"{options.scene}, camera `{camera.name}`, {options.frames} pictures of each, in blocks of {options.block}."]
    print("\n".join(lines))
    if options.write:
        report.put(report.REPOSITORY / "docs/truth.md", "cost", "\n".join(lines), "`python -m tools.bench.truth --write`")


if __name__ == "__main__":
    main()
