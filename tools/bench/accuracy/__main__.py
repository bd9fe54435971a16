"""Measures camrig's accuracy and writes docs/accuracy.md with its figures.

    python tools/bench/accuracy [--quick] [PART...]

Parts not named stay as they are. Needs tools/bench/accuracy/requirements.txt, the camrig
program ($CAMRIG_BIN, or build/dev), the lens_probe program and ffmpeg with libx264. A full run takes about 15 minutes.
"""

import argparse
import pathlib
import sys
import time

BENCH = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(BENCH), str(BENCH.parents[1])]

from accuracy import REPOSITORY, part_calibration, part_codecs, part_cost, part_points, part_sampling, part_shadows  # noqa: E402
from accuracy.section import Section  # noqa: E402
from tools.bench import report  # noqa: E402

PARTS = {
    "curve": part_cost.curve,
    "reprojection": part_points.reprojection,
    "calibration": part_calibration.calibration,
    "stereo": part_calibration.stereo,
    "offset": part_points.offset,
    "depth": part_points.depth,
    "inverse": part_calibration.inverse,
    "lens_methods": part_sampling.lens_methods,
    "antialias": part_sampling.antialias,
    "textures": part_sampling.textures,
    "detail": part_cost.detail,
    "shadows": part_shadows.edges_and_cost,
    "colour": part_codecs.colour,
    "jpeg": part_codecs.jpeg,
    "h264": part_codecs.h264,
}
PAGE = REPOSITORY / "docs" / "accuracy.md"
KEPT = REPOSITORY / "build" / "accuracy"


def bounds():
    """The gates of all parts as a table, and those that were missed. None: a part was never measured in this checkout."""
    if not all((KEPT / f"{name}.json").exists() for name in PARTS):
        return None
    gates = [gate for name in PARTS for gate in Section.read(KEPT / f"{name}.json").gates]
    lines = ["| what | worst measured | must be below | |", "|---|---|---|---|"]
    for gate in gates:
        met = "" if gate["value"] < gate["limit"] else "**missed**"
        lines.append(f"| {gate['what']} | {gate['value']:.3g} {gate['unit']} | {gate['limit']:.3g} | {met} |")
    return "\n".join(lines), [gate for gate in gates if not gate["value"] < gate["limit"]]


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
        report.put(PAGE, name, section.text, f"`python tools/bench/accuracy {name}`")
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
    if (found := bounds()) is None:
        print("the table of bounds stays as it was: it needs all parts")
        return 0
    text, missed = found
    report.put(PAGE, "bounds", text, "`python tools/bench/accuracy`")
    for gate in missed:
        print(f"missed: {gate['what']}: {gate['value']:.3g} {gate['unit']}, must be below {gate['limit']:.3g}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
