"""Shadows, through lenses too: how far their edges are from where light and geometry put them.

How: tools/bench/accuracy/shadows.py, with OpenCV's projection; figures: docs/accuracy.md.
"""

import sys

import numpy as np
import pytest

from conftest import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "tools" / "bench"))
from accuracy import measure, shadow_scene, shadows  # noqa: E402
from accuracy.lenses import LENSES, PINHOLES  # noqa: E402

CAMERAS = [PINHOLES[0]] + [c for c in LENSES if c.name in ("barrel and tangential", "rational, wide", "fisheye 180 deg")]
GROUND = shadow_scene.Ground(30.0)


@pytest.fixture(scope="module")
def meter():
    with measure.rig_of() as rig:
        yield rig


def measured(meter, camera, light, **options):
    """Two samples a pixel each way, or three: a texel is never less than a sample."""
    return shadows.measured(meter, camera, shadows.over_ground(camera), GROUND, light, fine=2 if camera.fx > 300 else 3, **options)


def assert_edges_are_right(edges):
    assert edges.missing == 0 and len(edges.error_m) >= 60
    # An outline in a map is one of whole texels: half of one, where it lies along them.
    assert np.abs(edges.error_texels).max() < 0.65
    assert abs(edges.error_texels.mean()) < 0.12
    assert edges.width_m.max() < 5 * (edges.texel_m * edges.stretch).max()


@pytest.mark.parametrize("light", shadow_scene.LIGHTS, ids=lambda light: light.name)
@pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: c.name)
def test_the_edge_of_a_shadow_is_where_geometry_puts_it_within_parts_of_a_texel(meter, camera, light):
    assert_edges_are_right(measured(meter, camera, light))


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: c.name)
def test_the_edge_of_a_movers_shadow_is_where_that_of_a_thing_is(meter, camera):
    edges = measured(meter, camera, shadow_scene.SUN, boxes="standing")
    assert_edges_are_right(edges)
