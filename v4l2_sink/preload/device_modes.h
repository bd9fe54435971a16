#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/stream/frame_bus.h"
#include "v4l2_sink/preload/protocol.h"

namespace camrig::device {

/// What a user-space device enumerates, as a UVC camera does: every pixel format in every size at every rate, all
/// discrete. Raw sensor data comes in the camera's own size only: it is not scaled.
struct DeviceModes {
    std::vector<std::uint32_t> fourccs;  ///< YUYV, MJPG, YU12, NV12, BGR3, then raw sensor data
    std::vector<ImageSize> sizes;        ///< the camera's own first, then smaller ones of the same shape
    std::vector<Rate> rates;             ///< the camera's own first, then usual lower ones
};

/// Sizes are even, because of subsampled chroma: a camera of odd size is offered one pixel smaller, and without raw
/// sensor data. Raw data is offered at the sensor's own bit depth (or the next one that V4L2 has a format for), at 16
/// bits and at 8. A sensor of three chips has none: V4L2 knows no format of three full planes.
DeviceModes modes_of(const stream::CameraStream& camera);

/// The format to subscribe to on the frame bus; nullopt for a pixel format that camrig does not offer.
std::optional<stream::MediaFormat> media_format_of(const camrig_format& format, codec::ChromaSampling mjpg_sampling);

/// The largest size of a frame of this format, in bytes (v4l2_pix_format::sizeimage).
std::uint32_t picture_bytes(const camrig_format& format);

}  // namespace camrig::device
