#pragma once

#include <cstdint>

namespace camrig::frame {

/// Which codes YUV uses: full is 0..255 for all three (JFIF), limited is 16..235 for Y and 16..240 for U and V.
enum class YuvRange : std::uint8_t { full, limited };

/// BT.601 (Kr 0.299, Kb 0.114) from sRGB codes in fixed point, for whoever converts (rgb_to_yuv.cpp, convert.comp):
/// integers, so all of them make the same bytes. `y = (yr * r + yg * g + yb * b + y_offset) >> fraction_bits`; U and V
/// from the sums of four pixels likewise, with `sum_offset` and `sum_bits`.
struct YuvMatrix {
    static constexpr int fraction_bits = 16;
    static constexpr int sum_bits = fraction_bits + 2;
    /// One unit short of a half (as in libjpeg), so that the full range's 255.5 becomes 255 without a comparison.
    static constexpr int sum_offset = (128 << sum_bits) + (1 << (sum_bits - 1)) - 1;

    int yr = 0, yg = 0, yb = 0, y_offset = 0;
    int ur = 0, ug = 0, ub = 0;
    int vr = 0, vg = 0, vb = 0;

    /// The green coefficients take up the rounding of the others, so that gray stays gray: Y of white is exact and
    /// U = V = 128.
    static constexpr YuvMatrix bt601(double y_scale, double uv_scale, int y_offset) {
        constexpr double kr = 0.299;
        constexpr double kb = 0.114;
        YuvMatrix m;
        m.yr = fixed(kr * y_scale);
        m.yb = fixed(kb * y_scale);
        m.yg = fixed(y_scale) - m.yr - m.yb;
        m.y_offset = (y_offset << fraction_bits) + (1 << (fraction_bits - 1));
        m.ub = fixed(0.5 * uv_scale);
        m.ur = fixed(-0.5 * kr / (1 - kb) * uv_scale);
        m.ug = -m.ub - m.ur;
        m.vr = fixed(0.5 * uv_scale);
        m.vb = fixed(-0.5 * kb / (1 - kr) * uv_scale);
        m.vg = -m.vr - m.vb;
        return m;
    }

private:
    static constexpr int fixed(double value) {
        const double scaled = value * (1 << fraction_bits);
        return static_cast<int>(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
    }
};

inline constexpr YuvMatrix full_yuv = YuvMatrix::bt601(1.0, 1.0, 0);
inline constexpr YuvMatrix limited_yuv = YuvMatrix::bt601(219.0 / 255.0, 224.0 / 255.0, 16);

}  // namespace camrig::frame
