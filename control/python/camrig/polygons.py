"""python -m camrig.polygons DIR: masks of a recording as polygons, for trainers that take nothing else.

Reads DIR/coco.json of `camrig record --masks`, whose masks are exact (run lengths), and writes DIR/coco_polygons.json beside it, in
which each is a list of polygons along the edges of its pixels. Polygons know no holes: what shows through an object counts as the
object there; `area` and `bbox` stay those of the mask. Needs OpenCV.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, Mapping

import numpy as np

from .errors import CamrigError


def decode_mask(segmentation: Mapping[str, Any]) -> np.ndarray:
    """The mask (bool, height x width) of a `segmentation` {"size": [height, width], "counts": "..."} of coco.json."""
    height, width = segmentation["size"]
    lengths: list[int] = []
    value = shift = 0
    for character in segmentation["counts"].encode():
        group = character - 48
        value |= (group & 0x1F) << shift
        shift += 5
        if group & 0x20:
            continue
        if group & 0x10:
            value -= 1 << shift
        lengths.append(value + (lengths[-2] if len(lengths) > 2 else 0))
        value = shift = 0
    inside = np.arange(len(lengths)) % 2 == 1
    if shift or sum(lengths) != height * width or min(lengths) < 0:
        raise CamrigError("invalid_argument", f"a mask of {width}x{height} whose runs do not fill it")
    return np.repeat(inside, lengths).reshape(width, height).T


def mask_polygons(mask: np.ndarray) -> list[list[int]]:
    """The outlines of a mask's parts as COCO has them: [x, y, x, y, ...], pixel edges at integers; without holes."""
    try:
        import cv2
    except ImportError as missing:
        raise CamrigError("unsupported", "polygons need OpenCV: pip install 'camrig[opencv]'") from missing

    # Each pixel as 2x2: the outline through their middles then lies within the pixel's quarters, and rounds to its edges.
    doubled = np.ascontiguousarray(mask, np.uint8).repeat(2, axis=0).repeat(2, axis=1)
    outlines = cv2.findContours(doubled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[-2]
    return [((outline.reshape(-1) + 1) // 2).tolist() for outline in outlines]


def convert(folder: Path) -> Path:
    source, target = folder / "coco.json", folder / "coco_polygons.json"
    try:
        coco = json.loads(source.read_text())
    except OSError as problem:
        raise CamrigError("not_found", f"{source}: {problem.strerror}; it is written by `camrig record --masks`") from problem
    for annotation in coco["annotations"]:
        if not annotation["segmentation"]:
            raise CamrigError("invalid_argument", f"{source} has no masks: record with --masks")
        if isinstance(annotation["segmentation"], list):
            continue  # an ignored region: it is a polygon already
        annotation["segmentation"] = mask_polygons(decode_mask(annotation["segmentation"]))
    target.write_text(json.dumps(coco))
    return target


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m camrig.polygons", description="Masks of a recording as polygons.")
    parser.add_argument("folder", type=Path, help="what camrig record wrote")
    try:
        print(convert(parser.parse_args().folder))
    except CamrigError as problem:
        print(problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
