#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/sensor/expose_row.h"
#include "core/sensor/poisson_tables.h"

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
    /// Bounds are not negative. Their bits as whole numbers are in the same order, and compared in one instruction.
    CAMRIG_ROW_LOOP static Floats at_least(Floats value, float low) {
        const auto bits = reinterpret_cast<Ints>(value), bound = Ints{} + std::bit_cast<std::int32_t>(low);
        return reinterpret_cast<Floats>(bits > bound ? bits : bound);
    }
    CAMRIG_ROW_LOOP static Floats at_most(Floats value, float high) {
        const auto bits = reinterpret_cast<Ints>(value), bound = Ints{} + std::bit_cast<std::int32_t>(high);
        return reinterpret_cast<Floats>(bits < bound ? bits : bound);
    }
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

    /// The integer hash of C. Wellons ("lowbias32", 2018).
    CAMRIG_ROW_LOOP static Words hash_of(Words counter) {
        counter ^= counter >> 16;
        counter *= 0x7feb352dU;
        counter ^= counter >> 15;
        counter *= 0x846ca68bU;
        return counter ^ counter >> 16;
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

    /// Poisson numbers of means below PoissonTables::end_e: of one of the two means of the tables beside it, drawn so
    /// that the mean is right.
    CAMRIG_ROW_LOOP static Floats count_few(const std::uint32_t* tables, Floats mean, Words counter) {
        const Words bits = hash_of(counter);
        const Floats few = at_most(mean, float{PoissonTables::end_e}) * float{PoissonTables::per_electron};
        const Ints row = truncated(few + floats_of(reinterpret_cast<Ints>(bits & 0xff)) * 0x1p-8f);
        const Ints column = reinterpret_cast<Ints>(bits >> 26);
        const Ints at = row * PoissonTables::columns + column;
        Ints entry{};
        for (int i = 0; i < lanes; ++i) entry[i] = static_cast<std::int32_t>(tables[at[i]]);
        const Ints place = reinterpret_cast<Ints>(bits >> 8) & ((1 << PoissonTables::share_bits) - 1);
        return floats_of(place < (entry >> 6) ? column : entry & (PoissonTables::columns - 1));
    }
    /// Of others: normal values z by the mean and variance of the Poisson distribution.
    CAMRIG_ROW_LOOP static Floats count_many(Floats mean, Floats z) {
        // The square gives the third moment of Poisson's; what it adds to the variance is taken from the root.
        return mean + root_of(at_least(mean - 1.0f / 18.0f, 0.0f)) * z + (z * z - 1.0f) * (1.0f / 6.0f);
    }

    /// One vector of photosites on its way.
    struct Piece {
        Floats mean, z, read, count;
        Words counter;
        Ints is_few;

        CAMRIG_ROW_LOOP Piece(const RowExposure& row, const float* mean_e, int x, Words numbered) {
            const Floats a = load(row.noise.a + x), b = load(row.noise.b + x);
            const Floats pattern = load(row.fixed.a + x) - load(row.fixed.b + x);
            mean = load(mean_e + x);
            z = a + b;
            read = row.read_noise_e * (a - b) + row.dsnu_e * pattern + row.row_e;
            counter = numbered;
            is_few = mean < float{PoissonTables::end_e};
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
        const std::uint32_t* const tables = poisson_tables().entries.data();
        // Two vectors at once: counting waits long for itself.
        for (int x = 0; x < row.padded_width; x += 2 * lanes, counter += golden * 2 * lanes) {
            Piece one(row, mean_e, x, counter), other(row, mean_e, x + lanes, counter + golden * lanes);
            const bool has_few = has_any(one.is_few | other.is_few);
            if (has_any(~(one.is_few & other.is_few))) {
                one.count = count_many(one.mean, one.z);
                other.count = count_many(other.mean, other.z);
                if (has_few) {
                    one.count = one.is_few ? count_few(tables, one.mean, one.counter) : one.count;
                    other.count = other.is_few ? count_few(tables, other.mean, other.counter) : other.count;
                }
            } else {
                one.count = count_few(tables, one.mean, one.counter);
                other.count = count_few(tables, other.mean, other.counter);
            }
            one.store(row, numbers + x);
            other.store(row, numbers + x + lanes);
        }
    }
};

}  // namespace camrig::sensor
