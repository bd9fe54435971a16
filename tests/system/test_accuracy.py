"""Where the cameras see a point, against OpenCV in double precision. How: tools/bench/accuracy; figures: docs/accuracy.md."""

import sys

import numpy as np
import pytest

from conftest import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tools" / "bench"))
from accuracy import estimator, marks, measure, part_codecs, part_points  # noqa: E402
from accuracy.lenses import PINHOLES, Camera  # noqa: E402


@pytest.fixture(scope="module")
def meter():
    with measure.rig_of() as rig:
        yield rig


def test_the_estimator_itself_is_better_than_the_gates():
    """A gate of 0.02 px means nothing when the ruler is off by as much."""
    exact = estimator.bias(samples=16, shifts_n=1, eight_bit=True)
    assert np.abs(exact.mean(axis=0)).max() < 5e-4
    dithered = estimator.bias(samples=1, shifts_n=4, eight_bit=True)
    assert np.abs(dithered.mean(axis=0)).max() < 2e-3
    assert np.hypot(*dithered.T).max() < 0.018


@pytest.mark.parametrize("camera", PINHOLES, ids=lambda c: c.name)
def test_a_pinhole_sees_every_mark_within_two_hundredths_of_a_pixel(meter, camera):
    residuals, places = measure.reprojection(meter, camera, dither=6)
    assert len(places) >= 70
    assert estimator.summary(residuals)[0] < 0.02
    assert np.abs(residuals.mean(axis=0)).max() < 0.002


def test_the_same_world_far_from_the_origin_is_seen_at_the_same_pixels(meter):
    """A million kilometres out, only the rounding of the camera's own place (6e-8 m) may show."""
    camera = PINHOLES[1]
    field = marks.place_discs(camera, spacing_px=80)
    seen = {}
    for distance in (0.0, 1e3, 1e6, 1e9):
        moved = np.array([distance, -distance, distance])
        meter.load(marks.write_scene(meter.folder, field, offset=moved))
        cam = measure.new_camera(meter, **camera.options(), position=list(field.position + moved), orientation=list(field.orientation))
        light = estimator.linear_light(cam.frame().image)
        seen[distance] = light, estimator.centroids(light, field.outlines(camera))
    here, places = seen.pop(0.0)
    for distance, (light, there) in seen.items():
        shift = (there - places).mean(axis=0)
        assert np.hypot(*shift) < 0.002, distance
        assert (light != here).sum() <= 20, distance  # a sample on the very edge of a disc may change sides


def test_depth_in_the_middle_is_right_to_a_millionth_from_a_decimetre_to_a_thousand_kilometres(meter):
    distances = [0.1, 1.0, 37.0, 1e3, 1e4, 1e6]
    meter.load(part_points.walls(meter.folder, distances))
    camera = Camera("depth", cx=320.0, cy=240.0)
    cam = measure.new_camera(meter, **camera.options(), position=(0, 0, 0), near=0.001)
    for i, distance in enumerate(distances):
        cam.set(position=(0, 0, 0), pan_deg=part_points.step_deg(distances) * i)
        metres = cam.depth()
        assert abs(float(metres[240, 320]) / distance - 1) < 1e-6
        lit = np.isfinite(metres)
        assert lit.sum() > 10_000
        assert np.abs(metres[lit] / distance - 1).max() < 2e-6


def test_flat_colours_survive_jpeg_and_png(meter):
    """Through the rig's conversion and a stock decoder; the gates are those of BT.601 at 8 bits."""
    png = part_codecs.colour_errors(meter, lambda cam: cam.frame(format="png").image[:, :, :3], seeds=(1,))
    assert not png.any()
    jpeg = part_codecs.colour_errors(meter, part_codecs.decode_jpeg)
    assert np.abs(jpeg).max() <= 1
    assert np.abs(jpeg.mean(axis=0)).max() < 0.02
