"""The model of large farms: where its answers are known without it."""

import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))
from tools.bench.farm_model import DAY_S, Measured, Network, batch, log, moves  # noqa: E402

STEADY = Network("steady", 0.01, 0, loss=0)


def test_nobody_is_held_when_the_lead_covers_the_way_and_all_are_when_not():
    # A watermark closes steps that begin its lead less one interval and one step later, at the least.
    assert log(10, STEADY, 0.06, 20).holds == 0
    held = log(10, STEADY, 0.02, 20)
    assert held.holds > 0.9 * 10 * 20 / 0.02 and held.share > 0.1


def test_a_slow_store_holds_nodes_as_a_slow_network_does():
    slow = Measured(ack_p50=0.1, ack_p99=0.2)
    assert log(5, STEADY, 0.1, 20, slow).holds > 10 * log(5, STEADY, 0.4, 20, slow).holds


def test_cameras_are_back_after_lease_lead_and_first_frame():
    times, share = moves(200, 8, 0, 0.1, 50)
    assert 200 * 50 * 24 / 1000 == pytest.approx(len(times), rel=0.2)
    assert 2.0 - 0.5 + 0.1 <= min(times) and max(times) <= 2.0 + 0.1 + 0.1
    assert share == pytest.approx(sum(times) / (200 * 50 * DAY_S))


def test_without_deaths_a_batch_loses_the_cost_of_shards_and_its_end():
    quiet = batch(4, 400, 60, mtbf_h=1e9)
    assert quiet.lost_shards == 0 and 0.95 * 60 / 60.9 < quiet.efficiency < 60 / 60.9
    # One that hands out for 0.3 s each is what 100 nodes with shards of 10 s wait for.
    bound = batch(100, 1000, 10, Measured(hand_out=0.3), mtbf_h=1e9)
    assert bound.seconds > 1000 * 0.3


def test_a_batch_is_whole_whoever_dies():
    deadly = batch(4, 100, 60, mtbf_h=0.1)
    assert deadly.lost_shards > 5 and deadly.useful == pytest.approx(batch(4, 100, 60, mtbf_h=1e9).useful)
    assert deadly.efficiency < 0.9
