#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include "core/base/clock.h"
#include "core/base/unique_fd.h"
#include "tools/probe/gray.h"
#include "tools/probe/source.h"

// A V4L2 capture program like any other: nothing here knows whether the device is a real one or the rig's.
namespace camrig::probe {
namespace {

constexpr unsigned buffer_count = 4;
constexpr std::size_t max_buffers = 32;  // VIDEO_MAX_FRAME

int xioctl(int fd, unsigned long request, void* argument) {
    int result;
    do result = ::ioctl(fd, request, argument);
    while (result < 0 && errno == EINTR);
    return result;
}

std::string fourcc_text(std::uint32_t fourcc) {
    std::string text;
    for (int i = 0; i < 4; ++i) {
        const char letter = static_cast<char>((fourcc >> (8 * i)) & 0x7f);
        text += letter < 0x20 ? '?' : letter;
    }
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

class DeviceSource final : public Source {
public:
    explicit DeviceSource(UniqueFd fd) : fd_(std::move(fd)) {}
    ~DeviceSource() override {
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (streaming_) xioctl(fd_.get(), VIDIOC_STREAMOFF, &type);
        for (const std::span<std::byte> buffer : buffers_) ::munmap(buffer.data(), buffer.size());
    }

    Result<void> begin(const std::string& format) {
        v4l2_capability capability{};
        if (xioctl(fd_.get(), VIDIOC_QUERYCAP, &capability) != 0) return failed("is no V4L2 device");
        const std::uint32_t can =
            (capability.capabilities & V4L2_CAP_DEVICE_CAPS) ? capability.device_caps : capability.capabilities;
        if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0)
            return error(ErrorKind::unsupported, "does not stream pictures (single-planar V4L2 capture)");
        if (auto chosen = choose_format(format); !chosen) return chosen;
        if (auto queued = queue_buffers(); !queued) return queued;
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (xioctl(fd_.get(), VIDIOC_STREAMON, &type) != 0) return failed("VIDIOC_STREAMON");
        streaming_ = true;
        return {};
    }

    std::string_view kind() const override { return "device"; }
    std::string format() const override { return fourcc_text(format_.pixelformat); }
    bool stamps_are_monotonic() const override { return monotonic_; }

    Result<std::optional<ProbedPicture>> next(TimeNs until_ns) override {
        if (auto back = give_back(); !back) return std::unexpected(back.error());
        for (;;) {
            v4l2_buffer buffer = blank();
            if (xioctl(fd_.get(), VIDIOC_DQBUF, &buffer) == 0) return picture_of(buffer);
            if (errno == ENODEV) return error(ErrorKind::unavailable, "was unplugged");
            if (errno != EAGAIN) return std::unexpected(failed("VIDIOC_DQBUF").error());
            const TimeNs left = until_ns - monotonic_now_ns();
            if (left <= 0) return std::nullopt;
            pollfd wait{fd_.get(), POLLIN, 0};
            ::poll(&wait, 1, static_cast<int>((left + ns_per_ms - 1) / ns_per_ms));
        }
    }

private:
    static v4l2_buffer blank() {
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        buffer.memory = V4L2_MEMORY_MMAP;
        return buffer;
    }
    Result<void> failed(const std::string& what) const {
        return error(errno == EBUSY ? ErrorKind::unavailable : ErrorKind::internal, what + ": " + std::strerror(errno));
    }

    Result<void> choose_format(const std::string& wanted) {
        v4l2_format format{};
        format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (xioctl(fd_.get(), VIDIOC_G_FMT, &format) != 0) return failed("VIDIOC_G_FMT");
        if (!wanted.empty()) {
            std::array<char, 4> letters{' ', ' ', ' ', ' '};
            std::copy_n(wanted.begin(), std::min<std::size_t>(wanted.size(), 4), letters.begin());
            format.fmt.pix.pixelformat = v4l2_fourcc(letters[0], letters[1], letters[2], letters[3]);
            const std::uint32_t asked = format.fmt.pix.pixelformat;
            if (xioctl(fd_.get(), VIDIOC_S_FMT, &format) != 0) return failed("VIDIOC_S_FMT " + wanted);
            if (format.fmt.pix.pixelformat != asked)
                return error(ErrorKind::unsupported, "does not offer the format " + wanted);
        }
        format_ = format.fmt.pix;
        return {};
    }

    Result<void> queue_buffers() {
        v4l2_requestbuffers request{};
        request.count = buffer_count;
        request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        request.memory = V4L2_MEMORY_MMAP;
        if (xioctl(fd_.get(), VIDIOC_REQBUFS, &request) != 0) return failed("VIDIOC_REQBUFS");
        for (unsigned i = 0; i < std::min<std::size_t>(request.count, max_buffers); ++i) {
            v4l2_buffer buffer = blank();
            buffer.index = i;
            if (xioctl(fd_.get(), VIDIOC_QUERYBUF, &buffer) != 0) return failed("VIDIOC_QUERYBUF");
            void* const memory = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_.get(),
                                        static_cast<off_t>(buffer.m.offset));
            if (memory == MAP_FAILED) return failed("mmap");
            buffers_.emplace_back(static_cast<std::byte*>(memory), buffer.length);
            if (xioctl(fd_.get(), VIDIOC_QBUF, &buffer) != 0) return failed("VIDIOC_QBUF");
        }
        return {};
    }

    std::optional<ProbedPicture> picture_of(const v4l2_buffer& buffer) {
        ProbedPicture picture;
        picture.arrival_ns = monotonic_now_ns();
        picture.stamp_ns = TimeNs{buffer.timestamp.tv_sec} * ns_per_s + TimeNs{buffer.timestamp.tv_usec} * ns_per_us;
        picture.sequence = buffer.sequence;
        monotonic_ = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
        picture.damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
        if (buffer.index < buffers_.size())
            decode(buffers_[buffer.index].first(std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].size())),
                   picture);
        held_ = buffer;
        return picture;
    }

    void decode(std::span<const std::byte> bytes, ProbedPicture& picture) {
        picture.size = {static_cast<int>(format_.width), static_cast<int>(format_.height)};
        if (format_.pixelformat == V4L2_PIX_FMT_MJPEG || format_.pixelformat == V4L2_PIX_FMT_JPEG) {
            picture.damaged = !gray_from_jpeg(bytes, picture.size, gray_) || picture.damaged;
        } else if (bytes.size() < format_.sizeimage) {
            picture.damaged = true;
        } else if (!gray_from_raw(format_.pixelformat, bytes, picture.size, format_.bytesperline, gray_)) {
            return;  // a format that the probe cannot look into
        }
        if (!picture.damaged) picture.gray = gray_;
    }

    /// The picture taken last belongs to the driver again.
    Result<void> give_back() {
        if (!held_) return {};
        v4l2_buffer buffer = *std::exchange(held_, std::nullopt);
        if (xioctl(fd_.get(), VIDIOC_QBUF, &buffer) == 0 || errno == ENODEV) return {};
        return failed("VIDIOC_QBUF");
    }

    const UniqueFd fd_;
    v4l2_pix_format format_{};
    bool streaming_ = false;
    bool monotonic_ = false;
    std::vector<std::span<std::byte>> buffers_;
    std::optional<v4l2_buffer> held_;
    std::vector<std::byte> gray_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_device_source(const std::string& path, const SourceOptions& options) {
    UniqueFd fd(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (fd.get() < 0) {
        const std::string hint =
            errno == ENOENT ? " (a rig's user-space devices are seen under camrig exec -- ...)" : "";
        return error(ErrorKind::not_found, std::strerror(errno) + hint);
    }
    auto source = std::make_unique<DeviceSource>(std::move(fd));
    if (auto begun = source->begin(options.device_format); !begun) return std::unexpected(begun.error());
    return source;
}

}  // namespace camrig::probe
