"""A lens that is out of focus, beside what else it goes with: lamps on the mains under a rolling shutter, and fisheyes."""

import json

import numpy as np
import pytest

import camrig

SENSOR = {"preset": "ideal", "filter": "mono", "white_balance": 6500, "f_number": 2, "pixel_pitch_m": 1e-4}
SIZE = (320, 240)


def started(tmp_path, lamp, models, objects):
    file = tmp_path / "scene.json"
    ambient = [0, 0, 0] if lamp else [0.5, 0.5, 0.5]
    file.write_text(json.dumps({
        "camrig_scene": 1, "name": "focus", "models": models, "objects": objects,
        "environment": {"background": [0, 0, 0], "ambient": {"sky": ambient, "ground": ambient}},
        "lights": [{"name": "lamp", "type": "directional", "direction": [1, 0, 0], "intensity": 0.4, "flicker_hz": 100, "flicker_depth": 0.6}] if lamp else [],
    }))  # fmt: skip
    return camrig.start(str(file), mode="lockstep")


def light(rig, cam, **sensor):
    """Of a picture, a number of which is as much as another: the ideal sensor has no black level and is not full here."""
    cam.set(sensor={**SENSOR, "focus_m": None, **sensor})
    rig.step(seconds=0.04)
    raw = cam.frame(kind="sensor")
    assert raw.sensor["black_level"] == 0 and raw.image.max() < 2 ** raw.sensor["bits"] - 1
    return raw.image.astype(float)


def test_bands_of_a_lamp_on_the_mains_are_what_they_are_in_focus(tmp_path):
    """Boards of two greys, upright and over all of the picture: out of focus they run into each other along rows, and what a row gets of
    the lamp stays."""
    boards = [{"name": f"board{i}", "model": "white" if i % 2 else "grey", "class": "board", "position": [4, 0.3 * i, -5]} for i in range(-20, 21)]
    models = {name: {"shape": "box", "size": [0.02, 0.3, 10], "color": [grey] * 3} for name, grey in (("white", 0.9), ("grey", 0.2))}
    with started(tmp_path, True, models, boards) as rig:
        cam = rig.create_camera("rolls", size=SIZE, fps=25, vfov_deg=50, position=(0, 0, 0), pan_deg=0, tilt_deg=0)
        how = {"exposure_s": 0.002, "readout_s": 0.02, "gain_db": 12}
        sharp, soft = light(rig, cam, **how), light(rig, cam, **how, focus_m=0.3)
        columns = [picture[100:140, 60:260].mean(axis=0) for picture in (sharp, soft)]
        assert np.abs(np.diff(columns[0])).max() > 3 * np.abs(np.diff(columns[1])).max() and columns[1].std() < 0.9 * columns[0].std()
        rows = [picture[:, 40:280].mean(axis=1) for picture in (sharp, soft)]
        # Two bands of 100 Hz in 20 ms: the swing of 0.6 by the sinc of 2 ms.
        left = 0.6 * np.sinc(100 * 0.002)
        assert (rows[0].max() - rows[0].min()) / (rows[0].max() + rows[0].min()) == pytest.approx(left, abs=0.01)
        assert np.abs(rows[1] / rows[0] - 1).max() < 0.01
        # Exposures of whole periods have none.
        steady = light(rig, cam, exposure_s=0.01, readout_s=0.02, gain_db=0, focus_m=0.3)[:, 40:280].mean(axis=1)
        assert steady.std() / steady.mean() < 0.0007, "of shot noise it is 0.00044"


@pytest.mark.parametrize("angle_deg", [0, 40])
def test_a_fisheye_out_of_focus_spreads_light_and_loses_none(tmp_path, angle_deg):
    turn = np.radians(angle_deg)
    patch = {"name": "patch", "model": "patch", "class": "patch", "position": [4 * np.cos(turn), -4 * np.sin(turn), -0.25], "yaw_deg": -angle_deg}
    models = {"patch": {"shape": "box", "size": [0.02, 0.5, 0.5], "color": [0.9] * 3}}
    with started(tmp_path, False, models, [patch]) as rig:
        cam = rig.create_camera("fish", size=SIZE, fps=25, position=(0, 0, 0), pan_deg=0, tilt_deg=0, lens={"model": "equidistant", "coefficients": [0, 0, 0, 0]},
                                intrinsics={"fx": 120, "fy": 120, "cx": 159.5, "cy": 119.5}, antialias="coverage")
        sharp, soft = (light(rig, cam, exposure_s=0.005, gain_db=6, focus_m=focus) for focus in (None, 0.05))
        assert np.isfinite(soft).all() and sharp.sum() > 0
        assert soft.sum() == pytest.approx(sharp.sum(), rel=0.01)
        at = [[(picture * np.arange(n).reshape(shape)).sum() / picture.sum() for n, shape in ((240, (-1, 1)), (320, (1, -1)))] for picture in (sharp, soft)]
        assert np.abs(np.subtract(*at)).max() < 0.5, at
        assert at[0][1] == pytest.approx(159.5 + 120 * turn, abs=0.3)
        # What a disc adds to the variance along a line: a quarter of the square of its radius (docs/sensor.md has its diameter).
        across = [(picture * (np.arange(320) - x) ** 2).sum() / picture.sum() for picture, (_, x) in zip((sharp, soft), at, strict=True)]
        image_m, focus_m = 120 * SENSOR["pixel_pitch_m"], 0.05
        disc_px = (1 / focus_m - 1 / 4) * 120 / (1 / image_m + 1 / focus_m) / SENSOR["f_number"]
        assert disc_px > 11 and across[1] - across[0] == pytest.approx(disc_px**2 / 16, rel=0.03)
        depth = cam.depth()
        assert np.isfinite(depth[round(at[0][0]), round(at[0][1])]), "depth is of the sharp picture"
