#include "core/sensor/develop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/black_body.h"
#include "core/base/result.h"
#include "core/sensor/bayer.h"
#include "core/sensor/row_loops.h"

namespace camrig::sensor {
namespace {

/// A row of light, 1 is white, with one place before it and, behind it, what is left of a vector.
struct PaddedRow {
    std::array<float, max_row + 16> values;
    float* data() { return values.data() + 1; }
    const float* data() const { return values.data() + 1; }
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

template <typename Loops>
CAMRIG_ROW_LOOP void store(typename Loops::Ints pixels, int x, int width, std::uint32_t* __restrict to) {
    pixels |= static_cast<std::int32_t>(0xff000000U);
    if (x + Loops::lanes <= width) {
        std::memcpy(to + x, &pixels, sizeof pixels);
    } else {
        for (int i = 0; x + i < width; ++i) to[x + i] = static_cast<std::uint32_t>(pixels[i]);
    }
}

template <typename Loops>
CAMRIG_ROW_LOOP void tone_grey(const float* __restrict light, int width, std::uint32_t* __restrict to) {
    for (int x = 0; x < width; x += Loops::lanes)
        store<Loops>(srgb_codes<Loops>(Loops::load(light + x)) * 0x010101, x, width, to);
}

using Gains = float[3];

template <typename Loops>
CAMRIG_ROW_LOOP void tone_colors(const std::array<const float*, 3>& light, int width, const Gains& gains,
                                 std::uint32_t* __restrict to) {
    for (int x = 0; x < width; x += Loops::lanes) {
        typename Loops::Ints pixels{};
        for (int c = 0; c < 3; ++c)
            pixels |= srgb_codes<Loops>(Loops::load(light[static_cast<std::size_t>(c)] + x) * gains[c]) << (8 * c);
        store<Loops>(pixels, x, width, to);
    }
}

/// A row of a mosaic, whose photosites have its own colour (red or blue) and green in turns: bilinear interpolation.
/// own: 0 or 1, where the first of its own is.
template <typename Loops>
CAMRIG_ROW_LOOP void tone_mosaic(const float* __restrict above, const float* __restrict row,
                                 const float* __restrict below, int width, int own, bool has_red, const Gains& gains,
                                 std::uint32_t* __restrict to) {
    using Floats = typename Loops::Floats;
    const float own_gain = gains[has_red ? 0 : 2], other_gain = gains[has_red ? 2 : 0];
    const int own_shift = has_red ? 0 : 16, other_shift = 16 - own_shift;
    const auto is_own = (Loops::lane_numbers() & 1) == own;
    for (int x = 0; x < width; x += Loops::lanes) {
        const Floats here = Loops::load(row + x);
        const Floats beside = (Loops::load(row + x - 1) + Loops::load(row + x + 1)) * 0.5f;
        const Floats over = (Loops::load(above + x) + Loops::load(below + x)) * 0.5f;
        const Floats diagonal = (Loops::load(above + x - 1) + Loops::load(above + x + 1) + Loops::load(below + x - 1) +
                                 Loops::load(below + x + 1)) *
                                0.25f;
        const Floats own_color = is_own ? here : beside, green = is_own ? (beside + over) * 0.5f : here,
                     other_color = is_own ? diagonal : over;
        store<Loops>(srgb_codes<Loops>(own_color * own_gain) << own_shift | srgb_codes<Loops>(green * gains[1]) << 8 |
                         srgb_codes<Loops>(other_color * other_gain) << other_shift,
                     x, width, to);
    }
}

/// Light of the rows of numbers, of which three are looked at for each row of a mosaic's picture.
struct LightOfNumbers {
    const std::uint16_t* numbers;
    ImageSize size;
    float black, scale;
    std::array<PaddedRow, 3> rows;
    std::array<int, 3> held;  ///< which row each of them is; -1: none yet

    void begin(const SensorSpec& spec, ImageSize of_size, const std::uint16_t* of_numbers) {
        numbers = of_numbers;
        size = of_size;
        black = static_cast<float>(spec.black());
        scale = static_cast<float>(1.0 / (spec.max_number() - spec.black()));
        held.fill(-1);
    }
    CAMRIG_ROW_LOOP const float* row(int y) {
        const auto i = static_cast<std::size_t>(y % 3);
        if (std::exchange(held[i], y) != y) read(0, y, rows[i]);
        return rows[i].data();
    }
    CAMRIG_ROW_LOOP const float* row_of_plane(int plane, int y) {
        PaddedRow& into = rows[static_cast<std::size_t>(plane)];
        read(plane, y, into);
        return into.data();
    }

private:
    CAMRIG_ROW_LOOP void read(int plane, int y, PaddedRow& into) const {
        light_of(numbers + (std::ptrdiff_t{plane} * size.height + y) * size.width, size.width, black, scale,
                 into.data());
        pad(into, size.width);
    }
};

/// Row y of the picture.
template <typename Loops>
CAMRIG_ROW_LOOP void develop_row(const SensorSpec& spec, LightOfNumbers& light, int y, const Gains& gains,
                                 std::uint32_t* to) {
    const int width = light.size.width, height = light.size.height;
    if (spec.is_bayer()) {
        const int edge = height > 1 ? 1 : 0;
        const int above = y > 0 ? y - 1 : edge, below = y + 1 < height ? y + 1 : y - edge;
        const RedPlace red = red_place(spec.filter);
        const bool has_red = ((y ^ red.y) & 1) == 0;
        const int own = has_red ? red.x : 1 - red.x;
        tone_mosaic<Loops>(light.row(above), light.row(y), light.row(below), width, own, has_red, gains, to);
    } else if (spec.planes() == 1) {
        tone_grey<Loops>(light.row_of_plane(0, y), width, to);
    } else {
        tone_colors<Loops>({light.row_of_plane(0, y), light.row_of_plane(1, y), light.row_of_plane(2, y)}, width, gains,
                           to);
    }
}

CAMRIG_WIDE_ROWS void develop_wide(const SensorSpec& spec, LightOfNumbers& light, int y, const Gains& gains,
                                   std::uint32_t* to) {
    develop_row<RowLoops<EightLanes>>(spec, light, y, gains, to);
}
void develop_plain(const SensorSpec& spec, LightOfNumbers& light, int y, const Gains& gains, std::uint32_t* to) {
    develop_row<RowLoops<FourLanes>>(spec, light, y, gains, to);
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
    Gains gains;
    for (std::size_t c = 0; c < 3; ++c) gains[c] = static_cast<float>(balance.gains[c]);
    thread_local LightOfNumbers light;
    light.begin(spec, size, numbers.data());
    for (int y = first_row; y < end_row; ++y) {
        std::uint32_t* const row = to.pixels + y * to.stride;
        if (wide) {
            develop_wide(spec, light, y, gains, row);
        } else {
            develop_plain(spec, light, y, gains, row);
        }
    }
}

}  // namespace camrig::sensor
