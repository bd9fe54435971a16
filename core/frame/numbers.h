#pragma once

#include "core/base/result.h"
#include "core/frame/frame.h"
#include "core/frame/frame_pool.h"

namespace camrig::frame {

/// The numbers of a sensor (FrameKind::sensor), brought to so many bits: shifted up, so that the largest number stays
/// about the largest there is (V4L2's Y16 is read so), or down, which loses the lowest bits. 8 bits are a byte each
/// (gray8 in this order of photosites), more two, little-endian. As many bits as the sensor has: the frame itself.
/// unsupported: a frame of another kind; invalid_argument: bits other than 8 to 16.
Result<FrameRef> numbers_in(FramePool& pool, const FrameRef& numbers, int bits);

}  // namespace camrig::frame
