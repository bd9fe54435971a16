"""The books of the speed bench: what a reader did not get must have been counted by somebody."""

from tools.bench.speed.meter import Reading, Use
from tools.bench.speed.readers import Stream
from tools.bench.speed.runs import Realtime


def realtime(gaps, *, dropped=0, dropped_by_readers=0):
    reading = Reading(wall_s=10.0, cpu_s=1.0, use=Use(1.0, 1.0, 1, 1), rendered=0, dropped=dropped, dropped_by_readers=dropped_by_readers,
                      instants=0, stages={}, renderer={}, sequences={})
    return Realtime(reading, [Stream(f"c{n}", gaps=count) for n, count in enumerate(gaps)], fps=25)


def test_gaps_that_nobody_counted_as_dropped_are_unreported():
    assert realtime([3], dropped=1).unreported == 2
    assert realtime([3, 4], dropped=1, dropped_by_readers=6).unreported == 0


def test_drops_of_frames_that_came_are_not_hidden():
    assert realtime([0], dropped=2).unreported == -2


def test_gaps_are_of_the_frames_between_two_moments_and_not_of_those_before_and_after():
    stream = Stream("c", pictures=6, sequences=[7, 11, 12, 15, 19, 22], latencies_ms=[1, 2, 3, 4, 5])
    stream.close_books(after=10, until=20)
    assert (stream.gaps, stream.pictures, stream.latencies_ms) == (6, 4, [1, 2, 3, 4])


def test_the_share_of_dropped_frames_is_of_those_due_by_the_clock():
    assert realtime([5, 0], dropped=5).dropped_share == 5 / (2 * 25 * 10)
