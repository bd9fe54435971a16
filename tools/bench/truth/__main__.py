"""python -m tools.bench.truth [--scene scenes/hall.json] [--frames 200] [--write]

One rig in lockstep, its first camera. CPU time (user and system) of the whole process per picture, from /proc: with pictures alone,
before anybody ever asked for truth; pictures and truth; pictures alone again. The first and the last differ by noise only, because
nothing is drawn, kept or computed for truth unless it is asked for. The three are taken in turns of --block pictures. --write puts the table
into docs/truth.md.
"""

import argparse
import os
import pathlib
import statistics

from tools.bench import report


def cpu_ms(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) * 1000 / os.sysconf("SC_CLK_TCK")


def measure(rig, camera, frames, with_truth):
    pid = rig.call("server.info")["pid"]
    before = cpu_ms(pid)
    for _ in range(frames):
        rig.step(seconds=0.04)
        camera.frame(kind="color")
        if with_truth:
            camera.truth()
    return (cpu_ms(pid) - before) / frames


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="scenes/hall.json")
    parser.add_argument("--frames", type=int, default=200, help="of each kind (default 200)")
    parser.add_argument("--block", type=int, default=25)
    parser.add_argument("--write", action="store_true", help="puts the table into docs/truth.md")
    options = parser.parse_args()
    with report.start(options.scene, mode="lockstep") as rig:
        camera = rig.cameras()[0]
        measure(rig, camera, options.block, False)  # shaders, static layers
        blocks = range(max(1, options.frames // options.block))
        never = [measure(rig, camera, options.block, False) for _ in blocks]
        asked, after = [], []
        for _ in blocks:
            asked.append(measure(rig, camera, options.block, True))
            after.append(measure(rig, camera, options.block, False))
    lines = ["| CPU ms per picture | median | lowest | highest |", "|---|---|---|---|"]
    for name, values in (("nobody has asked for truth", never), ("truth of every picture", asked), ("nobody asks any more", after)):
        lines.append(f"| {name} | {statistics.median(values):.2f} | {min(values):.2f} | {max(values):.2f} |")
    lines += ["", f"{options.scene}, camera `{camera.name}`, {options.frames} pictures of each."]
    print("\n".join(lines))
    if options.write:
        report.put(report.REPOSITORY / "docs/truth.md", "cost", "\n".join(lines), "`python -m tools.bench.truth --write`")


if __name__ == "__main__":
    main()
