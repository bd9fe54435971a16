#include "core/render/software/panorama_sampling.h"

#include <algorithm>
#include <cmath>

namespace camrig::render::software {
namespace {

/// Beyond the top and the bottom is the other side of the pole.
void around_poles(int& x, int& y, ImageSize size) {
    const auto [width, height] = size;
    if (y < 0 || y >= height) {
        y = y < 0 ? -1 - y : 2 * height - 1 - y;
        x += width / 2;
    }
    x %= width;
    if (x < 0) x += width;
}

/// What is there of a pixel of the view.
struct Part {
    glm::dvec3 light{0.0};  ///< of that share of it
    double share = 0.0;

    void add(double times, const std::uint8_t* pixel) {
        if (pixel == nullptr) return;
        const auto& linear = linear_of_code();
        light += times * glm::dvec3(linear[pixel[0]], linear[pixel[1]], linear[pixel[2]]);
        share += times;
    }
};

void add_bilinear(Part& sum, double times, const world::SparsePicture& picture, const glm::dvec2& place) {
    const double column = std::floor(place.x), row = std::floor(place.y);
    const double right = place.x - column, below = place.y - row;
    const auto add = [&](int dx, int dy, double weight) {
        int x = static_cast<int>(column) + dx, y = static_cast<int>(row) + dy;
        around_poles(x, y, picture.size());
        sum.add(times * weight, picture.at(x, y));
    };
    add(0, 0, (1.0 - below) * (1.0 - right));
    add(1, 0, (1.0 - below) * right);
    add(0, 1, below * (1.0 - right));
    add(1, 1, below * right);
}

Footprint scaled(const Footprint& of, double times) {
    return {(of.at + 0.5) * times - 0.5, of.dx * times, of.dy * times};
}

}  // namespace

glm::dvec3 sampled(const world::Panorama& panorama, const Footprint& of) {
    const std::vector<world::SparsePicture>& finer = panorama.finer;
    const auto whole = [&] { return sampled(panorama.whole, of, around_poles); };
    if (finer.empty()) return whole();
    const Footprint finest = scaled(of, static_cast<double>(1u << finer.size()));
    const Blur blur = blur_of(finest);
    const auto first = static_cast<std::size_t>(blur.level);
    if (first >= finer.size()) return whole();
    // Of the first, as of all, what is coarser shows where it ends; and with a growing share everywhere, until a
    // pixel of the view is as large as one of the next.
    double left = 1.0, of_level = 1.0 - (blur.level - static_cast<double>(first));
    glm::dvec3 light(0.0);
    for (std::size_t i = first; i < finer.size(); ++i, of_level = 1.0) {
        Part part;
        const double times = 1.0 / static_cast<double>(1u << i);
        for (int n = 0; n < blur.count(); ++n)
            add_bilinear(part, 1.0 / blur.count(), finer[i], (finest.at + blur.step(n) + 0.5) * times - 0.5);
        light += left * of_level * part.light;
        left *= 1.0 - of_level * part.share;
        constexpr double rounding = 1e-9;
        if (left < rounding) return light;
    }
    return light + left * whole();
}

}  // namespace camrig::render::software
