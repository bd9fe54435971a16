"""Devices that fail: unplugged and plugged in again, buffers with errors or of a wrong size, as stock programs meet them."""

import glob
import os
import subprocess
import sys

import pytest

import camrig
from conftest import wait_until
from fault_books import books_balance  # noqa: F401 (a fixture)

READER = """
import cv2, sys
capture = cv2.VideoCapture(sys.argv[1], cv2.CAP_V4L2)
while capture.read()[0]:
    print("frame", flush=True)
"""

# What one open descriptor sees: frames, then what poll() and every ioctl say.
RAW = """
import errno, fcntl, os, select, struct, sys
QUERYCAP, REQBUFS, QBUF, DQBUF, STREAMON, G_FMT = 0x80685600, 0xC0145608, 0xC058560F, 0xC0585611, 0x40045612, 0xC0D05604
fd = os.open(sys.argv[1], os.O_RDWR)
fcntl.ioctl(fd, REQBUFS, bytearray(struct.pack("5I", 4, 1, 1, 0, 0)))
buffer = lambda index: bytearray(struct.pack("2I", index, 1) + bytes(52) + struct.pack("I", 1) + bytes(24))
for index in range(4):
    fcntl.ioctl(fd, QBUF, buffer(index))
fcntl.ioctl(fd, STREAMON, struct.pack("I", 1))
poll = select.poll()
poll.register(fd, select.POLLIN)
while True:
    (_, events), = poll.poll(10000)
    if events & (select.POLLHUP | select.POLLERR):
        break
    got = buffer(0)
    try:
        fcntl.ioctl(fd, DQBUF, got)
        index, _, used, flags = struct.unpack_from("4I", got)
        print(used, int(bool(flags & 0x40)), flush=True)
        fcntl.ioctl(fd, QBUF, buffer(index))
    except OSError as problem:  # unplugged since poll(), which says so next
        if problem.errno != errno.ENODEV:
            raise
print("gone", flush=True)
for request, size in ((QUERYCAP, 104), (G_FMT, 208), (DQBUF, 88), (QBUF, 88), (REQBUFS, 20)):
    try:
        fcntl.ioctl(fd, request, bytearray(struct.pack("I", 1) + bytes(size - 4)) if request != DQBUF else buffer(0))
        print("answered", flush=True)
    except OSError as problem:
        print(errno.errorcode[problem.errno], flush=True)
"""


def under_exec(rig, *program):
    return [os.environ["CAMRIG_BIN"], "exec", "--control", rig.call("server.info")["control"], "--", *program]


def start(programs, rig, code, path):
    return programs(under_exec(rig, sys.executable, "-c", code, path), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for_frames(rig, name, count):
    first = rig.camera(name).truth()["sequence"]
    wait_until(lambda: rig.camera(name).truth()["sequence"] >= first + count, what="frames")


def nodes(rig):
    listed = subprocess.run(under_exec(rig, sys.executable, "-c", "import glob; print(*sorted(glob.glob('/dev/video*')))"), capture_output=True,
                            text=True, timeout=30)
    return set(listed.stdout.split()) - set(glob.glob("/dev/video*"))


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_an_unplugged_device_goes_with_its_node_and_comes_back_under_another_number_without_its_settings(rig, programs):
    rig.create_camera("desk", size=(320, 240), fps=25, outputs=[{"kind": "device", "number": 40}, {"kind": "mjpeg"}],
                      controls={"brightness": 0.2})
    rig.create_camera("well", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 41}])
    assert nodes(rig) == {"/dev/video40", "/dev/video41"}
    well, reader = start(programs, rig, READER, "/dev/video41"), start(programs, rig, RAW, "/dev/video40")
    try:
        for _ in range(10):
            assert reader.stdout.readline().split() == [str(320 * 240 * 2), "0"]
        fault = rig.fault.set("desk", "unplug", as_number=42)
        out, err = reader.communicate(timeout=20)
        lines = out.splitlines()
        assert lines[lines.index("gone") + 1:] == ["ENODEV"] * 5, (lines, err)
        assert nodes(rig) == {"/dev/video41"}
        failed = start(programs, rig, READER, "/dev/video40")
        assert failed.communicate(timeout=20)[0] == ""
        assert rig.call("camera.get", name="desk")["controls"]["brightness"] == 0.2
        rig.fault.clear(id=fault["id"])
        wait_until(lambda: nodes(rig) == {"/dev/video41", "/dev/video42"}, what="the device under its new number")
        camera = rig.call("camera.get", name="desk")
        assert [output.get("number") for output in camera["outputs"] if output["kind"] == "device"] == [42]
        assert camera["controls"]["brightness"] == 0
        again = start(programs, rig, READER, "/dev/video42")
        assert [again.stdout.readline() for _ in range(5)] == ["frame\n"] * 5
        again.kill()
        again.communicate()
        assert [well.stdout.readline() for _ in range(20)] == ["frame\n"] * 20 and well.poll() is None
    finally:
        for one in (well, reader):
            one.kill()
            one.communicate()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_an_unplugged_device_is_out_for_its_share_of_each_period_and_may_keep_its_settings(rig):
    rig.create_camera("desk", size=(160, 120), fps=10, outputs=[{"kind": "device", "number": 43}], controls={"brightness": 0.2})
    rig.fault.set("desk", "unplug", severity=0.5, period_s=1, replug_resets_controls=False)
    there = []
    for _ in range(4):
        rig.step(seconds=0.5)
        there.append("/dev/video43" in nodes(rig))
    assert there == [True, False, True, False]
    rig.fault.clear("desk")
    rig.step(seconds=0.1)
    assert nodes(rig) == {"/dev/video43"}
    assert rig.call("camera.get", name="desk")["controls"]["brightness"] == 0.2


@pytest.mark.camrig(scene="scenes/hall.json", mode="lockstep")
def test_an_unplugged_device_goes_at_the_instant_it_is_told_and_nothing_is_drawn_for_it(rig, programs):
    rig.create_camera("desk", size=(160, 120), fps=25, place="lobby", outputs=[{"kind": "device", "number": 43}])
    drawn = lambda: rig.stats()["renderer"]["views"]
    reader = start(programs, rig, RAW, "/dev/video43")
    try:
        wait_until(lambda: any(output["readers"] for camera in rig.stats()["cameras"] for output in camera["outputs"]), what="a reader")
        before = drawn()
        rig.step(seconds=0.4)
        assert reader.stdout.readline() and drawn() >= before + 10
        rig.fault.set("desk", "unplug")
        rig.step(seconds=0.04)
        assert reader.communicate(timeout=20)[0].splitlines()[-6:] == ["gone", *["ENODEV"] * 5], "in a world that stands"
        before = drawn()
        rig.step(seconds=0.4)
        assert drawn() == before
    finally:
        reader.kill()
        reader.wait()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_what_cannot_be_unplugged_is_refused_with_the_reason(rig):
    rig.create_camera("desk", size=(160, 120), outputs=[{"kind": "mjpeg"}])
    rig.create_camera("one", size=(160, 120), outputs=[{"kind": "device", "number": 44}])
    rig.create_camera("two", size=(160, 120), outputs=[{"kind": "device", "number": 45}])
    with pytest.raises(camrig.CamrigError, match="no user-space device.*v4l2loopback") as refused:
        rig.fault.set("desk", "unplug")
    assert refused.value.kind == "unsupported"
    with pytest.raises(camrig.CamrigError, match="params.as_number: .*belongs to camera two"):
        rig.fault.set("one", "unplug", as_number=45)
    assert rig.fault.list() == []


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_buffers_come_with_the_error_flag_and_of_a_wrong_size(rig, programs):
    rig.create_camera("desk", size=(320, 240), fps=25, outputs=[{"kind": "device", "number": 46}])
    whole = 320 * 240 * 2
    reader = start(programs, rig, RAW, "/dev/video46")
    take = lambda count: [tuple(map(int, reader.stdout.readline().split())) for _ in range(count)]

    def wait_for(buffer):
        """Those that were on their way come first."""
        for (one,) in (take(1) for _ in range(200)):
            if one == buffer:
                return
        raise AssertionError(f"no buffer {buffer} came")

    try:
        assert set(take(10)) == {(whole, 0)}
        rig.fault.set("desk", "buffer_error", probability=0.5)
        wait_for((whole, 1))
        flagged = take(40)
        assert {used for used, _ in flagged} == {whole} and 8 < sum(flag for _, flag in flagged) < 32
        rig.fault.clear("desk")
        rig.fault.set("desk", "wrong_size", share=0.25)
        wait_for((whole * 3 // 4, 0))
        assert set(take(10)) == {(whole * 3 // 4, 0)}
        rig.fault.clear("desk")
        wait_for((whole, 0))
        assert set(take(10)) == {(whole, 0)}
    finally:
        reader.kill()
        reader.communicate()


# Each call once, as a program makes them at its start and in its loop; what the first that fails says.
CALLS = """
import errno, fcntl, os, struct, sys
REQBUFS, QBUF, DQBUF, STREAMON, STREAMOFF = 0xC0145608, 0xC058560F, 0xC0585611, 0x40045612, 0x40045613
buffer = lambda index: bytearray(struct.pack("2I", index, 1) + bytes(52) + struct.pack("I", 1) + bytes(24))
def call(name, request, argument):
    try:
        fcntl.ioctl(fd, request, argument)
        return True
    except OSError as problem:
        print(name, errno.errorcode[problem.errno], flush=True)
        return False
fd = os.open(sys.argv[1], os.O_RDWR)
def begin():
    return (call("REQBUFS", REQBUFS, bytearray(struct.pack("5I", 4, 1, 1, 0, 0))) and all(call("QBUF", QBUF, buffer(i)) for i in range(4))
            and call("STREAMON", STREAMON, struct.pack("I", 1)))
if begin():
    print("streams", flush=True)
    while (got := buffer(0)) and call("DQBUF", DQBUF, got) and call("QBUF", QBUF, buffer(struct.unpack_from("I", got)[0])):
        pass
    call("STREAMOFF", STREAMOFF, struct.pack("I", 1))
    sys.stdin.readline()
    call("REQBUFS", REQBUFS, bytearray(struct.pack("5I", 0, 1, 1, 0, 0)))
    print("streams" if begin() and call("DQBUF", DQBUF, buffer(0)) else "fails", flush=True)
"""


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
@pytest.mark.parametrize("at", ["reqbufs", "qbuf", "streamon"])
def test_calls_fail_as_vivid_lets_them(rig, at, programs):
    rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 47}])
    rig.create_camera("well", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 48}])
    rig.fault.set("desk", "device_error", at=at)

    def first_line():
        """A program that comes before the fault does streams, and would go on."""
        program = start(programs, rig, CALLS, "/dev/video47")
        try:
            return program.stdout.readline()
        finally:
            program.kill()
            program.communicate()

    wait_until(lambda: first_line() == f"{at.upper()} EINVAL\n", what="the call fails")
    well = start(programs, rig, READER, "/dev/video48")
    assert [well.stdout.readline() for _ in range(5)] == ["frame\n"] * 5
    well.kill()
    well.communicate()
    rig.fault.clear("desk")
    wait_until(lambda: not rig.fault.list(), what="no fault")
    wait_for_frames(rig, "desk", 2)  # which the fault is no longer of
    reader = start(programs, rig, READER, "/dev/video47")
    assert [reader.stdout.readline() for _ in range(5)] == ["frame\n"] * 5


@pytest.mark.camrig(scene="scenes/minimal.json", mode="realtime")
def test_a_fatal_streaming_error_lasts_until_the_stream_is_stopped(rig, programs):
    rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 49}])
    program = programs(under_exec(rig, sys.executable, "-c", CALLS, "/dev/video49"), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert program.stdout.readline() == "streams\n"
        rig.fault.set("desk", "device_error", at="streaming")
        assert program.stdout.readline() in ("DQBUF EIO\n", "QBUF EIO\n")
        rig.fault.clear("desk")
        wait_for_frames(rig, "desk", 3)  # that are due without it
        program.stdin.write("\n")
        program.stdin.flush()
        assert program.stdout.readline() == "streams\n"
    finally:
        program.kill()
        program.communicate()


@pytest.mark.camrig(scene="scenes/minimal.json", mode="lockstep")
def test_programs_let_their_device_fail_by_vivids_controls(rig):
    rig.create_camera("desk", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 50, "error_controls": True}])
    rig.create_camera("well", size=(160, 120), fps=25, outputs=[{"kind": "device", "number": 51}])
    control = lambda *options, number=50: subprocess.run(under_exec(rig, "v4l2-ctl", "-d", f"/dev/video{number}", *options), capture_output=True, text=True,
                                                         timeout=30)
    wait_until(lambda: "inject_vidioc_reqbufs_error" in control("-l").stdout, what="the controls")
    listed = control("-l").stdout
    assert "Vivid Controls" in listed and "percentage_of_dropped_buffers 0x00f0f040" in listed, listed
    for name in ("disconnect 0x00f0f041", "inject_v4l2_buf_flag_error 0x00f0f042", "inject_vidioc_reqbufs_error 0x00f0f043", "inject_vidioc_qbuf_error 0x00f0f044",
                 "inject_vidioc_streamon_error 0x00f0f045", "inject_fatal_streaming_error 0x00f0f046"):
        assert f"{name} (button)" in listed, (name, listed)
    assert "Vivid" not in control("-l", number=51).stdout
    assert control("-c", "percentage_of_dropped_buffers=30").returncode == 0
    (drop,) = rig.fault.list("desk")
    assert (drop["kind"], drop["severity"], drop["params"]["probability"]) == ("drop", 0.3, 1.0)
    assert "30" in control("-C", "percentage_of_dropped_buffers").stdout
    rig.fault.clear("desk")
    assert " 0" in control("-C", "percentage_of_dropped_buffers").stdout, "others end faults too"
    assert control("-c", "percentage_of_dropped_buffers=20").returncode == 0
    assert control("-c", "percentage_of_dropped_buffers=0").returncode == 0
    assert rig.fault.list() == []
    assert control("-c", "inject_vidioc_qbuf_error=1").returncode == 0
    (error,) = rig.fault.list("desk")
    assert (error["kind"], error["params"]["at"]) == ("device_error", "qbuf") and error["end_ns"] - error["start_ns"] == pytest.approx(10**9, abs=2 * 10**8)
    rig.step(nanoseconds=error["end_ns"] - rig.status()["world_ns"])
    assert rig.fault.list() == []
