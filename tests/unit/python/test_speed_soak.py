"""What a soak may say: growth is ruled out, shown, or neither."""

import pytest

from tools.bench.speed.soak import line, verdict


@pytest.mark.parametrize(("slope", "error", "said"), [
    (0.2, 0.3, "yes"),
    (-12.2, 15.81, "**undecided**: run longer"),
    (1.5, 0.4, "**undecided**: run longer"),
    (2.5, 0.4, "**missed**"),
])
def test_noise_is_not_taken_for_standing_still(slope, error, said):
    assert verdict(slope, error, 1.0) == said


def test_a_count_that_stands_still_is_met_without_any_allowance():
    assert verdict(*line([(20.0 * n, 17.0) for n in range(10)]), 0.0) == "yes"


def test_a_few_points_decide_nothing():
    assert verdict(*line([(0.0, 360.0), (20.0, 360.0)]), 1.0) == "**undecided**: run longer"


def test_a_line_has_its_slope_an_hour():
    slope, error = line([(t, 100 + 2 * t / 3600) for t in (0.0, 60.0, 120.0, 180.0)])
    assert slope == pytest.approx(2.0)
    assert error == pytest.approx(0.0, abs=1e-6)
