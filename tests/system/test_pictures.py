"""A handful of reference pictures: what the rig draws today is what it drew when somebody looked at it.

CAMRIG_UPDATE_PICTURES=1 writes them anew; look at them before committing.
"""

import os
import pathlib

import cv2
import numpy as np
import pytest

import camrig
from conftest import REPOSITORY

PICTURES = pathlib.Path(__file__).parent / "pictures"
SIZE = (320, 240)

CASES = [
    ("hall", "lobby", "simple", 6.0),
    ("hall", "gallery", "simple", 2.0),
    ("hall", "desk", "fast", 3.0),
    ("hall", "entrance", "beautiful", 6.0),
    ("clock", None, "simple", 0.3),
    ("minimal", None, "simple", 1.0),
]


@pytest.mark.parametrize("scene, place, quality, seconds", CASES, ids=lambda value: str(value))
def test_reference_picture(scene, place, quality, seconds):
    # Without coarse meshes: those of people far away are meshoptimizer's, and each version's are others.
    with camrig.start(str(REPOSITORY / "scenes" / f"{scene}.json"), mode="lockstep", device="cpu", args=["--detail-error-px", "0"]) as rig:
        if place:
            cam = rig.create_camera("reference", place=place, size=SIZE, quality=quality)
        else:
            cam = rig.cameras()[0]
            cam.set(size=SIZE, quality=quality)
        rig.step(seconds=seconds)
        image = cam.frame().image
    path = PICTURES / f"{scene}-{place or 'main'}-{quality}.png"
    if os.environ.get("CAMRIG_UPDATE_PICTURES"):
        path.parent.mkdir(exist_ok=True)
        cv2.imwrite(str(path), image)
    reference = cv2.imread(str(path))
    assert reference is not None, f"{path} is missing; run with CAMRIG_UPDATE_PICTURES=1 and look at it"
    # All of it is drawn by camrig's own rasteriser, which gives the same bytes everywhere.
    assert np.array_equal(image, reference), f"differs by up to {np.abs(image.astype(int) - reference).max()} codes"
