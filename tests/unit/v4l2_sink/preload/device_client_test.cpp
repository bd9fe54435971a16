// The library's calls against a real server, in one process: what a program sees from open() to close().

#include <array>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>

#include "tests/unit/v4l2_sink/preload/test_rig.h"
#include "v4l2_sink/preload/client/device.h"
#include "v4l2_sink/preload/client/paths.h"

namespace camrig::device::device_client_test {
namespace {

constexpr int patience_ms = 10'000;

/// A program's view of one open device.
class Opened {
public:
    explicit Opened(int flags = O_RDWR) : fd_(device::open_device(10, flags)) {}
    ~Opened() { close(); }
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;

    void close() {
        if (fd_ < 0) return;
        device::unbind_fd(fd_);
        ::close(fd_);
        fd_ = -1;
    }
    int fd() const { return fd_; }
    template <typename T>
    int call(unsigned request, T& argument) {
        const device::Ref device(fd_);
        return device.get() == nullptr ? EBADF : device::device_ioctl(*device.get(), fd_, request, &argument);
    }
    int set_format(std::uint32_t fourcc, unsigned width, unsigned height) {
        v4l2_format format{};
        format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        format.fmt.pix.pixelformat = fourcc;
        format.fmt.pix.width = width;
        format.fmt.pix.height = height;
        return call(VIDIOC_S_FMT, format);
    }
    int set_rate(unsigned per_second) {
        v4l2_streamparm parm{};
        parm.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        parm.parm.capture.timeperframe = {1, per_second};
        return call(VIDIOC_S_PARM, parm);
    }
    int request(unsigned count) {
        v4l2_requestbuffers request{};
        request.count = count;
        request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        request.memory = V4L2_MEMORY_MMAP;
        return call(VIDIOC_REQBUFS, request);
    }
    int queue(unsigned index) {
        v4l2_buffer buffer = blank();
        buffer.index = index;
        return call(VIDIOC_QBUF, buffer);
    }
    int dequeue(v4l2_buffer& buffer) {
        buffer = blank();
        return call(VIDIOC_DQBUF, buffer);
    }
    int stream(bool on) {
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        return call(on ? VIDIOC_STREAMON : VIDIOC_STREAMOFF, type);
    }
    int start(unsigned buffers = 4) {
        if (const int problem = request(buffers)) return problem;
        for (unsigned i = 0; i < buffers; ++i)
            if (const int problem = queue(i)) return problem;
        return stream(true);
    }
    short poll_now(int timeout_ms = 0) {
        pollfd wait{fd_, POLLIN, 0};
        return ::poll(&wait, 1, timeout_ms) > 0 ? wait.revents : short{0};
    }
    /// Some luma code of a YUYV picture below the strip.
    int luma(const v4l2_buffer& buffer) {
        const device::Ref device(fd_);
        return device.get()->buffers[buffer.index].memory[buffer.bytesused - 2];
    }

private:
    static v4l2_buffer blank() {
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        buffer.memory = V4L2_MEMORY_MMAP;
        return buffer;
    }
    int fd_;
};

std::shared_ptr<const fault::FrameFaults> frame_faults(fault::FaultKind kind) {
    auto one = std::make_shared<const fault::Fault>(fault::Fault{.id = 1, .kind = std::move(kind)});
    return std::make_shared<const fault::FrameFaults>(fault::FrameFaults{.frame = {}, .active = {std::move(one)}});
}

class DeviceClientTest : public testing::Test {
protected:
    DeviceClientTest() {
        ::setenv("CAMRIG_DEVICE_SOCKET", rig.server->socket_path().c_str(), 1);
        device::read_environment();
    }
    TestRig rig;
};

TEST_F(DeviceClientTest, AProgramReadsPicturesInOrder) {
    Opened program;
    ASSERT_GE(program.fd(), 0);
    ASSERT_EQ(program.start(), 0);
    TimeNs last = 0;
    for (unsigned n = 0; n < 20; ++n) {
        rig.show();
        v4l2_buffer buffer;
        ASSERT_EQ(program.dequeue(buffer), 0);
        EXPECT_EQ(buffer.sequence, n);
        EXPECT_EQ(buffer.bytesused, 320u * 240 * 2);
        const TimeNs stamp = buffer.timestamp.tv_sec * ns_per_s + buffer.timestamp.tv_usec * ns_per_us;
        EXPECT_GT(stamp, last);
        last = stamp;
        ASSERT_EQ(program.queue(buffer.index), 0);
    }
}

// Whether or not the server has heard of it yet.
TEST_F(DeviceClientTest, APictureThatAFailingStreamBeginsWithNeverComes) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.show();
    v4l2_buffer buffer;
    ASSERT_EQ(program.dequeue(buffer), 0);
    rig.maker.faults = frame_faults(fault::DeviceError{.at = fault::DeviceCall::streaming});
    rig.show();
    EXPECT_EQ(program.dequeue(buffer), EIO);
    EXPECT_EQ(program.queue(0), EIO);
    rig.maker.faults = nullptr;
    rig.show();
    EXPECT_EQ(program.dequeue(buffer), EIO);
    ASSERT_EQ(program.stream(false), 0);
    for (unsigned i = 0; i < 4; ++i) ASSERT_EQ(program.queue(i), 0);
    ASSERT_EQ(program.stream(true), 0);
    rig.show();
    EXPECT_EQ(program.dequeue(buffer), 0);
}

TEST_F(DeviceClientTest, APictureOfAnUnpluggedDeviceNeverComes) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.maker.faults = frame_faults(fault::Unplug{});
    rig.show();
    const auto received = [&] {
        stream::RigReport report;
        report.cameras.emplace_back().name = "lobby";
        rig.bus.fill_report(report);
        const stream::OutputReport& output = report.cameras[0].outputs.at(0);
        return output.encoded + output.kept_back;
    };
    for (int i = 0; i < patience_ms && received() == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_EQ(received(), 1u);
    rig.maker.faults = nullptr;
    rig.show();
    v4l2_buffer buffer;
    ASSERT_EQ(program.dequeue(buffer), 0);
    EXPECT_NEAR(program.luma(buffer), 16 + PictureMaker::grey_of(1) * 219.0 / 255, 1);
}

// The fd is readable while, and only while, a picture can be dequeued.
TEST_F(DeviceClientTest, PollSaysWhenAPictureWaits) {
    Opened program(O_RDWR | O_NONBLOCK);
    ASSERT_EQ(program.start(2), 0);
    EXPECT_EQ(program.poll_now(), 0);
    v4l2_buffer buffer;
    EXPECT_EQ(program.dequeue(buffer), EAGAIN);
    rig.show();
    EXPECT_EQ(program.poll_now(patience_ms), POLLIN);
    EXPECT_EQ(program.poll_now(), POLLIN);
    ASSERT_EQ(program.dequeue(buffer), 0);
    EXPECT_EQ(program.poll_now(), 0);
    EXPECT_EQ(program.dequeue(buffer), EAGAIN);
}

TEST_F(DeviceClientTest, TheFdIsNeverWritable) {
    Opened program;
    pollfd wait{program.fd(), POLLOUT, 0};
    EXPECT_EQ(::poll(&wait, 1, 0), 0);
}

// A program that slept gets what is new, in order, and the gap shows in the sequence.
TEST_F(DeviceClientTest, ASleeperGetsTheNewestPicturesAndSeesTheGap) {
    Opened program;
    ASSERT_EQ(program.start(2), 0);
    constexpr int shown = 100;
    for (int n = 0; n < shown; ++n) {
        rig.show();
        // The bus drops pictures of its own when its workers are behind; here each shall reach the ring.
        const auto told = [&] { return rig.programs().at(0).delivered + rig.programs().at(0).dropped; };
        while (told() < static_cast<std::uint64_t>(n + 1)) std::this_thread::yield();
    }
    v4l2_buffer first, second, third;
    ASSERT_EQ(program.dequeue(first), 0);
    ASSERT_EQ(program.dequeue(second), 0);
    EXPECT_EQ(first.sequence, shown - 2u);
    EXPECT_EQ(second.sequence, shown - 1u);
    ASSERT_EQ(program.queue(first.index), 0);
    rig.show();
    ASSERT_EQ(program.dequeue(third), 0);
    EXPECT_EQ(third.sequence, static_cast<unsigned>(shown));
    while (rig.programs().at(0).delivered < 3) std::this_thread::yield();
    const stream::ReaderReport report = rig.programs().at(0);
    EXPECT_EQ(report.offered, report.delivered + report.dropped);
}

TEST_F(DeviceClientTest, EachPictureIsWholeAndTheRightOne) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    for (int n = 0; n < 30; ++n) {
        rig.show();
        v4l2_buffer buffer;
        ASSERT_EQ(program.dequeue(buffer), 0);
        const int grey = PictureMaker::grey_of(n);
        EXPECT_NEAR(program.luma(buffer), 16 + grey * 219.0 / 255, 1);
        ASSERT_EQ(program.queue(buffer.index), 0);
    }
}

TEST_F(DeviceClientTest, SmallerSizesAndOtherFormatsAreMadeForTheirReader) {
    for (const auto& [fourcc, bytes] :
         {std::pair{V4L2_PIX_FMT_YUV420, 160u * 120 * 3 / 2}, std::pair{V4L2_PIX_FMT_NV12, 160u * 120 * 3 / 2},
          std::pair{V4L2_PIX_FMT_BGR24, 160u * 120 * 3}}) {
        Opened program;
        ASSERT_EQ(program.set_format(fourcc, 160, 120), 0);
        ASSERT_EQ(program.start(), 0);
        rig.show();
        v4l2_buffer buffer;
        ASSERT_EQ(program.dequeue(buffer), 0);
        EXPECT_EQ(buffer.bytesused, bytes);
    }
}

// S_PARM decimates; what the program did not ask for is no loss.
TEST_F(DeviceClientTest, ALowerRateHasNoGaps) {
    Opened program;
    ASSERT_EQ(program.set_rate(10), 0);
    ASSERT_EQ(program.start(), 0);
    for (unsigned n = 0; n < 10; ++n) {
        for (int i = 0; i < 3; ++i) rig.show();
        v4l2_buffer buffer;
        ASSERT_EQ(program.dequeue(buffer), 0);
        EXPECT_EQ(buffer.sequence, n);
        ASSERT_EQ(program.queue(buffer.index), 0);
    }
}

// Lockstep: the step is over when the program was sent the picture, and not before it has a buffer for it.
TEST_F(DeviceClientTest, InLockstepAPictureWaitsForABuffer) {
    Opened program(O_RDWR | O_NONBLOCK);
    ASSERT_EQ(program.start(2), 0);
    const auto step = [&] {
        auto latch = stream::DeliveryLatch::create();
        auto own = latch->hold("the test");
        rig.show(latch);
        own.release();
        return latch;
    };
    const auto wait_open = [](const stream::DeliveryLatch& latch) {
        const TimeNs end = monotonic_now_ns() + patience_ms * ns_per_ms;
        while (!latch.is_open() && monotonic_now_ns() < end) std::this_thread::yield();
        return latch.is_open();
    };
    EXPECT_TRUE(wait_open(*step()));
    EXPECT_TRUE(wait_open(*step()));
    const auto third = step();  // both buffers hold a picture now
    while (rig.programs().at(0).offered < 3 || third->holders().size() > 1) std::this_thread::yield();
    ASSERT_EQ(third->holders().size(), 1u);
    EXPECT_NE(third->holders()[0].find("/dev/video10"), std::string::npos);
    for (unsigned n = 0; n < 3; ++n) {
        v4l2_buffer buffer;
        ASSERT_EQ(program.poll_now(patience_ms), POLLIN);
        ASSERT_EQ(program.dequeue(buffer), 0);
        EXPECT_EQ(buffer.sequence, n);
        ASSERT_EQ(program.queue(buffer.index), 0);
    }
    EXPECT_TRUE(wait_open(*third));
    EXPECT_EQ(rig.programs().at(0).dropped, 0u);
}

TEST_F(DeviceClientTest, AReaderThatLeavesDoesNotHoldTheStep) {
    Opened program;
    ASSERT_EQ(program.request(2), 0);
    ASSERT_EQ(program.stream(true), 0);  // no buffer queued
    auto latch = stream::DeliveryLatch::create();
    rig.show(latch);
    while (rig.programs().at(0).offered < 1) std::this_thread::yield();
    EXPECT_FALSE(latch->is_open());
    program.close();
    const TimeNs end = monotonic_now_ns() + patience_ms * ns_per_ms;
    while (!latch->is_open() && monotonic_now_ns() < end) std::this_thread::yield();
    EXPECT_TRUE(latch->is_open());
}

TEST_F(DeviceClientTest, ARigThatGoesIsAnUnpluggedCamera) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.server.reset();
    v4l2_buffer buffer;
    EXPECT_EQ(program.dequeue(buffer), ENODEV);
    EXPECT_NE(program.poll_now(patience_ms) & POLLHUP, 0);
    v4l2_control control{V4L2_CID_BRIGHTNESS, 1};
    EXPECT_EQ(program.call(VIDIOC_S_CTRL, control), ENODEV);
    EXPECT_LT(device::open_device(10, O_RDWR), 0);
}

TEST_F(DeviceClientTest, ADeletedCameraIsAnUnpluggedCamera) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.bus.remove_camera(CameraId{1});
    v4l2_buffer buffer;
    EXPECT_EQ(program.dequeue(buffer), ENODEV);
}

TEST_F(DeviceClientTest, ARemovedDeviceIsAnUnpluggedCamera) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.server->remove_device(10);
    v4l2_buffer buffer;
    EXPECT_EQ(program.dequeue(buffer), ENODEV);
    EXPECT_EQ(device::open_device(10, O_RDWR), -ENODEV);
}

// The number of a closed socket may be a stranger's connection at once: nobody may send to it any more by then. What
// waits for the reader goes when the ring lets go of it, and then the socket must still be there.
TEST_F(DeviceClientTest, TheRingLetsGoOfAReaderBeforeItsSocketIsClosed) {
    Opened program;
    ASSERT_EQ(program.request(2), 0);
    ASSERT_EQ(program.stream(true), 0);  // no buffer queued: the picture waits
    std::atomic<bool> is_armed = false, was_closed = false;
    auto latch = stream::DeliveryLatch::create(
        [&] { was_closed = was_closed || (is_armed && (program.poll_now() & POLLHUP) != 0); });
    rig.show(latch);
    while (rig.programs().at(0).offered < 1) std::this_thread::yield();
    ASSERT_FALSE(latch->is_open());
    is_armed = true;
    rig.server->remove_device(10);
    EXPECT_NE(program.poll_now(patience_ms) & POLLHUP, 0);
    EXPECT_TRUE(latch->is_open());
    EXPECT_FALSE(was_closed);
}

// A format holds for as long as a program reads; the pictures are scaled to it.
TEST_F(DeviceClientTest, AStreamGoesOnWhenItsCameraChangesSize) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    stream::CameraStream bigger = rig.maker.camera();
    bigger.size = {640, 480};
    rig.bus.change_camera(bigger);
    PictureMaker maker(bigger);
    const TimeNs end = monotonic_now_ns() + patience_ms * ns_per_ms;
    bool came = false;
    for (int n = 0; !came && monotonic_now_ns() < end; ++n) {
        frame::FrameSet set;
        set.world_ns = bigger.rate.time_of_frame(n);
        set.monotonic_ns = monotonic_now_ns();
        set.frames.push_back(maker.make(n, set.world_ns, set.monotonic_ns));
        rig.bus.publish(set, nullptr);
        came = program.poll_now(10) == POLLIN;
    }
    v4l2_buffer buffer;
    ASSERT_TRUE(came);
    ASSERT_EQ(program.dequeue(buffer), 0);
    EXPECT_EQ(buffer.bytesused, 320u * 240 * 2);
}

TEST_F(DeviceClientTest, TwoOpenersOfOneProgramShareOneQueue) {
    Opened first, second;
    ASSERT_EQ(first.request(4), 0);
    EXPECT_EQ(second.request(4), EBUSY);
    EXPECT_EQ(second.stream(true), EBUSY);
    EXPECT_EQ(second.set_format(V4L2_PIX_FMT_NV12, 160, 120), EBUSY);
    ASSERT_EQ(first.request(0), 0);
    EXPECT_EQ(second.request(4), 0);
}

// A device has one format, however many descriptors lead to it.
TEST_F(DeviceClientTest, AnOpenerReadsInTheFormatThatAnotherOneOfItsProgramChose) {
    Opened chooser, reader;
    ASSERT_EQ(chooser.set_format(V4L2_PIX_FMT_NV12, 160, 120), 0);
    ASSERT_EQ(chooser.set_rate(10), 0);
    ASSERT_EQ(reader.start(), 0);
    for (int n = 0; n < 4; ++n) rig.show();
    v4l2_buffer buffer;
    ASSERT_EQ(reader.dequeue(buffer), 0);
    EXPECT_EQ(buffer.bytesused, 160u * 120 * 3 / 2);
    ASSERT_EQ(reader.dequeue(buffer), 0);
    EXPECT_EQ(buffer.sequence, 1u);  // of each third picture
    ASSERT_EQ(reader.stream(false), 0);
    ASSERT_EQ(reader.request(0), 0);

    ASSERT_EQ(chooser.set_format(V4L2_PIX_FMT_YUYV, 320, 240), 0);
    v4l2_create_buffers more{};
    more.count = 1;
    more.memory = V4L2_MEMORY_MMAP;
    more.format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    more.format.fmt.pix.sizeimage = 160 * 120 * 3 / 2;
    EXPECT_EQ(reader.call(VIDIOC_CREATE_BUFS, more), EINVAL);
    more.format.fmt.pix.sizeimage = 320 * 240 * 2;
    EXPECT_EQ(reader.call(VIDIOC_CREATE_BUFS, more), 0);
}

// vb2 looks at the type alone, and some programs leave the rest zero.
TEST_F(DeviceClientTest, DequeuingNeedsNoKindOfMemoryAndQueuingDoes) {
    Opened program;
    ASSERT_EQ(program.start(), 0);
    rig.show();
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    ASSERT_EQ(program.call(VIDIOC_DQBUF, buffer), 0);
    EXPECT_EQ(buffer.memory, static_cast<unsigned>(V4L2_MEMORY_MMAP));
    buffer.memory = 0;
    EXPECT_EQ(program.call(VIDIOC_PREPARE_BUF, buffer), EINVAL);
    EXPECT_EQ(program.call(VIDIOC_QBUF, buffer), EINVAL);
}

TEST_F(DeviceClientTest, ControlsReachTheRigAndOthersHearOfIt) {
    Opened setter, listener(O_RDWR | O_NONBLOCK);
    v4l2_event_subscription requested{};
    requested.type = V4L2_EVENT_CTRL;
    requested.id = V4L2_CID_PAN_ABSOLUTE;
    ASSERT_EQ(listener.call(VIDIOC_SUBSCRIBE_EVENT, requested), 0);
    v4l2_control control{V4L2_CID_PAN_ABSOLUTE, 7300};
    ASSERT_EQ(setter.call(VIDIOC_S_CTRL, control), 0);
    EXPECT_EQ(control.value, 7200);  // steps of a degree
    EXPECT_EQ(rig.controls->get("lobby", V4L2_CID_PAN_ABSOLUTE).value(), 7200);
    v4l2_event event{};
    ASSERT_EQ(listener.call(VIDIOC_DQEVENT, event), 0);
    EXPECT_EQ(event.id, V4L2_CID_PAN_ABSOLUTE);
    EXPECT_EQ(event.u.ctrl.value, 7200);
    EXPECT_EQ(listener.call(VIDIOC_DQEVENT, event), ENOENT);
    v4l2_control wrong{V4L2_CID_EXPOSURE_AUTO, 2};  // a hole in the menu
    EXPECT_EQ(setter.call(VIDIOC_S_CTRL, wrong), EINVAL);
}

// STREAMOFF from another thread wakes a waiting DQBUF; nothing hangs, whatever the order (thread sanitizer).
TEST_F(DeviceClientTest, StoppingWakesAWaitingReader) {
    Opened program;
    for (int round = 0; round < 20; ++round) {
        ASSERT_EQ(program.start(), 0);
        int result = 0;
        std::thread reader([&] {
            v4l2_buffer buffer;
            while ((result = program.dequeue(buffer)) == 0) program.queue(buffer.index);
        });
        for (int n = 0; n < round % 5; ++n) rig.show();
        EXPECT_EQ(program.stream(false), 0);
        reader.join();
        EXPECT_EQ(result, EINVAL);
    }
}

// What wakes two waiting threads is over once both have seen it: else they would find it again and again.
TEST_F(DeviceClientTest, TwoWaitingReadersRestAfterABufferWasQueued) {
    Opened program;
    ASSERT_EQ(program.request(2), 0);
    ASSERT_EQ(program.stream(true), 0);
    const device::Ref device(program.fd());
    std::array<std::thread, 2> readers;
    for (std::thread& reader : readers)
        reader = std::thread([&] {
            v4l2_buffer buffer;
            EXPECT_EQ(program.dequeue(buffer), EINVAL);
        });
    const auto wait_for = [](const auto& condition) {
        const TimeNs end = monotonic_now_ns() + patience_ms * ns_per_ms;
        while (!condition() && monotonic_now_ns() < end) std::this_thread::yield();
        return condition();
    };
    const auto both_wait = [&] {
        const device::Locked guard(device.get()->lock);
        return device.get()->waiters == 2;
    };
    EXPECT_TRUE(wait_for(both_wait));
    EXPECT_EQ(program.queue(0), 0);
    EXPECT_TRUE(wait_for([&] {
        pollfd woken{device.get()->wake_fd, POLLIN, 0};
        return both_wait() && ::poll(&woken, 1, 0) == 0;
    }));
    EXPECT_EQ(program.stream(false), 0);
    for (std::thread& reader : readers) reader.join();
}

TEST_F(DeviceClientTest, ThreadsMayShareADevice) {
    Opened program;
    ASSERT_EQ(program.start(8), 0);
    std::atomic<bool> stop{false};
    std::thread camera([&] {
        while (!stop) rig.show();
    });
    std::thread controller([&] {
        for (int i = 0; !stop; ++i) {
            v4l2_control control{V4L2_CID_BRIGHTNESS, i % 60};
            program.call(VIDIOC_S_CTRL, control);
        }
    });
    std::array<std::thread, 2> readers;
    for (std::thread& reader : readers)
        reader = std::thread([&] {
            for (int n = 0; n < 200; ++n) {
                v4l2_buffer buffer;
                ASSERT_EQ(program.dequeue(buffer), 0);
                ASSERT_EQ(buffer.flags & V4L2_BUF_FLAG_ERROR, 0u);
                ASSERT_EQ(program.queue(buffer.index), 0);
            }
        });
    for (std::thread& reader : readers) reader.join();
    stop = true;
    camera.join();
    controller.join();
}

// ".." leads from a folder to the one it is in, and from a link's folder to the one where the link leads.
TEST_F(DeviceClientTest, NamesWithDotsAreThoseThatTheKernelWouldFind) {
    const auto found = [](const char* name) {
        device::Place place;
        device::find_place(AT_FDCWD, name, place);
        switch (place.kind) {
            case device::PlaceKind::node:
                return "node " + std::to_string(place.number);
            case device::PlaceKind::file:
                return std::string(std::strstr(place.path, ".tree") + 5);
            default:
                return std::string("foreign");
        }
    };
    EXPECT_EQ(found("/dev/v4l/by-id/../../video10"), "node 10");
    EXPECT_EQ(found("/dev/./v4l//../video10"), "node 10");
    EXPECT_EQ(found("/../dev/video10"), "foreign");  // as all that does not begin like a device
    EXPECT_EQ(found("/dev/../../dev/video10"), "node 10");
    EXPECT_EQ(found("/sys/dev/char/81:10/../video10/name"), "/sys/class/video4linux/video10/name");
    EXPECT_EQ(found("/sys/class/video4linux/video10/subsystem/../video4linux/video10/dev"),
              "/sys/class/video4linux/video10/dev");
    EXPECT_EQ(found("/dev/video10/../video10"), "foreign");  // not a folder
    EXPECT_EQ(found("/dev/v4l/by-id/camrig-lobby-video-index0/../../video10"), "foreign");
    EXPECT_EQ(found("/dev/nothing/../video10"), "foreign");
    EXPECT_EQ(found("/dev/../etc/passwd"), "foreign");
    EXPECT_EQ(found("/dev/../../devices.sock"), "foreign");
}

TEST_F(DeviceClientTest, ManyMayReadAtOnce) {
    std::vector<std::unique_ptr<Opened>> programs;
    for (int i = 0; i < 100; ++i) {
        programs.push_back(std::make_unique<Opened>());
        ASSERT_GE(programs.back()->fd(), 0) << i;
    }
    ASSERT_EQ(programs.back()->start(), 0);
    rig.show();
    v4l2_buffer buffer;
    EXPECT_EQ(programs.back()->dequeue(buffer), 0);
}

TEST_F(DeviceClientTest, OpeningAndClosingLeaksNoDescriptors) {
    const auto count = [] {
        return std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                             std::filesystem::directory_iterator());
    };
    const auto cycle = [&] {
        Opened program;
        ASSERT_EQ(program.start(), 0);
    };
    cycle();
    const TimeNs end = monotonic_now_ns() + patience_ms * ns_per_ms;
    const auto before = [&] {
        Opened program;  // the server has closed its ends of those before
        EXPECT_EQ(program.start(), 0);
        return count();
    }();
    for (int i = 0; i < 200; ++i) cycle();
    Opened program;
    ASSERT_EQ(program.start(), 0);
    while (count() != before && monotonic_now_ns() < end) std::this_thread::yield();
    EXPECT_EQ(count(), before);
}

}  // namespace
}  // namespace camrig::device::device_client_test
