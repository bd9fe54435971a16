#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/codec/encoder.h"
#include "core/frame/frame_pool.h"
#include "core/stream/sink.h"
#include "core/stream/statistics.h"

namespace camrig::stream {

/// Stage timers that all transcoders of a rig share.
struct TranscodeTimers {
    StageTimer convert;
    StageTimer encode;
};

/// Brings a camera's frame into one MediaFormat: scale, change the pixel format, encode; only the steps that are
/// needed. One thread at a time; keeps encoder tables and buffers.
class Transcoder {
public:
    /// Errors: invalid_argument for a quality or size that cannot be.
    static Result<std::unique_ptr<Transcoder>> create(const MediaFormat& format, std::shared_ptr<frame::FramePool> pool,
                                                      std::shared_ptr<TranscodeTimers> timers);
    Result<MediaUnit> transcode(const frame::FrameRef& frame);
    /// Into the same format at another size.
    Result<std::unique_ptr<Transcoder>> of_size(ImageSize size) const;
    const MediaFormat& format() const { return format_; }

private:
    Transcoder() = default;
    MediaFormat format_;
    std::shared_ptr<frame::FramePool> pool_;
    std::shared_ptr<TranscodeTimers> timers_;
    std::unique_ptr<codec::Encoder> encoder_;
    frame::FrameRef last_converted_;  ///< to copy from what is not damaged; null where that is not known
};

/// Which pixel format of a colour picture of that size takes the least to bring into this format: no conversion, unless
/// it is scaled too.
frame::PixelFormat source_format(const MediaFormat& format, ImageSize camera_size);

/// "jpeg q90", "raw yuyv 640x480": for statistics and messages.
std::string describe(const MediaFormat& format);

}  // namespace camrig::stream
