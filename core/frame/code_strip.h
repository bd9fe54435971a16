#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/image_size.h"
#include "core/base/time.h"
#include "core/frame/pixel_format.h"

namespace camrig::frame {

/// The machine-readable mark in the top-left corner of a picture: which camera, which frame, which instant. It proves
/// synchronism and measures latency through any consumer, codec and device.
///
/// Layout (docs/decisions/0010-code-strip.md): 32 columns x 4 rows of square black and white cells from pixel (0, 0);
/// 128 bits, row by row, most significant bit first, white is 1:
/// 8 bits sync 10110010, 8 camera, 32 sequence, 64 world_ns, 16 CRC-16/CCITT-FALSE of the 112 bits before it.
struct CodeStrip {
    std::uint8_t camera = 0;     ///< low bits of the camera's number
    std::uint32_t sequence = 0;  ///< low bits of the frame's sequence
    TimeNs world_ns = 0;

    friend bool operator==(const CodeStrip&, const CodeStrip&) = default;
};

inline constexpr int code_strip_columns = 32;
inline constexpr int code_strip_rows = 4;

/// Side of a cell in pixels: max(4, width / 80), but never so large that the four rows leave the picture; 0 for
/// pictures that are too small for a strip (below 128x32).
int code_strip_cell(ImageSize size);

/// Draws over an rgba8 picture (codes 0 and 255). Does nothing when code_strip_cell(size) is 0.
void draw_code_strip(std::span<std::byte> rgba, ImageSize size, const CodeStrip& strip);

/// Finds and checks the strip of a picture in any colour format, also after JPEG, video coding and scaling of both axes
/// by the same factor, as long as a cell has 2 pixels. Nothing when there is none or its checksum is wrong.
std::optional<CodeStrip> read_code_strip(std::span<const std::byte> pixels, ImageSize size,
                                         PixelFormat format = PixelFormat::rgba8);

}  // namespace camrig::frame
