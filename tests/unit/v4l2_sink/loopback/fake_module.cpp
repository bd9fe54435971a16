#include "tests/unit/v4l2_sink/loopback/fake_module.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/base/time.h"

namespace camrig::device {

namespace {

constexpr std::size_t page = 4096;

std::uint32_t picture_bytes(const v4l2_pix_format& pix) {
    switch (pix.pixelformat) {
        case V4L2_PIX_FMT_YUV420:
            return pix.width * pix.height * 3 / 2;
        case V4L2_PIX_FMT_BGR24:
            return pix.width * pix.height * 3;
        case V4L2_PIX_FMT_MJPEG:
            return pix.width * pix.height * 4;
        default:
            return pix.width * pix.height * 2;
    }
}

}  // namespace

FakeModule::~FakeModule() {
    CHECK(mapped_.empty());
}

FakeModule::Device& FakeModule::plug(int number, const std::string& card) {
    devices[number].card = card;
    return devices[number];
}

bool FakeModule::exists(const std::string& path) {
    if (path == "/sys/module/v4l2loopback") return loaded;
    if (path == loopback_control_node) return loaded && minor_ >= 13;
    for (const auto& [number, device] : devices)
        if (path == "/dev/video" + std::to_string(number)) return true;
    return false;
}

std::optional<std::string> FakeModule::read_line(const std::string& path) {
    if (path == "/sys/module/v4l2loopback/version") {
        if (!version.empty()) return version;
        if (minor_ >= 13 && tells_version) return "0." + std::to_string(minor_) + ".0";
        return std::nullopt;
    }
    for (const auto& [number, device] : devices)
        if (path == "/sys/class/video4linux/video" + std::to_string(number) + "/buffers")
            return std::to_string(device.max_buffers);
    return std::nullopt;
}

int FakeModule::open(const std::string& path) {
    Opener opener;
    if (path == loopback_control_node) {
        if (!exists(path)) return -ENOENT;
        if (control_problem != 0) return -control_problem;
    } else {
        if (!exists(path)) return -ENOENT;
        if (open_problem != 0) return -open_problem;
        opener.number = std::stoi(path.substr(std::strlen("/dev/video")));
    }
    open_[next_fd_] = opener;
    return next_fd_++;
}

void FakeModule::close(int fd) {
    const Opener opener = open_.at(fd);
    open_.erase(fd);
    const auto device = devices.find(opener.number);
    if (device == devices.end()) return;
    if (device->second.writer == fd) device->second.writer = -1;
    free_if_unused(opener.number);
}

void FakeModule::close_all() {
    while (!open_.empty()) close(open_.begin()->first);
    mapped_.clear();
}

void FakeModule::free_if_unused(int number) {
    Device& device = devices.at(number);
    for (const auto& [fd, opener] : open_)
        if (opener.number == number) return;
    if (!device.is_held && !device.keep_format) device.has_format = false;
}

bool FakeModule::in_use_by_others(const Device& device, int fd) const {
    return device.is_held || (device.writer >= 0 && device.writer != fd);
}

void FakeModule::reader_comes(int number) {
    devices.at(number).is_held = true;
    devices.at(number).readers = 1;
    tell_usage(number);
}

void FakeModule::reader_leaves(int number) {
    devices.at(number).is_held = false;
    devices.at(number).readers = 0;
    tell_usage(number);
}

void FakeModule::tell_usage(int number) {
    for (auto& [fd, opener] : open_)
        if (opener.number == number && opener.subscribed) opener.event = devices.at(number).readers;
}

int FakeModule::control_ioctl(unsigned long request, void* argument) {
    const int number = static_cast<int>(reinterpret_cast<std::intptr_t>(argument));
    switch (request) {
        case loopback_add: {
            const auto& config = *static_cast<const LoopbackConfig*>(argument);
            const int made = add_gives >= 0 ? add_gives : config.number;
            if (devices.contains(made)) return -EEXIST;
            Device& device = plug(made, config.card_label);
            device.max_buffers = config.max_buffers;
            device.exclusive = config.announce_all_caps == 0;
            ++added;
            return made;
        }
        case loopback_remove:
            if (!devices.contains(number)) return -ENODEV;
            for (const auto& [fd, opener] : open_)
                if (opener.number == number) return -EBUSY;
            if (devices.at(number).is_held) return -EBUSY;
            devices.erase(number);
            ++removed;
            return 0;
        case loopback_get_version:
            if (minor_ < 15) return -ENOSYS;
            *static_cast<std::uint32_t*>(argument) = static_cast<std::uint32_t>(minor_) << 8;
            return 0;
        default:
            return -ENOSYS;
    }
}

int FakeModule::set_format(Opener& opener, Device& device, v4l2_format& format) {
    const bool is_fixed = minor_ >= 14 ? device.keep_format || device.is_held : device.has_format;
    if (!is_fixed) {
        device.pix = format.fmt.pix;
        device.pix.sizeimage = picture_bytes(device.pix);
        if (minor_ <= 13) device.pix.sizeimage = (device.pix.sizeimage + page - 1) / page * page;
    }
    opener.has_format = true;
    format.fmt.pix = device.pix;
    return 0;
}

int FakeModule::queue(Opener& opener, Device& device, v4l2_buffer& buffer) {
    if (write_problem != 0) return -write_problem;
    if (buffer.index >= opener.buffers) return -EINVAL;
    if (device.writer < 0) return -EINVAL;
    ReadPicture picture;
    const auto& memory = device.memory[buffer.index];
    picture.bytes.assign(memory.begin(), memory.begin() + buffer.bytesused);
    picture.stamp_us = buffer.timestamp.tv_sec * 1'000'000 + buffer.timestamp.tv_usec;
    picture.sequence = static_cast<std::uint32_t>(device.written++);
    picture.index = buffer.index;
    device.pictures.push_back(std::move(picture));
    return 0;
}

int FakeModule::ioctl(int fd, unsigned long request, void* argument) {
    Opener& opener = open_.at(fd);
    if (opener.number == control) return control_ioctl(request, argument);
    if (!devices.contains(opener.number)) return -ENODEV;
    Device& device = devices.at(opener.number);
    const bool ours = device.driver == "v4l2 loopback";
    switch (request) {
        case VIDIOC_QUERYCAP: {
            auto& caps = *static_cast<v4l2_capability*>(argument);
            device.driver.copy(reinterpret_cast<char*>(caps.driver), sizeof caps.driver - 1);
            device.card.copy(reinterpret_cast<char*>(caps.card), sizeof caps.card - 1);
            const bool takes_output = device.writer < 0 && !(minor_ >= 14 && device.keep_format);
            caps.device_caps = V4L2_CAP_STREAMING;
            if (!device.exclusive || takes_output) caps.device_caps |= V4L2_CAP_VIDEO_OUTPUT;
            return 0;
        }
        case VIDIOC_S_CTRL: {
            const auto& ctrl = *static_cast<const v4l2_control*>(argument);
            if (!ours || ctrl.id != loopback_keep_format) return -EINVAL;
            device.keep_format = ctrl.value != 0;
            calls.push_back(device.keep_format ? "keep_format=1" : "keep_format=0");
            if (minor_ >= 14 && !device.keep_format && !device.is_held && device.writer < 0) device.has_format = false;
            return 0;
        }
        case VIDIOC_S_FMT:
            calls.push_back("S_FMT");
            if (minor_ >= 14 && device.writer >= 0 && device.writer != fd) return -EBUSY;
            return set_format(opener, device, *static_cast<v4l2_format*>(argument));
        case VIDIOC_S_PARM:
            calls.push_back("S_PARM");
            device.interval = static_cast<v4l2_streamparm*>(argument)->parm.output.timeperframe;
            return 0;
        case VIDIOC_G_PARM:
            static_cast<v4l2_streamparm*>(argument)->parm.output.timeperframe = device.interval;
            return 0;
        case VIDIOC_REQBUFS: {
            auto& requested = *static_cast<v4l2_requestbuffers*>(argument);
            calls.push_back("REQBUFS " + std::to_string(requested.count));
            if (!opener.has_format) return -EINVAL;
            requested.count = std::min(requested.count, static_cast<std::uint32_t>(device.max_buffers));
            opener.buffers = requested.count;
            device.memory.assign(requested.count,
                                 std::vector<std::byte>((device.pix.sizeimage + page - 1) / page * page));
            return 0;
        }
        case VIDIOC_QUERYBUF: {
            auto& buffer = *static_cast<v4l2_buffer*>(argument);
            if (buffer.index >= opener.buffers) return -EINVAL;
            buffer.length = static_cast<std::uint32_t>(device.memory[buffer.index].size());
            buffer.m.offset = buffer.index * buffer.length;
            return 0;
        }
        case VIDIOC_STREAMON:
            calls.push_back("STREAMON");
            if (minor_ >= 14 && opener.buffers == 0) return -EINVAL;
            device.writer = fd;
            device.has_format = true;
            return 0;
        case VIDIOC_DQBUF: {
            auto& buffer = *static_cast<v4l2_buffer*>(argument);
            if (opener.buffers == 0) return -EINVAL;
            // 0.13 hands back the buffer that was queued last, the one that readers look at.
            const std::uint64_t position = minor_ >= 14 ? device.written : device.written + opener.buffers - 1;
            buffer.index = static_cast<std::uint32_t>(position % opener.buffers);
            return 0;
        }
        case VIDIOC_QBUF:
            return queue(opener, device, *static_cast<v4l2_buffer*>(argument));
        case VIDIOC_SUBSCRIBE_EVENT:
            if (minor_ < 13 || static_cast<v4l2_event_subscription*>(argument)->type != loopback_client_usage)
                return -EINVAL;
            opener.subscribed = true;
            opener.event = device.readers;
            return 0;
        case VIDIOC_DQEVENT: {
            if (!opener.event) return -ENOENT;
            auto& event = *static_cast<v4l2_event*>(argument);
            event.type = loopback_client_usage;
            std::memcpy(event.u.data, &*opener.event, sizeof *opener.event);
            opener.event.reset();
            return 0;
        }
        default:
            return -ENOTTY;
    }
}

std::byte* FakeModule::map(int fd, std::size_t bytes, std::int64_t offset) {
    const auto index = static_cast<std::size_t>(offset) / bytes;
    std::byte* data = devices.at(open_.at(fd).number).memory.at(index).data();
    mapped_.insert(data);
    return data;
}

void FakeModule::unmap(std::byte* data, std::size_t) {
    CHECK(mapped_.erase(data) == 1);
}

std::int64_t FakeModule::write(int fd, std::span<const std::byte> bytes) {
    calls.push_back("write");
    if (write_problem != 0) return -write_problem;
    Device& device = devices.at(open_.at(fd).number);
    device.has_format = true;
    ReadPicture picture;
    picture.bytes.assign(bytes.begin(), bytes.end());
    picture.stamp_us = monotonic_now_ns() / ns_per_us;
    picture.sequence = static_cast<std::uint32_t>(device.written++);
    device.pictures.push_back(std::move(picture));
    return std::ssize(bytes);
}

}  // namespace camrig::device
