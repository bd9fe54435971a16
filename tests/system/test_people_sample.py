"""The people that the scenes show are people for a detector that was trained on photographs."""

import json

import camrig
from camrig.samples import people
from camrig.samples.hog import Detector
from conftest import REPOSITORY

THRESHOLD, ENLARGE = 0.3, 1.5  # the sample's own


def test_the_stock_detector_finds_the_unoccluded_people_of_the_hall():
    with camrig.start(str(REPOSITORY / "scenes/hall.json"), mode="lockstep") as rig:
        tallies = people.score(rig, ["lobby", "entrance", "gallery"], 6, 5.0, Detector(THRESHOLD), people.Views("upright", ENLARGE))
    assert sum(tallies[name].there[("clear",)] for name in ("lobby", "entrance")) >= 8 and tallies["all"].there[("clear",)] >= 12
    # The gallery looks down steeply, as the detector's photographs do not: it counts with the others only.
    for name in ("lobby", "entrance", "all"):
        tally = tallies[name]
        assert tally.recall("clear") >= 0.7, name
        assert tally.right + tally.wrong >= 4 and tally.precision() >= 0.8, name


def test_the_sample_runs_on_a_live_rig(tmp_path, capsys):
    with camrig.start(str(REPOSITORY / "scenes/hall.json"), mode="realtime") as rig:
        socket = rig.info()["control"]
        arguments = ["--control", socket, "--cameras", "lobby", "--frames", "1", "--every", "0.2", "--view", "as-seen", "--json", "--pictures", str(tmp_path)]
        assert people.main(arguments) == 0
    assert set(json.loads(capsys.readouterr().out)) == {"lobby", "all"}
    assert (tmp_path / "lobby-000.png").stat().st_size > 10000
