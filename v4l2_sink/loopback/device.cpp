#include "v4l2_sink/loopback/device.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <tuple>

#include "v4l2_sink/loopback/module_abi.h"

namespace camrig::device {

namespace {

constexpr int max_events = 64;  // the module keeps one; a bound for a kernel that would not

v4l2_streamparm rate_parameters(const Rate& rate) {
    v4l2_streamparm parameters{};
    parameters.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    parameters.parm.output.capability = V4L2_CAP_TIMEPERFRAME;
    parameters.parm.output.timeperframe = {static_cast<std::uint32_t>(rate.den()),
                                           static_cast<std::uint32_t>(rate.num())};
    return parameters;
}

}  // namespace

std::unexpected<Error> LoopbackDevice::failed(const char* what, int problem) const {
    return error(ErrorKind::unavailable, video_path(number_) + ": " + what + ": " + std::strerror(-problem));
}

Result<std::unique_ptr<LoopbackDevice>> LoopbackDevice::open_node(LoopbackKernel& kernel, int number) {
    const int fd = kernel.open(video_path(number));
    if (fd == -EACCES || fd == -EPERM)
        return error(ErrorKind::unauthorized, video_path(number) +
                                                  ": no permission; run: sudo usermod -aG video $USER and log in "
                                                  "again, or run the rig as a user of the group video");
    if (fd == -ENOENT || fd == -ENODEV || fd == -ENXIO)
        return error(ErrorKind::not_found, video_path(number) + ": is not there");
    if (fd == -EBUSY)
        return error(ErrorKind::unavailable, video_path(number) +
                                                 ": too many programs have it open; close some (module parameter "
                                                 "max_openers)");
    if (fd < 0) return error(ErrorKind::unavailable, video_path(number) + ": " + std::strerror(-fd));
    std::unique_ptr<LoopbackDevice> device(new LoopbackDevice(kernel, number, fd));
    v4l2_capability caps{};
    if (kernel.ioctl(fd, VIDIOC_QUERYCAP, &caps) < 0 ||
        std::string_view(reinterpret_cast<const char*>(caps.driver)) != loopback_driver_name) {
        const std::string driver = reinterpret_cast<const char*>(caps.driver);
        return error(ErrorKind::already_exists, video_path(number) + ": belongs to the driver '" + driver +
                                                    "', not to v4l2loopback; choose another number");
    }
    return device;
}

Result<void> LoopbackDevice::check(LoopbackKernel& kernel, int number) {
    const auto opened = open_node(kernel, number);
    if (!opened) return std::unexpected(opened.error());
    return {};
}

Result<std::unique_ptr<LoopbackDevice>> LoopbackDevice::open(LoopbackKernel& kernel, const LoopbackFeatures& features,
                                                             int number, const LoopbackFormat& wanted) {
    // The second try helps where the module frees a kept format only when the last descriptor is closed (0.12, 0.13).
    constexpr int tries = 2;
    for (int attempt = 1;; ++attempt) {
        auto opened = open_node(kernel, number);
        if (!opened) return opened;
        std::unique_ptr<LoopbackDevice> device = std::move(*opened);
        if (auto free = device->check_writers(); !free) return std::unexpected(free.error());
        if (auto set = device->set_format(wanted); !set) return std::unexpected(set.error());
        if (!device->format_.same_pictures(wanted) && attempt < tries) continue;
        if (!media_format_of(device->format_))
            return error(ErrorKind::unsupported, video_path(number) + ": a program holds it at " +
                                                     device->format_.to_string() +
                                                     ", which is none of YUYV, YU12, MJPG, BGR3; close that program");
        device->set_rate();
        const int fd = device->fd_;
        if (features.streams) {
            if (auto ready = device->set_up_buffers(); !ready) return std::unexpected(ready.error());
        } else {
            const auto told = kernel.read_line("/sys/class/video4linux/video" + std::to_string(number) + "/buffers");
            device->buffers_ = told ? std::atoi(told->c_str()) : static_cast<int>(buffer_count);
        }
        if (features.tells_readers) {
            v4l2_event_subscription subscription{};
            subscription.type = loopback_client_usage;
            subscription.flags = V4L2_EVENT_SUB_FL_SEND_INITIAL;
            device->tells_readers_ = kernel.ioctl(fd, VIDIOC_SUBSCRIBE_EVENT, &subscription) == 0;
        }
        return device;
    }
}

LoopbackDevice::~LoopbackDevice() {
    for (const Mapping& mapping : mappings_)
        if (mapping.data != nullptr) kernel_.unmap(mapping.data, mapping.bytes);
    kernel_.close(fd_);
}

Result<void> LoopbackDevice::check_writers() {
    // A kept format hides that the device takes output (0.14 on), so it is let go before the question is asked.
    set_keep_format(false);
    v4l2_capability now{};
    if (const int asked = kernel_.ioctl(fd_, VIDIOC_QUERYCAP, &now); asked < 0) return failed("QUERYCAP", asked);
    if ((now.device_caps & V4L2_CAP_VIDEO_OUTPUT) == 0) {
        set_keep_format(true);
        return error(ErrorKind::already_exists,
                     video_path(number_) + ": another program writes to it; end that program or choose another number");
    }
    return {};
}

Result<void> LoopbackDevice::set_format(const LoopbackFormat& wanted) {
    v4l2_format request{};
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.fmt.pix = pix_format_of(wanted);
    const int set = kernel_.ioctl(fd_, VIDIOC_S_FMT, &request);
    if (set == -EBUSY)
        return error(ErrorKind::already_exists,
                     video_path(number_) + ": another program writes to it; end that program or choose another number");
    if (set < 0) return failed("S_FMT", set);
    // Whoever has the device already decides: then the module answers with that format and no error.
    const v4l2_pix_format& got = request.fmt.pix;
    format_ = {got.pixelformat,
               {static_cast<int>(got.width), static_cast<int>(got.height)},
               wanted.rate,
               wanted.mjpg_sampling};
    return {};
}

Result<void> LoopbackDevice::set_up_buffers() {
    streams_ = true;
    v4l2_requestbuffers request{};
    request.count = buffer_count;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    const int asked = kernel_.ioctl(fd_, VIDIOC_REQBUFS, &request);
    if (asked < 0) return failed("REQBUFS", asked);
    buffers_ = static_cast<int>(request.count);
    if (buffers_ < 1 || request.count > buffer_count)
        return error(ErrorKind::unsupported, video_path(number_) + ": gives " + std::to_string(buffers_) +
                                                 " buffers instead of 4; close the programs that have it open");
    for (std::uint32_t index = 0; index < request.count; ++index) {
        v4l2_buffer buffer{};
        buffer.index = index;
        buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
        buffer.memory = V4L2_MEMORY_MMAP;
        if (const int told = kernel_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer); told < 0) return failed("QUERYBUF", told);
        mappings_[index] = {kernel_.map(fd_, buffer.length, buffer.m.offset), buffer.length};
        if (mappings_[index].data == nullptr) return failed("mmap", -ENOMEM);
    }
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    if (const int on = kernel_.ioctl(fd_, VIDIOC_STREAMON, &type); on < 0) return failed("STREAMON", on);
    return {};
}

void LoopbackDevice::set_rate() {
    auto parameters = rate_parameters(format_.rate);
    // It only tells readers what to expect; pictures come at the camera's rate whatever the module answers.
    std::ignore = kernel_.ioctl(fd_, VIDIOC_S_PARM, &parameters);
}

void LoopbackDevice::set_keep_format(bool keep) {
    v4l2_control control{loopback_keep_format, keep ? 1 : 0};
    std::ignore = kernel_.ioctl(fd_, VIDIOC_S_CTRL, &control);
}

Result<void> LoopbackDevice::show(std::span<const std::byte> bytes, std::int64_t stamp_us) {
    if (auto shown = streams_ ? queue(bytes, stamp_us) : write(bytes); !shown) return shown;
    if (shown_) return {};
    shown_ = true;
    if (!streams_) {
        // Without it 0.12 does not notice that its writer goes, and takes no other one afterwards. Later versions have
        // started on their own and may refuse.
        int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
        std::ignore = kernel_.ioctl(fd_, VIDIOC_STREAMON, &type);
    }
    // From here on the format stays, even without a writer: a reader survives a restart of the rig.
    set_keep_format(true);
    return {};
}

Result<void> LoopbackDevice::queue(std::span<const std::byte> bytes, std::int64_t stamp_us) {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    // The module gives the oldest buffer, at any time: its readers own none, they only look.
    if (const int taken = kernel_.ioctl(fd_, VIDIOC_DQBUF, &buffer); taken < 0) return failed("DQBUF", taken);
    if (buffer.index >= mappings_.size() || mappings_[buffer.index].bytes < bytes.size())
        return error(ErrorKind::internal, video_path(number_) + ": a picture of " + std::to_string(bytes.size()) +
                                              " bytes does not fit into buffer " + std::to_string(buffer.index));
    std::memcpy(mappings_[buffer.index].data, bytes.data(), bytes.size());
    buffer.bytesused = static_cast<std::uint32_t>(bytes.size());
    buffer.field = V4L2_FIELD_NONE;
    buffer.timestamp.tv_sec = stamp_us / 1'000'000;
    buffer.timestamp.tv_usec = stamp_us % 1'000'000;
    if (const int queued = kernel_.ioctl(fd_, VIDIOC_QBUF, &buffer); queued < 0) return failed("QBUF", queued);
    return {};
}

Result<void> LoopbackDevice::write(std::span<const std::byte> bytes) {
    const std::int64_t written = kernel_.write(fd_, bytes);
    if (written < 0) return failed("write", static_cast<int>(written));
    if (static_cast<std::size_t>(written) != bytes.size())
        return error(ErrorKind::internal, video_path(number_) + ": took " + std::to_string(written) + " of " +
                                              std::to_string(bytes.size()) + " bytes of a picture");
    return {};
}

Result<std::optional<bool>> LoopbackDevice::has_readers() {
    if (!tells_readers_) return std::nullopt;
    for (int i = 0; i < max_events; ++i) {
        v4l2_event event{};
        const int got = kernel_.ioctl(fd_, VIDIOC_DQEVENT, &event);
        if (got == -ENODEV) return error(ErrorKind::unavailable, video_path(number_) + ": was removed");
        if (got < 0) break;
        std::uint32_t count = 0;
        std::memcpy(&count, event.u.data, sizeof count);
        if (event.type == loopback_client_usage) has_readers_ = count > 0;
    }
    return has_readers_;
}

bool LoopbackDevice::restore_rate() {
    const auto mine = rate_parameters(format_.rate);
    v4l2_streamparm now{};
    now.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    if (kernel_.ioctl(fd_, VIDIOC_G_PARM, &now) < 0) return false;
    const v4l2_fract &have = now.parm.output.timeperframe, &want = mine.parm.output.timeperframe;
    if (std::uint64_t{have.numerator} * want.denominator == std::uint64_t{want.numerator} * have.denominator)
        return false;
    set_rate();
    return true;
}

void LoopbackDevice::change_rate(const Rate& rate) {
    format_.rate = rate;
    set_rate();
}

void LoopbackDevice::release_format() {
    set_keep_format(false);
}

}  // namespace camrig::device
