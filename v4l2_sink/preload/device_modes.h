#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/protocol.h"

namespace camrig::device {

/// What a user-space device offers, as a UVC camera does: every format in every size at every rate, all discrete.
struct DeviceModes {
    std::vector<ImageSize> sizes;  ///< the camera's own first, then smaller ones of the same shape
    std::vector<Rate> rates;       ///< the camera's own first, then usual lower ones
};

/// Fourccs in the order they are listed: YUYV, MJPG, YU12, NV12, BGR3.
extern const std::array<std::uint32_t, 5> device_fourccs;

/// Even sizes only (chroma is shared by pixels): an odd camera is offered one pixel smaller.
DeviceModes modes_of(const stream::CameraStream& camera);

/// The bus's name for a V4L2 format; nullopt: not one of ours.
std::optional<stream::MediaFormat> media_format_of(const camrig_format& format, codec::ChromaSampling mjpg_sampling);

/// Most bytes a picture of this format can have.
std::uint32_t picture_bytes(const camrig_format& format);

}  // namespace camrig::device
