#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/frame/frame.h"

namespace camrig::codec {

enum class Codec : std::uint8_t { raw, jpeg, png };
std::span<const Named<Codec>> names_of(std::type_identity<Codec>);

/// Encoded bytes, shared by all who send them.
using BytesRef = std::shared_ptr<const std::vector<std::byte>>;

/// Turns frames into bytes. One thread at a time; keeps its tables and buffers between calls.
class Encoder {
public:
    virtual ~Encoder() = default;
    virtual Result<BytesRef> encode(const frame::Frame& frame) = 0;
};

/// How many pixels share a chroma sample in a JPEG: 2x2 or 2x1.
enum class ChromaSampling : std::uint8_t { yuv420, yuv422 };
std::span<const Named<ChromaSampling>> names_of(std::type_identity<ChromaSampling>);

/// Baseline JFIF, accurate integer DCT, standard Huffman tables (RFC 2435 needs them), no EXIF.
/// quality 1..100 on libjpeg's scale. Takes rgba8, bgr24, rgb24, gray8 and jpeg_i420 frames (of whose chroma rows 4:2:2
/// shows each twice). Restart markers stand after every 16 rows, and only those rows are compressed that may differ
/// from the last frame encoded (FrameInfo::damage): the same bytes as without that knowledge.
Result<std::unique_ptr<Encoder>> create_jpeg_encoder(int quality, ChromaSampling sampling = ChromaSampling::yuv420);

/// 8-bit RGB from rgba8/rgb24/bgr24, 8-bit gray, or 16-bit gray from depth32f (millimetres, 0 = nothing or
/// beyond 65.535 m) and id32 (ids; above 65535 is an error). `level` 0..9: 0 stores, 1 is fast, 9 is small.
/// `keeps_alpha`: RGBA from rgba8.
Result<std::unique_ptr<Encoder>> create_png_encoder(int level = 1, bool keeps_alpha = false);

inline constexpr int default_jpeg_quality = 90;

}  // namespace camrig::codec
