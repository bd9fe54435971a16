#include "core/render/software/texture.h"

#include <algorithm>
#include <cmath>

#include "core/frame/srgb.h"

namespace camrig::render::software {
namespace {

using Codes = std::array<std::uint16_t, 256>;

Codes make_codes(bool is_color) {
    Codes codes{};
    for (std::size_t i = 0; i < codes.size(); ++i) {
        const double value = static_cast<double>(i) / 255.0;
        codes[i] = static_cast<std::uint16_t>(std::lround(65535.0 * (is_color ? frame::linear_of_srgb(value) : value)));
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

/// The mean of four texels, rounded. Both sides are even.
void halve_evenly(const Texel* from, std::size_t stride, const SoftwareImage::Level& small, Texel* to) {
    for (int y = 0; y < small.height; ++y, from += 2 * stride) {
        const Texel *upper = from, *lower = from + stride;
        for (int x = 0; x < small.width; ++x, ++to, upper += 2, lower += 2)
            for (std::size_t c = 0; c < to->size(); ++c)
                (*to)[c] =
                    static_cast<std::uint16_t>((upper[0][c] + upper[1][c] + lower[0][c] + lower[1][c] + 2u) / 4u);
    }
}

/// Fills level `number` from the one before.
void halve(SoftwareImage& image, std::size_t number) {
    const SoftwareImage::Level &large = image.levels[number - 1], &small = image.levels[number];
    const Texel* const from = image.texels.data() + large.first;
    Texel* to = image.texels.data() + small.first;
    const auto stride = static_cast<std::size_t>(large.width);
    if (large.width % 2 == 0 && large.height % 2 == 0) return halve_evenly(from, stride, small, to);
    for (int y = 0; y < small.height; ++y) {
        const Tap row = tap_of(y, small.height, large.height);
        for (int x = 0; x < small.width; ++x, ++to) {
            const Tap column = tap_of(x, small.width, large.width);
            for (std::size_t c = 0; c < to->size(); ++c) {
                const auto across = [&](std::size_t r) {
                    const double a = from[r * stride + column.first][c];
                    const double b = from[r * stride + column.second][c];
                    return a + (b - a) * column.share;
                };
                const double top = across(row.first);
                (*to)[c] = static_cast<std::uint16_t>(std::lround(top + (across(row.second) - top) * row.share));
            }
        }
    }
}

}  // namespace

SoftwareImage make_software_image(const world::Image& image, bool is_color) {
    static const Codes srgb = make_codes(true), plain = make_codes(false);
    const Codes& codes = is_color ? srgb : plain;
    SoftwareImage made;
    std::size_t count = 0;
    for (ImageSize size = image.size;; size = {std::max(1, size.width / 2), std::max(1, size.height / 2)}) {
        made.levels.push_back({size.width, size.height, static_cast<std::int32_t>(count)});
        count += static_cast<std::size_t>(size.pixels());
        if (std::max(size.width, size.height) == 1) break;
    }
    made.texels.resize(count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(image.size.pixels()); ++i) {
        const std::uint8_t* const from = image.rgba.data() + 4 * i;
        made.texels[i] = {codes[from[0]], codes[from[1]], codes[from[2]], plain[from[3]]};
    }
    for (std::size_t number = 1; number < made.levels.size(); ++number) halve(made, number);
    return made;
}

}  // namespace camrig::render::software
