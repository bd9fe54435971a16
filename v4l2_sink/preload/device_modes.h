#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/protocol.h"

namespace camrig::device {

/// What a user-space device offers, as a UVC camera does: every format in every size at every rate, all discrete. Of
/// numbers of a sensor the camera's own size alone: they are not scaled.
struct DeviceModes {
    std::vector<std::uint32_t> fourccs;  ///< YUYV, MJPG, YU12, NV12, BGR3, then those of numbers
    std::vector<ImageSize> sizes;        ///< the camera's own first, then smaller ones of the same shape
    std::vector<Rate> rates;             ///< the camera's own first, then usual lower ones
};

/// Even sizes only (chroma is shared by pixels): an odd camera is offered one pixel smaller, and no numbers. A sensor's
/// numbers come as they are, or in the next size of word that V4L2 has, in 16 bits and in 8; of three chips not at all,
/// for V4L2 has no name for that.
DeviceModes modes_of(const stream::CameraStream& camera);

/// The bus's name for a V4L2 format; nullopt: not one of ours.
std::optional<stream::MediaFormat> media_format_of(const camrig_format& format, codec::ChromaSampling mjpg_sampling);

/// Most bytes a picture of this format can have.
std::uint32_t picture_bytes(const camrig_format& format);

}  // namespace camrig::device
