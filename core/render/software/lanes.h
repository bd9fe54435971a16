#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/render/software/canvas.h"

/// Eight neighbouring pixels at once, as vectors of the compiler: with AVX2 one instruction each, without it two or
/// four. Only what IEEE 754 defines exactly is used and nothing is contracted (-ffp-contract=off): every CPU gives the
/// same bits.
namespace camrig::render::software {

using Lanes = float __attribute__((vector_size(32)));
using IntLanes = std::int32_t __attribute__((vector_size(32)));
using Doubles4 = double __attribute__((vector_size(32)));
using Words4 = std::int64_t __attribute__((vector_size(32)));

/// For code that is compiled once for each instruction set, inlined into a function that names it.
#define CAMRIG_LANES [[gnu::always_inline]] inline

CAMRIG_LANES Lanes lanes(float value) {
    return Lanes{} + value;
}
CAMRIG_LANES Lanes lane_numbers() {
    return Lanes{0, 1, 2, 3, 4, 5, 6, 7};
}
CAMRIG_LANES IntLanes int_lane_numbers() {
    return IntLanes{0, 1, 2, 3, 4, 5, 6, 7};
}
/// Vectors from anywhere in memory and to there: no compiler may take the address for one that suits a vector.
CAMRIG_LANES IntLanes load_lanes(const void* from) {
    IntLanes values;
    std::memcpy(&values, from, sizeof values);
    return values;
}
template <typename Vector>
CAMRIG_LANES void store_lanes(void* to, const Vector& values) {
    std::memcpy(to, &values, sizeof values);
}
CAMRIG_LANES Lanes min(Lanes a, Lanes b) {
    return a < b ? a : b;
}
CAMRIG_LANES Lanes max(Lanes a, Lanes b) {
    return a > b ? a : b;
}
CAMRIG_LANES IntLanes min(IntLanes a, IntLanes b) {
    return a < b ? a : b;
}
CAMRIG_LANES IntLanes max(IntLanes a, IntLanes b) {
    return a > b ? a : b;
}
CAMRIG_LANES Lanes clamp01(Lanes value) {
    // As whole numbers: those of floats that are not negative are in the same order, and a compiler that knows the
    // bounds of floats makes five instructions of what then are two.
    const auto bits = min(reinterpret_cast<IntLanes>(value), IntLanes{} + std::bit_cast<std::int32_t>(1.0f));
    return reinterpret_cast<Lanes>(max(bits, IntLanes{}));
}
CAMRIG_LANES Lanes sqrt(Lanes value) {
    for (int i = 0; i < lane_count; ++i) value[i] = std::sqrt(value[i]);
    return value;
}
CAMRIG_LANES IntLanes truncated(Lanes value) {
    return __builtin_convertvector(value, IntLanes);
}
/// For magnitudes below 2^31.
CAMRIG_LANES Lanes floor(Lanes value) {
    const Lanes whole = __builtin_convertvector(truncated(value), Lanes);
    return whole + __builtin_convertvector(whole > value, Lanes);
}

/// Eight doubles.
struct Doubles {
    Doubles4 low, high;
};
CAMRIG_LANES Doubles operator-(const Doubles& a, const Doubles& b) {
    return {a.low - b.low, a.high - b.high};
}
CAMRIG_LANES Doubles operator*(const Doubles& a, const Doubles& b) {
    return {a.low * b.low, a.high * b.high};
}
CAMRIG_LANES Doubles operator+(const Doubles& a, const Doubles& b) {
    return {a.low + b.low, a.high + b.high};
}
CAMRIG_LANES Doubles operator+(const Doubles& a, double b) {
    return {a.low + b, a.high + b};
}
CAMRIG_LANES Doubles operator/(double a, const Doubles& b) {
    return {a / b.low, a / b.high};
}
CAMRIG_LANES Doubles operator*(const Doubles& a, double b) {
    return {a.low * b, a.high * b};
}
CAMRIG_LANES Doubles operator-(double a, const Doubles& b) {
    return {a - b.low, a - b.high};
}
CAMRIG_LANES Doubles operator-(const Doubles& a) {
    return {-a.low, -a.high};
}
CAMRIG_LANES Doubles sqrt(Doubles value) {
    for (int i = 0; i < 4; ++i) {
        value.low[i] = std::sqrt(value.low[i]);
        value.high[i] = std::sqrt(value.high[i]);
    }
    return value;
}
CAMRIG_LANES Doubles widened(IntLanes value) {
    return {__builtin_convertvector(__builtin_shufflevector(value, value, 0, 1, 2, 3), Doubles4),
            __builtin_convertvector(__builtin_shufflevector(value, value, 4, 5, 6, 7), Doubles4)};
}
CAMRIG_LANES Doubles widened(Lanes value) {
    return {__builtin_convertvector(__builtin_shufflevector(value, value, 0, 1, 2, 3), Doubles4),
            __builtin_convertvector(__builtin_shufflevector(value, value, 4, 5, 6, 7), Doubles4)};
}
CAMRIG_LANES Doubles magnitude(const Doubles& value) {
    return {value.low < 0.0 ? -value.low : value.low, value.high < 0.0 ? -value.high : value.high};
}
/// A mask of eight doubles as one of eight lanes.
CAMRIG_LANES IntLanes narrowed(Words4 low, Words4 high) {
    return __builtin_shufflevector(reinterpret_cast<IntLanes>(low), reinterpret_cast<IntLanes>(high), 0, 2, 4, 6, 8, 10,
                                   12, 14);
}
CAMRIG_LANES IntLanes operator<(const Doubles& a, const Doubles& b) {
    return narrowed(a.low < b.low, a.high < b.high);
}
CAMRIG_LANES IntLanes operator<=(const Doubles& a, const Doubles& b) {
    return narrowed(a.low <= b.low, a.high <= b.high);
}
CAMRIG_LANES Doubles select(IntLanes mask, const Doubles& yes, const Doubles& no) {
    const auto low = __builtin_convertvector(__builtin_shufflevector(mask, mask, 0, 1, 2, 3), Words4);
    const auto high = __builtin_convertvector(__builtin_shufflevector(mask, mask, 4, 5, 6, 7), Words4);
    return {low ? yes.low : no.low, high ? yes.high : no.high};
}
/// To the nearest whole number, halves to the even one; for magnitudes below 2^31.
CAMRIG_LANES IntLanes rounded(const Doubles& value) {
    using Ints4 = std::int32_t __attribute__((vector_size(16)));
    constexpr double shift = 6755399441055744.0;  // 1.5 * 2^52: beyond it, doubles are whole numbers
    return __builtin_shufflevector(__builtin_convertvector(value.low + shift - shift, Ints4),
                                   __builtin_convertvector(value.high + shift - shift, Ints4), 0, 1, 2, 3, 4, 5, 6, 7);
}
CAMRIG_LANES Lanes narrowed(const Doubles& value) {
    using Floats4 = float __attribute__((vector_size(16)));
    return __builtin_shufflevector(__builtin_convertvector(value.low, Floats4),
                                   __builtin_convertvector(value.high, Floats4), 0, 1, 2, 3, 4, 5, 6, 7);
}

struct Lanes3 {
    Lanes x, y, z;
};
CAMRIG_LANES Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
CAMRIG_LANES Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
CAMRIG_LANES Lanes3 operator*(const Lanes3& a, const Lanes3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
CAMRIG_LANES Lanes3 operator*(const Lanes3& a, Lanes b) {
    return {a.x * b, a.y * b, a.z * b};
}
CAMRIG_LANES Lanes dot(const Lanes3& a, const Lanes3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Up to eight indices; where fewer are left, the last is repeated.
CAMRIG_LANES IntLanes indices_at(const std::uint32_t* from, std::size_t left) {
    if (left >= static_cast<std::size_t>(lane_count)) [[likely]]
        return load_lanes(from);
    IntLanes made{};
    for (int k = 0; k < lane_count; ++k)
        made[k] = static_cast<std::int32_t>(
            from[static_cast<std::size_t>(k) < left ? static_cast<std::size_t>(k) : left - 1]);
    return made;
}

/// Four words that lie beside each other in memory, for each lane.
using Quads = std::array<IntLanes, 4>;

/// All that code for two instruction sets differs in; the results are the same. gather: what lies at from[at[k]] for
/// each lane k; of 64 bits for lanes 0 to 3 or 4 to 7. quads: the four words from from[at[k]] on, by whole loads:
/// gathers take several times as long on many CPUs. bits: one for each lane of a mask that is set.
struct PlainIsa {
    static inline unsigned bits(const IntLanes& mask) {
        unsigned made = 0;
        for (int k = 0; k < lane_count; ++k) made |= static_cast<unsigned>(mask[k] < 0) << k;
        return made;
    }
    static inline void gather(const float* from, const IntLanes& at, Lanes& to) {
        for (int k = 0; k < lane_count; ++k) to[k] = from[at[k]];
    }
    template <int half>
    static inline void gather(const std::int64_t* from, const IntLanes& at, Words4& to) {
        for (int k = 0; k < 4; ++k) to[k] = from[at[4 * half + k]];
    }
    static inline void quads(const std::int32_t* from, const IntLanes& at, Quads& to) {
        for (int k = 0; k < lane_count; ++k)
            for (int i = 0; i < 4; ++i) to[static_cast<std::size_t>(i)][k] = from[at[k] + i];
    }
};
#if defined(__x86_64__)
struct Avx2Isa {
    [[gnu::target("avx2")]] static inline unsigned bits(const IntLanes& mask) {
        return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
    }
    [[gnu::target("avx2")]] static inline void gather(const float* from, const IntLanes& at, Lanes& to) {
        to = _mm256_i32gather_ps(from, reinterpret_cast<__m256i>(at), 4);
    }
    template <int half>
    [[gnu::target("avx2")]] static inline void gather(const std::int64_t* from, const IntLanes& at, Words4& to) {
        const __m128i four = _mm256_extracti128_si256(reinterpret_cast<__m256i>(at), half);
        to = reinterpret_cast<Words4>(_mm256_i32gather_epi64(reinterpret_cast<const long long*>(from), four, 8));
    }
    [[gnu::target("avx2")]] static inline void quads(const std::int32_t* from, const IntLanes& at, Quads& to) {
        alignas(32) std::int32_t index[lane_count];
        std::memcpy(index, &at, sizeof index);
        const auto both = [&](int k) __attribute__((always_inline, target("avx2"))) {
            const auto* const low = reinterpret_cast<const __m128i*>(from + index[k]);
            const auto* const high = reinterpret_cast<const __m128i*>(from + index[k + 4]);
            return _mm256_inserti128_si256(_mm256_castsi128_si256(_mm_loadu_si128(low)), _mm_loadu_si128(high), 1);
        };
        // Four by four words are transposed in each half.
        const __m256i a = both(0), b = both(1), c = both(2), d = both(3);
        const __m256i ab_low = _mm256_unpacklo_epi32(a, b), ab_high = _mm256_unpackhi_epi32(a, b);
        const __m256i cd_low = _mm256_unpacklo_epi32(c, d), cd_high = _mm256_unpackhi_epi32(c, d);
        to[0] = reinterpret_cast<IntLanes>(_mm256_unpacklo_epi64(ab_low, cd_low));
        to[1] = reinterpret_cast<IntLanes>(_mm256_unpackhi_epi64(ab_low, cd_low));
        to[2] = reinterpret_cast<IntLanes>(_mm256_unpacklo_epi64(ab_high, cd_high));
        to[3] = reinterpret_cast<IntLanes>(_mm256_unpackhi_epi64(ab_high, cd_high));
    }
};
#else
using Avx2Isa = PlainIsa;
#endif

/// For functions that inline code with Avx2Isa.
#if defined(__x86_64__)
#define CAMRIG_WIDE [[gnu::target("avx2")]]
#else
#define CAMRIG_WIDE
#endif

template <typename Isa>
CAMRIG_LANES Lanes gathered(const float* from, IntLanes at) {
    Lanes made;
    Isa::gather(from, at, made);
    return made;
}
template <typename Isa>
CAMRIG_LANES IntLanes gathered(const std::int32_t* from, IntLanes at) {
    return reinterpret_cast<IntLanes>(gathered<Isa>(reinterpret_cast<const float*>(from), at));
}
template <typename Isa>
CAMRIG_LANES Doubles gathered(const double* from, IntLanes at) {
    Words4 low, high;
    Isa::template gather<0>(reinterpret_cast<const std::int64_t*>(from), at, low);
    Isa::template gather<1>(reinterpret_cast<const std::int64_t*>(from), at, high);
    return {reinterpret_cast<Doubles4>(low), reinterpret_cast<Doubles4>(high)};
}

}  // namespace camrig::render::software
