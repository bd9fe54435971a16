"""Masks of recordings as polygons, held against COCO's own reader."""

import json

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask

import camrig
from camrig.polygons import convert, decode_mask, mask_polygons


def masks():
    numbers = np.random.default_rng(3)
    yield np.ones((5, 7), bool)
    yield np.eye(9, dtype=bool)  # pixels that touch at their corners only
    for size in ((40, 30), (31, 57), (1, 9), (64, 1)):
        yield numbers.random(size) < 0.4
        yield cv2.GaussianBlur(numbers.random(size), (0, 0), 2.5) > 0.5
    ring = np.zeros((20, 20), bool)
    ring[3:17, 4:18] = True
    ring[8:12, 9:13] = False
    yield ring


def without_holes(mask):
    """What cannot be reached from outside by steps to the four sides belongs to the object."""
    padded = np.pad(mask, 1).astype(np.uint8)
    cv2.floodFill(padded, None, (0, 0), 2, flags=4)
    return padded[1:-1, 1:-1] != 2


@pytest.mark.parametrize("mask", list(masks()))
def test_polygons_hold_the_pixels_of_the_mask_and_of_its_holes(mask):
    outlines = mask_polygons(mask)
    drawn = coco_mask.decode(coco_mask.merge(coco_mask.frPyObjects(outlines, *mask.shape))) if outlines else np.zeros(mask.shape)
    np.testing.assert_array_equal(drawn == 1, without_holes(mask))


@pytest.mark.parametrize("mask", list(masks()))
def test_run_lengths_are_read_as_cocos_own_tools_read_them(mask):
    written = coco_mask.encode(np.asfortranarray(mask, np.uint8))
    np.testing.assert_array_equal(decode_mask({"size": written["size"], "counts": written["counts"].decode()}), mask)


@pytest.mark.parametrize("counts", ["", "0", "T", "1000000", "P1"])
def test_run_lengths_that_do_not_fill_the_picture_are_refused(counts):
    with pytest.raises(camrig.CamrigError):
        decode_mask({"size": [4, 4], "counts": counts})


def test_a_recording_without_masks_says_what_to_do(tmp_path):
    with pytest.raises(camrig.CamrigError, match="camrig record --masks"):
        convert(tmp_path)
    (tmp_path / "coco.json").write_text('{"annotations": [{"segmentation": []}]}')
    with pytest.raises(camrig.CamrigError, match="--masks"):
        convert(tmp_path)


def test_ignored_regions_are_polygons_already_and_stay(tmp_path):
    mask = {"size": [2, 2], "counts": coco_mask.encode(np.asfortranarray(np.ones((2, 2), np.uint8)))["counts"].decode()}
    ignored = [[0, 0, 2, 0, 2, 1]]
    (tmp_path / "coco.json").write_text(json.dumps({"annotations": [{"segmentation": mask}, {"segmentation": ignored, "iscrowd": 1}]}))
    one, other = json.loads(convert(tmp_path).read_text())["annotations"]
    assert one["segmentation"] == mask_polygons(np.ones((2, 2), bool)) and other["segmentation"] == ignored
