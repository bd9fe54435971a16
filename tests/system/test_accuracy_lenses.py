"""Cameras with lenses: where they see a point, what OpenCV calibrates from their pictures, and how edges are covered.

How: tools/bench/accuracy; figures: docs/accuracy.md.
"""

import sys

import numpy as np
import pytest

from conftest import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tools" / "bench"))
from accuracy import estimator, measure, part_calibration, part_sampling  # noqa: E402
from accuracy.lenses import LENSES, PINHOLES  # noqa: E402
from camrig_assets.glb import Glb  # noqa: E402
from camrig_assets.scene import Scene  # noqa: E402


@pytest.fixture(scope="module")
def meter():
    with measure.rig_of() as rig:
        yield rig


@pytest.mark.parametrize("camera", LENSES, ids=lambda c: c.name)
def test_one_picture_through_a_lens_shows_every_mark_within_a_fiftieth_of_a_pixel(meter, camera):
    """Over the whole valid picture, up to the corners and the fold."""
    residuals, places = measure.reprojection(meter, camera, dither=1, spacing_px=55, antialias="coverage")
    assert len(places) >= 30
    assert np.isfinite(residuals).all()
    # Nearest to a strong barrel's fold rays change unevenly within a pixel.
    assert estimator.summary(residuals)[0] < (0.04 if camera.name == "strong barrel" else 0.02)
    assert np.abs(residuals.mean(axis=0)).max() < 0.003


@pytest.mark.parametrize("camera", LENSES, ids=lambda c: c.name)
def test_a_lens_that_mesa_resamples_puts_every_mark_within_a_twentieth_of_a_pixel(meter, camera):
    residuals, _ = measure.reprojection(meter, camera, dither=2, spacing_px=55, antialias="ssaa3")
    assert np.isfinite(residuals).all()
    assert estimator.summary(residuals)[0] < 0.05
    assert np.abs(residuals.mean(axis=0)).max() < 0.005


def test_beyond_the_fold_there_is_nothing(meter):
    camera = next(c for c in LENSES if c.name == "fold well inside")
    meter.load(white_room(meter.folder))
    cam = measure.new_camera(meter, **camera.options(), position=(0, 0, 0))
    image, depth, ids = cam.frame().image, cam.depth(), cam.instances()
    y, x = np.indices(depth.shape)
    r = np.hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy)
    edge = camera._radius(camera.fold_angle())
    beyond, within = r > edge + 2 / camera.fx, r < edge - 2 / camera.fx
    assert beyond.any() and within.any()
    assert not image[beyond].any() and np.isinf(depth[beyond]).all() and not ids[beyond].any()
    assert (image[within] == 255).all() and np.isfinite(depth[within]).all() and ids[within].all()


@pytest.mark.parametrize("name", ["fisheye 180 deg", "fisheye 220 deg, circular", "rational 120 deg"])
def test_no_seam_shows_in_a_wide_lens(meter, name):
    """Inside a room of one colour every pixel is of that colour, across all faces a wide picture is put together of."""
    camera = next(c for c in LENSES if c.name == name)
    meter.load(white_room(meter.folder))
    cam = measure.new_camera(meter, **camera.options(), position=(0, 0, 0), orientation=(0.3, -0.2, 0.4, 0.8))
    for antialias in ("none", "ssaa2"):
        cam.set(antialias=antialias)
        image, ids = cam.frame().image, cam.instances()
        assert (image[ids > 0] == 255).all(), antialias
        assert (ids > 0).mean() > 0.5


def assert_recovered(camera, matrix):
    assert abs(matrix[0, 0] / camera.fx - 1) < 5e-4 and abs(matrix[1, 1] / camera.fy - 1) < 5e-4
    assert abs(matrix[0, 2] - camera.cx) < 0.1 and abs(matrix[1, 2] - camera.cy) < 0.1


@pytest.fixture(scope="module")
def studio():
    with measure.rig_of(part_calibration.SCENE) as rig:
        yield rig


@pytest.mark.slow
@pytest.mark.parametrize("camera", part_calibration.CALIBRATED, ids=lambda c: c.name)
def test_opencv_recovers_the_lens_from_twenty_pictures_of_a_board(studio, camera):
    (rms, matrix, k), _ = measure.calibrate(studio, camera, antialias="coverage")
    assert rms < 0.05
    assert_recovered(camera, matrix)
    assert measure.curve_error(camera, matrix, k) < 0.05


@pytest.mark.slow
def test_opencv_recovers_a_pinhole_and_the_baseline_and_rotation_of_a_stereo_pair(studio):
    pair = measure.stereo(studio, PINHOLES[0], antialias="coverage")
    assert pair["rms"] < 0.05
    assert_recovered(PINHOLES[0], pair["matrix"])
    assert abs(pair["baseline"] / pair["true_baseline"] - 1) < 5e-4
    assert pair["rotation_off_deg"] < 0.002


def test_edges_are_covered_as_well_as_the_samples_allow(meter):
    errors = part_sampling.coverage(meter, timed=False)
    for mode, (rms, _, _) in errors.items():
        assert rms < part_sampling.EXPECTED_COVERAGE_RMS[mode], mode


def white_room(folder):
    """A cube of white walls seen from inside, 8 m wide."""
    glb = Glb("room")
    white = glb.material("white", base=(1, 1, 1), unlit=True, double_sided=True)
    parts = []
    for axis in range(3):
        for side in (-4.0, 4.0):
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[:, (axis + 1) % 3] = (-4, 4, 4, -4)
            corners[:, (axis + 2) % 3] = (-4, -4, 4, 4)
            parts.append(glb.primitive(corners, [(0, 1, 0)] * 4, [(0, 1, 2), (0, 2, 3)], white))
    glb.node("room", mesh=glb.mesh("room", parts))
    (folder / "room.glb").write_bytes(glb.bytes())
    scene = Scene("room", "Six white walls.", seed=1)
    scene.environment(background=(0, 0, 0), sky=(1, 1, 1), ground=(1, 1, 1))
    scene.model("room", "room.glb")
    scene.object("room", "room", "room")
    path = folder / "room.json"
    path.write_bytes(scene.text())
    return path
