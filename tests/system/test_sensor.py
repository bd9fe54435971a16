"""Cameras with a sensor: what a laboratory measures on their delivered pictures is what was asked for (EMVA 1288)."""

import numpy as np
import pytest

import camrig

SKY = {"position": [0, 0, 50], "look_at": [0, 0.001, 100]}  # nothing but the background: the same light everywhere
QUIET = {"vignetting": 0, "prnu": 0, "dsnu_e": 0, "row_noise_e": 0, "hot_pixels_ppm": 0, "dark_e_per_s": 0}


def numbers(rig, cam, sensor):
    """The photosites under green in two pictures that follow each other, and what they were taken with."""
    cam.set(sensor=sensor)
    pictures = []
    for _ in range(2):
        rig.step(seconds=0.04)
        pictures.append(cam.frame(kind="sensor"))
    assert pictures[0].sequence < pictures[1].sequence and pictures[1].image.dtype == np.uint16
    return [picture.image[0::2, 1::2].astype(float) for picture in pictures], pictures[1].sensor


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_photon_transfer_finds_gain_read_noise_full_well_and_a_straight_line(rig):
    well_e, read_e = 4866.0, 2.5  # of imx219
    cam = rig.create_camera("bench", size=(1280, 720), fps=25, **SKY, sensor={"preset": "imx219"})
    base = {"preset": "imx219", **QUIET}
    # How much light the sky is: from one picture, so that the steps reach from dark to nine tenths of the well.
    (first, _), reading = numbers(rig, cam, {**base, "exposure_s": 0.001})
    black, top = reading["black_level"], 2 ** reading["bits"] - 1
    longest_s = 0.9 * (top - black) / (first.mean() - black) * 0.001
    exposures = np.linspace(longest_s / 16, longest_s, 16)
    means, variances = [], []
    for exposure_s in exposures:
        (a, b), reading = numbers(rig, cam, {**base, "exposure_s": exposure_s})
        assert reading["exposure_s"] == pytest.approx(exposure_s) and reading["gain_db"] == 0
        means.append((a.mean() + b.mean()) / 2 - black)
        variances.append((a - b).var() / 2 - 1 / 12)  # of what the converter rounds away
    gain, _ = np.polyfit(means, variances, 1)
    asked = (top - black) / well_e
    assert gain == pytest.approx(asked, rel=0.01) and 1 / reading["electrons_per_number"] == pytest.approx(asked)
    slope, offset = np.polyfit(exposures, means, 1)
    assert np.abs(np.polyval((slope, offset), exposures) - means).max() < 0.002 * (top - black)

    # Full wells, read with noise by a converter that ends there.
    (a, b), _ = numbers(rig, cam, {**base, "exposure_s": 4 * longest_s})
    assert top - 1 < a.mean() <= a.max() == top and (a.mean() - black) / gain == pytest.approx(well_e, rel=0.01)
    # In the dark, at 10 times the numbers an electron: what the converter rounds is small against it.
    (a, b), reading = numbers(rig, cam, {**base, "exposure_s": 1e-6, "gain_db": 20})
    assert np.sqrt((a - b).var() / 2 - 1 / 12) * reading["electrons_per_number"] == pytest.approx(read_e, rel=0.03)
    for along in ((a[:, 1:], a[:, :-1]), (a[1:], a[:-1]), (a, b)):
        assert abs(np.corrcoef(along[0].ravel(), along[1].ravel())[0, 1]) < 0.01


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("share", [1, 0.5])
def test_light_falls_off_to_the_corners_by_cos4_of_the_angle(rig, share):
    """Of an evenly lit scene, with all noise: means over 12 pictures and 16x16 photosites. `vignetting` is the share of the natural falloff."""
    sensor = {"preset": "imx249", "exposure_s": 0.004, "white_balance": 6500, "hot_pixels_ppm": 0, "vignetting": share}
    cam = rig.create_camera("wide", size=(1280, 960), fps=25, **SKY, vfov_deg=70, sensor=sensor)
    mean = np.zeros((960, 1280))
    for _ in range(12):
        rig.step(seconds=0.04)
        raw = cam.frame(kind="sensor")
        mean += (raw.image - raw.sensor["black_level"]) / 12
    assert raw.image.max() < 2 ** raw.sensor["bits"] - 1
    x, y = np.meshgrid((np.arange(1280) - cam.K[0, 2]) / cam.K[0, 0], (np.arange(960) - cam.K[1, 2]) / cam.K[1, 1])
    falloff = np.cos(np.arctan(np.hypot(x, y))) ** 4 if share == 1 else 1 / (1 + share * (x**2 + y**2)) ** 2
    seen, asked = (values.reshape(60, 16, 80, 16).mean(axis=(1, 3)) for values in (mean, falloff))
    seen /= seen[29:31, 39:41].mean() / asked[29:31, 39:41].mean()
    assert asked.min() < (0.35 if share == 1 else 0.6) and np.abs(seen / asked - 1).max() < 0.005


def run(scene, pictures):
    """Of a rig of its own, all that is read of two cameras; the second has no sensor."""
    read = []
    with camrig.start(str(scene), mode="lockstep") as rig:
        cam = rig.create_camera("counts", size=(160, 120), fps=25, place="desk", sensor={"preset": "imx290", "exposure_s": "auto", "lux": 40, "seed": 7})
        plain = rig.create_camera("plain", size=(160, 120), fps=25, place="desk")
        for _ in range(pictures):
            rig.step(seconds=0.04)
            picture = cam.frame(format="png")
            read.append((picture.image.tobytes(), picture.sensor, cam.frame(kind="sensor").image.tobytes(), plain.frame().image.tobytes()))
            assert plain.frame().sensor is None
            truth = cam.truth()
            assert truth["sensor"] == picture.sensor and truth["sequence"] == picture.sequence
    return read


def test_the_same_commands_give_the_same_numbers_and_exposure_settles(scenes):
    first, again = (run(scenes / "hall.json", 40) for _ in range(2))
    assert first == again
    readings = [sensor for _, sensor, _, _ in first]
    assert len({picture for picture, *_ in first}) == len(first)  # noise of its own in each
    assert not readings[0]["settled"] and readings[-1]["settled"]
    assert readings[-1]["exposure_s"] != readings[0]["exposure_s"] and readings[-1]["metered"] > 0.02


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_what_cannot_be_is_said_with_its_unit(rig):
    cam = rig.create_camera("counts", size=(160, 120))
    for sensor, words in (
        ({"preset": "imx9"}, "sensor.preset"),
        ({"exposure_s": 0}, "sensor.exposure_s: must be 1e-6 to 10 s"),
        ({"exposure_s": 11}, "sensor.exposure_s: must be 1e-6 to 10 s"),
        ({"exposure_s": "manual"}, "sensor.exposure_s"),
        ({"full_well_e": 1e7}, "sensor.full_well_e: must be 100 to 1e6 e"),
        ({"full_well_e": 0}, "sensor.full_well_e: must be 100 to 1e6 e"),
        ({"read_noise_e": -1}, "sensor.read_noise_e: must be 0 to 1000 e"),
        ({"read_noise_e": 1e6}, "sensor.read_noise_e: must be 0 to 1000 e"),
        ({"gain_db": 60}, "sensor.gain_db: must be 0 to 48 dB"),
        ({"focus_m": 0}, "sensor.focus_m: must be 0.01 to 1e6 m"),
        ({"least_highlights": 2}, "sensor.least_highlights: must be 0 to 1"),
        ({"bits": 7}, "sensor.bits: must be 8 to 16"),
        ({"bits": 8, "black_level": 65}, "sensor.black_level: must be at most 64"),
        ({"shutter": 1}, "sensor.shutter: unknown key"),
    ):
        with pytest.raises(camrig.CamrigError) as refused:
            cam.set(sensor=sensor)
        assert words in str(refused.value), refused.value
    with pytest.raises(camrig.CamrigError, match="has no sensor"):
        cam.frame(kind="sensor")
    assert cam.get()["sensor"] is None


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("sensor", [
    {"exposure_s": 1e-6, "full_well_e": 1e6, "lux": 1e-4},
    {"exposure_s": 10, "full_well_e": 100, "lux": 1e6},
    {"exposure_s": 10, "read_noise_e": 1000, "dark_e_per_s": 1e5, "hot_pixels_ppm": 1e4, "hot_e_per_s": 1e6, "bits": 8},
    {"filter": "mono", "quantum_efficiency": 0, "lux": 1},
    {"exposure_s": 10, "full_well_e": 1e6, "read_noise_e": 0, "gain_db": 48},
    {"exposure_s": 1e-6, "full_well_e": 100, "read_noise_e": 0, "bits": 16, "gain_db": 48},
    {"exposure_s": 10, "full_well_e": 1e6, "lux": 1e-4, "read_noise_e": 0, "preset": "imx219", "readout_s": 0.2, "vignetting": 4},
], ids=["dark", "bright", "noisy", "blind", "long", "short", "faint"])
def test_the_ends_of_the_ranges_give_defined_pictures(rig, sensor):
    cam = rig.create_camera("counts", size=(162, 122), position=[-6, 0, 2.5], look_at=[0, 0, 0.5], sensor=sensor)
    rig.step(seconds=0.2)
    raw, picture = cam.frame(kind="sensor"), cam.frame()
    bits = picture.sensor["bits"]
    assert raw.image.max() < 2 ** bits and raw.image.shape[:2] == picture.image.shape[:2] == (122, 162)
    if sensor.get("gain_db") == 48 and sensor["full_well_e"] == 100:
        assert set(np.unique(raw.image)) == {0, 2**16 - 1} and raw.image.mean() < 1000, "an electron is more than the converter has numbers"
    elif "lux" in sensor and sensor.get("readout_s"):
        assert 0 <= raw.image.mean() - picture.sensor["black_level"] < 40 and raw.image.std() < 40
    elif sensor.get("exposure_s") == 1e-6 or sensor.get("quantum_efficiency") == 0:
        assert abs(raw.image.mean() - picture.sensor["black_level"]) < 1 and picture.image.max() <= 1
    elif sensor.get("read_noise_e", 0) == 0:
        assert (raw.image == 2 ** bits - 1).mean() > 0.9


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_lens_a_code_strip_and_outputs_go_with_a_sensor(rig):
    pose = {"position": [-6, 0, 2.5], "look_at": [0, 0, 0.5]}
    lens = {"model": "equidistant", "coefficients": [0.0, 0.0, 0.0, 0.0]}
    cam = rig.create_camera("fish", size=(320, 240), fps=25, **pose, lens=lens, code_strip=True, sensor={"preset": "webcam", "white_balance": 6500})
    plain = rig.create_camera("eye", size=(320, 240), fps=25, **pose, lens=lens, code_strip=True)
    rig.step(seconds=0.2)
    seen, exact = cam.frame(), plain.frame()
    assert camrig.read_code(seen.image).sequence == seen.sequence
    # The red box is where it is without a sensor.
    places = []
    for image in (seen.image.astype(int), exact.image.astype(int)):
        y, x = np.nonzero((image[40:, :, 2] > 1.6 * image[40:, :, 0]) & (image[40:, :, 2] > 40))
        assert len(x) > 100
        places.append((x.mean(), y.mean()))
    assert np.hypot(*np.subtract(*places)) < 0.5
