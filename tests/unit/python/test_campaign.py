"""What a campaign's file may say, and how its program is run; campaigns that run are in tests/system/test_campaigns.py."""

from types import SimpleNamespace

import pytest

import camrig
from camrig.campaign import load, runner


@pytest.mark.parametrize(
    "params, said",
    [
        ({"seed": 3}, "faults[1].params.seed: is none of the kind's own parameters: each cell's follows from the campaign's seed"),
        ({"severity": 0.5}, "faults[1].params.severity: .* severity, or a list of severities, stands beside params"),
        ({"end_s": 4}, "faults[1].params.end_s: .* hold_s of the campaign"),
        ({"start_s": 4}, "faults[1].params.start_s"),
        ({"camera": "lobby"}, "faults[1].params.camera: .* the campaign's"),
        ({"kind": "black"}, "faults[1].params.kind: .* beside params"),
    ],
)
def test_what_a_campaign_says_of_all_its_faults_is_no_parameter_of_one(params, said):
    with pytest.raises(camrig.CamrigError, match=said.replace("[", r"\[").replace("]", r"\]")) as caught:
        load({"faults": [{"kind": "freeze"}, {"kind": "drop", "params": {"burst_frames": 8, **params}}]})
    assert caught.value.kind == "invalid_argument"


def test_a_setting_is_of_the_camera_whatever_its_name():
    (row,) = load({"faults": [{"kind": "settings", "params": {"seed": 3}}]}).rows
    assert row.params == {"seed": 3}


def test_devices_are_seen_through_the_program_that_runs_the_rig():
    campaign = load({"faults": [{"kind": "freeze"}], "program": ["look", "{device}"]})
    places = {"device": "/dev/video180", "control": "/run/c.sock"}
    assert runner._program_words(SimpleNamespace(program="/opt/camrig"), campaign, places) == ["/opt/camrig", "--control", "/run/c.sock", "exec", "--", "look", "/dev/video180"]
