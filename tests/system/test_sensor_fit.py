"""`camrig sensor fit` finds the figures that our own sensor took pictures with."""

import json
import os
import subprocess

import cv2
import numpy as np
import pytest

SKY = {"position": [0, 0, 50], "look_at": [0, 0.001, 100]}  # nothing but the background: the same light everywhere


def fit(*arguments):
    return subprocess.run([os.environ["CAMRIG_BIN"], "sensor", "fit", *map(str, arguments)], capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("preset, dark_s", [("imx249", 1e-6), ("imx477", 1e-6)])
def test_full_well_read_noise_and_black_level_come_out_as_put_in(rig, tmp_path, preset, dark_s):
    sensor = {"preset": preset, "row_noise_e": 0, "hot_pixels_ppm": 0, "dark_e_per_s": 0}
    cam = rig.create_camera("bench", size=(1280, 720), fps=25, **SKY, sensor={**sensor, "exposure_s": 0.001})
    rig.step(seconds=0.04)
    first = cam.frame(kind="sensor")
    black, top = first.sensor["black_level"], 2 ** first.sensor["bits"] - 1
    longest_s = 0.85 * (top - black) / (first.image.max() - black) * 0.001
    files = []
    for n, exposure_s in enumerate([dark_s, *np.linspace(longest_s / 8, longest_s, 8)]):
        cam.set(sensor={**sensor, "exposure_s": exposure_s})
        pair = []
        for _ in range(2):
            rig.step(seconds=0.04)
            pair.append(cam.frame(kind="sensor").image)
        if n % 2:
            files.append(tmp_path / f"{n}.npy")
            np.save(files[-1], np.stack(pair))
        else:
            for side, image in enumerate(pair):
                files.append(tmp_path / f"{n}-{side}.png")
                cv2.imwrite(str(files[-1]), image)
    done = fit(*files, "--bits", first.sensor["bits"])
    assert done.returncode == 0, done.stderr
    found, asked = json.loads(done.stdout), cam.get()["sensor"]
    assert found["full_well_e"] == pytest.approx(asked["full_well_e"], rel=0.01)
    assert found["read_noise_e"] == pytest.approx(asked["read_noise_e"], rel=0.03)
    assert found["black_level"] == pytest.approx(black, abs=0.1) and found["bits"] == asked["bits"]
    assert cam.set(sensor={**sensor, **found})["sensor"]["full_well_e"] == found["full_well_e"]  # as it is

    too_few = fit(*files[:3], "--bits", first.sensor["bits"])
    assert too_few.returncode != 0 and "two dark ones" in too_few.stderr
    narrow = fit(*files, "--bits", 8)
    assert narrow.returncode != 0 and "more than 8 bits hold" in narrow.stderr
    white = tmp_path / "white.npy"
    np.save(white, np.full((2, 720, 1280), top, np.uint16))
    saturated = fit(*files, white, "--bits", first.sensor["bits"])
    assert saturated.returncode != 0 and "white.npy" in saturated.stderr and "is saturated" in saturated.stderr
