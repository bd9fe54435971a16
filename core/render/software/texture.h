#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/world/model.h"

namespace camrig {

/// Linear light or plain data, 16 bits a channel: from sRGB at most 1/30 of the step between its two darkest codes off.
using Texel = std::array<std::uint16_t, 4>;

struct TextureLevel {
    int width = 0;
    int height = 0;
    std::vector<Texel> texels;  ///< top row first
};

/// An image with its mip levels, each half as wide and high as the one before (rounded down), filtered in linear light.
struct SoftwareImage {
    std::vector<TextureLevel> levels;
};

/// is_color: red, green and blue are sRGB (IEC 61966-2-1).
SoftwareImage make_software_image(const Image& image, bool is_color);

}  // namespace camrig
