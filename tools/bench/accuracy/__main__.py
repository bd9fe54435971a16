"""Measures camrig's accuracy and writes docs/accuracy.md with its figures.

    python tools/bench/accuracy [--quick] [PART...]

Parts not named keep what was measured last (build/accuracy). Needs tools/bench/accuracy/requirements.txt, the camrig
program ($CAMRIG_BIN, or build/dev), the lens_probe program and ffmpeg with libx264. A full run takes about 15 minutes.
"""

import argparse
import pathlib
import platform
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from accuracy import REPOSITORY, part_calibration, part_codecs, part_points, part_sampling  # noqa: E402
from accuracy.section import Section  # noqa: E402

PARTS = {
    "reprojection": part_points.reprojection,
    "calibration": part_calibration.calibration,
    "stereo": part_calibration.stereo,
    "offset": part_points.offset,
    "depth": part_points.depth,
    "inverse": part_calibration.inverse,
    "lens_methods": part_sampling.lens_methods,
    "antialias": part_sampling.antialias,
    "textures": part_sampling.textures,
    "colour": part_codecs.colour,
    "jpeg": part_codecs.jpeg,
    "h264": part_codecs.h264,
}
KEPT = REPOSITORY / "build" / "accuracy"


def machine():
    model = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.processor())
    import os

    return f"{os.cpu_count()} cores of {model}, Mesa llvmpipe, shared with other work"


def page(sections):
    text = (pathlib.Path(__file__).parent / "page.md").read_text()
    gates = []
    for name in PARTS:
        section = sections.get(name)
        text = text.replace("{{" + name + "}}", section.text.strip() if section else "Not measured yet.")
        gates += section.gates if section else []
    lines = ["| what | worst measured | must be below | |", "|---|---|---|---|"]
    for gate in gates:
        met = "" if gate["value"] < gate["limit"] else "**missed**"
        lines.append(f"| {gate['what']} | {gate['value']:.3g} {gate['unit']} | {gate['limit']:.3g} | {met} |")
    text = text.replace("{{gates}}", "\n".join(lines)).replace("{{machine}}", machine())
    (REPOSITORY / "docs" / "accuracy.md").write_text(text)
    return [gate for gate in gates if not gate["value"] < gate["limit"]]


def main():
    parser = argparse.ArgumentParser(prog="accuracy", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--quick", action="store_true", help="fewer cameras, points and samples; writes the page all the same")
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    for name in options.parts or PARTS:
        start = time.monotonic()
        section = Section()
        PARTS[name](section, options.quick)
        section.save(KEPT / f"{name}.json")
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
    sections = {name: Section.read(KEPT / f"{name}.json") for name in PARTS if (KEPT / f"{name}.json").exists()}
    missed = page(sections)
    for gate in missed:
        print(f"missed: {gate['what']}: {gate['value']:.3g} {gate['unit']}, must be below {gate['limit']:.3g}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
