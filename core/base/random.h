#pragma once

#include <cstdint>

namespace camrig {

/// Counter-based random numbers: a pure function of (seed, stream, counter), so the answer never depends on
/// the order of calls, on threads, or on what else was drawn.
///
/// Method: Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter);

/// Uniform in [0, 1), 53 bits.
double random_unit(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter);

}  // namespace camrig
