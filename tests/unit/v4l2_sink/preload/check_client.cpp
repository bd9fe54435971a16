// A V4L2 program that knows nothing of camrig and trusts nothing: it checks what ROS usb_cam and v4l2_camera, OpenCV
// and libwebrtc rely on, and that every picture is whole and in order.
//
//   check_client DEVICE FRAMES FOURCC WIDTHxHEIGHT [hold] [slow] [unplug]
//     hold    looks at each picture again after a while: it must not change while the program has the buffer
//     slow    sleeps between pictures, so that some are lost
//     unplug  expects the device to vanish; success is a clean ENODEV
// Exit 0 and one line of numbers, or 1 and the reason.

#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <span>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/frame/code_strip.h"

namespace {

constexpr unsigned buffer_count = 4;  // usb_cam has room for exactly four

[[noreturn]] void die(const char* format, ...) {
    va_list rest;
    va_start(rest, format);
    std::vfprintf(stderr, format, rest);
    va_end(rest);
    std::fprintf(stderr, " (errno %d %s)\n", errno, std::strerror(errno));
    std::exit(1);
}

int xioctl(int fd, unsigned long request, void* argument) {
    int result;
    do result = ioctl(fd, request, argument);
    while (result < 0 && errno == EINTR);
    return result;
}

std::int64_t now_us() {
    timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
}

void check_modes(int fd, unsigned fourcc, unsigned width, unsigned height) {
    bool format = false, size = false;
    v4l2_fmtdesc desc{};
    desc.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; xioctl(fd, VIDIOC_ENUM_FMT, &desc) == 0; ++desc.index) format = format || desc.pixelformat == fourcc;
    if (!format) die("format not listed");
    v4l2_frmsizeenum frame_size{};
    frame_size.pixel_format = fourcc;
    for (; xioctl(fd, VIDIOC_ENUM_FRAMESIZES, &frame_size) == 0; ++frame_size.index) {
        if (frame_size.type != V4L2_FRMSIZE_TYPE_DISCRETE) die("size not discrete");
        size = size || (frame_size.discrete.width == width && frame_size.discrete.height == height);
    }
    if (!size) die("size not listed");
    v4l2_frmivalenum interval{};
    interval.pixel_format = fourcc;
    interval.width = width;
    interval.height = height;
    for (; xioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index)
        if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) die("interval not discrete");
    if (interval.index == 0) die("no intervals listed");
}

camrig::frame::PixelFormat layout_of(unsigned fourcc) {
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
            return camrig::frame::PixelFormat::yuyv;
        case V4L2_PIX_FMT_BGR24:
            return camrig::frame::PixelFormat::bgr24;
        case V4L2_PIX_FMT_NV12:
            return camrig::frame::PixelFormat::nv12;
        default:
            return camrig::frame::PixelFormat::i420;
    }
}

/// All luma (or BGR) codes below the strip are one value, the picture's.
bool uniform(const std::uint8_t* bytes, unsigned fourcc, unsigned width, unsigned height) {
    const unsigned step = fourcc == V4L2_PIX_FMT_YUYV ? 2 : 1;
    const unsigned per_pixel = fourcc == V4L2_PIX_FMT_YUYV ? 2 : fourcc == V4L2_PIX_FMT_BGR24 ? 3 : 1;
    const unsigned strip =
        4 * static_cast<unsigned>(camrig::frame::code_strip_cell({static_cast<int>(width), static_cast<int>(height)}));
    const std::size_t begin = std::size_t{strip} * width * per_pixel, end = std::size_t{height} * width * per_pixel;
    for (std::size_t i = begin; i < end; i += step)
        if (bytes[i] != bytes[begin]) return false;
    return true;
}

// What a program finds whose device has vanished: calls that fail, and an end in peace. Its exit status.
int leave_unplugged(int fd, long pictures) {
    pollfd wait{fd, POLLIN, 0};
    if (poll(&wait, 1, 0) != 1 || (wait.revents & (POLLHUP | POLLERR)) == 0) die("no POLLHUP");
    wait.events = POLLPRI;  // beside POLLHUP, as v4l2_poll() has it
    if (poll(&wait, 1, 0) != 1 || (wait.revents & POLLPRI) == 0) die("no POLLPRI");
    fd_set other;
    FD_ZERO(&other);
    FD_SET(fd, &other);
    timeval now{0, 0};
    if (select(fd + 1, nullptr, nullptr, &other, &now) != 1 || !FD_ISSET(fd, &other)) die("select of exceptions");
    v4l2_capability again{};
    v4l2_control control{V4L2_CID_BRIGHTNESS, 0};
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    xioctl(fd, VIDIOC_QUERYCAP, &again);
    if (xioctl(fd, VIDIOC_S_CTRL, &control) == 0) die("a control was set on nothing");
    if (xioctl(fd, VIDIOC_STREAMOFF, &type) != 0 && errno != ENODEV) die("STREAMOFF");
    if (close(fd) != 0) die("close");
    std::printf("unplugged after %ld\n", pictures);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 5) return 2;
    const char* name = argv[1];
    const long frames = std::atol(argv[2]);
    const unsigned fourcc = v4l2_fourcc(argv[3][0], argv[3][1], argv[3][2], argv[3][3]);
    unsigned width = 0, height = 0;
    std::sscanf(argv[4], "%ux%u", &width, &height);
    bool hold = false, slow = false, unplug = false;
    for (int i = 5; i < argc; ++i) {
        hold = hold || std::strcmp(argv[i], "hold") == 0;
        slow = slow || std::strcmp(argv[i], "slow") == 0;
        unplug = unplug || std::strcmp(argv[i], "unplug") == 0;
    }

    struct stat info;
    if (stat(name, &info) != 0) die("stat %s", name);
    if (!S_ISCHR(info.st_mode)) die("%s is no device", name);
    const int fd = open(name, O_RDWR | O_NONBLOCK);
    if (fd < 0) die("open %s", name);
    if (fstat(fd, &info) != 0 || !S_ISCHR(info.st_mode)) die("the descriptor is no device");
    v4l2_capability capability{};
    if (xioctl(fd, VIDIOC_QUERYCAP, &capability) != 0) die("QUERYCAP");
    if ((capability.device_caps & V4L2_CAP_VIDEO_CAPTURE) == 0 ||
        (capability.device_caps & V4L2_CAP_VIDEO_OUTPUT) != 0 || (capability.device_caps & V4L2_CAP_STREAMING) == 0)
        die("capabilities %x", capability.device_caps);
    v4l2_cropcap cropcap{};
    cropcap.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    xioctl(fd, VIDIOC_CROPCAP, &cropcap);
    check_modes(fd, fourcc, width, height);

    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = fourcc;
    if (xioctl(fd, VIDIOC_S_FMT, &format) != 0) die("S_FMT");
    if (format.fmt.pix.width != width || format.fmt.pix.height != height || format.fmt.pix.pixelformat != fourcc)
        die("S_FMT gave %ux%u", format.fmt.pix.width, format.fmt.pix.height);
    v4l2_streamparm parm{};
    parm.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (xioctl(fd, VIDIOC_G_PARM, &parm) != 0) die("G_PARM");

    v4l2_requestbuffers request{};
    request.count = buffer_count;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (xioctl(fd, VIDIOC_REQBUFS, &request) != 0) die("REQBUFS");
    if (request.count != buffer_count) die("REQBUFS gave %u buffers", request.count);
    void* memory[buffer_count];
    for (unsigned i = 0; i < buffer_count; ++i) {
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        buffer.memory = V4L2_MEMORY_MMAP;
        buffer.index = i;
        if (xioctl(fd, VIDIOC_QUERYBUF, &buffer) != 0) die("QUERYBUF");
        memory[i] = mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, buffer.m.offset);
        if (memory[i] == MAP_FAILED) die("mmap");
        if (xioctl(fd, VIDIOC_QBUF, &buffer) != 0) die("QBUF");
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (xioctl(fd, VIDIOC_STREAMON, &type) != 0) die("STREAMON");

    long lost = 0, spurious = 0;
    std::int64_t last_stamp = 0, last_strip = -1, worst_age = 0;
    long last_sequence = -1;
    for (long n = 0; n < frames; ++n) {
        fd_set readable;
        FD_ZERO(&readable);
        FD_SET(fd, &readable);
        timeval limit{5, 0};
        const int ready = select(fd + 1, &readable, nullptr, nullptr, &limit);
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) die("no picture within 5 s after %ld", n);
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        buffer.memory = V4L2_MEMORY_MMAP;
        if (xioctl(fd, VIDIOC_DQBUF, &buffer) != 0) {
            if (errno == ENODEV && unplug) return leave_unplugged(fd, n);
            if (errno != EAGAIN) die("DQBUF after %ld", n);
            ++spurious;
            continue;
        }
        if (buffer.index >= buffer_count) die("index %u", buffer.index);
        if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) die("picture %ld with the error flag", n);
        if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
            die("clock of the stamp");
        const std::int64_t stamp = std::int64_t{buffer.timestamp.tv_sec} * 1'000'000 + buffer.timestamp.tv_usec;
        const std::int64_t age = now_us() - stamp;
        if (stamp <= last_stamp) die("stamp not rising after %ld", n);
        if (age < 0 || age > 10'000'000) die("stamp is %lld us old", static_cast<long long>(age));
        if (age > worst_age) worst_age = age;
        last_stamp = stamp;
        if (last_sequence >= 0) {
            if (static_cast<long>(buffer.sequence) <= last_sequence)
                die("sequence %u after %ld", buffer.sequence, last_sequence);
            lost += static_cast<long>(buffer.sequence) - last_sequence - 1;
        }
        last_sequence = buffer.sequence;
        const auto* bytes = static_cast<const std::uint8_t*>(memory[buffer.index]);
        if (fourcc == V4L2_PIX_FMT_MJPEG) {
            if (buffer.bytesused < 100 || bytes[0] != 0xff || bytes[1] != 0xd8 || bytes[buffer.bytesused - 2] != 0xff ||
                bytes[buffer.bytesused - 1] != 0xd9)
                die("picture %ld is no JPEG", n);
        } else {
            if (buffer.bytesused != format.fmt.pix.sizeimage) die("bytesused %u", buffer.bytesused);
            const auto strip =
                camrig::frame::read_code_strip(std::as_bytes(std::span(bytes, buffer.bytesused)),
                                               {static_cast<int>(width), static_cast<int>(height)}, layout_of(fourcc));
            if (!uniform(bytes, fourcc, width, height)) die("picture %ld is torn", n);
            if (strip) {
                if (strip->sequence <= last_strip)
                    die("strip %u after %ld", strip->sequence, static_cast<long>(last_strip));
                last_strip = strip->sequence;
            } else if (camrig::frame::code_strip_cell({static_cast<int>(width), static_cast<int>(height)}) > 0) {
                die("picture %ld has no readable strip", n);
            }
            if (hold) {
                const std::uint8_t seen = bytes[buffer.bytesused - 2];
                usleep(300'000);
                if (!uniform(bytes, fourcc, width, height) || bytes[buffer.bytesused - 2] != seen)
                    die("picture %ld changed while it was ours", n);
            }
        }
        if (slow) usleep(120'000);
        // It may vanish at any call, not only while a picture is waited for.
        const bool goes_on = xioctl(fd, VIDIOC_G_FMT, &format) == 0 && xioctl(fd, VIDIOC_QBUF, &buffer) == 0;
        if (!goes_on && errno == ENODEV && unplug) return leave_unplugged(fd, n + 1);
        if (!goes_on) die("G_FMT and QBUF while streaming, after %ld", n);
    }
    if (unplug) die("was not unplugged");
    if (xioctl(fd, VIDIOC_STREAMOFF, &type) != 0) die("STREAMOFF");
    close(fd);
    std::printf("frames %ld lost %ld spurious %ld worst_age_us %lld\n", frames, lost, spurious,
                static_cast<long long>(worst_age));
}
