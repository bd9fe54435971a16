"""python -m tools.bench.people_pictures [--before PROGRAM COMMIT] [--report]

How well OpenCV's stock people detector (HOG, camrig.samples.hog) finds the people of the shipped scenes in pictures of each quality: whether
pictures that please the eye still show people as a detector knows them from photographs. --before: the same with another build of camrig and
its own scenes, for instance that of a commit before light was baked; its people walk other ways, so compare shares, not pictures.

Scored as the Caltech benchmark does (camrig.samples.scoring): people of 80 to 300 pixels who are at least half visible and do not sit.
"""

from __future__ import annotations

import argparse
import math
from statistics import mean

from camrig.samples.hog import Detector
from camrig.samples.people import observe
from camrig.samples.views import AsSeen
from tools.bench import report
from tools.bench.detection_curve import Curve

PAGE = report.REPOSITORY / "docs" / "quality.md"
PLACES = (("hall", "lobby"), ("hall", "entrance"), ("street", "crossing"), ("street", "corner"), ("crowd", "west"))
QUALITIES = ("fast", "simple", "beautiful")
SIZE, APART_S = (640, 480), 1.6
ENLARGE, THRESHOLD = 1.5, -0.6
FALSE_PER_PICTURE = (0.1, 1.0)


def look(pictures: int, program: str | None = None) -> dict[str, dict[str, Curve]]:
    """By quality and scene; None: this build. One instant is looked at at every quality."""
    detector, view = Detector(THRESHOLD), AsSeen(ENLARGE)
    curves = {quality: {scene: Curve() for scene, _ in PLACES} for quality in QUALITIES}
    for scene, place in PLACES:
        with report.start(scene, mode="lockstep", seed=23, binary=program) as rig:
            cameras = {quality: rig.create_camera(quality, place=place, size=SIZE, fps=25, quality=quality) for quality in QUALITIES}
            for _ in range(pictures):
                rig.step(seconds=APART_S)
                for quality, camera in cameras.items():
                    frame, truth = observe(camera)
                    curves[quality][scene].add(detector(frame.image, view), truth)
    return curves


def row(title: str, of_scenes: dict[str, Curve]) -> str:
    """Scenes count alike: how many people there are to be found says nothing of the pictures."""
    curves = list(of_scenes.values())
    errors = [curve.standard_error(Curve.average_precision) for curve in curves]
    cells = [f"{curve.average_precision():.2f} ± {error:.2f} ({curve.people})" for curve, error in zip(curves, errors)]
    cells.append(f"**{mean(curve.average_precision() for curve in curves):.3f}** ± {math.hypot(*errors) / len(errors):.3f}")
    return f"| {title} | " + " | ".join([*cells, *(f"{mean(curve.recall_at(wrong) for curve in curves):.2f}" for wrong in FALSE_PER_PICTURE)]) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", nargs=2, metavar=("PROGRAM", "COMMIT"), help="another build of camrig, and which it is")
    parser.add_argument("--pictures", type=int, default=40, help="of each camera at each quality (default 40)")
    parser.add_argument("--report", action="store_true", help="writes the table into docs/quality.md")
    options = parser.parse_args()
    scenes = list(dict.fromkeys(scene for scene, _ in PLACES))
    rows = ["| pictures | " + " | ".join(f"average precision, {scene}" for scene in scenes) + " | mean of scenes | "
            + " | ".join(f"found at {wrong:g} wrong a picture, mean" for wrong in FALSE_PER_PICTURE) + " |", "|---" * (len(scenes) + 4) + "|"]
    if options.before:
        program, commit = options.before
        rows += [row(f"`{quality}` of commit {commit}", of) for quality, of in look(options.pictures, program).items()]
    rows += [row(f"`{quality}`", of) for quality, of in look(options.pictures).items()]
    text = "\n".join(rows) + (f"\n\nIn brackets: people to be found, of {SIZE[0]}x{SIZE[1]} pixels from {', '.join(f'{scene} {place}' for scene, place in PLACES)}, "
                              f"{options.pictures} pictures each, {APART_S:g} s apart. ±: standard error, by the bootstrap over pictures.")
    print(text)
    if options.report:
        report.put(PAGE, "people", text, "`python -m tools.bench.people_pictures --before PROGRAM COMMIT --report`")


if __name__ == "__main__":
    main()
