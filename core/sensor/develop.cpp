#include "core/sensor/develop.h"

#include <algorithm>
#include <cmath>

#include "core/base/black_body.h"
#include "core/base/result.h"
#include "core/sensor/bayer.h"
#include "core/sensor/row_loops.h"

namespace camrig::sensor {
namespace {

/// A row of light, 1 is white, with one place before it and one behind it.
struct PaddedRow {
    std::array<float, max_row + 2> values;
    float* data() { return values.data() + 1; }
    const float* data() const { return values.data() + 1; }
};
struct ColorRows {
    std::array<float, max_row> red, green, blue;
};

CAMRIG_ROW_LOOP void light_of(const std::uint16_t* __restrict numbers, int width, float black, float scale,
                              float* __restrict light) {
    for (int x = 0; x < width; ++x) light[x] = (static_cast<float>(numbers[x]) - black) * scale;
}

/// What is left and right of a row of a mosaic is as two places further in: there are the same colours.
void pad(PaddedRow& row, int width) {
    float* const light = row.data();
    light[-1] = light[width > 1 ? 1 : 0];
    light[width] = light[width > 1 ? width - 2 : 0];
}

/// The photosites that have the row's own colour (red or blue), and the green ones between them. own: 0 or 1, where the
/// first of them is.
CAMRIG_ROW_LOOP void interpolate(const float* __restrict above, const float* __restrict row,
                                 const float* __restrict below, int width, int own, float* __restrict own_color,
                                 float* __restrict green, float* __restrict other_color) {
    for (int x = 0; x < width; ++x) {
        const float beside = (row[x - 1] + row[x + 1]) * 0.5f, over = (above[x] + below[x]) * 0.5f;
        const float diagonal = (above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1]) * 0.25f;
        const bool is_own = (x & 1) == own;
        own_color[x] = is_own ? row[x] : beside;
        green[x] = is_own ? (beside + over) * 0.5f : row[x];
        other_color[x] = is_own ? diagonal : over;
    }
}

/// Of the sRGB curve, from 0 to 255: x^(1/2.4) fitted by two square roots.
template <typename Loops>
CAMRIG_ROW_LOOP typename Loops::Ints srgb_codes(typename Loops::Floats linear) {
    using Floats = typename Loops::Floats;
    const Floats c = Loops::at_most(Loops::at_least(linear, 0.0f), 1.0f);
    const Floats root = Loops::root_of(c);
    const Floats high =
        0.91269030f * root + 0.25450221f * Loops::root_of(root) + c * (0.03564411f * root - 0.13222371f) - 0.07051239f;
    return Loops::truncated((c <= 0.0031308f ? 12.92f * c : high) * 255.0f + 0.5f);
}

/// Pixels from planes of light, all three the same for grey.
template <typename Loops>
CAMRIG_ROW_LOOP void tone(const std::array<const float*, 3>& light, int width, const float (&gains)[3],
                          std::uint32_t* __restrict to) {
    using Ints = typename Loops::Ints;
    constexpr int lanes = Loops::lanes;
    const bool is_grey = light[0] == light[2];
    for (int x = 0; x < width; x += lanes) {
        Ints pixels = srgb_codes<Loops>(Loops::load(light[0] + x) * gains[0]);
        if (is_grey) {
            pixels *= 0x010101;
        } else {
            pixels |= srgb_codes<Loops>(Loops::load(light[1] + x) * gains[1]) << 8 |
                      srgb_codes<Loops>(Loops::load(light[2] + x) * gains[2]) << 16;
        }
        pixels |= static_cast<std::int32_t>(0xff000000U);
        if (x + lanes <= width) {
            std::memcpy(to + x, &pixels, sizeof pixels);
        } else {
            for (int i = 0; x + i < width; ++i) to[x + i] = static_cast<std::uint32_t>(pixels[i]);
        }
    }
}

/// Row y of the picture.
template <typename Loops>
CAMRIG_ROW_LOOP void develop_row(const SensorSpec& spec, ImageSize size, const std::uint16_t* numbers, int y,
                                 const float (&gains)[3], std::uint32_t* to) {
    thread_local PaddedRow rows[3];
    thread_local ColorRows colors;
    const auto black = static_cast<float>(spec.black());
    const auto scale = static_cast<float>(1.0 / (spec.max_number() - spec.black()));
    const auto read = [&](int plane, int row, PaddedRow& into) __attribute__((always_inline)) {
        light_of(numbers + (std::ptrdiff_t{plane} * size.height + row) * size.width, size.width, black, scale,
                 into.data());
    };
    if (spec.is_bayer()) {
        const int edge = size.height > 1 ? 1 : 0;
        const int above = y > 0 ? y - 1 : edge, below = y + 1 < size.height ? y + 1 : y - edge;
        read(0, above, rows[0]);
        read(0, y, rows[1]);
        read(0, below, rows[2]);
        for (PaddedRow& row : rows) pad(row, size.width);
        const RedPlace red = red_place(spec.filter);
        const bool has_red = ((y ^ red.y) & 1) == 0;
        const int own = has_red ? red.x : 1 - red.x;
        interpolate(rows[0].data(), rows[1].data(), rows[2].data(), size.width, own,
                    has_red ? colors.red.data() : colors.blue.data(), colors.green.data(),
                    has_red ? colors.blue.data() : colors.red.data());
        tone<Loops>({colors.red.data(), colors.green.data(), colors.blue.data()}, size.width, gains, to);
    } else {
        const int planes = spec.planes();
        for (int plane = 0; plane < planes; ++plane) read(plane, y, rows[plane]);
        tone<Loops>({rows[0].data(), rows[planes == 3 ? 1 : 0].data(), rows[planes == 3 ? 2 : 0].data()}, size.width,
                    gains, to);
    }
}

CAMRIG_WIDE_ROWS void develop_wide(const SensorSpec& spec, ImageSize size, const std::uint16_t* numbers, int y,
                                   const float (&gains)[3], std::uint32_t* to) {
    develop_row<RowLoops<EightLanes>>(spec, size, numbers, y, gains, to);
}
void develop_plain(const SensorSpec& spec, ImageSize size, const std::uint16_t* numbers, int y, const float (&gains)[3],
                   std::uint32_t* to) {
    develop_row<RowLoops<FourLanes>>(spec, size, numbers, y, gains, to);
}

}  // namespace

WhiteBalance WhiteBalance::normalised(const std::array<double, 3>& gains) {
    const double smallest = std::min({gains[0], gains[1], gains[2]});
    return {{gains[0] / smallest, gains[1] / smallest, gains[2] / smallest}};
}

WhiteBalance WhiteBalance::of_kelvin(const SensorSpec& spec, double kelvin) {
    if (spec.filter == ColorFilter::mono) return {};
    std::array<double, 3> gains = white_balance_of(kelvin);
    const auto responses = spec.responses();
    for (std::size_t c = 0; c < 3; ++c) gains[c] /= responses[c];
    return normalised(gains);
}

void develop(const SensorSpec& spec, ImageSize size, std::span<const std::uint16_t> numbers,
             const WhiteBalance& balance, int first_row, int end_row, const Rgba8Rows& to, bool wide) {
    CHECK(numbers.size() == static_cast<std::size_t>(size.pixels() * spec.planes()) && size.width <= max_row);
    CHECK(0 <= first_row && first_row <= end_row && end_row <= size.height);
    float gains[3];
    for (std::size_t c = 0; c < 3; ++c) gains[c] = static_cast<float>(balance.gains[c]);
    for (int y = first_row; y < end_row; ++y) {
        std::uint32_t* const row = to.pixels + y * to.stride;
        if (wide) {
            develop_wide(spec, size, numbers.data(), y, gains, row);
        } else {
            develop_plain(spec, size, numbers.data(), y, gains, row);
        }
    }
}

}  // namespace camrig::sensor
