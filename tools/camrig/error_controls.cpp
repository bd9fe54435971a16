#include "tools/camrig/error_controls.h"

#include <cmath>
#include <variant>

#include <linux/videodev2.h>

namespace camrig::cli {
namespace {

using fault::DeviceCall, fault::DeviceError;

constexpr std::uint32_t vivid_base = 0x00f00000u | 0xf000u;  // VIVID_CID_VIVID_BASE
enum ErrorControl : std::uint32_t {
    percentage_dropped = vivid_base + 64,
    disconnect = vivid_base + 65,
    buffer_error = vivid_base + 66,
    reqbufs_error = vivid_base + 67,
    qbuf_error = vivid_base + 68,
    streamon_error = vivid_base + 69,
    streaming_error = vivid_base + 70,
};

device::DeviceControl button(ErrorControl id, const char* name) {
    constexpr std::uint32_t flags = V4L2_CTRL_FLAG_WRITE_ONLY | V4L2_CTRL_FLAG_EXECUTE_ON_WRITE;
    return {id, device::DeviceControl::Kind::button, name, 0, 0, 0, 0, flags, {}};
}

ErrorSetting pressed(fault::FaultKind kind) {
    return {.clears = {}, .fault = fault::FaultSpec{.kind = std::move(kind)}};
}

}  // namespace

std::vector<device::DeviceControl> error_controls() {
    return {{percentage_dropped,
             device::DeviceControl::Kind::integer,
             "Percentage of Dropped Buffers",
             0,
             100,
             1,
             0,
             0,
             {}},
            button(disconnect, "Disconnect"),
            button(buffer_error, "Inject V4L2_BUF_FLAG_ERROR"),
            button(reqbufs_error, "Inject VIDIOC_REQBUFS Error"),
            button(qbuf_error, "Inject VIDIOC_QBUF Error"),
            button(streamon_error, "Inject VIDIOC_STREAMON Error"),
            button(streaming_error, "Inject Fatal Streaming Error")};
}

bool is_error_control(std::uint32_t id) {
    return id >= percentage_dropped && id <= streaming_error;
}

ErrorSetting error_setting(std::uint32_t id, std::int32_t value) {
    switch (id) {
        case percentage_dropped: {
            ErrorSetting drops{.clears = "drop", .fault = std::nullopt, .is_button = false};
            if (value > 0)
                drops.fault = fault::FaultSpec{.kind = fault::Drop{.probability = 1.0}, .severity = value / 100.0};
            return drops;
        }
        case disconnect:
            return pressed(fault::Disconnect{.output = fault::Output::device});
        case buffer_error:
            return pressed(fault::BufferError{.probability = 1.0});
        case reqbufs_error:
            return pressed(DeviceError{.at = DeviceCall::reqbufs});
        case qbuf_error:
            return pressed(DeviceError{.at = DeviceCall::qbuf});
        case streamon_error:
            return pressed(DeviceError{.at = DeviceCall::streamon});
        default:
            return pressed(DeviceError{.at = DeviceCall::streaming});
    }
}

std::int32_t error_value(std::uint32_t id, std::span<const fault::FaultRef> faults) {
    if (id != percentage_dropped) return 0;
    double kept = 1.0;
    for (const fault::FaultRef& fault : faults)
        if (const auto* const drop = std::get_if<fault::Drop>(&fault->kind))
            kept *= 1.0 - drop->probability * fault->severity;
    return static_cast<std::int32_t>(std::lround(100.0 * (1.0 - kept)));
}

}  // namespace camrig::cli
