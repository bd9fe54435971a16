#pragma once

#include <algorithm>
#include <cmath>

#include "core/render/software/rasterizer.h"
#include "core/world/backdrop/picture_pyramid.h"

/// Light of a picture at any place and in any size. Places are in pixels of the largest level, centres at integers.
namespace camrig::render::software {

/// What of the largest level a pixel of a view sees: its middle, and its steps to the next pixel on the right and
/// below.
struct Footprint {
    glm::dvec2 at{0.0}, dx{0.0}, dy{0.0};
};

/// Bilinear in linear light. to_inside(x, y, size) says which pixel of a picture is at (x, y), also beside it.
template <typename ToInside>
glm::dvec3 bilinear(const world::Image& picture, double u, double v, const ToInside& to_inside) {
    const auto& linear = linear_of_code();
    const double column = std::floor(u), row = std::floor(v);
    const double right = u - column, below = v - row;
    const auto texel = [&](int x, int y) {
        to_inside(x, y, picture.size);
        const std::uint8_t* const at =
            picture.rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.size.width) +
                                       static_cast<std::size_t>(x));
        return glm::dvec3(linear[at[0]], linear[at[1]], linear[at[2]]);
    };
    const int x = static_cast<int>(column), y = static_cast<int>(row);
    return (1.0 - below) * ((1.0 - right) * texel(x, y) + right * texel(x + 1, y)) +
           below * ((1.0 - right) * texel(x, y + 1) + right * texel(x + 1, y + 1));
}

/// Of a number of at least 1: how often it can be halved, and between two powers of two evenly.
inline double halvings_of(double number) {
    int exponent = 0;
    const double share = std::frexp(number, &exponent);
    return exponent - 1 + (2.0 * share - 1.0);
}

/// Over how much of a picture the mean is taken for a pixel of a view: samples along the longer side of what it sees,
/// in one row or a few beside each other, from the two levels whose pixels are nearest to the distance of the samples
/// (as EXT_texture_filter_anisotropic, which has one row).
struct Blur {
    double level = 0.0;
    int samples = 1, rows = 1;
    glm::dvec2 along{0.0}, across{0.0};

    bool is_none() const { return level == 0.0 && count() == 1; }
    int count() const { return samples * rows; }
    /// From the middle to a sample.
    glm::dvec2 step(int number) const {
        return along * ((number % samples + 0.5) / samples - 0.5) + across * ((number / samples + 0.5) / rows - 0.5);
    }
};

/// most_rows: with one, what is smaller than a pixel of the view is blurred by as much again, because samples are
/// bilinear; with two by half of that.
inline Blur blur_of(const Footprint& of, int most_rows = 1) {
    constexpr double most_samples = 16.0;
    // A view of the picture's own pixels has steps of 1 but for rounding, and is not to be blurred.
    constexpr double as_large = 1.001;
    const double x2 = glm::dot(of.dx, of.dx), y2 = glm::dot(of.dy, of.dy);
    const double longer = std::sqrt(std::max(x2, y2)), shorter = std::sqrt(std::min(x2, y2));
    if (longer <= as_large) return {};
    const double wide = std::max({shorter / most_rows, longer / most_samples, 1.0});
    const auto number = [&](double side, double most) {
        return static_cast<int>(std::clamp(std::ceil(side / wide - (as_large - 1.0)), 1.0, most));
    };
    return {.level = halvings_of(wide),
            .samples = number(longer, most_samples),
            .rows = number(shorter, most_rows),
            .along = x2 >= y2 ? of.dx : of.dy,
            .across = x2 >= y2 ? of.dy : of.dx};
}

/// Where a pixel of the view is smaller than one of the picture, bilinear; else the mean over the pixel, as of blur_of.
template <typename ToInside>
glm::dvec3 sampled(const world::PicturePyramid& picture, const Footprint& of, const ToInside& to_inside,
                   int most_rows = 1) {
    const Blur blur = blur_of(of, most_rows);
    if (blur.is_none()) return bilinear(picture.levels[0], of.at.x, of.at.y, to_inside);
    const double level = std::min(blur.level, static_cast<double>(picture.levels.size() - 1));
    const auto fine = static_cast<std::size_t>(level);
    const double coarse_share = level - static_cast<double>(fine);
    glm::dvec3 sum(0.0);
    const auto add = [&](std::size_t number, double share) {
        const world::Image& at_level = picture.levels[number];
        const ImageSize whole = picture.levels[0].size;
        const glm::dvec2 scale(static_cast<double>(at_level.size.width) / whole.width,
                               static_cast<double>(at_level.size.height) / whole.height);
        for (int i = 0; i < blur.count(); ++i) {
            const glm::dvec2 place = (of.at + blur.step(i) + 0.5) * scale - 0.5;
            sum += share / blur.count() * bilinear(at_level, place.x, place.y, to_inside);
        }
    };
    add(fine, 1.0 - coarse_share);
    if (coarse_share > 0.0) add(fine + 1, coarse_share);
    return sum;
}

inline std::uint32_t code_of(const glm::dvec3& light) {
    const auto code = [](double channel) { return std::uint32_t{srgb_code(static_cast<float>(channel))}; };
    return code(light.r) | code(light.g) << 8 | code(light.b) << 16 | 0xFFu << 24;
}

}  // namespace camrig::render::software
