#pragma once

#include "core/base/image_size.h"

namespace camrig {

/// RFC 2435, 3.1.5: RTP sends a JPEG's width and height as eighths, in a byte each.
inline constexpr int rtp_jpeg_step = 8, max_rtp_jpeg_side = 255 * rtp_jpeg_step;

constexpr bool fits_rtp_jpeg(ImageSize size) {
    return size.width <= max_rtp_jpeg_side && size.height <= max_rtp_jpeg_side && size.width % rtp_jpeg_step == 0 &&
           size.height % rtp_jpeg_step == 0;
}

}  // namespace camrig
