#pragma once

#include <cstddef>
#include <span>

#include "core/base/result.h"
#include "core/frame/frame.h"
#include "core/frame/frame_pool.h"

namespace camrig::frame {

/// Colour conversion and scaling of rgba8 frames. Any thread; no state.
///
/// Matrix: BT.601 (Kr 0.299, Kb 0.114) applied to sRGB codes, for every size. Range: limited (Y 16..235, U and V
/// 16..240) for yuyv, i420 and nv12; full (0..255, JFIF) for jpeg_i420; gray8 is the full-range Y.
/// Siting: a chroma sample is the mean of the 2x2 (yuyv: 2x1) pixels it covers, that is, it lies in their middle
/// (MPEG-1 and JPEG siting, V4L2's default for these formats; not MPEG-2's left). Odd sizes: the last column and row
/// count twice; a yuyv row of odd width ends with its last pixel twice.
/// Error: each code is the exact value rounded to nearest within 0.51 code, without bias.
///
/// Scaling is a box or bilinear filter on sRGB codes (libyuv), done before the conversion. Alpha is ignored.

/// Writes the picture in another layout and size to `out`, which has exactly bytes_of(format, size) bytes.
/// A size of 0x0 means the frame's own. unsupported: a frame that is not rgba8, or a target that is not a colour
/// format. When it scales to another layout it allocates a scaled copy; converted() takes that from a pool.
Result<void> convert(const Frame& rgba, PixelFormat format, ImageSize size, std::span<std::byte> out);

/// The same as a frame of its own, with the info of the first (its damage is forgotten when it is scaled).
/// A frame that already is as wanted comes back itself, of whatever format.
/// `last` may be what it made, in the same format and size, of an earlier frame: when this frame's damage is since that
/// one, only damaged rows are converted and the others copied. The same bytes.
Result<FrameRef> converted(FramePool& pool, const FrameRef& frame, PixelFormat format, ImageSize size,
                           const FrameRef& last = nullptr);

}  // namespace camrig::frame
