#include "core/world/backdrop/scale_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/portable_math.h"

namespace camrig::world {
namespace {

/// IEC 61966-2-1.
double linear_of_code(double code) {
    const double value = code / 255.0;
    return value <= 0.04045 ? value / 12.92 : portable::exp(2.4 * portable::log((value + 0.055) / 1.055));
}

struct Curve {
    std::array<float, 256> linear{};
    std::array<float, 256> next{};  ///< linear light from which the next code is nearer
    static constexpr int bins = 4096;
    std::array<std::uint8_t, bins + 1> least{};  ///< the code of light that is so many times 1 / bins

    Curve() {
        for (std::size_t i = 0; i < linear.size(); ++i) {
            linear[i] = static_cast<float>(linear_of_code(static_cast<double>(i)));
            next[i] = static_cast<float>(linear_of_code(static_cast<double>(i) + 0.5));
        }
        next.back() = 2.0f;
        for (int i = 0; i <= bins; ++i)
            least[static_cast<std::size_t>(i)] =
                static_cast<std::uint8_t>(std::ranges::upper_bound(next, static_cast<float>(i) / bins) - next.begin());
    }
    std::uint8_t code(float light) const {
        // The shares of a pixel may add up to a little more than 1.
        std::uint8_t code = least[static_cast<std::size_t>(std::min(light, 1.0f) * bins)];
        while (light >= next[code]) ++code;
        return code;
    }
};

/// Which pixels of a side lie under one of the other size, and with which share.
struct Span {
    int first = 0;
    std::vector<float> shares;
};

std::vector<Span> spans_of(int from, int to) {
    std::vector<Span> spans(static_cast<std::size_t>(to));
    const double step = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        Span& span = spans[static_cast<std::size_t>(i)];
        const double begin = i * step, end = std::min((i + 1) * step, static_cast<double>(from));
        span.first = std::min(static_cast<int>(begin), from - 1);
        for (int at = span.first; at < from && (at < end || at == span.first); ++at)
            span.shares.push_back(static_cast<float>(
                std::max(0.0, std::min<double>(at + 1, end) - std::max<double>(at, begin)) / (end - begin)));
    }
    return spans;
}

}  // namespace

Image scaled_picture(const Image& picture, ImageSize to) {
    Image made{.size = to, .rgba = {}};
    if (picture.size == to) {
        made.rgba = picture.rgba;
    } else {
        static const Curve curve;
        made.rgba.resize(static_cast<std::size_t>(to.pixels()) * 4);
        const std::vector<Span> columns = spans_of(picture.size.width, to.width),
                                rows = spans_of(picture.size.height, to.height);
        std::vector<float> row(static_cast<std::size_t>(to.width) * 3);
        for (int y = 0; y < to.height; ++y) {
            const Span& down = rows[static_cast<std::size_t>(y)];
            std::ranges::fill(row, 0.0f);
            for (std::size_t i = 0; i < down.shares.size(); ++i) {
                const std::uint8_t* const from =
                    picture.rgba.data() + std::size_t{4} * static_cast<std::size_t>(picture.size.width) *
                                              (static_cast<std::size_t>(down.first) + i);
                for (std::size_t x = 0; x < columns.size(); ++x) {
                    const Span& across = columns[x];
                    for (std::size_t k = 0; k < across.shares.size(); ++k) {
                        const std::uint8_t* const pixel = from + 4 * (static_cast<std::size_t>(across.first) + k);
                        const float share = down.shares[i] * across.shares[k];
                        for (std::size_t c = 0; c < 3; ++c) row[3 * x + c] += share * curve.linear[pixel[c]];
                    }
                }
            }
            std::uint8_t* const out =
                made.rgba.data() + std::size_t{4} * static_cast<std::size_t>(to.width) * static_cast<std::size_t>(y);
            for (std::size_t x = 0; x < columns.size(); ++x)
                for (std::size_t c = 0; c < 3; ++c) out[4 * x + c] = curve.code(row[3 * x + c]);
        }
    }
    for (std::size_t i = 3; i < made.rgba.size(); i += 4) made.rgba[i] = 255;
    return made;
}

}  // namespace camrig::world
