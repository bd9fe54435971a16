#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/world/model.h"

namespace camrig::render::software {

/// Linear light or plain data, 16 bits a channel: from sRGB at most 1/30 of the step between its two darkest codes off.
using Texel = std::array<std::uint16_t, 4>;

/// An image with its mip levels, each half as wide and high as the one before (rounded down, at least 1), filtered in
/// linear light.
struct SoftwareImage {
    struct Level {
        int width = 0;
        int height = 0;
        std::int32_t first = 0;  ///< of its texels
    };
    std::vector<Level> levels;
    std::vector<Texel> texels;  ///< level after level, top row first

    std::span<const Texel> texels_of(std::size_t level) const {
        const Level& of = levels[level];
        return {texels.data() + of.first, static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.height)};
    }
};

/// is_color: red, green and blue are sRGB (IEC 61966-2-1).
SoftwareImage make_software_image(const world::Image& image, bool is_color);

}  // namespace camrig::render::software
