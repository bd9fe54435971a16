"""Where the package says that a camera sees a point, against OpenCV."""

import cv2
import numpy as np
import pytest

from camrig import Projection

LENSES = {
    "pinhole": ("pinhole", []),
    "barrel": ("plumb_bob", [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.0]),
    "tangential": ("plumb_bob", [0.0, 0.0, 6e-3, -9e-3, 0.0]),
    "rational": ("rational_polynomial", [0.9, 0.12, 3e-4, -2e-4, 0.004, 1.25, 0.35, 0.03]),
    "fisheye": ("equidistant", [0.02, -0.01, 0.003, -0.0005]),
}


def camera(lens, position=(2.0, 3.0, 2.8), orientation=(0.1, -0.2, 0.3, 0.9)):
    """As camera.get answers."""
    orientation = np.array(orientation) / np.linalg.norm(orientation)
    return {
        "intrinsics": {"fx": 420.0, "fy": 431.0, "cx": 305.2, "cy": 251.8},
        "lens": {"model": lens[0], "coefficients": lens[1]},
        "pose": {"position": list(position), "orientation": orientation.tolist()},
    }


def by_opencv(view, points):
    camera_from_world = np.linalg.inv(view.world_from_camera)
    rvec, tvec = cv2.Rodrigues(camera_from_world[:3, :3])[0], camera_from_world[:3, 3]
    if view.model == "equidistant":
        return cv2.fisheye.projectPoints(points[:, None], rvec, tvec, view.K, view.distortion)[0][:, 0]
    return cv2.projectPoints(points[:, None], rvec, tvec, view.K, view.distortion)[0][:, 0]


@pytest.mark.parametrize("name", LENSES)
def test_pixels_are_those_of_opencv_through_every_lens(name):
    view = Projection.of(camera(LENSES[name]))
    rng = np.random.default_rng(1)
    spread = 0.6
    seen = np.c_[rng.uniform(-spread, spread, (500, 2)), np.ones(500)] * rng.uniform(0.5, 20, (500, 1))
    world = seen @ view.world_from_camera[:3, :3].T + view.world_from_camera[:3, 3]
    pixels = view.project(world)
    assert pixels.shape == (500, 2) and pixels.dtype == np.float64
    np.testing.assert_allclose(pixels, by_opencv(view, world), atol=1e-9)


def test_the_camera_looks_along_the_z_of_its_optical_frame():
    view = Projection.of(camera(LENSES["pinhole"], position=(1, 2, 3), orientation=(0, 0, 0, 1)))  # its body looks along the world's x
    np.testing.assert_allclose(view.world_from_camera @ [0, 0, 5, 1], [6, 2, 3, 1])
    np.testing.assert_allclose(view.world_from_camera @ [1, 0, 0, 1], [1, 1, 3, 1])
    np.testing.assert_allclose(view.project([6, 2, 3]), [[305.2, 251.8]])
    assert view.K.dtype == view.distortion.dtype == view.world_from_camera.dtype == np.float64


@pytest.mark.parametrize("name", LENSES)
def test_what_is_behind_or_at_the_camera_has_no_pixel(name):
    view = Projection.of(camera(LENSES[name], position=(0, 0, 0), orientation=(0, 0, 0, 1)))
    pixels = view.project([[1, 0, 0], [-1, 0, 0], [0, 0, 0], [np.nan, 0, 0]])
    assert np.isfinite(pixels[0]).all() and np.isnan(pixels[1:]).all()
    sideways = view.project([[0, 1, 0], [-0.2, 1, 0]])
    assert np.isfinite(sideways).all() == (name == "fisheye")


@pytest.mark.parametrize(
    ("lens", "fold_deg"),
    [
        (("plumb_bob", [-0.3, 0.0, 0.0, 0.0, 0.0]), np.degrees(np.arctan(np.sqrt(1 / 0.9)))),  # 1 - 3 * 0.3 r^2 = 0
        (("equidistant", [-0.1, 0.0, 0.0, 0.0]), np.degrees(np.sqrt(1 / 0.3))),
        (("rational_polynomial", [0.0] * 5 + [-0.25, 0.0, 0.0]), np.degrees(np.arctan(2 * (1 - 1e-4)))),  # its pole
    ],
)
def test_beyond_the_fold_of_a_lens_there_is_no_pixel(lens, fold_deg):
    view = Projection.of(camera(lens, position=(0, 0, 0), orientation=(0, 0, 0, 1)))
    angles = np.radians([fold_deg - 1e-3, fold_deg + 1e-3, fold_deg + 5])
    pixels = view.project(np.stack([np.cos(angles), -np.sin(angles), np.zeros(3)], axis=1))
    assert np.isfinite(pixels[0]).all() and np.isnan(pixels[1:]).all()


def test_no_two_directions_share_a_pixel_with_tangential_terms():
    view = Projection.of(camera(("plumb_bob", [-0.30, 0.0, 4e-3, 3e-3, 0.0]), position=(0, 0, 0), orientation=(0, 0, 0, 1)))
    step, grid = 1e-6, np.stack(np.meshgrid(np.linspace(-3, 3, 121), np.linspace(-3, 3, 121)), axis=-1).reshape(-1, 2)

    def pixels(x, y):
        return view.project(np.stack([np.ones(len(x)), -x, -y], axis=1))

    at, right, down = pixels(*grid.T), pixels(grid[:, 0] + step, grid[:, 1]), pixels(grid[:, 0], grid[:, 1] + step)
    known = np.isfinite(at + right + down).all(axis=1)
    jacobian = np.stack([right - at, down - at], axis=-1)[known] / step
    assert 500 < known.sum() < len(grid) and np.linalg.det(jacobian).min() > 0
