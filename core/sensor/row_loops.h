#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/sensor/expose_row.h"

/// The loops of expose_row.h as vectors of the compiler: of eight photosites with AVX2, of four on every other x86-64
/// processor. Only what IEEE 754 defines exactly is used, nothing is contracted (-ffp-contract=off) and no sum runs
/// across photosites: every processor, vector width and compiler gives the same bits.
#define CAMRIG_ROW_LOOP [[gnu::always_inline]] inline
/// For functions that inline them for AVX2.
#if defined(__x86_64__)
#define CAMRIG_WIDE_ROWS [[gnu::target("avx2")]]
#else
#define CAMRIG_WIDE_ROWS
#endif

namespace camrig::sensor {

#define CAMRIG_LANES_OF(name, count)                                            \
    struct name {                                                               \
        static constexpr int lanes = count;                                     \
        using Floats = float __attribute__((vector_size(4 * (count))));         \
        using Ints = std::int32_t __attribute__((vector_size(4 * (count))));    \
        using Words = std::uint32_t __attribute__((vector_size(4 * (count))));  \
        using Longs = std::int64_t __attribute__((vector_size(4 * (count))));   \
        using Shorts = std::uint16_t __attribute__((vector_size(2 * (count)))); \
    }
CAMRIG_LANES_OF(TwoLanes, 2);
CAMRIG_LANES_OF(FourLanes, 4);
CAMRIG_LANES_OF(EightLanes, 8);
#undef CAMRIG_LANES_OF

template <typename Lanes>
struct RowLoops {
    static constexpr int lanes = Lanes::lanes;
    using Floats = typename Lanes::Floats;
    using Ints = typename Lanes::Ints;
    using Words = typename Lanes::Words;

    CAMRIG_ROW_LOOP static Floats load(const float* from) {
        Floats values;
        std::memcpy(&values, from, sizeof values);
        return values;
    }
    CAMRIG_ROW_LOOP static Floats at_least(Floats value, float low) { return value > low ? value : Floats{} + low; }
    CAMRIG_ROW_LOOP static Floats at_most(Floats value, float high) { return value < high ? value : Floats{} + high; }
    CAMRIG_ROW_LOOP static Floats root_of(Floats value) {
        for (int i = 0; i < lanes; ++i) value[i] = std::sqrt(value[i]);
        return value;
    }
    /// Towards 0; for magnitudes below 2^31.
    CAMRIG_ROW_LOOP static Ints truncated(Floats value) { return __builtin_convertvector(value, Ints); }
    CAMRIG_ROW_LOOP static Floats floats_of(Ints value) { return __builtin_convertvector(value, Floats); }
    CAMRIG_ROW_LOOP static bool has_any(Ints mask) {
        const auto bits = reinterpret_cast<typename Lanes::Longs>(mask);
        std::int64_t any = 0;
        for (int i = 0; i < lanes / 2; ++i) any |= bits[i];
        return any != 0;
    }

    /// e^-x for 0 <= x <= 80, to 2e-7 of it.
    CAMRIG_ROW_LOOP static Floats exp_minus(Floats x) {
        const Floats power = x * -1.44269504f;
        const Ints whole = truncated(power - 0.5f);
        const Floats y = (power - floats_of(whole)) * 0.69314718f;
        const Floats series =
            1.0f +
            y * (1.0f + y * (0.5f + y * (0.16666667f + y * (0.041666668f + y * (0.0083333338f + y * 0.0013888889f)))));
        return series * reinterpret_cast<Floats>((whole + 127) << 23);
    }

    /// Uniform in [0, 1) in steps of 2^-24, of counters: the integer hash of C. Wellons ("lowbias32", 2018).
    CAMRIG_ROW_LOOP static Floats uniform(Words counter) {
        counter ^= counter >> 16;
        counter *= 0x7feb352dU;
        counter ^= counter >> 15;
        counter *= 0x846ca68bU;
        counter ^= counter >> 16;
        return floats_of(reinterpret_cast<Ints>(counter >> 8)) * 0x1p-24f;
    }
    /// 0, 1, 2, ... of each lane.
    CAMRIG_ROW_LOOP static Ints lane_numbers() {
        Ints numbers{};
        for (int i = 0; i < lanes; ++i) numbers[i] = i;
        return numbers;
    }

    CAMRIG_ROW_LOOP static void expect_electrons(const RowExposure& row, const float* __restrict light,
                                                 float* __restrict mean_e) {
        const float* const a = row.fixed.a;
        const float* const b = row.fixed.b;
        Floats place = floats_of(lane_numbers());
        for (int x = 0; x < row.padded_width; x += lanes, place += static_cast<float>(lanes)) {
            const Floats u = row.u0 + place * row.u_step;
            const Floats tangents = 1.0f + u * u + row.v2;
            const Floats sensitivity = 1.0f + row.prnu * (load(a + x) + load(b + x));
            const Floats lit = load(light + x) * row.electrons * sensitivity / (tangents * tangents);
            const Floats mean = at_least(at_most(lit + row.dark_e, row.limit_e), 0.0f);
            std::memcpy(mean_e + x, &mean, sizeof mean);
        }
    }

    /// Counts of means below 8: how often a uniform number is at or above the sum of probabilities so far, which is the
    /// exact inverse but for the 2^-24 of both.
    struct FewCounts {
        Floats few, u, p, sum;
        Ints count, is_more;

        CAMRIG_ROW_LOOP FewCounts(Floats mean, Words counter)
            : few(at_most(mean, 8.0f)), u(uniform(counter)), p(exp_minus(few)), sum(p), count{}, is_more{} {}
        CAMRIG_ROW_LOOP void turn(float one_over_k) {
            is_more = u >= sum;
            count -= is_more;
            p *= few * one_over_k;
            sum += p;
        }
        CAMRIG_ROW_LOOP Floats counts() const {
            // A sum that rounding keeps below 1 would count on: of 5e7 about one has more.
            const Floats made = floats_of(count), bound = few * 2.5f + 9.0f;
            return made < bound ? made : bound;
        }
    };
    static constexpr int most_few = 40;
    static constexpr auto one_over = [] {
        std::array<float, most_few + 1> made{};
        for (int k = 1; k <= most_few; ++k) made[static_cast<std::size_t>(k)] = 1.0f / static_cast<float>(k);
        return made;
    }();

    /// Counts of means from 8 to 20 for normal values z: the quantile of the Poisson distribution by its expansion in
    /// 1 / sqrt(mean), cut off to whole numbers (M. B. Giles, ACM TOMS 42:1, 2016, Q_N3).
    CAMRIG_ROW_LOOP static Floats count_some(Floats mean, Floats z) {
        const Floats m = at_least(mean, 8.0f), root = root_of(m), inverse = 1.0f / root, z2 = z * z;
        const Floats third = (z2 * (z2 * (1.0f / 270.0f) + 7.0f / 810.0f) - 8.0f / 405.0f) * inverse;
        const Floats second = z * (z2 * (1.0f / 72.0f) + 1.0f / 36.0f);
        const Floats quantile = m + root * z + (1.0f / 3.0f + z2 * (1.0f / 6.0f)) + (third - second) * inverse;
        return floats_of(truncated(at_least(quantile, 0.0f)));
    }

    /// One vector of photosites on its way.
    struct Piece {
        Floats mean, z, read, count;
        Words counter;
        Ints is_few, is_some;

        CAMRIG_ROW_LOOP Piece(const RowExposure& row, const float* mean_e, int x, Words numbered) {
            const Floats a = load(row.noise.a + x), b = load(row.noise.b + x);
            const Floats pattern = load(row.fixed.a + x) - load(row.fixed.b + x);
            mean = load(mean_e + x);
            z = a + b;
            read = row.read_noise_e * (a - b) + row.dsnu_e * pattern + row.row_e;
            // The square gives the third moment of Poisson's; what it adds to the variance is taken from the root.
            count = mean + root_of(at_least(mean - 1.0f / 18.0f, 0.0f)) * z + (z * z - 1.0f) * (1.0f / 6.0f);
            counter = numbered;
            is_few = mean < 8.0f;
            is_some = (mean < counted_below_e) & ~is_few;
        }
        CAMRIG_ROW_LOOP void store(const RowExposure& row, std::uint16_t* numbers) const {
            const Floats held = at_most(at_least(count, 0.0f), row.full_well_e);
            const Floats exact = (held + read) * row.numbers_per_e + row.black;
            const Ints number = truncated(at_most(at_least(exact, 0.0f), row.max_number) + 0.5f);
            using Shorts = typename Lanes::Shorts;
            const Shorts made = __builtin_convertvector(number, Shorts);
            std::memcpy(numbers, &made, sizeof made);
        }
    };

    CAMRIG_ROW_LOOP static void count_electrons(const RowExposure& row, const float* __restrict mean_e,
                                                std::uint16_t* __restrict numbers) {
        constexpr std::uint32_t golden = 0x9E3779B9U;
        Words counter = row.noise.key + reinterpret_cast<Words>(lane_numbers()) * golden;
        // Two vectors at once: counting waits long for itself.
        for (int x = 0; x < row.padded_width; x += 2 * lanes, counter += golden * 2 * lanes) {
            Piece one(row, mean_e, x, counter), other(row, mean_e, x + lanes, counter + golden * lanes);
            if (has_any(one.is_some | other.is_some)) {
                one.count = one.is_some ? count_some(one.mean, one.z) : one.count;
                other.count = other.is_some ? count_some(other.mean, other.z) : other.count;
            }
            if (has_any(one.is_few | other.is_few)) {
                constexpr std::size_t turns = 4;
                FewCounts few(one.mean, one.counter), others(other.mean, other.counter);
                for (std::size_t k = 1; k <= most_few; k += turns) {
                    for (std::size_t turn = 0; turn < turns; ++turn) {
                        few.turn(one_over[k + turn]);
                        others.turn(one_over[k + turn]);
                    }
                    if (!has_any(few.is_more | others.is_more)) break;
                }
                one.count = one.is_few ? few.counts() : one.count;
                other.count = other.is_few ? others.counts() : other.count;
            }
            one.store(row, numbers + x);
            other.store(row, numbers + x + lanes);
        }
    }
};

}  // namespace camrig::sensor
