"""build/light/bin/python -m tools.bench.light: our pictures against Mitsuba 3; writes the part `light` of docs/quality.md.

The shipped scenes without what moves. Both draw the same scene file, camera and size; the reference's linear light goes through our
exposure and sRGB curve. That both see the same is checked first, by depth through the pixels' centres.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from tools.bench import report

ROOT = report.REPOSITORY
sys.path.insert(0, str(ROOT / "control" / "python"))
from camrig.places import find_binary  # noqa: E402
from camrig.scene_base import on_its_base  # noqa: E402
from tools.bench.light import compare, export  # noqa: E402
from tools.bench.light.reference import Reference  # noqa: E402

PAGE = ROOT / "docs" / "quality.md"
PICTURES = ROOT / "docs" / "pictures" / "light"
VIEWS = (("hall", "lobby"), ("street", "corner"), ("street-noon", "crossing"))
#: Who stands before the camera when people are looked at, on level ground, some with their backs to it.
PEOPLE = {
    "hall": (("person_1", 6.2, 5.5, 210), ("person_4", 5.5, 6.6, 20), ("person_6", 6.8, 4.4, 170), ("person_8", 7.7, 7.6, 260), ("person_11", 9.0, 5.3, 120)),
    "street": (("person_1", -5.2, 0.5, 250), ("person_4", -3.6, -1.2, 40), ("person_6", -2.6, -2.6, 200), ("person_8", -6.4, -2.4, 300), ("person_11", -0.6, 0.6, 230)),
    "street-noon": (("person_1", -0.3, 4.4, 200), ("person_4", -2.0, 2.2, 330), ("person_6", -2.8, 0.7, 150), ("person_8", -4.5, 3.7, 170), ("person_11", -4.6, 1.8, 90)),
}
LEVELS = ("fast", "simple", "beautiful")
#: `beautiful` in the baked light that the scene is shipped with.
BAKED = "`beautiful`, baked"
#: Samples a pixel between two looks at the noise, in two halves.
BATCH = 256
#: Samples a pixel at most where people are looked at: the error that is told has no noise, so few do.
PEOPLE_SAMPLES = 512
#: Share of the pixels whose depth may differ by more than 1 %: edges of triangles and of what is masked.
DEPTH_SHARE = 0.02


@dataclass(frozen=True)
class Drawn:
    """pictures: HxWx3 codes of each level; depth: HxW metres; is_person: HxW; eye: the camera as the export has it."""

    pictures: dict[str, np.ndarray]
    depth: np.ndarray
    is_person: np.ndarray
    eye: export.Eye


def draw(scene: dict, place: str, size: tuple[int, int], levels: tuple[str, ...], *, light: Path | None = None) -> Drawn:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "still.json"
        file.write_text(json.dumps(scene))
        if light is not None:
            shutil.copyfile(light, file.with_suffix(".light"))
            subprocess.run([find_binary(), "bake", file, "--check"], check=True, stdout=subprocess.DEVNULL)
        with report.start(str(file), mode="lockstep", device="cpu") as rig:
            cameras = [rig.create_camera(level, place=place, size=size, fps=5, quality=level, antialias="coverage") for level in levels]
            rig.step(seconds=0.2)
            pictures = {level: camera.frame().image[..., 2::-1].astype(float) for level, camera in zip(levels, cameras)}
            people = [item["id"] for item in cameras[0].truth()["objects"] if item["class"] == "person"]
            projection = cameras[0].projection()
            eye = export.eye(size, projection.K, projection.world_from_camera)
            return Drawn(pictures, cameras[0].depth(), np.isin(cameras[0].instances(), people), eye)


def depth_differs(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Share of the pixels that do not show the same place."""
    is_seen = np.isfinite(ours) & np.isfinite(theirs)
    differs = np.isfinite(ours) != np.isfinite(theirs)
    differs[is_seen] = np.abs(ours[is_seen] - theirs[is_seen]) > 0.01 * theirs[is_seen]
    return float(differs.mean())


def save(name: str, ours: np.ndarray, theirs: np.ndarray) -> str:
    """Ours, the reference, and the difference about grey, side by side; the page's line for it."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    row = np.hstack([ours, theirs, np.clip(128 + (ours - theirs), 0, 255)])
    Image.fromarray(row.round().astype(np.uint8)).save(PICTURES / f"{name}.jpg", quality=88)
    return f"![{name}: baked `beautiful`, Mitsuba, the difference about grey](pictures/light/{name}.jpg)"


@dataclass(frozen=True)
class Found:
    """One view drawn by us at all levels and by the reference in two halves of its samples a pixel; `differs`: share of the pixels whose depth does."""

    drawn: Drawn
    exported: export.Exported
    lights: tuple[np.ndarray, np.ndarray]
    denoised: tuple[np.ndarray, np.ndarray]
    differs: float
    samples: int

    @property
    def light(self) -> np.ndarray:
        """The reference's."""
        return sum(self.denoised) / 2

    def halves(self, level: str, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """In codes, as our level shows that light."""
        return self._codes(self.lights, level, factor)

    def clean(self, level: str, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        """The same, denoised."""
        return self._codes(self.denoised, level, factor)

    def _codes(self, lights: tuple[np.ndarray, np.ndarray], level: str, factor: float) -> tuple[np.ndarray, np.ndarray]:
        return tuple(export.codes(light, self.exported.exposure * factor, is_toned=self.is_toned(level)) for light in lights)

    def is_toned(self, level: str) -> bool:
        return self.exported.has_tone_curve and level in ("beautiful", BAKED)


def find(name: str, place: str, size: tuple[int, int], samples: int, scene: dict, *, noise: float = 0.0) -> Found:
    """`scene`: the still one of that name, or with people in it. No more samples are taken once the reference is known to `noise` codes."""
    drawn = draw(scene, place, size, LEVELS)
    path = ROOT / "scenes" / f"{name}.json"
    shipped = next(file for file in (path, path.with_name(json.loads(path.read_text()).get("base", path.name))) if file.with_suffix(".light").is_file())
    drawn.pictures[BAKED] = draw(scene, place, size, ("beautiful",), light=shipped.with_suffix(".light")).pictures["beautiful"]
    exported = export.read(scene, ROOT / "scenes")
    reference = Reference(exported, drawn.eye)
    share = depth_differs(drawn.depth, reference.depth())
    print(f"{name}, {place}: {100 * share:.2f} % of the pixels differ in depth", file=sys.stderr, flush=True)
    if share > DEPTH_SHARE:
        raise RuntimeError(f"{name}, {place}: depth differs in {100 * share:.1f} % of the pixels: the export is wrong")
    # The sun has the seed after the others'.
    parts: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    taken = 0
    while taken < samples:
        batch = min(BATCH, samples - taken)
        for half, found in enumerate(parts):
            found.append(reference.light(batch // 2, 10 + 4 * len(found) + 2 * half) * batch)
        taken += batch
        lights = tuple(sum(found) / taken for found in parts)
        if compare.noise(tuple(export.codes(light, exported.exposure, is_toned=exported.has_tone_curve) for light in lights)) < noise:
            break
    return Found(drawn, exported, lights, tuple(reference.denoised(light) for light in lights), share, taken)


def shown(level: str) -> str:
    return level if level == BAKED else f"`{level}`"


def measure(name: str, place: str, size: tuple[int, int], samples: int, noise: float) -> tuple[list[str], str]:
    """Rows of the table of what stands still, and the line of its picture."""
    path = ROOT / "scenes" / f"{name}.json"
    scene = export.still(on_its_base(json.loads(path.read_text()), path))
    found = find(name, place, size, samples, scene, noise=noise)
    exported = found.exported
    is_lamp = compare.beside_lamps(found.light * exported.exposure)
    rows = []
    for level, picture in found.drawn.pictures.items():
        score = compare.score(picture, found.halves(level), found.clean(level), is_lamp)
        factor = compare.best_factor(picture, found.light * exported.exposure, is_toned=found.is_toned(level))
        levelled = compare.score(picture, found.halves(level, factor), found.clean(level, factor), is_lamp)
        rows.append(
            f"| {name}, {place} | {shown(level)} | {score.psnr_db:.1f} | {score.psnr_without_lamps_db:.1f} | {score.ssim:.3f} | {score.flip:.3f} | {factor:.2f} | {levelled.psnr_db:.1f} | "
            f"{levelled.flip:.3f} | {found.samples} | {compare.noise(found.halves(level)):.1f} | {compare.noise(found.clean(level)):.1f} | {100 * found.differs:.2f} |"
        )
        print(rows[-1], file=sys.stderr, flush=True)
    print(f"{name}, {place}: {100 * is_lamp.mean():.1f} % of the pixels are of or beside what shines over white", file=sys.stderr, flush=True)
    return rows, save(f"{name}-{place}", found.drawn.pictures[BAKED], sum(found.clean(BAKED)) / 2)


def measure_people(name: str, place: str, size: tuple[int, int], samples: int) -> tuple[str, str]:
    """The row of the table of people, and the line of the picture."""
    path = ROOT / "scenes" / f"{name}.json"
    people = tuple(export.Person(*of) for of in PEOPLE[name])
    found = find(name, place, size, samples, export.with_people(export.still(on_its_base(json.loads(path.read_text()), path)), people))
    there = found.drawn.is_person
    found_db = (
        compare.decibels(compare.mean_square(picture[there], tuple(half[there] for half in found.halves(level)))) for level, picture in found.drawn.pictures.items()
    )
    row = f"| {name}, {place} | {len(people)} | {100 * there.mean():.1f} | " + " | ".join(f"{value:.1f}" for value in found_db) + " |"
    print(row, file=sys.stderr, flush=True)
    return row, save(f"{name}-{place}-people", found.drawn.pictures[BAKED], sum(found.clean(BAKED)) / 2)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.light", description="our pictures against Mitsuba 3; writes docs/quality.md")
    parser.add_argument("--samples", type=int, default=4096, help="a pixel at most, in two halves (default 4096)")
    parser.add_argument("--noise", type=float, default=1.0, help="of the reference, codes, below which no more samples are taken (default 1)")
    parser.add_argument("--only", choices=[name for name, _ in VIEWS], help="this scene, printed and not written")
    parser.add_argument("--size", default="320x240", help="WxH (default 320x240)")
    arguments = parser.parse_args()
    width, height = (int(part) for part in arguments.size.split("x"))
    views = [view for view in VIEWS if arguments.only in (None, view[0])]
    still = [measure(name, place, (width, height), arguments.samples, arguments.noise) for name, place in views]
    people = [measure_people(name, place, (width, height), min(arguments.samples, PEOPLE_SAMPLES)) for name, place in views]
    if arguments.only:
        return 0
    text = "\n".join([
        f"{width}x{height}, `antialias: coverage`; Mitsuba with as many samples a pixel as its noise needs to be below {arguments.noise:g} codes, {arguments.samples} at most.", "",
        "| scene, place | level | PSNR dB | PSNR, lamps left out | SSIM | FLIP | level, ours to reference | PSNR at equal level | FLIP at equal level | samples | noise of the reference, codes | and denoised | depth differs, % |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
        *(row for rows, _ in still for row in rows), "",
        f"PSNR in dB of the pixels of people who stand there ({min(arguments.samples, PEOPLE_SAMPLES)} samples):", "",
        "| scene, place | people | % of the pixels | " + " | ".join(shown(level) for level in (*LEVELS, BAKED)) + " |", "|---|---|---|---|---|---|---|",
        *(row for row, _ in people), "",
        *(line for of_still, of_people in zip(still, people) for line in (of_still[1], "", of_people[1], "")),
    ])
    report.put(PAGE, "light", text, f"`build/light/bin/python -m tools.bench.light --samples {arguments.samples} --noise {arguments.noise:g} --size {arguments.size}`")
    return 0


if __name__ == "__main__":
    sys.exit(main())
