"""A picture takes time: when, by stamps and truth, and where things are in it, by ids, boxes and keypoints."""

import json

import numpy as np
import pytest

import camrig

STAND = {"position": [-6, 0, 2.5]}
QUIET = {"preset": "ideal", "white_balance": 6500}


def box_of(ids, number):
    y, x = np.nonzero(ids == number)
    return [x.min(), y.min(), x.max() - x.min() + 1, y.max() - y.min() + 1]


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_stamps_are_the_start_of_the_exposure_and_truth_tells_every_row(rig):
    cam = rig.create_camera("rolls", size=(320, 240), fps=25, place="main", sensor={**QUIET, "exposure_s": 0.005, "readout_s": 0.024})
    plain = rig.create_camera("plain", size=(320, 240), fps=25, place="main")
    rig.step(seconds=0.4)
    frame, truth = cam.frame(), cam.truth()
    row_ns = 24_000_000 // 240
    assert truth["row_ns"] == row_ns and truth["exposure_end_ns"] == truth["time_ns"] == frame.time_ns == plain.frame().time_ns
    assert truth["exposure_start_ns"] == truth["time_ns"] - 5_000_000 - 239 * row_ns
    assert truth["stamp_ns"] == frame.stamp_ns == truth["exposure_start_ns"]
    assert frame.steady_ns == frame.monotonic_ns - (frame.time_ns - frame.stamp_ns)
    assert frame.sensor["exposure_start_ns"] == truth["exposure_start_ns"]
    # What moves is where it was when the row in the middle counted.
    middle_ns = truth["exposure_start_ns"] + 120 * row_ns + 2_500_000
    now = plain.truth()
    assert now["exposure_start_ns"] is now["exposure_end_ns"] is now["row_ns"] is None
    place = {one["name"]: one for one in truth["objects"]}["mover"]
    later = {one["name"]: one for one in now["objects"]}["mover"]
    gone = np.subtract(later["position"], place["position"])
    assert np.allclose(gone, np.multiply(later["velocity"], (now["time_ns"] - middle_ns) * 1e-9), atol=1e-3)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("lens", [None, {"model": "plumb_bob", "coefficients": [-0.1, 0.02, 0, 0, 0]}], ids=["pinhole", "lens"])
def test_truth_of_a_panning_rolling_shutter_is_where_the_picture_shows_it(rig, lens):
    """300 deg/s: the box leans by some 25 pixels."""
    made = {"lens": lens} if lens else {}
    cam = rig.create_camera("rolls", size=(640, 480), fps=25, vfov_deg=50, **STAND, pan_deg=-30, tilt_deg=-20, **made, sensor={**QUIET, "exposure_s": 0.0002, "gain_db": 30, "readout_s": 0.02})
    rig.step(seconds=0.2)
    cam.set(**STAND, pan_deg=30, tilt_deg=-20, seconds=0.2)
    leans = []
    for _ in range(5):
        rig.step(seconds=0.04)
        ids, truth, picture = cam.instances(), cam.truth(), cam.frame().image.astype(int)
        for one in truth["objects"]:
            if one["name"] != "box" or one["truncated"] > 0 or one["occluded_by"] is not None:
                continue
            seen = box_of(ids, one["id"])
            assert one["box"] == seen and one["visible_fraction"] == 1
            low, high = np.array(one["box_full"][:2]), np.array(one["box_full"][:2]) + one["box_full"][2:]
            assert np.abs(low + 0.5 - seen[:2]).max() < 1.5 and np.abs(high + 0.5 - np.add(seen[:2], seen[2:])).max() < 1.5
            # The picture has its red there too.
            red = (picture[:, :, 2] > 1.6 * picture[:, :, 0]) & (picture[:, :, 2] > 40)
            assert (red & (ids == one["id"])).sum() > 0.97 * red.sum() > 0
            leans.append(one["box_full"][2])
    cam.set(**STAND, pan_deg=0, tilt_deg=-20)
    rig.step(seconds=0.4)
    still = {one["name"]: one for one in cam.truth()["objects"]}["box"]["box_full"][2]
    assert leans and max(abs(one - still) for one in leans) > 8


def test_the_same_commands_give_the_same_blurred_pictures(scenes):
    def run():
        read = []
        with camrig.start(str(scenes / "minimal.json"), mode="lockstep") as rig:
            cam = rig.create_camera("rolls", size=(160, 120), fps=25, place="main", sensor={"preset": "imx219", "exposure_s": "auto"})
            for _ in range(8):
                cam.set(**STAND, pan_deg=10, tilt_deg=-20, seconds=0.3)
                rig.step(seconds=0.12)
                read.append((cam.frame(format="png").image.tobytes(), cam.instances().tobytes(), json.dumps(cam.truth()["objects"])))
        return read

    assert run() == run()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_blur_can_be_had_without_and_lasts_as_long_as_the_exposure(rig):
    """A pan past the box: its upright edges are as wide as the pan goes in an exposure."""
    def edges(**sensor):
        cam = rig.create_camera("pans", size=(640, 480), fps=25, vfov_deg=50, **STAND, pan_deg=-12, tilt_deg=-20, sensor={**QUIET, **sensor})
        rig.step(seconds=0.04)
        cam.set(**STAND, pan_deg=12, tilt_deg=-20, seconds=0.4)
        rig.step(seconds=0.2)
        image = cam.frame(format="png").image.astype(float)
        cam.delete()
        return np.abs(np.diff(image[:, :, 2], axis=1)).max()

    sharp, blurred, off = edges(exposure_s=1e-4), edges(exposure_s=0.01), edges(exposure_s=0.01, blur=False)
    assert blurred < 0.5 * min(sharp * 4, off), (sharp, blurred, off)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_what_cannot_be_is_said(rig):
    cam = rig.create_camera("rolls", size=(160, 120))
    for sensor, words in (
        ({"readout_s": 0.3}, "sensor.readout_s: must be 0 to 0.2 s"),
        ({"readout_s": -1}, "sensor.readout_s: must be 0 to 0.2 s"),
        ({"blur": 3}, "sensor.blur"),
    ):
        with pytest.raises(camrig.CamrigError) as refused:
            cam.set(sensor=sensor)
        assert words in str(refused.value), refused.value
    cam.set(sensor={"exposure_s": 10, "readout_s": 0.2}, **STAND, pan_deg=40, tilt_deg=-20, seconds=1)
    rig.step(seconds=0.5)
    assert cam.frame().image.shape == (120, 160, 3) and cam.truth()["exposure_start_ns"] < 0
