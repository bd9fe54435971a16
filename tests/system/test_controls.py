"""A camera's controls: by the control protocol, and by V4L2 programs that know nothing of camrig."""

import itertools
import os
import re
import subprocess
import sys

import numpy as np
import pytest

import camrig
from compliance import complaints
from conftest import wait_until

CAMRIG = os.environ["CAMRIG_BIN"]
pytestmark = pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
DEVICE = "/dev/video7"


@pytest.fixture
def camera(rig):
    return rig.create_camera("eye", size=(320, 240), fps=20, position=(-4, 0, 2), pan_deg=10, tilt_deg=-20,
                             outputs=[{"kind": "device", "number": 7}])


def run_with_devices(rig, *command):
    control = rig.call("server.info")["control"]
    done = subprocess.run([CAMRIG, "exec", "--control", control, "--", *command], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def v4l2_ctl(rig, *arguments):
    return run_with_devices(rig, "v4l2-ctl", "-d", DEVICE, *arguments)


def get(rig, name):
    return int(re.search(rf"^{name}: (-?\d+)", v4l2_ctl(rig, "-C", name), re.MULTILINE)[1])


def picture(rig, camera):
    """One that fell due after now, so that it shows what was set before."""
    return camera.frame(min_ns=rig.status()["world_ns"] + 1).image


def mean(rig, camera):
    """Mean R, G and B."""
    return picture(rig, camera).reshape(-1, 3).mean(axis=0)[::-1]


def test_all_controls_are_listed_with_their_values(rig, camera):
    listed = v4l2_ctl(rig, "-L")
    for name in ("brightness", "contrast", "saturation", "white_balance_temperature_auto", "white_balance_temperature", "gain",
                 "exposure_auto", "exposure_absolute", "pan_absolute", "tilt_absolute", "zoom_absolute"):
        assert re.search(rf"^\s*{name} 0x", listed, re.MULTILINE), listed
    assert get(rig, "pan_absolute") == -10 * 3600  # V4L2 counts to the right
    assert get(rig, "tilt_absolute") == -20 * 3600
    assert get(rig, "zoom_absolute") == 100


def test_of_a_camera_on_a_head_they_are_the_heads(rig):
    head = {"preset": "ideal", "tilt_limits_deg": [-60, 30]}
    dome = rig.create_camera("dome", size=(320, 240), fps=20, position=(-4, 0, 2), pan_deg=10, ptz=head,
                             outputs=[{"kind": "device", "number": 7}])
    listed = v4l2_ctl(rig, "-L")
    assert re.search(r"pan_absolute 0x\S+ \(int\)\s+: min=-648000 max=648000 .* value=0", listed), listed
    assert re.search(r"tilt_absolute 0x\S+ \(int\)\s+: min=-216000 max=108000 ", listed), listed
    assert re.search(r"zoom_absolute 0x\S+ \(int\)\s+: min=100 max=3000 ", listed), listed
    assert re.search(r"pan_speed 0x\S+ \(int\)\s+: min=-360 max=360 ", listed), listed
    base = dome.get()["pose"]
    v4l2_ctl(rig, "-c", "pan_absolute=72000,tilt_absolute=18000,zoom_absolute=250")
    wait_until(lambda: not any(dome.ptz.status()[key] for key in ("turning", "zooming")), what="the head to stand")
    assert (get(rig, "pan_absolute"), get(rig, "tilt_absolute"), get(rig, "zoom_absolute")) == (72000, 18000, 250)
    true = dome.ptz.status()["true"]
    assert (true["pan_deg"], true["tilt_deg"]) == pytest.approx((-20, 5)) and dome.get()["pose"] == base  # V4L2 counts to the right
    dome.ptz.move(pan_deg=30)
    wait_until(lambda: get(rig, "pan_absolute") == -30 * 3600, what="what another client said")
    slow = rig.create_camera("slow", size=(64, 48), fps=20, position=(-4, 0, 2), ptz={"preset": "ideal", "speed_deg_s": 0.5},
                             outputs=[{"kind": "device", "number": 8}])
    run_with_devices(rig, "v4l2-ctl", "-d", "/dev/video8", "-c", "pan_absolute=-324000")
    before = slow.ptz.status()["pan_deg"]
    read = int(run_with_devices(rig, "v4l2-ctl", "-d", "/dev/video8", "-C", "pan_absolute").split()[-1])
    after = slow.ptz.status()["pan_deg"]
    assert before * 3600 - 1 <= -read <= after * 3600 + 1 < 324000, "where it is, not where it goes"
    slow.delete()
    v4l2_ctl(rig, "-c", "pan_speed=20")
    wait_until(lambda: dome.ptz.status()["pan_deg"] < 25, what="the drive to the right")
    v4l2_ctl(rig, "-c", "pan_speed=0")
    wait_until(lambda: not dome.ptz.status()["turning"], what="the stand")
    tilt = dome.ptz.status()["tilt_deg"]
    v4l2_ctl(rig, "-c", "tilt_speed=-20")
    wait_until(lambda: dome.ptz.status()["tilt_deg"] < tilt - 5, what="the drive downwards")
    v4l2_ctl(rig, "-c", "tilt_speed=0")
    wait_until(lambda: not dome.ptz.status()["turning"], what="the stand after it")


def test_pan_tilt_and_zoom_move_the_camera(rig, camera):
    before = camera.get()
    v4l2_ctl(rig, "-c", "pan_absolute=72000,tilt_absolute=18000,zoom_absolute=200")
    after = camera.get()
    assert after["pose"]["pan_deg"] == pytest.approx(-20, abs=1e-9)
    assert after["pose"]["tilt_deg"] == pytest.approx(5, abs=1e-9)
    assert after["pose"]["position"] == before["pose"]["position"]
    assert after["intrinsics"]["fx"] == pytest.approx(2 * before["intrinsics"]["fx"])
    assert (get(rig, "pan_absolute"), get(rig, "tilt_absolute"), get(rig, "zoom_absolute")) == (72000, 18000, 200)


def test_image_controls_change_the_pixels_of_every_output(rig, camera):
    rig.remove_actor("mover")  # pictures differ by the controls alone
    usual = mean(rig, camera)
    v4l2_ctl(rig, "-c", "exposure_absolute=400")
    assert camera.get()["controls"]["auto_exposure"]  # waits until the automatic is off
    v4l2_ctl(rig, "-c", "exposure_auto=1")
    assert camera.get()["controls"]["exposure_ev"] == pytest.approx(2)
    assert (mean(rig, camera) > usual + 10).all()
    v4l2_ctl(rig, "-c", "exposure_auto=3,saturation=0")
    grey = picture(rig, camera).astype(int)
    assert np.ptp(grey, axis=2).max() == 0
    v4l2_ctl(rig, "-c", "saturation=100,brightness=-20")
    assert (mean(rig, camera) < usual - 20).any() and (mean(rig, camera) <= usual).all()
    v4l2_ctl(rig, "-c", "brightness=0,white_balance_temperature_auto=0,white_balance_temperature=3000")
    assert mean(rig, camera)[2] > usual[2] + 5 and mean(rig, camera)[0] < usual[0] - 5
    v4l2_ctl(rig, "-c", "white_balance_temperature_auto=1")
    assert camera.get()["controls"] == {"auto_exposure": True, "exposure_ev": 2, "gain_db": 0, "auto_white_balance": True,
                                        "white_balance_k": 3000, "brightness": 0, "contrast": 1, "saturation": 1}
    assert mean(rig, camera) == pytest.approx(usual, abs=1)


def test_the_code_strip_is_read_whatever_the_controls_do(rig):
    dark = rig.create_camera("dark", size=(320, 240), code_strip=True, controls={"exposure_ev": -6, "contrast": 0.1, "saturation": 0})
    assert camrig.read_code(dark.frame().image) is not None


def told_of(rig, control, change):
    """What v4l2-ctl prints of its first event of this control, while change() is made over and over."""
    listener = subprocess.Popen([CAMRIG, "exec", "--control", rig.call("server.info")["control"], "--", "v4l2-ctl", "-d", DEVICE, f"--wait-for-event=ctrl={control}"],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def heard():
        change()
        return listener.poll() is not None

    try:
        wait_until(heard, 30, "a control event")
        return listener.stdout.read()
    finally:
        listener.kill()
        listener.wait()


def test_programs_hear_of_changes_that_others_make(rig, camera):
    zooms = itertools.cycle((1.5, 2.5))
    output = told_of(rig, "zoom_absolute", lambda: camera.set(zoom=next(zooms)))
    assert "zoom_absolute" in output or re.search(r"value: (150|250)", output), output


@pytest.mark.slow
def test_v4l2_compliance_finds_nothing_at_a_running_rig(rig, camera):
    report = run_with_devices(rig, "v4l2-compliance", "-d", DEVICE, "-s")
    assert not complaints(report), report[-3000:]


@pytest.fixture
def sensing(rig):
    return rig.create_camera("counts", size=(320, 240), fps=20, position=(-4, 0, 2), pan_deg=10, tilt_deg=-20,
                             sensor={"preset": "imx219", "exposure_s": "auto", "lux": 300},
                             outputs=[{"kind": "device", "number": 7}])


def test_of_a_camera_with_a_sensor_they_are_the_sensors(rig, sensing):
    listed = v4l2_ctl(rig, "-L")
    assert re.search(r"exposure_absolute 0x\S+ \(int\)\s+: min=1 max=100000 ", listed), listed
    assert re.search(r"gain 0x\S+ \(int\)\s+: min=0 max=480 ", listed), listed
    assert re.search(r"white_balance_temperature 0x\S+ \(int\)\s+: min=2000 max=12000 ", listed), listed
    assert re.search(r"power_line_frequency 0x\S+ \(menu\)\s+: min=0 max=2 ", listed) and "2: 60 Hz" in listed, listed
    assert (get(rig, "exposure_auto"), get(rig, "white_balance_temperature_auto"), get(rig, "power_line_frequency")) == (3, 1, 0)

    # What is set while the automatic is on acts when it goes off, in either order.
    v4l2_ctl(rig, "-c", "exposure_absolute=40")
    assert sensing.get()["sensor"]["exposure_s"] == "auto" and get(rig, "exposure_absolute") == 40
    v4l2_ctl(rig, "-c", "exposure_auto=1")
    assert sensing.get()["sensor"]["exposure_s"] == pytest.approx(0.004)
    v4l2_ctl(rig, "-c", "exposure_auto=3")
    v4l2_ctl(rig, "-c", "exposure_auto=1,exposure_absolute=25,gain=65,power_line_frequency=2")
    sensor = sensing.get()["sensor"]
    assert (sensor["exposure_s"], sensor["gain_db"], sensor["flicker_hz"]) == (pytest.approx(0.0025), 6.5, 60)
    v4l2_ctl(rig, "-c", "white_balance_temperature=3000")
    assert sensing.get()["sensor"]["white_balance"] == "auto"
    v4l2_ctl(rig, "-c", "white_balance_temperature_auto=0")
    assert sensing.get()["sensor"]["white_balance"] == 3000
    assert re.search(r"exposure_dynamic_framerate 0x009a0903 \(bool\)\s+: default=0 value=0", listed), listed
    v4l2_ctl(rig, "-c", "exposure_dynamic_framerate=1")
    assert sensing.get()["sensor"]["dynamic_framerate"] is True
    # The picture is taken so, and its finished picture is left alone.
    taken = sensing.frame(min_ns=rig.status()["world_ns"] + 1).sensor
    assert (taken["exposure_s"], taken["gain_db"]) == (pytest.approx(0.0025), 6.5)
    assert sensing.get()["controls"] == rig.create_camera("plain", size=(64, 48)).get()["controls"]

    # And the other way: what the control protocol sets is what programs read.
    sensing.set(sensor={"exposure_s": 0.02, "gain_db": 12, "flicker_hz": 50, "white_balance": 5000, "dynamic_framerate": False})
    assert get(rig, "exposure_dynamic_framerate") == 0
    assert [get(rig, name) for name in ("exposure_auto", "exposure_absolute", "gain", "power_line_frequency",
                                        "white_balance_temperature_auto", "white_balance_temperature")] == [1, 200, 120, 1, 0, 5000]
    sensing.set(sensor={"exposure_s": "auto", "white_balance": "auto"})
    assert [get(rig, name) for name in ("exposure_auto", "exposure_absolute", "white_balance_temperature_auto")] == [3, 200, 1]


def test_programs_hear_what_others_do_to_a_sensor(rig, sensing):
    exposures = itertools.cycle((0.003, 0.007))
    output = told_of(rig, "exposure_absolute", lambda: sensing.set(sensor={"exposure_s": next(exposures)}))
    assert "exposure_absolute" in output or re.search(r"value: (30|70)\b", output), output


def test_in_the_dark_a_device_slows_down_where_it_may(rig):
    """What people trip over with webcams: the rate is still said to be 20, and 5 pictures a second come."""
    rig.create_camera("dark", size=(320, 240), fps=20, position=(-4, 0, 2), sensor={"preset": "imx219", "exposure_s": "auto", "lux": 0.01},
                      code_strip=True, outputs=[{"kind": "device", "number": 7}])
    capture = """
import camrig, cv2
c, seen = cv2.VideoCapture("/dev/video7", cv2.CAP_V4L2), {}
while len(seen) < 29:
    ok, image = c.read()
    assert ok
    seen.setdefault(camrig.read_code(image).sequence, c.get(cv2.CAP_PROP_POS_MSEC))  # one that comes again, after a second of none, is no new picture
print(c.get(cv2.CAP_PROP_FPS), *(value for number in list(seen)[20:] for value in (number, seen[number])))
"""

    def check_period(period_ms):
        """Of each two pictures: as many periods as their numbers differ by, for a machine that is busy drops pictures."""
        said, *numbers = map(float, run_with_devices(rig, sys.executable, "-c", capture).split())
        pictures = list(zip(numbers[::2], numbers[1::2], strict=True))
        print(pictures)
        assert said == 20 and len(pictures) == 9
        for (number, at_ms), (next_number, next_at_ms) in itertools.pairwise(pictures):
            assert next_number > number and next_at_ms - at_ms == pytest.approx((next_number - number) * period_ms, abs=1)

    check_period(50)
    v4l2_ctl(rig, "-c", "exposure_dynamic_framerate=1")
    check_period(200)


def test_a_camera_without_a_sensor_has_no_mains(rig, camera):
    listed = v4l2_ctl(rig, "-L")
    assert "power_line_frequency" not in listed and "exposure_dynamic_framerate" not in listed
