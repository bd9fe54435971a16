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
from pathlib import Path

import numpy as np
from PIL import Image

from tools.bench import report

ROOT = report.REPOSITORY
sys.path.insert(0, str(ROOT / "control" / "python"))
from camrig.places import find_binary  # noqa: E402
from camrig.scene_base import on_its_base  # noqa: E402
from tools.bench.light import compare, export  # noqa: E402

PAGE = ROOT / "docs" / "quality.md"
PICTURES = ROOT / "docs" / "pictures" / "light"
VIEWS = (("hall", "lobby"), ("street", "corner"), ("street-noon", "crossing"))
LEVELS = ("fast", "simple", "beautiful")
#: `beautiful` in the baked light that the scene is shipped with.
BAKED = "`beautiful`, baked"
#: Share of the pixels whose depth may differ by more than 1 %: edges of triangles and of what is masked.
DEPTH_SHARE = 0.02


def draw(scene: dict, place: str, size: tuple[int, int], levels: tuple[str, ...], *, light: Path | None = None):
    """({level: HxWx3 codes}, depth, the camera as the export has it)."""
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
            projection = cameras[0].projection()
            return pictures, cameras[0].depth(), export.eye(size, projection.K, projection.world_from_camera)


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


def measure(name: str, place: str, size: tuple[int, int], samples: int) -> tuple[list[str], str, str]:
    from tools.bench.light.reference import Reference

    path = ROOT / "scenes" / f"{name}.json"
    scene = export.still(on_its_base(json.loads(path.read_text()), path))
    pictures, depth, eye = draw(scene, place, size, LEVELS)
    shipped = next(file for file in (path, path.with_name(json.loads(path.read_text()).get("base", path.name))) if file.with_suffix(".light").is_file())
    pictures[BAKED] = draw(scene, place, size, ("beautiful",), light=shipped.with_suffix(".light"))[0]["beautiful"]
    exported = export.read(scene, ROOT / "scenes")
    unlit = draw(export.without_lights(scene, exported), place, size, ("beautiful",))[0]["beautiful"]
    reference = Reference(exported, eye)
    share = depth_differs(depth, reference.depth())
    print(f"{name}, {place}: {100 * share:.2f} % of the pixels differ in depth", file=sys.stderr, flush=True)
    if share > DEPTH_SHARE:
        raise RuntimeError(f"{name}, {place}: depth differs in {100 * share:.1f} % of the pixels: the export is wrong")
    layers = tuple(reference.layers(samples // 2, seed) for seed in (10, 20))
    light = (layers[0].whole + layers[1].whole) / 2
    is_lamp = compare.beside_lamps(light * exported.exposure)
    rows = []
    for level in (*LEVELS, BAKED):
        is_toned = exported.has_tone_curve and level in ("beautiful", BAKED)
        halves = tuple(export.codes(half.whole, exported.exposure, is_toned=is_toned) for half in layers)
        found = compare.score(pictures[level], halves, is_lamp)
        factor = compare.best_factor(pictures[level], light * exported.exposure, is_toned=is_toned)
        levelled = compare.score(pictures[level], tuple(export.codes(half.whole, exported.exposure * factor, is_toned=is_toned) for half in layers), is_lamp)
        rows.append(
            f"| {name}, {place} | {level if level == BAKED else f'`{level}`'} | {found.psnr_db:.1f} | {found.psnr_without_lamps_db:.1f} | {found.ssim:.3f} | {found.flip:.3f} | {factor:.2f} | {levelled.psnr_db:.1f} | "
            f"{levelled.flip:.3f} | {compare.noise(halves):.1f} | {100 * share:.2f} |"
        )
        print(rows[-1], file=sys.stderr, flush=True)
    ours = export.light_of(pictures["beautiful"], is_toned=exported.has_tone_curve)
    steps = compare.mended(ours, export.light_of(unlit), layers, exported.exposure, is_toned=exported.has_tone_curve)
    print(f"{name}, {place}: {100 * is_lamp.mean():.1f} % of the pixels are of or beside what shines over white", file=sys.stderr, flush=True)
    ladder = f"| {name}, {place} | " + " | ".join(f"{decibels:.1f}" for _, decibels in steps) + " |"
    print(ladder, file=sys.stderr, flush=True)
    return rows, ladder, save(f"{name}-{place}", pictures[BAKED], (halves[0] + halves[1]) / 2)


def main() -> int:
    parser = argparse.ArgumentParser(prog="tools.bench.light", description="our pictures against Mitsuba 3; writes docs/quality.md")
    parser.add_argument("--samples", type=int, default=1024, help="a pixel, in two halves (default 1024)")
    parser.add_argument("--only", choices=[name for name, _ in VIEWS], help="this scene, printed and not written")
    parser.add_argument("--size", default="320x240", help="WxH (default 320x240)")
    arguments = parser.parse_args()
    width, height = (int(part) for part in arguments.size.split("x"))
    found = [measure(name, place, (width, height), arguments.samples) for name, place in VIEWS if arguments.only in (None, name)]
    if arguments.only:
        return 0
    text = "\n".join([
        f"{width}x{height}, `antialias: coverage`, {arguments.samples} samples a pixel of Mitsuba.", "",
        "| scene, place | level | PSNR dB | PSNR, lamps left out | SSIM | FLIP | level, ours to reference | PSNR at equal level | FLIP at equal level | noise of the reference, codes | depth differs, % |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
        *(row for rows, _, _ in found for row in rows), "",
        "PSNR in dB of `beautiful` as one part of its light after the other is replaced by the reference's:", "",
        "| scene, place | as it is | sun: shadows, surfaces | and sun bounced | and the surroundings, with what hides them |", "|---|---|---|---|---|",
        *(ladder for _, ladder, _ in found), "",
        *(line for _, _, picture in found for line in (picture, "")),
    ])
    report.put(PAGE, "light", text, f"`build/light/bin/python -m tools.bench.light --samples {arguments.samples} --size {arguments.size}`")
    return 0


if __name__ == "__main__":
    sys.exit(main())
