"""Unmodified programs read two cameras from real devices of the kernel module."""

import errno
import re
import statistics
import subprocess
import time

import cv2
import pytest

import camrig
from conftest import FPS, LEFT, NAMES, ONE_READER, RIGHT, SIZE, STAMPS_ARE_INSTANTS, gray_of, is_camera, needs_control_node, wait_until
from v4l2_reader import V4l2Reader


def run(command: str, timeout: float = 90) -> str:
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout[-1500:]}\n{done.stderr[-1500:]}"
    return done.stdout + done.stderr


def test_without_the_module_the_answer_says_what_to_run_and_nothing_is_made(station):
    assert station.refusal.kind == "unavailable" and "modprobe v4l2loopback" in str(station.refusal)
    assert station.cameras_without_module == []


@pytest.mark.parametrize("number", [LEFT, RIGHT])
def test_what_the_ros_drivers_rely_on_holds(rig, number):
    with V4l2Reader(number, "YUYV", SIZE) as reader:
        assert reader.card == NAMES[number]
        assert reader.intervals == [(1, 1, FPS)]
        assert reader.line == 2 * SIZE[0]
        pictures = reader.take(8)
    assert all(len(picture.data) == SIZE[0] * SIZE[1] * 2 for picture in pictures)
    codes = [camrig.read_code(gray_of(picture.data)) for picture in pictures]
    assert None not in codes
    assert all(after.sequence >= before.sequence for before, after in zip(codes, codes[1:]))
    if STAMPS_ARE_INSTANTS:
        assert all(after.sequence == before.sequence + 1 for before, after in zip(pictures, pictures[1:]))


def test_both_cameras_carry_the_same_stamp_for_the_same_instant(rig):
    stamps: dict[int, dict[int, int]] = {LEFT: {}, RIGHT: {}}
    with V4l2Reader(LEFT, "YUYV", SIZE) as left, V4l2Reader(RIGHT, "YUYV", SIZE) as right:
        for _ in range(12):
            for number, reader in ((LEFT, left), (RIGHT, right)):
                picture = reader.next()
                stamps[number].setdefault(camrig.read_code(gray_of(picture.data)).time_ns, picture.stamp_us)
    common = sorted(set(stamps[LEFT]) & set(stamps[RIGHT]))[1:]  # the first may be from before the readers came
    assert len(common) >= 5
    skews = [stamps[LEFT][instant] - stamps[RIGHT][instant] for instant in common]
    print(f"{len(common)} instants, largest skew {max(map(abs, skews))} us")
    if STAMPS_ARE_INSTANTS:
        assert set(skews) == {0}
    else:
        # The module stamps when it is written to. Who pairs pictures by the nearest stamp still gets those of one instant:
        # they are less than half a period apart (in the middle; single ones wait for this emulated processor).
        assert statistics.median(map(abs, skews)) < 500_000 / FPS
        for stamp_of in stamps.values():
            in_order = [stamp_of[instant] for instant in common]
            assert in_order == sorted(set(in_order))


def test_a_second_reader_of_a_device(rig):
    with V4l2Reader(LEFT, "YUYV", SIZE) as first:
        first.take(2)
        if ONE_READER:
            with pytest.raises(OSError) as caught:
                V4l2Reader(LEFT, "YUYV", SIZE)
            assert caught.value.errno == errno.EBUSY
        else:
            with V4l2Reader(LEFT, "YUYV", SIZE) as second:
                second.take(3)
        assert len(first.take(3)) == 3


def test_opencv_reads_both(rig):
    captures = {number: cv2.VideoCapture(number, cv2.CAP_V4L2) for number in (LEFT, RIGHT)}
    try:
        last, late = dict.fromkeys(captures, -1), 0
        for _ in range(8):
            for number, capture in captures.items():
                ok, image = capture.read()
                age_s = time.monotonic() - capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
                assert ok and image.shape == (SIZE[1], SIZE[0], 3)
                code = camrig.read_code(image)
                # Readers own no buffer: the module gives the writer the oldest of the four, whoever reads it. Up to two
                # periods old, a picture is whole; one that this emulated machine kept longer may be half the next.
                if age_s > 2 / FPS:
                    late += 1
                    continue
                assert code is not None, f"torn after {age_s:.3f} s"
                assert code.sequence >= last[number]
                last[number] = code.sequence
        print(f"{late} of 16 pictures were read late")
        assert all(sequence > 0 for sequence in last.values())
        assert captures[LEFT].get(cv2.CAP_PROP_FPS) in (FPS, 30)  # 30 is what OpenCV asks every device for
    finally:
        for capture in captures.values():
            capture.release()


def test_opencv_sees_the_colours_of_the_picture(rig):
    still = rig.camera("left").frame().image
    capture = cv2.VideoCapture(LEFT, cv2.CAP_V4L2)
    ok, image = capture.read()
    capture.release()
    assert ok
    sky = (slice(24, 30), slice(0, SIZE[0]))  # below the code strip, above the ground
    difference = abs(still[sky].mean(axis=(0, 1)) - image[sky].mean(axis=(0, 1)))
    print("mean difference of blue, green, red:", difference.round(2))
    assert difference.max() <= 2


def test_ffmpeg_reads_it(rig):
    told = run(f"ffmpeg -v info -f v4l2 -i /dev/video{LEFT} -frames:v 8 -f null - 2>&1")
    assert re.search(r"yuyv422.*160x120", told) and "frame=    8" in told
    assert "corrupt" not in told.lower() and "dropped" not in told.lower()


def test_v4l2_ctl_streams_it(rig):
    listed = run(f"v4l2-ctl -d /dev/video{LEFT} --list-formats-ext")
    assert "YUYV" in listed and "Discrete 160x120" in listed and "(5.000 fps)" in listed
    told = run(f"v4l2-ctl -d /dev/video{LEFT} --stream-mmap --stream-count=8 --verbose")
    sequences = [int(n) for n in re.findall(r"cap dqbuf: \d+ seq: +(\d+)", told)]
    assert len(sequences) == 8 and sequences == sorted(set(sequences))


def test_gstreamer_reads_it(rig):
    told = run(f"gst-launch-1.0 -v v4l2src device=/dev/video{LEFT} num-buffers=8 ! fakesink silent=false")
    assert re.search(r"format=\(string\)YUY2, width=\(int\)160, height=\(int\)120", told)
    if STAMPS_ARE_INSTANTS:
        assert "colorimetry=(string)2:4:7:1" in told
    stamps = [int(minutes) * 60 + float(seconds) for minutes, seconds in re.findall(r"chain.*?pts: 0:(\d+):([\d.]+)", told)]
    assert len(stamps) == 8 and stamps == sorted(stamps)


def test_a_paused_world_keeps_its_readers_alive(rig):
    with V4l2Reader(LEFT, "YUYV", SIZE) as reader:
        reader.take(3)
        rig.pause()
        try:
            came = []
            while len(came) < 8:
                picture = reader.next()
                came.append((time.monotonic(), picture))
            print(f"longest silence {max(b[0] - a[0] for a, b in zip(came, came[1:])):.2f} s")
            # A few may still be from before the pause; then it is the last one again and again, with the time of each sending.
            repeated = [picture for _, picture in came[-3:]]
            assert len({camrig.read_code(gray_of(picture.data)).time_ns for picture in repeated}) == 1
            assert all(after.stamp_us - before.stamp_us > 500_000 for before, after in zip(repeated, repeated[1:]))
        finally:
            rig.resume()
        reader.take(3)


def test_a_rate_that_a_reader_sets_is_put_back(rig):
    with V4l2Reader(LEFT, "YUYV", SIZE) as reader:
        reader.wish_rate(30)
        wait_until(lambda: reader.rate() == (FPS, 1), what="the camera's rate")
        reader.take(3)


@needs_control_node
def test_a_camera_that_nobody_reads_is_not_streamed(rig):
    def readers():
        (left,) = (camera for camera in rig.call("stats.get")["cameras"] if camera["name"] == "left")
        return sum(len(output["readers"]) for output in left["outputs"])

    wait_until(lambda: readers() == 0, what="no reader")
    with V4l2Reader(LEFT, "YUYV", SIZE) as reader:
        first = reader.next()
        assert first.age_us < 4_000_000  # it was fetched a moment ago
        wait_until(lambda: readers() == 1, what="a reader")
    wait_until(lambda: readers() == 0, what="no reader")


def test_the_other_formats(rig):
    right = rig.camera("right")
    try:
        for fourcc, size_image in (("YU12", 160 * 120 * 3 // 2), ("BGR3", 160 * 120 * 3), ("MJPG", None)):
            right.set(outputs=[{"kind": "v4l2", "number": RIGHT, "format": fourcc}])
            wait_until(lambda: f"'{fourcc}'" in run(f"v4l2-ctl -d /dev/video{RIGHT} --get-fmt-video || true"), what=fourcc)
            wait_until(lambda: is_camera(RIGHT), what=fourcc)
            with V4l2Reader(RIGHT, fourcc, SIZE) as reader:
                pictures = [picture for picture in reader.take(6) if picture.stamp_us > reader.asked_us]
            assert len(pictures) >= 3, "0.12 forgets the length of those that were there; there are at most two"
            for picture in pictures:
                assert size_image is None or len(picture.data) == size_image
                assert size_image is not None or (picture.data[:2] == b"\xff\xd8" and picture.data[-2:] == b"\xff\xd9")
            capture = cv2.VideoCapture(RIGHT, cv2.CAP_V4L2)
            ok, image = capture.read()
            capture.release()
            assert ok and camrig.read_code(image) is not None, fourcc
    finally:
        right.set(outputs=[{"kind": "v4l2", "number": RIGHT}])
        wait_until(lambda: "'YUYV'" in run(f"v4l2-ctl -d /dev/video{RIGHT} --get-fmt-video || true"), what="YUYV")
        wait_until(lambda: is_camera(RIGHT), what="YUYV")


def test_a_new_size_waits_for_the_reader_whose_stream_goes_on(rig):
    left = rig.camera("left")
    with V4l2Reader(LEFT, "YUYV", SIZE) as reader:
        reader.take(2)
        left.set(size=(128, 96))
        wait_until(lambda: "a program has it open at YUYV 160x120" in rig.log, what="a word about the reader")
        for picture in reader.take(5):
            assert len(picture.data) == SIZE[0] * SIZE[1] * 2
    wait_until(lambda: "Width/Height      : 128/96" in run(f"v4l2-ctl -d /dev/video{LEFT} --get-fmt-video || true"), what="128x96")
    with V4l2Reader(LEFT, "YUYV", (128, 96)) as reader:
        assert len(reader.take(3)[-1].data) == 128 * 96 * 2
    left.set(size=SIZE)
    wait_until(lambda: "Width/Height      : 160/120" in run(f"v4l2-ctl -d /dev/video{LEFT} --get-fmt-video || true"), what="160x120")
