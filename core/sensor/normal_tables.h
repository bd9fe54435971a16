#pragma once

#include <array>
#include <cstdint>
#include <memory>

namespace camrig::sensor {

/// The widest row, in photosites (a camera's widest picture).
inline constexpr int max_row = 8192;

/// Two tables of the same 65536 normal values in two random orders, made once. Values have mean 0 and variance 1/2, so
/// that of entries a and b at two unrelated places a + b and a - b are standard normal and uncorrelated: two random
/// numbers for two loads. Kurtosis of the sum 2.9996, its largest value 6.1.
///
/// Entries beyond 65536 repeat those from 0 on: a row is read straight on from any place.
struct NormalTables {
    static constexpr int size = 65536;
    std::array<float, size + max_row> a, b;
};
const NormalTables& normal_tables();

/// Where a row reads: a function of seed, purpose, plane, frame and row alone.
struct RowNoise {
    const float* a = nullptr;
    const float* b = nullptr;
    std::uint32_t key = 0;  ///< of uniform numbers by photosite

    enum class Purpose : std::uint8_t { picture, fixed_pattern };
    static RowNoise of(std::uint64_t seed, Purpose purpose, int plane, std::int64_t frame, int row);
    /// A standard normal value of the whole row.
    static float of_row(std::uint64_t seed, int plane, std::int64_t frame, int row);
};

}  // namespace camrig::sensor
