"""Automatic exposure as it is seen in delivered pictures: how fast it follows the light, and how the rate falls in the dark."""

import concurrent.futures
import json
import re
import urllib.request
from fractions import Fraction

import numpy as np
import pytest

import camrig

SKY = {"position": [0, 0, 50], "look_at": [0, 0.001, 100]}  # nothing but the background: the same light everywhere
STAND = {"position": [-6, 0, 2.5], "look_at": [0, 0, 0.5]}
PERIOD_NS = 40_000_000


def taken(rig, cam, seconds):
    """What the pictures of that time, each read when it was due, were taken with, by sequence number."""
    readings = {}
    for _ in range(round(seconds / 0.04)):
        rig.step(seconds=0.04)
        frame = cam.frame(kind="sensor")
        readings[frame.sequence] = {**frame.sensor, "time_ns": frame.time_ns}
    return readings


def intervals_ns(readings):
    assert list(readings) == list(range(min(readings), max(readings) + 1)), "numbers rise by one"
    return np.diff([one["time_ns"] for one in readings.values()])


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_the_rate_falls_in_the_dark_where_it_may_and_exposures_never_overlap(rig):
    sensor = {"preset": "imx290", "exposure_s": "auto", "lux": 2000, "dynamic_framerate": True}
    cam = rig.create_camera("dark", size=(64, 48), fps=25, **SKY, sensor=sensor)
    bright = taken(rig, cam, 1)
    assert set(intervals_ns(bright)) == {PERIOD_NS} and {one["fps"] for one in bright.values()} == {25}
    cam.set(sensor={"lux": 0.01})
    falling = taken(rig, cam, 8)
    cam.set(sensor={"lux": 2000})
    taken(rig, cam, 0.4)  # pictures that the command came between
    rising = taken(rig, cam, 16)
    for readings in (falling, rising):
        apart = intervals_ns(readings)
        later = list(readings.values())[1:]
        assert (apart % PERIOD_NS == 0).all()
        for ns, one in zip(apart, later, strict=True):
            assert one["exposure_s"] * 1e9 <= ns + 1000 and one["exposure_end_ns"] == one["time_ns"]
            assert one["fps"] == pytest.approx(25 / np.ceil(one["exposure_s"] / 0.04 - 1e-4))
    assert intervals_ns(falling)[-1] == 200_000_000 and later[-1]["fps"] == 25
    last = list(falling.values())[-1]
    assert last["exposure_s"] == pytest.approx(0.2) and last["fps"] == 5
    assert intervals_ns(rising)[-1] == PERIOD_NS and intervals_ns(rising)[0] == 200_000_000
    assert cam.truth()["sensor"]["fps"] == 25
    # By default it lasts a period at most.
    cam.set(sensor={"lux": 0.01, "dynamic_framerate": False})
    steady = taken(rig, cam, 3)
    assert set(intervals_ns(steady)) == {PERIOD_NS} and list(steady.values())[-1]["exposure_s"] == pytest.approx(0.04)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
@pytest.mark.parametrize("fps", [30, "30000/1001", 60])
@pytest.mark.parametrize("hz", [50, 60])
def test_exposures_that_fill_periods_to_the_nanosecond_take_no_more(rig, fps, hz):
    """Whole half periods of the mains, and the longest exposure, are whole numbers of nothing."""
    cam = rig.create_camera("dark", size=(64, 48), fps=fps, **SKY,
                            sensor={"preset": "imx290", "exposure_s": "auto", "lux": 0.01, "dynamic_framerate": True, "flicker_hz": hz})
    frames = {}
    for _ in range(400):
        rig.step(seconds=1 / 60)
        frames[cam.frame().sequence] = cam.frame()
    last, before = [frames[number] for number in sorted(frames)[-1:-3:-1]]
    rate = float(Fraction(fps))
    assert last.sensor["exposure_s"] == pytest.approx(0.2)
    assert last.sensor["fps"] == pytest.approx(rate / np.ceil(0.2 * rate - 1e-3)) and last.sensor["fps"] > 4.9
    assert last.time_ns - before.time_ns == pytest.approx(1e9 / last.sensor["fps"], abs=2)


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_exposures_by_hand_take_their_time_too(rig):
    cam = rig.create_camera("slow", size=(64, 48), fps=25, **SKY, sensor={"exposure_s": 0.3, "dynamic_framerate": True})
    rig.step(seconds=0.04)
    assert set(intervals_ns(taken(rig, cam, 2))) == {320_000_000}
    cam.set(sensor={"exposure_s": 0.04})
    rig.step(seconds=0.4)
    assert set(intervals_ns(taken(rig, cam, 1))) == {PERIOD_NS}


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_rate_that_has_fallen_comes_back_with_the_sensor_gone(rig):
    cam = rig.create_camera("slow", size=(64, 48), fps=25, **SKY, sensor={"exposure_s": 0.3, "dynamic_framerate": True})
    rig.step(seconds=1)
    cam.set(sensor=None)
    rig.step(seconds=0.4)
    first = cam.frame()
    rig.step(seconds=0.4)
    last = cam.frame()
    assert last.sequence - first.sequence == 10 and last.time_ns - first.time_ns == 10 * PERIOD_NS


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_a_reader_gets_what_is_due_and_nothing_else_is_missed(rig):
    """The books: instants that an exposure passes over were not due, so they are not dropped either."""
    cam = rig.create_camera("dark", size=(64, 48), fps=25, **SKY, sensor={"preset": "imx290", "exposure_s": "auto", "lux": 0.01, "dynamic_framerate": True})
    cam.frame()  # the light is metered from here on, and the reader begins with it
    stream = urllib.request.urlopen(cam.url("mjpeg"), timeout=30)
    reads = concurrent.futures.ThreadPoolExecutor(1).submit(stream.read)
    rig.step(seconds=4)
    books = next(one for one in rig.stats()["cameras"] if one["name"] == "dark")
    cam.delete()
    headers = re.findall(rb"X-Sequence: (\d+)\r\nX-World-Time-Ns: (\d+)", reads.result())
    sequences, times_ns = np.array([one for one, before in zip(headers, [None, *headers]) if one != before], dtype=np.int64).T  # what is sent again is no frame
    assert (np.diff(sequences) == 1).all() and np.diff(times_ns)[-1] == 200_000_000 and 20 < len(sequences) < 60
    assert books["due"] == books["rendered"] and books["dropped"] == 0 and len(sequences) - 1 <= books["due"] <= len(sequences)


def test_the_same_commands_give_the_same_fall_of_the_rate(scenes):
    def run():
        with camrig.start(str(scenes / "minimal.json"), mode="lockstep") as rig:
            cam = rig.create_camera("dark", size=(64, 48), fps=25, **STAND,
                                    sensor={"preset": "imx219", "exposure_s": "auto", "lux": 300, "dynamic_framerate": True})
            first = taken(rig, cam, 0.4)
            cam.set(sensor={"lux": 1})
            return json.dumps([first, taken(rig, cam, 3)]), cam.frame(kind="sensor").image.tobytes()

    assert run() == run()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_steps_of_light_are_followed_in_the_times_of_the_table_in_delivered_pictures(rig):
    """Frames until the mean of the delivered numbers stays within 5 % of the target: as libcamera's algorithm does it (docs/sensor.md)."""
    light = 750.0  # half of the wells in 10 ms, by the light of the sky
    cam = rig.create_camera("meters", size=(320, 240), fps=25, **SKY,
                            sensor={"preset": "imx249", "vignetting": 0, "exposure_s": "auto", "least_highlights": 0, "lux": light})

    def mean_of_next():
        rig.step(seconds=0.04)
        raw = cam.frame(kind="sensor")
        black = raw.sensor["black_level"]
        return (raw.image.mean() - black) / (2 ** raw.sensor["bits"] - 1 - black), raw.sensor

    found = {}
    for factor in (1 / 16, 1 / 2, 2, 4, 16):
        cam.set(sensor={"lux": light})
        for _ in range(60):
            mean_of_next()
        assert mean_of_next()[1]["settled"]
        cam.set(sensor={"lux": light * factor})
        means, readings = zip(*(mean_of_next() for _ in range(70)), strict=True)
        assert readings[-1]["settled"] and means[-1] == pytest.approx(0.16, rel=0.03) and (means[0] > means[-1]) == (factor > 1)
        found[factor] = max(i + 1 for i, mean in enumerate(means) if abs(mean / 0.16 - 1) > 0.05)
    for factor, frames in {1 / 16: 14, 1 / 2: 10, 2: 12, 4: 17, 16: 25}.items():
        assert abs(found[factor] - frames) <= 2, found


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_optical_flow_reaches_to_the_next_picture_that_comes(rig):
    """Five periods of a rate that has fallen: five times the way of a camera whose rate has not."""
    slow = rig.create_camera("slow", size=(320, 240), fps=25, place="above", sensor={"exposure_s": 0.2, "dynamic_framerate": True, "blur": False})
    fast = rig.create_camera("fast", size=(320, 240), fps=25, place="above", sensor={"exposure_s": 0.2, "blur": False})
    rig.step(seconds=0.44)
    assert slow.frame().time_ns == fast.frame().time_ns
    mover = next(one for one in fast.truth()["objects"] if one["name"] == "mover")["id"]
    ways = [np.hypot(*flow[cam.instances() == mover].mean(axis=0)) for cam, flow in ((cam, cam.flow()) for cam in (slow, fast))]
    assert ways[1] > 0.3 and ways[0] == pytest.approx(5 * ways[1], rel=0.03)
