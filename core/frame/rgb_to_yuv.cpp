#include "core/frame/rgb_to_yuv.h"

#include <cstring>

#include "core/base/cpu_features.h"

namespace camrig::frame {
namespace {

// A pixel as a little-endian number: R in the lowest byte. Byte lanes come out by shifts, which vectorise better than
// loads with stride 4.
inline std::uint32_t load_pixel(const std::byte* rgba, int x) {
    std::uint32_t pixel;
    std::memcpy(&pixel, rgba + 4 * static_cast<std::ptrdiff_t>(x), 4);
    return pixel;
}

template <const YuvMatrix& m>
[[gnu::always_inline]] inline void luma_row_body(const std::byte* rgba, int width, std::byte* __restrict y) {
    for (int x = 0; x < width; ++x) {
        const std::uint32_t p = load_pixel(rgba, x);
        const int r = static_cast<int>(p & 255U);
        const int g = static_cast<int>((p >> 8) & 255U);
        const int b = static_cast<int>((p >> 16) & 255U);
        y[x] = static_cast<std::byte>((m.yr * r + m.yg * g + m.yb * b + m.y_offset) >> YuvMatrix::fraction_bits);
    }
}

/// U and V from the sums of four pixels.
struct Chroma {
    std::byte u, v;
};
template <const YuvMatrix& m>
[[gnu::always_inline]] inline Chroma chroma_of_sums(int r, int g, int b) {
    return {static_cast<std::byte>((m.ur * r + m.ug * g + m.ub * b + m.sum_offset) >> m.sum_bits),
            static_cast<std::byte>((m.vr * r + m.vg * g + m.vb * b + m.sum_offset) >> m.sum_bits)};
}

template <const YuvMatrix& m>
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
    range == YuvRange::full ? luma_row_body<full_yuv>(rgba, width, y) : luma_row_body<limited_yuv>(rgba, width, y);
}
void chroma_row_plain(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1, int width, std::byte* u,
                      std::byte* v) {
    range == YuvRange::full ? chroma_row_body<full_yuv>(rgba_0, rgba_1, width, u, v)
                            : chroma_row_body<limited_yuv>(rgba_0, rgba_1, width, u, v);
}

// The same C++ compiled a second time for AVX2, chosen by a plain branch: target_clones would do it with an ifunc,
// whose resolver runs before the sanitizers are ready.
#if defined(__x86_64__)
[[gnu::target("avx2")]] void luma_row_avx2(YuvRange range, const std::byte* rgba, int width, std::byte* y) {
    range == YuvRange::full ? luma_row_body<full_yuv>(rgba, width, y) : luma_row_body<limited_yuv>(rgba, width, y);
}
[[gnu::target("avx2")]] void chroma_row_avx2(YuvRange range, const std::byte* rgba_0, const std::byte* rgba_1,
                                             int width, std::byte* u, std::byte* v) {
    range == YuvRange::full ? chroma_row_body<full_yuv>(rgba_0, rgba_1, width, u, v)
                            : chroma_row_body<limited_yuv>(rgba_0, rgba_1, width, u, v);
}
#else
constexpr auto luma_row_avx2 = luma_row_plain;
constexpr auto chroma_row_avx2 = chroma_row_plain;
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

}  // namespace camrig::frame
