// Unmodified programs of Debian against a rig's devices, through the real library (LD_PRELOAD).

#include <array>
#include <csignal>
#include <sstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include "tests/unit/v4l2_sink/preload/test_rig.h"

extern char** environ;

namespace camrig::device {
namespace {

struct Outcome {
    int status = -1;
    std::string output;
};

/// Runs a shell command with the rig's devices in sight.
Outcome run(const std::string& socket, const std::string& command) {
    const std::string line = "export CAMRIG_DEVICE_SOCKET='" + socket + "' ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD='" +
                             CAMRIG_TEST_PRELOAD "'; exec timeout 120 " + command + " 2>&1";
    Outcome outcome;
    FILE* pipe = ::popen(line.c_str(), "r");
    if (pipe == nullptr) return outcome;
    std::array<char, 4096> part;
    while (const std::size_t got = std::fread(part.data(), 1, part.size(), pipe))
        outcome.output.append(part.data(), got);
    const int status = ::pclose(pipe);
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return outcome;
}

class DevicePrograms : public testing::Test {
protected:
    DevicePrograms() {
        camera = std::thread([this] {
            const Rate rate = rig.maker.camera().rate;
            const TimeNs start = monotonic_now_ns();
            while (!stop) {
                const TimeNs due = start + rate.time_of_frame(rig.next);
                timespec until{due / ns_per_s, due % ns_per_s};
                ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
                rig.show();
            }
        });
    }
    ~DevicePrograms() override {
        stop = true;
        camera.join();
    }
    void passes(const std::string& command) {
        const Outcome outcome = run(rig.server->socket_path(), command);
        EXPECT_EQ(outcome.status, 0) << command << "\n" << outcome.output;
    }
    void says(const std::string& command, const std::string& text) {
        const Outcome outcome = run(rig.server->socket_path(), command);
        EXPECT_NE(outcome.output.find(text), std::string::npos) << command << "\n" << outcome.output;
    }

    TestRig rig{{640, 480}};
    std::atomic<bool> stop{false};
    std::thread camera;
};

TEST_F(DevicePrograms, V4l2ComplianceFindsNothing) {
    const Outcome outcome = run(rig.server->socket_path(), "v4l2-compliance -d /dev/video10 -s");
    EXPECT_NE(outcome.output.find("Failed: 0, Warnings: "), std::string::npos) << outcome.output;
    // Where it was too slow for a frame it warns of the next one's number, which is no fault of the device's.
    std::istringstream lines(outcome.output);
    for (std::string line; std::getline(lines, line);)
        EXPECT_TRUE(line.find("warn:") == std::string::npos || line.find("got sequence number") != std::string::npos)
            << line;
}

// What ROS usb_cam, v4l2_camera and libwebrtc check, and every picture whole and in order.
TEST_F(DevicePrograms, ACarefulClientIsContentWithEveryFormat) {
    for (const char* fourcc : {"YUYV", "MJPG", "YU12", "NV12", "BGR3"})
        passes(std::string(CAMRIG_TEST_CLIENT " /dev/video10 30 ") + fourcc + " 640x480");
    passes(CAMRIG_TEST_CLIENT " /dev/v4l/by-id/camrig-lobby-video-index0 10 YUYV 320x240");
}

TEST_F(DevicePrograms, APictureBelongsToTheProgramUntilItIsQueuedAgain) {
    passes(CAMRIG_TEST_CLIENT " /dev/video10 5 YUYV 640x480 hold");
}

TEST_F(DevicePrograms, V4l2CtlStreamsAndLists) {
    passes("v4l2-ctl -d /dev/video10 --stream-mmap --stream-count=10");
    says("v4l2-ctl --list-devices", "/dev/video10");
    passes("v4l2-ctl -d /dev/video10 -c brightness=7");
    says("v4l2-ctl -d /dev/video10 -C brightness", "brightness: 7");
    passes("v4l2-ctl -w -d /dev/video10 --stream-mmap --stream-count=5");  // through libv4l2 and so syscall()
}

TEST_F(DevicePrograms, FfmpegReads) {
    passes("ffmpeg -v error -f v4l2 -i /dev/video10 -frames:v 10 -f null -");
    passes(
        "ffmpeg -v error -f v4l2 -input_format mjpeg -framerate 10 -video_size 320x240 -i /dev/video10 -frames:v 5 -f "
        "null -");
}

TEST_F(DevicePrograms, GStreamerReads) {
    passes("gst-launch-1.0 -q v4l2src device=/dev/video10 num-buffers=10 ! video/x-raw,format=YUY2 ! fakesink");
    passes("gst-launch-1.0 -q v4l2src device=/dev/video10 num-buffers=5 ! image/jpeg,width=320 ! jpegdec ! fakesink");
}

// libc's fclose() closes the descriptor past the library; the next file gets its number.
TEST_F(DevicePrograms, AfterFcloseTheNumberIsAnotherFiles) {
    passes(R"(/usr/bin/python3 -c "
import ctypes, os
libc = ctypes.CDLL(None)
libc.fopen.restype = ctypes.c_void_p
libc.fclose.argtypes = libc.fileno.argtypes = [ctypes.c_void_p]
stream = libc.fopen(b'/dev/video10', b'r')
number = libc.fileno(stream)
assert libc.fclose(stream) == 0
fd = os.open('/proc/version', os.O_RDONLY)
assert fd == number
assert os.read(fd, 5) == b'Linux'
")");
}

TEST_F(DevicePrograms, TheShellSeesTheNodes) {
    says("sh -c 'ls /dev/video*'", "/dev/video10");
    says("ls -l /dev/video10", "81, 10");
    says("cat /sys/class/video4linux/video10/name", "lobby");
    says("readlink -f /dev/v4l/by-id/camrig-lobby-video-index0", "/dev/video10");
    passes("test -c /dev/video10");
}

// How desktop programs (Cheese, GNOME, GStreamer's device monitor) look for cameras.
TEST_F(DevicePrograms, LibudevFindsTheCamera) {
    passes(R"(/usr/bin/python3 -c "
import ctypes
udev = ctypes.CDLL('libudev.so.1')
def call(name, *arguments, text=False):
    function = getattr(udev, 'udev_' + name)
    function.restype = ctypes.c_char_p if text else ctypes.c_void_p
    return function(*[ctypes.c_void_p(a) if isinstance(a, int) else a for a in arguments])
context = call('new')
found = call('enumerate_new', context)
call('enumerate_add_match_subsystem', found, b'video4linux')
call('enumerate_scan_devices', found)
entry, cameras = call('enumerate_get_list_entry', found), []
while entry:
    device = call('device_new_from_syspath', context, call('list_entry_get_name', entry, text=True))
    cameras.append((call('device_get_devnode', device, text=True), call('device_get_sysattr_value', device, b'name', text=True),
                    call('device_get_property_value', device, b'ID_V4L_CAPABILITIES', text=True),
                    call('device_get_property_value', device, b'DEVLINKS', text=True)))
    entry = call('list_entry_get_next', entry)
assert cameras == [(b'/dev/video10', b'lobby', b':capture:', b'/dev/v4l/by-id/camrig-lobby-video-index0')], cameras
")");
}

TEST_F(DevicePrograms, AProgramOutlivesItsRig) {
    Outcome outcome;
    std::thread program([&] {
        outcome = run(rig.server->socket_path(), CAMRIG_TEST_CLIENT " /dev/video10 1000000 YUYV 640x480 unplug");
    });
    while (true) {
        const auto readers = rig.programs();
        if (!readers.empty() && readers[0].delivered > 5) break;
        std::this_thread::yield();
    }
    rig.server.reset();
    program.join();
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("unplugged"), std::string::npos);
}

// Python's subprocess uses vfork() and closes descriptors in the child: that must not touch the parent's devices.
TEST_F(DevicePrograms, AForkingProgramKeepsItsDevice) {
    passes(R"(/usr/bin/python3 -c "
import fcntl, os, struct, subprocess
fd = os.open('/dev/video10', os.O_RDWR)
QUERYCAP = 0x80685600
def card(): return fcntl.ioctl(fd, QUERYCAP, bytes(104))[16:21]
assert card() == b'lobby'
subprocess.run(['true'], check=True)
subprocess.run(['true'], close_fds=False, check=True)
if os.fork() == 0:
    os.close(fd); os._exit(0)
os.wait()
assert card() == b'lobby'
assert os.listdir('/sys/class/video4linux') == ['video10']
copy = os.dup(fd); os.close(fd); fd = copy
assert card() == b'lobby'
os.dup2(fd, 50); os.close(fd); fd = 50
assert card() == b'lobby'
os.close(fd)
try: card(); assert False
except OSError: pass
")");
}

}  // namespace
}  // namespace camrig::device
