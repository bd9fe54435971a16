"""Things that are compared are measured in turns, and the page says how far the turns are apart."""

from tools.bench.speed import programs
from tools.bench.speed.programs import ToMemory, Values, in_turns


def test_values_are_printed_as_their_median_with_the_lowest_and_the_highest():
    assert f"{Values([161.2, 104.6, 150.1]):.0f}" == "150 (105..161)"
    assert f"{Values([2.0, 1.0]):.1f}" == "1.5 (1.0..2.0)"


def test_what_is_compared_takes_its_turn_one_after_the_other_for_the_same_time(monkeypatch):
    log, speed = [], {4: 100.0, 12: 300.0}

    def draw(program, what, frames):
        log.append((what.cameras, frames))
        return speed[what.cameras], 10.0

    monkeypatch.setattr(programs, "built", lambda name: "render_scene")
    monkeypatch.setattr(programs, "_draw", draw)
    drawn = in_turns({"few": ToMemory(4), "many": ToMemory(12)}, 2.0, lambda turn: log.append(f"turn {turn}"))
    assert log[2:] == [entry for turn in range(programs.TURNS) for entry in (f"turn {turn}", (4, 50), (12, 50))]
    assert drawn["few"].per_second.values == [100.0] * programs.TURNS


def test_without_the_renderer_what_is_beside_it_is_measured_all_the_same(monkeypatch):
    turns = []
    monkeypatch.setattr(programs, "built", lambda name: None)
    assert in_turns({"few": ToMemory(4)}, 2.0, turns.append) is None
    assert turns == list(range(programs.TURNS))
