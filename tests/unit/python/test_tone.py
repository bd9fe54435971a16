"""The tone curve of quality `beautiful` by daylight, and its inverse."""

import numpy as np

from camrig import tone


def test_it_has_the_values_that_its_definition_gives() -> None:
    grey = np.array([0.0, 0.04, 0.08, 0.5, 0.8, 1.0, 4.0])
    shown = tone.pbr_neutral(np.repeat(grey[:, None], 3, axis=1))
    # x^2 / 0.16 up to 0.08, less 0.04 up to 0.8, then 1 - 0.24^2 / (x - 0.04 + 0.24 - 0.76).
    expected = [0.0, 0.01, 0.04, 0.46, 0.76, 1 - 0.0576 / 0.44, 1 - 0.0576 / 3.44]
    np.testing.assert_allclose(shown, np.repeat(np.array(expected)[:, None], 3, axis=1), atol=1e-12)


def test_bright_colours_fade_and_none_is_over_1() -> None:
    shown = tone.pbr_neutral([[20.0, 1.0, 0.5]])[0]
    assert shown.max() < 1
    assert shown[1] / shown[0] > 0.5


def test_the_inverse_gives_light_back() -> None:
    light = np.random.default_rng(1).uniform(0, 1, (10000, 3)) ** 3 * 8
    shown = tone.pbr_neutral(light)
    inside = shown.max(axis=-1) < 0.998
    np.testing.assert_allclose(tone.inverse_pbr_neutral(shown)[inside], light[inside], rtol=1e-7, atol=1e-6)  # the dark end is a square root


def test_codes_give_light_back_as_exactly_as_they_hold_it() -> None:
    light = np.linspace(0.05, 1.2, 200)[:, None] * np.array([1.0, 0.8, 0.6])
    linear = tone.pbr_neutral(light)
    codes = np.rint(255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
    assert abs(tone.light_of(codes) - light).max() < 0.03
