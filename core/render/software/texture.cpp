#include "core/render/software/texture.h"

#include <algorithm>
#include <cmath>

namespace camrig {
namespace {

using Codes = std::array<std::uint16_t, 256>;

Codes make_codes(bool is_color) {
    Codes codes{};
    for (std::size_t i = 0; i < codes.size(); ++i) {
        const double value = static_cast<double>(i) / 255.0;
        const double linear = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
        codes[i] = static_cast<std::uint16_t>(std::lround(65535.0 * (is_color ? linear : value)));
    }
    return codes;
}

/// Where the middle of a texel of the smaller level falls in the larger one: two texels and how much of the second.
struct Tap {
    std::size_t first, second;
    double share;
};

Tap tap_of(int index, int small, int large) {
    const double at = (index + 0.5) * large / small - 0.5;
    const int first = std::clamp(static_cast<int>(std::floor(at)), 0, large - 1);
    return {static_cast<std::size_t>(first), static_cast<std::size_t>(std::min(first + 1, large - 1)), at - first};
}

TextureLevel halved(const TextureLevel& large) {
    TextureLevel small{.width = std::max(1, large.width / 2), .height = std::max(1, large.height / 2), .texels = {}};
    small.texels.reserve(static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height));
    const auto stride = static_cast<std::size_t>(large.width);
    for (int y = 0; y < small.height; ++y) {
        const Tap row = tap_of(y, small.height, large.height);
        for (int x = 0; x < small.width; ++x) {
            const Tap column = tap_of(x, small.width, large.width);
            Texel& texel = small.texels.emplace_back();
            for (std::size_t c = 0; c < texel.size(); ++c) {
                const auto across = [&](std::size_t r) {
                    const double a = large.texels[r * stride + column.first][c];
                    const double b = large.texels[r * stride + column.second][c];
                    return a + (b - a) * column.share;
                };
                const double top = across(row.first);
                texel[c] = static_cast<std::uint16_t>(std::lround(top + (across(row.second) - top) * row.share));
            }
        }
    }
    return small;
}

}  // namespace

SoftwareImage make_software_image(const Image& image, bool is_color) {
    static const Codes srgb = make_codes(true), plain = make_codes(false);
    const Codes& codes = is_color ? srgb : plain;
    TextureLevel full{.width = image.size.width, .height = image.size.height, .texels = {}};
    full.texels.resize(static_cast<std::size_t>(image.size.pixels()));
    for (std::size_t i = 0; i < full.texels.size(); ++i) {
        const std::uint8_t* const from = image.rgba.data() + 4 * i;
        full.texels[i] = {codes[from[0]], codes[from[1]], codes[from[2]], plain[from[3]]};
    }
    SoftwareImage made;
    made.levels.push_back(std::move(full));
    while (std::max(made.levels.back().width, made.levels.back().height) > 1)
        made.levels.push_back(halved(made.levels.back()));
    return made;
}

}  // namespace camrig
