#include "v4l2_sink/loopback/module.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/base/image_size.h"
#include "v4l2_sink/loopback/module_abi.h"

namespace camrig::device {

namespace {

// Four: ROS usb_cam and libwebrtc map exactly four buffers and index with what they dequeue; with the module's default
// of two a reader has one frame's time to copy before it sees a torn picture.
constexpr std::int32_t buffers_per_device = 4;
constexpr std::int32_t openers_per_device = 32;
constexpr const char* module_folder = "/sys/module/v4l2loopback";

/// {major, minor} of "0.15.4" or of a snapshot's "0.15.4-12-gabcdef".
std::optional<std::pair<int, int>> parse_version(const std::string& text) {
    int major = 0, minor = 0;
    if (std::sscanf(text.c_str(), "%d.%d", &major, &minor) != 2) return std::nullopt;
    return std::pair(major, minor);
}

std::string modprobe_line(int number, const std::string& label) {
    return "sudo modprobe v4l2loopback video_nr=" + std::to_string(number) +
           " exclusive_caps=1 max_buffers=4 card_label=" + label;
}

/// The control node, closed at the end of its scope.
class ControlNode {
public:
    explicit ControlNode(LoopbackKernel& kernel) : kernel_(kernel), fd_(kernel.open(loopback_control_node)) {}
    ControlNode(const ControlNode&) = delete;
    ControlNode& operator=(const ControlNode&) = delete;
    ~ControlNode() {
        if (fd_ >= 0) kernel_.close(fd_);
    }
    int problem() const { return fd_ < 0 ? -fd_ : 0; }
    int ioctl(unsigned long request, void* argument) { return kernel_.ioctl(fd_, request, argument); }

private:
    LoopbackKernel& kernel_;
    const int fd_;
};

Error no_permission() {
    return {ErrorKind::unauthorized,
            std::string(loopback_control_node) +
                ": no permission to add or remove devices; run: sudo chgrp video /dev/v4l2loopback && sudo chmod g+rw "
                "/dev/v4l2loopback (and be in the group video), or add the device yourself: sudo v4l2loopback-ctl add"};
}

}  // namespace

std::string video_path(int number) {
    return "/dev/video" + std::to_string(number);
}

Result<LoopbackFeatures> LoopbackModule::features() const {
    if (!kernel_.exists(module_folder))
        return error(ErrorKind::unavailable, "the kernel module v4l2loopback is not loaded");
    LoopbackFeatures features;
    features.adds_devices = kernel_.exists(loopback_control_node);
    auto told = kernel_.read_line(std::string(module_folder) + "/version");
    if (!told && features.adds_devices) {
        std::uint32_t code = 0;
        ControlNode control(kernel_);
        if (control.problem() == 0 && control.ioctl(loopback_get_version, &code) == 0)
            told = std::to_string(code >> 16 & 0xff) + "." + std::to_string(code >> 8 & 0xff) + "." +
                   std::to_string(code & 0xff);
    }
    // 0.12 tells its version nowhere; of two that may be meant the older one is taken, whose ways work on both.
    features.version = told.value_or(features.adds_devices ? "0.13" : "0.12");
    const auto version = parse_version(features.version);
    if (version && *version < std::pair(0, 12))
        return error(ErrorKind::unsupported,
                     "v4l2loopback " + features.version + " is too old; install 0.12.7 or later (Debian 12 has it)");
    features.tells_readers = features.adds_devices;
    features.streams = features.adds_devices && version && *version >= std::pair(0, 14);
    return features;
}

Result<LoopbackFeatures> LoopbackModule::can_provide(int number, const std::string& label) const {
    const auto features = this->features();
    if (!features && features.error().kind == ErrorKind::unavailable)
        return error(ErrorKind::unavailable, features.error().message + "; run: sudo apt install v4l2loopback-dkms; " +
                                                 modprobe_line(number, label) +
                                                 "  (or use a user-space device, --device N)");
    if (!features) return std::unexpected(features.error());
    if (kernel_.exists(video_path(number))) return features;
    if (!features->adds_devices)
        return error(ErrorKind::not_found, video_path(number) + " is not there and v4l2loopback " + features->version +
                                               " cannot add it while loaded; run: sudo modprobe -r v4l2loopback; " +
                                               modprobe_line(number, label));
    if (ControlNode(kernel_).problem() != 0) return std::unexpected(no_permission());
    return features;
}

Result<LoopbackModule::Provided> LoopbackModule::provide(int number, const std::string& label) const {
    const auto features = can_provide(number, label);
    if (!features) return std::unexpected(features.error());
    if (kernel_.exists(video_path(number))) return Provided{*features, false};
    ControlNode control(kernel_);
    if (control.problem() != 0) return std::unexpected(no_permission());
    LoopbackConfig config;
    config.number = number;
    label.copy(config.card_label, sizeof config.card_label - 1);
    config.min_width = static_cast<std::uint32_t>(min_image_size.width);
    config.min_height = static_cast<std::uint32_t>(min_image_size.height);
    config.max_width = static_cast<std::uint32_t>(max_image_size.width);
    config.max_height = static_cast<std::uint32_t>(max_image_size.height);
    config.max_buffers = buffers_per_device;
    config.max_openers = openers_per_device;
    config.announce_all_caps = 0;  // Chrome refuses a device that announces output; 0.13's default is the wrong one
    const int made = control.ioctl(loopback_add, &config);
    if (made < 0)
        return error(ErrorKind::unavailable,
                     video_path(number) + ": v4l2loopback could not add it: " + std::strerror(-made) + "; see dmesg");
    if (made != number) {  // the number is another driver's, without a node in this /dev
        control.ioctl(loopback_remove, reinterpret_cast<void*>(static_cast<std::intptr_t>(made)));
        return error(ErrorKind::already_exists,
                     video_path(number) + ": the number belongs to another driver; choose another");
    }
    return Provided{*features, true};
}

Result<void> LoopbackModule::remove(int number) const {
    ControlNode control(kernel_);
    if (control.problem() != 0) return std::unexpected(no_permission());
    const int removed = control.ioctl(loopback_remove, reinterpret_cast<void*>(static_cast<std::intptr_t>(number)));
    if (removed == -EBUSY) return error(ErrorKind::unavailable, video_path(number) + " is still open in some program");
    if (removed < 0) return error(ErrorKind::not_found, video_path(number) + ": " + std::strerror(-removed));
    return {};
}

}  // namespace camrig::device
