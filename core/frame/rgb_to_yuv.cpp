#include "core/frame/rgb_to_yuv.h"

#include <cstring>

namespace camrig {
namespace {

constexpr int fraction_bits = 16;

/// Rounds a coefficient to fixed point.
constexpr int fixed(double value) {
    const double scaled = value * (1 << fraction_bits);
    return static_cast<int>(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

struct Matrix {
    int yr, yg, yb, y_offset;
    int ur, ug, ub;
    int vr, vg, vb;
};

/// The green coefficients take up the rounding of the others, so that gray stays gray: Y of white is exact and U = V =
/// 128.
constexpr Matrix bt601(double y_scale, double uv_scale, int y_offset) {
    constexpr double kr = 0.299;
    constexpr double kb = 0.114;
    Matrix m{};
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

constexpr Matrix full = bt601(1.0, 1.0, 0);
constexpr Matrix limited = bt601(219.0 / 255.0, 224.0 / 255.0, 16);

// A pixel as a little-endian number: R in the lowest byte. Byte lanes come out by shifts, which vectorise better than
// loads with stride 4.
inline std::uint32_t load_pixel(const std::byte* rgba, int x) {
    std::uint32_t pixel;
    std::memcpy(&pixel, rgba + 4 * static_cast<std::ptrdiff_t>(x), 4);
    return pixel;
}

template <const Matrix& m>
[[gnu::always_inline]] inline void luma_row_body(const std::byte* rgba, int width, std::byte* __restrict y) {
    for (int x = 0; x < width; ++x) {
        const std::uint32_t p = load_pixel(rgba, x);
        const int r = static_cast<int>(p & 255U);
        const int g = static_cast<int>((p >> 8) & 255U);
        const int b = static_cast<int>((p >> 16) & 255U);
        y[x] = static_cast<std::byte>((m.yr * r + m.yg * g + m.yb * b + m.y_offset) >> fraction_bits);
    }
}

/// U and V from the sums of four pixels. The half is one unit short of a half (as in libjpeg), so that the full range's
/// 255.5 becomes 255 without a comparison.
struct Chroma {
    std::byte u, v;
};
template <const Matrix& m>
[[gnu::always_inline]] inline Chroma chroma_of_sums(int r, int g, int b) {
    constexpr int shift = fraction_bits + 2;
    constexpr int offset = (128 << shift) + (1 << (shift - 1)) - 1;
    return {static_cast<std::byte>((m.ur * r + m.ug * g + m.ub * b + offset) >> shift),
            static_cast<std::byte>((m.vr * r + m.vg * g + m.vb * b + offset) >> shift)};
}

template <const Matrix& m>
[[gnu::always_inline]] inline void chroma_row_body(const std::byte* rgba_0, const std::byte* rgba_1, int width,
                                                   std::byte* __restrict u, std::byte* __restrict v) {
    // R and B (then G) of a pixel sit in one 32-bit number with 16 bits each, so one addition sums both.
    constexpr std::uint32_t even_bytes = 0x00ff00ffU;
    const int pairs = width / 2;
    for (int x = 0; x < pairs; ++x) {
        const std::uint32_t p = load_pixel(rgba_0, 2 * x);
        const std::uint32_t q = load_pixel(rgba_0, 2 * x + 1);
        const std::uint32_t s = load_pixel(rgba_1, 2 * x);
        const std::uint32_t t = load_pixel(rgba_1, 2 * x + 1);
        const std::uint32_t rb = (p & even_bytes) + (q & even_bytes) + (s & even_bytes) + (t & even_bytes);
        const std::uint32_t g = ((p >> 8) & 255U) + ((q >> 8) & 255U) + ((s >> 8) & 255U) + ((t >> 8) & 255U);
        const Chroma c =
            chroma_of_sums<m>(static_cast<int>(rb & 0xffffU), static_cast<int>(g), static_cast<int>(rb >> 16));
        u[x] = c.u;
        v[x] = c.v;
    }
    if (width % 2 == 0) return;
    const std::uint32_t p = load_pixel(rgba_0, width - 1);
    const std::uint32_t s = load_pixel(rgba_1, width - 1);
    const auto sum = [&](int bits) { return static_cast<int>(2 * ((p >> bits) & 255U) + 2 * ((s >> bits) & 255U)); };
    const Chroma c = chroma_of_sums<m>(sum(0), sum(8), sum(16));
    u[pairs] = c.u;
    v[pairs] = c.v;
}

void luma_row_plain(YuvRange range, const std::byte* rgba, int width, std::byte* y) {
    range == YuvRange::full ? luma_row_body<full>(rgba, width, y) : luma_row_body<limited>(rgba, width, y);
}
void chroma_row_plain(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1, int width, std::byte* u,
                      std::byte* v) {
    range == YuvRange::full ? chroma_row_body<full>(rgba_0, rgba_1, width, u, v)
                            : chroma_row_body<limited>(rgba_0, rgba_1, width, u, v);
}

// The same C++ compiled a second time for AVX2, chosen by a plain branch: target_clones would do it with an ifunc,
// whose resolver runs before the sanitizers are ready.
#if defined(__x86_64__)
[[gnu::target("avx2")]] void luma_row_avx2(YuvRange range, const std::byte* rgba, int width, std::byte* y) {
    range == YuvRange::full ? luma_row_body<full>(rgba, width, y) : luma_row_body<limited>(rgba, width, y);
}
[[gnu::target("avx2")]] void chroma_row_avx2(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1,
                                             int width, std::byte* u, std::byte* v) {
    range == YuvRange::full ? chroma_row_body<full>(rgba_0, rgba_1, width, u, v)
                            : chroma_row_body<limited>(rgba_0, rgba_1, width, u, v);
}
bool has_avx2() {
    return __builtin_cpu_supports("avx2");
}
#else
constexpr auto luma_row_avx2 = luma_row_plain;
constexpr auto chroma_row_avx2 = chroma_row_plain;
constexpr bool has_avx2() {
    return false;
}
#endif

}  // namespace

void luma_row(YuvRange range, const std::byte* rgba, int width, std::byte* y) {
    has_avx2() ? luma_row_avx2(range, rgba, width, y) : luma_row_plain(range, rgba, width, y);
}

void chroma_row(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1, int width, std::byte* u,
                std::byte* v) {
    has_avx2() ? chroma_row_avx2(range, rgba_0, rgba_1, width, u, v)
               : chroma_row_plain(range, rgba_0, rgba_1, width, u, v);
}

}  // namespace camrig
