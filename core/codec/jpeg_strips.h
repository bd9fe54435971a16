#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/codec/encoder.h"
#include "core/frame/frame.h"

namespace camrig::codec {

/// Rows of a strip (two rows of luma blocks, whatever the chroma); of the last one what is left.
inline constexpr int jpeg_strip_rows = frame::Damage::band_rows;

/// Rows of a picture as libjpeg wrote them, taken apart. A strip is what stands between two restart markers: it can be
/// decoded without what is before it, so it is the same bytes in any picture that has these rows.
struct JpegStrips {
    std::span<const std::byte> head;  ///< from SOI up to the first strip
    std::vector<std::span<const std::byte>> strips;
};

/// Compresses rows of frames by libjpeg. One thread at a time; keeps its buffers between calls.
class JpegStripCompressor {
public:
    static Result<std::unique_ptr<JpegStripCompressor>> create(int quality, ChromaSampling sampling);
    ~JpegStripCompressor();
    JpegStripCompressor(const JpegStripCompressor&) = delete;
    JpegStripCompressor& operator=(const JpegStripCompressor&) = delete;

    /// Rows first_row <= y < end_row as a picture of their own. first_row is a multiple of jpeg_strip_rows, and so is
    /// end_row unless it is the frame's height. What it answers holds until the next call. Errors: invalid_argument for
    /// a size that JPEG has not, unsupported for a format it cannot take.
    Result<const JpegStrips*> compress(const frame::Frame& frame, int first_row, int end_row);

private:
    struct Libjpeg;
    explicit JpegStripCompressor(std::unique_ptr<Libjpeg> libjpeg);
    std::unique_ptr<Libjpeg> libjpeg_;
    JpegStrips strips_;
};

}  // namespace camrig::codec
