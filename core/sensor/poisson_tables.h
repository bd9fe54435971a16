#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace camrig::sensor {

/// Poisson distributions of means 0, 1/128, 2/128 and so on, each as 64 columns of Walker's alias method (A. J. Walker,
/// ACM TOMS 3:3, 1977): a column drawn evenly gives its own number or another one. Each is exact to 2^-24; of means
/// between two of them, the mixture of both has a variance that is 1.5e-5 too large at most, and probabilities that are
/// wrong by 8e-6.
///
/// An entry: 64 times the share of its column that has its own number, in 2^-18, plus the other number.
struct PoissonTables {
    static constexpr int per_electron = 128, columns = 64;
    /// Means below this have tables.
    static constexpr int end_e = 20;
    static constexpr int share_bits = 18;

    std::array<std::uint32_t, std::size_t{end_e * per_electron + 1} * columns> entries;
};
/// Made once.
const PoissonTables& poisson_tables();

}  // namespace camrig::sensor
